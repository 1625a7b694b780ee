//! Dependencies and derivatives (FMI 3.0.2, 2.2.9, 2.2.12 and 4.1.2).

use super::instance::Instance;
use super::problem::Outcome;
use super::types::FmiDependencyKind;
use crate::component::variables::DependencyKind;
use crate::component::{self, Dependency};

/// How far beyond a stop a solver may look, in gaps from the middle: farther out it does not look for an impact, but has gone
/// astray.
const REACH: f64 = 10.0;

/// `fmi3DependencyKind` of a kind.
pub fn number(kind: DependencyKind) -> FmiDependencyKind {
    match kind {
        DependencyKind::Constant => 1,
        DependencyKind::Fixed => 2,
        DependencyKind::Tunable => 3,
        DependencyKind::Discrete => 4,
        DependencyKind::Dependent => 5,
    }
}

impl Instance {
    /// `fmi3GetDirectionalDerivative` (FMI 3.0.2, 2.2.12).
    ///
    /// # Errors
    /// As [`directional_derivative`](crate::component::Instance::directional_derivative).
    pub fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        write: impl FnMut(usize, f64),
    ) -> Outcome {
        Ok(self.component.directional_derivative(unknowns, knowns, seed, write)?)
    }

    /// `fmi3GetOutputDerivatives` (FMI 3.0.2, 4.1.2).
    ///
    /// # Errors
    /// As [`output_derivatives`](crate::component::Instance::output_derivatives).
    pub fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        write: impl FnMut(usize, f64),
    ) -> Outcome {
        self.check_get()?;
        Ok(self.component.output_derivatives(references, orders, write)?)
    }

    /// `fmi3SetContinuousStates` (FMI 3.0.2, 3.2.1).
    ///
    /// # Errors
    /// As [`set_continuous_states`](crate::component::Instance::set_continuous_states), and for a block too far beyond a stop;
    /// nothing has changed then.
    pub fn set_continuous_states(&mut self, states: &[f64; 6]) -> Outcome {
        let w = states[1] - states[0];
        if w.abs() > REACH * self.component.settings().parameters.stop_gap {
            let allowed = "up to 10 times stop.gap, so that a solver can look beyond an impact";
            return Err(component::Problem::Value { name: "stop.s", value: w, allowed }.into());
        }
        Ok(self.component.set_continuous_states(states)?)
    }

    /// `fmi3GetAdjointDerivative` (FMI 3.0.2, 2.2.12).
    ///
    /// # Errors
    /// As [`directional_derivative`](Self::directional_derivative).
    pub fn adjoint_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        mut write: impl FnMut(usize, f64),
    ) -> Outcome {
        for (k, known) in knowns.iter().enumerate() {
            let mut sum = 0.0;
            self.directional_derivative(unknowns, &[*known], &[1.0], |i, x| sum += seed[i] * x)?;
            write(k, sum);
        }
        Ok(())
    }

    /// What a variable depends on now, by `fmi3GetVariableDependencies` (FMI 3.0.2, 2.2.9).
    ///
    /// # Errors
    /// As [`dependencies`](component::Instance::dependencies).
    pub fn dependencies(&self, reference: u32) -> Outcome<Vec<Dependency>> {
        Ok(self.component.dependencies(reference)?)
    }
}
