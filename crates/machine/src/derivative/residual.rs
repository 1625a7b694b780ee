//! Derivatives of the forces on residual flexibility by one parameter, in a configuration
//! (docs/assembly-law.md (A72)).

use crate::functional::{Functional, StateRow};
use crate::system::{Configuration, Residual};
use nalgebra::DMatrix;

/// Derivatives of the numbers of an element on residual flexibility, and of its rows without the
/// forces of elements there.
#[derive(Clone, Debug)]
pub(super) struct Moved {
    /// Derivative of the reciprocal stiffness.
    pub compliance: f64,
    /// Derivative of the coefficient of friction.
    pub friction: f64,
    /// Derivatives of the elongation and its rate.
    pub whole: [StateRow; 2],
    /// Derivative of the displacement that the flexibilities take up, x of (A68).
    pub x: StateRow,
}

/// The derivatives of the rows of a [`Configuration`].
#[derive(Clone, Debug)]
pub(super) struct ResidualTangent {
    /// Derivatives of each element, before the forces act.
    pub moved: Vec<Moved>,
    /// Derivatives of [`Residual::between`].
    pub between: DMatrix<f64>,
    /// Derivative of each force.
    pub forces: Vec<StateRow>,
    /// Derivative of each force's rate.
    pub rates: Vec<StateRow>,
    /// Derivatives of the coordinate and rate of each node, with residual flexibility.
    pub nodes: Vec<[StateRow; 2]>,
}

impl ResidualTangent {
    /// The derivative of the elongation, or of its rate, that all forces take from an element: the
    /// sum of the flexibilities times the forces.
    pub fn taken(&self, own: &Residual, rows: &Configuration, c: usize, of_rates: bool) -> StateRow {
        let (forces, at) = if of_rates { (&self.rates, &rows.rates) } else { (&self.forces, &rows.forces) };
        let mut sum = StateRow::zeros(forces[c].len());
        forces.iter().enumerate().for_each(|(j, force)| sum.axpy(own.between[(c, j)], force, 1.0));
        add_row(&self.between, c, at, &mut sum);
        sum
    }

    /// The derivatives of an element's elongation and of its rate, with the forces.
    pub fn elongation(&self, own: &Residual, rows: &Configuration, c: usize) -> [StateRow; 2] {
        let [e, rate] = &self.moved[c].whole;
        [e - self.taken(own, rows, c, false), rate - self.taken(own, rows, c, true)]
    }
}

/// Adds a row of a matrix times the forces.
fn add_row(matrix: &DMatrix<f64>, row: usize, forces: &[Functional], sum: &mut StateRow) {
    let terms = matrix.row(row).into_iter().zip(forces);
    terms.filter(|term| *term.0 != 0.0).for_each(|(x, force)| sum.axpy(*x, force, 1.0));
}

/// The derivatives of the rows of all forces, (C + G)_aa dp_a = dx_a - d(C + G)_aa p_a.
pub(super) fn vary(
    own: &Residual,
    rows: &Configuration,
    forces: &[Functional],
    (moved, between): (&[Moved], &DMatrix<f64>),
    x: fn(&Moved) -> &StateRow,
) -> Vec<StateRow> {
    let acting = &rows.acting;
    let active = own.active(acting);
    let inverse = own.inverse(acting, &active);
    let off: Vec<StateRow> = active
        .iter()
        .map(|&i| {
            let mut taken = moved[i].compliance * &*forces[i];
            add_row(between, i, forces, &mut taken);
            let mut row = x(&moved[i]) - taken;
            for (t, component) in own.components.iter().enumerate() {
                if let Some((normal, _)) = component.limit {
                    let share = acting[t].direction() * moved[t].friction * own.between[(i, t)];
                    row.axpy(-share, &forces[normal], 1.0);
                }
            }
            row
        })
        .collect();
    let mut varied = vec![StateRow::zeros(forces.first().map_or(0, |row| row.len())); forces.len()];
    for (row, &i) in active.iter().enumerate() {
        off.iter().enumerate().for_each(|(column, x)| varied[i].axpy(inverse[(row, column)], x, 1.0));
    }
    for (t, component) in own.components.iter().enumerate() {
        if let (Some((normal, friction)), true) = (component.limit, acting[t].direction() != 0.0) {
            varied[t] =
                acting[t].direction() * (moved[t].friction * &*forces[normal] + friction * &varied[normal]);
        }
    }
    varied
}
