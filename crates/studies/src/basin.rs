//! Basins of attraction over two numbers of the starts: the attractors that the motions from a
//! plane of starts reach, and the attractors that coexist.

mod described;

pub use described::SettledAttractor;

use crate::axis::{check_cells, parts_of_plane, rows_of_part};
use crate::class::{MotionClass, Relation};
use crate::design_sweep::{DesignMachine, Plain};
use crate::error::{Error, Result};
use crate::parts::Task;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Axis of a plane of starts: a number of a start at the centres of `count` cells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StartAxis {
    /// Name of the number: `time`, `block.s`, `block.v`. For the paper's machine `x1` or `v2`, in
    /// units of L or L ω10.
    pub name: String,
    /// Lower end; in SI except for the paper's machine.
    pub from: f64,
    /// Upper end.
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
#[serde(bound = "")]
pub struct BasinRequest<M: DesignMachine> {
    /// Horizontal axis.
    pub x: StartAxis,
    /// Vertical axis.
    pub y: StartAxis,
    /// Start parameters that are not on an axis.
    pub start: M::Start,
    /// Returns or drive periods discarded before a motion is observed. A motion that is then
    /// undecided is followed further.
    pub discard: u32,
}

/// Destination of the motion from a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum BasinCell {
    /// To the attractor with this number.
    Attractor(u16),
    /// To the mirror image of the attractor with this number.
    Mirror(u16),
    /// Nowhere: the start violates a rigid stop.
    Outside,
    /// The class was not decided.
    NotSettled,
    /// Chaotic or on a torus; the attractor was not decided.
    Undecided,
    /// The motion cannot continue, or never returns to the section.
    Ended,
    /// The motion came to rest and never returns to the section.
    Rest,
}

/// Attractor reached by starts of a plane.
pub trait BasinAttractor: Plain {
    /// Whether shares refer to all starts instead of the starts inside the stops.
    const SHARES_OF_ALL: bool;
    /// Class of the motions.
    fn class(&self) -> MotionClass;
    /// Relation of another attractor to this one.
    fn relation(&self, other: &Self) -> Relation;
    /// Joins the means of another motion on this attractor, or on its mirror image.
    fn pool(&mut self, other: &Self, mirrored: bool);
}

/// Basins over a plane of starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Basins<A> {
    /// The attractors, numbered by their first cell.
    pub attractors: Vec<A>,
    /// Cells, in rows of constant y, beginning with the lowest y.
    pub cells: Vec<BasinCell>,
    /// Reason why the first ended motion ended.
    pub ended: Option<String>,
    /// Range of each body's coordinate over all motions that came to rest; empty if none did.
    pub rest: Vec<[f64; 2]>,
}

impl<A> Default for Basins<A> {
    fn default() -> Self {
        Self { attractors: Vec::new(), cells: Vec::new(), ended: None, rest: Vec::new() }
    }
}

/// Machine whose basins can be studied.
pub trait BasinMachine: DesignMachine {
    /// Attractor of its motions.
    type Attractor: BasinAttractor;
    /// Data that all parts read.
    type Shared: Sync;
    /// Workspace reused for all parts; it does not change results.
    type BasinWorkspace: Default;
    /// Number of motions in a part, rounded up to whole rows.
    const IN_BASIN_PART: usize;

    /// Checks the conditions that all starts share, and prepares the data that all parts read.
    ///
    /// # Errors
    /// Error for starts and names that the machine does not have.
    fn check_basin(&self, request: &BasinRequest<Self>) -> Result<Self::Shared>;

    /// The cells of some rows, with the attractors that they reach.
    ///
    /// # Errors
    /// [`Error::TooManyAttractors`]; errors of the machine, except for single starts.
    fn rows_of_basin(
        &self,
        request: &BasinRequest<Self>,
        rows: Range<usize>,
        with: (&Self::Shared, &mut Self::BasinWorkspace),
    ) -> Result<Basins<Self::Attractor>>;
}

impl<M: BasinMachine> BasinRequest<M> {
    /// Checks the conditions that all starts share, and prepares the data that all parts read.
    ///
    /// # Errors
    /// [`Error::Form`] for two axes of the same number, an empty or infinite range, and no cells;
    /// [`Error::TooMany`]; as [`BasinMachine::check_basin`].
    pub fn check(&self, machine: &M) -> Result<M::Shared> {
        let (x, y) = (&self.x, &self.y);
        if x.name == y.name {
            return Err(Error::Form {
                text: x.name.clone(),
                expected: "two different initial values, e.g. block.s and block.v",
            });
        }
        for axis in [x, y] {
            if !(axis.from < axis.to && (axis.to - axis.from).is_finite() && axis.count > 0) {
                let text = format!("{}={}:{} in {} cells", axis.name, axis.from, axis.to, axis.count);
                return Err(Error::Form { text, expected: "from < to, both finite, and at least 1 cell" });
            }
        }
        // The parts and the whole plane are in memory at the same time.
        check_cells("cells of the plane", (x.count, y.count), 2 * size_of::<BasinCell>())?;
        machine.check_basin(self)
    }

    /// Number of parts, each of one or more whole rows.
    pub fn count(&self) -> usize {
        parts_of_plane((self.x.count, self.y.count), M::IN_BASIN_PART)
    }
}

/// Computes the basins of a machine on all threads. `None` if rows belong to other shards. The
/// result depends neither on threads nor on shards.
///
/// # Errors
/// As [`BasinRequest::check`] and [`BasinMachine::rows_of_basin`].
///
/// # Examples
/// A linear oscillator has one attractor, which all starts reach:
///
/// ```
/// use vibro_studies::basin::{BasinCell, BasinRequest, StartAxis, basins};
/// use vibro_studies::parts::Task;
/// use vibro_studies::{Machine, Start};
///
/// # let text = r#"
/// #     name = "Shaken"
/// #     body.a = { mass = 1.0 }
/// #     spring.k = { between = ["ground", "a"], stiffness = 4.0, damping = 1.25 }
/// #     load.f = { on = "a", amplitude = 26.0, frequency = "2 Hz" }
/// # "#;
/// let machine = Machine::parse(text, "shaken.toml", &vibro_machine::file::no_records)?;
/// let axis = |name: &str| StartAxis { name: name.into(), from: -5.0, to: 5.0, count: 3 };
/// let (x, y) = (axis("a.s"), axis("a.v"));
/// let request = BasinRequest { x, y, start: Start::default(), discard: 100 };
/// let found = basins(&machine, &request, &Task::ALL)?.unwrap();
/// assert_eq!((found.cells.len(), found.attractors.len()), (9, 1));
/// assert_eq!(found.share(BasinCell::Attractor(0)), 1.0);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
pub fn basins<M: BasinMachine>(
    machine: &M,
    request: &BasinRequest<M>,
    task: &Task,
) -> Result<Option<Basins<M::Attractor>>> {
    let shared = request.check(machine)?;
    let part = |workspace: &mut M::BasinWorkspace, part| {
        let rows = rows_of_part((request.x.count, request.y.count), M::IN_BASIN_PART, part);
        machine.rows_of_basin(request, rows, (&shared, workspace))
    };
    let Some(parts) = task.complete_with(request.count(), part)? else { return Ok(None) };
    let mut found = Basins::default();
    parts.into_iter().try_for_each(|part| found.append(part))?;
    Ok(Some(found))
}

impl<A: BasinAttractor> Basins<A> {
    /// Share of the starts with this cell.
    pub fn share(&self, of: BasinCell) -> f64 {
        let count = |sought| self.cells.iter().filter(|cell| **cell == sought).count() as f64;
        let outside = if A::SHARES_OF_ALL { 0.0 } else { count(BasinCell::Outside) };
        count(of) / (self.cells.len() as f64 - outside).max(1.0)
    }

    /// Shares of the starts that lead to an attractor, and to its mirror image.
    pub fn shares(&self, number: u16) -> [f64; 2] {
        [BasinCell::Attractor(number), BasinCell::Mirror(number)].map(|cell| self.share(cell))
    }

    /// Returns the cell of a motion that reaches the attractor `found`. If the attractor is known,
    /// it pools the means of both; otherwise `found` is added. `None` if the relation to a known
    /// attractor is undecided, or if the attractor is new and `sure` is false.
    pub(crate) fn reached(&mut self, found: A, sure: bool) -> Result<Option<BasinCell>> {
        let mut undecided = false;
        // Attractor numbers cannot exceed `u16::MAX`.
        for (known, number) in self.attractors.iter_mut().zip(0..=u16::MAX) {
            let (cell, mirrored) = match known.relation(&found) {
                Relation::Same => (BasinCell::Attractor(number), false),
                Relation::Mirror => (BasinCell::Mirror(number), true),
                Relation::Different => continue,
                Relation::Undecided => {
                    undecided = true;
                    continue;
                }
            };
            known.pool(&found, mirrored);
            return Ok(Some(cell));
        }
        if undecided || !sure { Ok(None) } else { self.add(found).map(Some) }
    }

    pub(crate) fn add(&mut self, found: A) -> Result<BasinCell> {
        let Ok(number) = u16::try_from(self.attractors.len()) else {
            return Err(Error::TooManyAttractors { most: self.attractors.len() });
        };
        self.attractors.push(found);
        Ok(BasinCell::Attractor(number))
    }

    /// Appends the cells of further rows, whose attractors are numbered separately.
    ///
    /// # Errors
    /// [`Error::TooManyAttractors`].
    pub(crate) fn append(&mut self, rows: Self) -> Result<()> {
        let known = rows.attractors.into_iter().map(|found| self.reached(found, true));
        let known: Vec<Option<BasinCell>> = known.collect::<Result<_>>()?;
        let number = |number: u16| known[usize::from(number)].unwrap_or(BasinCell::Undecided);
        self.cells.extend(rows.cells.into_iter().map(|cell| match cell {
            BasinCell::Attractor(own) => number(own),
            BasinCell::Mirror(own) => number(own).mirrored(),
            other => other,
        }));
        self.ended = self.ended.take().or(rows.ended);
        self.widen(rows.rest);
        Ok(())
    }

    /// Widens the range of rest positions.
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

impl BasinCell {
    /// Cell of the mirror image of a motion.
    fn mirrored(self) -> Self {
        match self {
            Self::Attractor(number) => Self::Mirror(number),
            Self::Mirror(number) => Self::Attractor(number),
            other => other,
        }
    }
}
