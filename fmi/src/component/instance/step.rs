//! Stepping from one communication point to the next.

use super::advance::{advance, pass_event_at_end};
use super::events::Changes;
use super::{Engine, Instance, Outcome, Phase, Problem};
use crate::component::closed_form::ClosedForm;
use crate::component::log::{Category, Log};
use fmi_doors::{StepOutcome, StepReason};
use vibro_impact::State;
use vibro_impact::error::Error;
use vibro_impact::numerics::double_double::DoubleDouble;
use vibro_impact::simulator::{AdvanceOutcome, Event, EventObserver, Pause, Simulator, Snapshot};

impl Instance {
    /// From the present time to `point + size` exactly. Own time is the truth; `point` may be off by rounding. Where the
    /// step ends early at an impact, the phase is then [`Phase::StoppedEarly`], and the next step may begin there.
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

/// Takes back a step that failed, and says why it did, or that it could not be taken back.
#[cold]
pub(super) fn take_back(simulator: &mut Simulator, before: &Snapshot, error: Error) -> Problem {
    if let Err(refused) = simulator.restore(before) {
        return Problem::NotTakenBack { cause: error.to_string(), refused: refused.to_string() };
    }
    match error {
        Error::WorkLimit { time, events, restitution, path, .. } => {
            Problem::WorkLimit { own: simulator.time(), time, events, restitution, path }
        }
        error => error.into(),
    }
}

/// How far off a step's end an impact still is at its end, s: a master's sum of time and step size may be off by this.
pub(super) fn rounding(end: f64) -> f64 {
    const UNITS: f64 = 4.0; // of the last place
    UNITS * f64::EPSILON * end.abs()
}

/// How far past a step's end an event still is at its end, s. To the rounding of times comes that of w, which moves the time of an
/// impact by as much over the speed (docs/numerics.md, section 2, *The root*): a slow block that is a few units in the last place
/// before a stop at the time that a master was told is at it.
pub(super) fn lateness(simulator: &Simulator, end: f64) -> f64 {
    /// Of the last place of w, which each of the steps since the time was told may have moved by a unit.
    const UNITS: f64 = 256.0;
    /// At most so long, in parts of the fastest time constant: the slower bounces are the last of a chatter run. Also in parts of a
    /// master's time, of which it is a tenth of what own time may be off ([`TIME_TOLERANCE`](fmi_doors::TIME_TOLERANCE)).
    const LONGEST: f64 = 1e-10;
    let (_, rate) = simulator.relative_motion();
    let longest = LONGEST * end.abs().max(1.0).min(1.0 / simulator.fastest_rate());
    rounding(end) + (UNITS * f64::EPSILON * size(simulator) / rate.abs()).min(longest)
}

/// S of docs/numerics.md, section 1, but for what loads add: the size of the motion, m.
pub(super) fn size(simulator: &Simulator) -> f64 {
    let (parameters, fastest) = (simulator.parameters(), simulator.fastest_rate());
    let State { x, v } = simulator.state();
    let pushed = parameters.drive_amplitude.abs() / (parameters.box_mass * fastest * fastest);
    parameters.stop_gap + x[0].abs() + x[2].abs() + (v[0].abs() + v[2].abs()) / fastest + pushed
}

/// Tells how many impacts of a steady state a long step has not listed.
pub(super) fn log_left_out(impacts: f64, end: f64, log: &mut dyn Log) {
    if impacts > 0.0 && log.wants(Category::Events) {
        let message = format!("{impacts} more impacts up to t = {end} s are not listed one by one");
        log.log(Category::Events, &message);
    }
}

/// An event in words.
pub(super) fn describe(event: &Event) -> String {
    let stop = |side: i8| if side > 0 { "upper" } else { "lower" };
    match *event {
        Event::Impact { time, side, speed, impulse } => format!(
            "impact on the {} stop at t = {time} s: approach speed {speed} m/s, impulse {impulse} N.s",
            stop(side)
        ),
        Event::Rest { time, side } => {
            format!("the block comes to rest on the {} stop at t = {time} s", stop(side))
        }
        Event::Release { time, side } => format!("the block leaves the {} stop at t = {time} s", stop(side)),
    }
}
