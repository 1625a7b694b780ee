//! Words of orbits: the events of a period, each with the modes before and after it.

use super::place::with_signals;
use super::timed::{Tick, Timed};
use std::sync::Arc;
use vibro_machine::mode::{Mode, StopState, Watch};
use vibro_machine::motion::{Crossing, Event, keep};
use vibro_machine::system::System;
use vibro_machine::{Assembly, motion::EventKind};
use vibro_studies::named;

/// Word for a change of mode without a report, for example when a stop opens without a force.
const CHANGE: &str = "change";

/// One event of an orbit.
#[derive(Clone, Debug)]
pub struct Letter {
    /// Modes before and after it.
    pub modes: [Mode; 2],
    /// The cause of the event.
    pub cause: Cause,
    /// The reports of the event: impacts in their order, then changes of elements. Times and
    /// speeds are from the original motion.
    pub events: Vec<Event>,
    /// For the first impact of a run that accumulates: how the run ends.
    pub chatter: Option<Chatter>,
}

/// The cause of an event.
#[derive(Clone, Debug, PartialEq)]
pub enum Cause {
    /// An event function passes zero.
    Passes {
        /// The event function.
        watch: Watch,
        /// Index among the event functions of the mode before with the same `watch`: an
        /// `ElastoGap` has two.
        place: usize,
    },
    /// A knot or a sample at a fixed time.
    Timed(Timed),
}

/// A run of impacts that accumulates until its stop closes. It is one event of a word, whatever
/// its number of impacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Chatter {
    /// The stop.
    pub stop: usize,
    /// The mode after the stop has closed.
    pub mode: Mode,
}

impl PartialEq for Letter {
    /// Whether two events have the same law: modes, cause, and impacts in their order.
    fn eq(&self, other: &Self) -> bool {
        self.modes == other.modes && self.cause == other.cause && self.has_impacts_of(other)
    }
}

impl Letter {
    fn has_impacts_of(&self, other: &Self) -> bool {
        self.impacts().eq(other.impacts()) && self.chatter == other.chatter
    }

    /// The event function that passes zero; `None` at a fixed time.
    pub fn watch(&self) -> Option<Watch> {
        if let Cause::Passes { watch, .. } = self.cause { Some(watch) } else { None }
    }

    /// Ticks and actions at its fixed time; `None` for an event function.
    pub fn timed(&self) -> Option<&Timed> {
        if let Cause::Timed(timed) = &self.cause { Some(timed) } else { None }
    }

    /// The event `periods` common periods later: only fixed times differ.
    pub(super) fn later(&self, periods: i64) -> Self {
        let cause = match &self.cause {
            Cause::Timed(timed) => Cause::Timed(timed.later(periods)),
            passes => passes.clone(),
        };
        Self { cause, ..self.clone() }
    }

    /// Whether `other` is this event, `periods` common periods later.
    pub(super) fn is_later(&self, other: &Self, periods: i64) -> bool {
        let is_cause = match (&self.cause, &other.cause) {
            (Cause::Timed(own), Cause::Timed(other)) => own.is_later(other, periods),
            (own, other) => own == other,
        };
        is_cause && self.modes == other.modes && self.has_impacts_of(other)
    }

    /// The impacts: stop, and number of stops that take part.
    fn impacts(&self) -> impl Iterator<Item = (usize, usize)> + '_ {
        self.events.iter().filter_map(|event| match event.kind {
            EventKind::Impact { stop, stops, .. } => Some((stop, stops)),
            _ => None,
        })
    }

    /// The stops that are hit.
    pub fn hits(&self) -> impl Iterator<Item = usize> + '_ {
        self.impacts().map(|(stop, _)| stop)
    }

    /// The mode after the event and, if it begins one, after its run of impacts.
    pub(super) fn last_mode(&self) -> &Mode {
        self.chatter.as_ref().map_or(&self.modes[1], |chatter| &chatter.mode)
    }

    /// Whether it opens a compliant stop. At given event times, a stiff contact turns a change of
    /// displacement into a change of velocity, larger by its angular frequency.
    fn opens_compliant(&self) -> bool {
        let [before, after] = &self.modes;
        let pairs = before.stops.iter().zip(&after.stops);
        pairs.into_iter().any(|(before, after)| before != after && *after == StopState::Below)
    }

    /// Whether the event has an impact.
    pub fn is_impact(&self) -> bool {
        self.impacts().next().is_some()
    }

    /// Applies the event's law to augmented states, each as a function of the state before it at a
    /// fixed time. The law is linear in the augmented state: coordinate 1 carries gaps and the
    /// signals carry prescribed rates. At a knot the states have the signals after it.
    pub(super) fn apply<'v>(&self, system: &System, states: impl IntoIterator<Item = &'v mut [f64]>) {
        let Some(timed) = self.timed() else { return self.strike(system, states) };
        let mut states: Vec<&mut [f64]> = states.into_iter().collect();
        self.strike(system, states.iter_mut().map(|state| &mut **state));
        states.into_iter().for_each(|state| timed.sample(system, state));
    }

    /// The part of [`apply`](Self::apply) before samples: impacts and the contacts after them.
    pub(super) fn strike<'v>(&self, system: &System, states: impl IntoIterator<Item = &'v mut [f64]>) {
        let still = vec![0.0; system.signals.size];
        let (rates, zero) = ([&still[..], &still[..]], [&still[..], &still[..]]);
        let modes = [&self.modes[0], &self.modes[1]];
        let events: Vec<Event> = self.events.iter().filter(|e| e.sample().is_none()).cloned().collect();
        Crossing { modes, states: zero, rates, row: None, events: &events }.carry(system, states);
    }

    /// The augmented state at the end of a flight, with the signals after its event.
    pub(super) fn arrived(&self, system: &System, time: f64, end: &[f64]) -> Vec<f64> {
        let mut state = end.to_vec();
        if self.timed().is_some() {
            with_signals(system, time, &mut state);
        }
        state
    }

    /// A placeholder event for a word without events: it keeps the contacts of the mode.
    pub(super) fn staying(word: &Word) -> Self {
        let modes = [word.mode.clone(), word.mode.clone()];
        let cause = Cause::Passes { watch: Watch::Meets(usize::MAX), place: 0 };
        Self { modes, cause, events: Vec::new(), chatter: None }
    }

    /// Projects variations onto the contacts that are closed after the event.
    pub(super) fn keep<'v>(&self, system: &System, variations: impl IntoIterator<Item = &'v mut [f64]>) {
        variations.into_iter().for_each(|v| keep(system, &self.modes[1], v));
    }

    /// The event in words: `impact steel`, `slip guide`; several reports are joined by ` + `. A
    /// change of mode without a report is `change`.
    pub fn in_words(&self, assembly: &Assembly) -> String {
        let plain = |name: &str| name.rsplit('.').next().unwrap_or(name).to_owned();
        let mut words: Vec<String> = self.timed().map(|own| own.in_words(assembly)).unwrap_or_default();
        let is_told = |event: &&Event| event.kind != EventKind::Knot && event.sample().is_none();
        for event in self.events.iter().filter(is_told) {
            let named = named(assembly, &event.kind);
            let word = format!("{} {}", named.kind, plain(&named.element));
            if !words.contains(&word) {
                words.push(word);
            }
        }
        if let Some(Chatter { stop, .. }) = self.chatter {
            words.push(format!("chatter {}", plain(&assembly.name_of_stop(stop))));
        }
        if words.is_empty() { CHANGE.into() } else { words.join(" + ") }
    }
}

/// The corners before and after an event.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Between {
    /// The ticks of the corners before and after the event.
    pub ticks: [Tick; 2],
    /// Whether each corner is an event of the word; their order is then a separate condition.
    pub are_letters: [bool; 2],
}

/// The events of a period in their order, and the period.
#[derive(Clone, Debug, PartialEq)]
pub struct Word {
    /// The events; if empty, the motion stays in [`mode`](Self::mode).
    pub letters: Arc<[Letter]>,
    /// The mode after the last event.
    pub mode: Mode,
    /// Number of the drive's common periods; `None` for an autonomous machine.
    pub periods: Option<u32>,
    nodes: Arc<[usize]>,
    free: Arc<[usize]>,
    /// The corners of signals next to each event; empty for a machine without corners.
    pub(super) between: Arc<[Option<Between>]>,
}

impl Word {
    /// A word with its mode after the last event. If the word begins with a fixed time, fixed
    /// times count from the common period of this event.
    pub(super) fn new(letters: Arc<[Letter]>, mode: Mode, periods: Option<u32>) -> Self {
        let first = letters.first().and_then(Letter::timed).map_or(0, Timed::turn);
        let letters =
            if first == 0 { letters } else { letters.iter().map(|own| own.later(-first)).collect() };
        let later = (1..letters.len()).filter(|k| letters[*k].opens_compliant());
        let nodes = std::iter::once(0).chain(later).collect();
        let free = (0..letters.len()).filter(|k| letters[*k].timed().is_none()).collect();
        Self { letters, mode, periods, nodes, free, between: Vec::new().into() }
    }

    /// The events whose times are unknowns.
    pub(super) fn free(&self) -> &[usize] {
        &self.free
    }

    /// Whether the word has events at fixed times.
    pub(super) fn is_timed(&self) -> bool {
        self.free.len() < self.len()
    }

    /// Number of common drive periods in the word's period.
    pub(super) fn turns(&self) -> i64 {
        i64::from(self.periods.unwrap_or(0))
    }

    /// Events after which the state is an unknown: the first event, and events that open a
    /// compliant stop. Thus no contact magnifies what another has magnified.
    pub(super) fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// Whether the word has a run of impacts that accumulates.
    pub(super) fn has_run(&self) -> bool {
        self.letters.iter().any(|letter| letter.chatter.is_some())
    }

    /// Number of events.
    pub fn len(&self) -> usize {
        self.letters.len()
    }

    /// Whether the word has no event.
    pub fn is_empty(&self) -> bool {
        self.letters.is_empty()
    }

    /// The mode after event `k` and, if it begins one, after its run of impacts.
    pub(super) fn mode_after(&self, k: usize) -> &Mode {
        self.letters.get(k).map_or(&self.mode, Letter::last_mode)
    }

    /// The word repeated `times` times.
    #[must_use]
    pub(super) fn repeated(&self, times: u32) -> Self {
        let turns = (0..i64::from(times)).map(|turn| turn * self.turns());
        let letters = turns.flat_map(|by| self.letters.iter().map(move |letter| letter.later(by)));
        let whole = Self::new(letters.collect(), self.mode.clone(), self.periods.map(|n| n * times));
        Self { between: self.repeated_corners(times), ..whole }
    }

    /// The corners next to the events of the word repeated `times` times.
    fn repeated_corners(&self, times: u32) -> Arc<[Option<Between>]> {
        let turns = (0..i64::from(times)).map(|turn| turn * self.turns());
        let of = |own: Between, by: i64| Between { ticks: own.ticks.map(|tick| tick.later(by)), ..own };
        turns.flat_map(|by| self.between.iter().map(move |own| own.map(|own| of(own, by)))).collect()
    }

    /// The first part of the word, if the word repeats it `times` times.
    pub(super) fn part(&self, times: u32) -> Option<Self> {
        let (count, letters) = (times as usize, &self.letters);
        let is_whole = letters.len().is_multiple_of(count)
            && self.periods.is_none_or(|periods| periods.is_multiple_of(times));
        let part = letters.len() / count;
        let by = self.turns() / i64::from(times);
        if !is_whole
            || part == 0
            || (part..letters.len()).any(|k| !letters[k - part].is_later(&letters[k], by))
        {
            return None;
        }
        let periods = self.periods.map(|periods| periods / times);
        let between = self.between[..part.min(self.between.len())].into();
        Some(Self { between, ..Self::new(letters[..part].to_vec().into(), self.mode.clone(), periods) })
    }

    /// Whether another word is this one, starting at letter `first`.
    pub(super) fn is_from(&self, first: usize, other: &Self) -> bool {
        let m = self.len();
        let turn =
            |letters: &[Letter], k: usize| letters.get(k).and_then(Letter::timed).map_or(0, Timed::turn);
        let by = turn(&other.letters, 0) - turn(&self.letters, first);
        let is_own = |k: usize| {
            let (turn, own) = ((first + k) / m, (first + k) % m);
            self.letters[own].is_later(&other.letters[k], by + turn as i64 * self.turns())
        };
        (m, self.periods) == (other.len(), other.periods)
            && (m > 0 || self.mode == other.mode)
            && (0..m).all(is_own)
    }

    /// The events in words: `impact steel, press buffer, free buffer`, with the number of
    /// consecutive samples: `sample control ×40`; empty without events. Changes of mode without a
    /// report are left out.
    pub fn in_words(&self, assembly: &Assembly) -> String {
        let mut words: Vec<(String, usize)> = Vec::new();
        for letter in self.letters.iter() {
            let (word, is_timed) = (letter.in_words(assembly), letter.timed().is_some());
            match words.last_mut().filter(|last| is_timed && last.0 == word) {
                Some(last) => last.1 += 1,
                None if word == CHANGE => {}
                None => words.push((word, 1)),
            }
        }
        let told =
            |(word, count): (String, usize)| if count > 1 { format!("{word} ×{count}") } else { word };
        words.into_iter().map(told).collect::<Vec<_>>().join(", ")
    }
}
