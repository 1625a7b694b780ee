//! Bifurcation diagrams of described machines: local maxima of a quantity, or its values at the
//! section, over one parameter in both directions, with period, class and, on request, the largest
//! exponent.
//!
//! As for the 3-DOF machine, each value starts from the last state of the value before, and the
//! observation at each value is independent of the others. Time continues from value to value, so
//! that a prescribed body is where the others met it. If what drives the machine does not repeat,
//! each motion would depend on when its value is reached: such a machine is refused, unless each
//! value [starts anew](DiagramRequest::anew).

use super::flight::Flows;
use super::settled::{Settled, settled};
use super::timescales::{runs_on_beyond, settle};
use super::watch::{Maxima, Watcher};
use super::{Machine, QuantityName, Section, Start, now};
use crate::axis::ParameterAxis;
use crate::class::MotionClass;
use crate::directions::{self, Diagram, DiagramPoint, chained, in_both_directions};
use crate::error::{Error, Result};
use crate::parts::{PartStore, Task};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use vibro_machine::Motion;

/// Digits by which values are distinguished, relative to the largest of the motion.
const DIGITS: i32 = 6;
/// Most values of a diagram.
pub const MOST_VALUES: usize = 20_000;

/// Request of a bifurcation diagram.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DiagramRequest {
    /// The parameter and its values, SI.
    pub axis: ParameterAxis<String>,
    /// The quantity that is drawn.
    pub of: QuantityName,
    /// Whether its values at the section are drawn, and not its local maxima.
    pub at_section: bool,
    /// Returns discarded at each value; fewer where the motion has settled.
    pub discard: u32,
    /// Returns kept.
    pub keep: u32,
    /// Returns over which the largest exponent is counted, if it is.
    pub exponents: Option<u32>,
    /// Whether each value starts from `start`, which leaves one direction.
    pub anew: bool,
    /// Start at the first value of either direction.
    #[serde(default, skip_serializing_if = "Start::is_own")]
    pub start: Start,
}

/// Motion at one value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AssemblyPoint {
    /// The parameter's value.
    pub value: f64,
    /// Maxima, or values at the section, SI, to seven digits of the largest, ascending, each with
    /// its count.
    pub maxima: Vec<(f64, u32)>,
    /// Attractor of the motion.
    pub settled: Settled,
}

impl DiagramPoint for AssemblyPoint {
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

/// Settled state of the motion at one value; none where the motion cannot go on.
struct SettledStart {
    value: f64,
    start: Option<Start>,
}

impl DiagramRequest {
    /// The machine at a value.
    fn at(&self, machine: &Machine, value: f64) -> Result<Machine> {
        machine.with([(self.axis.name.as_str(), value)])
    }

    /// Checks the properties on which every value depends.
    ///
    /// # Errors
    /// Names that the machine does not have, ends that are not allowed, no section, or no motion
    /// from the start.
    pub fn check(&self, machine: &Machine) -> Result<()> {
        self.of.find(&machine.description)?;
        for end in [self.axis.from, self.axis.to] {
            self.at(machine, end)?;
        }
        if self.axis.count > MOST_VALUES || self.keep == 0 {
            let text = format!("{} values with {} returns kept", self.axis.count, self.keep);
            return Err(Error::Form { text, expected: "up to 20000 values and a return at least" });
        }
        for end in [self.axis.from, self.axis.to] {
            let own = self.at(machine, end)?;
            let section = Section::of(&own.description, &own.section)?;
            match runs_on_beyond(&own.description, &section, self.start.time, self.discard) {
                Some(why) if !self.anew => return Err(Error::Described { problem: runs_on_in_words(&why) }),
                _ => {}
            }
        }
        let others = (!self.anew && !self.start.is_own()).then_some(self.axis.to);
        let mut begun = std::iter::once(self.axis.from).chain(others);
        begun.try_for_each(|value| self.at(machine, value)?.motion(&self.start).map(drop))
    }

    /// Number of parts.
    pub fn count(&self) -> usize {
        directions::parts(self.axis.count)
    }
}

/// Refusal of a chain of values, and its reason.
fn runs_on_in_words(why: &str) -> String {
    format!(
        "{why}: time goes on from value to value, so that each would be seen at another time of it; allowed are changes within what is \
         discarded at the first value (--discard), or --anew (anew=True in Python), with which each value has the same start and nothing is said of \
         hysteresis"
    )
}

fn chain(
    machine: &Machine,
    request: &DiagramRequest,
    store: &dyn PartStore,
    upward: bool,
) -> Result<Vec<SettledStart>> {
    let mut state = None;
    if request.anew {
        let start = |i| SettledStart {
            value: request.axis.value(i),
            start: upward
                .then(|| settled_at(machine, request, request.axis.value(i), None).ok())
                .flatten()
                .map(|motion| now(&motion)),
        };
        return Ok((0..request.axis.count).into_par_iter().map(start).collect());
    }
    chained(request.axis.count, upward, store, &mut |i| {
        let value = request.axis.value(i);
        let start = settled_at(machine, request, value, state.as_ref()).ok().map(|motion| now(&motion));
        state = start.clone();
        Ok(SettledStart { value, start })
    })
}

/// The motion at a value after it has settled; it begins at the state of the value before
/// or, without one, at the start.
fn settled_at(
    machine: &Machine,
    request: &DiagramRequest,
    value: f64,
    before: Option<&Start>,
) -> Result<Motion> {
    let own = request.at(machine, value)?;
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
/// Where the motion cannot go on.
fn observe(machine: &Machine, request: &DiagramRequest, value: f64, end: &Start) -> Result<AssemblyPoint> {
    let (motion, section) = request.at(machine, value)?.motion_on(end)?;
    let mut motion = motion.without_energy_accounts();
    let mut scout = motion.clone();
    let settled = settled(&mut scout, &section, request.exponents)?;
    // A motion with a period is observed over one period after it has settled.
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
        // The first period shows whether the quantity rises where the second begins.
        section.follow(&mut motion, &mut flows, &mut [&mut watcher])?;
        watcher.maxima.iter_mut().for_each(|m| m.found.clear());
        for _ in 0..length {
            section.follow(&mut motion, &mut flows, &mut [&mut watcher])?;
        }
        values = watcher.maxima.map_or(Vec::new(), |m| m.found);
    }
    Ok(AssemblyPoint { value, maxima: counted(values, times), settled })
}

/// Values to some digits of the largest, ascending, each with its count.
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

/// One direction of a diagram, value by value, for one who shows each as soon as it is found. A
/// value is its place in the axis, the state that the motion has settled in, and what is found
/// there; both are missing where the motion cannot go on.
#[derive(Debug)]
pub struct Direction {
    machine: Machine,
    request: DiagramRequest,
    upward: bool,
    next: usize,
    before: Option<Start>,
}

impl Direction {
    /// The direction of rising or of falling values.
    ///
    /// # Errors
    /// As [`DiagramRequest::check`].
    pub fn new(machine: Machine, request: DiagramRequest, upward: bool) -> Result<Self> {
        request.check(&machine)?;
        Ok(Self { machine, request, upward, next: 0, before: None })
    }
}

impl Iterator for Direction {
    type Item = (usize, Option<Start>, Option<AssemblyPoint>);

    fn next(&mut self) -> Option<Self::Item> {
        let Self { machine, request, upward, .. } = &*self;
        let count = request.axis.count;
        let i = Some(self.next).filter(|i| *i < count)?;
        let i = if *upward { i } else { count - 1 - i };
        let value = request.axis.value(i);
        let before = self.before.as_ref().filter(|_| !request.anew);
        let motion = settled_at(machine, request, value, before).ok();
        let start = motion.as_ref().map(now);
        let point = start.as_ref().and_then(|start| observe(machine, request, value, start).ok());
        let own = motion.map(|motion| Start::of(&motion));
        (self.next, self.before) = (self.next + 1, start);
        Some((i, own, point))
    }
}

/// The diagram, on all threads, in parts; `None` where parts belong to other shards. The result
/// depends neither on threads nor on shards.
///
/// # Errors
/// As [`DiagramRequest::check`]; what the parts' folder refuses.
pub fn diagram(
    machine: &Machine,
    request: &DiagramRequest,
    task: &Task,
) -> Result<Option<Diagram<AssemblyPoint>>> {
    request.check(machine)?;
    let points = |_: &mut (), starts: &[SettledStart]| {
        let point = |s: &SettledStart| observe(machine, request, s.value, s.start.as_ref()?).ok();
        Ok(starts.iter().map(point).collect())
    };
    in_both_directions(
        request.axis.count,
        task,
        &|upward| chain(machine, request, task.store, upward),
        &points,
    )
}

#[cfg(test)]
mod tests;
