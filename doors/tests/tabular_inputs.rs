//! An input of a table that a host sets for the course of a step, by its callback.

use fmi_doors::hybrid::Pieces;
use fmi_doors::log::Silence;
use fmi_doors::tabular::{FromTable, Row, Tabular};
use fmi_doors::{Bases, Component, EventHandling, Instantiation, Interface, Model, Piece, Version};

/// y follows u: y' = u - y.
enum Lag {}

const TIME: usize = 0;
const U: usize = 1;
const Y: usize = 2;
const RATE: usize = 3;

impl Tabular for Lag {
    const NAME: &'static str = "Lag";
    const IDENTIFIER: &'static str = "lag";
    const DESCRIPTION: &'static str = "A first-order lag";
    const VERSION: &'static str = "1.0";
    const ROWS: &'static [Row] = &[
        Row::time("time"),
        Row::input("u", "1", 0.0, "What is followed"),
        Row::state("y", "1", 0.0, "What follows"),
        Row::derivative("der(y)", "1/s", Y, "Its rate"),
    ];

    fn evaluate(x: &mut [f64]) {
        x[RATE] = x[U] - x[Y];
    }

    fn advance(x: &mut [f64], time: f64) {
        x[Y] = x[U] + (x[Y] - x[U]) * (-(time - x[TIME])).exp();
    }
}

fn read(lag: &mut FromTable<Lag>, place: usize) -> f64 {
    let mut value = f64::NAN;
    lag.get(Bases::REAL, &[place as u32 + 1], |_, x| value = x).unwrap();
    value
}

/// The input is held in each of 16 parts of a step, at its value in their middle: the square of a
/// part over 24 is left of the answer to a ramp.
#[test]
fn closed_form_answer_of_a_lag_to_a_ramp_in_a_step() {
    const STEP: f64 = 0.5;
    const LEFT: f64 = (STEP / 16.0) * (STEP / 16.0) / 24.0;
    let token = FromTable::<Lag>::token();
    let mut lag = FromTable::<Lag>::instantiate(&Instantiation {
        version: Version::Fmi3,
        interface: Interface::CoSimulation,
        handling: EventHandling::default(),
        name: "lag",
        token: &token,
        resources: None,
    })
    .unwrap();
    lag.enter_initialization();
    lag.exit_initialization(&mut Silence).unwrap();
    let mut pieces = Pieces::begin(&lag, 0.0, STEP).unwrap();
    pieces.interpolate(&mut lag, U as u32 + 1, [0.0, 1.0, 2.0, 3.0].map(|k| k / 3.0 * STEP));
    pieces.start(&mut lag, &mut Silence).unwrap();
    assert_eq!(pieces.next(&mut lag, None, &mut Silence).unwrap(), Piece::End);
    let ended = pieces.end(&mut lag);
    assert_eq!((ended.time, ended.event, ended.early), (STEP, false, false));
    let answer = |t: f64| t - 1.0 + (-t).exp();
    let y = read(&mut lag, Y);
    assert!((y - answer(STEP)).abs() < LEFT, "{y} {}", answer(STEP));
    // From the step's end on it holds the value that it has there.
    assert!((read(&mut lag, U) - STEP).abs() < f64::EPSILON);
    lag.step_as_agreed(STEP, STEP, &mut Silence).unwrap();
    let held = STEP + (answer(STEP) - STEP) * (-STEP).exp();
    assert!((read(&mut lag, Y) - held).abs() < LEFT);
}
