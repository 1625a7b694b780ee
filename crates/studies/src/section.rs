//! Poincaré section of a described machine: whole common periods of its harmonics and repeated
//! signals or, without these, the events of one element. A return to the section corresponds to a
//! drive period of the 3-DOF machine.

use super::flight::{Flows, Observer, follow};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use vibro_machine::Motion;
use vibro_machine::description::{Description, Signal};
use vibro_machine::elements::NamedSignal;
use vibro_machine::motion::{Event, EventKind, Reached};
use vibro_machine::refusal::advice;

/// Relative tolerance for a whole ratio of frequencies.
const COMMENSURATE: f64 = 1e-9;
/// Largest number of periods of the slowest harmonic in a common period.
const MOST_PERIODS: u32 = 1000;
/// Time limit between two events of the section, s.
const WITHIN: f64 = 100.0;

/// Offset of a shifted section from whole periods, as a fraction of the period. Its value is not
/// near a ratio of small integers.
const BESIDE: f64 = 0.381_966_011_250_105;

/// Rule for the choice of the section.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub enum SectionRule {
    /// Whole common periods of all harmonics and repeated signals. Without these the events of the
    /// first stop, else of the first contact, else of the first friction element.
    #[default]
    Auto,
    /// Whole multiples of a time, s.
    Period(f64),
    /// Events of an element: impacts and first touches of a stop or contact; for friction, each
    /// time it begins to stick.
    Element(String),
}

/// Poincaré section of a machine.
///
/// Without a drive, the events of the first stop are the section:
///
/// ```
/// use vibro_studies::{Machine, Section, SectionRule, Start};
///
/// # let text = r#"
/// #     name = "Ball"
/// #     gravity = 10.0
/// #     body.ball = { mass = "20 g", gravity = 1.0 }
/// #     stop.floor = { between = ["ground", "ball"], gap = "5 m", restitution = 0.5 }
/// # "#;
/// let machine = Machine::parse(text, "ball.toml", &vibro_machine::file::no_records)?;
/// let section = Section::of(&machine.description, &SectionRule::Auto)?;
/// assert_eq!(section.in_words(&machine.description), "events of stop.floor");
/// let (mut motion, _) = machine.motion(&Start::default())?;
/// for exact in [1.0, 2.0, 2.5] {
///     section.advance(&mut motion, &mut |_| ())?;
///     assert!((motion.time() - exact).abs() < 1e-14);
/// }
/// # Ok::<(), vibro_studies::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Section {
    /// Whole multiples of a time, s.
    Period(f64),
    /// Whole multiples of a time plus an offset, s, for motions with events at whole multiples.
    Shifted(f64, f64),
    /// Impacts or first touches of a stop. Contacts with friction follow the stops.
    Stop(usize),
    /// The events at which a friction element begins to stick.
    Friction(usize),
}

/// Frequencies of all signals, Hz: harmonics, repeated signals, samples, and sweeps after their
/// ends.
pub(super) fn frequencies(d: &Description) -> impl Iterator<Item = f64> {
    let harmonics = d.signals().flat_map(|s| s.signal.harmonics.iter());
    let repeats = d.signals().filter_map(|s| s.signal.repeat);
    let sweeps = d.signals().flat_map(|s| s.signal.sweeps.iter()).map(|sweep| sweep.to);
    let periods = repeats.chain(samples(d));
    harmonics.map(|h| h.frequency).chain(periods.map(|period| 1.0 / period)).chain(sweeps)
}

/// The times between samples of blocks, s.
fn samples(d: &Description) -> impl Iterator<Item = f64> {
    d.blocks.iter().filter_map(|block| Some(block.sampling.as_ref()?.period))
}

/// Whether no signal changes with time; prescribed bodies may move uniformly.
pub fn is_steady(d: &Description) -> bool {
    let is_constant =
        |s: &Signal| s.harmonics.is_empty() && s.sweeps.is_empty() && s.steps.is_empty() && s.table.is_none();
    let is_uniform = |s: &NamedSignal| s.motion != Some(2) || s.signal.constant == 0.0;
    samples(d).next().is_none() && d.signals().all(|s| is_constant(s.signal) && is_uniform(&s))
}

/// Smallest time, s, that is a whole number of periods of each harmonic, repeated signal and
/// sampling. `None` without these, with a sweep, or if it exceeds 1000 times the longest period.
///
/// ```
/// use vibro_machine::file::{no_records, parse};
///
/// let text = r#"
///     name = "Twice"
///     body.a = { mass = 1.0 }
///     load.slow = { on = "a", amplitude = 1.0, frequency = "2 Hz" }
///     load.fast = { on = "a", amplitude = 1.0, frequency = "3 Hz" }
/// "#;
/// let machine = parse(text, "twice.toml", &no_records)?;
/// assert_eq!(vibro_studies::common_period(&machine), Some(1.0));
/// let irrational = machine.with([("load.fast.frequency", 2.0 * 2f64.sqrt())])?;
/// assert_eq!(vibro_studies::common_period(&irrational), None);
/// # Ok::<(), vibro_machine::Refusal>(())
/// ```
pub fn common_period(d: &Description) -> Option<f64> {
    if d.signals().any(|s| !s.signal.sweeps.is_empty()) { None } else { last_period(d) }
}

/// [`common_period`] once all sweeps have ended.
pub(super) fn last_period(d: &Description) -> Option<f64> {
    let all: Vec<f64> = frequencies(d).collect();
    let slowest = all.iter().copied().reduce(f64::min)?;
    let is_whole = |ratio: f64| (ratio - ratio.round()).abs() <= COMMENSURATE * ratio;
    let all = |k: &u32| all.iter().all(|f| is_whole(f64::from(*k) * f / slowest));
    let count = f64::from((1..=MOST_PERIODS).find(all)?);
    // The period of a repeated signal is used directly, without the rounding of its frequency.
    let repeats = d.signals().filter_map(|s| s.signal.repeat).chain(samples(d));
    let repeat = repeats.into_iter().find(|period| 1.0 / period == slowest);
    Some(repeat.map_or(count / slowest, |period| count * period))
}

/// Whether a machine has an element whose events can be a section.
fn has_elements(d: &Description) -> bool {
    sections(d).next().is_some()
}

/// Names and sections of all elements whose events can be a section: stops, contacts with friction,
/// frictions.
fn sections(d: &Description) -> impl Iterator<Item = (&'static str, &str, Section)> + Clone {
    let stops = d.stops.iter().map(|own| ("stop", own.name.as_str()));
    let contacts = d.contacts.iter().map(|own| ("contact", own.name.as_str()));
    let stops = stops.chain(contacts).enumerate().map(|(i, (kind, name))| (kind, name, Section::Stop(i)));
    let frictions = d.frictions.iter().enumerate();
    stops.chain(frictions.map(|(i, own)| ("friction", own.name.as_str(), Section::Friction(i))))
}

impl Section {
    /// The section of a machine.
    ///
    /// # Errors
    /// [`Error::NoSection`] if the machine has no section; [`Error::Described`] if the rule does not
    /// give one. The message lists the possible sections.
    pub fn of(d: &Description, rule: &SectionRule) -> Result<Self> {
        let refused = |problem: String| Err(Error::Described { problem });
        let has_elements = has_elements(d);
        let none = |problem: String| Err(Error::NoSection { problem, has_elements });
        match rule {
            SectionRule::Period(period) if period.is_finite() && *period > 0.0 => Ok(Self::Period(*period)),
            SectionRule::Period(period) => {
                refused(format!("period = {period:?} s: expected a finite time > 0"))
            }
            SectionRule::Element(name) => {
                let plain = name.split_once('.').map_or(name.as_str(), |(_, plain)| plain);
                if let Some((.., section)) = sections(d).find(|own| own.1 == plain) {
                    return Ok(section);
                }
                let problem = format!("section {name}: no stop, contact or friction has this name");
                if !has_elements {
                    return none(format!("{problem}, and the machine has none of them"));
                }
                refused(format!("{problem}; {}", advice(plain, sections(d).map(|own| own.1))))
            }
            SectionRule::Auto => match common_period(d) {
                Some(period) => Ok(Self::Period(period)),
                None if d.signals().any(|s| !s.signal.sweeps.is_empty()) => {
                    let name = d
                        .signals()
                        .find(|s| !s.signal.sweeps.is_empty())
                        .map_or_else(String::new, |s| s.name);
                    none(format!("{name} is a sweep, so the loads have no common period"))
                }
                None if frequencies(d).next().is_some() => {
                    let repeats = d.signals().any(|s| s.signal.repeat.is_some());
                    let what = if repeats {
                        "the periods of harmonics and repeats"
                    } else {
                        "the harmonics' frequencies"
                    };
                    none(format!("{what} have no common period up to 1000 periods of the slowest"))
                }
                None => {
                    let first = sections(d).next().map(|own| own.2);
                    first.map_or_else(|| none("the machine has no harmonics, stops or friction".into()), Ok)
                }
            },
        }
    }

    /// Description of the section: `periods of 0.1 s`, `events of stop.floor`.
    pub fn in_words(&self, d: &Description) -> String {
        match self {
            Self::Period(period) | Self::Shifted(period, _) => {
                format!("periods of {} s", crate::significant(*period))
            }
            Self::Stop(_) | Self::Friction(_) => {
                let own = sections(d).find(|own| own.2 == *self);
                own.map_or_else(String::new, |(kind, name, _)| format!("events of {kind}.{name}"))
            }
        }
    }

    fn is_met(&self, events: &[Event]) -> bool {
        events.iter().any(|event| match (event.kind, self) {
            (EventKind::Impact { stop, .. } | EventKind::Press { stop, .. }, Self::Stop(i)) => stop == *i,
            (EventKind::Stick { friction }, Self::Friction(i)) => friction == *i,
            _ => false,
        })
    }

    fn missed(&self, motion: &Motion) -> Error {
        let d = &motion.assembly().description;
        // The section's own element does not help.
        let others = sections(d).nth(1).is_some();
        let advice = if others { ", or name another stop, contact or friction (--section)" } else { "" };
        let problem = format!(
            "{}: none in the last {WITHIN} s, until t = {:.1} s; the motion has probably come to rest: drive the \
             machine, begin elsewhere (--start){advice}",
            self.in_words(d),
            motion.time()
        );
        Error::Described { problem }
    }

    /// End of the current period; `None` for a section of events.
    fn end(&self, time: f64) -> Option<f64> {
        let (period, shift) = match self {
            Self::Period(period) => (*period, 0.0),
            Self::Shifted(period, shift) => (*period, *shift),
            Self::Stop(_) | Self::Friction(_) => return None,
        };
        Some((((time - shift) / period + COMMENSURATE).floor() + 1.0) * period + shift)
    }

    /// Whether a harmonic of this frequency, Hz, makes a whole number of turns between returns.
    pub(super) fn holds(&self, frequency: f64) -> bool {
        let turns = match self {
            Self::Period(period) | Self::Shifted(period, _) => period * frequency,
            Self::Stop(_) | Self::Friction(_) => return false,
        };
        (turns - turns.round()).abs() <= COMMENSURATE * turns && turns.round() >= 1.0
    }

    /// This section of whole periods, shifted by `BESIDE` periods. `None` for other sections.
    pub(super) fn beside(&self) -> Option<Self> {
        match self {
            Self::Period(period) => Some(Self::Shifted(*period, BESIDE * period)),
            _ => None,
        }
    }

    /// Advances to the next return and reports every event on the way.
    ///
    /// # Errors
    /// As [`Motion::advance_to`]; [`Error::NoSection`] if an element has no event for 100 s.
    pub fn advance(&self, motion: &mut Motion, tell: &mut dyn FnMut(&Event)) -> Result<()> {
        if let Some(end) = self.end(motion.time()) {
            return Ok(motion.advance_observed(end, tell)?);
        }
        let end = motion.time() + WITHIN;
        let mut events = Vec::new();
        loop {
            events.clear();
            let outcome = motion.advance_to_event(end, &mut |event| {
                tell(event);
                events.push(event.clone());
            })?;
            match outcome {
                _ if self.is_met(&events) => return Ok(()),
                Reached::End => return Err(self.missed(motion)),
                Reached::Event => {}
            }
        }
    }

    /// Advances to the next return and passes the flights and events before it to observers.
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    pub fn follow(
        &self,
        motion: &mut Motion,
        flows: &mut Flows,
        observers: &mut [&mut dyn Observer],
    ) -> Result<()> {
        if let Some(end) = self.end(motion.time()) {
            follow(motion, flows, end, observers, &mut |_| false)?;
            return Ok(());
        }
        let end = motion.time() + WITHIN;
        let met = follow(motion, flows, end, observers, &mut |events| self.is_met(events))?;
        if met { Ok(()) } else { Err(self.missed(motion)) }
    }
}

#[cfg(test)]
mod tests;
