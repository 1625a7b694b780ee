//! Derivatives of outputs with respect to time, states, inputs and parameters, at the present
//! instant and in the present mode.

use super::Machine;
use crate::problem::MachineProblem;
use crate::table::{Quantity, Role, VariableRow};
use fmi_doors::{Bases, Interface, Phase, Problem};
use std::f64::consts::TAU;
use vibro_machine::derivative::By;
use vibro_machine::{Differentiated, Motion};

/// Highest order of time derivatives of outputs.
pub(crate) const OUTPUT_ORDER: u32 = 3;

/// A direction in the space of knowns.
struct Along {
    states: Vec<f64>,
    inputs: Vec<f64>,
    /// Index of each varied parameter, with the component of the direction along it.
    parameters: Vec<(usize, f64)>,
    time: f64,
}

/// Derivatives with respect to parameters and time, each with its weight.
struct Partial {
    of: Differentiated,
    weights: Vec<f64>,
}

impl Partial {
    /// The weighted sum for a quantity; NaN if a derivative does not exist.
    fn of(&self, quantity: vibro_machine::Quantity) -> f64 {
        let term = |(p, weight): (usize, &f64)| match *weight {
            0.0 => 0.0,
            weight => weight * self.of.derivative_in_mode(quantity, p).unwrap_or(f64::NAN),
        };
        self.weights.iter().enumerate().map(term).sum()
    }
}

impl Machine {
    /// Returns the row of a variable that is a quantity of a body or an element; only these have
    /// derivatives.
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
            by_order[order as usize - 1]
                .as_ref()
                .map_or(Ok(0.0), |motion| self.derivative(motion, reference, &None))
        });
        let derivatives = derivatives.collect::<Result<Vec<_>, _>>()?;
        derivatives.into_iter().enumerate().for_each(|(i, derivative)| write(i, derivative));
        Ok(())
    }

    /// Computes the derivatives of unknowns along a direction of inputs, in Model Exchange also of
    /// states, and in FMI 3.0 of tunable parameters and time, with the states fixed.
    pub(super) fn derivatives_along(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), MachineProblem> {
        let along = self.seeded(knowns, seed)?;
        for &unknown in unknowns {
            self.linear(unknown, "derivatives of other variables than coordinates, elongations and forces")?;
        }
        let motion = self.present()?.motion.clone();
        let varied = motion.variation(&along.states, &along.inputs);
        let further = self.partial(motion, &along)?;
        let derivative = |&unknown: &u32| self.derivative(&varied, unknown, &further);
        let derivatives = unknowns.iter().map(derivative).collect::<Result<Vec<_>, _>>()?;
        derivatives.into_iter().enumerate().for_each(|(i, derivative)| write(i, derivative));
        Ok(())
    }

    /// Returns the direction of a seed.
    fn seeded(&self, knowns: &[u32], seed: &[f64]) -> Result<Along, MachineProblem> {
        let exchange = self.life.interface == Interface::ModelExchange;
        let moves = self.plan.knows_parameters
            && !matches!(self.life.phase, Phase::Instantiated | Phase::Initialization);
        let mut along = Along {
            states: vec![0.0; self.plan.size],
            inputs: vec![0.0; self.pending.len()],
            parameters: Vec::new(),
            time: 0.0,
        };
        for (&known, &part) in knowns.iter().zip(seed) {
            let row = self.plan.table.row(known, Bases::ANY)?;
            if !part.is_finite() {
                return Err(Problem::value(format!("seed of {}", row.name), part, "a finite number").into());
            }
            match (row.quantity, self.state_of(row.quantity).filter(|_| exchange)) {
                (Quantity::Input(i), _) => along.inputs[i] += part,
                (_, Some(place)) => along.states[self.plan.places[place]] += part,
                (Quantity::Parameter(i), _) if moves && row.role == Role::Tunable => {
                    along.parameters.push((i, part));
                }
                (Quantity::Time, _) if moves => along.time += part,
                _ => {
                    let what = match (exchange, moves) {
                        (true, true) => {
                            "derivatives with respect to other variables than states, inputs, tunable parameters and time"
                        }
                        (false, true) => {
                            "derivatives with respect to other variables than inputs, tunable parameters and time"
                        }
                        (true, false) => "derivatives with respect to other variables than states and inputs",
                        (false, false) => "derivatives with respect to other variables than inputs",
                    };
                    return Err(Problem::NotOffered { what }.into());
                }
            }
        }
        Ok(along)
    }

    /// Returns the derivatives of a motion's values with respect to the parameters and the time in
    /// a direction, each with its weight.
    fn partial(&self, motion: Motion, along: &Along) -> Result<Option<Partial>, MachineProblem> {
        if along.parameters.is_empty() && along.time == 0.0 {
            return Ok(None);
        }
        let time = motion.time();
        let terms = along.parameters.iter().flat_map(|&(i, part)| {
            self.direction(i, time).into_iter().map(move |(name, weight)| (By::from(name), weight * part))
        });
        let terms: Vec<(By, f64)> = terms.chain([(By::Time, along.time)]).collect();
        let (columns, weights): (Vec<By>, _) = terms.into_iter().unzip();
        Ok(Some(Partial { of: Differentiated::at_fixed_state(motion, &columns)?, weights }))
    }

    /// Returns the parameters that change with parameter `i` at a time, each with its change per
    /// change of parameter `i`. If the frequency of a harmonic changes, its phase parameter
    /// changes too, so that its present phase stays.
    pub(super) fn direction(&self, i: usize, time: f64) -> Vec<(&str, f64)> {
        let name = |i: usize| self.plan.table.parameters[i].name.as_str();
        match name(i).ends_with(".frequency") {
            true => vec![(name(i), 1.0), (name(i + 1), -TAU * time)],
            false => vec![(name(i), 1.0)],
        }
    }

    /// Returns the derivative of a quantity of a body or an element, from a motion `of` whose
    /// states are the derivatives of the states. Error if the derivative is not finite.
    fn derivative(
        &self,
        of: &Motion,
        reference: u32,
        further: &Option<Partial>,
    ) -> Result<f64, MachineProblem> {
        let row = self.plan.table.row(reference, Bases::ANY)?;
        let value = match row.quantity {
            Quantity::Column(column) => {
                of.value_varied(column) + further.as_ref().map_or(0.0, |further| further.of(column))
            }
            _ => 0.0,
        } + 0.0;
        if value.is_finite() {
            return Ok(value);
        }
        let allowed = "a finite number; seed, states or inputs are too large together";
        Err(Problem::value(format!("derivative of {}", row.name), value, allowed).into())
    }
}
