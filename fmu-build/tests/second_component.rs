//! The doors' second component, the bouncing ball, as an FMU of both versions in FMPy.

mod common;

use common::python::{python, root, run};
use std::fs;
use std::process::Command;

#[test]
fn closed_form_of_the_bouncing_ball_in_fmpy() {
    // Cargo has compiled these examples where all tests run, and compiles them now where this test runs alone. No package is named:
    // cargo would choose other features then and compile all anew.
    let target = fmu_build::compile::target();
    let folder = target.join("ball");
    // Archives of an earlier run would be packed again.
    let _ = fs::remove_dir_all(&folder);
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(root()).args([
        "build",
        "--example",
        "bouncing_ball",
        "--example",
        "describe",
        "--locked",
    ]);
    run("building it", &mut cargo);
    let examples = target.join("debug/examples");
    run("describing it", Command::new(examples.join("describe")).arg(&folder));
    let (prefix, ending) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let library = examples.join(format!("{prefix}bouncing_ball{ending}"));
    let mut script = Command::new(python());
    script.arg(root().join("tests/fmpy/second_component.py")).arg(&folder).arg(&library);
    run("running it in FMPy", &mut script);
}
