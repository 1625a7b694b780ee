//! Jumps of signals: prescribed bodies whose coordinate or rate jumps, and events at the instant
//! of a knot.

use crate::common::*;
use std::sync::Arc;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::EventKind;
use vibro_machine::{Assembly, Motion};

/// Tens of roundings of numbers of order one.
const ROUNDING: f64 = 1e-14;

fn near(a: f64, b: f64) {
    assert!((a - b).abs() < ROUNDING, "{a} instead of {b}");
}

/// Balance of the accounts minus the change of the mechanical energy.
fn off_balance(m: &Motion, start: f64) -> f64 {
    let (kinetic, stored) = m.kinetic_and_stored();
    kinetic + stored - start - m.energy().balance()
}

#[test]
fn closed_form_friction_on_a_belt_that_starts_and_stops_at_once() {
    let mut m = moving(
        "name = \"Belt\"\n[body.b]\nmass = 1.0\n[body.belt]\nmotion = { table = [[0.25, 0.0], [0.5, 0.25], [1.0, 0.25]] }\n\
         [friction.f]\nbetween = [\"belt\", \"b\"]\nforce = 2.0\n",
    );
    let all = events(&mut m, 0.5);
    // Sticking ends when the belt starts at 1 m/s; friction accelerates the body at 2 m/s² up to
    // 0.5 m/s.
    near(m.body(0)[0], 0.0625);
    near(m.body(0)[1], 0.5);
    assert_eq!(times(&all, |k| matches!(k, EventKind::Slip { direction: -1.0, .. })), [0.25]);
    assert_eq!(times(&all, |k| matches!(k, EventKind::Slip { direction: 1.0, .. })), [0.5]);
    m.advance_to(1.0).unwrap();
    near(m.body(0)[0], 0.125);
    near(m.body(0)[1], 0.0);
    near(m.energy().motions.value(), 0.5);
    near(off_balance(&m, 0.0), 0.0);
}

#[test]
fn closed_form_base_that_steps_away_from_what_lies_on_it() {
    let mut m = moving(
        "name = \"Base\"\ngravity = 10.0\n[body.b]\nmass = 1.0\ngravity = 1.0\n[body.base]\nmotion = { steps = [[0.5, 0.1]] }\n\
         [stop.r]\nbetween = [\"base\", \"b\"]\ngap = 0.0\nrestitution = 0.0\n",
    );
    let all = events(&mut m, 0.6);
    near(m.body(0)[0], 0.05);
    assert_eq!(times(&all, |k| matches!(k, EventKind::Open { .. })), [0.5]);
    let all = events(&mut m, 1.0);
    near(times(&all, |k| matches!(k, EventKind::Impact { .. }))[0], 0.5 + 0.02f64.sqrt());
    near(m.body(0)[0], 0.1);
    near(m.energy().impacts.value(), 1.0);
    near(off_balance(&m, 0.0), 0.0);
}

/// A differential: two bodies whose coordinates add up to the prescribed body's coordinate, with
/// springs that store the work of a step.
fn differential(motion: &str, order: [&str; 2]) -> Motion {
    differential_with(motion, order, "")
}

/// The differential with more elements.
fn differential_with(motion: &str, order: [&str; 2], more: &str) -> Motion {
    let bodies: String = order
        .iter()
        .map(|name| format!("[body.{name}]\nmass = {}\n", if *name == "a" { 1.0 } else { 3.0 }))
        .collect();
    moving(&format!(
        "name = \"D\"\n{bodies}[body.p]\nmotion = {{ {motion} }}\n[link.l]\narms = {{ a = 1.0, b = 1.0, p = -1.0 }}\n\
         [spring.k]\nbetween = [\"a\", \"b\"]\nstiffness = 40.0\n[spring.base]\nbetween = [\"p\", \"b\"]\nstiffness = 20.0\n{more}"
    ))
}

#[test]
fn closed_form_links_share_a_jump_by_inertia() {
    for order in [["a", "b"], ["b", "a"]] {
        let place = |name: &str| order.iter().position(|n| *n == name).unwrap();
        let (a, b) = (place("a"), place("b"));
        // The link's impulse divides a jump 3 : 1 between the bodies, in rate and in coordinate.
        let mut m = differential("table = [[0.25, 0.0], [0.5, 1.0]]", order);
        m.advance_to(0.25).unwrap();
        near(m.body(a)[1], 3.0);
        near(m.body(b)[1], 1.0);
        let mut m = differential("steps = [[0.25, 0.4]]", order);
        m.advance_to(0.25).unwrap();
        near(m.body(a)[0], 0.3);
        near(m.body(b)[0], 0.1);
        m.advance_to(1.0).unwrap();
        near(m.body(a)[0] + m.body(b)[0], 0.4);
        near(off_balance(&m, 0.0), 0.0);
    }
}

#[test]
fn closed_form_inputs_that_jump_a_belt_and_a_base() {
    let mut m = moving(
        "name = \"I\"\n[body.b]\nmass = 1.0\n[body.belt]\nmotion = { input = true }\n\
         [friction.f]\nbetween = [\"belt\", \"b\"]\nforce = 2.0\n[stop.r]\nbetween = [\"b\", \"belt\"]\ngap = 0.5\nrestitution = 0.5\n",
    );
    m.advance_to(0.25).unwrap();
    m.set_input(0, [0.0, 1.0, 0.0, 0.0]).unwrap();
    m.advance_to(0.5).unwrap();
    near(m.body(0)[0], 0.0625);
    // A step that violates the stop is refused and changes nothing.
    let refused = m.set_input(0, [1.0, 0.0, 0.0, 0.0]).unwrap_err().to_string();
    assert!(refused.contains("stop.r") && refused.contains("e - gap"), "{refused}");
    near(m.body(0)[0], 0.0625);
    near(m.body(1)[0], 0.25);
}

#[test]
fn closed_form_force_that_touches_its_level_at_a_knot_makes_no_slip() {
    // The holding force reaches its level at the load's peak only; a rounding before the peak
    // would let the body slip and stick again.
    for peak in [0.3, 0.4, 0.5, 0.6, 0.7, 0.9, 1.1] {
        let mut m = moving(&format!(
            "name = \"T\"\n[body.b]\nmass = 1.0\n[friction.f]\nbetween = [\"ground\", \"b\"]\nforce = 2.0\n\
             [load.l]\non = \"b\"\ntable = [[0.0, 0.0], [{peak}, -2.0], [1.7, 1.0]]\n"
        ));
        let all = events(&mut m, 1.5);
        assert_eq!(times(&all, |k| !matches!(k, EventKind::Knot)), [0.0; 0], "{peak}");
        near(m.body(0)[0], 0.0);
    }
}

#[test]
fn invariant_every_knot_is_told_beside_what_ends_there() {
    // A stop's force falls to zero with zero slope at a knot, so that by rounding it ends before;
    // a body meets another stop at the knot, too.
    for knot in [0.8125f64, 0.3, 0.7] {
        let mut m = moving(&format!(
            "name = \"K\"\n[body.b]\nmass = 0.5\n[body.c]\nmass = 1.0\nstart = {{ s = -{knot}, v = 1.0 }}\n\
             [stop.r]\nbetween = [\"ground\", \"b\"]\ngap = 0.0\nrestitution = 0.0\n\
             [stop.h]\nbetween = [\"ground\", \"c\"]\ngap = 0.0\nrestitution = 0.5\n\
             [load.l]\non = \"b\"\ntable = [[0.1, 3.0], [0.2, 2.0], [{knot}, 0.0], [1.2, 0.0]]\ninterpolation = \"cubic\"\n"
        ));
        let all = events(&mut m, 1.0);
        assert_eq!(times(&all, |k| matches!(k, EventKind::Knot)), [0.1, 0.2, knot]);
        let hit = times(&all, |k| matches!(k, EventKind::Impact { stop: 1, .. }));
        assert!(hit.len() == 1 && (hit[0] - knot).abs() < ROUNDING, "{hit:?}");
    }
}

#[test]
fn invariant_impacts_at_the_start_are_told() {
    let toml = "name = \"S\"\n[body.b]\nmass = 1.0\nstart = { s = 0.0, v = 1.0 }\n\
                [stop.r]\nbetween = [\"ground\", \"b\"]\ngap = 0.0\nrestitution = 0.5\n";
    let machine = parse(toml, "start.toml", &no_records).unwrap();
    let mut all = Vec::new();
    let m = Motion::new_observed(Arc::new(Assembly::new(machine).unwrap()), &mut |e| all.push(e.clone()))
        .unwrap();
    near(m.body(0)[1], -0.5);
    let told = |k: &EventKind| matches!(k, EventKind::Impact { stop: 0, speed: 1.0, stops: 1, .. });
    assert_eq!(times(&all, told), [0.0]);
}

#[test]
fn invariant_energy_of_impacts_on_bodies_that_links_tie_to_a_moving_one() {
    // At an impact the link of two bodies to a prescribed one has an impulse, too, which does
    // work; with one stop and with two.
    for second in ["", "[stop.t]\narms = { a = 2.0 }\ngap = 0.2\nrestitution = 0.3\n"] {
        let mut m = moving(&format!(
            "name = \"C\"\n[body.a]\nmass = 1.0\nstart = {{ v = 0.75 }}\n[body.b]\nmass = 3.0\nstart = {{ v = 0.25 }}\n[body.p]\nmotion = {{ rate = 1.0 }}\n\
             [link.l]\narms = {{ a = 1.0, b = 1.0, p = -1.0 }}\n[stop.s]\narms = {{ a = 1.0 }}\ngap = 0.1\nrestitution = 0.5\n{second}"
        ));
        let (kinetic, stored) = m.kinetic_and_stored();
        let all = events(&mut m, 1.0);
        assert!(!times(&all, |k| matches!(k, EventKind::Impact { .. })).is_empty());
        near(off_balance(&m, kinetic + stored), 0.0);
    }
}

#[test]
fn closed_form_stops_on_linked_bodies_see_the_share_of_a_jump() {
    // A step of 0.4 moves a by 0.3 and b by 0.1, whichever is the coordinate: a violates a gap of
    // 0.2, b does not.
    let stop = |body: &str, gap: f64, order: [&str; 2]| {
        let mut m = differential_with(
            "steps = [[0.25, 0.4]]",
            order,
            &format!("[stop.r]\narms = {{ {body} = 1.0 }}\ngap = {gap}\nrestitution = 0.5\n"),
        );
        m.advance_to(0.25).map_err(|e| e.to_string())
    };
    for order in [["a", "b"], ["b", "a"]] {
        for (body, jump) in [("a", 0.3), ("b", 0.1)] {
            stop(body, jump + 0.01, order).unwrap();
            let refused = stop(body, jump - 0.01, order).unwrap_err();
            assert!(refused.contains("stop.r") && refused.contains("e - gap = 0.0"), "{order:?} {refused}");
        }
    }
}

#[test]
fn closed_form_changed_numbers_are_judged_after_the_share_of_their_jump() {
    // The step's height changes from 0 to 0.4 during the motion: a moves by 0.3, within its gap of
    // 0.35.
    for order in [["a", "b"], ["b", "a"]] {
        let with = |height: f64| {
            let gap = "[stop.r]\narms = { a = 1.0 }\ngap = 0.35\nrestitution = 0.5\n";
            differential_with(&format!("steps = [[0.25, {height}]]"), order, gap)
        };
        let mut m = with(0.0);
        m.advance_to(0.5).unwrap();
        let m = m.changed(with(0.4).assembly().clone()).unwrap();
        near(m.body(order.iter().position(|n| *n == "a").unwrap())[0], 0.3);
    }
}

#[test]
fn closed_form_inputs_that_are_set_at_once_move_what_touches_together() {
    // A carriage and the plate on it, both prescribed, are set together: no violation, no impact.
    let mut m = moving(
        "name = \"T\"\n[body.plate]\nmotion = { input = true }\n[body.carriage]\nmotion = { input = true }\n\
         [body.b]\nmass = 1.0\n[stop.r]\nbetween = [\"carriage\", \"plate\"]\ngap = 0.0\nrestitution = 0.5\n\
         [friction.f]\nbetween = [\"plate\", \"b\"]\nforce = 1.0\n",
    );
    m.advance_to(0.25).unwrap();
    let together = [(0, [0.5, 1.0, 0.0, 0.0]), (1, [0.5, 1.0, 0.0, 0.0])];
    m.set_inputs(&together).unwrap();
    assert_eq!((m.body(0)[0], m.body(1)[0], m.impacts(0).count), (0.5, 0.5, 0));
    // Inputs that are incompatible together are all refused.
    let before = m.save();
    assert!(m.set_inputs(&[(0, [2.0, 0.0, 0.0, 0.0]), (1, [1.0, 0.0, 0.0, 0.0])]).is_err());
    assert!(m.save() == before);
}
