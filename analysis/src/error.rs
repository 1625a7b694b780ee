//! What can go wrong between the user's words and the files on disk.

use std::path::{Path, PathBuf};

/// Errors of the analyses; every message names what was given and what is allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The model refuses.
    #[error(transparent)]
    Model(#[from] vibro_impact::Error),
    /// No parameter has this name.
    #[error("no parameter is named `{name}`; the nearest is `{nearest}`: {description}, {allowed}")]
    UnknownName {
        /// What was given.
        name: String,
        /// The nearest valid name.
        nearest: &'static str,
        /// What that one is.
        description: &'static str,
        /// The range of that one.
        allowed: &'static str,
    },
    /// The value of a parameter is no number.
    #[error("{name} = `{text}` is not a number: allowed is {allowed}")]
    NotANumber {
        /// The parameter.
        name: &'static str,
        /// What was given.
        text: String,
        /// Its range.
        allowed: &'static str,
    },
    /// A text of another form than the one expected.
    #[error("`{text}`: expected {expected}")]
    Form {
        /// What was given.
        text: String,
        /// The form, with an example.
        expected: &'static str,
    },
    /// A parameter file cannot be understood.
    #[error("{}: {problem}", path.display())]
    Config {
        /// The file.
        path: PathBuf,
        /// What is wrong, and where.
        problem: String,
    },
    /// Reading or writing a file failed.
    #[error("{doing} {}: {source}", path.display())]
    File {
        /// What was being done.
        doing: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A picture or table could not be made.
    #[error("making {what}: {problem}")]
    Output {
        /// What was being made.
        what: &'static str,
        /// The library's reason.
        problem: String,
    },
}

/// Result with the analyses' error.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Whether the user's input is at fault, not the machine.
    pub fn is_usage(&self) -> bool {
        !matches!(self, Self::File { doing: "writing" | "making folder", .. } | Self::Output { .. })
    }

    /// For `map_err` on operations on a file.
    pub fn file(doing: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::File { doing, path, source }
    }

    /// For `map_err` on the libraries that make pictures and tables.
    pub fn output<E: std::fmt::Display>(what: &'static str) -> impl Fn(E) -> Self {
        move |e| Self::Output { what, problem: e.to_string() }
    }
}
