//! Vectors of numbers of several motions, with the usual operators. Each lane of a result depends
//! on that lane of the operands alone, so a motion's numbers never depend on its neighbours'.

use pulp::{Simd, bytemuck};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Number of motions side by side in memory: a whole number of vectors on every machine, two with
/// AVX-512 and four with AVX2.
pub(crate) const ROW: usize = 16;

/// One number of each motion, in memory, aligned to a cache line.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct LaneRow(pub(crate) [f64; ROW]);

impl LaneRow {
    pub(crate) const ZERO: Self = Self([0.0; ROW]);

    /// Number of vectors in a row.
    #[inline(always)]
    pub(crate) fn vectors<S: Simd>() -> usize {
        ROW / S::F64_LANES
    }
}

/// Vector of one number of each of some neighbouring motions.
#[derive(Clone, Copy)]
pub(crate) struct Wide<S: Simd> {
    simd: S,
    x: S::f64s,
}

/// Bit of each lane of a vector, the first lane's the lowest.
const LANE_BITS: [u64; 8] = [1, 2, 4, 8, 16, 32, 64, 128];

/// Vector of truth values.
#[derive(Clone, Copy)]
pub(crate) struct Mask<S: Simd> {
    simd: S,
    m: S::m64s,
}

impl<S: Simd> Wide<S> {
    /// `x` in every lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, x: f64) -> Self {
        Self { simd, x: simd.splat_f64s(x) }
    }

    /// Vector `v` of a row.
    #[inline(always)]
    pub(crate) fn load(simd: S, row: &LaneRow, v: usize) -> Self {
        Self { simd, x: S::as_simd_f64s(&row.0).0[v] }
    }

    /// Vector `v` of each row.
    #[inline(always)]
    pub(crate) fn load_each<const N: usize>(simd: S, rows: &[LaneRow; N], v: usize) -> [Self; N] {
        let mut all = [Self::splat(simd, 0.0); N];
        for (one, row) in all.iter_mut().zip(rows) {
            *one = Self::load(simd, row, v);
        }
        all
    }

    /// Transposes four numbers of each motion into four vectors, for one motion per lane. The lane
    /// of a motion is the same in all four and depends on the instruction set.
    #[inline(always)]
    pub(crate) fn transposed(simd: S, motions: &[[f64; 4]]) -> [Self; 4] {
        let mut vectors = [simd.splat_f64s(0.0); 4];
        let there = S::as_simd_f64s(motions.as_flattened()).0;
        vectors.copy_from_slice(&there[..4]);
        let [a, b, c, d] = simd.deinterleave_shfl_f64s(vectors);
        [Self { simd, x: a }, Self { simd, x: b }, Self { simd, x: c }, Self { simd, x: d }]
    }

    /// Σ_j rows[j] x_j from vector `v` of each row; fused multiply-adds after the first product.
    #[inline(always)]
    pub(crate) fn dot<const N: usize>(simd: S, rows: &[LaneRow; N], v: usize, x: &[Self; N]) -> Self {
        let mut sum = Self::load(simd, &rows[0], v) * x[0];
        for (row, x) in rows.iter().zip(x).skip(1) {
            sum = Self::load(simd, row, v).mul_add(*x, sum);
        }
        sum
    }

    /// Writes vector `v` of a row.
    #[inline(always)]
    pub(crate) fn store(self, row: &mut LaneRow, v: usize) {
        S::as_mut_simd_f64s(&mut row.0).0[v] = self.x;
    }

    /// `x` in every lane.
    #[inline(always)]
    pub(crate) fn uniform(self, x: f64) -> Self {
        Self::splat(self.simd, x)
    }

    /// `self b + c`, rounded once.
    #[inline(always)]
    pub(crate) fn mul_add(self, b: Self, c: Self) -> Self {
        Self { x: self.simd.mul_add_e_f64s(self.x, b.x, c.x), ..self }
    }

    /// `c - self b`, rounded once.
    #[inline(always)]
    pub(crate) fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Self { x: self.simd.negate_mul_add_e_f64s(self.x, b.x, c.x), ..self }
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self { x: self.simd.abs_f64s(self.x), ..self }
    }

    #[inline(always)]
    pub(crate) fn max(self, b: Self) -> Self {
        Self { x: self.simd.max_f64s(self.x, b.x), ..self }
    }

    /// `self < b` lane by lane; false for NaN.
    #[inline(always)]
    pub(crate) fn less_than(self, b: Self) -> Mask<S> {
        Mask { simd: self.simd, m: self.simd.less_than_f64s(self.x, b.x) }
    }

    /// `self ≤ b` lane by lane; false for NaN.
    #[inline(always)]
    pub(crate) fn at_most(self, b: Self) -> Mask<S> {
        Mask { simd: self.simd, m: self.simd.less_than_or_equal_f64s(self.x, b.x) }
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $function:ident) => {
        impl<S: Simd> $trait for Wide<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                Self { x: self.simd.$function(self.x, b.x), ..self }
            }
        }
    };
}

operator!(Add, add, add_f64s);
operator!(Sub, sub, sub_f64s);
operator!(Mul, mul, mul_f64s);
operator!(Div, div, div_f64s);

impl<S: Simd> Neg for Wide<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: self.simd.neg_f64s(self.x), ..self }
    }
}

impl<S: Simd> Mask<S> {
    /// Mask from a bit for each lane, the first lane's the lowest.
    #[inline(always)]
    pub(crate) fn from_bits(simd: S, bits: u64) -> Self {
        let lanes = S::as_simd_u64s(&LANE_BITS).0[0];
        Self { simd, m: simd.equal_u64s(simd.and_u64s(simd.splat_u64s(bits), lanes), lanes) }
    }

    /// `yes` in the lanes that are true and `no` in the others.
    #[inline(always)]
    pub(crate) fn select(self, yes: Wide<S>, no: Wide<S>) -> Wide<S> {
        Wide { simd: self.simd, x: self.simd.select_f64s(self.m, yes.x, no.x) }
    }

    /// Bit of each lane that is true, the first lane's the lowest.
    #[inline(always)]
    pub(crate) fn bits(self) -> u64 {
        if size_of::<S::m64s>() == 1 {
            return u64::from(bytemuck::bytes_of(&self.m)[0]);
        }
        let chosen = self.simd.select_u64s(self.m, S::as_simd_u64s(&LANE_BITS).0[0], self.simd.splat_u64s(0));
        let lanes: &[u64] = bytemuck::cast_slice(std::slice::from_ref(&chosen));
        let mut bits = 0;
        for bit in lanes {
            bits |= bit;
        }
        bits
    }
}

impl<S: Simd> BitAnd for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, b: Self) -> Self {
        Self { m: self.simd.and_m64s(self.m, b.m), ..self }
    }
}

impl<S: Simd> BitOr for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, b: Self) -> Self {
        Self { m: self.simd.or_m64s(self.m, b.m), ..self }
    }
}

impl<S: Simd> Not for Mask<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self { m: self.simd.not_m64s(self.m), ..self }
    }
}

/// Vector of sums in extended precision, by the formulas of [`DoubleDouble::plus`] on vectors;
/// `second_method_sums_are_double_double` checks that both are bit-identical.
///
/// [`DoubleDouble::plus`]: vibro_numerics::double_double::DoubleDouble::plus
#[derive(Clone, Copy)]
pub(crate) struct WideDoubleDouble<S: Simd> {
    pub(crate) hi: Wide<S>,
    pub(crate) lo: Wide<S>,
}

impl<S: Simd> WideDoubleDouble<S> {
    /// Vector `v` of two rows, which hold the leading and trailing parts.
    #[inline(always)]
    pub(crate) fn load(simd: S, [hi, lo]: &[LaneRow; 2], v: usize) -> Self {
        Self { hi: Wide::load(simd, hi, v), lo: Wide::load(simd, lo, v) }
    }

    /// Writes vector `v` of two rows: this in the lanes `chosen`, `before` in the others.
    #[inline(always)]
    pub(crate) fn store_where(self, chosen: Mask<S>, before: Self, [hi, lo]: &mut [LaneRow; 2], v: usize) {
        chosen.select(self.hi, before.hi).store(hi, v);
        chosen.select(self.lo, before.lo).store(lo, v);
    }

    /// Sum with a vector of doubles.
    #[inline(always)]
    pub(crate) fn plus(self, b: Wide<S>) -> Self {
        let sum = self.hi + b;
        let t = sum - self.hi;
        let lo = ((self.hi - (sum - t)) + (b - t)) + self.lo;
        let hi = sum + lo;
        Self { hi, lo: lo - (hi - sum) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use vibro_numerics::double_double::DoubleDouble;

    /// Sums of the terms of each lane, all from one start.
    struct Sums<'a>(f64, &'a [[f64; ROW]]);

    impl pulp::WithSimd for Sums<'_> {
        type Output = [DoubleDouble; ROW];

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let mut parts = [LaneRow([self.0; ROW]), LaneRow::ZERO];
            for v in 0..LaneRow::vectors::<S>() {
                for terms in self.1 {
                    let sum = WideDoubleDouble::load(simd, &parts, v);
                    let all = Mask::from_bits(simd, u64::MAX);
                    let more = sum.plus(Wide::load(simd, &LaneRow(*terms), v));
                    more.store_where(all, sum, &mut parts, v);
                }
            }
            std::array::from_fn(|lane| DoubleDouble { hi: parts[0].0[lane], lo: parts[1].0[lane] })
        }
    }

    proptest! {
        #[test]
        fn second_method_sums_are_double_double(
            start in -1e3..1e3f64,
            terms in prop::collection::vec(prop::array::uniform16(-1.0..1.0f64), 1..20),
        ) {
            let together = pulp::Arch::new().dispatch(Sums(start, &terms));
            for (lane, together) in together.into_iter().enumerate() {
                let alone = terms.iter().fold(DoubleDouble::new(start), |sum, terms| sum.plus(terms[lane]));
                prop_assert_eq!(alone, together);
            }
        }
    }
}
