//! Orbits without restitution, whose block leaves its stop at zero speed.

use crate::paper::{Family, Label, OrbitWord, PathOptions, Span, branch};
use vibro_impact::parameters::Parameters;
use vibro_impact::simulator::{Contact, Simulator};
use vibro_studies::paper::{ParameterSet, find_group};

/// Tolerance for a zero acceleration after an impact, units of ω1² L.
const NONE: f64 = 1e-9;

/// The branch of symmetric orbits ends where the acceleration after the impact begins to point to
/// the stop: beyond this, the block would stay. There the block passes the stop slightly, which is
/// neither certified as clear nor taken for a touch.
#[test]
fn invariant_a_block_that_would_stay_on_its_stop_has_no_orbit_and_no_touch() {
    let machine = [
        ("epsilon", 0.026_087_991_774_455),
        ("kappa", 0.0),
        ("f10", 2.640_458_534_731),
        ("gamma1", 0.187_257_704_655),
        ("sigma30", 0.362_766_045_886),
        ("gamma3", 0.014_147_036_644),
        ("beta2", 0.103_631_888_646),
    ];
    let set = machine.iter().fold(ParameterSet::basic(), |set, (name, value)| {
        set.with(find_group(name).unwrap(), *value).unwrap()
    });
    let family = Family::new(&set, Span::new(find_group("sigma1").unwrap(), -0.6, 2.0).unwrap()).unwrap();
    let word = OrbitWord::new("U", -1, 1).unwrap();
    let found = branch(&family, &word, &[0.117], 1.9, &PathOptions::default(), &[]).unwrap();
    let ends = [&found.points[0], &found.points[found.points.len() - 1]];
    let end = ends
        .into_iter()
        .find(|end| (end.value - 1.8963).abs() < 1e-4)
        .expect("an end where the block would stay");
    assert_eq!(end.label(), Some(Label::NoConvergence));
    for point in found.points.iter().filter(|point| point.label() != Some(Label::Grazing)) {
        let orbit = found.orbit(&family, point).unwrap();
        let (p, theta) = (*orbit.system().parameters(), orbit.phases()[0]);
        let state = orbit.state(theta);
        let force =
            p.drive_amplitude * theta.sin() - p.box_stiffness * state.x[0] - p.box_damping * state.v[0];
        let coupling = p.coupling_stiffness * (state.x[1] - state.x[2]);
        let acceleration = -coupling / p.block_mass - force / p.box_mass;
        assert!(
            acceleration < NONE * p.stop_gap * p.drive_frequency.powi(2),
            "{} {acceleration}",
            point.value
        );
        // In the simulator the block, which hits the other stop half a period later, has left it
        // again.
        let start = theta + 1.0;
        let mut simulator =
            Simulator::new(&Parameters { drive_phase: start, ..p }, &orbit.state(start), 0.0).unwrap();
        simulator.advance_to((std::f64::consts::PI - 1.0 + 1e-5) / p.drive_frequency).unwrap();
        assert_eq!((simulator.impacts().lower, simulator.contact()), (1, Contact::Flight), "{}", point.value);
    }
}
