//! The queue that supplies the lanes with motions and receives their reports.

use crate::error::Result;
use crate::model::Augmented;
use crate::simulator::{Event, Simulator};
use crate::state::State;
use serde::{Deserialize, Serialize};
use std::ops::ControlFlow;

/// Plan of a motion: its simulator, its end and its reports.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// Index of the simulator.
    pub simulator: usize,
    /// End of the motion, s.
    pub end: f64,
    /// Reports on the way.
    pub reports: Option<Reports>,
}

/// Reports of a motion: its state at regular times, all its events and, on request, the local
/// maxima of a displacement. Reports do not change the bits of a motion, except that they switch
/// its energy accounts off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reports {
    /// Origin of the samples: sample k, counted from 1, is taken at `origin + k step`, s, if that
    /// is after the motion's start and not after its end. If `origin` is infinite, no samples are
    /// taken.
    pub origin: f64,
    /// Time between two samples, s; greater than zero.
    pub step: f64,
    /// Number of the first sample. If it is [`u32::MAX`], no sample is taken until an
    /// [event](MotionQueue::event) sets the number of the next one.
    pub first: u32,
    /// Weights of x1, x2 and x3 in the displacement whose maxima are reported; `None` for no
    /// maxima. The motion before the start is unknown. If the block rests at the upper stop at the
    /// start, or is within rounding of its departure, the reports may contain one maximum of w
    /// more or less at the start.
    pub maxima_of: Option<[f64; 3]>,
}

/// A local maximum of a displacement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Maximum {
    /// Time, s.
    pub time: f64,
    /// Displacement, m.
    pub value: f64,
    /// Whether the maximum is a corner, at an impact.
    pub corner: bool,
}

/// A supply of motions, which also receives their reports. `lane` is less than
/// [`TOGETHER`](super::TOGETHER), and each lane has one motion at a time.
///
/// The reports of a motion come in the order of its sub-steps. Within a sub-step the maxima come
/// first, then the samples, then the event, whatever their times.
pub trait MotionQueue {
    /// Receives the result `ended` of the last motion in a lane, if there was one, and sets up the
    /// next motion for this lane in a simulator that no other lane uses. `None` leaves the lane
    /// empty for good.
    fn next(&mut self, lane: usize, simulators: &mut [Simulator], ended: Option<Result<()>>) -> Option<Plan>;

    /// Receives the state at sample `number`, counted from 1. If an impact occurs at exactly that
    /// time, the state is that before the impact. Returns the number of the next sample, which
    /// must be larger, or a break, which ends the motion without an error. After a break the
    /// simulator is not at the sample's time: it must be [restarted](Simulator::restart) or given
    /// another state before it is used.
    fn sample(&mut self, lane: usize, number: u32, state: &State) -> ControlFlow<(), u32> {
        let _ = (lane, state);
        ControlFlow::Continue(number + 1)
    }

    /// Receives an event and the augmented state after its law: x1, w, x3, their rates, cos θ and
    /// sin θ. Returns the number of the next sample if it is to change. If that sample is already
    /// past, the next one is the first sample that is not.
    fn event(&mut self, lane: usize, event: &Event, after: &Augmented) -> Option<u32> {
        let _ = (lane, event, after);
        None
    }

    /// Receives a local maximum.
    fn maximum(&mut self, lane: usize, maximum: &Maximum) {
        let _ = (lane, maximum);
    }
}

/// Counts of how the lanes were used.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LaneUse {
    /// Rounds: passes over all lanes.
    pub rounds: u64,
    /// Lanes with a motion, summed over the rounds.
    pub occupied: u64,
    /// Sub-steps done in lanes.
    pub substeps: u64,
    /// Number of transfers of a motion to the code for a single motion, for one sub-step or more.
    pub handed_over: u64,
}

impl LaneUse {
    /// Fraction of all lanes in all rounds that had a motion.
    pub fn occupation(&self) -> f64 {
        self.occupied as f64 / (self.rounds.max(1) * super::TOGETHER as u64) as f64
    }

    /// Fraction of all lanes in all rounds that moved a motion. The other lanes were empty or
    /// their motions were passed.
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
