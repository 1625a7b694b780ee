//! The remainder of a power series with curved forces (docs/assembly-law.md, section 20).

use super::series::tail;
use super::{CurveSeries, Operation};

/// Largest error of a series in the norm of (A6), relative to the largest term of the states. This
/// is half the spacing of doubles at 1.
const REMAINDER: f64 = 1e-16;
/// Size of the last two terms, relative to the largest of the first three, at the initial span of
/// the search for the longest span.
const LAST: f64 = 1e-17;
/// Largest number of times a span is shortened.
const SHORTENINGS: usize = 100;
/// Relative allowance for the rounding error of a sum of coefficients.
pub(super) const ROOM: f64 = 1e-12;
/// Largest exponent of the growth of an error within a span.
const GROWTH: f64 = 20.0;

/// Shortening factor of a span at an edge.
const AT_EDGE: f64 = 0.5;
/// Shortening of a span if an operation may not be defined throughout the span.
const UNDEFINED: f64 = 0.7;

/// The row of an argument: its norm, and the operations in it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ArgumentTerms<'a> {
    /// Norm of the row without operations: Σ |ℓᵢ| wᵢ.
    pub(crate) reach: f64,
    /// Index and size of the factor of each operation in the argument.
    pub(crate) nested: &'a [(usize, f64)],
}

impl ArgumentTerms<'_> {
    /// Bound of the change of an operation with this slope by the values that the series of the
    /// operations in the argument leave out at their edges.
    fn left_out(&self, known: &[CurveTerms], slope: f64) -> f64 {
        let sum: f64 = self.nested.iter().map(|&(i, factor)| factor * known[i].left_out).sum();
        if sum > 0.0 { slope * sum } else { 0.0 }
    }
}

/// Omitted terms of a force that moves no state, relative to the force.
const UNSEEN: f64 = 1e-16;
/// Factor on a span that is too long for such a force.
const OF_UNSEEN: f64 = 0.8;
/// Fraction of the span proved for the states, below which such a force shortens it no further.
const LEAST_OF_UNSEEN: f64 = 1e-3;

/// An operation with its series, and the norms of its rows and its column.
#[derive(Clone, Copy)]
pub(crate) struct CurveTerms<'a> {
    /// The operation.
    pub(crate) operation: Operation,
    /// Its series.
    pub(crate) series: &'a CurveSeries,
    /// Its arguments.
    pub(crate) arguments: [ArgumentTerms<'a>; 2],
    /// Norm of its column in z': max |yᵢ| / wᵢ.
    pub(crate) effect: f64,
    /// ρ with |wₖ| ≤ C ρ⁻ᵏ for the operation's value w beyond the computed orders; set by
    /// [`Remainder::prepare`].
    pub(crate) radius: f64,
    /// C.
    pub(crate) scale: f64,
    /// For a [plain](Self::is_plain) polynomial: the C with |xₖ| ≤ C ρ⁻ᵏ for its argument, and
    /// Σ |xₖ| over the longest fraction that is tried; set by [`Remainder::prepare`].
    pub(crate) of_argument: [f64; 2],
    /// Norm of the derivative of the operation's value by the states, over the tube; set by
    /// [`Remainder::bound`].
    pub(crate) steepness: f64,
    /// Whether the operation is a side of a power with an edge. The motion near the polynomial may
    /// pass the edge, where the power stays Lipschitz.
    pub(crate) is_sided: bool,
    /// Bound of the value of a power at its edge, which the series leaves out; set by
    /// [`Remainder::bound`].
    pub(crate) left_out: f64,
    /// Whether the force moves no state, as between held or prescribed bodies. Contact forces and
    /// accounts then need its own series to be exact.
    pub(crate) is_unseen: bool,
    /// Bound of the omitted terms of such a force; set by [`Remainder::bound`].
    pub(crate) omitted: f64,
}

impl<'a> CurveTerms<'a> {
    /// An operation whose bounds are not yet set.
    pub(crate) fn new(
        operation: Operation,
        series: &'a CurveSeries,
        arguments: [ArgumentTerms<'a>; 2],
        effect: f64,
    ) -> Self {
        let (radius, scale, of_argument, steepness, left_out) = (0.0, 0.0, [0.0; 2], 0.0, 0.0);
        let (is_sided, is_unseen, omitted) = (false, false, 0.0);
        Self {
            operation,
            series,
            arguments,
            effect,
            radius,
            scale,
            of_argument,
            steepness,
            is_sided,
            left_out,
            is_unseen,
            omitted,
        }
    }

    /// Whether this is a polynomial of a row without operations.
    #[inline(always)]
    pub(crate) fn is_plain(&self) -> bool {
        matches!(self.operation, Operation::Polynomial(_)) && self.arguments[0].nested.is_empty()
    }

    /// Whether this is a power at its edge, which counts as 0.
    #[inline(always)]
    pub(crate) fn is_still(&self) -> bool {
        self.operation.edge().is_some()
    }

    /// Whether an argument has terms beyond order 0.
    fn varies(&self, last: usize) -> bool {
        let [first, second, ..] = self.series.of_operation();
        let is_zero = |terms: &[f64]| terms[1..=last].iter().all(|x| *x == 0.0);
        let has_second = self.operation.is_of_two();
        !is_zero(first) || has_second && !is_zero(second)
    }

    /// Whether the omitted terms of a force that moves no state are rounding of it. A power at its
    /// edge has no terms.
    fn is_exact(&self, part: f64, last: usize) -> bool {
        if !self.is_unseen || self.is_still() || self.omitted == 0.0 || !self.varies(last) {
            return true;
        }
        let (mut most, mut power) = (0.0f64, 1.0);
        for k in 0..=last {
            let value = match &self.operation {
                Operation::Polynomial(force) => self.series.at_order(force, k),
                _ => self.series.of_operation()[2][k],
            };
            most = most.max(value.abs() * power);
            power *= part;
        }
        self.omitted <= UNSEEN * most
    }

    /// Σ |wₖ| partᵏ over k ≥ `last`, what operations at their edges leave out, and the norm of w's
    /// derivative by the states within `margin` of the polynomial. `known` has the operations
    /// before this one.
    pub(super) fn tail_and_steepness(
        &self,
        known: &[Self],
        (part, margin): (f64, f64),
        last: usize,
    ) -> (f64, f64, f64) {
        let ratio = part / self.radius;
        if !(ratio < 1.0 && self.scale.is_finite()) {
            return (f64::INFINITY, 0.0, f64::INFINITY);
        }
        let [a, b, w, _] = self.series.of_operation();
        let tail = match self.operation {
            Operation::OneSided(_) | Operation::TwoSided(_) => 0.0,
            Operation::Polynomial(_) => self.scale * ratio.powi(last as i32) / (1.0 - ratio),
            _ => {
                let first = w[last].abs() * part.powi(last as i32) * (1.0 + ROOM);
                first + self.scale * ratio.powi(last as i32 + 1) / (1.0 - ratio)
            }
        };
        let reaches = self.arguments.map(|own| {
            own.nested.iter().fold(own.reach, |sum, &(i, factor)| sum + factor * known[i].steepness)
        });
        let mut radii = [0.0; 2];
        for ((radius, argument), (reach, series)) in
            radii.iter_mut().zip(&self.arguments).zip(reaches.iter().zip([a, b]))
        {
            let sum = series[1..=last].iter().rev().fold(0.0, |sum, x| sum * part + x.abs()) * part;
            *radius = sum * (1.0 + ROOM) + argument.beyond(known, part, last) + reach * margin;
        }
        let slopes = match self.operation {
            Operation::Power(p) if self.is_sided => Operation::TwoSided(p).steepest([a[0], b[0]], radii),
            operation => operation.steepest([a[0], b[0]], radii),
        };
        let [first, _] = &self.arguments;
        let highest = self.series.highest(&self.operation, part) * (1.0 + ROOM)
            + first.beyond(known, part, last)
            + reaches[0] * margin;
        let left_out: f64 = match self.operation.edge() {
            Some(_) => self.operation.value([highest, 0.0]),
            None => self.arguments.iter().zip(slopes).map(|(own, slope)| own.left_out(known, slope)).sum(),
        };
        let along = |slope: f64, reach: f64| if reach > 0.0 { slope * reach } else { 0.0 };
        (tail, left_out, along(slopes[0], reaches[0]) + along(slopes[1], reaches[1]))
    }
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
        let are_plain = self.curves.iter().all(CurveTerms::is_plain);
        for i in 0..self.curves.len() {
            let (known, later) = self.curves.split_at_mut(i);
            let terms = &mut later[0];
            if terms.is_plain() {
                let (scale, most) = (terms.series.scale(radius, last), terms.series.sum_of_sizes(part, last));
                terms.of_argument = [scale, most];
            }
            if !are_plain {
                terms.majorize(known, radius, last);
            }
        }
    }

    /// Bound (A59) of the error of the series within the fraction `part` of the span: the integral
    /// of the polynomial's defect times the growth factor of an error. The bound is valid if it is
    /// at most `margin`.
    ///
    /// The tails of plain polynomials come from |xₖ| ≤ C radius⁻ᵏ, with the least C for the given
    /// `radius` (in units of the span). Every radius larger than `part` gives a valid bound.
    #[inline(always)]
    pub(crate) fn bound(&mut self, part: f64, radius: f64, margin: f64) -> f64 {
        let last = self.last();
        let h = self.span * part;
        let (mut defect, mut growth) = (self.rate * self.norms[last] * part.powi(last as i32), self.rate);
        let ratio = radius / part;
        let power = ratio.powi(-(last as i32));
        for i in 0..self.curves.len() {
            let (known, later) = self.curves.split_at_mut(i);
            let CurveTerms { operation, arguments, effect, of_argument, .. } = later[0];
            if let (Operation::Polynomial(force), true) = (&operation, later[0].is_plain()) {
                let (reach, [scale, most]) = (arguments[0].reach, of_argument);
                let tail = tail(force, scale, (ratio, power), last);
                defect += effect * tail;
                later[0].omitted = tail;
                let most = most * (1.0 + ROOM) + reach * margin;
                let slope = force.majorant().derivative(most);
                growth += effect * slope * reach;
                later[0].steepness = slope * reach;
                continue;
            }
            let (own, left_out, steepness) = later[0].tail_and_steepness(known, (part, margin), last);
            let tail = own + left_out;
            (later[0].steepness, later[0].omitted) = (steepness, own);
            let is_still = later[0].is_still();
            later[0].left_out = if is_still { tail } else { 0.0 };
            if effect > 0.0 {
                defect += effect * tail;
                growth += effect * steepness;
            }
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
        // In units of this radius, the last terms are about as large as the first ones.
        let radius = part * (1.0 / LAST).powf(1.0 / last as f64);
        self.prepare(part, radius);
        let mut proved = None;
        for _ in 0..SHORTENINGS {
            let limit = REMAINDER * if at_rest { size } else { self.size(part) };
            let bound = self.bound(part, radius, limit);
            if bound <= limit {
                let most = *proved.get_or_insert(part);
                if part < LEAST_OF_UNSEEN * most {
                    return most;
                }
                if self.curves.iter().all(|own| own.is_exact(part, last)) {
                    return part;
                }
                part *= OF_UNSEEN;
                continue;
            }
            let is_undefined = bound.is_infinite() && self.curves.iter().any(|own| !own.is_plain());
            let factor = match self.curves.iter().any(CurveTerms::is_still) {
                true => AT_EDGE,
                false if is_undefined => UNDEFINED,
                false => 0.98 * (limit / bound).powf(1.0 / last as f64),
            };
            part *= if factor.is_finite() { factor.clamp(0.1, 0.98) } else { 0.5 };
        }
        proved.unwrap_or(0.0)
    }
}
