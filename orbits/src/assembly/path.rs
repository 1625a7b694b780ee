//! One branch followed along the parameter, with its special points.

use super::branch::{Branch, OrbitPoint, Special};
use super::cycle::Condition;
use super::orbit::{Orbit, Stability};
use super::problem::{Problem, Residual};
use crate::branch::Label;
use crate::curve::{CurvePoint, Equations, correct, gradient, meet};
use crate::obstacle::Obstacle;
use crate::path::PathOptions;
use crate::special::zero;
use crate::test_functions::{SignedLog, determinant, is_on_circle, pair_test};
use nalgebra::{Complex, DVector};

/// Least step; a branch that needs a smaller one ends with MX.
const LEAST_STEP: f64 = 1e-7;
/// Steps that are tried where shorter ones fail.
const JUMPS: [f64; 4] = [1e-3, 3e-3, 1e-2, 3e-2];
/// Least cosine of the angle by which the tangent turns in a step.
const COSINE: f64 = 0.95;
/// Growth of the step after few Newton steps, and its reduction after many.
const GROWTH: f64 = 1.4;
const REDUCTION: f64 = 1.5;
/// Points after which a branch can have closed.
const SHORTEST_LOOP: usize = 10;
/// Share of the parameter in the tangent below which the equations are bordered as they are.
const STEEP: f64 = 1e-2;
/// Size of the difference of an orbit's halves that is rounding.
const BIRTH: f64 = 1e-9;
/// Step of the differences of a test function. It sets the speed of convergence of its zero and
/// never the result.
const DIFFERENCE: f64 = 1e-6;
/// Accuracy of the arc of a special point.
const LOCATION: f64 = 1e-13;
/// Value of a condition, relative to its terms, below zero that is rounding.
const ROUNDING: f64 = 1e-12;
/// Distance, in parts of a step, within which a bifurcation is one with a touch.
const MERGED: f64 = 1e-5;
/// Distance of a fold from a crossing at which it is the turn of the side branch.
const TURN: f64 = 1e-4;
/// Places of the points from which a crossing is interpolated, in steps beside it, and the step in
/// parts of the arc.
const NODES: [f64; 6] = [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0];
const NODE_STEP: f64 = 0.02;
/// Most steps towards such a zero.
const MOST_SECANTS: usize = 3;
/// Part of the arc to a touch at which its multipliers are taken, on this side of it.
const BEFORE: f64 = 1.0 - 1e-7;

/// Start of a path.
#[derive(Clone, Debug)]
pub(super) struct Departure {
    pub problem: Problem,
    pub u: DVector<f64>,
    /// The direction in which the path leaves.
    pub direction: DVector<f64>,
    /// The first step.
    pub step: f64,
    /// The special point from which it leaves: no condition is examined there.
    pub special: Option<Special>,
}

impl Departure {
    /// The orbit after a first step of a length; `None` where there is none.
    pub fn first_orbit(&self, step: f64) -> Option<Orbit> {
        let direction = self.direction.normalize();
        let at = correct(&self.problem, &(&self.u + &direction * step), &direction).ok()?;
        let (problem, u) = self.problem.reduced(&at.u).ok()?;
        let place = problem.place(&u).ok()?;
        Orbit::at(problem, place, u).ok()
    }
}

/// What follows at the end of a path.
#[derive(Clone, Debug)]
pub(super) enum PathEnd {
    /// As the label of the last point says.
    Plain,
    /// At the first point of the path.
    Closed,
    /// Where a condition ceases to hold.
    Broken(Condition),
}

/// A path with its end.
pub(super) struct Path {
    pub points: Vec<OrbitPoint>,
    pub end: PathEnd,
}

/// A point with its properties.
#[derive(Clone)]
struct Position {
    u: DVector<f64>,
    tangent: DVector<f64>,
    steps: usize,
    period: f64,
    multipliers: Vec<Complex<f64>>,
    stability: Stability,
    /// Determinant of the equations bordered by the tangent: zero where branches cross.
    crossing: SignedLog,
    /// ∏ (1 + μ), each factor of size one at most: zero at a doubling.
    doubling: f64,
    /// Zero where a pair of multipliers has the product 1.
    pair: f64,
    conditions: Vec<(Condition, f64)>,
}

impl Position {
    /// Position along the parameter's direction.
    fn fold(&self) -> f64 {
        self.tangent[self.tangent.len() - 1]
    }
}

/// A bifurcation's test.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Test {
    Fold,
    Crossing,
    Doubling,
    Pair,
}

impl Test {
    const ALL: [Self; 4] = [Self::Fold, Self::Crossing, Self::Doubling, Self::Pair];

    fn label(self) -> Label {
        match self {
            Self::Fold => Label::Fold,
            Self::Crossing => Label::BranchPoint,
            Self::Doubling => Label::PeriodDoubling,
            Self::Pair => Label::NeimarkSacker,
        }
    }

    /// The test's value in units of a position's.
    fn of(self, at: &Position, unit: &Position) -> f64 {
        match self {
            Self::Fold => at.fold(),
            Self::Crossing => at.crossing.relative_to(unit.crossing),
            Self::Doubling => at.doubling,
            Self::Pair => at.pair,
        }
    }
}

struct Follower<'a> {
    problem: &'a Problem,
}

/// Follows a branch from a departure until it ends.
pub(super) fn follow(departure: &Departure, options: &PathOptions) -> Result<Path, Obstacle> {
    let follower = Follower { problem: &departure.problem };
    let first = follower.first(departure)?;
    let mut points = vec![follower.point(&first, departure.special.clone())];
    let start = (first.u.clone(), first.tangent.clone());
    let (mut last, mut step) = (first, departure.step.min(options.longest_step));
    let mut is_first = true;
    loop {
        if points.len() >= options.most_points {
            return Ok(ended(points, Label::NoConvergence));
        }
        let next = match follower.step(&last, step, is_first && departure.special.is_some()) {
            Ok(next) => next,
            Err(_) if step > LEAST_STEP => {
                step *= 0.5;
                continue;
            }
            // Next to a crossing the equations are nearly singular: a longer step passes it.
            Err(_) => {
                let mut jumps = JUMPS.iter().filter(|_| !is_first);
                match jumps.find_map(|jump| follower.step(&last, *jump, false).ok()) {
                    Some(next) => next,
                    None => return Ok(ended(points, Label::NoConvergence)),
                }
            }
        };
        let Step { between, next, special, end } = next;
        if is_first && departure.special.is_some() {
            points[0].stability = between.first().map_or(next.stability, |p| p.stability);
            points[0].multipliers = next.multipliers.clone();
        }
        is_first = false;
        points.extend(between);
        if end.is_none() && points.len() > SHORTEST_LOOP && follower.closes(&start, &last, &next) {
            let first = points[0].clone();
            points.push(first);
            return Ok(Path { points, end: PathEnd::Closed });
        }
        points.push(follower.point(&next, special));
        if let Some(end) = end {
            return Ok(Path { points, end });
        }
        if next.steps <= 3 {
            step *= GROWTH;
        } else if next.steps >= 5 {
            step /= REDUCTION;
        }
        step = step.clamp(LEAST_STEP, options.longest_step);
        last = next;
    }
}

fn ended(mut points: Vec<OrbitPoint>, label: Label) -> Path {
    if let Some(last) = points.last_mut().filter(|p| p.special.is_none()) {
        last.special = Some(Special::of(label));
    }
    Path { points, end: PathEnd::Plain }
}

/// A step that was taken.
struct Step {
    between: Vec<OrbitPoint>,
    next: Position,
    special: Option<Special>,
    end: Option<PathEnd>,
}

impl Follower<'_> {
    fn point(&self, at: &Position, special: Option<Special>) -> OrbitPoint {
        OrbitPoint {
            value: self.problem.value(&at.u),
            period: at.period,
            multipliers: at.multipliers.clone(),
            stability: at.stability,
            special,
            u: at.u.clone(),
        }
    }

    fn first(&self, departure: &Departure) -> Result<Position, Obstacle> {
        let Departure { u, direction, .. } = departure;
        let at = CurvePoint { u: u.clone(), tangent: direction.normalize(), steps: 3 };
        self.look(at)
    }

    /// Properties of a point of the curve.
    fn look(&self, at: CurvePoint) -> Result<Position, Obstacle> {
        let CurvePoint { u, tangent, steps } = at;
        let place = self.problem.place(&u)?;
        let Residual { matrix, cycle, .. } = self.problem.residual(&place, &u, true)?;
        let matrix = matrix.ok_or(Obstacle::NoConvergence)?;
        let along = tangent[tangent.len() - 1];
        // det [F_u F_p; t] = det F_u / t_p, since F_u t_u = -F_p t_p.
        let crossing = if along.abs() > STEEP {
            let SignedLog { sign, log } = determinant(matrix);
            SignedLog { sign: sign * along.signum(), log: log - along.abs().ln() }
        } else {
            let whole = self.problem.linearize(&u, None)?.matrix;
            let last = whole.nrows();
            let mut bordered = whole.insert_row(last, 0.0);
            bordered.set_row(last, &tangent.transpose());
            determinant(bordered)
        };
        let orbit = Orbit::of_cycle(self.problem.clone(), place, u.clone(), cycle)?;
        let multipliers = orbit.multipliers().to_vec();
        let pair = pair_test(&multipliers);
        Ok(Position {
            tangent,
            steps,
            period: orbit.period(),
            stability: orbit.stability(),
            crossing,
            doubling: doubling(&multipliers),
            pair: pair.relative_to(SignedLog { sign: 1.0, log: 0.0 }),
            conditions: orbit.conditions().to_vec(),
            multipliers,
            u,
        })
    }

    /// The point at an arc from a position.
    fn at(&self, from: &Position, arc: f64) -> Result<CurvePoint, Obstacle> {
        correct(self.problem, &(&from.u + &from.tangent * arc), &from.tangent)
    }

    /// One step, with the special points on it. `leaves` says that it leaves a special point.
    fn step(&self, last: &Position, step: f64, leaves: bool) -> Result<Step, Obstacle> {
        let next = self.at(last, step)?;
        if next.tangent.dot(&last.tangent) < COSINE && !leaves {
            return Err(Obstacle::NoConvergence);
        }
        let (mut next, mut arc, mut end, mut special) = (self.look(next)?, step, None, None);
        if let Some((condition, at, found)) = self.broken(last, &next, step, leaves)? {
            let place = self.problem.place(&next.u)?;
            special = Some(Special::of_condition(condition, &self.problem.word, &place));
            let before = self.at(last, at * BEFORE).and_then(|before| self.look(before));
            let own = match found {
                Some(own) => own,
                None => self.look(self.at(last, at)?)?,
            };
            // A touch has multipliers on this side of it.
            next = match before {
                Ok(before) => {
                    Position { multipliers: before.multipliers, stability: before.stability, ..own }
                }
                Err(_) => own,
            };
            (arc, end) = (at, Some(PathEnd::Broken(condition)));
        }
        if let Some((boundary, at)) = self.boundary(last, &next, arc)? {
            (next, arc, special, end) =
                (boundary, at, Some(Special::of(Label::EndPoint)), Some(PathEnd::Plain));
        }
        if !leaves && let Some((birth, at)) = self.birth(last, &next)? {
            (next, arc, special, end) =
                (birth, at * arc, Some(Special::of(Label::PeriodDoubling)), Some(PathEnd::Plain));
        }
        let is_touch = matches!(end, Some(PathEnd::Broken(_)));
        let between = self.bifurcations(last, &next, arc, (leaves, is_touch))?;
        Ok(Step { between, next, special, end })
    }

    /// The end of the parameter's range, if a step passes it, with its arc.
    fn boundary(
        &self,
        last: &Position,
        next: &Position,
        arc: f64,
    ) -> Result<Option<(Position, f64)>, Obstacle> {
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
        let mut guess = &last.u + (&next.u - &last.u) * part;
        guess[index] = goal;
        let axis = crate::curve::axis(guess.len(), index);
        let mut at = correct(self.problem, &guess, &axis)?;
        at.u[index] = goal;
        if at.tangent.dot(&last.tangent) < 0.0 {
            at.tangent = -at.tangent;
        }
        Ok(Some((self.look(at)?, arc * part)))
    }

    /// The doubling at which this branch is born, if a step passes it, with its part of the step:
    /// both halves of the orbit are equal there, and past it the branch runs back along itself.
    fn birth(&self, last: &Position, next: &Position) -> Result<Option<(Position, f64)>, Obstacle> {
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
        let (_, u) = half.repeated(&half.place(&u)?, &u, 2);
        let birth = self.look(CurvePoint { u, tangent: last.tangent.clone(), steps: 3 })?;
        // No test is examined at the birth itself.
        Ok(Some((
            Position { crossing: last.crossing, doubling: last.doubling, pair: last.pair, ..birth },
            part,
        )))
    }

    /// The first condition that ceases to hold in a step, with its arc, and the position there where
    /// it is not solved for.
    fn broken(
        &self,
        last: &Position,
        next: &Position,
        arc: f64,
        leaves: bool,
    ) -> Result<Option<(Condition, f64, Option<Position>)>, Obstacle> {
        let fails = |(condition, value): &&(Condition, f64)| match condition {
            Condition::Stays { .. } => *value < -ROUNDING,
            _ => *value <= 0.0,
        };
        let mut first: Option<(Condition, f64, Option<Position>)> = None;
        for (condition, after) in next.conditions.iter().filter(fails) {
            let before = value_of(&last.conditions, *condition).unwrap_or(1.0);
            if before <= 0.0 {
                // It has just begun to fail, or the branch leaves the point at which it does.
                if leaves {
                    return Err(Obstacle::NoConvergence);
                }
                first = Some((*condition, 0.0, None));
                continue;
            }
            let value = |s: f64| {
                let at = self.at(last, s)?;
                let place = self.problem.place(&at.u)?;
                let cycle = self.problem.cycle(&place, &at.u)?;
                Ok(value_of(&cycle.conditions(&self.problem.word), *condition).unwrap_or(1.0))
            };
            let (at, own) = match zero(&value, arc, (before, *after), LOCATION) {
                Some(at) => (at, None),
                // Two events that vanish together leave singular equations.
                None => {
                    let of = |at: &Position| value_of(&at.conditions, *condition).unwrap_or(1.0);
                    let (at, own) = self.between_points(last, arc, (before, *after), &of)?;
                    (at, Some(own))
                }
            };
            if first.as_ref().is_none_or(|(_, s, _)| at < *s) {
                first = Some((*condition, at, own));
            }
        }
        Ok(first)
    }

    /// The bifurcations within a step of a length, in their order.
    fn bifurcations(
        &self,
        last: &Position,
        next: &Position,
        arc: f64,
        (leaves, ends_at_touch): (bool, bool),
    ) -> Result<Vec<OrbitPoint>, Obstacle> {
        let mut found: Vec<(f64, OrbitPoint)> = Vec::new();
        for test in Test::ALL {
            let ends = (test.of(last, last), test.of(next, last));
            if ends.0 * ends.1 >= 0.0 || leaves {
                continue;
            }
            if test == Test::Crossing {
                let crossing = |at: &Position| Test::Crossing.of(at, last);
                let (at, position) = self.between_points(last, arc, ends, &crossing)?;
                found.push((at, self.point(&position, Some(Special::of(test.label())))));
                continue;
            }
            let value = |s: f64| Ok(test.of(&self.look(self.at(last, s)?)?, last));
            let at = zero(&value, arc, ends, LOCATION).ok_or(Obstacle::NoConvergence)?;
            let position = self.look(self.at(last, at)?)?;
            if test == Test::Pair && !is_on_circle(&position.multipliers) {
                continue;
            }
            found.push((at, self.point(&position, Some(Special::of(test.label())))));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Next to a touch multipliers grow without bound: a bifurcation there is the touch.
        found.retain(|(at, _)| !ends_at_touch || arc - at > MERGED * arc);
        // The piece after a bifurcation has the stability of what follows.
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

    /// A zero of a test in a step at which the equations are singular, as at a crossing of branches,
    /// so that no point next to it is solved for: the test and the unknowns are interpolated from
    /// points on both sides.
    fn between_points(
        &self,
        last: &Position,
        arc: f64,
        ends: (f64, f64),
        test: &dyn Fn(&Position) -> f64,
    ) -> Result<(f64, Position), Obstacle> {
        // Secant steps that keep away from the ends.
        let mut near = arc * (ends.0 / (ends.0 - ends.1)).clamp(0.1, 0.9);
        let mut nodes: Vec<(f64, Position)> = Vec::new();
        for _ in 0..MOST_SECANTS {
            nodes.clear();
            for k in NODES {
                let s = near + k * NODE_STEP * arc;
                nodes.push((s, self.look(self.at(last, s)?)?));
            }
            let values: Vec<f64> = nodes.iter().map(|(_, at)| test(at)).collect();
            let times: Vec<f64> = nodes.iter().map(|(s, _)| *s).collect();
            // The zero as a function of the test: inverse interpolation.
            let next = interpolated(&values, &times, 0.0);
            let moved = (next - near).abs();
            near = next.clamp(0.0, arc);
            if moved < 0.5 * NODE_STEP * arc {
                break;
            }
        }
        let times: Vec<f64> = nodes.iter().map(|(s, _)| *s).collect();
        let of = |value: &dyn Fn(&Position) -> f64| {
            let values: Vec<f64> = nodes.iter().map(|(_, at)| value(at)).collect();
            interpolated(&times, &values, near)
        };
        let size = last.u.len();
        let u = DVector::from_fn(size, |i, _| of(&|at| at.u[i]));
        let tangent = DVector::from_fn(size, |i, _| of(&|at| at.tangent[i])).normalize();
        Ok((near, self.look(CurvePoint { u, tangent, steps: 3 })?))
    }

    /// Whether a step passes the first point of the path again.
    fn closes(&self, start: &(DVector<f64>, DVector<f64>), last: &Position, next: &Position) -> bool {
        let way = &next.u - &last.u;
        let length = way.norm();
        let from = &start.0 - &last.u;
        let part = from.dot(&way) / (length * length);
        let aside = (from - &way * part).norm();
        (0.0..=1.0).contains(&part) && aside < 0.05 * length && start.1.dot(&next.tangent) > COSINE
    }
}

/// ∏ (1 + μ), each factor of size one at most.
fn doubling(multipliers: &[Complex<f64>]) -> f64 {
    multipliers.iter().map(|m| (1.0 + m) / (1.0 + m.norm())).product::<Complex<f64>>().re
}

/// The polynomial through some points, at `x`.
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

impl Branch {
    /// The branch of a path in both directions from an orbit: the first path turned round, then the
    /// second.
    pub(super) fn joined(problem: Problem, back: Path, on: Path) -> (Self, [PathEnd; 2]) {
        let mut points: Vec<OrbitPoint> = back.points;
        points.reverse();
        // Each point has the stability of the piece that follows it, which was that before it.
        for k in 0..points.len().saturating_sub(1) {
            let next = points[k + 1].stability;
            if points[k].special.is_some() {
                points[k].stability = next;
            }
        }
        points.pop();
        let began_at = Some(points.len());
        points.extend(on.points);
        // The side branch of a crossing turns there: its fold is the crossing.
        let crossings: Vec<DVector<f64>> =
            points.iter().filter(|p| p.is(Label::BranchPoint)).map(|p| p.u.clone()).collect();
        for point in points.iter_mut().filter(|p| p.is(Label::Fold)) {
            if crossings.iter().any(|u| (u - &point.u).norm() < TURN) {
                point.special = None;
            }
        }
        let closed = matches!(on.end, PathEnd::Closed);
        let branch = Self { id: 0, parent: None, depth: 0, points, closed, began_at, problem };
        (branch, [back.end, on.end])
    }
}
