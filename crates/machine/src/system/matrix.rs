//! The matrix A of z' = A z, built from rows of accelerations (docs/assembly-law.md (A5)).

use super::System;
use crate::kernel::SparseMatrix;
use crate::mode::{SliderState, StopState};
use nalgebra::DMatrix;

impl System {
    /// The matrix A with these rows of accelerations, in states of the branches and of the stops.
    pub(crate) fn matrix(
        &self,
        acceleration: &DMatrix<f64>,
        states: (&[SliderState], &[StopState]),
    ) -> SparseMatrix {
        let size = self.signals.size;
        self.rows_of(|k, a| a.push_row((0..size).map(|j| (j, acceleration[(k, j)]))), states)
    }

    /// The matrix A; `push` adds the row of each coordinate's acceleration.
    fn rows_of(
        &self,
        push: impl Fn(usize, &mut SparseMatrix),
        (sliders, stops): (&[SliderState], &[StopState]),
    ) -> SparseMatrix {
        let n = self.coordinates;
        let mut a = SparseMatrix::default();
        (0..n).for_each(|k| a.push_row(std::iter::once((n + k, 1.0))));
        (0..n).for_each(|k| push(k, &mut a));
        self.push_first_order(&mut a, sliders, stops);
        self.signals.rates().iter().for_each(|row| a.push_row(row.terms().iter().copied()));
        a
    }

    /// The matrix A of the mode without pressed stops, slipping friction and held contacts. It
    /// leaves out the forces of stiff springs and of springs with sliders.
    pub(crate) fn base(&self) -> SparseMatrix {
        let forces = self.soft_forces();
        if self.is_diagonal {
            // The sum comes before the division, so that cancelling forces leave exact zeros.
            let row = |k: usize| forces.entries(k).iter().map(move |&(j, x)| (j, x / self.mass[(k, k)]));
            return self.rows_of(|k, a| a.push_row(row(k)), (&[], &[]));
        }
        let rows = self.inertia.solve_rows(forces);
        self.rows_of(|k, a| a.push_row(rows[k].iter().copied()), (&[], &[]))
    }
}
