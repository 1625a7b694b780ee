//! The WebAssembly component of described machines (draft of FMI-LS-WASM): an archive with it, run
//! by wasmtime from the registry of Python packages. Asked for by name, since it needs a target of
//! the compiler: `rustup target add wasm32-wasip2`.

mod common;

use common::python::{pytest, python_with, root, run};
use fmu_build::compile::target;
use fmu_build::{assembly, kit};
use std::fs;

#[test]
#[ignore = "compiles the component with optimisation: minutes"]
fn second_method_the_component_in_an_archive_moves_as_the_native_library() {
    let kit = kit::with_component(kit::at_hand().expect("the library was compiled with this test"))
        .expect("the component is compiled: `rustup target add wasm32-wasip2`");
    let folder = target().join("component-test");
    fs::create_dir_all(&folder).expect("target can be written");
    let machine = root().join("examples/assembly/damper_with_buffer.toml");
    let written = assembly::write(&machine, Some(&folder.join("Damper.fmu")), false, &kit);
    let archive = written.expect("it is packed").pop().expect("the archive of FMI 3.0 is the last");
    let python = python_with(&["tests/fmpy/requirements.txt", "tests/component/requirements.txt"]);
    let mut tests = pytest(python, "tests/component");
    println!("{}", run("pytest tests/component", tests.env("COMPONENT_ARCHIVE", archive)));
}
