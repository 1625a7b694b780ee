//! How bodies that links tie to prescribed bodies share the jumps of these bodies, and the
//! derivative of this share (docs/assembly-law.md, section 3, Jumps, and (A35)).

use super::tangent::Tangent;
use crate::functional::StateRow;
use crate::system::System;
use nalgebra::DVector;

/// The signals' part of a row's value.
fn of_signals(system: &System, row: &StateRow, z: &DVector<f64>) -> f64 {
    row.rows_range(system.signals.one..).dot(&z.rows_range(system.signals.one..))
}

/// Returns -Bᵀ m D Δp for a jump of the places (`first` is 0) or of the rates.
fn pull(system: &System, first: usize, jump: &DVector<f64>) -> DVector<f64> {
    let mut pull = DVector::zeros(system.coordinates);
    for (rows, m) in system.bodies.iter().zip(&system.inertias) {
        let row = if first == 0 { &rows.s } else { &rows.v };
        pull.axpy(-m * of_signals(system, row, jump), &rows.weights, 1.0);
    }
    pull
}

/// Returns the state after a jump of the signals, before impacts: signals from `after`, everything
/// else from `before` plus its share of the jump.
pub(super) fn jumped(system: &System, before: &DVector<f64>, after: &DVector<f64>) -> DVector<f64> {
    let (n, one, mut z) = (system.coordinates, system.signals.one, after.clone());
    z.rows_mut(0, one).copy_from(&before.rows(0, one));
    if system.has_motions {
        let jump = after - before;
        for first in [0, n] {
            let shared = system.inertia.solve(&pull(system, first, &jump));
            z.rows_mut(first, n).axpy(1.0, &shared, 1.0);
        }
    }
    z
}

/// Adds the derivative of the share M Δq = -Bᵀ m D Δp, and likewise for rates. `jump` and `step`
/// are the changes of the state and its derivative at the event; only their signals count.
pub(super) fn share(
    system: &System,
    tangent: &Tangent,
    jump: &DVector<f64>,
    step: &DVector<f64>,
    delta: &mut DVector<f64>,
) {
    if !system.has_motions {
        return;
    }
    let n = system.coordinates;
    for first in [0, n] {
        let shared = system.inertia.solve(&pull(system, first, jump));
        let mut change = pull(system, first, step) - &tangent.mass * shared;
        for (i, (rows, by)) in system.bodies.iter().zip(&tangent.bodies).enumerate() {
            let (row, own) = if first == 0 { (&rows.s, &by.s) } else { (&rows.v, &by.v) };
            let (m, dm) = (system.inertias[i], tangent.inertias[i]);
            let moved = of_signals(system, row, jump);
            let varied = dm * moved + m * of_signals(system, own, jump);
            change.axpy(-varied, &rows.weights, 1.0);
            change.axpy(-m * moved, &by.weights, 1.0);
        }
        delta.rows_mut(first, n).axpy(1.0, &system.inertia.solve(&change), 1.0);
    }
}
