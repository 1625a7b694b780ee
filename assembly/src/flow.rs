//! Exact flow of a mode: the transition over a sub-step and its intervals, and for each watched
//! functional samples, a bound between them and its Taylor coefficients (docs/assembly-law.md (A5),
//! (A6)). Machines of few coordinates keep columns for all this, which act on the augmented state;
//! the others find it from each state anew.

mod ahead;
mod apart;
mod exact;
mod exponential;
mod kept;
mod ladder;
mod watched;

pub use crate::kernel::SparseMatrix;
pub use ahead::{Ahead, Series};
pub use exponential::rate_bound;
pub use ladder::{Ladder, RUNGS, Rung};
pub(crate) use watched::taylor;
pub use watched::{Group, Head, WatchTable, head_of};

use crate::law::ZERO;
use crate::mode::Linear;
use crate::signals::SMALL;
use crate::system::StateRow;
use apart::Apart;
use exponential::{LEAST_RATE, series_orders};
use kept::Kept;
use nalgebra::DMatrix;

/// Derivatives of a functional that are looked at where a mode begins, and its Taylor coefficients
/// from the first one on that is not zero.
pub const ORDERS: usize = 26;
/// Rate times the length of a sub-step. With 2 more whole sub-steps are made between events, with 4
/// bounds throughout a sub-step are so wide that more is searched: both take longer.
const RADIUS: f64 = 3.0;
/// Springs and buffers are stiff where they make the rate so many times what it is without them.
pub(crate) const STIFF: f64 = 30.0;
/// Intervals of a sub-step, at whose ends functionals are sampled.
pub const INTERVALS: usize = 8;
/// Taylor coefficients of a functional over an interval: with a radius of 3/8 the first one left
/// out is under 0.375¹⁶/16! < 8e-21 of the largest coordinate. They fill whole vectors.
pub const LOCAL: usize = 16;
/// Up to this many coordinates tables of a sub-step are kept as dense matrices; beyond, a power
/// series of the actual state takes their place. Measured on chains: the series needs less where
/// modes are new, and up to half as much again where a few come back often, beyond 30 hardly more.
pub(crate) const DENSE: usize = 20;
/// Within an interval no frequency turns farther than signals are carried on.
const _: () = assert!(RADIUS / INTERVALS as f64 <= SMALL);
/// Parts of a sub-step at its intervals' ends.
const ENDS: [f64; INTERVALS] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];

/// The flow of a mode.
#[derive(Debug)]
pub struct FlowTable {
    /// A of z' = A z, by its entries.
    pub a: SparseMatrix,
    /// The sizes of the terms of A's entries.
    sizes: SparseMatrix,
    /// The sizes of what contacts leave of the velocities, where there are such.
    loose: Option<SparseMatrix>,
    /// Coordinates and velocities of the machine, before the signals.
    one: usize,
    /// A bound of the norm of A in a weighted maximum norm, 1/s.
    pub rate: f64,
    /// Length of a sub-step, s.
    pub length: f64,
    /// The forces of stiff springs and of buffers that press, where they are found apart.
    apart: Option<Apart>,
    /// Tables of a sub-step, of machines of few coordinates.
    kept: Option<Kept>,
    /// Longer sub-steps, each twice the one before, made when they are first needed.
    ladder: Ladder<Rung>,
    /// Orders of a power series from the sub-step's start into each interval.
    orders: [usize; INTERVALS],
    /// What is watched.
    pub watched: Vec<WatchTable>,
    /// The forces of the basis.
    pub lambda: Vec<StateRow>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W of the basis.
    pub triangle: DMatrix<f64>,
}

impl FlowTable {
    /// The flow of a linear system whose coordinates from `one` on are signals.
    pub fn new(linear: Linear, one: usize) -> Self {
        let Linear { mut a, terms: sizes, lambda, triangle, watched, elastic, loose } = linear;
        let mut rate = rate_bound(&a, one).max(LEAST_RATE);
        // Whoever keeps tables pays for forces that are found apart, so that only stiff ones are.
        let is_small = a.len() <= DENSE;
        let apart = elastic.and_then(|elastic| {
            let is_stiff = !is_small || elastic.are_stiff || rate > STIFF * rate_bound(&elastic.rest, one);
            is_stiff.then(|| Apart::of(elastic))
        });
        // What contacts hold against such a force would leave its rounding in A, a force from
        // nowhere on all that they hold together.
        if let (Some(apart), Some(_)) = (&apart, &loose) {
            a = apart.sum();
            rate = rate_bound(&a, one).max(LEAST_RATE);
        }
        let length = RADIUS / rate;
        let orders = ENDS.map(|end| series_orders(RADIUS * end));
        let watched = watched.into_iter().map(|(watch, row)| WatchTable::new(watch, row, &a));
        let watched = watched.collect();
        let mut table = Self {
            a,
            sizes,
            loose,
            one,
            rate,
            length,
            apart,
            kept: None,
            ladder: Ladder::default(),
            orders,
            watched,
            lambda,
            triangle,
        };
        table.kept = is_small.then(|| Kept::of(&table));
        table
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
        self.rows_times_to(0, z, 1.0, to);
    }

    /// `factor` × A `z` but for the first rows.
    #[inline(always)]
    fn rows_times_to(&self, first: usize, z: &[f64], factor: f64, to: &mut [f64]) {
        match &self.apart {
            Some(apart) => apart.rows_times_to(first, z, factor, to),
            None => self.a.rows_times_to(first, z, factor, to),
        }
    }

    /// Carries a state on over a time of any length: by the longest rungs that fit, and the rest by
    /// its series.
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
            series.at(1.0, z);
        }
    }

    /// Length of an interval, s.
    pub fn interval(&self) -> f64 {
        self.length / INTERVALS as f64
    }

    /// The interval in which a span of a sub-step ends.
    pub fn interval_of(&self, span: f64) -> usize {
        ((span / self.interval()).ceil() as usize).clamp(1, INTERVALS) - 1
    }

    /// Orders of a power series from the sub-step's start into interval `last`.
    pub fn orders_to(&self, last: usize) -> usize {
        self.orders[last]
    }

    /// Looks ahead by a time within a sub-step: writes where the watched functionals stand; where
    /// forces are found apart also z' and z''.
    ///
    /// Such a force is a small difference of large terms: what the state's coordinates bound is far
    /// too much. z'' has that difference in it.
    #[inline(always)]
    pub fn look_ahead(
        &self,
        z: &[f64],
        time: f64,
        [rates, second]: [&mut Vec<f64>; 2],
        ahead: &mut Ahead,
        to: &mut Vec<Group>,
    ) {
        let Some(kept) = &self.kept else {
            return ahead.find(self, z, self.orders_to(self.interval_of(time)), to);
        };
        let mut sizes = z;
        if let Some(apart) = &self.apart {
            [&mut *rates, second].into_iter().for_each(|memory| memory.resize(z.len(), 0.0));
            apart.rows_times_to(0, z, 1.0, rates);
            apart.rows_times_to(0, rates, 1.0, second);
            sizes = second;
        }
        kept.heads_at(z, sizes, to);
    }

    /// The state at a time within an [interval](Self::begin_interval) from that at its start.
    /// Signals, whose values at a time are known, may stay as in `to` unless `all` are asked for.
    #[inline(always)]
    pub fn within(&self, z: &[f64], dt: f64, all: bool, ahead: &mut Ahead, to: &mut [f64]) {
        match &self.kept {
            None => ahead.within(dt / self.interval(), to),
            Some(kept) if !all => kept.within(z, dt, self.interval(), to),
            Some(_) => {
                let series = ahead.memory();
                series.expand(self, z, dt, self.orders[0]);
                series.at(1.0, to);
            }
        }
    }

    /// The state at the end of a sub-step from that at its start, and from what
    /// [looking ahead](Self::look_ahead) has left.
    #[inline(always)]
    pub fn at_end(&self, z: &[f64], derivatives: [&[f64]; 2], ahead: &Ahead, to: &mut [f64]) {
        match &self.kept {
            Some(kept) => kept.at_end(z, derivatives, self.length, to),
            None => ahead.series.at(1.0, to),
        }
    }

    /// The state at the start of interval `i` from that at the sub-step's start, and from what
    /// [looking ahead](Self::look_ahead) has left.
    #[inline(always)]
    pub fn at_interval_start(&self, i: usize, z: &[f64], ahead: &Ahead, to: &mut [f64]) {
        match (i.checked_sub(1), &self.kept) {
            (None, _) => to.copy_from_slice(z),
            (Some(last), Some(kept)) => kept.at_interval_end(last, z, to),
            (Some(last), None) => ahead.series.at(ENDS[last], to),
        }
    }

    /// The values of the watched functional at a place at the interval ends, from the state at the
    /// sub-step's start.
    #[inline(always)]
    pub fn samples(&self, place: usize, z: &[f64], ahead: &Ahead) -> [f64; INTERVALS] {
        match &self.kept {
            Some(kept) => kept.watched(place).samples(z),
            None => ahead.samples(place),
        }
    }

    /// Goes on to an interval, at whose start the state is `from`.
    #[inline(always)]
    pub fn begin_interval(&self, from: &[f64], ahead: &mut Ahead) {
        if self.kept.is_none() {
            ahead.begin_interval(self, from);
        }
    }

    /// The Taylor coefficients of the watched functional at a place about the
    /// [begin of an interval](Self::begin_interval), in units of an interval.
    #[inline(always)]
    pub fn local(&self, place: usize, from: &[f64], ahead: &Ahead) -> [f64; LOCAL] {
        match &self.kept {
            Some(kept) => kept.watched(place).local(from),
            None => ahead.local(self, place),
        }
    }

    /// Whether tables of a sub-step are kept; else a state's series is found by the entries that
    /// are not zero.
    pub fn is_dense(&self) -> bool {
        self.kept.is_some()
    }

    /// The order of the first derivative of a functional that is not zero, and its value; those
    /// that are positive count as zero up to `doubt` times what is zero else. None where all are.
    /// `rows` is memory.
    pub fn departure(
        &self,
        w: &WatchTable,
        z: &[f64],
        sizes: &[f64],
        doubt: f64,
        rows: &mut DepartureRows,
    ) -> Option<(usize, f64)> {
        let leaves = |value: f64, size: f64| value < -ZERO * size || value > doubt * ZERO * size;
        let value = w.row.at(z);
        if leaves(value, w.row.size(sizes)) {
            return Some((0, value));
        }
        let slope = w.slope.dot(z);
        if leaves(slope, self.slope_size(w, sizes)) {
            return Some((1, slope));
        }
        let size = w.row.len();
        let DepartureRows { row, next_row, terms, next_terms } = rows;
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

    /// The size of the terms that the time derivative of a functional is the sum of, from the
    /// coordinates' sizes.
    fn slope_size(&self, w: &WatchTable, sizes: &[f64]) -> f64 {
        w.row.terms().iter().map(|&(i, x)| x.abs() * self.sizes.row_times(i, sizes)).sum()
    }

    /// The second time derivative of a functional at a state.
    pub fn bow(&self, w: &WatchTable, z: &[f64]) -> f64 {
        w.slope.terms().iter().map(|&(i, x)| x * self.a.row_times(i, z)).sum()
    }

    /// The sizes of what a flight of a time, of which at most a sub-step counts, has added to the
    /// velocities: Σ |A| |z| times this time, from the coordinates' sizes. Forces that balance
    /// leave of a velocity the rounding of this size, but for what contacts keep at zero. `all` is
    /// memory.
    #[inline(always)]
    pub fn flight_sizes(&self, sizes: &[f64], time: f64, all: &mut Vec<f64>, to: &mut [f64]) {
        let time = time.min(self.length);
        match &self.loose {
            None => self.sizes.rows_times_to(self.one / 2, sizes, time, to),
            Some(loose) => {
                let first = self.one / 2;
                let apart = self.apart.as_ref().and_then(|apart| Some((apart, apart.rest_terms()?)));
                let terms = apart.map_or(&self.sizes, |(_, terms)| terms);
                all.resize(to.len(), 0.0);
                terms.rows_times_to(first, sizes, time, all);
                loose.rows_times_to(0, all, 1.0, to);
                if let Some((apart, _)) = apart {
                    apart.add_sizes(first, sizes, time, to);
                }
            }
        }
    }

    /// Numbers that the table holds.
    pub fn numbers(&self) -> usize {
        let size = self.a.len();
        2 * (self.a.entries() + self.sizes.entries() + self.loose.as_ref().map_or(0, SparseMatrix::entries))
            + self.watched.len() * size
            + self.kept.as_ref().map_or(0, |kept| kept.numbers(size))
            + self.apart.as_ref().map_or(0, Apart::numbers)
            + self.ladder.made().map(Rung::numbers).sum::<usize>()
            + self.lambda.len() * (size + self.lambda.len())
    }
}

/// Memory for a functional's derivative and for the sizes of its terms.
#[derive(Clone, Debug, Default)]
pub struct DepartureRows {
    row: Vec<f64>,
    next_row: Vec<f64>,
    terms: Vec<f64>,
    next_terms: Vec<f64>,
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
