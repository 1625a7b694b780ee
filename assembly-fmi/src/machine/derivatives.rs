//! Derivatives of outputs with respect to time, states and inputs, at the present instant and in
//! the mode in force.

use super::Machine;
use crate::problem::MachineProblem;
use crate::table::{Quantity, VariableRow};
use fmi_doors::{Bases, Interface, Problem};
use vibro_assembly::Motion;

/// Highest order of time derivatives of outputs.
pub(crate) const OUTPUT_ORDER: u32 = 3;

impl Machine {
    /// The row of a variable whose value is linear in states and signals.
    fn linear(&self, reference: u32, what: &'static str) -> Result<&VariableRow, MachineProblem> {
        let row = self.plan.table.row(reference, Bases::ANY)?;
        match row.quantity {
            Quantity::Column(_) => Ok(row),
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
        let derivatives = references.iter().zip(orders).map(|(&reference, &order)| {
            by_order[order as usize - 1].as_ref().map_or(Ok(0.0), |motion| self.derivative(motion, reference))
        });
        let derivatives = derivatives.collect::<Result<Vec<_>, _>>()?;
        derivatives.into_iter().enumerate().for_each(|(i, derivative)| write(i, derivative));
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
        let count = self.plan.nominals.len();
        let (mut states, mut inputs) = (vec![0.0; count], vec![0.0; self.pending.len()]);
        for (&known, &part) in knowns.iter().zip(seed) {
            if !part.is_finite() {
                let what = format!("seed of {}", self.plan.table.row(known, Bases::ANY)?.name);
                return Err(Problem::value(what, part, "a finite number").into());
            }
            let quantity = self.plan.table.row(known, Bases::ANY)?.quantity;
            match (quantity, self.state_of(quantity).filter(|_| exchange)) {
                (Quantity::Input(i), _) => inputs[i] += part,
                (_, Some(place)) => states[place] += part,
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
        let derivatives = unknowns.iter().map(|&unknown| self.derivative(&varied, unknown));
        let derivatives = derivatives.collect::<Result<Vec<_>, _>>()?;
        derivatives.into_iter().enumerate().for_each(|(i, derivative)| write(i, derivative));
        Ok(())
    }

    /// What a variable that is linear in the motion reads of a derivative of the motion, which is
    /// to be finite.
    fn derivative(&self, of: &Motion, reference: u32) -> Result<f64, MachineProblem> {
        let row = self.plan.table.row(reference, Bases::ANY)?;
        let value = match row.quantity {
            Quantity::Column(column) => of.value_varied(column),
            _ => 0.0,
        } + 0.0;
        if value.is_finite() {
            return Ok(value);
        }
        let allowed = "a finite number: seed, states or inputs are too large together";
        Err(Problem::value(format!("derivative of {}", row.name), value, allowed).into())
    }
}
