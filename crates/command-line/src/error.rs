//! Errors of the command line's library.

use std::path::{Path, PathBuf};

/// An error; every message names what was given and what is allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An analysis refuses its input.
    #[error(transparent)]
    Analysis(#[from] vibro_studies::Error),
    /// A machine's file, or a new value of its parameters, is refused.
    #[error(transparent)]
    Refusal(#[from] vibro_machine::Refusal),
    /// A described machine cannot be built or its motion cannot go on.
    #[error(transparent)]
    Assembly(#[from] vibro_machine::Error),
    /// A parameter file or a folder of parts cannot be understood.
    #[error("{}: {problem}", path.display())]
    Config {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong, and where.
        problem: String,
    },
    /// Input that does not fit the study that was asked for.
    #[error("{what}: {problem}")]
    Refused {
        /// What was given.
        what: String,
        /// Why it does not fit, and what does.
        problem: String,
    },
    /// Nothing that was asked for could be computed.
    #[error("{what}: {problem}")]
    Failed {
        /// The study.
        what: String,
        /// The reason of the first failure.
        problem: String,
    },
    /// Reading or writing a file failed.
    #[error("{doing} {}: {source}", path.display())]
    File {
        /// What was being done, e.g. `writing`.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A picture could not be made.
    #[error(transparent)]
    Picture(#[from] vibro_figures::Error),
    /// A table could not be made.
    #[error("making {what}: {problem}")]
    Output {
        /// What was being made.
        what: &'static str,
        /// The library's reason.
        problem: String,
    },
}

/// Result with this error.
pub type Result<T> = std::result::Result<T, Error>;

impl From<vibro_impact::Error> for Error {
    fn from(error: vibro_impact::Error) -> Self {
        Self::Analysis(error.into())
    }
}

impl Error {
    /// Whether the user's input is at fault, and not the computer or the motion.
    pub fn is_usage(&self) -> bool {
        !matches!(
            self,
            Self::File { doing: "writing" | "making folder", .. }
                | Self::Output { .. }
                | Self::Failed { .. }
                | Self::Picture(_)
                | Self::Assembly(
                    vibro_machine::Error::Jammed { .. }
                        | vibro_machine::Error::Stuck { .. }
                        | vibro_machine::Error::TooStiff { .. }
                        | vibro_machine::Error::Beyond { .. }
                        | vibro_machine::Error::Interrupted { .. }
                        | vibro_machine::Error::Violated { .. }
                )
                | Self::Analysis(vibro_studies::Error::Store(_))
        )
    }

    /// Error for a text that does not have the expected form.
    pub fn form(text: impl Into<String>, expected: &'static str) -> Self {
        vibro_studies::Error::Form { text: text.into(), expected }.into()
    }

    /// For `map_err` on operations on a file.
    pub fn file(doing: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::File { doing, path, source }
    }

    /// For `map_err` on the libraries that make tables.
    pub fn output<E: std::fmt::Display>(what: &'static str) -> impl Fn(E) -> Self {
        move |e| Self::Output { what, problem: e.to_string() }
    }
}
