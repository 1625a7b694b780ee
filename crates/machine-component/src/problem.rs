//! Reasons why a described machine refuses a call.

use fmi_doors::{Problem, Refusal};

/// Reason of a refused call; the instance stays unchanged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachineProblem {
    /// A problem of the common FMI layer.
    #[error(transparent)]
    Door(#[from] Problem),
    /// The machine's file cannot be read.
    #[error("{file}: {problem}; the FMU's archive has it among its resources")]
    File {
        /// Path of the file.
        file: String,
        /// Reason.
        problem: String,
    },
    /// The file's text differs from the text of the model description.
    #[error("{place}: this is not the text from which the model description was made, {token}")]
    Text {
        /// The file or, if its text is not a machine, the refusal with its lines.
        place: String,
        /// The given token and the file's.
        token: Problem,
    },
    /// The file's text, or the parameters together, are refused.
    #[error("{0}")]
    Machine(#[from] vibro_machine::Refusal),
    /// A value set during the motion contradicts the present state.
    #[error("{set}: {problem}")]
    Change {
        /// Names and values that were set.
        set: String,
        /// Reason.
        problem: vibro_machine::Error,
    },
    /// The machine has no motion, or its motion cannot continue.
    #[error("{0}")]
    Motion(#[from] vibro_machine::Error),
}

impl Refusal for MachineProblem {
    fn is_of_a_value(&self) -> bool {
        match self {
            Self::Door(problem) => problem.is_of_a_value(),
            Self::Machine(_) | Self::Motion(_) | Self::Change { .. } => true,
            Self::File { .. } | Self::Text { .. } => false,
        }
    }
}

/// The problem of bytes that are not a saved state of this machine.
pub(crate) fn refused(what: impl Into<String>) -> Problem {
    Problem::SavedState { what: what.into().into() }
}
