//! Why a call was refused.

use super::logging::{Category, Status};
use super::states::{Function, Interface, State};

/// Why a call did not do what was asked. Each text names the thing, its value and what is allowed; the function's
/// name is put before it when it is logged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The call is not allowed in this state (FMI 2.0, 3.2.3 and 4.2.4).
    #[error("not allowed in state {state:?} of {}", interface.name())]
    State {
        /// The call.
        function: Function,
        /// The state it met.
        state: State,
        /// Interface type.
        interface: Interface,
    },
    /// No variable of this base type has that reference.
    #[error("value reference {reference} is not a {base} variable: {found}")]
    Reference {
        /// The reference.
        reference: u32,
        /// Base type of the call.
        base: &'static str,
        /// What is there.
        found: String,
    },
    /// The variable can never be set, or not now.
    #[error("{name} cannot be set in state {state:?}: allowed are {allowed}")]
    NotSettable {
        /// The variable.
        name: &'static str,
        /// Present state.
        state: State,
        /// What may be set.
        allowed: &'static str,
    },
    /// A value outside its range.
    #[error("{name} = {value}: allowed is {allowed}")]
    Value {
        /// What was to be set.
        name: &'static str,
        /// The value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A pointer that is null, or not aligned for what it should point to.
    #[error("{argument} is null or misaligned: allowed is a valid pointer")]
    Null {
        /// The argument.
        argument: &'static str,
    },
    /// A count that is not possible.
    #[error("{argument} = {value}: allowed is {allowed}")]
    Count {
        /// The argument.
        argument: &'static str,
        /// Its value.
        value: usize,
        /// What is allowed.
        allowed: String,
    },
    /// Text that is not what it must be.
    #[error("{argument} = \"{value}\": allowed is {allowed}")]
    Text {
        /// The argument.
        argument: &'static str,
        /// Its value.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// The master's time is not ours (FMI 2.0, 4.2.2).
    #[error(
        "currentCommunicationPoint = {given} s, but the instance is at t = {own} s: allowed is a difference of 1e-9 max(1, |t|)"
    )]
    Time {
        /// The master's time.
        given: f64,
        /// Our time.
        own: f64,
    },
    /// A step beyond the stop time given to `fmi2SetupExperiment` (FMI 2.0, 2.1.6).
    #[error("step to t = {end} s: allowed is up to the stop time {stop} s of fmi2SetupExperiment")]
    StopTime {
        /// End of the step.
        end: f64,
        /// Stop time.
        stop: f64,
    },
    /// Something must be done first.
    #[error("{what}")]
    Sequence {
        /// What.
        what: &'static str,
    },
    /// Not supported, and said so in the model description.
    #[error("{what}")]
    Unsupported {
        /// What.
        what: &'static str,
    },
    /// An FMU state that is not one of this instance's or not intact (FMI 2.0, 2.1.8).
    #[error("FMU state refused: {what}")]
    Memory {
        /// Why.
        what: String,
    },
    /// The model refuses.
    #[error(transparent)]
    Model(#[from] vibro_impact::error::Error),
    /// A closed-form mode cannot be played.
    #[error("{what}")]
    ClosedForm {
        /// Why.
        what: String,
    },
    /// The step ended at an impact (`stopAtImpact`).
    #[error("the step ended at the impact at t = {time} s, since stopAtImpact is true")]
    Impact {
        /// Time of the impact.
        time: f64,
    },
    /// A status that is not available (FMI 2.0, 4.2.3).
    #[error("{what}")]
    StatusNotAvailable {
        /// Which and why.
        what: &'static str,
    },
    /// A panic inside the library.
    #[error("internal error: {what}; the instance can no longer be used")]
    Panic {
        /// The panic's message.
        what: String,
    },
}

impl Problem {
    /// The status to return.
    pub fn status(&self) -> Status {
        match self {
            Self::Impact { .. } | Self::StatusNotAvailable { .. } => Status::Discard,
            Self::Panic { .. } => Status::Fatal,
            _ => Status::Error,
        }
    }

    /// The log category.
    pub fn category(&self) -> Category {
        match self.status() {
            Status::Discard => Category::Discard,
            Status::Fatal => Category::Fatal,
            _ => Category::Error,
        }
    }
}
