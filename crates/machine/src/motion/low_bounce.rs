//! Low bounces (docs/assembly-law.md (A19)), and the higher limits for a host's solver, which
//! integrates between events and detects impacts late.

use super::Motion;
use super::contact::{Flags, is_low};
use super::projection::project;
use crate::error::Error;
use crate::law::impact::Impacts;
use crate::mode::{Contact, StopState};

/// Lowest height of a simulated bounce, relative to the size of e - gap. For lower bounces the
/// stop closes.
const LEAST_BOUNCE: f64 = 1e-12;

/// Lowest height of a bounce under a host's solver, in multiples of the overshoot.
const OVERSHOOT_BOUNCES: f64 = 100.0;

/// Cap on the addition for a restitution ε, in multiples of the overshoot. It takes effect for ε >
/// 0.9999, and for ε = 1, where bounces decay by other losses. If these are smaller than the
/// losses at ε = 0.9999, a bounce becomes so low only after more than 80,000 bounces.
const MOST_OVERSHOOT_BOUNCES: f64 = 1e4;

impl Motion {
    /// Returns the relative height below which bounces are not simulated. If impacts are detected
    /// late, at a depth d, a ball falls d further at every impact. For a restitution ε the height
    /// of its bounces then stays above d ε²/(1 - ε²).
    pub(super) fn least_bounce(&self, restitution: f64) -> f64 {
        if self.overshoot == 0.0 {
            return LEAST_BOUNCE;
        }
        let kept = restitution * restitution;
        self.overshoot * (OVERSHOOT_BOUNCES + (2.0 * kept / (1.0 - kept)).min(MOST_OVERSHOOT_BOUNCES))
    }

    /// If impacts are detected late, closes each stop that an impact of other stops opens for a
    /// bounce too low to be simulated. Returns these stops. A body between two stops would
    /// otherwise bounce from one to the other without end, since every late impact gains the
    /// energy of its overshoot.
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
        let basis = system.independent(&all);
        let (before, energy) = (self.hybrid.z.clone(), self.kinetic_and_stored().0);
        let r = system.triangle(&basis);
        project(system, &basis, &r, true, self.hybrid.z.as_mut_slice(), &mut Vec::new());
        system.fill_curved(self.hybrid.z.as_mut_slice());
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
