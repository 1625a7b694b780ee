//! Functionals of the state by the few coordinates that they have.

use vibro_assembly::flow::ORDERS;

/// A functional.
#[derive(Clone, Debug, Default)]
pub(super) struct Sparse(Vec<(usize, f64)>);

impl Sparse {
    /// Of all its weights.
    pub fn of(row: impl IntoIterator<Item = f64>) -> Self {
        Self(row.into_iter().enumerate().filter(|term| term.1 != 0.0).collect())
    }

    /// Its value.
    pub fn at(&self, z: &[f64]) -> f64 {
        self.0.iter().map(|&(i, weight)| weight * z[i]).sum()
    }

    /// Its coefficients along a series.
    pub fn along(&self, series: &[Vec<f64>]) -> [f64; ORDERS] {
        let mut c = [0.0; ORDERS];
        c.iter_mut().zip(series).for_each(|(c, term)| *c = self.at(term));
        c
    }
}
