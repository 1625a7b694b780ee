//! Forces of stiff springs and compliant stops, separate from the rest of A.
//!
//! Such a force acts on two bodies with opposite signs. The entries of exp(A h) that express it
//! are rounded independently. If coordinates are far greater than the elongation, the result is a
//! spurious force, the same in thousands of sub-steps. A force that is computed first and then
//! applied to both bodies has opposite signs to the last bit.

use crate::functional::Functional;
use crate::kernel::{Sparse, SparseMatrix};
use crate::linear::Elastic;
use crate::system::Term;
use nalgebra::DMatrix;
use std::sync::Arc;
use vibro_numerics::double_double::DoubleDouble;

/// A = rest - Σ by ⊗ force, with separate forces.
#[derive(Clone, Debug)]
pub(super) struct Apart {
    /// A without these forces.
    pub(super) rest: Arc<SparseMatrix>,
    /// Sizes of the terms of the entries of `rest`, if there are contacts.
    rest_terms: Option<SparseMatrix>,
    /// The forces, each with the column that a unit of it subtracts from z'.
    pub(super) forces: Vec<(Arc<Functional>, Arc<Sparse>)>,
}

impl Apart {
    /// The form of A with a mode's elastic forces separate.
    pub(super) fn of(Elastic { rest, rest_terms, forces, .. }: Elastic) -> Self {
        Self { rest: Arc::new(rest), rest_terms, forces }
    }

    /// The form of A for a mode without held contacts.
    pub(super) fn split(rest: Arc<SparseMatrix>, terms: Vec<Term>) -> Self {
        let forces = terms.into_iter().map(|term| (term.force, term.by));
        Self { rest, rest_terms: None, forces: forces.collect() }
    }

    /// `to` = `factor` × A `z`, beginning with row `first`, with the forces computed first.
    #[inline(always)]
    pub(super) fn rows_times_to(&self, first: usize, z: &[f64], factor: f64, to: &mut [f64]) {
        self.rest.rows_times_to(first, z, factor, to);
        for (force, by) in &self.forces {
            let force = factor * force.at(z);
            by.terms().iter().for_each(|&(k, x)| to[k - first] -= force * x);
        }
    }

    /// Sizes of the terms of each entry of A without these forces, if there are contacts.
    pub(super) fn rest_terms(&self) -> Option<&SparseMatrix> {
        self.rest_terms.as_ref()
    }

    /// Adds `factor` × the sizes of these forces' contributions to z', beginning with row `first`,
    /// given the coordinates' sizes. Contacts carry no share of them.
    pub(super) fn add_sizes(&self, first: usize, sizes: &[f64], factor: f64, to: &mut [f64]) {
        for (force, by) in &self.forces {
            let force = factor * force.size(sizes);
            by.terms().iter().for_each(|&(k, x)| to[k - first] += force * x.abs());
        }
    }

    /// A as one matrix. Each force's part of a row is rounded separately, so that parts of
    /// opposite sign in two rows stay opposite.
    pub(super) fn sum(&self) -> SparseMatrix {
        self.rest.less(self.forces.iter().map(|(force, by)| [by.terms(), force.terms()]))
    }

    /// A in double-double arithmetic.
    pub(super) fn matrix(&self, size: usize) -> DMatrix<DoubleDouble> {
        let mut a = DMatrix::from_element(size, size, DoubleDouble::default());
        for i in 0..size {
            self.rest.row(i).iter().for_each(|&(j, x)| a[(i, j)] = x.into());
        }
        for (force, by) in &self.forces {
            for &(i, x) in by.terms() {
                let part = DoubleDouble::new(-x);
                force.terms().iter().for_each(|&(j, f)| a[(i, j)] = a[(i, j)] + part.times(f.into()));
            }
        }
        a
    }

    /// Count of stored numbers.
    pub(super) fn numbers(&self) -> usize {
        let terms = self.rest_terms.as_ref().map_or(0, SparseMatrix::entries);
        if terms == 0 {
            return 2 * self.forces.len(); // shared by the modes
        }
        let by = self.forces.iter().map(|(force, by)| force.len() + force.terms().len() + by.terms().len());
        2 * (self.rest.entries() + terms) + 2 * by.sum::<usize>()
    }
}
