//! The eigenproblem K φ = λ M φ with its factor. Module [`crate::shift`] makes it.

use crate::Result;
use crate::factor::{Analysis, Factor};
use crate::sparse::Symmetric;
use nalgebra::DMatrix;

/// Stiffness, mass, and the factor of K - σ M.
pub struct Problem<'m> {
    /// Stiffness.
    pub stiffness: &'m Symmetric,
    /// Mass.
    pub mass: &'m Symmetric,
    /// Pattern of K - σ M.
    pub analysis: Analysis,
    /// Factor of K - σ M.
    pub factor: Factor,
    /// σ: 0 for a body that is held, negative for a free one.
    pub shift: f64,
    /// Number of rigid-body modes.
    pub rigid: usize,
}

impl Problem<'_> {
    /// (K - σ M)⁻¹ b.
    ///
    /// # Errors
    /// An error if there is too little memory.
    pub fn solve(&self, mut b: DMatrix<f64>) -> Result<DMatrix<f64>> {
        self.factor.solve(&mut b)?;
        Ok(b)
    }

    /// Number of eigenvalues below a value.
    ///
    /// # Errors
    /// An error if the factor cannot be computed.
    pub fn below(&self, value: f64) -> Result<usize> {
        self.analysis.negative_eigenvalues(&self.stiffness.plus(-value, self.mass))
    }
}
