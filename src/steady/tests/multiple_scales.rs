//! Multiple scales against its own equations by other methods: differences, sampling, elimination.

use crate::error::Error;
use crate::parameters::Groups;
use crate::steady::multiple_scales::*;
use crate::steady::{Bifurcation, Roots};
use std::f64::consts::PI;

/// Tolerance for golden numbers, which have nine decimals.
const GOLDEN: f64 = 5e-10;
/// Tolerance for golden ends of ranges, which have three decimals.
const GOLDEN_RANGE: f64 = 5e-4;
/// Tolerance: rounding of closed forms of amplitudes of order one.
const ROUNDING: f64 = 1e-13;
/// Tolerance for central differences with step 1e-6: rounding 1e-10; third derivatives grow with
/// powers of 1/B, and B is at least 0.05 here.
const DIFFERENCE: f64 = 1e-6;
/// Tolerance for nalgebra's QR against closed form; eigenvalues of order one, some nearly double.
const EIGENVALUE: f64 = 1e-9;

/// Step of the central differences.
const STEP: f64 = 1e-6;
/// Phase before an impact at which its left limits are read, rad.
const BEFORE: f64 = 1e-9;
/// Tolerance for slopes of order one: their change over [`BEFORE`], with the rounding of the
/// phase.
const SLOPE: f64 = 1e-7;
/// Tolerance: rounding of an amplitude or of W computed from another phase.
const PHASE_ROUNDING: f64 = 1e-12;
/// Tolerance for a sampled amplitude, which misses the maximum by the square of the spacing.
const SAMPLING: f64 = 1e-7;

fn basic() -> Roots<FixedPoint> {
    fixed_points(&Groups::basic()).unwrap().unwrap()
}

fn sets() -> Vec<Groups> {
    let mut sets = vec![Groups::basic(), Groups::weak(0.1, 0.75, 1.5, 0.5, 0.4, 0.1, 0.5, 0.2)];
    for kappa in [0.0, 0.3, 0.9, 1.0] {
        for sigma1 in [-0.8, -0.1, 0.0, 0.6] {
            for f10 in [0.7, 1.5, -2.5, 6.0] {
                sets.push(Groups::weak(0.05, kappa, f10, sigma1, 0.3, 0.8, 0.2, 0.5));
            }
        }
    }
    sets
}

fn states() -> Vec<(MultipleScales, FixedPoint)> {
    let solve = |g: &Groups| {
        let flow = MultipleScales::new(g).unwrap();
        flow.fixed_points().map(|r| [(flow, r.lower), (flow, r.upper)])
    };
    let all: Vec<_> = sets().iter().filter_map(solve).flatten().collect();
    assert!(all.len() > 60, "the grid has lost its solutions: {}", all.len());
    all
}

fn slow_state(p: &FixedPoint) -> SlowState {
    SlowState { b: p.b, psi: p.psi, a3: p.a3, psi3: p.psi3 }
}

#[test]
fn golden_fixed_point_of_the_default_set() {
    let p = basic().upper;
    assert!((p.c - 1.340127767).abs() < GOLDEN, "{}", p.c);
    assert!((p.b - 0.361305063).abs() < GOLDEN, "{}", p.b);
    assert!((p.a3 - 1.030523031).abs() < GOLDEN, "{}", p.a3);
    assert!(p.admissibility.all());
    assert_eq!(p.branch, Branch::Right);
    assert!(!basic().lower.admissibility.all());
}

#[test]
fn golden_force_range_of_the_default_set() {
    let range = MultipleScales::new(&Groups::basic()).unwrap().force_range().unwrap();
    let (low, high) = range.admissible.unwrap();
    assert!((low - 0.891).abs() < GOLDEN_RANGE && (high - 2.136).abs() < GOLDEN_RANGE, "{low} {high}");
}

#[test]
fn second_method_force_range_by_its_tests() {
    for g in sets() {
        let range = MultipleScales::new(&g).unwrap().force_range().unwrap();
        let count = |f10: f64| {
            let roots = fixed_points(&Groups { f10, ..g }).unwrap();
            let roots: Vec<_> = roots.into_iter().flat_map(|r| [r.lower, r.upper]).collect();
            let positive = roots.iter().filter(|p| p.c > 0.0).count();
            (roots.len(), positive, roots.iter().any(|p| p.admissibility.all()))
        };
        for i in 1..200 {
            let f = 0.025 * f64::from(i) + 1e-4;
            let (real, positive, admissible) = count(f);
            assert_eq!(real == 2, f >= range.real_from);
            assert_eq!(
                positive,
                usize::from(f >= range.positive_from)
                    + usize::from(f >= range.positive_from && f < range.two_until),
                "{g:?} {f}"
            );
            assert_eq!(
                admissible,
                range.admissible.is_some_and(|(low, high)| f > low && f < high),
                "{g:?} {f} {range:?}"
            );
        }
    }
}

#[test]
fn invariant_fixed_points_are_zeros_of_the_slow_flow() {
    for (flow, p) in states() {
        let rate = flow.slow_flow(p.branch, &slow_state(&p)).unwrap();
        let scale = 1.0 + p.c.abs() + flow.groups().f10.abs() / p.b;
        // dC/dB grows without bound at C_min and magnifies the rounding of B.
        let near = 1.0 / (p.c / flow.manifold().c_min() - 1.0).abs();
        assert!(rate.iter().all(|r| r.abs() < ROUNDING * scale * (1.0 + near)), "{p:?}\n{rate:?}");
    }
}

#[test]
fn second_method_jacobian_by_differences() {
    let h = STEP;
    for (flow, p) in states() {
        if (p.c / flow.manifold().c_min() - 1.0).abs() < 0.05 {
            continue; // the slope of C(B) has no bound at C_min
        }
        let s = SlowState { b: 1.02 * p.b, psi: p.psi + 0.1, a3: 0.9 * p.a3, psi3: p.psi3 - 0.2 };
        let jacobian = flow.jacobian(p.branch, &s).unwrap();
        for column in 0..4 {
            let shifted = |by: f64| {
                let mut t = s;
                *[&mut t.b, &mut t.psi, &mut t.a3, &mut t.psi3][column] += by;
                flow.slow_flow(p.branch, &t).unwrap()
            };
            let (up, down) = (shifted(h), shifted(-h));
            for row in 0..4 {
                let slope = (up[row] - down[row]) / (2.0 * h);
                let exact = jacobian[(row, column)];
                assert!(
                    (slope - exact).abs() < DIFFERENCE * (1.0 + exact.abs()),
                    "({row}, {column}) {slope} {exact} {p:?}"
                );
            }
        }
    }
}

#[test]
fn second_method_eigenvalues_by_the_jacobian() {
    for (flow, p) in states() {
        let jacobian = flow.jacobian(p.branch, &slow_state(&p)).unwrap();
        let size = jacobian.norm();
        for e in jacobian.complex_eigenvalues().iter() {
            let nearest = p.eigenvalues.iter().map(|x| (x - e).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < EIGENVALUE * size.max(1.0).powi(2), "{e} of {p:?}");
        }
    }
}

#[test]
fn second_method_quadratic_by_elimination() {
    for g in sets() {
        let flow = MultipleScales::new(&g).unwrap();
        let (rho, big_g) = (flow.manifold().rho(), g.gamma1.powi(2) + 4.0 * g.sigma1.powi(2));
        let (a, b, c) = flow.quadratic();
        let p2 = PI * PI;
        assert!(
            (a - (big_g * (1.0 + rho * rho)
                + 16.0 / p2 * (g.gamma1 * rho + 2.0 * g.sigma1)
                + 64.0 / p2 / p2))
                .abs()
                < ROUNDING
        );
        assert!((b - (-2.0 * big_g - 32.0 / p2 * g.sigma1)).abs() < ROUNDING);
        assert!((c - (big_g - g.f10 * g.f10)).abs() < 1e2 * ROUNDING);
        assert!((flow.discriminant() - (b * b - 4.0 * a * c)).abs() < 1e3 * ROUNDING);
    }
}

#[test]
fn second_method_periodic_motion_by_the_multipliers() {
    for (_, p) in states().into_iter().filter(|(_, p)| p.c > 0.0) {
        assert_eq!(p.admissibility.periodic_motion, p.spectral_radius() < 1.0, "{p:?}");
    }
    let strong = fixed_points(&Groups { f10: 2.2, ..Groups::basic() }).unwrap().unwrap().upper;
    assert_eq!(strong.bifurcation(), Bifurcation::SymmetryBreaking);
}

#[test]
fn invariant_impact_law_of_the_multiple_scales_motion() {
    for (flow, p) in states() {
        let (at, before) = (p.motion(p.impact_phase), p.motion(p.impact_phase - BEFORE));
        assert!((at.w - 1.0).abs() < ROUNDING * (1.0 + p.c.abs()));
        let kappa = flow.groups().kappa;
        assert!((at.dw + kappa * before.dw).abs() < SLOPE * (1.0 + p.c.abs()));
        // momentum: U is smooth
        assert!((at.du - before.du).abs() < SLOPE * (1.0 + p.b));
        // motion at this instant by the phase of the drive
        let drive = p.motion_at_drive(p.drive_phase);
        assert!((drive.w.abs() - 1.0).abs() < PHASE_ROUNDING * (1.0 + p.c.abs()));
    }
}

#[test]
fn second_method_amplitudes_by_sampling() {
    for (_, p) in states() {
        let mut sampled = [0.0_f64; 3];
        for i in 0..40_000 {
            let m = p.motion(p.impact_phase + 2.0 * PI * f64::from(i) / 40_000.0);
            for (best, x) in sampled.iter_mut().zip(m.x) {
                *best = best.max(x.abs());
            }
        }
        for (value, sample) in [p.a1(), p.a2(), p.a3].into_iter().zip(sampled) {
            assert!(
                value >= sample - PHASE_ROUNDING * (1.0 + value) && value - sample < SAMPLING * (1.0 + value),
                "{p:?}"
            );
        }
    }
}

#[test]
fn wrong_groups_are_errors() {
    for (g, name) in [
        (Groups { kappa: 1.5, ..Groups::basic() }, "kappa"),
        (Groups { sigma1: f64::NAN, ..Groups::basic() }, "sigma1"),
        (Groups { gamma3: -1.0, ..Groups::basic() }, "gamma3"),
        (Groups { f10: f64::INFINITY, ..Groups::basic() }, "f10"),
    ] {
        assert!(matches!(fixed_points(&g), Err(Error::OutOfRange { name: n, .. }) if n == name));
    }
    let resonant = Groups::weak(0.1, 0.75, 1.5, 0.5, 0.4, 0.5, 0.5, 0.0);
    assert!(matches!(fixed_points(&resonant), Err(Error::Undefined { name: "gamma3", .. })));
    assert!(fixed_points(&Groups { f10: 0.0, ..Groups::basic() }).unwrap().is_none());
}
