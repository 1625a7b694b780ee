//! The Python blocks of docs/paper-machine.md and docs/design-a-damper.md run with the packaged
//! FMU, and agree with the library and closed forms.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use vibro_impact::load::{Body, Interpolation, Load};
use vibro_impact::simulator::Pause;
use vibro_impact::{Parameters, Simulator, State};

/// Rounding, m: FMU and library use the same code; only the ends of steps differ by rounding.
const ROUNDING: f64 = 1e-12;

/// Runs the blocks of a page in order in one interpreter, each with separate names.
const DRIVER: &str = "import sys
for name in sys.argv[1:]:
    with open(name, encoding='utf-8') as file:
        exec(compile(file.read(), name, 'exec'), {})
    print('---')
";

/// The output of a page's Python blocks, block by block, in a folder with the page's files and the
/// FMU.
fn printed(page: &str) -> Vec<String> {
    let folder: PathBuf = Path::new(env!("CARGO_TARGET_TMPDIR")).join(page);
    fs::create_dir_all(folder.join("target")).expect("target can be written");
    fs::copy(common::python::fmu(), folder.join("target/VibroImpact3DOF.fmu"))
        .expect("target can be written");
    let text =
        fs::read_to_string(common::python::root().join("docs").join(page)).expect("the page can be read");
    let mut scripts = Vec::new();
    for (info, block) in common::blocks(&text) {
        match info.split_once(' ') {
            Some((_, file)) => fs::write(folder.join(file), &block).expect("target can be written"),
            None if info == "python" => {
                let name = format!("block{}.py", scripts.len());
                fs::write(folder.join(&name), &block).expect("target can be written");
                scripts.push(name);
            }
            None => {}
        }
    }
    let mut python = common::python::command(common::python::python());
    python.args(["-c", DRIVER]).args(&scripts).current_dir(&folder);
    let all = common::python::run(&format!("the Python blocks of {page}"), &mut python);
    let found: Vec<String> = all.split("---\n").map(|part| part.trim().to_owned()).collect();
    found[..scripts.len()].to_vec()
}

/// The numbers in a text.
fn numbers(text: &str) -> Vec<f64> {
    text.split([' ', '\n', ',']).filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn closed_form_of_the_recipes() {
    let [alone, record, tilted, off_centre] = &printed("paper-machine.md")[..] else {
        panic!("four recipes")
    };
    // The amplitude in mm and the largest difference from the formula in m.
    assert!(numbers(alone)[1] < ROUNDING && alone.contains("amplitude 37.761 mm"), "{alone}");
    // The record: equal to the library's result for the same interpolant.
    let p = Parameters {
        box_mass: 12.0,
        box_stiffness: 48e3,
        box_damping: 30.0,
        block_mass: 1.2,
        coupling_stiffness: 0.0,
        stop_gap: 0.015,
        stop_restitution: 0.6,
        drive_amplitude: 0.0,
        ..Parameters::default()
    };
    let samples = [(0.0, 0.0), (0.01, 900.0), (0.02, 1200.0), (0.03, 450.0), (0.04, 0.0)];
    let load = Load::new(Body::Box, &samples, Interpolation::Linear).unwrap();
    let mut simulator = Simulator::new(&p, &State::default(), 0.0).unwrap();
    simulator.advance_under(&[load], 1.0, Pause::Never, None).unwrap();
    let [_, x1, x2] = numbers(record)[..] else { panic!("{record}") };
    let State { x, .. } = simulator.state();
    assert!((x1 - x[0]).abs() < ROUNDING && (x2 - x[1]).abs() < ROUNDING, "{record} {x:?}");
    // Each line gives a number twice: by the FMU and by hand.
    for line in tilted.lines() {
        let [found, by_hand] = numbers(line)[..] else { panic!("{line}") };
        assert_eq!(found, by_hand, "{line}");
    }
    let [above, below, difference] = numbers(off_centre)[..] else { panic!("{off_centre}") };
    assert!(above > 10.0 && above != below && difference < ROUNDING, "{off_centre}");
}

#[test]
fn second_method_the_tutorials_fmu_is_the_exact_orbit() {
    let [said] = &printed("design-a-damper.md")[..] else { panic!("one block") };
    let [with, without] = numbers(said)[..] else { panic!("{said}") };
    let page = fs::read_to_string(common::python::root().join("docs/design-a-damper.md")).unwrap();
    assert!(page.contains(&format!("It prints {with:.1} mm and {without:.1} mm.")), "{said}");
    let p = Parameters {
        box_mass: 12.0,
        box_stiffness: 48e3,
        box_damping: 30.0,
        block_mass: 1.1,
        coupling_stiffness: 0.0,
        stop_gap: 0.018,
        stop_restitution: 0.5,
        drive_amplitude: 75.0,
        drive_frequency: std::f64::consts::TAU * 10.05,
        ..Parameters::default()
    };
    let orbit = vibro_impact::steady::exact_orbit::solve(&p).unwrap().upper.expect("an orbit");
    // Stated to a tenth of a millimetre, from samples a hundredth of a period apart.
    assert!(orbit.is_stable() && (1e3 * orbit.amplitudes()[0] - with).abs() < 0.06, "{said}");
}
