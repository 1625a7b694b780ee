//! Runs `tests/examples/`: the scripts of `examples/`, with what they draw, distribute and are checked with.

mod common;

use std::process::Command;

#[test]
#[ignore = "installs dask, pyarrow, matplotlib and mypy: cargo test --test examples -- --ignored"]
fn the_scripts_do_what_they_say() {
    let requirements = ["tests/fmpy/requirements.txt", "tests/examples/requirements.txt"];
    let mut pytest = Command::new(common::python::python_with(&requirements));
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/examples"]);
    pytest.current_dir(common::python::root()).env("PYTHONDONTWRITEBYTECODE", "1");
    pytest.env("VIBRO_IMPACT_FMU", common::python::fmu());
    println!("{}", common::python::run("pytest tests/examples", &mut pytest));
}
