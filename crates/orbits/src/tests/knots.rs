//! Orbits under signals with steps and knots.

use super::*;
use nalgebra::{Matrix2, Vector2};
use vibro_machine::{Motion, Start};

/// Tolerance for a state of size one.
const ROUNDING: f64 = 1e-12;

/// A mass of 1 on a stiffness of 1 under ±0.3, which changes sign twice per period.
fn square(period: f64, rest: &str) -> Machine {
    machine(&format!(
        "name = \"Square\"\nbody.a = {{ mass = 1.0 }}\nspring.k = {{ between = [\"ground\", \"a\"], stiffness = 1.0, damping = 0.1 }}\n\
         load.p = {{ on = \"a\", constant = 0.3, steps = [[{}, -0.6]], repeat = {period} }}\n{rest}",
        0.5 * period
    ))
}

/// The state returns with the opposite sign after half a period: (1 + E) z₀ = (E - 1) p with E =
/// exp(A T/2) and the rest state p under the force.
#[test]
fn closed_form_an_oscillator_under_a_square_wave() {
    let period = 7.0_f64;
    let orbit = Orbit::settled(&square(period, ""), &Start::default(), 400).unwrap();
    assert!(orbit.word().is_empty() && orbit.is_certified());
    let half = (Matrix2::new(0.0, 1.0, -1.0, -0.1) * (0.5 * period)).exp();
    let p = Vector2::new(0.3, 0.0);
    let z = (Matrix2::identity() + half).try_inverse().unwrap() * (half - Matrix2::identity()) * p;
    let turns = orbit.legs()[0].time / period;
    assert!((turns - turns.round()).abs() < ROUNDING, "{turns}");
    assert!((orbit.state()[0] - z[0]).abs() < ROUNDING && (orbit.state()[1] - z[1]).abs() < ROUNDING);
    let exact = (-0.05 * period).exp();
    assert!(orbit.multipliers().iter().all(|mu| (mu.norm() - exact).abs() < ROUNDING));
    let largest = orbit.measure(&"maximum.a.s".parse().unwrap()).unwrap();
    let mut motion = Motion::from_state(orbit.place().assembly.clone(), 0.0, z.as_slice()).unwrap();
    let sampled = (1..2000).map(|k| {
        motion.advance_to(f64::from(k) * period / 2000.0).unwrap();
        motion.coordinate(0)
    });
    let sampled = sampled.fold(0.0, f64::max);
    assert!(largest >= sampled && largest - sampled < 1e-5, "{largest} {sampled}");
}

const STOP: &str = "stop.wall = { between = [\"ground\", \"a\"], gap = 0.3, restitution = 0.6 }\n";

/// Orbits along a branch are the orbits on which motions settle, whether forces or knot times
/// change; each is the machine's own motion.
#[test]
fn second_method_impacts_under_a_square_wave() {
    for (parameter, range) in [("load.p.constant", (0.25, 0.35)), ("load.p.repeat", (6.5, 7.5))] {
        let family = Family::new(&square(7.0, STOP), parameter, range).unwrap();
        let orbit = Orbit::settled(&family.machine, &Start::default(), 400).unwrap();
        let branch = branch(&family, &orbit, &Default::default()).unwrap();
        assert!(branch.points.len() > 4, "{parameter}: {}", branch.points.len());
        for point in branch.points.iter().step_by(3) {
            let orbit = branch.orbit(point).unwrap();
            let apart = orbit.check_by_motion().unwrap();
            assert!(apart < 1e-10, "{parameter} {}: {apart}", point.value);
        }
        for value in [0.3, 0.7].map(|part| range.0 + part * (range.1 - range.0)) {
            let settled = Orbit::settled_at(&family, value, &Start::default(), 400).unwrap();
            assert!(branch.passes(&settled), "{parameter} {value}");
        }
    }
}

/// A sine as a record of 256 knots has an error of at most 1e-4 of its size, and so do the special
/// points of its orbits.
#[test]
fn second_method_a_recorded_sine_has_the_branches_of_the_sine() {
    let text = |signal: &str| {
        format!(
            "name = \"Wall\"\nbody.a = {{ mass = 1.0 }}\nspring.k = {{ between = [\"ground\", \"a\"], stiffness = 1.0, damping = 0.04 }}\n\
             stop.wall = {{ between = [\"ground\", \"a\"], gap = \"= gap\", restitution = 0.9 }}\n[parameters]\ngap = 1.0\n[load.p]\non = \"a\"\n{signal}"
        )
    };
    let (omega, count) = (0.8_f64, 256);
    let period = std::f64::consts::TAU / omega;
    let knot = |k: usize| {
        let part = k as f64 / count as f64;
        format!("[{:?}, {:?}]", period * part, (std::f64::consts::TAU * part).cos())
    };
    let knots: Vec<String> = (0..count).map(knot).collect();
    let signals = [
        format!(
            "amplitude = 0.45\nfrequency = {:?}\nphase = {:?}\n",
            1.0 / period,
            0.5 * std::f64::consts::PI
        ),
        format!(
            "table = [{}]\nscale = 0.45\ninterpolation = \"cubic\"\nrepeat = {period:?}\n",
            knots.join(", ")
        ),
    ];
    let found = signals.map(|signal| {
        let family = Family::new(&machine(&text(&signal)), "gap", (0.9, 1.1)).unwrap();
        let orbit = Orbit::settled(&family.machine, &Start::default(), 1000).unwrap();
        let branch = branch(&family, &orbit, &Default::default()).unwrap();
        let special = branch.points.iter().filter_map(|p| Some((p.special.as_ref()?.label.name(), p.value)));
        special.collect::<Vec<_>>()
    });
    assert!(found[0].len() > 1 && found[0].len() == found[1].len(), "{found:?}");
    for (one, other) in found[0].iter().zip(&found[1]) {
        assert!(one.0 == other.0 && (one.1 - other.1).abs() < 1e-3, "{found:?}");
    }
}

/// Relative tolerance for a branch's end against the closed form: rounding.
const CORNER: f64 = 1e-12;

/// A ball on a table with the acceleration ±a, each for half of the period 0.2 s, under g = 10.
fn bouncing(restitution: f64, a: f64) -> Machine {
    machine(&format!(
        "name = \"Table\"\ngravity = 10.0\nparameters = {{ a = {a} }}\n\
         body.ball = {{ mass = 0.05, gravity = -1.0, start = {{ s = 0.05 }} }}\n\
         body.table = {{ motion = {{ acceleration = {{ table = [[0.0, 1.0], [0.1, -1.0]], interpolation = \"hold\", \
         repeat = 0.2, scale = \"= a\" }}, v = \"= 0 - a*0.2/4\" }} }}\n\
         stop.floor = {{ between = [\"ball\", \"table\"], gap = 0.0, restitution = {restitution} }}\n"
    ))
}

/// One impact per period at the table's speed w requires w = g T (1 - e) / (2 (1 + e)). The speed
/// is at most aT/4, at the knot. The orbits with the impact before and after it therefore end at a
/// = 2 g (1 - e) / (1 + e), without crossing.
#[test]
fn closed_form_branches_end_where_their_impact_meets_a_knot() {
    for restitution in [0.4, 0.5, 0.6] {
        let end = 20.0 * (1.0 - restitution) / (1.0 + restitution);
        let family = Family::new(&bouncing(restitution, 1.2 * end), "a", (0.9 * end, 1.4 * end)).unwrap();
        let place = family.place(end).unwrap();
        let is_own =
            |b: &Branch| b.word().in_words(&place.assembly) == "impact floor" && b.word().periods == Some(1);
        let branches: Vec<Branch> = grown(&family, 3, 0).into_iter().filter(is_own).collect();
        let alone = branch(
            &family,
            &Orbit::settled(&family.machine, &Start::default(), 400).unwrap(),
            &Default::default(),
        );
        assert_eq!(branches.len(), 2, "{restitution}");
        for own in branches.iter().chain([&alone.unwrap()]) {
            let ends = [&own.points[0], &own.points[own.points.len() - 1]];
            let corner = ends.iter().find(|p| p.special.as_ref().unwrap().label.name() == "CC");
            let (value, special) = corner.map(|p| (p.value, p.special.clone().unwrap())).unwrap();
            assert!((value / end - 1.0).abs() < CORNER, "{restitution}: {value} {end}");
            assert_eq!(special.element, "stop.floor body.table");
            assert!(
                own.points
                    .iter()
                    .all(|p| p.value > end * (1.0 - CORNER) && p.label() != Some(crate::Label::BranchPoint))
            );
            for point in own.points.iter().filter(|p| p.special.is_none()).step_by(5) {
                own.orbit(point).unwrap().check_by_motion().unwrap();
            }
        }
        // The impact is before the knot on one branch; on the other, unstable one it is after it.
        let halves = |own: &Branch| {
            let middle = own.orbit(&own.points[own.points.len() / 2]).unwrap();
            (middle.times()[0] / 0.1).floor() as i64 % 2
        };
        assert_ne!(halves(&branches[0]), halves(&branches[1]), "{restitution}");
        let plain = branches[1].points.iter().filter(|p| p.special.is_none());
        assert!(plain.map(|p| p.stability).all(|own| own == Stability::Unstable), "{restitution}");
    }
}
