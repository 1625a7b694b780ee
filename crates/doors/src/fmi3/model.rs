//! Functions about the model: Model Exchange, derivatives and dependencies (FMI 3.0.2, 2.2.9,
//! 2.2.12, 3.2.1 and 4.1.2).

use super::instance::Instance;
use super::problem::{CallProblem, Outcome};
use crate::component::Component;
use crate::ffi::pointers::check_count;
use crate::problem::Refusal;
use crate::values::Dependency;

impl<C: Component> Instance<C> {
    /// `fmi3GetDirectionalDerivative` (FMI 3.0.2, 2.2.12), with the numbers of elements of seed
    /// and sensitivity.
    ///
    /// # Errors
    /// If the numbers of elements differ from the numbers of knowns and unknowns; otherwise as
    /// [`directional_derivative`](crate::Model::directional_derivative).
    pub fn directional_derivative(
        &mut self,
        (unknowns, knowns): (&[u32], &[u32]),
        (seed, sensitivity): (&[f64], usize),
        write: impl FnMut(usize, f64),
    ) -> Outcome<C> {
        check_count("nSeed", seed.len(), knowns.len())?;
        check_count("nSensitivity", sensitivity, unknowns.len())?;
        Ok(self.component.directional_derivative(unknowns, knowns, seed, write)?)
    }

    /// `fmi3GetAdjointDerivative` (FMI 3.0.2, 2.2.12), with the numbers of elements of seed and
    /// sensitivity. For each known it gives the sum over the unknowns of the seed times the
    /// derivative with respect to the known.
    ///
    /// # Errors
    /// As [`directional_derivative`](Self::directional_derivative), and if a seed or a sum is not
    /// finite. Then nothing is written.
    pub fn adjoint_derivative(
        &mut self,
        (unknowns, knowns): (&[u32], &[u32]),
        (seed, sensitivity): (&[f64], usize),
        mut write: impl FnMut(usize, f64),
    ) -> Outcome<C> {
        check_count("nSeed", seed.len(), unknowns.len())?;
        check_count("nSensitivity", sensitivity, knowns.len())?;
        for (unknown, &part) in unknowns.iter().zip(seed) {
            if !part.is_finite() {
                let what = format!("seed of {}", self.component.variable(*unknown)?.name);
                return Err(refused(what, part, "a finite number"));
            }
        }
        let mut sums = vec![0.0; knowns.len()];
        for (known, sum) in knowns.iter().zip(&mut sums) {
            let part = |i: usize, x: f64| *sum += seed[i] * x;
            self.component.directional_derivative(unknowns, &[*known], &[1.0], part)?;
            if !sum.is_finite() {
                let what = format!("adjoint derivative by {}", self.component.variable(*known)?.name);
                let allowed = "a finite number; seed and derivatives are too large together";
                return Err(refused(what, *sum, allowed));
            }
        }
        sums.into_iter().enumerate().for_each(|(k, sum)| write(k, sum));
        Ok(())
    }

    /// `fmi3GetOutputDerivatives` (FMI 3.0.2, 4.1.2).
    ///
    /// # Errors
    /// As [`output_derivatives`](crate::Model::output_derivatives).
    pub fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        count: usize,
        write: impl FnMut(usize, f64),
    ) -> Outcome<C> {
        check_count("nValues", count, references.len())?;
        self.check_get()?;
        Ok(self.component.output_derivatives(references, orders, write)?)
    }

    /// Present dependencies of a variable, for `fmi3GetVariableDependencies` (FMI 3.0.2, 2.2.9).
    ///
    /// # Errors
    /// As [`dependencies`](crate::Model::dependencies).
    pub fn dependencies(&self, reference: u32) -> Outcome<C, Vec<Dependency>> {
        Ok(self.component.dependencies(reference)?)
    }

    /// [`dependencies`](Self::dependencies) for a host with room for `count` of them.
    ///
    /// # Errors
    /// If `count` differs from the number of dependencies.
    pub fn dependencies_counted(&self, reference: u32, count: usize) -> Outcome<C, Vec<Dependency>> {
        let list = self.dependencies(reference)?;
        check_count("nDependencies", count, list.len())?;
        Ok(list)
    }

    /// A function that is never allowed, with any arguments.
    ///
    /// # Errors
    /// None: [`guard`](Self::guard) has refused it.
    pub fn never(&self) -> Outcome<C> {
        Ok(())
    }
}

/// Refusal, by the component, of a number that is not finite.
fn refused<P: Refusal>(what: String, value: f64, allowed: &'static str) -> CallProblem<P> {
    P::from(crate::Problem::value(what, value, allowed)).into()
}
