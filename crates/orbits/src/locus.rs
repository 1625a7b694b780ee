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

/// Number of branch points to try as nearby orbits, on either side of a special point.
const BESIDE: usize = 6;
/// Least distance of a nearby orbit from a special point, in units of the unknowns.
const APART: f64 = 1e-4;
/// Upper limit of a nearby orbit's multipliers: its start in a table then leads back to it.
const LEADS_BACK: f64 = 1e6;
/// Length of a traced branch, in points, for finding a special point from a nearby orbit.
const SHORT: usize = 60;
/// Largest distance of a special point from its value in a table, as a fraction of the range.
const FOUND: f64 = 1e-6;
/// Tolerance for equal points in two rows, as a fraction of the range and of the period. Regular
/// points are found to 1e-9.
const ONE_POINT: f64 = 1e-8;
/// Half of the arc on which a special point is located again: long compared with rounding of the
/// point, short compared with the curvature of a branch.
const NEXT_TO: f64 = 1e-5;
/// Accuracy of this location, as arc length.
const ARC: f64 = 1e-14;
/// Tolerance for the value of a condition at its special point.
const CEASES: f64 = 1e-4;

/// A starting point of a curve over two parameters.
#[derive(Clone, Debug)]
pub struct LocusStart {
    /// Kind of all points of the curve, with the element concerned.
    pub special: Special,
    problem: Problem,
    u: DVector<f64>,
}

impl Branch {
    /// The start of a curve from one of the branch's points; `None` for a point that is not
    /// special, an end of the range and an end where following failed.
    pub fn locus_start(&self, point: usize) -> Option<LocusStart> {
        let at = self.points.get(point)?;
        let special = at.special.clone()?;
        let is_start = Label::STARTS.contains(&special.label);
        is_start.then(|| LocusStart { special, problem: self.of.clone(), u: at.u.clone() })
    }

    /// An orbit of the branch near one of its points. It can be found again from its
    /// [start](Orbit::start). `None` if no such orbit is nearby.
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
    /// The special point of a branch over a family's parameter, found from a nearby orbit. The
    /// point is given by its kind and parameter value; the nearby orbit by its parameter value,
    /// period (s) and start.
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

    /// The special point of the branch over the first parameter that contains a nearby orbit: the
    /// point of the given kind that is nearest to a parameter value. If several conditions cease
    /// to hold there, its kind may differ. The family's machine has the orbit's value.
    ///
    /// # Errors
    /// [`Error::Described`] if the branch of the orbit has no such point at the value; otherwise
    /// as [`branch`](tree::branch).
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
            let nearest =
                found.map_or(String::new(), |k| format!("; the nearest is at {}", branch.points[k].value));
            let what = format!("{} {element}", label.name());
            let problem = format!(
                "the branch has no point {} at {} = {value}{nearest}; use a row of a table that \
                 was computed for this machine",
                what.trim(),
                family.parameter
            );
            Error::Described { problem }
        })
    }

    /// The special point in the shortest word of its orbit. Its curve is followed in this word,
    /// which does not list a touch of a rigid stop.
    #[must_use]
    pub fn shortest(&self) -> Self {
        self.normal().map_or_else(|_| self.clone(), |(own, _)| own)
    }

    /// Whether two starts over one parameter, each in its [shortest](Self::shortest) word, are the
    /// same point of a curve: same kind, element and value, and orbits with the same period and
    /// events. This holds for the orbits on both sides of a touch, and for orbits that mirror each
    /// other.
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

    /// The parameter value at which the point's own condition holds, located along the branch of
    /// its shortest word. It is an independent check of the search along the branch, with other
    /// equations. `None` if the condition has no zero near the point.
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

    /// Number of common drive periods in the orbit's period; `None` for an autonomous machine.
    pub fn periods(&self) -> Option<u32> {
        self.problem.word.periods
    }

    /// The point in the shortest word of its orbit, with the condition of its curve. Several words
    /// meet at a touch; the word that does not list the touch is used.
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

/// The curve over two parameters on which an orbit keeps the special point of a start, followed in
/// both directions. The first parameter is the parameter of the start's branch.
///
/// # Errors
/// As [`check_second`]; [`Error::Described`] if no such curve passes through the start.
pub fn locus(start: &LocusStart, second: &Family) -> Result<Vec<LocusPoint>> {
    let first = start.problem.family.as_ref();
    let held = check_second(first, second)?;
    let refused = |problem: String| Error::Described { problem };
    let failed = |obstacle: Obstacle| match obstacle {
        Obstacle::Refused(error) => error,
        _ if start.special.element.starts_with("spring.") => refused(format!(
            "{} slips on one side of this point and can stick at any position on the other side; \
             following its curve is not supported: use branches over {} for several values of {}",
            start.special.element, first.parameter, second.parameter
        )),
        _ => refused(format!(
            "no curve over {} and {} passes through this point: the equations have no solutions \
             near it, for example because orbits cross at this value only",
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
    // If a sticking slider may rest at any position, the equations are singular: steps fail.
    let fails = |(_, end): &(_, Option<LocusEnd>)| *end == Some(LocusEnd::NoConvergence);
    let stands = start.special.element.starts_with("spring.") && found.len() == 2 && found.iter().all(fails);
    if found.len() == 1 || stands || locus.is_point(&found) {
        return Err(failed(Obstacle::NoConvergence));
    }
    found.into_iter().map(|(w, end)| locus.seen(&w, end).map_err(failed)).collect()
}

/// The present value of a second parameter, where curves begin.
///
/// # Errors
/// [`Error::Described`] if both parameters are the same, or if the present value of the second
/// lies outside its range.
pub fn check_second(first: &Family, second: &Family) -> Result<f64> {
    let name = &second.parameter;
    let refused = |problem: String| Err(Error::Described { problem });
    if first.parameter == *name {
        return refused(format!("{name} is given twice: expected two different parameters"));
    }
    let (held, (from, to)) = (second.present()?, second.range);
    if !(from..=to).contains(&held) {
        return refused(format!(
            "{name} = {held}: must lie in the range {from} to {to}, because curves begin at this \
             value; change it by --set"
        ));
    }
    Ok(held)
}
