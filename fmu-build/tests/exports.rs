//! The packaged binary exports the functions of FMI 2.0 and 3.0 and nothing else, and needs the C library and nothing else.

mod common;

use fmu_build::{compile, inspect};

#[test]
fn exports_are_the_functions_of_both_versions() {
    let bytes = std::fs::read(compile::library().unwrap()).unwrap();
    assert_eq!(inspect::exports(&bytes).unwrap(), common::functions());
}

/// No libgcc_s, say, which a host's machine may lack.
#[test]
fn only_the_c_library_and_its_mathematics_are_needed() {
    let bytes = std::fs::read(compile::library().unwrap()).unwrap();
    let needs = inspect::needs(&bytes).unwrap();
    assert!(!needs.is_empty(), "even sin() comes from somewhere");
    let foreign: Vec<&String> = needs.iter().filter(|name| !inspect::is_system(name)).collect();
    assert!(foreign.is_empty(), "{foreign:?} of {needs:?}");
}
