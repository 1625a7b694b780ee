//! The forces of stiff buffers apart from the rest of A, and what a sub-step adds to the state: z(h) - z = ∫ exp(A s) ds · z'.
//!
//! A buffer's force acts on two bodies with opposite signs. The entries of exp(A h) that say so are rounded each by itself, and with coordinates
//! that are far greater than the buffer's deflection this is a force from nowhere, the same in each of thousands of sub-steps. Found
//! first and then put to both bodies, the force has opposite signs to its last bit, and what the integral is multiplied by is of the size of
//! what changes.

use super::RADIUS;
use super::exponential::series_orders;
use crate::kernel::{Blocks, Sparse, SparseMatrix};
use crate::mode::Buffers;
use crate::system::Functional;
use nalgebra::DMatrix;

/// A = rest - Σ by ⊗ force.
#[derive(Clone, Debug)]
pub(super) struct Apart {
    /// A without the buffers.
    rest: SparseMatrix,
    /// The buffers' forces, and what a unit of each takes from z'.
    forces: Vec<(Functional, Sparse)>,
}

impl Apart {
    /// Of a mode in which buffers press.
    pub(super) fn of(Buffers { rest, forces }: Buffers) -> Self {
        let forces = forces.into_iter().map(|(force, by)| (force, Sparse::of(by.as_slice())));
        Self { rest, forces: forces.collect() }
    }

    /// `to` = `factor` × A `z` but for the first rows, the buffers' forces found first.
    #[inline(always)]
    pub(super) fn rows_times_to(&self, first: usize, z: &[f64], factor: f64, to: &mut [f64]) {
        self.rest.rows_times_to(first, z, factor, to);
        for (force, by) in &self.forces {
            let force = factor * force.at(z);
            by.terms().iter().for_each(|&(k, x)| to[k - first] -= force * x);
        }
    }

    /// Numbers that it holds.
    pub(super) fn numbers(&self) -> usize {
        let by = self.forces.iter().map(|(force, by)| force.len() + force.terms().len() + by.terms().len());
        2 * self.rest.entries() + 2 * by.sum::<usize>()
    }
}

/// ∫ exp(A s) ds over a sub-step.
pub(super) fn integral(a: &SparseMatrix, length: f64) -> Blocks {
    // Transposed until the end.
    let mut term = DMatrix::identity(a.len(), a.len()) * length;
    let mut sum = term.clone();
    for k in 1..=series_orders(RADIUS) {
        term = a.times_rows(&term, length / (k + 1) as f64);
        sum += &term;
    }
    Blocks::of(&sum.transpose())
}

/// The state at the end of a sub-step, from that at its start, its rates and this integral.
#[inline(always)]
pub(super) fn at_end(integral: &Blocks, z: &[f64], rates: &[f64], to: &mut [f64]) {
    integral.times(rates, to);
    for (to, z) in to.iter_mut().zip(z) {
        *to += z;
    }
}
