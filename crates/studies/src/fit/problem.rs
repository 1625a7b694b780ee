//! Least-squares problem of one record or of several records together, as the solver, the profile
//! of the cost and the restarts require it.

use super::evaluated::{Evaluated, Point, Reach, Solved};
use super::loss::Loss;
use super::model::Model;
use crate::QuantityName;
use crate::error::Result;

/// A least-squares problem.
pub(super) trait Problem: Sync {
    /// Loss function of the residuals.
    fn loss(&self) -> Loss;
    /// Whether the standard deviations of the noise are given.
    fn has_sigma(&self) -> bool;
    /// Number of residuals.
    fn rows(&self) -> usize;
    /// Whether the machine has stops.
    fn has_stops(&self) -> bool;
    /// Whether the problem has only contact times.
    fn is_of_contacts(&self) -> bool;
    /// Number of simulations so far.
    fn simulations(&self) -> u32;
    /// Residuals and derivatives at a point.
    fn evaluate(&self, point: &Point, reach: &Reach) -> Result<Evaluated>;
    /// Sum of losses at a point.
    fn cost(&self, solved: &Solved) -> Result<f64>;
    /// Whether residuals exceed what chance permits for white noise.
    fn misses(&self, point: &Point, reach: &Reach) -> Result<bool>;
    /// Half the range of the quantity whose initial value is the free parameter `j`; `None` if the
    /// parameter is not an initial value.
    fn size_of_start(&self, j: usize, values: &[f64]) -> Option<f64>;
    /// Reports the cost of a step.
    fn tell(&self, cost: f64, reach: &Reach);

    /// Variance of residuals in units of the squared standard deviations, from the least cost. If
    /// the loss is robust, outliers dominate the cost, and the standard deviations are from
    /// residuals.
    fn variance(&self, cost: f64, free: usize) -> f64 {
        if self.has_sigma() || self.loss() != Loss::Linear {
            1.0
        } else {
            cost / self.rows().saturating_sub(free).max(1) as f64
        }
    }
}

impl Problem for Model<'_> {
    fn loss(&self) -> Loss {
        self.loss
    }

    fn has_sigma(&self) -> bool {
        self.has_sigma
    }

    fn rows(&self) -> usize {
        Model::rows(self)
    }

    fn has_stops(&self) -> bool {
        Model::has_stops(self)
    }

    fn is_of_contacts(&self) -> bool {
        Model::is_of_contacts(self)
    }

    fn simulations(&self) -> u32 {
        self.compared.simulations()
    }

    fn evaluate(&self, point: &Point, reach: &Reach) -> Result<Evaluated> {
        Model::evaluate(self, point, reach)
    }

    fn cost(&self, solved: &Solved) -> Result<f64> {
        Model::cost(self, solved)
    }

    fn misses(&self, point: &Point, reach: &Reach) -> Result<bool> {
        Model::misses(self, point, reach)
    }

    fn size_of_start(&self, j: usize, values: &[f64]) -> Option<f64> {
        // `body.box.start.v` and `start.box.v` are initial values of `box.v`.
        let name = self.unknowns.name(j)?;
        let of_body = name.strip_prefix("body.").and_then(|name| name.split_once(".start."));
        let of_start = || name.strip_prefix("start.")?.rsplit_once('.');
        let (body, what) = of_body.or_else(of_start)?;
        let made = self.unknowns.with(values).ok()?;
        let named: QuantityName = format!("body.{body}.{what}").parse().ok()?;
        let quantity = named.find(&made.machine.description).ok()?.quantity;
        let mut motion = made.start.motion(made.assembly.clone()).ok()?;
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for time in self.times() {
            motion.advance_to((time + made.shift).max(motion.time())).ok()?;
            let value = motion.value(quantity);
            (low, high) = (low.min(value), high.max(value));
        }
        Some(0.5 * (high - low)).filter(|size| *size > 0.0 && size.is_finite())
    }

    fn tell(&self, cost: f64, reach: &Reach) {
        let is_whole = reach.nodes.is_empty() && reach.end >= self.end();
        self.watch.cost(cost, is_whole && !self.is_part);
    }
}
