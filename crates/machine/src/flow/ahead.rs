//! Power series ahead of a state, for modes that keep no tables, as in machines of many
//! coordinates. If a machine has many contacts, a mode seldom occurs twice, and the power series
//! of the actual state costs little more than products with tables.
//!
//! One series serves a sub-step. It ends a little after the next event that a parabola predicts
//! for any watched functional, with orders up to a remainder that is provably rounding. The
//! events, the state at the first event and the accounts up to it all come from this series
//! (docs/assembly-law.md, section 2).

use super::{FlowTable, RADIUS};
use crate::curved::CurveSeries;
pub use crate::curved::TERMS;
use crate::kernel::{AtNodes, Sparse, largest_product, multiply_add_rows};

/// Bound of the omitted terms of a series, relative to the largest of its first three terms, in
/// the norm of (A6).
const REMAINDER: f64 = 1e-18;

/// Length of a series relative to the predicted time of the event: parabolas predict it too early
/// or too late.
const BEHIND: f64 = 1.15;

/// Shortest series, as a fraction of the longest: predictions for functionals that leave zero
/// slowly may be too early.
const SHORTEST: f64 = 0.02;

/// Rate times length of the longest series. Measured on chains: one series then covers a contact
/// from beginning to end.
const REACH: f64 = 4.0;

/// Power series of the states within a span, in the elapsed fraction of the span. Its memory is
/// reused.
#[derive(Clone, Debug, Default)]
pub struct Series {
    pub(super) terms: Vec<f64>,
    pub(super) size: usize,
    /// Order of the last term.
    pub(super) orders: usize,
    /// Series of the curved forces.
    pub(super) curves: Vec<CurveSeries>,
}

impl Series {
    /// Expands the states within a time `dt` from `z`, up to order `orders`.
    #[inline(always)]
    pub fn expand(&mut self, table: &FlowTable, z: &[f64], dt: f64, orders: usize) {
        self.begin(z, orders);
        if !table.curves.is_empty() {
            self.curve(table, 0);
        }
        // Not by `for_each`, whose closure is compiled without the computer's vectors.
        for k in 1..=orders {
            self.next(table, k, dt / k as f64);
        }
        self.orders = orders;
    }

    #[inline(always)]
    fn begin(&mut self, z: &[f64], orders: usize) {
        self.size = z.len();
        if self.terms.len() < (orders + 1) * self.size {
            self.terms.resize((orders + 1) * self.size, 0.0);
        }
        self.terms[..self.size].copy_from_slice(z);
    }

    /// Computes the term of order `k`: A times the previous term times `factor`.
    #[inline(always)]
    fn next(&mut self, table: &FlowTable, k: usize, factor: f64) {
        let (size, own) = (self.size, table.coordinates);
        let (before, after) = self.terms.split_at_mut(k * size);
        let before = &before[(k - 1) * size..];
        // The rates of the coordinates are the velocities, which follow the coordinates in the
        // state.
        let (lengths, others) = after[..size].split_at_mut(own);
        lengths.iter_mut().zip(&before[own..]).for_each(|(q, v)| *q = factor * v);
        table.rows_times_to(own, before, factor, others);
        if !table.curves.is_empty() {
            self.curve(table, k);
        }
    }

    #[inline(always)]
    pub(super) fn term(&self, k: usize) -> &[f64] {
        &self.terms[k * self.size..][..self.size]
    }

    /// The norm of (A6) of the first coordinates of a term.
    #[inline(always)]
    pub(super) fn norm(&self, table: &FlowTable, k: usize, coordinates: usize) -> f64 {
        largest_product(&self.term(k)[..coordinates], &table.weights[..coordinates])
    }

    #[inline(always)]
    pub(super) fn scale(&mut self, k: usize, factor: f64) {
        self.terms[k * self.size..][..self.size].iter_mut().for_each(|x| *x *= factor);
    }

    /// Writes the state after the fraction `part` of the span.
    #[inline(always)]
    pub fn at(&self, part: f64, to: &mut [f64]) {
        to.copy_from_slice(self.term(self.orders));
        // The larger terms are added last.
        (0..self.orders).rev().for_each(|k| multiply_add_rows(to, part, self.term(k)));
    }

    /// Writes the coordinates from `first` on at nodes within the first `part` of the span.
    #[inline(always)]
    pub fn at_nodes<const G: usize>(
        &self,
        nodes: &[(f64, f64); G],
        part: f64,
        first: usize,
        to: &mut Vec<AtNodes>,
    ) {
        let parts: [f64; G] = std::array::from_fn(|node| part * nodes[node].0);
        let mut powers = [[1.0; G]; TERMS];
        for k in 1..=self.orders {
            powers[k] = std::array::from_fn(|node| powers[k - 1][node] * parts[node]);
        }
        to.resize(self.size, AtNodes::default());
        for (j, to) in to.iter_mut().enumerate().skip(first) {
            let mut sums = [0.0; G];
            // The larger terms are added last.
            for (k, powers) in powers[..=self.orders].iter().enumerate().rev() {
                let x = self.terms[k * self.size + j];
                sums.iter_mut().zip(powers).for_each(|(sum, power)| *sum += x * power);
            }
            to[..G].copy_from_slice(&sums);
        }
    }

    /// The terms, beginning with order 0, each with one number for each coordinate of the state.
    pub fn terms(&self) -> impl Iterator<Item = &[f64]> {
        self.terms.chunks_exact(self.size.max(1)).take(self.orders + 1)
    }
}

/// A watched functional over a span.
#[derive(Clone, Copy, Debug)]
pub struct HeadAhead {
    /// Value at the start.
    pub value: f64,
    /// Coefficient of order 1, with time in units of the span.
    pub slope: f64,
    /// Bound of the sum of the sizes of the other coefficients.
    pub behind: f64,
}

/// Power series and watched functionals ahead of a state.
#[derive(Clone, Debug, Default)]
pub struct Ahead {
    /// The states within the span.
    pub series: Series,
    /// Length of the span, s.
    pub span: f64,
    /// Span of the series of curved forces, s.
    pub(super) expanded: f64,
    /// Whether the series of curved forces goes back in time.
    pub(super) backwards: bool,
    /// Head of each watched functional.
    pub(super) heads: Vec<HeadAhead>,
    /// For each coordinate, the sum of the sizes of its terms of order 2 and above.
    behind: Vec<f64>,
    memory: Series,
}

impl Ahead {
    /// Memory for series ahead of states, or with `backwards` for series back in time.
    pub fn towards(backwards: bool) -> Self {
        Self { backwards, ..Self::default() }
    }

    /// Expands the states ahead of `z` up to the nearest predicted event, but at most by a time
    /// `most`. `leaving` returns, for a watched functional, the order of its zero at the start and
    /// the value that it crosses.
    #[inline(always)]
    pub fn find(&mut self, table: &FlowTable, z: &[f64], most: f64, leaving: impl Fn(usize) -> (usize, f64)) {
        if !table.curves.is_empty() {
            return self.find_curved(table, z, most);
        }
        let series = &mut self.series;
        series.begin(z, TERMS - 1);
        series.next(table, 1, 1.0);
        series.next(table, 2, 1.0);
        let mut span = most.min(REACH / table.rate);
        let shortest = SHORTEST * span;
        self.heads.clear();
        for (place, w) in table.watched.iter().enumerate() {
            let (order, limit) = leaving(place);
            // Not by `map`, which the compiler turns into a call.
            let of = |k: usize| w.row.dot(series.term(k));
            let (value, slope, bend) = (of(0), of(1), of(2));
            self.heads.push(HeadAhead { value, slope, behind: 0.0 });
            let passes = match order {
                0 => passage(value - limit, slope, bend),
                1 => (bend > 0.0 && slope < 0.0).then(|| -2.0 * slope / bend),
                _ => None,
            };
            span = passes.map_or(span, |time| span.min((BEHIND * time).max(shortest)));
        }
        self.span = span;
        series.scale(1, span);
        series.scale(2, 0.5 * span * span);
        let size = (0..3).map(|k| series.norm(table, k, table.one)).fold(0.0, f64::max);
        let (radius, mut k, mut bound) = (table.rate * span, 2, 0.5 * (table.rate * span).powi(2));
        loop {
            let ratio = radius / (k + 1) as f64;
            if k + 1 == TERMS {
                break;
            }
            // The remainder is at most the last term times q/(1 - q). The norm is computed only
            // where the remainder may be small.
            if ratio < 0.9
                && bound < 1e-8
                && series.norm(table, k, z.len()) * ratio / (1.0 - ratio) <= REMAINDER * size
            {
                break;
            }
            k += 1;
            bound *= ratio;
            series.next(table, k, span / k as f64);
        }
        series.orders = k;
        self.heads.iter_mut().for_each(|head| head.slope *= span);
        self.sum_behind(table);
    }

    /// Sets the bounds of the heads from the terms of order 2 and above.
    #[inline(always)]
    pub(super) fn sum_behind(&mut self, table: &FlowTable) {
        let series = &self.series;
        self.behind.clear();
        self.behind.resize(series.size, 0.0);
        for k in 2..=series.orders {
            self.behind.iter_mut().zip(series.term(k)).for_each(|(sum, x)| *sum += x.abs());
        }
        for (head, w) in self.heads.iter_mut().zip(&table.watched) {
            head.behind = w.row.size(&self.behind);
        }
    }

    /// The head of the watched functional with index `place`.
    #[inline(always)]
    pub fn head(&self, place: usize) -> HeadAhead {
        self.heads[place]
    }

    /// The power series of a functional, in the fraction of the span.
    #[inline(always)]
    pub fn way(&self, row: &Sparse) -> [f64; TERMS] {
        let mut way = [0.0; TERMS];
        way.iter_mut().zip(self.series.terms()).for_each(|(c, term)| *c = row.dot(term));
        way
    }

    /// Number of possibly nonzero coefficients of these series.
    #[inline(always)]
    pub fn coefficients(&self) -> usize {
        self.series.orders + 1
    }

    /// Memory for a series.
    pub fn memory(&mut self) -> &mut Series {
        &mut self.memory
    }
}

/// First zero of the parabola with this value below zero, slope and curvature at the start.
fn passage(value: f64, slope: f64, bend: f64) -> Option<f64> {
    let square = slope * slope - 2.0 * bend * value;
    let sum = slope + square.sqrt();
    (value < 0.0 && square >= 0.0 && sum > 0.0).then(|| -2.0 * value / sum)
}

const _: () = assert!(RADIUS <= REACH);
