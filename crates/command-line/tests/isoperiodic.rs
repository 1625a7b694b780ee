//! Planes by simulation, compared with single runs, the exact orbit, their own table and picture.

use std::collections::HashMap;
use vibro::studies;
use vibro_figures::chart::Shape;
use vibro_impact::steady::exact_orbit;
use vibro_impact::{Simulator, State};
use vibro_studies::MotionClass;
use vibro_studies::isoperiodic::isoperiodic;
use vibro_studies::paper::attractor::observe;
use vibro_studies::paper::isoperiodic::{Isoperiodic, IsoperiodicRequest};
use vibro_studies::paper::plane::{self, Method, ParameterAxis, SteadyStateClass};
use vibro_studies::paper::start::StartRule;
use vibro_studies::paper::stroboscopic::moving_block;
use vibro_studies::paper::{ParameterSet, find_group};
use vibro_studies::parts::Task;

fn axis(name: &str, range: (f64, f64), count: usize) -> ParameterAxis {
    ParameterAxis::new(find_group(name).unwrap(), range, count).unwrap()
}

fn request(x: ParameterAxis, y: ParameterAxis, start: StartRule, discard: u32) -> IsoperiodicRequest {
    IsoperiodicRequest { x, y, start, discard, exponents: Some(4000) }
}

fn found(request: &IsoperiodicRequest) -> Isoperiodic {
    isoperiodic(&ParameterSet::basic(), request, &Task::ALL).unwrap().unwrap()
}

fn at(request: &IsoperiodicRequest, index: usize) -> ParameterSet {
    let (x, y) = (&request.x, &request.y);
    let set = ParameterSet::basic().with(x.name, x.value(index % x.count)).unwrap();
    set.with(y.name, y.value(index / x.count)).unwrap()
}

#[test]
fn second_method_points_of_a_plane_one_by_one() {
    let r = request(axis("sigma1", (-1.0, 1.0), 7), axis("f10", (0.0, 3.5), 6), StartRule::default(), 200);
    let plane = found(&r);
    let theory = plane::plane(&ParameterSet::basic(), r.x, r.y, Method::ExactOrbit, &|| ()).unwrap();
    let mut periods = std::collections::BTreeSet::new();
    /// m/s; much more than rounding, much less than a visible basin of attraction.
    const BESIDE: f64 = 1e-9;
    let (mut compared, mut open) = (0, 0);
    for (i, point) in plane.points.iter().enumerate() {
        assert_eq!(point.theory, theory.classes[i], "point {i}");
        let motion = point.motion.expect("not refused");
        // The reference is one simulator in one run, and a second one from a neighbouring start.
        // If these two end differently, rounding decides the end of the batch too.
        let p = *at(&r, i).parameters();
        let alone = |beside: f64| {
            let State { x, mut v } = moving_block(&p);
            v[1] += beside;
            let mut simulator = Simulator::new(&p, &State { x, v }, 0.0).unwrap();
            simulator.advance_to(200.0 * p.period()).unwrap();
            observe(&mut simulator).unwrap()
        };
        let (alone, next) = (alone(0.0), alone(BESIDE));
        if let (Some(period), true) = (alone.period, alone.period == next.period) {
            compared += 1;
            assert_eq!(motion.class, MotionClass::Periodic(period), "point {i}");
            assert_eq!(motion.impacts, alone.impacts, "point {i}");
            periods.insert(period);
        }
        // Exponents exist if there are impacts and no period.
        let impacts = motion.impacts != [0.0; 2];
        let periodic = matches!(motion.class, MotionClass::Periodic(_));
        assert_eq!(motion.exponent.is_some(), impacts && !periodic, "point {i}: {motion:?}");
        let threshold = 1e-3 * p.box_frequency().min(p.drive_frequency);
        // A motion that is not settled at the limit has an exponent of undecided sign.
        if motion.class == MotionClass::NotSettled {
            open += 1;
            let undecided = motion.exponent.is_some_and(|[e, error]| e.abs() - threshold <= 6.0 * error);
            assert!(undecided, "point {i}: {motion:?}");
        }
        // Chaos requires an exponent that is significantly positive.
        let positive = motion.exponent.is_some_and(|[e, error]| e - 6.0 * error > threshold);
        assert_eq!(motion.class == MotionClass::Chaotic, positive, "point {i}: {motion:?}");
    }
    assert!(open <= 2, "{open} of {} not settled", plane.points.len());
    assert!(compared >= 15, "{compared} of {}", plane.points.len());
    assert!(
        periods.len() > 1 && plane.points.iter().any(|p| p.motion.unwrap().class == MotionClass::Chaotic)
    );
}

#[test]
fn second_method_the_stable_exact_orbit_is_kept_and_no_other_is_met() {
    /// Half-period multipliers this far inside the circle let rounding of the start decay within
    /// the discarded periods; this far outside, it grows beyond all tolerances.
    const INSIDE: f64 = 0.97;
    let (x, y) = (axis("sigma1", (-2.0, 2.0), 17), axis("f10", (0.4, 4.0), 16));
    let on_orbit = found(&request(x, y, StartRule::Orbit, 100));
    let mut well_inside = 0;
    for (i, point) in on_orbit.points.iter().enumerate() {
        if point.theory != SteadyStateClass::Stable {
            continue;
        }
        let orbits = exact_orbit::solve(at(&request(x, y, StartRule::Orbit, 0), i).parameters()).unwrap();
        let stable = [orbits.upper, orbits.lower].into_iter().flatten().find(|o| o.is_stable()).unwrap();
        if stable.spectral_radius() < INSIDE {
            let motion = point.motion.unwrap();
            assert!(motion.on_orbit && motion.is_two_impact(), "point {i}: {motion:?}");
            well_inside += 1;
        }
    }
    assert!(well_inside > 60, "{well_inside}");
    // From the default start some motions end on other attractors, but none ends on an orbit that
    // is unstable in theory.
    let kicked = found(&request(x, y, StartRule::default(), 300)).agreement();
    assert_eq!(kicked.predicted, kicked.two_impact, "{kicked:?}");
    assert!(
        kicked.reached as f64 > 0.9 * kicked.stable as f64 && kicked.reached < kicked.stable,
        "{kicked:?}"
    );
}

#[test]
fn closed_form_parts_without_a_system_are_left_out() {
    // 1 + ε σ1 > 0: a drive that rotates forwards.
    let r = request(axis("sigma1", (-12.0, -6.0), 7), axis("f10", (0.5, 1.0), 2), StartRule::default(), 20);
    for (i, point) in found(&r).points.iter().enumerate() {
        assert_eq!(point.motion.is_none(), r.x.value(i % 7) <= -10.0, "point {i}");
    }
}

#[test]
fn pictures_show_what_the_table_holds() {
    let r = request(axis("kappa", (0.0, 1.0), 9), axis("f10", (0.5, 4.0), 8), StartRule::default(), 60);
    let plane = found(&r);
    let study = studies::isoperiodic(&ParameterSet::basic(), &r, &plane, "isoperiodic").unwrap();
    let rows: Vec<HashMap<String, String>> =
        csv::Reader::from_reader(study.tables[0].1.as_slice()).deserialize().map(|r| r.unwrap()).collect();
    assert_eq!(rows.len(), 72);
    let panels = &study.figure.as_ref().unwrap().panels;
    let cells = |panel: usize| match &panels[panel].layers[0].shape {
        Shape::Cells { cells, columns: 9, .. } => cells.clone(),
        other => panic!("{other:?}"),
    };
    let number = |row: &HashMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
    for (i, row) in rows.iter().enumerate() {
        assert_eq!((number(row, "kappa"), number(row, "f10")), (r.x.value(i % 9), r.y.value(i / 9)));
    }
    // More impacts never have a lighter colour; two and three impacts have separate colours.
    let all = |row: &HashMap<String, String>| number(row, "impacts_upper") + number(row, "impacts_lower");
    let mut impacts: Vec<(f64, u8)> = rows.iter().map(all).zip(cells(1)).collect();
    impacts.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert!(impacts.windows(2).all(|w| w[0].1 <= w[1].1), "{impacts:?}");
    for whole in [2.0, 3.0] {
        let own = impacts.iter().find(|c| c.0 == whole).unwrap().1;
        assert!(impacts.iter().all(|c| (c.1 == own) == (c.0 == whole)), "{whole}: {impacts:?}");
    }
    // The symmetric motion with two impacts per period has a single colour, and so does chaos.
    let two_impact = |row: &HashMap<String, String>| {
        row["class"] == "1T" && row["symmetric"] == "true" && row["rests"] == "false" && all(row) == 2.0
    };
    for own in [
        rows.iter().map(two_impact).collect::<Vec<bool>>(),
        rows.iter().map(|row| row["class"] == "chaotic").collect(),
    ] {
        let colour = cells(0)[own.iter().position(|o| *o).unwrap()];
        assert_eq!(cells(0).iter().map(|c| *c == colour).collect::<Vec<_>>(), own);
    }
    // The limit of stability has an edge between each pair of a stable and an unstable neighbour.
    let Shape::Lines { pieces, .. } = &panels[0]
        .layers
        .iter()
        .find(|l| l.name.as_deref() == Some("limit of the stable exact orbit"))
        .unwrap()
        .shape
    else {
        panic!("a line")
    };
    let stable: Vec<bool> = rows.iter().map(|r| r["exact_orbit"] == "stable").collect();
    let across = (0..72).filter(|i| i % 9 > 0 && stable[*i] != stable[i - 1]).count();
    let up = (9..72).filter(|i| stable[*i] != stable[i - 9]).count();
    assert_eq!(pieces.len(), across + up);
    assert!(across > 0 && up > 0);
}
