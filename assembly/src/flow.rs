//! Exact flow of a mode: the transition over a sub-step and its intervals, and for each watched functional samples, a bound
//! between them and its Taylor coefficients, all as columns that act on the augmented state (docs/assembly-law.md (A5), (A6)).

mod exponential;
mod increment;
mod ladder;
mod watched;

pub use exponential::rate_bound;
pub use ladder::{Ladder, RUNGS, Rung};
pub(crate) use watched::taylor;
pub use watched::{Group, Head, WatchTable, head_of};

use crate::kernel::{Blocks, SparseMatrix, combine};
use crate::law::ZERO;
use crate::mode::{Buffers, Linear};
use crate::system::Row;
use exponential::{LEAST_RATE, exponentials, series_orders};
use increment::Increment;
use nalgebra::DMatrix;
use watched::{Heads, watch_table};

/// Derivatives of a functional that are looked at where a mode begins. With rate times length at most 2 the first Taylor
/// coefficient left out is under 2²⁶/26! < 2e-19 of the largest coordinate.
pub const ORDERS: usize = 26;
/// Rate times the length of a sub-step.
const RADIUS: f64 = 2.0;
/// A buffer is stiff where it makes the rate so many times that of the mode without it.
const STIFF: f64 = 30.0;
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

/// The flow of a mode.
#[derive(Debug)]
pub struct Table {
    /// A of z' = A z, by its entries.
    pub a: SparseMatrix,
    /// The sizes of the terms of A's entries.
    sizes: SparseMatrix,
    /// The rows of the velocities of it.
    forces: Blocks,
    /// A bound of the norm of A in a weighted maximum norm, 1/s.
    pub rate: f64,
    /// Length of a sub-step, s.
    pub length: f64,
    /// z at the interval ends from z at the sub-step's start, where these matrices are kept.
    transitions: Vec<Blocks>,
    /// The Taylor coefficients of the velocities from order 1 on, in units of an interval, where these matrices are kept: one velocity after
    /// another, each by coordinate.
    velocities: Vec<[f64; WITHIN]>,
    /// What a sub-step adds where a stiff buffer is pressed.
    increment: Option<Increment>,
    /// Longer sub-steps, each twice the one before, made when they are first needed.
    ladder: Ladder<Rung>,
    /// Orders of a power series from the sub-step's start into each interval.
    orders: [usize; INTERVALS],
    /// What is watched.
    pub watched: Vec<WatchTable>,
    heads: Vec<Heads>,
    /// The forces of the basis.
    pub lambda: Vec<Row>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W of the basis.
    pub triangle: DMatrix<f64>,
}

impl Table {
    /// The flow of a linear system whose coordinates from `one` on are signals.
    pub fn new(linear: Linear, one: usize) -> Self {
        let Linear { a, terms, lambda, triangle, watched, buffers } = linear;
        let rate = rate_bound(&a, one).max(LEAST_RATE);
        let length = RADIUS / rate;
        let forces = Blocks::of(&terms.rows(one / 2, one - one / 2).into_owned());
        let (a, sizes) = (SparseMatrix::of(&a), SparseMatrix::of(&terms));
        let step = length / INTERVALS as f64;
        let kept = if a.len() <= DENSE { INTERVALS } else { 0 };
        let ends: Vec<f64> = (1..=kept).map(|i| i as f64 / INTERVALS as f64).collect();
        let stiff = |buffers: &Buffers| kept > 0 && rate > STIFF * rate_bound(&buffers.rest, one);
        let increment = buffers.filter(stiff).map(|buffers| Increment::new(&a, buffers, length));
        let transitions = exponentials(&a, rate, length, &ends).iter().map(Blocks::of).collect();
        let orders: [usize; INTERVALS] = std::array::from_fn(|i| series_orders(rate * step * (i + 1) as f64));
        let abs = a.abs();
        let watched: Vec<WatchTable> = watched
            .into_iter()
            .map(|(watch, row)| watch_table(watch, row, [&a, &abs, &sizes], (step, increment.is_some())))
            .collect();
        let heads = Heads::of(&watched, a.len());
        let kept = if a.len() <= DENSE { one / 2..one } else { 0..0 };
        let velocities = kept.flat_map(|j| taylor(&a, a.row_of(j).as_slice(), step, step));
        let velocities = velocities.map(|c: [f64; WITHIN]| std::array::from_fn(|k| c[k] / (k + 1) as f64));
        let velocities = velocities.collect();
        Self {
            velocities,
            a,
            sizes,
            forces,
            rate,
            length,
            transitions,
            increment,
            ladder: Ladder::default(),
            orders,
            watched,
            heads,
            lambda,
            triangle,
        }
    }

    /// The flow over 2^`k` sub-steps.
    pub fn rung(&self, k: usize) -> &Rung {
        self.ladder.at(k).get_or_init(|| match k.checked_sub(1) {
            Some(below) => self.rung(below).doubled(self),
            None => Rung::first(self),
        })
    }

    /// Length of 2^`k` sub-steps, s.
    pub fn long_length(&self, k: usize) -> f64 {
        self.length * 2f64.powi(k as i32)
    }

    /// z' at a state.
    pub fn rates(&self, z: &[f64], to: &mut [f64]) {
        match &self.increment {
            Some(increment) => increment.rates(z, to),
            None => self.a.times(z, 1.0, to),
        }
    }

    /// Carries a state on over a time of any length: by the longest rungs that fit, and the rest by its series.
    pub fn carry(&self, z: &mut [f64], mut time: f64) {
        let (mut rates, mut end) = (vec![0.0; z.len()], vec![0.0; z.len()]);
        for k in (1..RUNGS).rev() {
            while time >= self.long_length(k) {
                let rung = self.rung(k);
                self.rates(z, &mut rates);
                rung.at_end(z, &rates, &mut end);
                z.copy_from_slice(&end);
                time -= rung.length;
            }
        }
        let (mut series, parts) = (Series::default(), (time / self.length).ceil());
        for _ in 0..parts as u64 {
            series.expand(self, z, time / parts, self.orders_to(INTERVALS - 1));
            series.at_end(z);
        }
    }

    /// Length of an interval, s.
    pub fn interval(&self) -> f64 {
        self.length / INTERVALS as f64
    }

    /// Orders of a power series from the sub-step's start into interval `last`.
    pub fn orders_to(&self, last: usize) -> usize {
        self.orders[last]
    }

    /// Writes where the watched functionals stand at a state; where a stiff buffer presses also z' and z''.
    ///
    /// Its force is a small difference of large terms: what the state's coordinates bound is far too much. z'' has that difference in it.
    #[inline(always)]
    pub fn heads_at(&self, z: &[f64], [rates, second]: [&mut Vec<f64>; 2], to: &mut Vec<Group>) {
        let mut sizes = z;
        if let Some(increment) = &self.increment {
            [&mut *rates, second].into_iter().for_each(|memory| memory.resize(z.len(), 0.0));
            increment.rates(z, rates);
            increment.rates(rates, second);
            sizes = second;
        }
        to.resize(self.heads.len(), Default::default());
        for (to, group) in to.iter_mut().zip(&self.heads) {
            *to = group.at(z, sizes);
        }
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

    /// The state at the end of a sub-step from that at its start, and from the rates that the [heads](Self::heads_at) have left.
    #[inline(always)]
    pub fn at_end(&self, z: &[f64], rates: &[f64], series: &mut Series, to: &mut [f64]) {
        match &self.increment {
            Some(increment) => increment.at_end(z, rates, to),
            None => self.at_interval_end(INTERVALS - 1, z, series, to),
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
        let value = w.row.at(z);
        if leaves(value, w.row.size(sizes)) {
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

    /// The sizes of what a flight of a time, of which at most a sub-step counts, has added to the velocities: Σ |A| |z| times this time, from
    /// the coordinates' sizes. Forces that balance leave of a velocity the rounding of this size.
    #[inline(always)]
    pub fn flown(&self, sizes: &[f64], time: f64, to: &mut [f64]) {
        self.forces.times(sizes, to);
        let time = time.min(self.length);
        for to in to {
            *to *= time;
        }
    }

    /// Numbers that the table holds.
    pub fn numbers(&self) -> usize {
        let size = self.a.len();
        self.transitions.len() * size * size
            + 2 * (self.a.entries() + self.sizes.entries())
            + size * size / 2
            + self.velocities.len() * WITHIN
            + self.watched.len() * size * (INTERVALS + LOCAL + 5)
            + self.increment.as_ref().map_or(0, Increment::numbers)
            + self.ladder.made().map(Rung::numbers).sum::<usize>()
            + self.lambda.len() * (size + self.lambda.len())
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
    /// The states within a time `dt` from `z`, by so many orders. A function of its own, as its entries that are not zero have no use for vectors.
    #[inline(never)]
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
    #[inline(never)]
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
