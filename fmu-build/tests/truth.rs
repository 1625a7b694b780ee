//! The truth suite (`truth/`): its score, its tables, and its cases as FMUs in FMPy.

mod common;

use common::python::{command, pytest, python, python_with, root, run};
use fmu_build::assembly::write;
use fmu_build::kit;
use std::fs;

/// The case in which every host fails that holds an input over a step, as FMPy does.
const HELD: &str = "input_ramps";

/// Broken hosts and bad tables, with Python's standard library alone: 3 s.
#[test]
fn the_score_of_right_and_broken_hosts_and_of_bad_tables() {
    println!("{}", run("pytest tests/truth", &mut pytest(python(), "tests/truth/test_score.py")));
}

#[test]
#[ignore = "installs gmpy2 and python-flint, and makes motions in 96 digits: a minute"]
fn second_method_the_tables_are_made_again_by_both_programs() {
    let python = python_with(&["tests/theory/requirements.txt", "truth/requirements.txt"]);
    println!("{}", run("pytest tests/truth", &mut pytest(python, "tests/truth/test_made.py")));
}

#[test]
#[ignore = "packs and runs 35 machines: 30 s of processor time"]
fn second_method_fmpy_passes_every_case_but_the_one_for_held_inputs() {
    let kit = kit::at_hand().expect("the library was compiled with this test");
    let archives = fmu_build::compile::target().join("truth-test");
    fs::create_dir_all(&archives).expect("target can be written");
    let ways = ["FMI 3.0 CS", "FMI 3.0 CS, event mode and early return"];
    let mut score = command(python());
    score.args(["truth/score.py", "fmpy", "--archives"]).arg(&archives);
    for way in ways {
        score.args(["--way", way]);
    }
    for entry in fs::read_dir(root().join("truth/cases")).expect("the cases") {
        let case = entry.expect("a case").path();
        let name = case.file_name().expect("a name").to_string_lossy().into_owned();
        let words = name.split('_').map(|word| word[..1].to_uppercase() + &word[1..]);
        let out = archives.join(words.collect::<String>() + ".fmu");
        write(&case.join("machine.toml"), Some(&out), false, &kit).expect("it is packed");
        if name != HELD {
            score.args(["--case", &name]);
        }
    }
    println!("{}", run("scoring FMPy", &mut score));
    let mut masters = pytest(python(), "tests/truth/test_fmi3.py");
    println!("{}", run("right and broken masters", masters.env("TRUTH_ARCHIVES", &archives)));
    let mut held = command(python());
    held.args(["truth/score.py", "fmpy", "--way", ways[0], "--case", HELD, "--archives"]).arg(&archives);
    let output = held.output().expect("Python runs");
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(!output.status.success() && text.contains("the host holds the input"), "{text}");
}
