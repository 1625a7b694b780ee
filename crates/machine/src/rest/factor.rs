//! Factorization of symmetric matrices in double-doubles, accurate for stiffness ratios beyond the
//! precision of doubles.

use crate::sparse_factor::{Number, SymmetricSparse};
use vibro_numerics::double_double::DoubleDouble;

/// Factors L D Lᵀ of a positive definite matrix.
pub(super) struct Factor<'p>(SymmetricSparse<'p, DoubleDouble>);

impl<'p> Factor<'p> {
    /// The factors of a symmetric matrix; `None` if it is not positive definite.
    pub(super) fn new(a: SymmetricSparse<'p, DoubleDouble>) -> Option<Self> {
        let is_positive = |pivot: f64| pivot > 0.0 && pivot.is_finite();
        a.factor(|pivot, _| is_positive(pivot.value()).then_some(pivot)).map(Self)
    }

    /// Replaces `x` by the matrix's inverse times `x`.
    pub(super) fn solve(&self, x: &mut [DoubleDouble]) {
        self.0.solve(x);
    }

    /// D^-½ L⁻¹ x, rounded, in the order of elimination; the scalar product of two such vectors is
    /// xᵀ A⁻¹ y.
    pub(super) fn half(&self, x: Vec<DoubleDouble>) -> Vec<f64> {
        let half = self.0.half(&x);
        half.iter().zip(&self.0.diagonal).map(|(x, pivot)| x.value() / pivot.value().sqrt()).collect()
    }
}

impl Number for DoubleDouble {
    const ZERO: Self = Self { hi: 0.0, lo: 0.0 };

    fn less_product(self, a: Self, b: Self) -> Self {
        self.minus(a.times(b))
    }

    /// a/b to 32 digits.
    fn over(self, b: Self) -> Self {
        let first = self.value() / b.value();
        let left = self.minus(b.times(Self::new(first)));
        let second = left.value() / b.value();
        let left = left.minus(b.times(Self::new(second)));
        Self::sum(first, second).plus(left.value() / b.value())
    }
}
