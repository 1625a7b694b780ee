//! Matrices of a machine by the nonzero entries of their rows.

use crate::functional::Functional;
use crate::kernel::Sparse;
use nalgebra::{DMatrix, DVector};
use std::ops::{Deref, Index};
use std::sync::OnceLock;

/// A matrix, stored by the nonzero entries of its rows. It dereferences to the full matrix, which
/// is made on first use.
#[derive(Clone, Debug)]
pub struct RowMatrix {
    columns: usize,
    rows: Vec<Sparse>,
    all: OnceLock<DMatrix<f64>>,
}

/// Entries of a matrix that are added up.
pub(crate) struct RowSums {
    columns: usize,
    rows: Vec<Vec<(usize, f64)>>,
}

impl RowSums {
    /// The matrix of zeros.
    pub(crate) fn zeros(rows: usize, columns: usize) -> Self {
        Self { columns, rows: vec![Vec::new(); rows] }
    }

    /// Adds factor · x yᵀ.
    pub(crate) fn add_outer(&mut self, factor: f64, x: &Functional, y: &Functional) {
        for &(i, own) in x.terms() {
            self.rows[i].extend(y.terms().iter().map(|&(j, y)| (j, factor * y * own)));
        }
    }

    /// The sums.
    pub(crate) fn finish(self) -> RowMatrix {
        let rows = self.rows.into_iter().map(Sparse::summed).collect();
        RowMatrix { columns: self.columns, rows, all: OnceLock::new() }
    }
}

impl RowMatrix {
    /// The nonzero entries of a row, with their column indices.
    pub fn entries(&self, i: usize) -> &[(usize, f64)] {
        self.rows[i].terms()
    }

    /// The entries on the diagonal.
    pub fn diagonal(&self) -> DVector<f64> {
        DVector::from_fn(self.rows.len(), |k, _| self[(k, k)])
    }

    /// Whether all entries off the diagonal are zero.
    pub(crate) fn is_diagonal(&self) -> bool {
        self.rows.iter().enumerate().all(|(i, row)| row.terms().iter().all(|&(j, _)| i == j))
    }

    /// Whether all entries are zero.
    pub(crate) fn is_zero(&self) -> bool {
        self.rows.iter().all(|row| row.terms().is_empty())
    }

    /// The product with a vector.
    pub fn times(&self, z: &DVector<f64>) -> DVector<f64> {
        DVector::from_iterator(self.rows.len(), self.rows.iter().map(|row| row.dot(z.as_slice())))
    }

    /// The product of the entries' absolute values and a vector's absolute values.
    pub(crate) fn sizes(&self, z: &DVector<f64>) -> DVector<f64> {
        let sizes = z.abs();
        DVector::from_iterator(self.rows.len(), self.rows.iter().map(|row| row.size(sizes.as_slice())))
    }
}

impl Index<(usize, usize)> for RowMatrix {
    type Output = f64;

    fn index(&self, (i, j): (usize, usize)) -> &f64 {
        let row = self.entries(i);
        row.binary_search_by_key(&j, |entry| entry.0).map_or(&0.0, |place| &row[place].1)
    }
}

impl Deref for RowMatrix {
    type Target = DMatrix<f64>;

    fn deref(&self) -> &DMatrix<f64> {
        self.all.get_or_init(|| {
            let mut all = DMatrix::zeros(self.rows.len(), self.columns);
            for (i, row) in self.rows.iter().enumerate() {
                row.terms().iter().for_each(|&(j, x)| all[(i, j)] = x);
            }
            all
        })
    }
}
