//! Corners of signals: knots at which a force or the acceleration of a prescribed body jumps.
//!
//! The equations of an orbit are smooth while each event stays between its adjacent corners.
//! Beyond a corner they are continued with the signals of the original side. A branch thus reaches
//! the corner like a touch and ends there; on the other side another branch begins.

use super::place::{Place, with_signals};
use super::timed::{Source, Tick, Timed};
use super::word::{Between, Letter, Word};
use std::sync::Arc;
use vibro_machine::signals::RepeatedKnot;
use vibro_machine::system::System;
use vibro_studies::flight::{Flow, dot};

/// Largest number of corners in a common period of the drive; with more, none is considered. Such
/// signals are records, whose jumps are small.
const MOST: usize = 32;
/// Tolerance for a signal's relative jump: rounding.
const ROUNDING: f64 = 1e-9;
/// Largest difference of simultaneous times, in periods: rounding of different computations.
const INSTANT: f64 = 1e-12;

/// The piece of the signals at an event.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece {
    /// The event's time, s.
    pub time: f64,
    /// Times of the corners before and after it, s; `None` for an event at a fixed time or a
    /// machine without corners.
    corners: Option<[f64; 2]>,
}

/// Corners of the signals in the order of time, over one common period starting at 0.
struct Corners {
    period: f64,
    ticks: Vec<(f64, Tick)>,
}

impl Corners {
    /// The corners that affect a machine's motion in at least one mode of a word.
    fn of(place: &Place, word: &Word) -> Option<Self> {
        let (system, period) = (place.assembly.system(), place.period?);
        let flows: Vec<Arc<Flow>> = (0..word.len().max(1)).map(|k| place.flow(word.mode_after(k))).collect();
        let mut ticks: Vec<(f64, Tick)> = Vec::new();
        let mut time = -INSTANT * period;
        while let Some(knot) = system.signals.next_knot(time).filter(|knot| *knot < period * (1.0 - INSTANT))
        {
            let jump = jump(system, &flows[0], [time, knot]);
            time = knot;
            let is_new = ticks.last().is_none_or(|(last, _)| knot - last > INSTANT * period);
            if !is_new || !flows.iter().any(|flow| is_felt(flow, system.states(), &jump)) {
                continue;
            }
            let own = system.signals.repeated_knots_at(knot).next();
            ticks.extend(own.map(|RepeatedKnot { of, number }| {
                (knot, Tick::new(Source::Signal(of), number, system, period))
            }));
            if ticks.len() > MOST {
                return None;
            }
        }
        (!ticks.is_empty()).then_some(Self { period, ticks })
    }

    /// The last corner up to a time and the first one after it.
    fn around(&self, time: f64) -> [Tick; 2] {
        let turn = (time / self.period).floor();
        let count = self.ticks.len() as i64;
        let within = time - turn * self.period;
        let after = self.ticks.iter().take_while(|(corner, _)| *corner <= within).count() as i64;
        let tick = |k: i64| {
            let turns = turn as i64 + k.div_euclid(count);
            self.ticks[k.rem_euclid(count) as usize].1.later(turns)
        };
        [tick(after - 1), tick(after)]
    }
}

/// The signals of the piece that begins at `begin`, extrapolated to `time`.
fn carried(system: &System, flow: &Flow, [begin, time]: [f64; 2]) -> Vec<f64> {
    let mut z = vec![0.0; system.signals.size];
    with_signals(system, begin, &mut z);
    flow.stretches(&z, time - begin, &mut |_, _| ())
}

/// The jump of the signals at a knot, relative to the piece that begins at `before`.
fn jump(system: &System, flow: &Flow, [before, knot]: [f64; 2]) -> Vec<f64> {
    let (old, mut new) = (carried(system, flow, [before, knot]), vec![0.0; system.signals.size]);
    with_signals(system, knot, &mut new);
    let harmonic = system.signals.constant_size_until();
    let of = |(i, (a, b)): (usize, (&f64, &f64))| {
        let is_rounding = i < harmonic || (b - a).abs() <= ROUNDING * (a.abs() + b.abs());
        if is_rounding { 0.0 } else { b - a }
    };
    old.iter().zip(&new).enumerate().map(of).collect()
}

/// Whether a jump of the signals changes an acceleration, or an event function or its first two
/// rates.
fn is_felt(flow: &Flow, own: usize, jump: &[f64]) -> bool {
    if jump.iter().all(|x| *x == 0.0) {
        return false;
    }
    let rate = flow.derivative(jump);
    let second = flow.derivative(&rate);
    let feels = |row: &[f64]| [jump, &rate, &second].iter().any(|z| dot(row, z) != 0.0);
    rate[..own].iter().any(|x| *x != 0.0) || flow.watched.iter().any(|(_, row)| feels(row.as_slice()))
}

impl Word {
    /// The word with the corners adjacent to its events at given times.
    #[must_use]
    pub(super) fn between_corners(mut self, place: &Place, times: &[f64]) -> Self {
        self.between = Vec::new().into();
        let Some(corners) = Corners::of(place, &self) else { return self };
        let turns = i64::from(self.periods.unwrap_or(0));
        let timed: Vec<&Timed> = self.letters.iter().filter_map(Letter::timed).collect();
        let is_letter = |tick: Tick| {
            timed.iter().flat_map(|own| &own.ticks).any(|own| {
                let apart = tick.number - own.number;
                own.source == tick.source && apart.rem_euclid((turns * own.per_period).max(1)) == 0
            })
        };
        let of = |(letter, time): (&Letter, &f64)| {
            (letter.timed().is_none() && letter.chatter.is_none()).then(|| {
                let ticks = corners.around(*time);
                Between { ticks, are_letters: ticks.map(is_letter) }
            })
        };
        self.between = self.letters.iter().zip(times).map(of).collect();
        self
    }

    /// The word with one event moved beyond its next (`ahead`) or previous corner.
    pub(super) fn beyond_corner(&self, place: &Place, letter: usize, ahead: bool) -> Option<Self> {
        let corners = Corners::of(place, self)?;
        let mut between = self.between.to_vec();
        let own = between.get_mut(letter)?.as_mut()?;
        let system = place.assembly.system();
        let passed = own.ticks[usize::from(ahead)];
        // A time within the piece beyond the corner.
        let step = corners.period * INSTANT * if ahead { 1.0 } else { -1.0 };
        let ticks = corners.around(passed.time(system) + 1e3 * step);
        *own = Between { ticks, are_letters: [false; 2] };
        let mut word = self.clone();
        word.between = between.into();
        Some(word)
    }

    /// The next (`ahead`) or previous corner of an event.
    pub(super) fn corner(&self, letter: usize, ahead: bool) -> Option<Tick> {
        self.between.get(letter).copied().flatten().map(|own| own.ticks[usize::from(ahead)])
    }

    /// The distance of an event from its next (`ahead`) or previous corner, s; `None` if the
    /// corner is an event of the word. `time` is the event's time; for the first event, one period
    /// after the start.
    pub(super) fn distance(&self, (system, time): (&System, f64), letter: usize, ahead: bool) -> Option<f64> {
        let own = self.between.get(letter).copied().flatten()?;
        let later = if letter == 0 { self.turns() } else { 0 };
        let corner = own.ticks[usize::from(ahead)].later(later).time(system);
        let is_letter = own.are_letters[usize::from(ahead)];
        (!is_letter).then_some(if ahead { corner - time } else { time - corner })
    }

    /// The piece of the signals that contains event `k`, `later` common periods later.
    pub(super) fn piece(&self, system: &System, k: usize, time: f64, later: i64) -> Piece {
        let own = self.between.get(k).copied().flatten();
        let corners = own.map(|own| own.ticks.map(|tick| tick.later(later).time(system)));
        Piece { time, corners }
    }
}

impl Piece {
    /// An event at a fixed time.
    pub fn fixed(time: f64) -> Self {
        Self { time, corners: None }
    }

    /// Whether the event lies between its corners.
    fn is_within(&self) -> bool {
        self.corners.is_none_or(|[before, after]| before <= self.time && self.time < after)
    }

    /// The knots of signals between this event and the next one, both on their side of corners.
    pub fn knots(&self, system: &System, next: &Self) -> Vec<f64> {
        let mut from = self.time;
        if let Some([before, after]) = self.corners {
            // A corner that an event has passed still comes after it.
            from = if from >= after { after.next_down() } else { from.max(before) };
        }
        let mut until = next.time;
        if let Some([before, after]) = next.corners {
            until = if until <= before { before.next_up() } else { until.min(after) };
        }
        let knot = |time: &f64| system.signals.next_knot(*time).filter(|knot| *knot < until);
        std::iter::successors(knot(&from), knot).collect()
    }

    /// Updates the signals of an augmented state, already propagated by the flow, on the event's
    /// side of its corners.
    pub fn renew(&self, system: &System, z: &mut [f64]) {
        if self.is_within() {
            with_signals(system, self.time, z);
        }
    }

    /// Fills in the signals of an augmented state on the event's side of its corners.
    pub fn fill(&self, system: &System, flow: &Flow, z: &mut [f64]) {
        let Some([before, after]) = self.corners.filter(|_| !self.is_within()) else {
            return with_signals(system, self.time, z);
        };
        let mut begin = before;
        while let Some(knot) =
            system.signals.next_knot(begin).filter(|knot| self.time >= after && *knot < after)
        {
            begin = knot;
        }
        let signals = carried(system, flow, [begin, self.time]);
        z[system.states()..].copy_from_slice(&signals[system.states()..]);
    }
}
