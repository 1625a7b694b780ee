//! Orbits from motions: the events of a motion over a period are a word, and their times with the
//! state after the first one are a guess.

use super::cycle::with_signals;
use super::orbit::{Obstructed, Orbit, newton};
use super::place::Family;
use super::problem::{Numbers, Problem, Units};
use super::timed::Timed;
use super::word::{Cause, Chatter, Letter, Word};
use crate::obstacle::Obstacle;
use std::f64::consts::TAU;
use std::sync::Arc;
use vibro_analysis::assembly::flight::{Flows, ObservedFlight, Observer, Passage, dot};
use vibro_analysis::assembly::{Machine, Section, SectionRule, carried, discard, settled};
use vibro_analysis::attractor::MotionClass;
use vibro_analysis::{Error, Result};
use vibro_assembly::mode::Mode;
use vibro_assembly::motion::EventKind;
use vibro_assembly::system::System;
use vibro_assembly::{Motion, Start};

/// Relative difference of a motion's period from a multiple of the drive's that is rounding.
const WHOLE: f64 = 1e-9;
/// Least unit of a state's number relative to the largest of its kind.
const LEAST: f64 = 1e-3;
/// Most events and samples of an orbit: each has a matrix of the state's size.
const MOST_LETTERS: usize = 20_000;
/// Difference of times of one instant, relative to the time: rounding.
const INSTANT: f64 = 4.0 * f64::EPSILON;
/// Samples of a flight for the sizes of states.
const SAMPLES: usize = 8;

/// A motion as a word with its times.
#[derive(Debug, Default)]
struct Record {
    letters: Vec<Letter>,
    times: Vec<f64>,
    /// The state after each event.
    states: Vec<Vec<f64>>,
    /// The drive's common period, s.
    period: f64,
    /// Time of a knot at which prescribed bodies move others at once, s.
    jump: Option<f64>,
    /// Least and largest value of each number of the state.
    extents: Vec<(f64, f64)>,
}

impl Record {
    fn include(&mut self, z: &[f64]) {
        self.extents.resize(z.len(), (f64::INFINITY, f64::NEG_INFINITY));
        for ((least, largest), x) in self.extents.iter_mut().zip(z) {
            (*least, *largest) = (least.min(*x), largest.max(*x));
        }
    }

    /// Units in which the state's numbers are of size one.
    fn units(&self, system: &System, radian: f64) -> Units {
        let coordinates = system.coordinates;
        let extent = |i: usize| self.extents.get(i).copied().unwrap_or((0.0, 0.0));
        let way = |k: usize| 0.5 * (extent(k).1 - extent(k).0);
        let speed = |k: usize| {
            let (least, largest) = extent(coordinates + k);
            largest.max(-least).max(way(k) / radian)
        };
        let most = (0..coordinates).map(speed).fold(0.0, f64::max);
        let unit_of = |most: f64| if most > 0.0 { most } else { 1.0 };
        let unit = |k: usize| if most > 0.0 { speed(k).max(LEAST * most) } else { 1.0 };
        let places = (0..coordinates).map(|k| unit(k) * radian);
        // An inner place is of the size of its way, or of the largest of a coordinate.
        let inner = system.places_of_first_order();
        let inner = inner
            .map(|k| if way(k) > 0.0 { way(k).max(LEAST * most * radian) } else { unit_of(most) * radian });
        let state = places.chain((0..coordinates).map(unit)).chain(inner).collect();
        Units { state, time: radian }
    }
}

impl Record {
    /// Places in the letters of the events at which a stop closes after impacts that accumulate.
    fn closings(&self) -> Vec<(usize, usize)> {
        let closes = |(k, letter): (usize, &Letter)| {
            let stop = letter.events.iter().find_map(|event| match event.kind {
                EventKind::Close { stop } if letter.hits().any(|hit| hit == stop) => Some(stop),
                _ => None,
            })?;
            Some((k, stop))
        };
        self.letters.iter().enumerate().filter_map(closes).collect()
    }

    /// Makes each run of impacts that accumulates one letter. The record begins after the last
    /// closing, so that no run goes on over its end.
    fn with_runs(&mut self, period: f64, periods: Option<u32>) {
        let closings = self.closings();
        let Some((last, _)) = closings.last() else { return };
        self.begin_with((last + 1) % self.letters.len(), period, periods);
        let mut from = self.letters.len();
        while let Some((end, stop)) = self.closings().into_iter().rev().find(|(k, _)| *k < from) {
            from = end;
            let hits: Vec<usize> =
                (0..=end).filter(|k| self.letters[*k].hits().any(|hit| hit == stop)).collect();
            // The run begins with the impact after which all intervals shrink. Fixed times lie in no
            // run.
            let mut begin = hits.len() - 1;
            while begin >= 1 {
                let interval = |k: usize| self.times[hits[k + 1]] - self.times[hits[k]];
                let is_timed = |letter: &Letter| letter.timed().is_some();
                if self.letters[hits[begin - 1]..=end].iter().any(is_timed) {
                    break;
                }
                let shrinks = begin + 1 >= hits.len() || interval(begin - 1) > interval(begin);
                if !shrinks {
                    break;
                }
                begin -= 1;
            }
            let begin = hits[begin];
            if begin == end {
                continue;
            }
            from = begin;
            let mode = self.letters[end].modes[1].clone();
            self.letters[begin].chatter = Some(Chatter { stop, mode });
            self.letters.drain(begin + 1..=end);
            self.states.drain(begin + 1..=end);
            self.times.drain(begin + 1..=end);
        }
    }
}

impl Record {
    /// Begins the record with another letter; those before it come a period later.
    fn begin_with(&mut self, first: usize, period: f64, periods: Option<u32>) {
        let later = self.times.len() - first;
        self.letters.rotate_left(first);
        self.states.rotate_left(first);
        self.times.rotate_left(first);
        self.times.iter_mut().skip(later).for_each(|time| *time += period);
        let turns = i64::from(periods.unwrap_or(0));
        self.letters.iter_mut().skip(later).for_each(|letter| *letter = letter.later(turns));
    }

    /// Begins the record with a fixed time, if it has one.
    fn begin_with_fixed_time(&mut self, period: f64, periods: Option<u32>) {
        if let Some(first) = self.letters.iter().position(|letter| letter.timed().is_some()) {
            self.begin_with(first, period, periods);
        }
    }

    /// Whether a knot moves bodies at once. Impacts alone change rates there, samples alone what
    /// blocks keep.
    fn is_moved(&self, system: &System, passage: &Passage<'_>) -> bool {
        let (n, [before, after]) = (system.coordinates, passage.states);
        let has_impact = passage.events.iter().any(|e| matches!(e.kind, EventKind::Impact { .. }));
        let inner = 2 * n..2 * n + system.branches.len();
        let kinds = [0..n, if has_impact { n..n } else { n..2 * n }, inner];
        kinds.into_iter().any(|places| {
            let extents = self.extents.get(places.clone()).unwrap_or(&[]);
            let size = extents.iter().fold(0.0, |most, (least, largest)| largest.max(-least).max(most));
            places.into_iter().any(|i| (before[i] - after[i]).abs() > WHOLE * size.max(before[i].abs()))
        })
    }

    /// Takes what happens at a fixed time: knots and samples of one instant are one letter.
    fn fix(&mut self, system: &System, passage: Passage<'_>) {
        let modes: [Mode; 2] = passage.flows.map(|flow| flow.mode.clone());
        let mut timed = Timed::at(system, self.period, passage.time, passage.events);
        timed.sides = timed.sides_in(system, passage.states[0]);
        let (time, events, after) = (passage.time, passage.events.to_vec(), passage.states[1].to_vec());
        let last = self.letters.last_mut().zip(self.times.last()).zip(self.states.last_mut());
        if let Some(((last, &at), state)) = last
            && let Cause::Timed(own) = &mut last.cause
            && time - at <= INSTANT * time
        {
            own.join(timed);
            last.modes[1] = modes[1].clone();
            last.events.extend(events);
            *state = after;
            return;
        }
        self.letters.push(Letter { modes, cause: Cause::Timed(timed), events, chatter: None });
        self.times.push(time);
        self.states.push(after);
    }

    /// Leaves out knots that change signals alone.
    fn leave_plain_knots_out(&mut self) {
        let is_plain = |letter: &Letter| {
            let is_knot = letter.events.iter().all(|event| event.kind == EventKind::Knot);
            letter.timed().is_some() && is_knot && letter.modes[0] == letter.modes[1]
        };
        let kept: Vec<bool> = self.letters.iter().map(|letter| !is_plain(letter)).collect();
        let mut of = kept.iter();
        self.letters.retain(|_| of.next().copied().unwrap_or(true));
        let mut of = kept.iter();
        self.times.retain(|_| of.next().copied().unwrap_or(true));
        let mut of = kept.iter();
        self.states.retain(|_| of.next().copied().unwrap_or(true));
    }
}

impl Observer for Record {
    fn flight(&mut self, _: &System, flight: ObservedFlight<'_>) {
        let part = flight.span / SAMPLES as f64;
        let propagator = flight.flow.propagator(part);
        let mut z = nalgebra::DVector::from_column_slice(flight.start);
        for _ in 0..SAMPLES {
            self.include(z.as_slice());
            z = &propagator * z;
        }
        self.include(z.as_slice());
    }

    fn passage(&mut self, system: &System, passage: Passage<'_>) {
        let Some(watch) = passage.watch else {
            if self.is_moved(system, &passage) {
                self.jump = Some(passage.time);
            }
            return self.fix(system, passage);
        };
        let own: Vec<f64> = passage.flows[0]
            .watched
            .iter()
            .filter(|(other, _)| *other == watch)
            .map(|(_, row)| dot(row.as_slice(), passage.states[0]).abs())
            .collect();
        let place = (0..own.len()).min_by(|a, b| own[*a].total_cmp(&own[*b])).unwrap_or(0);
        let modes: [Mode; 2] = passage.flows.map(|flow| flow.mode.clone());
        self.states.push(passage.states[1].to_vec());
        let events = passage.events.to_vec();
        self.letters.push(Letter { modes, cause: Cause::Passes { watch, place }, events, chatter: None });
        self.times.push(passage.time);
    }
}

/// A word, a guess of its orbit, and its equations.
#[derive(Debug)]
pub(super) struct Seed {
    pub problem: Problem,
    pub numbers: Numbers,
    pub value: f64,
}

/// Follows a motion over `returns` returns to its section, as the seed of an orbit.
pub(super) fn seed(
    family: &Arc<Family>,
    value: f64,
    motion: &mut Motion,
    section: &Section,
    returns: u32,
) -> Result<Seed> {
    let place = family.place(value)?;
    let (assembly, from) = (motion.assembly().clone(), motion.time());
    let (begin, mode) = (motion.state().as_slice().to_vec(), motion.mode().clone());
    let period = place.period.unwrap_or_default();
    let (mut record, mut flows) = (Record { period, ..Record::default() }, Flows::default());
    for _ in 0..returns {
        section.follow(motion, &mut flows, &mut [&mut record])?;
    }
    record.leave_plain_knots_out();
    let span = motion.time() - from;
    if let Some(time) = record.jump {
        let problem = format!(
            "at t = {time} s a knot of a signal moves bodies at once: its orbits are not sought; allowed are knots of forces, stiffness and motions that go on from their place"
        );
        return Err(Error::Described { problem });
    }
    let periods = match place.period {
        Some(period) => {
            let ratio = span / period;
            if (ratio - ratio.round()).abs() > WHOLE * ratio || ratio.round() < 1.0 {
                let problem = format!(
                    "the motion returns after {span} s, which is no multiple of the drive's period {period} s"
                );
                return Err(Error::Described { problem });
            }
            Some(ratio.round() as u32)
        }
        None => None,
    };
    let period = place.period.map_or(span, |period| period * f64::from(periods.unwrap_or(1)));
    let system = assembly.system();
    let own = system.states();
    let is_empty = record.letters.is_empty();
    if is_empty && periods.is_none() {
        let problem = "the motion has no events and nothing drives it: it rests, or swings freely; allowed are motions with events or a drive";
        return Err(Error::Described { problem: problem.into() });
    }
    record.with_runs(period, periods);
    record.begin_with_fixed_time(period, periods);
    if record.letters.len() > MOST_LETTERS {
        let problem = format!(
            "the motion has {} events and samples a period; allowed for an orbit are up to {MOST_LETTERS}",
            record.letters.len()
        );
        return Err(Error::Described { problem });
    }
    let radian = place.period.unwrap_or(span) / TAU;
    let units = record.units(system, radian);
    let mut times = if is_empty { vec![from] } else { std::mem::take(&mut record.times) };
    let own_states = if is_empty { vec![begin] } else { std::mem::take(&mut record.states) };
    let mode = record.letters.last().map_or(mode, |letter| letter.last_mode().clone());
    let word = Word::new(record.letters.into(), mode, periods);
    // Times count from within the first period of the drive; fixed ones are those of the word.
    let fixed =
        |k: usize| word.letters.get(k).and_then(Letter::timed).map(|own| own.time(place.assembly.system()));
    let whole = match (place.period, fixed(0)) {
        (Some(period), Some(first)) => ((times[0] - first) / period).round() * period,
        (Some(period), None) => (times[0] / period).floor() * period,
        (None, _) => times[0],
    };
    let own_times: Vec<f64> = (0..times.len()).map(|k| fixed(k).unwrap_or(times[k] - whole)).collect();
    let mut states = Vec::new();
    for &k in word.nodes() {
        let mut state = own_states[k].clone();
        move_back(system, &mut state, own_times[k])?;
        state.truncate(own);
        states.push(state);
    }
    times = own_times;
    let neutral = Problem::neutral_of(&place);
    let fixed = neutral.iter().map(|n| n.iter().zip(&states[0]).map(|(n, x)| n * x).sum()).collect();
    let drifts = vec![0.0; neutral.len()];
    let problem = Problem { family: family.clone(), word, units, neutral, fixed, origin: times[0] };
    Ok(Seed { problem, numbers: Numbers { states, times, period, drifts }, value })
}

/// Least and largest value of each number of the state of a motion over some returns, or as far as
/// it goes on.
pub(super) fn extents(motion: &mut Motion, section: &Section, returns: u32) -> Vec<(f64, f64)> {
    let (mut record, mut flows) = (Record::default(), Flows::default());
    for _ in 0..returns {
        if section.follow(motion, &mut flows, &mut [&mut record]).is_err() {
            break;
        }
    }
    record.extents
}

/// The state that uniformly moving bodies have at an earlier time, with what they carry along.
fn move_back(system: &System, state: &mut [f64], time: f64) -> Result<()> {
    let mut earlier = state.to_vec();
    with_signals(system, time, &mut earlier);
    let own = system.states();
    let change: Vec<f64> =
        (0..state.len()).map(|i| if i < own { 0.0 } else { earlier[i] - state[i] }).collect();
    let is_rounding = |(i, x): (usize, &f64)| x.abs() <= WHOLE * (state[i].abs() + earlier[i].abs()).max(1.0);
    if change.iter().enumerate().all(is_rounding) {
        return Ok(());
    }
    let change: Vec<f64> =
        change.iter().enumerate().map(|(i, x)| if is_rounding((i, x)) { 0.0 } else { *x }).collect();
    let Some(along) = carried(system, &change, false) else {
        let problem =
            "uniformly moving bodies change what the springs and stops feel: the motion does not repeat";
        return Err(Error::Described { problem: problem.into() });
    };
    along.iter().enumerate().for_each(|(i, x)| state[i] += x);
    Ok(())
}

impl Orbit {
    /// The orbit of a seed.
    pub(super) fn of_seed(seed: Seed) -> std::result::Result<Self, Obstructed> {
        let Seed { problem, numbers, value } = seed;
        let word = |problem: &Problem| {
            let place = problem.family.place(value);
            place.map_or_else(|_| String::new(), |place| problem.word.in_words(&place.assembly))
        };
        let found = || {
            let place = problem.family.place(value).map_err(|e| (Obstacle::Refused(e), f64::INFINITY))?;
            let guess = problem.point(&place, &numbers, value);
            newton(&problem, &place, &guess).map(|u| (u, place))
        };
        match found() {
            Ok((u, place)) => {
                let residual = 0.0;
                let obstructed = |obstacle| Obstructed { obstacle, residual, word: String::new() };
                let (problem, u) = problem.reduced(&u).map_err(obstructed)?;
                Self::at(problem, place, u).map_err(obstructed)
            }
            Err((obstacle, residual)) => Err(Obstructed { obstacle, residual, word: word(&problem) }),
        }
    }

    /// The orbit on which the motion of a machine from a start settles, after `discard` returns to
    /// its section, or fewer where it has settled before.
    ///
    /// # Errors
    /// [`Error::Described`] where the motion settles on no periodic orbit, with its class, and
    /// where Newton's method finds none; as [`Machine::motion`] and as [`Family::place`].
    pub fn settled(machine: &Machine, start: &Start, discard_returns: u32) -> Result<Self> {
        let family = Arc::new(Family::of_one(machine)?);
        let (motion, section) = machine.motion(start)?;
        let value = family.present()?;
        let mut motion = motion.without_energy_accounts();
        Self::settled_in(&family, value, (&mut motion, &section), discard_returns)
    }

    /// The orbit on which the motion of a family's machine at a value settles.
    ///
    /// # Errors
    /// As [`settled`](Self::settled).
    pub fn settled_at(family: &Family, value: f64, start: &Start, discard_returns: u32) -> Result<Self> {
        let (motion, section) = family.at(value)?.motion(start)?;
        let mut motion = motion.without_energy_accounts();
        Self::settled_in(&Arc::new(family.clone()), value, (&mut motion, &section), discard_returns)
    }

    /// As [`settled`](Self::settled), of a family's machine at a value, from a motion's present
    /// state. The motion goes on to where it has been observed.
    pub(super) fn settled_in(
        family: &Arc<Family>,
        value: f64,
        (motion, section): (&mut Motion, &Section),
        discard_returns: u32,
    ) -> Result<Self> {
        discard(motion, section, discard_returns)?;
        let found = settled(motion, section, None)?;
        let MotionClass::Periodic(returns) = found.class else {
            let words = section.in_words(&motion.assembly().description);
            let problem = format!(
                "the motion settles on no periodic orbit: it is {} at {words}; allowed are other starts (--start) and more discarded returns",
                found.class.name()
            );
            return Err(Error::Described { problem });
        };
        let seed = seed(family, value, motion, section, returns)?;
        Self::of_seed(seed).map_err(Obstructed::error)
    }

    /// The orbit near a motion that begins at a start and is followed over a time, s.
    ///
    /// # Errors
    /// [`Error::Described`] where Newton's method does not converge, with what it found.
    pub fn near(machine: &Machine, start: &Start, period: f64) -> Result<Self> {
        let family = Arc::new(Family::of_one(machine)?);
        let (mut motion, _) = machine.motion(start)?;
        let from = motion.time();
        let section = Section::of(&machine.description, &SectionRule::Period(period))?;
        let section = match section {
            Section::Period(period) if from != 0.0 => Section::Shifted(period, from),
            section => section,
        };
        let value = family.present()?;
        let seed = seed(&family, value, &mut motion, &section, 1)?;
        Self::of_seed(seed).map_err(Obstructed::error)
    }
}
