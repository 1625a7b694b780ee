//! The equations of docs/theory.md, derived again or verified by computer algebra
//! (`tests/theory/`).

mod common;

#[test]
fn second_method_the_equations_of_the_theory_page() {
    let mut pytest = common::python::pytest(common::python::python(), "tests/theory");
    println!("{}", common::python::run("pytest tests/theory", &mut pytest));
}
