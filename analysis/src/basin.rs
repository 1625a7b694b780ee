//! Basins of attraction over two initial values, and the attractors that coexist.

use super::attractor::{Attractor, Relation, observe};
use super::error::{Error, Result};
use super::parts::Task;
use super::stroboscopic::{COORDINATES, dimensional};
use super::trajectories::{Start, propagate};
use serde::{Deserialize, Serialize};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Simulator, State};

/// The range of an initial value, both ends finite and the lower one first; read from `name=from:to`.
///
/// ```
/// use vibro_analysis::basin::InitialValueRange;
///
/// let range: InitialValueRange = "v2=-2:2".parse()?;
/// assert_eq!(range.cells(4).value(0), -1.5);
/// # Ok::<(), vibro_analysis::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InitialValueRange {
    coordinate: usize,
    from: f64,
    to: f64,
}

impl InitialValueRange {
    /// The range divided into `count` cells, at least one.
    pub fn cells(self, count: usize) -> InitialValueAxis {
        let Self { coordinate, from, to } = self;
        InitialValueAxis { coordinate, from, to, count: count.max(1) }
    }
}

impl std::str::FromStr for InitialValueRange {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let form = || Error::Form {
            text: text.into(),
            expected: "name=from:to with from < to and a name of x1 x2 x3 v1 v2 v3, e.g. v2=-2:2",
        };
        let (name, ends) = text.split_once('=').ok_or_else(form)?;
        let coordinate = COORDINATES.iter().position(|c| *c == name.trim()).ok_or_else(form)?;
        let (from, to) = ends.split_once(':').ok_or_else(form)?;
        let number = |t: &str| t.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        match (number(from), number(to)) {
            (Some(from), Some(to)) if from < to => Ok(Self { coordinate, from, to }),
            _ => Err(form()),
        }
    }
}

impl std::fmt::Display for InitialValueRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}:{}", COORDINATES[self.coordinate], self.from, self.to)
    }
}

/// One axis of a plane of starts: an initial value at the centres of `count` cells between `from` and `to`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InitialValueAxis {
    /// Index into [`COORDINATES`].
    pub coordinate: usize,
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Cells.
    pub count: usize,
}

impl InitialValueAxis {
    /// The value at the centre of cell `i`.
    pub fn value(&self, i: usize) -> f64 {
        self.from + (self.to - self.from) * (i as f64 + 0.5) / self.count as f64
    }
}

/// What to compute.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Request {
    /// Horizontal.
    pub x: InitialValueAxis,
    /// Vertical.
    pub y: InitialValueAxis,
    /// Drive periods discarded before a motion is observed.
    pub discard: u32,
}

/// Where the motion from a start ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Destination {
    /// On the attractor of this number.
    Attractor(u16),
    /// On the mirror image of the attractor of this number.
    Mirror(u16),
    /// There is no motion: the start is outside the stops.
    Outside,
}

/// A plane of starts.
#[derive(Clone, Debug, PartialEq)]
pub struct Basin {
    /// The attractors, in the order in which the cells meet them.
    pub attractors: Vec<Attractor>,
    /// Rows of constant y, from the first.
    pub cells: Vec<Destination>,
}

impl Basin {
    /// The part of the starts inside the stops that lead to an attractor, and to its mirror image.
    pub fn shares(&self, number: u16) -> [f64; 2] {
        let count =
            |destination: Destination| self.cells.iter().filter(|g| **g == destination).count() as f64;
        let inside = self.cells.len() as f64 - count(Destination::Outside);
        [Destination::Attractor(number), Destination::Mirror(number)].map(|g| count(g) / inside.max(1.0))
    }
}

/// The start at the centre of a cell; the initial values that are on no axis are zero.
fn start(p: &Parameters, request: &Request, column: usize, row: usize) -> State {
    let mut s = [0.0; 6];
    for (axis, i) in [(&request.x, column), (&request.y, row)] {
        s[axis.coordinate] = axis.value(i);
    }
    dimensional(p, &s)
}

/// Number of parts: the rows.
pub fn count(request: &Request) -> usize {
    request.y.count
}

/// The basins, on all threads; `None` where rows belong to other shards. The result depends neither on threads nor on
/// shards.
///
/// # Errors
/// [`Error::Form`] for two axes of one coordinate; what the simulator refuses, starts outside the stops apart.
pub fn basin(p: &Parameters, request: &Request, task: &Task) -> Result<Option<Basin>> {
    if request.x.coordinate == request.y.coordinate {
        let text = COORDINATES[request.x.coordinate].into();
        return Err(Error::Form { text, expected: "two different initial values, e.g. v2 and x1" });
    }
    let row = |j: usize| -> Result<Vec<Option<Attractor>>> {
        let states = (0..request.x.count).map(|i| start(p, request, i, j));
        let starts: Vec<Start> = states.map(|state| Start { parameters: *p, state }).collect();
        let ends = propagate(&starts, request.discard, &|| ());
        let system = Simulator::new(p, &State::default(), 0.0)?.without_energy_accounts();
        ends.into_iter()
            .map(|end| match end {
                Ok(state) => observe(&mut system.with_state(&state, 0.0)?).map(Some),
                Err(Error::Model(vibro_impact::Error::Penetration { .. })) => Ok(None),
                Err(other) => Err(other),
            })
            .collect()
    };
    let Some(rows) = task.complete(count(request), row)? else { return Ok(None) };
    let mut found = Basin { attractors: Vec::new(), cells: Vec::new() };
    for cell in rows.into_iter().flatten() {
        let Some(attractor) = cell else {
            found.cells.push(Destination::Outside);
            continue;
        };
        let known =
            found.attractors.iter().zip(0..).find_map(|(known, number)| match known.relation(&attractor) {
                Relation::Same => Some(Destination::Attractor(number)),
                Relation::Mirror => Some(Destination::Mirror(number)),
                Relation::Different => None,
            });
        let number = found.attractors.len() as u16;
        found.cells.push(known.unwrap_or(Destination::Attractor(number)));
        if known.is_none() {
            found.attractors.push(attractor);
        }
    }
    Ok(Some(found))
}
