//! A point of a branch with its properties.

use super::conditions::Condition;
use super::orbit::Stability;
use crate::test_functions::SignedLog;
use nalgebra::{Complex, DVector};

/// A point with its properties; `T` contains the values of the bifurcation tests.
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

/// Properties examined at a position of a described machine.
#[derive(Clone)]
pub(super) struct Examined {
    /// Determinant of the equations bordered by the tangent: zero where branches cross.
    pub crossing: SignedLog,
    /// Determinant of the equations for variations that change sign; zero at a doubling.
    pub doubling: SignedLog,
    /// Zero if a pair of multipliers has the product 1.
    pub pair: f64,
    pub conditions: Vec<(Condition, f64)>,
}

impl<T> Position<T> {
    /// Component of the tangent along the parameter; zero at a fold.
    pub fn fold(&self) -> f64 {
        self.tangent[self.tangent.len() - 1]
    }
}

/// ∏ (1 + μ), with each factor scaled to at most one.
pub(super) fn doubling(multipliers: &[Complex<f64>]) -> f64 {
    multipliers.iter().map(|m| (1.0 + m) / (1.0 + m.norm())).product::<Complex<f64>>().re
}
