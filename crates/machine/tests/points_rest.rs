//! Starts at rest of machines with piecewise linear springs (docs/assembly-law.md, section 10).

use crate::common::*;
use vibro_machine::description::*;
use vibro_machine::{Assembly, Error};

/// Relative rounding error of coordinates.
const ROUNDING: f64 = 1e-12;

/// A spring between ground and body `i`, or between two bodies.
fn lines(name: &str, terms: &[(usize, f64)], all: &[(f64, f64)]) -> Spring {
    let points = all.iter().map(|&(e, f)| ForcePoint { e, f }).collect();
    Spring { name: name.into(), points, ..spring(terms, 0.0, 0.0) }
}

fn loaded(bodies: usize, springs: Vec<Spring>, forces: &[f64]) -> Description {
    let load = |(i, &f): (usize, &f64)| Load { name: format!("l{i}"), body: i, force: constant(f) };
    Description {
        name: "Loaded".into(),
        starts_at_rest: true,
        bodies: (0..bodies).map(|i| body(&format!("b{i}"), 1.0 + i as f64, 0.0, 0.0)).collect(),
        springs,
        loads: forces.iter().enumerate().map(load).collect(),
        ..Description::default()
    }
}

fn places(d: &Description) -> Vec<f64> {
    let assembly = Assembly::new(d.clone()).unwrap_or_else(|e| panic!("{e}"));
    let found = assembly.equilibrium().unwrap();
    // The machine stays at rest.
    let mut m = motion(d.clone());
    m.advance_to(3.0).unwrap();
    for (i, s) in found.iter().enumerate() {
        assert!((m.body(i)[0] - s).abs() < 1e-9 * s.abs().max(1e-3), "{i}: {} {s}", m.body(i)[0]);
    }
    found
}

fn gives_way(d: &Description) -> (String, f64) {
    match Assembly::new(d.clone()).map(drop) {
        Err(Error::GivesWay { spring, factor }) => (spring, factor),
        other => panic!("{other:?}"),
    }
}

const SOFTENING: [(f64, f64); 4] = [(-0.1, -30.0), (0.0, 0.0), (0.02, 4.0), (1.0, 53.0)];
/// Rises to 3 N at 10 mm, falls to -2 N at 30 mm, and rises again.
const SNAPS: [(f64, f64); 4] = [(-0.1, -30.0), (0.01, 3.0), (0.03, -2.0), (0.08, 13.0)];

#[test]
fn closed_form_lines_that_rise_bear_loads_at_their_own_places() {
    for (force, place) in [(-6.0, -0.02), (2.0, 0.01), (4.0, 0.02), (9.0, 0.12), (103.0, 2.0)] {
        let found = places(&loaded(1, vec![lines("s", &[(0, 1.0)], &SOFTENING)], &[force]));
        assert!((found[0] - place).abs() < ROUNDING, "{force}: {found:?} {place}");
    }
    // Two springs in series carry the same force; a stop holds the second body.
    let springs = vec![
        lines("a", &[(0, 1.0)], &SOFTENING),
        lines("b", &[(0, -1.0), (1, 1.0)], &[(0.0, 0.0), (0.01, 5.0), (0.02, 5.0), (0.03, 25.0)]),
    ];
    let mut d = loaded(2, springs, &[0.0, 9.0]);
    let found = places(&d);
    assert!((found[0] - 0.12).abs() < ROUNDING && (found[1] - 0.142).abs() < ROUNDING, "{found:?}");
    d.stops = vec![rigid("s", &[(1, 1.0)], 0.025, 0.5)];
    let found = places(&d);
    // 200 e equals 500 (0.025 - e).
    let held = 500.0 * 0.025 / 700.0;
    assert!(held < 0.02 && (found[1] - 0.025).abs() < ROUNDING, "{found:?}");
    assert!((found[0] - held).abs() < ROUNDING, "{found:?} {held}");
}

#[test]
fn closed_form_a_spring_that_falls_is_reached_up_to_its_peak() {
    for force in [-20.0, 0.0, 1.0, 2.9] {
        let found = places(&loaded(1, vec![lines("snap", &[(0, 1.0)], &SNAPS)], &[force]));
        assert!((found[0] - force / 300.0).abs() < ROUNDING, "{force}: {found:?}");
    }
    let (spring, factor) = gives_way(&loaded(1, vec![lines("snap", &[(0, 1.0)], &SNAPS)], &[4.0]));
    assert_eq!(spring, "snap");
    assert!((factor - 0.75).abs() < ROUNDING, "{factor}");
    // The machine starts on the falling line, so that the spring gives way at the factor 0.
    let hump = [(-0.2, -3.0), (-0.1, 1.0), (0.1, -1.0), (0.2, 3.0)];
    let (spring, factor) = gives_way(&loaded(1, vec![lines("hump", &[(0, 1.0)], &hump)], &[0.1]));
    assert_eq!((spring.as_str(), factor), ("hump", 0.0));
    let said =
        Assembly::new(loaded(1, vec![lines("hump", &[(0, 1.0)], &hump)], &[0.1])).unwrap_err().to_string();
    assert!(
        said.starts_with("start = \"rest\": spring.hump has a falling force and gives way without any load;"),
        "{said}"
    );
}

/// In parallel with a spring stiffer than the falling line, the total force rises everywhere, so
/// that the state of rest is found on the falling line too.
#[test]
fn closed_form_a_falling_spring_beside_a_stiffer_one_is_followed_through() {
    let beside = |force: f64| {
        let springs = vec![
            lines("snap", &[(0, 1.0)], &SNAPS),
            Spring { name: "mount".into(), ..spring(&[(0, 1.0)], 400.0, 0.0) },
        ];
        loaded(1, springs, &[force])
    };
    for (force, place) in [(3.5, 0.005), (7.0, 0.01), (8.5, 0.02), (10.0, 0.03), (17.0, 0.04)] {
        let found = places(&beside(force));
        assert!((found[0] - place).abs() < ROUNDING, "{force}: {found:?} {place}");
    }
    // In series, the stiffer spring does not help: the other spring gives way at its peak.
    let springs = vec![
        Spring { name: "mount".into(), ..spring(&[(0, 1.0)], 400.0, 0.0) },
        lines("snap", &[(0, -1.0), (1, 1.0)], &SNAPS),
    ];
    let mut d = loaded(2, springs, &[0.0, 6.0]);
    assert_eq!(gives_way(&d).0, "snap");
    assert!((gives_way(&d).1 - 0.5).abs() < ROUNDING);
    // A stop that closes earlier carries the remaining load.
    d.stops = vec![rigid("stop", &[(1, 1.0)], 0.01, 0.5)];
    let found = places(&d);
    let first = 300.0 * 0.01 / 700.0;
    assert!((found[0] - first).abs() < ROUNDING && (found[1] - 0.01).abs() < ROUNDING, "{found:?}");
    d.stops = vec![compliant("pad", &[(1, 1.0)], 0.01, 1e4, 0.0, DampingLimit::NoPull)];
    let found = places(&d);
    let left = 6.0 - 1e4 * (found[1] - 0.01) - 300.0 * (found[1] - found[0]);
    assert!(left.abs() < 1e4 * ROUNDING && (400.0 * found[0] - 300.0 * (found[1] - found[0])).abs() < 1e-9);
}

/// Derivatives of a start at rest on a falling line, with respect to every number.
#[test]
fn second_method_derivatives_of_a_start_at_rest() {
    let springs = vec![
        lines("snap", &[(0, 1.0)], &SNAPS),
        Spring { name: "mount".into(), damping: 0.3, ..spring(&[(0, 1.0)], 400.0, 0.0) },
    ];
    let mut d = loaded(1, springs, &[8.5]);
    d.loads[0].force.harmonics = vec![Harmonic { amplitude: 3.0, frequency: 2.0, phase: 0.0 }];
    let (names, met) = differences::compare(&d, 1.3);
    assert!(names.len() > 10 && met > 3, "{met} {names:?}");
}
