//! Runs `tests/examples/`: the scripts of `examples/`, with what they draw, distribute and are checked with.

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use vibro_analysis::ParameterSet;
use vibro_orbits::{Orbit, OrbitWord, System};

/// A folder with what `vibro orbit --word U- --set f10=2.3` writes: the symmetric motion past its loss of stability.
fn orbit() -> PathBuf {
    let mut set = ParameterSet::basic();
    set.apply(&["f10=2.3"]).expect("an allowed value");
    let system = System::new(set.parameters()).expect("an allowed machine");
    let word = OrbitWord::new("U", -1, 1).expect("a word");
    let orbit = Orbit::find(&system, &word, &[5.0]).expect("the orbit");
    assert!(orbit.is_certified() && !orbit.is_stable());
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("unstable-orbit");
    fs::create_dir_all(&folder).expect("target can be written");
    for (name, text) in vibro::studies::orbit(&set, std::slice::from_ref(&orbit)).expect("tables").tables {
        fs::write(folder.join(format!("{name}.csv")), text).expect("target can be written");
    }
    folder
}

#[test]
#[ignore = "builds and installs the wheel, dask, pyarrow, matplotlib and mypy: cargo test --test examples -- --ignored"]
fn the_scripts_do_what_they_say() {
    let python = common::python::install_wheel(&["tests/examples/requirements.txt"]);
    let mut pytest = common::python::pytest(python, "tests/examples");
    pytest.env("VIBRO_IMPACT_FMU", common::python::fmu()).env("VIBRO_ORBIT", orbit());
    println!("{}", common::python::run("pytest tests/examples", &mut pytest));
}
