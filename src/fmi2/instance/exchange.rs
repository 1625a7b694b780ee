//! Model Exchange (FMI 2.0, 3.2): events and continuous states for a host's own solver.

use super::{Instance, Outcome};
use crate::fmi2::logging::Log;
use crate::fmi2::problem::Problem;
use crate::fmi2::states::Function;

const NOT_YET: Problem = Problem::Unsupported { what: "Model Exchange is not supported" };

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

#[allow(missing_docs, clippy::missing_errors_doc)]
impl Instance {
    pub fn enter_event_mode(&mut self) -> Outcome {
        self.guard(Function::EnterEventMode)?;
        Err(NOT_YET)
    }
    pub fn new_discrete_states(&mut self, _log: &mut dyn Log) -> Outcome<EventInfo> {
        self.guard(Function::NewDiscreteStates)?;
        Err(NOT_YET)
    }
    pub fn enter_continuous_time_mode(&mut self) -> Outcome {
        self.guard(Function::EnterContinuousTimeMode)?;
        Err(NOT_YET)
    }
    pub fn completed_integrator_step(&mut self) -> Outcome<bool> {
        self.guard(Function::CompletedIntegratorStep)?;
        Err(NOT_YET)
    }
    pub fn set_time(&mut self, _time: f64) -> Outcome {
        self.guard(Function::SetTime)?;
        Err(NOT_YET)
    }
    pub fn set_continuous_states(&mut self, _states: &[f64; 6]) -> Outcome {
        self.guard(Function::SetContinuousStates)?;
        Err(NOT_YET)
    }
    pub fn event_indicators(&mut self) -> Outcome<[f64; 3]> {
        self.guard(Function::GetEventIndicators)?;
        Err(NOT_YET)
    }
    pub fn continuous_states(&mut self) -> Outcome<[f64; 6]> {
        self.guard(Function::GetContinuousStates)?;
        Err(NOT_YET)
    }
    pub fn state_derivatives(&mut self) -> Outcome<[f64; 6]> {
        self.guard(Function::GetDerivatives)?;
        Err(NOT_YET)
    }
    pub fn nominals(&self) -> Outcome<[f64; 6]> {
        self.guard(Function::GetNominalsOfContinuousStates)?;
        Err(NOT_YET)
    }
    pub fn directional_derivative(
        &mut self,
        _unknowns: &[u32],
        _knowns: &[u32],
        _seed: &[f64],
        _write: impl FnMut(usize, f64),
    ) -> Outcome {
        self.guard(Function::GetDirectionalDerivative)?;
        Err(Problem::Unsupported { what: "directional derivatives are not supported" })
    }
}
