//! Steps along a branch of a described machine's orbits.

use super::bifurcation::Ends;
use super::branch::{OrbitPoint, Special};
use super::conditions::Condition;
use super::orbit::Orbit;
use super::path::{self, Advance, COSINE, Earlier, Follow, Path, PathEnd};
use super::position::{Examined, Position};
use super::problem::{Problem, Residual};
use crate::curve::{CurvePoint, Equations, correct};
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::path_options::PathOptions;
use crate::test_functions::{SignedLog, determinant, pair_test};
use vibro_machine::mode::Watch;

/// Time before a fixed time, as a fraction of the period. If a run of impacts cannot be followed
/// further within it, the run has met the fixed time.
const NEAR_END: f64 = 1e-5;
/// Step lengths that are tried if shorter ones fail.
const JUMPS: [f64; 4] = [1e-3, 3e-3, 1e-2, 3e-2];
/// Smallest parameter component of the tangent for using the unbordered equations.
const STEEP: f64 = 1e-2;
/// Largest distance of a touch's own bifurcation from the touch.
const AT_TOUCH: f64 = 1e-5;
/// Fractions of the arc to a touch at which its multipliers are tried. The first fraction with all
/// multipliers below [`LIMITED`] is used.
const BEFORE: [f64; 5] = [1.0 - 1e-7, 1.0 - 1e-5, 1.0 - 1e-3, 0.9, 0.5];
/// Modulus beyond which a multiplier is considered to grow without bound at a touch. At this
/// limit, half of the digits of the other multipliers remain.
const LIMITED: f64 = 1e8;

/// Fraction of the arc to the birth of a branch at which tests replace the vanishing tests at the
/// birth itself; also used at the start of a path.
const BESIDE: f64 = 0.9;

/// Start of a path, with the equations of its orbits.
pub(super) type Departure = path::Departure<Problem>;
type Step = Advance<Examined, Condition>;

impl Departure {
    /// The orbit after a first step of a given length; `None` if there is none.
    pub fn first_orbit(&self, step: f64) -> Option<Orbit> {
        let direction = self.direction.normalize();
        let at = correct(&self.of, &(&self.u + &direction * step), &direction).ok()?;
        let (problem, u) = self.of.reduced(&at.u).ok()?;
        let place = problem.place(&u).ok()?;
        Orbit::at(problem, place, u).ok()
    }
}

/// Follows a branch from a departure until it ends.
pub(super) fn follow(departure: &Departure, options: &PathOptions) -> Result<Path<Condition>, Obstacle> {
    path::follow(&Follower { problem: &departure.of }, departure, options)
}

pub(super) struct Follower<'a> {
    pub problem: &'a Problem,
}

impl Follow for Follower<'_> {
    type Tests = Examined;
    type Of = Problem;
    /// A condition that ceases to hold at the end of a path.
    type End = Condition;
    const SHORT: f64 = 1e-2;

    fn first(&self, departure: &Departure) -> Result<Position<Examined>, Obstacle> {
        let Departure { u, direction, .. } = departure;
        let at = CurvePoint { u: u.clone(), tangent: direction.normalize(), steps: 3 };
        self.look(at)
    }

    fn value(&self, u: &nalgebra::DVector<f64>) -> f64 {
        self.problem.value(u)
    }

    fn step(
        &self,
        (earlier, last): (&Earlier<Examined>, &Position<Examined>),
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
            // The touch takes the multipliers on this side of it.
            let (multipliers, stability) = (beside.0.multipliers.clone(), beside.0.stability);
            next = Position { multipliers, stability, ..own };
            (arc, end, before) = (at, Some(PathEnd::At(condition)), Some(beside));
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
        let is_touch = matches!(end, Some(PathEnd::At(_)));
        let ends = Ends { next: &next, arc, before, is_touch };
        if !leaves {
            let between = self.bifurcations(earlier.as_ref(), last, &ends)?;
            return Ok(Step { between, next, special, end, begins: None });
        }
        // At the special point itself, tests vanish or have no value: tests next to it are used.
        let begins = self.look(self.within(last, &next, arc, (1.0 - BESIDE) * arc)?);
        let between = match &begins {
            Ok(begins) => self.bifurcations(None, begins, &ends.seen_from(last, begins)).unwrap_or_default(),
            Err(_) => Vec::new(),
        };
        let begins = Some(begins.unwrap_or_else(|_| next.clone()));
        Ok(Step { between, next, special, end, begins })
    }

    /// Near a crossing the equations are nearly singular: a longer step passes it.
    fn leap(&self, before: (&Earlier<Examined>, &Position<Examined>), is_first: bool) -> Option<Step> {
        let mut jumps = JUMPS.iter().filter(|_| !is_first);
        jumps.find_map(|jump| self.step(before, *jump, false).ok())
    }

    fn leave(&self, first: &mut OrbitPoint, advance: &Step) {
        if let Some(begins) = &advance.begins {
            (first.stability, first.multipliers) = (begins.stability, begins.multipliers.clone());
        }
    }

    /// Near a touch, multipliers grow without bound: a bifurcation there belongs to the touch.
    fn arrive(&self, points: &mut Vec<OrbitPoint>, end: &PathEnd<Condition>) {
        while let [_, .., before, last] = &points[..]
            && matches!(end, PathEnd::At(_))
            && before.special.is_some()
            && (&before.u - &last.u).norm() < AT_TOUCH
        {
            points.remove(points.len() - 2);
        }
    }

    /// A run of impacts that has not accumulated by a fixed time is another motion: no equations
    /// continue the branch there.
    fn stopped(&self, points: &mut [OrbitPoint], last: &Position<Examined>) -> PathEnd<Condition> {
        let is_run =
            |letter: usize| self.problem.word.letters.get(letter).is_some_and(|own| own.chatter.is_some());
        let own = last.tests.conditions.iter().find(|(condition, value)| match condition {
            Condition::Lasts { letter } => is_run(*letter) && *value < NEAR_END,
            _ => false,
        });
        let place = self.problem.place(&last.u);
        // A visit to a buffer with zero duration makes the equations singular.
        let visit = last.tests.conditions.iter().find_map(|(condition, value)| match condition {
            Condition::Lasts { letter } if *value < NEAR_END => {
                let watch = self.problem.word.letters.get(*letter)?.watch()?;
                matches!(watch, Watch::Presses(_)).then_some((*condition, watch.contact()))
            }
            _ => None,
        });
        if let (Some((condition, stop)), Ok(place), Some(point)) = (visit, &place, points.last_mut()) {
            let element = place.assembly.name_of_contact(stop);
            point.special = Some(Special::new(Label::Grazing, element));
            return PathEnd::At(condition);
        }
        if let (Some((condition, _)), Ok(place), Some(point)) = (own, place, points.last_mut()) {
            point.special = Some(Special::of_condition(*condition, &self.problem.word, &place));
            return PathEnd::At(*condition);
        }
        path::failed(points)
    }
}

impl Follower<'_> {
    /// Properties of a point of the curve.
    pub fn look(&self, at: CurvePoint) -> Result<Position<Examined>, Obstacle> {
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
        let pair = pair.relative_to(SignedLog { sign: 1.0, log: 0.0 });
        let tests = Examined { crossing, doubling, pair, conditions: orbit.conditions().to_vec() };
        let (period, stability) = (orbit.period(), orbit.stability());
        Ok(Position { u, tangent, steps, period, multipliers, stability, tests })
    }

    /// The point at a given arc from a position.
    pub fn at(&self, from: &Position<Examined>, arc: f64) -> Result<CurvePoint, Obstacle> {
        correct(self.problem, &(&from.u + &from.tangent * arc), &from.tangent)
    }

    /// The point at `arc` within a step of length `step`, as [`at`](Self::at). It is predicted by
    /// the cubic between the step's ends, which saves Newton steps.
    pub fn within(
        &self,
        last: &Position<Examined>,
        next: &Position<Examined>,
        step: f64,
        arc: f64,
    ) -> Result<CurvePoint, Obstacle> {
        let along = next.tangent.dot(&last.tangent);
        if along < COSINE || step == 0.0 {
            return self.at(last, arc);
        }
        // The part perpendicular to the first tangent: the point stays in the plane of `at`.
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

    /// A position before a touch that supplies the touch's multipliers, with its arc.
    fn before_touch(
        &self,
        (last, next): (&Position<Examined>, &Position<Examined>),
        arc: f64,
        touch: f64,
    ) -> (Position<Examined>, f64) {
        let limited = |at: &Position<Examined>| at.multipliers.first().is_none_or(|m| m.norm() < LIMITED);
        let at = |part: &f64| {
            Some((self.look(self.within(last, next, arc, touch * part).ok()?).ok()?, touch * part))
        };
        let found = BEFORE.iter().filter_map(at).find(|(at, _)| limited(at));
        found.unwrap_or_else(|| (last.clone(), 0.0))
    }
}
