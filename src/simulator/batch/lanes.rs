//! Many independent motions at a time on one thread, each in a lane of the machine's vectors.
//!
//! Nearly all sub-steps of a motion are free flight over a whole sub-step, to its end or to an
//! impact that is easily proved to be the first. These are computed for all lanes at once. All
//! other sub-steps (not free flight, or without a proof by the lanes) are computed for each motion
//! alone with the code of [`step`](super::super::step). Only the motion's state decides between
//! the two computations, so the result does not depend on neighbouring motions.

mod centres;
mod maxima;
mod passage;
mod report;
mod rows;
mod substep;
mod transition;

use super::super::step::{AdvanceState, RENEW};
use super::super::{Contact, Event, Pause, Simulator};
use super::queue::{LaneUse, MotionQueue, Plan};
use crate::error::Result;
use crate::model::{Augmented, RELATIVE};
use crate::simulator::batch::vectors::ROW;
use centres::Centres;
use pulp::Simd;
use report::{Reporter, SubstepOrigin};
use rows::{LaneStates, LaneSystems, SubstepStarts};
use std::ops::ControlFlow;
use substep::{Progress, SearchedIntervals};
use vibro_numerics::double_double::DoubleDouble;

/// Number of sub-steps in a lane between two computations of cos θ and sin θ from the extended
/// phase. In between they collect no more round-off than the other coordinates, which are never
/// renewed.
const RENEWAL: u32 = 64;
/// Number of lanes of a vector above which lanes are faster. On machines with fewer lanes all
/// motions are advanced alone.
const FEWEST_LANES: usize = 4;

/// Work of one thread, compiled once for each instruction set.
pub(super) struct Lanes<'a> {
    pub(super) simulators: &'a mut [Simulator],
    pub(super) queue: &'a mut dyn MotionQueue,
    pub(super) one_by_one: bool,
}

impl pulp::WithSimd for Lanes<'_> {
    type Output = LaneUse;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> LaneUse {
        let lanes = if self.one_by_one || S::F64_LANES < FEWEST_LANES { 1 } else { ROW };
        let mut rounds = Rounds {
            work: self,
            motions: [const { None }; ROW],
            simulator_of: [0; ROW],
            systems: Box::new(LaneSystems::zero()),
            states: Box::new(LaneStates::zero()),
            searched: Box::new(SearchedIntervals::zero(simd)),
            samples: Box::new(Centres::new(simd)),
            starts: Box::new(SubstepStarts::ZERO),
            active: 0,
            reporting: 0,
            finding: 0,
            used: LaneUse::default(),
        };
        for lane in 0..lanes {
            rounds.take_next(lane, None);
        }
        while rounds.active != 0 {
            if lanes == 1 {
                rounds.hand_over(simd, 0, None);
            } else {
                rounds.round(simd);
            }
        }
        rounds.used
    }
}

/// Motion under way.
struct LaneMotion {
    advance: AdvanceState,
    end: DoubleDouble,
    reporter: Option<Reporter>,
}

/// The motions under way, round after round.
struct Rounds<'a> {
    work: Lanes<'a>,
    motions: [Option<LaneMotion>; ROW],
    /// Index of the simulator of each lane's motion.
    simulator_of: [usize; ROW],
    systems: Box<LaneSystems>,
    states: Box<LaneStates>,
    searched: Box<SearchedIntervals>,
    /// States at the centres of the intervals that contain samples.
    samples: Box<Centres>,
    starts: Box<SubstepStarts>,
    /// Lanes that have a motion.
    active: LaneSet,
    /// Lanes whose motion reports.
    reporting: LaneSet,
    /// Lanes whose motion reports maxima.
    finding: LaneSet,
    used: LaneUse,
}

impl Rounds<'_> {
    /// Advances all lanes by a sub-step. Each motion that the lanes cannot move is advanced alone,
    /// by one sub-step or more.
    #[inline(always)]
    fn round<S: Simd>(&mut self, simd: S) {
        for lane in lanes_of(self.states.due_for_renewal(simd, f64::from(RENEWAL)) & self.active) {
            self.renew(lane);
        }
        let sets = (self.active, self.reading(simd));
        let Self { systems, states, searched, starts, .. } = self;
        let done = substep::flight_substep(simd, systems, states, searched, sets, starts);
        self.used.rounds += 1;
        self.used.occupied += u64::from(self.active.count_ones());
        self.used.substeps += u64::from(done.moved.count_ones());
        let mut ended = 0;
        if done.moved & self.reporting != 0 {
            ended = report_apart(simd, self, &done);
        }
        for lane in lanes_of(ended) {
            self.take_next(lane, Some(Ok(())));
        }
        for lane in lanes_of((done.unproved | done.at_stop) & !ended) {
            let touched = (done.at_stop >> lane & 1 != 0).then_some(self.searched.side.0[lane]);
            let simulator = &mut self.work.simulators[self.simulator_of[lane]];
            let Some(motion) = &mut self.motions[lane] else { continue };
            self.states.store_state(lane, simulator, &mut motion.advance);
            self.hand_over(simd, lane, touched);
        }
    }

    /// Lanes whose next sub-step may contain samples or maxima.
    #[inline(always)]
    fn reading<S: Simd>(&self, simd: S) -> LaneSet {
        let mut sampled = 0;
        if self.reporting != 0 {
            sampled = self.states.near_sample(simd, &self.systems);
        }
        (sampled & self.reporting) | self.finding
    }

    /// Renews cos θ and sin θ of a motion and checks its limit on work.
    #[inline(never)]
    fn renew(&mut self, lane: usize) {
        let Some(motion) = &mut self.motions[lane] else { return };
        let simulator = &mut self.work.simulators[self.simulator_of[lane]];
        self.states.renew_phase(lane, simulator);
        if self.states.substeps(lane) + simulator.work.substeps <= motion.advance.allowed {
            return;
        }
        self.states.store_state(lane, simulator, &mut motion.advance);
        match simulator.check_work(&mut motion.advance) {
            Ok(()) => self.states.load_state(lane, simulator, &motion.advance),
            refused => self.take_next(lane, Some(refused)),
        }
    }

    /// Advances a motion alone and returns it to its lane; if it has ended, the lane takes the
    /// next motion.
    #[inline(always)]
    fn hand_over<S: Simd>(&mut self, simd: S, lane: usize, touched: Option<f64>) {
        let Some(motion) = &mut self.motions[lane] else { return };
        self.used.handed_over += 1;
        let simulator = &mut self.work.simulators[self.simulator_of[lane]];
        match advance_alone(simd, motion, simulator, (self.work.queue, lane), touched) {
            None => {
                self.states.load_state(lane, simulator, &motion.advance);
                self.states.next_sample.0[lane] =
                    motion.reporter.as_ref().map_or(f64::INFINITY, Reporter::next_sample);
            }
            ended => self.take_next(lane, ended),
        }
    }

    /// Loads a lane with the next motion of the queue that lanes can advance; the motions before
    /// it are advanced alone to their ends. The lane stays empty if there is none.
    #[inline(never)]
    fn take_next(&mut self, lane: usize, mut ended: Option<Result<()>>) {
        let bit: LaneSet = 1 << lane;
        (self.motions[lane], self.states.next_sample.0[lane]) = (None, f64::INFINITY);
        for set in [&mut self.active, &mut self.reporting, &mut self.finding] {
            *set &= !bit;
        }
        self.systems.release_tables(lane);
        while let Some(plan) = self.work.queue.next(lane, self.work.simulators, ended.take()) {
            let simulator = &mut self.work.simulators[plan.simulator];
            let mut motion = match LaneMotion::begin(simulator, &plan, (&mut *self.work.queue, lane)) {
                Ok(Some(motion)) => motion,
                result => {
                    ended = Some(result.map(|_| ()));
                    continue;
                }
            };
            if simulator.loaded() {
                // Lanes have no loads, so this motion is advanced alone to its end.
                ended = advance_loaded(&mut motion, simulator, (&mut *self.work.queue, lane));
                continue;
            }
            self.systems.load_system(lane, simulator, motion.end);
            self.states.load_state(lane, simulator, &motion.advance);
            self.active |= bit;
            if let Some(reporter) = &motion.reporter {
                self.reporting |= bit;
                self.finding |= if reporter.maxima.is_some() { bit } else { 0 };
                self.states.next_sample.0[lane] = reporter.next_sample();
            }
            self.simulator_of[lane] = plan.simulator;
            self.motions[lane] = Some(motion);
            return;
        }
    }
}

/// [`Rounds::report`], not inlined so that it takes no registers from the lanes' loop.
#[inline(never)]
fn report_apart<S: Simd>(simd: S, rounds: &mut Rounds<'_>, done: &Progress) -> LaneSet {
    struct Report<'a, 'w>(&'a mut Rounds<'w>, &'a Progress);
    impl pulp::WithSimd for Report<'_, '_> {
        type Output = LaneSet;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> LaneSet {
            self.0.report(simd, self.1)
        }
    }
    simd.vectorize(Report(rounds, done))
}

/// Set of lanes, the first lane's bit the lowest.
type LaneSet = u64;

/// Lanes of a set, in order.
#[inline(always)]
fn lanes_of(mut set: LaneSet) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = set.trailing_zeros() as usize;
        set &= set.wrapping_sub(1);
        (lane < LaneSet::BITS as usize).then_some(lane)
    })
}

/// [`LaneMotion::advance_alone`], not inlined so that it takes no registers from the lanes' loop.
#[inline(never)]
fn advance_alone<'q, S: Simd>(
    simd: S,
    motion: &mut LaneMotion,
    simulator: &mut Simulator,
    report_to: (&mut (dyn MotionQueue + 'q), usize),
    touched: Option<f64>,
) -> Option<Result<()>> {
    struct Alone<'m, 'q>(
        &'m mut LaneMotion,
        &'m mut Simulator,
        (&'m mut (dyn MotionQueue + 'q), usize),
        Option<f64>,
    );
    impl pulp::WithSimd for Alone<'_, '_> {
        type Output = Option<Result<()>>;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Option<Result<()>> {
            let Self(motion, simulator, report_to, touched) = self;
            motion.advance_alone::<S, 0>(simd, simulator, report_to, touched)
        }
    }
    simd.vectorize(Alone(motion, simulator, report_to, touched))
}

/// Advances a motion under loads to its end, by the code that is compiled once for all instruction
/// sets.
#[inline(never)]
fn advance_loaded(
    motion: &mut LaneMotion,
    simulator: &mut Simulator,
    report_to: (&mut (dyn MotionQueue + '_), usize),
) -> Option<Result<()>> {
    motion.advance_alone::<_, 1>(pulp::Scalar, simulator, report_to, None)
}

/// Observer that stores the events of one law: an impact or a release, and the capture into rest
/// that may follow.
#[inline(always)]
fn keep_in(events: &mut [Option<Event>; 2]) -> impl FnMut(&Event) {
    |event| {
        let first_free = usize::from(events[0].is_some());
        events[first_free] = Some(*event);
    }
}

impl LaneMotion {
    /// Begins a motion and applies the law of an event that is due. `None` if the motion is over:
    /// a motion whose end is the present, and one that lanes cannot advance and that needs no
    /// reports on the way, is advanced to its end at once.
    fn begin(
        simulator: &mut Simulator,
        plan: &Plan,
        report_to: (&mut (dyn MotionQueue + '_), usize),
    ) -> Result<Option<Self>> {
        let end = DoubleDouble::new(plan.end);
        let rounded = simulator.check_end(end)?;
        let mut reporter =
            plan.reports.map(|reports| Reporter::new(simulator, reports, plan.end)).transpose()?;
        if let Some(reporter) = &mut reporter
            && simulator.due_event().is_some()
        {
            let from = SubstepOrigin::from(simulator, &simulator.begin_advance());
            let mut events = [None; 2];
            simulator.apply_due_event(Some(&mut keep_in(&mut events)));
            let after = simulator.augmented();
            // Only a sample could end the motion, and no sample is due yet.
            let _ = reporter.report_alone(simulator, &from, &after, events, report_to);
        }
        let alone = simulator.keeps_energy_accounts || (simulator.loaded() && reporter.is_none());
        if rounded || alone {
            return simulator.advance_until(end, Pause::Never, None).map(|_| None);
        }
        simulator.apply_due_event(None);
        Ok(Some(Self { advance: simulator.begin_advance(), end, reporter }))
    }

    /// Advances this motion by the code for a single motion until its next sub-step suits the
    /// lanes. Returns the result of the motion if it has ended. If the lanes have brought the
    /// block to the stop `touched`, the law of that impact is applied first.
    #[inline(always)]
    fn advance_alone<S: Simd, const LOADS: usize>(
        &mut self,
        simd: S,
        simulator: &mut Simulator,
        (queue, lane): (&mut (dyn MotionQueue + '_), usize),
        touched: Option<f64>,
    ) -> Option<Result<()>> {
        let Self { advance, end, reporter } = self;
        // Lanes renew cos θ and sin θ less often than the code for a single motion.
        advance.since_renewal = advance.since_renewal.min(RENEW);
        let mut law_is_due = touched.is_some();
        loop {
            let from = SubstepOrigin::from(simulator, advance);
            let mut events = [None; 2];
            let going = {
                let mut keep = keep_in(&mut events);
                let mut observer: super::super::EventObserver<'_, '_> =
                    if reporter.is_some() { Some(&mut keep) } else { None };
                if law_is_due {
                    simulator.finish_substep::<LOADS>(advance, touched, Pause::Never, &mut observer)
                } else {
                    simulator.next_substep::<S, LOADS, false>(
                        simd,
                        advance,
                        *end,
                        Pause::Never,
                        &mut observer,
                    )
                }
            };
            law_is_due = false;
            if let Some(reporter) = reporter
                && reporter.report_alone(simulator, &from, &advance.z, events, (queue, lane)).is_break()
            {
                return Some(Ok(()));
            }
            if let ControlFlow::Break(reason) = going {
                return Some(reason.map(|_| ()));
            }
            if simulator.suits_lanes(&advance.z, *end) {
                return None;
            }
        }
    }
}

impl Simulator {
    /// Whether lanes can probably compute the next sub-step: free flight without loads that starts
    /// inside or has just left a stop, with at least a sub-step and an interval left before `end`.
    /// This decides only which code tries first. The lanes prove all that they use.
    #[inline(always)]
    fn suits_lanes(&self, z: &Augmented, end: DoubleDouble) -> bool {
        self.hybrid.contact == Contact::Flight
            && !self.loaded()
            && self.hybrid.departing <= 1
            && self.hybrid.departure.is_none()
            && (self.hybrid.departing == 1 || z[RELATIVE].abs() < self.model.gap)
            && end.minus(self.hybrid.time).value() >= self.substep + self.interval()
    }
}
