//! Low bounces, and what lateness makes of them where a host's solver finds the motion between
//! events.

use super::Motion;
use super::contact::{Flags, is_low, project};
use crate::error::Error;
use crate::law::box_qp::{independent, triangle};
use crate::law::impact::Impacts;
use crate::mode::{Contact, StopState};

/// A stop whose bounces would be lower than this part of its largest e so far is closed.
const LEAST_BOUNCE: f64 = 1e-12;

/// Where stops are met late, bounces under this many times the lateness are too low to matter.
const OVERSHOOT_BOUNCES: f64 = 100.0;

/// Of a restitution near 1 at most so many times the lateness more, and of 1 itself, which ends its
/// bounces by what is lost elsewhere. One that loses less in a bounce than this allows for would
/// come so low after some eighty thousand bounces and more.
const MOST_OVERSHOOT_BOUNCES: f64 = 1e4;

impl Motion {
    /// The part of a stop's largest e so far under which a bounce is too low to matter. Where stops
    /// are met late by a depth d, a ball falls on by it, and its bounces do not get lower than d
    /// e²/(1 - e²).
    pub(super) fn least_bounce(&self, restitution: f64) -> f64 {
        if self.overshoot == 0.0 {
            return LEAST_BOUNCE;
        }
        let kept = restitution * restitution;
        self.overshoot * (OVERSHOOT_BOUNCES + (2.0 * kept / (1.0 - kept)).min(MOST_OVERSHOOT_BOUNCES))
    }

    /// Where stops are met late, holds those that an impact of others opens by less than matters,
    /// and tells which. A body between two stops would be driven from one to the other without end,
    /// since every late impact gains what it falls on.
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
