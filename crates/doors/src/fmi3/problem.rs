//! Reasons why a call was refused, and the corresponding status.

use super::states::{Function, Stage};
use crate::ffi::Fault;
use crate::life::Interface;
use crate::messages::Status;
use crate::model::Model;
use crate::problem::{Refusal, Refused};

/// Outcome of a call on a component `C`.
pub type Outcome<C, T = ()> = Result<T, CallProblem<<C as Model>::Problem>>;

/// Reason why a call was refused. Each text states the name, its value and the valid values; the
/// log puts the function's name before it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CallProblem<P: Refusal> {
    /// The present state forbids the call (FMI 3.0.2, 2.3, 3.2 and 4.2).
    #[error("cannot be called in state {stage:?} of {}{}{}", interface.name(), led_there(*failed), way_on(*stage))]
    State {
        /// The state of the instance.
        stage: Stage,
        /// Interface type.
        interface: Interface,
        /// The function whose error has led to this state, if any.
        failed: Option<Function>,
    },
    /// An error that both versions have.
    #[error(transparent)]
    Refused(#[from] Refused<P>),
    /// Another call must come first, or the call is never possible.
    #[error("{what}")]
    Sequence {
        /// The required order.
        what: &'static str,
    },
    /// A variable that must not be accessed in Intermediate Update Mode (FMI 3.0.2, 4.2.2).
    #[error("{what} in Intermediate Update Mode: {allowed}")]
    Intermediate {
        /// The access.
        what: String,
        /// The valid accesses.
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

/// Text about the error that has led to the state; empty if there was none.
fn led_there(failed: Option<Function>) -> String {
    failed.map_or_else(String::new, |function| format!(", after an error in {}", function.name()))
}

/// Advice to a host in a state with few permitted calls.
fn way_on(stage: Stage) -> &'static str {
    match stage {
        Stage::Terminated => ": restore a saved state or reset the instance",
        _ => "",
    }
}

impl<P: Refusal> CallProblem<P> {
    /// The status to return from a function. A value that the model cannot accept gives Discard:
    /// the instance is unchanged, and the host may continue with another value (FMI 3.0.2, 2.2.4).
    /// Every other problem is an error of the call.
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
