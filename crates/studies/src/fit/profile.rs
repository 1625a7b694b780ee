//! Standard errors from the profile of the cost: the change of a parameter at which the cost,
//! minimised over all others, has risen by one variance. Appearing and disappearing impacts create
//! kinks, at which the curvature gives too small an error.

use super::bounds::Bounds;
use super::directions::Directions;
use super::elimination::Triangle;
use super::evaluated::{Change, Point, Solved};
use super::problem::Problem;
use super::solver::{Convergence, solve};
use crate::error::Result;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Distances to which a parameter is moved, in standard errors. Far away the cost may rise less
/// than the curvature predicts: a carriage that sticks soon shows little of its initial velocity.
const AWAY: f64 = 2.0;
const FAR: f64 = 5.0;
/// Range of the rise of the cost at [`AWAY`], in variances, within which the curvature holds (4)
/// and the other parameters are not fitted again.
const EXPECTED: (f64, f64) = (2.8, 5.6);
/// Rise, in variances, that suffices for an error; largest number of doublings to reach it.
const TOLD: f64 = 0.5;
const FARTHER: u32 = 3;
/// Decrease in cost, in units of the variance, that counts as an improvement.
const BETTER: f64 = 0.5;
/// Singular value, relative to the largest, below which a combination is undetermined.
const SINGULAR: f64 = 1e-9;

/// Result of the profile.
pub(super) enum Profile {
    /// Ratio of each error to the one from the curvature; at least 1.
    Factors(Vec<f64>),
    /// A better point.
    Better(Solved),
}

/// Moved parameter: the rise of the cost, the distance in standard errors, and the point.
struct Moved {
    number: usize,
    away: f64,
    rise: f64,
    found: Option<Solved>,
}

/// Parameter changes that move one parameter by its standard error, with the others at least cost;
/// `None` for an undetermined parameter.
struct Errors {
    triangle: Triangle,
    changes: Vec<Option<DVector<f64>>>,
}

impl Errors {
    fn of(model: &dyn Problem, best: &Solved) -> Result<Option<Self>> {
        let at = model.evaluate(&best.point, &best.reach)?;
        let values = &best.point.values;
        let p = values.len();
        let Some(Directions { triangle, scales, singular, right, .. }) = Directions::of(model, values, &at)
        else {
            return Ok(None);
        };
        let least = SINGULAR * singular.max();
        if singular.len() < p || singular.iter().any(|own| *own <= least) {
            return Ok(None);
        }
        let root = DMatrix::from_fn(p, p, |k, j| right[(k, j)] / singular[k]);
        let covariance = root.tr_mul(&root);
        let deviation = model.variance(best.cost, p).sqrt();
        let change = |j: usize| {
            let error = covariance[(j, j)].sqrt();
            let all = DVector::from_fn(p, |i, _| deviation * scales[i] * covariance[(i, j)] / error);
            (error > 0.0 && !at.is_idle(j, values[j])).then_some(all)
        };
        Ok(Some(Self { triangle, changes: (0..p).map(change).collect() }))
    }

    /// Point with one parameter moved by `away` standard errors; `None` beyond its bounds.
    fn moved(&self, bounds: &Bounds, best: &Point, j: usize, away: f64) -> Option<Point> {
        let change = self.changes[j].as_ref()? * away;
        let states = self.triangle.states_of(&change, 0.0)?;
        let mut moved = Change { values: change.as_slice().to_vec(), states };
        let next = bounds.moved(best, &mut moved);
        let reached = (next.values[j] - best.values[j]) / change[j];
        ((reached - 1.0).abs() < 1e-9).then_some(next)
    }
}

/// Ratios of the errors to the ones from the curvature, over both sides of each parameter.
pub(super) fn profile(
    model: &dyn Problem,
    bounds: &Bounds,
    best: &Solved,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Profile> {
    let p = best.point.values.len();
    let Some(errors) = Errors::of(model, best)? else { return Ok(Profile::Factors(vec![1.0; p])) };
    let variance = model.variance(best.cost, p);
    let sides: Vec<(usize, f64)> =
        (0..p).flat_map(|j| [AWAY, -AWAY, FAR, -FAR].map(|away| (j, away))).collect();
    let side = |&(j, away): &(usize, f64)| side(model, bounds, best, &errors, (j, away, variance), go_on);
    let all: Vec<Moved> = sides.par_iter().filter_map(side).collect();
    let better = all.iter().filter(|own| own.rise < -BETTER).min_by(|a, b| a.rise.total_cmp(&b.rise));
    if let Some(found) = better.and_then(|own| own.found.clone()) {
        return Ok(Profile::Better(found));
    }
    let mut factors = vec![1.0; p];
    for own in &all {
        let factor = own.away.abs() / own.rise.max(TOLD / 4.0).sqrt();
        factors[own.number] = f64::max(factors[own.number], factor);
    }
    Ok(Profile::Factors(factors))
}

/// Moves a parameter to one side until the rise of the cost determines its error.
fn side(
    model: &dyn Problem,
    bounds: &Bounds,
    best: &Solved,
    errors: &Errors,
    (j, mut away, variance): (usize, f64, f64),
    go_on: &(dyn Fn() -> bool + Sync),
) -> Option<Moved> {
    let mut last = None;
    for _ in 0..=FARTHER {
        let Some(next) = errors.moved(bounds, &best.point, j, away) else { break };
        let at = Solved { point: next.clone(), cost: f64::INFINITY, ..best.clone() };
        // A motion that cannot be simulated has infinite cost.
        let cost = model.cost(&at).unwrap_or(f64::INFINITY);
        let (mut rise, mut found) = ((cost - best.cost) / variance, None);
        let expected = (away / AWAY).powi(2);
        if !(EXPECTED.0 * expected..=EXPECTED.1 * expected).contains(&rise) && go_on() {
            let held = bounds.held(j, next.values[j]);
            let own = solve(model, &held, &next, (&best.reach, Convergence::Back(f64::NEG_INFINITY)), go_on);
            if let Ok(own) = own {
                (rise, found) = ((own.cost - best.cost) / variance, Some(own));
            }
        }
        let is_told = !(-BETTER..TOLD).contains(&rise);
        last = Some(Moved { number: j, away, rise, found });
        if is_told {
            break;
        }
        away *= 2.0;
    }
    last
}
