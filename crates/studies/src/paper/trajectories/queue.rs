//! Stages of the motions in a thread's lanes.

use super::{MotionEnd, Program, Start};
use crate::class::OBSERVED;
use crate::error::Result;
use crate::exponent::LargestExponent;
use crate::paper::attractor::{Attractor, StroboscopicRecord};
use crate::paper::free_limit::is_damped;
use crate::paper::free_motion;
use crate::paper::largest_exponent::{ALIGN, BLOCK, Tangent};
use crate::paper::settling::{Confirmation, ImpactRepetition};
use crate::paper::stroboscopic::Units;
use std::ops::ControlFlow;
use vibro_impact::Parameters;
use vibro_impact::model::{Augmented, SmoothMode};
use vibro_impact::simulator::{Event, Maximum, MotionQueue, Plan, Reports, Simulator, State};

/// Drive periods between two checks whether an exponent is decided: half of an observation.
const LOOK: u32 = 8 * BLOCK;

/// Drive periods without an impact after which it is checked whether more impacts will follow.
const QUIET: u32 = 8;

/// State of a lane, with the record of its motion.
#[derive(Debug, Default)]
pub(super) struct LaneRecord {
    /// Index of the motion.
    number: usize,
    parameters: Parameters,
    units: Units,
    /// Period of the drive, s, and its reciprocal.
    period: f64,
    frequency: f64,
    /// 1/(L ω10), s/m.
    per_speed: f64,
    stage: Stage,
    stroboscopic: StroboscopicRecord,
    impacts: ImpactRepetition,
    confirmation: Option<Confirmation>,
    /// Drive period at which it is checked whether impacts will follow; each impact postpones it.
    watched: u32,
    tangent: Tangent,
    /// Start time of the tangent, s, and whether it has begun.
    tangent_from: f64,
    tangent_begun: bool,
    /// Whether there were events since the last check of the exponent.
    moved_on: bool,
    /// Start time of the observation, s.
    observed_from: f64,
    attractor: Option<Attractor>,
    exponent: Option<LargestExponent>,
    maxima: Vec<f64>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Stage {
    #[default]
    Discarding,
    /// Found settled while discarding, in a state at a whole drive period.
    Settled(State),
    Maxima,
    Observing,
    Exponent,
}

impl LaneRecord {
    /// Begins another motion; the memory is reused.
    fn begin(&mut self, number: usize, start: &Start, program: &Program) {
        self.maxima.clear();
        self.impacts.clear();
        (self.confirmation, self.attractor, self.exponent) = (None, None, None);
        (self.number, self.stage, self.watched) = (number, Stage::Discarding, QUIET);
        self.parameters = start.parameters;
        (self.units, self.period) = (Units::of(&start.parameters), start.parameters.period());
        (self.frequency, self.per_speed) = (1.0 / self.period, 1.0 / self.units.speed());
        // The tangent is aligned when the observation begins. If the program does not end early,
        // events are not reported while discarding, and the tangent begins with the observation.
        let align = program.ends_early().then_some(ALIGN * BLOCK);
        let from = align.and_then(|align| program.discard.checked_sub(align)).map(f64::from);
        self.tangent_from = match (program.exponent, from) {
            (Some(_), Some(from)) => from * self.period,
            _ => f64::INFINITY,
        };
        self.tangent_begun = false;
    }

    /// Carries the tangent to an event, or starts it there when it is due.
    fn carry_tangent(&mut self, event: &Event, after: &Augmented) {
        if self.tangent_begun {
            self.tangent.event(event, after);
            return;
        }
        let (time, mode) = match *event {
            Event::Impact { time, .. } | Event::Release { time, .. } => (time, SmoothMode::Flight),
            Event::Rest { time, .. } => (time, SmoothMode::Rest),
        };
        if time >= self.tangent_from {
            self.tangent.begin(&self.parameters, mode, (self.tangent_from, time));
            self.tangent_begun = true;
        }
    }

    /// Whether the motion is certainly chaotic; `now` is at the end of a block.
    fn is_chaotic(&mut self, now: f64) -> bool {
        self.tangent.end_block(now);
        self.tangent.is_positive()
    }

    /// Records an event of a motion that may have settled. Returns the index of the next sample
    /// that is needed.
    fn look_for_repetition(&mut self, event: &Event) -> Option<u32> {
        self.stroboscopic.event(event);
        let Event::Impact { time, side, speed, .. } = *event else { return None };
        let time = time * self.frequency;
        let period = self.impacts.impact(time, side > 0, self.per_speed * speed);
        if self.confirmation.is_some() {
            return None;
        }
        if let Some(period) = period {
            let confirmation = Confirmation::new(period, time);
            self.confirmation = Some(confirmation);
            return Some(confirmation.first);
        }
        let now = time as u32;
        (now + 1 >= self.watched).then(|| self.watch(now))
    }

    /// Postpones the check whether impacts will follow; returns the index of its sample.
    fn watch(&mut self, now: u32) -> u32 {
        self.watched = now + QUIET;
        2 * self.watched
    }

    /// Takes a sample of a motion that may not have any more impacts, in a run that discards
    /// `discard` drive periods.
    fn look_ahead(&mut self, number: u32, state: &State, discard: u32) -> ControlFlow<(), u32> {
        let (p, now) = (self.parameters, number / 2);
        if number.is_multiple_of(2)
            && free_motion::keeps_clear(&p, state)
            && let Some(end) = free_motion::observe(&p, state, discard - now, &mut self.stroboscopic)
        {
            self.attractor = Some(self.stroboscopic.attractor(&p));
            self.stage = Stage::Settled(end);
            return ControlFlow::Break(());
        }
        ControlFlow::Continue(self.watch(now))
    }

    /// Takes a sample of a motion that may have settled or may not have any more impacts, in a run
    /// that discards `discard` drive periods.
    fn confirm(&mut self, number: u32, state: &State, discard: u32) -> ControlFlow<(), u32> {
        let Some(confirmation) = &mut self.confirmation else {
            return self.look_ahead(number, state, discard);
        };
        let sample = self.units.dimensionless(state);
        if number <= confirmation.first {
            self.stroboscopic.clear();
            confirmation.start = sample;
            return ControlFlow::Continue(number + 1);
        }
        self.stroboscopic.sample(number, sample);
        if number < confirmation.last() {
            return ControlFlow::Continue(number + 1);
        }
        // The rest of the discarded periods and the observation are skipped.
        let left = (discard - number / 2).saturating_add(OBSERVED);
        if confirmation.holds(&self.stroboscopic, left, self.parameters.is_symmetric()) {
            self.stage = Stage::Settled(*state);
            return ControlFlow::Break(());
        }
        self.confirmation = None;
        ControlFlow::Continue(self.watch(number / 2))
    }
}

/// Motions of one thread.
pub(super) struct Motions<'a> {
    starts: &'a mut dyn Iterator<Item = (usize, Start)>,
    program: &'a Program,
    finished: &'a mut dyn FnMut(usize, Result<MotionEnd<'_>>),
    lanes: &'a mut [LaneRecord],
}

impl<'a> Motions<'a> {
    pub(super) fn new(
        starts: &'a mut dyn Iterator<Item = (usize, Start)>,
        program: &'a Program,
        finished: &'a mut dyn FnMut(usize, Result<MotionEnd<'_>>),
        lanes: &'a mut [LaneRecord],
    ) -> Self {
        Self { starts, program, finished, lanes }
    }

    /// The next plan for the motion in a lane; `None` if its program is over.
    fn next_stage(&mut self, lane: usize, simulator: &Simulator) -> Option<Plan> {
        let (record, program) = (&mut self.lanes[lane], self.program);
        let (now, period) = (simulator.time(), record.period);
        let events = Reports { origin: now, step: 0.5 * period, first: u32::MAX, maxima_of: None };
        let plan = |from: f64, periods: u32, reports| {
            let end = from + f64::from(periods) * period;
            Some(Plan { simulator: lane, end, reports: Some(reports) })
        };
        match (record.stage, program.maxima) {
            (Stage::Discarding, Some((of, keep))) => {
                record.stage = Stage::Maxima;
                plan(now, keep, Reports { origin: f64::INFINITY, maxima_of: Some(of.weights()), ..events })
            }
            (Stage::Discarding | Stage::Maxima, _) if program.observed => {
                record.stage = Stage::Observing;
                record.stroboscopic.begin(simulator.contact());
                if program.exponent.is_some() && !record.tangent_begun {
                    record.tangent.begin(&record.parameters, simulator.contact().mode(), (now, now));
                    record.tangent_begun = true;
                }
                record.observed_from = now;
                let periods = if program.exponent.is_some() { LOOK } else { OBSERVED };
                plan(now, periods, Reports { first: 1, ..events })
            }
            // A motion that is certainly chaotic need not be observed further.
            (Stage::Observing, _) if !record.stroboscopic.is_complete() && !record.is_chaotic(now) => {
                let from = record.observed_from;
                plan(from, OBSERVED, Reports { origin: from, first: 1, ..events })
            }
            (Stage::Settled(_), _) => {
                if let Some(Confirmation { period, .. }) = record.confirmation {
                    let attractor = record.stroboscopic.attractor_of(simulator.parameters(), Some(period));
                    record.attractor = Some(attractor);
                }
                None
            }
            (Stage::Observing | Stage::Exponent, _) => {
                let attractor = record
                    .attractor
                    .get_or_insert_with(|| record.stroboscopic.attractor(simulator.parameters()));
                let most = program.exponent.filter(|_| attractor.period.is_none() && !attractor.is_free())?;
                record.tangent.end_block(now);
                let exponent = record.tangent.exponent();
                if record.stage == Stage::Exponent
                    && !record.moved_on
                    && is_damped(&record.parameters)
                    && free_motion::keeps_clear(&record.parameters, &simulator.state())
                {
                    // Chaos has ended in a motion without impacts, and everything except the
                    // drive's phase is damped, so the exponent is certainly negative. Without this
                    // proof impacts may return, since the impacts of a lightly damped box come in
                    // bursts.
                    attractor.approaching = true;
                    let value = f64::NEG_INFINITY;
                    record.exponent = Some(LargestExponent { value, error: 0.0, ..exponent });
                    return None;
                }
                if record.tangent.is_decided(most) {
                    record.exponent = Some(exponent);
                    return None;
                }
                (record.stage, record.moved_on) = (Stage::Exponent, false);
                // In whole blocks, like the earlier counts.
                let left = (most - exponent.periods).next_multiple_of(BLOCK);
                plan(now, left.min(LOOK), events)
            }
            _ => None,
        }
    }

    fn finish(&mut self, lane: usize, simulator: &Simulator, ended: vibro_impact::Result<()>) {
        let record = &mut self.lanes[lane];
        let state = match record.stage {
            Stage::Settled(state) => state,
            _ => simulator.state(),
        };
        let (attractor, exponent) = (record.attractor.take(), record.exponent);
        let outcome = ended.map(|()| MotionEnd {
            state,
            maxima: &record.maxima,
            attractor,
            exponent,
            record: &record.stroboscopic,
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
        let (simulator, program) = (&mut simulators[lane], self.program);
        if let Some(ended) = ended {
            let going_on = if ended.is_ok() { self.next_stage(lane, simulator) } else { None };
            if going_on.is_some() {
                return going_on;
            }
            self.finish(lane, simulator, ended);
        }
        loop {
            let (number, start) = self.starts.next()?;
            if let Err(refused) = simulator.restart(&start.parameters, &start.state, 0.0) {
                (self.finished)(number, Err(refused.into()));
                continue;
            }
            let record = &mut self.lanes[lane];
            record.begin(number, &start, program);
            record.stroboscopic.begin(simulator.contact());
            // Samples at half drive periods, beginning only when impacts repeat or stay away.
            let (step, first) = (0.5 * record.period, 2 * record.watched);
            let reports = Reports { origin: 0.0, step, first, maxima_of: None };
            let end = f64::from(program.discard) * record.period;
            return Some(Plan { simulator: lane, end, reports: program.ends_early().then_some(reports) });
        }
    }

    fn sample(&mut self, lane: usize, number: u32, state: &State) -> ControlFlow<(), u32> {
        let record = &mut self.lanes[lane];
        if record.stage == Stage::Discarding {
            return record.confirm(number, state, self.program.discard);
        }
        record.stroboscopic.sample(number, record.units.dimensionless(state));
        ControlFlow::Continue(number + 1)
    }

    fn event(&mut self, lane: usize, event: &Event, after: &Augmented) -> Option<u32> {
        let (record, program) = (&mut self.lanes[lane], self.program);
        match record.stage {
            Stage::Discarding => {
                if program.exponent.is_some() {
                    record.carry_tangent(event, after);
                }
                return record.look_for_repetition(event);
            }
            Stage::Observing => record.stroboscopic.event(event),
            Stage::Exponent => record.moved_on = true,
            _ => {}
        }
        // If maxima are recorded before the observation, the tangent may not have begun.
        if record.tangent_begun {
            record.tangent.event(event, after);
        }
        None
    }

    fn maximum(&mut self, lane: usize, maximum: &Maximum) {
        self.lanes[lane].maxima.push(maximum.value);
    }
}
