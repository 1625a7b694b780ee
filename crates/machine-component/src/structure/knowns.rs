//! Sets of knowns with their dependency kinds (FMI 3.0.2, 2.4.8, `dependenciesKind`).

use fmi_doors::DependencyKind;
use fmi_doors::DependencyKind::{Constant, Dependent, Discrete, Fixed, Tunable};
use std::collections::BTreeMap;

/// Dependency kinds by value reference of the known.
pub(super) type Knowns = BTreeMap<u32, DependencyKind>;

/// Rank of a dependency kind: the weaker its statement, the higher its rank.
fn rank(kind: DependencyKind) -> u8 {
    match kind {
        Constant => 0,
        Fixed => 1,
        Tunable => 2,
        Discrete => 3,
        Dependent => 4,
    }
}

/// Adds a known; the weaker of two kinds is kept.
pub(super) fn put(into: &mut Knowns, known: u32, kind: DependencyKind) {
    let entry = into.entry(known).or_insert(kind);
    if rank(kind) > rank(*entry) {
        *entry = kind;
    }
}

/// Adds knowns whose factors are multiplied by a factor of kind `times`.
pub(super) fn join(into: &mut Knowns, from: &Knowns, times: DependencyKind) {
    for (&known, &kind) in from {
        put(into, known, if rank(times) > rank(kind) { times } else { kind });
    }
}
