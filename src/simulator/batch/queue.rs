//! What the lanes take their motions from, and what they report on the way.

use crate::error::Result;
use crate::model::Augmented;
use crate::simulator::{Event, Simulator};
use crate::state::State;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// What is to be done with a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// The index of its simulator.
    pub simulator: usize,
    /// Where it ends, s.
    pub end: f64,
    /// What is reported on the way.
    pub reports: Option<Reports>,
}

/// What is reported of a motion: its state at regular times, all its events and, if asked for, the
/// local maxima of a displacement. The motion itself has the same bits with and without; one that
/// keeps its energy accounts, which reports switch off, then has those of the motion without
/// accounts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reports {
    /// Sample k, counted from 1, is taken at `origin + k step`, s, as long as that is after the
    /// motion's start and not after its end. An infinite `origin` asks for none.
    pub origin: f64,
    /// The time between two samples, s; greater than zero.
    pub step: f64,
    /// The number of the first sample. [`u32::MAX`] leaves all out until an
    /// [event](MotionQueue::event) asks for one.
    pub first: u32,
    /// The weights of x1, x2 and x3 in the displacement whose maxima are reported, if any are. The
    /// way before the motion's start is not known: one that starts while the block rests at the
    /// upper stop, or within rounding of its departure, may have one maximum of w more or less
    /// there.
    pub maxima_of: Option<[f64; 3]>,
}

/// A local maximum of a displacement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Maximum {
    /// When, s.
    pub time: f64,
    /// The displacement there, m.
    pub value: f64,
    /// Whether it is a corner: at an impact.
    pub corner: bool,
}

/// A supply of motions, which also receives their reports. `lane` is under
/// [`TOGETHER`](super::TOGETHER), and each lane has one motion at a time.
///
/// What is reported of a motion comes in the order of its sub-steps. Of one sub-step the maxima
/// come first, then the samples, then its event; where the order matters, their times tell it.
pub trait MotionQueue {
    /// Takes note of how the motion in a lane has `ended`, if there was one, and sets up the next
    /// motion for this lane in one of the simulators, which no other lane is at work on. `None`
    /// leaves the lane empty for good.
    fn next(&mut self, lane: usize, simulators: &mut [Simulator], ended: Option<Result<()>>) -> Option<Plan>;

    /// The state at sample `number`, counted from 1; an impact at that very time has not yet
    /// happened. Returns the number of the next sample, a larger one, or a break: then nothing more
    /// is asked of this motion, which has ended well. Its simulator has not been brought to that
    /// time, and is to be [restarted](Simulator::restart) or given another state before it is used.
    fn sample(&mut self, lane: usize, number: u32, state: &State) -> ControlFlow<(), u32> {
        let _ = (lane, state);
        ControlFlow::Continue(number + 1)
    }

    /// An event and the augmented state after its law: x1, w, x3, their rates, cos θ and sin θ. A
    /// number that is returned is that of the next sample, or of the first after it that is not yet
    /// past.
    fn event(&mut self, lane: usize, event: &Event, after: &Augmented) -> Option<u32> {
        let _ = (lane, event, after);
        None
    }

    /// A local maximum.
    fn maximum(&mut self, lane: usize, maximum: &Maximum) {
        let _ = (lane, maximum);
    }
}

/// How the lanes were used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LaneUse {
    /// Rounds: times that all lanes were looked at.
    pub rounds: u64,
    /// Lanes with a motion, summed over the rounds.
    pub occupied: u64,
    /// Sub-steps done in lanes.
    pub substeps: u64,
    /// Times that a motion was passed to the code for a single one, for one sub-step or more.
    pub handed_over: u64,
}

impl LaneUse {
    /// The part of the lanes' places in all rounds that were occupied.
    pub fn occupation(&self) -> f64 {
        self.occupied as f64 / (self.rounds.max(1) * super::TOGETHER as u64) as f64
    }

    /// The part of the lanes' places in all rounds that moved a motion. The others were empty or
    /// handed over.
    pub fn utilisation(&self) -> f64 {
        self.substeps as f64 / (self.rounds.max(1) * super::TOGETHER as u64) as f64
    }
}

impl std::ops::AddAssign for LaneUse {
    fn add_assign(&mut self, other: Self) {
        self.rounds += other.rounds;
        self.occupied += other.occupied;
        self.substeps += other.substeps;
        self.handed_over += other.handed_over;
    }
}
