//! Matrix exponentials by power series (docs/assembly-law.md (A6)).

use super::RADIUS;
use crate::kernel::{ABREAST, SparseMatrix};
use nalgebra::DMatrix;

/// Bound of the remainder of a series.
const REMAINDER: f64 = 1e-19;

/// exp(A u t) for several fractions u of a time t.
#[inline(always)]
pub(super) fn exponentials(a: &SparseMatrix, rate: f64, t: f64, parts: &[f64]) -> Vec<DMatrix<f64>> {
    let (size, orders) = (a.len(), series_orders(rate * t));
    let mut all = vec![DMatrix::zeros(size, size); parts.len()];
    let (mut term, mut next) = (Vec::new(), vec![[0.0; ABREAST]; size]);
    let (mut sums, mut powers) = (vec![Vec::new(); parts.len()], Vec::new());
    // Eight columns at a time.
    for first in (0..size).step_by(ABREAST) {
        unit_columns(size, first, 1.0, &mut term);
        sums.iter_mut().for_each(|sum| sum.clone_from(&term));
        powers.clear();
        powers.resize(parts.len(), 1.0);
        for k in 1..=orders {
            a.times_eight(&term, t / k as f64, &mut next);
            std::mem::swap(&mut term, &mut next);
            for ((sum, power), u) in sums.iter_mut().zip(&mut powers).zip(parts) {
                *power *= u;
                add(sum, *power, &term);
            }
        }
        all.iter_mut().zip(&sums).for_each(|(all, sum)| put_columns(sum, first, all));
    }
    all
}

/// ∫ (t - s) exp(A s) ds from 0 to t.
#[inline(always)]
pub(super) fn second_integral(a: &SparseMatrix, rate: f64, t: f64) -> DMatrix<f64> {
    let (size, orders) = (a.len(), series_orders(rate * t));
    let mut all = DMatrix::zeros(size, size);
    let (mut term, mut next, mut sum) = (Vec::new(), vec![[0.0; ABREAST]; size], Vec::new());
    for first in (0..size).step_by(ABREAST) {
        unit_columns(size, first, 0.5 * t * t, &mut term);
        sum.clone_from(&term);
        for k in 1..=orders {
            a.times_eight(&term, t / (k + 2) as f64, &mut next);
            std::mem::swap(&mut term, &mut next);
            add(&mut sum, 1.0, &term);
        }
        put_columns(&sum, first, &mut all);
    }
    all
}

/// ∫ exp(A s) ds over a sub-step, and exp(A h) - 1 at its end.
pub(super) fn integral_and_change(a: &SparseMatrix, length: f64) -> [DMatrix<f64>; 2] {
    let size = a.len();
    let mut all = [DMatrix::zeros(size, size), DMatrix::zeros(size, size)];
    let (mut term, mut next, mut sums) = (Vec::new(), vec![[0.0; ABREAST]; size], [Vec::new(), Vec::new()]);
    for first in (0..size).step_by(ABREAST) {
        unit_columns(size, first, length, &mut sums[0]);
        unit_columns(size, first, 0.0, &mut sums[1]);
        unit_columns(size, first, 1.0, &mut term);
        for k in 1..=series_orders(RADIUS) {
            a.times_eight(&term, length / k as f64, &mut next);
            std::mem::swap(&mut term, &mut next);
            let factors = [length / (k + 1) as f64, 1.0];
            for (sum, factor) in sums.iter_mut().zip(factors) {
                add(sum, factor, &term);
            }
        }
        all.iter_mut().zip(&sums).for_each(|(all, sum)| put_columns(sum, first, all));
    }
    all
}

/// Adds `factor` × `terms` as flat lists: by rows, the compiler would gather single numbers.
#[inline(always)]
pub(super) fn add(sums: &mut [[f64; ABREAST]], factor: f64, terms: &[[f64; ABREAST]]) {
    let terms = terms.as_flattened();
    sums.as_flattened_mut().iter_mut().zip(terms).for_each(|(sum, x)| *sum += factor * x);
}

/// Writes eight columns of a diagonal matrix with equal entries, beginning with column `first`.
#[inline(always)]
fn unit_columns(size: usize, first: usize, entry: f64, to: &mut Vec<[f64; ABREAST]>) {
    to.clear();
    to.resize(size, [0.0; ABREAST]);
    (0..ABREAST.min(size - first)).for_each(|i| to[first + i][i] = entry);
}

/// Writes columns into a matrix, beginning with column `first`.
#[inline(always)]
fn put_columns(columns: &[[f64; ABREAST]], first: usize, to: &mut DMatrix<f64>) {
    let size = columns.len();
    for (i, to) in to.as_mut_slice().chunks_exact_mut(size).skip(first).take(ABREAST).enumerate() {
        to.iter_mut().zip(columns).for_each(|(to, row)| *to = row[i]);
    }
}

/// Number of orders of a series of radius x whose remainder is below [`REMAINDER`].
pub(super) const fn series_orders(x: f64) -> usize {
    let (mut k, mut term) = (0, 1.0);
    // The remainder is at most the next term times 1/(1 - x/(k + 1)), which is at most twice the
    // next term for k >= 2x.
    while term > 0.5 * REMAINDER || (k as f64) < 2.0 * x {
        k += 1;
        term *= x / k as f64;
    }
    k
}
