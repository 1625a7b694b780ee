//! Many independent motions in one call, side by side in the machine's vectors where that is
//! faster.
//!
//! | file | content |
//! |---|---|
//! | `mod.rs` | [`advance_queue`] and, for motions that all exist at once, [`advance_together`] |
//! | `queue.rs` | sources of motions, reports of motions, use of the lanes |
//! | `lanes.rs` | the loop over sub-steps, and how a motion enters, leaves and comes back to its lane |
//! | `lanes/rows.rs` | the motions' numbers, the same number of all motions side by side |
//! | `lanes/substep.rs` | one sub-step of all lanes |
//! | `lanes/centres.rs` | states at interval centres, motion by motion, read by vectors |
//! | `lanes/passage.rs` | series of the free flight, the gap's first zero and the proofs about it, in lanes |
//! | `lanes/report.rs` | samples and events of the motions in lanes and alone |
//! | `lanes/maxima.rs` | local maxima of a displacement |
//! | `vectors.rs` | vectors with operators |
//!
//! Why each part is right is in docs/numerics.md, "Many motions side by side"; which results are
//! bit-identical is in docs/guarantees.md.

mod lanes;
mod queue;
pub(crate) mod vectors;

pub use self::queue::{LaneUse, Maximum, MotionQueue, Plan, Reports};

use self::lanes::Lanes;
use super::Simulator;
use crate::error::Result;

/// Number of lanes: motions under way at a time on one thread.
pub const TOGETHER: usize = vectors::ROW;

/// Advances the motions of a queue until the queue is empty. A lane whose motion has ended takes
/// the next one, without allocation. A motion and its reports depend neither on the other motions
/// nor on their order or number.
///
/// Motions that keep their energy accounts or are under loads are advanced one by one. Reports
/// switch the accounts off. Reports under loads other than the constant ones of the parameters are
/// refused with [`Error::OutOfRange`](crate::Error::OutOfRange), which `next` receives.
///
/// # Panics
/// If a plan names a simulator that does not exist.
pub fn advance_queue(simulators: &mut [Simulator], queue: &mut dyn MotionQueue) -> LaneUse {
    advance_queue_by(Way::Together, simulators, queue)
}

/// Ways to advance a queue, for comparisons of results and speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Way {
    /// Side by side in the widest vectors of the machine, as [`advance_queue`] does.
    #[default]
    Together,
    /// One motion after another by the code for a single motion, all in lane 0, as
    /// [`advance_queue`] does on machines without wide vectors.
    OneByOne,
    /// [`Together`](Self::Together) in vectors of AVX2, on a machine that has wider ones.
    TogetherAvx2,
    /// [`OneByOne`](Self::OneByOne) with AVX2.
    OneByOneAvx2,
}

/// [`advance_queue`] in a given way. On a machine without AVX2 the ways with AVX2 use the vectors
/// that the machine has.
///
/// # Panics
/// As [`advance_queue`].
pub fn advance_queue_by(way: Way, simulators: &mut [Simulator], queue: &mut dyn MotionQueue) -> LaneUse {
    let one_by_one = matches!(way, Way::OneByOne | Way::OneByOneAvx2);
    let lanes = Lanes { simulators, queue, one_by_one };
    #[cfg(target_arch = "x86_64")]
    if let (Way::TogetherAvx2 | Way::OneByOneAvx2, Some(avx2)) = (way, pulp::x86::V3::try_new()) {
        return pulp::Simd::vectorize(avx2, lanes);
    }
    pulp::Arch::new().dispatch(lanes)
}

/// Advances each simulator to its `end` (s), as [`Simulator::advance_to`] does. The results are in
/// the simulators' order; an error of one motion does not touch the others.
///
/// On machines with AVX2 or AVX-512 the motions lie side by side in the vectors. Compared with
/// `advance_to` for one motion after another, one or two motions take longer, about three or more
/// take less time, and eight or more take less than half the time, unless the motions rest for
/// much of their time. Motions that keep their energy accounts or are under loads are advanced one
/// by one.
///
/// The results are as accurate as after `advance_to`, and the impacts are proved in an equivalent
/// way. The bits may differ from the bits after `advance_to`: the operations have another order,
/// and differences in the last digits grow like any difference in a motion with impacts. The
/// result depends neither on the other motions nor on their order or number.
///
/// ```
/// use vibro_impact::simulator::advance_together;
/// use vibro_impact::{Parameters, Simulator, State};
///
/// let first = Simulator::new(&Parameters::default(), &State::default(), 0.0)?;
/// let first = first.without_energy_accounts();
/// let start = |x2: f64| first.with_state(&State { x: [0.0, x2, 0.0], v: [0.0; 3] }, 0.0);
/// let mut motions = [-0.5, 0.0, 0.5, 0.9].map(|x2| start(x2).expect("inside the box"));
/// for result in advance_together(&mut motions, |_| 100.0) {
///     result?;
/// }
/// assert!(motions.iter().all(|motion| motion.time() == 100.0));
/// # Ok::<(), vibro_impact::Error>(())
/// ```
pub fn advance_together(simulators: &mut [Simulator], end: impl Fn(&Simulator) -> f64) -> Vec<Result<()>> {
    /// Queue that supplies each simulator once, in order.
    struct Each<F> {
        end: F,
        next: usize,
        under_way: [usize; TOGETHER],
        results: Vec<Result<()>>,
    }

    impl<F: Fn(&Simulator) -> f64> MotionQueue for Each<F> {
        fn next(
            &mut self,
            lane: usize,
            simulators: &mut [Simulator],
            ended: Option<Result<()>>,
        ) -> Option<Plan> {
            if let Some(result) = ended {
                self.results[self.under_way[lane]] = result;
            }
            let index = self.next;
            let end = (self.end)(simulators.get(index)?);
            self.next += 1;
            self.under_way[lane] = index;
            Some(Plan { simulator: index, end, reports: None })
        }
    }

    let results = vec![Ok(()); simulators.len()];
    let mut each = Each { end, next: 0, under_way: [0; TOGETHER], results };
    advance_queue(simulators, &mut each);
    each.results
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulator::{Loads, State};
    use crate::{Parameters, Simulator};

    #[test]
    fn invariant_accounts_and_loads_have_the_bits_of_one_by_one() {
        /// Some hundred impacts, long enough for a difference in the last digit to grow.
        const END: f64 = 300.0;
        let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
        let accounts = Simulator::new(&Parameters::default(), &start, 0.0).unwrap();
        let mut loaded = accounts.clone().without_energy_accounts();
        loaded.set_loads(&Loads { derivatives: [[0.0; 4], [0.02, 1e-5, 0.0, 0.0], [0.0; 4]] }).unwrap();
        let in_a_lane = accounts.clone().without_energy_accounts();
        let mut together = [in_a_lane, accounts.clone(), loaded.clone()];
        assert!(advance_together(&mut together, |_| END).iter().all(Result::is_ok));
        for (together, mut alone) in together[1..].iter().zip([accounts, loaded]) {
            alone.advance_to(END).unwrap();
            assert!(alone.impacts().upper > 0);
            assert_eq!(alone.snapshot(), together.snapshot());
        }
    }
}
