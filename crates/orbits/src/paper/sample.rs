//! Test functions of a cycle, and properties examined at each point of a branch.

use super::cycle::{Cycle, Functional};
use super::orbit::{eigenvalues, is_clear};
use crate::test_functions::{SignedLog, determinant, pair_test};
use nalgebra::{Complex, Matrix6};

/// Number of test functions.
pub(super) const TESTS: usize = 3;
/// Index of the test for a multiplier 1: a fold, or a branch point.
pub(super) const UNIT: usize = 0;
/// Index of the test for a multiplier -1: a period doubling, or the symmetry breaking of a
/// symmetric orbit.
pub(super) const DOUBLING: usize = 1;
/// Index of the test for a pair of multipliers with the product 1: a Neimark-Sacker point.
pub(super) const PAIR: usize = 2;

/// Value of a test function at a cycle; [`PAIR`] requires the multipliers.
pub(super) fn test(cycle: &Cycle, index: usize) -> Option<SignedLog> {
    match index {
        UNIT => breaking(cycle, 1.0),
        DOUBLING => breaking(cycle, -1.0),
        _ => eigenvalues(cycle.monodromy()).map(|m| pair_test(&m)),
    }
}

/// t_LP or t_PD of docs/theory.md (108), for variations that close with a factor.
fn breaking(cycle: &Cycle, factor: f64) -> Option<SignedLog> {
    let SignedLog { sign, log } = cycle.derivative(Functional::Gap, factor).map(determinant)?;
    let anchor = SignedLog::of([cycle.anchor(factor)].into_iter());
    Some(SignedLog { sign: sign * anchor.sign, log: log + anchor.log })
}

/// Properties examined at each point of a branch.
#[derive(Clone, Debug)]
pub(super) struct Sample {
    pub multipliers: [Complex<f64>; 6],
    pub tests: [Option<SignedLog>; TESTS],
    /// Whether all impacts approach their stops.
    pub approaches: bool,
    /// Whether no stop is touched between the impacts.
    pub clear: bool,
}

impl Sample {
    /// The properties of a cycle; `None` if its eigenvalues cannot be computed.
    pub fn of(cycle: &Cycle) -> Option<Self> {
        let map: Matrix6<f64> = cycle.monodromy();
        let multipliers = eigenvalues(map)?;
        let tests = [test(cycle, UNIT), test(cycle, DOUBLING), Some(pair_test(&multipliers))];
        let approaches = (0..cycle.phases.len()).all(|i| cycle.speed(i) > 0.0);
        Some(Self { multipliers, tests, approaches, clear: is_clear(cycle) })
    }

    pub fn is_certified(&self) -> bool {
        self.approaches && self.clear
    }

    pub fn is_stable(&self) -> bool {
        self.is_certified() && self.multipliers[0].norm() < 1.0
    }
}
