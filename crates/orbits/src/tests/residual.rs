//! Orbits of bodies with residual flexibility, whose contacts change the rows of all forces.

use super::*;
use vibro_studies::Start;

/// Two points of a body: one meets a rigid wall, the other rubs on a pad.
fn coupled(frequency: f64, friction: f64) -> Machine {
    machine(&format!(
        "name = \"Coupled\"\n[modal.m]\nfrequencies = [1.0, 3.4, 6.2]\ndamping_ratio = 0.04\n\
         nodes = {{ a = {{ n = [0.9, -0.4, 0.5], t = [-0.2, 0.7, 0.3] }}, b = {{ n = [0.8, 0.6, -0.5], t = [0.1, -0.3, 0.9] }}, push = [0.5, 0.3, -0.2] }}\n\
         residual = {{ nodes = [\"a.n\", \"a.t\", \"b.n\"], flexibility = [[4e-3, 8e-4, 9e-4], [8e-4, 3e-3, 2e-4], [9e-4, 2e-4, 5e-3]] }}\n\
         [contact.pad]\nbetween = [\"ground\", \"m.a\"]\nnormal = \"n\"\ntangent = \"t\"\npreload = 1.0\n\
         stiffness = 300.0\ntangential_stiffness = 200.0\nfriction = {friction}\n\
         [stop.wall]\nbetween = [\"ground\", \"m.b.n\"]\ngap = 0.02\n\
         [load.f]\non = \"m.push\"\namplitude = 4.0\nfrequency = {frequency}\n"
    ))
}

/// Rounding of a period with some ten contacts.
const ROUNDING: f64 = 1e-8;

/// Relative error of the columns' differences.
const APART: f64 = 1e-6;

/// The orbit is the settled motion, its multipliers are those of the motion's own derivatives, and the
/// columns of parameters are differences of the equations.
#[test]
fn second_method_multipliers_and_columns_of_coupled_contacts() {
    for frequency in [0.7, 1.6] {
        let machine = coupled(frequency, 0.3);
        let orbit = Orbit::settled(&machine, &Start::default(), 400).unwrap();
        let words = orbit.word().in_words(&orbit.place().assembly);
        assert!(words.contains("press wall") && words.contains("slip pad"), "{words}");
        let parameters = [
            "contact.pad.friction",
            "contact.pad.stiffness",
            "contact.pad.tangential_stiffness",
            "contact.pad.preload",
            "stop.wall.gap",
            "load.f.amplitude",
            "load.f.frequency",
        ];
        examine(&machine, &orbit, &parameters, &Allowed { rounding: ROUNDING, apart: APART });
    }
}

/// Each point of a branch is a motion.
#[test]
fn second_method_branches_of_coupled_contacts_are_motions() {
    let machine = coupled(1.6, 0.3);
    let orbit = Orbit::settled(&machine, &Start::default(), 400).unwrap();
    points_are_motions(&machine, &orbit, ("load.f.amplitude", (3.6, 4.4)), ROUNDING);
}
