//! Errors when writing and reading archives.

use std::path::{Path, PathBuf};

/// Error; each message names the fault and its remedy.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("{action} {}: {source}", path.display())]
    File {
        /// The attempted action, e.g. `writing`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The archive could not be written or read.
    #[error("{}: is not a zip archive, or is damaged ({source})", path.display())]
    Archive {
        /// The archive.
        path: PathBuf,
        /// The cause.
        source: zip::result::ZipError,
    },
    /// The archive lacks a file.
    #[error("archive {} has no {name}; build it again with `cargo run --bin fmu-build`", path.display())]
    Missing {
        /// The archive.
        path: PathBuf,
        /// The missing file.
        name: String,
    },
    /// The machine cannot be packed as an FMU.
    #[error("{0}")]
    Machine(#[from] vibro_machine_component::MachineProblem),
    /// A picture could not be drawn.
    #[error(transparent)]
    Picture(#[from] vibro_figures::Error),
}

impl Error {
    /// Maps an I/O error of a file operation, for `map_err`.
    pub(crate) fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::File { action, path: path.to_owned(), source }
    }
}

/// Result with this error.
pub type Result<T> = std::result::Result<T, Error>;
