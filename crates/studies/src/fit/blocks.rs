//! Iterated extended Kalman filter over blocks of samples (A. Gelb, Applied Optimal Estimation,
//! 1974, section 6.1), for motions with many impacts and parameters far off. Each block updates
//! parameters and state together, so that the motion never moves far from the record.
//!
//! The filter's errors are only linearized. The search therefore uses its parameters alone, and
//! fits them over the whole record.

use super::beside::end_of;
use super::bounds::Bounds;
use super::evaluated::{Point, Varied};
use super::loss::Loss;
use super::model::Model;
use super::unknowns::{Columns, Made};
use crate::error::{Error, Result};
use nalgebra::{DMatrix, DVector};
use std::ops::Range;
use vibro_machine::motion::Event;
use vibro_machine::{Differentiated, Motion};

/// Relative standard deviation of the parameters before each pass over the record.
const PASSES: [f64; 2] = [0.3, 0.05];
/// Standard deviation of the initial state, relative to the sizes of the states.
const START: f64 = 1e-3;
/// Standard deviation that each block adds to the state, relative to its size. It covers the
/// linearization and the error of parameters that are still wrong.
const ADDED: f64 = 2e-3;
/// Number of residuals in a block per parameter and state.
const RESIDUALS: usize = 2;
/// Smallest number of blocks in a segment, and the fraction of a block around the segment's start
/// without contact events.
const SEGMENT: usize = 5;
const QUIET: f64 = 0.25;
/// Cap on the steps in a block, initial damping, and damping at which the block ends.
const STEPS: u32 = 8;
const DAMPING: (f64, f64) = (1e-3, 1e6);
/// A spurious impact gives large residuals, which count less.
const LOSS: Loss = Loss::Huber;
/// Relative reduction of the cost below which a block ends.
const REDUCTION: f64 = 1e-3;

/// Parameters and state at one time, with their covariance.
struct Estimate {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
}

impl Estimate {
    /// Estimate at the start of the motion, with a relative standard deviation of the parameters.
    fn at_start(made: &Made, values: &[f64], (part, sizes): (f64, &[f64])) -> Result<Self> {
        let state = made.start.motion(made.assembly.clone())?.states();
        let (count, all) = (values.len(), values.len() + state.len());
        let deviation = |i: usize| match i.checked_sub(count) {
            None => part * if values[i] == 0.0 { 1.0 } else { values[i].abs() },
            Some(k) => START * sizes[k],
        };
        Ok(Self {
            mean: DVector::from_iterator(all, values.iter().chain(&state).copied()),
            covariance: DMatrix::from_diagonal(&DVector::from_fn(all, |i, _| deviation(i).powi(2))),
        })
    }
}

/// Block of samples with its residuals.
struct Block {
    residuals: DVector<f64>,
    /// Derivatives of the residuals by the parameters and the state at the block's begin.
    by: DMatrix<f64>,
    end: Vec<Varied>,
    /// Times of the motion's contact events: hits and touches of stops, and changes of contacts.
    events: Vec<f64>,
}

/// Rows of a block, and the time at which it begins.
struct Place {
    time: f64,
    rows: Range<usize>,
}

/// Result of the passes over the record from a start. Segments begin in states of the last pass.
pub(super) fn over_blocks(
    model: &Model,
    bounds: &Bounds,
    start: &[f64],
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<(Vec<f64>, Point)> {
    let bounds = bounds.inside(start);
    let mut found = (Vec::new(), Point::from(start.to_vec()));
    for part in PASSES {
        found = pass(model, &bounds, &found.1.values, part, go_on)?;
    }
    Ok(found)
}

/// One pass over the record, with a relative standard deviation of the parameters: the times at
/// which segments begin, and the point reached.
fn pass(
    model: &Model,
    bounds: &Bounds,
    values: &[f64],
    part: f64,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<(Vec<f64>, Point)> {
    let (sizes, count) = (model.sizes_of_states(values)?, values.len());
    let made = model.unknowns.with(values)?;
    let mut now = Estimate::at_start(&made, values, (part, &sizes))?;
    let all = now.mean.len();
    let times = &model.measured.times;
    let length = (RESIDUALS * all).div_ceil(model.measured.columns.len().max(1)).max(1);
    let (mut time, mut row) = (made.start.time - made.shift, 0);
    let (mut nodes, mut states) = (Vec::new(), Vec::new());
    let (mut since, mut is_quiet) = (0, false);
    while row < times.len() && go_on() {
        let rows = row..(row + length).min(times.len());
        row = rows.end;
        let place = Place { time, rows };
        let begin: Vec<f64> = now.mean.iter().skip(count).copied().collect();
        let (next, events) = updated((model, bounds), &now, &place, &sizes)?;
        let end = times[row - 1];
        let margin = QUIET * (end - time);
        since += 1;
        if is_quiet && since >= SEGMENT && events.iter().all(|event| *event > time + margin) {
            nodes.push(time);
            states.push(begin);
            since = 0;
        }
        is_quiet = events.iter().all(|event| *event < end - margin);
        (now, time) = (next, end);
    }
    let values: Vec<f64> = now.mean.iter().take(count).copied().collect();
    // A state found with other parameters may be behind a stop.
    let made = model.unknowns.with(&values)?;
    let begins = |(node, state): &(f64, Vec<f64>)| {
        Motion::from_state(made.assembly.clone(), node + made.shift, state).is_ok()
    };
    let (nodes, states) = nodes.into_iter().zip(states).filter(begins).unzip();
    Ok((nodes, Point { values, states }))
}

/// Least squares of one block, in units of the prior standard deviations.
struct Problem<'a> {
    model: &'a Model<'a>,
    bounds: &'a Bounds,
    prior: &'a Estimate,
    place: &'a Place,
    /// Number of parameters; the state follows them.
    count: usize,
    units: DVector<f64>,
    /// Inverse of the prior covariance.
    information: DMatrix<f64>,
}

fn not_positive() -> Error {
    Error::Described { problem: "the covariance of a block is not positive".into() }
}

impl<'a> Problem<'a> {
    fn new(
        (model, bounds): (&'a Model, &'a Bounds),
        prior: &'a Estimate,
        place: &'a Place,
        count: usize,
    ) -> Result<Self> {
        let all = prior.mean.len();
        let units = DVector::from_fn(all, |i, _| prior.covariance[(i, i)].sqrt().max(f64::MIN_POSITIVE));
        let scaled = DMatrix::from_fn(all, all, |i, j| prior.covariance[(i, j)] / (units[i] * units[j]));
        let information = scaled.cholesky().ok_or_else(not_positive)?.inverse();
        Ok(Self { model, bounds, prior, place, count, units, information })
    }

    fn block(&self, mean: &DVector<f64>) -> Result<Block> {
        block(self.model, mean, self.count, self.place)
    }

    /// Deviation of a mean from the prior mean.
    fn off(&self, mean: &DVector<f64>) -> DVector<f64> {
        (mean - &self.prior.mean).component_div(&self.units)
    }

    fn cost(&self, own: &Block, mean: &DVector<f64>) -> f64 {
        let off = self.off(mean);
        LOSS.sum(own.residuals.iter().copied()) + off.dot(&(&self.information * &off))
    }

    /// Matrix of the normal equations, and the right side from the residuals.
    fn normal(&self, at: &Block) -> (DMatrix<f64>, DVector<f64>) {
        let weights = at.residuals.map(|r| LOSS.weight(r));
        let row = |i, j| at.by[(i, j)] * weights[i] * self.units[j];
        let rows = DMatrix::from_fn(at.residuals.len(), self.units.len(), row);
        let right = rows.tr_mul(&at.residuals.component_mul(&weights));
        (&self.information + rows.tr_mul(&rows), right)
    }

    /// Mean after one damped step, within the bounds.
    fn stepped(&self, mean: &DVector<f64>, at: &Block, damping: f64) -> Result<DVector<f64>> {
        let (mut matrix, right) = self.normal(at);
        let gradient = right + &self.information * self.off(mean);
        (0..matrix.nrows()).for_each(|i| matrix[(i, i)] *= 1.0 + damping);
        let change = matrix.cholesky().ok_or_else(not_positive)?.solve(&gradient);
        let mut next = mean - change.component_mul(&self.units);
        for i in 0..self.count {
            next[i] = next[i].clamp(self.bounds.low[i], self.bounds.high[i]);
        }
        Ok(next)
    }

    /// Mean of least cost, and its block.
    fn solved(&self) -> Result<(DVector<f64>, Block)> {
        let mut mean = self.prior.mean.clone();
        let mut at = self.block(&mean)?;
        let (mut least, mut damping) = (self.cost(&at, &mean), DAMPING.0);
        for _ in 0..STEPS {
            let next = self.stepped(&mean, &at, damping)?;
            // A motion cannot begin in a state behind a stop.
            let tried = self.block(&next).ok().map(|own| (self.cost(&own, &next), own));
            let Some((cost, own)) = tried.filter(|(cost, _)| *cost < least) else {
                damping *= 10.0;
                if damping > DAMPING.1 {
                    break;
                }
                continue;
            };
            let is_done = least - cost <= REDUCTION * cost;
            (mean, at, least, damping) = (next, own, cost, f64::max(0.1 * damping, 0.01 * DAMPING.0));
            if is_done {
                break;
            }
        }
        Ok((mean, at))
    }
}

/// Estimate at the end of a block, and the times of its contact events.
fn updated(
    (model, bounds): (&Model, &Bounds),
    prior: &Estimate,
    place: &Place,
    sizes: &[f64],
) -> Result<(Estimate, Vec<f64>)> {
    let all = prior.mean.len();
    let count = all - sizes.len();
    let problem = Problem::new((model, bounds), prior, place, count)?;
    let (mut mean, at) = problem.solved()?;
    let inverse = problem.normal(&at).0.cholesky().ok_or_else(not_positive)?.inverse();
    let posterior = DMatrix::from_fn(all, all, |i, j| inverse[(i, j)] * problem.units[i] * problem.units[j]);
    let carried = DMatrix::from_fn(all, all, |i, j| match i.checked_sub(count) {
        None => f64::from(u8::from(i == j)),
        Some(k) => at.end[k].1[j].unwrap_or(0.0),
    });
    let own = &carried * posterior * carried.transpose();
    // Rounding makes the product slightly asymmetric.
    let mut covariance = 0.5 * (&own + own.transpose());
    for (k, size) in sizes.iter().enumerate() {
        mean[count + k] = at.end[k].0;
        covariance[(count + k, count + k)] += (ADDED * size).powi(2);
    }
    Ok((Estimate { mean, covariance }, at.events))
}

/// Block of samples for a motion that begins at a mean.
fn block(model: &Model, mean: &DVector<f64>, count: usize, place: &Place) -> Result<Block> {
    let (values, state) = mean.as_slice().split_at(count);
    let made: Made = model.unknowns.with(values)?;
    let columns: Columns = model.unknowns.columns(Some(state.len()));
    let time = place.time + made.shift;
    let mut motion = Differentiated::from_state(made.assembly.clone(), time, state, &columns.by)?;
    let data = &model.measured.columns;
    let all = count + state.len();
    let rows = place.rows.len() * data.len();
    // A contact closed at the begin counts as an event there.
    let is_held = motion.motion().mode().contacts().next().is_some();
    let mut events: Vec<f64> = is_held.then_some(place.time).into_iter().collect();
    let (mut residuals, mut by) = (Vec::with_capacity(rows), Vec::with_capacity(rows * all));
    for row in place.rows.clone() {
        let mut note = |event: &Event, _: &[Option<f64>]| {
            if event.contact().is_some() {
                events.push(event.time - made.shift);
            }
        };
        motion.advance_observed((model.measured.times[row] + made.shift).max(time), &mut note)?;
        for (k, (_, measured)) in data.iter().enumerate() {
            let (quantity, rate) = model.compared.quantities_of(k);
            let unit = model.deviations()[k];
            residuals.push((motion.motion().value(quantity) + made.offsets[k] - measured[row]) / unit);
            let rate = rate.map(|rate| motion.motion().value(rate));
            let own = columns.all(&|p| motion.derivative(quantity, p), rate, Some(k));
            by.extend(own.into_iter().map(|x| x.unwrap_or(0.0) / unit));
        }
    }
    let end = end_of(&motion, &columns, &Default::default());
    let own = Block {
        residuals: DVector::from_vec(residuals),
        by: DMatrix::from_row_slice(rows, all, &by),
        end,
        events,
    };
    let is_finite = own.residuals.iter().chain(own.by.iter()).all(|x| x.is_finite());
    let grows =
        || Error::Described { problem: "the motion grows beyond the range of floating-point numbers".into() };
    is_finite.then_some(own).ok_or_else(grows)
}
