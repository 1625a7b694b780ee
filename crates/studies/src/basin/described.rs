//! Basins of described machines.
//!
//! Attractors with a period are distinguished by their class, their period and their states at the
//! section, as in a [diagram](crate::diagram). Nothing decides whether two motions without a
//! period are on one attractor, so all of one class count as one. Positions of rest are not
//! numbered: friction may hold a body anywhere in a range.

use super::{BasinAttractor, BasinCell, BasinMachine, BasinRequest, Basins};
use crate::class::{MotionClass, Relation};
use crate::error::{Error, Result};
use crate::timescales::{runs_on, runs_on_beyond, settle};
use crate::{Machine, Section, Settled, settled};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::sync::Arc;
use vibro_machine::{Assembly, Error as MotionError, Motion, Start};

/// Attractor of a described machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SettledAttractor {
    /// Class, period, contacts.
    pub settled: Settled,
    /// A start on the attractor, or near it if it has no period.
    pub start: Start,
}

/// Result of a motion.
enum Led {
    Attractor(Box<SettledAttractor>),
    /// Coordinates of the bodies at rest.
    Rest(Vec<f64>),
}

/// Tolerance for a body at rest: velocity times time since the start, relative to the largest
/// displacement of any body since the start.
const AT_REST: f64 = 1e-9;

impl BasinMachine for Machine {
    type Attractor = SettledAttractor;
    type Shared = (Arc<Assembly>, Section);
    type BasinWorkspace = ();
    const IN_BASIN_PART: usize = 32;

    /// [`Error::Refusal`] for an unknown name and for a body whose coordinate follows from others;
    /// [`Error::Described`] for a machine without a section, and for one whose loads do not repeat
    /// after the discarded returns.
    fn check_basin(&self, request: &BasinRequest<Self>) -> Result<Self::Shared> {
        let assembly = Assembly::new(self.description.clone())?;
        for (i, j) in [(0, 0), (request.x.count - 1, request.y.count - 1)] {
            start(self, request, i, j)?.state(&assembly)?;
        }
        let section = Section::of(&self.description, &self.section)?;
        match runs_on_beyond(&self.description, &section, request.start.time, request.discard) {
            None => Ok((Arc::new(assembly), section)),
            Some(why) => Err(Error::Described {
                problem: format!(
                    "{why}, but attractors exist only while all loads repeat; increase --discard \
                     until the change lies in the discarded periods"
                ),
            }),
        }
    }

    fn rows_of_basin(
        &self,
        request: &BasinRequest<Self>,
        rows: Range<usize>,
        ((assembly, section), ()): (&Self::Shared, &mut ()),
    ) -> Result<Basins<SettledAttractor>> {
        let mut found = Basins::default();
        for (j, i) in rows.flat_map(|j| (0..request.x.count).map(move |i| (j, i))) {
            let led = motion(assembly, section, &start(self, request, i, j)?, request.discard);
            let cell = found.cell(led)?;
            found.cells.push(cell);
        }
        Ok(found)
    }
}

/// The start of a cell.
fn start(machine: &Machine, request: &BasinRequest<Machine>, i: usize, j: usize) -> Result<Start> {
    let mut start = request.start.clone();
    for (axis, i) in [(&request.x, i), (&request.y, j)] {
        start.set(&machine.description, &axis.name, axis.value(i))?;
    }
    Ok(start)
}

/// Attractor of the motion from a start, with its final state, or its position of rest.
fn motion(assembly: &Arc<Assembly>, section: &Section, start: &Start, discard: u32) -> Result<Led> {
    let mut motion = start.motion(assembly.clone())?.without_energy_accounts();
    let begin = (motion.time(), states(&motion));
    match settle(&mut motion, section, discard).and_then(|()| settled(&mut motion, section, None)) {
        Ok(settled) => Ok(Led::Attractor(Box::new(SettledAttractor { settled, start: Start::of(&motion) }))),
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

/// Whether all bodies are at rest and no signal changes later; `begin` are their first states.
fn is_at_rest(motion: &Motion, (time, begin): (f64, Vec<[f64; 3]>)) -> bool {
    let passed = motion.time() - time;
    let now = states(motion);
    let way = now.iter().zip(&begin).map(|(now, begin)| (now[0] - begin[0]).abs()).fold(0.0, f64::max);
    // Accelerations are not compared: at rest they are rounding of forces.
    let is_steady = |[_, v, _]: &[f64; 3]| (v * passed).abs() <= AT_REST * way;
    let is_over = runs_on(&motion.assembly().description, motion.time()).is_none();
    passed > 0.0 && is_over && now.iter().all(is_steady)
}

impl BasinAttractor for SettledAttractor {
    const SHARES_OF_ALL: bool = true;

    fn class(&self) -> MotionClass {
        self.settled.class
    }

    fn relation(&self, other: &Self) -> Relation {
        let (a, b) = (&self.settled, &other.settled);
        // Without a period the class decides; with other phases of states, the class and the
        // contacts.
        let differs =
            a.differs(b).unwrap_or(a.class != b.class || a.period.is_some() && a.contacts != b.contacts);
        if differs { Relation::Different } else { Relation::Same }
    }

    fn pool(&mut self, _: &Self, _: bool) {}
}

impl Basins<SettledAttractor> {
    fn cell(&mut self, led: Result<Led>) -> Result<BasinCell> {
        match led {
            Ok(Led::Attractor(found)) if !found.settled.class.is_decided() => Ok(BasinCell::NotSettled),
            Ok(Led::Attractor(found)) => Ok(self.reached(*found, true)?.unwrap_or(BasinCell::Undecided)),
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
}
