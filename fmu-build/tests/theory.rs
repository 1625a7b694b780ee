//! The equations of docs/theory.md, derived again or verified by computer algebra (`tests/theory/`).

mod common;

use std::process::Command;

#[test]
fn second_method_the_equations_of_the_theory_page() {
    let python = common::python::python_with(&["tests/theory/requirements.txt"]);
    let mut pytest = Command::new(python);
    pytest.args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/theory"]);
    pytest.current_dir(common::python::root()).env("PYTHONDONTWRITEBYTECODE", "1");
    println!("{}", common::python::run("pytest tests/theory", &mut pytest));
}
