//! Strong coupling against multiple scales at no coupling, against its own equations, quadrature
//! and sampling.

use crate::error::Error;
use crate::parameters::Groups;
use crate::steady::strong_coupling::*;
use crate::steady::{Roots, multiple_scales};
use std::f64::consts::PI;

/// Tolerance: rounding of a closed form computed in two ways, with amplitudes of order one.
const ROUNDING: f64 = 1e-13;
/// Tolerance for eigenvalues by QR; a nearly double pair keeps half its digits.
const EIGENVALUE: f64 = 1e-9;

/// Tolerance for multipliers: a nearly double pair keeps half its digits.
const MULTIPLIER: f64 = 1e-6;
/// Phase before an impact at which its left limits are read, rad.
const BEFORE: f64 = 1e-10;
/// Tolerance for slopes: their change over [`BEFORE`], with the rounding of the phase.
const SLOPE: f64 = 1e-8;
/// Tolerance for W: its change over [`BEFORE`], with the rounding of the phase.
const RELATIVE: f64 = 1e-9;
/// Step of second differences.
const STEP: f64 = 1e-4;
/// Tolerance for second differences: rounding over the square of the step.
const SECOND_DIFFERENCE: f64 = 1e-6;
/// Tolerance for the midpoint rule with 20,000 nodes.
const QUADRATURE: f64 = 1e-7;
/// Tolerance for a sampled amplitude, which misses the maximum by the square of the spacing.
const SAMPLING: f64 = 1e-6;
/// Limit on the rounding by which a sampled amplitude may exceed the maximum.
const SAMPLE_ROUNDING: f64 = 1e-11;
/// Distance of β from 1 on either side.
const NEAR_ONE: f64 = 1e-5;
/// Limit on the difference of the amplitudes on either side of β = 1, where their slope is under
/// fifty.
const LIMIT: f64 = 1e-3;

fn strong() -> Groups {
    Groups { beta2: 0.3, mu13: 1.0, sigma30: 0.5, ..Groups::basic() }
}

fn points(g: &Groups) -> Vec<StrongPoint> {
    solve(g).unwrap().into_iter().flat_map(|r| [r.lower, r.upper]).collect()
}

#[test]
fn second_method_strong_coupling_without_coupling() {
    for kappa in [0.0, 0.5, 0.75, 1.0] {
        for (f10, sigma1) in [(1.5, 0.4), (2.5, -0.3), (-1.2, 0.1), (0.7, 0.5)] {
            let g = Groups { kappa, f10, sigma1, beta2: 0.0, ..Groups::basic() };
            let (a, b) = (solve(&g).unwrap(), multiple_scales::fixed_points(&g).unwrap());
            assert_eq!(a.is_some(), b.is_some());
            let (Some(a), Some(b)) = (a, b) else { continue };
            for (a, b) in [(a.lower, b.lower), (a.upper, b.upper)] {
                for (x, y) in [(a.c, b.c), (a.b, b.b), (a.a3, b.a3), (a.a1(), b.a1()), (a.a2(), b.a2())] {
                    assert!((x - y).abs() < ROUNDING, "{x} {y} {g:?}");
                }
                assert!((a.drive_phase - b.drive_phase).sin().abs() < ROUNDING);
                assert_eq!(a.admissibility, b.admissibility, "{a:?}\n{b:?}");
                for m in a.multipliers {
                    assert!(b.multipliers.iter().any(|n| (m - n).norm() < MULTIPLIER), "{a:?}\n{b:?}");
                }
                for e in a.eigenvalues {
                    assert!(b.eigenvalues.iter().any(|f| (e - f).norm() < EIGENVALUE * 1e3));
                }
                let (x, y) = (a.motion_at_drive(0.7), b.motion_at_drive(0.7));
                for (x, y) in [(x.u, y.u), (x.w, y.w), (x.dw, y.dw), (x.x[0], y.x[0]), (x.x[1], y.x[1])] {
                    assert!((x - y).abs() < 10.0 * ROUNDING);
                }
            }
        }
    }
}

#[test]
fn invariant_limit_of_no_coupling_is_smooth() {
    let zero = solve(&Groups { beta2: 0.0, ..strong() }).unwrap().unwrap().upper;
    for exponent in [4, 8, 12, 20, 40, 200, 300] {
        let beta2 = 10f64.powi(-exponent);
        let near = solve(&Groups { beta2, ..strong() }).unwrap().unwrap().upper;
        // Everything is analytic in β̂²; the slopes are under ten.
        let allowed = 10.0 * beta2 + ROUNDING;
        assert!((near.c - zero.c).abs() < allowed && (near.b - zero.b).abs() < allowed);
        assert!((near.motion(1.0).w - zero.motion(1.0).w).abs() < allowed);
        assert!((near.spectral_radius() - zero.spectral_radius()).abs() < 10.0 * allowed);
        assert_eq!(near.admissibility, zero.admissibility);
    }
}

#[test]
fn invariant_impact_law_and_equations_of_strong_coupling() {
    for g in
        [strong(), Groups { beta2: 2.0, f10: 3.0, ..strong() }, Groups { kappa: 0.2, beta2: 0.6, ..strong() }]
    {
        for p in points(&g) {
            let scale = 1.0 + p.c.abs() + p.b;
            let (at, before) = (p.motion(0.0), p.motion(-BEFORE));
            assert!((at.w - 1.0).abs() < ROUNDING * scale);
            assert!((at.dw + g.kappa * before.dw).abs() < SLOPE * scale);
            assert!((p.motion(PI - 1e-12).w + 1.0).abs() < RELATIVE * scale);
            // X2'' + β²(X2 - X3) = 0 in between, at leading order
            let h = STEP;
            let x2 = |s: f64| p.motion(s).w + p.motion(s).u;
            for s in [0.5, 1.5, 2.5] {
                let curvature = (x2(s + h) - 2.0 * x2(s) + x2(s - h)) / (h * h);
                assert!((curvature + g.beta2 * (x2(s) - p.motion(s).x[2])).abs() < SECOND_DIFFERENCE * scale);
            }
        }
    }
}

#[test]
fn second_method_balance_of_harmonics_by_quadrature() {
    // The solvability conditions by numerical Fourier integrals of the motion instead of the
    // closed form.
    let g = strong();
    for p in points(&g) {
        let n = 20_000;
        let (mut first, mut second) = (nalgebra::Complex::new(0.0, 0.0), nalgebra::Complex::new(0.0, 0.0));
        for i in 0..n {
            let s = PI * (f64::from(i) + 0.5) / f64::from(n);
            let m = p.motion(s);
            let (x2, turn) = (m.w + m.u, nalgebra::Complex::cis(-s) * (2.0 / f64::from(n)));
            // Im(z e^{is}) has z = (i/π)∫ f e^{-is} over the whole period, twice the half.
            let i_turn = nalgebra::Complex::new(0.0, 1.0) * turn;
            first += i_turn * (x2 - g.beta2 * (x2 - m.x[2]));
            second += i_turn * (g.mu13 * g.beta2 * (m.x[2] - x2));
        }
        let force = g.f10 * nalgebra::Complex::cis(p.drive_phase);
        let u = nalgebra::Complex::new(-2.0 * g.sigma1, g.gamma1) * p.u - force - first;
        let x = nalgebra::Complex::new(g.sigma30 - 2.0 * g.sigma1, g.gamma3) * p.x3 + second;
        assert!(u.norm() < QUADRATURE * (1.0 + p.b) && x.norm() < QUADRATURE * (1.0 + p.a3), "{u} {x}");
    }
}

#[test]
fn second_method_amplitudes_and_clearance_by_sampling() {
    for g in
        [strong(), Groups { beta2: 0.85, f10: 2.0, ..strong() }, Groups { beta2: 2.5, f10: 4.0, ..strong() }]
    {
        for p in points(&g) {
            let mut sampled = [0.0_f64; 3];
            for i in 0..20_000 {
                let m = p.motion(2.0 * PI * f64::from(i) / 20_000.0);
                for (best, x) in sampled.iter_mut().zip([m.x[0], m.x[1], m.w]) {
                    *best = best.max(x.abs());
                }
            }
            for (exact, sample) in [p.a1(), p.a2()].into_iter().zip(sampled) {
                assert!(
                    exact > sample - SAMPLE_ROUNDING * (1.0 + exact)
                        && exact - sample < SAMPLING * (1.0 + exact)
                );
            }
            assert_eq!(
                p.admissibility.geometric,
                sampled[2] < 1.0 + RELATIVE && p.motion(-RELATIVE).dw > 0.0
            );
        }
    }
}

#[test]
fn invariant_motion_near_beta_one() {
    // The singularity of β̂ = 1 is one of C alone: U tends to a limit from both sides.
    let u = |beta: f64| {
        let Roots { lower, upper } = solve(&Groups { beta2: beta * beta, ..strong() }).unwrap().unwrap();
        if upper.c.abs() > lower.c.abs() { upper.b } else { lower.b }
    };
    let (above, below) = (u(1.0 + NEAR_ONE), u(1.0 - NEAR_ONE));
    assert!((above - below).abs() < LIMIT, "{above} {below}");
}

#[test]
fn resonances_are_errors() {
    for beta in [1.0, 2.0, 3.0, 1.0 + 1e-9] {
        let e = solve(&Groups { beta2: beta * beta, ..strong() }).unwrap_err();
        assert!(matches!(e, Error::Undefined { name: "beta", .. }), "{e}");
    }
    let undamped = Groups { beta2: 0.5, mu13: 1.0, sigma30: 0.0, sigma1: 0.5, gamma3: 0.0, ..strong() };
    assert!(matches!(solve(&undamped), Err(Error::Undefined { name: "gamma3", .. })));
    assert!(matches!(
        solve(&Groups { beta2: f64::NAN, ..strong() }),
        Err(Error::OutOfRange { name: "beta2", .. })
    ));
}

#[test]
fn closed_form_sum_of_the_eigenvalues_where_sweeps_turn_in_circles() {
    // Elastic impacts and no dampers: the slow flow conserves volumes.
    for [epsilon, f10, sigma1, beta2, sigma30, mu13] in [
        [
            0.3559830366926683,
            0.18071539319857002,
            1.1115268028028602,
            0.13452962442818192,
            3.271926923633078,
            0.26783681850859314,
        ],
        [
            0.1424303026391679,
            0.06797328823390743,
            0.0,
            2.6915376822070725,
            -0.6772621099320908,
            0.25831487114853985,
        ],
        [
            0.0033640423189846753,
            4.997853133202947,
            3.4389006039710086,
            1.591355158533356,
            -0.56505900763554,
            8.402860001395883,
        ],
        [
            0.2597007575476307,
            9.140975084230707,
            0.8586823786820039,
            0.8685613991195966,
            2.9243073905289085,
            0.8269264279730152,
        ],
    ] {
        let (gamma1, gamma3, kappa) = (0.0, 0.0, 1.0);
        let g = Groups { epsilon, f10, sigma1, beta2, sigma30, mu13, gamma1, gamma3, kappa, ..strong() };
        let Roots { lower, upper } = solve(&g).unwrap().unwrap();
        for point in [lower, upper] {
            let sum: f64 = point.eigenvalues.iter().map(|e| e.re).sum();
            let size = point.eigenvalues.iter().map(|e| e.norm()).fold(1.0, f64::max);
            assert!(sum.abs() < 1e-12 * size, "{g:?} {sum}");
        }
    }
}
