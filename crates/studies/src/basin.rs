//! Basins of attraction of described machines: where the motions from a plane of starts settle, and
//! on which attractors.
//!
//! Attractors with a period are told apart by their class, their period and their states at the
//! section, as in a [diagram](super::diagram). Of two motions without a period nothing decides
//! whether they are one attractor: all of one class count as one. Places of rest are not numbered:
//! friction may hold a body anywhere in a range.

use super::timescales::{runs_on, runs_on_beyond, settle};
use super::{Machine, Section, Settled, settled};
use crate::axis::check_cells;
use crate::error::{Error, Result};
use crate::parts::Task;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use vibro_machine::{Assembly, Error as MotionError, Motion, Start};

/// Motions of a part, rounded up to whole rows.
const MOTIONS: usize = 32;
/// Most attractors that are numbered.
const MOST: usize = u16::MAX as usize;

/// Axis of a plane of starts: a number of a start at the centres of `count` cells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartAxis {
    /// The number's name: `time`, `block.s`, `block.v`.
    pub name: String,
    /// Lower end, SI.
    pub from: f64,
    /// Upper end, SI.
    pub to: f64,
    /// Number of cells.
    pub count: usize,
}

impl StartAxis {
    /// The value at the centre of cell `i`.
    pub fn value(&self, i: usize) -> f64 {
        self.from + (self.to - self.from) * (i as f64 + 0.5) / self.count as f64
    }
}

/// Request of a study of basins.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BasinRequest {
    /// Horizontal axis.
    pub x: StartAxis,
    /// Vertical axis.
    pub y: StartAxis,
    /// The numbers of the starts that are on no axis.
    pub start: Start,
    /// Returns discarded; fewer where the motion has settled.
    pub discard: u32,
}

/// Where the motion from a start leads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum BasinCell {
    /// To the attractor of this number.
    Attractor(u16),
    /// Nowhere: the start violates a rigid stop.
    Outside,
    /// The class was not decided.
    NotSettled,
    /// The motion cannot go on, or never returns to the section.
    Ended,
    /// The motion came to rest, from where it never returns to the section.
    Rest,
}

/// An attractor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BasinAttractor {
    /// Class, period, contacts.
    pub settled: Settled,
    /// A start on it, or near it where it has no period.
    pub start: Start,
}

/// Basins over a plane of starts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Basins {
    /// The attractors, in the order in which the cells meet them.
    pub attractors: Vec<BasinAttractor>,
    /// Cells, row by row of constant y from the lowest.
    pub cells: Vec<BasinCell>,
    /// Why the first motion that ended did.
    pub ended: Option<String>,
    /// Least and largest coordinate of each body over all motions that came to rest; empty where
    /// none did.
    pub rest: Vec<[f64; 2]>,
}

/// Where a motion led.
enum Led {
    Attractor(BasinAttractor),
    /// Coordinates of the bodies at rest.
    Rest(Vec<f64>),
}

/// Largest way, relative to the way from the start, that a body at rest goes in the time for which
/// a return was awaited.
const AT_REST: f64 = 1e-9;

impl BasinRequest {
    /// Checks what every start depends on.
    ///
    /// # Errors
    /// [`Error::Refusal`] for an unknown name and for a body whose coordinate follows from others;
    /// [`Error::Form`] for two axes of one number, a range that is empty or not finite, and no
    /// cells; [`Error::TooMany`]; [`Error::Described`] for a machine without a section, and for one
    /// that does not repeat after the discarded returns.
    pub fn check(&self, machine: &Machine) -> Result<()> {
        let (x, y) = (&self.x, &self.y);
        if x.name == y.name {
            return Err(Error::Form {
                text: x.name.clone(),
                expected: "two different numbers of a start, e.g. block.s and block.v",
            });
        }
        for axis in [x, y] {
            if !(axis.from < axis.to && (axis.to - axis.from).is_finite() && axis.count > 0) {
                let text = format!("{}={}:{} in {} cells", axis.name, axis.from, axis.to, axis.count);
                return Err(Error::Form { text, expected: "from < to, both finite, and at least 1 cell" });
            }
        }
        check_cells("cells of the plane", (x.count, y.count), 2 * size_of::<BasinCell>())?;
        let assembly = Assembly::new(machine.description.clone())?;
        for (i, j) in [(0, 0), (x.count - 1, y.count - 1)] {
            self.at(machine, i, j)?.state(&assembly)?;
        }
        let section = Section::of(&machine.description, &machine.section)?;
        match runs_on_beyond(&machine.description, &section, self.start.time, self.discard) {
            None => Ok(()),
            Some(why) => Err(Error::Described {
                problem: format!(
                    "{why}: only what repeats has attractors; allowed are changes within what is discarded (--discard)"
                ),
            }),
        }
    }

    /// Number of parts.
    pub fn count(&self) -> usize {
        self.y.count.div_ceil(self.rows_of_part())
    }

    fn rows_of_part(&self) -> usize {
        MOTIONS.div_ceil(self.x.count.max(1))
    }

    /// The start of a cell.
    fn at(&self, machine: &Machine, i: usize, j: usize) -> Result<Start> {
        let mut start = self.start.clone();
        start.set(&machine.description, &self.x.name, self.x.value(i))?;
        start.set(&machine.description, &self.y.name, self.y.value(j))?;
        Ok(start)
    }
}

/// The basins of a machine, on all threads; `None` where rows belong to other shards. The result
/// depends neither on threads nor on shards.
///
/// # Errors
/// As [`BasinRequest::check`]; [`Error::TooManyAttractors`].
pub fn basins(machine: &Machine, request: &BasinRequest, task: &Task) -> Result<Option<Basins>> {
    request.check(machine)?;
    let assembly = Arc::new(Assembly::new(machine.description.clone())?);
    let section = Section::of(&machine.description, &machine.section)?;
    let rows = request.rows_of_part();
    let part = |part: usize| -> Result<Basins> {
        let mut found = Basins::default();
        for j in part * rows..((part + 1) * rows).min(request.y.count) {
            for i in 0..request.x.count {
                let start = request.at(machine, i, j)?;
                let led = motion(&assembly, &section, &start, request.discard);
                let cell = found.cell(led)?;
                found.cells.push(cell);
            }
        }
        Ok(found)
    };
    let Some(parts) = task.complete(request.count(), part)? else { return Ok(None) };
    let mut found = Basins::default();
    for part in parts {
        found.append(part)?;
    }
    Ok(Some(found))
}

/// Attractor of the motion from a start with its state then, or its place of rest.
fn motion(assembly: &Arc<Assembly>, section: &Section, start: &Start, discard: u32) -> Result<Led> {
    let mut motion = start.motion(assembly.clone())?.without_energy_accounts();
    let begin = (motion.time(), states(&motion));
    match settle(&mut motion, section, discard).and_then(|()| settled(&mut motion, section, None)) {
        Ok(settled) => Ok(Led::Attractor(BasinAttractor { settled, start: Start::of(&motion) })),
        Err(_) if is_at_rest(&motion, begin) => {
            Ok(Led::Rest(states(&motion).into_iter().map(|[s, ..]| s).collect()))
        }
        Err(error) => Err(error),
    }
}

/// Coordinates, rates and accelerations of all bodies.
fn states(motion: &Motion) -> Vec<[f64; 3]> {
    (0..motion.assembly().description.bodies.len()).map(|i| motion.body(i)).collect()
}

/// Whether all bodies stay where they are, by their states when the motion began.
fn is_at_rest(motion: &Motion, (time, begin): (f64, Vec<[f64; 3]>)) -> bool {
    let passed = motion.time() - time;
    let now = states(motion);
    let way = now.iter().zip(&begin).map(|(now, begin)| (now[0] - begin[0]).abs()).fold(0.0, f64::max);
    // An acceleration at rest is rounding of forces, and its way over this time is not.
    let is_steady = |[_, v, _]: &[f64; 3]| (v * passed).abs() <= AT_REST * way;
    let is_over = runs_on(&motion.assembly().description, motion.time()).is_none();
    passed > 0.0 && is_over && now.iter().all(is_steady)
}

impl BasinAttractor {
    /// Whether two motions count as one attractor.
    fn is_same(&self, other: &Self) -> bool {
        let (a, b) = (&self.settled, &other.settled);
        match a.differs(b) {
            Some(differs) => !differs,
            // Without a period, or with states taken at different phases.
            None => a.class == b.class && (a.period.is_none() || a.contacts == b.contacts),
        }
    }
}

impl Basins {
    /// Share of the cells that lead to a cell's kind.
    pub fn share(&self, of: BasinCell) -> f64 {
        let count = self.cells.iter().filter(|cell| **cell == of).count();
        count as f64 / self.cells.len().max(1) as f64
    }

    fn cell(&mut self, led: Result<Led>) -> Result<BasinCell> {
        match led {
            Ok(Led::Attractor(found)) if !found.settled.class.is_decided() => Ok(BasinCell::NotSettled),
            Ok(Led::Attractor(found)) => Ok(BasinCell::Attractor(self.number(found)?)),
            Ok(Led::Rest(places)) => {
                self.widen(places.into_iter().map(|s| [s, s]).collect());
                Ok(BasinCell::Rest)
            }
            Err(Error::Assembly(MotionError::Refused(_)) | Error::Refusal(_)) => Ok(BasinCell::Outside),
            Err(error) => {
                self.ended.get_or_insert_with(|| error.to_string());
                Ok(BasinCell::Ended)
            }
        }
    }

    /// The number of an attractor, which is added where it is new.
    fn number(&mut self, found: BasinAttractor) -> Result<u16> {
        if let Some(known) = self.attractors.iter().position(|own| own.is_same(&found)) {
            return Ok(known as u16);
        }
        if self.attractors.len() > MOST {
            return Err(Error::TooManyAttractors { most: MOST + 1 });
        }
        self.attractors.push(found);
        Ok((self.attractors.len() - 1) as u16)
    }

    /// Adds the cells of the next rows.
    fn append(&mut self, part: Self) -> Result<()> {
        let numbers: Vec<u16> =
            part.attractors.into_iter().map(|found| self.number(found)).collect::<Result<_>>()?;
        let own = |cell: BasinCell| match cell {
            BasinCell::Attractor(number) => BasinCell::Attractor(numbers[usize::from(number)]),
            other => other,
        };
        self.cells.extend(part.cells.into_iter().map(own));
        self.ended = self.ended.take().or(part.ended);
        self.widen(part.rest);
        Ok(())
    }

    /// Takes places of rest into the range of all.
    fn widen(&mut self, places: Vec<[f64; 2]>) {
        if self.rest.is_empty() {
            self.rest = places;
            return;
        }
        for (own, [least, largest]) in self.rest.iter_mut().zip(places) {
            *own = [own[0].min(least), own[1].max(largest)];
        }
    }
}
