//! Guaranteed event location on a polynomial: the first passage from ≤ 0 to > 0, or a proof that
//! none exists.
//!
//! # Why it is so
//!
//! A missed event changes all of the later motion, and a simulator that samples can always miss an
//! event between two samples. This module searches a polynomial instead: the Taylor coefficients
//! of the event functional on |u| ≤ 1, truncated where the remainder is under round-off
//! (`docs/numerics.md`, "Events"). The sizes of the coefficients bound the polynomial, its slope
//! and its curvature on the whole interval. Three methods use these bounds in turn:
//!
//! - **Dominance.** If the size of the constant term of p' or p'' exceeds the sum of the other
//!   coefficients' sizes, p is monotone, convex or concave on all of |u| ≤ 1. Its values and
//!   slopes at the ends then determine whether it passes zero. This holds for all u at once;
//!   nothing is sampled.
//! - **Bisection** of the interval, with the coefficients about each half's centre, until
//!   dominance holds on every piece or the coefficients' sizes bound p below zero there.
//! - **Newton's method in a bracket** for the root itself; in flight it starts from the
//!   third-order reversion of the series.
//!
//! # What must not change without proof
//!
//! - The order of operations in the flight path ([`flight_crossing`]) and in [`first_crossing`]:
//!   the motions' bits depend on it (`tests/state_bits.rs`, `golden_*` in `events/tests.rs`).
//! - The constants `MAX_DEPTH`, `MAX_COEFFICIENTS` and `MAX_PIECES`, which together bound the
//!   work: docs/numerics.md, "Second stage".
//! - The criteria by which Newton's method ends: docs/numerics.md, "The root";
//!   `closed_form_the_newton_criterion_holds_up_to_its_largest_factor`.
//!
//! # Changes
//!
//! - A faster path for a special shape, such as [`flight_crossing`]: it may return only an answer
//!   that it has proved, and otherwise calls [`first_crossing`]. Its test is a second method that
//!   compares both on random polynomials (`second_method_nearly_straight_passages`).
//! - More coefficients: raise `MAX_COEFFICIENTS` and prove the number of pieces again.

mod newton;

use crate::simd::{PADDED, value, weighted};
use newton::{
    by_fours, pairwise, refine, reverted, rising, root_of_nearly_straight, slope_of, value_and_slope,
};
use pulp::Simd;

/// Largest number of halvings of an interval. A piece is then 2⁻⁵⁵ long, less than the spacing of
/// the doubles near ±1.
const MAX_DEPTH: u32 = 56;
/// Largest number of coefficients of a searched polynomial; sufficient for the series of described
/// machines.
const MAX_COEFFICIENTS: usize = 40;
/// Largest number of examined pieces. A polynomial of up to [`MAX_COEFFICIENTS`] coefficients
/// needs fewer, nearly always less than a hundred (docs/numerics.md, "Second stage").
const MAX_PIECES: u32 = 250_000;
/// Largest bound K on |p''|/(2p') with which a short Newton step proves the accuracy of the next
/// iterate; see [`refine`]. The proof holds for any K far below 1/ε.
const MAX_NEWTON_FACTOR: f64 = 1e4;
/// Bound K on |p''|/(2p') below which a polynomial is nearly straight: its curvature is less than
/// half its smallest slope.
const STRAIGHT: f64 = 0.25;

/// Factors k of the coefficients of order k in p'.
const ORDERS: [f64; PADDED] = orders(0);
/// Factors k - 1 that lead from p' to p''.
const LOWER: [f64; PADDED] = orders(1);

/// Factors k for the longest polynomial, padded to a multiple of four.
const PLACES: [f64; MAX_COEFFICIENTS.next_multiple_of(4)] = orders(0);

const fn orders<const N: usize>(less: usize) -> [f64; N] {
    let mut k = [0.0; N];
    let mut i = 1;
    while i < N {
        k[i] = (i - less) as f64;
        i += 1;
    }
    k
}

/// Shape of p on |u| ≤ 1, from the sign of p' or p''. `Unknown` if neither sign is certain.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Shape {
    Rising,
    Falling,
    Convex,
    Concave,
    Unknown,
}

/// Shape of p by dominance and, for a rising p, a bound K on |p''|/(2p') over |u| ≤ 1. A Newton
/// step from an error e leaves an error of at most K e² (Taylor's formula with p'' in the
/// remainder). K is infinite for other shapes and if it would exceed [`MAX_NEWTON_FACTOR`].
#[inline(always)]
fn shape<const N: usize>(c: &[f64; N]) -> (Shape, f64) {
    // Sums of the sizes of the coefficients of p' and p'', in four chains each. The constant term
    // is first added with the opposite sign, so that it cancels.
    let d = slope_of(c, 1.0);
    let (mut slopes, mut curvatures) = ([-d[0].abs(), 0.0, 0.0, 0.0], [0.0, -d[1].abs(), 0.0, 0.0]);
    for (four, orders) in d.chunks(4).zip(PLACES.as_chunks::<4>().0) {
        for (k, x) in four.iter().enumerate() {
            slopes[k] += x.abs();
            curvatures[k] += orders[k] * x.abs();
        }
    }
    let [slope, curvature] = [slopes, curvatures].map(|[a, b, c, d]| (a + b) + (c + d));
    if c[1] > slope {
        let factor = 0.5 * (2.0 * c[2].abs() + curvature) / (c[1] - slope);
        return (Shape::Rising, if factor <= MAX_NEWTON_FACTOR { factor } else { f64::INFINITY });
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

/// [`first_crossing`] for a p of known shape; `None` for an unknown shape.
#[inline(always)]
fn crossing_of_shape<const N: usize>(
    c: &[f64; N],
    (shape, newton_factor): (Shape, f64),
    lo: f64,
    hi: f64,
    iterations: &mut u64,
) -> Option<f64> {
    let (low, low_slope) = value_and_slope(c, lo);
    match shape {
        Shape::Rising => rising(c, lo, low, hi, newton_factor, iterations),
        Shape::Falling | Shape::Unknown => None,
        Shape::Convex => {
            if low_slope >= 0.0 {
                return rising(c, lo, low, hi, newton_factor, iterations);
            }
            if value(c, hi) <= 0.0 {
                return None;
            }
            // p falls to its minimum and then rises to a positive end.
            let slope = slope_of(c, 1.0);
            let bottom = refine(&slope, (lo, hi), 0.5 * (lo + hi), f64::INFINITY, iterations);
            rising(c, bottom, value(c, bottom), hi, newton_factor, iterations)
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
            rising(c, lo, low, top, newton_factor, iterations)
        }
    }
}

/// [`first_crossing`] for the relative displacement in free flight, whose coefficients from order
/// ten on are zero. Nearly always the polynomial rises and is nearly straight: its curvature is
/// less than half its smallest slope, so that K = |p''|/(2p') < 1/4. Newton's method, started from
/// the third-order reversion of the series, then takes one or two steps with proved accuracy. A
/// root found inside is the only one.
///
/// Finds every passage that [`first_crossing`] finds. It may also find a root within rounding of
/// `hi` where `first_crossing` finds none, because it uses the sign of the computed p(hi).
#[inline(always)]
pub fn flight_crossing<S: Simd>(
    simd: S,
    c: &[f64; PADDED],
    lo: f64,
    hi: f64,
    iterations: &mut u64,
) -> Option<f64> {
    // The coefficients of the slope are k c_k; the curvature has k (k-1) c_k.
    let (slope, sum, curvature) = weighted(simd, c, &ORDERS, &LOWER);
    let spare = c[1] - (sum - c[1].abs());
    if !(spare > 0.0 && curvature < 0.5 * spare) {
        return first_crossing(c, lo, hi, iterations);
    }
    let newton_factor = 0.5 * curvature / spare;
    let functions = (|u| pairwise::<S>(c, 0, u), |u| pairwise::<S>(&slope, 1, u));
    root_of_nearly_straight::<1>(functions, reverted(c), (lo, hi), newton_factor, iterations)
        .or_else(|| rising(c, lo, value(c, lo), hi, newton_factor, iterations))
}

/// [`first_crossing`] on [0, hi]. If p rises on all of |u| ≤ 1, Newton's method starts from the
/// third-order reversion of the series, whose error is small on the short intervals of a described
/// machine.
#[inline(always)]
pub fn crossing_after_start<const N: usize>(c: &[f64; N], hi: f64, iterations: &mut u64) -> Option<f64> {
    let (Shape::Rising, newton_factor) = shape(c) else { return any_crossing(c, hi, iterations) };
    if c[0] < 0.0 && newton_factor < STRAIGHT {
        let slope = slope_of(c, 1.0);
        let functions = (|u| by_fours(c, u), |u| by_fours(&slope, u));
        let root = root_of_nearly_straight::<3>(functions, reverted(c), (0.0, hi), newton_factor, iterations);
        if root.is_some() {
            return root;
        }
    }
    rising(c, 0.0, c[0], hi, newton_factor, iterations)
}

/// [`first_crossing`] on [0, hi], not inlined so that the frequent path stays short.
#[cold]
#[inline(never)]
fn any_crossing<const N: usize>(c: &[f64; N], hi: f64, iterations: &mut u64) -> Option<f64> {
    first_crossing(c, 0.0, hi, iterations)
}

/// Coefficients in v of p(mid + half v).
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

/// First u in `[lo, hi] ⊂ [-1, 1]` at which p passes from ≤ 0 to > 0. A touch from below does not
/// count as a passage. Neither does a zero exactly at `hi`: the search that begins at `hi` finds
/// it.
///
/// Requires p(lo) ≤ 0 up to rounding. A positive p(lo) counts as zero: the answer is `lo` if p
/// rises or is constant there, and the next passage if p falls. (So `0.5 + u²` on [0, 1], which
/// violates the requirement, gives 0.)
///
/// `None` proves that p, with the coefficients as given, nowhere passes zero by more than
/// `4 N² ε Σ|c_k|` (docs/numerics.md, "Second stage").
#[inline(always)]
pub fn first_crossing<const N: usize>(c: &[f64; N], lo: f64, hi: f64, iterations: &mut u64) -> Option<f64> {
    const { assert!(N <= MAX_COEFFICIENTS, "the bound on the number of pieces is proved up to here") };
    match shape(c) {
        (Shape::Unknown, _) => subdivide(c, lo, hi, 0, &mut { MAX_PIECES }, iterations),
        known => crossing_of_shape(c, known, lo, hi, iterations),
    }
}

/// Visits in order the turning points in [lo, hi] ⊂ [-1, 1] of a quantity whose rate is p. A
/// turning point is where p passes zero by more than the rounding of its sign. `rising` is whether
/// the quantity rises: at `lo` on entry, at `hi` on return. `visit` receives u and a flag that is
/// true if the quantity rose before u, so that u is a maximum.
///
/// The search for the next turning point begins where p is certainly beyond zero: from a computed
/// zero it could find the same zero again and again.
#[inline(always)]
pub fn turns<const N: usize>(
    p: &[f64; N],
    (mut lo, hi): (f64, f64),
    rising: &mut bool,
    mut visit: impl FnMut(f64, bool),
) {
    // A polynomial has no more zeros than its degree.
    for _ in 0..N {
        let sought = if *rising { p.map(|c| -c) } else { *p };
        let Some((u, turned)) = certain_crossing(&sought, lo, hi) else { break };
        visit(u, *rising);
        (*rising, lo) = (!*rising, turned);
    }
}

/// First passage of p from below zero to more than the rounding of its sign above zero; this
/// rounding is `4 N² ε Σ|c_k|`, as for [`first_crossing`]. Returns the zero and the point at which
/// p exceeds the rounding.
#[inline(always)]
fn certain_crossing<const N: usize>(c: &[f64; N], lo: f64, hi: f64) -> Option<(f64, f64)> {
    let sizes: f64 = c.iter().map(|x| x.abs()).sum();
    let mut lower = *c;
    lower[0] -= (4 * N * N) as f64 * f64::EPSILON * sizes;
    let above = first_crossing(&lower, lo, hi, &mut 0)?;
    Some((first_crossing(c, lo, above, &mut 0).unwrap_or(above), above))
}

/// Change of sign of the computed p from ≤ 0 to > 0 in [lo, hi], by bisection, on a piece where
/// |p| is within its rounding. `None` unless p(hi) > 0; `lo` if p(lo) > 0, too.
fn change_of_sign<const N: usize>(c: &[f64; N], mut lo: f64, mut hi: f64) -> Option<f64> {
    if value(c, hi) <= 0.0 {
        return None;
    }
    if value(c, lo) > 0.0 {
        return Some(lo);
    }
    for _ in 0..MAX_DEPTH {
        let mid = 0.5 * (lo + hi);
        *(if value(c, mid) > 0.0 { &mut hi } else { &mut lo }) = mid;
    }
    Some(lo)
}

/// [`first_crossing`] by bisection until the shape of p is certain on every piece; needed about
/// once in thousands of sub-steps.
///
/// On a piece where |p| is within its rounding, halving does not help: the signs of the computed p
/// decide (docs/numerics.md, "Second stage").
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
    let sizes: f64 = c.iter().map(|x| x.abs()).sum();
    if local[0].abs() + spread <= N as f64 * f64::EPSILON * sizes {
        return change_of_sign(c, lo, hi);
    }
    match shape(&local) {
        (Shape::Unknown, _) if depth < MAX_DEPTH && *pieces > 0 => {
            subdivide(c, lo, mid, depth + 1, pieces, iterations)
                .or_else(|| subdivide(c, mid, hi, depth + 1, pieces, iterations))
        }
        (Shape::Unknown, _) => change_of_sign(c, lo, hi),
        known => crossing_of_shape(&local, known, -1.0, 1.0, iterations).map(|v| mid + half * v),
    }
}

#[cfg(test)]
mod tests;
