//! Springs of zero or almost zero stiffness (docs/theory.md (112)) against the closed form of the
//! symmetric motion, the simulator and its verdict.

use crate::paper::{Orbit, OrbitWord, System, orbit_of, settle};
use vibro_impact::parameters::Parameters;
use vibro_impact::steady::exact_orbit;
use vibro_impact::{Simulator, State};
use vibro_studies::MotionClass;
use vibro_studies::paper::trajectories::Start;
use vibro_studies::paper::verdict::verdict;

/// Tolerance between phases found in two ways: rounding of a flight times the sensitivity of the
/// orbit.
const CLOSED_FORM: f64 = 1e-12;

const START: State = State { x: [0.0; 3], v: [0.0, 0.5, 0.0] };

/// Drive periods for a transient to die out; all multipliers are below 0.95.
const SETTLED: u32 = 2000;

fn soft(body: &str, stiffness: f64, amplitude: f64) -> Parameters {
    let mut p = Parameters { drive_amplitude: amplitude, ..Parameters::default() };
    match body {
        "box" => p.box_stiffness = stiffness,
        "block" => p.coupling_stiffness = stiffness,
        _ => p.secondary_stiffness = stiffness,
    }
    p
}

fn word(text: &str, closing: i8, half_periods: u32) -> OrbitWord {
    OrbitWord::new(text, closing, half_periods).unwrap()
}

#[test]
fn closed_form_of_the_symmetric_orbit_beside_a_missing_spring() {
    for (body, stiffness, amplitude) in [
        ("box", 0.0, 0.5),
        ("box", 1e-30, 0.8),
        ("box", 1e-6, 0.8),
        ("secondary", 0.0, 1.5),
        ("secondary", 1e-12, 2.5),
    ] {
        let p = soft(body, stiffness, amplitude);
        let exact = exact_orbit::solve(&p).unwrap().upper.unwrap();
        let system = System::new(&p).unwrap();
        let first = exact.drive_phase();
        let half = Orbit::find(&system, &word("U", -1, 1), &[first + 0.02]).unwrap();
        // Closed with +, the equations have a singular matrix without an anchor.
        let guess = [first + 0.02, first + 0.01 + std::f64::consts::PI];
        let whole = Orbit::find(&system, &word("UL", 1, 2), &guess).unwrap();
        for orbit in [&half, &whole] {
            assert!((orbit.phases()[0] - first).abs() < CLOSED_FORM, "{body} {stiffness} {}", orbit.word());
            for theta in [0.0, 1.0, 2.5, 4.0] {
                let (own, closed) = (orbit.state(theta), exact.state(theta));
                let pairs = own.x.iter().chain(&own.v).zip(closed.x.iter().chain(&closed.v));
                assert!(
                    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < CLOSED_FORM,
                    "{body} {stiffness}"
                );
            }
        }
        assert_eq!(half.is_certified(), exact.is_clear());
        let radius = whole.spectral_radius() - exact.spectral_radius().powi(2);
        assert!(radius.abs() < 10.0 * CLOSED_FORM, "{body} {stiffness} {radius}");
    }
}

/// A damped body without a spring may rest anywhere, and an undamped body keeps oscillating. Both
/// have a multiplier of modulus 1, which rounding makes slightly more or less.
#[test]
fn closed_form_without_impacts_a_neutral_body_makes_no_stable_orbit() {
    let held = Parameters { drive_amplitude: 0.05, ..Parameters::default() };
    for damping in [0.02, 0.05, 0.1, 0.15] {
        let held = Parameters { box_damping: damping, ..held };
        for drive_frequency in [0.8, 1.0, 1.04, 1.3] {
            for (p, stable) in [
                (held, true),
                (Parameters { box_stiffness: 0.0, ..held }, false),
                (Parameters { secondary_stiffness: 0.0, ..held }, false),
                (Parameters { coupling_stiffness: 0.0, ..held }, false),
                (Parameters { secondary_damping: 0.0, ..held }, false),
            ] {
                let system = System::new(&Parameters { drive_frequency, ..p }).unwrap();
                for (closing, half_periods) in [(-1, 1), (1, 2)] {
                    let orbit = Orbit::find(&system, &word("", closing, half_periods), &[]).unwrap();
                    assert_eq!(orbit.is_stable(), stable, "{p:?} {drive_frequency}");
                }
            }
        }
    }
}

/// The period of the settled orbit equals the period of the simulator's verdict, however soft a
/// body's spring is.
#[test]
fn second_method_settled_orbits_have_the_period_of_the_verdict() {
    /// Tolerance for a transient's remainder, and rounding of times after thousands of periods.
    const RETURN: f64 = 1e-9;
    for (body, amplitude, periods) in
        [("box", 0.5, 1), ("box", 1.2, 1), ("box", 2.0, 2), ("block", 0.6, 1), ("secondary", 0.3, 1)]
    {
        for stiffness in [0.0, 1e-30, 1e-14, 1e-8, 1e-6, 1e-4] {
            let p = soft(body, stiffness, amplitude);
            let class = verdict(&Start { parameters: p, state: START }, SETTLED).unwrap().class;
            let system = System::new(&p).unwrap();
            let found = settle(&system, &START, SETTLED).and_then(|state| orbit_of(&system, &state));
            let orbit = found.unwrap_or_else(|error| panic!("{body} {amplitude} {stiffness}: {error}"));
            let case = format!("{body} {amplitude} {stiffness}: {} {class:?}", orbit.word());
            assert_eq!((class, orbit.word().period()), (MotionClass::Periodic(periods), periods), "{case}");
            assert!(orbit.is_stable(), "{case}");
            let start = orbit.start_state();
            let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
            simulator.advance_to(f64::from(60 * periods) * p.period()).unwrap();
            let pairs = simulator.state();
            let moved = start.x.iter().zip(&pairs.x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(moved < RETURN, "{case} {moved}");
        }
    }
}

#[test]
fn settled_motions_whose_phases_determine_no_orbit_name_the_spring() {
    let p = Parameters { coupling_stiffness: 0.0, ..soft("box", 0.0, 0.5) };
    let system = System::new(&p).unwrap();
    let error = settle(&system, &START, SETTLED).and_then(|state| orbit_of(&system, &state)).unwrap_err();
    assert!(error.to_string().starts_with("box.k = 0"), "{error}");
}

#[test]
fn second_springs_too_soft_to_hold_a_body_are_named() {
    for (body, stiffness, amplitude, field) in
        [("box", 1e-11, 0.908, "box.k"), ("secondary", 1e-12, 0.329, "secondary.k")]
    {
        let p =
            Parameters { coupling_stiffness: 0.0, stop_restitution: 0.9, ..soft(body, stiffness, amplitude) };
        let system = System::new(&p).unwrap();
        let error = Orbit::find(&system, &word("UL", 1, 2), &[1.0, 4.1]).unwrap_err().to_string();
        assert!(error.starts_with(field), "{error}");
    }
}

/// A spring that would hold a load so far away that displacements overflow is named, with the
/// largest distance.
#[test]
fn loads_that_are_held_beyond_all_numbers_name_the_spring() {
    let basic = Parameters::default();
    for (p, loads, name) in [
        (Parameters { secondary_stiffness: 1e-300, ..basic }, [0.0, 0.0, 1e10], "secondary.k"),
        (Parameters { secondary_stiffness: 1e-320, ..basic }, [0.0, 0.01, 0.0], "secondary.k"),
        (Parameters { box_stiffness: 1e-320, ..basic }, [0.01, 0.0, 0.0], "box.k"),
        (Parameters { coupling_stiffness: 1e-320, ..basic }, [0.0, 0.01, -0.01], "coupling.k"),
    ] {
        let error = System::new(&Parameters { constant_loads: loads, ..p }).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{name} = ")) && error.contains("1e100"), "{error}");
    }
}

#[test]
fn words_that_push_a_box_without_a_spring_one_way_are_refused() {
    for (body, field) in [("box", "box.k"), ("secondary", "secondary.k")] {
        let system = System::new(&soft(body, 0.0, 2.0)).unwrap();
        let error = Orbit::find(&system, &word("LL", 1, 2), &[1.0, 3.0]).unwrap_err().to_string();
        assert!(error.contains(field) && error.contains("both U and L"), "{error}");
    }
}

/// A spring of almost zero stiffness would hold a load millions of gaps away. Impacts limit the
/// motion: it equals the motion without the spring, if the machine without it can bear the load.
#[test]
fn second_method_settled_orbits_under_loads_that_a_soft_spring_bears() {
    /// Tolerance for a transient's remainder, and rounding of times after thousands of periods.
    const RETURN: f64 = 1e-9;
    /// Tolerance for the effect of springs of up to 1e-10 N/m on bodies within the stops, times
    /// the sensitivity of the orbit.
    const TAKEN_UP: f64 = 1e-8;
    for (body, amplitude, load) in [
        ("box", 1.2, [0.01, 0.0, 0.0]),
        ("block", 0.6, [0.1, 0.004, 0.0]),
        ("secondary", 0.3, [0.1, 0.0, 0.004]),
    ] {
        let mut last: Option<Orbit> = None;
        for stiffness in [1e-30, 1e-14, 1e-12, 1e-10, 1e-8, 1e-6, 1e-5] {
            let p = Parameters { constant_loads: load, ..soft(body, stiffness, amplitude) };
            let class = verdict(&Start { parameters: p, state: START }, SETTLED).unwrap().class;
            let system = System::new(&p).unwrap();
            let found = settle(&system, &START, SETTLED).and_then(|state| orbit_of(&system, &state));
            let orbit = found.unwrap_or_else(|error| panic!("{body} {stiffness} {class:?}: {error}"));
            let case = format!("{body} {stiffness}: {} {class:?}", orbit.word());
            assert_eq!(class, MotionClass::Periodic(orbit.word().period()), "{case}");
            assert!(orbit.is_stable(), "{case}");
            let start = orbit.start_state();
            let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
            simulator.advance_to(f64::from(60 * orbit.word().period()) * p.period()).unwrap();
            let pairs = simulator.state();
            let moved = start.x.iter().zip(&pairs.x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(moved < RETURN, "{case} {moved}");
            if let Some(last) = last.filter(|_| stiffness <= 1e-10) {
                assert!(orbit.is_same(&last, TAKEN_UP), "{case} {:?} {:?}", orbit.phases(), last.phases());
            }
            last = Some(orbit);
        }
    }
}

/// A block on a spring of almost zero stiffness bears its load like a block without a spring.
#[test]
fn second_method_a_loaded_block_on_a_soft_spring_is_one_without_a_spring() {
    let loaded =
        |stiffness: f64| Parameters { constant_loads: [0.1, 0.004, 0.0], ..soft("block", stiffness, 0.6) };
    let system = System::new(&loaded(0.0)).unwrap();
    let free = orbit_of(&system, &settle(&system, &START, SETTLED).unwrap()).unwrap();
    let soft = Orbit::find(&System::new(&loaded(1e-30)).unwrap(), free.word(), free.phases()).unwrap();
    assert!(
        soft.is_certified() && soft.is_same(&free, CLOSED_FORM),
        "{:?} {:?}",
        soft.phases(),
        free.phases()
    );
    assert!((soft.spectral_radius() - free.spectral_radius()).abs() < CLOSED_FORM);
    for theta in [0.0, 1.0, 2.5, 4.0] {
        let (a, b) = (soft.state(theta), free.state(theta));
        let pairs = a.x.iter().chain(&a.v).zip(b.x.iter().chain(&b.v));
        assert!(pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < CLOSED_FORM, "{theta}");
    }
}
