//! Simulated motion over a plane of two parameters: period, impacts and class (an isoperiodic
//! diagram).
//!
//! Every point has a motion of its own. A part of the study consists of one or more rows.

use crate::axis::{ParameterAxis, check_cells, parts_of_plane, rows_of_part};
use crate::design_sweep::{DesignMachine, Plain};
use crate::error::{Error, Result};
use crate::parts::Task;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Request of an isoperiodic diagram.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct IsoperiodicRequest<M: DesignMachine> {
    /// Horizontal axis.
    pub x: ParameterAxis<M::Name>,
    /// Vertical axis.
    pub y: ParameterAxis<M::Name>,
    /// Start of each motion.
    pub start: M::Start,
    /// Drive periods discarded before a motion is observed.
    pub discard: u32,
    /// Drive periods or returns for the largest exponents; `None` without exponents.
    ///
    /// For the 3-DOF machine this is the largest number of drive periods for motions with impacts
    /// and without a period; the computation ends when the class is decided, and an undecided
    /// motion is [followed](crate::paper::verdict) further. For a described machine this is the
    /// number of returns counted for every motion; without a period the computation continues
    /// until the class is decided.
    pub exponents: Option<u32>,
}

/// Machine whose motions can be studied over a plane.
pub trait PlaneMachine: DesignMachine {
    /// Result at a point.
    type Point: Plain;
    /// Workspace reused from part to part; it does not change results.
    type Workspace: Default;
    /// Motions in a part, rounded to whole rows.
    const IN_PLANE_PART: usize;

    /// Checks the properties on which every point depends.
    ///
    /// # Errors
    /// Error for invalid starts and names.
    fn check_plane(&self, request: &IsoperiodicRequest<Self>) -> Result<()>;

    /// The points of some rows, one row after the other.
    fn points(
        &self,
        request: &IsoperiodicRequest<Self>,
        rows: Range<usize>,
        workspace: &mut Self::Workspace,
    ) -> Vec<Self::Point>;
}

/// Plane of motions.
#[derive(Clone, Debug, PartialEq)]
pub struct Isoperiodic<P> {
    /// Points, row by row of constant y from the lowest.
    pub points: Vec<P>,
}

/// Number of parts, each of one or more whole rows.
pub fn count<M: PlaneMachine>(request: &IsoperiodicRequest<M>) -> usize {
    parts_of_plane((request.x.count, request.y.count), M::IN_PLANE_PART)
}

/// The plane, on all threads; `None` where rows belong to other shards. The result depends neither
/// on threads nor on shards.
///
/// # Errors
/// [`Error::Form`] for axes of one quantity, and for starts on the exact orbit under constant
/// loads; [`Error::TooMany`] for a plane that does not fit into memory; also errors of the
/// simulator for a start, and of the store of parts.
pub fn isoperiodic<M: PlaneMachine>(
    machine: &M,
    request: &IsoperiodicRequest<M>,
    task: &Task,
) -> Result<Option<Isoperiodic<M::Point>>> {
    check(machine, request)?;
    let part = |workspace: &mut M::Workspace, part| {
        let rows = rows_of_part((request.x.count, request.y.count), M::IN_PLANE_PART, part);
        Ok(machine.points(request, rows, workspace))
    };
    let parts = task.complete_with(count(request), part)?;
    Ok(parts.map(|parts| Isoperiodic { points: parts.concat() }))
}

/// Checks the properties on which every point depends.
///
/// # Errors
/// As [`isoperiodic`], before any computation.
pub fn check<M: PlaneMachine>(machine: &M, request: &IsoperiodicRequest<M>) -> Result<()> {
    if M::is_same_quantity(&request.x.name, &request.y.name) {
        let text = format!("{},{}", M::name(&request.x.name), M::name(&request.y.name));
        return Err(Error::Form { text, expected: "two independent parameters" });
    }
    // While the parts are joined, they and the whole plane are in memory.
    check_cells("points of the plane", (request.x.count, request.y.count), 2 * size_of::<M::Point>())?;
    machine.check_plane(request)
}
