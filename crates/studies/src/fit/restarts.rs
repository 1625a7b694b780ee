//! Restarts near a fitted point. Appearing and disappearing impacts create local minima; friction
//! creates plateaus where a parameter has no effect.

use super::bounds::Bounds;
use super::directions::Directions;
use super::errors::Uncertainty;
use super::evaluated::{Evaluated, Point, Solved};
use super::problem::Problem;
use super::solver::{Convergence, solve};
use crate::error::Result;
use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

/// Distances of a restart from the fitted point, in standard errors: without and with contacts.
/// The cost jumps where an impact appears, and the valley behind the jump often begins ten errors
/// away. The next distance is tried if the previous one finds no better point.
const AWAY: [&[f64]; 2] = [&[6.0], &[12.0]];
/// Distances along pairs of combinations if the residuals exceed noise, in standard errors.
const MORE: [f64; 2] = [12.0, 20.0];
/// Largest relative change of a parameter in a restart.
const MOST: f64 = 0.3;
/// Number of parameter combinations tried: without and with contacts.
const DIRECTIONS: [usize; 2] = [1, 6];
/// Change of a start parameter without effect, as a fraction of the motion's size.
const NUDGE: f64 = 0.1;
/// Singular value, relative to the largest, below which a combination is not tried.
const SINGULAR: f64 = 1e-6;
/// Decrease in cost, in units of the residual variance, that counts as an improvement: for a
/// single motion, and for segments, where the misses between segments count as well.
const BETTER: [f64; 2] = [0.01, 1.0];
/// A minimum is as good if its cost is at most `AS_GOOD` variances higher. It is another one if
/// the fitted point's own quadratic cost rises there by more than `ELSEWHERE` variances.
const AS_GOOD: f64 = 4.0;
const ELSEWHERE: f64 = 9.0;
/// Two minima within this many standard errors in each parameter count as one. The rise in cost
/// alone would separate minima that differ by rounding, which a chaotic motion amplifies. For a
/// parameter without a standard error: this fraction of its value.
const ONE: f64 = 3.0;
const ONE_PART: f64 = 1e-3;

/// Result of restarts near a point.
pub(super) enum Found {
    /// All lead back to the point or to worse ones.
    Same,
    /// A better point.
    Better(Solved),
    /// Other minima that are as good.
    Others(Vec<Other>),
}

/// Another minimum that is as good.
pub(super) struct Other {
    pub(super) values: Vec<f64>,
    /// Ratios of the errors that reach this minimum to the ones from the curvature, at least 1. As
    /// in a profile of the cost, a rise by r variances is √r errors away.
    pub(super) factors: Vec<f64>,
}

/// Starting points that move each parameter without effect at `point`, in both directions.
fn nudged(model: &dyn Problem, bounds: &Bounds, point: &Point, at: &Evaluated) -> Vec<Point> {
    let mut all = Vec::new();
    for j in (0..point.values.len()).filter(|&j| at.is_idle(j, point.values[j])) {
        let Some(size) = model.size_of_start(j, &point.values) else { continue };
        for sign in [1.0, -1.0] {
            let mut next = point.clone();
            next.values[j] = (next.values[j] + sign * NUDGE * size).clamp(bounds.low[j], bounds.high[j]);
            all.push(next);
        }
    }
    all
}

/// Best point found after moving the parameters that have no effect at the initial point.
pub(super) fn from_rest(
    model: &dyn Problem,
    bounds: &Bounds,
    best: Solved,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Solved> {
    let starts = nudged(model, bounds, &best.point, &model.evaluate(&best.point, &best.reach)?);
    let reach = &best.reach;
    let all = starts
        .iter()
        .filter_map(|start| solve(model, bounds, start, (reach, Convergence::Rough), go_on).ok());
    let all: Vec<Solved> = all.collect();
    Ok(all.into_iter().fold(best, |best, own| if own.cost < best.cost { own } else { best }))
}

/// Restarts some standard errors away from a point. `factors` are the ratios of the standard
/// errors to the ones from the curvature.
pub(super) fn restarted(
    model: &dyn Problem,
    bounds: &Bounds,
    best: &Solved,
    factors: &[f64],
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Found> {
    let is_whole = best.reach.is_whole();
    let mut others = Vec::new();
    if model.has_stops() && is_whole {
        match scanned(model, bounds, best, factors, go_on)? {
            Found::Same => {}
            Found::Others(found) => others.extend(found),
            found @ Found::Better(_) => return Ok(found),
        }
    }
    let ways = AWAY[usize::from(model.has_stops() && is_whole)].iter().map(|away| (*away, false));
    // Residuals above noise indicate that a better point exists.
    let is_better = model.has_stops() && is_whole && model.misses(&best.point, &best.reach)?;
    let more = MORE.iter().filter(|_| is_better).map(|away| (*away, true));
    for (away, is_paired) in ways.chain(more) {
        match restarted_from(model, bounds, best, (factors, away, is_paired), go_on)? {
            Found::Same => {}
            Found::Others(found) => others.extend(found),
            found @ Found::Better(_) => return Ok(found),
        }
    }
    Ok(if others.is_empty() { Found::Same } else { Found::Others(others) })
}

/// Number of points of a scanned line to each side, and their distance in standard errors.
const SCAN: (i32, f64) = (12, 1.0);
/// Largest number of valleys from which a scan descends.
const VALLEYS: usize = 12;

/// Restarts from the valleys of the cost on lines through a point: along each parameter, and along
/// the combinations. The cost of a motion with impacts has narrow valleys side by side, which a
/// restart at a fixed distance misses.
fn scanned(
    model: &dyn Problem,
    bounds: &Bounds,
    best: &Solved,
    factors: &[f64],
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Found> {
    let at = model.evaluate(&best.point, &best.reach)?;
    let Some((jacobian, mut lines)) = along(model, best, &at, (1.0, false)) else { return Ok(Found::Same) };
    let own = (model.loss(), model.has_sigma());
    let errors = Uncertainty::of(&at, &bounds.names, &best.point.values, own).errors;
    for (j, error) in errors.iter().enumerate() {
        let mut line = Point::from(vec![0.0; best.point.values.len()]);
        line.values[j] = error.unwrap_or(0.0);
        lines.push(line);
    }
    let (count, step) = SCAN;
    let place = |line: &Point, k: i32| {
        let mut next = best.point.clone();
        for (j, value) in next.values.iter_mut().enumerate() {
            let moved = *value + step * f64::from(k) * line.values[j];
            *value = moved.clamp(bounds.low[j], bounds.high[j]);
        }
        next
    };
    let valleys = |(line, sign): (&Point, i32)| {
        let points: Vec<Point> = (0..=count).map(|k| place(line, sign * k)).collect();
        let cost = |point: &Point| {
            let at = Solved { point: point.clone(), ..best.clone() };
            if go_on() { model.cost(&at).unwrap_or(f64::INFINITY) } else { f64::INFINITY }
        };
        let costs: Vec<f64> = points.par_iter().map(cost).collect();
        let is_valley =
            |k: &usize| costs[*k] < costs[k - 1] && costs.get(k + 1).is_none_or(|next| costs[*k] <= *next);
        (1..costs.len()).filter(is_valley).map(|k| (costs[k], points[k].clone())).collect::<Vec<_>>()
    };
    let sides: Vec<(&Point, i32)> = lines.iter().flat_map(|line| [(line, 1), (line, -1)]).collect();
    let mut all: Vec<(f64, Point)> = sides.into_par_iter().flat_map(valleys).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.truncate(VALLEYS);
    let starts: Vec<Point> = all.into_iter().map(|own| own.1).collect();
    descended(model, bounds, best, (factors, &jacobian, &at), &starts, go_on)
}

/// Restarts at one distance from a point.
fn restarted_from(
    model: &dyn Problem,
    bounds: &Bounds,
    best: &Solved,
    (factors, away, is_paired): (&[f64], f64, bool),
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Found> {
    let at = model.evaluate(&best.point, &best.reach)?;
    let p = best.point.values.len();
    let mut starts = nudged(model, bounds, &best.point, &at);
    let Some((jacobian, along)) = along(model, best, &at, (away, is_paired)) else { return Ok(Found::Same) };
    for change in &along {
        starts.extend([1.0, -1.0].map(|sign| {
            let mut next = best.point.clone();
            for j in 0..p {
                let moved = next.values[j] + sign * change.values[j];
                next.values[j] = moved.clamp(bounds.low[j], bounds.high[j]);
            }
            for (state, change) in next.states.iter_mut().zip(&change.states) {
                state.iter_mut().zip(change).for_each(|(x, dx)| *x += sign * dx);
            }
            next
        }));
    }
    descended(model, bounds, best, (factors, &jacobian, &at), &starts, go_on)
}

/// Descends from several points, and compares the minima with the best point.
fn descended(
    model: &dyn Problem,
    bounds: &Bounds,
    best: &Solved,
    (factors, jacobian, at): (&[f64], &DMatrix<f64>, &Evaluated),
    starts: &[Point],
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Found> {
    let p = best.point.values.len();
    let variance = model.variance(best.cost, p);
    // Without contacts there is one valley: its minimum need not be found again.
    let enough = if model.has_stops() { f64::NEG_INFINITY } else { best.cost + variance };
    let by =
        |start: &Point| solve(model, bounds, start, (&best.reach, Convergence::Back(enough)), go_on).ok();
    let all: Vec<Solved> = starts.par_iter().filter_map(by).collect();
    let least = all.iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
    let better = BETTER[usize::from(!best.reach.is_whole())];
    if let Some(own) = least.filter(|own| own.cost < best.cost - better * variance) {
        return Ok(Found::Better(own.clone()));
    }
    let own = (model.loss(), model.has_sigma());
    let mut uncertainty = Uncertainty::of(at, &bounds.names, &best.point.values, own);
    uncertainty.widen(factors);
    let errors = uncertainty.errors;
    let is_other = |own: &&Solved| {
        let mut near = errors.iter().zip(&best.point.values).zip(&own.point.values);
        let is_one = |((error, a), b): ((&Option<f64>, &f64), &f64)| {
            (a - b).abs() <= error.map_or(ONE_PART * a.abs(), |error| ONE * error)
        };
        let is_one = near.all(is_one);
        let off = own.point.values.iter().zip(&best.point.values).map(|(a, b)| a - b);
        let rise = (jacobian * DVector::from_iterator(p, off)).norm_squared();
        own.cost < best.cost + AS_GOOD * variance && rise > ELSEWHERE * variance && !is_one
    };
    let other = |own: &Solved| {
        let away = ((own.cost - best.cost) / variance).max(1.0).sqrt();
        let mut wider = factors.to_vec();
        for (j, wider) in wider.iter_mut().enumerate() {
            let off = (own.point.values[j] - best.point.values[j]).abs();
            *wider *= errors[j].map_or(f64::INFINITY, |error| off / (error * away)).max(1.0);
        }
        Other { values: own.point.values.clone(), factors: wider }
    };
    let others: Vec<Other> = all.iter().filter(is_other).map(other).collect();
    Ok(if others.is_empty() { Found::Same } else { Found::Others(others) })
}

/// Jacobian of all residuals, and parameter changes of `away` standard errors along the least
/// determined combinations, each with the resulting changes of segment states.
fn along(
    model: &dyn Problem,
    best: &Solved,
    at: &Evaluated,
    (away, is_paired): (f64, bool),
) -> Option<(DMatrix<f64>, Vec<Point>)> {
    let values = &best.point.values;
    let p = values.len();
    let Directions { triangle, jacobian, scales, singular, right } = Directions::of(model, values, at)?;
    let largest = singular.max();
    let mut known: Vec<usize> = (0..right.nrows()).filter(|&k| singular[k] > SINGULAR * largest).collect();
    known.sort_by(|&a, &b| singular[a].total_cmp(&singular[b]));
    let variance = model.variance(best.cost, p);
    let of = |ways: &[(usize, f64)]| {
        let mut change = DVector::zeros(p);
        for &(k, part) in ways {
            let direction = right.row(k).transpose();
            let length = (away * variance.sqrt() / singular[k]).min(MOST / direction.amax());
            change += DVector::from_fn(p, |j, _| part * length * scales[j] * direction[j]);
        }
        let states = triangle.states_of(&change, 0.0)?;
        Some(Point { values: change.iter().copied().collect(), states })
    };
    let most = DIRECTIONS[usize::from(model.has_stops())];
    known.truncate(most);
    let mut ways: Vec<Vec<(usize, f64)>> = Vec::new();
    for (i, &a) in known.iter().enumerate() {
        match is_paired {
            false => ways.push(vec![(a, 1.0)]),
            true => ways.extend(known[..i].iter().flat_map(|&b| {
                [0.5f64.sqrt(), -0.5f64.sqrt()].map(|part| vec![(a, 0.5f64.sqrt()), (b, part)])
            })),
        }
    }
    Some((jacobian, ways.iter().filter_map(|own| of(own)).collect()))
}
