//! Model Exchange (FMI 2.0, 3.2): events and continuous states for a host's own solver.

use super::initial::forces;
use super::step::describe;
use super::{Engine, Instance, Outcome};
use crate::fmi2::continuous::{Continuous, check_states};
use crate::fmi2::logging::{Category, Log, Status};
use crate::fmi2::problem::Problem;
use crate::fmi2::states::{Function, State};
use vibro_impact::simulator::{self, Event};

/// `fmi2EventInfo` (FMI 2.0, 3.2.2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EventInfo {
    /// `fmi2NewDiscreteStates` must be called again.
    pub new_discrete_states_needed: bool,
    /// The simulation must end.
    pub terminate_simulation: bool,
    /// Nominal values have changed.
    pub nominals_changed: bool,
    /// Continuous states have changed.
    pub values_changed: bool,
    /// Time of the next time event, s.
    pub next_event_time: Option<f64>,
}

impl Instance {
    /// `fmi2EnterEventMode` (FMI 2.0, 3.2.2): the present point is accepted.
    ///
    /// # Errors
    /// [`Problem::State`].
    pub fn enter_event_mode(&mut self) -> Outcome {
        self.guard(Function::EnterEventMode)?;
        self.continuous_mut()?.accept();
        self.state = State::EventMode;
        Ok(())
    }

    /// `fmi2NewDiscreteStates` (FMI 2.0, 3.2.2): the impact law, rest or release where the present point calls for it. One
    /// call does all that happens at an instant; there are no time events.
    ///
    /// # Errors
    /// [`Problem::State`].
    pub fn new_discrete_states(&mut self, log: &mut dyn Log) -> Outcome<EventInfo> {
        self.guard(Function::NewDiscreteStates)?;
        let events = self.enabled.contains(Category::Events);
        let values_changed = self.continuous_mut()?.handle_event(&mut |event: &Event| {
            if events {
                log.log(Status::Ok, Category::Events, &describe(event));
            }
        });
        self.motion_stale = true;
        Ok(EventInfo { values_changed, ..EventInfo::default() })
    }

    /// `fmi2EnterContinuousTimeMode` (FMI 2.0, 3.2.2).
    ///
    /// # Errors
    /// [`Problem::State`].
    pub fn enter_continuous_time_mode(&mut self) -> Outcome {
        self.guard(Function::EnterContinuousTimeMode)?;
        self.state = State::ContinuousTimeMode;
        Ok(())
    }

    /// `fmi2CompletedIntegratorStep` (FMI 2.0, 3.2.2): the energy accounts are carried on. Asks for Event Mode where the
    /// host has passed over an event.
    ///
    /// # Errors
    /// [`Problem::State`].
    pub fn completed_integrator_step(&mut self) -> Outcome<bool> {
        self.guard(Function::CompletedIntegratorStep)?;
        let continuous = self.continuous_mut()?;
        continuous.accept();
        let missed = continuous.missed_event();
        self.motion_stale = true;
        Ok(missed)
    }

    /// `fmi2SetTime` (FMI 2.0, 3.2.1); in Event Mode only to the present time, as some hosts do.
    ///
    /// # Errors
    /// [`Problem::Value`] for a time that is not finite, or in Event Mode another than the present; one too large to resolve.
    pub fn set_time(&mut self, time: f64) -> Outcome {
        self.guard(Function::SetTime)?;
        let refuse = |allowed| Err(Problem::Value { name: "time", value: time, allowed });
        if !time.is_finite() {
            return refuse("a finite number");
        }
        if self.state == State::EventMode && time != self.continuous_mut()?.time() {
            return refuse("the present time in Event Mode");
        }
        self.continuous_mut()?.set_time(time)?;
        self.motion_stale = true;
        Ok(())
    }

    /// `fmi2SetContinuousStates` (FMI 2.0, 3.2.1), in the order of [`STATES`](crate::fmi2::structure::STATES).
    ///
    /// # Errors
    /// [`Problem::Value`] for one that is not finite; nothing has changed then.
    pub fn set_continuous_states(&mut self, states: &[f64; 6]) -> Outcome {
        self.guard(Function::SetContinuousStates)?;
        let state = check_states(states)?;
        self.continuous_mut()?.set_state(state);
        self.motion_stale = true;
        Ok(())
    }

    /// `fmi2GetContinuousStates` (FMI 2.0, 3.2.2).
    ///
    /// # Errors
    /// In Initialization Mode when the start is not possible.
    pub fn continuous_states(&mut self) -> Outcome<[f64; 6]> {
        self.guard(Function::GetContinuousStates)?;
        self.with_continuous(|continuous| {
            let simulator::State { x, v } = continuous.state();
            [x[0], x[1], x[2], v[0], v[1], v[2]]
        })
    }

    /// `fmi2GetDerivatives` (FMI 2.0, 3.2.2).
    ///
    /// # Errors
    /// In Initialization Mode when the start is not possible.
    pub fn state_derivatives(&mut self) -> Outcome<[f64; 6]> {
        self.guard(Function::GetDerivatives)?;
        self.with_continuous(Continuous::derivatives)
    }

    /// `fmi2GetEventIndicators` (FMI 2.0, 3.2.2): distances to both stops in flight, pressing acceleration in rest.
    ///
    /// # Errors
    /// In Initialization Mode when the start is not possible.
    pub fn event_indicators(&mut self) -> Outcome<[f64; 3]> {
        self.guard(Function::GetEventIndicators)?;
        self.with_continuous(Continuous::indicators)
    }

    /// `fmi2GetNominalsOfContinuousStates` (FMI 2.0, 3.2.2), as the model description has them.
    ///
    /// # Errors
    /// [`Problem::State`].
    pub fn nominals(&self) -> Outcome<[f64; 6]> {
        self.guard(Function::GetNominalsOfContinuousStates)?;
        Ok([1.0; 6])
    }

    fn continuous_mut(&mut self) -> Outcome<&mut Continuous> {
        match &mut self.engine {
            Engine::Continuous(continuous) => Ok(continuous),
            _ => Err(Problem::Sequence { what: "the instance is not initialized" }),
        }
    }

    /// Evaluates the model; in Initialization Mode at the start.
    fn with_continuous<T>(&self, evaluate: impl FnOnce(&Continuous) -> T) -> Outcome<T> {
        match &self.engine {
            Engine::Continuous(continuous) => Ok(evaluate(continuous)),
            _ => {
                let (simulator, _) = self.initial_simulator(&self.settings)?;
                Ok(evaluate(&Continuous::start(&simulator, forces(&self.settings))?))
            }
        }
    }
}
