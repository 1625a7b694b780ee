//! Why a call was refused, and the status that says so.

use super::states::{Function, Stage};
use crate::ffi::Fault;
use crate::life::Interface;
use crate::messages::Status;
use crate::model::Model;
use crate::problem::{Refusal, Refused};

/// Outcome of a call on a component `C`.
pub type Outcome<C, T = ()> = Result<T, CallProblem<<C as Model>::Problem>>;

/// Why a call was refused. Each text names the thing, its value and what is allowed; the function's
/// name is put before it when it is logged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CallProblem<P: Refusal> {
    /// The call is not allowed in this state (FMI 3.0.2, 2.3, 3.2 and 4.2).
    #[error("not allowed in state {stage:?} of {}{}{}", interface.name(), led_there(*failed), way_on(*stage))]
    State {
        /// The state it met.
        stage: Stage,
        /// Interface type.
        interface: Interface,
        /// The function whose error has led there, if one has.
        failed: Option<Function>,
    },
    /// What any version refuses.
    #[error(transparent)]
    Refused(#[from] Refused<P>),
    /// Something must be done first, or is never possible.
    #[error("{what}")]
    Sequence {
        /// What.
        what: &'static str,
    },
    /// A variable that must not be accessed in Intermediate Update Mode (FMI 3.0.2, 4.2.2).
    #[error("{what} in Intermediate Update Mode: allowed is {allowed}")]
    Intermediate {
        /// The access.
        what: String,
        /// What is allowed.
        allowed: &'static str,
    },
}

impl<P: Refusal> From<P> for CallProblem<P> {
    fn from(problem: P) -> Self {
        Self::Refused(problem.into())
    }
}

impl<P: Refusal> From<Fault> for CallProblem<P> {
    fn from(fault: Fault) -> Self {
        Self::Refused(fault.into())
    }
}

/// What has led to the state, where it was an error.
fn led_there(failed: Option<Function>) -> String {
    failed.map_or_else(String::new, |function| format!(", after an error in {}", function.name()))
}

/// How a host goes on from a state in which little is allowed.
fn way_on(stage: Stage) -> &'static str {
    match stage {
        Stage::Terminated => ": restore a saved state or reset the instance",
        _ => "",
    }
}

impl<P: Refusal> CallProblem<P> {
    /// The status to return from a function. What the model cannot take as a value is discarded,
    /// with all as it was, since the host may go on with another value (FMI 3.0.2, 2.2.4);
    /// everything else is a mistake in the call.
    pub fn status(&self, function: Function) -> Status {
        match self {
            Self::Refused(Refused::Fault(Fault::Panic { .. })) => Status::Fatal,
            Self::Refused(Refused::Component(problem))
                if problem.is_of_a_value() && function.takes_values() =>
            {
                Status::Discard
            }
            _ => Status::Error,
        }
    }
}
