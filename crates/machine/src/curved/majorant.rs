//! Bounds of all coefficients of the operations of a formula (docs/assembly-law.md, section 20).
//!
//! For each operation w, in the order of the formula, a radius ρ and a number C are found with
//! |wₖ| ≤ C ρ⁻ᵏ for all orders k beyond the computed ones. The coefficients of an argument beyond
//! the computed orders come from the operations in it.

use super::Operation;
use super::remainder::{ArgumentTerms, CurveTerms, ROOM};

/// Radius of an operation, relative to the radii of the operations in its arguments. The sizes of
/// the coefficients of the arguments then have finite sums.
const NESTED: f64 = 1.0 / 1.05;
/// Factor from one tried radius to the next.
const SMALLER: f64 = 0.87;
/// Largest number of tried radii.
const TRIALS: usize = 120;
/// Radii without a bound that are tried before each next radius is half the last one. The series of a
/// saturated tanh has small terms over spans a billion times longer than its radius.
const FEW: usize = 60;
/// Largest change of the argument of ln, as a fraction of its value.
const OF_LOGARITHM: f64 = 0.97;
/// Largest change of the argument of a positive power, as a fraction of its value.
const OF_ROOT: f64 = 0.999;
/// Largest change of the argument of atan, as a fraction of its distance from the poles.
const OF_ARCTANGENT: f64 = 0.95;
/// Largest change of the argument of tanh near 0; the poles are at ± i π/2.
const OF_TANGENT: f64 = 1.5;
/// Distance that the argument of tanh keeps from the imaginary axis if it changes by more.
const FROM_AXIS: f64 = 0.3;

/// Sums over the coefficients of an argument, each times its power of a radius.
#[derive(Clone, Copy, Debug)]
struct Sums {
    /// |a₀|.
    first: f64,
    /// Σ |aₖ| ρᵏ over k ≥ 1.
    others: f64,
    /// Σ k |aₖ| ρᵏ.
    weighted: f64,
    /// Largest |aₖ| ρᵏ.
    largest: f64,
}

/// Σ xᵏ and Σ k xᵏ over k ≥ `first`.
fn geometric(x: f64, first: usize) -> (f64, f64) {
    let (n, power) = (first as f64, x.powi(first as i32));
    (power / (1.0 - x), power * (n - (n - 1.0) * x) / (1.0 - x).powi(2))
}

/// Largest |wₖ| ρᵏ of computed coefficients.
fn largest(w: &[f64], radius: f64) -> f64 {
    let step = |(most, power): (f64, f64), x: &f64| (most.max(x.abs() * power), power * radius);
    w.iter().fold((0.0, 1.0), step).0
}

impl ArgumentTerms<'_> {
    /// Bound of Σ |aₖ| partᵏ over the orders beyond `last`, which only operations have.
    pub(super) fn beyond(&self, known: &[CurveTerms], part: f64, last: usize) -> f64 {
        let own = |&(i, factor): &(usize, f64)| {
            let CurveTerms { radius, scale, .. } = known[i];
            factor * scale * geometric(part / radius, last + 1).0
        };
        self.nested.iter().map(own).sum()
    }

    /// The sums at a radius below the radii of the operations in the argument.
    fn sums(&self, a: &[f64], known: &[CurveTerms], radius: f64) -> Sums {
        let mut sums = Sums { first: a[0].abs(), others: 0.0, weighted: 0.0, largest: a[0].abs() };
        let mut power = 1.0;
        for (k, a) in a.iter().enumerate().skip(1) {
            power *= radius;
            let size = a.abs() * power;
            sums.others += size;
            sums.weighted += k as f64 * size;
            sums.largest = sums.largest.max(size);
        }
        let mut beyond = 0.0;
        for &(i, factor) in self.nested {
            let ratio = radius / known[i].radius;
            let (sum, weighted) = geometric(ratio, a.len());
            let scale = factor * known[i].scale;
            sums.others += scale * sum;
            sums.weighted += scale * weighted;
            beyond += scale * ratio.powi(a.len() as i32);
        }
        sums.others *= 1.0 + ROOM;
        sums.weighted *= 1.0 + ROOM;
        sums.largest = sums.largest.max(beyond);
        sums
    }
}

/// The least C with |wₖ| ≤ C ρ⁻ᵏ beyond the computed orders that is proved at a radius. `None` if
/// none is.
fn scale(operation: &Operation, sums: [Sums; 2], centre: f64, w: [&[f64]; 2], radius: f64) -> Option<f64> {
    let [Sums { first, others, weighted, largest: most }, b] = sums;
    let orders = w[0].len() as f64;
    match operation {
        // Cauchy's estimate on the disc |x - x₀| ≤ Σ |xₖ| ρᵏ.
        Operation::Polynomial(force) => Some(force.majorant().value(first + others)),
        Operation::Product => {
            let one = (first + others) * b.largest;
            Some(one.min((b.first + b.others) * most))
        }
        Operation::Power(p) if *p < 0.0 => {
            let limit = orders / (orders + p.abs());
            (others <= limit * first && first > 0.0).then(|| (first - others).powf(*p))
        }
        Operation::Power(p) => {
            (p.fract() == 0.0 || others <= OF_ROOT * first).then(|| (first + others).powf(*p))
        }
        Operation::OneSided(_) | Operation::TwoSided(_) => Some(0.0),
        // In a mode this is an exponential function.
        Operation::Decay => None,
        Operation::Logarithm => (others <= OF_LOGARITHM * first).then(|| -(-others / first).ln_1p()),
        // By induction over k wₖ = Σ j aⱼ gₖ₋ⱼ, with g = ±w or the other one of sine and cosine.
        Operation::Exponential | Operation::Sine | Operation::Cosine => {
            (weighted <= orders).then(|| largest(w[0], radius).max(largest(w[1], radius)))
        }
        // |cosh(x + iy)|² = sinh² x + cos² y.
        Operation::HyperbolicTangent => {
            let away = (first - others).max(0.0);
            let near = if others <= OF_TANGENT { others.cos().powi(2) } else { 0.0 };
            let is_free = others <= OF_TANGENT || away >= FROM_AXIS;
            is_free.then(|| others / (away.sinh().powi(2) + near))
        }
        // |1 + a²| ≥ (d - s)² within s of the centre, at the distance d from the poles.
        Operation::Arctangent => {
            let distance = centre.hypot(1.0);
            (others <= OF_ARCTANGENT * distance).then(|| others / (distance - others).powi(2))
        }
    }
}

impl CurveTerms<'_> {
    /// Sets ρ and C, given them for the operations before. `radius` is the first radius that is
    /// tried. If no bound is found, C is infinite.
    pub(super) fn majorize(&mut self, known: &[CurveTerms], radius: f64, last: usize) {
        let [a, b, w, g] = self.series.of_operation().map(|own| &own[..=last]);
        let nested = self.arguments.iter().flat_map(|own| own.nested);
        let mut radius = nested.fold(radius, |least, own| least.min(NESTED * known[own.0].radius));
        (self.radius, self.scale) = (radius, f64::INFINITY);
        let mut tail = f64::INFINITY;
        for trial in 0..TRIALS {
            let [first, second] = &self.arguments;
            let sums = first.sums(a, known, radius);
            let others = if self.operation.is_of_two() { second.sums(b, known, radius) } else { sums };
            let sums = [sums, others];
            if let Some(scale) = scale(&self.operation, sums, a[0], [w, g], radius) {
                let found = scale * radius.powi(-(last as i32));
                if found.is_nan() || found >= tail {
                    break;
                }
                tail = found;
                (self.radius, self.scale) = (radius, scale);
            }
            radius *= if trial < FEW || tail.is_finite() { SMALLER } else { 0.5 };
        }
    }
}
