//! A curve in two parameters followed in both directions to its ends.

use super::LocusEnd;
use super::TwoParameters;
use super::marks::{Marked, ahead};
use crate::curve::{CurvePoint, axis, correct, meet, tangent};
use crate::obstacle::Obstacle;
use nalgebra::DVector;

/// First, smallest and largest step, in rad and curve units of the parameters (fifths of their
/// ranges).
const STEPS: [f64; 3] = [5e-3, 1e-5, 0.05];
/// Largest number of points in one direction.
const MOST_POINTS: usize = 600;
/// Largest correction of a step relative to its length, and smallest cosine of the tangent's turn
/// in a step.
const CORRECTION: f64 = 0.3;
const COSINE: f64 = 0.9;
/// Minimum number of points of a closed curve, and distance from its first point, in steps, within
/// which it counts as closed.
const SHORTEST_LOOP: usize = 10;
const CLOSED: f64 = 0.1;

/// A point of a curve; if it is an end, with the kind of end.
pub(crate) type Located = (DVector<f64>, Option<LocusEnd>);

/// The points of a curve in both directions from one of them, each with its end if it is one.
pub(crate) fn both_ways(locus: &impl TwoParameters, u: &DVector<f64>) -> Result<Vec<Located>, Obstacle> {
    let both = axis(u.len(), u.len() - 1) + axis(u.len(), u.len() - 2);
    let along = tangent(locus, u, &both)?;
    let (forward, end) = follow(locus, u, along.clone());
    let (backward, begin) =
        if end == LocusEnd::Closed { (Vec::new(), LocusEnd::Closed) } else { follow(locus, u, -along) };
    let mut points: Vec<Located> = backward.into_iter().rev().collect();
    points.push((u.clone(), None));
    points.extend(forward);
    // If no step succeeds in a direction, the start itself is the end there.
    let last = points.len() - 1;
    points[0].1 = Some(begin);
    points[last].1 = Some(end);
    Ok(points)
}

/// Follows a curve in one direction to its end; the first point is excluded.
fn follow(locus: &impl TwoParameters, start: &DVector<f64>, along: DVector<f64>) -> (Vec<Located>, LocusEnd) {
    let [mut step, least, longest] = STEPS;
    let mut points = Vec::new();
    let mut locus = locus.clone();
    let first = CurvePoint { u: start.clone(), tangent: along.clone(), steps: 0 };
    let mut marked = vec![Marked::new(&locus, first)];
    let mut is_renewed = false;
    while points.len() < MOST_POINTS {
        let from = &marked[marked.len() - 1];
        let last = &from.point;
        match advance(&locus, last, step) {
            Ok((next, end)) => {
                let next = Marked::new(&locus, next);
                for (u, mark) in from.between(&locus, &next, step) {
                    points.push((u, Some(mark)));
                    if locus.ends_at(mark) {
                        return (points, mark);
                    }
                }
                let way = &next.point.u - &last.u;
                let from = start - &last.u;
                let part = from.dot(&way) / way.norm_squared();
                let closes = points.len() > SHORTEST_LOOP
                    && (0.0..=1.0).contains(&part)
                    && (from - &way * part).norm() < CLOSED * way.norm()
                    && next.point.tangent.dot(&along) > COSINE;
                let end = if closes { Some(LocusEnd::Closed) } else { end };
                points.push((next.point.u.clone(), end));
                if let Some(end) = end {
                    return (points, end);
                }
                step = if next.point.steps <= 4 { (1.4 * step).min(longest) } else { step };
                locus.adapt(&next.point.u);
                marked.push(next);
                marked.drain(..marked.len().saturating_sub(3));
                is_renewed = false;
            }
            Err(_) if step > least => step *= 0.5,
            // The corrector's tangent uses derivatives at the predicted point. If they change much
            // over a step, as near a crossing of curves, it leads away from the curve.
            Err(_) if !is_renewed => {
                is_renewed = true;
                step = STEPS[0];
                let renewed = tangent(&locus, &last.u, &last.tangent);
                if let (Ok(renewed), Some(at)) = (renewed, marked.last_mut()) {
                    at.point.tangent = renewed;
                }
            }
            Err(Obstacle::Order) => return (points, LocusEnd::Touch),
            Err(_) => {
                if let Some(u) = ahead(&marked) {
                    points.push((u, Some(LocusEnd::FoldPitchfork)));
                    return (points, LocusEnd::FoldPitchfork);
                }
                return (points, locus.near_end(&last.u).unwrap_or(LocusEnd::NoConvergence));
            }
        }
    }
    (points, LocusEnd::NoConvergence)
}

/// One step of continuation. The error is `Obstacle::Order` if the point reached within the ranges
/// is not an orbit of the machine.
fn advance(
    locus: &impl TwoParameters,
    last: &CurvePoint,
    step: f64,
) -> Result<(CurvePoint, Option<LocusEnd>), Obstacle> {
    let predicted = &last.u + &last.tangent * step;
    if let Some(bound) = first_bound(locus, &last.u, &predicted) {
        return at_bound(locus, last, &predicted, bound);
    }
    let next = correct(locus, &predicted, &last.tangent)?;
    let turned = next.tangent.dot(&last.tangent) < COSINE;
    if turned || (&next.u - &predicted).norm() > CORRECTION * step {
        return Err(Obstacle::NoConvergence);
    }
    // The correction may lead out of a range.
    if let Some(bound) = first_bound(locus, &last.u, &next.u) {
        return at_bound(locus, last, &next.u, bound);
    }
    if !locus.is_orbit(&next.u)? {
        return Err(Obstacle::Order);
    }
    if let Some(end) = locus.passed(&next.u) {
        return Ok((next, Some(end)));
    }
    Ok((next, None))
}

/// The first bound of a range on the way from one point to another.
#[derive(Clone, Copy)]
struct Bound {
    /// Index of the parameter among the unknowns.
    index: usize,
    value: f64,
    /// Fraction of the way to the bound.
    part: f64,
}

fn first_bound(locus: &impl TwoParameters, from: &DVector<f64>, to: &DVector<f64>) -> Option<Bound> {
    let bound = |k: usize| {
        let (index, (least, most)) = (to.len() - 2 + k, locus.range(k));
        let value = to[index].clamp(least, most);
        let part = ((value - from[index]) / (to[index] - from[index])).clamp(0.0, 1.0);
        (value != to[index]).then_some(Bound { index, value, part })
    };
    let bounds = (0..2).filter_map(bound);
    bounds.min_by(|a, b| a.part.total_cmp(&b.part))
}

/// The end of a curve at a bound on the way from one point to another.
fn at_bound(
    locus: &impl TwoParameters,
    last: &CurvePoint,
    to: &DVector<f64>,
    Bound { index, value, part }: Bound,
) -> Result<(CurvePoint, Option<LocusEnd>), Obstacle> {
    let way = to - &last.u;
    let guess = &last.u + &way * part;
    let hold = |u: &DVector<f64>| Ok((u[index] - value, axis(u.len(), index)));
    let mut u = meet(locus, &guess, hold)?;
    u[index] = value;
    let is_far = (&u - &guess).norm() > CORRECTION * way.norm();
    if is_far || first_bound(locus, &last.u, &u).is_some() || !locus.is_orbit(&u)? {
        return Err(Obstacle::NoConvergence);
    }
    Ok((CurvePoint { u, tangent: last.tangent.clone(), steps: 3 }, Some(LocusEnd::Range)))
}
