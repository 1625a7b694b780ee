//! Factorization of symmetric matrices in double-double arithmetic, for stiffnesses with ratios
//! beyond the precision of doubles.

use nalgebra::DMatrix;
use vibro_impact::numerics::double_double::DoubleDouble;

/// A = L D Lᵀ with a unit lower triangle L, stored below the diagonal D.
pub(super) struct Factor(DMatrix<DoubleDouble>);

impl Factor {
    /// Factors a symmetric matrix, given by its lower triangle; `None` where it is not positive
    /// definite.
    pub(super) fn new(mut a: DMatrix<DoubleDouble>) -> Option<Self> {
        let n = a.nrows();
        let zero = DoubleDouble::default();
        for j in 0..n {
            let pivot = a[(j, j)];
            if !(pivot.value() > 0.0 && pivot.value().is_finite()) {
                return None;
            }
            let below: Vec<_> = (j + 1..n).map(|i| (i, a[(i, j)])).filter(|(_, x)| *x != zero).collect();
            let shares: Vec<_> = below.iter().map(|&(i, x)| (i, quotient(x, pivot))).collect();
            for (from, &(k, x)) in below.iter().enumerate() {
                shares[from..].iter().for_each(|&(i, share)| a[(i, k)] = a[(i, k)].minus(share.times(x)));
            }
            shares.into_iter().for_each(|(i, share)| a[(i, j)] = share);
        }
        Some(Self(a))
    }

    /// Replaces x by L⁻¹ x.
    fn forward(&self, x: &mut [DoubleDouble]) {
        for j in 0..x.len() {
            let known = x[j];
            if known == DoubleDouble::default() {
                continue;
            }
            (j + 1..x.len()).for_each(|i| x[i] = x[i].minus(self.0[(i, j)].times(known)));
        }
    }

    /// Replaces x by A⁻¹ x.
    pub(super) fn solve(&self, x: &mut [DoubleDouble]) {
        self.forward(x);
        for j in (0..x.len()).rev() {
            let own = quotient(x[j], self.0[(j, j)]);
            x[j] = (j + 1..x.len()).fold(own, |sum, i| sum.minus(self.0[(i, j)].times(x[i])));
        }
    }

    /// D^-½ L⁻¹ x, rounded to doubles. Scalar products of such vectors are xᵀ A⁻¹ y.
    pub(super) fn half(&self, mut x: Vec<DoubleDouble>) -> Vec<f64> {
        self.forward(&mut x);
        x.iter().enumerate().map(|(j, x)| x.value() / self.0[(j, j)].value().sqrt()).collect()
    }
}

/// a/b, to 32 digits.
fn quotient(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble {
    let first = a.value() / b.value();
    let left = a.minus(b.times(DoubleDouble::new(first)));
    let second = left.value() / b.value();
    let left = left.minus(b.times(DoubleDouble::new(second)));
    DoubleDouble::sum(first, second).plus(left.value() / b.value())
}
