//! Bounces too low to be followed (docs/assembly-law.md (A15)), with the overshoot of events under
//! a host's solver.

use super::Motion;
use super::contact::{Flags, is_low};
use super::projection::project;
use crate::error::Error;
use crate::law::box_qp::{independent, triangle};
use crate::law::impact::Impacts;
use crate::mode::{Contact, StopState};

/// Least relative height of a bounce, in exact motions; lower ones close the stop.
const LEAST_BOUNCE: f64 = 1e-12;

/// Least height of a bounce in multiples of the overshoot, under a host's solver.
const OVERSHOOT_BOUNCES: f64 = 100.0;

/// Most multiples of the overshoot that are added for a restitution near 1, and for 1 itself, whose
/// bounces decay by other losses. With less loss than this allows for, a bounce becomes so low only
/// after some 80,000 bounces.
const MOST_OVERSHOOT_BOUNCES: f64 = 1e4;

impl Motion {
    /// The least height of a bounce relative to the largest size of e - gap so far. With an
    /// overshoot d a ball gains the energy of the fall by d at each impact, so that its bounces
    /// never become lower than d e²/(1 - e²).
    pub(super) fn least_bounce(&self, restitution: f64) -> f64 {
        if self.overshoot == 0.0 {
            return LEAST_BOUNCE;
        }
        let kept = restitution * restitution;
        self.overshoot * (OVERSHOOT_BOUNCES + (2.0 * kept / (1.0 - kept)).min(MOST_OVERSHOOT_BOUNCES))
    }

    /// Under a host's solver, closes touching stops that impacts at others open with too low a
    /// bounce, and returns them. A body between two stops would otherwise be driven from one to the
    /// other without end, since each impact gains the energy of its overshoot.
    pub(super) fn hold_low(
        &mut self,
        touching: &[usize],
        flags: &Flags,
        impacts: &mut Impacts,
    ) -> Result<Vec<(usize, f64)>, Error> {
        if self.overshoot == 0.0 || touching.len() < 2 {
            return Ok(Vec::new());
        }
        let mode = self.select(flags)?;
        let assembly = self.assembly.clone();
        let (system, n) = (&assembly.system, assembly.system.coordinates);
        let place = self.tables.place_of(&mode, system);
        let acceleration = self.tables.at(place).table.a.rows_times(n..2 * n, self.hybrid.z.as_slice());
        let opens_low = |&i: &usize| {
            let stop = &system.stops[i];
            let rebound = -stop.elongation.rate.dot(&self.hybrid.z);
            let a = stop.elongation.w.dot(&acceleration) + stop.elongation.drift.dot(&self.hybrid.z);
            let least =
                self.least_bounce(stop.restitution().unwrap_or(0.0)) * self.hybrid.sizes.of(&stop.excess);
            mode.stops[i] == StopState::Open && rebound > 0.0 && a > 0.0 && is_low(rebound, a, least)
        };
        let low: Vec<usize> = touching.iter().copied().filter(opens_low).collect();
        if low.is_empty() {
            return Ok(Vec::new());
        }
        let held = touching.iter().filter(|i| low.contains(i) || mode.stops[**i] == StopState::Closed);
        let all: Vec<Contact> = held.map(|&i| Contact::Stop(i)).collect();
        let free = independent(&system.columns(&all), &(0..all.len()).collect::<Vec<_>>());
        let basis: Vec<Contact> = free.into_iter().map(|k| all[k]).collect();
        let (before, energy) = (self.hybrid.z.clone(), self.kinetic_and_stored().0);
        let r = triangle(&system.columns(&basis));
        project(system, &basis, &r, true, self.hybrid.z.as_mut_slice(), &mut Vec::new());
        let closes = |&i: &usize| {
            let e = &system.stops[i].elongation;
            e.rate.dot(&self.hybrid.z) > self.hybrid.sizes.zero_of(&e.rate)
        };
        if touching.iter().any(closes) {
            self.hybrid.z = before;
            return Ok(Vec::new());
        }
        impacts.projected_loss += energy - self.kinetic_and_stored().0;
        Ok(low.into_iter().map(|i| (i, 0.0)).collect())
    }
}
