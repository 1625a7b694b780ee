//! Numbers of several motions side by side in one of the machine's vectors, with the usual operators. Each place of a
//! vector is computed from the same place of the others alone.

use pulp::{Simd, bytemuck};
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

/// Motions side by side in memory: whole vectors of every machine.
pub(crate) const ROW: usize = 16;

/// One number of each motion, as it lies in memory.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Row(pub(crate) [f64; ROW]);

impl Row {
    pub(crate) const ZERO: Self = Self([0.0; ROW]);

    /// Vectors of a row.
    #[inline(always)]
    pub(crate) fn vectors<S: Simd>() -> usize {
        ROW / S::F64_LANES
    }
}

/// A vector.
#[derive(Clone, Copy)]
pub(crate) struct Wide<S: Simd> {
    simd: S,
    x: S::f64s,
}

/// A truth value in each place of a vector.
#[derive(Clone, Copy)]
pub(crate) struct Mask<S: Simd> {
    simd: S,
    m: S::m64s,
}

impl<S: Simd> Wide<S> {
    #[inline(always)]
    pub(crate) fn splat(simd: S, x: f64) -> Self {
        Self { simd, x: simd.splat_f64s(x) }
    }

    /// Vector `v` of a row.
    #[inline(always)]
    pub(crate) fn of(simd: S, row: &Row, v: usize) -> Self {
        Self { simd, x: S::as_simd_f64s(&row.0).0[v] }
    }

    /// Vector `v` of each row.
    #[inline(always)]
    pub(crate) fn of_each<const N: usize>(simd: S, rows: &[Row; N], v: usize) -> [Self; N] {
        let mut all = [Self::splat(simd, 0.0); N];
        for (one, row) in all.iter_mut().zip(rows) {
            *one = Self::of(simd, row, v);
        }
        all
    }

    /// Σ_j rows[j] x_j.
    #[inline(always)]
    pub(crate) fn dot<const N: usize>(simd: S, rows: &[Row; N], v: usize, x: &[Self; N]) -> Self {
        let mut sum = Self::of(simd, &rows[0], v) * x[0];
        for (row, x) in rows.iter().zip(x).skip(1) {
            sum = Self::of(simd, row, v).mul_add(*x, sum);
        }
        sum
    }

    /// Becomes vector `v` of a row.
    #[inline(always)]
    pub(crate) fn put(self, row: &mut Row, v: usize) {
        S::as_mut_simd_f64s(&mut row.0).0[v] = self.x;
    }

    /// The same number everywhere.
    #[inline(always)]
    pub(crate) fn all(self, x: f64) -> Self {
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

    #[inline(always)]
    pub(crate) fn less(self, b: Self) -> Mask<S> {
        Mask { simd: self.simd, m: self.simd.less_than_f64s(self.x, b.x) }
    }

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
    /// The first place is the lowest bit's.
    #[inline(always)]
    pub(crate) fn of(simd: S, bits: u64) -> Self {
        const PLACES: [u64; 8] = [1, 2, 4, 8, 16, 32, 64, 128];
        let places = S::as_simd_u64s(&PLACES).0[0];
        Self { simd, m: simd.equal_u64s(simd.and_u64s(simd.splat_u64s(bits), places), places) }
    }

    #[inline(always)]
    pub(crate) fn select(self, yes: Wide<S>, no: Wide<S>) -> Wide<S> {
        Wide { simd: self.simd, x: self.simd.select_f64s(self.m, yes.x, no.x) }
    }

    /// A bit for each place that holds true, the first place's the lowest.
    #[inline(always)]
    pub(crate) fn bits(self) -> u64 {
        if size_of::<S::m64s>() == 1 {
            return u64::from(bytemuck::bytes_of(&self.m)[0]);
        }
        let (ones, none) = (self.simd.splat_u64s(u64::MAX), self.simd.splat_u64s(0));
        let ones = self.simd.select_u64s(self.m, ones, none);
        let places: &[u64] = bytemuck::cast_slice(std::slice::from_ref(&ones));
        let mut bits = 0;
        for (place, ones) in places.iter().enumerate() {
            bits |= (ones >> 63) << place;
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

/// Sums in extended precision, place by place: the formulas of [`crate::numerics::double_double`].
#[derive(Clone, Copy)]
pub(crate) struct WideDoubleDouble<S: Simd> {
    pub(crate) hi: Wide<S>,
    pub(crate) lo: Wide<S>,
}

impl<S: Simd> WideDoubleDouble<S> {
    #[inline(always)]
    pub(crate) fn plus(self, b: Wide<S>) -> Self {
        let sum = self.hi + b;
        let t = sum - self.hi;
        let lo = ((self.hi - (sum - t)) + (b - t)) + self.lo;
        let hi = sum + lo;
        Self { hi, lo: lo - (hi - sum) }
    }
}
