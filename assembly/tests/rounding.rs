//! What is rounding and counts as zero (docs/assembly-law.md (A14)): speeds that balanced forces leave, and forces and impulses that cancel.

mod common;

use common::*;
use vibro_assembly::description::*;
use vibro_assembly::file::{no_records, parse};
use vibro_assembly::motion::EventKind;

/// Some tens of roundings of numbers of order one.
const ROUNDING: f64 = 1e-14;

/// By place and speed: half a rounding of 1 m in each of 2e4 sub-steps, which may all go one way; some roundings of the speed.
const MANY_STEPS: [f64; 2] = [1e-11, 1e-13];

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

#[test]
fn closed_form_a_stiff_buffer_puts_the_same_force_to_both_bodies() {
    // Two bodies that loads press together on a stiff and strongly damped buffer, 1 m from the origin: for a fifth of a second, some 2e4 sub-steps of
    // which each puts 1e8 N/m times 1 m to each body. No other force acts, so that the center of their masses moves evenly.
    let (masses, v, end) = ([0.49, 0.65], 0.67, 0.2);
    let pair = Description {
        bodies: vec![body("a", masses[0], 1.0, v), body("b", masses[1], 1.0, v)],
        stops: vec![compliant("buffer", &[(0, 1.0), (1, -1.0)], 0.0, 1.3e8, 6e4, DampingLimit::NoPull)],
        loads: vec![
            Load { name: "right".into(), body: 0, force: constant(10.0) },
            Load { name: "left".into(), body: 1, force: constant(-10.0) },
        ],
        ..Description::default()
    };
    // Alone by tables, and among bodies that touch nothing by the series of each state.
    for others in [0, 10] {
        let mut d = pair.clone();
        d.bodies.extend((0..others).map(|i| body(&format!("idle{i}"), 1.0, 0.0, 0.0)));
        let mut motion = motion(d);
        motion.advance_to(end).unwrap();
        let mean = |k: usize| {
            (masses[0] * motion.body(0)[k] + masses[1] * motion.body(1)[k]) / (masses[0] + masses[1])
        };
        let exact = [1.0 + v * end, v];
        for (k, exact) in exact.into_iter().enumerate().rev() {
            assert!((mean(k) - exact).abs() < MANY_STEPS[k], "{others}, {k}: {:e}", mean(k) - exact);
        }
        assert!((motion.stop(0)[2] - 10.0).abs() < 1e-6, "{others}: {:?}", motion.stop(0));
    }
}

#[test]
fn closed_form_body_at_rest_at_a_buffers_edge_stays() {
    // In equilibrium a body that friction holds to another stands at a buffer's gap, where its place has no size but what rounding makes of
    // the other's forces: no event, and nobody moves.
    let machine = parse(
        "name = \"E\"\ngravity = 9.81\nstart = \"rest\"\n[body.a]\nmass = 0.94\ngravity = -1.0\n[body.b]\nmass = 0.39\ngravity = 1.0\n\
         [body.c]\nmass = 0.37\n[link.l]\narms = { a = 1.0, b = 2.0 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 342.6\n\
         [spring.m]\nbetween = [\"a\", \"b\"]\nstiffness = 871.1\npreload = 7.3\n[stop.s]\narms = { c = -1.0 }\ngap = 0.0\nstiffness = 1318.0\n\
         [friction.f]\nbetween = [\"c\", \"b\"]\nforce = 3.0\n[friction.g]\nbetween = [\"c\", \"b\"]\nforce = 5.0\n[load.q]\non = \"b\"\nconstant = -5.3\n",
        "edge.toml",
        &no_records,
    );
    // Short calls have short sub-steps, at the ends of which the places are rounding of rounding.
    for end in [1e-7, 1e-3, 1.0] {
        let mut m = motion(machine.clone().unwrap());
        let at = m.coordinate(0);
        assert!(events(&mut m, end).is_empty());
        assert!((m.coordinate(0) - at).abs() < 1e-15 && m.coordinate(2).abs() < 1e-15);
    }
}

#[test]
fn invariant_friction_across_a_stiff_spring_stays_within_its_level() {
    // What friction holds across a spring of 1e6 times the mount has no rounding of that spring's forces, however long it is held: else friction that
    // comes to rest against a force beyond its level would stay.
    let machine = parse(
        "name = \"F\"\n[body.a]\nmass = 0.3765\nstart = { v = -0.614 }\n[body.b]\nmass = 2.4796\nstart = { v = -0.8143 }\n\
         [spring.mount]\narms = { a = 1.0 }\nstiffness = 170.0\ndamping = 0.5\n\
         [spring.tie]\narms = { a = -1.0, b = 1.0 }\nstiffness = 1.7e8\ndamping = 100.0\n\
         [friction.f]\narms = { a = 1.0, b = -1.0 }\nforce = 0.4535\nstatic = 0.6802\n[friction.g]\narms = { a = -1.0, b = 1.0 }\nforce = 0.5631\n\
         [load.p]\non = \"a\"\nconstant = 21.3\namplitude = 10.8\nfrequency = 1.277\nphase = 1.318\n\
         [load.q]\non = \"b\"\nsteps = [[0.4375, 11.0], [0.5, -9.6]]\n",
        "tie.toml",
        &no_records,
    );
    let mut m = motion(machine.unwrap());
    let mut held = 0;
    for k in 1..=4000 {
        m.advance_to(f64::from(k) * 2.5e-4).unwrap();
        for (i, level) in [(0, 0.6802), (1, 0.5631)] {
            let [_, rate, force] = m.friction(i);
            assert!(force.abs() <= level * (1.0 + ROUNDING), "{}: friction {i}: {force}", m.time());
            held += i32::from(rate == 0.0);
        }
    }
    assert!(held > 1000, "{held}");
}
