//! Words of orbits: the events of a period, each with the modes before and after it.

use std::sync::Arc;
use vibro_analysis::assembly::named;
use vibro_assembly::mode::{Mode, StopState, Watch};
use vibro_assembly::motion::{Crossing, Event, keep};
use vibro_assembly::system::System;
use vibro_assembly::{Assembly, motion::EventKind};

/// One event of an orbit.
#[derive(Clone, Debug)]
pub struct Letter {
    /// Modes before and after it.
    pub modes: [Mode; 2],
    /// The functional that passes zero.
    pub watch: Watch,
    /// Its place among the functionals of the mode before with the same `watch`: an `ElastoGap` has
    /// two.
    pub place: usize,
    /// The reports of the event: impacts in their order, then changes of elements. Times and speeds
    /// are those of the motion in which the event was found.
    pub events: Vec<Event>,
    /// Where the event is the first impact of a run that accumulates: what the run ends with.
    pub chatter: Option<Chatter>,
}

/// A run of impacts that accumulates until its stop closes. It is one part of a word, whatever the
/// number of its impacts.
#[derive(Clone, Debug, PartialEq)]
pub struct Chatter {
    /// The stop.
    pub stop: usize,
    /// The mode in which it has closed.
    pub mode: Mode,
}

impl PartialEq for Letter {
    /// Whether two events have the same law: modes, functional, and impacts in their order.
    fn eq(&self, other: &Self) -> bool {
        self.modes == other.modes
            && (self.watch, self.place) == (other.watch, other.place)
            && self.impacts().eq(other.impacts())
            && self.chatter == other.chatter
    }
}

impl Letter {
    /// The impacts: stop, and number of stops that take part in it.
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

    /// The mode after it, and after its run of impacts.
    pub(super) fn last_mode(&self) -> &Mode {
        self.chatter.as_ref().map_or(&self.modes[1], |chatter| &chatter.mode)
    }

    /// Whether it opens a compliant stop. At given event times a stiff contact turns a change of
    /// the place into one of the speed, its angular frequency times as large.
    fn opens_compliant(&self) -> bool {
        let [before, after] = &self.modes;
        let pairs = before.stops.iter().zip(&after.stops);
        pairs.into_iter().any(|(before, after)| before != after && *after == StopState::Below)
    }

    /// Whether the event has an impact.
    pub fn is_impact(&self) -> bool {
        self.impacts().next().is_some()
    }

    /// Applies the event's law to augmented states, each as a function of the state before at a
    /// fixed time: linear in the augmented state, whose coordinate 1 carries gaps and whose signals
    /// carry prescribed rates.
    pub(super) fn apply<'v>(&self, system: &System, states: impl IntoIterator<Item = &'v mut [f64]>) {
        let still = vec![0.0; system.signals.size];
        let (rates, zero) = ([&still[..], &still[..]], [&still[..], &still[..]]);
        let modes = [&self.modes[0], &self.modes[1]];
        Crossing { modes, states: zero, rates, row: None, events: &self.events }.carry(system, states);
    }

    /// The letter of a word without events: the contacts of its mode are kept.
    pub(super) fn staying(word: &Word) -> Self {
        let modes = [word.mode.clone(), word.mode.clone()];
        Self { modes, watch: Watch::Meets(usize::MAX), place: 0, events: Vec::new(), chatter: None }
    }

    /// Removes from variations what the contacts after the event constrain.
    pub(super) fn keep<'v>(&self, system: &System, variations: impl IntoIterator<Item = &'v mut [f64]>) {
        variations.into_iter().for_each(|v| keep(system, &self.modes[1], v));
    }

    /// The event in words: `impact steel`, `slip guide`; several reports are joined by ` + `.
    pub fn in_words(&self, assembly: &Assembly) -> String {
        let plain = |name: &str| name.rsplit('.').next().unwrap_or(name).to_owned();
        let mut words: Vec<String> = Vec::new();
        for event in &self.events {
            let named = named(assembly, &event.kind);
            let word = format!("{} {}", named.kind, plain(&named.element));
            if !words.contains(&word) {
                words.push(word);
            }
        }
        if let Some(Chatter { stop, .. }) = self.chatter {
            words.push(format!("chatter {}", plain(&assembly.name_of_stop(stop))));
        }
        if words.is_empty() { "change".into() } else { words.join(" + ") }
    }
}

/// The events of a period in their order, and the period.
#[derive(Clone, Debug, PartialEq)]
pub struct Word {
    /// The events; without one the motion stays in [`mode`](Self::mode).
    pub letters: Arc<[Letter]>,
    /// The mode after the last event.
    pub mode: Mode,
    /// Number of the drive's common periods; `None` for an autonomous machine.
    pub periods: Option<u32>,
    nodes: Arc<[usize]>,
}

impl Word {
    /// A word with its mode after the last event.
    pub(super) fn new(letters: Arc<[Letter]>, mode: Mode, periods: Option<u32>) -> Self {
        let later = (1..letters.len()).filter(|k| letters[*k].opens_compliant());
        let nodes = std::iter::once(0).chain(later).collect();
        Self { letters, mode, periods, nodes }
    }

    /// The events after which the state is an unknown: the first one, and those that open a
    /// compliant stop, so that no contact magnifies what another one has magnified.
    pub(super) fn nodes(&self) -> &[usize] {
        &self.nodes
    }

    /// Number of events.
    pub fn len(&self) -> usize {
        self.letters.len()
    }

    /// Whether it has no event.
    pub fn is_empty(&self) -> bool {
        self.letters.is_empty()
    }

    /// The mode of the flight that ends before the event after event `k`.
    pub(super) fn mode_after(&self, k: usize) -> &Mode {
        self.letters.get(k).map_or(&self.mode, Letter::last_mode)
    }

    /// The word passed `times` times.
    #[must_use]
    pub(super) fn repeated(&self, times: u32) -> Self {
        let letters = self.letters.iter().cloned().cycle().take(self.len() * times as usize);
        Self::new(letters.collect(), self.mode.clone(), self.periods.map(|n| n * times))
    }

    /// The word that begins with letter `first`.
    #[must_use]
    pub(super) fn rotated(&self, first: usize) -> Self {
        let mut letters = self.letters.to_vec();
        letters.rotate_left(first);
        let mode = letters.last().map_or_else(|| self.mode.clone(), |letter| letter.last_mode().clone());
        Self::new(letters.into(), mode, self.periods)
    }

    /// The events in words: `impact steel, press buffer, free buffer`; empty without events.
    pub fn in_words(&self, assembly: &Assembly) -> String {
        let words: Vec<String> = self.letters.iter().map(|letter| letter.in_words(assembly)).collect();
        words.join(", ")
    }
}
