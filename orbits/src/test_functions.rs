//! Functions along a branch whose zeros are bifurcations (docs/theory.md (107), (108)).

use super::cycle::{Cycle, Functional};
use super::orbit::{eigenvalues, is_clear};
use nalgebra::{Complex, DMatrix, Matrix6};

/// A number by its sign and the logarithm of its modulus, which neither overflows nor underflows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SignedLog {
    /// -1, 0 or 1.
    pub sign: f64,
    pub log: f64,
}

impl SignedLog {
    fn of(factors: impl Iterator<Item = f64>) -> Self {
        factors.fold(Self { sign: 1.0, log: 0.0 }, |product, factor| Self {
            sign: if factor == 0.0 { 0.0 } else { product.sign * factor.signum() },
            log: product.log + factor.abs().max(f64::MIN_POSITIVE).ln(),
        })
    }

    /// Value in units of another number's modulus.
    pub fn relative_to(self, unit: Self) -> f64 {
        self.sign * (self.log - unit.log).exp()
    }
}

/// The determinant of a matrix.
pub(super) fn determinant(matrix: DMatrix<f64>) -> SignedLog {
    let lu = matrix.lu();
    let permutation: f64 = lu.p().determinant();
    let diagonal = lu.lu_internal().diagonal();
    SignedLog::of(diagonal.iter().copied().chain([permutation]))
}

/// Number of test functions.
pub(super) const TESTS: usize = 3;
/// Index of the test for a multiplier 1: a fold, or a branch point.
pub(super) const UNIT: usize = 0;
/// Index of the test for a multiplier -1: a period doubling, or the symmetry breaking of a
/// symmetric orbit.
pub(super) const DOUBLING: usize = 1;
/// Index of the test for a pair of multipliers with the product 1: a Neimark-Sacker point.
pub(super) const PAIR: usize = 2;

/// Value of a test function at a cycle; [`PAIR`] needs the multipliers.
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

/// t_NS of docs/theory.md (81), with each factor divided by 1 + |μᵢ μⱼ|, which leaves the zeros
/// unchanged.
pub(super) fn pair_test(multipliers: &[Complex<f64>]) -> SignedLog {
    let (mut product, mut log) = (Complex::new(1.0, 0.0), 0.0);
    for (i, a) in multipliers.iter().enumerate() {
        for b in &multipliers[i + 1..] {
            let factor = (1.0 - a * b) / (1.0 + (a * b).norm());
            let size = factor.norm().max(f64::MIN_POSITIVE);
            (product, log) = (product * (factor / size), log + size.ln());
        }
    }
    // The product is real, since with each pair its conjugate is among the factors.
    SignedLog { sign: product.re.signum(), log }
}

/// Distance from the unit circle within which a complex pair counts as on it, as for the exact
/// orbit.
const ON_CIRCLE: f64 = 1e-5;

/// Whether a complex multiplier is on the unit circle. If none is, a zero of the pair's test is a
/// neutral saddle, which is not a bifurcation.
pub(super) fn is_on_circle(multipliers: &[Complex<f64>]) -> bool {
    multipliers.iter().any(|m| m.im != 0.0 && (m.norm() - 1.0).abs() < ON_CIRCLE)
}

/// Properties of a cycle that are examined at each point of a branch.
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
    /// The properties of a cycle; `None` where its eigenvalues cannot be computed.
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
