//! The simulator against motions in closed form.

use vibro_impact::simulator::{Contact, Event, Loads, Pause};
use vibro_impact::{Parameters, Simulator, State};
use vibro_numerics::double_double::DoubleDouble;

/// A few hundred roundings of numbers of order one, over at most a few hundred sub-steps.
const ROUNDING: f64 = 2e-13;

/// Three independent bodies: no coupling spring, and stops out of reach.
fn uncoupled() -> Parameters {
    Parameters { coupling_stiffness: 0.0, stop_gap: 1e4, ..Parameters::default() }
}

/// Displacement and velocity at t of x'' + 2 d x' + w² x = a sin(ω t + φ) in closed form.
#[allow(clippy::too_many_arguments)]
fn oscillator(d: f64, square: f64, a: f64, omega: f64, phase: f64, x0: f64, v0: f64, t: f64) -> (f64, f64) {
    // Particular solution p sin + q cos.
    let (real, imaginary) = (square - omega * omega, 2.0 * d * omega);
    let norm = real * real + imaginary * imaginary;
    let (p, q) = (a * real / norm, -a * imaginary / norm);
    let steady = |t: f64| {
        let (s, c) = (omega * t + phase).sin_cos();
        (p * s + q * c, omega * (p * c - q * s))
    };
    let (xs0, vs0) = steady(0.0);
    let (y0, u0) = (x0 - xs0, v0 - vs0);
    let free = (square - d * d).sqrt();
    let (s, c) = (free * t).sin_cos();
    let decay = (-d * t).exp();
    let b = (u0 + d * y0) / free;
    let (xs, vs) = steady(t);
    let x = decay * (y0 * c + b * s);
    let v = decay * ((b * free - d * y0) * c - (y0 * free + d * b) * s);
    (xs + x, vs + v)
}

#[test]
fn closed_form_of_the_uncoupled_oscillators() {
    let p = Parameters { drive_phase: 0.7, secondary_damping: 0.03, ..uncoupled() };
    let start = State { x: [0.3, -0.2, 0.5], v: [-0.4, 0.1, 0.2] };
    let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
    for n in 1..=100 {
        let t = 0.731 * f64::from(n);
        simulator.advance_to(t).unwrap();
        let State { x, v } = simulator.state();
        let (x1, v1) = oscillator(0.05, 1.0, 0.15, 1.04, 0.7, 0.3, -0.4, t);
        let (x3, v3) = oscillator(0.15, 1.0, 0.0, 1.0, 0.0, 0.5, 0.2, t);
        // The simulator integrates w = x2 - x1; it is checked through x2.
        for (ours, exact) in [(x[0], x1), (v[0], v1), (x[2], x3), (v[2], v3), (x[1], -0.2 + 0.1 * t)] {
            assert!((ours - exact).abs() < ROUNDING, "t = {t}: {ours} {exact}");
        }
    }
}

#[test]
fn closed_form_of_polynomial_loads() {
    // Free bodies under f = a + b t + c t²/2 + d t³/6 move on polynomials of degree five.
    let p = Parameters {
        box_stiffness: 0.0,
        box_damping: 0.0,
        secondary_stiffness: 0.0,
        secondary_damping: 0.0,
        ..uncoupled()
    };
    let p = Parameters { drive_amplitude: 0.0, ..p };
    let mut simulator = Simulator::new(&p, &State::default(), 0.0).unwrap();
    let loads = [[0.5, -0.1, 0.02, 0.003], [0.05, 0.02, -0.01, 0.001], [-0.1, 0.05, 0.01, -0.002]];
    simulator.set_loads(&Loads { derivatives: loads }).unwrap();
    for n in 1..=20 {
        let t = 0.37 * f64::from(n);
        simulator.advance_to(t).unwrap();
        let State { x, v } = simulator.state();
        for (body, mass) in [1.0, 0.1, 0.1].into_iter().enumerate() {
            let [a, b, c, d] = loads[body];
            let exact = t * t * (a / 2.0 + t * (b / 6.0 + t * (c / 24.0 + t * d / 120.0))) / mass;
            let speed = t * (a + t * (b / 2.0 + t * (c / 6.0 + t * d / 24.0))) / mass;
            let scale = 1.0 + exact.abs() + speed.abs();
            assert!((x[body] - exact).abs() < ROUNDING * scale, "{body} at {t}: {} {exact}", x[body]);
            assert!((v[body] - speed).abs() < ROUNDING * scale, "{body} at {t}: {} {speed}", v[body]);
        }
    }
}

/// Box and block without springs and loads: the block moves between the stops; in each flight its
/// speed relative to the box is κ times the previous one.
#[test]
fn closed_form_of_a_free_block_between_the_stops() {
    let p = Parameters {
        box_stiffness: 0.0,
        box_damping: 0.0,
        coupling_stiffness: 0.0,
        drive_amplitude: 0.0,
        stop_restitution: 0.8,
        ..Parameters::default()
    };
    let start = State { x: [0.0, 0.0, 0.0], v: [0.0, 1.0, 0.0] };
    let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
    let mut times = Vec::new();
    simulator
        .advance_observed(400.0, &mut |event| {
            if let Event::Impact { time, speed, .. } = event {
                times.push((*time, *speed));
            }
        })
        .unwrap();
    let (mut t, mut speed, mut free) = (0.0, 1.0, 1.0);
    assert!(times.len() > 10);
    for &(time, approach) in &times {
        t += free / speed;
        assert!((time - t).abs() < ROUNDING * t, "{time} {t}");
        assert!((approach - speed).abs() < ROUNDING);
        speed *= 0.8;
        free = 2.0;
    }
    let State { v, .. } = simulator.state();
    assert!((v[0] + 0.1 * v[1] - 0.1).abs() < ROUNDING, "momentum of box and block is kept");
}

/// A constant push on the block presses it to the stop: a bouncing ball, whose chatter ends at a
/// known instant.
#[test]
fn closed_form_of_a_bouncing_block_that_comes_to_rest() {
    const CLOSED_EARLY: f64 = 1e-7; // s; the last bounces, replaced by rest, are shorter
    for kappa in [0.0, 0.3, 0.75, 0.95] {
        let p = Parameters {
            box_mass: 1e9, // a wall
            box_stiffness: 0.0,
            box_damping: 0.0,
            coupling_stiffness: 0.0,
            drive_amplitude: 0.0,
            stop_restitution: kappa,
            ..Parameters::default()
        };
        let start = State { x: [0.0, 1.0 - 0.5, 0.0], v: [0.0; 3] };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        simulator.set_loads(&Loads { derivatives: [[0.0; 4], [0.1, 0.0, 0.0, 0.0], [0.0; 4]] }).unwrap();
        let mut rest = None;
        simulator
            .advance_observed(100.0, &mut |event| {
                if let Event::Rest { time, side } = event {
                    rest = Some((*time, *side));
                }
            })
            .unwrap();
        // The block falls by 0.5 m at 1 m/s² in 1 s and arrives with 1 m/s; the bounces last
        // 2κ/(1-κ).
        let exact = 1.0 + 2.0 * kappa / (1.0 - kappa);
        let (time, side) = rest.expect("it comes to rest");
        assert_eq!(side, 1);
        assert!((time - exact).abs() < CLOSED_EARLY, "κ = {kappa}: {time} {exact}");
        assert_eq!(simulator.contact(), Contact::RestUpper);
        assert_eq!(simulator.relative_motion(), (1.0, 0.0));
        assert!((simulator.contact_force() - 0.1).abs() < 1e-8, "{}", simulator.contact_force());
    }
}

/// At rest under a decreasing push, the block is released when the push changes sign.
#[test]
fn closed_form_of_the_release() {
    let p = Parameters {
        box_mass: 1e9,
        box_stiffness: 0.0,
        box_damping: 0.0,
        coupling_stiffness: 0.0,
        drive_amplitude: 0.0,
        ..Parameters::default()
    };
    let start = State { x: [0.0, 1.0, 0.0], v: [0.0; 3] };
    for (step, end) in [(20.0, 1), (0.013, 1500)] {
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        simulator.set_loads(&Loads { derivatives: [[0.0; 4], [0.1, -0.01, 0.0, 0.0], [0.0; 4]] }).unwrap();
        assert_eq!(simulator.contact(), Contact::RestUpper);
        let mut released = None;
        for n in 0..end {
            simulator
                .advance_until(
                    DoubleDouble::sum(step * f64::from(n), step),
                    Pause::Never,
                    Some(&mut |event| {
                        if let Event::Release { time, .. } = event {
                            released = Some(*time);
                        }
                    }),
                )
                .unwrap();
        }
        let time = released.expect("it lets go");
        assert!((time - 10.0).abs() < ROUNDING * 10.0, "{time}");
        // After the release w'' = -0.1 (t - 10): at 10 + τ the block is 0.1 τ³/6 off the stop,
        // until it hits the other one.
        let tau: f64 = simulator.time() - 10.0;
        if tau.powi(3) * 0.1 / 6.0 < 2.0 {
            assert!((simulator.relative_motion().0 - (1.0 - 0.1 * tau.powi(3) / 6.0)).abs() < 1e-8);
        }
    }
}

/// A heavy block that its load holds at a stop of a light box: box and block swing on the box's
/// spring as one body. The error is rounding: about ε S per sub-step, with the size S of the
/// motion (docs/numerics.md, section 1). If the box's small share of the mass were computed as 1
/// minus the block's, it would have few digits, and the error of the motion would be a thousand
/// times as large.
#[test]
fn closed_form_a_heavy_block_at_rest_in_a_light_box() {
    for (ratio, end) in [(1e2, 100.0), (1e6, 10.0), (1e8, 1.0)] {
        let p = Parameters {
            box_mass: 1.0 / ratio,
            box_damping: 0.0,
            block_mass: 1.0,
            secondary_damping: 0.0,
            coupling_stiffness: 0.0,
            drive_amplitude: 0.0,
            constant_loads: [0.0, 1.0, 0.0],
            ..Parameters::default()
        };
        let start = State { x: [1.1, 2.1, 0.0], v: [0.0; 3] };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        simulator.advance_to(end).unwrap();
        assert_eq!(simulator.contact(), Contact::RestUpper);
        let frequency = (p.box_stiffness / (p.box_mass + p.block_mass)).sqrt();
        let exact = 1.0 + 0.1 * (frequency * end).cos();
        // S = gap + |x| + f2/(m2 r²), where r² = k1/m1 = `ratio`.
        let size = 1.0 + 1.1 + 1.0 / ratio;
        let rounding = f64::EPSILON * size * simulator.work_counters().substeps as f64;
        let error = (simulator.state().x[0] - exact).abs();
        assert!(error <= rounding, "{ratio:e}: {error:e} of {rounding:e}");
    }
}
