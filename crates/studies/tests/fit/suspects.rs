//! Diagnosis of residuals that exceed noise: where they are, and which parameter would reduce
//! them.

use super::*;
use vibro_studies::fit::{Misfit, Place, misfit};

/// Relative tolerance of a suspect's value: other parameters are fitted with it, and kinks of
/// friction bend the cost.
const NEAR: f64 = 0.02;

/// Removes the lines of a section of a machine's file.
fn without(machine: &str, section: &str) -> Machine {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly");
    let text = std::fs::read_to_string(Path::new(folder).join(machine)).unwrap();
    let (before, rest) = text.split_once(&format!("[{section}]")).unwrap();
    let after = rest.split_once("\n[").map_or(String::new(), |(_, after)| format!("\n[{after}"));
    Machine::parse(&(before.to_owned() + &after), machine, &no_records).unwrap()
}

/// A fit with its diagnosis.
fn explained(request: &FitRequest) -> (Fitted, Misfit) {
    let found = fitted(request);
    let misfit = misfit(request, &found, &|| true).unwrap();
    (found, misfit)
}

#[test]
fn made_record_of_a_machine_whose_friction_is_left_out() {
    let truth = example("coulomb_oscillator.toml");
    let measured = record(&truth, &[("mass.s", 2e-6)], 0.25, 200, &mut Noise(61));
    let m = without("coulomb_oscillator.toml", "friction.floor");
    let (found, misfit) = explained(&request(m, measured, &["spring.mount.stiffness"]));
    assert_ne!(found.verdict, Verdict::Fits);
    let best = &misfit.suspects[0];
    assert_eq!((&*best.name, best.value), ("friction between ground and mass", 0.0));
    assert!((best.better / truth.description.get("friction.floor.force").unwrap() - 1.0).abs() < NEAR);
    // The noise is 2 µm; friction leaves residuals of some 300 µm.
    assert!(best.left < 0.05, "{:?}", misfit.suspects);
}

#[test]
fn made_record_of_a_ball_whose_restitution_is_wrong() {
    let text = "name = \"Ball\"\ngravity = 9.81\nbody.a = { mass = 1.0, gravity = 1.0 }\n\
                stop.floor = { between = [\"ground\", \"a\"], gap = 1.0, restitution = 0.8 }\n";
    let truth = Machine::parse(text, "ball.toml", &no_records).unwrap();
    let measured = record(&truth, &[("a.s", 1e-3)], 1.2, 400, &mut Noise(62));
    let m = truth.with([("stop.floor.restitution", 0.75)]).unwrap();
    let (found, misfit) = explained(&request(m, measured, &["stop.floor.gap"]));
    assert_ne!(found.verdict, Verdict::Fits);
    let best = &misfit.suspects[0];
    assert_eq!(best.name, "stop.floor.restitution");
    assert!((best.better / 0.8 - 1.0).abs() < NEAR, "{best:?}");
    // The first contact is at 0.45 s: all residuals come after it. The next flight takes 0.72 s.
    let is_late = |place: &Place| matches!(place, Place::Time(from, _) if *from > 0.45);
    assert!(misfit.places.iter().any(|own| is_late(&own.place)), "{:?}", misfit.places);
}

#[test]
fn invariant_a_fit_that_is_accepted_suspects_nothing() {
    let m = example("coulomb_oscillator.toml");
    let measured = record(&m, &[("mass.s", 2e-6)], 0.25, 400, &mut Noise(63));
    let (found, misfit) = explained(&request(m, measured, &["spring.mount.stiffness"]));
    assert_eq!(found.verdict, Verdict::Fits);
    assert_eq!(misfit, Misfit::default());
}

/// A bump of 50 times the noise from 0.10 s to 0.11 s: the window of the record and its share of
/// the squared residuals are known.
#[test]
fn closed_form_residuals_of_a_window_are_named_by_its_times() {
    let m = example("coulomb_oscillator.toml");
    let mut measured = record(&m, &[("mass.s", 2e-6)], 0.2, 401, &mut Noise(64));
    for (time, value) in measured.times.iter().zip(&mut measured.columns[0].1) {
        *value += if (0.1..0.11).contains(time) { 1e-4 } else { 0.0 };
    }
    let (_, misfit) = explained(&request(m, measured, &["friction.floor.force"]));
    let place = misfit.places.iter().find(|own| matches!(own.place, Place::Time(..))).unwrap();
    let Place::Time(from, to) = place.place else { panic!() };
    // Windows are a twentieth of the record.
    assert!((from - 0.1).abs() < 1e-12 && (to - 0.11).abs() < 1e-12, "{place:?}");
    assert!(place.shares.0 > 0.8 && (place.shares.1 - 0.05).abs() < 0.005, "{place}");
}

/// The residuals that a suspect leaves, against a fit of a machine with the suspect's value.
#[test]
fn second_method_what_a_suspect_leaves_is_what_a_fit_with_its_value_leaves() {
    let text = "name = \"Ball\"\ngravity = 9.81\nbody.a = { mass = 1.0, gravity = 1.0 }\n\
                stop.floor = { between = [\"ground\", \"a\"], gap = 1.0, restitution = 0.8 }\n";
    let truth = Machine::parse(text, "ball.toml", &no_records).unwrap();
    let measured = record(&truth, &[("a.s", 1e-3)], 1.2, 400, &mut Noise(65));
    let m = truth.with([("stop.floor.restitution", 0.75)]).unwrap();
    let own = request(m.clone(), measured.clone(), &["stop.floor.gap"]);
    let (found, misfit) = explained(&own);
    let best = &misfit.suspects[0];
    let with = m.with([(&*best.name, best.better)]).unwrap();
    let again = fitted(&request(with, measured, &["stop.floor.gap"]));
    assert!((again.rms[0].1 / found.rms[0].1 / best.left - 1.0).abs() < NEAR, "{best:?}");
}

/// Contact times of a ball in air, fitted almost without air. A ball of a millionth of the mass
/// would take up the residuals as well; its tens of thousands of contacts do not delay the search.
#[test]
fn made_contacts_of_a_ball_whose_drag_is_left_out() {
    let text = "name = \"Ball\"\ngravity = 9.81\n\
                body.a = { mass = 2.7e-3, gravity = 1.0, start = { v = -2.3 } }\n\
                stop.table = { between = [\"ground\", \"a\"], gap = 0.0, restitution = 0.95 }\n\
                damper.air = { between = [\"ground\", \"a\"], quadratic = 4e-4 }\n";
    let truth = Machine::parse(text, "ball.toml", &no_records).unwrap();
    let mut measured = contacts(&truth, &["table"], 3.0, 0.0, &mut Noise(0));
    measured.contacts[0].1.truncate(8);
    let m = truth.with([("damper.air.quadratic", 1e-9)]).unwrap();
    let free = ["stop.table.restitution", "body.a.start.v"];
    let own = FitRequest { sigma: Some(vec![1e-4]), ..request(m, measured, &free) };
    let (found, misfit) = explained(&own);
    assert_ne!(found.verdict, Verdict::Fits);
    let drag = misfit.suspects.iter().find(|own| own.name == "damper.air.quadratic").unwrap();
    assert!((drag.better / 4e-4 - 1.0).abs() < NEAR && drag.left < 0.01, "{drag:?}");
}
