//! The work of a power over many sub-steps at once: the sum of Gauss's rule over all sub-steps, as
//! one bilinear form in the initial state (docs/assembly-law.md (A29)).

use crate::flow::Rung;
use crate::kernel::{AtNodes, NODES};
use nalgebra::{DMatrix, DVectorView};

/// The integral of the product of two functionals over a length of time, as the scalar product of
/// two vectors L z and M z.
#[derive(Clone, Debug)]
pub(super) struct WorkIntegral {
    left: DMatrix<f64>,
    /// M; `None` if it equals L, as for the square of a functional.
    right: Option<DMatrix<f64>>,
}

impl WorkIntegral {
    /// The integral over one sub-step, from the values of two functionals at its nodes by
    /// coordinate; for a square, from the values of one functional.
    pub(super) fn new(left: &[AtNodes], right: Option<&[AtNodes]>, length: f64) -> Self {
        let matrix = |rows: &[AtNodes], weight: &dyn Fn(f64) -> f64| {
            DMatrix::from_fn(NODES.len(), rows.len(), |k, j| weight(length * NODES[k].1) * rows[j][k])
        };
        match right {
            Some(right) => Self { left: matrix(left, &|w| w), right: Some(matrix(right, &|_| 1.0)) },
            None => Self { left: matrix(left, &f64::sqrt), right: None },
        }
    }

    /// The integral over twice the rung's length. The factors L = QR turn L z · M z into R z · QᵀM
    /// z, with one row for each coordinate, and a square into |R z|². Orthogonal factors preserve
    /// small differences of rows, such as a dashpot's rate.
    pub(super) fn doubled(&self, rung: &Rung) -> Self {
        let both = |rows: &DMatrix<f64>| {
            let (count, later) = (rows.nrows(), rung.after(rows));
            DMatrix::from_fn(2 * count, rows.ncols(), |i, j| {
                if i < count { rows[(i, j)] } else { later[(i - count, j)] }
            })
        };
        let (left, right) = (both(&self.left), self.right.as_ref().map(both));
        if left.nrows() <= left.ncols() {
            return Self { left, right };
        }
        let size = left.ncols();
        let qr = left.qr();
        let right = right.map(|mut right| {
            qr.q_tr_mul(&mut right);
            right.rows(0, size).into_owned()
        });
        Self { left: qr.unpack_r(), right }
    }

    /// The work from a state.
    pub(super) fn of(&self, z: &[f64]) -> f64 {
        let z = DVectorView::from_slice(z, z.len());
        let left = &self.left * z;
        match &self.right {
            Some(right) => left.dot(&(right * z)),
            None => left.norm_squared(),
        }
    }

    /// Count of stored numbers.
    pub(super) fn numbers(&self) -> usize {
        self.left.len() + self.right.as_ref().map_or(0, DMatrix::len)
    }
}
