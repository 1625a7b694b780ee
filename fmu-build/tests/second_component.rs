//! The doors' second component, the bouncing ball, as an FMU of both versions in FMPy.

mod common;

use common::python::{python, root, run};
use std::fs;
use std::path::Path;
use std::process::Command;
use std::time::SystemTime;

/// When a file was last written; for a folder, the newest of its files.
fn written(path: &Path) -> Option<SystemTime> {
    if path.is_dir() {
        let entries = fs::read_dir(path).expect("a folder of the repository can be read");
        return entries.filter_map(|entry| written(&entry.expect("an entry").path())).max();
    }
    fs::metadata(path).and_then(|data| data.modified()).ok()
}

#[test]
fn closed_form_of_the_bouncing_ball_in_fmpy() {
    let target = fmu_build::compile::target();
    let examples = target.join("debug/examples");
    let library = examples.join(format!(
        "{}bouncing_ball{}",
        std::env::consts::DLL_PREFIX,
        std::env::consts::DLL_SUFFIX
    ));
    let describe = examples.join(format!("describe{}", std::env::consts::EXE_SUFFIX));
    // Cargo has compiled both where all tests run. Where this test runs alone it is asked to.
    let sources = written(&root().join("doors"));
    if [&library, &describe].into_iter().any(|file| written(file) < sources) {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.current_dir(root()).args(["build", "--example", "bouncing_ball", "--example", "describe"]);
        run("building it", cargo.arg("--locked"));
    }
    let folder = target.join("ball");
    // Archives of an earlier run would be packed again.
    let _ = fs::remove_dir_all(&folder);
    run("describing it", Command::new(describe).arg(&folder));
    let mut script = Command::new(python());
    script.arg(root().join("tests/fmpy/second_component.py")).arg(&folder).arg(&library);
    run("running it in FMPy", &mut script);
}
