//! Derivatives of curved forces and of their rates (docs/assembly-law.md, section 20).

use crate::curved::{Curved, Polynomial};
use crate::flow::CurveInMode;
use crate::functional::Functional;
use crate::kernel::SparseMatrix;
use crate::norm::norm;
use crate::system::System;
use nalgebra::DVector;

/// The derivative of a curved force by one parameter, at a fixed state.
#[derive(Clone, Debug)]
pub(super) struct CurveTangent {
    /// Derivative of the argument.
    pub argument: Functional,
    /// Derivatives of the coefficients.
    pub force: Polynomial,
}

impl CurveTangent {
    /// The derivative of φ at a state, with the derivative of the state.
    pub fn derivative(&self, own: &Curved, z: &DVector<f64>, delta: &DVector<f64>) -> f64 {
        let x = own.argument.at(z.as_slice());
        let dx = own.argument.at(delta.as_slice()) + self.argument.at(z.as_slice());
        own.force.derivative(x) * dx + self.force.value(x)
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
    /// Indices of the velocities.
    pub velocities: std::ops::Range<usize>,
}

impl CurvesInMode {
    /// The curved forces of a system in a mode with matrix A.
    pub fn of(system: &System, by: Vec<Vec<CurveTangent>>, a: &SparseMatrix) -> Self {
        if system.curved.is_empty() {
            return Self::default();
        }
        let (rate, weights) = norm(&system.with_slopes(a), system.signals.one);
        let velocities = system.coordinates..2 * system.coordinates;
        Self { forces: CurveInMode::all(system, a, &weights), by, rate, weights, velocities }
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
            let x = own.argument.at(z.as_slice());
            let dx = own.argument.at(delta.as_slice()) + by.argument.at(z.as_slice());
            let speed = own.argument.at(rates.as_slice());
            let dspeed = own.argument.at(changes.as_slice()) + by.argument.at(rates.as_slice());
            let bend = own.force.second_derivative(x) * dx + by.force.derivative(x);
            changes[own.place] = bend * speed + own.force.derivative(x) * dspeed;
        }
    }
}
