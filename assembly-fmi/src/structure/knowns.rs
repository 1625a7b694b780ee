//! Sets of knowns with their kinds of dependency.

use fmi_doors::DependencyKind;
use fmi_doors::DependencyKind::{Constant, Dependent, Discrete, Fixed, Tunable};
use std::collections::BTreeMap;

/// Kind of dependency by the known's value reference.
pub(super) type Knowns = BTreeMap<u32, DependencyKind>;

/// Rank of a kind; higher for weaker statements about the dependency.
fn rank(kind: DependencyKind) -> u8 {
    match kind {
        Constant => 0,
        Fixed => 1,
        Tunable => 2,
        Discrete => 3,
        Dependent => 4,
    }
}

/// Adds a known; of two kinds for one known the higher rank holds.
pub(super) fn put(into: &mut Knowns, known: u32, kind: DependencyKind) {
    let entry = into.entry(known).or_insert(kind);
    if rank(kind) > rank(*entry) {
        *entry = kind;
    }
}

/// Adds knowns with their factors multiplied by a factor of kind `times`.
pub(super) fn join(into: &mut Knowns, from: &Knowns, times: DependencyKind) {
    for (&known, &kind) in from {
        put(into, known, if rank(times) > rank(kind) { times } else { kind });
    }
}
