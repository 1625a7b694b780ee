//! Why a call was refused, and the status that says so.

use super::states::{Function, Stage};
use crate::component::{self, Interface};
use crate::ffi::Fault;
use crate::messages::Status;

/// Outcome of a call.
pub type Outcome<T = ()> = Result<T, Problem>;

/// Why a call was refused. Each text names the thing, its value and what is allowed; the function's name is put before it
/// when it is logged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The call is not allowed in this state (FMI 2.0, 3.2.3 and 4.2.4).
    #[error("not allowed in state {stage:?} of {}{}", interface.name(), way_on(*stage))]
    State {
        /// The call.
        function: Function,
        /// The state it met.
        stage: Stage,
        /// Interface type.
        interface: Interface,
    },
    /// The component refuses.
    #[error(transparent)]
    Component(#[from] component::Problem),
    /// An argument that cannot be, or a panic.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// Something must be done first, or is never possible.
    #[error("{what}")]
    Sequence {
        /// What.
        what: &'static str,
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
}

/// How a host gets on from a state in which little is allowed.
fn way_on(stage: Stage) -> &'static str {
    match stage {
        Stage::StepFailed => ": restore the state saved before the impact, or go on from lastSuccessfulTime",
        _ => "",
    }
}

impl Problem {
    /// The status to return.
    pub fn status(&self) -> Status {
        match self {
            Self::Impact { .. } | Self::StatusNotAvailable { .. } => Status::Discard,
            Self::Fault(Fault::Panic { .. }) => Status::Fatal,
            _ => Status::Error,
        }
    }
}
