//! States of a motion as the record shows them: where segments begin by themselves.
//!
//! At a sample a parabola through its neighbours tells a column's value and rate. The fitted
//! motion's state there is changed as little as they ask for: a state that no column shows stays
//! as it is.

use super::evaluated::Point;
use super::model::Model;
use crate::error::Result;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use std::sync::Arc;
use vibro_machine::derivative::By;
use vibro_machine::mode::StopState;
use vibro_machine::{Assembly, Differentiated, What};

/// Samples on either side of one through which its parabola may go: as many as leave noise alone.
const BESIDE: [usize; 4] = [3, 5, 8, 12];
/// What a parabola leaves, over the noise, up to which it is that of the motion.
const NOISE: f64 = 1.3;
/// Part of a segment's length, before its end, in which the next one may begin.
const PLACE: f64 = 0.6;
/// Instants in this part that are tried, those first whose parabolas leave the least.
const TRIED: usize = 8;
/// Singular value of what columns show, relative to the largest, below which a state is not shown.
const SHOWN: f64 = 1e-4;

/// What a column shows at a sample.
#[derive(Clone, Copy)]
struct Shown {
    value: f64,
    rate: f64,
    /// Root mean square that the parabola leaves.
    left: f64,
}

/// The parabola through a number of samples on either side of one.
fn shown(times: &[f64], values: &[f64], place: usize, beside: usize) -> Option<Shown> {
    let low = place.checked_sub(beside)?;
    let (times, values) = (times.get(low..=place + beside)?, &values[low..=place + beside]);
    let (middle, width) = (times[beside], times[2 * beside] - times[0]);
    let powers = |time: &f64| {
        let x = (time - middle) / width;
        Vector3::new(1.0, x, x * x)
    };
    let (mut matrix, mut right) = (Matrix3::zeros(), Vector3::zeros());
    for (time, value) in times.iter().zip(values) {
        let row = powers(time);
        matrix += row * row.transpose();
        right += row * *value;
    }
    let found = matrix.cholesky()?.solve(&right);
    let left = |(time, value): (&f64, &f64)| (powers(time).dot(&found) - value).powi(2);
    let sum: f64 = times.iter().zip(values).map(left).sum();
    Some(Shown { value: found[0], rate: found[1] / width, left: (sum / times.len() as f64).sqrt() })
}

impl Model<'_> {
    /// Begins of segments of about a length, and the states that the record shows there, from the
    /// motion of `values` on. `sizes` are those of the states.
    pub(super) fn by_record(&self, values: &[f64], length: f64, sizes: &[f64]) -> Result<(Vec<f64>, Point)> {
        let mut point = Point::from(values.to_vec());
        let mut nodes = Vec::new();
        let made = self.unknowns.with(values)?;
        let assembly = made.assembly.clone();
        let mut motion = made.start.motion(assembly.clone())?;
        let (times, mut from) = (&self.measured.times, self.first());
        while from + length < self.end() {
            let (low, high) = (from + (1.0 - PLACE) * length, from + length);
            let range = times.partition_point(|t| *t < low)..times.partition_point(|t| *t <= high);
            let mut places: Vec<(f64, usize, usize)> = range
                .filter_map(|place| self.parabolas(place).map(|(left, beside)| (left, beside, place)))
                .collect();
            places.sort_by(|a, b| a.0.total_cmp(&b.0));
            let mut next = None;
            for (_, beside, place) in places.into_iter().take(TRIED) {
                let mut own = motion.clone();
                // A motion that breaks off shows no more states.
                if own.advance_to(times[place] + made.shift).is_err() {
                    continue;
                }
                let state = own.states();
                let found =
                    self.state_at(&assembly, (own.time(), &state), (place, beside), (&made.offsets, sizes));
                if let Some(found) = found {
                    next = Some((times[place], found, own));
                    break;
                }
            }
            from = match next {
                Some((time, state, _)) => {
                    nodes.push(time);
                    point.states.push(state);
                    time
                }
                None => from + PLACE * length,
            };
            // States that no column shows are those of the motion, as far as it goes.
            if motion.advance_to((from + made.shift).max(motion.time())).is_err() {
                break;
            }
        }
        Ok((nodes, point))
    }

    /// How little the widest parabolas around a sample tell that leave noise alone, and their width.
    fn parabolas(&self, place: usize) -> Option<(f64, usize)> {
        let left = |beside: usize| {
            let all = self.measured.columns.iter().enumerate().map(|(k, (_, all))| {
                Some(shown(&self.measured.times, all, place, beside)?.left / self.deviations()[k])
            });
            all.collect::<Option<Vec<f64>>>().map(|all| all.into_iter().fold(0.0, f64::max))
        };
        let fits = |beside: &&usize| left(**beside).is_some_and(|left| left <= NOISE);
        match BESIDE.iter().rev().find(fits) {
            Some(&beside) => Some(((beside as f64).powf(-1.5), beside)),
            None => Some((1.0 + left(BESIDE[0])?, BESIDE[0])),
        }
    }

    /// The state nearest to that of a motion that shows what the record has at a sample; `None`
    /// where a motion cannot begin with it.
    fn state_at(
        &self,
        assembly: &Arc<Assembly>,
        (time, state): (f64, &[f64]),
        (place, beside): (usize, usize),
        (offsets, sizes): (&[f64], &[f64]),
    ) -> Option<Vec<f64>> {
        let columns: Vec<By> = (0..state.len()).map(By::Start).collect();
        let motion = Differentiated::from_state(assembly.clone(), time, state, &columns).ok()?;
        let mut rows: Vec<(Vec<f64>, f64)> = Vec::new();
        for (k, (_, all)) in self.measured.columns.iter().enumerate() {
            let own = shown(&self.measured.times, all, place, beside)?;
            let unit = self.deviations()[k];
            let (value, rate) = self.compared.quantities_of(k);
            let mut row = |quantity, shown: f64, unit: f64| {
                let by: Option<Vec<f64>> = (0..state.len())
                    .map(|p| Some(motion.derivative(quantity, p)? * sizes[p] / unit))
                    .collect();
                let off = (shown - motion.motion().value(quantity)) / unit;
                by.map(|by| rows.push((by, off)))
            };
            row(value, own.value - offsets[k], unit);
            if let Some(rate) = rate.filter(|_| self.measured.columns[k].0.what != What::V) {
                // Rates count less than places by the time of a parabola.
                let times = &self.measured.times;
                let width = times[place + beside] - times[place - beside];
                row(rate, own.rate, unit / width);
            }
        }
        let matrix = DMatrix::from_fn(rows.len(), state.len(), |i, j| rows[i].0[j]);
        let right = DVector::from_fn(rows.len(), |i, _| rows[i].1);
        if rows.is_empty() || matrix.iter().chain(right.iter()).any(|x| !x.is_finite()) {
            return None;
        }
        let svd = matrix.svd(true, true);
        let most = svd.singular_values.max();
        let change = svd.solve(&right, SHOWN * most).ok()?;
        let state: Vec<f64> =
            state.iter().zip(sizes).zip(change.iter()).map(|((x, size), dx)| x + size * dx).collect();
        let motion = Differentiated::from_state(assembly.clone(), time, &state, &columns).ok()?;
        // A motion that presses a stop cannot be told from one that has left it.
        let is_open = |stop: &StopState| matches!(stop, StopState::Open | StopState::Below);
        motion.motion().mode().stops.iter().all(is_open).then_some(state)
    }
}
