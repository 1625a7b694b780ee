//! Derivatives of curved forces and of their rates (docs/assembly-law.md, section 20).

use crate::curved::{Curved, Operation, Polynomial};
use crate::flow::CurveInMode;
use crate::functional::Functional;
use crate::kernel::SparseMatrix;
use crate::mode::Mode;
use crate::norm::norm;
use crate::system::System;
use nalgebra::DVector;

/// The derivative of a curved force by one parameter, at a fixed state.
#[derive(Clone, Debug)]
pub(super) struct CurveTangent {
    /// Derivatives of the rows of the arguments.
    pub arguments: [Functional; 2],
    /// Derivatives of the coefficients of a polynomial; 0 for other operations.
    pub force: Polynomial,
}

impl CurveTangent {
    /// The derivative of φ at a state, with the derivative of the state.
    pub fn derivative(&self, own: &Curved, z: &DVector<f64>, delta: &DVector<f64>) -> f64 {
        let arguments = own.arguments(z.as_slice());
        let slopes = own.operation.slopes(arguments);
        let changes = self.changes(own, z, delta);
        let along = slopes[0] * changes[0];
        match own.operation {
            Operation::Polynomial(_) => along + self.force.value(arguments[0]),
            Operation::Product => along + slopes[1] * changes[1],
            _ => along,
        }
    }

    /// The derivatives of the arguments at a state, with the derivative of the state.
    fn changes(&self, own: &Curved, z: &DVector<f64>, delta: &DVector<f64>) -> [f64; 2] {
        let (own, by) = (own.arguments(delta.as_slice()), self.arguments.each_ref());
        std::array::from_fn(|i| own[i] + by[i].at(z.as_slice()))
    }
}

/// The curved forces of a mode with their derivatives.
#[derive(Default)]
pub(super) struct CurvesInMode {
    pub forces: Vec<CurveInMode>,
    /// Derivatives, by column and force.
    pub by: Vec<Vec<CurveTangent>>,
    /// A bound of the norm of A, and 1/w for each coordinate; empty without curved forces.
    pub rate: f64,
    pub weights: Vec<f64>,
    /// Number of displacements, and index of the constant 1.
    pub coordinates: usize,
    pub one: usize,
}

impl CurvesInMode {
    /// The curved forces of a system in a mode with matrix A.
    pub fn of(system: &System, mode: &Mode, by: Vec<Vec<CurveTangent>>, a: &SparseMatrix) -> Self {
        if system.curved.is_empty() {
            return Self::default();
        }
        let in_mode = |(own, mut by): (&Curved, CurveTangent)| {
            if let Some(factor) = own.factor_in(mode) {
                by.arguments[0] = factor * &by.arguments[0];
            }
            by
        };
        let by = by.into_iter().map(|all| system.curved.iter().zip(all).map(in_mode).collect()).collect();
        let (rate, weights) = norm(a, system.signals.one);
        let (coordinates, one) = (system.coordinates, system.signals.one);
        Self { forces: CurveInMode::all(system, mode, a, &weights), by, rate, weights, coordinates, one }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.forces.is_empty()
    }

    /// Writes the time derivatives of φ into z'.
    pub fn add_rates(&self, z: &DVector<f64>, rates: &mut DVector<f64>) {
        for own in &self.forces {
            own.curved.vary(z.as_slice(), rates.as_mut_slice());
        }
    }

    /// Writes the derivatives of φ' by column `p` into `changes`, the derivative of z', given z and
    /// z', and the derivative of z.
    pub fn add_rates_by(&self, p: usize, [z, rates, delta]: [&DVector<f64>; 3], changes: &mut DVector<f64>) {
        for (CurveInMode { curved: own, .. }, by) in self.forces.iter().zip(&self.by[p]) {
            let arguments = own.arguments(z.as_slice());
            let [dx, dy] = by.changes(own, z, delta);
            let [speed, other] = own.arguments(rates.as_slice());
            let [dspeed, dother] = by.changes(own, rates, changes);
            let [twice, mixed] = own.operation.second_derivatives(arguments);
            let slopes = own.operation.slopes(arguments);
            let mut bend = twice * dx;
            if let Operation::Polynomial(_) = own.operation {
                bend += by.force.derivative(arguments[0]);
            }
            let mut sum = bend * speed + slopes[0] * dspeed;
            if own.operation.is_of_two() {
                sum += mixed * (dy * speed + dx * other) + slopes[1] * dother;
            }
            changes[own.place] = sum;
        }
    }
}
