//! Diagrams of described machines: local maxima of a quantity, or its values at the section.
//!
//! Time continues from value to value, so that the motion of a prescribed body is continuous. If
//! the drive of the machine does not repeat, each motion would depend on the time at which its
//! value is reached. Such a machine is refused, unless each value [starts
//! anew](DiagramRequest::anew).

use super::{DiagramMachine, DiagramPoint, DiagramRequest};
use crate::class::MotionClass;
use crate::error::{Error, Result};
use crate::flight::Flows;
use crate::settled::{Settled, settled};
use crate::timescales::{runs_on_beyond, settle};
use crate::watch::{Maxima, Watcher};
use crate::{Machine, QuantityName, Section, Start, now};
use serde::{Deserialize, Serialize};
use vibro_machine::Motion;

/// Number of digits kept after the first digit of the largest value of a motion.
const DIGITS: i32 = 6;
/// Largest number of values of a diagram.
pub const MOST_VALUES: usize = 20_000;

/// Motion at one value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DescribedPoint {
    /// The parameter's value.
    pub value: f64,
    /// Maxima, or values at the section, SI, rounded to seven digits of the largest, ascending,
    /// each with its count.
    pub maxima: Vec<(f64, u32)>,
    /// Attractor of the motion.
    pub settled: Settled,
}

impl DiagramPoint for DescribedPoint {
    fn value(&self) -> f64 {
        self.value
    }

    fn maxima(&self) -> &[(f64, u32)] {
        &self.maxima
    }

    fn class(&self) -> MotionClass {
        self.settled.class
    }

    fn contacts(&self) -> f64 {
        self.settled.contacts
    }

    fn differs(&self, other: &Self) -> Option<bool> {
        self.settled.differs(&other.settled)
    }
}

impl DiagramMachine for Machine {
    type Of = QuantityName;
    /// Number of returns for the largest exponent.
    type Exponents = u32;
    type Point = DescribedPoint;
    type Settled = Start;
    type DiagramWorkspace = ();

    /// Error for unknown names, ends out of range, too many values, no kept returns, a missing
    /// section, loads that do not repeat, or a start without a motion.
    fn check_diagram(&self, request: &DiagramRequest<Self>) -> Result<()> {
        request.of.find(&self.description)?;
        for end in [request.axis.from, request.axis.to] {
            at(self, request, end)?;
        }
        if request.axis.count > MOST_VALUES || request.keep == 0 {
            let text = format!("{} values with {} returns kept", request.axis.count, request.keep);
            return Err(Error::Form { text, expected: "up to 20000 values and a return at least" });
        }
        for end in [request.axis.from, request.axis.to] {
            let own = at(self, request, end)?;
            let section = Section::of(&own.description, &own.section)?;
            match runs_on_beyond(&own.description, &section, request.start.time, request.discard) {
                Some(why) if !request.anew => {
                    return Err(Error::Described { problem: runs_on_in_words(&why) });
                }
                _ => {}
            }
        }
        let others = (!request.anew && !request.start.is_own()).then_some(request.axis.to);
        let mut begun = std::iter::once(request.axis.from).chain(others);
        begun.try_for_each(|value| at(self, request, value)?.motion(&request.start).map(drop))
    }

    fn settled_at(
        &self,
        request: &DiagramRequest<Self>,
        value: f64,
        before: Option<&Start>,
    ) -> Result<Option<Start>> {
        Ok(settled_motion(self, request, value, before).ok().map(|motion| now(&motion)))
    }

    fn observe(
        &self,
        request: &DiagramRequest<Self>,
        starts: &[(f64, Option<Start>)],
        (): &mut (),
    ) -> Result<Vec<Option<DescribedPoint>>> {
        let point =
            |(value, start): &(f64, Option<Start>)| observe(self, request, *value, start.as_ref()?).ok();
        Ok(starts.iter().map(point).collect())
    }
}

/// The machine at a value.
fn at(machine: &Machine, request: &DiagramRequest<Machine>, value: f64) -> Result<Machine> {
    machine.with([(request.axis.name.as_str(), value)])
}

/// Message that refuses a chain of values, with the reason.
fn runs_on_in_words(why: &str) -> String {
    format!(
        "{why}, but each value continues the motion of the previous value at a later time; use --anew \
         (anew=True in Python): each value then has the same start, and the diagram does not show \
         hysteresis; or increase --discard until the change lies in the discarded periods of the first value"
    )
}

/// The settled motion at a value. It begins at the state of the previous value or, without one, at
/// the start.
fn settled_motion(
    machine: &Machine,
    request: &DiagramRequest<Machine>,
    value: f64,
    before: Option<&Start>,
) -> Result<Motion> {
    let own = at(machine, request, value)?;
    let (motion, section) = match before {
        Some(end) => own.motion_on(end)?,
        None => own.motion(&request.start)?,
    };
    let mut motion = motion.without_energy_accounts();
    settle(&mut motion, &section, request.discard)?;
    Ok(motion)
}

/// Observes the motion at one value.
///
/// # Errors
/// Error if the motion cannot continue.
fn observe(
    machine: &Machine,
    request: &DiagramRequest<Machine>,
    value: f64,
    end: &Start,
) -> Result<DescribedPoint> {
    let (motion, section) = at(machine, request, value)?.motion_on(end)?;
    let mut motion = motion.without_energy_accounts();
    let mut scout = motion.clone();
    let settled = settled(&mut scout, &section, request.exponents)?;
    // A periodic motion is observed over one period after it has settled.
    let (length, times) = match settled.period {
        Some(n) => {
            motion = scout;
            (n, (request.keep / n).max(1))
        }
        None => (request.keep, 1),
    };
    let mut flows = Flows::default();
    let quantity = request.of.find(&motion.assembly().description)?.quantity;
    let stops = motion.mode().stops.len();
    let mut values = Vec::new();
    let mut watcher = Watcher::of(&[], stops);
    if request.at_section {
        for _ in 0..length {
            section.follow(&mut motion, &mut flows, &mut [])?;
            values.push(flows.value(&motion, quantity));
        }
    } else {
        watcher.maxima = Some(Maxima::new(quantity));
        // The first period shows whether the quantity is rising where the second one begins.
        section.follow(&mut motion, &mut flows, &mut [&mut watcher])?;
        watcher.maxima.iter_mut().for_each(|m| m.found.clear());
        for _ in 0..length {
            section.follow(&mut motion, &mut flows, &mut [&mut watcher])?;
        }
        values = watcher.maxima.map_or(Vec::new(), |m| m.found);
    }
    Ok(DescribedPoint { value, maxima: counted(values, times), settled })
}

/// Values rounded to some digits of the largest, ascending, each with its count.
fn counted(values: Vec<f64>, times: u32) -> Vec<(f64, u32)> {
    let largest = values.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    if largest == 0.0 {
        return if values.is_empty() { Vec::new() } else { vec![(0.0, times * values.len() as u32)] };
    }
    let unit = 10f64.powi(largest.log10().floor() as i32 - DIGITS);
    let mut whole: Vec<i64> = values.iter().map(|x| (x / unit).round() as i64).collect();
    whole.sort_unstable();
    whole.chunk_by(|a, b| a == b).map(|same| (same[0] as f64 * unit, times * same.len() as u32)).collect()
}

/// One direction of a diagram, value by value, so that each value can be shown as soon as it is
/// found. Each item has the index in the axis, the settled state and the point; the last two are
/// missing if the motion cannot continue.
#[derive(Debug)]
pub struct Direction {
    machine: Machine,
    request: DiagramRequest<Machine>,
    upward: bool,
    next: usize,
    before: Option<Start>,
}

impl Direction {
    /// Starts the direction of rising (`upward`) or falling values.
    ///
    /// # Errors
    /// As [`DiagramRequest::check`].
    pub fn new(machine: Machine, request: DiagramRequest<Machine>, upward: bool) -> Result<Self> {
        request.check(&machine)?;
        Ok(Self { machine, request, upward, next: 0, before: None })
    }
}

impl Iterator for Direction {
    type Item = (usize, Option<Start>, Option<DescribedPoint>);

    fn next(&mut self) -> Option<Self::Item> {
        let Self { machine, request, upward, .. } = &*self;
        let count = request.axis.count;
        let i = Some(self.next).filter(|i| *i < count)?;
        let i = if *upward { i } else { count - 1 - i };
        let value = request.axis.value(i);
        let before = self.before.as_ref().filter(|_| !request.anew);
        let motion = settled_motion(machine, request, value, before).ok();
        let start = motion.as_ref().map(now);
        let point = start.as_ref().and_then(|start| observe(machine, request, value, start).ok());
        let own = motion.map(|motion| Start::of(&motion));
        (self.next, self.before) = (self.next + 1, start);
        Some((i, own, point))
    }
}

#[cfg(test)]
mod tests;
