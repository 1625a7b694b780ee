//! Dependencies of unknowns on knowns, and their kinds: lists made from the table's columns.

use super::variables::{
    Causality, Dependencies, DependencyKind, Edition, Initial, Initially, Knowns, START, VARIABLES, Variable,
    of_edition, place,
};
use std::collections::BTreeMap;

/// Unknown and its dependencies. The lists hold in every mode: if the closed form and the
/// simulation differ, they are the union of both. Outside initialization the continuous states are
/// knowns and count as fixed: a jump of the states when a parameter is set at an event is not
/// listed as a dependency, nor are the effects of that jump on other unknowns.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Index in the table.
    pub place: usize,
    /// Dependencies as (index, kind), ordered by index.
    pub dependencies: Vec<(usize, DependencyKind)>,
}

/// Names of the continuous states, in a solver's order.
pub const STATES: [&str; 6] = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];

/// Names of their derivatives, in the same order.
pub const DERIVATIVES: [&str; 6] = ["box.v", "block.v", "secondary.v", "box.a", "block.a", "secondary.a"];

/// Names of the derivatives in editions that list derivatives as variables of their own.
pub const EXTENDED_DERIVATIVES: [&str; 6] =
    ["der(box.s)", "der(block.s)", "der(secondary.s)", "box.a", "block.a", "secondary.a"];

/// Names of the event indicators: both gaps and the contact force in rest.
pub const INDICATORS: [&str; EVENT_INDICATORS] =
    ["stop.indicator.upper", "stop.indicator.lower", "stop.indicator.rest"];

/// Number of event indicators.
pub const EVENT_INDICATORS: usize = 3;

const fn check_names(names: &[&str]) {
    let mut i = 0;
    while i < names.len() {
        place(names[i]);
        i += 1;
    }
}

// A name that is not in the table does not compile.
const _: () = {
    let mut i = 0;
    while i < VARIABLES.len() {
        if let Dependencies::On(knowns) = VARIABLES[i].dependencies {
            let mut k = 0;
            while k < knowns.len() {
                place(knowns[k].0);
                k += 1;
            }
        }
        check_names(VARIABLES[i].further);
        if let Initially::On(names) | Initially::OnStartAnd(names) = VARIABLES[i].initially {
            check_names(names);
        }
        i += 1;
    }
    check_names(START);
    check_names(&STATES);
    check_names(&DERIVATIVES);
    check_names(&EXTENDED_DERIVATIVES);
    check_names(&INDICATORS);
};

/// The input that acts on a body.
pub fn input_of(body: usize) -> Option<&'static Variable> {
    VARIABLES.iter().find(|variable| variable.body == Some(body))
}

/// Dependencies ordered by index: `knowns` with their kinds, `names` with the kind `Dependent`.
fn ordered<'a>(
    knowns: Knowns,
    names: impl IntoIterator<Item = &'a &'static str>,
) -> Vec<(usize, DependencyKind)> {
    let named = names.into_iter().map(|name| (*name, DependencyKind::Dependent));
    // Names in both lists keep the second kind, `Dependent`, which is the less specific one.
    let all = knowns.iter().copied().chain(named).map(|(name, kind)| (place(name), kind));
    let ordered: BTreeMap<_, _> = all.collect();
    ordered.into_iter().collect()
}

fn listed(variable: &Variable) -> Knowns {
    match variable.dependencies {
        Dependencies::On(knowns) => knowns,
        Dependencies::NotUnknown => &[],
    }
}

/// Dependencies of a variable that is not an unknown of the model's structure; an array counts as
/// a whole.
pub fn declared(variable: &Variable) -> Vec<(usize, DependencyKind)> {
    ordered(listed(variable), variable.further)
}

/// Dependencies outside initialization. Later descriptions have further knowns.
fn unknown((place, variable): (usize, &Variable), edition: Edition) -> Unknown {
    let further = if edition > Edition::Every { variable.further } else { &[] };
    Unknown { place, dependencies: ordered(listed(variable), further) }
}

/// Dependencies in initialization. Their kind is either constant or dependent (no particular
/// structure).
fn initially((place, variable): (usize, &Variable)) -> Unknown {
    let knowns = listed(variable);
    let dependencies = match variable.initially {
        Initially::AsLater => ordered(knowns, []),
        Initially::OnStartAnd(names) => {
            ordered(&[], START.iter().chain(names).chain(knowns.iter().map(|(name, _)| name)))
        }
        Initially::On(names) => ordered(&[], names),
    };
    Unknown { place, dependencies }
}

/// Every output of an edition, in the order of the table, with its dependencies outside
/// initialization.
pub fn outputs(edition: Edition) -> Vec<Unknown> {
    let outputs = of_edition(edition).filter(|(_, variable)| variable.causality == Causality::Output);
    outputs.map(|row| unknown(row, edition)).collect()
}

fn named(names: &[&str], edition: Edition) -> Vec<Unknown> {
    names.iter().map(|name| unknown((place(name), &VARIABLES[place(name)]), edition)).collect()
}

/// The derivatives of the states, in the order of the states.
pub fn derivatives(edition: Edition) -> Vec<Unknown> {
    named(if edition > Edition::Every { &EXTENDED_DERIVATIVES } else { &DERIVATIVES }, edition)
}

/// The event indicators, in their order.
pub fn event_indicators() -> Vec<Unknown> {
    named(&INDICATORS, Edition::Extended)
}

/// The unknowns of initialization: calculated outputs and calculated parameters in the order of
/// the table, and the derivatives that are separate variables.
pub fn initial_unknowns(edition: Edition) -> Vec<Unknown> {
    let derivatives: &[_] = if edition > Edition::Every { &EXTENDED_DERIVATIVES } else { &[] };
    let unknowns = of_edition(edition).filter(|(_, variable)| {
        let exposed = variable.causality != Causality::Local || derivatives.contains(&variable.name);
        variable.initial == Some(Initial::Calculated) && exposed
    });
    unknowns.map(initially).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::component::variables::Kind;

    #[test]
    fn invariant_dependencies_are_listed_once_and_in_order() {
        let every = Edition::Clocked;
        for list in [outputs(every), derivatives(every), event_indicators(), initial_unknowns(every)] {
            for unknown in list {
                for pair in unknown.dependencies.windows(2) {
                    assert!(pair[0].0 < pair[1].0, "{unknown:?}");
                }
            }
        }
        assert_eq!(derivatives(every).len(), STATES.len());
        assert_eq!(event_indicators().len(), EVENT_INDICATORS);
    }

    #[test]
    fn invariant_derivatives_belong_to_the_states() {
        let pairs = STATES.iter().zip(&DERIVATIVES).chain(STATES.iter().zip(&EXTENDED_DERIVATIVES));
        for (state, derivative) in pairs {
            let variable = &VARIABLES[place(derivative)];
            assert!(
                matches!(variable.kind, Kind::Real { derivative_of: Some(of), .. } if of == *state),
                "{derivative} must be the derivative of {state}"
            );
        }
    }

    #[test]
    fn invariant_each_body_has_one_input() {
        for body in 0..3 {
            let inputs = VARIABLES.iter().filter(|variable| variable.body == Some(body));
            assert_eq!(inputs.count(), 1);
            assert_eq!(input_of(body).unwrap().causality, Causality::Input);
        }
        assert!(VARIABLES.iter().all(|v| v.body.is_some() == (v.causality == Causality::Input)));
    }
}
