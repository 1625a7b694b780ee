//! The exact flow of a mode, z' = A z, over a sub-step: transitions, and for each watched
//! functional samples at interval ends, a bound between them and local Taylor coefficients
//! (docs/assembly-law.md (A5), (A6)).
//!
//! A flow has two representations. Up to `DENSE` coordinates, a mode stores matrices (`kept`);
//! above, the power series of each state is computed when needed (`ahead`). Stiff forces are
//! computed separately from the rest of A (`apart`), and stiff machines may advance many sub-steps
//! at once (`ladder`).
//!
//! `RADIUS`, [`INTERVALS`], [`LOCAL`] and the other numbers of coefficients depend on each other:
//! a change of one requires a new proof of the error bound of each. Another order of summation
//! changes the last bits of motions, and with them the golden files.

mod ahead;
mod apart;
mod curved;
mod exact;
mod exponential;
mod kept;
mod ladder;
mod watched;

pub use crate::kernel::{Sparse, SparseMatrix};
pub use ahead::{Ahead, Series, TERMS};
pub use ladder::{Ladder, RUNGS, Rung};
pub(crate) use watched::taylor;
pub use watched::{Group, Head, head_of};

use crate::law::ZERO;
use crate::law::groups::Triangle;
use crate::linear::Linear;
use crate::mode::{Mode, WatchTable};
use crate::norm::{norm, rate_bound};
use crate::signals::SMALL;
use crate::system::{DENSE, STIFF, System};
use apart::Apart;
pub(crate) use curved::{
    AtState, CURVE_REACH, CurveInMode, GroupNorms, LAST_CURVE_ORDER, part, part_at_edges, part_from_edges,
    part_to_edge, rate_at, shortened, sides_ahead,
};
use exponential::series_orders;
use kept::Kept;
use std::sync::Arc;

/// Number of derivatives of a functional examined at the start of a mode, and number of its Taylor
/// coefficients, beginning with the first nonzero one.
pub const ORDERS: usize = 26;
/// Rate times the length of a sub-step. Radius 2 needs more sub-steps; radius 4 loosens the
/// bounds, so that more intervals are searched. Both are slower.
pub(crate) const RADIUS: f64 = 3.0;
/// Number of equal intervals of a sub-step; functionals are sampled at their ends.
pub const INTERVALS: usize = 8;
/// Number of Taylor coefficients of a functional over an interval: with a radius of 3/8 the first
/// omitted term is below 0.375¹⁶/16! < 8e-21 of the largest coordinate. A multiple of the vector
/// length.
pub const LOCAL: usize = 16;
/// Within an interval no harmonic turns by more than [`SMALL`] rad, as `Signals::carry_within`
/// requires.
const _: () = assert!(RADIUS / INTERVALS as f64 <= SMALL);
/// Interval ends as fractions of a sub-step.
const ENDS: [f64; INTERVALS] = [0.125, 0.25, 0.375, 0.5, 0.625, 0.75, 0.875, 1.0];
/// For each interval: orders of a power series from the sub-step's start to the interval's end.
const SERIES_ORDERS: [usize; INTERVALS] = {
    let (mut orders, mut i) = ([0; INTERVALS], 0);
    while i < INTERVALS {
        orders[i] = series_orders(RADIUS * ENDS[i]);
        i += 1;
    }
    orders
};

/// The flow of a mode.
#[derive(Debug)]
pub struct FlowTable {
    /// A of z' = A z.
    pub a: SparseMatrix,
    /// Sizes of the terms of A's entries, if they differ from the entries' own sizes.
    sizes: Option<SparseMatrix>,
    /// Sizes of the projection of velocities past the contacts; `None` without contacts.
    loose: Option<SparseMatrix>,
    /// Number of coordinates; their velocities follow.
    coordinates: usize,
    /// Number of states (coordinates, velocities, first-order states); the signals follow.
    one: usize,
    /// A bound of the norm of A in a weighted maximum norm, 1/s.
    pub rate: f64,
    /// Factor of each coordinate in this norm, 1/w of (A6).
    weights: Vec<f64>,
    /// Length of a sub-step, s.
    pub length: f64,
    /// Forces of stiff springs and pressed compliant stops, if they are computed separately.
    apart: Option<Apart>,
    /// Matrices of a sub-step, with at most [`DENSE`] coordinates.
    kept: Option<Kept>,
    /// Curved forces; with any, z' = A z does not give their rates, and the flow is a series.
    curves: Vec<CurveInMode>,
    /// Flows over 2^k sub-steps, made on first use.
    ladder: Ladder<Rung>,
    /// Watched functionals.
    pub watched: Vec<Arc<WatchTable>>,
    /// Contact forces of the basis, as rows.
    pub lambda: Vec<Sparse>,
    /// The upper triangle R with RᵀR = WᵀM⁻¹W of the basis.
    pub triangle: Triangle,
    /// Count of the numbers stored on construction.
    fixed: usize,
}

impl FlowTable {
    /// The flow of a linear system whose coordinates from `one` on are signals.
    pub fn new(linear: Linear, one: usize) -> Self {
        Self::with_norm(linear, one, true, |a| norm(a, one))
    }

    /// The flow of a linear system; `norm` bounds the norm of A, given its matrix. Small systems
    /// store matrices if `keeps` is true.
    fn with_norm(
        linear: Linear,
        one: usize,
        keeps: bool,
        norm: impl Fn(&SparseMatrix) -> (f64, Vec<f64>),
    ) -> Self {
        let Linear { coordinates, mut a, terms, lambda, triangle, watched, elastic, loose } = linear;
        // Separate forces make stored tables slower: only stiff forces are separated.
        let is_small = keeps && a.len() <= DENSE;
        let apart = elastic.and_then(|elastic| {
            let is_fast = || norm(&a).0 > STIFF * rate_bound(&elastic.rest, one);
            let is_stiff = !is_small || elastic.are_stiff || is_fast();
            is_stiff.then(|| Apart::of(elastic))
        });
        // The contacts' reaction to such a force would leave its rounding error in A: a spurious
        // force on all bodies that the contacts hold together.
        if let (Some(apart), Some(_)) = (&apart, &loose) {
            a = apart.sum();
        }
        let (rate, weights) = norm(&a);
        let length = RADIUS / rate;
        let watched = watched.into_iter().map(|(watch, row)| Arc::new(WatchTable::new(watch, row, &a)));
        let watched = watched.collect();
        let mut table = Self {
            a,
            // Without contacts nothing cancels.
            sizes: terms,
            loose,
            coordinates,
            one,
            rate,
            weights,
            length,
            apart,
            kept: None,
            curves: Vec::new(),
            ladder: Ladder::default(),
            watched,
            lambda,
            triangle,
            fixed: 0,
        };
        table.kept = is_small.then(|| Kept::of(&table));
        table.fixed = table.fixed_numbers();
        table
    }

    /// The flow of a mode, from the machine's split form unless the machine keeps matrices.
    pub fn of_mode(system: &System, mode: &Mode) -> Self {
        let system = &*system.at_mode(mode);
        let one = system.signals.one;
        if system.keeps_matrices() {
            return Self::new(system.linear(mode), one);
        }
        let split = system.split();
        let is_straight = system.curved.is_empty();
        let norm = |a: &SparseMatrix| split.norm(a);
        if mode.contacts().next().is_some() {
            let mut table = Self::with_norm(system.linear(mode), one, is_straight, norm);
            table.curves = CurveInMode::all(system, mode, &table.a, &table.weights);
            return table;
        }
        let mut terms = split.elastic(mode);
        terms.extend(split.frictional(mode));
        let a = split.with(terms.iter());
        let (rate, weights) = norm(&a);
        let in_mode = |(known, depends): &(Arc<WatchTable>, bool)| {
            if *depends { Arc::new(known.in_mode(&a)) } else { known.clone() }
        };
        let watched = split.watched(mode).map(in_mode).collect();
        let mut table = Self {
            sizes: None,
            loose: None,
            coordinates: system.coordinates,
            one,
            rate,
            length: RADIUS / rate,
            apart: Some(Apart::split(split.base.clone(), terms)),
            kept: None,
            curves: CurveInMode::all(system, mode, &a, &weights),
            weights,
            ladder: Ladder::default(),
            watched,
            lambda: Vec::new(),
            triangle: Triangle::default(),
            a,
            fixed: 0,
        };
        table.fixed = table.fixed_numbers();
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

    /// Writes z' at a state.
    pub fn rates(&self, z: &[f64], to: &mut [f64]) {
        self.rows_times_to(0, z, 1.0, to);
    }

    /// Writes `factor` × A `z`, beginning with row `first`.
    #[inline(always)]
    fn rows_times_to(&self, first: usize, z: &[f64], factor: f64, to: &mut [f64]) {
        match &self.apart {
            Some(apart) => apart.rows_times_to(first, z, factor, to),
            None => self.a.rows_times_to(first, z, factor, to),
        }
    }

    /// Advances a state by a time of any length: by the longest rungs that fit, and for the rest
    /// by power series.
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

    /// Index of the interval that contains the end of a span of a sub-step.
    pub fn interval_of(&self, span: f64) -> usize {
        ((span / self.interval()).ceil() as usize).clamp(1, INTERVALS) - 1
    }

    /// Orders of a power series from the sub-step's start to the end of interval `last`.
    pub fn orders_to(&self, last: usize) -> usize {
        SERIES_ORDERS[last]
    }

    /// Looks ahead if tables are kept: writes the heads of the watched functionals and, if forces
    /// are computed separately, z' and z''.
    ///
    /// A separate force is a small difference of large terms. Bounds from the state's coordinates
    /// would be far too wide and are therefore computed from z''.
    #[inline(always)]
    pub fn look_ahead(&self, z: &[f64], [rates, second]: [&mut Vec<f64>; 2], to: &mut Vec<Group>) {
        let Some(kept) = &self.kept else { return };
        let mut sizes = z;
        if let Some(apart) = &self.apart {
            [&mut *rates, second].into_iter().for_each(|memory| memory.resize(z.len(), 0.0));
            apart.rows_times_to(0, z, 1.0, rates);
            apart.rows_times_to(0, rates, 1.0, second);
            sizes = second;
        }
        kept.heads_at(z, sizes, to);
    }

    /// Writes the state at a time within an interval from the state at the interval's start.
    /// Unless `all` is true, signals may keep their values in `to`: they are known at any time.
    #[inline(always)]
    pub fn within(&self, z: &[f64], dt: f64, all: bool, ahead: &mut Ahead, to: &mut [f64]) {
        match &self.kept {
            Some(kept) if !all => kept.within(z, dt, self.interval(), to),
            _ => {
                let series = ahead.memory();
                series.expand(self, z, dt, self.orders_to(0));
                series.at(1.0, to);
            }
        }
    }

    /// The tables of a sub-step, for a mode that keeps tables.
    #[inline(always)]
    fn tables(&self) -> &Kept {
        self.kept.as_ref().expect("asked for where tables are kept")
    }

    /// Writes the state at the end of a sub-step from the state at its start and the derivatives
    /// found by [looking ahead](Self::look_ahead).
    #[inline(always)]
    pub fn at_end(&self, z: &[f64], derivatives: [&[f64]; 2], to: &mut [f64]) {
        self.tables().at_end(z, derivatives, self.length, to);
    }

    /// Writes the state at the start of interval `i` from the state at the sub-step's start.
    #[inline(always)]
    pub fn at_interval_start(&self, i: usize, z: &[f64], to: &mut [f64]) {
        match i.checked_sub(1) {
            None => to.copy_from_slice(z),
            Some(last) => self.tables().at_interval_end(last, z, to),
        }
    }

    /// Values of watched functional `place` at the interval ends, from the state at the sub-step's
    /// start.
    #[inline(always)]
    pub fn samples(&self, place: usize, z: &[f64]) -> [f64; INTERVALS] {
        self.tables().watched(place).samples(z)
    }

    /// Taylor coefficients of watched functional `place` about a state, with time in units of an
    /// interval.
    #[inline(always)]
    pub fn local(&self, place: usize, from: &[f64]) -> [f64; LOCAL] {
        self.tables().watched(place).local(from)
    }

    /// Whether matrices of a sub-step are stored; if not, states advance by power series.
    pub fn is_dense(&self) -> bool {
        self.kept.is_some()
    }

    /// Order and value of a functional's first nonzero derivative; `None` if all up to [`ORDERS`]
    /// are zero. Negative values count as zero within their rounding error, positive values within
    /// `doubt` times their rounding error. `rows` is scratch memory.
    pub fn departure(
        &self,
        w: &WatchTable,
        z: &[f64],
        sizes: &[f64],
        doubt: f64,
        rows: &mut DepartureRows,
    ) -> Option<(usize, f64)> {
        self.departure_from(0, w, z, sizes, doubt, rows)
    }

    /// As [`departure`](Self::departure), with the value counted as zero if `first` is 1.
    pub fn departure_from(
        &self,
        first: usize,
        w: &WatchTable,
        z: &[f64],
        sizes: &[f64],
        doubt: f64,
        rows: &mut DepartureRows,
    ) -> Option<(usize, f64)> {
        let leaves = |value: f64, size: f64| value < -ZERO * size || value > doubt * ZERO * size;
        let value = w.row.dot(z);
        if first == 0 && leaves(value, w.row.size(sizes)) {
            return Some((0, value));
        }
        let slope = w.slope.dot(z);
        if leaves(slope, self.slope_size(w, sizes)) {
            return Some((1, slope));
        }
        let size = z.len();
        let DepartureRows { row, next_row, terms, next_terms } = rows;
        [&mut *row, next_row, terms, next_terms].into_iter().for_each(|memory| memory.resize(size, 0.0));
        [&mut *row, terms].into_iter().for_each(|memory| memory.fill(0.0));
        w.row.terms().iter().for_each(|&(j, x)| (row[j], terms[j]) = (x, x.abs()));
        for k in 1..ORDERS {
            // Derivatives are Taylor coefficients in units of the sub-step.
            let factor = self.length / k as f64;
            self.a.after_row(row, factor, next_row);
            match &self.sizes {
                Some(sizes) => sizes.after_row(terms, factor, next_terms),
                None => self.a.sizes_after_row(terms, factor, next_terms),
            }
            std::mem::swap(row, next_row);
            std::mem::swap(terms, next_terms);
            let value = dot(row, z);
            if leaves(value, dot(terms, sizes)) {
                return Some((k, value));
            }
        }
        None
    }

    /// Sum of the sizes of the terms of a functional's time derivative, from the coordinates'
    /// sizes.
    fn slope_size(&self, w: &WatchTable, sizes: &[f64]) -> f64 {
        w.row.terms().iter().map(|&(i, x)| x.abs() * self.terms_of(i, sizes)).sum()
    }

    /// Sizes of the terms in row `i` of A, times the coordinates' sizes.
    fn terms_of(&self, i: usize, sizes: &[f64]) -> f64 {
        match &self.sizes {
            Some(own) => own.row_times(i, sizes),
            None => self.a.sizes_row_times(i, sizes),
        }
    }

    /// The second time derivative of a functional at a state.
    pub fn bow(&self, w: &WatchTable, z: &[f64]) -> f64 {
        w.slope.terms().iter().map(|&(i, x)| x * self.a.row_times(i, z)).sum()
    }

    /// Writes the sizes of the terms that a time adds to velocities and first-order states: Σ |A|
    /// |z| times this time, at most a sub-step. Terms that contacts keep at zero are left out.
    /// `sizes` are the coordinates' sizes. A velocity under balanced forces has a rounding error
    /// of this size. `all` is scratch memory.
    #[inline(always)]
    pub fn flight_sizes(&self, sizes: &[f64], time: f64, all: &mut Vec<f64>, to: &mut [f64]) {
        let time = time.min(self.length);
        match &self.loose {
            None => self.a.sizes_rows_times_to(self.coordinates, sizes, time, to),
            Some(loose) => {
                let first = self.coordinates;
                let apart = self.apart.as_ref().and_then(|apart| Some((apart, apart.rest_terms()?)));
                let own = self.sizes.as_ref().unwrap_or(&self.a);
                let terms = apart.map_or(own, |(_, terms)| terms);
                all.resize(to.len(), 0.0);
                terms.rows_times_to(first, sizes, time, all);
                loose.rows_times_to(0, all, 1.0, to);
                if let Some((apart, _)) = apart {
                    apart.add_sizes(first, sizes, time, to);
                }
            }
        }
    }

    /// Count of stored numbers.
    pub fn numbers(&self) -> usize {
        self.fixed + self.ladder.made().map(Rung::numbers).sum::<usize>()
    }

    /// Count of the numbers stored on construction.
    fn fixed_numbers(&self) -> usize {
        let held = [&self.sizes, &self.loose].into_iter().flatten().map(SparseMatrix::entries).sum::<usize>();
        // Modes without contacts share their watched functionals.
        let terms = |w: &Arc<WatchTable>| 2 * (w.row.terms().len() + w.slope.terms().len());
        let is_own = held > 0 || self.kept.is_some();
        2 * (self.a.entries() + held)
            + self.weights.len()
            + self.watched.iter().map(|w| if is_own { terms(w) } else { 1 }).sum::<usize>()
            + self.kept.as_ref().map_or(0, |kept| kept.numbers(self.a.len()))
            + self.apart.as_ref().map_or(0, Apart::numbers)
            + 2 * self.lambda.iter().map(|row| row.terms().len()).sum::<usize>()
            + self.triangle.numbers()
    }
}

/// Scratch memory of [`FlowTable::departure`]: a functional's derivative and the sizes of its
/// terms.
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

#[cfg(test)]
mod tests;
