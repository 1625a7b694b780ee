//! Time scale of a power series with curved forces, from the norms of its own terms.
//!
//! The scale of a motion under curved forces changes with its amplitude. It is not estimated in
//! advance: the last terms show how fast the coordinates change, for any cause.

use super::LAST_CURVE_ORDER;

/// Norms of (A6) of a term: of the displacements, the velocities and the inner states.
pub(crate) type GroupNorms = [f64; 3];

/// Orders among which the largest term is sought: bodies may start from rest.
const FIRST: usize = LAST_CURVE_ORDER / 2;
/// Limit for the last terms, relative to the first terms. The time after which they reach it is
/// the inverse of the pace.
const LAST: f64 = 1e-17;
/// Fraction of the radius of convergence at which terms are compared. The last terms are
/// [`LAST`] there.
const PART: f64 = 0.25;
/// Factor for the span of a series whose terms overflow.
const OVERFLOW: f64 = 1e-3;

/// Binary exponent of a positive number.
fn exponent(x: f64) -> i64 {
    (x.to_bits() >> 52) as i64
}

/// Exponent n of 2 such that a span is about 2ⁿ times the radius of convergence that the terms of
/// the series suggest. `None` if all last terms are 0.
#[inline(always)]
fn excess(norms: &[GroupNorms]) -> Option<i64> {
    let last = LAST_CURVE_ORDER;
    let of_group = |group: usize| {
        if norms[last][group] == 0.0 {
            return None;
        }
        let top = exponent(norms[last][group]);
        let by_order = (0..FIRST).filter(|k| norms[*k][group] > 0.0);
        by_order.map(|k| (top - exponent(norms[k][group])).div_euclid((last - k) as i64)).min()
    };
    (0..3).filter_map(of_group).max().map(|n| n + 1)
}

/// A shorter span for a series whose terms overflow, or whose span exceeds the radius of
/// convergence by more than the factor 2^`most`. `None` if the series can be used.
#[inline(always)]
pub(crate) fn shortened(span: f64, is_finite: bool, norms: &[GroupNorms], most: i64) -> Option<f64> {
    if span < f64::MIN_POSITIVE {
        return None;
    }
    if !is_finite {
        return Some(span * OVERFLOW);
    }
    excess(norms).filter(|n| *n > most).map(|n| span * 0.5f64.powi(n as i32))
}

/// The longest part of a span, about, over which the last terms of each group are at most `limit`
/// of the first ones.
#[inline(always)]
pub(crate) fn part(norms: &[GroupNorms], limit: f64) -> f64 {
    // For each of the two last orders the least first term over the last one.
    let mut ratios = [f64::INFINITY; 2];
    for group in 0..3 {
        let (mut first, mut power) = (0.0f64, 1.0);
        for norm in &norms[..FIRST] {
            first = first.max(norm[group] * power);
            power *= PART;
        }
        for (ratio, norm) in ratios.iter_mut().zip(&norms[LAST_CURVE_ORDER - 1..]) {
            if norm[group] > 0.0 && first > 0.0 {
                *ratio = ratio.min(first / norm[group]);
            }
        }
    }
    let order = LAST_CURVE_ORDER as f64;
    (limit * ratios[0]).powf(1.0 / (order - 1.0)).min((limit * ratios[1]).powf(1.0 / order))
}

/// Rate at which the coordinates change, 1/s: the inverse of the time after which the last terms
/// are rounding. 0 if they are 0.
#[inline(always)]
pub(super) fn pace(norms: &[GroupNorms], span: f64) -> f64 {
    1.0 / (span * part(norms, LAST))
}
