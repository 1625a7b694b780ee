//! Many independent motions at once: on all threads, and in each thread sixteen side by side in
//! the processor's vectors.

mod queue;

use self::queue::{LaneRecord, Motions};
use super::attractor::{Attractor, StroboscopicRecord};
use super::maxima::Displacement;
use crate::error::Result;
use crate::exponent::LargestExponent;
use rayon::prelude::*;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{LaneUse, Simulator, State, TOGETHER, Way, advance_queue_by};

/// Lower limit for the motions in a part of a study. A lane that has finished a motion takes the
/// next one, so lanes idle only for the last few motions, here a tenth of the time.
pub(crate) const MOTIONS: usize = 128;

/// Start of a motion at time 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// The machine.
    pub parameters: Parameters,
    /// The state.
    pub state: State,
}

/// Stages of each motion, in order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Program {
    /// Whole drive periods that are discarded.
    pub discard: u32,
    /// Whether a motion ends early, while discarding, once it has certainly settled on a period or
    /// has no more impacts; it then has the attractor that an observation would find. Only for
    /// motions that are observed and whose maxima are not collected.
    pub until_settled: bool,
    /// Displacement whose maxima are collected, if any, and the number of whole drive periods.
    pub maxima: Option<(Displacement, u32)>,
    /// Whether the motion is then [observed](super::attractor::observe).
    pub observed: bool,
    /// Cap on the drive periods for the largest exponent of a motion with impacts and without a
    /// period; `None` without the exponent. Only for observed motions. The exponent is
    /// computed over most of the observation, even if the cap is lower.
    pub exponent: Option<u32>,
}

impl Program {
    /// Whether motions end as soon as their attractor is known.
    fn ends_early(&self) -> bool {
        self.until_settled && self.observed && self.maxima.is_none()
    }
}

/// Result of a motion.
#[derive(Debug)]
pub struct MotionEnd<'a> {
    /// State at the end, a whole number of drive periods after the start.
    pub state: State,
    /// Maxima, m, in order of time.
    pub maxima: &'a [f64],
    /// Attractor, if the motion was observed.
    pub attractor: Option<Attractor>,
    /// Largest exponent besides the zero of the drive's phase, if it was requested and there are
    /// impacts and no period.
    pub exponent: Option<LargestExponent>,
    /// Record of the observation, if there was one.
    pub(crate) record: &'a StroboscopicRecord,
}

/// Workspace of a thread: simulators and records that are reused for one motion after another
/// without new allocations.
#[derive(Debug, Default)]
pub struct Workspace {
    simulators: Vec<Simulator>,
    lanes: Vec<LaneRecord>,
    /// Use of the lanes so far.
    pub used: LaneUse,
    /// Way of advancing the motions; ways other than the default are for comparisons.
    pub way: Way,
}

impl Workspace {
    /// Runs a program on motions on this thread, and calls `finished` with the index among the
    /// starts for each motion that ends. The result of a motion does not depend on the others. If
    /// the simulator refuses a motion, the refusal is its result.
    pub fn run(
        &mut self,
        starts: &mut dyn Iterator<Item = Start>,
        program: &Program,
        finished: &mut dyn FnMut(usize, Result<MotionEnd<'_>>),
    ) {
        let mut starts = starts.enumerate();
        let mut first = None;
        while self.simulators.is_empty() {
            // The first motion that is accepted creates the simulators.
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

/// Advances motions over `periods` whole drive periods on all threads, and calls `done` after
/// each. The results are in the order of the starts and depend neither on the number of threads
/// nor on the other starts. Since the periods are whole, a motion may be continued from its result
/// at time 0.
///
/// # Errors
/// Each start has its own result: errors of [`Simulator::new`] or [`Simulator::advance_until`].
pub fn propagate(starts: &[Start], periods: u32, done: &(dyn Fn() + Sync)) -> Vec<Result<State>> {
    let program = Program { discard: periods, ..Program::default() };
    let share = starts.len().div_ceil(4 * rayon::current_num_threads()).clamp(TOGETHER, MOTIONS);
    let together = |workspace: &mut Workspace, starts: &[Start]| {
        let mut ends: Vec<Option<Result<State>>> = starts.iter().map(|_| None).collect();
        workspace.run(&mut starts.iter().copied(), &program, &mut |number, outcome| {
            done();
            ends[number] = Some(outcome.map(|outcome| outcome.state));
        });
        // Each motion has a result.
        ends.into_iter().flatten().collect::<Vec<_>>()
    };
    starts.par_chunks(share).map_init(Workspace::default, together).flatten_iter().collect()
}

#[cfg(test)]
mod tests;
