//! Events of several contacts at one instant.

use super::*;
use vibro_machine::Start;

/// Relative tolerance for the common end of two branches: rounding of a condition.
const ROUNDING: f64 = 1e-11;
/// Number of branch points from one comparison with the machine's own motion to the next.
const EACH: usize = 7;

/// A body on a belt, with more static than sliding friction, in front of a compliant stop.
fn pressed() -> Machine {
    machine(
        "name = \"Belt\"\nbody.a = { mass = 1.0, start = { v = 0.1 } }\n\
         body.belt = { motion = { rate = 0.1 } }\n\
         spring.k = { between = [\"ground\", \"a\"], stiffness = 100.0, damping = 0.5 }\n\
         friction.g = { between = [\"belt\", \"a\"], force = 0.8, static = 1.4 }\n\
         stop.w = { between = [\"ground\", \"a\"], gap = 0.012, stiffness = 20.0, damping = 3.0 }\n\
         load.f = { on = \"a\", amplitude = 0.8, frequency = 1.2 }\n",
    )
}

/// Two bodies with two friction elements; one slips while the other sticks.
fn rubbed() -> Machine {
    machine(
        "name = \"Two\"\nbody.a = { mass = 1.0 }\nbody.b = { mass = 0.5 }\n\
         spring.k = { between = [\"ground\", \"a\"], stiffness = 100.0, damping = 0.4 }\n\
         spring.c = { between = [\"a\", \"b\"], stiffness = 80.0, damping = 0.2 }\n\
         friction.g = { between = [\"ground\", \"b\"], force = 0.5, static = 0.8 }\n\
         friction.h = { between = [\"a\", \"b\"], force = 0.4, static = 0.5 }\n\
         load.f = { on = \"a\", amplitude = 2.0, frequency = 1.3, constant = 0.2 }\n",
    )
}

#[test]
fn second_method_orbits_whose_friction_slips_with_another_event_are_motions_of_the_machine() {
    for (m, vary, (from, to), word) in [
        (pressed(), "stop.w.gap", (0.005, 0.02), "press w + slip g, free w, stick g"),
        (
            rubbed(),
            "load.f.amplitude",
            (0.5, 1.2),
            "slip g, stick h, stick g + slip h, slip g, stick h, stick g + slip h",
        ),
    ] {
        let family = Family::new(&m, vary, (from, to)).unwrap();
        let branches = grown(&family, 8, 1);
        let said = |branch: &Branch| {
            let place = family.place(branch.points[0].value).unwrap();
            branch.word().in_words(&place.assembly)
        };
        for branch in &branches {
            for point in branch.points.iter().step_by(EACH).filter(|point| point.special.is_none()) {
                branch.orbit(point).unwrap().check_by_motion().unwrap();
            }
        }
        // The word's branch begins and ends where other branches do.
        let own = branches.iter().find(|branch| said(branch) == word).unwrap();
        for end in [&own.points[0], own.points.last().unwrap()] {
            let others = branches.iter().filter(|branch| said(branch) != word);
            let ends =
                others.flat_map(|branch| [branch.points[0].value, branch.points.last().unwrap().value]);
            let apart = ends.map(|value| (value / end.value - 1.0).abs()).fold(f64::INFINITY, f64::min);
            assert!(apart < ROUNDING, "{vary} = {}: {apart}", end.value);
        }
    }
}

#[test]
fn invariant_words_that_the_machine_has_on_neither_side_of_a_point_are_no_branches() {
    let m = machine(
        "name = \"Pair\"\nbody.a = { mass = 1.0 }\nbody.b = { mass = 0.4 }\n\
         spring.k = { between = [\"ground\", \"a\"], stiffness = 100.0, damping = 1.0 }\n\
         spring.c = { between = [\"a\", \"b\"], stiffness = 30.0, damping = 0.3 }\n\
         stop.r = { between = [\"a\", \"b\"], gap = 0.01, restitution = 0.6 }\n\
         stop.l = { between = [\"ground\", \"b\"], gap = 0.03, stiffness = 900.0, damping = 1.0, law = \"undamped-rebound\" }\n\
         load.f = { on = \"a\", amplitude = 1.5, frequency = 2.0 }\n",
    );
    let family = Family::new(&m, "load.f.frequency", (1.5, 1.7)).unwrap();
    let branches = grown(&family, 6, 1);
    let crossings = branches.iter().flat_map(|branch| &branch.points).filter_map(|p| p.special.as_ref());
    assert!(crossings.filter(|special| special.label == Label::Crossing).count() > 0);
    branches.iter().for_each(|branch| assert!(branch.points.len() > 1, "{}", branch.id));
}

#[test]
fn second_method_an_orbit_that_just_makes_its_slider_slip_is_undecided() {
    // Nearby, the slider sticks at another position and stays there.
    let m = machine(
        "name = \"Shakedown\"\nbody.a = { mass = 1.0 }\nbody.b = { mass = 0.5 }\n\
         spring.k = { between = [\"ground\", \"a\"], stiffness = 100.0, damping = 0.5 }\n\
         spring.j = { between = [\"a\", \"b\"], stiffness = 300.0, slip = 1.0 }\n\
         spring.c = { between = [\"ground\", \"b\"], stiffness = 50.0, damping = 0.4 }\n\
         load.f = { on = \"a\", amplitude = 3.0, frequency = 1.0625, constant = 0.5 }\n",
    );
    let orbit = Orbit::settled(&m, &Start::default(), 500).unwrap();
    assert_eq!(orbit.stability(), Stability::Undecided, "{}", orbit.word().len());
}

#[test]
fn closed_form_curve_on_which_a_slider_begins_to_slip() {
    // The stuck amplitude F k / |K + k - m ω² + i c ω| of the slider's force is its slip force.
    let m = machine(
        "name = \"Jenkins\"\nbody.a = { mass = 1.0 }\n\
         spring.k = { between = [\"ground\", \"a\"], stiffness = 100.0, damping = 0.3 }\n\
         spring.j = { between = [\"ground\", \"a\"], stiffness = 200.0, slip = 1.0 }\n\
         load.f = { on = \"a\", amplitude = 3.0, frequency = 3.0 }\n",
    );
    let family = Family::new(&m, "load.f.frequency", (3.0, 6.0)).unwrap();
    let branches = grown(&family, 6, 0);
    let force = |frequency: f64| {
        let omega = std::f64::consts::TAU * frequency;
        600.0 / (300.0 - omega * omega).hypot(0.3 * omega)
    };
    let of = |branch: &Branch| (0..branch.points.len()).filter_map(|k| branch.locus_start(k)).next();
    let (branch, start) = branches.iter().find_map(|branch| Some((branch, of(branch)?))).unwrap();
    assert_eq!((start.special.label, start.special.element.as_str()), (Label::Stick, "spring.j"));
    let at = branch.points.iter().find(|point| point.special.as_ref() == Some(&start.special)).unwrap();
    assert!((force(at.value) - 1.0).abs() < ROUNDING, "{} {}", at.value, force(at.value));
    let curve = locus(&start, &Family::new(&m, "spring.j.slip", (0.5, 2.0)).unwrap()).unwrap();
    assert!(curve.len() > 4);
    for point in curve {
        let [frequency, slip] = point.values;
        assert!((force(frequency) - slip).abs() < ROUNDING, "{frequency} {slip}");
    }
}

#[test]
fn second_method_columns_of_an_orbit_with_a_run_of_impacts_are_those_of_differences() {
    /// Relative tolerance for a difference over 2e-5 of a unit when the number of impacts jumps.
    const DIFFERENCES: f64 = 1e-6;
    const STEP: f64 = 1e-5;
    let m = machine(
        "name = \"Run\"\nbody.a = { mass = 1.0 }\nbody.b = { mass = 0.5 }\n\
         spring.k = { between = [\"ground\", \"a\"], stiffness = 100.0, damping = 1.0 }\n\
         friction.g = { between = [\"a\", \"b\"], force = 0.6, static = 0.8 }\n\
         stop.r = { between = [\"a\", \"b\"], gap = 0.01, restitution = 0.5 }\n\
         stop.l = { between = [\"b\", \"a\"], gap = 0.02, stiffness = 500.0, damping = 1.0 }\n\
         load.f = { on = \"a\", amplitude = 3.0, frequency = 1.5 }\n",
    );
    for (vary, (from, to)) in
        [("load.f.frequency", (1.0, 3.0)), ("load.f.amplitude", (2.0, 4.0)), ("stop.r.gap", (0.005, 0.02))]
    {
        let family = Family::new(&m, vary, (from, to)).unwrap();
        let orbit = Orbit::settled(&m, &Start::default(), 500).unwrap();
        assert!(orbit.word().has_run());
        let problem = Problem { family: Arc::new(family), ..orbit.problem.clone() };
        let u = problem.point(orbit.place(), &orbit.numbers, m.description.get(vary).unwrap());
        let matrix = problem.linearize(&u, None).unwrap().matrix;
        for k in 0..u.len() {
            let value = |by: f64| {
                let mut moved = u.clone();
                moved[k] += by;
                problem.residual(&problem.place(&moved).unwrap(), &moved, false).unwrap().value
            };
            let apart = (value(STEP) - value(-STEP)) / (2.0 * STEP) - matrix.column(k);
            assert!(apart.amax() < DIFFERENCES * matrix.column(k).amax(), "{vary}, column {k}: {apart}");
        }
    }
}

/// An event function of 6 N minus 2 N is half of its terms above zero, in any unit.
#[test]
fn closed_form_a_functional_is_told_relative_to_its_terms() {
    for unit in [1e-9, 1.0, 1e9] {
        assert!((crate::timed::beyond(&[2.0, -1.0], &[3.0 * unit, 2.0 * unit]) - 0.5).abs() < 1e-15);
    }
}
