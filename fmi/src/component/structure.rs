//! Which unknown depends on which known, and how: lists made from the table's columns.

use super::variables::{
    Causality, Dependencies, DependencyKind, Edition, Initial, Initially, START, VARIABLES, Variable, find,
    of_edition, reference,
};
use std::collections::BTreeMap;

/// An unknown and what it depends on. The lists hold in every mode: where a closed form and a simulation differ, they name
/// what either depends on.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Its value reference.
    pub reference: u32,
    /// Dependencies as (value reference, kind), ordered by reference; of the knowns of initialization, or of inputs,
    /// continuous states and time.
    pub dependencies: Vec<(u32, DependencyKind)>,
    /// The parameters beside them, where a standard counts them among the knowns; empty in initialization, where they are
    /// among the dependencies.
    pub parameters: Vec<u32>,
}

impl Unknown {
    /// All dependencies, parameters among them, ordered by reference.
    pub fn with_parameters(&self) -> Vec<(u32, DependencyKind)> {
        let parameters = self.parameters.iter().map(|&reference| (reference, DependencyKind::Dependent));
        let mut all: Vec<_> = self.dependencies.iter().copied().chain(parameters).collect();
        all.sort_by_key(|(reference, _)| *reference);
        all
    }
}

/// Names of the continuous states, in the order in which a solver takes them.
pub const STATES: [&str; 6] = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];

/// Names of their derivatives, in the same order.
pub const DERIVATIVES: [&str; 6] = ["box.v", "block.v", "secondary.v", "box.a", "block.a", "secondary.a"];

/// The same where each derivative is a variable that is no state.
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
        reference(names[i]);
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
                reference(knowns[k].0);
                k += 1;
            }
        }
        check_names(VARIABLES[i].parameters);
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

fn references(names: &[&str]) -> impl Iterator<Item = u32> {
    names.iter().filter_map(|name| Some(find(name)?.0))
}

/// The dependencies of the column of that name, by reference.
fn listed(variable: &Variable) -> BTreeMap<u32, DependencyKind> {
    match variable.dependencies {
        Dependencies::On(knowns) => {
            knowns.iter().filter_map(|(name, kind)| Some((find(name)?.0, *kind))).collect()
        }
        Dependencies::NotUnknown => BTreeMap::new(),
    }
}

/// Outside initialization.
fn later((reference, variable): (u32, &Variable)) -> Unknown {
    let mut parameters: Vec<_> = references(variable.parameters).collect();
    parameters.sort_unstable();
    Unknown { reference, dependencies: listed(variable).into_iter().collect(), parameters }
}

/// In initialization, where a factor is either constant or has no particular structure.
fn initially((reference, variable): (u32, &Variable)) -> Unknown {
    let dependencies: BTreeMap<_, _> = match variable.initially {
        Initially::AsLater => listed(variable),
        Initially::OnStartAnd(names) => {
            let names = references(START).chain(references(names)).chain(listed(variable).into_keys());
            names.map(|reference| (reference, DependencyKind::Dependent)).collect()
        }
        Initially::On(names) => {
            references(names).map(|reference| (reference, DependencyKind::Dependent)).collect()
        }
    };
    Unknown { reference, dependencies: dependencies.into_iter().collect(), parameters: Vec::new() }
}

/// Every output of an edition, in the order of the table, with what it depends on outside initialization.
pub fn outputs(edition: Edition) -> Vec<Unknown> {
    let outputs = of_edition(edition).filter(|(_, variable)| variable.causality == Causality::Output);
    outputs.map(later).collect()
}

fn named(names: &[&str], dependencies: fn((u32, &Variable)) -> Unknown) -> Vec<Unknown> {
    names.iter().filter_map(|name| find(name)).map(dependencies).collect()
}

/// The derivatives of the states, in the order of the states; in extended descriptions they are variables that are no states.
pub fn derivatives(edition: Edition) -> Vec<Unknown> {
    named(if edition > Edition::Every { &EXTENDED_DERIVATIVES } else { &DERIVATIVES }, later)
}

/// The event indicators, in their order.
pub fn event_indicators() -> Vec<Unknown> {
    named(&INDICATORS, later)
}

/// What is read of the motion and is no output: derivatives of states, event indicators and arrays as variables.
pub fn locals() -> Vec<Unknown> {
    let locals = of_edition(Edition::Extended).filter(|(_, variable)| {
        variable.causality == Causality::Local && matches!(variable.dependencies, Dependencies::On(_))
    });
    locals.map(later).collect()
}

/// What is unknown in initialization: calculated outputs and calculated parameters of an edition, in the order of the table.
pub fn initial_unknowns(edition: Edition) -> Vec<Unknown> {
    let unknowns = of_edition(edition).filter(|(_, variable)| {
        variable.initial == Some(Initial::Calculated) && variable.causality != Causality::Local
    });
    unknowns.map(initially).collect()
}

/// The derivatives of the states in initialization.
pub fn initial_derivatives(edition: Edition) -> Vec<Unknown> {
    named(if edition > Edition::Every { &EXTENDED_DERIVATIVES } else { &DERIVATIVES }, initially)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::component::variables::Kind;

    #[test]
    fn invariant_dependencies_are_listed_once_and_in_order() {
        let every = Edition::Clocked;
        for list in [
            outputs(every),
            derivatives(every),
            event_indicators(),
            initial_unknowns(every),
            initial_derivatives(every),
        ] {
            for unknown in list {
                for pair in unknown.with_parameters().windows(2) {
                    assert!(pair[0].0 < pair[1].0, "{unknown:?}");
                }
            }
        }
        assert_eq!(derivatives(every).len(), STATES.len());
    }

    #[test]
    fn invariant_derivatives_belong_to_the_states() {
        let pairs = STATES.iter().zip(&DERIVATIVES).chain(STATES.iter().zip(&EXTENDED_DERIVATIVES));
        for (state, derivative) in pairs {
            let (_, variable) = find(derivative).unwrap();
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
