//! `ModelStructure` (FMI 2.0, 2.2.8): which unknown depends on which known, and how.

use super::variables::{Access, Causality, Initial, VARIABLES, Variable, find};

/// FMI 2.0, 2.2.8, attribute `dependenciesKind`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DependencyKind {
    /// No particular structure.
    Dependent,
    /// A constant factor.
    Constant,
    /// A factor of fixed parameters.
    Fixed,
    /// A factor of tunable parameters.
    Tunable,
    /// A factor that changes at events.
    Discrete,
}

/// One element of a list of `ModelStructure`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// `ScalarVariable` index, from 1.
    pub index: u32,
    /// Dependencies as (index, kind), ordered by index; `None` means on all knowns, empty means on none.
    pub dependencies: Option<Vec<(u32, DependencyKind)>>,
}

/// Names of the continuous states, in the order of `fmi2GetContinuousStates`.
pub const STATES: [&str; 6] = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];

/// Names of their derivatives, in the order of `fmi2GetDerivatives`.
pub const DERIVATIVES: [&str; 6] = ["box.v", "block.v", "secondary.v", "box.a", "block.a", "secondary.a"];

/// Names of the inputs.
pub const INPUTS: [&str; 3] = ["box.f", "block.f", "secondary.f"];

use DependencyKind::{Constant, Dependent, Discrete, Fixed, Tunable};

/// What box and block feel, in flight or as one body in rest: the factors change with the contact.
const PAIR: &[(&str, DependencyKind)] = &[
    ("time", Dependent),
    ("box.f", Discrete),
    ("block.f", Discrete),
    ("box.s", Discrete),
    ("box.v", Discrete),
    ("block.s", Discrete),
    ("secondary.s", Discrete),
];

/// Everything: accumulated work and energies.
const ALL: &[(&str, DependencyKind)] = &[
    ("time", Dependent),
    ("box.f", Dependent),
    ("block.f", Dependent),
    ("secondary.f", Dependent),
    ("box.s", Dependent),
    ("box.v", Dependent),
    ("block.s", Dependent),
    ("block.v", Dependent),
    ("secondary.s", Dependent),
    ("secondary.v", Dependent),
];

/// The bodies' places and velocities, the last six of [`ALL`].
const ENERGY: &[(&str, DependencyKind)] = ALL.split_at(4).1;

/// Dependencies of an output on inputs, continuous states and time, outside initialization.
fn knowns(name: &str) -> &'static [(&'static str, DependencyKind)] {
    match name {
        "box.s" => &[("box.s", Constant)],
        "block.s" => &[("block.s", Constant)],
        "secondary.s" => &[("secondary.s", Constant)],
        "box.v" => &[("box.v", Constant)],
        "block.v" => &[("block.v", Constant)],
        "secondary.v" => &[("secondary.v", Constant)],
        "box.a" | "block.a" | "stop.force" => PAIR,
        "secondary.a" => &[
            ("secondary.f", Fixed),
            ("block.s", Tunable),
            ("secondary.s", Tunable),
            ("secondary.v", Tunable),
        ],
        // In rest they are constants.
        "stop.s" => &[("box.s", Discrete), ("block.s", Discrete)],
        "stop.v" => &[("box.v", Discrete), ("block.v", Discrete)],
        "coupling.f" => &[("block.s", Tunable), ("secondary.s", Tunable)],
        "energy.mechanical" => ENERGY,
        "energy.input" | "energy.damped" => ALL,
        // Discrete outputs hold what the last event made of them.
        _ => &[],
    }
}

/// Which parameters a dimensionless group is made of.
fn group_knowns(name: &str) -> &'static [&'static str] {
    match name {
        "groups.epsilon" => &["box.m", "block.m"],
        "groups.kappa" => &["stop.restitution"],
        "groups.f10" => &["box.m", "box.k", "block.m", "stop.gap", "drive.amplitude"],
        "groups.sigma1" => &["box.m", "box.k", "block.m", "drive.frequency"],
        "groups.gamma1" => &["box.m", "box.k", "box.c", "block.m"],
        "groups.alpha23" => &["box.m", "box.k", "block.m", "coupling.k"],
        "groups.beta2" => &["box.m", "box.k", "block.m", "coupling.k"],
        "groups.sigma30" => &["box.m", "box.k", "block.m", "secondary.m", "secondary.k"],
        "groups.gamma3" => &["box.m", "box.k", "block.m", "secondary.m", "secondary.c"],
        _ => &["box.m", "secondary.m"],
    }
}

fn index(name: &str) -> u32 {
    find(name).map_or(0, |(reference, _)| reference + 1)
}

fn unknown(name: &str, knowns: &[(&str, DependencyKind)]) -> Unknown {
    let mut dependencies: Vec<_> = knowns.iter().map(|(name, kind)| (index(name), *kind)).collect();
    dependencies.sort_by_key(|(index, _)| *index);
    Unknown { index: index(name), dependencies: Some(dependencies) }
}

/// `ModelStructure/Outputs`: every output, in the order of the table.
pub fn outputs() -> Vec<Unknown> {
    VARIABLES
        .iter()
        .filter(|variable| variable.causality == Causality::Output)
        .map(|variable| unknown(variable.name, knowns(variable.name)))
        .collect()
}

/// `ModelStructure/Derivatives`, in the order of the states.
pub fn derivatives() -> Vec<Unknown> {
    DERIVATIVES.iter().map(|name| unknown(name, knowns(name))).collect()
}

/// `ModelStructure/InitialUnknowns`: calculated outputs and calculated parameters, ordered by index. Groups list the
/// parameters they are made of; everything else may depend on everything, since `mode` and `startOnOrbit` choose
/// what the start is made of.
pub fn initial_unknowns() -> Vec<Unknown> {
    VARIABLES
        .iter()
        .filter(|variable| is_initial_unknown(variable))
        .map(|variable| match variable.name.starts_with("groups.") {
            true => {
                let knowns: Vec<_> =
                    group_knowns(variable.name).iter().map(|name| (*name, Dependent)).collect();
                unknown(variable.name, &knowns)
            }
            false => Unknown { index: index(variable.name), dependencies: None },
        })
        .collect()
}

fn is_initial_unknown(variable: &Variable) -> bool {
    variable.initial == Some(Initial::Calculated)
        && matches!(variable.access, Access::Motion(_) | Access::Derived(_))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_in_the_table() {
        for name in STATES.iter().chain(&DERIVATIVES).chain(&INPUTS) {
            assert!(find(name).is_some(), "{name}");
        }
        for list in [outputs(), derivatives(), initial_unknowns()] {
            for unknown in list {
                assert!(unknown.index > 0);
                for pair in unknown.dependencies.iter().flat_map(|d| d.windows(2)) {
                    assert!(0 < pair[0].0 && pair[0].0 < pair[1].0, "{unknown:?}");
                }
            }
        }
    }

    #[test]
    fn derivatives_belong_to_the_states() {
        use crate::fmi2::variables::Kind;
        for (state, derivative) in STATES.iter().zip(&DERIVATIVES) {
            let (_, variable) = find(derivative).unwrap();
            assert!(
                matches!(variable.kind, Kind::Real { derivative_of: Some(of), .. } if of == *state),
                "{derivative} must be the derivative of {state}"
            );
        }
    }
}
