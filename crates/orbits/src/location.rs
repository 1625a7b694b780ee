//! Events within a step along a branch: the end of the range, a doubling at which the branch is
//! born, conditions that cease to hold, bifurcations.

use super::bifurcation::{Bracket, Ends, Test};
use super::branch::{OrbitPoint, Special};
use super::conditions::Condition;
use super::orbit::Orbit;
use super::path::Follow;
use super::position::{Examined, Position, doubling};
use super::step::Follower;
use crate::curve::zero;
use crate::curve::{CurvePoint, axis, correct, gradient, meet};
use crate::obstacle::Obstacle;
use crate::test_functions::is_on_circle;
use nalgebra::DVector;
use std::cmp::Ordering;
use vibro_numerics::sorting::sort_by;

/// Tolerance for equal halves of an orbit: rounding.
const BIRTH: f64 = 1e-9;
/// Step of the difference quotients of a test function. It affects how fast its zero converges,
/// not the result.
const DIFFERENCE: f64 = 1e-6;
/// Accuracy of the arc of a special point.
const LOCATION: f64 = 1e-13;
/// Distance, as a fraction of a step, within which a bifurcation belongs to a touch, or conditions
/// cease to hold together: near a visit of zero duration the equations are nearly singular.
const MERGED: f64 = 1e-5;
/// Positions of the points that interpolate a crossing, in steps from it, and the step as a
/// fraction of the arc.
const NODES: [f64; 6] = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0];
const NODE_STEP: f64 = 0.02;
/// Tolerance for the tangent's parameter component, per arc of a step: rounding. A family of
/// orbits at one value of the parameter has no folds.
const VERTICAL: f64 = 1e-5;
/// Arc below which rounding no longer shrinks with the step.
const SHORT_ARC: f64 = 1e-2;
/// Largest number of secant steps towards an interpolated zero.
const MOST_SECANTS: usize = 3;

/// A condition that ceases to hold in a step, with its arc, and the position if it was
/// interpolated.
type Broken = (Condition, f64, Option<Position<Examined>>);

impl Follower<'_> {
    /// The end of the parameter's range, if a step passes it, with its arc.
    pub fn boundary(
        &self,
        last: &Position<Examined>,
        next: &Position<Examined>,
        arc: f64,
    ) -> Result<Option<(Position<Examined>, f64)>, Obstacle> {
        let (from, to) = self.problem.family.range;
        let value = self.problem.value(&next.u);
        let end = if value > to {
            to
        } else if value < from {
            from
        } else {
            return Ok(None);
        };
        let index = self.problem.size();
        let goal = end / self.problem.family.unit();
        let way = next.u[index] - last.u[index];
        let part = if way == 0.0 { 1.0 } else { (goal - last.u[index]) / way };
        let guess = &last.u + (&next.u - &last.u) * part;
        Ok(Some((self.look(self.at_value(last, guess, end)?)?, arc * part)))
    }

    /// The point of the curve at a given parameter value, near a guess.
    fn at_value(
        &self,
        last: &Position<Examined>,
        mut guess: DVector<f64>,
        value: f64,
    ) -> Result<CurvePoint, Obstacle> {
        let index = self.problem.size();
        let goal = value / self.problem.family.unit();
        guess[index] = goal;
        let mut at = correct(self.problem, &guess, &axis(guess.len(), index))?;
        at.u[index] = goal;
        if at.tangent.dot(&last.tangent) < 0.0 {
            at.tangent = -at.tangent;
        }
        Ok(at)
    }

    /// The end of the parameter's range if a step would lead beyond it, with its arc: values
    /// beyond may not be allowed.
    pub fn boundary_ahead(&self, last: &Position<Examined>, step: f64) -> Option<(Position<Examined>, f64)> {
        let (from, to) = self.problem.family.range;
        let (index, unit) = (self.problem.size(), self.problem.family.unit());
        let (value, rate) = (last.u[index] * unit, last.tangent[index] * unit);
        let end = if rate > 0.0 { to } else { from };
        let arc = (end - value) / rate;
        if !(0.0..step).contains(&arc) {
            return None;
        }
        let at = self.at_value(last, &last.u + &last.tangent * arc, end).ok()?;
        let is_near = (&at.u - &last.u).norm() <= 2.0 * arc.max(f64::EPSILON);
        Some((self.look(at).ok().filter(|_| is_near)?, arc))
    }

    /// The doubling at which this branch is born, if a step passes it, with its fraction of the
    /// step. Both halves of the orbit are equal there, and beyond it the branch retraces itself.
    pub fn birth(
        &self,
        last: &Position<Examined>,
        next: &Position<Examined>,
    ) -> Result<Option<(Position<Examined>, f64)>, Obstacle> {
        let Some(half) = self.problem.half() else { return Ok(None) };
        let [before, after] = [&last.u, &next.u].map(|u| self.problem.halves(u));
        let (before, after) = (before?, after?);
        if before.dot(&after) >= 0.0 || before.norm() < BIRTH {
            return Ok(None);
        }
        let part = before.norm() / (before.norm() + after.norm());
        let at = &last.u + (&next.u - &last.u) * part;
        let guess = self.problem.halved(&half, &at)?;
        let function = |u: &DVector<f64>| {
            let orbit = Orbit::at(half.clone(), half.place(u)?, u.clone())?;
            Ok(doubling(orbit.multipliers()))
        };
        let condition = |u: &DVector<f64>| Ok((function(u)?, gradient(u, DIFFERENCE, function)?));
        let u = meet(&half, &guess, condition)?;
        if (&u - &guess).norm() > (&next.u - &last.u).norm() {
            return Err(Obstacle::NoConvergence);
        }
        let (_, u) = half.repeated(&half.place(&u)?, &u, 2)?;
        let birth = self.look(CurvePoint { u, tangent: last.tangent.clone(), steps: 3 })?;
        Ok(Some((birth, part)))
    }

    /// The first condition that ceases to hold in a step, with its arc, and the position if it was
    /// interpolated.
    pub fn broken(
        &self,
        last: &Position<Examined>,
        next: &Position<Examined>,
        arc: f64,
        leaves: bool,
    ) -> Result<Option<Broken>, Obstacle> {
        let mut first: Option<Broken> = None;
        for (condition, after) in next.tests.conditions.iter().filter(|(own, value)| own.fails(*value)) {
            let before = value_of(&last.tests.conditions, *condition).unwrap_or(1.0);
            if condition.fails(before) {
                // It has just begun to fail, or the branch starts at the point where it fails.
                if leaves {
                    return Err(Obstacle::NoConvergence);
                }
                first = Some((*condition, 0.0, None));
                continue;
            }
            let value = |s: f64| {
                let at = self.within(last, next, arc, s)?;
                let place = self.problem.place(&at.u)?;
                let cycle = self.problem.cycle(&place, &at.u)?;
                Ok(value_of(&cycle.conditions(&place, &self.problem.word), *condition).unwrap_or(1.0))
            };
            let found = if *after > 0.0 { Some(arc) } else { zero(&value, arc, (before, *after), LOCATION) };
            let (at, own) = match found {
                Some(at) => (at, None),
                // Two events that vanish together make the equations singular.
                None => {
                    let of =
                        |at: &Position<Examined>| value_of(&at.tests.conditions, *condition).unwrap_or(1.0);
                    let (at, own) = self.between_points(last, arc, (before, *after), &of)?;
                    (at, Some(own))
                }
            };
            let is_before = |(other, s, _): &(Condition, f64, _)| match condition.rank().cmp(&other.rank()) {
                Ordering::Less => at <= *s + MERGED * arc,
                Ordering::Equal => at < *s,
                Ordering::Greater => at < *s - MERGED * arc,
            };
            if first.as_ref().is_none_or(is_before) {
                first = Some((*condition, at, own));
            }
        }
        Ok(first)
    }

    /// The bifurcations within a step, in order. `earlier` is the position before the step, with
    /// the arc to its start.
    pub fn bifurcations(
        &self,
        earlier: Option<&(Position<Examined>, f64)>,
        last: &Position<Examined>,
        at_end: &Ends,
    ) -> Result<Vec<OrbitPoint>, Obstacle> {
        let mut found: Vec<(f64, OrbitPoint)> = Vec::new();
        for test in Test::ALL {
            let (next, arc) = at_end.of(test);
            let ends = [last, next].map(|at| test.of(at, last));
            let is_vertical =
                test == Test::Fold && ends[0].abs().max(ends[1].abs()) < VERTICAL * arc.max(SHORT_ARC);
            if is_vertical {
                continue;
            }
            let brackets = match ends[0] * ends[1] < 0.0 {
                true => vec![Bracket { begin: 0.0, ends: [last.clone(), next.clone()], arc }],
                false => earlier.map_or_else(Vec::new, |own| self.hidden(test, own, [last, next], arc)),
            };
            for bracket in &brackets {
                found.extend(self.zero_in(test, bracket)?.map(|(at, point)| (bracket.begin + at, point)));
            }
        }
        sort_by(&mut found, |a, b| a.0.total_cmp(&b.0));
        // Near a touch, multipliers grow without bound: a bifurcation there belongs to the touch.
        let Ends { next, arc, is_touch, .. } = *at_end;
        found.retain(|(at, _)| !is_touch || arc - at > MERGED * arc);
        // A bifurcation gets the stability of the piece after it.
        let mut points: Vec<OrbitPoint> = found.into_iter().map(|(_, point)| point).collect();
        for k in 0..points.len() {
            if k + 1 == points.len() {
                points[k].stability = next.stability;
            } else {
                let middle = (&points[k].u + &points[k + 1].u) * 0.5;
                let tangent = (&points[k + 1].u - &points[k].u).normalize();
                points[k].stability = self.look(correct(self.problem, &middle, &tangent)?)?.stability;
            }
        }
        Ok(points)
    }

    /// The bifurcation at which a test changes sign, with its arc in the bracket; `None` for a
    /// pair of real multipliers.
    fn zero_in(&self, test: Test, bracket: &Bracket) -> Result<Option<(f64, OrbitPoint)>, Obstacle> {
        let Bracket { ends: [last, next], arc, .. } = bracket;
        let special = Some(Special::of(test.label()));
        let ends = (test.of(last, last), test.of(next, last));
        if test == Test::Crossing {
            let crossing = |at: &Position<Examined>| Test::Crossing.of(at, last);
            let (at, near) = self.between_points(last, *arc, ends, &crossing)?;
            // First interpolated, then refined by the crossing's own equations.
            let position = match self.problem.crossing(&near.u, *arc) {
                Some(u) => self.look(CurvePoint { u, tangent: near.tangent, steps: near.steps })?,
                None => near,
            };
            return Ok(Some((at, self.point(&position, special))));
        }
        let value = |s: f64| Ok(test.of(&self.look(self.within(last, next, *arc, s)?)?, last));
        let at = zero(&value, *arc, ends, LOCATION).ok_or(Obstacle::NoConvergence)?;
        let position = self.look(self.within(last, next, *arc, at)?)?;
        let is_own = test != Test::Pair || is_on_circle(&position.multipliers);
        Ok(is_own.then(|| (at, self.point(&position, special))))
    }

    /// A zero of a test in a step with singular equations, as at a crossing of branches. Points
    /// near it cannot be computed, so the test and the unknowns are interpolated from points on
    /// both sides.
    fn between_points(
        &self,
        last: &Position<Examined>,
        arc: f64,
        ends: (f64, f64),
        test: &dyn Fn(&Position<Examined>) -> f64,
    ) -> Result<(f64, Position<Examined>), Obstacle> {
        // Secant steps that stay away from the ends.
        let mut near = arc * (ends.0 / (ends.0 - ends.1)).clamp(0.1, 0.9);
        let mut nodes: Vec<(f64, Position<Examined>)> = Vec::new();
        for _ in 0..MOST_SECANTS {
            nodes.clear();
            for k in NODES {
                let s = near + k * NODE_STEP * arc;
                nodes.push((s, self.look(self.at(last, s)?)?));
            }
            let values: Vec<f64> = nodes.iter().map(|(_, at)| test(at)).collect();
            let times: Vec<f64> = nodes.iter().map(|(s, _)| *s).collect();
            // Inverse interpolation: the zero as a function of the test.
            let next = interpolated(&values, &times, 0.0);
            let moved = (next - near).abs();
            near = next.clamp(0.0, arc);
            if moved < 0.5 * NODE_STEP * arc {
                break;
            }
        }
        let times: Vec<f64> = nodes.iter().map(|(s, _)| *s).collect();
        let of = |value: &dyn Fn(&Position<Examined>) -> f64| {
            let values: Vec<f64> = nodes.iter().map(|(_, at)| value(at)).collect();
            interpolated(&times, &values, near)
        };
        let size = last.u.len();
        let u = DVector::from_fn(size, |i, _| of(&|at| at.u[i]));
        let tangent = DVector::from_fn(size, |i, _| of(&|at| at.tangent[i])).normalize();
        Ok((near, self.look(CurvePoint { u, tangent, steps: 3 })?))
    }
}

/// Value at `x` of the polynomial through given points.
fn interpolated(from: &[f64], to: &[f64], x: f64) -> f64 {
    let weight = |i: usize| {
        let others = (0..from.len()).filter(|j| *j != i);
        others.map(|j| (x - from[j]) / (from[i] - from[j])).product::<f64>()
    };
    (0..from.len()).map(|i| weight(i) * to[i]).sum()
}

fn value_of(conditions: &[(Condition, f64)], condition: Condition) -> Option<f64> {
    conditions.iter().find(|(own, _)| *own == condition).map(|(_, value)| *value)
}
