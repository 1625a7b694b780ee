//! Reasons for which a described machine refuses a call.

use fmi_doors::{Problem, Refusal};

/// Reason of a refused call; the instance stays unchanged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachineProblem {
    /// A problem that any component may have.
    #[error(transparent)]
    Door(#[from] Problem),
    /// The machine's file cannot be read.
    #[error("{file}: {problem}; the FMU's archive has it among its resources")]
    File {
        /// Path of the file.
        file: String,
        /// The error.
        problem: String,
    },
    /// The file is not the one that the description was generated from.
    #[error("{place}: this is not the text of which the model description was made, {token}")]
    Text {
        /// The file or, if its text is no machine, its problems with their lines.
        place: String,
        /// The given token and that of the file.
        token: Problem,
    },
    /// The file, or the parameters together, are not a machine.
    #[error("{0}")]
    Machine(#[from] vibro_assembly::Refusal),
    /// Values set during a motion are incompatible with the present state.
    #[error("{set}: {problem}")]
    Change {
        /// Names and values that were set.
        set: String,
        /// The error.
        problem: vibro_assembly::Error,
    },
    /// The machine has no motion, or its motion cannot go on.
    #[error("{0}")]
    Motion(#[from] vibro_assembly::Error),
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
