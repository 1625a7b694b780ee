//! Errors of the command line's library.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use vibro_machine::file::unread;

/// An error; every message states the given input and the valid choices.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Invalid input of an analysis.
    #[error(transparent)]
    Analysis(#[from] vibro_studies::Error),
    /// A machine's file, or a new value of its parameters, is refused.
    #[error(transparent)]
    Refusal(#[from] vibro_machine::Refusal),
    /// A described machine cannot be built or its motion cannot continue.
    #[error(transparent)]
    Assembly(#[from] vibro_machine::Error),
    /// A parameter file or a folder of parts is not valid.
    #[error("{}: {problem}", path.display())]
    Config {
        /// The file or folder.
        path: PathBuf,
        /// The problem, and where it is.
        problem: String,
    },
    /// Input that does not fit the requested study.
    #[error("{what}: {problem}")]
    Refused {
        /// The input.
        what: String,
        /// Why it does not fit, and what does.
        problem: String,
    },
    /// Nothing that was requested could be computed.
    #[error("{what}: {problem}")]
    Failed {
        /// The study.
        what: String,
        /// Reason of the first failure.
        problem: String,
    },
    /// Reading or writing a file failed.
    #[error("{}", failed(doing, path, source))]
    File {
        /// The failed action, e.g. `writing`.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// Reason given by the system.
        source: std::io::Error,
    },
    /// A picture could not be made.
    #[error(transparent)]
    Picture(#[from] vibro_figures::Error),
    /// A table could not be made.
    #[error("making {what}: {problem}")]
    Output {
        /// The failed output.
        what: &'static str,
        /// Reason given by the library.
        problem: String,
    },
}

/// The failed operation on a file, and the cause.
fn failed(doing: &str, path: &Path, source: &io::Error) -> String {
    let name = path.display();
    let said = source.to_string();
    let said = said.split(" (os error").next().unwrap_or_default();
    match source.kind() {
        ErrorKind::AlreadyExists | ErrorKind::NotADirectory => {
            format!("{name}: is a file; expected a folder")
        }
        _ if doing == "reading" => format!("{name}: {}", unread(source, "save it with the encoding UTF-8")),
        ErrorKind::NotFound if doing == "writing" => {
            let folder = path.parent().unwrap_or(Path::new(""));
            format!("{name}: cannot be written: there is no folder {}", folder.display())
        }
        _ if doing == "writing" => format!("{name}: cannot be written: {said}; give another path"),
        _ if doing == "making folder" => {
            format!("{name}: the folder cannot be made: {said}; give another folder (--out)")
        }
        _ => format!("{doing} {name}: {said}"),
    }
}

/// Result with this error.
pub type Result<T> = std::result::Result<T, Error>;

impl From<vibro_impact::Error> for Error {
    fn from(error: vibro_impact::Error) -> Self {
        Self::Analysis(error.into())
    }
}

impl Error {
    /// Whether the error is in the user's input, not in the computer or the motion.
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

    /// Wraps an error of a file operation, for `map_err`.
    pub fn file(doing: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::File { doing, path, source }
    }

    /// Wraps an error of a library that makes tables, for `map_err`.
    pub fn output<E: std::fmt::Display>(what: &'static str) -> impl Fn(E) -> Self {
        move |e| Self::Output { what, problem: e.to_string() }
    }
}
