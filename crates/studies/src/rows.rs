//! Sparse functionals of the state.

use super::flight::Series;
use vibro_machine::flow::ORDERS;

/// Functional by its nonzero weights.
#[derive(Clone, Debug, Default)]
pub(super) struct Sparse(Vec<(usize, f64)>);

impl Sparse {
    /// The functional with all its weights given.
    pub fn of(row: impl IntoIterator<Item = f64>) -> Self {
        Self(row.into_iter().enumerate().filter(|term| term.1 != 0.0).collect())
    }

    /// Value at a state.
    pub fn at(&self, z: &[f64]) -> f64 {
        self.0.iter().map(|&(i, weight)| weight * z[i]).sum()
    }

    /// Coefficients along a series.
    pub fn along(&self, series: &Series) -> [f64; ORDERS] {
        let mut c = [0.0; ORDERS];
        c.iter_mut().zip(series.terms()).for_each(|(c, term)| *c = self.at(term));
        c
    }
}
