//! Energy accounts along the sub-steps (see [`crate::ledger`]).

use super::Simulator;
use super::careful::{Arrival, Start};
use crate::flow::INTERVALS;
use crate::model::Mode;
use std::sync::Arc;

impl Simulator {
    #[inline(always)]
    pub(super) fn account<const LOADS: usize, const N: usize>(
        &mut self,
        start: &Start<LOADS>,
        to: &Arrival<N>,
    ) {
        let mut total = (0.0, 0.0);
        let mut from = 0.0;
        if let Some(index) = to.interval {
            if LOADS > 0 {
                total = self.account_loaded(start, index);
                from = -1.0;
            } else {
                self.prepare_gramians();
                total = self.tables().energy.up_to(pulp::Scalar, index, &start.z);
            }
        }
        let forces = start.forces_after(to.base);
        let (input, damped) = self.tables().energy.along(to.series, forces.as_ref(), (from, to.u), to.radius);
        self.motion.sums.input = self.motion.sums.input.plus(total.0 + input);
        self.motion.sums.damped = self.motion.sums.damped.plus(total.1 + damped);
    }

    #[inline(always)]
    pub(super) fn account_whole<const LOADS: usize>(&mut self, start: &Start<LOADS>) {
        let (input, damped) = if LOADS > 0 {
            self.account_loaded(start, INTERVALS)
        } else {
            self.prepare_gramians();
            self.tables().energy.up_to(pulp::Scalar, INTERVALS, &start.z)
        };
        self.motion.sums.input = self.motion.sums.input.plus(input);
        self.motion.sums.damped = self.motion.sums.damped.plus(damped);
    }

    /// Under loads the powers are integrated interval by interval, up to the beginning of interval `count`.
    #[inline(always)]
    fn account_loaded<const LOADS: usize>(&mut self, start: &Start<LOADS>, count: usize) -> (f64, f64) {
        let mut total = (0.0, 0.0);
        for index in 0..count {
            let (series, base) = self.centred(start, index);
            let forces = start.forces_after(base);
            let radius = 0.5 * self.interval();
            let (input, damped) = self.tables().energy.along(&series, forces.as_ref(), (-1.0, 1.0), radius);
            total = (total.0 + input, total.1 + damped);
        }
        total
    }

    #[inline(always)]
    pub(super) fn prepare_gramians(&mut self) {
        let mode = self.mode();
        let tables = if mode == Mode::Flight { &mut self.flight } else { &mut self.rest };
        if !tables.energy_ready {
            let tables = Arc::make_mut(tables);
            tables.energy.fill(&self.model, mode, self.substep);
            tables.energy_ready = true;
        }
    }
}
