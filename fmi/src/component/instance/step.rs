//! Stepping from one communication point to the next.

use super::arrival::{advance, pass_event_at_end, rounding, take_back};
use super::events::{Changes, describe, log_left_out};
use super::{Engine, Instance, Outcome, Phase, Problem};
use crate::component::closed_form::ClosedForm;
use crate::component::log::{Category, Log};
use fmi_doors::{StepOutcome, StepReason};
use vibro_impact::numerics::double_double::DoubleDouble;
use vibro_impact::simulator::{AdvanceOutcome, Event, EventObserver, Pause, Simulator};

impl Instance {
    /// From the present time to `point + size` exactly. Own time is the truth; `point` may be off
    /// by rounding. Where the step ends early at an impact, the phase is then
    /// [`Phase::StoppedEarly`], and the next step may begin there.
    ///
    /// # Errors
    /// [`Problem`] when the step was not carried out at all; the component stands where it stood.
    pub fn step(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Outcome<StepOutcome> {
        self.check_step(point, size)?;
        let end = point + size;
        let (wanted, mut left_out) = (log.wants(Category::Events), 0.0);
        let mut report = |event: &Event| log.log(Category::Events, &describe(event));
        let mut report: EventObserver = if wanted { Some(&mut report) } else { None };
        let reason = match &mut self.engine {
            Engine::Simulation(simulator) => {
                let changes = Changes::of(&self.settings, (self.parameters_set, self.loads_set));
                simulate(simulator, &changes, (point, size), self.settings.stop_at_impact, report)?
            }
            Engine::Closed(form) => {
                let mut next = ClosedForm::clone(form);
                if self.parameters_set {
                    next.set_parameters(&self.settings.parameters)?;
                }
                let stop = self.settings.stop_at_impact;
                let (reason, unreported) = next.advance(point, size, stop, report.as_deref_mut())?;
                if reason == AdvanceOutcome::End && next.meet(rounding(end)) {
                    next.apply_due_event(report);
                }
                (**form, left_out) = (next, unreported);
                reason
            }
            Engine::None | Engine::Continuous(_) => AdvanceOutcome::End,
        };
        log_left_out(left_out, end, log);
        Ok(self.finish_step(reason, end))
    }

    /// Whether a step can be made at all.
    pub(super) fn check_step(&self, point: f64, size: f64) -> Outcome {
        if matches!(self.engine, Engine::None | Engine::Continuous(_)) {
            return Err(Problem::sequence("the instance is not initialized"));
        }
        self.life.check_step(point, size, self.time()).map_err(|problem| match problem {
            fmi_doors::Problem::Time { given, own } if self.life.phase == Phase::StoppedEarly => {
                Problem::Stopped { given, own }
            }
            problem => problem.into(),
        })
    }

    /// What a step leaves behind: nothing pending, and the loads as they have become.
    fn finish_step(&mut self, reason: AdvanceOutcome, end: f64) -> StepOutcome {
        self.taken_over();
        let time = self.time();
        let early = reason == AdvanceOutcome::Impact && time < end;
        if early {
            // The rest of the step follows the same polynomials.
            self.carry_loads();
        } else {
            self.hold_loads();
        }
        self.life.phase = if early { Phase::StoppedEarly } else { Phase::Step };
        StepOutcome { time, reason: if early { StepReason::Stopped } else { StepReason::EndReached } }
    }
}

/// One step of the simulator, all or nothing.
fn simulate(
    simulator: &mut Simulator,
    changes: &Changes<'_>,
    (point, size): (f64, f64),
    stop_at_impact: bool,
    mut report: EventObserver<'_, '_>,
) -> Outcome<AdvanceOutcome> {
    let before = simulator.snapshot();
    let end = DoubleDouble::sum(point, size);
    let stop = if stop_at_impact { Pause::AfterImpact } else { Pause::Never };
    let mut run = || {
        changes.put(simulator, report.as_deref_mut())?;
        if advance(simulator, end, stop, report.as_deref_mut())? == AdvanceOutcome::Impact {
            if point + size - simulator.time() > rounding(point + size) {
                return Ok(AdvanceOutcome::Impact);
            }
            // At the end but for rounding.
            advance(simulator, end, Pause::Never, report.as_deref_mut())?;
        }
        pass_event_at_end(simulator, point + size, report.as_deref_mut())?;
        Ok(AdvanceOutcome::End)
    };
    run().map_err(|error| take_back(simulator, &before, error))
}
