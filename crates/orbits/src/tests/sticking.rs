//! Orbits on which a slider or a friction sticks for the whole period: other places where it
//! sticks give other orbits.

use super::*;
use nalgebra::Complex;
use std::f64::consts::TAU;

/// A shaken mass with a second one beside it, which a contact may press.
const PAIR: &str = r#"
name = "Pair"
body.a = { mass = 1.0 }
body.b = { mass = 1.0 }
spring.mount_a = { between = ["ground", "a"], stiffness = 1000.0, damping = 3.0 }
spring.mount_b = { between = ["ground", "b"], stiffness = 2000.0, damping = 3.0 }
load.push_a = { on = "a", amplitude = 1.0, frequency = 3.0 }
load.push_b = { on = "b", amplitude = 0.5, frequency = 3.0, constant = 100.0 }
"#;

/// Springs of 500 N/m at mass a whose other end sticks.
const STICKING: [(&str, &str); 3] = [
    (
        "contact",
        "contact.pad = { normal = [\"ground\", \"b\"], tangent = [\"ground\", \"a\"], preload = 100.0, \
         stiffness = 1e4, tangential_stiffness = 500.0, friction = 0.3 }\n",
    ),
    ("slider", "spring.c = { between = [\"ground\", \"a\"], stiffness = 500.0, slip = 100.0 }\n"),
    (
        "friction",
        "body.c = { mass = 1.0 }\nfriction.pad = { between = [\"ground\", \"c\"], force = 50.0 }\n\
         spring.c = { between = [\"a\", \"c\"], stiffness = 500.0 }\n",
    ),
];

/// Relative tolerance of an amplitude: rounding, and the step of Newton's method that is rounding.
const EXACT: f64 = 1e-11;

#[test]
fn closed_form_a_contact_that_sticks_has_one_branch_of_the_place_where_it_sticks() {
    for (name, text) in STICKING {
        let machine = machine(&format!("{PAIR}{text}"));
        let family = Family::new(&machine, "load.push_a.amplitude", (0.9, 1.1)).unwrap();
        let branches = grown(&family, 3, 0);
        assert_eq!(branches.len(), 1, "{name}");
        let points = &branches[0].points;
        let range = points.iter().fold((2.0f64, 0.0f64), |(a, b), own| (a.min(own.value), b.max(own.value)));
        assert!(points.len() > 2 && range == (0.9, 1.1), "{name}: {range:?}");
        for point in points {
            let orbit = branches[0].orbit(point).unwrap();
            let omega = TAU * 3.0;
            let force = Complex::from_polar(point.value, 0.0);
            let response = force / Complex::new(1500.0 - omega * omega, omega * 3.0);
            let angle = omega * orbit.numbers.times[0];
            let expected = (response * Complex::from_polar(1.0, angle)).im;
            let apart = orbit.state()[0] - expected;
            assert!(apart.abs() < EXACT * response.norm(), "{name}: {apart:e}");
            assert_eq!(orbit.held().len(), 1, "{name}");
            let own = moduli_by_motion(&orbit);
            // The place where the contact sticks has the multiplier 1, or no state of its own.
            assert!(orbit.multipliers().iter().all(|m| m.norm() < 1.0) && (own[0] - 1.0).abs() < EXACT);
        }
    }
}

/// A mass strikes a wall while a slider between it and a moving table sticks: the place where the
/// slider sticks depends on the time of the first event, and on the motion of the table.
#[test]
fn second_method_a_slider_on_a_moving_table_is_held_where_it_sticks() {
    let text = "name = \"Table\"\nbody.table = { motion = { amplitude = 2e-3, frequency = 3.0 } }\n\
                body.a = { mass = 1.0 }\nspring.a = { between = [\"ground\", \"a\"], stiffness = 300.0, damping = 3.0 }\n\
                spring.c = { between = [\"table\", \"a\"], stiffness = 500.0, slip = 100.0 }\n\
                stop.wall = { between = [\"a\", \"ground\"], gap = 1e-3, restitution = 0.6 }\n";
    let machine = machine(text);
    let orbit = Orbit::settled(&machine, &vibro_machine::Start::default(), 400).unwrap();
    assert!(!orbit.word().is_empty() && orbit.is_certified(), "{:?}", orbit.violation());
    assert_eq!(orbit.held(), [vibro_machine::mode::Contact::Slider(0)]);
    for own in [("body.table.motion.amplitude", 1e-4), ("stop.wall.gap", 1e-4), ("spring.c.stiffness", 10.0)]
    {
        let apart = column_apart(&machine, &orbit, own);
        assert!(apart < DIFFERENCED, "{own:?}: {apart:e}");
    }
    let family = Family::new(&machine, "body.table.motion.amplitude", (1.9e-3, 2.1e-3)).unwrap();
    let found = branch(&family, &orbit, &PathOptions::default()).unwrap();
    let inner = |orbit: &Orbit| {
        let (assembly, (time, state)) = (orbit.place().assembly.clone(), orbit.middle_state());
        assert!(time.is_finite() && assembly.system().branches.len() == 1);
        state[2]
    };
    let held = inner(&orbit);
    assert!(found.points.len() > 4);
    for point in &found.points {
        let apart = inner(&found.orbit(point).unwrap()) - held;
        assert!(apart.abs() < HELD, "{}: {apart:e}", point.value);
    }
}

/// Tolerance for the place where a slider sticks, m: rounding of elongations of 2 mm.
const HELD: f64 = 1e-15;
/// Tolerance for a column against a difference of second order with steps of 1e-5.
const DIFFERENCED: f64 = 1e-6;
