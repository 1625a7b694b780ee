//! Orbits on which motions have settled against the simulator's verdict.

use crate::paper::{Orbit, System, orbit_of, settle};
use std::time::Instant;
use vibro_impact::State;
use vibro_impact::parameters::Parameters;
use vibro_studies::paper::trajectories::Start;
use vibro_studies::paper::verdict::verdict;
use vibro_studies::paper::{ParameterSet, find_group};
use vibro_studies::{MotionClass, Result};

const START: State = State { x: [0.0; 3], v: [0.0, 0.5, 0.0] };

fn settled(p: &Parameters, periods: u32) -> Result<Orbit> {
    let system = System::new(p)?;
    orbit_of(&system, &settle(&system, &START, periods)?)
}

/// Near a doubling, a settled motion returns to within 2e-3 in half of its period, near the orbit
/// that is no longer stable. A motion on a still stable orbit approaches it from alternating
/// sides.
#[test]
fn second_method_orbits_next_to_a_doubling() {
    let secondary = Parameters { secondary_stiffness: 0.0, stop_restitution: 0.9, ..Parameters::default() };
    for (p, amplitude, period) in [
        (secondary, 1.8, 4),
        (Parameters { coupling_stiffness: 1e-4, ..Parameters::default() }, 2.1, 8),
        (Parameters::default(), 0.28, 1),
        (Parameters::default(), 1.078, 1),
    ] {
        let p = Parameters { drive_amplitude: amplitude, ..p };
        let orbit = settled(&p, 6000).unwrap();
        assert!(orbit.is_stable() && orbit.word().period() == period, "{amplitude} {}", orbit.word());
        let class = verdict(&Start { parameters: p, state: START }, 2000).unwrap().class;
        assert_eq!(class, MotionClass::Periodic(period), "{amplitude}");
    }
}

/// A period doubling of UUL+ is at f10 = 2.802205439. This close to it, the settled motion nearly
/// returns in two periods. Newton's method leaves the two repetitions different by more than
/// rounding, or so far apart that they miss their stops.
#[test]
fn invariant_an_orbit_next_to_its_doubling_is_not_passed_twice() {
    for below in [1e-5, 1e-6, 1e-7] {
        let set = ParameterSet::basic().with(find_group("f10").unwrap(), 2.802205439 - below).unwrap();
        for periods in [3000, 10_000] {
            let orbit = settled(set.parameters(), periods).unwrap();
            let found = (orbit.word().len(), orbit.word().period(), orbit.is_stable());
            assert_eq!(found, (3, 1, true), "{below} {periods} {}", orbit.word());
        }
    }
}

/// Nine fast impacts per period determine contact less accurately than 1e-12 gaps. The motion is
/// periodic whichever period Newton's method starts from.
#[test]
fn second_method_fast_impacts_of_settled_motions_are_an_orbit() {
    for (amplitude, impacts) in [(1.82, 7), (2.964, 9)] {
        let p = Parameters { drive_amplitude: amplitude, stop_restitution: 0.9, ..Parameters::default() };
        for more in 0..40 {
            let orbit =
                settled(&p, 2000 + more).unwrap_or_else(|error| panic!("{amplitude} {more}: {error}"));
            let found = (orbit.word().len(), orbit.word().period(), orbit.is_certified());
            assert_eq!(found, (impacts, 1, true), "{amplitude} {more}: {}", orbit.word());
        }
    }
}

/// Newton's method ends if rounding leaves fewer than twelve digits of the phases.
#[test]
fn second_method_steps_that_rounding_keeps_up_end() {
    let p = Parameters { drive_amplitude: 5.838, ..Parameters::default() };
    // A state on the motion, so that no transient depends on the last digits.
    let start = State {
        x: [-14.049223986757433, -13.599320953809062, 24.820027180061036],
        v: [-23.782946830758004, -27.22130001084083, -4.803150414870151],
    };
    let system = System::new(&p).unwrap();
    let state = settle(&system, &start, 3000).unwrap();
    let orbit = orbit_of(&system, &state).unwrap();
    assert!(orbit.word().period() == 1 && orbit.is_stable(), "{}", orbit.word());
    let class = verdict(&Start { parameters: p, state }, 0).unwrap().class;
    assert_eq!(class, MotionClass::Periodic(1));
}

/// Chaos with 900 impacts per period: words of more than 1024 impacts are not tried, since their
/// equations would take hours.
#[test]
fn words_of_more_than_a_thousand_impacts_are_not_tried() {
    let p = Parameters {
        box_damping: 1.8795186817407998,
        block_mass: 0.00718511127032136,
        secondary_damping: 0.004826389512857791,
        coupling_stiffness: 0.04773359740113498,
        stop_restitution: 0.9964692760367297,
        drive_amplitude: 5.160435214912685,
        drive_frequency: 0.06567821074714303,
        ..Parameters::default()
    };
    let error = settled(&p, 20).unwrap_err().to_string();
    assert!(error.contains("within 1024 impacts"), "{error}");
}

/// Chaos with a hundred impacts per period nearly returns near an unstable orbit. Words of more
/// periods, up to thousands of impacts, are not tried in search of a stable one.
#[test]
fn second_method_chaos_of_many_impacts_has_its_near_return_soon() {
    /// Time limit, s: half a second suffices on an idle machine; all words would take minutes.
    const SOON: u64 = 30;
    let p =
        Parameters { drive_amplitude: 33.491260524620834, stop_restitution: 0.9, ..Parameters::default() };
    let begun = Instant::now();
    let orbit = settled(&p, 4000).unwrap();
    assert!(!orbit.is_stable() && orbit.word().len() > 100, "{}", orbit.word());
    assert!(begun.elapsed().as_secs() < SOON, "{:?}", begun.elapsed());
}
