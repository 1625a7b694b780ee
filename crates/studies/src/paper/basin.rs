//! Basins of attraction over two initial values, and the attractors that coexist.

use super::attractor::{Attractor, MotionClass, Relation};
use super::start::{Coordinate, SI_COORDINATES, StartRule, coordinate, coordinate_value};
use super::stroboscopic::{COORDINATES, dimensional};
use super::trajectories::{MOTIONS, Start, Workspace};
use super::verdict::{Followed, Following, follow};
use crate::axis::check_cells;
use crate::error::{Error, Result};
use crate::parts::Task;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use vibro_impact::State;
use vibro_impact::parameters::Parameters;

/// Range of an initial value, with finite ends and the lower one first; parsed from `name=from:to`.
///
/// ```
/// use vibro_studies::paper::basin::InitialValueRange;
///
/// let range: InitialValueRange = "v2=-2:2".parse()?;
/// assert_eq!(range.cells(4).value(0), -1.5);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialValueRange {
    coordinate: usize,
    from: f64,
    to: f64,
    /// Whether the ends are in m or m/s instead of L or L ω10.
    si: bool,
}

impl InitialValueRange {
    /// The range in units of L or L ω10 of a machine.
    ///
    /// # Errors
    /// [`vibro_impact::Error::Undefined`] for a range of a speed in SI without a spring between box
    /// and ground, since ω10 is zero.
    pub fn scaled(self, p: &Parameters) -> Result<Self> {
        if !self.si {
            return Ok(self);
        }
        let unit = if self.coordinate < 3 { p.stop_gap } else { p.stop_gap * p.box_frequency() };
        if unit == 0.0 {
            let needed_by = "unit of speed L omega10";
            let (name, value, allowed) = ("box.k", p.box_stiffness, "box.k > 0");
            return Err(vibro_impact::Error::Undefined { name, value, needed_by, allowed }.into());
        }
        Ok(Self { from: self.from / unit, to: self.to / unit, si: false, ..self })
    }

    /// The range, [scaled](Self::scaled), divided into `count` cells, at least one.
    pub fn cells(self, count: usize) -> InitialValueAxis {
        let Self { coordinate, from, to, .. } = self;
        InitialValueAxis { coordinate, from, to, count: count.max(1) }
    }
}

impl std::str::FromStr for InitialValueRange {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let form = || Error::Form {
            text: text.into(),
            expected: "name=from:to with from < to and a name of x1 x2 x3 v1 v2 v3, e.g. v2=-2:2, or in SI of box.s block.s \
                       secondary.s box.v block.v secondary.v, e.g. block.s=-20mm:20mm",
        };
        let (name, ends) = text.split_once('=').ok_or_else(form)?;
        let found = coordinate(name).ok_or_else(form)?;
        let (from, to) = ends.split_once(':').ok_or_else(form)?;
        let (from, to, si) = match (coordinate_value(found, from), coordinate_value(found, to)) {
            (Some(Coordinate::Scaled(from)), Some(Coordinate::Scaled(to))) => (from, to, false),
            (Some(Coordinate::Si(from)), Some(Coordinate::Si(to))) => (from, to, true),
            _ => return Err(form()),
        };
        if from < to { Ok(Self { coordinate: found.0, from, to, si }) } else { Err(form()) }
    }
}

impl std::fmt::Display for InitialValueRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names = if self.si { SI_COORDINATES } else { COORDINATES };
        write!(f, "{}={}:{}", names[self.coordinate], self.from, self.to)
    }
}

/// Axis of a plane of starts: an initial value at the centres of `count` cells between `from` and
/// `to`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InitialValueAxis {
    /// Index into [`COORDINATES`].
    pub coordinate: usize,
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Number of cells.
    pub count: usize,
}

impl InitialValueAxis {
    /// The value at the centre of cell `i`.
    pub fn value(&self, i: usize) -> f64 {
        self.from + (self.to - self.from) * (i as f64 + 0.5) / self.count as f64
    }
}

/// Request of a study of basins.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BasinRequest {
    /// Horizontal axis.
    pub x: InitialValueAxis,
    /// Vertical axis.
    pub y: InitialValueAxis,
    /// Drive periods discarded before a motion is observed; one that is then undecided is followed
    /// further.
    pub discard: u32,
    /// Initial values that are on no axis.
    #[serde(default = "in_the_middle")]
    pub start: StartRule,
}

/// The start with all initial values zero.
pub fn in_the_middle() -> StartRule {
    StartRule::scaled([0.0; 6])
}

/// Destination of the motion from a start.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Destination {
    /// The attractor of this number.
    Attractor(u16),
    /// The mirror image of the attractor of this number.
    Mirror(u16),
    /// There is no motion: the start is outside the stops.
    Outside,
    /// The class was not decided up to the [limit](crate::paper::verdict::PROLONGED).
    NotSettled,
    /// Chaotic or on a torus; on which of the known attractors was not decided up to the limit.
    Undecided,
}

/// Attractor reached from starts of a plane.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BasinAttractor {
    /// The attractor. Without a period its means are those of all motions on it.
    pub attractor: Attractor,
    /// Class of the motions.
    pub class: MotionClass,
}

/// A plane of starts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Basin {
    /// Attractors in the order in which the cells reach them.
    pub attractors: Vec<BasinAttractor>,
    /// Destinations, row by row of constant y from the lowest.
    pub cells: Vec<Destination>,
}

impl Basin {
    /// Shares of the starts inside the stops that lead to an attractor, and to its mirror image.
    pub fn shares(&self, number: u16) -> [f64; 2] {
        [Destination::Attractor(number), Destination::Mirror(number)]
            .map(|destination| self.share(destination))
    }

    /// Share of the starts inside the stops with a destination.
    pub fn share(&self, destination: Destination) -> f64 {
        let count = |sought| self.cells.iter().filter(|cell| **cell == sought).count() as f64;
        count(destination) / (self.cells.len() as f64 - count(Destination::Outside)).max(1.0)
    }
}

/// The start at the centre of a cell: the request's start with the scaled values of the axes.
fn cell_start(p: &Parameters, request: &BasinRequest, first: &State, column: usize, row: usize) -> State {
    let mut s = *first;
    for (axis, i) in [(&request.x, column), (&request.y, row)] {
        let (mut scaled, k) = ([0.0; 6], axis.coordinate);
        scaled[k] = axis.value(i);
        let own = dimensional(p, &scaled);
        if k < 3 { s.x[k] = own.x[k] } else { s.v[k - 3] = own.v[k - 3] }
    }
    s
}

/// Rows of the plane in a part.
fn rows(request: &BasinRequest, part: usize) -> Range<usize> {
    let rows = MOTIONS.div_ceil(request.x.count.max(1));
    part * rows..((part + 1) * rows).min(request.y.count)
}

/// Number of parts, each of one or more whole rows.
pub fn count(request: &BasinRequest) -> usize {
    request.y.count.div_ceil(MOTIONS.div_ceil(request.x.count.max(1)))
}

/// The basins, on all threads; `None` where rows belong to other shards. The result depends neither
/// on threads nor on shards.
///
/// # Errors
/// [`Error::Form`] for two axes of one coordinate, a range that is empty or not finite, and no
/// cells; [`Error::TooMany`] for a plane that does not fit into memory;
/// [`Error::TooManyAttractors`] for more than can be numbered; what the simulator refuses, except
/// for starts outside the stops.
pub fn basin(p: &Parameters, request: &BasinRequest, task: &Task) -> Result<Option<Basin>> {
    let BasinRequest { x, y, .. } = request;
    if x.coordinate == y.coordinate {
        let text = COORDINATES[x.coordinate].into();
        return Err(Error::Form { text, expected: "two different initial values, e.g. v2 and x1" });
    }
    for axis in [x, y] {
        if !(axis.from < axis.to && (axis.to - axis.from).is_finite() && axis.count > 0) {
            let text =
                format!("{}={}:{} in {} cells", COORDINATES[axis.coordinate], axis.from, axis.to, axis.count);
            return Err(Error::Form { text, expected: "from < to, both finite, and at least 1 cell" });
        }
    }
    // The parts are put together beside the whole plane.
    check_cells("cells of the plane", (x.count, y.count), 2 * size_of::<Destination>())?;
    let part = |workspace: &mut Workspace, part| cells(p, request, rows(request, part), workspace);
    let Some(parts) = task.complete_with(count(request), part)? else { return Ok(None) };
    let mut found = Basin::default();
    parts.iter().try_for_each(|part| found.append(part))?;
    Ok(Some(found))
}

/// The cells of some rows, with their attractors. One machine has one set of tables.
fn cells(
    p: &Parameters,
    request: &BasinRequest,
    rows: Range<usize>,
    workspace: &mut Workspace,
) -> Result<Basin> {
    let first = request.start.state(p)?;
    let places = rows.flat_map(|j| (0..request.x.count).map(move |i| (i, j)));
    let starts: Vec<Start> =
        places.map(|(i, j)| Start { parameters: *p, state: cell_start(p, request, &first, i, j) }).collect();
    let following = Following { discard: request.discard, ..Following::default() };
    let mut found = Basin { cells: vec![Destination::NotSettled; starts.len()], ..Basin::default() };
    let mut refused = Ok(());
    follow(workspace, &starts, &following, &mut |number, motion, last| {
        let decided = match motion {
            Ok(motion) => found.decide(number, motion, last),
            Err(Error::Model(vibro_impact::Error::Penetration { .. })) => {
                found.cells[number] = Destination::Outside;
                Ok(true)
            }
            Err(other) => Err(other),
        };
        decided.unwrap_or_else(|error| {
            refused = Err(error);
            true
        })
    });
    refused.map(|()| found.in_order_of_cells())
}

impl Basin {
    /// Records the destination of a cell's motion; returns whether it is decided. Chaos, and an
    /// attractor that is not known well enough, are decided only at the `last` look.
    fn decide(&mut self, number: usize, motion: &Followed, last: bool) -> Result<bool> {
        // Chaos beside periodic motions is often a long transient: it counts as an attractor only
        // at the limit.
        let open = motion.wanders() && !last;
        let destination = if open { None } else { self.destination(motion)? };
        if let Some(destination) = destination {
            self.cells[number] = destination;
        } else if last && motion.wanders() && motion.stationary {
            self.cells[number] = Destination::Undecided;
        }
        Ok(destination.is_some())
    }

    /// Destination of a motion on a known attractor or a new one; `None` where that is undecided.
    fn destination(&mut self, motion: &Followed) -> Result<Option<Destination>> {
        if !motion.class.is_decided() {
            return Ok(None);
        }
        let found = BasinAttractor { attractor: motion.attractor.clone(), class: motion.class };
        Ok(match self.known(&found) {
            Known::As(destination) => {
                let known = match destination {
                    Destination::Attractor(number) | Destination::Mirror(number) => Some(number),
                    _ => None,
                };
                if let Some(known) = known.and_then(|number| self.attractors.get_mut(usize::from(number))) {
                    known.attractor.pool(&found.attractor, destination.is_mirror());
                }
                Some(destination)
            }
            Known::Undecided => None,
            // The means of a single motion make an attractor once they are known well enough.
            Known::Not if found.attractor.period.is_none() && !motion.stationary => None,
            Known::Not => Some(self.add(found)?),
        })
    }

    fn add(&mut self, found: BasinAttractor) -> Result<Destination> {
        let Ok(number) = u16::try_from(self.attractors.len()) else {
            return Err(Error::TooManyAttractors { most: self.attractors.len() });
        };
        self.attractors.push(found);
        Ok(Destination::Attractor(number))
    }

    /// Whether an attractor is among the known ones.
    fn known(&self, found: &BasinAttractor) -> Known {
        let mut undecided = false;
        // All numbers that attractors can have.
        for (known, number) in self.attractors.iter().zip(0..=u16::MAX) {
            match known.attractor.relation(&found.attractor) {
                Relation::Same => return Known::As(Destination::Attractor(number)),
                Relation::Mirror => return Known::As(Destination::Mirror(number)),
                Relation::Different => {}
                Relation::Undecided => undecided = true,
            }
        }
        if undecided { Known::Undecided } else { Known::Not }
    }

    /// This basin with its attractors in the order in which the cells reach them, instead of the
    /// order in which they were decided.
    fn in_order_of_cells(self) -> Self {
        let mut order: Vec<u16> = Vec::new();
        for cell in &self.cells {
            if let Destination::Attractor(number) | Destination::Mirror(number) = cell
                && !order.contains(number)
            {
                order.push(*number);
            }
        }
        let place = |number: u16| order.iter().position(|n| *n == number).unwrap_or_default() as u16;
        let cell = |cell: &Destination| match *cell {
            Destination::Attractor(number) => Destination::Attractor(place(number)),
            Destination::Mirror(number) => Destination::Mirror(place(number)),
            other => other,
        };
        let attractors = order.iter().map(|n| self.attractors[usize::from(*n)].clone()).collect();
        Self { cells: self.cells.iter().map(cell).collect(), attractors }
    }

    /// Appends the cells of further rows, whose attractors have numbers of their own.
    ///
    /// # Errors
    /// [`Error::TooManyAttractors`].
    fn append(&mut self, rows: &Self) -> Result<()> {
        let mut known = Vec::with_capacity(rows.attractors.len());
        for found in &rows.attractors {
            known.push(match self.known(found) {
                Known::As(destination) => {
                    if let Destination::Attractor(number) | Destination::Mirror(number) = destination {
                        self.attractors[usize::from(number)]
                            .attractor
                            .pool(&found.attractor, destination.is_mirror());
                    }
                    destination
                }
                Known::Undecided => Destination::Undecided,
                Known::Not => self.add(found.clone())?,
            });
        }
        let cell = |cell: &Destination| match *cell {
            Destination::Attractor(number) => known[usize::from(number)],
            Destination::Mirror(number) => known[usize::from(number)].mirrored(),
            other => other,
        };
        self.cells.extend(rows.cells.iter().map(cell));
        Ok(())
    }
}

/// Match of an attractor among the known ones.
enum Known {
    As(Destination),
    Undecided,
    Not,
}

impl Destination {
    /// Destination of the mirror image of a motion.
    fn mirrored(self) -> Self {
        match self {
            Self::Attractor(number) => Self::Mirror(number),
            Self::Mirror(number) => Self::Attractor(number),
            other => other,
        }
    }

    fn is_mirror(self) -> bool {
        matches!(self, Self::Mirror(_))
    }
}

#[cfg(test)]
mod tests;
