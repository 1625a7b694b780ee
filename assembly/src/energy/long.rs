//! The work of a power over a long sub-step, which is far beyond the reach of a quadrature's nodes:
//! the sums over the nodes of all sub-steps in it, put together (docs/assembly-law.md (A24)).

use super::{AtNodes, NODES};
use crate::flow::Rung;
use nalgebra::DMatrix;

/// The integral of the product of two functionals: the scalar product of two vectors that are
/// linear in the state.
#[derive(Clone, Debug)]
pub(super) struct WorkIntegral([DMatrix<f64>; 2]);

impl WorkIntegral {
    /// Over a length, from two functionals' values at its nodes, by coordinate.
    pub(super) fn new(rows: [&[AtNodes]; 2], length: f64) -> Self {
        let matrix = |rows: &[AtNodes], weight: &dyn Fn(usize) -> f64| {
            DMatrix::from_fn(NODES.len(), rows.len(), |k, j| weight(k) * rows[j][k])
        };
        Self([matrix(rows[0], &|k| length * NODES[k].1), matrix(rows[1], &|_| 1.0)])
    }

    /// Over a rung and then over as much again. Of L = QR and L z · M z only R and QᵀM are kept: as
    /// many rows as there are coordinates. Differences of rows, as of the rate of a dashpot, keep
    /// their digits in them.
    pub(super) fn doubled(&self, rung: &Rung) -> Self {
        let [left, mut right] = self.0.each_ref().map(|rows| {
            let (count, later) = (rows.nrows(), rung.after(rows));
            DMatrix::from_fn(2 * count, rows.ncols(), |i, j| {
                if i < count { rows[(i, j)] } else { later[(i - count, j)] }
            })
        });
        if left.nrows() <= left.ncols() {
            return Self([left, right]);
        }
        let size = left.ncols();
        let qr = left.qr();
        qr.q_tr_mul(&mut right);
        Self([qr.unpack_r(), right.rows(0, size).into_owned()])
    }

    /// Its value from a state.
    pub(super) fn of(&self, z: &[f64]) -> f64 {
        let [left, right] = &self.0;
        let row = |rows: &DMatrix<f64>, i: usize| -> f64 {
            z.iter().enumerate().map(|(j, z)| rows[(i, j)] * z).sum()
        };
        (0..left.nrows()).map(|i| row(left, i) * row(right, i)).sum()
    }

    /// Numbers that it holds.
    pub(super) fn numbers(&self) -> usize {
        2 * self.0[0].len()
    }
}
