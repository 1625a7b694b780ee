//! Many independent motions at a time on one thread, each in a lane of the machine's vectors.
//!
//! Nearly all sub-steps of a motion are of one kind: free flight for a whole sub-step, to its end or to an impact that is
//! easily proved to be the first. These are computed for all lanes at once. Whatever the lanes cannot prove, and all that
//! is not free flight, each motion does by itself with the code of [`step`](super::super::step). Which of the two does a sub-step is
//! decided by the motion's own state, so that its result does not depend on its neighbours.

mod passage;
mod rows;
mod substep;

use super::super::step::{AdvanceState, RENEW};
use super::super::{Contact, Simulator, Stop, StopReason};
use crate::error::Result;
use crate::model::{Augmented, GAP};
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
    pub(super) result: &'a mut Result<()>,
}

/// The work of one thread, to be compiled once for each instruction set.
pub(super) struct Lanes<'a> {
    /// Taken from the back.
    pub(super) waiting: Vec<LaneMotion<'a>>,
}

/// cos θ and sin θ are taken anew after this many sub-steps of a lane, in which they collect no more round-off than the other
/// coordinates, which are never taken anew.
const RENEWAL: u32 = 64;
/// Vectors with fewer places than this gain nothing.
const LEAST: usize = 4;

impl pulp::WithSimd for Lanes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        if S::F64_LANES < LEAST {
            while let Some(mut motion) = self.waiting.pop() {
                while motion.advance_alone(simd, None) {}
            }
            return;
        }
        let mut lanes: [Option<LaneMotion<'_>>; ROW] = [const { None }; ROW];
        let mut systems = Box::new(LaneSystems::zero());
        let mut moving = Box::new(LaneStates::zero());
        let mut live = 0;
        for (lane, place) in lanes.iter_mut().enumerate() {
            *place = self.waiting.pop();
            if let Some(motion) = place {
                systems.load_system(lane, motion.simulator, motion.end);
                moving.take(lane, motion.simulator, &motion.advance);
                live |= 1 << lane;
            }
        }
        while live != 0 {
            for lane in places(moving.stale(simd, f64::from(RENEWAL)) & live) {
                let Some(motion) = &mut lanes[lane] else { continue };
                moving.renew(lane, motion.simulator);
                if moving.substeps.0[lane] as u64 + motion.simulator.work.substeps <= motion.advance.allowed {
                    continue;
                }
                moving.give(lane, motion.simulator, &mut motion.advance);
                if let Err(error) = motion.simulator.check_work(&mut motion.advance) {
                    *motion.result = Err(error);
                    lanes[lane] = self.waiting.pop();
                    match &lanes[lane] {
                        Some(motion) => systems.load_system(lane, motion.simulator, motion.end),
                        None => live &= !(1 << lane),
                    }
                }
                if let Some(motion) = &lanes[lane] {
                    moving.take(lane, motion.simulator, &motion.advance);
                }
            }
            let left = substep::substep(simd, &systems, &mut moving, live);
            for lane in places(left.behind | left.touching) {
                let Some(motion) = &mut lanes[lane] else { continue };
                moving.give(lane, motion.simulator, &mut motion.advance);
                let side = (left.touching >> lane & 1 != 0).then_some(left.side.0[lane]);
                if !advance_alone(simd, motion, side) {
                    lanes[lane] = self.waiting.pop();
                    match &lanes[lane] {
                        Some(motion) => systems.load_system(lane, motion.simulator, motion.end),
                        None => live &= !(1 << lane),
                    }
                }
                if let Some(motion) = &lanes[lane] {
                    moving.take(lane, motion.simulator, &motion.advance);
                }
            }
        }
    }
}

/// The places of motions in a row, as bits.
type Places = u64;

#[inline(always)]
fn places(mut bits: Places) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let place = bits.trailing_zeros() as usize;
        bits &= bits.wrapping_sub(1);
        (place < Places::BITS as usize).then_some(place)
    })
}

/// [`LaneMotion::advance_alone`] out of the lanes' way.
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
    /// Goes on by its own code until the next sub-step looks like one for the lanes; false at the end of the advance. It
    /// begins with the impact at a stop just `touched`, if there is one.
    #[inline(always)]
    fn advance_alone<S: Simd>(&mut self, simd: S, touched: Option<f64>) -> bool {
        let Self { simulator, advance, end, result } = self;
        advance.since_renewal = advance.since_renewal.min(RENEW);
        let mut going = match touched {
            Some(_) => simulator.finish_substep::<0>(advance, touched, Stop::Never, &mut None),
            None => simulator.next_substep::<S, 0, false>(simd, advance, *end, Stop::Never, &mut None),
        };
        loop {
            if let ControlFlow::Break(reason) = going {
                **result = reason.map(|_: StopReason| ());
                return false;
            }
            if simulator.suits_lanes(&advance.z, *end) {
                return true;
            }
            going = simulator.next_substep::<S, 0, false>(simd, advance, *end, Stop::Never, &mut None);
        }
    }
}

impl Simulator {
    /// Whether the next sub-step looks like one of free flight that lies whole before `end`, from inside or just off a stop.
    #[inline(always)]
    fn suits_lanes(&self, z: &Augmented, end: DoubleDouble) -> bool {
        self.hybrid.contact == Contact::Flight
            && self.hybrid.departing <= 1
            && (self.hybrid.departing == 1 || z[GAP].abs() < self.model.gap)
            && end.minus(self.hybrid.time).value() >= self.substep + self.interval()
    }
}
