//! What a sub-step adds to the state of a mode in which a stiff buffer is pressed: z(h) - z = ∫ exp(A s) ds · z', with z' by the elements.
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

/// What a sub-step adds.
#[derive(Clone, Debug)]
pub(super) struct Increment {
    /// A without the buffers.
    rest: SparseMatrix,
    /// The buffers' forces, and what a unit of each changes of z'.
    forces: Vec<(Functional, Sparse)>,
    /// ∫ exp(A s) ds over a sub-step.
    integral: Blocks,
}

impl Increment {
    /// Of a mode of which a sub-step has the length `length`.
    pub(super) fn new(a: &SparseMatrix, buffers: Buffers, length: f64) -> Self {
        // Transposed until the end.
        let mut term = DMatrix::identity(a.len(), a.len()) * length;
        let mut sum = term.clone();
        for k in 1..=series_orders(RADIUS) {
            term = a.times_rows(&term, length / (k + 1) as f64);
            sum += &term;
        }
        let integral = Blocks::of(&sum.transpose());
        let forces = buffers.forces.into_iter().map(|(force, by)| (force, Sparse::of(by.as_slice())));
        Self { rest: SparseMatrix::of(&buffers.rest), forces: forces.collect(), integral }
    }

    /// The state at the end of a sub-step, from that at its start and its rates.
    #[inline(always)]
    pub(super) fn at_end(&self, z: &[f64], rates: &[f64], to: &mut [f64]) {
        self.integral.times(rates, to);
        for (to, z) in to.iter_mut().zip(z) {
            *to += z;
        }
    }

    /// z' at a state, the buffers' forces found first.
    #[inline(always)]
    pub(super) fn rates(&self, z: &[f64], rates: &mut [f64]) {
        self.rest.times(z, 1.0, rates);
        for (force, by) in &self.forces {
            let force = force.at(z);
            by.terms().iter().for_each(|&(k, x)| rates[k] -= force * x);
        }
    }

    /// Numbers that it holds.
    pub(super) fn numbers(&self) -> usize {
        self.rest.len() * self.rest.len() + 2 * self.rest.entries()
    }
}
