//! C types of the standard that are plain numbers (FMI 2.0, 2.1.2, 2.1.3 and 3.2.2), with std's
//! names for the C types.

use crate::events::Handled;
use core::ffi::c_int;

/// `fmi2Boolean`.
pub type FmiBoolean = c_int;
/// `fmi2Status`, as an integer.
pub type FmiStatus = c_int;

/// `fmi2EventInfo` (FMI 2.0, 3.2.2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct FmiEventInfo {
    /// `fmi2NewDiscreteStates` must be called again.
    pub new_discrete_states_needed: FmiBoolean,
    /// The simulation must end.
    pub terminate_simulation: FmiBoolean,
    /// Nominal values have changed.
    pub nominals_of_continuous_states_changed: FmiBoolean,
    /// Continuous states have changed.
    pub values_of_continuous_states_changed: FmiBoolean,
    /// Whether the next time event is known.
    pub next_event_time_defined: FmiBoolean,
    /// Time of the next time event, s.
    pub next_event_time: f64,
}

impl FmiEventInfo {
    /// The result of handling an event. One call carries out everything due at the present time,
    /// and no event ends the simulation.
    pub fn after_event(changed: Handled, next_event_time: Option<f64>) -> Self {
        Self {
            values_of_continuous_states_changed: changed.states.into(),
            nominals_of_continuous_states_changed: changed.nominals.into(),
            next_event_time_defined: next_event_time.is_some().into(),
            next_event_time: next_event_time.unwrap_or_default(),
            ..Self::default()
        }
    }
}
