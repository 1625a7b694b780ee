//! Basins of the paper's machine, whose attractors have mirror images.

use super::attractor::Attractor;
use super::parameter_set::ParameterSet;
use super::start::{Coordinate, SI_COORDINATES, StartRule, coordinate, coordinate_value};
use super::stroboscopic::{COORDINATES, dimensional};
use super::trajectories::{MOTIONS, Start, Workspace};
use super::verdict::{Followed, Following, follow};
use crate::basin::{BasinAttractor, BasinCell, BasinMachine, BasinRequest, Basins, StartAxis};
use crate::class::{MotionClass, Relation};
use crate::error::{Error, Result};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use vibro_impact::State;
use vibro_impact::parameters::Parameters;

/// Range of an initial value, finite and ascending; parsed from `name=from:to`.
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
    /// [`vibro_impact::Error::Undefined`] for a range of a speed in SI without a spring between
    /// box and ground, since ω10 is zero.
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
    pub fn cells(self, count: usize) -> StartAxis {
        let Self { coordinate, from, to, .. } = self;
        StartAxis { name: COORDINATES[coordinate].into(), from, to, count: count.max(1) }
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

/// The start with all initial values zero.
pub fn in_the_middle() -> StartRule {
    StartRule::scaled([0.0; 6])
}

/// Attractor of the paper's machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ClassedAttractor {
    /// The attractor. Without a period its means are over all motions on it.
    pub attractor: Attractor,
    /// Class of the motions.
    pub class: MotionClass,
}

impl BasinAttractor for ClassedAttractor {
    const SHARES_OF_ALL: bool = false;

    fn class(&self) -> MotionClass {
        self.class
    }

    fn relation(&self, other: &Self) -> Relation {
        self.attractor.relation(&other.attractor)
    }

    fn pool(&mut self, other: &Self, mirrored: bool) {
        self.attractor.pool(&other.attractor, mirrored);
    }
}

/// Index of the coordinate on an axis.
fn place(axis: &StartAxis) -> Result<usize> {
    let expected = "a name of x1 x2 x3 v1 v2 v3";
    let place = COORDINATES.iter().position(|name| *name == axis.name);
    place.ok_or_else(|| Error::Form { text: axis.name.clone(), expected })
}

impl BasinMachine for ParameterSet {
    type Attractor = ClassedAttractor;
    /// Coordinates of the axes.
    type Shared = [usize; 2];
    type BasinWorkspace = Workspace;
    const IN_BASIN_PART: usize = MOTIONS;

    fn check_basin(&self, request: &BasinRequest<Self>) -> Result<[usize; 2]> {
        Ok([place(&request.x)?, place(&request.y)?])
    }

    /// One machine has one set of tables for all its motions.
    fn rows_of_basin(
        &self,
        request: &BasinRequest<Self>,
        rows: Range<usize>,
        (axes, workspace): (&[usize; 2], &mut Workspace),
    ) -> Result<Basins<ClassedAttractor>> {
        let p = self.parameters();
        let first = request.start.state(p)?;
        let places = rows.flat_map(|j| (0..request.x.count).map(move |i| (i, j)));
        let values = places.map(|(i, j)| [request.x.value(i), request.y.value(j)]);
        let starts: Vec<Start> = values
            .map(|values| Start { parameters: *p, state: cell_start(p, &first, *axes, values) })
            .collect();
        let following = Following { discard: request.discard, ..Following::default() };
        let mut found = Basins { cells: vec![BasinCell::NotSettled; starts.len()], ..Basins::default() };
        let mut refused = Ok(());
        follow(workspace, &starts, &following, &mut |number, motion, last| {
            let decided = match motion {
                Ok(motion) => found.decide(number, motion, last),
                Err(Error::Model(vibro_impact::Error::Penetration { .. })) => {
                    found.cells[number] = BasinCell::Outside;
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
}

/// The start at the centre of a cell: the request's start with the scaled values of the axes.
fn cell_start(p: &Parameters, first: &State, axes: [usize; 2], values: [f64; 2]) -> State {
    let mut s = *first;
    for (k, value) in axes.into_iter().zip(values) {
        let mut scaled = [0.0; 6];
        scaled[k] = value;
        let own = dimensional(p, &scaled);
        if k < 3 { s.x[k] = own.x[k] } else { s.v[k - 3] = own.v[k - 3] }
    }
    s
}

impl Basins<ClassedAttractor> {
    /// Records the destination of a cell's motion. Returns whether it is decided. Chaos is decided
    /// only at the `last` call, an attractor only once its means are known well enough.
    fn decide(&mut self, number: usize, motion: &Followed, last: bool) -> Result<bool> {
        // Chaos next to periodic motions is often a long transient: it counts as an attractor only
        // at the limit.
        let open = motion.wanders() && !last;
        let destination = if open { None } else { self.destination(motion)? };
        if let Some(destination) = destination {
            self.cells[number] = destination;
        } else if last && motion.wanders() && motion.stationary {
            self.cells[number] = BasinCell::Undecided;
        }
        Ok(destination.is_some())
    }

    /// Destination of a motion: a known attractor or a new one. `None` if it is undecided.
    fn destination(&mut self, motion: &Followed) -> Result<Option<BasinCell>> {
        if !motion.class.is_decided() {
            return Ok(None);
        }
        let found = ClassedAttractor { attractor: motion.attractor.clone(), class: motion.class };
        // The means of a single motion form an attractor once they are known well enough.
        let sure = motion.attractor.period.is_some() || motion.stationary;
        self.reached(found, sure)
    }

    /// This basin with its attractors numbered by their first cell instead of by the time of their
    /// verdict.
    fn in_order_of_cells(self) -> Self {
        let mut order: Vec<u16> = Vec::new();
        for cell in &self.cells {
            if let BasinCell::Attractor(number) | BasinCell::Mirror(number) = cell
                && !order.contains(number)
            {
                order.push(*number);
            }
        }
        let place = |number: u16| order.iter().position(|n| *n == number).unwrap_or_default() as u16;
        let cell = |cell: &BasinCell| match *cell {
            BasinCell::Attractor(number) => BasinCell::Attractor(place(number)),
            BasinCell::Mirror(number) => BasinCell::Mirror(place(number)),
            other => other,
        };
        let attractors = order.iter().map(|n| self.attractors[usize::from(*n)].clone()).collect();
        Self { cells: self.cells.iter().map(cell).collect(), attractors, ..self }
    }
}

#[cfg(test)]
mod tests;
