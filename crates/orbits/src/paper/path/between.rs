//! Special points between two points of a branch.

use super::{Follower, Position};
use crate::branch::{OrbitPoint, Special};
use crate::curve::{CurvePoint, correct};
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::paper::cycle::Cycle;
use crate::paper::orbit::newton;
use crate::paper::sample::{DOUBLING, PAIR, TESTS, UNIT, test};
use crate::paper::special;
use crate::path::Follow;
use crate::test_functions::SignedLog;
use nalgebra::Complex;

/// Accuracy of the `arc` of a special point, limited by the rounding of points.
const LOCATION: f64 = 1e-14;
/// Tolerance for equal values of the parameter, in its curve unit: rounding.
const ROUNDING: f64 = 1e-12;
/// Accuracy of the first location of a sign change, as a fraction of a step.
const ROUGHLY: f64 = 1e-4;
/// Distance limit from the unit circle, at this first location, for a pair of multipliers that may
/// have crossed it.
const NEAR_CIRCLE: f64 = 0.1;
/// Size limit of the largest multiplier, up to which multipliers on the unit circle keep ten
/// digits.
const RESOLVED: f64 = 1e6;

/// A special point within a step.
struct LabelledPoint {
    arc: f64,
    at: CurvePoint,
    label: Label,
}

/// The number of multipliers outside the unit circle.
fn outside(multipliers: &[Complex<f64>]) -> usize {
    multipliers.iter().filter(|m| m.norm() > 1.0).count()
}

/// Change of the number of multipliers outside the unit circle in a step.
fn crossings(last: &Position, next: &Position) -> usize {
    let [before, after] = [last, next].map(|p| outside(&p.multipliers));
    before.abs_diff(after)
}

/// Whether a test function is known at both ends of a step and changes its sign in it.
fn changes(last: &Position, next: &Position, index: usize) -> bool {
    let signs = [last, next].map(|p| p.tests[index].map_or(0.0, |t| t.sign));
    signs[0] * signs[1] < 0.0
}

/// Result when the pair's test function changes sign without a pair on the unit circle: `None` for
/// a neutral saddle, an error if two real multipliers cross the circle at 1 or -1. Such a crossing
/// does not change the signs of the test functions for 1 and -1; the step is then too long.
/// Crossings are only counted if the largest multiplier is below [`RESOLVED`]; otherwise the
/// smallest multipliers are rounding errors.
fn neutral<T>(last: &Position, next: &Position) -> Result<Option<T>, Obstacle> {
    let resolved = |p: &Position| p.multipliers[0].norm() < RESOLVED;
    let single = [UNIT, DOUBLING].iter().any(|index| changes(last, next, *index));
    let hidden = !single && crossings(last, next) >= 2 && resolved(last) && resolved(next);
    if hidden { Err(Obstacle::NoConvergence) } else { Ok(None) }
}

impl Follower<'_> {
    /// The special points between two points, in order, each with the stability of the piece after
    /// it.
    pub(super) fn between(&self, last: &Position, next: &Position) -> Result<Vec<OrbitPoint>, Obstacle> {
        let changes = |index: usize| {
            let pair = last.tests[index].zip(next.tests[index]);
            pair.filter(|(a, b)| a.sign * b.sign < 0.0).map(|(a, _)| a)
        };
        let mut found = Vec::new();
        for index in 0..TESTS {
            if let Some(unit) = changes(index) {
                found.extend(self.zero(last, next, index, unit)?);
            }
        }
        found.extend(self.marks.iter().filter_map(|mark| self.mark(last, next, *mark)));
        found.sort_by(|a, b| a.arc.total_cmp(&b.arc));
        let length = last.tangent.dot(&(&next.u - &last.u));
        let ends: Vec<f64> = found.iter().skip(1).map(|f| f.arc).chain([length]).collect();
        let mut points = Vec::new();
        for (LabelledPoint { arc, at, label }, end) in found.into_iter().zip(ends) {
            let middle = self.at_arc(last, next, 0.5 * (arc + end))?;
            let stability = self.look_certified(middle)?.stability;
            let position = self.look_certified(at)?;
            points.push(OrbitPoint { stability, ..self.point(&position, Some(Special::of(label))) });
        }
        Ok(points)
    }

    /// The branch's point in the plane across the last tangent, at distance `arc` from `last`.
    fn at_arc(&self, last: &Position, next: &Position, arc: f64) -> Result<CurvePoint, Obstacle> {
        let way = &next.u - &last.u;
        let length = last.tangent.dot(&way);
        let part = arc / length;
        // The parabola through both points that starts along the tangent.
        let predicted = &last.u + &last.tangent * arc + (way - &last.tangent * length) * (part * part);
        correct(&self.contacts(), &predicted, &last.tangent)
    }

    /// The bifurcation at the zero of a test function between two points, if it is one.
    fn zero(
        &self,
        last: &Position,
        next: &Position,
        index: usize,
        unit: SignedLog,
    ) -> Result<Option<LabelledPoint>, Obstacle> {
        let length = last.tangent.dot(&(&next.u - &last.u));
        let value = |arc: f64| -> Result<f64, Obstacle> {
            let at = self.at_arc(last, next, arc)?;
            let system = self.family.system_at(&at.u)?;
            let cycle = Cycle::new(&system, self.word, &at.u.as_slice()[..self.word.len()])?;
            let found = test(&cycle, index).ok_or(Obstacle::NoConvergence)?;
            Ok(found.relative_to(unit))
        };
        let ends = (unit.sign, next.tests[index].map_or(f64::NAN, |b| b.relative_to(unit)));
        if index == PAIR
            && !self
                .may_be_torus(last, next, |tolerance| crate::curve::zero(&value, length, ends, tolerance))?
        {
            return neutral(last, next);
        }
        let arc = crate::curve::zero(&value, length, ends, LOCATION).ok_or(Obstacle::NoConvergence)?;
        let at = self.at_arc(last, next, arc)?;
        let label = match index {
            UNIT if self.turns(last, next, &at) => Label::Fold,
            UNIT => Label::BranchPoint,
            DOUBLING if self.word.closing() > 0 => Label::PeriodDoubling,
            DOUBLING => Label::BranchPoint,
            _ => Label::NeimarkSacker,
        };
        if index == PAIR && !special::is_torus(self.family, self.word, &at.u)? {
            return neutral(last, next);
        }
        Ok(Some(LabelledPoint { arc, at, label }))
    }

    /// Whether the parameter has an extremum at a point within a step: the tangents at the step's
    /// ends have parameter components of opposite sign. A touch and a birth have no tangent of
    /// their own. A second test therefore compares values: both ends lie on the same side of the
    /// point's value.
    fn turns(&self, last: &Position, next: &Position, at: &CurvePoint) -> bool {
        let n = self.word.len();
        let sides = [last, next].map(|p| p.u[n] - at.u[n]);
        let beside = sides[0] * sides[1] > 0.0 && sides.iter().all(|side| side.abs() > ROUNDING);
        last.tangent[n] * next.tangent[n] < 0.0 || beside
    }

    /// Whether a pair of multipliers may cross the unit circle in a step with a sign change of the
    /// pair's test function. `zero` locates the sign change to a tolerance. The sign also changes
    /// at neutral saddles and, for very large multipliers, because of rounding. This check avoids
    /// an accurate location of such changes.
    fn may_be_torus(
        &self,
        last: &Position,
        next: &Position,
        zero: impl Fn(f64) -> Option<f64>,
    ) -> Result<bool, Obstacle> {
        // A pair changes the number of multipliers outside the circle by two, or by another number
        // if a real multiplier crosses in the same step.
        if !changes(last, next, UNIT) && !changes(last, next, DOUBLING) && crossings(last, next) < 2 {
            return Ok(false);
        }
        let length = last.tangent.dot(&(&next.u - &last.u));
        let arc = zero(ROUGHLY * length).ok_or(Obstacle::NoConvergence)?;
        let there = self.look(self.at_arc(last, next, arc)?)?.0;
        let near = |m: &Complex<f64>| m.im != 0.0 && (m.norm() - 1.0).abs() < NEAR_CIRCLE;
        Ok(there.multipliers.iter().any(near))
    }

    /// The point at a marked value of the parameter, if the step passes it.
    fn mark(&self, last: &Position, next: &Position, mark: f64) -> Option<LabelledPoint> {
        let n = self.word.len();
        let [from, to] = [&last.u, &next.u].map(|u| self.value(u));
        // If an end of the step has the marked value, that end gets the label.
        if (from - mark) * (to - mark) >= 0.0 || self.is_at(from, mark) || self.is_at(to, mark) {
            return None;
        }
        let part = (mark - from) / (to - from);
        let guess = &last.u + (&next.u - &last.u) * part;
        let system = self.family.system(&[mark]).ok()?;
        let phases = newton(&system, self.word, &guess.as_slice()[..n]).ok()?;
        let u = self.family.point(&phases, &[mark]);
        let arc = last.tangent.dot(&(&u - &last.u));
        let at = CurvePoint { u, tangent: last.tangent.clone(), steps: 3 };
        Some(LabelledPoint { arc, at, label: Label::UserValue })
    }
}
