//! Properties that the source must have.

#[path = "common/sources.rs"]
mod sources;

use sources::{sources, with_unsafe_code};
use std::fs;
use std::path::Path;

/// The folder of this package.
const PACKAGE: &str = env!("CARGO_MANIFEST_DIR");

#[test]
fn unsafe_code_stands_in_the_doors_and_their_pointer_helpers() {
    let with = with_unsafe_code(PACKAGE);
    let allowed = [
        "ffi/arguments.rs",
        "ffi/library.rs", // asks the system where the library lies
        "ffi/pointers.rs",
        "fmi2/abi.rs",
        "fmi3/abi.rs",
        "fmi3/abi/functions.rs",
        "fmi3/abi/instantiation.rs",
        "fmi3/abi/step.rs",
    ];
    assert_eq!(with, allowed);
}

#[test]
fn neither_door_imports_the_other_and_ffi_imports_neither() {
    for (folder, foreign, count) in [
        ("fmi2", &["fmi3::"][..], 6),
        ("fmi3", &["fmi2::"], 6),
        ("ffi", &["crate::fmi", "crate::component", "crate::life", "fmi2", "fmi3"], 3),
    ] {
        let files = sources(PACKAGE, folder);
        assert!(files.len() > count, "{folder}: {}", files.len());
        for (name, text) in files {
            for other in foreign {
                assert!(!text.contains(other), "{name} imports {other}");
            }
        }
    }
}

/// The doors can export a component of any kind: they do not contain a word of the machine for
/// which they were first made, or a package of this repository.
#[test]
fn the_doors_know_no_machine() {
    for (name, text) in sources(PACKAGE, "") {
        let lower = text.to_lowercase();
        for word in ["vibro", "impact", "restitution", "oscillator", "stop.gap"] {
            assert!(!lower.contains(word), "{name} knows {word}");
        }
    }
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let manifest = fs::read_to_string(manifest).unwrap();
    assert!(!manifest.contains("vibro") && !manifest.contains("path = \"../.."), "{manifest}");
}
