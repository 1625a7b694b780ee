//! Equations of an orbit for variations that close with a factor.
//!
//! A variation is a small change of the motion. Along an eigenvector of the monodromy matrix a
//! period multiplies it by the multiplier μ: it closes with the factor μ.
//!
//! The equations of an orbit have the derivatives A(1): a change of the first event's time moves
//! the start and the end alike. If a change is multiplied by μ from start to end, the derivatives
//! are A(μ) = A(1) + (μ - 1) B; they are singular if μ is a multiplier. Events at given times are
//! linear maps of the state, so A(μ) has entries of size one even for a very unstable orbit. The
//! determinant of A(-1) has the sign of ∏ (1 + μ). The eigenvalues of the pencil A(1), B are
//! accurate for all multipliers. The monodromy matrix, a product over the flights, is accurate for
//! the largest one only.

use super::cycle::Cycle;
use super::orbit::{eigenvalues, sort};
use super::place::Place;
use super::problem::{Problem, Residual};
use crate::obstacle::Obstacle;
use nalgebra::{Complex, DMatrix, DVector};

/// Factor at which the pencil is inverted. No multiplier equals this number by theory, and the
/// unit circle is near it.
const SHIFT: f64 = 1.93;
/// Modulus limit of multipliers from the monodromy matrix: beyond it, rounding leaves fewer than
/// ten digits of a multiplier near the unit circle.
const BLURS: f64 = 1e6;
/// Largest modulus of a multiplier from the equations. Rounding makes the infinite eigenvalues of
/// the pencil finite, with a modulus of about 1e8, far above this limit.
const SHARP: f64 = 1e4;

impl Problem {
    /// Whether the time of the first event is an unknown that moves the start.
    fn moves_start(&self, place: &Place) -> bool {
        place.period.is_some() && self.word.free().first() == Some(&0)
    }

    /// Derivatives of the equations with respect to the time of the first event, moving only the
    /// start. Requires the derivatives with respect to all unknowns except the parameter.
    fn by_start(&self, place: &Place, cycle: &Cycle, matrix: &DMatrix<f64>) -> DVector<f64> {
        let (own, radian) = (self.units.state.len(), self.radian(place));
        let equations = self.first_time() + self.word.free().len();
        let rate = place.flow(&self.word.letters[0].modes[1]).derivative(cycle.legs[0].entered());
        let mut column = DVector::zeros(matrix.nrows());
        for i in 0..own {
            let part = -rate[i] * radian / self.units.state[i];
            column.rows_mut(0, equations).axpy(part, &matrix.view((0, i), (equations, 1)).column(0), 1.0);
            // The derivative 1 of the closing condition with respect to its end state does not
            // belong to the motion from the start.
            column[i] -= part;
        }
        column
    }

    /// The derivative of A(μ) with respect to μ.
    fn by_factor(&self, place: &Place, cycle: &Cycle, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        let (own, n) = (self.units.state.len(), matrix.nrows());
        let mut by = DMatrix::zeros(n, n);
        (0..own).for_each(|i| by[(i, i)] = 1.0);
        if self.moves_start(place) {
            let time = self.first_time();
            by.set_column(time, &(matrix.column(time) - self.by_start(place, cycle, matrix)));
        }
        by
    }

    /// A(-1), from the equations' derivatives A(1); singular at a doubling.
    pub(super) fn antiperiodic(&self, place: &Place, cycle: &Cycle, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        matrix - self.by_factor(place, cycle, matrix) * 2.0
    }

    /// Recomputes the multipliers that lost digits in the monodromy matrix because of the largest
    /// multiplier.
    ///
    /// # Errors
    /// As [`residual`](Self::residual).
    pub(super) fn sharpen(
        &self,
        (place, u): (&Place, &DVector<f64>),
        multipliers: &mut [Complex<f64>],
        trivial: usize,
    ) -> Result<(), Obstacle> {
        let count = multipliers.len().saturating_sub(trivial);
        let radius = multipliers.first().filter(|_| count > 1).map_or(0.0, |largest| largest.norm());
        if radius < BLURS {
            return Ok(());
        }
        let Residual { matrix, cycle, .. } = self.residual(place, u, true)?;
        let sharp = matrix.and_then(|matrix| self.multipliers_by_equations((place, &cycle), &matrix, count));
        for (own, sharp) in multipliers.iter_mut().zip(sharp.unwrap_or_default()) {
            // In units of rounding, a multiplier from the equations has an error of its square;
            // one from the matrix has an error of the largest multiplier.
            if sharp.norm() < SHARP && sharp.norm_sqr() < radius {
                *own = sharp;
            }
        }
        Ok(())
    }

    /// The `count` largest multipliers, largest first, from the equations' derivatives. A
    /// multiplier of modulus one is as accurate as the equations; the error of a large one grows
    /// with its square. `None` if the equations have no eigenvalues.
    pub(super) fn multipliers_by_equations(
        &self,
        (place, cycle): (&Place, &Cycle),
        matrix: &DMatrix<f64>,
        count: usize,
    ) -> Option<Vec<Complex<f64>>> {
        let by = self.by_factor(place, cycle, matrix);
        let shifted = matrix + &by * (SHIFT - 1.0);
        let inverse = eigenvalues(shifted.lu().solve(&by)?)?;
        // The time of the first event adds the eigenvalue 0 to the pencil. The infinite
        // eigenvalues come first.
        let finite = inverse.iter().filter(|own| own.norm() > f64::MIN_POSITIVE);
        let mut all: Vec<Complex<f64>> = finite.map(|own| SHIFT - own.inv()).collect();
        sort(&mut all);
        let spurious = all.len().checked_sub(count + usize::from(self.moves_start(place)))?;
        Some(all.into_iter().skip(spurious).take(count).collect())
    }
}
