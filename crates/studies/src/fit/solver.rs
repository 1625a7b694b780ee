//! Levenberg-Marquardt method within bounds (K. Madsen, H. B. Nielsen and O. Tingleff, Methods for
//! Non-Linear Least Squares Problems, 2004), with losses by reweighting. Published crates support
//! neither bounds nor rows without a derivative.

use super::bounds::Bounds;
use super::elimination::Triangle;
use super::evaluated::{Change, Evaluated, Point, Reach, Solved};
use super::loss::Loss;
use super::problem::Problem;
use crate::error::Result;
use nalgebra::DVector;

/// Convergence criterion over one horizon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Convergence {
    /// A few steps: a longer horizon follows.
    Rough,
    /// Restart near a fitted point, where residuals are nearly linear; ends at this cost.
    Back(f64),
    /// Until steps are as small as rounding errors.
    Whole,
}

impl Convergence {
    /// Cap on the steps, and the relative step and cost reduction below which the descent ends.
    fn limits(self) -> (u32, f64, f64) {
        match self {
            Self::Rough | Self::Back(_) => (20, 1e-5, 1e-5),
            Self::Whole => (60, 1e-10, 1e-13),
        }
    }

    /// Initial damping.
    fn damping(self) -> f64 {
        match self {
            Self::Rough | Self::Whole => 1e-3,
            Self::Back(_) => 1e-9,
        }
    }
}

/// Largest relative change of a parameter in a step if only contacts are matched, since contacts
/// appear and disappear.
const STEP: f64 = 0.2;
/// Largest damping; no step improves the cost there.
const MOST_DAMPING: f64 = 1e12;

/// Updates the scales: the largest lengths of the columns of derivatives so far.
fn include(sizes: &mut Change, at: &Evaluated) {
    for (j, size) in sizes.values.iter_mut().enumerate() {
        let length = at.0.iter().map(|own| own.rows.by_numbers.column(j).norm_squared()).sum::<f64>().sqrt();
        *size = size.max(length).max(f64::MIN_POSITIVE);
    }
    // Defects are left out: they would damp a state towards its neighbours.
    for (sizes, own) in sizes.states.iter_mut().zip(&at.0[1..]) {
        for (i, size) in sizes.iter_mut().enumerate() {
            *size = size.max(own.rows.by_state.column(i).norm()).max(f64::MIN_POSITIVE);
        }
    }
}

/// Half the negative gradient of the cost with respect to the free parameters.
fn down(at: &Evaluated, loss: Loss) -> DVector<f64> {
    let mut sum = DVector::zeros(at.0[0].rows.by_numbers.ncols());
    for own in &at.0 {
        let weighted = own.rows.residuals.iter().map(|r| r * loss.weight(*r).powi(2));
        sum -= own.rows.by_numbers.tr_mul(&DVector::from_iterator(own.rows.residuals.len(), weighted));
        if let Some(rows) = &own.defect {
            sum -= rows.by_numbers.tr_mul(&DVector::from_column_slice(&rows.residuals));
        }
    }
    sum
}

/// Decrease in cost predicted for a change by the linear model.
fn predicted(at: &Evaluated, loss: Loss, change: &Change) -> f64 {
    let numbers = DVector::from_column_slice(&change.values);
    let empty = Vec::new();
    let mut sum = 0.0;
    for (k, own) in at.0.iter().enumerate() {
        let state = k.checked_sub(1).map_or(&empty, |k| &change.states[k]);
        let state = DVector::from_column_slice(state);
        let moved = |rows: &super::evaluated::Rows| &rows.by_numbers * &numbers + &rows.by_state * &state;
        let fall = |(r, dr): (&f64, &f64)| loss.weight(*r).powi(2) * (r * r - (r + dr).powi(2));
        sum += own.rows.residuals.iter().zip(moved(&own.rows).iter()).map(fall).sum::<f64>();
        if let Some(rows) = &own.defect {
            let next = change.states[k].iter().zip(&own.weights).map(|(x, weight)| x * weight);
            let moved = moved(rows);
            let all = rows.residuals.iter().zip(moved.iter().zip(next));
            sum += all.map(|(r, (dr, next))| r * r - (r + dr - next).powi(2)).sum::<f64>();
        }
    }
    sum
}

/// Cost of a point, including defects.
fn cost_of(at: &Evaluated, loss: Loss) -> f64 {
    loss.sum(at.residuals()) + at.defects()
}

/// Factor for the damping after a step, from the ratio of actual to predicted decrease in cost
/// (Madsen et al., algorithm 3.16).
fn damped(ratio: f64) -> f64 {
    (1.0 - (2.0 * ratio - 1.0).powi(3)).clamp(1.0 / 3.0, 2.0)
}

/// Point of least cost near a given one.
pub(super) fn solve(
    model: &dyn Problem,
    bounds: &Bounds,
    begin: &Point,
    (reach, convergence): (&Reach, Convergence),
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Solved> {
    let rough = (convergence == Convergence::Rough).then(|| bounds.near(&bounds.begin));
    let bounds = rough.as_ref().unwrap_or(bounds);
    let (loss, mut point) = (model.loss(), begin.clone());
    let mut at = model.evaluate(&point, reach)?;
    let mut cost = cost_of(&at, loss);
    let (mut damping, mut growth) = (convergence.damping(), 2.0);
    let mut sizes = Point {
        values: vec![0.0; point.values.len()],
        states: point.states.iter().map(|state| vec![0.0; state.len()]).collect(),
    };
    let (steps, least_step, least_reduction) = convergence.limits();
    for _ in 0..steps {
        model.tell(cost, reach);
        if !go_on() {
            break;
        }
        include(&mut sizes, &at);
        let down = down(&at, loss);
        // A parameter without effect so far is held.
        let held = (0..point.values.len())
            .map(|j| at.is_idle(j, point.values[j]) || bounds.holds(j, point.values[j], down[j]));
        let held: Vec<bool> = held.collect();
        if point.states.is_empty() && held.iter().all(|held| *held) {
            break;
        }
        let way = Triangle::of(&at, loss, &sizes, damping, &held).step(point.values.len());
        let Some(mut way) = way else { break };
        if model.is_of_contacts() {
            way.limit(&point.values, STEP);
        }
        let next = bounds.moved(&point, &mut way);
        let expected = predicted(&at, loss, &way);
        if way.length(&sizes) <= least_step * point.length(&sizes) || expected <= least_reduction * cost {
            break;
        }
        // A motion that cannot be simulated has infinite cost.
        let tried = model.evaluate(&next, reach).ok();
        let after = tried.as_ref().map_or(f64::INFINITY, |tried| cost_of(tried, loss));
        if after < cost {
            let ratio = (cost - after) / expected.max(f64::MIN_POSITIVE);
            let is_done = cost - after <= least_reduction * cost;
            (point, cost) = (next, after);
            at = tried.unwrap_or(at);
            damping *= damped(ratio);
            growth = 2.0;
            if is_done || matches!(convergence, Convergence::Back(enough) if cost <= enough) {
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
    Ok(Solved { point, reach: reach.clone(), cost: loss.sum(at.residuals()), is_continuous: true })
}

#[cfg(test)]
mod tests {
    use super::damped;

    #[test]
    fn closed_form_a_step_as_predicted_thirds_the_damping_and_half_as_good_a_step_keeps_it() {
        assert_eq!([1.0, 0.5, 0.0].map(damped), [1.0 / 3.0, 1.0, 2.0]);
        // (2 · 0.75 - 1)³ is an eighth.
        assert_eq!([0.75, 0.25].map(damped), [0.875, 1.125]);
    }
}
