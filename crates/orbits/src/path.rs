//! One branch followed along the parameter, with its special points.

use super::bifurcation::Ends;
use super::branch::{Kind, OrbitPoint, Special};
use super::conditions::Condition;
use super::orbit::Orbit;
use super::position::Position;
use super::problem::{Problem, Residual};
use crate::curve::{CurvePoint, Equations, correct};
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::path_options::PathOptions;
use crate::test_functions::{SignedLog, determinant, pair_test};
use nalgebra::DVector;
use vibro_machine::mode::Watch;

/// Least step; a branch that needs a smaller one ends with MX.
const LEAST_STEP: f64 = 1e-7;
/// Part of the period before a fixed time at which a run of impacts that cannot be followed on ends
/// there.
const NEAR_END: f64 = 1e-5;
/// Steps that are tried where shorter ones fail.
const JUMPS: [f64; 4] = [1e-3, 3e-3, 1e-2, 3e-2];
/// Least cosine of the angle by which the tangent turns in a step.
const COSINE: f64 = 0.95;
/// Growth of the step after few Newton steps, and its reduction after many.
const GROWTH: f64 = 1.4;
const REDUCTION: f64 = 1.5;
/// Part of the longest step below which steps that cost no less than longer ones grow.
const SHORT: f64 = 1e-2;
/// Points after which a branch can have closed.
const SHORTEST_LOOP: usize = 10;
/// Share of the parameter in the tangent below which the equations are bordered as they are.
const STEEP: f64 = 1e-2;
/// Distance from a touch within which a bifurcation is one with it.
const AT_TOUCH: f64 = 1e-5;
/// Parts of the arc to a touch at which the touch's multipliers are taken: at the first of them
/// where the largest multiplier is below [`LIMITED`].
const BEFORE: [f64; 5] = [1.0 - 1e-7, 1.0 - 1e-5, 1.0 - 1e-3, 0.9, 0.5];
/// Modulus of a multiplier above which it is one of a touch, where it has no bound: half of the
/// digits of the others remain.
const LIMITED: f64 = 1e8;

/// Part of the arc to the birth of a branch at which tests are taken in place of those at the
/// birth, where they vanish; beside the begin of a path at the same distance.
const BESIDE: f64 = 0.9;

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

pub(super) struct Follower<'a> {
    pub problem: &'a Problem,
}

/// Follows a branch from a departure until it ends.
pub(super) fn follow(departure: &Departure, options: &PathOptions) -> Result<Path, Obstacle> {
    let follower = Follower { problem: &departure.problem };
    let first = follower.first(departure)?;
    let mut points = vec![follower.point(&first, departure.special.clone())];
    let start = (first.u.clone(), first.tangent.clone());
    let (mut last, mut step) = (first, departure.step.min(options.longest_step));
    let mut earlier: Option<(Position, f64)> = None;
    let mut is_first = true;
    loop {
        if points.len() >= options.most_points {
            return Ok(ended(points, Label::NoConvergence));
        }
        let next =
            match follower.step((earlier.as_ref(), &last), step, is_first && departure.special.is_some()) {
                Ok(next) => next,
                Err(_) if step > LEAST_STEP => {
                    step *= 0.5;
                    continue;
                }
                // Next to a crossing the equations are nearly singular: a longer step passes it.
                Err(_) => {
                    let mut jumps = JUMPS.iter().filter(|_| !is_first);
                    match jumps.find_map(|jump| follower.step((earlier.as_ref(), &last), *jump, false).ok()) {
                        Some(next) => next,
                        None => return Ok(follower.stopped(points, &last)),
                    }
                }
            };
        let Step { between, next, special, end, begins } = next;
        if let Some(begins) = &begins {
            (points[0].stability, points[0].multipliers) = (begins.stability, begins.multipliers.clone());
        }
        is_first = false;
        points.extend(between);
        let is_loop = closes((&start.0, &start.1), [&last.u, &next.u], &next.tangent);
        if end.is_none() && points.len() > SHORTEST_LOOP && is_loop {
            let first = points[0].clone();
            points.push(first);
            return Ok(Path { points, end: PathEnd::Closed });
        }
        if matches!(end, Some(PathEnd::Broken(_))) {
            // Next to a touch multipliers grow without bound: a bifurcation there is the touch.
            let is_touch = |p: &OrbitPoint| p.special.is_some() && (&p.u - &next.u).norm() < AT_TOUCH;
            while points.len() > 1 && points.last().is_some_and(is_touch) {
                points.pop();
            }
        }
        points.push(follower.point(&next, special));
        if let Some(end) = end {
            return Ok(Path { points, end });
        }
        // Where Newton's method takes as many steps however short the way is, its length costs
        // nothing: next to a touch rounding takes them, and the curve would crawl.
        let crawls = step < SHORT * options.longest_step && next.steps <= last.steps;
        if next.steps <= 3 || crawls {
            step *= GROWTH;
        } else if next.steps >= 5 {
            step /= REDUCTION;
        }
        step = step.clamp(LEAST_STEP, options.longest_step);
        // A special point from which the branch begins has no tests.
        let begun = std::mem::replace(&mut last, next);
        let before = begins.unwrap_or(begun);
        let arc = before.tangent.dot(&(&last.u - &before.u));
        earlier = Some((before, arc));
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
    /// The position beside the special point that the step leaves.
    begins: Option<Position>,
}

impl Follower<'_> {
    /// The path that cannot be followed further from its last position. A run of impacts that has
    /// not accumulated when a fixed time comes is another motion, so that no equation holds beyond.
    fn stopped(&self, mut points: Vec<OrbitPoint>, last: &Position) -> Path {
        let is_run =
            |letter: usize| self.problem.word.letters.get(letter).is_some_and(|own| own.chatter.is_some());
        let own = last.conditions.iter().find(|(condition, value)| match condition {
            Condition::Lasts { letter } => is_run(*letter) && *value < NEAR_END,
            _ => false,
        });
        let place = self.problem.place(&last.u);
        // A visit of a buffer without duration leaves singular equations.
        let visit = last.conditions.iter().find_map(|(condition, value)| match condition {
            Condition::Lasts { letter } if *value < NEAR_END => {
                let watch = self.problem.word.letters.get(*letter)?.watch()?;
                matches!(watch, Watch::Presses(_)).then_some((*condition, watch.contact()))
            }
            _ => None,
        });
        if let (Some((condition, stop)), Ok(place), Some(point)) = (visit, &place, points.last_mut()) {
            let element = place.assembly.name_of_contact(stop);
            point.special = Some(Special { kind: Kind::As(Label::Grazing), element });
            return Path { points, end: PathEnd::Broken(condition) };
        }
        if let (Some((condition, _)), Ok(place), Some(point)) = (own, place, points.last_mut()) {
            point.special = Some(Special::of_condition(*condition, &self.problem.word, &place));
            return Path { points, end: PathEnd::Broken(*condition) };
        }
        ended(points, Label::NoConvergence)
    }

    pub fn point(&self, at: &Position, special: Option<Special>) -> OrbitPoint {
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
    pub fn look(&self, at: CurvePoint) -> Result<Position, Obstacle> {
        let CurvePoint { u, tangent, steps } = at;
        let place = self.problem.place(&u)?;
        let Residual { matrix, cycle, .. } = self.problem.residual(&place, &u, true)?;
        let matrix = matrix.ok_or(Obstacle::NoConvergence)?;
        let along = tangent[tangent.len() - 1];
        let doubling = determinant(self.problem.antiperiodic(&place, &cycle, &matrix));
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
            doubling,
            pair: pair.relative_to(SignedLog { sign: 1.0, log: 0.0 }),
            conditions: orbit.conditions().to_vec(),
            multipliers,
            u,
        })
    }

    /// The point at an arc from a position.
    pub fn at(&self, from: &Position, arc: f64) -> Result<CurvePoint, Obstacle> {
        correct(self.problem, &(&from.u + &from.tangent * arc), &from.tangent)
    }

    /// The point at an arc within a step of the length `step`, as [`at`](Self::at), but predicted
    /// by the cubic between the step's ends. From there Newton's method takes fewer steps.
    pub fn within(
        &self,
        last: &Position,
        next: &Position,
        step: f64,
        arc: f64,
    ) -> Result<CurvePoint, Obstacle> {
        let along = next.tangent.dot(&last.tangent);
        if along < COSINE || step == 0.0 {
            return self.at(last, arc);
        }
        // What lies across the first tangent: the plane of the point is that of `at`.
        let way = &next.u - &last.u;
        let aside = &way - &last.tangent * way.dot(&last.tangent);
        let turn = &next.tangent / along - &last.tangent;
        let part = arc / step;
        let square = part * part;
        let predicted = &last.u
            + &last.tangent * arc
            + aside * (square * (3.0 - 2.0 * part))
            + turn * (step * square * (part - 1.0));
        correct(self.problem, &predicted, &last.tangent)
    }

    /// One step, with the special points on it. `leaves` says that it leaves a special point.
    fn step(
        &self,
        (earlier, last): (Option<&(Position, f64)>, &Position),
        step: f64,
        leaves: bool,
    ) -> Result<Step, Obstacle> {
        let ahead = self.boundary_ahead(last, step);
        let is_last = ahead.is_some();
        let (mut next, mut arc) = match ahead {
            Some(ahead) => ahead,
            None => (self.look(self.at(last, step)?)?, step),
        };
        if next.tangent.dot(&last.tangent) < COSINE && !leaves {
            return Err(Obstacle::NoConvergence);
        }
        let (mut end, mut special, mut before) = (None, None, None);
        if is_last {
            (special, end) = (Some(Special::of(Label::EndPoint)), Some(PathEnd::Plain));
        }
        if let Some((condition, at, found)) = self.broken(last, &next, arc, leaves)? {
            let place = self.problem.place(&next.u)?;
            special = Some(Special::of_condition(condition, &self.problem.word, &place));
            let beside = self.before_touch((last, &next), arc, at);
            let own = match found {
                Some(own) => own,
                None => self.look(self.within(last, &next, arc, at)?)?,
            };
            // A touch has multipliers on this side of it.
            let (multipliers, stability) = (beside.0.multipliers.clone(), beside.0.stability);
            next = Position { multipliers, stability, ..own };
            (arc, end, before) = (at, Some(PathEnd::Broken(condition)), Some(beside));
        }
        if !is_last && let Some((boundary, at)) = self.boundary(last, &next, arc)? {
            (next, arc, special, end) =
                (boundary, at, Some(Special::of(Label::EndPoint)), Some(PathEnd::Plain));
        }
        if !leaves && let Some((birth, at)) = self.birth(last, &next)? {
            let beside = BESIDE * at * arc;
            before = Some((self.look(self.within(last, &next, arc, beside)?)?, beside));
            (next, arc, special, end) =
                (birth, at * arc, Some(Special::of(Label::PeriodDoubling)), Some(PathEnd::Plain));
        }
        let is_touch = matches!(end, Some(PathEnd::Broken(_)));
        let ends = Ends { next: &next, arc, before, is_touch };
        if !leaves {
            let between = self.bifurcations(earlier, last, &ends)?;
            return Ok(Step { between, next, special, end, begins: None });
        }
        // At the special point itself tests vanish, or have no value: those beside it are taken.
        let begins = self.look(self.within(last, &next, arc, (1.0 - BESIDE) * arc)?);
        let between = match &begins {
            Ok(begins) => self.bifurcations(None, begins, &ends.seen_from(last, begins)).unwrap_or_default(),
            Err(_) => Vec::new(),
        };
        let begins = Some(begins.unwrap_or_else(|_| next.clone()));
        Ok(Step { between, next, special, end, begins })
    }

    /// The position before a touch at which the touch's multipliers are taken, with its arc.
    fn before_touch(&self, (last, next): (&Position, &Position), arc: f64, touch: f64) -> (Position, f64) {
        let limited = |at: &Position| at.multipliers.first().is_none_or(|m| m.norm() < LIMITED);
        let at = |part: &f64| {
            Some((self.look(self.within(last, next, arc, touch * part).ok()?).ok()?, touch * part))
        };
        let found = BEFORE.iter().filter_map(at).find(|(at, _)| limited(at));
        found.unwrap_or_else(|| (last.clone(), 0.0))
    }
}

/// Whether a step from a point to another one, with the tangent there, passes the first point of
/// its path again, with the path's first tangent.
pub(super) fn closes(
    (first, begins): (&DVector<f64>, &DVector<f64>),
    [last, next]: [&DVector<f64>; 2],
    tangent: &DVector<f64>,
) -> bool {
    let (way, from) = (next - last, first - last);
    let length = way.norm();
    let part = from.dot(&way) / (length * length);
    let aside = (from - &way * part).norm();
    (0.0..=1.0).contains(&part) && aside < 0.05 * length && begins.dot(tangent) > COSINE
}
