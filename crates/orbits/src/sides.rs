//! The two words of an orbit that touches a contact: with and without the contact's events.
//!
//! A visit is a run of events: a contact leaves its state and returns to it. At the touch a visit
//! has no duration, and the impact of a rigid stop has no speed, so both words describe the orbit.
//! A visit of several events makes the equations of its word singular there, because its event
//! functions are equal to first order.

use super::conditions::{Condition, off_gap};
use super::cycle::{Cycle, Leg};
use super::orbit::within;
use super::place::Place;
use super::problem::{Numbers, Problem};
use super::word::{Cause, Letter, Word};
use crate::obstacle::Obstacle;
use nalgebra::DVector;
use vibro_machine::mode::{Contact, ElementState, FrictionState, SliderState, StopState, Watch};
use vibro_machine::motion::{Event, EventKind};
use vibro_studies::flight::{Series, coefficients, turning_points};

/// Fraction of a flight that is unlikely to coincide with a regularly recurring touch.
const GOLDEN: f64 = 0.381_966_011_250_105_1;
/// Largest number of events of a visit: a stop with damping is met, no longer pulls, and opens,
/// and a friction element reverses meanwhile.
const MOST_EVENTS: usize = 5;
/// Tolerance for a stop at its gap, relative to its terms.
const RESTS: f64 = 1e-9;
/// Tolerance for a visit of zero duration, in periods.
const BRIEF: f64 = 1e-4;

/// An orbit in another word, with the condition that ceases to hold in that word.
pub(super) struct Side {
    pub problem: Problem,
    pub u: DVector<f64>,
    pub condition: Condition,
}

/// The orbit that touches a contact in the shortest word on the other side. If the word does not
/// list a rigid stop's touch, an impact at zero speed is inserted. If it lists the touch, visits
/// of zero duration are removed.
///
/// # Errors
/// An obstacle if the other side has no such word.
pub(super) fn other_side(
    problem: &Problem,
    u: &DVector<f64>,
    condition: Condition,
) -> Result<Side, Obstacle> {
    let place = problem.place(u)?;
    let cycle = problem.cycle(&place, u)?;
    let at = At { problem, place: &place, u, cycle: &cycle };
    let (other, numbers, condition) = match condition {
        Condition::Stays { letter, watch: Watch::Meets(stop), place: functional } => {
            at.with_impact((letter, stop, functional))?
        }
        Condition::Rises { letter } | Condition::Lasts { letter } => at.without_visits(letter)?,
        Condition::Corner { letter, ahead } => {
            let word = problem.word.beyond_corner(&place, letter, ahead).ok_or(Obstacle::NoConvergence)?;
            let condition = Condition::Corner { letter, ahead: !ahead };
            return Ok(Side { problem: Problem { word, ..problem.clone() }, u: u.clone(), condition });
        }
        _ => return Err(Obstacle::NoConvergence),
    };
    let whole = other.point(&place, &numbers, problem.value(u));
    let (problem, u) = other.reduced(&whole)?;
    // The shorter word has the condition in its first repetition.
    let first = |letter: usize| letter % problem.word.len().max(1);
    let condition = match condition {
        Condition::Rises { letter } => Condition::Rises { letter: first(letter) },
        Condition::Stays { letter, watch, place } => Condition::Stays { letter: first(letter), watch, place },
        other => other,
    };
    Ok(Side { problem, u, condition })
}

type Other = (Problem, Numbers, Condition);

/// An orbit that touches a contact.
struct At<'a> {
    problem: &'a Problem,
    place: &'a Place,
    u: &'a DVector<f64>,
    cycle: &'a Cycle,
}

impl At<'_> {
    /// The word with an impact of `stop` in the flight after `letter`.
    fn with_impact(&self, (letter, stop, functional): (usize, usize, usize)) -> Result<Other, Obstacle> {
        let Self { problem, place, u, cycle } = *self;
        let leg = &cycle.legs[letter];
        let after = highest(leg, functional);
        let time = leg.time + after;
        let mode = problem.word.mode_after(letter).clone();
        let kind = EventKind::Impact { stop, speed: 0.0, impulse: 0.0, stops: 1 };
        let own = Letter {
            modes: [mode.clone(), mode],
            cause: Cause::Passes { watch: Watch::Meets(stop), place: 0 },
            events: vec![Event { time, kind }],
            chatter: None,
        };
        let mut numbers = problem.numbers(place, u);
        let mut letters = problem.word.letters.to_vec();
        let index = if letters.is_empty() { 0 } else { letter + 1 };
        letters.insert(index, own);
        if problem.word.is_empty() {
            let (_, mut state) = within(place, leg, after / leg.span);
            state.truncate(numbers.states[0].len());
            numbers.states = vec![state];
            numbers.times = vec![time];
        } else {
            // An impact is not a node of the word.
            numbers.times.insert(index, time);
        }
        let word = Word::new(letters.into(), problem.word.mode.clone(), problem.word.periods);
        let word = word.between_corners(place, &numbers.times);
        let other = problem.with_word(place, word, &mut numbers);
        Ok((other, numbers, Condition::Rises { letter: index }))
    }

    /// The events of the visit that contains an event, if the visit has no duration: events of one
    /// contact, from leaving its state until returning to it.
    fn visit(&self, letter: usize) -> Option<Vec<usize>> {
        let (word, m) = (&self.problem.word, self.problem.word.len());
        let period = self.problem.numbers(self.place, self.u).period;
        let contact = |k: usize| word.letters[k].watch().map(|watch| watch.contact());
        let element = element_of(contact(letter)?);
        let is_brief = |k: usize| self.cycle.legs[k].span.abs() < BRIEF * period;
        let is_simple = |k: usize| {
            let own = &word.letters[k];
            own.chatter.is_none() && own.events.iter().all(|event| event.contact() == contact(k))
        };
        let begins = (0..MOST_EVENTS.min(m)).map(|back| (letter + m - back) % m);
        let mut visits = begins.filter(|begin| contact(*begin) == contact(letter)).filter_map(|begin| {
            let before = word.letters[begin].modes[0].state_of(element);
            let mut own = Vec::new();
            for k in (0..MOST_EVENTS.min(m)).map(|further| (begin + further) % m) {
                let letter = &word.letters[k];
                if !is_simple(k) {
                    return None;
                }
                if contact(k) == contact(begin) {
                    own.push(k);
                    if letter.modes[1].state_of(element) == before {
                        return Some(own);
                    }
                }
                if !is_brief(k) && !self.rests(k, contact(begin)) {
                    return None;
                }
            }
            None
        });
        let is_visit = |own: &Vec<usize>| {
            let impacts: usize = own.iter().map(|k| word.letters[*k].hits().count()).sum();
            own.contains(&letter) && impacts == usize::from(own.len() == 1)
        };
        visits.find(is_visit)
    }

    /// Whether a stop stays at its gap during a flight, for example while a body sticks there.
    fn rests(&self, flight: usize, contact: Option<Contact>) -> bool {
        let Some(Contact::Stop(stop)) = contact else { return false };
        let leg = &self.cycle.legs[flight];
        let states = [&leg.states[0], &leg.states[1], &within(self.place, leg, GOLDEN).1];
        states.into_iter().all(|z| off_gap(self.place.assembly.system(), stop, z) <= RESTS)
    }

    /// An event in the word without visits: if it lies in a contact's visit, the contact has its
    /// state before the visit.
    fn beside(&self, kept: usize, visits: &[Vec<usize>]) -> Letter {
        let (word, m) = (&self.problem.word, self.problem.word.len());
        let mut own = word.letters[kept].clone();
        for visit in visits {
            let (first, last) = (visit[0], visit[visit.len() - 1]);
            let is_inside = (kept + m - first) % m < (last + m - first) % m;
            let contact = word.letters[first].watch().map(|watch| watch.contact()).filter(|_| is_inside);
            let Some(contact) = contact else { continue };
            let state = word.letters[first].modes[0].state_of(element_of(contact));
            let system = self.place.assembly.system();
            own.modes = own.modes.map(|mode| system.with_element(&mode, state));
        }
        own
    }

    /// The word without the visit of event `letter` and without all other visits of zero duration.
    /// The condition belongs to the flight that contained the visit.
    fn without_visits(&self, letter: usize) -> Result<Other, Obstacle> {
        let Self { problem, place, u, cycle } = *self;
        let (word, m) = (&problem.word, problem.word.len());
        let own = self.visit(letter).ok_or(Obstacle::NoConvergence)?;
        // A single event is an impact; other single impacts are kept.
        let several = (0..m).filter_map(|k| self.visit(k)).filter(|visit| visit.len() > 1);
        let visits: Vec<Vec<usize>> = several.chain([own.clone()]).collect();
        let is_kept = |k: &usize| !visits.iter().any(|visit| visit.contains(k));
        let kept: Vec<usize> = (0..m).filter(is_kept).collect();
        let letters: Vec<Letter> = kept.iter().map(|k| self.beside(*k, &visits)).collect();
        let watch = word.letters[own[0]].watch().ok_or(Obstacle::NoConvergence)?;
        let functional = cycle.before(own[0]).ending.ok_or(Obstacle::NoConvergence)?;
        let begin = &word.letters[own[0]];
        let mode = letters.last().map_or(&begin.modes[0], Letter::last_mode).clone();
        let other = Word::new(letters.into(), mode, word.periods);
        let Numbers { times, period, drifts, .. } = problem.numbers(place, u);
        let count = problem.units.state.len();
        let mut origin = problem.origin;
        let (states, times) = if kept.is_empty() {
            // A touch at the start of the orbit would not be found.
            let longest = cycle.legs.iter().max_by(|a, b| a.span.total_cmp(&b.span));
            let (time, state) = within(place, longest.ok_or(Obstacle::NoConvergence)?, GOLDEN);
            origin = time;
            (vec![state[..count].to_vec()], vec![time])
        } else {
            let entered = |&k: &usize| cycle.legs[kept[k]].entered()[..count].to_vec();
            // Times of an autonomous machine count from its first event.
            let begin = if problem.driven_period(place).is_none() { times[kept[0]] } else { 0.0 };
            (other.nodes().iter().map(entered).collect(), kept.iter().map(|k| times[*k] - begin).collect())
        };
        let other = other.between_corners(place, &times);
        let before = kept.iter().filter(|k| **k < own[0]).count();
        let flight = (before + kept.len().max(1) - 1) % kept.len().max(1);
        let mut numbers = Numbers { states, times, period, drifts };
        let other = problem.with_word(place, other, &mut numbers);
        let other = Problem { origin, ..other };
        Ok((other, numbers, Condition::Stays { letter: flight, watch, place: functional }))
    }
}

/// The element of a contact, in an arbitrary state.
fn element_of(contact: Contact) -> ElementState {
    match contact {
        Contact::Stop(i) => ElementState::Stop(i, StopState::Below),
        Contact::Friction(i) => ElementState::Friction(i, FrictionState::Stuck),
        Contact::Slider(i) => ElementState::Slider(i, SliderState::Held),
    }
}

/// Time in a flight, s, of the largest interior value of an event function.
fn highest(leg: &Leg, functional: usize) -> f64 {
    let row = leg.flow.watched[functional].1.as_slice();
    let (mut best, mut past) = ((f64::NEG_INFINITY, 0.0), 0.0);
    let mut look = |series: &Series, length: f64| {
        let q = coefficients(row, series);
        turning_points(&q, &mut |part, value| {
            let is_inside = past + part > 0.0 && past + part * length < leg.span;
            if is_inside && value > best.0 {
                best = (value, past + part * length);
            }
        });
        past += length;
    };
    for part in leg.parts() {
        leg.flow.stretches(part.start, part.span, &mut look);
    }
    best.1
}
