//! Curves of solutions of n equations in n + 1 unknowns: corrector and tangent of pseudo-arclength
//! continuation (E. L. Allgower and K. Georg, Introduction to Numerical Continuation Methods,
//! 2003), and Newton's method with one more condition.

use super::obstacle::Obstacle;
use nalgebra::{ComplexField, DMatrix, DVector};
use std::cell::Cell;
use vibro_numerics::roots::brent;

/// Largest number of Newton steps of a correction in continuation.
const STEPS: usize = 8;

/// Largest number of Newton steps towards a point given by one further condition; these steps
/// start farther away.
const CONDITION_STEPS: usize = 20;

/// Tolerance for convergence, as the relative size of a Newton step: the next step is only
/// rounding.
pub(super) const STEP_ROUNDING: f64 = 1e-12;

/// Limit of a Newton step, rad, below which a step longer than half of the previous one counts as
/// rounding. If an orbit has many fast impacts, the equations determine fewer digits of the
/// phases.
pub(super) const STEP_STALLED: f64 = 1e-9;

/// Largest Newton step towards a point given by a further condition; longer steps are shortened.
const LONGEST_STEP: f64 = 0.1;

/// The value of n equations and their derivatives with respect to n + 1 unknowns.
pub(super) struct Linearization {
    pub value: DVector<f64>,
    pub matrix: DMatrix<f64>,
}

/// n equations in n + 1 unknowns.
pub(super) trait Equations {
    /// Value and derivatives. Columns that hardly change may be taken from `known`, the
    /// derivatives at a nearby point.
    ///
    /// # Errors
    /// An obstacle if the equations are not defined at `u`.
    fn linearize(&self, u: &DVector<f64>, known: Option<&DMatrix<f64>>) -> Result<Linearization, Obstacle>;

    /// Tolerance for convergence, as the relative size of a Newton step: the next one is rounding.
    fn rounding(&self) -> f64 {
        STEP_ROUNDING
    }

    /// Limit of a Newton step below which a step longer than half of the previous one is only
    /// rounding.
    fn stalled(&self) -> f64 {
        STEP_STALLED
    }
}

/// A point on a curve with its tangent of length one.
#[derive(Clone, Debug)]
pub(super) struct CurvePoint {
    pub u: DVector<f64>,
    pub tangent: DVector<f64>,
    /// Number of Newton steps of the correction.
    pub steps: usize,
}

/// A matrix with one more row at its end.
fn bordered(matrix: &DMatrix<f64>, row: &DVector<f64>) -> DMatrix<f64> {
    let mut whole = matrix.clone().insert_row(matrix.nrows(), 0.0);
    whole.set_row(matrix.nrows(), &row.transpose());
    whole
}

/// The point of the curve in the plane through `predicted` perpendicular to `direction`, with the
/// tangent on the side of `direction`.
pub(super) fn correct(
    equations: &impl Equations,
    predicted: &DVector<f64>,
    direction: &DVector<f64>,
) -> Result<CurvePoint, Obstacle> {
    let mut u = predicted.clone();
    let mut known: Option<DMatrix<f64>> = None;
    // After this number of steps all further ones may be rounding ([`Equations::stalled`]): the
    // correction has converged there.
    let (mut stalled, mut before) = (None, f64::INFINITY);
    for steps in 1..=STEPS {
        let Linearization { value, matrix } = equations.linearize(&u, known.as_ref())?;
        let n = value.len();
        let mut right = DMatrix::zeros(n + 1, 2);
        right.view_mut((0, 0), (n, 1)).copy_from(&-value);
        right[(n, 0)] = direction.dot(&(predicted - &u));
        right[(n, 1)] = 1.0;
        let lu = bordered(&matrix, direction).lu();
        if !lu.solve_mut(&mut right) {
            return Err(Obstacle::NoConvergence);
        }
        known = Some(matrix);
        let step = right.column(0);
        u += step;
        let size = step.norm();
        if !size.is_finite() {
            return Err(Obstacle::NoConvergence);
        }
        if size >= equations.stalled() {
            stalled = None;
        } else if size > 0.5 * before {
            stalled.get_or_insert(steps);
        }
        before = size;
        // Rounding causes longer steps under a load held far away by a soft spring, and near a
        // crossing of branches.
        let last = if steps == STEPS { stalled } else { None };
        if size < equations.rounding() * (1.0 + u.norm()) || last.is_some() {
            let tangent = right.column(1).normalize();
            return Ok(CurvePoint { u, tangent, steps: last.unwrap_or(steps) });
        }
    }
    Err(Obstacle::NoConvergence)
}

/// The tangent at a point of the curve on the side of `towards`: the null vector of the
/// derivatives. Its sign is arbitrary if `towards` is perpendicular to it.
pub(super) fn tangent(
    equations: &impl Equations,
    u: &DVector<f64>,
    towards: &DVector<f64>,
) -> Result<DVector<f64>, Obstacle> {
    let matrix = equations.linearize(u, None)?.matrix;
    let square = matrix.clone().insert_row(matrix.nrows(), 0.0);
    let null = least_vectors(square).ok_or(Obstacle::NoConvergence)?.1;
    Ok(if null.dot(towards) < 0.0 { -null } else { null })
}

/// The solution of equations with the same number of unknowns, by Newton's method from a guess,
/// with bounded steps.
pub(super) fn solve(
    guess: &DVector<f64>,
    linearize: impl Fn(&DVector<f64>) -> Result<Linearization, Obstacle>,
) -> Result<DVector<f64>, Obstacle> {
    let mut u = guess.clone();
    for _ in 0..CONDITION_STEPS {
        let Linearization { value, matrix } = linearize(&u)?;
        let step = matrix.lu().solve(&-value).ok_or(Obstacle::NoConvergence)?;
        let size = step.norm();
        if !size.is_finite() {
            return Err(Obstacle::NoConvergence);
        }
        u += step * (LONGEST_STEP / size).min(1.0);
        if size < STEP_ROUNDING * (1.0 + u.norm()) {
            return Ok(u);
        }
    }
    Err(Obstacle::NoConvergence)
}

/// The point at which one further condition holds, from a guess. `condition` returns its value and
/// gradient.
pub(super) fn meet(
    equations: &impl Equations,
    guess: &DVector<f64>,
    condition: impl Fn(&DVector<f64>) -> Result<(f64, DVector<f64>), Obstacle>,
) -> Result<DVector<f64>, Obstacle> {
    solve(guess, |u| {
        let Linearization { value, matrix } = equations.linearize(u, None)?;
        let (last, gradient) = condition(u)?;
        let scale = gradient.norm();
        if !(scale > 0.0 && scale.is_finite()) {
            return Err(Obstacle::NoConvergence);
        }
        Ok(Linearization { value: value.push(last / scale), matrix: bordered(&matrix, &(gradient / scale)) })
    })
}

/// Largest number of sweeps of a singular value decomposition; a few for each value suffice.
const SWEEPS: usize = 100_000;

/// The left and right singular vectors of the smallest singular value of a square matrix: the null
/// vectors of a singular matrix. `None` if an entry is not finite, since the sweeps would not end.
pub(super) fn least_vectors<T: ComplexField<RealField = f64>>(
    matrix: DMatrix<T>,
) -> Option<(DVector<T>, DVector<T>)> {
    if !matrix.iter().all(ComplexField::is_finite) {
        return None;
    }
    let svd = matrix.try_svd(true, true, 5.0 * f64::EPSILON, SWEEPS)?;
    let least = svd.singular_values.imin();
    let (u, v) = (svd.u?, svd.v_t?);
    Some((u.column(least).into_owned(), v.row(least).adjoint()))
}

/// Singular value, relative to the largest one, up to which a matrix is singular.
const DEGENERATE: f64 = 1e-11;

/// Whether the rows of a matrix are linearly dependent within rounding.
pub(super) fn is_degenerate(matrix: &DMatrix<f64>) -> bool {
    let is_finite = matrix.iter().all(|x| x.is_finite());
    let values = is_finite.then(|| matrix.clone().try_svd(false, false, 5.0 * f64::EPSILON, SWEEPS));
    let values = values.flatten().map(|svd| svd.singular_values);
    values.is_none_or(|values| values.is_empty() || values.min() <= DEGENERATE * values.max())
}

/// The unit vector along one unknown.
pub(super) fn axis(length: usize, index: usize) -> DVector<f64> {
    DVector::from_fn(length, |i, _| if i == index { 1.0 } else { 0.0 })
}

/// The derivative at 0 by second-order differences: central if the function is defined on both
/// sides, otherwise one-sided.
///
/// # Errors
/// An obstacle if the function is defined on neither side.
pub(super) fn slope(
    step: f64,
    at: impl Fn(f64) -> Result<Vec<f64>, Obstacle>,
) -> Result<DVector<f64>, Obstacle> {
    let one_sided = |step: f64, near: Vec<f64>| -> Result<DVector<f64>, Obstacle> {
        let [near, zero, far] = [near, at(0.0)?, at(2.0 * step)?].map(DVector::from_vec);
        Ok((near * 4.0 - zero * 3.0 - far) / (2.0 * step))
    };
    match (at(-step), at(step)) {
        (Ok(below), Ok(above)) => Ok((DVector::from_vec(above) - DVector::from_vec(below)) / (2.0 * step)),
        (Ok(below), Err(_)) => one_sided(-step, below),
        (Err(_), above) => one_sided(step, above?),
    }
}

/// The gradient of a function at a point, by differences.
pub(super) fn gradient(
    u: &DVector<f64>,
    step: f64,
    function: impl Fn(&DVector<f64>) -> Result<f64, Obstacle>,
) -> Result<DVector<f64>, Obstacle> {
    let component = |k: usize| {
        let at = |by: f64| {
            let mut moved = u.clone();
            moved[k] += by;
            Ok(vec![function(&moved)?])
        };
        Ok(slope(step, at)?[0])
    };
    let components: Result<Vec<f64>, Obstacle> = (0..u.len()).map(component).collect();
    Ok(DVector::from_vec(components?))
}

/// Arc in (0, length) at which a test function is zero, to `tolerance`, from its values at the
/// ends.
pub(super) fn zero(
    value: &impl Fn(f64) -> Result<f64, Obstacle>,
    length: f64,
    ends: (f64, f64),
    tolerance: f64,
) -> Option<f64> {
    let failed = Cell::new(false);
    let of = |arc: f64| {
        if arc == 0.0 {
            return ends.0;
        }
        if arc == length {
            return ends.1;
        }
        value(arc).unwrap_or_else(|_| {
            failed.set(true);
            f64::NAN
        })
    };
    brent(of, 0.0, length, tolerance).filter(|_| !failed.get())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_null_vectors() {
        let (left, right) = least_vectors(DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 4.0])).unwrap();
        assert!((left[0] + 2.0 * left[1]).abs() + (right[0] + 2.0 * right[1]).abs() < 1e-14);
        // NaN and infinity end the sweeps at once.
        for bad in [f64::NAN, f64::INFINITY] {
            assert!(least_vectors(DMatrix::from_row_slice(2, 2, &[1.0, bad, 0.0, 1.0])).is_none());
        }
    }
}
