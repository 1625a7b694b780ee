//! Two builds in two folders give the same bytes.

use fmu_build::compile::{self, Compiler};
use std::fs;
use std::path::Path;

/// What the library is compiled from, and what cargo wants to see beside it.
const SOURCES: [&str; 20] = [
    "Cargo.toml",
    "Cargo.lock",
    "src",
    "analysis",
    "assets",
    "benches",
    "examples",
    "explorer/Cargo.toml",
    "explorer/src",
    "explorer-build/Cargo.toml",
    "explorer-build/src",
    "fmi",
    "tests",
    "modelDescription",
    "python/Cargo.toml",
    "python/src",
    "fmu-build/Cargo.toml",
    "fmu-build/src",
    "vibro/Cargo.toml",
    "vibro/src",
];

/// Copies what differs, so that a second run of this test finds everything compiled.
fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(from).unwrap() {
            let name = entry.unwrap().file_name();
            if name == "target" {
                continue; // the fuzzer's
            }
            copy(&from.join(&name), &to.join(&name));
        }
        return;
    }
    let bytes = fs::read(from).unwrap();
    if fs::read(to).ok().as_ref() != Some(&bytes) {
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::write(to, bytes).unwrap();
    }
}

/// The second folder is elsewhere and its path has another length; everything in it is compiled anew, dependencies too.
#[test]
fn another_folder_gives_the_same_bytes() {
    let second = compile::target().join("reproducible-in-another-folder");
    for source in SOURCES {
        copy(&compile::workspace().join(source), &second.join("sources").join(source));
    }
    let here = Compiler::default().library().unwrap();
    let there = Compiler::in_folders(&second.join("sources"), &second.join("compiled")).library().unwrap();
    assert_ne!(here, there);
    let (here, there) = (fs::read(here).unwrap(), fs::read(there).unwrap());
    let differ = here.iter().zip(&there).position(|(a, b)| a != b);
    assert!(here == there, "{} and {} bytes, first difference at {differ:?}", here.len(), there.len());
}
