//! What lies ahead of a state where a mode keeps no tables of its sub-step, as in machines of many
//! coordinates: of many contacts a mode is seldom met twice, and the power series of the actual
//! state costs little more than products with tables. It also bounds the motion more closely than
//! what holds for every state.

use super::watched::{BOUND_MARGIN, WHOLE, put_head};
use super::{ENDS, FlowTable, Group, Head, INTERVALS, LOCAL};

/// The states within a span as a power series in the part of it that has passed; its memory is used
/// again.
#[derive(Clone, Debug, Default)]
pub struct Series {
    terms: Vec<f64>,
    size: usize,
}

impl Series {
    /// The states within a time `dt` from `z`, by so many orders. A function of its own, as its
    /// entries that are not zero have no use for vectors.
    #[inline(never)]
    pub fn expand(&mut self, table: &FlowTable, z: &[f64], dt: f64, orders: usize) {
        let (size, own) = (z.len(), table.one);
        self.size = size;
        self.terms.resize((orders + 1) * size, 0.0);
        self.terms[..size].copy_from_slice(z);
        for k in 1..=orders {
            let (before, after) = self.terms.split_at_mut(k * size);
            let (before, factor) = (&before[(k - 1) * size..], dt / k as f64);
            // The rates of the coordinates, which are the first half of the machine's own, are the
            // velocities.
            let (lengths, others) = after[..size].split_at_mut(own / 2);
            lengths.iter_mut().zip(&before[own / 2..]).for_each(|(q, v)| *q = factor * v);
            table.rows_times_to(own / 2, before, factor, others);
        }
    }

    /// The state where this part of the span has passed.
    #[inline(never)]
    pub fn at(&self, part: f64, to: &mut [f64]) {
        to.fill(0.0);
        // The larger terms last.
        for term in self.terms.chunks_exact(self.size).rev() {
            to.iter_mut().zip(term).for_each(|(sum, x)| *sum = *sum * part + x);
        }
    }

    /// The terms, each of as many coordinates as the state, from order 0 on.
    pub fn terms(&self) -> impl Iterator<Item = &[f64]> {
        self.terms.chunks_exact(self.size)
    }
}

/// What lies ahead of a state. What computes here stays a function: put into a sub-step's code it
/// slows the machines that keep tables, by a twentieth.
#[derive(Clone, Debug, Default)]
pub struct Ahead {
    /// The states within a sub-step.
    pub series: Series,
    /// The power series of each watched functional, in units of the sub-step.
    ways: Vec<[f64; WHOLE]>,
    /// The states within an interval, from its start.
    interval: Series,
}

impl Ahead {
    /// Finds it for a state, as far as `orders` of the series reach, with the heads of all watched
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
            // Within the sub-step no term of the second derivative is larger than at its end.
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

    /// The values of the watched functional at a place at the interval ends.
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

    /// Goes on to an interval, at whose start the state is `from`.
    pub(super) fn begin_interval(&mut self, table: &FlowTable, from: &[f64]) {
        self.interval.expand(table, from, table.interval(), LOCAL - 1);
    }

    /// The Taylor coefficients of the watched functional at a place about this interval's start, in
    /// units of an interval.
    #[inline(never)]
    pub(super) fn local(&self, table: &FlowTable, place: usize) -> [f64; LOCAL] {
        let mut c = [0.0; LOCAL];
        let row = &table.watched[place].row;
        c.iter_mut().zip(self.interval.terms()).for_each(|(c, term)| *c = row.at(term));
        c
    }

    /// The state at a part of this interval.
    pub(super) fn within(&self, part: f64, to: &mut [f64]) {
        self.interval.at(part, to);
    }

    /// Memory for a series.
    pub fn memory(&mut self) -> &mut Series {
        &mut self.interval
    }
}

/// What the coefficients of a series are multiplied by in its second derivative.
const BEND: [f64; WHOLE] = {
    let mut factors = [0.0; WHOLE];
    let mut k = 2;
    while k < WHOLE {
        factors[k] = (k * (k - 1)) as f64;
        k += 1;
    }
    factors
};
