//! Follows one branch along the parameter and finds its special points; used for every kind of
//! machine.

use super::branch::{OrbitPoint, Special};
use super::position::Position;
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::path_options::PathOptions;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// Smallest step, as arc length; a branch ends with MX if it requires a smaller one.
pub(super) const LEAST_STEP: f64 = 1e-7;
/// Smallest cosine of the angle between the tangents at both ends of a step.
pub(super) const COSINE: f64 = 0.95;
/// Growth of the step after few Newton steps, and its reduction after many, as factors.
const GROWTH: f64 = 1.4;
const REDUCTION: f64 = 1.5;
/// Minimum number of points of a closed branch.
const SHORTEST_LOOP: usize = 10;
/// Distance from the first point, in steps, within which a branch counts as closed.
const CLOSED: f64 = 0.05;

/// Start of a path; `O` is further data that the machine's follower requires.
#[derive(Clone, Debug)]
pub(super) struct Departure<O> {
    pub u: DVector<f64>,
    /// The direction of the path at its start.
    pub direction: DVector<f64>,
    /// The first step.
    pub step: f64,
    /// The special point where the path starts; it need not be an orbit of the machine.
    pub special: Option<Special>,
    pub of: O,
}

/// How a path ends.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum PathEnd<E> {
    /// As given by the label of the last point.
    Plain,
    /// At the first point of the path.
    Closed,
    /// At a point where other branches begin.
    At(E),
}

/// A path with its end.
#[derive(Clone, Debug)]
pub(super) struct Path<E> {
    pub points: Vec<OrbitPoint>,
    pub end: PathEnd<E>,
}

/// A completed step.
pub(super) struct Advance<T, E> {
    pub between: Vec<OrbitPoint>,
    pub next: Position<T>,
    pub special: Option<Special>,
    pub end: Option<PathEnd<E>>,
    /// The position next to the special point where the step starts.
    pub begins: Option<Position<T>>,
}

/// The previous position, with the arc length to the current one.
pub(super) type Earlier<T> = Option<(Position<T>, f64)>;

/// The orbits of a machine along a curve, as the follower of branches sees them.
pub(super) trait Follow {
    /// Values tested at each position.
    type Tests;
    /// Data of a departure besides its point.
    type Of;
    /// An end of a path at which other branches begin.
    type End;
    /// Fraction of the longest step for short steps. A shorter step grows if it was no costlier
    /// than a longer one. Near a touch, rounding makes Newton's method take the same number of
    /// iterations at any length: without this growth the curve would crawl.
    const SHORT: f64;

    /// The position of a departure.
    fn first(&self, departure: &Departure<Self::Of>) -> Result<Position<Self::Tests>, Obstacle>;

    /// The parameter's value at a point.
    fn value(&self, u: &DVector<f64>) -> f64;

    /// One step, with the special points on it; `leaves` if it begins at a special point.
    fn step(
        &self,
        before: (&Earlier<Self::Tests>, &Position<Self::Tests>),
        step: f64,
        leaves: bool,
    ) -> Result<Advance<Self::Tests, Self::End>, Obstacle>;

    /// A step to use when even the smallest ordinary step fails.
    fn leap(
        &self,
        before: (&Earlier<Self::Tests>, &Position<Self::Tests>),
        is_first: bool,
    ) -> Option<Advance<Self::Tests, Self::End>>;

    /// Gives the special point where a path starts the stability of the piece after it.
    fn leave(&self, first: &mut OrbitPoint, advance: &Advance<Self::Tests, Self::End>);

    /// Completes a path that has ended.
    fn arrive(&self, points: &mut Vec<OrbitPoint>, end: &PathEnd<Self::End>);

    /// How a path ends that cannot be followed beyond its last position.
    fn stopped(&self, points: &mut [OrbitPoint], _: &Position<Self::Tests>) -> PathEnd<Self::End> {
        failed(points)
    }

    /// Whether a step passes the first point of the path again.
    fn closes(
        &self,
        first: &(DVector<f64>, DVector<f64>),
        [last, next]: [&Position<Self::Tests>; 2],
    ) -> bool {
        closes((&first.0, &first.1), [&last.u, &next.u], &next.tangent)
    }

    /// The orbit at a position.
    fn point(&self, at: &Position<Self::Tests>, special: Option<Special>) -> OrbitPoint {
        OrbitPoint {
            value: self.value(&at.u),
            period: at.period,
            multipliers: at.multipliers.clone(),
            stability: at.stability,
            special,
            u: at.u.clone(),
        }
    }
}

/// Labels the last point of a path that cannot be followed further.
pub(super) fn failed<E>(points: &mut [OrbitPoint]) -> PathEnd<E> {
    if let Some(last) = points.last_mut().filter(|p| p.special.is_none()) {
        last.special = Some(Special::of(Label::NoConvergence));
    }
    PathEnd::Plain
}

/// Follows a branch from a departure until it ends.
pub(super) fn follow<F: Follow>(
    follower: &F,
    departure: &Departure<F::Of>,
    options: &PathOptions,
) -> Result<Path<F::End>, Obstacle> {
    let mut last = follower.first(departure)?;
    let mut points = vec![follower.point(&last, departure.special.clone())];
    let start = (last.u.clone(), last.tangent.clone());
    let mut step = departure.step.min(options.longest_step);
    let (mut earlier, mut is_first): (Earlier<F::Tests>, bool) = (None, true);
    loop {
        if points.len() >= options.most_points {
            let end = failed(&mut points);
            return Ok(Path { points, end });
        }
        let leaves = is_first && departure.special.is_some();
        let advance = match follower.step((&earlier, &last), step, leaves) {
            Ok(advance) => advance,
            Err(_) if step > LEAST_STEP => {
                step *= 0.5;
                continue;
            }
            Err(_) => match follower.leap((&earlier, &last), is_first) {
                Some(advance) => advance,
                None => {
                    let end = follower.stopped(&mut points, &last);
                    return Ok(Path { points, end });
                }
            },
        };
        if leaves {
            follower.leave(&mut points[0], &advance);
        }
        let Advance { between, next, special, end, begins } = advance;
        is_first = false;
        points.extend(between);
        if end.is_none() && points.len() > SHORTEST_LOOP && follower.closes(&start, [&last, &next]) {
            points.push(points[0].clone());
            return Ok(Path { points, end: PathEnd::Closed });
        }
        points.push(follower.point(&next, special));
        if let Some(end) = end {
            follower.arrive(&mut points, &end);
            return Ok(Path { points, end });
        }
        let crawls = step < F::SHORT * options.longest_step && next.steps <= last.steps;
        if next.steps <= 3 || crawls {
            step *= GROWTH;
        } else if next.steps >= 5 {
            step /= REDUCTION;
        }
        step = step.clamp(LEAST_STEP, options.longest_step);
        // A special point at the start of a branch has no tests.
        let begun = std::mem::replace(&mut last, next);
        let before = begins.unwrap_or(begun);
        let arc = before.tangent.dot(&(&last.u - &before.u));
        earlier = Some((before, arc));
    }
}

/// Whether a step from `last` to `next`, with the tangent at `next`, passes the first point of its
/// path again in the path's first direction.
pub(super) fn closes(
    (first, begins): (&DVector<f64>, &DVector<f64>),
    [last, next]: [&DVector<f64>; 2],
    tangent: &DVector<f64>,
) -> bool {
    let (way, from) = (next - last, first - last);
    let length = way.norm();
    let part = from.dot(&way) / (length * length);
    let aside = (from - &way * part).norm();
    (0.0..=1.0).contains(&part) && aside < CLOSED * length && begins.dot(tangent) > COSINE
}
