//! Matrix exponentials by power series, and the norm bound that determines their lengths
//! (docs/assembly-law.md (A6)).

use super::RADIUS;
use crate::kernel::{ABREAST, SparseMatrix};
use nalgebra::DMatrix;

/// Below this rate, 1/s, nothing of a machine happens in minutes; it keeps sub-steps finite.
pub(crate) const LEAST_RATE: f64 = 1e-3;
/// Turns of the balancing of rows and columns; each comes nearer to the least norm, and any number
/// of them gives a bound.
const BALANCE_TURNS: usize = 12;
/// Relative size of a series' remainder.
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

/// Adds `factor` × `terms`. As one list: by rows the compiler gathers single numbers of several.
#[inline(always)]
pub(super) fn add(sums: &mut [[f64; ABREAST]], factor: f64, terms: &[[f64; ABREAST]]) {
    let terms = terms.as_flattened();
    sums.as_flattened_mut().iter_mut().zip(terms).for_each(|(sum, x)| *sum += factor * x);
}

/// Eight columns, from the one at `first` on, of a diagonal matrix with equal entries.
#[inline(always)]
fn unit_columns(size: usize, first: usize, entry: f64, to: &mut Vec<[f64; ABREAST]>) {
    to.clear();
    to.resize(size, [0.0; ABREAST]);
    (0..ABREAST.min(size - first)).for_each(|i| to[first + i][i] = entry);
}

/// Writes columns to a matrix, from the one at `first` on.
#[inline(always)]
fn put_columns(columns: &[[f64; ABREAST]], first: usize, to: &mut DMatrix<f64>) {
    let size = columns.len();
    for (i, to) in to.as_mut_slice().chunks_exact_mut(size).skip(first).take(ABREAST).enumerate() {
        to.iter_mut().zip(columns).for_each(|(to, row)| *to = row[i]);
    }
}

/// Orders of a series of radius x whose remainder is below [`REMAINDER`].
pub(super) const fn series_orders(x: f64) -> usize {
    let (mut k, mut term) = (0, 1.0);
    // The remainder is at most the next term times 1/(1 - x/(k + 1)); from k = 2x on that is at
    // most twice the term.
    while term > 0.5 * REMAINDER || (k as f64) < 2.0 * x {
        k += 1;
        term *= x / k as f64;
    }
    k
}

/// A bound of the norm of A, and by coordinate 1/w.
pub(super) fn norm(a: &SparseMatrix, one: usize) -> (f64, Vec<f64>) {
    let (rate, mut w) = weighted(a, one);
    w.iter_mut().for_each(|w| *w = 1.0 / *w);
    (rate.max(LEAST_RATE), w)
}

/// A bound of the norm of A.
pub fn rate_bound(a: &SparseMatrix, one: usize) -> f64 {
    weighted(a, one).0
}

/// The largest factor of the derivatives of sweeps: their angular frequency. Those of other
/// polynomials have the factor 1.
pub(crate) fn swept(a: &SparseMatrix, one: usize) -> f64 {
    let next = |i: usize| a.entry(i, i + 1);
    (one..a.len().saturating_sub(1))
        .filter(|&i| a.entry(i + 1, i) == 0.0)
        .map(next)
        .filter(|x| *x != 1.0)
        .fold(0.0, f64::max)
}

/// A bound of the norm of A with its weights: the maximum norm weighted by w, max_i Σ_j |a_ij| w_j
/// / w_i. The weights of the machine's coordinates balance rows and columns; those of signals are
/// so small that they add at most a quarter.
fn weighted(a: &SparseMatrix, one: usize) -> (f64, Vec<f64>) {
    let size = a.len();
    let mut w = vec![1.0f64; size];
    let columns = a.transpose();
    let others = |i: usize| move |term: &&(usize, f64)| term.0 < one && term.0 != i;
    for _ in 0..BALANCE_TURNS {
        for i in 0..one {
            let row: f64 = a.row(i).iter().filter(others(i)).map(|&(j, x)| x.abs() * w[j]).sum();
            let column: f64 = columns.row(i).iter().filter(others(i)).map(|&(j, x)| x.abs() / w[j]).sum();
            // The weight that makes row/w and column·w equal, within the range of doubles.
            if row > 0.0 && column > 0.0 {
                w[i] = (row / column).sqrt().clamp(1e-100, 1e100);
            } else if row > 0.0 {
                // Nothing depends on the coordinate: its row may weigh as little as the least rate.
                w[i] = w[i].max(row / LEAST_RATE);
            }
        }
    }
    let row_sum = |w: &[f64], i: usize, to: usize| {
        a.row(i).iter().filter(|term| term.0 < to).map(|&(j, x)| x.abs() * w[j]).sum::<f64>() / w[i]
    };
    let own = (0..one).map(|i| row_sum(&w, i, one)).fold(LEAST_RATE, f64::max);
    // The entries between a cosine and its sine are ± the angular frequency.
    let omega = (one..size)
        .flat_map(|i| a.row(i).iter().map(move |&(j, x)| (i, j, x)))
        .filter(|&(i, j, _)| one <= j && j < i)
        .map(|(i, j, x)| x.abs().min(a.entry(j, i).abs()))
        .fold(0.0, f64::max);
    let rate = own.max(omega).max(swept(a, one));
    let share = 0.25 * rate / (size - one) as f64;
    let limit = |w: &[f64], j: usize| {
        let terms = columns.row(j).iter().filter(|term| term.0 < one);
        terms.map(|&(i, x)| share * w[i] / x.abs()).fold(f64::INFINITY, f64::min)
    };
    let mut signal = vec![f64::INFINITY; size];
    for (j, most) in signal.iter_mut().enumerate().skip(one) {
        *most = limit(&w, j);
    }
    // The weight of a derivative of a polynomial is at most the rate times that of the lower
    // derivative; cosine and sine have equal weights.
    for j in one..size {
        for &(i, x) in columns.row(j).iter().filter(|term| term.0 >= one && term.0 != j) {
            let mutual = a.entry(j, i) != 0.0;
            let most = if mutual { signal[i].min(signal[j]) } else { rate * signal[i] / x.abs() };
            if mutual {
                signal[i] = signal[i].min(most);
            }
            signal[j] = signal[j].min(most);
        }
    }
    for j in one..size {
        w[j] = if signal[j].is_finite() && signal[j] > 0.0 { signal[j] } else { 1.0 };
    }
    let rate = (0..size).map(|i| row_sum(&w, i, size)).fold(rate, f64::max);
    (rate, w)
}
