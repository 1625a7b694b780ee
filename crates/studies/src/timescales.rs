//! Necessary time of observation: after the last change of the signals, for several periods of the
//! machine's slowest natural oscillation.

use super::oscillations::oscillations;
use super::section::Section;
use super::settled::discard;
use crate::error::{Error, Result};
use crate::significant;
use vibro_machine::Motion;
use vibro_machine::description::Description;
use vibro_machine::elements::NamedSignal;

/// Smallest length of a window, and of the discarded time before it, in periods of the slowest
/// natural oscillation.
const SLOWEST: f64 = 4.0;
/// Cap on the growth of a requested window.
const MOST: f64 = 100.0;
/// Smallest number of events in a window.
const EVENTS: u32 = 8;
/// Cap on the prolongation of a window that contains fewer than [`EVENTS`] events.
const TIMES: u32 = 10;

/// Period of the slowest natural oscillation, s; 0 without one.
fn slowest(motion: &Motion) -> f64 {
    oscillations(motion.assembly().system()).into_iter().map(|f| 1.0 / f).fold(0.0, f64::max)
}

/// Smallest length of a window, s.
///
/// # Errors
/// [`Error::Described`] if it is more than a hundred times the requested length.
pub(super) fn needed(motion: &Motion, section: &Section, periods: u32) -> Result<f64> {
    let slowest = slowest(motion);
    is_allowed(section, periods, slowest, "measured, --periods")?;
    Ok(SLOWEST * slowest)
}

/// Refuses a number of periods if the slowest natural oscillation needs more than a hundred times
/// this number.
fn is_allowed(section: &Section, periods: u32, slowest: f64, option: &str) -> Result<()> {
    match section {
        Section::Period(period) | Section::Shifted(period, _)
            if SLOWEST * slowest > MOST * f64::from(periods) * period =>
        {
            Err(too_short(f64::from(periods) * period, periods, slowest, option))
        }
        _ => Ok(()),
    }
}

fn too_short(time: f64, periods: u32, slowest: f64, option: &str) -> Error {
    let least = (SLOWEST * slowest / (time / f64::from(periods))).ceil();
    Error::Described {
        problem: format!(
            "{periods} periods ({option}) last {} s, but must last at least {SLOWEST} periods of \
             the machine's slowest natural oscillation, {} s each; use at least {least} periods or \
             a longer --period",
            significant(time),
            significant(slowest)
        ),
    }
}

/// Progress of a window.
pub(super) struct Passed {
    begin: f64,
    needed: f64,
    periods: u32,
    returns: u32,
    events: u32,
}

impl Passed {
    /// Begins a window at the present time, over at least a time and a number of returns.
    pub fn new(motion: &Motion, needed: f64, periods: u32) -> Self {
        Self { begin: motion.time(), needed, periods, returns: 0, events: 0 }
    }

    /// Counts a return with its events; returns whether the window is long enough.
    ///
    /// # Errors
    /// [`Error::Described`] if the window would be more than a hundred times the requested one.
    pub fn is_enough(&mut self, motion: &Motion, (events, repeats): (u32, bool)) -> Result<bool> {
        self.returns += 1;
        self.events = self.events.saturating_add(events);
        let time = motion.time() - self.begin;
        if repeats && SLOWEST * time >= self.needed {
            return Ok(true);
        }
        if self.returns < self.periods {
            return Ok(false);
        }
        if time < self.needed {
            let is_too_long = f64::from(self.returns) >= MOST * f64::from(self.periods);
            let problem = || too_short(time, self.returns, self.needed / SLOWEST, "measured, --periods");
            return if is_too_long { Err(problem()) } else { Ok(false) };
        }
        let is_rare = (1..EVENTS).contains(&self.events);
        Ok(!is_rare || self.returns >= self.periods.saturating_mul(TIMES))
    }
}

/// The last step, end of a sweep or end of a record of all signals: its time, s, and its
/// description. Steps and records of repeated signals do not count. `None` without such a change.
fn last_change(d: &Description) -> Option<(f64, String)> {
    let of = |NamedSignal { name, signal, .. }: NamedSignal| {
        let ends = signal.sweeps.iter().map(|sweep| sweep.duration).reduce(f64::max);
        let sweep = ends.map(|end| (end, format!("{name} is a sweep up to {} s", significant(end))));
        if signal.repeat.is_some() {
            return [sweep, None, None];
        }
        let step =
            signal.steps.last().map(|s| (s.time, format!("{name} has a step at {} s", significant(s.time))));
        let end = signal.table.as_ref().and_then(|table| table.knots.last()).map(|k| k.0);
        let record = end.map(|end| (end, format!("{name} is a record up to {} s", significant(end))));
        [sweep, step, record]
    };
    d.signals().flat_map(of).flatten().reduce(|a, b| if b.0 > a.0 { b } else { a })
}

/// Description of the last change of a signal if it comes after `time`, s. `None` if all signals
/// are periodic or constant after `time`.
///
/// ```
/// use vibro_machine::file::{no_records, parse};
/// use vibro_studies::runs_on;
///
/// let text = r#"
///     name = "Pushed"
///     body.a = { mass = 1.0 }
///     load.push = { on = "a", steps = [["0.5 s", "2 N"], ["1.5 s", "-2 N"]] }
/// "#;
/// let machine = parse(text, "pushed.toml", &no_records)?;
/// assert_eq!(runs_on(&machine, 1.0).as_deref(), Some("load.push has a step at 1.5 s"));
/// assert_eq!(runs_on(&machine, 2.0), None);
/// # Ok::<(), vibro_machine::Refusal>(())
/// ```
pub fn runs_on(d: &Description, time: f64) -> Option<String> {
    last_change(d).filter(|(end, _)| *end > time).map(|(_, words)| words)
}

/// Description of the last change of a signal if it comes after `discard` returns from a start at
/// the time `begin`, s. If the section is at events, the time of these returns is not known in
/// advance, and a change at any time counts.
pub(super) fn runs_on_beyond(d: &Description, section: &Section, begin: f64, discard: u32) -> Option<String> {
    match section {
        Section::Period(period) | Section::Shifted(period, _) => {
            runs_on(d, begin + f64::from(discard) * period)
        }
        Section::Stop(_) | Section::Friction(_) => runs_on(d, begin),
    }
}

/// Discards the transient. First the motion advances past the last change of a signal, for at most
/// `returns` returns; if the change comes later, the function returns. Then the motion advances
/// until it has settled, again for at most `returns` returns. If four periods of the slowest
/// natural oscillation have not passed since the change, it advances over them and settles once
/// more.
///
/// # Errors
/// As [`Section::advance`]; [`Error::Described`] if these four periods are more than a hundred
/// times the requested time.
///
/// # Examples
/// ```
/// use vibro_studies::{Machine, MotionClass, Start, settle, settled};
///
/// let text = r#"
///     name = "Shaken"
///     body.a = { mass = 1.0 }
///     spring.k = { between = ["ground", "a"], stiffness = 4.0, damping = 1.25 }
///     load.f = { on = "a", amplitude = 26.0, frequency = "2 Hz" }
/// "#;
/// let machine = Machine::parse(text, "shaken.toml", &vibro_machine::file::no_records)?;
/// let (mut motion, section) = machine.motion(&Start::default())?;
/// settle(&mut motion, &section, 100)?;
/// let found = settled(&mut motion, &section, None)?;
/// assert_eq!((found.class, found.contacts), (MotionClass::Periodic(1), 0.0));
/// assert!((found.interval - 0.5).abs() < 1e-12);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
pub fn settle(motion: &mut Motion, section: &Section, returns: u32) -> Result<()> {
    let begin = motion.time();
    let end = last_change(&motion.assembly().description).map_or(begin, |(time, _)| time);
    let mut passed = 0;
    while motion.time() < end && passed < returns {
        section.advance(motion, &mut |_| ())?;
        passed += 1;
    }
    if motion.time() < end || returns == 0 {
        return Ok(());
    }
    let slowest = slowest(motion);
    is_allowed(section, returns, slowest, "discarded, --discard")?;
    let (begin, most) = (motion.time(), (MOST * f64::from(returns)) as u64);
    discard(motion, section, returns)?;
    if motion.time() - begin >= SLOWEST * slowest {
        return Ok(());
    }
    for _ in 0..most {
        if motion.time() - begin >= SLOWEST * slowest {
            break;
        }
        section.advance(motion, &mut |_| ())?;
    }
    discard(motion, section, returns)
}

#[cfg(test)]
mod tests;
