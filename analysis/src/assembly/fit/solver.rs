//! Levenberg-Marquardt's method within bounds (K. Madsen, H. B. Nielsen and O. Tingleff, Methods for
//! Non-Linear Least Squares Problems, 2004), with losses by reweighting. Written here since the
//! published crates know neither bounds nor rows without a derivative.

use super::evaluated::Evaluated;
use super::model::{Horizon, Model};
use super::{FitRequest, MOST_FREE};
use crate::error::{Error, Result};
use crate::sobol;
use nalgebra::{DMatrix, DVector};

/// How far a fit over one horizon goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Convergence {
    /// A few steps: a longer horizon follows.
    Rough,
    /// Until steps are rounding.
    Whole,
}

impl Convergence {
    /// Most steps, and relative step and reduction of the cost at which it ends.
    fn limits(self) -> (u32, f64, f64) {
        match self {
            Self::Rough => (20, 1e-6, 1e-6),
            Self::Whole => (60, 1e-10, 1e-13),
        }
    }
}

/// First damping, and the largest, at which no step helps.
const DAMPING: f64 = 1e-3;
const MOST_DAMPING: f64 = 1e12;

/// How a residual counts, by its square z in units of the standard deviation's square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Loss {
    /// z.
    #[default]
    Linear,
    /// 2 (√(1 + z) - 1).
    SoftL1,
    /// z up to 1, then 2 √z - 1.
    Huber,
}

impl Loss {
    /// The loss of a residual and its derivative by z.
    fn of(self, residual: f64) -> (f64, f64) {
        let z = residual * residual;
        match self {
            Self::Linear => (z, 1.0),
            Self::SoftL1 => (2.0 * ((1.0 + z).sqrt() - 1.0), 1.0 / (1.0 + z).sqrt()),
            Self::Huber if z <= 1.0 => (z, 1.0),
            Self::Huber => (2.0 * z.sqrt() - 1.0, 1.0 / z.sqrt()),
        }
    }

    /// The sum over residuals.
    pub fn sum(self, residuals: &[f64]) -> f64 {
        residuals.iter().map(|r| self.of(*r).0).sum()
    }

    /// The factor of a residual and its row of derivatives in a step.
    pub fn weight(self, residual: f64) -> f64 {
        self.of(residual).1.sqrt()
    }
}

/// Ranges of the free numbers, and where they begin.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    pub begin: Vec<f64>,
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    names: Vec<String>,
    given: Vec<bool>,
}

impl Bounds {
    pub fn of(request: &FitRequest, model: &Model) -> Result<Self> {
        let refused = |problem: String| Err(Error::Described { problem });
        let free = &request.free;
        if free.is_empty() || free.len() > MOST_FREE {
            return refused(format!("{} free numbers: allowed are 1 to {MOST_FREE}", free.len()));
        }
        if let Some(i) = (1..free.len()).find(|&i| free[..i].iter().any(|own| own.name == free[i].name)) {
            return refused(format!("{} is free twice; allowed is each number once", free[i].name));
        }
        if model.rows() < free.len() {
            return refused(format!(
                "the record has {} samples for {} free numbers; allowed are at least as many samples",
                model.rows(),
                free.len()
            ));
        }
        let begin = model.unknowns.begin.clone();
        let (mut low, mut high) = (Vec::new(), Vec::new());
        for (k, own) in free.iter().enumerate() {
            let (least, most) = own.within.unwrap_or_else(|| model.unknowns.allowed(k));
            if least >= most || least.is_nan() || most.is_nan() {
                return refused(format!(
                    "{} within {least} to {most}: allowed is a range with length",
                    own.name
                ));
            }
            if !(least..=most).contains(&begin[k]) {
                return refused(format!(
                    "{} begins at {}, outside {least} to {most}; allowed is a range that contains it",
                    own.name, begin[k]
                ));
            }
            low.push(least);
            high.push(most);
        }
        let names = free.iter().map(|own| own.name.clone()).collect();
        let given = free.iter().map(|own| own.within.is_some()).collect();
        Ok(Self { begin, low, high, names, given })
    }

    /// Point `k` of the Sobol sequence within the bounds.
    pub fn within(&self, k: u32) -> Result<Vec<f64>> {
        let at = |i: usize| {
            if !self.given[i] {
                let problem = format!(
                    "--starts needs a range of each free number; allowed is --within {}=LOW:HIGH",
                    self.names[i]
                );
                return Err(Error::Described { problem });
            }
            Ok(self.low[i] + (self.high[i] - self.low[i]) * sobol::coordinate(k, i))
        };
        (0..self.begin.len()).map(at).collect()
    }

    /// Point `k` of the Sobol sequence around a start, within a part of its values and the bounds.
    pub fn beside(&self, start: &[f64], k: u32, part: f64) -> Vec<f64> {
        let at = |i: usize| {
            let moved = start[i] * (1.0 + part * (2.0 * sobol::coordinate(k, i) - 1.0));
            moved.clamp(self.low[i], self.high[i])
        };
        (0..start.len()).map(at).collect()
    }

    /// Whether a number lies at a bound beyond which a step would lead.
    fn holds(&self, i: usize, value: f64, step: f64) -> bool {
        (value <= self.low[i] && step < 0.0) || (value >= self.high[i] && step > 0.0)
    }
}

/// Values reached, with the sum of losses.
pub(super) struct Solved {
    pub values: Vec<f64>,
    pub cost: f64,
}

/// The step from values: minus the solution of the damped normal equations, over the numbers that no
/// bound holds.
fn step(
    at: &Evaluated,
    loss: Loss,
    sizes: &DVector<f64>,
    damping: f64,
    held: &[bool],
) -> Option<DVector<f64>> {
    let (m, count) = (at.residuals.len(), held.len());
    let free: Vec<usize> = (0..count).filter(|&j| !held[j]).collect();
    let mut matrix = DMatrix::zeros(m + free.len(), free.len());
    let mut right = DVector::zeros(m + free.len());
    for i in 0..m {
        let weight = loss.weight(at.residuals[i]);
        right[i] = -weight * at.residuals[i];
        free.iter().enumerate().for_each(|(c, &j)| matrix[(i, c)] = weight * at.jacobian[(i, j)]);
    }
    free.iter().enumerate().for_each(|(c, &j)| matrix[(m + c, c)] = damping.sqrt() * sizes[j]);
    let qr = matrix.qr();
    qr.q_tr_mul(&mut right);
    let part = qr.r().solve_upper_triangular(&right.rows(0, free.len()).into_owned())?;
    let mut whole = DVector::zeros(count);
    free.iter().zip(part.iter()).for_each(|(&j, x)| whole[j] = *x);
    whole.iter().all(|x| x.is_finite()).then_some(whole)
}

/// The gradient of the cost, halved.
fn gradient(at: &Evaluated, loss: Loss) -> DVector<f64> {
    let weighted = at.residuals.iter().map(|r| r * loss.weight(*r).powi(2));
    at.jacobian.tr_mul(&DVector::from_iterator(at.residuals.len(), weighted))
}

/// The values with the least cost near given ones, over a horizon.
pub(super) fn solve(
    model: &Model,
    bounds: &Bounds,
    begin: &[f64],
    (horizon, convergence): (Horizon, Convergence),
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Solved> {
    let (loss, mut values) = (model.loss, begin.to_vec());
    let mut at = model.evaluate(&values, horizon)?;
    let mut cost = loss.sum(&at.residuals);
    let (mut damping, mut growth) = (DAMPING, 2.0);
    let mut sizes = DVector::<f64>::zeros(values.len());
    let (steps, least_step, least_reduction) = convergence.limits();
    for _ in 0..steps {
        if !go_on() {
            break;
        }
        for (j, size) in sizes.iter_mut().enumerate() {
            *size = size.max(at.jacobian.column(j).norm()).max(f64::MIN_POSITIVE);
        }
        let down = -gradient(&at, loss);
        // A number that moves nothing so far is kept.
        let is_idle = |j: usize| at.jacobian.column(j).amax() == 0.0;
        let held = (0..values.len()).map(|j| is_idle(j) || bounds.holds(j, values[j], down[j]));
        let held: Vec<bool> = held.collect();
        if held.iter().all(|held| *held) {
            break;
        }
        let Some(mut way) = step(&at, loss, &sizes, damping, &held) else { break };
        let next: Vec<f64> =
            (0..values.len()).map(|j| (values[j] + way[j]).clamp(bounds.low[j], bounds.high[j])).collect();
        (0..values.len()).for_each(|j| way[j] = next[j] - values[j]);
        let relative = (0..values.len()).map(|j| (way[j] * sizes[j]).powi(2)).sum::<f64>().sqrt();
        let whole = (0..values.len()).map(|j| (values[j] * sizes[j]).powi(2)).sum::<f64>().sqrt();
        if relative <= least_step * whole {
            break;
        }
        let linear = &at.jacobian * &way;
        let fall = |(r, dr): (&f64, &f64)| loss.weight(*r).powi(2) * (r * r - (r + dr).powi(2));
        let predicted: f64 = at.residuals.iter().zip(linear.iter()).map(fall).sum();
        // A motion that breaks off costs more than any.
        let tried = model.evaluate(&next, horizon).ok();
        let after = tried.as_ref().map_or(f64::INFINITY, |tried| loss.sum(&tried.residuals));
        if after < cost {
            let ratio = (cost - after) / predicted.max(f64::MIN_POSITIVE);
            let is_done = cost - after <= least_reduction * cost;
            (values, cost) = (next, after);
            at = tried.unwrap_or(at);
            damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0);
            growth = 2.0;
            if is_done {
                break;
            }
        } else {
            damping *= growth;
            growth *= 2.0;
            if damping > MOST_DAMPING {
                break;
            }
        }
    }
    Ok(Solved { values, cost })
}
