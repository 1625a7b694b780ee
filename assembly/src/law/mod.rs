//! The law at events: contact forces and impulses, impacts, and which mode follows (docs/assembly-law.md).

pub mod box_qp;
pub mod impact;
pub mod selection;

use crate::kernel::Sparse;
use crate::system::Row;
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// What is under this part of the sum of its terms' largest sizes so far counts as zero: some hundreds of roundings.
pub const ZERO: f64 = 1e-13;

/// The largest size of each coordinate of the augmented state so far.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sizes(#[serde(with = "crate::motion::saved::vector")] pub DVector<f64>);

impl Sizes {
    /// The sum of the sizes of a row's terms.
    pub fn of(&self, row: &Row) -> f64 {
        row.iter().zip(self.0.iter()).map(|(r, s)| r.abs() * s).sum()
    }

    /// The same of a row by its terms.
    pub(crate) fn zero_of(&self, row: &Sparse) -> f64 {
        ZERO * row.size(self.0.as_slice())
    }

    /// Below this a row's value counts as zero.
    pub fn zero(&self, row: &Row) -> f64 {
        ZERO * self.of(row)
    }

    /// Takes in a state.
    #[inline(always)]
    pub fn include(&mut self, z: &[f64]) {
        self.include_from(0, z);
    }

    /// Takes in coordinates of the state, the first of them at a place.
    #[inline(always)]
    pub fn include_from(&mut self, first: usize, z: &[f64]) {
        self.0.as_mut_slice()[first..].iter_mut().zip(z).for_each(|(s, x)| *s = s.max(x.abs()));
    }
}
