//! Fixed-point numbers of 384 bits, 256 of them after the point: 77 decimal digits.

use vibro_numerics::double_double::DoubleDouble;

const LIMBS: usize = 6;
/// Limbs after the point.
const BEHIND: usize = 4;

/// A number below 2^128 in size. Sums are exact; products and quotients are truncated at 2^-256.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Wide {
    is_negative: bool,
    /// The size, lowest limb first.
    size: [u64; LIMBS],
}

impl Wide {
    pub(super) fn new(x: f64) -> Self {
        let mut one = Self::default();
        one.size[BEHIND] = 1;
        one.times(x)
    }

    pub(super) fn plus(self, other: Self) -> Self {
        if self.is_negative == other.is_negative {
            let mut sum = self;
            let mut carry = false;
            for (x, y) in sum.size.iter_mut().zip(other.size) {
                let (first, one) = x.overflowing_add(y);
                let (second, two) = first.overflowing_add(u64::from(carry));
                (*x, carry) = (second, one || two);
            }
            assert!(!carry, "beyond the range");
            return sum;
        }
        let is_less = self.size.iter().rev().lt(other.size.iter().rev());
        let (mut larger, less) = if is_less { (other, self) } else { (self, other) };
        let mut borrow = false;
        for (x, y) in larger.size.iter_mut().zip(less.size) {
            let (first, one) = x.overflowing_sub(y);
            let (second, two) = first.overflowing_sub(u64::from(borrow));
            (*x, borrow) = (second, one || two);
        }
        larger
    }

    /// The product with a double.
    pub(super) fn times(self, x: f64) -> Self {
        let bits = x.to_bits();
        let exponent = (bits >> 52 & 0x7ff) as i32;
        if exponent == 0 {
            assert!(x == 0.0, "{x} is not normal");
            return Self::default();
        }
        let mantissa = bits & ((1 << 52) - 1) | 1 << 52;
        let mut product = [0u64; LIMBS + 1];
        let mut carry = 0;
        for (to, limb) in product.iter_mut().zip(self.size) {
            let sum = u128::from(limb) * u128::from(mantissa) + carry;
            (*to, carry) = (sum as u64, sum >> 64);
        }
        product[LIMBS] = carry as u64;
        // x = mantissa 2^(exponent - 1075).
        let shift = exponent - 1075;
        let (limbs, bits) = (shift.div_euclid(64), shift.rem_euclid(64) as u32);
        let at =
            |i: i32| usize::try_from(i).ok().and_then(|i| product.get(i)).map_or(0, |limb| u128::from(*limb));
        let shifted = |i: usize| {
            let i = i as i32 - limbs;
            ((at(i) << 64 | at(i - 1)) << bits >> 64) as u64
        };
        assert!((LIMBS..2 * LIMBS + 8).all(|i| shifted(i) == 0), "beyond the range");
        Self { is_negative: self.is_negative != (x < 0.0), size: std::array::from_fn(shifted) }
    }

    /// The quotient by a whole number.
    pub(super) fn over(mut self, by: usize) -> Self {
        let mut rest = 0;
        for limb in self.size.iter_mut().rev() {
            let all = rest << 64 | u128::from(*limb);
            (*limb, rest) = ((all / by as u128) as u64, all % by as u128);
        }
        self
    }

    /// Rounded to a double.
    pub(super) fn value(self) -> f64 {
        let parts = self.size.iter().enumerate().rev();
        let size: f64 =
            parts.map(|(i, &limb)| limb as f64 * 2f64.powi(64 * (i as i32 - BEHIND as i32))).sum();
        if self.is_negative { -size } else { size }
    }
}

#[test]
fn closed_form_wide_numbers() {
    // exp(1) exp(-1) = 1, by series with products and quotients by doubles.
    let series = |x: f64| {
        let (mut term, mut sum) = (Wide::new(1.0), Wide::new(1.0));
        for k in 1..70 {
            term = term.times(x).over(k);
            sum = sum.plus(term);
        }
        sum
    };
    // The first 53 bits of 1/e and the next: their products with e add to 1 to 75 digits.
    let (e, mut left) = (series(1.0), series(-1.0));
    let mut rest = Wide::new(-1.0);
    for _ in 0..6 {
        let part = left.value();
        rest = rest.plus(e.times(part));
        left = left.plus(Wide::new(-part));
    }
    assert!(rest.value().abs() < 1e-75, "{:e}", rest.value());
    let sum = DoubleDouble::sum(0.3, -0.1);
    let left = Wide::new(0.3).plus(Wide::new(-0.1)).plus(Wide::new(-sum.hi));
    assert_eq!((left.value(), left.plus(Wide::new(-sum.lo)).value()), (sum.lo, 0.0));
}
