use super::*;
use nalgebra::Complex;
use std::f64::consts::TAU;

/// Number of random states of each operation.
const STATES: usize = 1000;
/// Order of the last term of a series, as in a flow.
const LAST: usize = 28;
/// Rounding of a coefficient, relative to the largest value on the circle over the radius to the
/// power of its order: the recurrences add up to 40 terms of this size.
const ROUNDING: f64 = 1e-13;
/// Slack of a bound for the roundings of the coefficients that it is compared with.
const SLACK: f64 = 1e-9;
/// Relative step of a difference, and the relative error that it may have.
const STEP: f64 = 1e-5;
const OF_DIFFERENCE: f64 = 1e-8;

const ALL: [Operation; 12] = [
    Operation::Product,
    Operation::Power(0.5),
    Operation::Power(1.5),
    Operation::Power(2.7),
    Operation::Power(-1.0),
    Operation::Power(-2.0),
    Operation::Exponential,
    Operation::Logarithm,
    Operation::Sine,
    Operation::Cosine,
    Operation::HyperbolicTangent,
    Operation::Arctangent,
];

/// Numbers between 0 and 1, by a linear congruence.
struct Chance(u64);

impl Chance {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1u64 << 53) as f64)
    }

    /// Coefficients of an argument whose values keep away from the operation's singularities in a
    /// circle larger than 1: the integrals over the unit circle then have no error of their nodes.
    fn argument(&mut self, operation: &Operation) -> [f64; LAST + 1] {
        let ratio = self.between(0.3, 0.9);
        let mut a: [f64; LAST + 1] = std::array::from_fn(|k| self.between(-1.0, 1.0) * ratio.powi(k as i32));
        let sum: f64 = a[1..].iter().map(|x| x.abs()).sum();
        a[0] = if operation.has_domain() { self.between(0.1, 3.0) } else { self.between(-3.0, 3.0) };
        let most = match operation {
            _ if operation.has_domain() => 0.4 * a[0],
            Operation::HyperbolicTangent | Operation::Arctangent => 0.4,
            _ => 3.0,
        };
        a[1..].iter_mut().for_each(|x| *x *= most / sum);
        a
    }
}

fn complex(operation: &Operation, a: Complex<f64>, b: Complex<f64>) -> [Complex<f64>; 2] {
    let one = Complex::new(1.0, 0.0);
    match operation {
        Operation::Product => [a * b, b],
        Operation::Power(p) => [a.powf(*p), a.powf(p - 1.0) * *p],
        Operation::Exponential => [a.exp(), a.exp()],
        Operation::Logarithm => [a.ln(), one / a],
        Operation::Sine => [a.sin(), a.cos()],
        Operation::Cosine => [a.cos(), -a.sin()],
        Operation::HyperbolicTangent => [a.tanh(), one - a.tanh() * a.tanh()],
        Operation::Arctangent => [a.atan(), one / (one + a * a)],
        Operation::Polynomial(_) | Operation::OneSided(_) | Operation::TwoSided(_) | Operation::Decay => {
            unreachable!()
        }
    }
}

/// The series of an operation of polynomials, with zeros after their last terms.
fn series(operation: &Operation, a: &[f64], b: &[f64]) -> CurveSeries {
    let mut series = CurveSeries::default();
    for k in 0..TERMS {
        let of = |own: &[f64]| own.get(k).copied().unwrap_or_default();
        series.next(operation, k, [of(a), of(b)]);
    }
    series
}

/// Coefficients of the value and the slope are Cauchy's integrals over the unit circle.
#[test]
fn second_method_recurrences_are_cauchy_integrals() {
    const NODES: usize = 512;
    let mut chance = Chance(3);
    for operation in ALL {
        for _ in 0..STATES {
            let (a, b) = (chance.argument(&operation), chance.argument(&operation));
            let own = series(&operation, &a, &b);
            let at =
                |c: &[f64], u: Complex<f64>| c.iter().rev().fold(Complex::default(), |sum, x| sum * u + x);
            let nodes: Vec<_> = (0..NODES).map(|n| Complex::cis(TAU * n as f64 / NODES as f64)).collect();
            let values: Vec<_> = nodes.iter().map(|u| complex(&operation, at(&a, *u), at(&b, *u))).collect();
            let [_, _, w, g] = own.of_operation();
            for (which, found) in [w, g].into_iter().enumerate() {
                if which == 1 && operation == Operation::Product {
                    continue;
                }
                let size = values.iter().map(|own| own[which].norm()).fold(0.0, f64::max);
                for (k, found) in found.iter().enumerate().take(LAST + 1) {
                    let turn = |n: usize| nodes[(NODES - n * k % NODES) % NODES];
                    let sum: Complex<f64> = (0..NODES).map(|n| values[n][which] * turn(n)).sum();
                    let off = (found - sum.re / NODES as f64).abs();
                    assert!(off <= ROUNDING * size * (k + 1) as f64, "{operation:?} {k} {off:e} of {size:e}");
                }
            }
        }
    }
}

/// All coefficients beyond the last computed one are below C ρ⁻ᵏ, also of operations in
/// operations; the sums of the sizes are below the tails, and the slopes below the steepness.
#[test]
fn invariant_coefficients_are_below_their_majorants() {
    let mut chance = Chance(5);
    let (mut sharpest, mut compared) = (f64::INFINITY, 0);
    for (outer, inner) in ALL.into_iter().flat_map(|outer| ALL.map(|inner| (outer, inner))) {
        for _ in 0..STATES / ALL.len() + 1 {
            let (a, b) = (chance.argument(&inner), chance.argument(&outer));
            let first = series(&inner, &a, &b);
            // The outer operation is of a constant plus a multiple of the inner one.
            let factor = chance.between(-0.5, 0.5);
            let mut argument: [f64; TERMS] = first.of_operation()[2].map(|x| factor * x);
            argument[0] = if outer.has_domain() { 1.0 + argument[0].abs() } else { argument[0] };
            let second = series(&outer, &argument, &b);
            let plain = ArgumentTerms { reach: 1.0, nested: &[] };
            let nested = [(0, factor.abs())];
            let of_inner = ArgumentTerms { reach: 0.0, nested: &nested };
            let mut terms = [
                CurveTerms::new(inner, &first, [plain, plain], 1.0),
                CurveTerms::new(outer, &second, [of_inner, plain], 1.0),
            ];
            let radius = chance.between(0.5, 6.0);
            for i in 0..2 {
                let (known, later) = terms.split_at_mut(i);
                later[0].majorize(known, radius, LAST);
                let CurveTerms { radius, scale, series, operation, .. } = later[0];
                assert!(scale.is_finite(), "{outer:?} of {inner:?}");
                let w = series.of_operation()[2];
                // Beyond the last order the true coefficients are rounded relative to the first.
                let rounding = |k: usize| {
                    let largest = w.iter().map(|x| x.abs()).fold(0.0, f64::max);
                    ROUNDING * largest * (k as f64).powi(2)
                };
                for (k, w) in w.iter().enumerate().skip(LAST + 1) {
                    let limit = scale * radius.powi(-(k as i32));
                    assert!(
                        w.abs() <= limit * (1.0 + SLACK) + rounding(k),
                        "{operation:?} {k} {w:e} {limit:e}"
                    );
                    if w.abs() > rounding(k) {
                        sharpest = sharpest.min((limit / w.abs()).powf(1.0 / k as f64));
                        compared += 1;
                    }
                }
                let part = chance.between(0.05, 0.9) * radius;
                let (own, left_out, steepness) = later[0].tail_and_steepness(known, (part, 0.0), LAST);
                let tail = own + left_out;
                later[0].steepness = steepness;
                let sum: f64 = (LAST..TERMS).map(|k| w[k].abs() * part.powi(k as i32)).sum();
                let slack: f64 = (LAST..TERMS).map(|k| rounding(k) * part.powi(k as i32)).sum();
                assert!(sum <= tail * (1.0 + SLACK) + slack, "{operation:?} {sum:e} {tail:e}");
            }
            compare_steepness(&terms, &mut chance);
        }
    }
    println!("{compared} compared; the bound of a radius is at least {sharpest} times the radius");
    assert!(compared > 100_000 && sharpest < 1.2, "{compared} {sharpest}");
}

/// The slopes at points of the tube are below the steepness.
fn compare_steepness(terms: &[CurveTerms; 2], chance: &mut Chance) {
    for own in terms {
        let [a, b, ..] = own.series.of_operation();
        let at = |c: &[f64; TERMS], u: f64| c[..=LAST].iter().rev().fold(0.0, |sum, x| sum * u + x);
        // The bound was found for the fraction `part` of a span; 0 is within every one.
        let u = chance.between(0.0, 0.04) * own.radius;
        let slopes = own.operation.slopes([at(a, u), at(b, u)]);
        let inner = if own.arguments[0].nested.is_empty() { 1.0 } else { 0.0 };
        let slope = slopes[0].abs() * inner + slopes[1].abs();
        assert!(slope <= own.steepness * (1.0 + SLACK), "{:?} {slope:e} {:e}", own.operation, own.steepness);
    }
}

/// The sizes of the terms are at least the terms.
#[test]
fn invariant_sizes_are_at_least_the_terms() {
    let mut chance = Chance(9);
    for operation in ALL {
        for _ in 0..STATES {
            let (a, b) = (chance.argument(&operation), chance.argument(&operation));
            let own = series(&operation, &a, &b);
            let mut sizes = CurveSizes::of(&operation, [a[0], b[0]], [a[0].abs(), b[0].abs()]);
            for k in 1..=LAST {
                let (size, x) = (sizes.next(k, [a[k].abs(), b[k].abs()]), own.of_operation()[2][k]);
                assert!(x.abs() <= size * (1.0 + SLACK), "{operation:?} {k} {x:e} {size:e}");
            }
        }
    }
}

/// The derivatives are the limits of differences.
#[test]
fn second_method_derivatives_are_differences() {
    let mut chance = Chance(11);
    for operation in ALL {
        for _ in 0..STATES {
            let at = [chance.argument(&operation)[0], chance.between(-2.0, 2.0)];
            let moved = |by: f64| [at[0] * (1.0 + by), at[1]];
            let central = |of: &dyn Fn([f64; 2]) -> f64| {
                let once = |step: f64| (of(moved(step)) - of(moved(-step))) / (2.0 * step * at[0]);
                // Richardson's extrapolation.
                (4.0 * once(STEP) - once(2.0 * STEP)) / 3.0
            };
            let slope = operation.slopes(at);
            let [twice, mixed] = operation.second_derivatives(at);
            let size = (operation.value(at) / at[0]).abs() + slope[0].abs() + (twice * at[0]).abs();
            let off = (central(&|a| operation.value(a)) - slope[0]).abs();
            assert!(off <= OF_DIFFERENCE * size, "{operation:?} at {at:?}: {off:e}");
            let off = (central(&|a| operation.slopes(a)[0]) - twice).abs();
            assert!(
                off <= OF_DIFFERENCE * (size + twice.abs() + 1.0) / at[0].abs(),
                "{operation:?}: {off:e}"
            );
            let off = (central(&|a| operation.slopes(a)[1]) - mixed).abs();
            assert!(off <= OF_DIFFERENCE, "{operation:?} at {at:?}: {off:e}");
        }
    }
}
