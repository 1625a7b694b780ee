//! Derivatives with respect to state and time of the start: the transition matrix.

use crate::common::*;
use std::sync::Arc;
use vibro_machine::derivative::{By, Cause};
use vibro_machine::motion::Reached;
use vibro_machine::{Assembly, Differentiated, Error, Motion};

/// Machines with known motions in 50 digits (tests/second_method.rs).
const MACHINES: &str = include_str!("data/motions.txt");
/// Rounding of a derivative, relative to the largest of its column: some hundred operations at
/// each event, amplified by later flights.
const ROUNDING: f64 = 1e-9;
/// Rounding of a closed form of some operations.
const EXACT: f64 = 1e-13;
/// Largest share of columns of random machines without a derivative, because a contact is touched
/// at the start.
const MOST_LOST: f64 = 0.1;

fn all_columns(assembly: &Assembly) -> Vec<By> {
    (0..2 * assembly.system().coordinates).map(By::Start).collect()
}

/// The states at `end` of a motion from `state`, by variations of the state.
fn by_variations(assembly: &Arc<Assembly>, time: f64, state: &[f64], end: f64) -> Vec<Vec<f64>> {
    let mut motion = Motion::from_state(assembly.clone(), time, state).unwrap();
    let mut variations = motion.unit_variations();
    while motion.advance_with(end, &mut variations).unwrap() == Reached::Event {}
    variations
}

#[test]
fn second_method_the_transition_matrix_of_random_machines() {
    let (mut compared, mut lost) = (0, 0);
    for block in MACHINES.split("## machine ").skip(1) {
        let toml: String =
            block.lines().skip(1).filter(|l| !l.starts_with("##")).flat_map(|l| [l, "\n"]).collect();
        let assembly = assembled(&toml);
        // Starts inside a motion, so that some of them have held contacts.
        let (begin, end) = (0.3, 0.55);
        let mut before = Motion::new(assembly.clone()).unwrap();
        before.advance_to(begin).unwrap();
        let columns = all_columns(&assembly);
        let state = &before.state().as_slice()[..columns.len()];
        let mut motion = Differentiated::from_state(assembly.clone(), begin, state, &columns).unwrap();
        motion.advance_to(end).unwrap();
        let variations = by_variations(&assembly, begin, state, end);
        for (p, variation) in variations.iter().take(columns.len()).enumerate() {
            let Some(found) = motion.state_derivative(p) else {
                lost += 1;
                continue;
            };
            let size = variation.iter().fold(1.0f64, |most, x| most.max(x.abs()));
            let off = found.iter().zip(variation).fold(0.0f64, |most, (x, y)| most.max((x - y).abs()));
            let name = block.lines().next().unwrap();
            assert!(off < ROUNDING * size, "machine {name}, {p}: {found:?} {variation:?}");
            compared += 1;
        }
    }
    println!("{compared} columns compared, {lost} without a derivative");
    assert!(compared > 300 && f64::from(lost) < MOST_LOST * f64::from(compared));
}

#[test]
fn closed_form_a_motion_on_a_closed_stop_moves_with_its_gap() {
    // Pressed against arm·s = gap by F until F reverses: F = 4 at first, -2 from t = 1 on.
    let text = "name = \"H\"\n[body.a]\nmass = 2.0\n[stop.s]\narms = { a = 2.0 }\ngap = 0.5\nrestitution = 0.4\n\
                [load.push]\non = \"a\"\nconstant = 4.0\nsteps = [[1.0, -6.0]]\n";
    let columns =
        ["stop.s.gap".into(), By::Start(0), By::Start(1), "load.push.steps[0].time".into(), By::Time];
    let begun = Motion::from_state(assembled(text), 0.5, &[0.25, 0.0]).unwrap();
    let mut motion = Differentiated::from_motion(begun, &columns).unwrap();
    assert_eq!(
        motion.parameters(),
        ["stop.s.gap", "start[0]", "start[1]", "load.push.steps[0].time", "start.time"]
    );
    motion.advance_to(2.0).unwrap();
    let exact = [[0.5, 0.0], [0.0, 0.0], [0.0, 0.0], [1.0, 1.0], [0.0, 0.0]];
    for (p, exact) in exact.iter().enumerate() {
        let found = motion.state_derivative(p).unwrap();
        assert!(found.iter().zip(exact).all(|(x, y)| (x - y).abs() < EXACT), "{}: {found:?}", columns[p]);
    }
}

#[test]
fn closed_form_by_the_time_of_the_start() {
    // v = v₀ + A (sin φ(t) - sin φ(t₀))/(mω), without forces before t₀. It hits the stop later by
    // δt = 1 + A/m cos φ(t₀) (t - t₀)/v, as the state there is the same.
    let text = "name = \"T\"\n[body.a]\nmass = 2.0\n[load.l]\non = \"a\"\namplitude = 3.0\nfrequency = 0.5\nphase = 1.5707963267948966\n\
                [stop.s]\nbetween = [\"ground\", \"a\"]\ngap = 1.0\nrestitution = 0.5\n";
    let (time, v) = (0.2, 2.0);
    let columns = [By::Time, By::Start(0), By::Start(1)];
    let mut motion = Differentiated::from_state(assembled(text), time, &[0.0, v], &columns).unwrap();
    motion.advance_to(0.5).unwrap();
    let push = 3.0 / 2.0 * (std::f64::consts::PI * time).cos();
    let exact = [[-v - push * 0.3, -push], [1.0, 0.0], [0.3, 1.0]];
    for (p, exact) in exact.iter().enumerate() {
        let found = motion.state_derivative(p).unwrap();
        assert!(found.iter().zip(exact).all(|(x, y)| (x - y).abs() < EXACT), "{}: {found:?}", columns[p]);
    }
    let mut hit = None;
    motion.advance_observed(0.8, &mut |event, by| hit = Some((event.time, by.to_vec()))).unwrap();
    let (at, by) = hit.unwrap();
    let omega = std::f64::consts::PI;
    let speed = v + 1.5 / omega * ((omega * at).sin() - (omega * time).sin());
    let later = [(v + push * (at - time)) / speed, -1.0 / speed, -(at - time) / speed];
    assert!(by.iter().zip(later).all(|(x, y)| (x.unwrap() - y).abs() < EXACT), "{by:?} {later:?}");
}

#[test]
fn a_start_that_touches_has_the_derivatives_that_it_has_on_both_sides() {
    let text = "name = \"L\"\n[body.a]\nmass = 1.0\n[stop.wall]\nbetween = [\"ground\", \"a\"]\ngap = 0.2\nrestitution = 0.5\n";
    let at = |v: f64| {
        let columns = [By::Start(0), By::Start(1)];
        let mut motion = Differentiated::from_state(assembled(text), 0.0, &[0.2, v], &columns).unwrap();
        motion.advance_to(1.0).unwrap();
        motion
    };
    // If it moves away, the wall does not matter; if it hits, starts behind the wall are refused.
    assert_eq!(at(-1.0).state_derivative(0).unwrap(), [1.0, 0.0]);
    assert_eq!(at(-1.0).state_derivative(1).unwrap(), [1.0, 1.0]);
    let hit = at(1.0);
    let lost = hit.lost(0).unwrap();
    assert_eq!((lost.element.as_str(), lost.cause), ("stop.wall", Cause::Limit));
    assert_eq!(hit.state_derivative(1).unwrap(), [-0.5, -0.5]);
}

#[test]
fn bad_starts_are_refused_by_name() {
    let machine = assembled(
        "name = \"L\"\n[body.a]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 1.0\n",
    );
    let refused = Differentiated::new(machine.clone(), &[By::Start(2)]).map(drop).unwrap_err();
    let Error::OutOfRange { name, allowed, .. } = &refused else { panic!("{refused}") };
    assert_eq!((name.as_str(), allowed.as_str()), ("index of a start value", "a whole number from 0 to 1"));
    assert!(Differentiated::from_state(machine, 0.0, &[1.0], &["body.a.mass"]).is_err());
}
