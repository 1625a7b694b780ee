//! Runs `tests/examples/`: the scripts of `examples/`, with their requirements for drawing, for
//! distributing and for type checks.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use vibro_orbits::paper::{Orbit, OrbitWord, System};
use vibro_studies::paper::ParameterSet;

/// A folder with the output of `vibro paper orbit --word U- --set f10=2.3`: the symmetric motion
/// beyond its loss of stability.
fn orbit() -> PathBuf {
    let mut set = ParameterSet::basic();
    set.apply(&["f10=2.3"]).expect("an allowed value");
    let system = System::new(set.parameters()).expect("an allowed machine");
    let word = OrbitWord::new("U", -1, 1).expect("a word");
    let orbit = Orbit::find(&system, &word, &[5.0]).expect("the orbit");
    assert!(orbit.is_certified() && !orbit.is_stable());
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("unstable-orbit");
    fs::create_dir_all(&folder).expect("target can be written");
    for (name, text) in
        vibro::studies::paper::orbit(&set, std::slice::from_ref(&orbit)).expect("tables").tables
    {
        fs::write(folder.join(format!("{name}.csv")), text).expect("target can be written");
    }
    folder
}

/// Python with the wheel, installed once in this process.
fn python() -> PathBuf {
    static PYTHON: OnceLock<PathBuf> = OnceLock::new();
    PYTHON.get_or_init(|| common::python::install_wheel(&["tests/examples/requirements.txt"])).clone()
}

#[test]
#[ignore = "builds and installs the wheel, dask, pyarrow and mypy: cargo test --test examples -- --ignored"]
fn the_scripts_do_what_they_say() {
    let mut pytest = common::python::pytest(python(), "tests/examples");
    pytest.env("VIBRO_IMPACT_FMU", common::python::fmu()).env("VIBRO_ORBIT", orbit());
    println!("{}", common::python::run("pytest tests/examples", &mut pytest));
}

/// For the package in the work tree and its native part.
#[test]
#[ignore = "builds and installs the wheel, dask, pyarrow and mypy: cargo test --test examples -- --ignored"]
fn types_are_strict_and_those_of_the_native_part_true() {
    let check = |what: &str, arguments: &[&str]| {
        println!("{}", common::python::run(what, common::python::command(python()).args(arguments)));
    };
    let cache = format!("--cache-dir={}", concat!(env!("CARGO_TARGET_TMPDIR"), "/mypy"));
    let configured = "--config-file=python/pyproject.toml";
    check("mypy --strict", &["-m", "mypy", &cache, configured, "python/package/vibro_impact"]);
    check(
        "stubtest",
        &["-m", "mypy.stubtest", "--mypy-config-file=python/pyproject.toml", "vibro_impact._native"],
    );
}
