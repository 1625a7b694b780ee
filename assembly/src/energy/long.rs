//! The work of a power over many sub-steps at once: the sum of Gauss's rule over all of them, as
//! one bilinear form in the initial state (docs/assembly-law.md (A24)).

use super::{AtNodes, NODES};
use crate::flow::Rung;
use nalgebra::DMatrix;

/// The integral of the product of two functionals over a length of time, as the scalar product of
/// two vectors L z and M z.
#[derive(Clone, Debug)]
pub(super) struct WorkIntegral([DMatrix<f64>; 2]);

impl WorkIntegral {
    /// The integral over one sub-step of a length, from two functionals' values at its nodes by
    /// coordinate.
    pub(super) fn new(rows: [&[AtNodes]; 2], length: f64) -> Self {
        let matrix = |rows: &[AtNodes], weight: &dyn Fn(usize) -> f64| {
            DMatrix::from_fn(NODES.len(), rows.len(), |k, j| weight(k) * rows[j][k])
        };
        Self([matrix(rows[0], &|k| length * NODES[k].1), matrix(rows[1], &|_| 1.0)])
    }

    /// The integral over twice the rung's length. With L = QR, L z · M z equals R z · QᵀM z, which
    /// has as many rows as coordinates. Orthogonal factors preserve small differences of rows, such
    /// as a dashpot's rate.
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

    /// The work from a state.
    pub(super) fn of(&self, z: &[f64]) -> f64 {
        let [left, right] = &self.0;
        let row = |rows: &DMatrix<f64>, i: usize| -> f64 {
            z.iter().enumerate().map(|(j, z)| rows[(i, j)] * z).sum()
        };
        (0..left.nrows()).map(|i| row(left, i) * row(right, i)).sum()
    }

    /// Count of stored numbers.
    pub(super) fn numbers(&self) -> usize {
        2 * self.0[0].len()
    }
}
