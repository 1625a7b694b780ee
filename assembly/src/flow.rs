//! Exact flow of a mode: the transition over a sub-step, and for each watched functional samples, a bound between them and its
//! Taylor coefficients, all as rows that act on the augmented state (docs/assembly-law.md (A5), (A6)).

use crate::energy::NODES;
use crate::mode::{Linear, Watch};
use crate::system::Row;
use nalgebra::{DMatrix, DVector};

/// Taylor coefficients of a functional over a sub-step. With rate times length at most 2 the first one left out
/// is under 2²⁶/26! < 2e-19 of the largest coordinate.
pub const ORDERS: usize = 26;
/// Rate times the length of a sub-step.
const RADIUS: f64 = 2.0;
/// Samples of a functional in a sub-step, at the ends of as many equal intervals.
pub const SAMPLES: usize = 8;
/// Below this rate, 1/s, nothing of a machine happens in minutes; it keeps sub-steps finite.
const LEAST_RATE: f64 = 1e-3;
/// Turns of the balancing of rows and columns; each comes nearer to the least norm, and any number of them gives a bound.
const BALANCE_TURNS: usize = 12;
/// A series ends when what is left is under this part of the largest coordinate.
const REMAINDER: f64 = 1e-19;
/// Covers the rounding of a bound.
const BOUND_MARGIN: f64 = 1.0 + 1e-9;

/// A watched functional over a sub-step.
#[derive(Clone, Debug)]
pub struct WatchTable {
    /// What it tells.
    pub watch: Watch,
    /// The functional.
    pub row: Row,
    /// Its values at the interval ends, a column each.
    pub samples: DMatrix<f64>,
    /// |functional''| is at most the sum of this times the coordinates' sizes, throughout the sub-step.
    pub curvature: Row,
    /// Its Taylor coefficients about the start, in units of the sub-step, a column an order.
    pub coefficients: DMatrix<f64>,
    /// The sizes of the terms that the coefficients are sums of.
    pub terms: DMatrix<f64>,
}

/// The flow of a mode.
#[derive(Clone, Debug)]
pub struct Table {
    /// z' = A z.
    pub a: DMatrix<f64>,
    /// A bound of the norm of A in a weighted maximum norm, 1/s.
    pub rate: f64,
    /// Length of a sub-step, s.
    pub length: f64,
    /// z at the sub-step's end from z at its start.
    pub transition: DMatrix<f64>,
    /// z at the places of the sub-step at which the powers are found ([`NODES`]).
    pub nodes: Vec<DMatrix<f64>>,
    /// What is watched.
    pub watched: Vec<WatchTable>,
    /// The forces of the basis.
    pub lambda: Vec<Row>,
}

impl Table {
    /// The flow of a linear system whose coordinates from `one` on are signals.
    pub fn new(linear: Linear, one: usize) -> Self {
        let Linear { a, terms, lambda, watched } = linear;
        let rate = rate_bound(&a, one).max(LEAST_RATE);
        let length = RADIUS / rate;
        let places: Vec<f64> = [1.0, 1.0 / SAMPLES as f64].into_iter().chain(NODES.map(|n| n.0)).collect();
        let mut nodes = exponentials(&a, rate, length, &places);
        let (transition, interval) = (nodes.remove(0), nodes.remove(0));
        let step = length / SAMPLES as f64;
        let spread = spread(&a, rate, step);
        let watched = watched
            .into_iter()
            .map(|(watch, row)| watch_table(watch, row, (&a, &terms), length, &interval, &spread))
            .collect();
        Self { a, rate, length, transition, nodes, watched, lambda }
    }

    /// The states within a time `dt`, at most a sub-step.
    pub fn taylor(&self, z: &DVector<f64>, dt: f64) -> Taylor {
        let orders = series_orders(self.rate * dt);
        let mut terms = Vec::with_capacity(orders + 1);
        terms.push(z.clone());
        for k in 1..=orders {
            let mut next = DVector::zeros(z.len());
            next.gemv(1.0, &self.a, &terms[k - 1], 0.0);
            next *= dt / k as f64;
            terms.push(next);
        }
        Taylor { terms }
    }

    /// Numbers that the table holds.
    pub fn numbers(&self) -> usize {
        let watched: usize = self.watched.iter().map(|w| 2 * w.coefficients.len() + w.samples.len()).sum();
        (self.nodes.len() + 2) * self.a.len() + watched
    }
}

/// The states within a span as a power series in its part that has passed.
#[derive(Debug)]
pub struct Taylor {
    terms: Vec<DVector<f64>>,
}

impl Taylor {
    /// The state at a part of the span from 0 to 1.
    pub fn at(&self, u: f64) -> DVector<f64> {
        let mut sum = DVector::zeros(self.terms[0].len());
        // Ascending powers in one pass: the small ones are of no more than the rounding of the first.
        let mut power = 1.0;
        for term in &self.terms {
            sum.axpy(power, term, 1.0);
            power *= u;
        }
        sum
    }
}

fn watch_table(
    watch: Watch,
    row: Row,
    (a, terms_of_a): (&DMatrix<f64>, &DMatrix<f64>),
    length: f64,
    interval: &DMatrix<f64>,
    spread: &DMatrix<f64>,
) -> WatchTable {
    let size = row.len();
    let mut coefficients = DMatrix::zeros(size, ORDERS);
    let mut terms = DMatrix::zeros(size, ORDERS);
    let (mut next, mut next_terms) = (row.clone(), row.abs());
    for k in 0..ORDERS {
        coefficients.set_column(k, &next);
        terms.set_column(k, &next_terms);
        let factor = length / (k + 1) as f64;
        next = a.tr_mul(&next) * factor;
        next_terms = terms_of_a.tr_mul(&next_terms) * factor;
    }
    let mut samples = DMatrix::zeros(size, SAMPLES);
    let mut sample = row.clone();
    let second = a.tr_mul(&a.tr_mul(&row));
    // The second derivative at each interval's start, then its bound within: |r exp(At)| <= |r| exp(|A| t) entry by entry.
    let mut peak = second.abs();
    for k in 0..SAMPLES {
        sample = interval.tr_mul(&sample);
        samples.set_column(k, &sample);
        if k + 1 < SAMPLES {
            let there = a.tr_mul(&a.tr_mul(&sample)).abs();
            peak = peak.zip_map(&there, f64::max);
        }
    }
    let curvature = spread.tr_mul(&peak) * BOUND_MARGIN;
    WatchTable { watch, row, samples, curvature, coefficients, terms }
}

/// exp(|A| t) entry by entry, which bounds the growth of a row over a time t.
fn spread(a: &DMatrix<f64>, rate: f64, t: f64) -> DMatrix<f64> {
    exponentials(&a.abs(), rate, t, &[1.0]).remove(0)
}

/// exp(A u t) at several parts u of a time.
fn exponentials(a: &DMatrix<f64>, rate: f64, t: f64, parts: &[f64]) -> Vec<DMatrix<f64>> {
    let mut term = DMatrix::identity(a.nrows(), a.nrows());
    let mut sums = vec![term.clone(); parts.len()];
    let mut powers = vec![1.0; parts.len()];
    for k in 1..=series_orders(rate * t) {
        term = a * term * (t / k as f64);
        for ((sum, power), u) in sums.iter_mut().zip(&mut powers).zip(parts) {
            *power *= u;
            sum.zip_apply(&term, |s, x| *s += *power * x);
        }
    }
    sums
}

/// Orders of a series of radius x, so that what is left out is under [`REMAINDER`].
fn series_orders(x: f64) -> usize {
    let (mut k, mut term) = (0, 1.0);
    // The rest is at most the next term times 1/(1 - x/(k + 1)); from k = 2x on that is at most twice the term.
    while term > 0.5 * REMAINDER || (k as f64) < 2.0 * x {
        k += 1;
        term *= x / k as f64;
    }
    k
}

/// A bound of the norm of A: the maximum norm weighted by w, max_i Σ_j |a_ij| w_j / w_i. The weights of the machine's
/// coordinates balance rows and columns; those of signals are so small that they add at most a quarter.
pub fn rate_bound(a: &DMatrix<f64>, one: usize) -> f64 {
    let size = a.nrows();
    let mut w = vec![1.0f64; size];
    for _ in 0..BALANCE_TURNS {
        for i in 0..one {
            let row: f64 = (0..one).filter(|&j| j != i).map(|j| a[(i, j)].abs() * w[j]).sum();
            let column: f64 = (0..one).filter(|&j| j != i).map(|j| a[(j, i)].abs() / w[j]).sum();
            // The weight that makes row/w and column·w equal, kept within what doubles can carry.
            if row > 0.0 && column > 0.0 {
                w[i] = (row / column).sqrt().clamp(1e-100, 1e100);
            } else if row > 0.0 {
                w[i] = w[i].max(row / LEAST_RATE);
            }
        }
    }
    // A coordinate that acts on nothing is as large as it needs to be, one that nothing acts on as small.
    let row_sum =
        |w: &[f64], i: usize, to: usize| (0..to).map(|j| a[(i, j)].abs() * w[j]).sum::<f64>() / w[i];
    let own = (0..one).map(|i| row_sum(&w, i, one)).fold(LEAST_RATE, f64::max);
    let signals = (one..size).flat_map(|i| (one..i).map(move |j| (i, j)));
    // Frequencies stand between a cosine and its sine, in both directions.
    let omega = signals.map(|(i, j)| a[(i, j)].abs().min(a[(j, i)].abs())).fold(0.0, f64::max);
    let rate = own.max(omega);
    let share = 0.25 * rate / (size - one) as f64;
    let limit = |w: &[f64], j: usize| {
        (0..one)
            .filter(|&i| a[(i, j)] != 0.0)
            .map(|i| share * w[i] / a[(i, j)].abs())
            .fold(f64::INFINITY, f64::min)
    };
    let mut signal = vec![f64::INFINITY; size];
    for (j, most) in signal.iter_mut().enumerate().skip(one) {
        *most = limit(&w, j);
    }
    // What feeds another signal is no larger than the rate times that one: derivatives of pieces; cosine and sine are equal.
    for j in one..size {
        for i in one..size {
            if i != j && a[(i, j)] != 0.0 {
                let mutual = a[(j, i)] != 0.0;
                let most = if mutual { signal[i].min(signal[j]) } else { rate * signal[i] / a[(i, j)].abs() };
                if mutual {
                    signal[i] = signal[i].min(most);
                }
                signal[j] = signal[j].min(most);
            }
        }
    }
    for j in one..size {
        w[j] = if signal[j].is_finite() && signal[j] > 0.0 { signal[j] } else { 1.0 };
    }
    (0..size).map(|i| row_sum(&w, i, size)).fold(rate, f64::max)
}
