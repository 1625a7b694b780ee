//! Touches from both sides, families of orbits, and parameters at their limits.

use super::*;
use std::f64::consts::PI;
use vibro_machine::Start;
use vibro_studies::Measure;

/// Relative tolerance for a touch.
const ROUNDING: f64 = 1e-11;
/// Relative tolerance for a gradient at a run of impacts, whose differences have errors of about
/// 1e-7.
const GRADIENT: f64 = 1e-6;
/// Smallest number of points of a followed curve.
const FOLLOWED: usize = 20;

/// The curves over a second parameter from every special point of branches except ends, with the
/// number of events of the branch.
fn curves(
    branches: &[Branch],
    machine: &Machine,
    second: (&str, f64, f64),
) -> Vec<(Special, usize, Vec<LocusPoint>)> {
    let second = Family::new(machine, second.0, (second.1, second.2)).unwrap();
    let of = |branch: &Branch| {
        let own = (0..branch.points.len()).filter_map(|k| branch.locus_start(k)).collect::<Vec<_>>();
        own.into_iter().map(|start| (start, branch.word().len())).collect::<Vec<_>>()
    };
    let starts = branches.iter().flat_map(of);
    starts.map(|(start, events)| (start.special.clone(), events, locus(&start, &second).unwrap())).collect()
}

/// An oscillator with a compliant stop; `stop` adds keys to the stop.
fn stopped(stop: &str) -> Machine {
    machine(&format!(
        "name = \"Stop\"\nbody.m = {{ mass = 1.0 }}\n\
         spring.k = {{ between = [\"ground\", \"m\"], stiffness = 100.0, damping = 1.0 }}\n\
         stop.a = {{ between = [\"ground\", \"m\"], gap = 0.02, stiffness = 4000.0{stop} }}\n\
         load.l = {{ on = \"m\", amplitude = 1.0, frequency = 2.0 }}\n"
    ))
}

#[test]
fn closed_form_graze_of_a_compliant_stop_from_the_side_with_its_contact() {
    // F = gap |k - m ω² + i c ω|: the amplitude without the stop equals the gap.
    let omega: f64 = 2.0 * PI * 2.0;
    let ratio = (100.0 - omega * omega).hypot(omega);
    for stop in ["", ", damping = 10.0"] {
        let m = stopped(stop);
        let family = Family::new(&m, "load.l.amplitude", (0.5, 3.0)).unwrap();
        let found = curves(&grown(&family, 6, 1), &m, ("stop.a.gap", 0.01, 0.05));
        let grazes: Vec<_> = found.iter().filter(|(special, ..)| special.label.name() == "GR").collect();
        assert!(grazes.iter().any(|own| own.1 == 0) && grazes.iter().any(|own| own.1 > 1), "{stop}");
        for (_, events, points) in grazes {
            assert!(points.len() > FOLLOWED, "{events} events: {} points", points.len());
            for LocusPoint { values: [force, gap], .. } in points {
                assert!((force / (gap * ratio) - 1.0).abs() < ROUNDING, "{events} events: {force} {gap}");
            }
        }
    }
}

#[test]
fn invariant_the_ends_of_two_branches_at_a_touch_are_one_point() {
    let m = stopped(", damping = 10.0");
    let family = Family::new(&m, "load.l.amplitude", (0.5, 3.0)).unwrap();
    let branches = grown(&family, 6, 1);
    // F = gap |k - m ω² + i c ω|.
    let force = 0.02 * (100.0 - (4.0 * PI).powi(2)).hypot(4.0 * PI);
    let of = |branch: &Branch| {
        let own =
            (0..branch.points.len()).filter_map(|k| Some((branch.points[k].value, branch.locus_start(k)?)));
        own.map(|(value, start)| ((value - force).abs() < 1e-9, branch.word().is_empty(), start))
            .collect::<Vec<_>>()
    };
    let starts: Vec<_> = branches.iter().flat_map(of).collect();
    let without = starts.iter().find(|(is_touch, is_empty, _)| *is_touch && *is_empty).unwrap();
    assert!(starts.iter().any(|(is_touch, is_empty, _)| *is_touch && !*is_empty));
    for (is_touch, _, start) in &starts {
        assert_eq!(
            start.shortest().is_same(&without.2.shortest()),
            *is_touch,
            "{:?} of {}",
            start.special,
            start.word()
        );
    }
}

/// An oscillator with friction; `further` adds elements.
fn rubbing(further: &str) -> Machine {
    machine(&format!(
        "name = \"Rub\"\nbody.m = {{ mass = 1.0 }}\n\
         spring.k = {{ between = [\"ground\", \"m\"], stiffness = 100.0, damping = 1.0 }}\n\
         load.l = {{ on = \"m\", amplitude = 4.0, frequency = 1.0 }}\n{further}"
    ))
}

#[test]
fn invariant_sticking_begins_at_loads_in_proportion_to_the_friction_from_either_side() {
    // Load, friction and motion scale together.
    let m = rubbing("friction.f = { between = [\"ground\", \"m\"], force = 1.0 }\n");
    let family = Family::new(&m, "load.l.amplitude", (1.5, 4.0)).unwrap();
    let found = curves(&grown(&family, 6, 1), &m, ("friction.f.force", 0.8, 2.0));
    let mut events: Vec<usize> = found.iter().map(|own| own.1).collect();
    events.sort_unstable();
    assert_eq!(events, [2, 4]);
    let ratio = found[0].2[0].values[0] / found[0].2[0].values[1];
    for (special, events, points) in found {
        assert_eq!((special.label.name(), special.element.as_str()), ("ST", "friction.f"));
        assert!(points.len() > FOLLOWED, "{events} events: {} points", points.len());
        for LocusPoint { values: [load, friction], .. } in points {
            assert!((load / (friction * ratio) - 1.0).abs() < ROUNDING, "{events} events: {load} {friction}");
        }
    }
}

#[test]
fn invariant_every_special_point_of_contacts_that_meet_begins_a_curve() {
    // More static than sliding friction, and a stop: visits in which the friction reverses or
    // sticks, velocities that touch zero, sticking that begins with the load at its limit.
    let stuck = "friction.f = { between = [\"ground\", \"m\"], force = 1.0, static = 1.4 }\n\
        stop.s = { between = [\"ground\", \"m\"], gap = 0.02, stiffness = 2000.0 }\n";
    // Two oscillators whose stops change their order.
    let two = "body.n = { mass = 0.5 }\n\
        spring.q = { between = [\"ground\", \"n\"], stiffness = 60.0, damping = 1.0 }\n\
        stop.s = { between = [\"ground\", \"m\"], gap = 0.01, stiffness = 2000.0 }\n\
        stop.u = { between = [\"ground\", \"n\"], gap = 0.01, stiffness = 1500.0 }\n\
        load.m = { on = \"n\", amplitude = 2.0, frequency = 1.0 }\n";
    for (further, (vary, from, to), gap) in [
        (stuck, ("load.l.amplitude", 1.9, 3.9), "stop.s.gap"),
        (two, ("load.m.amplitude", 1.0, 4.0), "stop.u.gap"),
    ] {
        let m = rubbing(&further.replace("amplitude = 4.0", "amplitude = 3.0"));
        let family = Family::new(&m, vary, (from, to)).unwrap();
        let present = m.description.get(gap).unwrap();
        let found = curves(&grown(&family, 12, 1), &m, (gap, 0.8 * present, 1.25 * present));
        assert!(found.len() > 3, "{}", found.len());
        for (special, events, points) in found {
            let ends: Vec<_> = points.iter().filter(|p| p.end.is_some()).collect();
            assert!(
                points.len() > FOLLOWED,
                "{special:?}, {events} events: {} points, {ends:?}",
                points.len()
            );
        }
    }
}

#[test]
fn a_crossing_that_a_second_parameter_breaks_is_refused() {
    let m = example("paper_machine.toml");
    let family = Family::new(&m, "load.drive.amplitude", (0.03, 0.35)).unwrap();
    let branches = grown(&family, 12, 0);
    let crossings = branches.iter().flat_map(|b| (0..b.points.len()).filter_map(|k| b.locus_start(k)));
    let crossing = crossings.into_iter().find(|start| start.special.label.name() == "BP").unwrap();
    let gap = m.description.parameters().into_iter().find(|p| p.name.ends_with(".gap")).unwrap();
    let second = Family::new(&m, &gap.name, (0.9 * gap.value, 1.1 * gap.value)).unwrap();
    let error = locus(&crossing, &second).unwrap_err().to_string();
    assert!(error.contains("because orbits cross at this value only"), "{error}");
}

#[test]
fn an_orbit_of_a_family_has_no_derivatives_and_no_branch() {
    // A free oscillation without losses: one orbit for each energy.
    let m = machine(
        "name = \"Free\"\nbody.mass = { mass = 1.0, start = { v = 0.1 } }\n\
         spring.k = { between = [\"ground\", \"mass\"], stiffness = 10.0 }\n\
         stop.s = { between = [\"ground\", \"mass\"], gap = 0.01, stiffness = 50.0 }\n",
    );
    let orbit = Orbit::settled(&m, &Start::default(), 4).unwrap();
    let measure: Measure = "amplitude.mass.s".parse().unwrap();
    for own in orbit.gradient(&measure).unwrap() {
        let why = own.derivative.unwrap_err();
        assert!(why.contains("belongs to a family"), "{}: {why}", own.parameter);
    }
    let family = Family::new(&m, "spring.k.stiffness", (5.0, 20.0)).unwrap();
    let error = branch(&family, &orbit, &Default::default()).unwrap_err().to_string();
    assert!(error.contains("belongs to a family"), "{error}");
}

#[test]
fn second_method_a_derivative_at_a_limit_is_that_beside_it() {
    // A ball that comes to rest after a run of impacts; its spring has the smallest damping, 0.
    let thrown = |damping: f64| {
        machine(&format!(
            "name = \"Ball\"\ngravity = 10.0\nbody.ball = {{ mass = 1.0, gravity = -1.0 }}\n\
             body.table = {{ motion = {{ amplitude = 0.03, frequency = \"20 rad/s\" }} }}\n\
             stop.floor = {{ between = [\"ball\", \"table\"], gap = 0.0, restitution = 0.6 }}\n\
             spring.d = {{ between = [\"ground\", \"ball\"], stiffness = 1.0, damping = {damping} }}\n"
        ))
    };
    let measure: Measure = "maximum.ball.s".parse().unwrap();
    let by = |damping: f64| {
        let orbit = Orbit::settled(&thrown(damping), &Start::default(), 50).unwrap();
        let all = orbit.gradient(&measure).unwrap();
        all.into_iter().find(|own| own.parameter == "spring.d.damping").unwrap().derivative.unwrap()
    };
    // The polynomial through three derivatives near the limit.
    let beside = 3.0 * by(0.01) - 3.0 * by(0.02) + by(0.03);
    let own = by(0.0);
    assert!((own / beside - 1.0).abs() < GRADIENT, "{own} {beside}");
}
