//! Reduction of the matrices of a finite-element program to a body of a described machine.
//!
//! [`import`] reads stiffness and mass with the names of their dofs, [`model`] checks them,
//! [`reduction`] computes modes, residual flexibility and the error statement, and [`output`]
//! writes the section `[modal.NAME]`, the basis and a report. The factorisations are in
//! [`factor`], the choice of the shift is in [`shift`], the eigenvalues are in [`eigen`].

pub mod clamp;
pub mod damping;
mod dense;
pub mod dofs;
pub mod eigen;
pub mod factor;
pub mod import;
pub mod interface;
pub mod job;
pub mod model;
pub mod output;
pub mod problem;
pub mod reduction;
pub mod shift;
pub mod sparse;
pub mod statement;
pub mod units;

/// Refused input, or a computation that did not succeed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{what}: {problem}")]
pub struct Error {
    /// The file with its line, the option or the dof.
    pub what: String,
    /// The problem and the expected input.
    pub problem: String,
}

impl Error {
    /// An error of a file, an option or a dof.
    pub fn new(what: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { what: what.into(), problem: problem.into() }
    }
}

/// Result with an [`Error`] of this package.
pub type Result<T> = std::result::Result<T, Error>;
