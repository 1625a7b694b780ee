//! Sets of knowns, and how they enter.

use fmi_doors::DependencyKind;
use fmi_doors::DependencyKind::{Constant, Dependent, Discrete, Fixed, Tunable};
use std::collections::BTreeMap;

/// Knowns by value reference, and how they enter.
pub(super) type Knowns = BTreeMap<u32, DependencyKind>;

/// The less a kind says of how a known enters, the higher.
fn rank(kind: DependencyKind) -> u8 {
    match kind {
        Constant => 0,
        Fixed => 1,
        Tunable => 2,
        Discrete => 3,
        Dependent => 4,
    }
}

/// Adds a known that enters in a way, and maybe in another besides.
pub(super) fn put(into: &mut Knowns, known: u32, kind: DependencyKind) {
    let entry = into.entry(known).or_insert(kind);
    if rank(kind) > rank(*entry) {
        *entry = kind;
    }
}

/// Adds knowns, whose factors are multiplied with one of this kind.
pub(super) fn join(into: &mut Knowns, from: &Knowns, times: DependencyKind) {
    for (&known, &kind) in from {
        put(into, known, if rank(times) > rank(kind) { times } else { kind });
    }
}
