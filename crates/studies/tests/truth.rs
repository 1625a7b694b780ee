//! The engine against the truth suite (`truth/`): states and events in 30 digits, made by a program
//! that shares no code with it. Errors are divided by the magnification of roundings in the tables.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::Event;
use vibro_machine::{Assembly, Motion};
use vibro_studies::{columns, named, values};

/// Largest error of a state, divided by its magnification: some ten roundings.
const STATES: f64 = 2e-15;
/// The same bound for thousands of stiff sub-steps, gaps of a ten-thousandth of the path, and the
/// edges of contacts with an exponent.
const STATES_OF_STIFF: f64 = 4e-13;
const STIFF: [&str; 4] = ["cradle", "gear_backlash", "hertz_bounce", "hunt_crossley"];
/// Largest error of an event's time, divided by its magnification.
const TIMES: f64 = 2e-13;

type Row = Vec<String>;

fn table(path: &Path) -> Vec<Row> {
    let text = fs::read_to_string(path).expect("a table of the truth suite");
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

fn number(text: &str) -> f64 {
    text.parse().expect("a number of the truth suite")
}

/// A motion that takes the inputs of `input.csv`: straight lines from row to row.
struct Driven {
    motion: Motion,
    inputs: Vec<[f64; 2]>,
    events: Vec<Event>,
}

impl Driven {
    fn of(case: &Path) -> Self {
        let text = fs::read_to_string(case.join("machine.toml")).expect("a machine");
        let machine = parse(&text, "machine.toml", &no_records).expect("a valid machine");
        let assembly = Arc::new(Assembly::new(machine).expect("a machine that can move"));
        let file = case.join("input.csv");
        let rows = if file.exists() { table(&file) } else { Vec::new() };
        let inputs = rows.iter().skip(1).map(|row| [number(&row[0]), number(&row[1])]).collect();
        let mut events = Vec::new();
        let motion =
            Motion::new_observed(assembly, &mut |event| events.push(event.clone())).expect("a start");
        let mut driven = Self { motion, inputs, events };
        driven.set_input();
        driven
    }

    fn set_input(&mut self) {
        let now = self.motion.time();
        let line = self.inputs.windows(2).find(|w| w[0][0] == now && w[1][0] > now);
        if let Some([[begin, value], [end, later]]) = line {
            let slope = (later - value) / (end - begin);
            self.motion.set_input(0, [*value, slope, 0.0, 0.0]).expect("an input");
        }
    }

    fn advance_to(&mut self, time: f64) {
        let due: Vec<f64> = self.inputs.iter().map(|row| row[0]).collect();
        let now = self.motion.time();
        for stop in due.into_iter().filter(|&t| t > now && t <= time).chain([time]) {
            let events = &mut self.events;
            self.motion.advance_observed(stop, &mut |event| events.push(event.clone())).expect("a motion");
            self.set_input();
        }
    }
}

/// Largest error of a state, divided by its magnification. If a time has two rows, before and after an
/// event, the nearer one counts: rounding decides whether the event has happened.
fn states_off(driven: &mut Driven, truth: &[Row]) -> f64 {
    let names = &truth[0];
    let states = names.iter().filter(|name| !name.ends_with("magnification")).count();
    let all = columns(&driven.motion.assembly().description);
    let places: Vec<usize> =
        names[1..states].iter().map(|name| all.iter().position(|c| c == name).expect("a column")).collect();
    let mut worst = 0.0f64;
    for rows in truth[1..].chunk_by(|a, b| a[0] == b[0]) {
        driven.advance_to(number(&rows[0][0]));
        let now = values(&driven.motion);
        let off = |row: &Row| {
            let magnified = |(k, &place): (usize, &usize)| {
                (now[place] - number(&row[1 + k])).abs() / number(&row[states + k])
            };
            places.iter().enumerate().map(magnified).fold(0.0, f64::max)
        };
        worst = worst.max(rows.iter().map(off).fold(f64::INFINITY, f64::min));
    }
    worst
}

/// Largest error of a required event's time, divided by its magnification. Each is matched with the
/// nearest event of its kind and element: a stop at rest that takes a share of an impulse opens and
/// closes in the same instant, which the tables leave out.
fn times_off(driven: &Driven, truth: &[Row]) -> f64 {
    let assembly = driven.motion.assembly();
    let mut worst = 0.0f64;
    for row in truth[1..].iter().filter(|row| row[5] == "yes") {
        let of_key = |event: &&Event| {
            let event = named(assembly, &event.kind);
            (event.kind, event.element.as_str()) == (row[1].as_str(), row[2].as_str())
        };
        let off = driven.events.iter().filter(of_key).map(|event| (event.time - number(&row[0])).abs());
        worst = worst.max(off.fold(f64::INFINITY, f64::min) / number(&row[4]));
    }
    worst
}

#[test]
fn second_method_the_engine_moves_as_the_truth_suite_says() {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../truth/cases"));
    let mut count = 0;
    for entry in fs::read_dir(folder).expect("the truth suite") {
        let case = entry.expect("a case").path();
        let mut driven = Driven::of(&case);
        let states = states_off(&mut driven, &table(&case.join("truth.csv")));
        let times = times_off(&driven, &table(&case.join("events.csv")));
        println!("{}: states {states:.1e}, events {times:.1e}", case.display());
        let stiff = STIFF.iter().any(|name| case.ends_with(name));
        assert!(states <= if stiff { STATES_OF_STIFF } else { STATES }, "{}: {states:e}", case.display());
        assert!(times <= TIMES, "{}: {times:e}", case.display());
        count += 1;
    }
    assert!(count >= 30, "cases: {count}");
}
