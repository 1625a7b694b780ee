//! Extremes of quantities over a motion, also between samples, and their curves for a picture.

use super::flight::{Flow, Series, turning_points};
use super::rows::Sparse;
use vibro_machine::Quantity;
use vibro_machine::system::System;
use vibro_numerics::sorting::sort_by;

/// Number of columns of a curve, each with the smallest and the largest value. A picture has fewer
/// columns of pixels.
const COLUMNS: usize = 2000;
/// Largest number of quantities with curves.
const CURVES: usize = 64;

/// Extremes of a quantity.
#[derive(Clone, Debug)]
pub struct Extreme {
    /// The quantity.
    pub quantity: Quantity,
    row: Sparse,
    /// Largest absolute value.
    pub largest: f64,
    /// For each column the smallest and the largest value with their times; empty while the
    /// quantity is zero.
    curve: Vec<Option<[(f64, f64); 2]>>,
    /// Whether the quantity began at zero.
    was_zero: bool,
}

/// Extremes of several quantities.
#[derive(Clone, Debug)]
pub struct Extremes {
    /// One for each quantity.
    pub all: Vec<Extreme>,
    /// Beginning and end of the curves, s.
    times: (f64, f64),
}

impl Extremes {
    /// Starts the extremes of these quantities; curves are kept between two times, s.
    pub fn new(quantities: &[Quantity], times: (f64, f64)) -> Self {
        let extreme = |&quantity: &Quantity| Extreme {
            quantity,
            row: Sparse::default(),
            largest: 0.0,
            curve: Vec::new(),
            was_zero: false,
        };
        Self { all: quantities.iter().map(extreme).collect(), times }
    }

    /// Enters a mode.
    pub(super) fn enter(&mut self, system: &System, flow: &Flow) {
        self.all.iter_mut().for_each(|e| e.row = Sparse::of(flow.row_of(system, e.quantity)));
    }

    /// Includes a stretch of a flight that begins at `time` and lasts `length` s.
    pub(super) fn stretch(&mut self, series: &Series, time: f64, length: f64) {
        let times = self.times;
        for (i, extreme) in self.all.iter_mut().enumerate() {
            let q = extreme.row.along(series);
            turning_points(&q, &mut |u, x| extreme.meet(time + length * u, x, times, i < CURVES));
        }
    }

    /// Includes a state at a time.
    pub(super) fn state(&mut self, z: &[f64], time: f64) {
        let times = self.times;
        for (i, extreme) in self.all.iter_mut().enumerate() {
            extreme.meet(time, extreme.row.at(z), times, i < CURVES);
        }
    }
}

impl Extreme {
    fn meet(&mut self, time: f64, value: f64, (from, to): (f64, f64), keeps: bool) {
        self.largest = self.largest.max(value.abs());
        let starts = self.curve.is_empty();
        if !keeps || to <= from || (starts && value == 0.0) {
            self.was_zero |= starts;
            return;
        }
        if starts {
            self.curve = vec![None; COLUMNS];
        }
        let column = ((time - from) / (to - from) * COLUMNS as f64) as usize;
        let Some(column) = self.curve.get_mut(column.min(COLUMNS - 1)) else { return };
        let point = (time, value + 0.0);
        let zero = starts && self.was_zero;
        let [least, largest] = column.get_or_insert(if zero { [(time, 0.0); 2] } else { [point; 2] });
        if point.1 < least.1 {
            *least = point;
        }
        if point.1 > largest.1 {
            *largest = point;
        }
    }

    /// Times and values of the curve in order of time: in each column the smallest and the largest
    /// value.
    pub fn points(&self) -> Vec<(f64, f64)> {
        let mut points: Vec<_> = self.curve.iter().flatten().flatten().copied().collect();
        sort_by(&mut points, |a, b| a.0.total_cmp(&b.0));
        points
    }
}

#[cfg(test)]
mod tests;
