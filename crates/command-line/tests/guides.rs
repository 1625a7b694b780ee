//! The commands of the recipes of docs/paper-machine.md, unchanged, compared with closed forms and
//! the library, and the lessons.

#[path = "common/mod.rs"]
mod command;
#[path = "common/guide.rs"]
mod guide;
#[path = "guides/lessons.rs"]
mod lessons;

use guide::Guide;
use std::f64::consts::TAU;
use vibro_impact::load::{Body, Interpolation, Load};
use vibro_impact::simulator::{Loads, Pause};
use vibro_impact::{Parameters, Simulator, State};

/// Rounding of a linear motion over hundreds of periods, relative to its amplitude.
const LINEAR: f64 = 1e-12;
/// Rounding of a motion with some tens of impacts, reached in other steps, m.
const ROUNDING: f64 = 1e-12;

/// The machine of the page.
fn machine() -> Parameters {
    Parameters {
        box_mass: 12.0,
        box_stiffness: 48e3,
        box_damping: 30.0,
        block_mass: 1.2,
        secondary_mass: 1.2,
        secondary_stiffness: 4800.0,
        secondary_damping: 5.0,
        coupling_stiffness: 0.0,
        stop_gap: 0.015,
        stop_restitution: 0.6,
        drive_amplitude: 75.0,
        drive_frequency: 10.0 * TAU,
        drive_phase: 0.0,
        constant_loads: [0.0; 3],
    }
}

/// Differences of the last row of a run from a simulator's displacements.
fn differences(last: &[f64], simulator: &Simulator) -> [f64; 3] {
    std::array::from_fn(|i| (last[1 + i] - simulator.state().x[i]).abs())
}

/// Two flanks of the same speed in each period: the part is thrown from one to the other.
#[test]
fn golden_what_coding_assistants_are_told() {
    let guide = Guide::at("../../AGENTS.md");
    let said = guide.perform("agents", &[]);
    assert!(said[0].contains("Rattle"), "{}", said[0]);
    let impacts = guide::texts("agents", "run/events.csv").iter().filter(|row| row[1] == "impact").count();
    assert!(impacts > 40, "{impacts}");
    assert_eq!(guide::rows("agents", "sweep/sweep.csv").len(), 5);
    assert!(guide::texts("agents", "orbit/orbit-events.csv").len() > 1);
}

#[test]
fn closed_form_of_the_recipes() {
    let guide = Guide::read("paper-machine.md");
    guide.perform("recipes", &[]);

    // Without the block: the linear oscillator.
    let p = machine();
    let (k, c) =
        (p.box_stiffness - p.box_mass * p.drive_frequency.powi(2), p.box_damping * p.drive_frequency);
    let (amplitude, lag) = (p.drive_amplitude / k.hypot(c), c.atan2(k));
    let rows = guide::rows("recipes", "without-block/run.csv");
    assert!(rows.len() > 2000);
    for row in &rows {
        let closed = amplitude * (p.drive_frequency * row[0] - lag).sin();
        assert!((row[1] - closed).abs() < LINEAR * amplitude, "{row:?} {closed}");
    }

    // The record, compared with the library with the same interpolant.
    let samples = [(0.0, 0.0), (0.01, 900.0), (0.02, 1200.0), (0.03, 450.0), (0.04, 0.0)];
    let record = Load::new(Body::Box, &samples, Interpolation::Linear).unwrap();
    let silent = Parameters { drive_amplitude: 0.0, ..p };
    let mut simulator = Simulator::new(&silent, &State::default(), 0.0).unwrap();
    simulator.advance_under(&[record], 1.0, Pause::Never, None).unwrap();
    assert!(simulator.impacts().upper > 4);
    let rows = guide::rows("recipes", "record/run.csv");
    let last = rows.last().unwrap();
    assert!(last[0] == 1.0 && differences(last, &simulator).iter().all(|d| *d < ROUNDING), "{last:?}");

    // Tilted: springs and weights, with the weights as rounded in the files.
    let rows = guide::rows("recipes", "tilted/run.csv");
    let last = rows.last().unwrap();
    assert!((last[1] + (20.4417 + 2.04417) / 48e3).abs() < ROUNDING && last[4] == -0.015, "{last:?}");

    // Standing: the heavy block hits the lower stop more often than the upper one; lying, both
    // equally often.
    let rows = guide::rows("recipes", "standing/sweep.csv");
    assert!(rows.len() == 7 && rows[0][0] == -11.772 && rows[6][0] == 0.0, "{rows:?}");
    let more_below = |row: &Vec<f64>| row[3] - row[2];
    assert!(more_below(&rows[0]) > 0.0 && more_below(&rows[6]).abs() < more_below(&rows[0]), "{rows:?}");

    // Off centre, compared with the library with constant loads.
    let coupled = Parameters { coupling_stiffness: 2000.0, ..p };
    let mut loads = Loads::default();
    (loads.derivatives[1][0], loads.derivatives[2][0]) = (-4.0, 4.0);
    let mut simulator = Simulator::new(&coupled, &State::default(), 0.0).unwrap();
    simulator.set_loads(&loads).unwrap();
    simulator.advance_to(2.0).unwrap();
    let rows = guide::rows("recipes", "off-centre/run.csv");
    let last = rows.last().unwrap();
    assert!(last[0] == 2.0 && differences(last, &simulator).iter().all(|d| *d < ROUNDING), "{last:?}");
}

/// The commands of docs/derivatives.md; its Python blocks are run by tests/python/test_guide.py.
#[test]
fn closed_form_of_the_page_of_derivatives() {
    Guide::read("derivatives.md").perform("derivatives", &[]);
    // The last impact of the ball before 2 s is the third: 2 (1 + 2e) t₁; derivative by e.
    let (events, by) = (
        guide::rows("derivatives", "ball/events.csv"),
        guide::rows("derivatives", "ball/event-derivatives.csv"),
    );
    assert_eq!(events.len(), by.len());
    let t = (2.0 / 9.81f64).sqrt();
    assert!((by[2][1] - 2.0 * (1.0 + 2.0 * 0.9) * t).abs() < LINEAR, "{by:?}");
    // The derivative by the start's number is 1 at the start, for this number alone.
    let first = &guide::rows("derivatives", "second/derivatives.csv")[0];
    // time; s, v, a of the box; s, v of the block.
    assert_eq!(first[..6], [0.5, 0.0, 0.0, 0.0, 0.0, 1.0]);
}
