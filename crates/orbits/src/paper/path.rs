//! One branch of orbits followed along a parameter, with the special points on it.

mod between;
mod step;

use super::branch::{OrbitPoint, Special};
use super::cycle::Cycle;
use super::family::{ContactEquations, Family, Span};
use super::grazing::{self, Touch};
use super::orbit::eigenvalues;
use super::switching::Departure;
use super::word::OrbitWord;
use crate::curve::CurvePoint;
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::paper::sample::{DOUBLING, Sample, TESTS, UNIT, test};
use crate::path_options::PathOptions;
use crate::test_functions::SignedLog;
use nalgebra::{Complex, DVector};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Least step: a branch that needs a smaller one ends with MX.
const LEAST_STEP: f64 = 1e-7;
/// The least cosine of the angle by which the tangent turns in a step.
const COSINE: f64 = 0.95;
/// Growth of the step after few Newton steps, and its reduction after many.
const GROWTH: f64 = 1.4;
const REDUCTION: f64 = 1.5;
/// Points after which a branch can have closed.
const SHORTEST_LOOP: usize = 10;
/// Distance from the first point, in steps, at which a branch counts as closed.
const CLOSED: f64 = 0.05;
/// Largest difference of two values of the parameter, in its curve unit, that counts as rounding.
const MARK: f64 = 1e-12;

/// End of a path.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) enum PathEnd {
    /// As the label of the last point says.
    Plain,
    /// At the first point of the path.
    Closed,
    /// At a touch.
    Touch(Box<Touch>),
    /// At the branch from which this branch is born by doubling, with the word, phases and
    /// parameter on that branch.
    Primary(OrbitWord, #[serde(with = "super::stored::vector")] DVector<f64>),
}

/// A path with its end.
#[derive(Clone, Debug)]
pub(super) struct Path {
    pub points: Vec<OrbitPoint>,
    pub end: PathEnd,
}

/// A point with its cycle's properties.
struct Position {
    u: DVector<f64>,
    tangent: DVector<f64>,
    steps: usize,
    multipliers: [Complex<f64>; 6],
    stable: bool,
    tests: [Option<SignedLog>; TESTS],
}

/// A step that was taken.
struct Advance {
    between: Vec<OrbitPoint>,
    next: Position,
    label: Option<Special>,
    end: Option<PathEnd>,
}

pub(super) struct Follower<'a> {
    pub family: &'a Family,
    pub word: &'a OrbitWord,
    pub options: &'a PathOptions,
    /// Values of the parameter at which points are wanted.
    pub marks: &'a [f64],
}

/// Follows a branch until it ends.
pub(super) fn follow(follower: &Follower, departure: Departure) -> Result<Path, Obstacle> {
    let first = follower.first(&departure)?;
    let mut points = vec![follower.point(&first, departure.special.clone())];
    let (start_u, start_tangent) = (first.u.clone(), first.tangent.clone());
    let mut last = first;
    let mut step = departure.step.min(follower.options.longest_step);
    loop {
        if points.len() >= follower.options.most_points {
            label_last(&mut points, Label::NoConvergence);
            return Ok(Path { points, end: PathEnd::Plain });
        }
        let advance = match follower.advance(&last, step) {
            Err(_) if step > LEAST_STEP => {
                step *= 0.5;
                continue;
            }
            advance => advance.or_else(|_| follower.advance_to_birth(&last)),
        };
        let Ok(advance) = advance else {
            label_last(&mut points, Label::NoConvergence);
            return Ok(Path { points, end: PathEnd::Plain });
        };
        let Advance { between, next, label, end } = advance;
        let closes = points.len() > SHORTEST_LOOP && follower.closes(&start_u, &start_tangent, &last, &next);
        if points.len() == 1 && departure.special.is_some() {
            // The first point is special, so that its piece has the stability of the next point.
            points[0].stable = next.stable && between.is_empty();
        }
        points.extend(between);
        if closes {
            points.push(points[0].clone());
            return Ok(Path { points, end: PathEnd::Closed });
        }
        let mut point = follower.point(&next, label);
        if end.is_some() {
            // The last point has the stability of the piece before it.
            point.stable = points.last().is_some_and(|p| p.stable);
        }
        points.push(point);
        if let Some(end) = end {
            return Ok(Path { points, end });
        }
        if next.steps <= 3 {
            step *= GROWTH;
        } else if next.steps >= 5 {
            step /= REDUCTION;
        }
        step = step.clamp(LEAST_STEP, follower.options.longest_step);
        last = next;
    }
}

fn label_last(points: &mut [OrbitPoint], label: Label) {
    if let Some(last) = points.last_mut().filter(|p| p.special.is_none()) {
        last.special = Some(Special::of(label));
    }
}

impl Follower<'_> {
    fn contacts(&self) -> ContactEquations<'_> {
        ContactEquations { family: self.family, word: self.word }
    }

    fn span(&self) -> &Span {
        self.family.span()
    }

    fn value(&self, u: &DVector<f64>) -> f64 {
        u[self.word.len()] * self.span().unit()
    }

    /// Whether a value of the parameter is a mark except for rounding.
    fn is_at(&self, value: f64, mark: f64) -> bool {
        (value - mark).abs() <= MARK * self.span().unit()
    }

    fn point(&self, position: &Position, special: Option<Special>) -> OrbitPoint {
        let value = self.value(&position.u);
        let mark =
            self.marks.iter().copied().find(|mark| self.is_at(value, *mark)).filter(|_| special.is_none());
        OrbitPoint {
            value: mark.unwrap_or(value),
            phases: position.u.as_slice()[..self.word.len()].to_vec(),
            multipliers: position.multipliers,
            stable: position.stable,
            special: special.or(mark.map(|_| Special::of(Label::UserValue))),
        }
    }

    /// Properties of the first point. At a birth or a touch only the test functions that are
    /// regular there are computed.
    fn first(&self, departure: &Departure) -> Result<Position, Obstacle> {
        let Departure { u, tangent, .. } = departure;
        let system = self.family.system_at(u)?;
        let cycle = Cycle::new(&system, self.word, &u.as_slice()[..self.word.len()])?;
        let label = departure.special.as_ref().map(|s| s.label);
        if label.is_none() {
            let sample = Sample::of(&cycle).ok_or(Obstacle::NoConvergence)?;
            let (stable, Sample { multipliers, tests, .. }) = (sample.is_stable(), sample);
            return Ok(Position {
                u: u.clone(),
                tangent: tangent.clone(),
                steps: 3,
                multipliers,
                stable,
                tests,
            });
        }
        let smooth = label == Some(Label::Grazing);
        let tests = [UNIT, DOUBLING].map(|index| if smooth { test(&cycle, index) } else { None });
        let own = || eigenvalues(cycle.monodromy());
        let multipliers = departure.multipliers.or_else(own).ok_or(Obstacle::NoConvergence)?;
        let tests = [tests[0], tests[1], None];
        Ok(Position { u: u.clone(), tangent: tangent.clone(), steps: 3, multipliers, stable: false, tests })
    }

    /// Properties of a point on the curve, with the touches that it announces if it is not
    /// certified.
    fn look(&self, curve: CurvePoint) -> Result<(Position, Option<Vec<Touch>>), Obstacle> {
        let system = self.family.system_at(&curve.u)?;
        let cycle = Cycle::new(&system, self.word, &curve.u.as_slice()[..self.word.len()])?;
        let sample = Sample::of(&cycle).ok_or(Obstacle::NoConvergence)?;
        let touches = (!sample.is_certified()).then(|| grazing::announced(&cycle, &curve.u));
        let (stable, Sample { multipliers, tests, .. }) = (sample.is_stable(), sample);
        let CurvePoint { u, tangent, steps } = curve;
        Ok((Position { u, tangent, steps, multipliers, stable, tests }, touches))
    }

    /// Properties of a point within a step between two certified points. If it is not certified,
    /// the block touches stops twice in the step, and the step is too long.
    fn look_certified(&self, curve: CurvePoint) -> Result<Position, Obstacle> {
        let (position, touches) = self.look(curve)?;
        if touches.is_some() { Err(Obstacle::NoConvergence) } else { Ok(position) }
    }

    /// Whether a step passes the first point of the path again.
    fn closes(&self, u: &DVector<f64>, tangent: &DVector<f64>, last: &Position, next: &Position) -> bool {
        let n = self.word.len();
        let way = &next.u - &last.u;
        let length = way.norm();
        let phases = &u.as_slice()[..n];
        self.word.symmetries(self.family.is_symmetric()).into_iter().any(|turn| {
            let turned = self.word.turned_phases(phases, turn);
            let rates =
                DVector::from_fn(n + 1, |i, _| if i < n { tangent[(i + turn.by) % n] } else { tangent[n] });
            let whole = ((last.u[0] - turned[0]) / TAU).round() * TAU;
            let there = DVector::from_fn(n + 1, |i, _| if i < n { turned[i] + whole } else { u[n] });
            let from = there - &last.u;
            let part = from.dot(&way) / (length * length);
            let aside = (from - &way * part).norm();
            let same_way = rates.dot(&next.tangent) > COSINE;
            (0.0..=1.0).contains(&part) && aside < CLOSED * length && same_way
        })
    }
}
