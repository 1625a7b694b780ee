//! Checks of texts in Python: the equations of docs/theory.md, derived again or verified by computer
//! algebra (`tests/theory/`), and phrases that readers had to read twice (`tests/words.py`).

mod common;

use std::process::Command;

#[test]
fn second_method_the_equations_of_the_theory_page() {
    let mut pytest = common::python::pytest(common::python::python(), "tests/theory");
    println!("{}", common::python::run("pytest tests/theory", &mut pytest));
}

/// A page that a commit makes harder to read fails here.
#[test]
fn invariant_no_package_has_more_hard_phrases_than_its_bound() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/words.py");
    let mut words = Command::new(common::python::python());
    println!("{}", common::python::run("tests/words.py", words.arg(path)));
}
