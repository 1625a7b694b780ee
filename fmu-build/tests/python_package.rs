//! The Python package: installs it into a virtual environment, writes results of the library for
//! comparison, runs `tests/python/`.

mod common;

use fmu_build::kit::Kit;
use serde_json::{Value, json};
use std::fs;
use std::path::Path;
use std::sync::Arc;
use vibro_figures::canvas;
use vibro_impact::load::{Body, Interpolation, Load};
use vibro_impact::simulator::{Event, Pause};
use vibro_impact::{Parameters, Simulator, State};
use vibro_sketch::Sketch;
use vibro_studies::basin::{BasinRequest, StartAxis, basins};
use vibro_studies::diagram::diagram;
use vibro_studies::paper::basin::in_the_middle;
use vibro_studies::paper::bifurcation::{Sweep, SweepPoint};
use vibro_studies::paper::lyapunov::{SpectrumOptions, spectrum};
use vibro_studies::paper::maxima::Displacement;
use vibro_studies::paper::motion::settled_simulator;
use vibro_studies::paper::plane::ParameterAxis;
use vibro_studies::paper::stroboscopic::moving_block;
use vibro_studies::paper::trajectories::{Start, propagate};
use vibro_studies::paper::{ParameterSet, find_group};
use vibro_studies::parts::Task;

fn numbers(state: &State) -> Vec<f64> {
    state.x.iter().chain(&state.v).copied().collect()
}

fn set(values: &[(&str, f64)]) -> ParameterSet {
    let mut set = ParameterSet::basic();
    let named: Vec<_> = values.iter().map(|(n, v)| (find_group(n).expect("a group").into(), *v)).collect();
    set.assign(&named).expect("in their ranges");
    set
}

/// A motion at `per_period` times per period, with its events and energy accounts.
fn motion(p: &Parameters, loads: &[Load], periods: u32, per_period: u32) -> Value {
    let mut simulator = Simulator::new(p, &moving_block(p), 0.0).expect("valid");
    let (mut t, mut states, mut energy) = (Vec::new(), Vec::new(), Vec::new());
    let (mut impacts, mut rests, mut releases) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..=periods * per_period {
        let end = p.period() * f64::from(i) / f64::from(per_period);
        let mut observer = |event: &Event| match *event {
            Event::Impact { time, side, speed, impulse } => impacts.push(json!([time, side, speed, impulse])),
            Event::Rest { time, side } => rests.push(json!([time, side])),
            Event::Release { time, side } => releases.push(json!([time, side])),
        };
        if loads.is_empty() {
            simulator.advance_observed(end, &mut observer).expect("it runs");
        } else {
            simulator.advance_under(loads, end, Pause::Never, Some(&mut observer)).expect("it runs");
        }
        let e = simulator.energy_accounts();
        t.push(end);
        states.push(numbers(&simulator.state()));
        energy.push([e.mechanical, e.input, e.damped, e.impact]);
    }
    json!({"t": t, "states": states, "energy": energy, "impacts": impacts, "rests": rests, "releases": releases})
}

/// Overlapping loads on box and block, one with each interpolation.
fn loads() -> [Load; 2] {
    let push = [(1.0, 0.0), (2.0, 0.5), (4.5, -0.25), (9.0, 0.0)];
    let pull = [(3.0, 0.1), (5.0, -0.2), (6.0, 0.05)];
    [(Body::Box, &push[..], Interpolation::Linear), (Body::Block, &pull[..], Interpolation::Cubic)]
        .map(|(body, samples, how)| Load::new(body, samples, how).expect("valid"))
}

fn many() -> Value {
    let values: Vec<f64> = (0..100).map(|i| 0.5 + 0.035 * f64::from(i)).collect();
    let start = |f10: &f64| {
        let parameters = *set(&[("f10", *f10)]).parameters();
        Start { parameters, state: moving_block(&parameters) }
    };
    let starts: Vec<Start> = values.iter().map(start).collect();
    let ends = propagate(&starts, 100, &|| ());
    let ends: Vec<_> = ends.into_iter().map(|end| numbers(&end.expect("it runs"))).collect();
    json!({"f10": values, "ends": ends})
}

fn bifurcation() -> Value {
    let axis = ParameterAxis::new(find_group("f10").expect("a group"), (0.5, 4.0), 41).expect("a range");
    let exponents = Some(SpectrumOptions { periods: 100, ..SpectrumOptions::default() });
    let sweep = Sweep { exponents, ..Sweep::new(axis, Displacement::X1, (60, 40)) };
    let found = diagram(&ParameterSet::basic(), &sweep, &Task::ALL).expect("valid").expect("all parts");
    let direction = |points: &[Option<SweepPoint>]| -> Vec<Value> {
        let point = |p: &SweepPoint| {
            let exponents = p.spectrum.as_ref().expect("asked for").exponents;
            json!({"value": p.value, "kind": p.class.name(), "maxima": p.maxima, "impacts": p.attractor.impacts,
                   "exponents": exponents})
        };
        points.iter().map(|p| point(p.as_ref().expect("it runs"))).collect()
    };
    json!({"up": direction(&found.up), "down": direction(&found.down), "hysteresis": found.hysteresis()})
}

fn basin_cells() -> Value {
    let set = set(&[("f10", 2.5)]);
    let axis = |name: &str, count| StartAxis { name: name.into(), from: -1.5, to: 1.25, count };
    let request = BasinRequest { x: axis("v2", 8), y: axis("x2", 6), discard: 200, start: in_the_middle() };
    let found = basins(&set, &request, &Task::ALL).expect("valid").expect("all parts");
    let cells: Vec<_> = found.cells.iter().map(|cell| format!("{cell:?}")).collect();
    json!({"cells": cells, "periods": found.attractors.iter().map(|a| a.attractor.period).collect::<Vec<_>>()})
}

fn exponents() -> Value {
    let p = *set(&[("f10", 3.6)]).parameters();
    let mut simulator = settled_simulator(&p, &moving_block(&p), 50.0).expect("it runs");
    let options = SpectrumOptions { periods: 120, ..SpectrumOptions::default() };
    json!(spectrum(&mut simulator, &options).expect("it runs").exponents)
}

/// Machine files whose motions, sketches and archives are compared, and the duration of each
/// motion, s.
const ASSEMBLIES: [(&str, f64); 4] = [
    ("damper_with_buffer", 0.5),
    ("gear_backlash", 0.1),
    ("msl_coupled_clutches", 1.5),
    ("valve_train", 0.045),
];
/// Number of samples of the motions.
const SAMPLES: usize = 50;

/// The output of `vibro run FILE`, `vibro draw FILE` and `fmu-build assembly` for a machine.
fn assembly(name: &str, until: f64) -> Value {
    let file = common::python::root().join("examples/assembly").join(name).with_extension("toml");
    let machine = vibro_machine::file::read(&file).expect("an example");
    let sketch = canvas::svg(&Sketch::new(&machine)).expect("it is drawn");
    let times = vibro::machine::even_times((0.0, until), SAMPLES).expect("some samples");
    let record = vibro::machine::record(machine, &Default::default(), &times, &Arc::default(), &mut |_| ())
        .expect("it has a start");
    let text = |csv: vibro::Result<Vec<u8>>| String::from_utf8(csv.expect("a table")).expect("text");
    let kit = Kit::read(&common::python::kit()).expect("a kit");
    let output = Path::new(env!("CARGO_TARGET_TMPDIR")).join("assemblies").join(name).with_extension("fmu");
    let archives = fmu_build::assembly::write(&file, Some(&output), false, &kit).expect("they are packed");
    json!({"until": until, "states": text(record.states(&[])), "events": text(record.events(true)), "sketch": sketch,
           "archives": {"2": archives[0], "3": archives[1]}})
}

fn assemblies() -> Value {
    ASSEMBLIES.into_iter().map(|(name, until)| (name.to_owned(), assembly(name, until))).collect()
}

/// Results of the library, with which the Python tests compare bit for bit.
fn native() -> Value {
    let standard = set(&[("f10", 1.5), ("kappa", 0.75)]);
    let resting = set(&[("kappa", 0.1), ("f10", 4.5)]);
    let loads = loads();
    json!({
        "standard": motion(standard.parameters(), &[], 50, 20),
        "resting": motion(resting.parameters(), &[], 30, 7),
        "loaded": motion(standard.parameters(), &loads, 3, 40),
        "many": many(),
        "bifurcation": bifurcation(),
        "basins": basin_cells(),
        "exponents": exponents(),
        "assemblies": assemblies(),
    })
}

fn python(what: &str, arguments: &[&str]) {
    let mut command = common::python::command(common::python::python_with_package());
    command.args(arguments);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("native.json");
    command.env("VIBRO_IMPACT_NATIVE", &file).env("VIBRO_IMPACT_FMU", common::python::fmu());
    command.env("VIBRO_IMPACT_PICTURES", Path::new(env!("CARGO_TARGET_TMPDIR")).join("python-pictures"));
    command.env("MPLBACKEND", "agg");
    println!("{}", common::python::run(what, &mut command));
}

#[test]
fn the_package_finds_what_the_library_and_the_fmu_find() {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("native.json");
    fs::write(file, native().to_string()).expect("target can be written");
    python("pytest tests/python", &["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/python"]);
}

#[test]
#[ignore = "ten minutes: cargo test -p fmu-build --test python_package -- --ignored"]
fn the_interpreter_survives_ten_minutes_of_whatever_is_asked() {
    let minutes =
        ["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/python/test_any_input.py", "--minutes=10"];
    python("ten minutes of hypothesis", &minutes);
}
