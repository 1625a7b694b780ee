//! A recorded motion: the events of a word, with their times and the states after them.

use super::problem::Units;
use super::timed::Timed;
use super::word::{Cause, Chatter, Letter};
use nalgebra::DVectorView;
use vibro_machine::mode::Mode;
use vibro_machine::motion::EventKind;
use vibro_machine::system::System;
use vibro_studies::flight::{ObservedFlight, Observer, Passage, dot};

/// Relative tolerance for equal times, or equal displacements at a knot: rounding.
pub(super) const WHOLE: f64 = 1e-9;
/// Smallest unit of a state variable, relative to the largest of its kind.
const LEAST: f64 = 1e-3;
/// Largest difference of simultaneous times, relative to the time: rounding.
const INSTANT: f64 = 4.0 * f64::EPSILON;
/// Number of samples of a flight for the sizes of states.
const SAMPLES: usize = 8;

/// A motion as a word with its times.
#[derive(Debug, Default)]
pub(super) struct Record {
    pub letters: Vec<Letter>,
    pub times: Vec<f64>,
    /// The state after each event.
    pub states: Vec<Vec<f64>>,
    /// The drive's common period, s.
    pub period: f64,
    /// Knot time of a jump of prescribed bodies that moves others, s.
    pub jump: Option<f64>,
    /// Smallest and largest value of each state variable.
    pub extents: Vec<(f64, f64)>,
}

impl Record {
    fn include(&mut self, z: &[f64]) {
        self.extents.resize(z.len(), (f64::INFINITY, f64::NEG_INFINITY));
        for ((least, largest), x) in self.extents.iter_mut().zip(z) {
            (*least, *largest) = (least.min(*x), largest.max(*x));
        }
    }

    /// Units that make the state variables of size one.
    pub fn units(&self, system: &System, radian: f64) -> Units {
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
        // The unit of an inner elongation is its own amplitude, or the largest of a coordinate.
        let inner = system.places_of_first_order();
        let inner = inner
            .map(|k| if way(k) > 0.0 { way(k).max(LEAST * most * radian) } else { unit_of(most) * radian });
        let state = places.chain((0..coordinates).map(unit)).chain(inner).collect();
        Units { state, time: radian }
    }

    /// Indices of the events at which a stop closes after accumulating impacts, with the stop.
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

    /// Replaces each run of accumulating impacts by one event. The record is rotated to begin
    /// after the last closing, so that no run crosses its end.
    pub fn with_runs(&mut self, period: f64, periods: Option<u32>) {
        let closings = self.closings();
        let Some((last, _)) = closings.last() else { return };
        self.begin_with((last + 1) % self.letters.len(), period, periods);
        let mut from = self.letters.len();
        while let Some((end, stop)) = self.closings().into_iter().rev().find(|(k, _)| *k < from) {
            from = end;
            let hits: Vec<usize> =
                (0..=end).filter(|k| self.letters[*k].hits().any(|hit| hit == stop)).collect();
            // The run begins with the impact after which all intervals shrink, without fixed
            // times.
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

    /// Rotates the record to begin with event `first`; earlier events move one period later.
    fn begin_with(&mut self, first: usize, period: f64, periods: Option<u32>) {
        let later = self.times.len() - first;
        self.letters.rotate_left(first);
        self.states.rotate_left(first);
        self.times.rotate_left(first);
        self.times.iter_mut().skip(later).for_each(|time| *time += period);
        let turns = i64::from(periods.unwrap_or(0));
        self.letters.iter_mut().skip(later).for_each(|letter| *letter = letter.later(turns));
    }

    /// Rotates the record to begin with a fixed time, if it has one.
    pub fn begin_with_fixed_time(&mut self, period: f64, periods: Option<u32>) {
        if let Some(first) = self.letters.iter().position(|letter| letter.timed().is_some()) {
            self.begin_with(first, period, periods);
        }
    }

    /// Whether a knot moves bodies at once. An impact there changes only rates, a sample only the
    /// states of blocks.
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

    /// Records what happens at a fixed time: simultaneous knots and samples are one event.
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

    /// Removes knots that change only signals.
    pub fn leave_plain_knots_out(&mut self) {
        let is_plain = |letter: &Letter| {
            let is_knot = letter.events.iter().all(|event| event.kind == EventKind::Knot);
            letter.timed().is_some() && is_knot && letter.modes[0] == letter.modes[1]
        };
        let kept: Vec<bool> = self.letters.iter().map(|letter| !is_plain(letter)).collect();
        keep(&mut self.letters, &kept);
        keep(&mut self.times, &kept);
        keep(&mut self.states, &kept);
    }
}

/// Removes the items that are not kept.
fn keep<T>(all: &mut Vec<T>, kept: &[bool]) {
    let mut of = kept.iter();
    all.retain(|_| of.next().copied().unwrap_or(true));
}

impl Observer for Record {
    fn flight(&mut self, _: &System, flight: ObservedFlight<'_>) {
        let part = flight.span / SAMPLES as f64;
        // Without curved forces one propagator serves all samples.
        let propagator = (!flight.flow.is_curved()).then(|| flight.flow.propagator(part));
        let mut z = flight.start.to_vec();
        for _ in 0..SAMPLES {
            self.include(&z);
            z = match &propagator {
                Some(propagator) => (propagator * DVectorView::from_slice(&z, z.len())).as_slice().to_vec(),
                None => flight.flow.after(&z, part),
            };
        }
        self.include(&z);
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
