//! Energy accounts along the sub-steps (see [`crate::energy`]).

use super::points::{SeriesPoint, SubstepStart};
use super::step::AdvanceState;
use super::{Contact, Simulator};
use crate::flow::{CENTRED, INTERVALS};
use crate::model::{Augmented, BOX_RATE, SmoothMode};
use pulp::Simd;
use std::sync::Arc;
use vibro_numerics::simd::StateRows;

impl Simulator {
    /// Begins the account of the drive's work in a flight without loads. This work is the
    /// difference of a function's values at both ends; the value at the present state is subtracted
    /// here.
    #[inline(always)]
    pub(super) fn open_account(&mut self, advance: &mut AdvanceState) {
        if self.hybrid.contact == Contact::Flight
            && let Some(work) = self.flight.energy.drive_work()
        {
            self.hybrid.sums.input = self.hybrid.sums.input.plus(-work.value(&advance.z));
            advance.flown_from = self.hybrid.time;
        }
    }

    /// Ends the account of the drive's work in a flight without loads: adds the function's value at
    /// the present state and the mean power times the time since
    /// [`open_account`](Self::open_account).
    #[inline(always)]
    pub(super) fn close_account(&mut self, advance: &AdvanceState) {
        if let Some(work) = self.flight.energy.drive_work() {
            let duration = self.hybrid.time.minus(advance.flown_from).value();
            let input = self.hybrid.sums.input.plus(work.value(&advance.z));
            self.hybrid.sums.input = input.plus(work.mean() * duration);
        }
    }

    /// Accounts for an event: `contact` is the mode and `speed` the box's velocity before it.
    #[inline(always)]
    pub(super) fn account_event(&mut self, advance: &mut AdvanceState, contact: Contact, speed: f64) {
        if contact != Contact::Flight {
            self.open_account(advance);
            return;
        }
        if let Some(work) = self.flight.energy.drive_work() {
            self.pending.input -= work.jump(&advance.z, advance.z[BOX_RATE] - speed);
        }
        if self.hybrid.contact != Contact::Flight {
            self.close_account(advance);
        }
    }

    /// Accounts for the last piece of a flight: from the sub-step's start to the centre of interval
    /// `index`, if given, and then along the series `rows` to u. `end` is the state at u.
    #[inline(always)]
    pub(super) fn account_flight<S: Simd>(
        &mut self,
        simd: S,
        z: &Augmented,
        index: Option<usize>,
        rows: &StateRows<S, CENTRED>,
        (u, end): (f64, &Augmented),
    ) {
        self.prepare_gramians();
        let radius = 0.5 * self.interval();
        let energy = &self.flight.energy;
        energy.damped_along(simd, index, z, rows, (u, end, radius), &mut self.pending.damped);
        if energy.drive_work().is_none() {
            let before = index.map_or(0.0, |index| energy.input_up_to(simd, index, z));
            let input = before + energy.input_along(simd, rows, (u, radius));
            self.pending.input += input;
        }
    }

    /// Accounts for a sub-step that ends at a point of a series. Not inlined: each end of a
    /// sub-step calls it.
    #[inline(never)]
    pub(super) fn account<const LOADS: usize, const N: usize>(
        &mut self,
        start: &SubstepStart<LOADS>,
        to: &SeriesPoint<N>,
    ) {
        let mut from = 0.0;
        if let Some(index) = to.interval {
            if LOADS > 0 {
                let (input, damped) = self.account_loaded(start, index);
                self.add::<LOADS>(input, damped);
                from = -1.0;
            } else {
                self.account_up_to(pulp::Scalar, &start.z, index);
            }
        }
        let forces = start.forces_after(to.base);
        let (input, damped) = self.tables().energy.along(to.series, forces.as_ref(), (from, to.u), to.radius);
        self.add::<LOADS>(input, damped);
    }

    /// Adds to the accounts. Input is added only if the drive's work is not computed as a
    /// difference.
    #[inline(always)]
    fn add<const LOADS: usize>(&mut self, input: f64, damped: f64) {
        if LOADS > 0 || self.tables().energy.drive_work().is_none() {
            self.hybrid.sums.input = self.hybrid.sums.input.plus(input);
        }
        self.hybrid.sums.damped = self.hybrid.sums.damped.plus(damped);
    }

    #[inline(never)]
    pub(super) fn account_whole<const LOADS: usize>(&mut self, start: &SubstepStart<LOADS>) {
        if LOADS > 0 {
            let (input, damped) = self.account_loaded(start, INTERVALS);
            self.add::<LOADS>(input, damped);
        } else {
            self.account_up_to(pulp::Scalar, &start.z, INTERVALS);
        }
    }

    /// Accounts for the motion without loads from a sub-step's start to the centre of interval
    /// `index`, or to the sub-step's end if `index` is [`INTERVALS`].
    #[inline(always)]
    pub(super) fn account_up_to<S: Simd>(&mut self, simd: S, z: &Augmented, index: usize) {
        self.prepare_gramians();
        let energy = &self.tables().energy;
        let damped = energy.damped_up_to(simd, index, z);
        if energy.drive_work().is_none() {
            let input = energy.input_up_to(simd, index, z);
            self.hybrid.sums.input = self.hybrid.sums.input.plus(input);
        }
        self.hybrid.sums.damped = self.hybrid.sums.damped.plus(damped);
    }

    /// Input and damped energy under loads over the first `count` intervals, integrated interval by
    /// interval, J.
    #[inline(always)]
    fn account_loaded<const LOADS: usize>(
        &mut self,
        start: &SubstepStart<LOADS>,
        count: usize,
    ) -> (f64, f64) {
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
        let tables = if mode == SmoothMode::Flight { &mut self.flight } else { &mut self.rest };
        if !tables.energy_ready {
            let tables = Arc::make_mut(tables);
            tables.energy.fill(&tables.core, &self.model, mode, self.substep);
            tables.energy_ready = true;
        }
    }
}
