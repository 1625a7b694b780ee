//! Local search: steps of a quadratic model by exact derivatives of orbits.
//!
//! The worst value of a design is the maximum of several smooth functions of its parameters: the
//! peaks of the measure over the band, one for each corner of the tolerances and each start. Each
//! step solves a [model](crate::quadratic) of these functions within a box, whose size depends on
//! how well the model predicted the last step. Each step is a full evaluation: no peak is missed.

use crate::contact_points::contact_points;
use crate::evaluation::{Evaluation, Evaluator, Stage, is_near};
use crate::orbits::{Followed, Slope};
use crate::quadratic::{Curvature, Piece, Step, merit, step};
use rayon::prelude::*;
use vibro_studies::design_sweep::SearchedRow;

/// Largest number of steps; smooth test problems take four to ten.
const ROUNDS: u32 = 25;
/// Half width of the box of the first step, in the unit box; also its largest value.
const FIRST: f64 = 0.2;
/// Smallest half width for a further step.
const LEAST: f64 = 1e-6;
/// Factors of the half width after a badly predicted step, and after a well predicted one.
const SHRINKS: f64 = 0.3;
const GROWS: f64 = 2.0;
/// Fractions of the predicted improvement at which a step is accepted, and the box grows.
const TAKEN: f64 = 0.05;
const GOOD: f64 = 0.7;
/// Predicted improvement, relative to the goal, below which the search ends.
const IMPROVES: f64 = 1e-8;
/// Distance to a limit that the search keeps, as a fraction of the limit, so that rounding does
/// not violate it.
const INSIDE: f64 = 1e-6;
/// Distance in the unit box to another result below which a search ends: they are the same.
const SAME: f64 = 0.02;

/// Result of a local search.
pub(crate) struct Descended {
    /// The resulting design, which may be the initial one.
    pub found: Evaluation,
    /// Whether the worst motion of each measure at the initial design is on an orbit with
    /// derivatives.
    pub has_gradients: bool,
    /// Whether the model predicts no further improvement.
    pub is_stationary: bool,
    /// Number of orbits with derivatives, without the initial design's.
    pub orbits: usize,
}

/// The orbits of a design's largest peaks; `None` if a measure's worst motion is not on an orbit.
fn followed(evaluator: &Evaluator, (own, found): &(Evaluation, SearchedRow)) -> Option<Vec<Followed>> {
    let mut all = Vec::new();
    for measure in 0..evaluator.sweep.measures.len() {
        let points = contact_points(&evaluator.sweep, found, measure);
        let orbits: Vec<Option<Followed>> =
            points.into_par_iter().map(|point| Followed::new(evaluator, &own.values, point)).collect();
        // The first point is the worst.
        if !matches!(orbits.first(), Some(Some(_))) {
            return None;
        }
        all.extend(orbits.into_iter().flatten());
    }
    Some(all)
}

/// The value of a design with the exact peaks of its band instead of nearby values, and the orbits
/// at these peaks. `None` if the worst motion of a measure is not on an orbit.
pub(crate) fn refined(
    evaluator: &Evaluator,
    design: &(Evaluation, SearchedRow),
) -> Option<(Evaluation, Vec<Followed>)> {
    let mut orbits = followed(evaluator, design)?;
    let values = &design.0.values;
    let peaks: Vec<Option<f64>> = orbits.par_iter_mut().map(|own| own.peak(evaluator, values)).collect();
    let mut found = design.0.clone();
    for (own, value) in orbits.iter().zip(peaks) {
        let Some(value) = value else { continue };
        found.raise(evaluator, (own.point.measure, value), (&own.point.place, own.point.start));
    }
    Some((found, orbits))
}

/// A design with the pieces of the model around it.
struct Around {
    found: Evaluation,
    unit: Vec<f64>,
    pieces: Vec<Piece>,
    orbits: Vec<Followed>,
}

/// The pieces around a design; `None` if the worst motion of a measure has no derivatives.
fn around(evaluator: &Evaluator, size: f64, design: &(Evaluation, SearchedRow)) -> Option<Around> {
    let (found, mut orbits) = refined(evaluator, design)?;
    let slopes: Vec<Option<Slope>> =
        orbits.par_iter_mut().map(|own| own.at(evaluator, &found.values)).collect();
    // The first peak of each measure is the worst.
    let mut pieces = Vec::new();
    let mut kept = Vec::new();
    for (own, slope) in orbits.into_iter().zip(slopes) {
        let is_first = !kept.iter().any(|other: &Followed| other.point.measure == own.point.measure);
        match slope {
            Some(slope) => pieces.push(piece(evaluator, size, (own.point.measure, &slope))),
            None if is_first => return None,
            None => continue,
        }
        kept.push(own);
    }
    Some(Around { unit: evaluator.unit(&found.values), found, pieces, orbits: kept })
}

/// The piece of a peak.
fn piece(evaluator: &Evaluator, size: f64, (measure, slope): (usize, &Slope)) -> Piece {
    let (value, unit) = match measure {
        0 => (slope.value / size, size),
        k => {
            let limit = evaluator.request.limits[k - 1].value;
            let unit = if limit == 0.0 { 1.0 } else { limit.abs() };
            let most = evaluator.sweep.measures[k].sign() * limit - INSIDE * unit;
            ((slope.value - most) / unit, unit)
        }
    };
    let ranges = evaluator.request.vary.iter().map(|own| own.to - own.from);
    let gradient = slope.gradient.iter().zip(ranges).map(|(by, range)| by * range / unit).collect();
    Piece { is_goal: measure == 0, value, gradient }
}

/// The pieces of a nearby design, relative to the present one.
fn seen_from(pieces: &[Piece], step: &[f64]) -> Vec<Piece> {
    let moved = |own: &Piece| {
        let along: f64 = own.gradient.iter().zip(step).map(|(a, b)| a * b).sum();
        Piece { value: own.value - along, ..own.clone() }
    };
    pieces.iter().map(moved).collect()
}

/// Change of the Lagrangian's gradient between two designs: each weighted piece is compared with
/// the nearest peak at the other design.
fn change(from: &Around, to: &Around, weights: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; from.unit.len()];
    for ((own, piece), weight) in from.orbits.iter().zip(&from.pieces).zip(weights) {
        let distance = |other: &Followed| {
            let places = own.point.place.iter().zip(&other.point.place);
            places
                .map(|(a, b)| ((a - b) / a.abs().max(b.abs()).max(f64::MIN_POSITIVE)).abs())
                .fold(0.0, f64::max)
        };
        let alike = |other: &(&Followed, &Piece)| {
            (other.0.point.measure, other.0.point.start) == (own.point.measure, own.point.start)
        };
        let others = to.orbits.iter().zip(&to.pieces).filter(alike);
        let nearest = others.min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
        let Some((_, there)) = nearest else { continue };
        for ((sum, a), b) in sum.iter_mut().zip(&piece.gradient).zip(&there.gradient) {
            *sum += weight * (b - a);
        }
    }
    sum
}

/// Improves a design by gradients until it stops improving, or comes near a known result of
/// another search in the unit box.
pub(crate) fn descend(
    evaluator: &Evaluator,
    begin: (Evaluation, SearchedRow),
    known: &[Vec<f64>],
) -> Descended {
    let found = begin.0.clone();
    let mut result = Descended { found, has_gradients: false, is_stationary: false, orbits: 0 };
    let Some(goal) = begin.0.goal else { return result };
    let size = if goal.value == 0.0 { 1.0 } else { goal.value.abs() };
    let Some(mut own) = around(evaluator, size, &begin) else { return result };
    (result.found, result.has_gradients) = (own.found.clone(), true);
    let (mut curvature, mut half) = (Curvature::unit(own.unit.len()), FIRST);
    let mut further: Vec<Piece> = Vec::new();
    for _ in 0..ROUNDS {
        let bounds: Vec<(f64, f64)> = own.unit.iter().map(|u| ((-half).max(-u), half.min(1.0 - u))).collect();
        let pieces = [&own.pieces[..], &further[..]].concat();
        let Some(Step { d, weights }) = step(&pieces, &curvature, &bounds) else { break };
        let zero = vec![0.0; d.len()];
        let foretold = merit(&own.pieces, &zero) - merit(&pieces, &d);
        result.is_stationary = foretold <= IMPROVES;
        if result.is_stationary || half < LEAST {
            break;
        }
        let unit: Vec<f64> = own.unit.iter().zip(&d).map(|(u, d)| (u + d).clamp(0.0, 1.0)).collect();
        let Some(next) = evaluator.evaluate(evaluator.values(&unit), Stage::Gradient) else { break };
        let Some(next) = around(evaluator, size, &next) else {
            half *= SHRINKS;
            continue;
        };
        result.orbits += next.orbits.len();
        if next.found.score < result.found.score {
            result.found = next.found.clone();
        }
        let part = (merit(&own.pieces, &zero) - merit(&next.pieces, &zero)) / foretold;
        if part < TAKEN {
            // The model did not contain the peaks of this design; the next model does.
            further.extend(seen_from(&next.pieces, &d));
            half *= SHRINKS;
            continue;
        }
        curvature.update(&d, &change(&own, &next, &weights));
        further.clear();
        if part > GOOD {
            half = (GROWS * half).min(FIRST);
        }
        own = next;
        if known.iter().any(|other| is_near(other, &own.unit, SAME)) {
            break;
        }
    }
    result
}
