//! Exact flow of a mode: the transition over a sub-step and its intervals, and for each watched functional samples, a bound
//! between them and its Taylor coefficients, all as columns that act on the augmented state (docs/assembly-law.md (A5), (A6)).

use crate::kernel::{Blocks, Sparse, SparseMatrix, combine};
use crate::law::ZERO;
use crate::mode::{Linear, Watch};
use crate::system::Row;
use nalgebra::DMatrix;

/// Derivatives of a functional that are looked at where a mode begins. With rate times length at most 2 the first Taylor
/// coefficient left out is under 2²⁶/26! < 2e-19 of the largest coordinate.
pub const ORDERS: usize = 26;
/// Rate times the length of a sub-step.
const RADIUS: f64 = 2.0;
/// Intervals of a sub-step, at whose ends functionals are sampled.
pub const INTERVALS: usize = 8;
/// Taylor coefficients of a functional over an interval: with a radius of a quarter the first one left out is under
/// 0.25¹⁴/14! < 5e-20 of the largest coordinate.
pub const LOCAL: usize = 14;
/// Taylor coefficients of the velocities within an interval, behind the constant ones: the first one left out is under
/// 0.25¹³/13! < 3e-18 of the largest coordinate.
const WITHIN: usize = 12;
/// Up to this many coordinates the transitions to the interval ends are kept as dense matrices, and the velocities' coefficients; beyond, a power
/// series with the entries that are not zero costs no more.
const DENSE: usize = 32;
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
    /// Its terms.
    pub terms: Sparse,
    /// Its time derivative.
    pub slope: Sparse,
    /// Its second time derivative.
    pub bow: Sparse,
    /// The sizes of the terms that its time derivative is the sum of.
    pub slope_sizes: Sparse,
    /// |functional''| is at most the sum of this times the coordinates' sizes, throughout the sub-step.
    pub curvature: Vec<f64>,
    /// Its values at the interval ends, by coordinate.
    samples: Vec<[f64; INTERVALS]>,
    /// Its Taylor coefficients about a point, in units of an interval, by coordinate.
    local: Vec<[f64; LOCAL]>,
}

impl WatchTable {
    /// Its values at the interval ends.
    #[inline(always)]
    pub fn samples(&self, z: &[f64]) -> [f64; INTERVALS] {
        combine(&self.samples, z)
    }

    /// Its Taylor coefficients about a point, in units of an interval.
    #[inline(always)]
    pub fn local(&self, z: &[f64]) -> [f64; LOCAL] {
        combine(&self.local, z)
    }

    /// A bound of its second derivative throughout the sub-step.
    #[inline(always)]
    pub fn bend(&self, sizes: &[f64]) -> f64 {
        self.curvature.iter().zip(sizes).map(|(c, s)| c * s).sum()
    }
}

/// The flow of a mode.
#[derive(Debug)]
pub struct Table {
    /// A of z' = A z, by its entries.
    pub a: SparseMatrix,
    /// The sizes of the terms of A's entries.
    sizes: SparseMatrix,
    /// A bound of the norm of A in a weighted maximum norm, 1/s.
    pub rate: f64,
    /// Length of a sub-step, s.
    pub length: f64,
    /// z at the interval ends from z at the sub-step's start, where these matrices are kept.
    transitions: Vec<Blocks>,
    /// The Taylor coefficients of the velocities from order 1 on, in units of an interval, where these matrices are kept: one velocity after
    /// another, each by coordinate.
    velocities: Vec<[f64; WITHIN]>,
    /// Orders of a power series from the sub-step's start into each interval.
    orders: [usize; INTERVALS],
    /// What is watched.
    pub watched: Vec<WatchTable>,
    /// The forces of the basis.
    pub lambda: Vec<Row>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W of the basis.
    pub triangle: DMatrix<f64>,
}

impl Table {
    /// The flow of a linear system whose coordinates from `one` on are signals.
    pub fn new(linear: Linear, one: usize) -> Self {
        let Linear { a, terms, lambda, triangle, watched } = linear;
        let rate = rate_bound(&a, one).max(LEAST_RATE);
        let length = RADIUS / rate;
        let (a, sizes) = (SparseMatrix::of(&a), SparseMatrix::of(&terms));
        let step = length / INTERVALS as f64;
        let kept = if a.len() <= DENSE { INTERVALS } else { 0 };
        let ends: Vec<f64> = (1..=kept).map(|i| i as f64 / INTERVALS as f64).collect();
        let transitions = exponentials(&a, rate, length, &ends).iter().map(Blocks::of).collect();
        let interval = exponentials(&a, rate, step, &[1.0]).remove(0);
        let spread = exponentials(&a.abs(), rate, step, &[1.0]).remove(0);
        let watched = watched
            .into_iter()
            .map(|(watch, row)| watch_table(watch, row, (&a, &sizes), step, &interval, &spread))
            .collect();
        let orders = std::array::from_fn(|i| series_orders(rate * step * (i + 1) as f64));
        let kept = if a.len() <= DENSE { one / 2..one } else { 0..0 };
        let velocities = kept.flat_map(|j| taylor(&a, a.row_of(j).as_slice(), step, step));
        let velocities = velocities.map(|c: [f64; WITHIN]| std::array::from_fn(|k| c[k] / (k + 1) as f64));
        let velocities = velocities.collect();
        Self { velocities, a, sizes, rate, length, transitions, orders, watched, lambda, triangle }
    }

    /// Length of an interval, s.
    pub fn interval(&self) -> f64 {
        self.length / INTERVALS as f64
    }

    /// Orders of a power series from the sub-step's start into interval `last`.
    pub fn orders_to(&self, last: usize) -> usize {
        self.orders[last]
    }

    /// The state at a time within an interval from that at its start. Signals, whose values at a time are known, may stay as in `to`
    /// unless `all` are asked for.
    #[inline(always)]
    pub fn within(&self, z: &[f64], dt: f64, all: bool, series: &mut Series, to: &mut [f64]) {
        if all || self.velocities.is_empty() {
            series.expand(self, z, dt, self.orders[0]);
            return series.at_end(to);
        }
        let u = dt / self.interval();
        let mut powers = [u; WITHIN];
        for k in 1..WITHIN {
            powers[k] = powers[(k - 1) / 2] * powers[k / 2];
        }
        let integrals: [f64; WITHIN] = std::array::from_fn(|k| powers[k] / (k + 2) as f64);
        let machine = self.velocities.len() / z.len();
        let (q, v) = z.split_at(machine);
        let (to_q, to_v) = to.split_at_mut(machine);
        for (j, columns) in self.velocities.chunks_exact(z.len()).enumerate() {
            let c = combine(columns, z);
            // The larger terms last.
            to_q[j] = q[j] + (v[j] + product(&c, &integrals)) * dt;
            to_v[j] = v[j] + product(&c, &powers);
        }
    }

    /// The state at the end of interval `i` from that at the sub-step's start.
    #[inline(always)]
    pub fn at_interval_end(&self, i: usize, z: &[f64], series: &mut Series, to: &mut [f64]) {
        match self.transitions.get(i) {
            Some(matrix) => matrix.times(z, to),
            None => {
                series.expand(self, z, (i + 1) as f64 * self.interval(), self.orders_to(i));
                series.at_end(to);
            }
        }
    }

    /// The state at the start of interval `i` from that at the sub-step's start.
    #[inline(always)]
    pub fn at_interval_start(&self, i: usize, z: &[f64], series: &mut Series, to: &mut [f64]) {
        match i.checked_sub(1) {
            Some(last) => self.at_interval_end(last, z, series, to),
            None => to.copy_from_slice(z),
        }
    }

    /// Whether matrices and coefficients are kept; else a state's series is found by the entries that are not zero.
    pub fn is_dense(&self) -> bool {
        !self.transitions.is_empty()
    }

    /// The order of the first derivative of a functional that is not zero, and its value; those that are positive count as zero up to
    /// `doubt` times what is zero else. None where all are. `rows` is memory.
    pub fn departure(
        &self,
        w: &WatchTable,
        z: &[f64],
        sizes: &[f64],
        doubt: f64,
        rows: &mut Rows,
    ) -> Option<(usize, f64)> {
        let leaves = |value: f64, size: f64| value < -ZERO * size || value > doubt * ZERO * size;
        let value = w.terms.dot(z);
        if leaves(value, w.terms.size(sizes)) {
            return Some((0, value));
        }
        let slope = w.slope.dot(z);
        if leaves(slope, w.slope_sizes.size(sizes)) {
            return Some((1, slope));
        }
        let size = w.row.len();
        let Rows { row, next_row, terms, next_terms } = rows;
        [&mut *row, next_row, terms, next_terms].into_iter().for_each(|memory| memory.resize(size, 0.0));
        row.copy_from_slice(w.row.as_slice());
        terms.iter_mut().zip(w.row.iter()).for_each(|(term, x)| *term = x.abs());
        for k in 1..ORDERS {
            // In units of the sub-step.
            let factor = self.length / k as f64;
            self.a.after_row(row, factor, next_row);
            self.sizes.after_row(terms, factor, next_terms);
            std::mem::swap(row, next_row);
            std::mem::swap(terms, next_terms);
            let value = dot(row, z);
            if leaves(value, dot(terms, sizes)) {
                return Some((k, value));
            }
        }
        None
    }

    /// Numbers that the table holds.
    pub fn numbers(&self) -> usize {
        let size = self.a.len();
        self.transitions.len() * size * size
            + 2 * (self.a.entries() + self.sizes.entries())
            + self.velocities.len() * WITHIN
            + self.watched.len() * size * (INTERVALS + LOCAL + 2)
    }
}

/// Memory for a functional's derivative and for the sizes of its terms.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    row: Vec<f64>,
    next_row: Vec<f64>,
    terms: Vec<f64>,
    next_terms: Vec<f64>,
}

/// The sum of the products of two series' terms, added up in pairs.
#[inline(always)]
fn product(a: &[f64; WITHIN], b: &[f64; WITHIN]) -> f64 {
    let mut sums = [0.0; WITHIN / 3];
    for (a, b) in a.chunks_exact(WITHIN / 3).zip(b.chunks_exact(WITHIN / 3)).rev() {
        sums.iter_mut().zip(a).zip(b).for_each(|((sum, a), b)| *sum += a * b);
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3])
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The states within a span as a power series in the part of it that has passed; its memory is used again.
#[derive(Clone, Debug, Default)]
pub struct Series {
    terms: Vec<f64>,
    size: usize,
}

impl Series {
    /// The states within a time `dt` from `z`, by so many orders.
    #[inline(always)]
    pub fn expand(&mut self, table: &Table, z: &[f64], dt: f64, orders: usize) {
        let size = z.len();
        self.size = size;
        self.terms.resize((orders + 1) * size, 0.0);
        self.terms[..size].copy_from_slice(z);
        for k in 1..=orders {
            let (before, after) = self.terms.split_at_mut(k * size);
            table.a.times(&before[(k - 1) * size..], dt / k as f64, &mut after[..size]);
        }
    }

    /// The state at the end of the span.
    #[inline(always)]
    pub fn at_end(&self, to: &mut [f64]) {
        to.fill(0.0);
        for term in self.terms.chunks_exact(self.size) {
            to.iter_mut().zip(term).for_each(|(sum, x)| *sum += x);
        }
    }

    /// The coefficients, from order 0 on, one after another.
    pub fn terms(&self) -> &[f64] {
        &self.terms
    }
}

/// The Taylor coefficients of a functional times `factor`, in units of a time `step`, by coordinate.
pub(crate) fn taylor<const K: usize>(a: &SparseMatrix, row: &[f64], factor: f64, step: f64) -> Vec<[f64; K]> {
    let mut columns = vec![[0.0; K]; row.len()];
    let (mut row, mut next): (Vec<f64>, _) = (row.iter().map(|x| factor * x).collect(), vec![0.0; row.len()]);
    for k in 0..K {
        columns.iter_mut().zip(&row).for_each(|(column, x)| column[k] = *x);
        a.after_row(&row, step / (k + 1) as f64, &mut next);
        std::mem::swap(&mut row, &mut next);
    }
    columns
}

fn watch_table(
    watch: Watch,
    row: Row,
    (a, sizes): (&SparseMatrix, &SparseMatrix),
    step: f64,
    interval: &DMatrix<f64>,
    spread: &DMatrix<f64>,
) -> WatchTable {
    let size = row.len();
    let after = |row: &Row, factor: f64| {
        let mut next = Row::zeros(size);
        a.after_row(row.as_slice(), factor, next.as_mut_slice());
        next
    };
    let local = taylor(a, row.as_slice(), 1.0, step);
    let mut samples = vec![[0.0; INTERVALS]; size];
    let mut sample = row.clone();
    // The second derivative at each interval's start, then its bound within: |r exp(At)| <= |r| exp(|A| t) entry by entry.
    let mut peak = Row::zeros(size);
    for k in 0..INTERVALS {
        peak = peak.zip_map(&after(&after(&sample, 1.0), 1.0).abs(), f64::max);
        sample = interval.tr_mul(&sample);
        samples.iter_mut().zip(sample.iter()).for_each(|(column, x)| column[k] = *x);
    }
    let curvature = (spread.tr_mul(&peak) * BOUND_MARGIN).as_slice().to_vec();
    let mut slope_sizes = vec![0.0; size];
    sizes.after_row(row.abs().as_slice(), 1.0, &mut slope_sizes);
    let first = after(&row, 1.0);
    WatchTable {
        watch,
        terms: Sparse::of(row.as_slice()),
        slope: Sparse::of(first.as_slice()),
        bow: Sparse::of(after(&first, 1.0).as_slice()),
        slope_sizes: Sparse::of(&slope_sizes),
        row,
        curvature,
        samples,
        local,
    }
}

/// exp(A u t) at several parts u of a time.
fn exponentials(a: &SparseMatrix, rate: f64, t: f64, parts: &[f64]) -> Vec<DMatrix<f64>> {
    // Transposed until the end.
    let mut term = DMatrix::identity(a.len(), a.len());
    let mut sums = vec![term.clone(); parts.len()];
    let mut powers = vec![1.0; parts.len()];
    for k in 1..=series_orders(rate * t) {
        term = a.times_rows(&term, t / k as f64);
        for ((sum, power), u) in sums.iter_mut().zip(&mut powers).zip(parts) {
            *power *= u;
            sum.zip_apply(&term, |s, x| *s += *power * x);
        }
    }
    sums.iter().map(DMatrix::transpose).collect()
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
