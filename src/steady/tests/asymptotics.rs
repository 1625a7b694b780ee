//! The approximations against the exact orbit as ε → 0: amplitudes, multipliers and slow
//! eigenvalues.

use crate::parameters::{Groups, Scales};
use crate::steady::exact_orbit::{self, ExactOrbit};
use crate::steady::{multiple_scales, strong_coupling};
use nalgebra::Complex;
use std::f64::consts::PI;

const EPSILONS: [f64; 5] = [0.1, 0.05, 0.02, 0.01, 0.005];
/// A first-order error halves with ε; terms of second order bend the slope at ε = 0.1.
const SLOPE: f64 = 0.15;
/// Bound on the deviation of the slope between the smallest ε, where higher terms are small.
const LAST_SLOPE: f64 = 0.05;

/// Small ε, at which only the leading term of a multiplier's error remains.
const TINY_EPSILON: f64 = 1e-4;
/// Bounds, for the groups' sizes here, on error / ε of a fast multiplier and on error / ε² of a
/// slow multiplier.
const ERROR_FACTOR: f64 = 30.0;

fn exact(g: &Groups) -> ExactOrbit {
    exact_orbit::solve(&g.to_parameters(Scales::default()).unwrap()).unwrap().upper.unwrap()
}

/// Least-squares slope of log error over log ε, and the slope of the last two points.
fn slopes(errors: &[f64; 5]) -> (f64, f64) {
    let points: Vec<_> = EPSILONS.iter().zip(errors).map(|(e, d)| (e.ln(), d.ln())).collect();
    let n = points.len() as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |s, p| (s.0 + p.0 / n, s.1 + p.1 / n));
    let (up, down) =
        points.iter().fold((0.0, 0.0), |s, p| (s.0 + (p.0 - x) * (p.1 - y), s.1 + (p.0 - x) * (p.0 - x)));
    (up / down, (points[4].1 - points[3].1) / (points[4].0 - points[3].0))
}

fn check(label: &str, amplitudes: impl Fn(f64) -> ([f64; 4], [f64; 4])) {
    let all = EPSILONS.map(|epsilon| {
        let (approximate, exact) = amplitudes(epsilon);
        std::array::from_fn::<f64, 4, _>(|i| (approximate[i] / exact[i] - 1.0).abs())
    });
    for (i, name) in ["B", "A1", "A2", "A3"].into_iter().enumerate() {
        let errors = all.map(|e| e[i]);
        let (slope, last) = slopes(&errors);
        println!("{label} {name}: errors {errors:.4?}, slope {slope:.3}, last {last:.3}");
        assert!((slope - 1.0).abs() < SLOPE, "{label} {name}: slope {slope} of {errors:?}");
        assert!((last - 1.0).abs() < LAST_SLOPE, "{label} {name}: last slope {last} of {errors:?}");
    }
}

fn exact_amplitudes(g: &Groups) -> [f64; 4] {
    let orbit = exact(g);
    let [a1, a2, a3] = orbit.amplitudes();
    [orbit.amplitude_of([1.0, g.epsilon, 0.0]), a1, a2, a3]
}

#[test]
fn second_method_multiple_scales_is_off_by_order_epsilon() {
    check("multiple scales", |epsilon| {
        let g = Groups::weak(epsilon, 0.75, 1.5, 0.4, 1.0, 0.6, 0.0, 0.6);
        let p = multiple_scales::fixed_points(&g).unwrap().unwrap().upper;
        ([p.b, p.a1(), p.a2(), p.a3], exact_amplitudes(&g))
    });
}

#[test]
fn second_method_strong_coupling_is_off_by_order_epsilon() {
    check("strong coupling", |epsilon| {
        let g = Groups { epsilon, beta2: 0.3, mu13: 1.0, sigma30: 0.5, ..Groups::basic() };
        let p = strong_coupling::solve(&g).unwrap().unwrap().upper;
        ([p.b, p.a1(), p.a2(), p.a3], exact_amplitudes(&g))
    });
}

/// As ε → 0, two multipliers of the exact half map tend to the multipliers of the periodic motion,
/// and four to 1 + επλ/Ω1 with λ the slow flow's eigenvalues. The exact orbit is the oracle of
/// both stability tests.
fn check_multipliers(orbit: &ExactOrbit, epsilon: f64, fast: [Complex<f64>; 2], slow: [Complex<f64>; 4]) {
    let expected = fast.into_iter().chain(slow.map(|e| Complex::new(1.0, 0.0) + epsilon * PI * e));
    let mut left = orbit.multipliers().to_vec();
    for (i, e) in expected.enumerate() {
        let distance = |m: &Complex<f64>| (m - e).norm();
        let nearest =
            (0..left.len()).min_by(|&a, &b| distance(&left[a]).total_cmp(&distance(&left[b]))).unwrap();
        // The error of fast multipliers is O(ε), the error of slow ones O(ε²).
        let allowed = if i < 2 { ERROR_FACTOR * epsilon } else { ERROR_FACTOR * epsilon * epsilon };
        assert!(distance(&left[nearest]) < allowed, "{i}: {e} of {left:?}");
        left.remove(nearest);
    }
}

#[test]
fn second_method_multiplier_limits_of_multiple_scales() {
    let epsilon = TINY_EPSILON;
    for (f10, sigma1) in [(1.2, 0.4), (1.8, 0.5), (1.5, 0.3)] {
        let g = Groups::weak(epsilon, 0.75, f10, sigma1, 0.8, 0.6, 0.1, 0.6);
        let p = multiple_scales::fixed_points(&g).unwrap().unwrap().upper;
        check_multipliers(&exact(&g), epsilon, p.multipliers, p.eigenvalues);
    }
}

#[test]
fn second_method_multiplier_limits_of_strong_coupling() {
    let epsilon = TINY_EPSILON;
    for (beta2, mu13) in [(0.1, 1.0), (0.3, 1.0), (0.5, 0.7)] {
        let g = Groups { epsilon, beta2, mu13, sigma30: 0.5, ..Groups::basic() };
        let p = strong_coupling::solve(&g).unwrap().unwrap().upper;
        check_multipliers(&exact(&g), epsilon, p.multipliers, p.eigenvalues);
    }
}
