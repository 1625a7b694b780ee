//! The proofs of a passage for polynomials, compared with their values at many places.

use super::*;

/// A polynomial is evaluated at this number of places of an interval.
const PLACES: usize = 64;
/// Tolerance relative to the terms of a polynomial: some thousands of roundings.
const ROUNDING: f64 = 1e-12;

/// Random numbers in [-1, 1), from a seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// A cubic's value and its second derivative.
fn cubic(c: &[f64; 4], t: f64) -> [f64; 2] {
    [c[0] + t * (c[1] + t * (c[2] + t * c[3])), 2.0 * c[2] + 6.0 * c[3] * t]
}

#[test]
fn invariant_every_interval_with_a_passage_is_near() {
    // The bound of the second derivative is exact. No interval is near if all values are so far
    // below zero that they need no proof.
    let (mut random, mut far) = (Random(3), 0);
    for case in 0..20_000 {
        let order = case % 4;
        let step = [0.125, 0.3, 4.0][case % 3];
        let length = step * INTERVALS as f64;
        let mut c = std::array::from_fn(|k| random.next() * f64::powi(length, -(k as i32)));
        c[..order].fill(0.0);
        if order > 0 {
            c[order.min(3)] = -c[order.min(3)].abs(); // goes down from zero
        } else {
            c[0] = -c[0].abs();
        }
        // The second derivative is linear: its largest size is at an end.
        let bend = cubic(&c, 0.0)[1].abs().max(cubic(&c, length)[1].abs());
        let head = Head { value: c[0], slope: c[1], bend };
        let samples = || std::array::from_fn(|k| cubic(&c, step * (k + 1) as f64)[0]);
        let near = near_intervals(order, &head, step, samples);
        let mut highest = f64::NEG_INFINITY;
        for interval in 0..INTERVALS {
            let at = |place: usize| cubic(&c, step * (interval as f64 + place as f64 / PLACES as f64))[0];
            let passes = (1..=PLACES).any(|place| at(place - 1) < -ROUNDING && at(place) > ROUNDING);
            assert!(
                !passes || near & (1 << interval) != 0,
                "{case}: {c:?} passes in {interval}, not in {near:b}"
            );
            let most = (0..=PLACES).map(at).fold(f64::NEG_INFINITY, f64::max);
            highest = highest.max(most);
            // Not searched: an interval whose ends are farther below zero than the bound.
            let is_far = |value: f64| value < -bend * step * step / 8.0 - ROUNDING;
            if is_far(at(0)) && is_far(at(PLACES)) {
                far += 1;
                assert!(near & (1 << interval) == 0, "{case}: {c:?} is searched in {interval}");
            }
        }
        // A polynomial that falls from zero with a slope that outweighs its bend is not searched
        // in the first interval.
        if order == 1
            && c[1] + 0.5 * bend * step < -ROUNDING
            && cubic(&c, 2.0 * step)[0] < -bend * step * step
        {
            assert!(near & 1 == 0, "{case}: {c:?}");
        }
        // Nothing is searched if the bounding parabola is below zero at both ends.
        if order == 0 && c[0] + length * (c[1] + 0.5 * bend * length) < -ROUNDING {
            assert!(near == 0 && highest < 0.0, "{case}: {c:?}");
        }
    }
    assert!(far > 10_000, "{far}");
    let any = Head { value: 1.0, slope: 1.0, bend: 1.0 };
    assert_eq!(near_intervals(HIGH_ORDER, &any, 1.0, || [1.0; INTERVALS]), 0);
}

#[test]
fn closed_form_what_turns_round_beyond_zero() {
    // begin + c₁ u + c₂ u² at u = 1: its vertex is c₁'²/(-4 c₂) higher than there, where c₁' = c₁
    // + 2 c₂ is its slope.
    let of = |begin: f64, terms: &[f64], zero: f64| {
        let mut c = [0.0; LOCAL];
        c[0] = begin;
        c[1..=terms.len()].copy_from_slice(terms);
        turns_round(begin, &c, zero)
    };
    let mut random = Random(7);
    let mut count = [0; 2];
    for _ in 0..4000 {
        let (begin, up, bow, zero) =
            (-random.next().abs(), 3.0 * random.next(), 3.0 * random.next(), random.next().abs());
        let (end, slope) = (begin + up + bow, up + 2.0 * bow);
        let comes_back = end <= 0.0 || slope <= 0.0 || (bow < 0.0 && slope * slope / (-4.0 * bow) <= zero);
        assert_eq!(of(begin, &[up, bow], zero), comes_back, "{begin} {up} {bow} {zero}");
        count[usize::from(comes_back)] += 1;
    }
    assert!(count.iter().all(|n| *n > 400), "{count:?}");
    // At 1, u³ has the slope 3 and the second derivative 6: with -2 u³ and 6.5 u they are 0.5 and
    // -12.
    assert!(
        of(-4.0, &[6.5, 0.0, -2.0], 0.25 / 24.0 + 1e-9) && !of(-4.0, &[6.5, 0.0, -2.0], 0.25 / 24.0 - 1e-9)
    );
}

#[test]
fn closed_form_sums_behind_the_first_coefficient() {
    let c: [f64; LOCAL] = std::array::from_fn(|k| if k % 3 == 0 { -1.0 } else { 1.0 } * f64::from(1u32 << k));
    let sum: f64 = c[1..].iter().sum();
    assert_eq!(sum_behind(&c, |x| x), sum);
    assert_eq!(sum_behind(&c, f64::abs), f64::from((1u32 << LOCAL) - 2));
}

#[test]
fn second_method_roots_of_series_from_below() {
    // Series of oscillating motions with rates up to 4 over the span: the roots agree with
    // bisection, and there are no others.
    let (mut random, mut roots, mut none) = (Random(11), 0, 0);
    for case in 0..20_000 {
        let rate = [0.5, 1.5, 4.0][case % 3];
        let mut c = [0.0; 32];
        let mut size = 1.0;
        for (k, c) in c.iter_mut().enumerate() {
            *c = size * random.next();
            size *= rate / (k + 1) as f64;
        }
        c[0] = -c[0].abs() * [1.0, 1e-3][case % 2];
        let hi = if case % 5 == 0 { 0.7 } else { 1.0 };
        let Some(found) = passage_from_below(&c, hi) else { continue };
        let value = |u: f64| c.iter().rev().fold(0.0, |sum, c| sum * u + c);
        let terms = c.iter().map(|c| c.abs()).sum::<f64>();
        match (found, first_crossing(&c, 0.0, hi, &mut 0)) {
            (Some(u), Some(by_halving)) => {
                let slope = (value(u + 1e-7) - value(u - 1e-7)) / 2e-7;
                assert!((u - by_halving).abs() * slope.abs() < ROUNDING * terms, "{case}: {u} {by_halving}");
                roots += 1;
            }
            (None, None) => none += 1,
            // The root is within rounding of the end or of a touch.
            (one, other) => {
                let at = one.or(other).unwrap();
                assert!(value(at.min(hi)).abs() < ROUNDING * terms, "{case}: {one:?} {other:?}");
            }
        }
    }
    assert!(roots > 5_000 && none > 2_000, "{roots} {none}");
}
