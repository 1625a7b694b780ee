//! Bodies in modal coordinates, and nodes on them.

use crate::common::*;
use std::sync::Arc;
use vibro_machine::file::{no_records, parse};
use vibro_machine::{Assembly, Description, Motion};

/// A thousand roundings of numbers of order one: events accumulate differences in last digits.
const ROUNDING: f64 = 1e-11;

/// The stop's bounces end soon after this time, s; rounding decides the number of the last ones.
const BEFORE_CHATTER: f64 = 0.36;

/// A beam of three modes that is driven at its tip and hits a stop there, and a mass on a spring
/// at its middle.
const BEAM: &str = r#"
    name = "Beam"
    gravity = 9.81
    body.mass = { mass = 0.4, gravity = 1.0 }
    modal.beam = { frequencies = ["2 Hz", "11 Hz", 30.0], damping_ratio = [0.01, 0.02, 0.03], masses = [2.0, 1.0, 0.5], gravity = [0.7, 0.4, 0.2], start = { q = [0.01, 0.0, 0.002], v = [0.3, 0.0, 0.0] }, nodes = { tip = [1.9, -2.0, 2.0], middle = { "0" = 0.6, "1" = 1.2 }, slope = { row = [0.5, 1.0, 3.0], dimension = "rotation" } } }
    spring.hanger = { between = ["beam.middle", "mass"], stiffness = 300.0, damping = 0.4 }
    stop.tip = { between = ["ground", "beam.tip"], gap = "30 mm", restitution = 0.7 }
    stop.pad = { arms = { beam = { tip = -1.0 } }, gap = "40 mm", stiffness = 5000.0, damping = 2.0 }
    friction.pivot = { between = ["ground", "beam.slope"], force = 0.3 }
    load.shaker = { on = "beam.tip", amplitude = 4.0, frequency = 1.7 }
"#;

/// The same beam as single bodies with springs and arms.
const BODIES: &str = r#"
    name = "Beam"
    gravity = 9.81
    body.mass = { mass = 0.4, gravity = 1.0 }
    body.q0 = { mass = 2.0, gravity = 0.7, start = { s = 0.01, v = 0.3 } }
    body.q1 = { mass = 1.0, gravity = 0.4 }
    body.q2 = { mass = 0.5, gravity = 0.2, start = { s = 0.002 } }
    spring.hanger = { arms = { mass = 1.0, q0 = -0.6, q1 = -1.2 }, stiffness = 300.0, damping = 0.4 }
    spring.mode0 = { between = ["ground", "q0"], stiffness = 315.82734083485946, damping = 0.5026548245743669 }
    spring.mode1 = { between = ["ground", "q1"], stiffness = 4776.888530127251, damping = 2.76460153515902 }
    spring.mode2 = { between = ["ground", "q2"], stiffness = 17765.287921960845, damping = 5.654866776461628 }
    stop.tip = { arms = { q0 = 1.9, q1 = -2.0, q2 = 2.0 }, gap = "30 mm", restitution = 0.7 }
    stop.pad = { arms = { q0 = -1.9, q1 = 2.0, q2 = -2.0 }, gap = "40 mm", stiffness = 5000.0, damping = 2.0 }
    friction.pivot = { arms = { q0 = 0.5, q1 = 1.0, q2 = 3.0 }, force = 0.3 }
    body.shaken = { mass = 1e-30, start = { s = 0.023, v = 0.57 } }
    link.shaken = { arms = { shaken = 1.0, q0 = -1.9, q1 = 2.0, q2 = -2.0 } }
    load.shaker = { on = "shaken", amplitude = 4.0, frequency = 1.7 }
"#;

fn place(m: &Motion, name: &str) -> usize {
    m.assembly().description.bodies.iter().position(|body| body.name == name).unwrap()
}

#[test]
fn second_method_modes_are_bodies_with_arms() {
    let mut both = [BEAM, BODIES].map(|text| motion(machine(text)));
    let events = both.each_mut().map(|m| {
        let mut events = Vec::new();
        m.advance_observed(BEFORE_CHATTER, &mut |event| {
            events.push((event.time, format!("{:?}", event.kind)))
        })
        .unwrap();
        events
    });
    assert!(events[0].len() > 20, "{}", events[0].len());
    assert_eq!(events[0].len(), events[1].len());
    for (one, other) in events[0].iter().zip(&events[1]) {
        assert!((one.0 - other.0).abs() < ROUNDING, "{one:?} {other:?}");
    }
    let [beam, bodies] = &both;
    for (one, other) in [
        ("mass", "mass"),
        ("beam.q[0]", "q0"),
        ("beam.q[1]", "q1"),
        ("beam.q[2]", "q2"),
        ("beam.tip", "shaken"),
    ] {
        let (own, other) = (beam.body(place(beam, one)), bodies.body(place(bodies, other)));
        assert!(
            (own[0] - other[0]).abs() < ROUNDING && (own[1] - other[1]).abs() < 100.0 * ROUNDING,
            "{one} {own:?} {other:?}"
        );
    }
    let energies = both.each_ref().map(|m| m.energy().dashpots.iter().map(|x| x.value()).sum::<f64>());
    assert!((energies[0] - energies[1]).abs() < ROUNDING, "{energies:?}");
}

#[test]
fn golden_the_written_file_reads_back_equal_and_columns_have_nodes_only() {
    let machine = machine(BEAM);
    let written = machine.to_toml();
    assert_eq!(parse(&written, "written.toml", &no_records), Ok(machine.clone()), "{written}");
    let columns: Vec<String> = machine.named_quantities().into_iter().map(|c| c.name).collect();
    for name in ["beam.tip.s", "beam.slope.v", "tip.e"] {
        assert!(columns.iter().any(|own| own == name), "{name}: {columns:?}");
    }
    assert!(!columns.iter().any(|own| own.contains('[')), "{columns:?}");
    for (name, value) in [
        ("modal.beam.frequencies[1]", 11.0),
        ("modal.beam.damping_ratio[2]", 0.03),
        ("modal.beam.masses[0]", 2.0),
        ("modal.beam.gravity[2]", 0.2),
        ("modal.beam.start.q[0]", 0.01),
        ("modal.beam.start.v[0]", 0.3),
        ("stop.pad.arms.beam.tip", -1.0),
    ] {
        assert_eq!(machine.get(name), Ok(value), "{name}");
    }
}

/// The deflection under weight at rest: q = m g r/(m ω²).
#[test]
fn closed_form_the_place_of_rest_under_weight() {
    let text = r#"
        name = "Rest"
        gravity = 10.0
        start = "rest"
        modal.beam = { frequencies = [2.0, 5.0], gravity = [1.5, 0.2], nodes = { tip = [1.0, -3.0], first = 0 } }
    "#;
    let m = motion(machine(text));
    let omega = |f: f64| (std::f64::consts::TAU * f).powi(2);
    let q = [15.0 / omega(2.0), 2.0 / omega(5.0)];
    let exact = [q[0], q[1], q[0] - 3.0 * q[1], q[0]];
    for (i, exact) in exact.into_iter().enumerate() {
        assert!((m.body(i)[0] - exact).abs() < ROUNDING * exact.abs(), "{i} {exact}");
    }
}

#[test]
fn a_link_to_a_node_and_to_a_moved_body_holds() {
    let text = r#"
        name = "Driven"
        body.table = { motion = { amplitude = "1 mm", frequency = "3 Hz" } }
        body.rider = { mass = 0.2 }
        modal.beam = { frequencies = [2.0, 5.0, 9.0], nodes = { root = [1.0, 1.0, 1.0], tip = [1.0, -1.0, 2.0] }, start = { v = [0.006283185307179587, 0.006283185307179587, 0.006283185307179587] } }
        link.root = { between = ["table", "beam.root"] }
        link.tip = { between = ["beam.tip", "rider"] }
    "#;
    let text = text.replace(
        "start = { v = [0.006283185307179587, 0.006283185307179587, 0.006283185307179587] }",
        &format!("start = {{ v = [{0:?}, 0.0, 0.0] }}", 0.001 * std::f64::consts::TAU * 3.0),
    );
    let text = text.replace(
        "mass = 0.2",
        &format!("mass = 0.2, start = {{ v = {:?} }}", 0.001 * std::f64::consts::TAU * 3.0),
    );
    let mut m = motion(machine(&text));
    m.advance_to(1.3).unwrap();
    let of = |name: &str| m.body(place(&m, name));
    for (one, other) in [("table", "beam.root"), ("rider", "beam.tip")] {
        let (one, other) = (of(one), of(other));
        assert!((0..3).all(|k| (one[k] - other[k]).abs() < ROUNDING * 10.0), "{one:?} {other:?}");
    }
    let (kinetic, stored) = m.kinetic_and_stored();
    let begin = motion(machine(&text)).kinetic_and_stored();
    assert!((kinetic + stored - begin.0 - begin.1 - m.energy().balance()).abs() < 1e-15);
}

/// A bar of length L with the wave speed 1, free at both ends, has the modes cos(iπx/L).
fn bar(name: &str, modes: usize, speed: f64, end: f64) -> String {
    let list =
        |f: &dyn Fn(usize) -> f64| (0..modes).map(|i| format!("{:?}", f(i))).collect::<Vec<_>>().join(", ");
    let frequencies = list(&|i| 0.5 * i as f64);
    let masses = list(&|i| if i == 0 { 1.0 } else { 0.5 });
    let row = list(&|i| if i == 0 || end > 0.0 || i % 2 == 0 { 1.0 } else { -1.0 });
    let v = list(&|i| if i == 0 { speed } else { 0.0 });
    format!(
        "modal.{name} = {{ frequencies = [{frequencies}], masses = [{masses}], nodes = {{ face = [{row}], middle = 0 }}, start = {{ v = [{v}] }} }}\n"
    )
}

/// Two equal elastic bars that collide exchange their velocities, with a contact time of 2L/c = 2
/// s (Saint-Venant). With a rigid stop on a few modes the contact is many impacts; momentum and
/// energy are kept.
#[test]
fn published_two_elastic_bars_exchange_their_speeds() {
    for (modes, allowed) in [(10, 0.2), (40, 0.06)] {
        let text = format!(
            "name = \"Bars\"\n{}{}stop.meet = {{ between = [\"two.face\", \"one.face\"], gap = 0.0, restitution = 0.0 }}\n",
            bar("one", modes, 1.0, 1.0),
            bar("two", modes, 0.0, -1.0)
        );
        let mut m = motion(machine(&text));
        let mut last = 0.0;
        m.advance_observed(4.0, &mut |event| last = event.time).unwrap();
        let (one, two) = (m.body(place(&m, "one.middle"))[1], m.body(place(&m, "two.middle"))[1]);
        let (kinetic, stored) = m.kinetic_and_stored();
        assert!((one + two - 1.0).abs() < ROUNDING);
        assert!(one.abs() < allowed && (two - 1.0).abs() < allowed, "{modes} {one} {two}");
        assert!((last - 2.0).abs() < allowed, "{last}");
        assert!((kinetic + stored - 0.5 - m.energy().balance()).abs() < ROUNDING);
    }
}

/// The derivative of the tip's displacement by each number, compared with differences.
#[test]
fn second_method_derivatives_by_the_numbers_of_modes() {
    let machine = machine(BEAM);
    let names = [
        "modal.beam.frequencies[0]",
        "modal.beam.frequencies[1]",
        "modal.beam.damping_ratio[1]",
        "modal.beam.masses[2]",
        "modal.beam.gravity[0]",
        "modal.beam.start.q[1]",
    ];
    let assembly = Arc::new(Assembly::new(machine.clone()).unwrap());
    let mut m = vibro_machine::Differentiated::new(assembly, &names).unwrap();
    m.advance_to(0.55).unwrap();
    let tip = |d: Description| {
        let mut m = motion(d);
        m.advance_to(0.55).unwrap();
        m.body(place(&m, "beam.tip"))[0]
    };
    for (p, name) in names.iter().enumerate() {
        let own = machine.get(name).unwrap();
        let h = 1e-6 * own.abs().max(0.01);
        let [up, down] = [1.0, -1.0].map(|side| tip(machine.with([(*name, own + side * h)]).unwrap()));
        let difference = (up - down) / (2.0 * h);
        let found = m.motion().assembly();
        let body = found.description.bodies.iter().position(|b| b.name == "beam.tip").unwrap();
        let found = m.derivative(vibro_machine::Quantity::of_body(body, vibro_machine::What::S), p).unwrap();
        assert!(
            (found - difference).abs() < 1e-6 * difference.abs().max(1e-3),
            "{name} {found} {difference}"
        );
    }
}

#[test]
fn errors_name_the_value_and_what_is_allowed() {
    for (whole, wrong, text) in [
        (
            "damping_ratio = [0.01, 0.02, 0.03]",
            "damping_ratio = [0.01, 0.02]",
            "modal.beam.damping_ratio = [0.01, 0.02]: expected a list of 3 numbers, one for each coordinate",
        ),
        ("\"2 Hz\"", "\"-2 Hz\"", "modal.beam.frequencies[0] = \"-2 Hz\": must not be negative"),
        (
            "tip = [1.9, -2.0, 2.0]",
            "tip = [1.9, -2.0]",
            "modal.beam.nodes.tip = [1.9, -2.0]: the row has the length 2; expected 3, one number for each coordinate",
        ),
        ("{ \"0\" = 0.6, \"1\" = 1.2 }", "3", "expected the index of a coordinate, 0 to 2"),
        (
            "\"beam.middle\", \"mass\"",
            "\"beam.midle\", \"mass\"",
            "no body has this name; did you mean `beam.middle`?",
        ),
        (
            "\"rotation\"",
            "\"turn\"",
            "modal.beam.nodes.slope.dimension = \"turn\": expected \"translation\" or \"rotation\"",
        ),
        (
            "masses = [2.0, 1.0, 0.5]",
            "masses = [2.0, 1.0, 0.0]",
            "modal.beam.masses[2] = 0.0: must be greater than 0",
        ),
        ("modal.beam", "mode.beam", "no such kind of section"),
    ] {
        assert!(BEAM.contains(whole), "{whole}");
        let refused = parse(&BEAM.replace(whole, wrong), "modal.toml", &no_records).unwrap_err().to_string();
        assert!(refused.contains(text), "{refused}");
    }
}
