//! The forces of stiff springs and of buffers apart from the rest of A.
//!
//! Such a force acts on two bodies with opposite signs. The entries of exp(A h) that say so are
//! rounded each by itself, and with coordinates that are far greater than its elongation this is a
//! force from nowhere, the same in each of thousands of sub-steps. Found first and then put to both
//! bodies, the force has opposite signs to its last bit.

use crate::kernel::{Sparse, SparseMatrix};
use crate::mode::Elastic;
use crate::system::Functional;
use nalgebra::DMatrix;
use vibro_impact::numerics::double_double::DoubleDouble;

/// A = rest - Σ by ⊗ force.
#[derive(Clone, Debug)]
pub(super) struct Apart {
    /// A without them.
    rest: SparseMatrix,
    /// Where there are contacts, the sizes of the terms of its entries.
    rest_terms: Option<SparseMatrix>,
    /// The forces, and what a unit of each takes from z'.
    forces: Vec<(Functional, Sparse)>,
}

impl Apart {
    /// Of a mode's elastic forces.
    pub(super) fn of(Elastic { rest, rest_terms, forces, .. }: Elastic) -> Self {
        let forces = forces.into_iter().map(|(force, by)| (force, Sparse::of(by.as_slice())));
        Self { rest, rest_terms, forces: forces.collect() }
    }

    /// `to` = `factor` × A `z` but for the first rows, the forces found first.
    #[inline(always)]
    pub(super) fn rows_times_to(&self, first: usize, z: &[f64], factor: f64, to: &mut [f64]) {
        self.rest.rows_times_to(first, z, factor, to);
        for (force, by) in &self.forces {
            let force = factor * force.at(z);
            by.terms().iter().for_each(|&(k, x)| to[k - first] -= force * x);
        }
    }

    /// The sizes of the terms of A's entries without these forces, where there are contacts.
    pub(super) fn rest_terms(&self) -> Option<&SparseMatrix> {
        self.rest_terms.as_ref()
    }

    /// Adds `factor` × what these forces do to the rates, in sizes, from the coordinates' sizes,
    /// but for the first rows: nothing of what contacts hold.
    pub(super) fn add_sizes(&self, first: usize, sizes: &[f64], factor: f64, to: &mut [f64]) {
        for (force, by) in &self.forces {
            let force = factor * force.size(sizes);
            by.terms().iter().for_each(|&(k, x)| to[k - first] += force * x.abs());
        }
    }

    /// A, each force's part of a row rounded by itself: what it takes from coordinates with
    /// opposite signs stays opposite.
    pub(super) fn sum(&self) -> SparseMatrix {
        let size = self.rest.len();
        let (mut a, mut row) = (SparseMatrix::default(), vec![0.0; size]);
        for i in 0..size {
            row.fill(0.0);
            self.rest.row(i).iter().for_each(|&(j, x)| row[j] = x);
            for (force, by) in &self.forces {
                let x = by.terms().iter().find(|(k, _)| *k == i).map_or(0.0, |(_, x)| *x);
                force.terms().iter().for_each(|&(j, f)| row[j] -= x * f);
            }
            a.push_row(row.iter().copied().enumerate());
        }
        a
    }

    /// A by double-doubles.
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

    /// Numbers that it holds.
    pub(super) fn numbers(&self) -> usize {
        let by = self.forces.iter().map(|(force, by)| force.len() + force.terms().len() + by.terms().len());
        let terms = self.rest_terms.as_ref().map_or(0, SparseMatrix::entries);
        2 * (self.rest.entries() + terms) + 2 * by.sum::<usize>()
    }
}
