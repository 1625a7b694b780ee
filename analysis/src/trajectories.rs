//! Many independent motions at once, on all threads and sixteen to a thread, side by side in the machine's vectors.

use super::attractor::{Attractor, OBSERVED, StroboscopicRecord};
use super::error::Result;
use super::maxima::Displacement;
use super::stroboscopic::Units;
use rayon::prelude::*;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{
    Event, LaneUse, Maximum, MotionQueue, Plan, Reports, Simulator, State, TOGETHER, Way, advance_queue_by,
};

/// Motions in a part of a study, at least. A lane that has finished one takes the next, so that only the last few of a part leave
/// lanes idle; with so many that is a tenth.
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
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Program {
    /// Whole drive periods that are discarded.
    pub discard: u32,
    /// Whole drive periods over which the maxima of a displacement are collected, if any are.
    pub maxima: Option<(Displacement, u32)>,
    /// Whether the motion is then [observed](super::attractor::observe).
    pub observed: bool,
}

/// What has become of a motion.
#[derive(Debug)]
pub struct Outcome<'a> {
    /// The state at the end, a whole number of drive periods after the start.
    pub state: State,
    /// The maxima, m, in the order of time.
    pub maxima: &'a [f64],
    /// What the motion has settled on, if it was observed.
    pub attractor: Option<Attractor>,
}

/// A thread's workspace: simulators and records that serve one motion after another, so that nothing is allocated for each.
#[derive(Debug, Default)]
pub struct Workspace {
    simulators: Vec<Simulator>,
    lanes: Vec<LaneRecord>,
    /// How the lanes were used so far.
    pub used: LaneUse,
    /// How the motions are advanced; other ways than the usual one are for comparisons.
    pub way: Way,
}

/// What a lane is at, and what it has recorded of its motion.
#[derive(Debug, Default)]
struct LaneRecord {
    /// The motion's number.
    number: usize,
    units: Units,
    stage: Stage,
    stroboscopic: StroboscopicRecord,
    maxima: Vec<f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Stage {
    #[default]
    Discarding,
    Maxima,
    Observing,
}

impl Workspace {
    /// Runs a program on motions on this thread and shows `finished` each as it ends, with its number in the order of the
    /// starts. What becomes of a motion does not depend on the others.
    /// What the simulator refuses is the outcome of the motion that it refuses.
    pub fn run(
        &mut self,
        starts: &mut dyn Iterator<Item = Start>,
        program: &Program,
        finished: &mut dyn FnMut(usize, Result<Outcome<'_>>),
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
        let mut motions = Motions { starts: &mut starts, program, finished, lanes: &mut self.lanes };
        self.used += advance_queue_by(self.way, &mut self.simulators, &mut motions);
    }
}

/// The motions that a thread works on.
struct Motions<'a> {
    starts: &'a mut dyn Iterator<Item = (usize, Start)>,
    program: &'a Program,
    finished: &'a mut dyn FnMut(usize, Result<Outcome<'_>>),
    lanes: &'a mut [LaneRecord],
}

impl Motions<'_> {
    /// What comes next for the motion in a lane, if it has not come to the end of the program.
    fn next_stage(&mut self, lane: usize, simulator: &Simulator) -> Option<Plan> {
        let (record, program) = (&mut self.lanes[lane], self.program);
        let (now, period) = (simulator.time(), simulator.parameters().period());
        let none = Reports { origin: f64::INFINITY, step: period, maxima_of: None };
        let plan = |periods: u32, reports| {
            Some(Plan { simulator: lane, end: now + f64::from(periods) * period, reports })
        };
        match (record.stage, program.maxima) {
            (Stage::Discarding, Some((of, keep))) => {
                record.stage = Stage::Maxima;
                plan(keep, Some(Reports { maxima_of: Some(of.weights()), ..none }))
            }
            (Stage::Discarding | Stage::Maxima, _) if program.observed => {
                record.stage = Stage::Observing;
                plan(OBSERVED, Some(Reports { origin: now, step: 0.5 * period, ..none }))
            }
            _ => None,
        }
    }

    fn finish(&mut self, lane: usize, simulator: &Simulator, ended: vibro_impact::Result<()>) {
        let record = &self.lanes[lane];
        let outcome = ended.map(|()| Outcome {
            state: simulator.state(),
            maxima: &record.maxima,
            attractor: (record.stage == Stage::Observing)
                .then(|| record.stroboscopic.attractor(simulator.parameters())),
        });
        (self.finished)(record.number, outcome.map_err(Into::into));
    }
}

impl MotionQueue for Motions<'_> {
    fn next(
        &mut self,
        lane: usize,
        simulators: &mut [Simulator],
        ended: Option<vibro_impact::Result<()>>,
    ) -> Option<Plan> {
        let simulator = &mut simulators[lane];
        if let Some(ended) = ended {
            let going_on = if ended.is_ok() { self.next_stage(lane, simulator) } else { None };
            if going_on.is_some() {
                return going_on;
            }
            self.finish(lane, simulator, ended);
        }
        loop {
            let (number, Start { parameters, state }) = self.starts.next()?;
            if let Err(refused) = simulator.restart(&parameters, &state, 0.0) {
                (self.finished)(number, Err(refused.into()));
                continue;
            }
            let record = &mut self.lanes[lane];
            record.maxima.clear();
            record.stroboscopic.clear();
            record.units = Units::of(&parameters);
            (record.number, record.stage) = (number, Stage::Discarding);
            let end = f64::from(self.program.discard) * parameters.period();
            return Some(Plan { simulator: lane, end, reports: None });
        }
    }

    fn sample(&mut self, lane: usize, number: u32, state: &State) {
        let record = &mut self.lanes[lane];
        record.stroboscopic.sample(number, record.units.dimensionless(state));
    }

    fn event(&mut self, lane: usize, event: &Event) {
        let record = &mut self.lanes[lane];
        if record.stage == Stage::Observing {
            record.stroboscopic.event(event);
        }
    }

    fn maximum(&mut self, lane: usize, maximum: &Maximum) {
        self.lanes[lane].maxima.push(maximum.value);
    }
}

/// Advances motions over `periods` whole drive periods, on all threads, and calls `done` after each. The results are in the
/// order of the starts and depend neither on the number of threads nor on the other starts. Since the periods are whole, a
/// motion may be continued from its result at time 0.
///
/// # Errors
/// Each start has a result of its own: what [`Simulator::new`] or [`Simulator::advance_until`] refuses.
pub fn propagate(starts: &[Start], periods: u32, done: &(dyn Fn() + Sync)) -> Vec<Result<State>> {
    let program = Program { discard: periods, maxima: None, observed: false };
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
mod tests {
    use super::*;
    use vibro_impact::parameters::{Groups, Scales};

    #[test]
    fn second_method_together_as_one_by_one() {
        // Several systems, one of another drive period, and starts that are refused among them.
        let mut starts = Vec::new();
        for (i, (f10, sigma1)) in [(0.6, 0.4), (2.48, 0.4), (3.6, 0.4), (1.5, 0.2)].into_iter().enumerate() {
            let groups = Groups { f10, sigma1, ..Groups::basic() };
            let parameters = groups.to_parameters(Scales::default()).unwrap();
            for k in 0..11 {
                let x2 = if k == 5 { 1.5 } else { 0.0 };
                let state = State { x: [0.0, x2, 0.0], v: [0.1 * i as f64, 0.2 * f64::from(k), 0.0] };
                starts.push(Start { parameters, state });
            }
        }
        /// The two ways differ in round-off, which the impacts of ten periods amplify, in chaos too.
        const ROUNDING: f64 = 1e-9;
        const PERIODS: u32 = 10;
        let ends = propagate(&starts, PERIODS, &|| ());
        assert_eq!(ends.len(), starts.len());
        for (start, end) in starts.iter().zip(ends) {
            // With other neighbours the bits are the same.
            let single = propagate(std::slice::from_ref(start), PERIODS, &|| ()).remove(0);
            assert_eq!(end.as_ref().ok(), single.as_ref().ok());
            let one = Simulator::new(&start.parameters, &start.state, 0.0).and_then(|s| {
                let mut s = s.without_energy_accounts();
                s.advance_to(f64::from(PERIODS) * start.parameters.period())?;
                Ok(s.state())
            });
            match (one, end) {
                (Ok(one), Ok(end)) => {
                    let pairs = one.x.iter().chain(&one.v).zip(end.x.iter().chain(&end.v));
                    let d = pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
                    assert!(d < ROUNDING, "{start:?}: {d:e}");
                }
                (Err(one), Err(end)) => assert_eq!(one.to_string(), end.to_string()),
                (one, end) => panic!("{one:?} {end:?}"),
            }
        }
    }

    /// A motion's attractor and maxima.
    type Settled = (Attractor, Vec<f64>);

    /// Outcomes of a program on motions of one system that start with different speeds: attractors and maxima.
    fn settled(f10: f64, one_by_one: bool) -> Vec<Settled> {
        const MOTIONS: u32 = 40;
        let parameters = Groups { f10, ..Groups::basic() }.to_parameters(Scales::default()).unwrap();
        let start = |k| State { x: [0.0; 3], v: [0.0, 0.1 + 0.03 * f64::from(k), 0.0] };
        let mut starts = (0..MOTIONS).map(|k| Start { parameters, state: start(k) });
        let program = Program { discard: 250, maxima: Some((Displacement::X2, 60)), observed: true };
        let mut found: Vec<Option<_>> = (0..MOTIONS).map(|_| None).collect();
        let way = if one_by_one { Way::OneByOne } else { Way::Together };
        let mut workspace = Workspace { way, ..Workspace::default() };
        workspace.run(&mut starts, &program, &mut |number, outcome| {
            let outcome = outcome.unwrap();
            found[number] = Some((outcome.attractor.unwrap(), outcome.maxima.to_vec()));
        });
        let used = workspace.used;
        assert!(!one_by_one || used.rounds == 0);
        assert!(used.rounds == 0 || used.utilisation() > 0.5, "{used:?}");
        found.into_iter().flatten().collect()
    }

    #[test]
    fn second_method_a_stable_motion_is_settled_on_either_way() {
        /// What is left of the transient.
        const SETTLED: f64 = 1e-9;
        for ((together, tops), (alone, others)) in settled(1.5, false).iter().zip(&settled(1.5, true)) {
            assert_eq!((together.period, together.impacts, together.rests), (Some(1), [1.0; 2], false));
            assert_eq!(together.relation(alone), crate::attractor::Relation::Same);
            assert_eq!(tops.len(), others.len());
            assert!(tops.iter().zip(others).all(|(a, b)| (a - b).abs() < SETTLED));
        }
    }

    /// Of eight motions of a plane some come to their end sooner than others. Counts tell that together they are still no slower than
    /// one by one: a round in which half of the lanes are empty has the work of three to five sub-steps of a single motion.
    #[test]
    fn invariant_eight_motions_keep_enough_lanes_at_work() {
        const ROUND: f64 = 5.0;
        let mut starts = (0..8).map(|k| {
            let groups =
                Groups { f10: 0.7 + 0.6 * f64::from(k), sigma1: 0.1 * f64::from(k), ..Groups::basic() };
            let parameters = groups.to_parameters(Scales::default()).unwrap();
            Start { parameters, state: crate::stroboscopic::moving_block(&parameters) }
        });
        let program = Program { discard: 300, maxima: None, observed: true };
        let mut workspace = Workspace::default();
        workspace.run(&mut starts, &program, &mut |_, outcome| assert!(outcome.is_ok()));
        let used = workspace.used;
        assert!(used.rounds == 0 || used.substeps as f64 > ROUND * used.rounds as f64, "{used:?}");
        // Little is left to the code for a single motion.
        assert!(used.handed_over < used.substeps / 50, "{used:?}");
    }

    #[test]
    fn second_method_in_chaos_the_statistics_agree() {
        /// Of the mean over 40 motions of 60 and 128 periods, whose impacts and maxima are correlated over some periods.
        const STATISTICS: f64 = 0.03;
        for f10 in [3.6, 4.5] {
            let [together, alone] = [false, true].map(|one_by_one| {
                let all = settled(f10, one_by_one);
                let count = all.len() as f64;
                let mean = |of: &dyn Fn(&Settled) -> f64| all.iter().map(of).sum::<f64>() / count;
                let tops = mean(&|m| m.1.len() as f64);
                [
                    mean(&|m| f64::from(u8::from(m.0.period.is_none()))),
                    mean(&|m| m.0.impacts[0] + m.0.impacts[1]),
                    mean(&|m| m.0.sizes[0]),
                    mean(&|m| m.0.sizes[1]),
                    tops,
                    mean(&|m| m.1.iter().sum::<f64>()) / tops,
                ]
            });
            assert!(alone[0] > 0.5, "f10 = {f10}: {alone:?} is no chaos");
            for (a, b) in together.iter().zip(&alone) {
                assert!((a - b).abs() < STATISTICS * b.abs(), "f10 = {f10}: {together:?} {alone:?}");
            }
        }
    }
}
