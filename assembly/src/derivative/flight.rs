//! Flights: derivatives of the state between two events (docs/assembly-law.md (A26)).

use super::mode::{InMode, VariedMode};
use crate::flow::{RADIUS, RUNGS};
use crate::kernel::SparseMatrix;
use nalgebra::{DMatrix, DVector};

/// Bound of the terms that a power series leaves out, relative to its largest.
const REMAINDER: f64 = 1e-18;
/// Orders beyond those of the state's own series: a term of a derivative is that of the state times
/// its order.
const MORE: usize = 2;
/// Shortest flight by matrices, as a part of the length of a series.
const PART: f64 = 0.125;
/// Most coordinates with which every flight from [`PART`] on is one by matrices: modes recur, and
/// each matrix is made once.
const SMALL: usize = 20;
/// With more coordinates, a flight is one by matrices where it has more lengths of a series than
/// the square of their number over this: making a matrix takes the cube.
const DEAR: f64 = 15.0;

/// The flow over 2^k parts of a length: exp(A t) - 1, and by parameter its derivative.
pub(super) struct Rung {
    flow: DMatrix<f64>,
    by: Vec<DMatrix<f64>>,
}

fn orders(radius: f64) -> usize {
    let (mut k, mut term) = (0, 1.0);
    while term > REMAINDER || (k as f64) < 2.0 * radius {
        k += 1;
        term *= radius / k as f64;
    }
    k + MORE
}

impl Rung {
    /// The flow over one part of the length of a series.
    fn first(mode: &VariedMode) -> Self {
        let size = mode.a.len();
        // Transposed, as `times_rows` has them.
        let (mut term, mut flow) = (DMatrix::identity(size, size), DMatrix::zeros(size, size));
        let mut terms = vec![DMatrix::zeros(size, size); mode.by.len()];
        let mut by = terms.clone();
        for k in 1..=orders(PART * RADIUS) {
            let factor = PART * mode.length / k as f64;
            for ((own, sum), InMode { a, .. }) in terms.iter_mut().zip(&mut by).zip(&mode.by) {
                let mut next = mode.a.times_rows(own, factor);
                for (i, row) in a {
                    let mut to = next.column_mut(*i);
                    row.terms().iter().for_each(|&(j, x)| to.axpy(factor * x, &term.column(j), 1.0));
                }
                *own = next;
                *sum += &*own;
            }
            term = mode.a.times_rows(&term, factor);
            flow += &term;
        }
        Self { flow: flow.transpose(), by: by.iter().map(DMatrix::transpose).collect() }
    }

    fn doubled(&self) -> Self {
        let by = |by: &DMatrix<f64>| 2.0 * by + &self.flow * by + by * &self.flow;
        Self { flow: 2.0 * &self.flow + &self.flow * &self.flow, by: self.by.iter().map(by).collect() }
    }

    fn carry(&self, z: &mut DVector<f64>, deltas: &mut [Option<DVector<f64>>]) {
        let mut change = DVector::zeros(z.len());
        for (delta, by) in deltas.iter_mut().zip(&self.by) {
            if let Some(delta) = delta {
                change.gemv(1.0, &self.flow, &*delta, 0.0);
                change.gemv(1.0, by, &*z, 1.0);
                *delta += &change;
            }
        }
        change.gemv(1.0, &self.flow, &*z, 0.0);
        *z += &change;
    }
}

impl VariedMode {
    /// Carries a state and its derivatives over a time without events.
    pub fn carry(&self, z: &mut DVector<f64>, deltas: &mut [Option<DVector<f64>>], mut time: f64) {
        let (size, parts) = (self.a.len(), time / (PART * self.length));
        if parts >= 1.0 && (size <= SMALL || PART * parts > (size as f64).powi(2) / DEAR) {
            let longest = (parts.log2() as usize).min(RUNGS - 1);
            for k in (0..=longest).rev() {
                let length = PART * self.length * 2f64.powi(k as i32);
                while time >= length {
                    self.rung(k).carry(z, deltas);
                    time -= length;
                }
            }
        }
        let parts = (time / self.length).ceil();
        for _ in 0..parts as u64 {
            self.series(z, deltas, time / parts);
        }
    }

    /// The flow over 2^`k` parts of a length.
    fn rung(&self, k: usize) -> &Rung {
        self.flights.at(k).get_or_init(|| match k.checked_sub(1) {
            Some(below) => self.rung(below).doubled(),
            None => Rung::first(self),
        })
    }

    /// One power series of the state and its derivatives.
    fn series(&self, z: &mut DVector<f64>, deltas: &mut [Option<DVector<f64>>], time: f64) {
        let size = z.len();
        let (mut term, mut next) = (z.as_slice().to_vec(), vec![0.0; size]);
        let mut own: Vec<Vec<f64>> =
            deltas.iter().map(|d| d.as_ref().map_or_else(Vec::new, |d| d.as_slice().to_vec())).collect();
        for k in 1..=orders(RADIUS * time / self.length) {
            let factor = time / k as f64;
            for ((own, delta), InMode { a, .. }) in own.iter_mut().zip(deltas.iter_mut()).zip(&self.by) {
                let Some(delta) = delta else { continue };
                times(&self.a, own, factor, &mut next);
                a.iter().for_each(|(i, row)| next[*i] += factor * row.dot(&term));
                std::mem::swap(own, &mut next);
                delta.iter_mut().zip(own.iter()).for_each(|(sum, x)| *sum += x);
            }
            times(&self.a, &term, factor, &mut next);
            std::mem::swap(&mut term, &mut next);
            z.iter_mut().zip(&term).for_each(|(sum, x)| *sum += x);
        }
    }
}

fn times(a: &SparseMatrix, from: &[f64], factor: f64, to: &mut [f64]) {
    a.rows_times_to(0, from, factor, to);
}
