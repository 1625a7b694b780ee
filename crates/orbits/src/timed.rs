//! Events at fixed times: knots at which a contact or a stiffness changes, and samples of blocks.
//! Each is identified by the number of its knot or sample. Its time depends on the machine's
//! parameters and is not an unknown.

use super::place::Place;
use crate::obstacle::Obstacle;
use vibro_machine::Assembly;
use vibro_machine::description::Description;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::signals::RepeatedKnot;
use vibro_machine::system::{LimitedValue, SampleAction, SampleKind, Sampler, System};
use vibro_studies::flight::dot;

/// Largest difference of simultaneous times, in periods: rounding of different computations.
const INSTANT: f64 = 1e-12;

/// Source of ticks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// A repeated signal, by its index among the repeated signals.
    Signal(usize),
    /// A block reading its inputs.
    Reads(usize),
    /// A block whose outputs take effect.
    Acts(usize),
}

/// A knot of a signal, or the time of a read or an output of a sampled block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tick {
    /// The source of the tick.
    pub source: Source,
    /// Number of earlier ticks of the source, from time 0.
    pub number: i64,
    /// Ticks of the source in a common period.
    pub per_period: i64,
}

/// Ticks and actions at a fixed time.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Timed {
    /// The ticks, all at one instant.
    pub ticks: Vec<Tick>,
    /// Actions of sampled blocks.
    pub actions: Vec<SampleAction>,
    /// For each limited value that samples read, the side of its limits on which it lies, in the
    /// order of [`System::sample_as`].
    pub sides: Vec<i8>,
}

impl Tick {
    /// The tick of a source with a given number.
    pub(super) fn new(source: Source, number: i64, system: &System, period: f64) -> Self {
        Self { source, number, per_period: per_period(source, system, period) }
    }

    /// The tick `periods` common periods later.
    #[must_use]
    pub(super) fn later(self, periods: i64) -> Self {
        Self { number: self.number + periods * self.per_period, ..self }
    }

    /// Its time, s.
    pub(super) fn time(&self, system: &System) -> f64 {
        let sampler = |block: usize| system.blocks[block].sampler.as_ref();
        match self.source {
            Source::Signal(of) => system.signals.time_of(RepeatedKnot { of, number: self.number }),
            Source::Reads(block) => sampler(block).map_or(f64::NAN, |own| own.time_of_sample(self.number)),
            Source::Acts(block) => sampler(block).map_or(f64::NAN, |own| own.time_of_acting(self.number)),
        }
    }

    /// Dotted name of the section that owns the source.
    pub(super) fn owner(&self, assembly: &Assembly) -> String {
        let d = &assembly.description;
        match self.source {
            Source::Signal(of) => {
                let signal = assembly.system().signals.repeated().nth(of).map(|own| own.signal);
                signal.and_then(|i| owners(d).into_iter().nth(i)).unwrap_or_default()
            }
            Source::Reads(block) | Source::Acts(block) => format!("block.{}", d.blocks[block].name),
        }
    }
}

/// Dotted names of the sections that own the signals of a system, in the order of the signals.
fn owners(d: &Description) -> Vec<String> {
    let bodies = d.bodies.iter().filter(|body| body.kind.is_prescribed());
    let mut all: Vec<String> = bodies.map(|body| format!("body.{}", body.name)).collect();
    all.extend(d.loads.iter().map(|own| format!("load.{}", own.name)));
    for own in &d.frictions {
        let count = 1 + usize::from(own.static_force.is_some());
        all.extend(std::iter::repeat_n(format!("friction.{}", own.name), count));
    }
    let stops = d.stops.iter().filter(|own| own.stepped.is_some());
    all.extend(stops.map(|own| format!("stop.{}", own.name)));
    let springs = d.springs.iter().filter(|own| own.stepped.is_some());
    all.extend(springs.map(|own| format!("spring.{}", own.name)));
    all.extend(d.sources.iter().map(|own| format!("signal.{}", own.name)));
    all
}

/// Number of ticks of a source in a common period.
fn per_period(source: Source, system: &System, period: f64) -> i64 {
    let sampler = |block: usize| system.blocks[block].sampler.as_ref();
    let turns = |own: f64| (period / own).round() as i64;
    match source {
        Source::Signal(of) => {
            let own = system.signals.repeated().nth(of);
            own.map_or(0, |own| turns(own.period) * own.count as i64)
        }
        Source::Reads(block) | Source::Acts(block) => sampler(block).map_or(0, |own| turns(own.period)),
    }
}

impl Timed {
    /// Ticks and actions at a time reached by a motion, with the events reported there.
    pub fn at(system: &System, period: f64, time: f64, events: &[Event]) -> Self {
        let actions: Vec<SampleAction> = events.iter().filter_map(Event::sample).collect();
        let tick = |source, number| Tick::new(source, number, system, period);
        let mut ticks = Vec::new();
        if events.iter().any(|event| event.kind == EventKind::Knot) {
            let knots = system.signals.repeated_knots_at(time);
            ticks.extend(knots.map(|knot| tick(Source::Signal(knot.of), knot.number)));
        }
        let nearest = |own: &Sampler, delay: f64| ((time - delay) / own.period).round() as i64;
        for SampleAction { block, kind } in &actions {
            let Some(own) = &system.blocks[*block].sampler else { continue };
            ticks.push(match kind {
                SampleKind::Reads(_) => tick(Source::Reads(*block), nearest(own, 0.0)),
                SampleKind::Acts => tick(Source::Acts(*block), nearest(own, own.delay)),
            });
        }
        Self { ticks, actions, sides: Vec::new() }
    }

    /// Adds what happens at the same instant.
    pub fn join(&mut self, other: Self) {
        self.ticks.extend(other.ticks);
        self.actions.extend(other.actions);
        self.sides.extend(other.sides);
    }

    /// The same ticks and actions, `periods` common periods later.
    #[must_use]
    pub fn later(&self, periods: i64) -> Self {
        let ticks = self.ticks.iter().map(|tick| tick.later(periods)).collect();
        Self { ticks, ..self.clone() }
    }

    /// Whether `other` is the same, `periods` common periods later.
    pub fn is_later(&self, other: &Self, periods: i64) -> bool {
        (&self.actions, &self.sides) == (&other.actions, &other.sides)
            && self.ticks.iter().map(|tick| tick.later(periods)).eq(other.ticks.iter().copied())
    }

    /// Index of the common period, counted from 0, with the first tick.
    pub fn turn(&self) -> i64 {
        self.ticks.first().map_or(0, |tick| tick.number.div_euclid(tick.per_period.max(1)))
    }

    /// Its time, s: the latest of its ticks, which differ by rounding.
    pub fn time(&self, system: &System) -> f64 {
        self.ticks.iter().map(|tick| tick.time(system)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Refuses ticks that are no longer at one instant, and sources whose number of ticks in a
    /// period has changed.
    pub(super) fn check(&self, place: &Place) -> Result<(), Obstacle> {
        let (system, period) = (place.assembly.system(), place.period.unwrap_or(f64::NAN));
        let latest = self.time(system);
        let is_own = |tick: &Tick| {
            per_period(tick.source, system, period) == tick.per_period
                && (latest - tick.time(system)) <= INSTANT * period
        };
        if self.ticks.iter().all(is_own) { Ok(()) } else { Err(Obstacle::Order) }
    }

    /// Applies its samples to an augmented state or a variation.
    pub fn sample(&self, system: &System, z: &mut [f64]) {
        let mut sides = self.sides.iter();
        system.sample_as(&self.actions, &mut |_| sides.next().copied().unwrap_or(0), z);
    }

    /// The side of its limits on which each limited value lies, in a state before the samples.
    pub fn sides_in(&self, system: &System, z: &[f64]) -> Vec<i8> {
        let (mut sides, mut z) = (Vec::new(), z.to_vec());
        let mut decide = |own: LimitedValue| {
            sides.push(own.side());
            own.side()
        };
        system.sample_as(&self.actions, &mut decide, &mut z);
        sides
    }

    /// The limited values in a state before the samples, each with its margin on its side.
    pub fn margins(&self, system: &System, z: &[f64]) -> Vec<((usize, usize), f64)> {
        let (mut all, mut z, mut sides) = (Vec::new(), z.to_vec(), self.sides.iter());
        let mut decide = |own: LimitedValue| {
            let side = sides.next().copied().unwrap_or(0);
            all.push((own.output, own.margin(side)));
            side
        };
        system.sample_as(&self.actions, &mut decide, &mut z);
        all
    }

    /// Dotted names of the sections that own the ticks, without repetition.
    pub fn owners(&self, assembly: &Assembly) -> Vec<String> {
        let mut all: Vec<String> = Vec::new();
        for tick in &self.ticks {
            let owner = tick.owner(assembly);
            if !all.contains(&owner) {
                all.push(owner);
            }
        }
        all
    }

    /// The ticks in words: `sample control`, `step mesh`.
    pub fn in_words(&self, assembly: &Assembly) -> Vec<String> {
        let mut words: Vec<String> = Vec::new();
        for tick in &self.ticks {
            let kind = if matches!(tick.source, Source::Signal(_)) { "step" } else { "sample" };
            let owner = tick.owner(assembly);
            let word = format!("{kind} {}", owner.rsplit('.').next().unwrap_or(&owner));
            if !words.contains(&word) {
                words.push(word);
            }
        }
        words
    }
}

/// The value of an event function in a state, relative to its terms; positive above zero.
pub(super) fn beyond(row: &[f64], z: &[f64]) -> f64 {
    let size: f64 = row.iter().zip(z).map(|(a, x)| (a * x).abs()).sum();
    dot(row, z) / size.max(f64::MIN_POSITIVE)
}
