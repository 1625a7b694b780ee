//! Drives the packaged FMU from Python: builds it, writes native trajectories for comparison, runs
//! `tests/fmpy/`.

mod common;

use std::fmt::Write;
use std::fs;
use std::path::Path;
use vibro_impact::steady::{exact_orbit, multiple_scales};
use vibro_impact::{Groups, Parameters, Simulator, State};

/// Drive periods of the comparison.
const PERIODS: f64 = 200.0;

/// Communication steps in drive periods, with their names in file names.
const STEPS: [(&str, f64); 3] = [("tenth", 1.0 / 10.0), ("odd", 1.0 / 7.3), ("long", 13.0)];

/// Communication step (s) and end (s) of the run in libcosim, which counts in whole nanoseconds.
const LIBCOSIM: (f64, f64) = (0.5, 600.0);

/// Writes the native states at the communication points of one step size as CSV, with full
/// precision.
fn native_trajectory(file: &Path, step: f64, end: f64) {
    let parameters = Parameters::default();
    // Number of steps; the end may be a whole number of steps up to rounding.
    let count = (end / step - 1e-9).ceil() as u32;
    let mut simulator =
        Simulator::new(&parameters, &State::default(), 0.0).expect("the default set is valid");
    let mut csv = String::from("time,box.s,block.s,secondary.s,box.v,block.v,secondary.v,impacts\n");
    for time in (0..count).map(|i| f64::from(i) * step).chain([end]) {
        simulator.advance_to(time).expect("the default set runs");
        let (State { x, v }, record) = (simulator.state(), simulator.impacts());
        let impacts = record.upper + record.lower;
        let [[x1, x2, x3], [v1, v2, v3]] = [x, v];
        writeln!(csv, "{time},{x1},{x2},{x3},{v1},{v2},{v3},{impacts}").expect("a String takes all");
    }
    fs::write(file, csv).expect("target can be written");
}

/// Writes a period of a closed form of the library in SI units, from drive phase zero at time
/// zero.
fn closed_form(file: &Path, state: impl Fn(f64) -> State) {
    let parameters = Parameters::default();
    let mut csv = String::from("time,box.s,block.s,secondary.s,box.v,block.v,secondary.v\n");
    for i in 0..=40 {
        let time = parameters.period() * f64::from(i) / 40.0;
        let State { x: [x1, x2, x3], v: [v1, v2, v3] } = state(time);
        writeln!(csv, "{time},{x1},{x2},{x3},{v1},{v2},{v3}").expect("a String takes all");
    }
    fs::write(file, csv).expect("target can be written");
}

/// The library's multiple scales and exact orbit of the default set; its scales are 1, so
/// velocities need ω1 only.
fn closed_forms(folder: &Path) {
    let parameters = Parameters::default();
    let omega = parameters.drive_frequency;
    let orbit = exact_orbit::solve(&parameters).expect("valid").upper.expect("the default set has an orbit");
    closed_form(&folder.join("orbit.csv"), |time| {
        let state = orbit.state(omega * time);
        State { x: state.x, v: state.v }
    });
    let points = multiple_scales::fixed_points(&Groups::basic()).expect("valid").expect("they exist");
    closed_form(&folder.join("scales.csv"), |time| {
        let motion = points.upper.motion_at_drive(omega * time);
        State { x: motion.x, v: motion.dx.map(|rate| rate * omega) }
    });
}

#[test]
fn fmpy_drives_the_packaged_fmu() {
    let python = common::python::python();
    let fmu = common::python::fmu();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("native");
    fs::create_dir_all(&folder).expect("target can be written");
    for (name, step) in STEPS {
        let period = Parameters::default().period();
        native_trajectory(&folder.join(format!("{name}.csv")), step * period, PERIODS * period);
    }
    native_trajectory(&folder.join("libcosim.csv"), LIBCOSIM.0, LIBCOSIM.1);
    closed_forms(&folder);
    let mut pytest = common::python::pytest(python, "tests/fmpy");
    pytest.env("VIBRO_IMPACT_FMU", fmu).env("VIBRO_IMPACT_NATIVE", folder);
    println!("{}", common::python::run("pytest tests/fmpy", &mut pytest));
}
