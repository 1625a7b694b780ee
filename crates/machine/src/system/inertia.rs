//! The factored inertia matrix, in blocks of coordinates that links and nodes couple.

use super::RowMatrix;
use crate::components::components;
use crate::functional::Functional;
use crate::kernel::sort_by_place;
use nalgebra::{Cholesky, DMatrix, DVector, Dim, Dyn, Matrix, OMatrix, StorageMut};
use std::sync::OnceLock;

/// Cholesky factor L of the inertia matrix M = L Lᵀ.
#[derive(Clone, Debug)]
pub struct Inertia {
    blocks: Vec<Block>,
    /// Block of each coordinate, and its index there.
    homes: Vec<(usize, usize)>,
    /// L with all entries.
    lower: OnceLock<DMatrix<f64>>,
}

/// Coordinates that M couples, in ascending order.
#[derive(Clone, Debug)]
struct Block {
    places: Vec<usize>,
    factor: Cholesky<f64, Dyn>,
}

impl Inertia {
    /// The factor; `None` if the matrix is not positive definite in double precision.
    pub(crate) fn new(mass: &RowMatrix) -> Option<Self> {
        let n = mass.diagonal().len();
        let pairs = (0..n).flat_map(|i| mass.entries(i).iter().map(move |&(j, _)| (i, j)));
        let mut blocks = Vec::new();
        let mut homes = vec![(0, 0); n];
        for places in components(n, pairs) {
            places.iter().enumerate().for_each(|(place, &k)| homes[k] = (blocks.len(), place));
            let own = DMatrix::from_fn(places.len(), places.len(), |i, j| mass[(places[i], places[j])]);
            blocks.push(Block { factor: Cholesky::new(own)?, places });
        }
        Some(Self { blocks, homes, lower: OnceLock::new() })
    }

    /// M⁻¹ times each column.
    pub fn solve<C: Dim, S: nalgebra::Storage<f64, Dyn, C>>(
        &self,
        b: &Matrix<f64, Dyn, C, S>,
    ) -> OMatrix<f64, Dyn, C>
    where
        nalgebra::DefaultAllocator: nalgebra::allocator::Allocator<Dyn, C>,
    {
        let mut x = b.clone_owned();
        self.solve_mut(&mut x);
        x
    }

    /// Replaces each column x by M⁻¹ x.
    pub fn solve_mut<C: Dim, S: StorageMut<f64, Dyn, C>>(&self, b: &mut Matrix<f64, Dyn, C, S>) {
        for Block { places, factor } in &self.blocks {
            for column in 0..b.ncols() {
                let own = places.iter().map(|&k| b[(k, column)]);
                let mut own = DVector::from_iterator(places.len(), own);
                factor.solve_mut(&mut own);
                places.iter().zip(own.iter()).for_each(|(&k, &x)| b[(k, column)] = x);
            }
        }
    }

    /// L⁻¹ w and M⁻¹ w.
    pub(crate) fn column_and_mobility(&self, w: &Functional) -> [Functional; 2] {
        let mut touched: Vec<usize> = w.terms().iter().map(|&(k, _)| self.homes[k].0).collect();
        touched.sort_unstable();
        touched.dedup();
        let [mut column, mut mobility] = [const { Vec::new() }; 2];
        for Block { places, factor } in touched.into_iter().map(|block| &self.blocks[block]) {
            let mut own = DVector::from_iterator(places.len(), places.iter().map(|&k| w[k]));
            factor.l_dirty().solve_lower_triangular_mut(&mut own);
            column.extend(places.iter().copied().zip(own.iter().copied()));
            factor.l_dirty().ad_solve_lower_triangular_mut(&mut own);
            mobility.extend(places.iter().copied().zip(own.iter().copied()));
        }
        [column, mobility].map(|mut terms| {
            sort_by_place(&mut terms);
            Functional::from_terms(w.len(), terms.into_iter())
        })
    }

    /// M⁻¹ times a matrix, by rows.
    pub(crate) fn solve_rows(&self, forces: &RowMatrix) -> Vec<Vec<(usize, f64)>> {
        let mut rows = vec![Vec::new(); self.homes.len()];
        for Block { places, factor } in &self.blocks {
            let entries = places.iter().flat_map(|&i| forces.entries(i));
            let mut columns: Vec<usize> = entries.map(|entry| entry.0).collect();
            columns.sort_unstable();
            columns.dedup();
            for j in columns {
                let own = places.iter().map(|&i| forces[(i, j)]);
                let mut own = DVector::from_iterator(places.len(), own);
                factor.solve_mut(&mut own);
                places.iter().zip(own.iter()).for_each(|(&i, &x)| rows[i].push((j, x)));
            }
        }
        rows
    }

    /// The diagonal entry of M⁻¹ at a coordinate.
    pub(crate) fn compliance(&self, k: usize) -> f64 {
        let (block, place) = self.homes[k];
        let Block { places, factor } = &self.blocks[block];
        let mut unit = DVector::zeros(places.len());
        unit[place] = 1.0;
        factor.solve(&unit)[place]
    }

    /// The factor L.
    pub fn l(&self) -> &DMatrix<f64> {
        self.lower.get_or_init(|| {
            let mut lower = DMatrix::zeros(self.homes.len(), self.homes.len());
            for Block { places, factor } in &self.blocks {
                for (j, &column) in places.iter().enumerate() {
                    (j..places.len()).for_each(|i| lower[(places[i], column)] = factor.l_dirty()[(i, j)]);
                }
            }
            lower
        })
    }
}
