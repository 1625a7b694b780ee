//! What can go wrong while archives are written and read.

use std::path::{Path, PathBuf};

/// What can go wrong; every message says what was wrong and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A file could not be read or written.
    #[error("{action} {}: {source}", path.display())]
    File {
        /// What was tried, e.g. `writing`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// Why not.
        source: std::io::Error,
    },
    /// The archive could not be written or read.
    #[error("archive {}: {source}", path.display())]
    Archive {
        /// The archive.
        path: PathBuf,
        /// Why not.
        source: zip::result::ZipError,
    },
    /// The archive lacks a file.
    #[error("archive {} has no {name}; build it again with `cargo run --bin fmu-build`", path.display())]
    Missing {
        /// The archive.
        path: PathBuf,
        /// The file looked for.
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
    /// For `map_err` on file operations.
    pub(crate) fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        move |source| Self::File { action, path: path.to_owned(), source }
    }
}

/// Result with this error.
pub type Result<T> = std::result::Result<T, Error>;
