//! Orbits against the machines' own motions.

use super::*;
use vibro_machine::Motion;
use vibro_machine::Start;

/// Largest difference of an event's time, in periods: rounding of a flight.
const TIME: f64 = 1e-11;
/// Perturbation of a state, relative to its units.
const PUSH: f64 = 1e-6;

#[test]
fn second_method_orbits_of_the_gallery_are_motions() {
    for (name, events) in [
        ("belt_friction.toml", 2),
        ("brake_squeal.toml", 2),
        ("damper_with_buffer.toml", 18),
        ("den_hartog.toml", 2),
        ("impact_on_spring.toml", 2),
        ("impact_pair.toml", 2),
        ("paper_machine.toml", 2),
        ("percussion_drill.toml", 19),
        ("vibratory_conveyor.toml", 3),
    ] {
        let orbit = Orbit::settled(&example(name), &Start::default(), 500).unwrap();
        assert_eq!(orbit.word().len(), events, "{name}");
        assert!(orbit.is_certified(), "{name}: {:?}", orbit.violation());
        let apart = orbit.check_by_motion().unwrap();
        assert!(apart < TIME * orbit.period(), "{name}: {apart} s");
    }
}

/// Distance of a perturbed motion from the orbit after some periods, in perturbations.
fn after_push(orbit: &Orbit, periods: u32) -> f64 {
    let own = 2 * orbit.place().assembly.system().coordinates;
    let (time, state) = orbit.middle_state();
    let pushed: Vec<f64> = state
        .iter()
        .zip(&orbit.problem.units.state)
        .enumerate()
        .map(|(i, (x, u))| x + PUSH * u * (1.0 + 0.1 * i as f64))
        .collect();
    let mut motion = Motion::from_state(orbit.place().assembly.clone(), time, &pushed).unwrap();
    motion.advance_to(time + f64::from(periods) * orbit.period()).unwrap();
    let apart = motion.state().iter().zip(&state).zip(&orbit.problem.units.state).take(own);
    apart.map(|((a, b), unit)| ((a - b) / unit).abs()).fold(0.0, f64::max) / PUSH
}

#[test]
fn second_method_pushed_motions_come_back_to_stable_orbits_and_leave_unstable_ones() {
    let family = Family::new(&example("paper_machine.toml"), "load.drive.amplitude", (0.19, 0.35)).unwrap();
    let (mut stable, mut unstable) = (0, 0);
    for branch in grown(&family, 6, 1) {
        for value in
            [0.192, 0.195, 0.2, 0.215, 0.22, 0.23, 0.235, 0.242, 0.26, 0.275, 0.285, 0.3, 0.32, 0.33, 0.34]
        {
            for orbit in branch.orbits_at(value) {
                // A perturbation grows or shrinks by a factor of about a thousand at most.
                let logarithm = orbit.spectral_radius().ln().abs();
                let periods = (7.0 / logarithm).ceil();
                if !(1.0..=200.0).contains(&periods) {
                    continue;
                }
                let apart = after_push(&orbit, periods as u32);
                match orbit.stability() {
                    Stability::Stable => {
                        assert!(apart < 0.2, "{value}: {apart} after {periods}");
                        stable += 1;
                    }
                    Stability::Unstable => {
                        assert!(apart > 5.0, "{value}: {apart} after {periods}");
                        unstable += 1;
                    }
                    other => panic!("{value}: {other}"),
                }
            }
        }
    }
    assert!(stable >= 20 && unstable >= 20, "{stable} {unstable}");
}

/// An accumulating run of impacts: a ball on a table that throws it once per period.
#[test]
fn second_method_orbits_with_runs_of_impacts_are_motions_and_are_followed() {
    let text = "name = \"Ball\"\ngravity = 10.0\nbody.ball = { mass = 1.0, gravity = -1.0 }\n\
        body.table = { motion = { amplitude = 0.03, frequency = \"20 rad/s\" } }\n\
        stop.floor = { between = [\"ball\", \"table\"], gap = 0.0, restitution = 0.6 }\n";
    let orbit = Orbit::settled(&machine(text), &Start::default(), 50).unwrap();
    let words = orbit.word().in_words(&orbit.place().assembly);
    assert_eq!(words, "open floor, impact floor + chatter floor");
    assert!(orbit.is_certified() && orbit.stability() == Stability::Stable);
    assert!(orbit.spectral_radius() < 1e-9);
    // The table's acceleration opens the stop: A ω² sin ωt = g.
    let opens = (10.0_f64 / (0.03 * 400.0)).asin() / 20.0;
    assert!((orbit.times()[0].rem_euclid(orbit.period()) - opens).abs() < 1e-12, "{:?}", orbit.times());
    let family = Family::new(&machine(text), "body.table.motion.amplitude", (0.026, 0.034)).unwrap();
    let found = branch(&family, &orbit, &Default::default()).unwrap();
    assert!(found.points.len() < 400, "{}", found.points.len());
}

/// Two equal oscillators with a stop each and the same drive.
const TWINS: &str = "name = \"Twins\"\nbody.a = { mass = 1.0 }\nbody.b = { mass = 1.0 }\n\
    spring.ga = { between = [\"ground\", \"a\"], stiffness = 100.0, damping = 0.4 }\n\
    spring.gb = { between = [\"ground\", \"b\"], stiffness = 100.0, damping = 0.4 }\n\
    spring.c = { between = [\"a\", \"b\"], stiffness = 40.0 }\n\
    stop.sa = { between = [\"ground\", \"a\"], gap = 0.03, restitution = 0.7 }\n\
    stop.sb = { between = [\"ground\", \"b\"], gap = 0.03, restitution = 0.7 }\n\
    load.la = { on = \"a\", amplitude = 10.0, frequency = 3.0 }\n\
    load.lb = { on = \"b\", amplitude = 10.0, frequency = 3.0 }\n";

#[test]
fn invariant_stops_hit_at_one_instant_are_undecided_and_end_their_branch() {
    let orbit = Orbit::settled(&machine(TWINS), &Start::default(), 300).unwrap();
    assert_eq!(orbit.word().in_words(&orbit.place().assembly), "impact sa + impact sb");
    assert_eq!(orbit.stability(), Stability::Undecided);
    let family = Family::new(&machine(TWINS), "load.la.amplitude", (8.0, 12.0)).unwrap();
    let found = branch(&family, &orbit, &Default::default()).unwrap();
    for end in [found.points.first(), found.points.last()] {
        let end = end.unwrap();
        assert_eq!(end.special.as_ref().map(|s| s.label), Some(Label::Crossing));
        assert!((end.value - 10.0).abs() < 1e-6, "{}", end.value);
    }
}

/// The ball rests on a floor for part of 13 periods; rounding would put it into the floor.
#[test]
fn second_method_an_orbit_that_rests_on_a_stop_with_gap_zero_is_found() {
    let text = "name = \"Rests\"\nbody.b = { mass = 1.0, start = { s = 0.02 } }\n\
        stop.f = { between = [\"b\", \"ground\"], gap = 0.0, restitution = 0.5 }\n\
        load.g = { on = \"b\", constant = -9.81, amplitude = 27.0, frequency = 25.0 }\n";
    let orbit = Orbit::settled(&machine(text), &Start::default(), 400).unwrap();
    assert_eq!(orbit.word().periods, Some(13));
    assert!(orbit.is_certified() && orbit.check_by_motion().unwrap() < TIME);
}

#[test]
fn invariant_a_branch_ends_where_the_parameters_values_end() {
    let text = "name = \"Hits\"\nbody.m = { mass = 1.0 }\n\
        spring.k = { between = [\"ground\", \"m\"], stiffness = 100.0, damping = 0.4 }\n\
        stop.s = { between = [\"ground\", \"m\"], gap = 0.05, restitution = 0.8 }\n\
        load.f = { on = \"m\", amplitude = 10.0, frequency = 3.0 }\n";
    let orbit = Orbit::settled(&machine(text), &Start::default(), 400).unwrap();
    let family = Family::new(&machine(text), "stop.s.restitution", (0.0, 1.0)).unwrap();
    let found = branch(&family, &orbit, &Default::default()).unwrap();
    for end in [found.points.first(), found.points.last()] {
        let end = end.unwrap();
        assert_eq!((end.special.as_ref().unwrap().label.name(), end.value), ("EP", 1.0));
    }
}

/// Tolerance of a parameter's column, relative: a stiff contact magnifies rounding over a period.
const COLUMN: f64 = 1e-5;

#[test]
fn second_method_the_parameters_column_is_that_of_differences_of_the_equations() {
    for (name, parameter, span) in [
        ("damper_with_buffer.toml", "load.shaker.frequency", 4.0),
        ("damper_with_buffer.toml", "stop.buffer.stiffness", 1e5),
        ("damper_with_buffer.toml", "friction.guide.force", 0.5),
        ("belt_friction.toml", "body.belt.motion.rate", 0.1),
        ("impact_pair.toml", "body.base.motion.amplitude", 0.1),
        ("paper_machine.toml", "stop.upper.restitution", 0.1),
        ("percussion_drill.toml", "load.drive.frequency", 1.0),
        ("vibratory_conveyor.toml", "body.trough.motion.harmonics[0].amplitude", 1e-4),
    ] {
        let machine = example(name);
        let orbit = Orbit::settled(&machine, &Start::default(), 500).unwrap();
        let apart = column_apart(&machine, &orbit, (parameter, span));
        assert!(apart < COLUMN, "{name}, {parameter}: {apart:e}");
    }
}

/// A shaken mass on a piecewise linear spring, with a pad that may pull and one without a dashpot
/// in the rebound. The first one has friction proportional to its force.
const LINES: &str = r#"
name = "Lines"
body.m = { mass = 1.0 }
spring.p = { between = ["ground", "m"], points = [[-0.03, -9.0], [-0.01, -1.0], [0.005, 1.0], [0.02, 0.7], [0.05, 9.0]], damping = 1.5 }
stop.glue = { between = ["ground", "m"], gap = 0.012, stiffness = 300.0, damping = 4.0, law = "pull" }
stop.pad = { between = ["m", "ground"], gap = 0.012, stiffness = 300.0, damping = 4.0, law = "undamped-rebound" }
friction.rub = { between = ["ground", "m"], follows = "glue", coefficient = 0.2 }
load.l = { on = "m", amplitude = 6.0, frequency = 2.5 }
"#;

#[test]
fn second_method_orbits_over_corners_and_pads_are_motions() {
    let machine = machine(LINES);
    let orbit = Orbit::settled(&machine, &Start::default(), 500).unwrap();
    let words = orbit.word().in_words(&orbit.place().assembly);
    for event in ["corner p", "press glue", "free glue", "press pad", "free pad"] {
        assert!(words.contains(event), "{words}");
    }
    // The pad's change of direction has no report.
    assert!(orbit.word().letters.iter().any(|letter| letter.events.is_empty()) && !words.contains("change"));
    assert!(orbit.is_certified() && orbit.stability() == Stability::Stable, "{:?}", orbit.violation());
    assert!(orbit.check_by_motion().unwrap() < TIME * orbit.period());
    let wanted = WantedWord::parse("press glue, press pad", &orbit.place().assembly).unwrap();
    assert!(wanted.is(orbit.word(), &orbit.place().assembly), "{words}");
    let refused = WantedWord::parse("corner q", &orbit.place().assembly).unwrap_err().to_string();
    assert!(refused.contains("such elements: p"), "{refused}");
    let family = Family::new(&machine, "spring.p.points[2].f", (0.8, 1.2)).unwrap();
    let found = branch(&family, &orbit, &Default::default()).unwrap();
    assert!(found.points.len() > 3, "{}", found.points.len());
}

/// A piston that strikes a bit, which is held by friction until then.
const HAMMER: &str = r#"
name = "Hammer"
body.p = { mass = 1.0, start = { v = 0.5 } }
body.b = { mass = 3.0 }
spring.p = { between = ["ground", "p"], stiffness = 600.0, damping = 2.0 }
spring.b = { between = ["ground", "b"], stiffness = 5e4, damping = 20.0 }
stop.an = { between = ["b", "p"], gap = 0.001, restitution = 0.6 }
friction.g = { between = ["ground", "b"], force = 40.0 }
load.l = { on = "p", amplitude = 36.0, frequency = 4.5 }
"#;

#[test]
fn second_method_multipliers_are_those_of_the_motions_own_transition() {
    for machine in [
        machine(HAMMER),
        machine(LINES),
        example("percussion_drill.toml"),
        example("damper_with_buffer.toml"),
    ] {
        let orbit = Orbit::settled(&machine, &Start::default(), 500).unwrap();
        let own = moduli_by_motion(&orbit);
        for (a, b) in orbit.multipliers().iter().zip(&own) {
            assert!((a.norm() - b).abs() < TRANSITION, "{:?} {own:?}", orbit.multipliers());
        }
    }
}

/// Largest difference of multipliers: rounding magnified by stiff contacts.
const TRANSITION: f64 = 1e-6;

#[test]
fn invariant_no_branch_runs_over_a_number_of_the_start() {
    let refused = Family::new(&machine(HAMMER), "body.p.start.v", (0.0, 1.0)).unwrap_err().to_string();
    assert!(refused.contains("body.p.start.v") && refused.contains("another parameter"), "{refused}");
}

#[test]
fn second_method_a_stick_slip_cycle_doubles_where_its_return_map_says() {
    // Differences of the return map from slip to slip, from another program: a multiplier of
    // -1.07381407 at 30 mm/s, and a pair of modulus 0.822 at 31 mm/s.
    let family = Family::new(&example("brake_squeal.toml"), "body.disc.motion.rate", (0.025, 0.04)).unwrap();
    let orbits: Vec<Orbit> = grown(&family, 4, 0).iter().flat_map(|branch| branch.orbits_at(0.03)).collect();
    let own = orbits.iter().find(|orbit| (orbit.period() - 0.002999918515).abs() < RETURN);
    let multiplier = own.expect("the cycle").multipliers()[0];
    assert!((multiplier.re + 1.07381407).abs() < RETURN, "{multiplier}");
}

/// Tolerance for these differences.
const RETURN: f64 = 1e-7;
