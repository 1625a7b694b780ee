//! A curve in two parameters followed in both directions to its ends.

use super::LocusEnd;
use crate::curve::{CurvePoint, Equations, axis, correct, meet, tangent};
use crate::obstacle::Obstacle;
use nalgebra::DVector;

/// First, least and longest step, in rad and curve units of the parameters (fifths of their
/// ranges).
const STEPS: [f64; 3] = [5e-3, 1e-5, 0.05];
/// Largest number of points in one direction.
const MOST_POINTS: usize = 600;
/// Largest correction of a step relative to its length, and least cosine of the angle by which the
/// tangent turns in a step.
const CORRECTION: f64 = 0.3;
const COSINE: f64 = 0.9;
/// Points after which a curve may have closed, and distance from its first point, in steps, at
/// which it counts as closed.
const SHORTEST_LOOP: usize = 10;
const CLOSED: f64 = 0.1;

/// A point of a curve, with the end there if it is one.
pub(crate) type Located = (DVector<f64>, Option<LocusEnd>);

/// Equations of a curve in two parameters, the last two unknowns, each in its curve unit.
pub(crate) trait TwoParameters: Equations + Clone {
    /// Least and largest value of parameter 0 or 1, in its curve unit.
    fn range(&self, k: usize) -> (f64, f64);

    /// Whether a point is an orbit of the machine, except for a touch that defines the curve.
    ///
    /// # Errors
    /// An obstacle if the equations are not defined at `u`.
    fn is_orbit(&self, u: &DVector<f64>) -> Result<bool, Obstacle>;

    /// Adapts the condition's borders to a point of the curve.
    fn adapt(&mut self, u: &DVector<f64>);

    /// The end of the curve that a point lies beyond.
    fn passed(&self, u: &DVector<f64>) -> Option<LocusEnd>;

    /// The end near a point beyond which the curve cannot be followed.
    fn near_end(&self, u: &DVector<f64>) -> Option<LocusEnd>;
}

/// The points of a curve in both directions from one of them, each with its end where it is one.
pub(crate) fn both_ways(locus: &impl TwoParameters, u: &DVector<f64>) -> Result<Vec<Located>, Obstacle> {
    let both = axis(u.len(), u.len() - 1) + axis(u.len(), u.len() - 2);
    let along = tangent(locus, u, &both)?;
    let (forward, end) = follow(locus, u, along.clone());
    let (backward, begin) =
        if end == LocusEnd::Closed { (Vec::new(), LocusEnd::Closed) } else { follow(locus, u, -along) };
    let mut points: Vec<Located> = backward.into_iter().rev().collect();
    points.push((u.clone(), None));
    points.extend(forward);
    // If no step succeeds in a direction, the start itself is the end in that direction.
    let last = points.len() - 1;
    points[0].1 = Some(begin);
    points[last].1 = Some(end);
    Ok(points)
}

/// Follows a curve in one direction to its end; the first point is left out.
fn follow(locus: &impl TwoParameters, start: &DVector<f64>, along: DVector<f64>) -> (Vec<Located>, LocusEnd) {
    let [mut step, least, longest] = STEPS;
    let mut points = Vec::new();
    let mut last = CurvePoint { u: start.clone(), tangent: along.clone(), steps: 0 };
    let mut locus = locus.clone();
    while points.len() < MOST_POINTS {
        match advance(&locus, &last, step) {
            Ok((next, end)) => {
                let way = &next.u - &last.u;
                let from = start - &last.u;
                let part = from.dot(&way) / way.norm_squared();
                let closes = points.len() > SHORTEST_LOOP
                    && (0.0..=1.0).contains(&part)
                    && (from - &way * part).norm() < CLOSED * way.norm()
                    && next.tangent.dot(&along) > COSINE;
                let end = if closes { Some(LocusEnd::Closed) } else { end };
                points.push((next.u.clone(), end));
                if let Some(end) = end.filter(|e| *e != LocusEnd::Cusp) {
                    return (points, end);
                }
                step = if next.steps <= 4 { (1.4 * step).min(longest) } else { step };
                locus.adapt(&next.u);
                last = next;
            }
            Err(_) if step > least => step *= 0.5,
            Err(Obstacle::Order) => return (points, LocusEnd::Touch),
            Err(_) => return (points, locus.near_end(&last.u).unwrap_or(LocusEnd::NoConvergence)),
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
    let columns = predicted.len();
    for k in 0..2 {
        let (index, (from, to)) = (columns - 2 + k, locus.range(k));
        let value = predicted[index];
        if (from..=to).contains(&value) {
            continue;
        }
        let bound = if value < from { from } else { to };
        let part = ((bound - last.u[index]) / (predicted[index] - last.u[index])).clamp(0.0, 1.0);
        let guess = &last.u + &last.tangent * (step * part);
        let hold = |u: &DVector<f64>| Ok((u[index] - bound, axis(columns, index)));
        let u = meet(locus, &guess, hold)?;
        if (&u - &guess).norm() > CORRECTION * step || !locus.is_orbit(&u)? {
            return Err(Obstacle::NoConvergence);
        }
        return Ok((CurvePoint { u, tangent: last.tangent.clone(), steps: 3 }, Some(LocusEnd::Range)));
    }
    let next = correct(locus, &predicted, &last.tangent)?;
    let turned = next.tangent.dot(&last.tangent) < COSINE;
    if turned || (&next.u - &predicted).norm() > CORRECTION * step {
        return Err(Obstacle::NoConvergence);
    }
    if !locus.is_orbit(&next.u)? {
        return Err(Obstacle::Order);
    }
    if let Some(end) = locus.passed(&next.u) {
        return Ok((next, Some(end)));
    }
    let turns = |k: usize| next.tangent[columns - k] * last.tangent[columns - k] < 0.0;
    let end = (turns(1) && turns(2)).then_some(LocusEnd::Cusp);
    Ok((next, end))
}
