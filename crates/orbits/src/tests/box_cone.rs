//! Orbits with contacts of two tangents.

use super::*;
use vibro_machine::Motion;
use vibro_studies::Start;

/// A body of three coordinates that rubs on a pad, with or without a gap to it.
fn rubbing(contacts: &str) -> Machine {
    machine(&format!(
        "name = \"Rubbing\"\n[body]\nn = {{ mass = 1.0 }}\nt = {{ mass = 1.3 }}\ns = {{ mass = 0.9 }}\n\
         [spring]\nn = {{ between = [\"ground\", \"n\"], stiffness = 300.0, damping = 1.5 }}\n\
         t = {{ between = [\"ground\", \"t\"], stiffness = 120.0, damping = 0.9 }}\n\
         s = {{ between = [\"ground\", \"s\"], stiffness = 150.0, damping = 0.8 }}\n\
         nt = {{ between = [\"n\", \"t\"], stiffness = 30.0 }}\n\
         [load]\nfn = {{ on = \"n\", constant = 4.0, amplitude = 14.0, frequency = 1.5 }}\n\
         ft = {{ on = \"t\", amplitude = 12.0, frequency = 1.5, phase = 1.0 }}\n\
         fs = {{ on = \"s\", amplitude = 9.0, frequency = 1.5, phase = 2.5 }}\n{contacts}"
    ))
}

/// The pad, as a contact with two tangents and as two contacts with one.
fn pads() -> [Machine; 2] {
    let boxed = "[contact.pad]\nnormal = [\"ground\", \"n\"]\ntangent = { arms = { t = 1.0, n = 0.2 } }\n\
                 second_tangent = [\"ground\", \"s\"]\ncone = \"box\"\npreload = 2.0\nstiffness = 400.0\n\
                 tangential_stiffness = [250.0, 200.0]\nfriction = 0.3\n";
    let half = |name: &str, tangent: &str, stiffness: f64| {
        format!(
            "[contact.{name}]\nnormal = [\"ground\", \"n\"]\ntangent = {tangent}\npreload = 1.0\nstiffness = 200.0\n\
             tangential_stiffness = {stiffness:?}\nfriction = 0.6\n"
        )
    };
    let halves =
        half("pad0", "{ arms = { t = 1.0, n = 0.2 } }", 250.0) + &half("pad1", "[\"ground\", \"s\"]", 200.0);
    [boxed, &halves].map(rubbing)
}

/// Rounding of a period with some ten events.
const ROUNDING: f64 = 1e-8;

/// Relative error of the columns' differences.
const APART: f64 = 1e-6;

/// The orbit is the settled motion and the orbit of two contacts with one tangent each, its
/// multipliers are those of the motion's own derivatives and of that orbit, and the columns of
/// parameters are differences of the equations.
#[test]
fn second_method_an_orbit_with_two_tangents_is_that_of_two_contacts() {
    let both = pads();
    let [orbit, other] =
        both.each_ref().map(|machine| Orbit::settled(machine, &Start::default(), 400).unwrap());
    let words = orbit.word().in_words(&orbit.place().assembly);
    for word in ["press pad", "free pad", "slip pad[0]", "slip pad[1]", "stick pad[0]", "stick pad[1]"] {
        assert!(words.contains(word), "{word}: {words}");
    }
    // The word is found by its text, and without the events of the second tangent it is another.
    let (assembly, letters) = (&orbit.place().assembly, words.split(", ").collect::<Vec<_>>());
    assert!(WantedWord::parse(&words, assembly).unwrap().is(orbit.word(), assembly));
    let fewer: Vec<&str> = letters.iter().copied().filter(|own| !own.contains("pad[1]")).collect();
    assert!(fewer.len() < letters.len());
    assert!(!WantedWord::parse(&fewer.join(", "), assembly).unwrap().is(orbit.word(), assembly));
    let moduli = |orbit: &Orbit| {
        let mut own: Vec<f64> = orbit.multipliers().iter().map(|m| m.norm()).collect();
        own.sort_by(|a, b| b.total_cmp(a));
        own
    };
    for (a, b) in moduli(&orbit).iter().zip(moduli(&other)) {
        assert!((a - b).abs() < ROUNDING, "{a} {b}");
    }
    let (time, state) = orbit.middle_state();
    let mut motion = Motion::from_state(other.place().assembly.clone(), time, &state).unwrap();
    motion.advance_to(time + orbit.period()).unwrap();
    for (a, b) in motion.states().iter().zip(&state) {
        assert!((a - b).abs() < ROUNDING, "{a} {b}");
    }
    let parameters = [
        "contact.pad.friction",
        "contact.pad.stiffness",
        "contact.pad.tangential_stiffness[0]",
        "contact.pad.tangential_stiffness[1]",
        "contact.pad.preload",
        "load.fs.amplitude",
    ];
    examine(&both[0], &orbit, &parameters, &Allowed { rounding: ROUNDING, apart: APART });
}

/// Each point of a branch is a motion.
#[test]
fn second_method_branches_with_two_tangents_are_motions() {
    let [machine, _] = pads();
    let orbit = Orbit::settled(&machine, &Start::default(), 400).unwrap();
    points_are_motions(&machine, &orbit, ("contact.pad.friction", (0.28, 0.32)), ROUNDING);
}

/// A slider that sticks for the whole period is a free direction along its own tangent alone.
#[test]
fn closed_form_each_tangent_that_sticks_is_held_by_itself() {
    let text = "name = \"Pair\"\nbody.a = { mass = 1.0 }\nbody.b = { mass = 1.0 }\nbody.c = { mass = 1.0 }\n\
        spring.a = { between = [\"ground\", \"a\"], stiffness = 1000.0, damping = 3.0 }\n\
        spring.b = { between = [\"ground\", \"b\"], stiffness = 2000.0, damping = 3.0 }\n\
        spring.c = { between = [\"ground\", \"c\"], stiffness = 1500.0, damping = 3.0 }\n\
        load.fa = { on = \"a\", amplitude = 1.0, frequency = 3.0 }\n\
        load.fc = { on = \"c\", amplitude = 400.0, frequency = 3.0 }\nload.fb = { on = \"b\", constant = 100.0 }\n\
        contact.pad = { normal = [\"ground\", \"b\"], tangent = [\"ground\", \"a\"], second_tangent = [\"ground\", \"c\"], \
        cone = \"box\", preload = 100.0, stiffness = 1e4, tangential_stiffness = [500.0, 500.0], friction = 0.3 }\n";
    let orbit = Orbit::settled(&machine(text), &Start::default(), 400).unwrap();
    assert_eq!(orbit.held(), [vibro_machine::mode::Contact::Slider(0)]);
    let words = orbit.word().in_words(&orbit.place().assembly);
    assert!(words.contains("slip pad[1]") && !words.contains("pad[0]"), "{words}");
}
