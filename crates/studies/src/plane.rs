//! Described machines as [`PlaneMachine`]s.

use super::timescales::{runs_on_beyond, settle};
use super::{Machine, Section, settled};
use crate::class::MotionClass;
use crate::error::{Error, Result};
use crate::isoperiodic::{IsoperiodicRequest, PlaneMachine};
use serde::{Deserialize, Serialize};
use std::ops::Range;
use vibro_machine::Assembly;

/// Motion at one point of a plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanePoint {
    /// Class of the motion.
    pub class: MotionClass,
    /// Impacts and first touches per return.
    pub contacts: f64,
    /// Whether at some time a stop stays closed or a friction element sticks.
    pub rests: bool,
    /// Mean time between returns, s.
    pub interval: f64,
    /// Largest exponent, 1/s, with its standard error, if it was computed.
    pub exponent: Option<[f64; 2]>,
}

impl PlaneMachine for Machine {
    /// `None` if the values do not make a machine, or if the motion cannot continue.
    type Point = Option<PlanePoint>;
    type Workspace = ();
    const IN_PLANE_PART: usize = 32;

    fn check_plane(&self, request: &IsoperiodicRequest<Self>) -> Result<()> {
        for axis in [&request.x, &request.y] {
            for end in [axis.from, axis.to] {
                self.with([(axis.name.as_str(), end)])?;
            }
        }
        // Conditions that every point must meet.
        request.start.state(&Assembly::new(self.description.clone())?)?;
        let section = Section::of(&self.description, &self.section)?;
        match runs_on_beyond(&self.description, &section, request.start.time, request.discard) {
            None => Ok(()),
            Some(why) => Err(Error::Described {
                problem: format!(
                    "{why}, but motions can be classified only while all loads repeat; increase \
                     --discard until the change lies in the discarded periods"
                ),
            }),
        }
    }

    fn points(
        &self,
        request: &IsoperiodicRequest<Self>,
        rows: Range<usize>,
        (): &mut (),
    ) -> Vec<Self::Point> {
        let places = rows.flat_map(|j| (0..request.x.count).map(move |i| (i, j)));
        places.map(|(i, j)| point(self, request, request.x.value(i), request.y.value(j)).ok()).collect()
    }
}

/// The motion at a point.
///
/// # Errors
/// Error if the values do not make a machine, or if the motion cannot continue.
fn point(machine: &Machine, request: &IsoperiodicRequest<Machine>, x: f64, y: f64) -> Result<PlanePoint> {
    let own = machine.with([(request.x.name.as_str(), x), (request.y.name.as_str(), y)])?;
    let (motion, section) = own.motion(&request.start)?;
    let mut motion = motion.without_energy_accounts();
    settle(&mut motion, &section, request.discard)?;
    let found = settled(&mut motion, &section, request.exponents)?;
    Ok(PlanePoint {
        class: found.class,
        contacts: found.contacts,
        rests: found.rests,
        interval: found.interval,
        exponent: found.exponent.map(|e| [e.value, e.error]),
    })
}
