//! Stepping and status (FMI 2.0, 4.2.2 and 4.2.3).

use super::{Engine, Instance, Outcome};
use crate::fmi2::logging::{Category, Log, Status};
use crate::fmi2::problem::Problem;
use crate::fmi2::states::{Function, State};
use vibro_impact::error::Error;
use vibro_impact::numerics::double_double::DoubleDouble;
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Event, EventObserver, Loads, Simulator, Stop, StopReason};

/// How far a master's time may be off ours, relative to max(1, |t|): masters add step sizes up and drift by about 1e-14 a
/// step, which stays below this for 1e5 steps; anything larger is a mistake.
const TIME_TOLERANCE: f64 = 1e-9;

/// `fmi2StatusKind` (FMI 2.0, 4.2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusKind {
    /// Of an asynchronous step; there are none.
    DoStepStatus,
    /// Of an asynchronous step; there are none.
    PendingStatus,
    /// Time up to which the last step was computed.
    LastSuccessfulTime,
    /// Whether the instance wants to end the simulation; it never does.
    Terminated,
}

impl StatusKind {
    /// From the C enumeration.
    ///
    /// # Errors
    /// [`Problem::Value`] for any other number.
    pub fn from_number(number: i32) -> Outcome<Self> {
        match number {
            0 => Ok(Self::DoStepStatus),
            1 => Ok(Self::PendingStatus),
            2 => Ok(Self::LastSuccessfulTime),
            3 => Ok(Self::Terminated),
            _ => Err(Problem::Value {
                name: "fmi2StatusKind",
                value: f64::from(number),
                allowed: "0 (fmi2DoStepStatus), 1 (fmi2PendingStatus), 2 (fmi2LastSuccessfulTime) or 3 (fmi2Terminated)",
            }),
        }
    }
}

impl Instance {
    /// `fmi2DoStep` (FMI 2.0, 4.2.2): to `point + size` exactly. Own time is the truth; `point` may be off by rounding.
    ///
    /// # Errors
    /// [`Problem::Impact`] (status Discard) when `stopAtImpact` ends the step early; else the step was not carried out at
    /// all and the instance stands where it stood.
    pub fn do_step(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Outcome {
        self.guard(Function::DoStep)?;
        let own = match &self.engine {
            Engine::Simulation(simulator) => simulator.time(),
            Engine::Closed(form) => form.time(),
            Engine::None | Engine::Continuous(_) => {
                return Err(Problem::Sequence { what: "the instance is not initialized" });
            }
        };
        check_step(point, size, own)?;
        let end = point + size;
        if let Some(stop) = self.experiment.and_then(|experiment| experiment.stop)
            && end > stop + TIME_TOLERANCE * stop.abs().max(1.0)
        {
            return Err(Problem::StopTime { end, stop });
        }
        let events = self.enabled.contains(Category::Events);
        let mut report = |event: &Event| log.log(Status::Ok, Category::Events, &describe(event));
        let report: Option<&mut dyn FnMut(&Event)> = if events { Some(&mut report) } else { None };
        let reason = match &mut self.engine {
            Engine::Simulation(simulator) => {
                let parameters = self.parameters_set.then_some(&self.settings.parameters);
                let loads = self.loads_set.then_some(&self.settings.loads);
                simulate(simulator, parameters, loads, (point, size), self.settings.stop_at_impact, report)?
            }
            Engine::Closed(form) => {
                if self.parameters_set {
                    form.set_parameters(&self.settings.parameters)?;
                }
                form.advance(point, size, self.settings.stop_at_impact, report)?
            }
            Engine::None | Engine::Continuous(_) => StopReason::End,
        };
        (self.parameters_set, self.loads_set) = (false, false);
        self.slopes_set = [false; 3];
        self.motion_stale = true;
        let time = match &self.engine {
            Engine::Simulation(simulator) => {
                let slopes = self.settings.loads.derivatives.iter().flat_map(|load| &load[1..]);
                if slopes.into_iter().any(|slope| *slope != 0.0) {
                    self.settings.loads = simulator.loads();
                }
                simulator.time()
            }
            Engine::Closed(form) => form.time(),
            Engine::None | Engine::Continuous(_) => end,
        };
        if reason == StopReason::Impact && time < end {
            self.state = State::StepFailed;
            return Err(Problem::Impact { time });
        }
        Ok(())
    }

    /// `fmi2CancelStep` (FMI 2.0, 4.2.2): steps are synchronous, so there is never one to cancel.
    ///
    /// # Errors
    /// Always.
    pub fn cancel_step(&mut self) -> Outcome {
        self.guard(Function::CancelStep)?;
        Err(Problem::Unsupported { what: "steps are synchronous: there is none to cancel" })
    }

    /// `fmi2GetRealStatus` (FMI 2.0, 4.2.3).
    ///
    /// # Errors
    /// [`Problem::StatusNotAvailable`] for all but the last successful time.
    pub fn real_status(&mut self, kind: StatusKind) -> Outcome<f64> {
        self.guard(Function::GetRealStatus)?;
        if kind == StatusKind::LastSuccessfulTime {
            self.refresh_motion()?;
            return Ok(self.motion.time);
        }
        Err(not_available(kind))
    }

    /// `fmi2GetBooleanStatus` (FMI 2.0, 4.2.3).
    ///
    /// # Errors
    /// [`Problem::StatusNotAvailable`] for all but `fmi2Terminated`.
    pub fn boolean_status(&self, kind: StatusKind) -> Outcome<bool> {
        self.guard(Function::GetBooleanStatus)?;
        if kind == StatusKind::Terminated {
            return Ok(false);
        }
        Err(not_available(kind))
    }

    /// `fmi2GetStatus`, `fmi2GetIntegerStatus`, `fmi2GetStringStatus` (FMI 2.0, 4.2.3): for asynchronous steps only.
    ///
    /// # Errors
    /// Always.
    pub fn other_status(&self, function: Function, kind: StatusKind) -> Outcome {
        self.guard(function)?;
        Err(not_available(kind))
    }
}

/// One step of the simulator, all or nothing.
fn simulate(
    simulator: &mut Simulator,
    parameters: Option<&Parameters>,
    loads: Option<&Loads>,
    (point, size): (f64, f64),
    stop_at_impact: bool,
    mut report: EventObserver<'_, '_>,
) -> Outcome<StopReason> {
    let before = simulator.snapshot();
    let end = DoubleDouble::sum(point, size);
    let stop = if stop_at_impact { Stop::AfterImpact } else { Stop::Never };
    let mut advance = || {
        if let Some(parameters) = parameters {
            simulator.set_parameters(parameters)?;
        }
        if let Some(loads) = loads {
            simulator.set_loads(loads)?;
        }
        match simulator.advance_until(end, stop, report.as_deref_mut()) {
            // Own time is past the end by the rounding that `point` is allowed: nothing is left to do.
            Err(Error::Step { .. }) => Ok(StopReason::End),
            Ok(StopReason::End) if stop_at_impact => {
                impact_at(simulator, point + size, report.as_deref_mut())?;
                Ok(StopReason::End)
            }
            // At the end but for rounding.
            Ok(StopReason::Impact) if point + size - simulator.time() <= rounding(point + size) => {
                simulator.advance_until(end, Stop::Never, report.as_deref_mut())
            }
            reason => reason,
        }
    };
    advance().map_err(|error| {
        // Cannot fail: it is this simulator's own.
        let _ = simulator.restore(&before);
        error.into()
    })
}

/// How far off a step's end an impact still is at its end, s: a master's sum of time and step size may be off by this.
fn rounding(end: f64) -> f64 {
    const UNITS: f64 = 4.0; // of the last place
    UNITS * f64::EPSILON * end.abs()
}

/// Takes an impact that lies past a step's end by rounding alone. A master that comes to the time of an impact it was
/// told must have it behind itself: else its next step would end where it began, and it could not get on.
fn impact_at(simulator: &mut Simulator, end: f64, report: EventObserver<'_, '_>) -> Result<(), Error> {
    let before = simulator.snapshot();
    match simulator.advance_until(DoubleDouble::sum(end, rounding(end)), Stop::AfterImpact, report)? {
        StopReason::Impact => Ok(()),
        StopReason::End | StopReason::EventDue => simulator.restore(&before),
    }
}

fn not_available(kind: StatusKind) -> Problem {
    Problem::StatusNotAvailable {
        what: match kind {
            StatusKind::DoStepStatus => "fmi2DoStepStatus is not available: steps are synchronous",
            StatusKind::PendingStatus => "fmi2PendingStatus is not available: steps are synchronous",
            StatusKind::LastSuccessfulTime => "fmi2LastSuccessfulTime is a Real: use fmi2GetRealStatus",
            StatusKind::Terminated => "fmi2Terminated is a Boolean: use fmi2GetBooleanStatus",
        },
    }
}

fn check_step(point: f64, size: f64, own: f64) -> Outcome {
    let refuse = |name, value, allowed| Err(Problem::Value { name, value, allowed });
    if !point.is_finite() {
        return refuse("currentCommunicationPoint", point, "a finite number");
    }
    if !(size > 0.0 && size.is_finite()) {
        return refuse("communicationStepSize", size, "a finite number > 0");
    }
    if (point - own).abs() > TIME_TOLERANCE * point.abs().max(1.0) {
        return Err(Problem::Time { given: point, own });
    }
    Ok(())
}

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
