//! Orbits over knots at which a stiffness or a contact changes.

use super::*;
use nalgebra::{Matrix2, Vector2};
use vibro_machine::mode::Contact;
use vibro_machine::{Motion, Start};

/// Tolerance for numbers of size one over a period.
const ROUNDING: f64 = 1e-11;
/// Tolerance for a special point against its closed form, in the parameter's unit: rounding,
/// magnified by a double multiplier.
const SPECIAL: f64 = 1e-9;

/// A mass of 1 under a constant force, on a spring with the stiffness 3 for half a period and
/// `low` for the other half, with a dashpot.
pub(super) fn meissner(low: f64, damping: f64, period: f64) -> Machine {
    machine(&format!(
        "name = \"Meissner\"\nbody.a = {{ mass = 1.0 }}\n\
         spring.k = {{ between = [\"ground\", \"a\"], damping = {damping}, \
         stiffness = {{ constant = 3.0, steps = [[{}, \"= low - 3\"]], repeat = {period} }} }}\n\
         load.p = {{ on = \"a\", constant = 0.2 }}\n[parameters]\nlow = {low}\n",
        0.5 * period
    ))
}

/// exp(A T/2) and the rest state under the force 0.2.
fn half(stiffness: f64, damping: f64, period: f64) -> (Matrix2<f64>, Vector2<f64>) {
    let e = (Matrix2::new(0.0, 1.0, -stiffness, -damping) * (0.5 * period)).exp();
    (e, Vector2::new(0.2 / stiffness, 0.0))
}

#[test]
fn closed_form_an_oscillator_whose_stiffness_steps() {
    let (low, damping, period) = (1.0, 0.1, 3.0);
    let orbit = Orbit::settled(&meissner(low, damping, period), &Start::default(), 800).unwrap();
    assert_eq!(orbit.word().in_words(&orbit.place().assembly), "step k ×2");
    assert!(orbit.is_certified(), "{:?}", orbit.violation());
    assert!(orbit.check_by_motion().unwrap() < ROUNDING);
    let [(high, at), (weak, rest)] = [3.0, low].map(|k| half(k, damping, period));
    let begins_high = (orbit.times()[0] / period).fract() == 0.0;
    let [(first, p), (second, q)] =
        if begins_high { [(high, at), (weak, rest)] } else { [(weak, rest), (high, at)] };
    let matrix = second * first;
    // z = q + E₂ (p + E₁ (z - p) - q)
    let constant = q + second * (p - first * p - q);
    let z = (Matrix2::identity() - matrix).try_inverse().unwrap() * constant;
    assert!((orbit.state()[0] - z[0]).abs() < ROUNDING && (orbit.state()[1] - z[1]).abs() < ROUNDING);
    let own = matrix.complex_eigenvalues();
    assert!(orbit.multipliers().iter().all(|mu| own.iter().any(|own| (mu - own).norm() < ROUNDING)));
}

/// 1 + trace + det of the map of Meissner's oscillator over a period: zero if a multiplier is -1.
pub(super) fn meissners_test(low: f64, damping: f64, period: f64) -> f64 {
    let matrix = half(low, damping, period).0 * half(3.0, damping, period).0;
    1.0 + matrix.trace() + matrix.determinant()
}

/// Fixed times repeat whether or not the state returns: an orbit repeated three times is the orbit
/// itself, and a motion that returns only after three passes keeps its word of three.
#[test]
fn invariant_a_word_of_fixed_times_is_as_short_as_its_state_returns() {
    let orbit = Orbit::settled(&meissner(1.0, 0.1, 3.0), &Start::default(), 800).unwrap();
    let (thrice, u) = orbit.problem.repeated(&orbit.place, &orbit.u, 3).unwrap();
    let (once, at) = thrice.reduced(&u).unwrap();
    assert_eq!((thrice.word.len(), once.word.len()), (6, 2));
    assert!((at - &orbit.u).norm() < ROUNDING);
    let mut moved = u.clone();
    moved[0] += 1e-3;
    let (own, at) = thrice.reduced(&moved).unwrap();
    assert_eq!((own.word.len(), at), (6, moved));
}

/// The trace of the product of two matrices of cosines is -2 at the boundary of instability of
/// Meissner's equation; with a dashpot a multiplier is -1 where trace + det = -1.
#[test]
fn closed_form_the_boundary_of_meissners_equation() {
    let (damping, period) = (0.02, 3.0);
    let test = |low: f64| meissners_test(low, damping, period);
    let (mut from, mut to) = (1.5, 0.4);
    assert!(test(from) * test(to) < 0.0, "{} {}", test(from), test(to));
    while f64::abs(from - to) > 1e-13 {
        let middle = 0.5 * (from + to);
        if test(middle) * test(from) > 0.0 { from = middle } else { to = middle }
    }
    let family = Family::new(&meissner(1.5, damping, period), "low", (0.4, 1.6)).unwrap();
    let orbit = Orbit::settled(&family.machine, &Start::default(), 2000).unwrap();
    let found = branch(&family, &orbit, &Default::default()).unwrap();
    let own = specials(&[found], 2, "PD");
    assert!(nearest(&own, from) < SPECIAL, "{own:?} {from}");
}

#[test]
fn second_method_a_gear_mesh_has_the_orbit_and_multipliers_of_its_motion() {
    let orbit = Orbit::settled(&example("gear_mesh.toml"), &Start::default(), 800).unwrap();
    let words = orbit.word().in_words(&orbit.place().assembly);
    assert!(words.contains("step drive_flank"), "{words}");
    assert!(orbit.is_certified(), "{:?}", orbit.violation());
    assert!(orbit.check_by_motion().unwrap() < ROUNDING * orbit.period());
    let own = moduli_by_motion(&orbit);
    for mu in orbit.multipliers() {
        assert!(own.iter().any(|own| (own - mu.norm()).abs() < 1e-7), "{:?} {own:?}", orbit.multipliers());
    }
}

/// A mass on Coulomb friction under a force ±P that changes sign twice per period. P exceeds the
/// friction force F only for part of each half; then the force falls to a value below F.
fn slider(push: f64) -> Machine {
    machine(&format!(
        "name = \"Slider\"\nbody.a = {{ mass = 2.0 }}\nspring.k = {{ between = [\"ground\", \"a\"], stiffness = 0.0, damping = 0.0 }}\n\
         friction.f = {{ between = [\"ground\", \"a\"], force = 1.0 }}\n\
         load.p = {{ on = \"a\", steps = [[0.0, {push}], [0.2, {}], [1.0, {}], [1.2, {}]], repeat = 2.0 }}\n",
        0.5 - push,
        -0.5 - push,
        push - 0.5,
    ))
}

/// Each push lasts 0.2 s and produces the velocity 0.2 (P - F)/m, which friction removes at the
/// rate (F - 0.5)/m. The displacement is half the velocity times the sum of both durations.
#[test]
fn closed_form_a_square_wave_moves_a_slider_that_sticks_in_between() {
    let push = 1.6;
    let orbit = Orbit::settled(&slider(push), &Start::default(), 20).unwrap();
    let words = orbit.word().in_words(&orbit.place().assembly);
    assert_eq!(words, "step p + slip f, stick f, step p + slip f, stick f");
    assert!(orbit.is_certified(), "{:?}", orbit.violation());
    assert!(orbit.check_by_motion().unwrap() < ROUNDING);
    let rate = 0.2 * (push - 1.0) / 2.0;
    let stops = rate / (0.5 / 2.0);
    for (k, time) in orbit.times().iter().enumerate() {
        let exact = if k % 2 == 0 { 0.0 } else { 0.2 + stops };
        assert!((time % 1.0 - exact).abs() < ROUNDING, "{:?}", orbit.times());
    }
    // At each step, the push exceeds the friction force by this fraction of their sum.
    let beyond = orbit.conditions().iter().filter_map(|(condition, value)| match condition {
        Condition::Changes { contact: Contact::Friction(0), .. } => Some(*value),
        _ => None,
    });
    let beyond: Vec<f64> = beyond.collect();
    assert!(beyond.len() >= 2 && beyond.iter().all(|x| (x - (push - 1.0) / (push + 1.0)).abs() < ROUNDING));
    let way = orbit.measure(&"peak_to_peak.a.s".parse().unwrap()).unwrap();
    assert!((way - 0.5 * rate * (0.2 + stops)).abs() < ROUNDING, "{way}");
    assert!(Motion::from_state(orbit.place().assembly.clone(), 0.1, orbit.state()).is_ok());
}

/// Tolerance for difference quotients of the equations: a stiff mesh magnifies rounding over a
/// period.
const COLUMN: f64 = 1e-5;

#[test]
fn second_method_columns_by_stiffness_and_times_of_steps_are_those_of_differences() {
    let mesh = example("gear_mesh.toml");
    let orbit = Orbit::settled(&mesh, &Start::default(), 800).unwrap();
    for by in [
        ("stop.drive_flank.stiffness.constant", 2e7),
        ("stop.drive_flank.stiffness.steps[0].time", 5e-5),
        ("stop.drive_flank.stiffness.repeat", 5e-5),
        ("load.engine.constant", 10.0),
    ] {
        let apart = column_apart(&mesh, &orbit, by);
        assert!(apart < COLUMN, "{}: {apart:e}", by.0);
    }
    let slider = slider(1.6);
    let orbit = Orbit::settled(&slider, &Start::default(), 20).unwrap();
    for by in [("friction.f.force", 0.1), ("load.p.steps[0].height", 0.1), ("load.p.steps[1].time", 0.1)] {
        let apart = column_apart(&slider, &orbit, by);
        assert!(apart < COLUMN, "{}: {apart:e}", by.0);
    }
}

/// Distance from P = F within which the vanishing slip rate is only rounding.
const VANISHES: f64 = 1e-6;

/// The slider slips at the step if its push exceeds the friction: up to P = F it does not move.
#[test]
fn closed_form_a_branch_ends_where_a_step_ceases_to_make_a_friction_slip() {
    let text = |push: &str| {
        format!(
            "name = \"Slider\"\nbody.a = {{ mass = 2.0 }}\nfriction.f = {{ between = [\"ground\", \"a\"], force = 1.0 }}\n\
             load.p = {{ on = \"a\", steps = [[0.0, \"= push\"], [0.2, \"= -push\"], [1.0, \"= -push\"], [1.2, \"= push\"]], repeat = 2.0 }}\n\
             [parameters]\npush = {push}\n"
        )
    };
    let family = Family::new(&machine(&text("1.5")), "push", (0.5, 2.0)).unwrap();
    let orbit = Orbit::settled(&family.machine, &Start::default(), 20).unwrap();
    assert_eq!(
        orbit.word().in_words(&orbit.place().assembly),
        "step p + slip f, stick f, step p + slip f, stick f"
    );
    let found = branch(&family, &orbit, &Default::default()).unwrap();
    let end = found.points.iter().min_by(|a, b| a.value.total_cmp(&b.value)).unwrap();
    let special = end.special.as_ref().unwrap();
    assert_eq!((special.label.name(), special.element.as_str()), ("ST", "friction.f"));
    assert!((end.value - 1.0).abs() < VANISHES, "{}", end.value);
}

#[test]
fn second_method_branches_over_a_gear_mesh_are_motions_at_any_step() {
    let family = Family::new(&example("gear_mesh.toml"), "load.engine.constant", (40.0, 70.0)).unwrap();
    let orbit = Orbit::settled(&family.machine, &Start::default(), 800).unwrap();
    let values = [1.0, 0.5].map(|part| {
        let mut options = crate::path_options::PathOptions::default();
        options.longest_step *= part;
        let found = branch(&family, &orbit, &options).unwrap();
        for point in found.points.iter().filter(|p| p.special.is_none()).step_by(4) {
            let apart = found.orbit(point).unwrap().check_by_motion().unwrap();
            assert!(apart < ROUNDING * point.period, "{}: {apart}", point.value);
        }
        found
            .points
            .iter()
            .filter_map(|p| Some((p.special.as_ref()?.label.name(), p.value)))
            .collect::<Vec<_>>()
    });
    assert!(values[0].len() >= 2 && values[0].len() == values[1].len(), "{values:?}");
    for (one, other) in values[0].iter().zip(&values[1]) {
        assert!(one.0 == other.0 && (one.1 - other.1).abs() < 1e-6, "{values:?}");
    }
}

/// A force that lifts a mass off the floor for 0.3 s; its bounces accumulate before the next lift.
const LIFTED: &str = "name = \"Lifted\"\nbody.a = { mass = 1.0 }\n\
    stop.floor = { between = [\"ground\", \"a\"], gap = 0.0, restitution = 0.5 }\n\
    load.p = { on = \"a\", constant = 2.0, steps = [[1.0, -5.0], [1.3, 5.0]], repeat = 4.0 }\n";

#[test]
fn closed_form_a_step_lifts_a_mass_from_its_stop() {
    let machine = machine(LIFTED);
    let orbit = Orbit::settled(&machine, &Start::default(), 20).unwrap();
    let words = orbit.word().in_words(&orbit.place().assembly);
    assert_eq!(words, "step p + open floor, impact floor + chatter floor");
    assert!(orbit.is_certified(), "{:?}", orbit.violation());
    assert!(orbit.check_by_motion().unwrap() < ROUNDING);
    assert!(orbit.spectral_radius() < ROUNDING);
    // Velocity -0.9 and displacement -0.135 when the force is 2 again.
    let (rate, place) = (0.9_f64, 0.135_f64);
    let speed = (rate * rate + 4.0 * place).sqrt();
    let lands = 1.3 + (rate + speed) / 2.0;
    assert!((orbit.times()[0] - 1.0).abs() < ROUNDING && (orbit.times()[1] - lands).abs() < ROUNDING);
    // Bounces with speeds e v, e² v, … at the acceleration 2 last e v/(1 - e) in total.
    let rests = lands + speed;
    let family = Family::new(&machine, "load.p.repeat", (2.2, 4.5)).unwrap();
    let found = branch(&family, &orbit, &Default::default()).unwrap();
    let end = found.points.iter().min_by(|a, b| a.value.total_cmp(&b.value)).unwrap();
    assert_eq!(end.special.as_ref().unwrap().label.name(), "CH");
    assert!((end.value - (rests - 1.0)).abs() < RESTS, "{} {}", end.value, rests - 1.0);
}

/// Bounces below a smallest height count as rest, so rest begins earlier by about this time.
const RESTS: f64 = 5e-6;

#[test]
fn closed_form_meissners_boundary_over_stiffness_and_damping() {
    let (damping, period) = (0.02, 3.0);
    let machine = meissner(1.5, damping, period);
    let family = Family::new(&machine, "low", (0.4, 1.6)).unwrap();
    let orbit = Orbit::settled(&machine, &Start::default(), 2000).unwrap();
    let found = branch(&family, &orbit, &Default::default()).unwrap();
    let is_own = |k: &usize| found.points[*k].special.as_ref().is_some_and(|s| s.label.name() == "PD");
    let start = (0..found.points.len()).find(is_own).and_then(|k| found.locus_start(k)).unwrap();
    let second = Family::new(&machine, "spring.k.damping", (0.01, 0.05)).unwrap();
    let points = locus(&start, &second).unwrap();
    assert!(points.len() > 4, "{points:?}");
    for point in points {
        let [low, damping] = point.values;
        let matrix = half(low, damping, period).0 * half(3.0, damping, period).0;
        let test = 1.0 + matrix.trace() + matrix.determinant();
        assert!(test.abs() < SPECIAL, "{point:?} {test:e}");
    }
}
