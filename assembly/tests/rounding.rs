//! What is rounding and counts as zero (docs/assembly-law.md (A14)): speeds that balanced forces leave, and forces and impulses that cancel.

mod common;

use common::*;
use vibro_assembly::description::*;
use vibro_assembly::motion::EventKind;

/// Some tens of roundings of numbers of order one.
const ROUNDING: f64 = 1e-14;

/// A weight that hangs at rest on a spring, and friction whose level begins to rise at 0.5 s.
fn hanging(mass: f64, stiffness: f64) -> Description {
    let level = Signal {
        table: Some(Record { knots: vec![(0.5, 0.0), (1.0, 0.1)], cubic: false }),
        ..Signal::default()
    };
    Description {
        gravity: 9.81,
        bodies: vec![heavy("weight", mass, 1.0, mass * 9.81 / stiffness, 0.0)],
        springs: vec![spring(&[(0, 1.0)], stiffness, 0.0)],
        frictions: vec![Friction { force: level, ..friction(&[(0, 1.0)], 0.0) }],
        ..Description::default()
    }
}

#[test]
fn closed_form_friction_on_what_hangs_at_rest_holds_at_once() {
    // Weight and spring force are equal but for their rounding, so that all the speed there has ever been is rounding. A level that rises from zero
    // by the square of time would need the root of it, 1e-8 s, to stop this speed.
    for k in 1..60 {
        let (mass, stiffness) = (0.37 * k as f64, 211.0 + 17.0 * k as f64);
        let mut motion = motion(hanging(mass, stiffness));
        let all = events(&mut motion, 2.0);
        let stick = times(&all, |kind| matches!(kind, EventKind::Stick { .. }));
        assert!(times(&all, |kind| matches!(kind, EventKind::Slip { .. })).is_empty(), "{k}: {all:?}");
        assert_eq!(stick, [0.5], "{k}: {all:?}");
        let [s, v, _] = motion.body(0);
        assert!((s - mass * 9.81 / stiffness).abs() <= ROUNDING && v.abs() <= ROUNDING, "{k}: {s} {v}");
    }
}

/// A light body between a wall and a heavy one that is pressed on it, with a buffer whose edge it just touches.
fn squeezed(mass: f64, force: f64) -> Description {
    Description {
        bodies: vec![body("light", mass, 0.0, 0.0), body("heavy", 1.0, 0.0, 0.0)],
        stops: vec![
            rigid("wall", &[(0, 1.0)], 0.0, 0.5),
            rigid("contact", &[(0, -1.0), (1, 1.0)], 0.0, 0.5),
            compliant("edge", &[(0, 1.0)], 0.0, 1e3, 1.0, DampingLimit::NoPull),
        ],
        frictions: vec![friction(&[(0, 3.0), (1, -2.0)], 0.1)],
        loads: vec![Load { name: "press".into(), body: 1, force: constant(force) }],
        ..Description::default()
    }
}

#[test]
fn closed_form_two_forces_that_cancel_on_a_light_body_decide_nothing() {
    // The contact forces on the light body are equal, and what their difference is by rounding makes accelerations of any size on it.
    for k in 1..100 {
        let (mass, force) = (0.83f64.powi(k), 0.37 * k as f64);
        let mut motion = motion(squeezed(mass, force));
        let all = events(&mut motion, 1.0);
        assert!(all.is_empty(), "{k}: {all:?}");
        for i in 0..2 {
            let [s, v, a] = motion.body(i);
            let a = a / (force / mass).max(force);
            assert!(
                s.abs() <= ROUNDING && v.abs() <= ROUNDING && a.abs() <= ROUNDING,
                "{k}, body {i}: {s} {v} {a}"
            );
            assert!(
                (motion.stop(i)[2] - force).abs() <= 10.0 * ROUNDING * force,
                "{k}: {:?}",
                motion.stop(i)
            );
        }
    }
}
