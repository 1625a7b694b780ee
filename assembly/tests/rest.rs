//! The start at rest against closed forms.

mod common;

use common::*;
use vibro_assembly::description::*;
use vibro_assembly::mode::{FrictionState, StopState};
use vibro_assembly::{Assembly, Error};

/// Some tens of roundings of numbers of order one.
const ROUNDING: f64 = 1e-13;

fn at_rest(d: Description) -> Description {
    Description { gravity: 10.0, starts_at_rest: true, ..d }
}

/// Nothing moves or happens until a time.
fn stands(m: &mut vibro_assembly::Motion, end: f64) {
    let free = |b: &Body| matches!(b.kind, BodyKind::Free(_));
    let bodies = &m.assembly().description.bodies;
    let places: Vec<usize> = (0..bodies.len()).filter(|&i| free(&bodies[i])).collect();
    let before: Vec<(usize, f64)> = places.into_iter().map(|i| (i, m.body(i)[0])).collect();
    let all = events(m, end);
    assert!(all.is_empty(), "{all:?}");
    for (i, s) in before {
        let [now, v, a] = m.body(i);
        assert!(
            (now - s).abs() < ROUNDING && v.abs() < ROUNDING && a.abs() < 1e2 * ROUNDING,
            "{i} {now} {v} {a}"
        );
    }
}

#[test]
fn closed_form_hanging_chain() {
    // Two masses on two springs: the upper bears both, the lower its own.
    let d = Description {
        bodies: vec![heavy("a", 1.0, 1.0, 0.0, 0.0), heavy("b", 2.0, 1.0, 0.0, 0.0)],
        springs: vec![spring(&[(0, 1.0)], 300.0, 1.0), spring(&[(0, -1.0), (1, 1.0)], 1e5, 0.0)],
        ..Description::default()
    };
    let mut m = motion(at_rest(d));
    assert!((m.body(0)[0] - 0.1).abs() < ROUNDING && (m.body(1)[0] - 0.1 - 20.0 / 1e5).abs() < ROUNDING);
    stands(&mut m, 1.0);
}

#[test]
fn closed_form_preloaded_stops() {
    // A block pressed on a rigid stop by a preloaded spring; a second one on a rubber that lies on the first.
    let d = Description {
        bodies: vec![heavy("block", 1.0, 1.0, 0.0, 0.0), heavy("rider", 3.0, 1.0, 0.0, 0.0)],
        springs: vec![Spring { preload: -50.0, ..spring(&[(0, 1.0)], 100.0, 0.0) }],
        stops: vec![
            rigid("floor", &[(0, 1.0)], 0.2, 0.5),
            compliant("rubber", &[(0, -1.0), (1, 1.0)], -0.5, 1e3, 20.0, DampingLimit::NoPull),
            rigid("unused", &[(1, -1.0)], 4.0, 0.5),
        ],
        ..Description::default()
    };
    let mut m = motion(at_rest(d));
    // 50 N preload, 10 N and 30 N of weight, less 100 N/m * 0.2 m of the spring.
    assert!((m.stop(0)[2] - 70.0).abs() < 1e3 * ROUNDING, "{:?}", m.stop(0));
    assert!((m.stop(1)[2] - 30.0).abs() < 1e3 * ROUNDING, "{:?}", m.stop(1));
    assert_eq!(m.mode().stops, [StopState::Closed, StopState::Pressed, StopState::Open]);
    stands(&mut m, 1.0);
}

#[test]
fn closed_form_friction_holds_where_it_must() {
    // Nothing but friction bears the first block; the second hangs on a spring, and friction bears nothing.
    let held = |level| Description {
        bodies: vec![heavy("held", 1.0, 1.0, 0.0, 0.0), heavy("hung", 1.0, 1.0, 0.0, 0.0)],
        springs: vec![spring(&[(1, 1.0)], 100.0, 0.0)],
        frictions: vec![
            Friction { static_force: Some(constant(12.0)), ..friction(&[(0, 1.0)], level) },
            friction(&[(1, 1.0)], 50.0),
        ],
        ..Description::default()
    };
    let mut m = motion(at_rest(held(10.5)));
    assert_eq!(m.body(0)[0], 0.0);
    assert!((m.friction(0)[2] - 10.0).abs() < ROUNDING * 100.0, "{:?}", m.friction(0));
    assert_eq!(m.mode().frictions, [FrictionState::Stuck; 2]);
    stands(&mut m, 1.0);
    // By its static level alone.
    stands(&mut motion(at_rest(held(9.0))), 1.0);
}

#[test]
fn closed_form_without_friction_where_there_is_a_spring() {
    let d = Description {
        bodies: vec![heavy("hung", 1.0, 1.0, 0.0, 0.0)],
        springs: vec![spring(&[(0, 1.0)], 100.0, 0.0)],
        frictions: vec![friction(&[(0, 1.0)], 50.0)],
        ..Description::default()
    };
    let mut m = motion(at_rest(d));
    assert!((m.body(0)[0] - 0.1).abs() < ROUNDING && m.friction(0)[2].abs() < 1e2 * ROUNDING);
    stands(&mut m, 1.0);
}

#[test]
fn no_equilibrium_is_refused_by_name() {
    let d = Description {
        bodies: vec![heavy("hung", 1.0, 1.0, 0.0, 0.0), heavy("loose", 1.0, 0.5, 0.0, 0.0)],
        springs: vec![spring(&[(0, 1.0)], 100.0, 0.0)],
        stops: vec![rigid("ceiling", &[(1, -1.0)], 1.0, 0.5)],
        frictions: vec![friction(&[(1, 1.0)], 4.0)],
        ..Description::default()
    };
    let refused = Assembly::new(at_rest(d)).unwrap_err();
    let Error::NoEquilibrium { body, acceleration } = &refused else { panic!("{refused}") };
    assert!(body == "loose" && (acceleration - 1.0).abs() < 1e-6, "{refused}");
}

#[test]
fn closed_form_belt_rubs_a_body_at_rest() {
    let d = Description {
        bodies: vec![prescribed("belt", constant(0.0), 0.5), body("block", 1.0, 0.0, 0.0)],
        springs: vec![spring(&[(1, 1.0)], 200.0, 0.0)],
        frictions: vec![friction(&[(0, -1.0), (1, 1.0)], 4.0)],
        ..Description::default()
    };
    let mut m = motion(at_rest(d));
    assert!((m.body(1)[0] - 0.02).abs() < ROUNDING, "{:?}", m.body(1));
    stands(&mut m, 0.5);
}
