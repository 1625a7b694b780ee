//! Orbits of machines with curved forces against a Fourier collocation, the motion's own
//! derivatives and differences.

use super::*;
use nalgebra::DVector;
use std::f64::consts::{PI, TAU};
use vibro_machine::Start;

/// Points in a period of the collocation. Twice as many change nothing above rounding.
const POINTS: usize = 101;
/// Tolerance for states of order 1: rounding of the collocation's second derivatives.
const COLLOCATED: f64 = 1e-10;
/// Tolerance for the moduli of multipliers, and for an orbit that is simulated again.
const ROUNDING: f64 = 1e-9;
/// Tolerance for a column, relative: rounding of the difference that it is compared with.
const APART: f64 = 1e-6;

/// Two bodies with curved springs and a curved dashpot, driven at `frequency` Hz.
fn chain(frequency: f64, more: &str) -> Machine {
    machine(&format!(
        "name = \"Chain\"\nbody.a = {{ mass = 1.0 }}\nbody.b = {{ mass = 0.3 }}\n\
         spring.a = {{ between = [\"ground\", \"a\"], stiffness = 40.0, cubic = 300.0, damping = 0.4 }}\n\
         spring.b = {{ between = [\"a\", \"b\"], stiffness = 5.0, quadratic = 10.0, cubic = 200.0, damping = 0.1 }}\n\
         damper.c = {{ between = [\"ground\", \"b\"], damping = 0.05, cubic = 0.3 }}\n\
         load.l = {{ on = \"a\", amplitude = 6.0, frequency = {frequency} }}\n{more}"
    ))
}

/// Displacements of both bodies at [`POINTS`] times of a period, by Newton's method on the
/// equations of motion at these times, with derivatives of the trigonometric interpolation.
fn collocated(frequency: f64) -> DVector<f64> {
    let n = POINTS;
    let slope = DMatrix::from_fn(n, n, |i, j| match i as i64 - j as i64 {
        0 => 0.0,
        k => PI * frequency * (-1f64).powi(k as i32) / (PI * k as f64 / n as f64).sin(),
    });
    let bend = &slope * &slope;
    let mut x = DVector::zeros(2 * n);
    for force in (1..=20).map(|k| 0.3 * f64::from(k)) {
        for _ in 0..30 {
            let (a, b) = (x.rows(0, n).into_owned(), x.rows(n, n).into_owned());
            let (va, vb, aa, ab) = (&slope * &a, &slope * &b, &bend * &a, &bend * &b);
            let (mut residual, mut matrix) = (DVector::zeros(2 * n), DMatrix::zeros(2 * n, 2 * n));
            matrix.view_mut((0, 0), (n, n)).copy_from(&(&bend + &slope * 0.5));
            matrix.view_mut((0, n), (n, n)).copy_from(&(&slope * -0.1));
            matrix.view_mut((n, 0), (n, n)).copy_from(&(&slope * -0.1));
            matrix.view_mut((n, n), (n, n)).copy_from(&(&bend * 0.3 + &slope * 0.15));
            for i in 0..n {
                let (e, rate) = (b[i] - a[i], vb[i] - va[i]);
                let inner = 5.0 * e + 10.0 * e * e + 200.0 * e.powi(3) + 0.1 * rate;
                let stiffness = 5.0 + 20.0 * e + 600.0 * e * e;
                let load = force * (TAU * i as f64 / n as f64).sin();
                residual[i] = aa[i] + 40.0 * a[i] + 300.0 * a[i].powi(3) + 0.4 * va[i] - inner - load;
                residual[n + i] = 0.3 * ab[i] + inner + 0.05 * vb[i] + 0.3 * vb[i].powi(3);
                matrix[(i, i)] += 40.0 + 900.0 * a[i] * a[i] + stiffness;
                matrix[(i, n + i)] -= stiffness;
                matrix[(n + i, i)] -= stiffness;
                matrix[(n + i, n + i)] += stiffness;
                for j in 0..n {
                    matrix[(n + i, n + j)] += 0.9 * vb[i] * vb[i] * slope[(i, j)];
                }
            }
            let step = matrix.lu().solve(&residual).expect("a regular matrix");
            x -= &step;
            if step.amax() < 1e-14 {
                break;
            }
        }
    }
    x
}

#[test]
fn second_method_fourier_collocation_of_curved_chains() {
    for frequency in [0.5, 3.0, 4.0] {
        let orbit = Orbit::settled(&chain(frequency, ""), &Start::default(), 200).unwrap();
        let x = collocated(frequency);
        let (time, state) = orbit.middle_state();
        // The trigonometric interpolation at this time.
        let n = POINTS as f64;
        let weight = |i: usize| {
            let turn = PI * (time * frequency - i as f64 / n);
            (n * turn).sin() / (n * turn.sin())
        };
        for body in 0..2 {
            let there: f64 = (0..POINTS).map(|i| weight(i) * x[body * POINTS + i]).sum();
            let off = (there - state[body]).abs();
            assert!(off < COLLOCATED, "{frequency} Hz, body {body}: {there} by collocation, off by {off:e}");
        }
    }
}

#[test]
fn second_method_multipliers_and_columns_of_curved_chains() {
    let stops = "stop.wall = { between = [\"ground\", \"b\"], gap = 0.3, restitution = 0.6 }\n\
                 stop.soft = { between = [\"a\", \"ground\"], gap = 0.2, stiffness = 500.0, damping = 1.0 }\n\
                 friction.f = { between = [\"ground\", \"a\"], force = 0.1 }\n";
    for (frequency, more) in [(0.5, ""), (1.1, stops)] {
        let machine = chain(frequency, more);
        let orbit = Orbit::settled(&machine, &Start::default(), 400).unwrap();
        assert_eq!(orbit.word().is_empty(), more.is_empty());
        assert!(orbit.check_by_motion().unwrap() < ROUNDING);
        let (own, by_motion) = (orbit.multipliers(), moduli_by_motion(&orbit));
        let mut moduli: Vec<f64> = own.iter().map(|m| m.norm()).collect();
        moduli.sort_by(|a, b| b.total_cmp(a));
        for (own, other) in moduli.iter().zip(&by_motion) {
            assert!((own - other).abs() < ROUNDING, "{frequency} Hz: {moduli:?} {by_motion:?}");
        }
        for parameter in [
            "load.l.frequency",
            "load.l.amplitude",
            "spring.a.cubic",
            "spring.b.quadratic",
            "damper.c.cubic",
            "body.b.mass",
            "spring.a.stiffness",
        ] {
            let present = machine.description.get(parameter).unwrap();
            let apart = column_apart(&machine, &orbit, (parameter, 0.1 * present));
            assert!(apart < APART, "{frequency} Hz, {parameter}: {apart:e}");
        }
    }
}
