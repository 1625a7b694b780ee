//! The doors' second component, the bouncing ball, as an FMU of both versions in FMPy.

mod common;

use common::python::{python, root, run};
use std::fs;
use std::process::Command;

#[test]
fn closed_form_of_the_bouncing_ball_in_fmpy() {
    // Cargo has compiled these examples already where all tests run, and compiles them now where this test runs alone.
    let target = fmu_build::compile::target();
    let cargo = |arguments: &[&str]| {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.current_dir(root()).args(arguments).args(["-p", "fmi-doors", "--locked"]);
        cargo
    };
    let folder = target.join("ball");
    // Archives of an earlier run would be packed again.
    let _ = fs::remove_dir_all(&folder);
    run("building the library", &mut cargo(&["build", "--example", "bouncing_ball"]));
    run("describing it", cargo(&["run", "--example", "describe"]).arg("--").arg(&folder));
    let (prefix, ending) = (std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let library = target.join("debug/examples").join(format!("{prefix}bouncing_ball{ending}"));
    let mut script = Command::new(python());
    script.arg(root().join("tests/fmpy/second_component.py")).arg(&folder).arg(&library);
    run("running it in FMPy", &mut script);
}
