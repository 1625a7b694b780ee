//! Watched functionals of a mode, with stored columns for their samples, bounds and Taylor
//! coefficients over a sub-step.

use super::exponential::add;
use super::{INTERVALS, LOCAL};
use crate::kernel::{ABREAST, SparseMatrix, combine};
use crate::mode::WatchTable;
use std::sync::Arc;

/// Factor that covers the rounding of a bound.
pub(super) const BOUND_MARGIN: f64 = 1.0 + 1e-9;

/// Stored columns of a watched functional over a sub-step.
#[derive(Clone, Debug)]
pub(super) struct WatchColumns {
    /// Bound throughout the sub-step: |functional''| is at most Σ curvature · |z|. In modes whose
    /// stiff forces are computed separately, it is at most Σ curvature · |z''|.
    curvature: Vec<f64>,
    /// For each coordinate: values at the interval ends.
    samples: Vec<[f64; INTERVALS]>,
    /// For each coordinate: Taylor coefficients, with time in units of an interval.
    local: Vec<[f64; LOCAL]>,
}

impl WatchColumns {
    /// Values at the interval ends.
    #[inline(always)]
    pub(super) fn samples(&self, z: &[f64]) -> [f64; INTERVALS] {
        combine(&self.samples, z)
    }

    /// Taylor coefficients about a state, with time in units of an interval.
    #[inline(always)]
    pub(super) fn local(&self, z: &[f64]) -> [f64; LOCAL] {
        combine(&self.local, z)
    }
}

/// A watched functional at the start of a sub-step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Head {
    /// Value.
    pub value: f64,
    /// Time derivative.
    pub slope: f64,
    /// Bound of the second derivative throughout the sub-step.
    pub bend: f64,
}

/// Number of functionals whose heads are computed together, one per vector lane.
const GROUP: usize = 4;

/// The heads of up to four functionals: values, slopes, bounds of second derivatives.
#[derive(Clone, Copy, Debug, Default)]
pub struct Group([[f64; GROUP]; 3]);

/// The head of the functional with index `place`.
#[inline(always)]
pub fn head_of(groups: &[Group], place: usize) -> Head {
    let Group(sums) = &groups[place / GROUP];
    let [value, slope, bend] = sums.each_ref().map(|sums| sums[place % GROUP]);
    Head { value, slope, bend }
}

/// Coefficients for the heads of a group of functionals. For each coordinate: values, slopes and
/// bounds of second derivatives.
#[derive(Clone, Debug)]
pub(super) struct Heads(Vec<[[f64; GROUP]; 3]>);

impl Heads {
    /// Coefficients for all functionals of a state of `size` numbers, in groups.
    pub(super) fn of(watched: &[Arc<WatchTable>], columns: &[WatchColumns], size: usize) -> Vec<Self> {
        let column = |(group, kept): (&[Arc<WatchTable>], &[WatchColumns]), j: usize| {
            let mut column = [[0.0; GROUP]; 3];
            for (k, (w, kept)) in group.iter().zip(kept).enumerate() {
                (column[0][k], column[2][k]) = (w.row.entry(j), kept.curvature[j]);
                column[1][k] = w.slope.entry(j);
            }
            column
        };
        let groups = watched.chunks(GROUP).zip(columns.chunks(GROUP));
        groups.map(|group| Self((0..size).map(|j| column(group, j)).collect())).collect()
    }

    /// The heads at a state `z`; the bounds are computed from the vector `sizes`.
    #[inline(always)]
    pub(super) fn at(&self, z: &[f64], sizes: &[f64]) -> Group {
        let mut sums = [[0.0; GROUP]; 3];
        for ((columns, x), size) in self.0.iter().zip(z).zip(sizes) {
            let factors = [*x, *x, size.abs()];
            for i in 0..3 {
                for k in 0..GROUP {
                    sums[i][k] += columns[i][k] * factors[i];
                }
            }
        }
        Group(sums)
    }
}

/// For each functional and coordinate: Taylor coefficients with time in units of `step`, from the
/// transpose of A.
#[inline(always)]
pub(crate) fn taylor<const K: usize>(
    transpose: &SparseMatrix,
    rows: &[Vec<f64>],
    step: f64,
) -> Vec<Vec<[f64; K]>> {
    let size = transpose.len();
    let mut all = vec![vec![[0.0; K]; size]; rows.len()];
    let mut next = vec![[0.0; ABREAST]; size];
    for (rows, all) in rows.chunks(ABREAST).zip(all.chunks_mut(ABREAST)) {
        let mut own = side_by_side(rows, size);
        for k in 0..K {
            for (i, columns) in all.iter_mut().enumerate() {
                columns.iter_mut().zip(&own).for_each(|(column, x)| column[k] = x[i]);
            }
            transpose.times_eight(&own, step / (k + 1) as f64, &mut next);
            std::mem::swap(&mut own, &mut next);
        }
    }
    all
}

/// Interleaves up to eight rows.
#[inline(always)]
fn side_by_side(rows: &[Vec<f64>], size: usize) -> Vec<[f64; ABREAST]> {
    let mut all = vec![[0.0; ABREAST]; size];
    for (i, row) in rows.iter().enumerate() {
        all.iter_mut().zip(row).for_each(|(all, x)| all[i] = *x);
    }
    all
}

/// Number of Taylor coefficients of a functional over a sub-step. The rate times the length of a
/// sub-step is 3. The first omitted term is therefore below 3³⁴/34! < 6e-23 of the largest
/// coordinate; in the second derivative it is below 7e-20.
pub(super) const WHOLE: usize = 34;

/// Values and second derivatives of a power series at 1, 2, …, [`INTERVALS`].
#[inline(always)]
fn at_interval_ends(c: &[f64; WHOLE]) -> [[f64; INTERVALS]; 2] {
    let ends: [f64; INTERVALS] = std::array::from_fn(|i| (i + 1) as f64);
    let (mut values, mut seconds) = ([0.0; INTERVALS], [0.0; INTERVALS]);
    for (k, c) in c.iter().enumerate().rev() {
        let second = c * (k * k.saturating_sub(1)) as f64;
        for i in 0..INTERVALS {
            values[i] = values[i] * ends[i] + c;
            if k >= 2 {
                seconds[i] = seconds[i] * ends[i] + second;
            }
        }
    }
    [values, seconds]
}

/// The columns of functionals over intervals of length `step`, from the transpose of A. Second
/// derivatives are bounded by the state or, with `is_stiff`, by the state's second derivative.
#[inline(always)]
pub(super) fn watch_columns(
    rows: &[Vec<f64>],
    transpose: &SparseMatrix,
    (step, is_stiff): (f64, bool),
) -> Vec<WatchColumns> {
    let size = transpose.len();
    let mut watched = Vec::with_capacity(rows.len());
    for columns in taylor::<WHOLE>(transpose, rows, step) {
        let (mut samples, mut peak) = (Vec::with_capacity(size), Vec::with_capacity(size));
        let mut local = Vec::with_capacity(size);
        for c in &columns {
            local.push(std::array::from_fn(|k| c[k]));
            let [values, seconds] = at_interval_ends(c);
            samples.push(values);
            // The largest |row''| at the intervals' starts; with `is_stiff`, the largest |row|.
            let (ends, first, unit) =
                if is_stiff { (&values, c[0], 1.0) } else { (&seconds, 2.0 * c[2], step * step) };
            let largest = ends[..INTERVALS - 1].iter().fold(first.abs(), |largest, x| largest.max(x.abs()));
            peak.push(largest / unit);
        }
        watched.push(WatchColumns { curvature: peak, samples, local });
    }
    // The bound within an interval: |r exp(At)| <= |r| exp(|A| t) for each entry. The series of
    // exp(|A| t) is summed to order `LOCAL`.
    let abs = transpose.abs();
    let peaks: Vec<_> = watched.iter().map(|w| w.curvature.clone()).collect();
    for (peaks, watched) in peaks.chunks(ABREAST).zip(watched.chunks_mut(ABREAST)) {
        let (mut peak, mut next) = (side_by_side(peaks, size), vec![[0.0; ABREAST]; size]);
        let mut bounds = peak.clone();
        for k in 1..=LOCAL {
            abs.times_eight(&peak, step / k as f64, &mut next);
            add(&mut bounds, 1.0, &next);
            std::mem::swap(&mut peak, &mut next);
        }
        for (i, w) in watched.iter_mut().enumerate() {
            w.curvature.iter_mut().zip(&bounds).for_each(|(bound, sum)| *bound = sum[i] * BOUND_MARGIN);
        }
    }
    watched
}
