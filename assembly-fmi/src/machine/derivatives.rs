//! Derivatives of outputs with respect to time, states and inputs, at the present instant and in the mode in force.

use super::Machine;
use crate::problem::MachineProblem;
use crate::table::{Quantity, Row};
use fmi_doors::{Bases, Interface, Problem};

/// Highest order of time derivatives of outputs.
pub(crate) const OUTPUT_ORDER: u32 = 3;

impl Machine {
    /// The row of a variable whose value is linear in states and signals.
    fn linear(&self, reference: u32, what: &'static str) -> Result<&Row, MachineProblem> {
        let row = self.plan.table.row(reference, Bases::ANY)?;
        match row.quantity {
            Quantity::Body(..)
            | Quantity::Spring(..)
            | Quantity::Stop(..)
            | Quantity::Friction(..)
            | Quantity::Load(_) => Ok(row),
            _ => Err(Problem::NotOffered { what }.into()),
        }
    }

    pub(super) fn time_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), MachineProblem> {
        for (&reference, &order) in references.iter().zip(orders) {
            let row = self.linear(
                reference,
                "time derivatives of other variables than coordinates, elongations and forces",
            )?;
            if !(1..=OUTPUT_ORDER as i32).contains(&order) {
                let what = format!("order of the derivative of {}", row.name);
                return Err(Problem::value(what, f64::from(order), "1, 2 or 3").into());
            }
        }
        let motion = self.present()?.motion.clone();
        let by_order: Vec<_> = (1..=OUTPUT_ORDER as usize)
            .map(|order| orders.contains(&(order as i32)).then(|| motion.time_derivative(order)))
            .collect();
        for (i, (&reference, &order)) in references.iter().zip(orders).enumerate() {
            let quantity = self.plan.table.row(reference, Bases::ANY)?.quantity;
            let derivative = by_order[order as usize - 1].as_ref();
            write(i, derivative.map_or(0.0, |motion| super::moving::linear(motion, quantity)) + 0.0);
        }
        Ok(())
    }

    /// The derivatives of unknowns along a direction of inputs and, in Model Exchange, states.
    pub(super) fn derivatives_along(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), MachineProblem> {
        let exchange = self.life.interface == Interface::ModelExchange;
        let bodies = self.plan.assembly.states();
        let (mut states, mut inputs) = (vec![0.0; 2 * bodies.len()], vec![0.0; self.pending.len()]);
        for (&known, &part) in knowns.iter().zip(seed) {
            let state = |body: usize| bodies.iter().position(|&state| state == body).filter(|_| exchange);
            match self.plan.table.row(known, Bases::ANY)?.quantity {
                Quantity::Input(i) => inputs[i] += part,
                Quantity::Body(body, order) if order < 2 && state(body).is_some() => {
                    states[order * bodies.len() + state(body).unwrap_or_default()] += part;
                }
                _ if exchange => {
                    let what = "derivatives with respect to other variables than states and inputs";
                    return Err(Problem::NotOffered { what }.into());
                }
                _ => {
                    let what = "derivatives with respect to other variables than inputs";
                    return Err(Problem::NotOffered { what }.into());
                }
            }
        }
        for &unknown in unknowns {
            self.linear(unknown, "derivatives of other variables than coordinates, elongations and forces")?;
        }
        let varied = self.present()?.motion.variation(&states, &inputs);
        for (i, &unknown) in unknowns.iter().enumerate() {
            let quantity = self.plan.table.row(unknown, Bases::ANY)?.quantity;
            write(i, super::moving::linear(&varied, quantity) + 0.0);
        }
        Ok(())
    }
}
