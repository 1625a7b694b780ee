//! The one error type of the packager.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

/// Error while packing or running; every message states the problem and the remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("{action} {}: {source}", path.display())]
    File {
        /// The failed action, e.g. `writing`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// Cargo could not be run or failed.
    #[error("`{command}` {problem}")]
    Cargo {
        /// The command line.
        command: String,
        /// The problem, and the remedy.
        problem: String,
    },
    /// The model description could not be written or read.
    #[error("modelDescription.xml: {0}")]
    Xml(String),
    /// The model description contradicts itself or the standard.
    #[error("modelDescription.xml is not valid; correct the table in crates/paper-component/src/component/variables:\n  {}", .0.join("\n  "))]
    Invalid(Vec<String>),
    /// An archive could not be written or read, or the archive of a machine could not be made.
    #[error(transparent)]
    Pack(#[from] vibro_pack::Error),
    /// The packaged binary could not be loaded, or lacks a function.
    #[error("loading the packaged binary: {0}")]
    Load(#[from] libloading::Error),
    /// A call into the packaged binary did not return `fmi2OK` or `fmi3OK`.
    #[error("{call} returned {status}; the FMU's log says: {log}")]
    Call {
        /// The function.
        call: &'static str,
        /// Name of the status.
        status: &'static str,
        /// Log of the FMU.
        log: String,
    },
    /// No variable has that name.
    #[error("the FMU has no variable {0}")]
    Variable(String),
    /// The simulator refused the run.
    #[error("native run: {0}")]
    Native(#[from] vibro_impact::Error),
    /// The archives do not hold the same library.
    #[error("{} and {} hold different libraries; build both again with `cargo run --bin fmu-build`", first.display(), second.display())]
    Binaries {
        /// One archive.
        first: PathBuf,
        /// The other.
        second: PathBuf,
    },
    /// The packaged binary and the native library disagree.
    #[error(
        "{name} at t = {time} s is {packaged:e} in the packaged binary of {version} and {native:e} in the native run: they must be equal bit for bit; run `cargo clean`, build both again and, if they still differ, report it"
    )]
    Differs {
        /// Archive.
        version: &'static str,
        /// Variable.
        name: &'static str,
        /// Time in s.
        time: f64,
        /// Value from the packaged binary.
        packaged: f64,
        /// Value from the native run.
        native: f64,
    },
    /// A machine's file is refused.
    #[error("{0}")]
    Refusal(#[from] vibro_machine::Refusal),
    /// The machine cannot be packed as an FMU.
    #[error("{0}")]
    Machine(#[from] vibro_machine_component::MachineProblem),
    /// A picture could not be drawn.
    #[error(transparent)]
    Picture(#[from] vibro_figures::Error),
    /// A release cannot be made from the present files.
    #[error("no release:\n  {}", .0.join("\n  "))]
    Release(Vec<String>),
    /// A command-line option has an invalid value.
    #[error("{name} = {value}: expected {allowed}")]
    Option {
        /// The option.
        name: &'static str,
        /// Its value.
        value: String,
        /// The valid values.
        allowed: Cow<'static, str>,
    },
}

impl Error {
    /// Wraps an error of a file operation, for `map_err`.
    pub(crate) fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::File { action, path: path.to_owned(), source }
    }
}

/// Result with the packager's error.
pub type Result<T> = std::result::Result<T, Error>;
