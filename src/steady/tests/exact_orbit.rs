//! The exact orbit against direct integration by a classical method, and against the laws that it
//! must satisfy.

use crate::State;
use crate::error::Error;
use crate::parameters::{Groups, Parameters, Scales};
use crate::steady::Sheet;
use crate::steady::exact_orbit::*;
use std::f64::consts::{PI, TAU};

/// Tolerance for the golden p/m2 and radius of the default set, which have nine decimals. All
/// golden numbers are of an earlier prototype.
const GOLDEN: f64 = 6e-10;
/// Tolerance for golden amplitudes, which have seven decimals.
const GOLDEN_AMPLITUDE: f64 = 6e-8;
/// Limit on the excess of a maximum over its golden amplitude, which the prototype sampled.
const GOLDEN_SAMPLING: f64 = 3e-7;
/// Tolerance for the golden numbers of the second set, which have ten decimals.
const GOLDEN_SECOND: f64 = 6e-11;
/// Tolerance for the golden radius of the second set, which has eight decimals.
const GOLDEN_RADIUS: f64 = 6e-9;
/// Tolerance: rounding over half a period, with amplitudes of order one.
const ROUNDING: f64 = 1e-13;
/// Tolerance for the classical Runge-Kutta method with 2000 steps per half period: h⁴ ≈ 6e-12.
const RUNGE_KUTTA: f64 = 1e-10;
/// Tolerance for products of multipliers. The multipliers of nearly double pairs lose half their
/// digits, their products do not.
const PRODUCT: f64 = 1e-11;

/// Tolerance for a sampled amplitude, which misses the maximum by the square of the spacing.
const SAMPLING: f64 = 1e-5;
/// Largest excess of a sampled w over the stop that counts as a touch.
const TOUCH: f64 = 1e-9;
/// Step of the central differences.
const STEP: f64 = 1e-5;
/// Tolerance for the characteristic polynomial by central differences.
const DIFFERENCE: f64 = 1e-6;
/// Tolerance for Simpson's rule with 2000 intervals over half a period.
const QUADRATURE: f64 = 1e-9;
/// Limit on the two multipliers that a plastic impact makes zero: a double one is accurate to the
/// root of the rounding.
const LOST_MULTIPLIER: f64 = 1e-6;

fn basic() -> ExactOrbit {
    solve(&Parameters::default()).unwrap().upper.unwrap()
}

fn weak(g: [f64; 8]) -> Parameters {
    let [epsilon, kappa, f10, sigma1, gamma1, alpha23, sigma30, gamma3] = g;
    Groups::weak(epsilon, kappa, f10, sigma1, gamma1, alpha23, sigma30, gamma3)
        .to_parameters(Scales::default())
        .unwrap()
}

/// Parameters with comparable masses and no unit scale.
fn odd() -> Parameters {
    Parameters {
        box_mass: 2.3,
        box_stiffness: 410.0,
        box_damping: 3.1,
        block_mass: 1.1,
        secondary_mass: 0.7,
        secondary_stiffness: 230.0,
        secondary_damping: 1.7,
        coupling_stiffness: 35.0,
        stop_gap: 0.02,
        stop_restitution: 0.6,
        drive_amplitude: 14.0,
        drive_frequency: 14.5,
        drive_phase: 0.4,
        constant_loads: [0.0; 3],
    }
}

fn orbits() -> Vec<ExactOrbit> {
    let mut all = Vec::new();
    for p in [Parameters::default(), odd(), weak([0.1, 0.75, 1.5, 0.5, 0.4, 0.1, 0.5, 0.2])] {
        for scale in [0.6, 1.0, -1.3, 3.0] {
            let p = Parameters { drive_amplitude: scale * p.drive_amplitude, ..p };
            let roots = solve(&p).unwrap();
            all.extend(roots.lower.into_iter().chain(roots.upper));
        }
    }
    assert!(all.len() >= 9, "{}", all.len());
    all
}

/// Accelerations straight from docs/theory.md (3), without the code under test.
fn acceleration(p: &Parameters, theta: f64, s: &State) -> [f64; 3] {
    let ([x1, x2, x3], [v1, _, v3]) = (s.x, s.v);
    [
        (p.drive_amplitude * theta.sin() - p.box_damping * v1 - p.box_stiffness * x1) / p.box_mass,
        -p.coupling_stiffness * (x2 - x3) / p.block_mass,
        -(p.secondary_damping * v3 + p.secondary_stiffness * x3 + p.coupling_stiffness * (x3 - x2))
            / p.secondary_mass,
    ]
}

/// The classical Runge-Kutta method from phase `theta` over `turn` rad.
fn integrate(p: &Parameters, mut theta: f64, mut s: State, turn: f64, steps: u32) -> State {
    let (turn_step, h) = (turn / f64::from(steps), turn / f64::from(steps) / p.drive_frequency);
    for _ in 0..steps {
        let rate = |s: &State, theta| (s.v, acceleration(p, theta, s));
        let moved = |k: &([f64; 3], [f64; 3]), by: f64| State {
            x: std::array::from_fn(|i| s.x[i] + by * k.0[i]),
            v: std::array::from_fn(|i| s.v[i] + by * k.1[i]),
        };
        let k1 = rate(&s, theta);
        let k2 = rate(&moved(&k1, h / 2.0), theta + turn_step / 2.0);
        let k3 = rate(&moved(&k2, h / 2.0), theta + turn_step / 2.0);
        let k4 = rate(&moved(&k3, h), theta + turn_step);
        for i in 0..3 {
            s.x[i] += h / 6.0 * (k1.0[i] + 2.0 * k2.0[i] + 2.0 * k3.0[i] + k4.0[i]);
            s.v[i] += h / 6.0 * (k1.1[i] + 2.0 * k2.1[i] + 2.0 * k3.1[i] + k4.1[i]);
        }
        theta += turn_step;
    }
    s
}

/// Largest difference of two states in units of L and ω1 L.
fn distance(p: &Parameters, a: &State, b: &State, sign: f64) -> f64 {
    let far = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| (a[i] - sign * b[i]).abs()).fold(0.0, f64::max);
    far(a.x, b.x).max(far(a.v, b.v) / p.drive_frequency) / p.stop_gap
}

#[test]
fn golden_orbit_of_the_default_set() {
    let orbit = basic();
    assert!((orbit.impulse() / 0.1 - 1.597276346).abs() < GOLDEN, "{}", orbit.impulse() / 0.1);
    let golden = [0.3574008, 1.2801013, 0.9555490];
    for (a, b) in orbit.amplitudes().into_iter().zip(golden) {
        assert!(a - b > -GOLDEN_AMPLITUDE && a - b < GOLDEN_SAMPLING, "{a} {b}");
    }
    assert!((orbit.spectral_radius() - 0.912416827).abs() < GOLDEN, "{}", orbit.spectral_radius());
    assert!(orbit.is_stable());
}

#[test]
fn golden_orbit_of_the_second_set() {
    let p = weak([0.1, 0.75, 1.5, 0.5, 0.4, 0.1, 0.5, 0.2]);
    let orbit = solve(&p).unwrap().upper.unwrap();
    assert!((orbit.impulse() / 0.1 - 1.6953736454).abs() < GOLDEN_SECOND);
    assert!((orbit.after_impact().x[1] - 1.2794804764).abs() < GOLDEN_SECOND);
    assert!((orbit.spectral_radius() - 0.97050802).abs() < GOLDEN_RADIUS);
}

#[test]
fn invariant_impact_law_and_stop_of_the_exact_orbit() {
    for orbit in orbits() {
        let (p, a, b) = (orbit.parameters(), orbit.after_impact(), orbit.before_impact());
        let scale = p.stop_gap * p.drive_frequency * (1.0 + orbit.impulse() / orbit.parameters().block_mass);
        assert_eq!(a.x, b.x);
        assert!(((a.x[1] - a.x[0]) / p.stop_gap - 1.0).abs() < ROUNDING * 10.0);
        let (before, after) = (b.v[1] - b.v[0], a.v[1] - a.v[0]);
        assert!((after + p.stop_restitution * before).abs() < 100.0 * ROUNDING * scale);
        let mu = p.box_mass * p.block_mass / (p.box_mass + p.block_mass);
        let impulse = (1.0 + p.stop_restitution) * mu * before;
        assert!((impulse / orbit.impulse() - 1.0).abs() < 100.0 * ROUNDING);
        assert!((a.v[0] - b.v[0] - impulse / p.box_mass).abs() < 100.0 * ROUNDING * scale);
        assert_eq!(a.v[2], b.v[2]);
    }
}

#[test]
fn second_method_half_a_period_by_runge_kutta() {
    for orbit in orbits() {
        let p = orbit.parameters();
        let end = integrate(p, orbit.drive_phase(), orbit.after_impact(), PI, 2000);
        let size = 1.0 + orbit.amplitudes()[1] / p.stop_gap;
        assert!(distance(p, &end, &orbit.before_impact(), -1.0) < RUNGE_KUTTA * size);
    }
}

#[test]
fn second_method_state_at_any_phase_by_runge_kutta() {
    let orbit = solve(&odd()).unwrap().upper.unwrap();
    let p = orbit.parameters();
    for turn in [0.0, 0.3, 1.7, 3.1] {
        let there = integrate(p, orbit.drive_phase(), orbit.after_impact(), turn, 2000);
        for (laps, sign) in [(0.0, 1.0), (TAU, 1.0), (PI, -1.0), (-3.0 * PI, -1.0)] {
            let state = orbit.state(orbit.drive_phase() + turn + laps);
            assert!(distance(p, &there, &state, sign) < RUNGE_KUTTA, "{turn} {laps}");
        }
    }
    assert_eq!(orbit.initial_state(), orbit.state(0.4));
}

#[test]
fn second_method_amplitudes_and_clearance_by_sampling() {
    for orbit in orbits() {
        let (gap, mut sampled, mut w) = (orbit.parameters().stop_gap, [0.0_f64; 3], 0.0_f64);
        for i in 0..4000 {
            let s = orbit.state(TAU * f64::from(i) / 4000.0 + orbit.drive_phase());
            (0..3).for_each(|k| sampled[k] = sampled[k].max(s.x[k].abs()));
            w = w.max((s.x[1] - s.x[0]).abs() / gap);
        }
        for (exact, sample) in orbit.amplitudes().into_iter().zip(sampled) {
            let excess = (exact - sample) / gap;
            assert!(
                excess > -ROUNDING * 100.0 && excess < SAMPLING * (1.0 + exact / gap),
                "{exact} {sample}"
            );
        }
        assert_eq!(orbit.is_clear(), w < 1.0 + TOUCH, "{w}");
    }
}

#[test]
fn second_method_multipliers_by_differences_of_the_map() {
    // Perturb the state after the impact, fly to the lower stop by Runge-Kutta, reflect, and
    // difference.
    for p in [Parameters::default(), odd()] {
        let orbit = solve(&p).unwrap().upper.unwrap();
        let (length, speed) = (p.stop_gap, p.stop_gap * p.drive_frequency);
        let map = |delta: [f64; 6]| {
            let mut s = orbit.after_impact();
            for i in 0..3 {
                s.x[i] += delta[i] * length;
                s.v[i] += delta[i + 3] * speed;
            }
            let mut turn = PI;
            let mut end = s;
            for _ in 0..6 {
                end = integrate(&p, orbit.drive_phase(), s, turn, 3000);
                let gap = (end.x[1] - end.x[0]) / length + 1.0;
                turn -= gap / ((end.v[1] - end.v[0]) / speed);
            }
            let jump = (1.0 + p.stop_restitution) * (end.v[1] - end.v[0]) / (p.box_mass + p.block_mass);
            end.v[0] += p.block_mass * jump;
            end.v[1] -= p.box_mass * jump;
            // Back to the phase δ + π with the flow after the impact, then mirrored.
            let back = integrate(&p, orbit.drive_phase() + turn, end, PI - turn, 20);
            let x = back.x.map(|x| -x / length);
            let v = back.v.map(|v| -v / speed);
            [x[0], x[1], x[2], v[0], v[1], v[2]]
        };
        let h = STEP;
        let mut matrix = nalgebra::Matrix6::<f64>::zeros();
        for column in 0..6 {
            let shifted = |by: f64| {
                let mut delta = [0.0; 6];
                delta[column] = by;
                map(delta)
            };
            let (up, down) = (shifted(h), shifted(-h));
            (0..6).for_each(|row| matrix[(row, column)] = (up[row] - down[row]) / (2.0 * h));
        }
        // Compare characteristic polynomials at points off the spectrum: smooth in the matrix.
        let exact = orbit.multipliers();
        for z in [1.0, -1.0, 0.3, 2.0] {
            let from_map = (nalgebra::Matrix6::identity() * z - matrix).determinant();
            let product = exact.iter().fold(nalgebra::Complex::new(1.0, 0.0), |acc, m| acc * (z - m));
            assert!(product.im.abs() < PRODUCT);
            assert!(
                (from_map - product.re).abs() < DIFFERENCE * (1.0 + product.re.abs()),
                "{from_map} {product}"
            );
        }
    }
}

#[test]
fn closed_form_of_the_determinant_of_the_half_map() {
    // Each impact multiplies volumes by κ², the flight by exp(-∫ damping): an invariant of the six
    // multipliers.
    for orbit in orbits() {
        let p = orbit.parameters();
        let damping = p.box_damping / p.box_mass + p.secondary_damping / p.secondary_mass;
        let expected = p.stop_restitution.powi(2) * (-damping * PI / p.drive_frequency).exp();
        let product: nalgebra::Complex<f64> = orbit.multipliers().into_iter().product();
        let scale = orbit.spectral_radius().powi(3).max(1.0);
        assert!((product.re - expected).abs() < PRODUCT * scale && product.im.abs() < PRODUCT * scale);
    }
}

#[test]
fn closed_form_of_the_determinant_at_the_fold() {
    // docs/theory.md (80): the slope of the quadratic shows on which side of one the real
    // multipliers are.
    let mut lower = 0;
    for orbit in orbits() {
        let p = orbit.parameters();
        let (a, b, _) = OrbitFamily::new(p).unwrap().quadratic();
        let flight = Flight::new(p).unwrap().transition(PI);
        let [one, pair] = [
            (nalgebra::Matrix2::identity() + flight.one).determinant(),
            (nalgebra::Matrix4::identity() + flight.pair).determinant(),
        ];
        let impulse = orbit.impulse() / (p.block_mass * p.drive_frequency * p.stop_gap);
        let share = (1.0 + p.stop_restitution) / (1.0 + p.block_mass / p.box_mass);
        let expected = share.powi(2) * (a + 0.5 * b / impulse) * one * pair;
        let found: nalgebra::Complex<f64> = orbit.multipliers().into_iter().map(|m| 1.0 - m).product();
        let scale = (1.0 + orbit.spectral_radius()).powi(3);
        assert!((found.re - expected).abs() < PRODUCT * scale, "{found} {expected}");
        if orbit.sheet() == Sheet::Lower {
            assert!(expected < 0.0 && orbit.spectral_radius() > 1.0 && !orbit.is_stable());
            lower += 1;
        }
    }
    assert!(lower > 0);
}

#[test]
fn invariant_energy_balance_over_half_a_period() {
    // Work of the drive = damping losses + impact loss, integrated by Simpson's rule on the orbit
    // itself.
    let orbit = solve(&odd()).unwrap().upper.unwrap();
    let p = *orbit.parameters();
    let n = 2000;
    let power = |i: u32| {
        let theta = orbit.drive_phase() + PI * f64::from(i) / f64::from(n);
        // The last node lies at the next impact: the state before it is needed.
        let s = if i < n { orbit.state(theta) } else { orbit.before_impact() };
        let sign = if i < n { 1.0 } else { -1.0 };
        let v = s.v.map(|v| sign * v);
        p.drive_amplitude * theta.sin() * v[0]
            - p.box_damping * v[0] * v[0]
            - p.secondary_damping * v[2] * v[2]
    };
    let weight = |i: u32| if i == 0 || i == n { 1.0 } else { 2.0 + 2.0 * f64::from(i % 2) };
    let work: f64 =
        (0..=n).map(|i| weight(i) * power(i)).sum::<f64>() * PI / p.drive_frequency / f64::from(n) / 3.0;
    let b = orbit.before_impact();
    let mu = p.box_mass * p.block_mass / (p.box_mass + p.block_mass);
    let lost = 0.5 * (1.0 - p.stop_restitution.powi(2)) * mu * (b.v[1] - b.v[0]).powi(2);
    assert!((work / lost - 1.0).abs() < QUADRATURE, "{work} {lost}");
}

#[test]
fn wrong_parameters_are_errors() {
    let bad = |p: Parameters| solve(&p).unwrap_err();
    let p = Parameters::default();
    assert!(matches!(bad(Parameters { box_mass: -1.0, ..p }), Error::OutOfRange { name: "box.m", .. }));
    assert!(matches!(
        bad(Parameters { drive_frequency: 0.0, ..p }),
        Error::Undefined { name: "drive.frequency", .. }
    ));
    assert!(matches!(
        bad(Parameters { box_damping: 0.0, drive_frequency: 1.0, ..p }),
        Error::Undefined { .. }
    ));
    assert!(matches!(bad(Parameters { secondary_stiffness: 1e12, ..p }), Error::PrecisionLost { .. }));
    let none = solve(&Parameters { drive_amplitude: 0.0, ..p }).unwrap();
    assert!(none.lower.is_none() && none.upper.is_none());
}

#[test]
fn invariant_plastic_and_elastic_impacts() {
    let plastic = solve(&Parameters { stop_restitution: 0.0, ..Parameters::default() }).unwrap();
    for orbit in plastic.lower.into_iter().chain(plastic.upper) {
        let a = orbit.after_impact();
        assert!((a.v[1] - a.v[0]).abs() < ROUNDING * 10.0);
        assert!(orbit.multipliers()[5].norm() < LOST_MULTIPLIER);
    }
    let elastic =
        solve(&Parameters { stop_restitution: 1.0, ..Parameters::default() }).unwrap().upper.unwrap();
    let (a, b) = (elastic.after_impact(), elastic.before_impact());
    assert!((a.v[1] - a.v[0] + b.v[1] - b.v[0]).abs() < ROUNDING * 10.0);
}

/// Orbits with much rounding: half a period has thousands of Taylor pieces with a strong damper,
/// and numbers of thousands of gaps cancel next to the resonance of a box without damper. The
/// rounding must not count as a stop that is met earlier.
#[test]
fn second_method_orbits_of_more_rounding_are_those_of_the_simulator() {
    let p = Parameters {
        box_mass: 1.62,
        box_stiffness: 1.02,
        box_damping: 0.068,
        block_mass: 0.086,
        secondary_mass: 0.0219,
        secondary_stiffness: 0.131,
        coupling_stiffness: 0.0021,
        stop_restitution: 0.807,
        drive_amplitude: 0.192,
        drive_frequency: 0.566,
        ..Parameters::default()
    };
    let damped = (0..24).map(|k| Parameters { secondary_damping: 30.0 + 2.0 * f64::from(k), ..p });
    let resonant = Parameters {
        box_mass: 0.41314948147566255,
        box_stiffness: 0.23020400887489528,
        box_damping: 0.0,
        block_mass: 0.5120194826230695,
        secondary_mass: 0.08295995253978093,
        secondary_stiffness: 0.2557568859202801,
        secondary_damping: 0.2742880659078564,
        coupling_stiffness: 0.08376871478062772,
        stop_restitution: 0.37374861547228583,
        drive_amplitude: 0.10710638844960861,
        drive_frequency: 0.7465804971508866,
        ..p
    };
    for p in damped.chain([resonant]) {
        let orbit = solve(&p).unwrap().upper.unwrap();
        let flight = Flight::new(&p).unwrap();
        assert!(flight.pieces >= 8192 || flight.harmonic(&p).unwrap().norm() > 1000.0);
        // The simulator starts just after the impact and meets the other stop after half a period.
        let after = orbit.after_impact();
        let q = Parameters { drive_phase: orbit.drive_phase(), ..p };
        let mut simulator = crate::Simulator::new(&q, &after, 0.0).unwrap();
        let half = 0.5 * p.period();
        simulator.advance_to((1.0 - 1e-6) * half).unwrap();
        assert_eq!(simulator.impacts().upper + simulator.impacts().lower, 0);
        simulator.advance_to((1.0 + 1e-6) * half).unwrap();
        assert_eq!(simulator.impacts().lower, 1);
        assert!(orbit.is_clear(), "{p:?}");
    }
}
