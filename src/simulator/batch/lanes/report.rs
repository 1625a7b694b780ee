//! Reports during motions: samples, events and maxima, for sub-steps in lanes and alone.

use super::maxima::MaximumFinder;
use super::passage::CentredFlights;
use super::substep::Progress;
use super::{LaneSet, Rounds, lanes_of};
use crate::error::{Error, Result};
use crate::flow::{CENTRED, INTERVALS, Series, SubstepTable, WHOLE};
use crate::model::{Augmented, Forces, RELATIVE, RELATIVE_RATE, SmoothMode};
use crate::simulator::batch::queue::{MotionQueue, Reports};
use crate::simulator::batch::vectors::{LaneRow, ROW, Wide};
use crate::simulator::step::AdvanceState;
use crate::simulator::{Event, Simulator};
use crate::state::State;
use pulp::Simd;
use std::ops::ControlFlow;
use vibro_numerics::double_double::DoubleDouble;

/// Reports of one motion, with their progress.
pub(super) struct Reporter {
    reports: Reports,
    /// Number of the next sample.
    next: u32,
    pub(super) maxima: Option<MaximumFinder>,
}

/// Start of a sub-step that is computed alone.
pub(super) struct SubstepOrigin {
    pub(super) mode: SmoothMode,
    pub(super) z: Augmented,
    pub(super) time: DoubleDouble,
    /// Constant loads, if any act.
    pub(super) forces: Option<Forces>,
}

impl SubstepOrigin {
    #[inline(always)]
    pub(super) fn from(simulator: &Simulator, advance: &AdvanceState) -> Self {
        let forces = simulator.model.constant_forces();
        Self { mode: simulator.mode(), z: advance.z, time: simulator.hybrid.time, forces }
    }
}

impl Reporter {
    /// Reporter for a motion that is about to begin; switches its energy accounts off.
    ///
    /// # Errors
    /// [`Error::OutOfRange`] if loads other than the parameters' constant loads act, if the time
    /// between samples is not positive, or if there are more samples than can be numbered.
    pub(super) fn new(simulator: &mut Simulator, reports: Reports, end: f64) -> Result<Self> {
        const NAMES: [&str; 3] = ["box.f", "block.f", "secondary.f"];
        for (name, derivatives) in NAMES.iter().zip(simulator.hybrid.loads) {
            if let Some(&value) = derivatives.iter().find(|d| **d != 0.0) {
                let allowed = "0 with all its derivatives if samples, events or maxima are \
                    requested; constant loads are parameters";
                return Err(Error::OutOfRange { name, value, allowed });
            }
        }
        let sampled = reports.origin < f64::INFINITY;
        let numbers = [simulator.time(), end].map(|time| (time - reports.origin) / reports.step);
        if sampled && !(reports.step > 0.0 && numbers.iter().all(|n| n.abs() < f64::from(u32::MAX))) {
            let allowed =
                "a time > 0 with fewer than 2^32 steps from the first sample to the start and to the end";
            return Err(Error::OutOfRange { name: "time between samples", value: reports.step, allowed });
        }
        simulator.keeps_energy_accounts = false;
        let maxima = reports.maxima_of.map(|weights| MaximumFinder::new(simulator, weights));
        let mut reporter = Self { reports, next: 1, maxima };
        if sampled {
            reporter.set_next((numbers[0] as u32).max(reports.first).max(1), simulator.time());
        }
        Ok(reporter)
    }

    /// Sets the next sample: the first with at least the number `number` whose time is after `now`.
    fn set_next(&mut self, number: u32, now: f64) {
        // The loop below begins at `number` or just before `now`, whichever is later.
        let passed = ((now - self.reports.origin) / self.reports.step).floor() - 1.0;
        self.next = number.max(passed as u32);
        while self.next < u32::MAX && self.next_sample() <= now {
            self.next += 1;
        }
    }

    /// Time of the next sample, s; infinite if there is none.
    #[inline(always)]
    pub(super) fn next_sample(&self) -> f64 {
        if self.next == u32::MAX {
            return f64::INFINITY;
        }
        self.reports.origin + f64::from(self.next) * self.reports.step
    }

    /// Reports the next sample, with the state `z`. Returns a break if the queue ends the motion.
    #[inline(always)]
    fn take(
        &mut self,
        z: &Augmented,
        (queue, lane): (&mut (dyn MotionQueue + '_), usize),
    ) -> ControlFlow<()> {
        let [x1, w, x3, v1, dw, v3, ..] = *z;
        self.next = queue.sample(lane, self.next, &State::from_relative(&[x1, w, x3, v1, dw, v3]))?;
        ControlFlow::Continue(())
    }

    /// Reports an event; returns whether the queue has changed the next sample.
    #[inline(always)]
    fn report_event(
        &mut self,
        event: &Event,
        after: &Augmented,
        now: f64,
        (queue, lane): (&mut (dyn MotionQueue + '_), usize),
    ) -> bool {
        let asked = queue.event(lane, event, after);
        if let Some(number) = asked {
            self.set_next(number, now);
        }
        asked.is_some()
    }

    /// Reports a sub-step from `from` with its `events`; `after` is the state after their law.
    /// Returns a break if the queue ends the motion.
    #[inline(always)]
    pub(super) fn report_alone(
        &mut self,
        simulator: &Simulator,
        from: &SubstepOrigin,
        after: &Augmented,
        events: [Option<Event>; 2],
        (queue, lane): (&mut (dyn MotionQueue + '_), usize),
    ) -> ControlFlow<()> {
        let time = simulator.hybrid.time;
        if let Some(finder) = &mut self.maxima {
            let span = time.minus(from.time).value();
            let mut found = |maximum| queue.maximum(lane, &maximum);
            finder.search(
                pulp::Scalar,
                simulator,
                (from.mode, &from.z, from.forces.as_ref()),
                (from.time.value(), span),
                &mut found,
            );
            if let Some(Event::Impact { time, .. }) = events[0] {
                finder.pass_impact(after, time, &mut found);
            }
        }
        while self.next_sample() <= time.value() {
            let z =
                simulator.state_after(from, DoubleDouble::new(self.next_sample()).minus(from.time).value());
            self.take(&z, (queue, lane))?;
        }
        for event in events.into_iter().flatten() {
            self.report_event(&event, after, time.value(), (queue, lane));
        }
        ControlFlow::Continue(())
    }
}

impl Simulator {
    /// State `dt` s after the start of a sub-step, from the tables and the series about an
    /// interval's centre.
    fn state_after(&self, from: &SubstepOrigin, dt: f64) -> Augmented {
        if from.forces.is_some() {
            // One series over the whole sub-step; its remainder is under round-off
            // (docs/numerics.md, section 1).
            let h = self.substep;
            let series = Series::<WHOLE>::expand(&self.model, from.mode, &from.z, from.forces.as_ref(), h);
            let mut z = series.at(dt / h);
            if from.mode == SmoothMode::Rest {
                (z[RELATIVE], z[RELATIVE_RATE]) = (from.z[RELATIVE], 0.0);
            }
            return z;
        }
        let tables = match from.mode {
            SmoothMode::Flight => &self.flight,
            SmoothMode::Rest => &self.rest,
        };
        let (index, u) = self.place_in_substep(dt);
        let mut z = [0.0; 8];
        SubstepTable::transit(&tables.core.centre[index], &from.z, &mut z);
        let hold = |z: &mut Augmented| {
            if from.mode == SmoothMode::Rest {
                (z[RELATIVE], z[RELATIVE_RATE]) = (from.z[RELATIVE], 0.0);
            }
        };
        hold(&mut z);
        let mut z = Series::<CENTRED>::expand(&self.model, from.mode, &z, None, 0.5 * self.interval()).at(u);
        hold(&mut z);
        z
    }

    /// Interval that contains the time `dt` after the start of a sub-step, and the time from the
    /// interval's centre in half intervals.
    #[inline(always)]
    fn place_in_substep(&self, dt: f64) -> (usize, f64) {
        let place = dt / self.interval();
        let index = (place as usize).min(INTERVALS - 1);
        (index, 2.0 * (place - (index as f64 + 0.5)))
    }
}

impl Rounds<'_> {
    /// Reports the sub-steps of a round. Returns the lanes whose motions the queue has ended.
    #[inline(always)]
    pub(super) fn report<S: Simd>(&mut self, simd: S, done: &Progress) -> LaneSet {
        let mut ended = 0;
        for lane in lanes_of(done.moved & self.finding) {
            self.find_maxima(simd, lane, done.through >> lane & 1 != 0);
        }
        loop {
            let due = self.states.due_for_sample(simd) & done.moved & self.reporting & !ended;
            if due == 0 {
                break;
            }
            ended |= self.take_samples(simd, due);
        }
        for lane in lanes_of(done.through & self.reporting & !ended) {
            let Some(reporter) = self.motions[lane].as_mut().and_then(|motion| motion.reporter.as_mut())
            else {
                continue;
            };
            let states = &mut self.states;
            let event = Event::Impact {
                time: states.last_time.0[lane],
                side: self.searched.side.0[lane] as i8,
                speed: states.last_speed.0[lane],
                impulse: states.last_impulse.0[lane],
            };
            let (after, now) = (states.state(lane), states.time(lane).value());
            if reporter.report_event(&event, &after, now, (self.work.queue, lane)) {
                states.next_sample.0[lane] = reporter.next_sample();
            }
        }
        ended
    }

    /// Reports the maxima in the latest sub-step of a motion in its lane.
    #[inline(always)]
    fn find_maxima<S: Simd>(&mut self, simd: S, lane: usize, through: bool) {
        let Some(reporter) = self.motions[lane].as_mut().and_then(|motion| motion.reporter.as_mut()) else {
            return;
        };
        let Some(finder) = &mut reporter.maxima else { return };
        let simulator = &self.work.simulators[self.simulator_of[lane]];
        let (begin, now) = (self.starts.time(lane), self.states.time(lane));
        let queue = &mut *self.work.queue;
        let mut found = |maximum| queue.maximum(lane, &maximum);
        let way = (begin.value(), now.minus(begin).value());
        let from = (SmoothMode::Flight, &self.starts.state(lane), None);
        finder.search(simd, simulator, from, way, &mut found);
        if through {
            finder.pass_impact(&self.states.state(lane), now.value(), &mut found);
        }
    }

    /// Reports a sample of each of the motions `due`, within its latest sub-step. The flights of
    /// all lanes are expanded side by side, each about the centre of its own interval. Returns the
    /// lanes whose motions the queue has ended.
    #[inline(always)]
    fn take_samples<S: Simd>(&mut self, simd: S, due: LaneSet) -> LaneSet {
        let (mut places, mut ended) = (LaneRow::ZERO, 0);
        for lane in lanes_of(due) {
            let dt =
                (self.states.next_sample.0[lane] - self.starts.time[0].0[lane]) - self.starts.time[1].0[lane];
            let (index, u) = self.work.simulators[self.simulator_of[lane]].place_in_substep(dt);
            places.0[lane] = u;
            self.samples.put(simd, &self.systems, lane, index, &self.starts.z);
        }
        let mut samples = [[0.0; 8]; ROW];
        for v in 0..LaneRow::vectors::<S>() {
            if due >> (v * S::F64_LANES) & ((1 << S::F64_LANES) - 1) == 0 {
                continue;
            }
            let centre = self.samples.load(simd, v);
            let flights = CentredFlights::expand(simd, &self.systems, v, &centre);
            let z = flights.state_at(&self.systems, simd, v, Wide::load(simd, &places, v));
            let mut row = LaneRow::ZERO;
            for (j, z) in z.into_iter().enumerate() {
                z.store(&mut row, v);
                let lanes = v * S::F64_LANES..(v + 1) * S::F64_LANES;
                for (sample, z) in samples[lanes.clone()].iter_mut().zip(&row.0[lanes]) {
                    sample[j] = *z;
                }
            }
        }
        for lane in lanes_of(due) {
            if let Some(reporter) = self.motions[lane].as_mut().and_then(|motion| motion.reporter.as_mut()) {
                if reporter.take(&samples[lane], (self.work.queue, lane)).is_break() {
                    ended |= 1 << lane;
                }
                self.states.next_sample.0[lane] = reporter.next_sample();
            }
        }
        ended
    }
}
