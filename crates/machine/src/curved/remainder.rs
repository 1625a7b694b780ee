//! The remainder of a power series with curved forces (docs/assembly-law.md, section 20).

use super::series::tail;
use super::{CurveSeries, Polynomial};

/// Largest error of a series in the norm of (A6), relative to the largest term of the states. This
/// is half the spacing of doubles at 1.
const REMAINDER: f64 = 1e-16;
/// Size of the last two terms, relative to the largest of the first three, at the span with which
/// the search for the longest span begins.
const LAST: f64 = 1e-17;
/// Largest number of times a span is shortened.
const SHORTENINGS: usize = 100;
/// Relative allowance for the rounding error of a sum of coefficients.
const ROOM: f64 = 1e-12;
/// Largest exponent of the growth of an error within a span.
const GROWTH: f64 = 20.0;

/// A curved force with its series, and the norms of its row and its column.
pub(crate) struct CurveTerms<'a> {
    /// The force.
    pub(crate) force: Polynomial,
    /// Its series.
    pub(crate) series: &'a CurveSeries,
    /// Norm of the row of its argument: Σ |ℓᵢ| wᵢ.
    pub(crate) reach: f64,
    /// Norm of its column in z': max |yᵢ| / wᵢ.
    pub(crate) effect: f64,
    /// C with |xₖ| ≤ C radius⁻ᵏ; set by [`Remainder::prepare`].
    pub(crate) scale: f64,
    /// Σ |xₖ| over the longest fraction that is tried; set by [`Remainder::prepare`].
    pub(crate) most: f64,
}

/// Data for a bound on the remainder of a power series over a fraction of the span.
pub(crate) struct Remainder<'a> {
    /// Length of the span of the computed series, s.
    pub(crate) span: f64,
    /// Norm of A, 1/s.
    pub(crate) rate: f64,
    /// Norm of the terms of each order, without the coordinates of curved forces.
    pub(crate) norms: &'a [f64],
    /// Norm of the terms of each order, for states only: without the constant 1, signals and
    /// curved forces.
    pub(crate) sizes: &'a [f64],
    /// The curved forces.
    pub(crate) curves: &'a mut [CurveTerms<'a>],
}

impl Remainder<'_> {
    /// Order of the last term.
    fn last(&self) -> usize {
        self.norms.len() - 1
    }

    /// Norm of the largest term of the states, with time in units of `part` times the span.
    fn size(&self, part: f64) -> f64 {
        let mut power = 1.0;
        let mut most = 0.0f64;
        for size in self.sizes {
            most = most.max(size * power);
            power *= part;
        }
        most
    }

    /// Sets what the bounds over all fractions up to `part` have in common.
    #[inline(always)]
    pub(crate) fn prepare(&mut self, part: f64, radius: f64) {
        let last = self.last();
        for terms in self.curves.iter_mut() {
            terms.scale = terms.series.scale(radius, last);
            terms.most = terms.series.sum_of_sizes(part, last);
        }
    }

    /// Bound (A59) of the error of the series within the fraction `part` of the span: the integral
    /// of the polynomial's defect times the growth factor of an error. The bound is valid if it is
    /// at most `margin`.
    ///
    /// The tails of the curved forces come from |xₖ| ≤ C radius⁻ᵏ, with the least C for the given
    /// `radius` (in units of the span). Every radius larger than `part` gives a valid bound.
    #[inline(always)]
    pub(crate) fn bound(&self, part: f64, radius: f64, margin: f64) -> f64 {
        let last = self.last();
        let h = self.span * part;
        let (mut defect, mut growth) = (self.rate * self.norms[last] * part.powi(last as i32), self.rate);
        let ratio = radius / part;
        let power = ratio.powi(-(last as i32));
        for CurveTerms { force, reach, effect, scale, most, .. } in self.curves.iter() {
            defect += effect * tail(force, *scale, (ratio, power), last);
            let most = most * (1.0 + ROOM) + reach * margin;
            growth += effect * force.majorant().derivative(most) * reach;
        }
        let exponent = growth * h;
        if exponent > GROWTH {
            return f64::INFINITY;
        }
        let growth = if exponent > 0.0 { exponent.exp_m1() / exponent } else { 1.0 };
        h * defect * growth
    }

    /// The longest fraction of the span, at most `most`, over which the remainder is proved to be
    /// below rounding. 0 if none is found.
    #[inline(always)]
    pub(crate) fn longest(&mut self, most: f64) -> f64 {
        let last = self.last();
        let largest = |terms: &[f64]| terms.iter().fold(0.0f64, |a, b| a.max(*b));
        let first = largest(&self.sizes[..3.min(self.sizes.len())]);
        // States at rest have no size: the signals then give one.
        let size = if first > 0.0 { first } else { largest(&self.norms[..3.min(self.norms.len())]) };
        let at_rest = largest(self.sizes) == 0.0;
        let mut part = most;
        for k in [last - 1, last] {
            if self.norms[k] > 0.0 {
                part = part.min((LAST * size / self.norms[k]).powf(1.0 / k as f64));
            }
        }
        // With this radius as the unit of time, the last terms are about as large as the first
        // ones.
        let radius = part * (1.0 / LAST).powf(1.0 / last as f64);
        self.prepare(part, radius);
        for _ in 0..SHORTENINGS {
            let limit = REMAINDER * if at_rest { size } else { self.size(part) };
            let bound = self.bound(part, radius, limit);
            if bound <= limit {
                return part;
            }
            let factor = 0.98 * (limit / bound).powf(1.0 / last as f64);
            part *= if factor.is_finite() { factor.clamp(0.1, 0.98) } else { 0.5 };
        }
        0.0
    }
}
