//! Short constructors of machines, for tests.
#![allow(dead_code)]

pub mod both_laws;
pub mod contacts;
pub mod differences;
pub mod machines;

use std::sync::Arc;
use vibro_machine::description::*;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Motion, Quantity, What, file};

/// The machine of a text.
#[track_caller]
pub fn machine(text: &str) -> Description {
    file::parse(text, "machine.toml", &file::no_records).unwrap_or_else(|refusal| panic!("{refusal}"))
}

/// The error of an invalid text.
#[track_caller]
pub fn refusal(text: &str) -> String {
    file::parse(text, "machine.toml", &file::no_records).unwrap_err().to_string()
}

/// The assembly of a text's machine.
#[track_caller]
pub fn assembled(text: &str) -> Arc<Assembly> {
    Arc::new(Assembly::new(machine(text)).unwrap_or_else(|refusal| panic!("{refusal}")))
}

/// The motion of a text's machine from its start.
#[track_caller]
pub fn moving(text: &str) -> Motion {
    motion(machine(text))
}

/// The machine of a text next to ten separate oscillators: more than twenty coordinates, for which
/// no tables are kept.
pub fn with_company(text: &str) -> String {
    let one = |i: usize| {
        format!(
            "[body.o{i}]\nmass = 1.0\nstart = {{ s = 0.1 }}\n[spring.o{i}]\nbetween = [\"ground\", \"o{i}\"]\nstiffness = {i}0.0\n"
        )
    };
    text.to_owned() + "\n" + &(1..=10).map(one).collect::<String>()
}

/// A quantity of an element, by the element's index.
pub fn of(m: &Motion, element: usize, what: What) -> f64 {
    m.value(Quantity::of_element(element, what))
}

/// Mechanical energy minus the balance of the accounts: constant, J.
pub fn unaccounted(m: &Motion) -> f64 {
    let (kinetic, stored) = m.kinetic_and_stored();
    kinetic + stored - m.energy().balance()
}

/// Requires a difference below `allowed`.
#[track_caller]
pub fn near(found: f64, exact: f64, allowed: f64) {
    assert!((found - exact).abs() < allowed, "{found} instead of {exact}");
}

/// A machine with elements with additional pieces of force.
pub fn laws() -> Description {
    file::parse(include_str!("../data/laws.toml"), "laws.toml", &file::no_records).unwrap()
}

/// A machine with stepping stiffness.
pub fn stepped() -> Description {
    file::parse(include_str!("../data/stepped.toml"), "stepped.toml", &file::no_records).unwrap()
}

/// A free body.
pub fn body(name: &str, inertia: f64, s: f64, v: f64) -> Body {
    let free = Free { inertia, gravity: 0.0, s, v };
    Body { name: name.into(), dimension: Dimension::Translation, kind: BodyKind::Free(free) }
}

/// A free body on which gravity acts.
pub fn heavy(name: &str, inertia: f64, gravity: f64, s: f64, v: f64) -> Body {
    let free = Free { inertia, gravity, s, v };
    Body { name: name.into(), dimension: Dimension::Translation, kind: BodyKind::Free(free) }
}

/// A prescribed body.
pub fn prescribed(name: &str, motion: Signal, rate: f64) -> Body {
    Body { name: name.into(), dimension: Dimension::Translation, kind: BodyKind::Prescribed { motion, rate } }
}

/// Arms by body and weight.
pub fn arms(terms: &[(usize, f64)]) -> Arms {
    Arms { terms: terms.to_vec(), dimension: Dimension::Translation, levers: true }
}

/// A spring.
pub fn spring(terms: &[(usize, f64)], stiffness: f64, damping: f64) -> Spring {
    let name = format!("spring{}", terms[0].0);
    let (points, stepped, series) = (Vec::new(), None, None);
    Spring {
        name,
        arms: arms(terms),
        stiffness,
        stepped,
        damping,
        preload: 0.0,
        curve: Default::default(),
        power: None,
        force: None,
        across: None,
        points,
        series,
    }
}

/// A rigid stop.
pub fn rigid(name: &str, terms: &[(usize, f64)], gap: f64, restitution: f64) -> Stop {
    Stop {
        name: name.into(),
        arms: arms(terms),
        gap,
        law: StopLaw::Rigid { restitution },
        stepped: None,
        contact: None,
    }
}

/// A compliant stop.
pub fn compliant(
    name: &str,
    terms: &[(usize, f64)],
    gap: f64,
    stiffness: f64,
    damping: f64,
    limit: DampingLimit,
) -> Stop {
    let law = StopLaw::Compliant { stiffness, damping, limit };
    Stop { name: name.into(), arms: arms(terms), gap, law, stepped: None, contact: None }
}

/// Friction of a constant level.
pub fn friction(terms: &[(usize, f64)], force: f64) -> Friction {
    Friction {
        name: "friction".into(),
        arms: arms(terms),
        force: constant(force),
        static_force: None,
        follows: None,
        stribeck: None,
        viscous: None,
    }
}

/// A constant signal.
pub fn constant(constant: f64) -> Signal {
    Signal { constant, ..Signal::default() }
}

/// A sine.
pub fn sine(amplitude: f64, frequency: f64, phase: f64) -> Signal {
    Signal { harmonics: vec![Harmonic { amplitude, frequency, phase }], ..Signal::default() }
}

/// The motion of a machine from its start.
pub fn motion(description: Description) -> Motion {
    Motion::new(Arc::new(Assembly::new(description).unwrap())).unwrap()
}

/// All events up to a time.
pub fn events(motion: &mut Motion, end: f64) -> Vec<Event> {
    let mut all = Vec::new();
    motion.advance_observed(end, &mut |event| all.push(event.clone())).unwrap();
    all
}

/// The times of events of one kind.
pub fn times(events: &[Event], kind: impl Fn(&EventKind) -> bool) -> Vec<f64> {
    events.iter().filter(|e| kind(&e.kind)).map(|e| e.time).collect()
}
