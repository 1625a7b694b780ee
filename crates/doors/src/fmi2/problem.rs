//! Reasons why a call was refused, and the corresponding status.

use super::states::{Function, Stage};
use crate::events::EarlyEnd;
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
    /// The present state forbids the call (FMI 2.0, 3.2.3 and 4.2.4).
    #[error("cannot be called in state {stage:?} of {}{}", interface.name(), way_on(*stage, early))]
    State {
        /// The call.
        function: Function,
        /// The state of the instance.
        stage: Stage,
        /// Interface type.
        interface: Interface,
        /// Texts of the component about steps that end early.
        early: EarlyEnd,
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
    /// The step ended at an event before its end.
    #[error("the step ended at the {} at t = {time} s{}", early.event, early.because)]
    Stopped {
        /// Time of the event.
        time: f64,
        /// Texts of the component about the event.
        early: EarlyEnd,
    },
    /// A status that is not available (FMI 2.0, 4.2.3).
    #[error("{what}")]
    StatusNotAvailable {
        /// The status, and why it is not available.
        what: &'static str,
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

/// Advice to a host in a state with few permitted calls.
fn way_on(stage: Stage, early: &EarlyEnd) -> String {
    match stage {
        Stage::StepFailed => {
            format!(
                ": restore the state saved before the {}, or continue from lastSuccessfulTime",
                early.event
            )
        }
        _ => String::new(),
    }
}

impl<P: Refusal> CallProblem<P> {
    /// The status to return.
    pub fn status(&self) -> Status {
        match self {
            Self::Stopped { .. } | Self::StatusNotAvailable { .. } => Status::Discard,
            Self::Refused(Refused::Fault(Fault::Panic { .. })) => Status::Fatal,
            _ => Status::Error,
        }
    }
}
