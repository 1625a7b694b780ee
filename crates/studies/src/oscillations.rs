//! Natural oscillations of a machine without contacts.

use super::natural::natural_above;
use std::f64::consts::TAU;
use vibro_machine::mode::{FrictionState, Mode};
use vibro_machine::system::{StopRows, System};

/// Frequency relative to the fastest one below which an oscillation is rounding.
const ROUNDING: f64 = 1e-7;

/// Frequencies of the machine's damped natural oscillations, Hz, with all stops open and all
/// friction off. Stiffness switched in time has its first value, and formulas have their slopes at
/// zero displacements.
pub(super) fn oscillations(system: &System) -> Vec<f64> {
    let stops = system.stops.iter().map(StopRows::state_apart).collect();
    let frictions = vec![FrictionState::Off; system.frictions.len()];
    let mut linear =
        system.linear(&Mode { stops, frictions, sliders: system.held_sliders(), basis: Vec::new() });
    if let Some(a) = system.linearised_at_zero(&linear.a) {
        linear.a = a;
    }
    let size = system.states();
    if size == 0 {
        return Vec::new();
    }
    let places: Vec<usize> = (0..size).collect();
    let values = natural_above(system, &linear, &places, usize::MAX).values;
    let fastest = values.iter().map(|c| c.norm()).fold(0.0, f64::max);
    let turning = values.iter().map(|c| c.im).filter(|im| *im > ROUNDING * fastest);
    turning.map(|im| im / TAU).collect()
}
