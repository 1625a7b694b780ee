//! Snapshots of the work counters: a loss of efficiency shows as a changed count, on any machine.
//! After a change that is meant to do other work: `INSTA_UPDATE=always cargo test --test work`.

use vibro_impact::{Groups, Parameters, Scales, Simulator, State};

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
    // Twenty: later the transient multiplies round-off, and counts differ between mathematical libraries.
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
    /// Sub-steps, expansions and events a period that no value of the sweep needs.
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
