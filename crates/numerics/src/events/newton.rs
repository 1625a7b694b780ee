//! Roots of a rising polynomial by Newton's method, in a bracket or with proved accuracy.

use crate::simd::{PADDED, multiply_add, value};
use pulp::Simd;

/// Largest number of steps of Newton's method in a bracket. It is never reached, since a step that
/// leaves the bracket is replaced by a bisection.
const MAX_ITERATIONS: u32 = 200;

/// p(u) and p'(u).
#[inline(always)]
pub(super) fn value_and_slope<const N: usize>(c: &[f64; N], u: f64) -> (f64, f64) {
    let square = u * u;
    let mut sums = [0.0; 4]; // p even, p odd, p' even, p' odd
    for k in (0..N).rev() {
        sums[k % 2] = sums[k % 2] * square + c[k];
        if k > 0 {
            let slope = &mut sums[2 + (k - 1) % 2];
            *slope = *slope * square + k as f64 * c[k];
        }
    }
    (sums[0] + u * sums[1], sums[2] + u * sums[3])
}

/// Root of a rising p in (lo, hi), p(lo) < 0 < p(hi), to the resolution of u, by Newton's method
/// in a bracket.
///
/// Ends when a step is at round-off, or when the error of the last iterate is proved to be at
/// round-off. After a step of length m = `moved` with K m ≤ 1, where K = `newton_factor`, this
/// error is at most 4 K m². A step with K m > 1 never passes this test (docs/numerics.md, "The
/// root").
#[inline(always)]
pub(super) fn refine<const N: usize>(
    c: &[f64; N],
    (mut lo, mut hi): (f64, f64),
    start: f64,
    newton_factor: f64,
    iterations: &mut u64,
) -> f64 {
    let mut u = start;
    for _ in 0..MAX_ITERATIONS {
        *iterations += 1;
        let (p, d) = value_and_slope(c, u);
        if p < 0.0 {
            lo = u;
        } else if p > 0.0 {
            hi = u;
        } else {
            return u;
        }
        let moved = (p / d).abs();
        let resolution = f64::EPSILON * u.abs();
        let newton = u - p / d;
        if moved <= 2.0 * resolution {
            return newton.clamp(lo, hi);
        }
        if newton > lo && newton < hi {
            u = newton;
            if 4.0 * newton_factor * moved * moved <= resolution {
                return u;
            }
        } else {
            u = 0.5 * (lo + hi);
            if u <= lo || u >= hi {
                return hi; // the bracket has shrunk to adjacent doubles
            }
        }
    }
    u
}

/// Coefficients of `sign` times p'.
#[inline(always)]
pub(super) fn slope_of<const N: usize>(c: &[f64; N], sign: f64) -> [f64; N] {
    let mut d = [0.0; N];
    for k in 1..N {
        d[k - 1] = sign * k as f64 * c[k];
    }
    d
}

/// Root of a rising p in (lo, hi) by at most `STEPS` Newton steps from `start`, and one further
/// step that reuses the slope of the last step. `None` if the accuracy is not proved.
/// `newton_factor` is K = |p''|/(2p') < 1/4, so that few steps nearly always suffice.
#[inline(always)]
pub(super) fn root_of_nearly_straight<const STEPS: usize>(
    (value, slope): (impl Fn(f64) -> f64, impl Fn(f64) -> f64),
    start: f64,
    (lo, hi): (f64, f64),
    newton_factor: f64,
    iterations: &mut u64,
) -> Option<f64> {
    let mut u = start;
    for _ in 0..STEPS {
        if !(u > lo && u < hi) {
            return None;
        }
        *iterations += 1;
        let inverse = 1.0 / slope(u);
        let moved = value(u) * inverse;
        u -= moved;
        let resolution = f64::EPSILON * u.abs();
        // Bound on the error of u; see `refine`.
        let error = 4.0 * newton_factor * moved * moved;
        if error <= resolution {
            return (u > lo && u < hi).then_some(u);
        }
        // One further step with the slope of the last step. This slope was evaluated at most
        // `moved + error` from the root. Its error is at most max |p''| times this distance;
        // relative to p', at most 2K times this distance.
        if 2.0 * error * newton_factor * (moved.abs() + error) <= resolution {
            *iterations += 1;
            u -= value(u) * inverse;
            return (u > lo && u < hi).then_some(u);
        }
    }
    None
}

/// p(u) as four parallel sums, each over every fourth order.
#[inline(always)]
pub(super) fn by_fours<const N: usize>(c: &[f64; N], u: f64) -> f64 {
    let square = u * u;
    let (fourth, mut sums) = (square * square, [0.0; 4]);
    for four in c.chunks(4).rev() {
        for (k, sum) in sums.iter_mut().enumerate() {
            *sum = *sum * fourth + four.get(k).copied().unwrap_or(0.0);
        }
    }
    (sums[0] + sums[1] * u) + (sums[2] + sums[3] * u) * square
}

/// Root near 0 of a nearly straight p by third-order reversion of its series:
/// u = l - b l² + (2b² - t) l³ with l = -c0/c1, b = c2/c1, t = c3/c1.
#[inline(always)]
pub(super) fn reverted<const N: usize>(c: &[f64; N]) -> f64 {
    let scale = 1.0 / c[1];
    let linear = -c[0] * scale;
    let (bend, twist) = (c[2] * scale, c[3] * scale);
    linear * (1.0 - linear * (bend - linear * (2.0 * bend * bend - twist)))
}

/// Σ_k c[first + k] u^k by pairs of adjacent orders (Estrin's scheme), which shortens the chain of
/// dependent operations.
#[inline(always)]
pub(super) fn pairwise<S: Simd>(c: &[f64; PADDED], first: usize, u: f64) -> f64 {
    let square = u * u;
    let fourth = square * square;
    let pair = |k: usize| multiply_add::<S>(c[first + k + 1], u, c[first + k]);
    let low = multiply_add::<S>(pair(2), square, pair(0));
    let middle = multiply_add::<S>(pair(6), square, pair(4));
    multiply_add::<S>(pair(8), fourth * fourth, multiply_add::<S>(middle, fourth, low))
}

/// Passage of a p that rises on [lo, hi], where `low` is p(lo): `None` if p(hi) ≤ 0, and `lo` if
/// p(lo) ≥ 0.
#[inline(always)]
pub(super) fn rising<const N: usize>(
    c: &[f64; N],
    lo: f64,
    low: f64,
    hi: f64,
    newton_factor: f64,
    iterations: &mut u64,
) -> Option<f64> {
    let high = value(c, hi);
    if high <= 0.0 {
        return None;
    }
    if low >= 0.0 {
        return Some(lo);
    }
    let chord = lo - low * (hi - lo) / (high - low);
    let start = if chord > lo && chord < hi { chord } else { 0.5 * (lo + hi) };
    Some(refine(c, (lo, hi), start, newton_factor, iterations))
}
