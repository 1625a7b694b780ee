//! Machines without coordinates: test rigs in which each body is prescribed or linked to a
//! prescribed body.

use crate::common::*;
use std::f64::consts::TAU;
use vibro_machine::What;
use vibro_machine::description::*;
use vibro_machine::motion::EventKind;

/// Hundreds of roundings of numbers of order one.
const ROUNDING: f64 = 1e-13;
/// Rounding of works that are summed over a hundred sub-steps.
const WORK: f64 = 1e-12;

/// A ram with a prescribed sine, and a spring with a dashpot, a buffer and a brake to ground.
fn rig() -> Description {
    Description {
        name: "Rig".into(),
        bodies: vec![prescribed("ram", sine(0.1, 1.0, 0.0), 0.0)],
        springs: vec![spring(&[(0, 1.0)], 200.0, 3.0)],
        stops: vec![compliant("buffer", &[(0, 1.0)], 0.05, 1e3, 0.0, DampingLimit::NoPull)],
        frictions: vec![friction(&[(0, 1.0)], 2.0)],
        ..Description::default()
    }
}

#[test]
fn closed_form_a_ram_that_moves_as_prescribed() {
    rig().check().unwrap();
    let mut m = motion(rig());
    let all = events(&mut m, 1.0);
    // The buffer closes at sin ωt = 1/2.
    let pressed = times(&all, |k| matches!(k, EventKind::Press { .. }));
    assert!(pressed.len() == 1 && (pressed[0] - 1.0 / 12.0).abs() < ROUNDING, "{all:?}");
    let slips = times(&all, |k| matches!(k, EventKind::Slip { .. }));
    assert!(
        !slips.is_empty() && slips.iter().all(|t| ((t * 4.0) % 2.0 - 1.0).abs() < 4.0 * ROUNDING),
        "{all:?}"
    );
    // Losses per period, equal to the work of the motion: ½ d (ωA)² T of the dashpot, 4 A F of
    // friction.
    let energy = m.energy();
    let dashpot = 0.5 * 3.0 * (0.1 * TAU).powi(2);
    assert!((energy.dashpots[0].value() - dashpot).abs() < WORK, "{energy:?}");
    assert!((energy.frictions[0].value() - 0.8).abs() < WORK, "{energy:?}");
    assert!((energy.motions.value() - dashpot - 0.8).abs() < WORK, "{energy:?}");
    m.advance_to(1.125).unwrap();
    let (s, v) = (0.1 * (0.125 * TAU).sin(), 0.1 * TAU * (0.125 * TAU).cos());
    let [place, rate, _] = m.body(0);
    assert!((place - s).abs() < ROUNDING && (rate - v).abs() < ROUNDING);
    assert!((m.stop(0)[2] - 1e3 * (s - 0.05)).abs() < 1e3 * ROUNDING);
    let (kinetic, stored) = m.kinetic_and_stored();
    assert!(kinetic == 0.0 && (stored - m.energy().balance()).abs() < WORK, "{kinetic} {stored}");
}

#[test]
fn closed_form_what_links_tie_to_a_motion_is_carried() {
    // A motor at 3 rad/s drives a loaded drum of 2 kg m² through a link of ratio -1/5.
    let mut d = Description {
        name: "Drum".into(),
        bodies: vec![prescribed("motor", constant(0.0), 3.0), body("drum", 2.0, 0.0, -0.6)],
        links: vec![Link { name: "gear".into(), arms: arms(&[(0, 1.0), (1, 5.0)]) }],
        loads: vec![Load { name: "load".into(), body: 1, force: constant(7.0) }],
        ..Description::default()
    };
    d.check().unwrap();
    let mut m = motion(d.clone());
    m.advance_to(2.0).unwrap();
    let [s, v, _] = m.body(1);
    assert!((s + 1.2).abs() < ROUNDING && (v + 0.6).abs() < ROUNDING, "{s} {v}");
    assert!((m.energy().loads[0].value() + 7.0 * 1.2).abs() < WORK);
    assert!((m.energy().motions.value() - 7.0 * 1.2).abs() < WORK, "{:?}", m.energy());
    assert_eq!(m.energy().balance().abs().max(WORK), WORK);
    // If the motor is free instead of prescribed, no motion at all is possible.
    d.bodies[0] = body("motor", 1.0, 0.0, 0.0);
    d.bodies[1] = body("drum", 2.0, 0.0, 0.0);
    d.links.push(Link { name: "second".into(), arms: arms(&[(0, 1.0), (1, -1.0)]) });
    let refused = d.check().unwrap_err().to_string();
    assert!(refused.contains("link.second: with link.gear it holds every body still"), "{refused}");
}

#[test]
fn invariant_a_rig_starts_at_rest_saves_and_is_set_from_outside() {
    let at_rest = Description { starts_at_rest: true, ..rig() };
    let mut m = motion(at_rest);
    assert_eq!(m.assembly().equilibrium().unwrap(), [0.0]);
    let saved = m.save();
    m.advance_to(0.3).unwrap();
    m.restore(&saved);
    assert_eq!(m.time(), 0.0);
    let driven = Description {
        bodies: vec![prescribed("flange", Signal { input: true, ..Signal::default() }, 0.0)],
        frictions: Vec::new(),
        ..rig()
    };
    let mut m = motion(driven);
    m.set_input(0, [0.0, 0.5, 0.0, 0.0]).unwrap();
    let all = events(&mut m, 0.2);
    let pressed = times(&all, |k| matches!(k, EventKind::Press { .. }));
    assert!(pressed.len() == 1 && (pressed[0] - 0.1).abs() < ROUNDING, "{all:?}");
    assert!((m.body(0)[0] - 0.1).abs() < ROUNDING);
}

/// A friction between prescribed bodies has no force of its own while they have the same rate: its
/// force is 0, and no load makes it slip. A rigid stop that they violate is named in the error.
#[test]
fn closed_form_stuck_friction_and_jams_between_prescribed_bodies() {
    let rig = |stop: &str| {
        format!(
            "name = \"Rig\"\nbody.a = {{ motion = {{ rate = 0.5 }} }}\nbody.idle = {{ motion = {{ rate = 1.0 }} }}\n\
             body.b = {{ motion = {{ rate = {{ constant = 0.5, table = [[1, 0], [3, 2]] }} }} }}\n\
             friction.f = {{ between = [\"a\", \"b\"], force = \"3 N\" }}\n{stop}"
        )
    };
    let mut m = moving(&rig(""));
    m.advance_to(0.9).unwrap();
    assert_eq!((of(&m, 0, What::F), of(&m, 0, What::Rate)), (0.0, 0.0));
    let slips = times(&events(&mut m, 2.0), |kind| matches!(kind, EventKind::Slip { .. }));
    assert!(slips.len() == 1 && (slips[0] - 1.0).abs() < ROUNDING, "{slips:?}");
    assert_eq!(of(&m, 0, What::F), 3.0);
    // (t - 1)²/2 is the gap at t = 1.5.
    let mut m = moving(&rig("stop.wall = { between = [\"a\", \"b\"], gap = 0.125, restitution = 0.5 }"));
    let jammed = m.advance_to(3.0).unwrap_err().to_string();
    assert!(jammed.contains("stop.wall") && jammed.contains("1.5"), "{jammed}");
}
