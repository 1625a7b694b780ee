//! Values of polynomials, bit-identical for one argument and for several side by side.

use crate::model::{Augmented, COORDINATES};
use pulp::Simd;

/// Number of arguments of one call of [`at_places`]: their sums fit into registers.
pub(super) const PLACES: usize = 4;

/// `Σ_k coefficients[k] u^k`, coordinate by coordinate. Even and odd orders are summed apart: two
/// chains of dependent operations instead of one.
#[inline(always)]
pub fn polynomial<const N: usize, const W: usize>(coefficients: &[[f64; W]; N], u: f64) -> [f64; W] {
    let square = u * u;
    let (mut even, mut odd) = ([0.0; W], [0.0; W]);
    for k in (0..N).rev() {
        let sum = if k % 2 == 0 { &mut even } else { &mut odd };
        for (s, c) in sum.iter_mut().zip(&coefficients[k]) {
            *s = *s * square + c;
        }
    }
    std::array::from_fn(|j| even[j] + u * odd[j])
}

/// Values of a scalar polynomial at the ends of equal intervals of [0, 1], computed in vectors.
/// Bit-identical to [`polynomial`], because no operation is fused and the number N of orders is
/// even.
#[inline(always)]
pub(super) fn at_interval_ends<S: Simd, const N: usize, const INTERVALS: usize>(
    simd: S,
    coefficients: &[f64; N],
) -> [f64; INTERVALS] {
    const { assert!(N.is_multiple_of(2)) };
    let mut ends = [0.0; INTERVALS];
    for (i, end) in ends.iter_mut().enumerate() {
        *end = (i as f64 + 1.0) / INTERVALS as f64;
    }
    let mut values = [0.0; INTERVALS];
    for (u, value) in S::as_simd_f64s(&ends).0.iter().zip(S::as_mut_simd_f64s(&mut values).0) {
        let square = simd.mul_f64s(*u, *u);
        let (mut even, mut odd) = (simd.splat_f64s(0.0), simd.splat_f64s(0.0));
        for pair in coefficients.as_chunks::<2>().0.iter().rev() {
            even = simd.add_f64s(simd.mul_f64s(even, square), simd.splat_f64s(pair[0]));
            odd = simd.add_f64s(simd.mul_f64s(odd, square), simd.splat_f64s(pair[1]));
        }
        *value = simd.add_f64s(even, simd.mul_f64s(*u, odd));
    }
    values
}

/// Values of a polynomial of augmented states at [`PLACES`] arguments, bit-identical to
/// [`polynomial`]. The arguments' chains of dependent operations run side by side.
#[inline(always)]
pub(super) fn at_places<S: Simd, const N: usize>(
    simd: S,
    coefficients: &[Augmented; N],
    places: &[f64; PLACES],
) -> [Augmented; PLACES] {
    const { assert!(N.is_multiple_of(2)) };
    let zero = simd.splat_f64s(0.0);
    let mut states = [[0.0; COORDINATES]; PLACES];
    for v in 0..COORDINATES / S::F64_LANES {
        let (mut even, mut odd) = ([zero; PLACES], [zero; PLACES]);
        for pair in coefficients.as_chunks::<2>().0.iter().rev() {
            let (low, high) = (S::as_simd_f64s(&pair[0]).0[v], S::as_simd_f64s(&pair[1]).0[v]);
            for (i, u) in places.iter().enumerate() {
                let square = simd.splat_f64s(u * u);
                even[i] = simd.add_f64s(simd.mul_f64s(even[i], square), low);
                odd[i] = simd.add_f64s(simd.mul_f64s(odd[i], square), high);
            }
        }
        for (i, u) in places.iter().enumerate() {
            let value = simd.add_f64s(even[i], simd.mul_f64s(simd.splat_f64s(*u), odd[i]));
            S::as_mut_simd_f64s(&mut states[i]).0[v] = value;
        }
    }
    states
}
