//! Guaranteed event location on a polynomial: the first passage from ≤ 0 to > 0, or the proof that there is none.
//!
//! The coefficients come from the exact flow with a truncation far under round-off, so what is decided here is
//! decided for the motion. The proof is by dominance: where one derivative's constant term outweighs the rest of its
//! coefficients the polynomial is monotone, convex or concave and its sign pattern is known; where none does, the
//! interval is bounded and halved. Nothing is sampled.

use crate::numerics::simd::{PADDED, multiply_add, value, weighted};
use pulp::Simd;

/// A bracket is halved at most this often: then its width is under the resolution of a double.
const MAX_DEPTH: u32 = 56;
/// A polynomial of degree 11 is settled in some dozens of pieces; one that is round-off throughout would never be.
const MAX_PIECES: u32 = 2000;
/// Newton's method inside a bracket; every failing step bisects, so this is never reached.
const MAX_ITERATIONS: u32 = 200;

/// k and k - 1.
const ORDERS: [f64; PADDED] = orders(0);
const LOWER: [f64; PADDED] = orders(1);

const fn orders(less: usize) -> [f64; PADDED] {
    let mut k = [0.0; PADDED];
    let mut i = 1;
    while i < PADDED {
        k[i] = (i - less) as f64;
        i += 1;
    }
    k
}

/// p(u) and p'(u).
#[inline(always)]
fn value_and_slope<const N: usize>(c: &[f64; N], u: f64) -> (f64, f64) {
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

/// The sign pattern of p on |u| ≤ 1, where it is certain.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Shape {
    Rising,
    Falling,
    Convex,
    Concave,
    Unknown,
}

/// The shape, and for a rising p a bound on |p''|/(2p'), by which Newton's method squares its error.
#[inline(always)]
fn shape<const N: usize>(c: &[f64; N]) -> (Shape, f64) {
    let (mut slopes, mut curvatures) = ([0.0; 2], [0.0; 2]); // two chains each
    for (k, &ck) in c.iter().enumerate().skip(2) {
        let weight = k as f64 * ck.abs();
        slopes[k % 2] += weight;
        if k > 2 {
            curvatures[k % 2] += (k - 1) as f64 * weight;
        }
    }
    let (slope, curvature) = (slopes[0] + slopes[1], curvatures[0] + curvatures[1]);
    if c[1] > slope {
        return (Shape::Rising, 0.5 * (2.0 * c[2].abs() + curvature) / (c[1] - slope));
    }
    let shape = if -c[1] > slope {
        Shape::Falling
    } else if 2.0 * c[2] > curvature {
        Shape::Convex
    } else if -2.0 * c[2] > curvature {
        Shape::Concave
    } else {
        Shape::Unknown
    };
    (shape, f64::INFINITY)
}

/// The root of a rising p in (lo, hi), p(lo) < 0 < p(hi), to the resolution of u. Newton's method inside a bracket; it
/// ends when a step is at round-off, or when `squares` (a bound on |p''|/(2p')) proves that the next one would be.
#[inline(always)]
fn refine<const N: usize>(
    c: &[f64; N],
    (mut lo, mut hi): (f64, f64),
    start: f64,
    squares: f64,
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
            if 4.0 * squares * moved * moved <= resolution {
                return u;
            }
        } else {
            u = 0.5 * (lo + hi);
            if u <= lo || u >= hi {
                return hi; // the bracket has closed on neighbouring doubles
            }
        }
    }
    u
}

/// Negates the odd or all coefficients so that `refine` can look for a sign change of the slope.
#[inline(always)]
fn slope_of<const N: usize>(c: &[f64; N], sign: f64) -> [f64; N] {
    let mut d = [0.0; N];
    for k in 1..N {
        d[k - 1] = sign * k as f64 * c[k];
    }
    d
}

/// Where p of known shape first passes from ≤ 0 to > 0 in [lo, hi] ⊂ [-1, 1].
#[inline(always)]
fn crossing_of_shape<const N: usize>(
    c: &[f64; N],
    (shape, squares): (Shape, f64),
    lo: f64,
    hi: f64,
    iterations: &mut u64,
) -> Option<f64> {
    let (low, low_slope) = value_and_slope(c, lo);
    match shape {
        Shape::Rising => rising(c, lo, low, hi, squares, iterations),
        Shape::Falling | Shape::Unknown => None,
        Shape::Convex => {
            if low_slope >= 0.0 {
                return rising(c, lo, low, hi, squares, iterations);
            }
            if value(c, hi) <= 0.0 {
                return None;
            }
            // Past its minimum p rises to a positive end; before it, it can only fall.
            let slope = slope_of(c, 1.0);
            let bottom = refine(&slope, (lo, hi), 0.5 * (lo + hi), f64::INFINITY, iterations);
            rising(c, bottom, value(c, bottom), hi, squares, iterations)
        }
        Shape::Concave => {
            if low_slope <= 0.0 {
                return None;
            }
            if low >= 0.0 {
                return Some(lo);
            }
            let slope = slope_of(c, -1.0);
            let top = if value(&slope, hi) <= 0.0 {
                hi
            } else {
                refine(&slope, (lo, hi), 0.5 * (lo + hi), f64::INFINITY, iterations)
            };
            rising(c, lo, low, top, squares, iterations)
        }
    }
}

/// [`first_crossing`] for the gap of a free flight, whose orders from ten on are zero. Nearly always the gap rises
/// and is nearly straight: then Newton's method from the inverse series proves its own end, and a root inside is the only one.
#[inline(always)]
pub fn flight_crossing<S: Simd>(
    simd: S,
    c: &[f64; PADDED],
    lo: f64,
    hi: f64,
    iterations: &mut u64,
) -> Option<f64> {
    // k c_k are the slope's coefficients, k (k-1) c_k the curvature's.
    let (slope, sum, curvature) = weighted(simd, c, &ORDERS, &LOWER);
    let spare = c[1] - (sum - c[1].abs());
    if !(spare > 0.0 && curvature < 0.5 * spare) {
        return first_crossing(c, lo, hi, iterations);
    }
    let squares = 0.5 * curvature / spare;
    let scale = 1.0 / c[1];
    let linear = -c[0] * scale;
    let (bend, twist) = (c[2] * scale, c[3] * scale);
    let mut u = linear * (1.0 - linear * (bend - linear * (2.0 * bend * bend - twist)));
    if u > lo && u < hi {
        *iterations += 1;
        let inverse = 1.0 / pairwise::<S>(&slope, 1, u);
        let moved = pairwise::<S>(c, 0, u) * inverse;
        u -= moved;
        let resolution = f64::EPSILON * u.abs();
        // Newton's method squares the error: it is now at most `error`.
        let error = 4.0 * squares * moved * moved;
        if error <= resolution && u > lo && u < hi {
            return Some(u);
        }
        // A second step with the slope of the first: |p''| times the way to there is all by which that slope is wrong.
        *iterations += 1;
        u -= pairwise::<S>(c, 0, u) * inverse;
        if 2.0 * error * squares * (moved.abs() + error) <= resolution && u > lo && u < hi {
            return Some(u);
        }
    }
    rising(c, lo, value(c, lo), hi, squares, iterations)
}

/// Σ_k c[first + k] u^k by pairs of neighbouring orders, so that nothing waits long for anything.
#[inline(always)]
fn pairwise<S: Simd>(c: &[f64; PADDED], first: usize, u: f64) -> f64 {
    let square = u * u;
    let fourth = square * square;
    let pair = |k: usize| multiply_add::<S>(c[first + k + 1], u, c[first + k]);
    let low = multiply_add::<S>(pair(2), square, pair(0));
    let middle = multiply_add::<S>(pair(6), square, pair(4));
    multiply_add::<S>(pair(8), fourth * fourth, multiply_add::<S>(middle, fourth, low))
}

/// The passage of a p that rises on [lo, hi].
#[inline(always)]
fn rising<const N: usize>(
    c: &[f64; N],
    lo: f64,
    low: f64,
    hi: f64,
    squares: f64,
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
    Some(refine(c, (lo, hi), start, squares, iterations))
}

/// The polynomial in v of p(mid + half v).
fn recentred<const N: usize>(c: &[f64; N], mid: f64, half: f64) -> [f64; N] {
    let mut r = *c;
    for first in 0..N - 1 {
        for k in (first..N - 1).rev() {
            r[k] += mid * r[k + 1];
        }
    }
    let mut scale = 1.0;
    for rk in &mut r {
        *rk *= scale;
        scale *= half;
    }
    r
}

/// The first u in `[lo, hi] ⊂ [-1, 1]` at which p passes from ≤ 0 to > 0; `lo` itself where p(lo) ≥ 0 and rises.
/// `None` is a proof that there is no passage. A touch from below without passing is none.
#[inline(always)]
pub fn first_crossing<const N: usize>(c: &[f64; N], lo: f64, hi: f64, iterations: &mut u64) -> Option<f64> {
    match shape(c) {
        (Shape::Unknown, _) => subdivide(c, lo, hi, 0, &mut { MAX_PIECES }, iterations),
        known => crossing_of_shape(c, known, lo, hi, iterations),
    }
}

/// Halves the interval until the shape of p is certain on every piece; taken about once in thousands of sub-steps.
#[cold]
#[inline(never)]
fn subdivide<const N: usize>(
    c: &[f64; N],
    lo: f64,
    hi: f64,
    depth: u32,
    pieces: &mut u32,
    iterations: &mut u64,
) -> Option<f64> {
    *iterations += 1;
    *pieces = pieces.saturating_sub(1);
    let (mid, half) = (0.5 * (lo + hi), 0.5 * (hi - lo));
    let local = recentred(c, mid, half);
    let spread: f64 = local[1..].iter().map(|x| x.abs()).sum();
    if local[0] + spread <= 0.0 {
        return None;
    }
    match shape(&local) {
        (Shape::Unknown, _) if depth < MAX_DEPTH && *pieces > 0 => {
            subdivide(c, lo, mid, depth + 1, pieces, iterations)
                .or_else(|| subdivide(c, mid, hi, depth + 1, pieces, iterations))
        }
        // Narrower than a double resolves, or nothing but its noise: the sign at the end decides.
        (Shape::Unknown, _) => (value(&local, 1.0) > 0.0).then_some(lo),
        known => crossing_of_shape(&local, known, -1.0, 1.0, iterations).map(|v| mid + half * v),
    }
}

#[cfg(test)]
mod tests;
