//! The initial state that a machine's file gives.

use crate::assembly::Assembly;

/// Returns the machine's initial state.
pub(crate) fn start_of(assembly: &Assembly) -> Vec<f64> {
    let bodies = || assembly.system.bodies_of.iter();
    let places = bodies().map(|&b| assembly.starts[b].0);
    places.chain(bodies().map(|&b| assembly.starts[b].1)).chain(assembly.inner.iter().copied()).collect()
}
