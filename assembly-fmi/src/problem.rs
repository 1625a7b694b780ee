//! Why a described machine refuses.

use fmi_doors::{Problem, Refusal};

/// Why a call was refused; the instance is then as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MachineProblem {
    /// What every component may say.
    #[error(transparent)]
    Door(#[from] Problem),
    /// The machine's file cannot be read.
    #[error("{file}: {problem}; the FMU's archive has it among its resources")]
    File {
        /// Where it was looked for.
        file: String,
        /// What is the matter.
        problem: String,
    },
    /// The file has another text than the one of which the description was made.
    #[error("{place}: this is not the text of which the model description was made, {token}")]
    Text {
        /// The file and, where its text is no machine at all, what is wrong in which line.
        place: String,
        /// The token that was given, and that of the file.
        token: Problem,
    },
    /// The file says nothing that is a machine, or the parameters together are none.
    #[error("{0}")]
    Machine(#[from] vibro_assembly::Refusal),
    /// What was set under way does not go with the present state.
    #[error("{set}: {problem}")]
    Change {
        /// Names and values.
        set: String,
        /// Why not.
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

/// Why bytes are no saved state of this machine.
pub(crate) fn refused(what: impl Into<String>) -> Problem {
    Problem::SavedState { what: what.into().into() }
}
