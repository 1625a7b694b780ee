//! Orbits of machines with freewheels, whose elongation grows from period to period.

use super::*;
use nalgebra::DMatrix;
use vibro_machine::derivative::By;
use vibro_machine::{Differentiated, Start};

/// A rotor on a spring drives a tail; in the second machine it strikes a wall, and catches the
/// tail at the same instant.
const TAIL: &str = r#"
name = "Tail"
body.rotor = { mass = 1.3 }
body.tail = { mass = 0.7 }
spring.k = { between = ["ground", "rotor"], stiffness = 60.0, damping = 1.5 }
damper.drag = { between = ["ground", "tail"], damping = 0.6 }
freewheel.w = { between = ["tail", "rotor"] }
load.push = { on = "rotor", amplitude = 6.0, frequency = 1.3 }
"#;

/// Tolerance for an orbit's values over a period.
const ROUNDING: f64 = 1e-9;

#[test]
fn second_method_orbits_with_freewheels_have_the_multipliers_of_their_motion() {
    let wall = "stop.wall = { between = [\"rotor\", \"ground\"], gap = 0.12, restitution = 0.6 }\n";
    for (text, words) in
        [(TAIL.to_owned(), ["close w", "open w"]), (format!("{TAIL}{wall}"), ["impact wall", "impact w"])]
    {
        let machine = machine(&text);
        let orbit = Orbit::settled(&machine, &Start::default(), 400).unwrap();
        let told = orbit.word().in_words(&orbit.place().assembly);
        assert!(words.iter().all(|word| told.contains(word)), "{told}");
        assert!(orbit.is_certified(), "{:?}", orbit.violation());
        assert!(orbit.check_by_motion().unwrap() < ROUNDING);
        let (assembly, (time, state)) = (orbit.place().assembly.clone(), orbit.middle_state());
        let columns: Vec<By> = (0..4).map(By::Start).collect();
        let mut motion = Differentiated::from_state(assembly, time, &state, &columns).unwrap();
        motion.advance_to(time + orbit.period()).unwrap();
        let column = |p: usize| motion.state_derivative(p).unwrap_or_else(|| panic!("{:?}", motion.lost(p)));
        let map = DMatrix::from_vec(4, 4, (0..4).flat_map(column).collect());
        let mut own: Vec<f64> = map.complex_eigenvalues().iter().map(|m| m.norm()).collect();
        own.sort_by(|a, b| b.total_cmp(a));
        // The tail's position is neutral.
        assert!((own.remove(0) - 1.0).abs() < ROUNDING);
        assert_eq!(orbit.multipliers().len(), own.len());
        for (a, b) in orbit.multipliers().iter().zip(&own) {
            assert!((a.norm() - b).abs() < ROUNDING, "{:?} {own:?}", orbit.multipliers());
        }
    }
}
