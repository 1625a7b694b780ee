//! Many independent motions at once, on all threads and sixteen to a thread, side by side in the
//! machine's vectors.

mod queue;

use self::queue::{LaneRecord, Motions};
use super::attractor::{Attractor, StroboscopicRecord};
use super::error::Result;
pub use super::largest_exponent::LargestExponent;
use super::maxima::Displacement;
use rayon::prelude::*;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{LaneUse, Simulator, State, TOGETHER, Way, advance_queue_by};

/// Motions in a part of a study, at least. A lane that has finished one takes the next, so that
/// only the last few of a part leave lanes idle; with so many that is a tenth.
pub(crate) const MOTIONS: usize = 128;

/// Where a motion starts, at time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// The system.
    pub parameters: Parameters,
    /// Its state.
    pub state: State,
}

/// What is done with each motion, in this order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Program {
    /// Whole drive periods that are discarded.
    pub discard: u32,
    /// Whether a motion that is found to have settled on a period within them, or to have no more
    /// impacts, ends there, as what it would be observed to be. Only for motions that are observed
    /// and whose maxima are not asked for.
    pub until_settled: bool,
    /// Whole drive periods over which the maxima of a displacement are collected, if any are.
    pub maxima: Option<(Displacement, u32)>,
    /// Whether the motion is then [observed](super::attractor::observe).
    pub observed: bool,
    /// Most drive periods over which the largest exponent of a motion with impacts and without a
    /// period is computed, if it is. Only for motions that are observed; most of the observation
    /// counts in any case.
    pub exponent: Option<u32>,
}

impl Program {
    /// Whether motions end as soon as it is known what they are.
    fn ends_early(&self) -> bool {
        self.until_settled && self.observed && self.maxima.is_none()
    }
}

/// What has become of a motion.
#[derive(Debug)]
pub struct MotionEnd<'a> {
    /// The state at the end, a whole number of drive periods after the start.
    pub state: State,
    /// The maxima, m, in the order of time.
    pub maxima: &'a [f64],
    /// What the motion has settled on, if it was observed.
    pub attractor: Option<Attractor>,
    /// The largest exponent beside the drive phase's zero, where it was asked for and there are
    /// impacts and no period.
    pub exponent: Option<LargestExponent>,
    /// What was observed, of motions that were.
    pub(crate) record: &'a StroboscopicRecord,
}

/// A thread's workspace: simulators and records that serve one motion after another, so that
/// nothing is allocated for each.
#[derive(Debug, Default)]
pub struct Workspace {
    simulators: Vec<Simulator>,
    lanes: Vec<LaneRecord>,
    /// How the lanes were used so far.
    pub used: LaneUse,
    /// How the motions are advanced; other ways than the usual one are for comparisons.
    pub way: Way,
}

impl Workspace {
    /// Runs a program on motions on this thread and shows `finished` each as it ends, with its
    /// number in the order of the starts. What becomes of a motion does not depend on the others.
    /// What the simulator refuses is the outcome of the motion that it refuses.
    pub fn run(
        &mut self,
        starts: &mut dyn Iterator<Item = Start>,
        program: &Program,
        finished: &mut dyn FnMut(usize, Result<MotionEnd<'_>>),
    ) {
        let mut starts = starts.enumerate();
        let mut first = None;
        while self.simulators.is_empty() {
            // The first motion that is accepted makes the simulators.
            let Some((number, start)) = starts.next() else { return };
            match Simulator::new(&start.parameters, &start.state, 0.0) {
                Ok(simulator) => {
                    self.simulators = vec![simulator.without_energy_accounts(); TOGETHER];
                    self.lanes.resize_with(TOGETHER, LaneRecord::default);
                    first = Some((number, start));
                }
                Err(refused) => finished(number, Err(refused.into())),
            }
        }
        let mut starts = first.into_iter().chain(starts);
        let mut motions = Motions::new(&mut starts, program, finished, &mut self.lanes);
        self.used += advance_queue_by(self.way, &mut self.simulators, &mut motions);
    }
}

/// Advances motions over `periods` whole drive periods, on all threads, and calls `done` after
/// each. The results are in the order of the starts and depend neither on the number of threads nor
/// on the other starts. Since the periods are whole, a motion may be continued from its result at
/// time 0.
///
/// # Errors
/// Each start has a result of its own: what [`Simulator::new`] or [`Simulator::advance_until`]
/// refuses.
pub fn propagate(starts: &[Start], periods: u32, done: &(dyn Fn() + Sync)) -> Vec<Result<State>> {
    let program = Program { discard: periods, ..Program::default() };
    let share = starts.len().div_ceil(4 * rayon::current_num_threads()).clamp(TOGETHER, MOTIONS);
    let together = |workspace: &mut Workspace, starts: &[Start]| {
        let mut ends: Vec<Option<Result<State>>> = starts.iter().map(|_| None).collect();
        workspace.run(&mut starts.iter().copied(), &program, &mut |number, outcome| {
            done();
            ends[number] = Some(outcome.map(|outcome| outcome.state));
        });
        // Each motion has an outcome.
        ends.into_iter().flatten().collect::<Vec<_>>()
    };
    starts.par_chunks(share).map_init(Workspace::default, together).flatten_iter().collect()
}

#[cfg(test)]
mod tests;
