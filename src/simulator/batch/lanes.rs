//! Many independent motions at a time on one thread, each in a lane of the machine's vectors.
//!
//! Nearly all sub-steps of a motion are of one kind: free flight for a whole sub-step, to its end or to an impact that is
//! easily proved to be the first. These are computed for all lanes at once. Whatever the lanes cannot prove, and all that
//! is not free flight, is computed for each motion alone with the code of [`step`](super::super::step). Which of the two
//! computes a sub-step is decided by the motion's own state, so its result does not depend on its neighbours.

mod passage;
mod rows;
mod substep;

use super::super::step::{AdvanceState, RENEW};
use super::super::{AdvanceOutcome, Contact, Pause, Simulator};
use crate::error::Result;
use crate::model::{Augmented, RELATIVE};
use crate::numerics::double_double::DoubleDouble;
use crate::simulator::batch::vectors::ROW;
use pulp::Simd;
use rows::{LaneStates, LaneSystems};
use std::ops::ControlFlow;

/// A motion under way.
pub(super) struct LaneMotion<'a> {
    pub(super) simulator: &'a mut Simulator,
    pub(super) advance: AdvanceState,
    pub(super) end: DoubleDouble,
    /// Where the result goes once the advance is over.
    pub(super) result: &'a mut Result<()>,
}

/// The work of one thread, to be compiled once for each instruction set.
pub(super) struct Lanes<'a> {
    /// The motions without a lane; the next one is the last of them.
    pub(super) waiting: Vec<LaneMotion<'a>>,
}

/// cos θ and sin θ are computed anew from the extended phase after this many sub-steps in a lane. The other coordinates are
/// never renewed, and in so many sub-steps these two collect no more round-off than they do.
const RENEWAL: u32 = 64;
/// On machines whose vectors have fewer lanes nothing is gained, and all motions are advanced alone.
const FEWEST_LANES: usize = 4;

impl pulp::WithSimd for Lanes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        if S::F64_LANES < FEWEST_LANES {
            while let Some(mut motion) = self.waiting.pop() {
                while motion.advance_alone(simd, None) {}
            }
            return;
        }
        let mut lanes: [Option<LaneMotion<'_>>; ROW] = [const { None }; ROW];
        let mut systems = Box::new(LaneSystems::zero());
        let mut states = Box::new(LaneStates::zero());
        let mut active: LaneSet = 0;
        for (lane, place) in lanes.iter_mut().enumerate() {
            if self.load_lane(false, &mut systems, &mut states, lane, place) {
                active |= 1 << lane;
            }
        }
        while active != 0 {
            // Whether a motion gets on is checked as often as its phase is renewed.
            for lane in lanes_of(states.due_for_renewal(simd, f64::from(RENEWAL)) & active) {
                let Some(motion) = &mut lanes[lane] else { continue };
                states.renew_phase(lane, motion.simulator);
                if states.substeps(lane) + motion.simulator.work.substeps <= motion.advance.allowed {
                    continue;
                }
                states.store_state(lane, motion.simulator, &mut motion.advance);
                *motion.result = motion.simulator.check_work(&mut motion.advance);
                let goes_on = motion.result.is_ok();
                if !self.load_lane(goes_on, &mut systems, &mut states, lane, &mut lanes[lane]) {
                    active &= !(1 << lane);
                }
            }
            let left = substep::flight_substep(simd, &systems, &mut states, active);
            for lane in lanes_of(left.unproved | left.at_stop) {
                let Some(motion) = &mut lanes[lane] else { continue };
                states.store_state(lane, motion.simulator, &mut motion.advance);
                let touched = (left.at_stop >> lane & 1 != 0).then_some(left.side.0[lane]);
                let goes_on = advance_alone(simd, motion, touched);
                if !self.load_lane(goes_on, &mut systems, &mut states, lane, &mut lanes[lane]) {
                    active &= !(1 << lane);
                }
            }
        }
    }
}

impl<'a> Lanes<'a> {
    /// Loads a lane with the motion in it if that `goes_on`, else with the next waiting one, if there is any. False when the lane
    /// stays empty.
    #[inline(always)]
    fn load_lane(
        &mut self,
        goes_on: bool,
        systems: &mut LaneSystems,
        states: &mut LaneStates,
        lane: usize,
        place: &mut Option<LaneMotion<'a>>,
    ) -> bool {
        if !goes_on {
            *place = self.waiting.pop();
        }
        let Some(motion) = place else { return false };
        if !goes_on {
            systems.load_system(lane, motion.simulator, motion.end);
        }
        states.load_state(lane, motion.simulator, &motion.advance);
        true
    }
}

/// A set of lanes, the first lane's bit the lowest.
type LaneSet = u64;

/// The lanes of a set, in order.
#[inline(always)]
fn lanes_of(mut set: LaneSet) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let lane = set.trailing_zeros() as usize;
        set &= set.wrapping_sub(1);
        (lane < LaneSet::BITS as usize).then_some(lane)
    })
}

/// [`LaneMotion::advance_alone`] as a function of its own, so that its code takes no registers from the lanes' loop.
#[inline(never)]
fn advance_alone<S: Simd>(simd: S, motion: &mut LaneMotion<'_>, touched: Option<f64>) -> bool {
    struct Alone<'m, 'a>(&'m mut LaneMotion<'a>, Option<f64>);
    impl pulp::WithSimd for Alone<'_, '_> {
        type Output = bool;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> bool {
            self.0.advance_alone(simd, self.1)
        }
    }
    simd.vectorize(Alone(motion, touched))
}

impl LaneMotion<'_> {
    /// Advances this motion by the code for a single one until its next sub-step suits the lanes; false when the advance is
    /// over and its result is set. Where the lanes have brought the block to the stop `touched` without applying the law
    /// of the impact, it begins with that law.
    #[inline(always)]
    fn advance_alone<S: Simd>(&mut self, simd: S, touched: Option<f64>) -> bool {
        let Self { simulator, advance, end, result } = self;
        // The lanes renew cos θ and sin θ less often than the code for a single motion does.
        advance.since_renewal = advance.since_renewal.min(RENEW);
        let mut going = match touched {
            Some(_) => simulator.finish_substep::<0>(advance, touched, Pause::Never, &mut None),
            None => simulator.next_substep::<S, 0, false>(simd, advance, *end, Pause::Never, &mut None),
        };
        loop {
            if let ControlFlow::Break(reason) = going {
                **result = reason.map(|_: AdvanceOutcome| ());
                return false;
            }
            if simulator.suits_lanes(&advance.z, *end) {
                return true;
            }
            going = simulator.next_substep::<S, 0, false>(simd, advance, *end, Pause::Never, &mut None);
        }
    }
}

impl Simulator {
    /// Whether the next sub-step is likely to be one for the lanes: free flight from inside or just off a stop, with a whole
    /// sub-step and an interval to go before `end`. The lanes prove what they need themselves; this only decides who tries
    /// first.
    #[inline(always)]
    fn suits_lanes(&self, z: &Augmented, end: DoubleDouble) -> bool {
        self.hybrid.contact == Contact::Flight
            && self.hybrid.departing <= 1
            && (self.hybrid.departing == 1 || z[RELATIVE].abs() < self.model.gap)
            && end.minus(self.hybrid.time).value() >= self.substep + self.interval()
    }
}
