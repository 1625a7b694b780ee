//! The flow of a mode without stored matrices, for machines of many coordinates: a power series of
//! the actual state. With many contacts a mode seldom recurs, and the series costs little more than
//! products with stored matrices. It also bounds the motion more closely than bounds for every
//! state.

use super::watched::{BOUND_MARGIN, WHOLE, put_head};
use super::{ENDS, FlowTable, Group, Head, INTERVALS, LOCAL};

/// The states within a span of time as a power series in the elapsed fraction; its memory is
/// reused.
#[derive(Clone, Debug, Default)]
pub struct Series {
    terms: Vec<f64>,
    size: usize,
}

impl Series {
    /// Expands the states within a time `dt` from `z` up to an order. Not inlined: sparse products
    /// gain nothing from the caller's vector instructions.
    #[inline(never)]
    pub fn expand(&mut self, table: &FlowTable, z: &[f64], dt: f64, orders: usize) {
        let (size, own) = (z.len(), table.one);
        self.size = size;
        self.terms.resize((orders + 1) * size, 0.0);
        self.terms[..size].copy_from_slice(z);
        for k in 1..=orders {
            let (before, after) = self.terms.split_at_mut(k * size);
            let (before, factor) = (&before[(k - 1) * size..], dt / k as f64);
            // The first rows of A are q' = v.
            let (lengths, others) = after[..size].split_at_mut(own / 2);
            lengths.iter_mut().zip(&before[own / 2..]).for_each(|(q, v)| *q = factor * v);
            table.rows_times_to(own / 2, before, factor, others);
        }
    }

    /// Writes the state at a fraction of the span.
    #[inline(never)]
    pub fn at(&self, part: f64, to: &mut [f64]) {
        to.fill(0.0);
        // The larger terms are added last.
        for term in self.terms.chunks_exact(self.size).rev() {
            to.iter_mut().zip(term).for_each(|(sum, x)| *sum = *sum * part + x);
        }
    }

    /// The coefficients from order 0 on, each as long as the state.
    pub fn terms(&self) -> impl Iterator<Item = &[f64]> {
        self.terms.chunks_exact(self.size)
    }
}

/// Power series of the states and functionals ahead of a state. Its functions are not inlined:
/// within a sub-step's code they slow machines with stored matrices by 5 %.
#[derive(Clone, Debug, Default)]
pub struct Ahead {
    /// States within a sub-step.
    pub series: Series,
    /// By watched functional: its power series in units of the sub-step.
    ways: Vec<[f64; WHOLE]>,
    /// States within the prepared interval, from its start.
    interval: Series,
}

impl Ahead {
    /// Expands the series at a state up to `orders`, and writes the heads of all watched
    /// functionals.
    #[inline(never)]
    pub(super) fn find(&mut self, table: &FlowTable, z: &[f64], orders: usize, heads: &mut Vec<Group>) {
        let Self { series, ways, .. } = self;
        series.expand(table, z, table.length, orders);
        ways.clear();
        heads.clear();
        for (place, w) in table.watched.iter().enumerate() {
            let mut way = [0.0; WHOLE];
            way.iter_mut().zip(series.terms()).for_each(|(c, term)| *c = w.row.at(term));
            // No term of the second derivative is larger within the sub-step than at its end.
            let bend: f64 = way.iter().zip(BEND).map(|(c, factor)| factor * c.abs()).sum();
            let head = Head {
                value: way[0],
                slope: way[1] / table.length,
                bend: bend * BOUND_MARGIN / (table.length * table.length),
            };
            put_head(heads, place, head);
            ways.push(way);
        }
    }

    /// The values at the interval ends of the watched functional at a place.
    #[inline(never)]
    pub(super) fn samples(&self, place: usize) -> [f64; INTERVALS] {
        let mut values = [0.0; INTERVALS];
        for c in self.ways[place].iter().rev() {
            for (value, end) in values.iter_mut().zip(ENDS) {
                *value = *value * end + c;
            }
        }
        values
    }

    /// Prepares an interval at whose start the state is `from`.
    pub(super) fn begin_interval(&mut self, table: &FlowTable, from: &[f64]) {
        self.interval.expand(table, from, table.interval(), LOCAL - 1);
    }

    /// The Taylor coefficients of the watched functional at a place about the prepared interval's
    /// start, in units of an interval.
    #[inline(never)]
    pub(super) fn local(&self, table: &FlowTable, place: usize) -> [f64; LOCAL] {
        let mut c = [0.0; LOCAL];
        let row = &table.watched[place].row;
        c.iter_mut().zip(self.interval.terms()).for_each(|(c, term)| *c = row.at(term));
        c
    }

    /// Writes the state at a fraction of the prepared interval.
    pub(super) fn within(&self, part: f64, to: &mut [f64]) {
        self.interval.at(part, to);
    }

    /// Scratch memory for a series; it replaces the prepared interval's.
    pub fn memory(&mut self) -> &mut Series {
        &mut self.interval
    }
}

/// Factors k (k - 1) of a series' coefficients in its second derivative.
const BEND: [f64; WHOLE] = {
    let mut factors = [0.0; WHOLE];
    let mut k = 2;
    while k < WHOLE {
        factors[k] = (k * (k - 1)) as f64;
        k += 1;
    }
    factors
};
