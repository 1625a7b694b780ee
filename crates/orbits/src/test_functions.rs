//! Functions along a branch whose zeros are bifurcations (docs/theory.md (107), (108)).

use nalgebra::{Complex, DMatrix};

/// A number as its sign and the logarithm of its modulus, without overflow or underflow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SignedLog {
    /// -1, 0 or 1.
    pub sign: f64,
    pub log: f64,
}

impl SignedLog {
    pub fn of(factors: impl Iterator<Item = f64>) -> Self {
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

/// Tolerance for a complex pair on the unit circle, as for the exact orbit.
const ON_CIRCLE: f64 = 1e-5;

/// Whether a complex multiplier is on the unit circle. If none is, a zero of the pair's test is a
/// neutral saddle, which is not a bifurcation.
pub(super) fn is_on_circle(multipliers: &[Complex<f64>]) -> bool {
    multipliers.iter().any(|m| m.im != 0.0 && (m.norm() - 1.0).abs() < ON_CIRCLE)
}
