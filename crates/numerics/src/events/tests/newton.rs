//! Newton's method on rising polynomials, in flights and in general, against exact roots and
//! against its criteria computed with 60 digits.

use super::super::*;
use super::{ROOT, random};

/// [`flight_crossing`] on an interval, with its number of iterations.
struct Flight<'a>(&'a [f64; PADDED], f64, f64);

impl pulp::WithSimd for Flight<'_> {
    type Output = (Option<f64>, u64);

    fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
        let mut iterations = 0;
        (flight_crossing(simd, self.0, self.1, self.2, &mut iterations), iterations)
    }
}

/// Results of [`Flight`] with the best instruction set of this machine and without vectors.
fn flights(c: &[f64; PADDED], lo: f64, hi: f64) -> [(Option<f64>, u64); 2] {
    let flight = || Flight(c, lo, hi);
    [pulp::Arch::new().dispatch(flight()), pulp::WithSimd::with_simd(flight(), pulp::Scalar)]
}

#[test]
fn second_method_nearly_straight_passages() {
    let mut random = random(11);
    let mut found = 0;
    for _ in 0..20_000 {
        // From nearly straight to strongly bent.
        let bend = 10f64.powf(-4.0 * random().abs());
        let mut c = [0.0; PADDED];
        for (k, ck) in c.iter_mut().enumerate().take(10) {
            *ck = random() * if k < 2 { 1.0 } else { bend.powi(k as i32 - 1) };
        }
        c[0] -= value(&c, -1.0).max(0.0) + 0.01 * random().abs();
        if value(&c, -1.0) >= 0.0 {
            continue;
        }
        let hi = if random() > 0.0 { 1.0 } else { random() };
        let sure = first_crossing(&c, -1.0, hi, &mut 0);
        for (root, _) in flights(&c, -1.0, hi) {
            match (root, sure) {
                (Some(a), Some(b)) => {
                    found += 1;
                    let slope = value_and_slope(&c, b).1;
                    assert!((a - b).abs() < ROOT / slope.abs().min(1.0), "{a} {b} {c:?}");
                }
                (None, None) => {}
                // A root within rounding of the end: Newton's iterate lies inside, but the
                // computed p(hi) is not positive.
                (Some(u), None) => assert!(u < hi && hi - u < ROOT, "{u} {hi} {c:?}"),
                (None, Some(u)) => panic!("missed the passage at {u} before {hi}: {c:?}"),
            }
        }
    }
    assert!(found > 5000, "{found}");
}

/// Criterion that ends Newton's method early, against the exact root of p = (u - r)(1 + b (u -
/// r)), for which the factor K is known.
#[test]
fn closed_form_the_newton_criterion_holds_up_to_its_largest_factor() {
    let mut random = random(5);
    let mut ended = 0;
    for _ in 0..20_000 {
        let (r, b) = (0.9 * random(), 0.26 * random());
        let p = [-r * (1.0 - b * r), 1.0 - 2.0 * b * r, b];
        let (Shape::Rising, factor) = shape(&p) else { continue };
        assert!(factor <= MAX_NEWTON_FACTOR || factor.is_infinite());
        let u = refine(&p, (-1.0, 1.0), 0.0, factor, &mut 0);
        // Error of the root: rounding of the coefficients over the slope 1.
        assert!((u - r).abs() < 4.0 * f64::EPSILON, "{u} {r} {b}");
        ended += 1;
    }
    assert!(ended > 10_000);
}

/// Estimate that ends Newton's method early, against Newton's method with 60 digits, with
/// estimates up to 7 % above and below the resolution. The numbers of iterations are equal, and
/// the roots agree within a few roundings.
#[test]
fn golden_newton_ends_where_its_estimate_says() {
    /// Relative error: the estimate allows ε, and rounding of p, of the step and of u add ε each.
    const ERROR: f64 = 4.0 * f64::EPSILON;
    let rows: Vec<&str> = include_str!("../../../tests/newton.csv").lines().skip(1).collect();
    assert!(rows.len() > 90);
    for row in rows {
        let numbers: Vec<f64> = row.split(',').map(|text| text.parse().unwrap()).collect();
        let [_, c @ .., start, factor, _, _, expected, high, low] = &numbers[..] else { panic!("{row}") };
        let c: [f64; 5] = c.try_into().unwrap();
        // K is summed in a different order.
        let (known, own) = shape(&c);
        assert!(known == Shape::Rising && (own - factor).abs() < 1e-10 * factor, "{row}: {own}");
        let mut iterations = 0;
        let u = refine(&c, (-1.0, 1.0), *start, *factor, &mut iterations);
        assert_eq!(iterations as f64, *expected, "{row}");
        assert!(((u - high) - low).abs() <= ERROR * u.abs(), "{row}: {u}");
    }
}

/// The estimate ends the method at equality, too: on a straight line all of its values are exact.
#[test]
fn closed_form_newton_ends_where_the_estimate_equals_the_resolution() {
    // From u = 1 the step is 2⁻²⁰, and 4 K 2⁻⁴⁰ = 2⁻⁵².
    let (step, factor) = (2f64.powi(-20), 2f64.powi(-14));
    let line = [step - 1.0, 1.0, 0.0, 0.0, 0.0];
    for (factor, expected) in [(factor, 1), (factor * (1.0 + f64::EPSILON), 2)] {
        let mut iterations = 0;
        assert_eq!(refine(&line, (-1.0, 1.0), 1.0, factor, &mut iterations), 1.0 - step);
        assert_eq!(iterations, expected);
    }
}

/// Estimates that end [`flight_crossing`], against the coefficients c at which they equal the
/// resolution, computed with 60 digits. For p = u - 1/2 + c u⁸ the first step, from u = 1/2, is m
/// = (c/256)/(1 + c/16), and K = 28 c/(1 - 8 c). The first estimate is 4 K m², the second 8 K² m²
/// (m + 4 K m²); the resolution is ε (1/2 - m).
#[test]
fn golden_flights_end_where_their_estimates_say() {
    const FIRST: f64 = 4.019_556_791_509_709e-5;
    const SECOND: f64 = 3.092_014_722_553_670_4e-3;
    /// Relative distance of c from these values. The estimates grow as c³ and c⁵, and their
    /// rounding is a few ε.
    const BESIDE: f64 = 1e-14;
    let ends = |c8: f64, most: u64| {
        let mut c = [0.0; PADDED];
        [c[0], c[1], c[8]] = [-0.5, 1.0, c8];
        let sure = first_crossing(&c, -1.0, 1.0, &mut 0).unwrap();
        flights(&c, -1.0, 1.0).map(|(root, iterations)| {
            assert!((root.unwrap() - sure).abs() <= 2.0 * f64::EPSILON, "{c8}: {root:?} {sure}");
            iterations <= most
        })
    };
    for (tight, steps) in [(FIRST, 1), (SECOND, 2)] {
        assert_eq!(ends(tight * (1.0 - BESIDE), steps), [true; 2], "{steps}");
        assert_eq!(ends(tight * (1.0 + BESIDE), steps), [false; 2], "{steps}");
    }
    // The estimate also ends the method at equality, as for a root at the centre, where both sides
    // are zero.
    for bend in [0.0, 0.125] {
        let mut c = [0.0; PADDED];
        [c[1], c[2]] = [1.0, bend];
        assert_eq!(flights(&c, -1.0, 1.0), [(Some(0.0), 1); 2], "{bend}");
    }
}

/// Polynomials p = s (u - r) (1 + b (u - r)) with exact coefficients and the root at one end of
/// the interval.
#[test]
fn closed_form_flights_with_roots_at_the_ends() {
    /// Bends b. The second step finds the root for larger ones, the first step for smaller ones.
    const BENDS: [f64; 5] = [0.0, 1.0 / 1024.0, -1.0 / 1024.0, 0.125, -0.125];
    for s in (1..1000).map(f64::from) {
        for (r, b) in [-0.25, 0.5, 0.75].into_iter().flat_map(|r| BENDS.map(|b| (r, b))) {
            let mut c = [0.0; PADDED];
            [c[0], c[1], c[2]] = [-s * r * (1.0 - b * r), s * (1.0 - 2.0 * b * r), s * b];
            // A root at the end is not a passage; rounding may find one just before it.
            for (root, _) in flights(&c, -1.0, r) {
                assert!(root.is_none_or(|u| u < r && r - u < ROOT), "{s} {r} {b}: {root:?}");
            }
            // A root at the start, or by rounding just before it, is a passage at the start.
            for lo in [r, r.next_up()] {
                for (root, _) in flights(&c, lo, 1.0) {
                    assert!(root.is_some_and(|u| u >= lo && u - lo < ROOT), "{s} {r} {b}: {root:?}");
                }
            }
        }
    }
}

/// Bound e ≤ m + K m² on the error e before a Newton step m, from a point where p' = P. Among all
/// rising p with p' ≥ σ and |p''| ≤ 2 K σ, the polynomial whose slope falls fastest has the
/// shortest step. The bound holds for it for each P, with equality for P = σ sqrt(1 + 4 K e).
#[test]
fn closed_form_the_error_before_a_newton_step() {
    const ROUNDING: f64 = 1e-12;
    let e = 1.0;
    for k in [0.01, 0.25, 2.0 / 3.0, 2.0, 1e2, 1e4] {
        // With σ = 1 the slope is max(1, P - 2 K t) a distance t from the start.
        let step = |p: f64| {
            let bent = ((p - 1.0) / (2.0 * k)).min(e);
            (p * bent - k * bent * bent + (e - bent)) / p
        };
        let bound = |m: f64| m + k * m * m;
        for n in 0..2000 {
            let p = 1.0 + (4.0 * k + 1.0) * f64::from(n) / 1000.0;
            assert!(e <= bound(step(p)) * (1.0 + ROUNDING), "{k} {p}");
        }
        let sharpest = bound(step((1.0 + 4.0 * k * e).sqrt()));
        assert!((sharpest - e).abs() < ROUNDING, "{k}: {sharpest}");
    }
}
