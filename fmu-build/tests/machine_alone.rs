//! `vibro-impact` alone contains the machine and nothing of FMI: it has only the planned
//! dependencies, and a program linked against it has no symbol of a door.

use fmu_build::compile::workspace;
use object::{Object, ObjectSymbol};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

/// All dependencies that `vibro-impact` may have.
const DEPENDENCIES: [&str; 5] = ["nalgebra", "pulp", "serde", "thiserror", "vibro-numerics"];
/// Forbidden dependencies: C types, threads, command lines, pictures, and packages that depend on
/// `vibro-impact`.
const NEVER: [&str; 7] =
    ["libc", "rayon", "clap", "tiny-skia", "postcard", "vibro-studies", "vibro-paper-component"];

fn cargo(arguments: &[&str]) -> String {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    let output = cargo.current_dir(workspace()).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Names of `vibro-impact`'s dependencies, down to a depth.
fn dependencies(depth: &str) -> BTreeSet<String> {
    let options =
        ["tree", "--locked", "-p", "vibro-impact", "-e", "normal", "--prefix", "none", "--depth", depth];
    let tree = cargo(&options);
    let names = tree.lines().filter_map(|line| line.split_whitespace().next());
    names.filter(|name| *name != "vibro-impact").map(str::to_owned).collect()
}

#[test]
fn the_papers_model_has_four_dependencies_and_the_numerics() {
    assert_eq!(dependencies("1"), DEPENDENCIES.map(str::to_owned).into());
    let all = dependencies("99");
    for name in NEVER {
        assert!(!all.contains(name), "{name} of {all:?}");
    }
}

/// The compiled example, found through the messages of cargo.
fn example(name: &str) -> PathBuf {
    let target = fmu_build::compile::target().join("machine-alone");
    let folder = target.to_string_lossy();
    let options = ["build", "--locked", "-p", "vibro-impact", "--example", name, "--target-dir", &folder];
    cargo(&options);
    Path::new(&*folder).join("debug/examples").join(name).with_extension(std::env::consts::EXE_EXTENSION)
}

#[test]
#[ignore = "compiles the machine again: cargo test -p fmu-build --test machine_alone -- --ignored"]
fn a_program_with_the_machine_has_no_symbol_of_fmi() {
    let bytes = std::fs::read(example("run")).unwrap();
    let binary = object::File::parse(&*bytes).unwrap();
    let names: Vec<&str> =
        binary.symbols().chain(binary.dynamic_symbols()).filter_map(|s| s.name().ok()).collect();
    // Proof that the test can fail: symbols of the machine are in the program.
    assert!(names.iter().any(|name| name.contains("vibro_impact")), "{} symbols", names.len());
    let foreign: Vec<_> =
        names.iter().filter(|name| name.contains("fmi2") || name.contains("vibro_paper_component")).collect();
    assert!(foreign.is_empty(), "{foreign:?}");
}
