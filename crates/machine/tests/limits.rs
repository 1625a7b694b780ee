//! Motions that end early: by request, or because energies would overflow.

use crate::common::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use vibro_machine::description::*;
use vibro_machine::{Error, Motion};

/// An undamped body on a stiff spring with a stop at twice its amplitude, so that each of its
/// periods must be checked for contact.
fn fast() -> Motion {
    motion(Description {
        bodies: vec![body("light", 1e-6, 0.0, 1.0)],
        springs: vec![spring(&[(0, 1.0)], 1e6, 0.0)],
        stops: vec![rigid("beside", &[(0, 1.0)], 2e-6, 0.5)],
        ..Description::default()
    })
}

#[test]
fn invariant_a_call_that_is_interrupted_goes_on_in_the_next_with_the_same_bits() {
    let end = 0.3; // 100,000 sub-steps of 3/1e6 s
    let asked = Arc::new(AtomicBool::new(true));
    let (mut motion, mut whole) = (fast().with_interruption(asked.clone()), fast());
    let Err(Error::Interrupted { time }) = motion.advance_to(end) else { panic!("{}", motion.time()) };
    assert!(time == motion.time() && (0.1..0.25).contains(&time), "{time}");
    asked.store(false, Ordering::Relaxed);
    motion.advance_to(end).unwrap();
    whole.advance_to(end).unwrap();
    assert_eq!(motion.save(), whole.save());
}

/// A body under a constant load.
fn pushed(force: f64) -> Motion {
    let load = Signal { constant: force, ..Signal::default() };
    motion(Description {
        bodies: vec![body("ball", 1.0, 0.0, 0.0)],
        stops: vec![rigid("wall", &[(0, 1.0)], 1e3, 0.5)],
        loads: vec![Load { name: "push".into(), body: 0, force: load }],
        ..Description::default()
    })
}

#[test]
fn coordinates_beyond_energies_are_refused_with_body_and_time() {
    for force in [-1e101, -1e200, -1e300] {
        let mut motion = pushed(force);
        let before = motion.save();
        let error = motion.advance_to(1.0).unwrap_err();
        let text = error.to_string();
        assert!(
            matches!(error, Error::Beyond { .. }) && text.contains("body.ball") && text.contains("1e100"),
            "{text}"
        );
        motion.restore(&before);
        assert_eq!(motion.body(0)[..2], [0.0, 0.0]);
    }
    // However short the rest of the call is when the limit is exceeded.
    for end in [0.500_001, 0.51, 0.6] {
        let error = pushed(-2e100).advance_to(end).unwrap_err();
        assert!(matches!(error, Error::Beyond { .. }), "{end}: {error}");
    }
    // The largest allowed coordinates have finite energies.
    let mut motion = pushed(-1e99);
    motion.advance_to(1.0).unwrap();
    let (kinetic, stored) = motion.kinetic_and_stored();
    assert!((kinetic / 5e197 - 1.0).abs() < 1e-12 && stored == 0.0, "{kinetic:e} {stored:e}");
}

#[test]
fn a_start_beyond_energies_is_refused() {
    let d = Description {
        bodies: vec![body("ball", 1.0, 0.0, 1e120)],
        ..pushed(0.0).assembly().description.clone()
    };
    let text = Motion::new(Arc::new(vibro_machine::Assembly::new(d).unwrap())).unwrap_err().to_string();
    assert!(text.contains("body.ball: v = 1e120"), "{text}");
}

#[test]
fn rates_beyond_doubles_are_refused_by_name() {
    let (sound, pushed) = (fast().assembly().description.clone(), pushed(1.0).assembly().description.clone());
    let said = |d: Description| vibro_machine::Assembly::new(d).unwrap_err().to_string();
    // 1e6 N/m over 1e-308 kg overflows: the first sub-step of the machine would never end.
    let mut light = sound.clone();
    light.bodies[0] = body("light", 1e-308, 0.0, 1.0);
    assert!(said(light).starts_with("spring.spring0.stiffness = 1e6: gives a rate above 1e100 rad/s"));
    let mut damped = sound;
    damped.springs[0].damping = 1e100;
    assert!(said(damped).starts_with("spring.spring0.damping = 1e100: gives a rate above 1e100 rad/s"));
    let mut loud = pushed;
    loud.loads[0].force = sine(1.0, 1e308, 0.0);
    assert!(said(loud).starts_with("load.push: frequency = 1e308: gives a rate above 1e100 rad/s"));
}

#[test]
fn what_a_link_makes_heavy_is_not_refused() {
    let mut d = fast().assembly().description.clone();
    d.bodies = vec![body("heavy", 1.0, 0.0, 1.0), body("light", 1e-300, 0.0, 1.0)];
    d.springs = vec![spring(&[(1, 1.0)], 1e6, 0.0)];
    d.stops.clear();
    d.links = vec![Link { name: "rod".into(), arms: arms(&[(0, 1.0), (1, -1.0)]) }];
    let mut motion = motion(d);
    motion.advance_to(0.001).unwrap();
    // For the linked body of 1 kg, the rate is 1,000 rad/s.
    let off = motion.body(1)[0] - 1e-3 * 1f64.sin();
    assert!(off.abs() < 1e-15, "{off:e}"); // a rounding of 1 m/s and some
}

#[test]
fn closed_form_knots_are_no_work_that_has_no_end() {
    // A force that rises and falls 60,000 times in 0.6 ms, with the mean 1 N, on a body whose
    // sub-step is 3 s.
    let knots = (0..120_001).map(|k| (5e-9 * f64::from(k), 2.0 * f64::from(k % 2))).collect();
    let force = Signal { table: Some(Record::new(knots, Interpolation::Straight)), ..Signal::default() };
    let mut motion = motion(Description {
        bodies: vec![body("b", 1.0, 0.0, 0.0)],
        springs: vec![spring(&[(0, 1.0)], 1.0, 0.0)],
        loads: vec![Load { name: "record".into(), body: 0, force }],
        ..Description::default()
    });
    motion.advance_to(6e-4).unwrap();
    // 1 - cos t and sin t; the ripple of the force adds at most 1e-8 N s, and nothing at its ends.
    let [s, v, _] = motion.body(0);
    assert!((s - (1.0 - 6e-4f64.cos())).abs() < 1e-11 && (v - 6e-4f64.sin()).abs() < 1e-11, "{s} {v}");
}

#[test]
fn too_many_events_in_a_call_are_told_with_what_helps() {
    // A ball under 1 N that bounces without loss, 1e6 times a second.
    let mut motion = motion(Description {
        bodies: vec![body("ball", 1.0, -1.25e-13, 0.0)],
        springs: vec![spring(&[(0, 1.0)], 1e-6, 0.0)],
        stops: vec![rigid("floor", &[(0, 1.0)], 0.0, 1.0)],
        loads: vec![Load { name: "push".into(), body: 0, force: constant(1.0) }],
        ..Description::default()
    });
    motion.advance_to(1e-4).unwrap();
    let Err(Error::Stuck { time, cause }) = motion.advance_to(1.0) else { panic!("{}", motion.time()) };
    assert!(time == motion.time() && (0.005..0.5).contains(&time), "{time}");
    for part in [
        "sub-steps in one call",
        "from t = 0.0001 s",
        "lower restitution",
        "stop.floor",
        "another call continues",
    ] {
        assert!(cause.contains(part), "{part}: {cause}");
    }
    motion.advance_to(time + 1e-3).unwrap();
}

/// Tolerance on a rate that a few operations give.
const RATE: f64 = 1e-14;

/// A formula so steep that a second of motion takes 10⁹ series: its slope 8/10⁻⁹ N s/m over 2 kg. A
/// call that would take many times its limit ends after a second or two of computing, and one that
/// reaches its limit ends there; both name the element.
#[test]
fn closed_form_a_steep_formula_is_named() {
    let text = "name = \"Steep\"\nbody.m = { mass = 2.0, start = { s = 0.0, v = 1e-12 } }\n\
                spring.k = { between = [\"ground\", \"m\"], stiffness = 50.0, preload = 1.0 }\n\
                damper.d = { between = [\"ground\", \"m\"], force = \"= 8 * tanh(rate / 1e-9)\" }\n";
    let assembly = assembled(text);
    let steep = assembly.steepest_at_zero().expect("a curved force");
    assert_eq!(steep.element, "damper.d");
    assert!((steep.rate / 4e9 - 1.0).abs() < RATE, "{}", steep.rate);
    for (most, series) in [(1_000, "1000 series"), (20_000_000, "500000 series")] {
        let mut motion = Motion::new(assembly.clone()).expect("a motion").with_most_work(most);
        let error = motion.advance_to(1e3).expect_err("an end").to_string();
        let is_named = error.contains(series) && error.contains("the force of damper.d changes as fast as");
        assert!(is_named && motion.time() < 1e-2, "{error}");
    }
}
