//! Double-double arithmetic: unevaluated sums of two doubles, about 32 digits (T. J. Dekker,
//! Numer. Math. 18, 1971). Used for time and the drive's phase
//! ([`drive_phase`](super::drive_phase)), so that they do not drift over any number of sub-steps.

use serde::{Deserialize, Serialize};

/// A number `hi + lo` with |lo| at most half a unit in the last place of `hi`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DoubleDouble {
    /// Leading part: the sum rounded to a double.
    pub hi: f64,
    /// Trailing part.
    pub lo: f64,
}

#[inline(always)]
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let hi = a + b;
    let t = hi - a;
    DoubleDouble { hi, lo: (a - (hi - t)) + (b - t) }
}

#[inline(always)]
fn quick_two_sum(a: f64, b: f64) -> DoubleDouble {
    let hi = a + b;
    DoubleDouble { hi, lo: b - (hi - a) }
}

/// Exact product by Dekker's splitting, bit-identical with and without fused multiply-add.
#[inline(always)]
fn two_product(a: f64, b: f64) -> DoubleDouble {
    let split = |x: f64| {
        let t = 134_217_729.0 * x; // 2^27 + 1
        let high = t - (t - x);
        (high, x - high)
    };
    let hi = a * b;
    let ((ah, al), (bh, bl)) = (split(a), split(b));
    DoubleDouble { hi, lo: ((ah * bh - hi) + ah * bl + al * bh) + al * bl }
}

impl DoubleDouble {
    /// The value of a double.
    #[inline(always)]
    pub fn new(value: f64) -> Self {
        Self { hi: value, lo: 0.0 }
    }

    /// The sum of two doubles, exactly.
    #[inline(always)]
    pub fn sum(a: f64, b: f64) -> Self {
        two_sum(a, b)
    }

    /// The sum with a double, to 32 digits.
    #[inline(always)]
    pub fn plus(self, b: f64) -> Self {
        let s = two_sum(self.hi, b);
        quick_two_sum(s.hi, s.lo + self.lo)
    }

    /// The difference, to 32 digits.
    #[inline(always)]
    pub fn minus(self, b: Self) -> Self {
        self + Self { hi: -b.hi, lo: -b.lo }
    }

    /// The product, to 32 digits.
    #[inline(always)]
    pub fn times(self, b: Self) -> Self {
        let p = two_product(self.hi, b.hi);
        quick_two_sum(p.hi, p.lo + (self.hi * b.lo + self.lo * b.hi))
    }

    /// Rounded to a double.
    #[inline(always)]
    pub fn value(self) -> f64 {
        self.hi + self.lo
    }

    /// Difference from the nearest whole number, in [-1/2, 1/2].
    #[inline(always)]
    pub fn fraction(self) -> Self {
        let whole = self.hi.round_ties_even();
        let rest = Self::new(self.hi - whole).plus(self.lo);
        let again = rest.hi.round_ties_even(); // lo may carry over a half
        Self { hi: rest.hi - again, lo: rest.lo }
    }
}

impl std::ops::Add for DoubleDouble {
    type Output = Self;

    /// To 32 digits.
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        let s = two_sum(self.hi, b.hi);
        let t = two_sum(self.lo, b.lo);
        let s = quick_two_sum(s.hi, s.lo + t.hi);
        quick_two_sum(s.hi, s.lo + t.lo)
    }
}

impl From<f64> for DoubleDouble {
    #[inline(always)]
    fn from(value: f64) -> Self {
        Self::new(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_sums_do_not_drift() {
        let mut time = DoubleDouble::default();
        for _ in 0..1_000_000 {
            time = time.plus(0.1);
        }
        // 10^6 additions of the double nearest 0.1, whose exact product with 10^6 is this:
        let exact = two_product(0.1, 1e6);
        assert!((time.minus(exact)).value().abs() < 1e-22, "{time:?}");
    }
}
