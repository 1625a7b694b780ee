//! Orbits and bifurcations with closed forms or published values.

use super::*;
use std::f64::consts::PI;
use vibro_machine::Start;

/// Tolerance for a special point's parameter; crossings are located by interpolation.
const LOCATED: f64 = 1e-10;
/// Tolerance for an orbit's values.
const ROUNDING: f64 = 1e-12;

/// x'' + 0.04 x' + x = F cos ωt with a wall at x = 1 and ε = 0.9.
pub(super) fn wall(omega: &str) -> Machine {
    machine(&format!(
        "name = \"Wall\"\nbody.block = {{ mass = 1.0 }}\n\
         spring.holder = {{ between = [\"ground\", \"block\"], stiffness = 1.0, damping = 0.04 }}\n\
         stop.wall = {{ between = [\"ground\", \"block\"], gap = 1.0, restitution = 0.9 }}\n\
         load.drive = {{ on = \"block\", amplitude = 0.35, frequency = \"{omega} rad/s\", phase = {} }}\n",
        0.5 * PI
    ))
}

#[test]
fn published_flip_fold_and_graze_of_an_oscillator_with_a_wall() {
    // The orbit of two drive periods with one impact: its flip at ω = 0.81 and its fold at 0.799,
    // to the published digits. Without impacts the amplitude is F / |1 - ω² + 0.04 i ω|.
    for (omega, kind, force, graze) in
        [("0.81", "PD", 0.3475334, 0.345422885750206), ("0.799", "LP", 0.3628362, 0.363008647832252)]
    {
        let family = Family::new(&wall(omega), "load.drive.amplitude", (0.33, 0.4)).unwrap();
        let branches = grown(&family, 8, 2);
        let found = specials(&branches, 1, kind);
        assert!(nearest(&found, force) < 1e-7, "{omega}: {found:?}");
        let grazes = specials(&branches, 0, "GR");
        assert!(nearest(&grazes, graze) < ROUNDING, "{omega}: {grazes:?}");
    }
}

#[test]
fn closed_form_both_symmetric_orbits_of_the_impact_pair_and_their_fold() {
    // Flight at V between impacts half a period apart: cos t = -(1 - ε)/(1 + ε) V/A and 2 A sin t
    // + 3 = π V, hence V²/9 + (π V - 3)²/4 = A².
    let m = example("impact_pair.toml");
    let family = Family::new(&m, "body.base.motion.amplitude", (0.2, 2.0)).unwrap();
    let branches = grown(&family, 10, 0);
    let orbits: Vec<Orbit> = branches.iter().flat_map(|b| b.orbits_at(1.0)).collect();
    for (speed, stability) in
        [(1.50557395311726, Stability::Stable), (0.321987289207181, Stability::Unstable)]
    {
        let own = orbits.iter().find(|o| (o.state()[1].abs() - speed).abs() < ROUNDING);
        assert_eq!(own.unwrap().stability(), stability, "V = {speed}");
        assert!(own.unwrap().check_by_motion().unwrap() < ROUNDING);
    }
    let fold = (2.25 - (1.5 * PI).powi(2) / (4.0 / 9.0 + PI * PI)).sqrt();
    let found = specials(&branches, 2, "LP");
    assert!(nearest(&found, fold) < LOCATED, "{found:?} {fold}");
}

#[test]
fn closed_form_fold_and_flip_of_a_ball_on_a_table() {
    // One bounce per period, from A ω² = π g (1 - ε)/(1 + ε).
    let (found, flip) = super::closing::ball();
    let found = [found];
    for (kind, value) in [("LP", 10.0 * PI * 0.25 / 400.0), ("PD", flip)] {
        let values = specials(&found, 1, kind);
        assert!(nearest(&values, value) < LOCATED, "{kind} {value}: {values:?}");
    }
}

/// The branch of two bounces begins at the flip of the branch of one bounce.
#[test]
fn closed_form_the_doubled_branch_of_a_ball_begins_at_its_flip() {
    let (found, flip) = super::closing::ball();
    let ball = &found.of.family.machine;
    let family = Family::new(ball, "body.table.motion.amplitude", (0.95 * flip, 1.02 * flip)).unwrap();
    let start = found.orbits_at(0.985 * flip).pop().unwrap().start();
    let options = TreeOptions { seeds: 1, depth: 1, start, ..TreeOptions::default() };
    let branches = tree(&family, &options, &mut |_, _| true).unwrap();
    let doubled = branches.iter().find(|b| b.word().len() == 2 && b.word().periods == Some(2)).unwrap();
    let (parent, point) = doubled.parent.unwrap();
    assert_eq!(branches[parent].points[point].special.as_ref().unwrap().label.name(), "PD");
    let begins = branches[parent].points[point].value;
    assert!((begins - flip).abs() < LOCATED && (doubled.points[0].value - flip).abs() < LOCATED, "{begins}");
}

#[test]
fn closed_form_period_of_a_stick_slip_cycle() {
    // It sticks at the belt's speed V over 2 (Fs - Fk)/k, then slips from this speed back to it.
    let orbit = Orbit::settled(&example("belt_friction.toml"), &Start::default(), 50).unwrap();
    let (k, speed, lead): (f64, f64, f64) = (100.0, 0.1, (2.0 - 1.5) / 100.0);
    let omega = k.sqrt();
    let period = (PI + 2.0 * (speed / (omega * lead)).atan()) / omega + 2.0 * lead / speed;
    assert!((orbit.period() - period).abs() < ROUNDING, "{} {period}", orbit.period());
    assert_eq!(orbit.stability(), Stability::Stable);
    // After sticking, no earlier deviation remains.
    assert!(orbit.spectral_radius() < ROUNDING && orbit.trivial_multipliers() == 1);
}

#[test]
fn published_frequency_of_a_free_vibration_with_a_stop() {
    // 1 kg on 10 N/m with a stop of 50 N/m at 10 mm, at the energy 0.00650108331626 J.
    let speed = (2.0 * 0.00650108331626_f64).sqrt();
    let text = format!(
        "name = \"Free\"\nbody.mass = {{ mass = 1.0, start = {{ v = {speed} }} }}\n\
         spring.k = {{ between = [\"ground\", \"mass\"], stiffness = 10.0 }}\n\
         stop.s = {{ between = [\"ground\", \"mass\"], gap = 0.01, stiffness = 50.0 }}\n"
    );
    let orbit = Orbit::settled(&machine(&text), &Start::default(), 4).unwrap();
    assert!((1.0 / orbit.period() - 0.646631040640).abs() < 1e-12, "{}", 1.0 / orbit.period());
    assert_eq!(orbit.stability(), Stability::Neutral);
}

#[test]
fn closed_form_den_hartogs_amplitude() {
    let orbit = Orbit::settled(&example("den_hartog.toml"), &Start::default(), 100).unwrap();
    let quantity = orbit.place().assembly.description.named_quantities();
    let place = quantity.iter().find(|q| q.name == "mass.s").unwrap().quantity;
    let extent = &orbit.watched(&[place]).extents[0];
    assert!((extent.largest - 0.721110255092798).abs() < ROUNDING, "{}", extent.largest);
}
