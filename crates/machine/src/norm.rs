//! The norm bound of z' = A z, which determines the lengths of sub-steps (docs/assembly-law.md
//! (A6)).

use crate::kernel::SparseMatrix;

/// Lower bound of rates, 1/s, which keeps sub-steps finite: at most 50 minutes.
pub(crate) const LEAST_RATE: f64 = 1e-3;
/// Number of iterations to balance rows and columns. Each comes nearer to the least norm; any
/// number gives a bound.
const BALANCE_TURNS: usize = 12;

/// A bound of the norm of A, and 1/w for each coordinate.
pub(crate) fn norm(a: &SparseMatrix, one: usize) -> (f64, Vec<f64>) {
    let (rate, mut w) = weighted(a, one);
    w.iter_mut().for_each(|w| *w = 1.0 / *w);
    (rate.max(LEAST_RATE), w)
}

/// A bound of the norm of A.
pub fn rate_bound(a: &SparseMatrix, one: usize) -> f64 {
    weighted(a, one).0
}

/// Largest factor of the derivatives of sweeps: their angular frequency. Derivatives of other
/// polynomials have the factor 1.
pub(crate) fn swept(a: &SparseMatrix, one: usize) -> f64 {
    let next = |i: usize| a.entry(i, i + 1);
    (one..a.len().saturating_sub(1))
        .filter(|&i| a.entry(i + 1, i) == 0.0)
        .map(next)
        .filter(|x| *x != 1.0)
        .fold(0.0, f64::max)
}

/// A bound of the norm of A with its weights: the maximum norm max_i Σ_j |a_ij| w_j / w_i,
/// weighted by w. The weights of the machine's coordinates balance rows and columns; the weights
/// of signals are so small that signals add at most a quarter.
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
                // Nothing depends on the coordinate: a larger weight lowers the sum of its row.
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
    // The weight of a polynomial's derivative is at most the rate times the weight of the next
    // lower derivative; cosine and sine have equal weights.
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
