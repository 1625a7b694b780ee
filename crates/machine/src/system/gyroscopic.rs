//! Gyroscopic forces among the coordinates of a body with matrices (docs/assembly-law.md (A51)).

use super::System;
use crate::description::Description;
use crate::functional::StateRow;
use nalgebra::DMatrix;

/// A skew-symmetric matrix on consecutive normal coordinates.
#[derive(Clone, Debug)]
pub struct Gyroscopic {
    /// Index of the first coordinate's body.
    pub first: usize,
    /// G in normal coordinates.
    pub matrix: DMatrix<f64>,
}

impl Gyroscopic {
    /// The gyroscopic matrices of a machine.
    pub(super) fn of(d: &Description) -> Vec<Self> {
        let own = d.matrices.iter().filter_map(|own| Some((own.first, own.gyroscopic.clone()?)));
        own.map(|(first, matrix)| Self { first, matrix }).collect()
    }

    /// The force (G v) against each of the bodies; `rate` returns a body's rate.
    pub(crate) fn forces<'r>(
        &self,
        size: usize,
        rate: impl Fn(usize) -> &'r StateRow,
    ) -> Vec<(usize, StateRow)> {
        let force = |i: usize| {
            let mut force = StateRow::zeros(size);
            for (j, factor) in self.matrix.row(i).iter().enumerate().filter(|(_, factor)| **factor != 0.0) {
                force.axpy(*factor, rate(self.first + j), 1.0);
            }
            (self.first + i, force)
        };
        (0..self.matrix.nrows()).map(force).collect()
    }
}

impl System {
    /// The gyroscopic force against each body, by index.
    pub(crate) fn gyroscopic_forces(&self) -> impl Iterator<Item = (usize, StateRow)> {
        let of = |own: &Gyroscopic| own.forces(self.signals.size, |body| &self.bodies[body].v);
        self.gyroscopic.iter().flat_map(of)
    }
}
