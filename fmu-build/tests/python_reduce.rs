//! `vi.reduce` of the Python package with the program that does its work. Asked for by name, since
//! the program's feature `reduce` takes minutes to compile.

mod common;

use common::python::{pytest, python_with_package, root, run};
use fmu_build::compile::target;
use std::process::Command;

#[test]
#[ignore = "compiles factorisations: minutes"]
fn closed_forms_of_a_cantilever_and_refusals_in_python() {
    let cargo = std::env::var_os("CARGO").expect("cargo runs this test");
    let mut build = Command::new(cargo);
    build.args(["build", "--quiet", "--package", "vibro", "--features", "reduce", "--target-dir"]);
    run("cargo build", build.arg(target()).current_dir(root()));
    let program = target().join("debug").join(format!("vibro{}", std::env::consts::EXE_SUFFIX));
    let mut tests = pytest(python_with_package(), "tests/reduce");
    println!("{}", run("pytest tests/reduce", tests.env("VIBRO", program)));
}
