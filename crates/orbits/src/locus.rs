//! Curves of special points of a described machine over two parameters (docs/theory.md, section
//! 14).

mod equations;

use self::equations::{Condition, Locus};
use super::branch::{Branch, Special};
use super::conditions;
use super::orbit::Orbit;
use super::place::Family;
use super::problem::Problem;
use super::sides::{Side, other_side};
use super::tree;
use crate::curve::zero;
use crate::curve::{axis, correct, tangent};
use crate::label::Label;
use crate::obstacle::Obstacle;
use crate::path_options::PathOptions;
use crate::two_parameters::{LocusEnd, LocusPoint, both_ways};
use nalgebra::DVector;
use vibro_machine::Start;
use vibro_studies::{Error, Result};

/// Points along a branch to either side among which an orbit beside a special point is sought.
const BESIDE: usize = 6;
/// Distance from a special point beyond which an orbit is beside it, in units of the unknowns.
const APART: f64 = 1e-4;
/// Largest multiplier of an orbit that a table's start leads to again.
const LEADS_BACK: f64 = 1e6;
/// Points of a branch among which a special point is found again from an orbit beside it.
const SHORT: usize = 60;
/// Largest distance of a special point from where a table has it, in parts of the range.
const FOUND: f64 = 1e-6;
/// Distance of two rows that are one point, in parts of the range and of the period: points are
/// found to 1e-9 where they are regular.
const ONE_POINT: f64 = 1e-8;
/// Half of the arc on which a special point is located again: long beside rounding of the point,
/// and short beside the curvature of a branch.
const NEXT_TO: f64 = 1e-5;
/// Accuracy of that location, as arc.
const ARC: f64 = 1e-14;
/// Value of a condition at a special point at which it ceases to hold.
const CEASES: f64 = 1e-4;

/// A point from which a curve over two parameters is followed.
#[derive(Clone, Debug)]
pub struct LocusStart {
    /// Kind of all points of the curve, with the element that is meant.
    pub special: Special,
    problem: Problem,
    u: DVector<f64>,
}

impl Branch {
    /// The start of a curve from one of its points; `None` for a point that is not special, an end
    /// of the range and an end of the following.
    pub fn locus_start(&self, point: usize) -> Option<LocusStart> {
        let at = self.points.get(point)?;
        let special = at.special.clone()?;
        let is_start = Label::STARTS.contains(&special.label);
        is_start.then(|| LocusStart { special, problem: self.of.clone(), u: at.u.clone() })
    }

    /// An orbit of the branch beside one of its points, to which a motion from its
    /// [start](Orbit::start) leads again; `None` where there is none nearby.
    pub fn beside(&self, point: usize) -> Option<Orbit> {
        let at = &self.points.get(point)?.u;
        let near = (1..=BESIDE).flat_map(|k| [point.checked_sub(k), Some(point + k)]).flatten();
        let plain = near.filter_map(|k| self.points.get(k)).filter(|p| p.special.is_none());
        plain
            .filter(|p| (&p.u - at).norm() > APART)
            .filter_map(|p| self.orbit(p))
            .find(|orbit| orbit.is_certified() && orbit.spectral_radius() < LEADS_BACK)
    }
}

impl LocusStart {
    /// The special point of a branch over a family's parameter, found from an orbit next to it that
    /// is given by the parameter's value, its period (s) and a start. The point has a kind and a
    /// value of the parameter.
    ///
    /// # Errors
    /// As [`Orbit::near`] and [`find`](Self::find).
    pub fn from_beside(
        over: &Family,
        (special, value): (&Special, f64),
        (at, period, start): (f64, f64, &Start),
    ) -> Result<Self> {
        let machine = over.at(at)?;
        let orbit = Orbit::near(&machine, start, period)?;
        let family = Family::new(&machine, &over.parameter, over.range)?;
        Self::find(&family, &orbit, special, value)
    }

    /// The special point of a branch over the first parameter that an orbit beside it leads to: of
    /// a kind, and nearest to a value of the parameter. Where several conditions cease to hold at
    /// the value, it may have the name of another one. The family's machine has the orbit's value.
    ///
    /// # Errors
    /// [`Error::Described`] where the branch of the orbit has no such point at the value; as
    /// [`branch`](tree::branch).
    pub fn find(family: &Family, orbit: &Orbit, special: &Special, value: f64) -> Result<Self> {
        let options = PathOptions { most_points: SHORT, ..PathOptions::default() };
        let branch = tree::branch(family, orbit, &options)?;
        let off = |k: &usize| (branch.points[*k].value - value).abs();
        let own = |k: &usize| branch.points[*k].special.as_ref() == Some(special);
        let found = (0..branch.points.len()).filter(own).min_by(|a, b| off(a).total_cmp(&off(b)));
        let is_there = |k: &usize| off(k) <= FOUND * (family.range.1 - family.range.0);
        let start = found.filter(is_there).and_then(|k| branch.locus_start(k));
        let other = || (0..branch.points.len()).filter(is_there).find_map(|k| branch.locus_start(k));
        start.or_else(other).ok_or_else(|| {
            let Special { label, element, .. } = special;
            let nearest = found.map_or(String::new(), |k| format!("; the nearest is at {}", branch.points[k].value));
            let what = format!("{} {element}", label.name());
            let problem = format!(
                "the branch has no point {} at {} = {value}{nearest}; allowed is a row of the table of this machine",
                what.trim(),
                family.parameter
            );
            Error::Described { problem }
        })
    }

    /// The special point in the shortest word of its orbit, in which its curve is followed; at a
    /// touch of a rigid stop in the shortest word that does not list it.
    #[must_use]
    pub fn shortest(&self) -> Self {
        self.normal().map_or_else(|_| self.clone(), |(own, _)| own)
    }

    /// Whether two starts over one parameter, each in its [shortest](Self::shortest) word, are one
    /// point of a curve: of one kind, element and value, with an orbit of one period and the same
    /// events. Orbits on both sides of a touch end there, each on its branch, and a pair of orbits
    /// that mirror each other.
    pub fn is_same(&self, other: &Self) -> bool {
        let told = |own: &Self| {
            let Ok(place) = own.problem.place(&own.u) else { return None };
            let letters = own.problem.word.letters.iter();
            let mut events: Vec<String> = letters.map(|letter| letter.in_words(&place.assembly)).collect();
            events.sort();
            let period = own.problem.numbers(&place, &own.u).period;
            Some((own.special.clone(), events, own.problem.word.periods, own.problem.value(&own.u), period))
        };
        let (Some(own), Some(their)) = (told(self), told(other)) else { return false };
        let (from, to) = self.problem.family.range;
        let is_near = |a: f64, b: f64, unit: f64| (a - b).abs() <= ONE_POINT * unit;
        (&own.0, &own.1, own.2) == (&their.0, &their.1, their.2)
            && is_near(own.3, their.3, to - from)
            && is_near(own.4, their.4, own.4)
    }

    /// The value of the parameter at which the point's own condition holds, located along the
    /// branch of its shortest word: a second way beside the one by which the branch was searched,
    /// with other equations. `None` where the condition has no zero next to the point.
    pub fn located_again(&self) -> Option<f64> {
        let (LocusStart { problem, u, .. }, condition) = self.normal().ok()?;
        let axis = axis(u.len(), u.len() - 1);
        if matches!(condition, Condition::Crossing(_)) {
            let beside = &u + &axis * NEXT_TO;
            return problem.crossing(&beside, 2.0 * NEXT_TO).map(|u| problem.value(&u));
        }
        let along = tangent(&problem, &u, &axis).ok()?;
        let at = |s: f64| correct(&problem, &(&u + &along * (s - NEXT_TO)), &along);
        let test = |s: f64| {
            let u = at(s)?.u;
            Ok(condition.tests(&problem, problem.place(&u)?, &u)?[0])
        };
        let ends = (test(0.0).ok()?, test(2.0 * NEXT_TO).ok()?);
        let found = (ends.0 * ends.1 < 0.0).then(|| zero(&test, 2.0 * NEXT_TO, ends, ARC)).flatten();
        found.and_then(|s| Some(problem.value(&at(s).ok()?.u)))
    }

    /// The events of the orbit in words.
    pub fn word(&self) -> String {
        let place = self.problem.place(&self.u);
        place.map_or_else(|_| String::new(), |place| self.problem.word.in_words(&place.assembly))
    }

    /// Number of the drive's common periods of the orbit; `None` for an autonomous machine.
    pub fn periods(&self) -> Option<u32> {
        self.problem.word.periods
    }

    /// The point in the shortest word of its orbit, with the condition of its curve. A touch stands
    /// in the word that does not list it, where several words meet.
    fn normal(&self) -> std::result::Result<(Self, Condition), Obstacle> {
        let special = self.special.clone();
        let (Label::Fold | Label::BranchPoint | Label::PeriodDoubling | Label::NeimarkSacker) = special.label
        else {
            let touch = self.touch()?;
            let is_listed =
                matches!(touch, conditions::Condition::Rises { .. } | conditions::Condition::Lasts { .. });
            return Ok(match other_side(&self.problem, &self.u, touch) {
                Ok(Side { problem, u, condition }) if is_listed => {
                    (Self { special, problem, u }, Condition::Touch(condition))
                }
                _ => (self.clone(), Condition::Touch(touch)),
            });
        };
        let (problem, u) = self.problem.reduced(&self.u)?;
        let condition = Condition::of(special.label, &problem, &u)?;
        Ok((Self { special, problem, u }, condition))
    }

    /// The condition that ceases to hold at the point.
    fn touch(&self) -> std::result::Result<conditions::Condition, Obstacle> {
        let place = self.problem.place(&self.u)?;
        let all = self.problem.cycle(&place, &self.u)?.conditions(&place, &self.problem.word);
        let own = all.into_iter().filter(|(condition, value)| {
            let is_own = Special::of_condition(*condition, &self.problem.word, &place) == self.special;
            is_own && value.abs() < CEASES && !matches!(condition, conditions::Condition::Together { .. })
        });
        let nearest = own.min_by(|a, b| a.0.rank().cmp(&b.0.rank()).then(a.1.abs().total_cmp(&b.1.abs())));
        nearest.map(|(condition, _)| condition).ok_or(Obstacle::NoConvergence)
    }
}

/// The curve over two parameters on which an orbit has the special point of a start, in both
/// directions from it. The first parameter is that of the start's branch.
///
/// # Errors
/// As [`check_second`]; [`Error::Described`] where no such curve passes the start.
pub fn locus(start: &LocusStart, second: &Family) -> Result<Vec<LocusPoint>> {
    let first = start.problem.family.as_ref();
    let held = check_second(first, second)?;
    let refused = |problem: String| Error::Described { problem };
    let failed = |obstacle: Obstacle| match obstacle {
        Obstacle::Refused(error) => error,
        _ if start.special.element.starts_with("spring.") => refused(format!(
            "{} slips on one side of this point, and on the other may stand at any place: its curve is not followed; allowed are \
             branches over {} for several values of {}",
            start.special.element, first.parameter, second.parameter
        )),
        _ => refused(format!(
            "no curve over {} and {} passes this point: the equations have no solution beside it, as where orbits cross for this value alone",
            first.parameter, second.parameter
        )),
    };
    let (LocusStart { problem, u, .. }, condition) = start.normal().map_err(failed)?;
    let locus = Locus::new([first.clone(), second.clone()], problem, condition);
    let guess = locus.point(&u, held);
    let last = guess.len() - 1;
    let at = correct(&locus, &guess, &axis(guess.len(), last)).map_err(failed)?;
    let locus = locus.with_twins(&at.u).map_err(failed)?;
    let found = both_ways(&locus, &at.u).map_err(failed)?;
    // Where a slider may stand at any place, the equations are singular: steps fail at once.
    let fails = |(_, end): &(_, Option<LocusEnd>)| *end == Some(LocusEnd::NoConvergence);
    let stands = start.special.element.starts_with("spring.") && found.len() == 2 && found.iter().all(fails);
    if found.len() == 1 || stands || locus.is_point(&found) {
        return Err(failed(Obstacle::NoConvergence));
    }
    found.into_iter().map(|(w, end)| locus.seen(&w, end).map_err(failed)).collect()
}

/// The present value of a second parameter, from which curves begin.
///
/// # Errors
/// [`Error::Described`] where both parameters are one, and where the present value of the second
/// lies outside its range.
pub fn check_second(first: &Family, second: &Family) -> Result<f64> {
    let name = &second.parameter;
    let refused = |problem: String| Err(Error::Described { problem });
    if first.parameter == *name {
        return refused(format!("{name} twice: allowed are two parameters"));
    }
    let (held, (from, to)) = (second.present()?, second.range);
    if !(from..=to).contains(&held) {
        return refused(format!(
            "{name} = {held}: curves begin here, so it must lie in the range {from} to {to}; --set gives it another value"
        ));
    }
    Ok(held)
}
