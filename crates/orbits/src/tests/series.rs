//! Orbits of machines with first-order states.

use super::*;
use crate::curve::Equations;
use crate::problem::Problem;
use nalgebra::DMatrix;
use std::sync::Arc;
use vibro_machine::derivative::By;
use vibro_machine::{Differentiated, Start};

/// A block on a Zener mount that strikes a wall.
const ZENER: &str = r#"
name = "Zener"
body.b = { mass = 1.0 }
spring.soft = { between = ["ground", "b"], stiffness = 100.0 }
spring.mount = { between = ["ground", "b"], stiffness = 80.0, series_damping = 6.0 }
stop.wall = { between = ["ground", "b"], gap = 0.02, restitution = 0.7 }
load.drive = { on = "b", amplitude = 10.0, frequency = 2.0 }
"#;

/// Tolerance for an orbit's values over a period.
const ROUNDING: f64 = 1e-9;
/// Step of the differences in the parameter's unit, and their tolerance.
const DIFFERENCE: (f64, f64) = (1e-5, 1e-6);

/// The orbit of a machine, checked against the machine's motion and the motion's derivative.
fn examined(machine: &Machine, states: usize) -> Orbit {
    let orbit = Orbit::settled(machine, &Start::default(), 400).unwrap();
    assert!(orbit.is_certified(), "{:?}", orbit.violation());
    assert!(orbit.check_by_motion().unwrap() < ROUNDING);
    let (assembly, (time, state)) = (orbit.place().assembly.clone(), orbit.middle_state());
    assert_eq!((state.len(), orbit.multipliers().len()), (states, states));
    let columns: Vec<By> = (0..states).map(By::Start).collect();
    let mut motion = Differentiated::from_state(assembly.clone(), time, &state, &columns).unwrap();
    motion.advance_to(time + orbit.period()).unwrap();
    let column = |p: usize| motion.state_derivative(p).unwrap_or_else(|| panic!("{:?}", motion.lost(p)));
    let map = DMatrix::from_vec(states, states, (0..states).flat_map(column).collect());
    let mut own: Vec<f64> = map.complex_eigenvalues().iter().map(|m| m.norm()).collect();
    own.sort_by(|a, b| b.total_cmp(a));
    for (a, b) in orbit.multipliers().iter().zip(&own) {
        assert!((a.norm() - b).abs() < ROUNDING, "{:?} {own:?}", orbit.multipliers());
    }
    // The orbit's start is also a start of the motion.
    let start = orbit.start();
    let begun = start.motion(assembly).unwrap();
    assert!(begun.states().iter().zip(&state).all(|(a, b)| (a - b).abs() < ROUNDING));
    orbit
}

/// Checks a parameter's column against differences of the equations.
fn check_column(machine: &Machine, orbit: &Orbit, parameter: &str) {
    let present = machine.description.get(parameter).unwrap();
    let family = Family::new(machine, parameter, (0.9 * present, 1.1 * present)).unwrap();
    let problem = Problem { family: Arc::new(family), ..orbit.problem.clone() };
    let u = problem.point(orbit.place(), &problem.numbers(orbit.place(), &orbit.u), present);
    let own = problem.linearize(&u, None).unwrap().matrix.column(problem.size()).into_owned();
    let at = |by: f64| {
        let mut moved = u.clone();
        moved[problem.size()] += by;
        problem.residual(&problem.place(&moved).unwrap(), &moved, false).unwrap().value
    };
    let (step, left) = DIFFERENCE;
    let step = step * present;
    let apart = ((at(step) - at(-step)) / (2.0 * step) - &own).norm() / own.norm();
    assert!(apart < left, "{parameter}: {apart:e}");
}

#[test]
fn second_method_an_orbit_on_a_zener_mount_has_a_multiplier_for_its_inner_place() {
    let machine = machine(ZENER);
    let orbit = examined(&machine, 3);
    assert_eq!(orbit.word().in_words(&orbit.place().assembly), "impact wall");
    // Each impact multiplies volumes by ε², the mount by exp(-k/c t).
    let product: f64 = orbit.multipliers().iter().map(|m| m.norm()).product();
    let exact = 0.49 * (-80.0 / 6.0 * orbit.period()).exp();
    assert!((product / exact - 1.0).abs() < 1e-6, "{product} {exact}");
    for parameter in ["spring.mount.stiffness", "spring.mount.series_damping", "load.drive.frequency"] {
        check_column(&machine, &orbit, parameter);
    }
}

/// The same block on a joint of two sliders, with a spring and a damper in parallel.
const JOINT: &str = r#"
name = "Joint"
body.b = { mass = 1.0 }
spring.soft = { between = ["ground", "b"], stiffness = 100.0, damping = 0.8 }
spring.first = { between = ["ground", "b"], stiffness = 60.0, slip = 1.0 }
spring.second = { between = ["ground", "b"], stiffness = 40.0, slip = 3.0 }
load.drive = { on = "b", amplitude = 10.0, frequency = 2.0 }
"#;

#[test]
fn second_method_an_orbit_whose_sliders_slip_forgets_their_places() {
    let machine = machine(JOINT);
    let orbit = examined(&machine, 4);
    let words = orbit.word().in_words(&orbit.place().assembly);
    assert!(words.contains("slip first") && words.contains("stick first"), "{words}");
    assert_eq!(orbit.stability(), Stability::Stable);
    // At its slip level a force no longer depends on the slider's earlier position.
    assert!(orbit.multipliers()[2..].iter().all(|m| m.norm() < ROUNDING), "{:?}", orbit.multipliers());
    for parameter in
        ["spring.first.stiffness", "spring.first.slip", "spring.second.slip", "load.drive.amplitude"]
    {
        check_column(&machine, &orbit, parameter);
    }
}

/// A body of two coordinates on a contact with friction; LOAD is the amplitude along the normal.
const TIP: &str = r#"
name = "Tip"
body.n = { mass = 1.0 }
body.t = { mass = 1.2 }
spring.n = { between = ["ground", "n"], stiffness = 60.0, damping = 1.5 }
spring.t = { between = ["ground", "t"], stiffness = 80.0, damping = 0.8 }
spring.nt = { between = ["n", "t"], stiffness = 12.0 }
contact.c = { normal = ["ground", "n"], tangent = ["ground", "t"], gap = 0.01, stiffness = 400.0, tangential_stiffness = 250.0, friction = 0.35 }
load.fn = { on = "n", constant = 12.0, amplitude = LOAD, frequency = 1.4, phase = 0.6 }
load.ft = { on = "t", amplitude = 9.0, frequency = 1.4 }
"#;

#[test]
fn second_method_orbits_on_a_contact_with_friction_and_with_lift_off() {
    for (load, words) in [("4.0", ["slip", "stick"]), ("19.0", ["press", "free"])] {
        let machine = machine(&TIP.replace("LOAD", load));
        let orbit = examined(&machine, 5);
        let word = orbit.word().in_words(&orbit.place().assembly);
        assert!(words.iter().all(|own| word.contains(own)), "{word}");
        for key in ["friction", "tangential_stiffness", "stiffness", "gap"] {
            check_column(&machine, &orbit, &format!("contact.c.{key}"));
        }
    }
}
