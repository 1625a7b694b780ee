//! An advance takes sub-steps one after another, each to its end or to its first event, and
//! applies the law of that event. The work of an advance is limited.

use super::general::{MAX_REACH, SHORT};
use super::{AdvanceOutcome, Contact, DueEvent, Event, ModeTables, Pause, Simulator};
use crate::error::{Error, Result};
use crate::flow::INTERVALS;
use crate::model::{Augmented, BOX_RATE, DRIVE_COS, DRIVE_SIN, RELATIVE, RELATIVE_RATE};
use pulp::Simd;
use std::ops::ControlFlow;
use vibro_numerics::double_double::DoubleDouble;
use vibro_numerics::simd;

/// Number of sub-steps (about ten drive periods) between two computations of cos θ and sin θ from
/// the extended phase. The rotations in between add a few units in the last place.
pub(super) const RENEW: u32 = 32;
/// Number of sub-steps allowed for an advance whose motion hardly progresses. The progress is
/// small if sub-steps end at events or are cut short because the block is fast. Such a sub-step
/// takes 0.4 µs (bounces on a stop) to 0.9 µs (a fast block under loads), so that the advance ends
/// within about a second.
const WORK_BASE: u64 = 1_000_000;
/// Number of further sub-steps allowed for each sub-step length of progress. An ordinary motion,
/// with an impact or two in that time, takes 1 to 3 sub-steps, far below the limit. A bounce takes
/// one sub-step of a single motion. In lanes it takes two sub-steps if it is longer than 0.6
/// intervals. 27 such bounces fit into a sub-step length. The limit of 64 is above twice that
/// number, so that a motion ends in the same way alone and in lanes.
const WORK_PER_SUBSTEP: f64 = 64.0;

/// Data that an advance carries from sub-step to sub-step; the state fills one cache line.
#[repr(C, align(64))]
pub(super) struct AdvanceState {
    pub(super) z: Augmented,
    /// Sub-steps since cos θ and sin θ were last computed from the phase.
    pub(super) since_renewal: u32,
    /// Start of the flight whose drive work is computed as a difference
    /// ([`Simulator::open_account`]).
    pub(super) flown_from: DoubleDouble,
    /// Time at the beginning of the advance.
    begin: DoubleDouble,
    /// Count of sub-steps at the beginning of the advance.
    substeps_before: u64,
    /// Count of events at the beginning of the advance.
    events_before: u64,
    /// Largest allowed count of sub-steps, for the time reached at the last check.
    pub(super) allowed: u64,
}

/// Arguments of the code of an advance, which is compiled once for each instruction set.
struct DispatchedAdvance<'a, 'b, const ACCOUNTS: bool> {
    simulator: &'a mut Simulator,
    end: DoubleDouble,
    pause: Pause,
    observer: EventObserver<'a, 'b>,
}

/// Optional function that is shown each event in order of time.
pub type EventObserver<'a, 'b> = Option<&'a mut (dyn FnMut(&Event) + 'b)>;

impl<const ACCOUNTS: bool> pulp::WithSimd for DispatchedAdvance<'_, '_, ACCOUNTS> {
    type Output = Result<AdvanceOutcome>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let Self { simulator, end, pause, observer } = self;
        simulator.run_as::<S, 0, ACCOUNTS>(simd, end, pause, observer)
    }
}

impl Simulator {
    /// Advances to `end`; see [`Simulator::advance_until`].
    pub(super) fn run(
        &mut self,
        end: DoubleDouble,
        pause: Pause,
        observer: EventObserver<'_, '_>,
    ) -> Result<AdvanceOutcome> {
        match (self.loaded(), self.keeps_energy_accounts) {
            (false, false) => self.dispatch::<false>(end, pause, observer),
            (false, true) => self.dispatch::<true>(end, pause, observer),
            // Under loads every sub-step is a general one, which checks at run time whether
            // accounts are kept.
            (true, _) => self.run_as::<_, 1, false>(pulp::Scalar, end, pause, observer),
        }
    }

    /// Runs the code compiled for the best instruction set of this machine.
    #[inline(never)]
    fn dispatch<const ACCOUNTS: bool>(
        &mut self,
        end: DoubleDouble,
        pause: Pause,
        observer: EventObserver<'_, '_>,
    ) -> Result<AdvanceOutcome> {
        pulp::Arch::new().dispatch(DispatchedAdvance::<ACCOUNTS> { simulator: self, end, pause, observer })
    }

    #[inline(always)]
    fn run_as<S: Simd, const LOADS: usize, const ACCOUNTS: bool>(
        &mut self,
        simd: S,
        end: DoubleDouble,
        pause: Pause,
        mut observer: EventObserver<'_, '_>,
    ) -> Result<AdvanceOutcome> {
        let mut advance = self.begin_advance();
        // Drive work in a flight without loads is a difference of values.
        let by_difference = ACCOUNTS && LOADS == 0;
        if by_difference {
            self.open_account(&mut advance);
        }
        loop {
            let going =
                self.next_substep::<S, LOADS, ACCOUNTS>(simd, &mut advance, end, pause, &mut observer);
            if let ControlFlow::Break(reason) = going {
                if by_difference {
                    if self.hybrid.contact == Contact::Flight {
                        self.close_account(&advance);
                    }
                    self.hybrid.sums.settle(&mut self.pending);
                }
                return reason;
            }
        }
    }

    /// Data of an advance from the present state.
    #[inline(always)]
    pub(super) fn begin_advance(&self) -> AdvanceState {
        let time = self.hybrid.time;
        let substeps_before = self.work.substeps;
        AdvanceState {
            z: self.augmented(),
            since_renewal: 0,
            flown_from: time,
            begin: time,
            substeps_before,
            events_before: self.work.events,
            allowed: substeps_before + WORK_BASE,
        }
    }

    /// One sub-step of an advance, with the law of its event; breaks at the end of the advance.
    #[inline(always)]
    pub(super) fn next_substep<S: Simd, const LOADS: usize, const ACCOUNTS: bool>(
        &mut self,
        simd: S,
        advance: &mut AdvanceState,
        end: DoubleDouble,
        pause: Pause,
        observer: &mut EventObserver<'_, '_>,
    ) -> ControlFlow<Result<AdvanceOutcome>> {
        // Far from the end the leading parts are accurate enough; near the end all digits are
        // needed.
        let mut remaining = end.hi - self.hybrid.time.hi;
        if remaining <= 2.0 * self.substep {
            remaining = end.minus(self.hybrid.time).value();
        }
        if remaining <= 0.0 {
            self.keep_state(&advance.z);
            self.hybrid.time = end;
            return ControlFlow::Break(Ok(AdvanceOutcome::End));
        }
        self.renew(advance);
        let mut departing = None;
        if self.is_departing(remaining) {
            departing = Some(self.return_to_departure(&mut advance.z));
            remaining = end.minus(self.hybrid.time).value();
        }
        let passage = self.substep::<S, LOADS, ACCOUNTS>(simd, &mut advance.z, remaining, end);
        if let Some(begun) = &departing {
            self.keep_departure(&mut advance.z, begun, passage, end);
        }
        let (contact, speed) = (self.hybrid.contact, advance.z[BOX_RATE]);
        let going = self.finish_substep::<LOADS>(advance, passage, pause, observer);
        if ACCOUNTS && LOADS == 0 && passage.is_some() {
            self.account_event(advance, contact, speed);
        }
        going
    }

    /// Every [`RENEW`] sub-steps computes cos θ and sin θ from the phase and adds the pending
    /// energies to the sums.
    #[inline(always)]
    pub(super) fn renew(&mut self, advance: &mut AdvanceState) {
        if advance.since_renewal == RENEW {
            (advance.z[DRIVE_SIN], advance.z[DRIVE_COS]) = self.sine_and_cosine();
            advance.since_renewal = 0;
            self.hybrid.sums.settle(&mut self.pending);
        }
        advance.since_renewal += 1;
    }

    /// sin θ and cos θ from the drive's phase; not inlined, so that the frequent path stays short.
    #[cold]
    #[inline(never)]
    fn sine_and_cosine(&self) -> (f64, f64) {
        self.drive_phase().sin_cos()
    }

    /// Ends a sub-step: applies the law of the event at stop `passage`, if there is one, and
    /// checks the work done.
    #[inline(always)]
    pub(super) fn finish_substep<const LOADS: usize>(
        &mut self,
        advance: &mut AdvanceState,
        passage: Option<f64>,
        pause: Pause,
        observer: &mut EventObserver<'_, '_>,
    ) -> ControlFlow<Result<AdvanceOutcome>> {
        if let Some(side) = passage {
            if pause == Pause::BeforeEvent {
                return ControlFlow::Break(Ok(self.pause_before_event(advance, side)));
            }
            self.work.events += 1;
            let impact = self.apply_event_law::<LOADS>(&mut advance.z, side, observer);
            if impact && pause == Pause::AfterImpact {
                self.keep_state(&advance.z);
                return ControlFlow::Break(Ok(AdvanceOutcome::Impact));
            }
        }
        if self.work.substeps > advance.allowed
            && let Err(error) = self.check_work(advance)
        {
            return ControlFlow::Break(Err(error));
        }
        ControlFlow::Continue(())
    }

    /// Computes the allowed count of sub-steps for the time reached.
    ///
    /// # Errors
    /// [`Error::WorkLimit`] if it is exceeded; the state then belongs to the time reached.
    #[cold]
    pub(super) fn check_work(&mut self, advance: &mut AdvanceState) -> Result<()> {
        let span = self.hybrid.time.minus(advance.begin).value();
        let further = WORK_PER_SUBSTEP * (span / self.substep);
        advance.allowed = advance.substeps_before + WORK_BASE + further as u64;
        if self.work.substeps <= advance.allowed {
            return Ok(());
        }
        self.keep_state(&advance.z);
        Err(Error::WorkLimit {
            time: self.time(),
            span,
            events: self.work.events - advance.events_before,
            restitution: self.model.restitution,
            path: self.hybrid.y[4].abs() * self.substep / self.model.gap,
        })
    }

    /// Stores the state at which an advance ends. Just before an impact, or just after the block
    /// has passed close to a stop, the rounding of w can leave the block past the stop. The block
    /// is then put on the stop, so that a motion may begin there. An impact that is imminent is
    /// the first event of the next advance.
    #[inline(always)]
    fn keep_state(&mut self, z: &Augmented) {
        self.hybrid.y.copy_from_slice(&z[..6]);
        let gap = self.model.gap;
        self.hybrid.y[RELATIVE] = z[RELATIVE].clamp(-gap, gap);
    }

    /// Ends an advance at an event whose law is not yet applied: w and w' become the exact left
    /// limits, on which the law acts.
    #[cold]
    fn pause_before_event(&mut self, advance: &mut AdvanceState, side: f64) -> AdvanceOutcome {
        let z = &mut advance.z;
        z[RELATIVE] = side * self.model.gap;
        let stop = side as i8;
        self.hybrid.due = Some(if self.hybrid.contact == Contact::Flight {
            z[RELATIVE_RATE] = side * (side * z[RELATIVE_RATE]).max(0.0);
            DueEvent::Impact { side: stop }
        } else {
            z[RELATIVE_RATE] = 0.0;
            DueEvent::Release { side: stop }
        });
        self.keep_state(&advance.z);
        AdvanceOutcome::EventDue
    }

    #[inline(always)]
    pub(super) fn tables(&self) -> &ModeTables {
        match self.hybrid.contact {
            Contact::Flight => &self.flight,
            _ => &self.rest,
        }
    }

    /// One sub-step of at most `remaining` s; returns the stop at which an event was reached.
    #[inline(always)]
    fn substep<S: Simd, const LOADS: usize, const ACCOUNTS: bool>(
        &mut self,
        simd: S,
        z: &mut Augmented,
        remaining: f64,
        end: DoubleDouble,
    ) -> Option<f64> {
        self.work.substeps += 1;
        if LOADS == 0 && self.hybrid.contact == Contact::Flight && !self.is_doubtful() {
            let interval = self.interval();
            let bound = simd::weigh::<S>(z, &self.flight.core.bound);
            if !self.exceeds_reach(z, bound) {
                if remaining > interval {
                    return self.flight_substep::<S, ACCOUNTS>(simd, z, bound, remaining, end);
                }
                // The shortest steps need `general_substep`, which sums their changes separately.
                if remaining >= SHORT * interval
                    && self.short_flight_substep::<S, ACCOUNTS>(simd, z, bound, remaining, end)
                {
                    return None;
                }
            }
        }
        let (arrived, side) = self.general_substep::<LOADS>(*z, remaining, end);
        *z = arrived;
        side
    }

    /// Length of an interval, s.
    #[inline(always)]
    pub(super) fn interval(&self) -> f64 {
        self.substep * (1.0 / INTERVALS as f64)
    }

    /// Whether the block in flight meets no stop in the first interval, given that the sample at
    /// the interval's end is within `limit`. This holds if the block also starts within `limit`.
    /// It holds as well if the block leaves a stop so fast that its acceleration, at most `bound`,
    /// cannot turn it back in the interval.
    #[inline(always)]
    pub(super) fn clears_first_interval(&self, z: &Augmented, bound: f64, limit: f64) -> bool {
        match self.hybrid.departing {
            0 => z[RELATIVE].abs() < limit,
            1 => z[RELATIVE_RATE].abs() > 0.5 * bound * self.interval(),
            _ => false,
        }
    }

    /// Whether the block's path in an interval may exceed [`MAX_REACH`] gaps, so that the interval
    /// cannot be searched as a whole.
    #[inline(always)]
    pub(super) fn exceeds_reach(&self, z: &Augmented, bound: f64) -> bool {
        let interval = self.interval();
        z[RELATIVE_RATE].abs() * interval + 0.5 * bound * interval * interval > MAX_REACH * self.model.gap
    }
}
