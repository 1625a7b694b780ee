//! A machine's own oscillations without contacts.

use nalgebra::DMatrix;
use std::f64::consts::TAU;
use vibro_assembly::mode::{FrictionState, Mode, StopState};
use vibro_assembly::system::System;

/// What turns slower than this part of the fastest turns by rounding.
const ROUNDING: f64 = 1e-7;

/// The frequencies of the machine's own oscillations with all stops open and all friction off,
/// damping included, Hz.
pub(super) fn oscillations(system: &System) -> Vec<f64> {
    let open = |stop: &vibro_assembly::system::StopRows| {
        if stop.restitution().is_some() { StopState::Open } else { StopState::Below }
    };
    let stops = system.stops.iter().map(open).collect();
    let frictions = vec![FrictionState::Off; system.frictions.len()];
    let linear = system.linear(&Mode { stops, frictions, basis: Vec::new() });
    let size = 2 * system.coordinates;
    if size == 0 {
        return Vec::new();
    }
    let values = DMatrix::from_fn(size, size, |i, j| linear.a.entry(i, j)).complex_eigenvalues();
    let fastest = values.iter().map(|c| c.norm()).fold(0.0, f64::max);
    let turning = values.iter().map(|c| c.im).filter(|im| *im > ROUNDING * fastest);
    turning.map(|im| im / TAU).collect()
}
