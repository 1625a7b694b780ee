//! A point of a branch with what is examined there.

use super::conditions::Condition;
use super::orbit::Stability;
use crate::test_functions::SignedLog;
use nalgebra::{Complex, DVector};

/// A point with its properties; `T` has the values of the tests of bifurcations.
#[derive(Clone)]
pub(super) struct Position<T> {
    pub u: DVector<f64>,
    pub tangent: DVector<f64>,
    pub steps: usize,
    pub period: f64,
    pub multipliers: Vec<Complex<f64>>,
    pub stability: Stability,
    pub tests: T,
}

/// What is examined at a position of a described machine.
#[derive(Clone)]
pub(super) struct Examined {
    /// Determinant of the equations bordered by the tangent: zero where branches cross.
    pub crossing: SignedLog,
    /// Determinant of the equations whose variations close with the factor -1: zero at a doubling.
    pub doubling: SignedLog,
    /// Zero where a pair of multipliers has the product 1.
    pub pair: f64,
    pub conditions: Vec<(Condition, f64)>,
}

impl<T> Position<T> {
    /// Position along the parameter's direction.
    pub fn fold(&self) -> f64 {
        self.tangent[self.tangent.len() - 1]
    }
}

/// ∏ (1 + μ), each factor of size one at most.
pub(super) fn doubling(multipliers: &[Complex<f64>]) -> f64 {
    multipliers.iter().map(|m| (1.0 + m) / (1.0 + m.norm())).product::<Complex<f64>>().re
}
