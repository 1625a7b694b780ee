//! Snapshots of the work counters, which show a loss of efficiency on any machine. After an
//! intended change of the work: `INSTA_UPDATE=always cargo test --test work`.

use vibro_impact::model::Model;
use vibro_impact::simulator::{Loads, advance_together};
use vibro_impact::{Error, Groups, Parameters, Scales, Simulator, State};

fn work(p: &Parameters, periods: f64) -> String {
    let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    let mut simulator = Simulator::new(p, &start, 0.0).unwrap();
    simulator.advance_to(periods * p.period()).unwrap();
    format!("{:?}", simulator.work_counters())
}

fn weak(kappa: f64, f10: f64) -> Parameters {
    Groups { kappa, f10, ..Groups::basic() }.to_parameters(Scales::default()).unwrap()
}

#[test]
fn golden_work_of_twenty_periods_of_the_standard_case() {
    // Only twenty periods, as the transient then amplifies rounding, and counts differ between
    // mathematical libraries.
    let p = Groups::weak(0.1, 0.75, 1.5, 0.0, 0.4, 0.2, 0.0, 0.4).to_parameters(Scales::default()).unwrap();
    insta::assert_snapshot!(work(&p, 20.0));
}

#[test]
fn golden_work_of_the_stable_two_impact_motion() {
    insta::assert_snapshot!(work(&weak(0.75, 1.5), 200.0));
}

#[test]
fn golden_work_of_motion_with_rest() {
    insta::assert_snapshot!(work(&weak(0.0, 3.0), 20.0));
}

#[test]
fn invariant_the_sweep_of_the_paper_ends_everywhere() {
    /// Bound on sub-steps, expansions and events per period, for all values of the sweep.
    const MANY: u64 = 200;
    const PERIODS: u64 = 120;
    for i in 0..=450 {
        let p = weak(0.75, 0.5 + 0.01 * f64::from(i));
        let mut simulator = Simulator::new(&p, &State { x: [0.0; 3], v: [0.1, 0.0, 0.0] }, 0.0).unwrap();
        simulator.advance_to(PERIODS as f64 * p.period()).unwrap();
        let work = simulator.work_counters();
        let total = work.substeps + work.expansions + work.events;
        assert!(total < MANY * PERIODS, "f10 = {}: {work:?}", 0.5 + 0.01 * f64::from(i));
    }
}

/// Largest number of sub-steps of an advance over `span` s in lanes: 10⁶, 64 per sub-step length
/// (2.4 over the fastest rate, here over 0.1 s), and the 64 between two checks of the limit.
fn most_substeps(span: f64) -> f64 {
    1e6 + 64.0 * span / 0.1 + 64.0
}

fn substeps(simulator: &Simulator) -> f64 {
    simulator.work_counters().substeps as f64
}

/// Motions that hardly progress: a block pressed against an elastic stop, and a block that is much
/// too fast, without and with loads.
fn busy_motions() -> Vec<Simulator> {
    let elastic = Parameters { stop_restitution: 1.0, ..Parameters::default() };
    let pressed = Parameters {
        box_stiffness: 0.0,
        coupling_stiffness: 0.0,
        drive_frequency: 0.0,
        drive_phase: std::f64::consts::FRAC_PI_2,
        drive_amplitude: -100.0,
        ..elastic
    };
    let at_stop = State { x: [0.0, 1.0, 0.0], v: [0.0, -3e-5, 0.0] };
    let fast = State { x: [0.0; 3], v: [0.0, 1e6, 0.0] };
    let mut loaded = Simulator::new(&elastic, &fast, 0.0).unwrap();
    loaded.set_loads(&Loads { derivatives: [[0.1, 0.0, 0.0, 0.0]; 3] }).unwrap();
    vec![
        Simulator::new(&pressed, &at_stop, 0.0).unwrap(),
        Simulator::new(&elastic, &fast, 0.0).unwrap().without_energy_accounts(),
        loaded,
    ]
}

#[test]
fn invariant_one_advance_ends_soon_and_another_goes_on() {
    const END: f64 = 1000.0;
    /// Imbalance of energies over a million impacts, relative to the largest energy.
    const BALANCE: f64 = 1e-6;
    for mut simulator in busy_motions() {
        let first = simulator.energy_accounts().mechanical;
        for _ in 0..2 {
            let (begin, before) = (simulator.time(), substeps(&simulator));
            let error = simulator.advance_to(END).unwrap_err();
            let Error::WorkLimit { time, span, events, .. } = error else { panic!("{error}") };
            assert!(time == simulator.time() && time > begin && time < END && events > 1000, "{error}");
            assert!((span - (time - begin)).abs() <= 4.0 * f64::EPSILON * time, "{error}");
            let spent = substeps(&simulator) - before;
            // A single motion checks the count after each sub-step.
            let more = 64.0 * span * Model::new(simulator.parameters()).unwrap().rate / 2.4;
            assert!(spent > 1e6 && spent <= 1e6 + 1.0 + more, "{spent} sub-steps: {error}");
            assert!(simulator.relative_motion().0.abs() <= 1.0);
            let e = simulator.energy_accounts();
            if e.input != 0.0 {
                let error = e.mechanical - first - e.input + e.damped + e.impact;
                assert!(error.abs() < BALANCE * e.mechanical, "{error:e} of {e:?}");
            }
            let said = error.to_string();
            let named = ["stop.restitution", "Remedy", "smaller steps", &time.to_string()];
            assert!(named.iter().all(|part| said.contains(part)), "{said}");
        }
        // Smaller steps succeed.
        let step = 1e-3 * (simulator.time() / 3.0);
        for n in 1..=10 {
            let end = simulator.time() + step;
            simulator.advance_to(end).unwrap_or_else(|e| panic!("step {n}: {e}"));
        }
    }
}

#[test]
fn invariant_the_lanes_have_the_same_limit() {
    let together: Vec<Simulator> =
        busy_motions().into_iter().take(2).map(Simulator::without_energy_accounts).collect();
    let mut together = [together.clone(), together].concat();
    for result in advance_together(&mut together, |_| 1000.0) {
        assert!(matches!(result, Err(Error::WorkLimit { .. })), "{result:?}");
    }
    for simulator in &mut together {
        assert!(substeps(simulator) < most_substeps(simulator.time()), "{:?}", simulator.work_counters());
        let now = simulator.time();
        simulator.advance_to(1.001 * now).unwrap();
    }
}

#[test]
fn second_method_elastic_bounces_come_to_the_same_end_in_lanes() {
    /// End, so late that in lanes bounces of 0.65 intervals, each of two sub-steps, take more
    /// sub-steps than 10⁶ and 32 for each sub-step length. Alone a bounce takes one sub-step.
    const END: f64 = 144_000.0;
    /// Relative change of the number of impacts by rounding.
    const ROUND_OFF: f64 = 1e-4;
    let p = Parameters {
        box_mass: 1.0,
        box_stiffness: 1.0,
        box_damping: 0.0,
        block_mass: 1e-9,
        secondary_mass: 1e6,
        secondary_stiffness: 0.0,
        coupling_stiffness: 1e-11,
        stop_gap: 1.0,
        stop_restitution: 1.0,
        drive_amplitude: 0.0,
        drive_frequency: 0.0,
        ..Parameters::default()
    };
    let bounce = 0.65 * 0.15 / Model::new(&p).unwrap().rate;
    let pull = 0.01; // m/s², by the coupling to the body at 2 m that hardly moves
    let start = State { x: [0.0, 1.0, 2.0], v: [0.0, -0.5 * pull * bounce, 0.0] };
    let mut alone = Simulator::new(&p, &start, 0.0).unwrap().without_energy_accounts();
    let mut together = [alone.clone()];
    alone.advance_to(END).unwrap();
    assert_eq!(advance_together(&mut together, |_| END), [Ok(())]);
    let [impacts, expected] = [&together[0], &alone].map(|s| s.impacts().upper as f64);
    assert!((impacts - expected).abs() <= ROUND_OFF * expected, "{impacts} and {expected}");
}
