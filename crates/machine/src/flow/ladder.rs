//! Long steps of stiff machines. The length of a sub-step follows from the mode's fastest motion.
//! If that motion has decayed or does not change the watched functionals, the state advances by 2,
//! 4, 8, … sub-steps at once; the actual state determines which length is safe
//! (docs/assembly-law.md (A27), (A28)).

use super::exact::Exact;
use super::exponential::{exponentials, integral_and_change};
use super::watched::BOUND_MARGIN;
use super::{FlowTable, INTERVALS, RADIUS};
use crate::kernel::{Blocks, Sparse};
use crate::mode::WatchTable;
use nalgebra::{DMatrix, DVector};
use std::sync::{Arc, OnceLock};

/// Number of rungs: lengths of up to 2⁴⁷ sub-steps.
pub const RUNGS: usize = 48;

/// Limit of the number of coordinates for flows with stiff forces that are doubled in
/// double-double arithmetic. It takes ten times as long: milliseconds for each doubling.
const EXACT: usize = 40;

/// A value for each length of 2^k sub-steps, made on first use. Most modes need no rung. The list
/// itself is therefore made with the first rung.
#[derive(Clone, Debug)]
pub struct Ladder<T>(OnceLock<Vec<OnceLock<T>>>);

impl<T> Default for Ladder<T> {
    fn default() -> Self {
        Self(OnceLock::new())
    }
}

impl<T> Ladder<T> {
    /// The rung of 2^`k` sub-steps.
    pub fn at(&self, k: usize) -> &OnceLock<T> {
        &self.0.get_or_init(|| (0..RUNGS).map(|_| OnceLock::new()).collect())[k]
    }

    /// The rungs that have been made.
    pub fn made(&self) -> impl Iterator<Item = &T> {
        self.0.get().into_iter().flatten().filter_map(OnceLock::get)
    }
}

fn dense(row: &Sparse, size: usize) -> DVector<f64> {
    DVector::from_vec(row.dense(size))
}

/// The flow over 2^k sub-steps.
#[derive(Debug)]
pub struct Rung {
    /// Length, s.
    pub length: f64,
    /// ∫ exp(A s) ds over the length.
    integral: DMatrix<f64>,
    /// `integral` in the form for fast products.
    blocks: Blocks,
    /// exp(A h) - 1 at the end. The 1 is subtracted so that small entries keep their digits in
    /// doubling.
    change: DMatrix<f64>,
    /// Integral and change in double-double arithmetic, if elastic forces are computed separately.
    exact: Option<Exact>,
    /// Bounds of |exp(A s)| throughout the length.
    spread: DMatrix<f64>,
    /// For each watched functional: bounds of |row exp(A s)| throughout the length.
    reaches: Vec<Vec<f64>>,
}

impl Rung {
    /// The flow over one sub-step.
    pub(super) fn first(table: &FlowTable) -> Self {
        let (a, length) = (&table.a, table.length);
        let [integral, change] = integral_and_change(a, length);
        let starts: Vec<f64> = (0..INTERVALS).map(|i| i as f64 / INTERVALS as f64).collect();
        let within = exponentials(&a.abs(), table.rate, table.interval(), &[1.0]).remove(0);
        let starts = exponentials(a, table.rate, length, &starts);
        let spreads = starts.iter().map(|start| start.abs() * &within);
        let spread = spreads.reduce(|a, b| a.zip_map(&b, f64::max)).expect("there are intervals");
        let reach =
            |row: &Sparse| (spread.tr_mul(&dense(row, a.len()).abs()) * BOUND_MARGIN).as_slice().to_vec();
        let reaches = table.watched.iter().map(|w| reach(&w.row)).collect();
        let apart = table.apart.as_ref().filter(|_| a.len() <= EXACT);
        let exact = apart.map(|apart| Exact::first(apart, a.len(), length, RADIUS));
        Self::of(length, [integral, change], exact, spread, reaches)
    }

    fn of(
        length: f64,
        rounded: [DMatrix<f64>; 2],
        exact: Option<Exact>,
        spread: DMatrix<f64>,
        reaches: Vec<Vec<f64>>,
    ) -> Self {
        let [integral, change] = exact.as_ref().map_or(rounded, Exact::rounded);
        let blocks = Blocks::of(&integral);
        Self { length, integral, blocks, change, exact, spread, reaches }
    }

    /// The flow over twice the length.
    pub(super) fn doubled(&self, table: &FlowTable) -> Self {
        let Self { length, integral, change, exact, spread, reaches, .. } = self;
        let end = DMatrix::identity(change.nrows(), change.ncols()) + change;
        let later = end.abs() * spread * BOUND_MARGIN;
        let reach = |(before, w): (&Vec<f64>, &Arc<WatchTable>)| {
            let later = spread.tr_mul(&end.tr_mul(&dense(&w.row, change.nrows())).abs()) * BOUND_MARGIN;
            before.iter().zip(&later).map(|(before, later)| before.max(*later)).collect()
        };
        let reaches = reaches.iter().zip(&table.watched).map(reach).collect();
        Self::of(
            2.0 * length,
            [integral * 2.0 + change * integral, change * 2.0 + change * change],
            exact.as_ref().map(Exact::doubled),
            spread.zip_map(&later, f64::max),
            reaches,
        )
    }

    /// Bound of a watched functional's second derivative over the whole length, from the state's
    /// second derivative at the start. `place` is the functional's index.
    pub fn bend(&self, place: usize, second: &[f64]) -> f64 {
        self.reaches[place].iter().zip(second).map(|(r, x)| r * x.abs()).sum()
    }

    /// Writes the state at the end from the state at the start and its derivative.
    pub fn at_end(&self, z: &[f64], rates: &[f64], to: &mut [f64]) {
        self.blocks.times(rates, to);
        to.iter_mut().zip(z).for_each(|(to, z)| *to += z);
    }

    /// The product rows × exp(A h): the rows that give, from the state at the start, the values of
    /// `rows` at the end.
    pub fn after(&self, rows: &DMatrix<f64>) -> DMatrix<f64> {
        rows + rows * &self.change
    }

    /// Count of stored numbers.
    pub fn numbers(&self) -> usize {
        let exact = self.exact.as_ref().map_or(0, Exact::numbers);
        4 * self.change.len() + exact + self.reaches.len() * self.change.nrows()
    }
}
