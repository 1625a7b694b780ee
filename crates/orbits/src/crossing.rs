//! Crossings of branches, located by their own conditions.
//!
//! At a crossing the equations F(u, p) = 0 of an orbit, with the parameter's column, are singular,
//! so that Newton's method loses digits. A multiple ε of a vector b unfolds them:
//! F(u, p) + ε b = 0, ψᵀ F_u = 0 and ψᵀ F_p = 0 are regular for u, p and ε (G. Moore, The
//! numerical treatment of non-trivial bifurcation points, 1980). At a crossing ε is 0.

use super::problem::{Problem, Residual};
use crate::curve::slope;
use crate::obstacle::Obstacle;
use crate::two_parameters::Border;
use nalgebra::{DMatrix, DVector};

/// Step of the conditions' difference quotients. It affects the speed of convergence, not the
/// result.
const DIFFERENCE: f64 = 1e-6;
/// Largest number of steps. The derivatives are computed only at the guess, so each step gains
/// about three digits.
const STEPS: usize = 12;
/// Length of a step that counts as rounding, in units of the unknowns.
const ROUNDING: f64 = 1e-12;
/// Tolerance for the unfolding at a crossing, in units of the equations: rounding.
const KEPT: f64 = 1e-8;

/// The singularity measure of a matrix from its bordered system, and the product of the bordered
/// system's left vector with the parameter's column.
pub(super) fn conditions(
    matrix: &DMatrix<f64>,
    column: &DVector<f64>,
    border: &Border<f64>,
) -> Option<Vec<f64>> {
    let turned = Border { left: border.right.clone(), right: border.left.clone() };
    let n = matrix.nrows();
    let mut whole = matrix.transpose().resize(n + 1, n + 1, 0.0);
    whole.view_mut((0, n), (n, 1)).copy_from(&turned.left);
    whole.view_mut((n, 0), (1, n)).copy_from(&turned.right.transpose());
    let mut right = DVector::zeros(n + 1);
    right[n] = 1.0;
    let found = whole.lu().solve(&right)?;
    Some(vec![found[n], found.rows(0, n).dot(column)])
}

impl Problem {
    /// The crossing of branches near a guess; `None` if there is none within a distance, in units
    /// of the unknowns.
    pub(super) fn crossing(&self, guess: &DVector<f64>, within: f64) -> Option<DVector<f64>> {
        let n = self.size();
        let at = |u: &DVector<f64>| -> Result<(Residual, DMatrix<f64>, DVector<f64>), Obstacle> {
            let place = self.place(u)?;
            let mut residual = self.residual(&place, u, true)?;
            let matrix = residual.matrix.take().ok_or(Obstacle::NoConvergence)?;
            let column = self.by_parameter((&place, u), &residual.cycle, &matrix)?;
            Ok((residual, matrix, column))
        };
        let (_, matrix, column) = at(guess).ok()?;
        let border = Border::of(matrix.clone())?;
        let tests = |u: &DVector<f64>| -> Result<Vec<f64>, Obstacle> {
            let (_, matrix, column) = at(u)?;
            conditions(&matrix, &column, &border).ok_or(Obstacle::NoConvergence)
        };
        // Unknowns: the orbit's, the parameter, the unfolding.
        let mut whole = matrix.resize(n + 2, n + 2, 0.0);
        whole.view_mut((0, n), (n, 1)).copy_from(&column);
        whole.view_mut((0, n + 1), (n, 1)).copy_from(&border.left);
        for k in 0..=n {
            let moved = |by: f64| {
                let mut moved = guess.clone();
                moved[k] += by;
                tests(&moved)
            };
            whole.view_mut((n, k), (2, 1)).copy_from(&slope(DIFFERENCE, moved).ok()?);
        }
        let lu = whole.lu();
        let (mut u, mut unfolding, mut before) = (guess.clone(), 0.0, f64::INFINITY);
        for _ in 0..STEPS {
            let (residual, matrix, column) = at(&u).ok()?;
            let mut value = residual.value + &border.left * unfolding;
            value.extend(conditions(&matrix, &column, &border)?);
            let step = lu.solve(&-value)?;
            u += step.rows(0, n + 1);
            unfolding += step[n + 1];
            let length = step.norm();
            if !length.is_finite() || (&u - guess).norm() > within {
                return None;
            }
            // Rounding ends the convergence.
            if length < ROUNDING || (length < KEPT && length > 0.5 * before) {
                return (unfolding.abs() < KEPT).then_some(u);
            }
            before = length;
        }
        None
    }
}
