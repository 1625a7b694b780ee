//! What the source promises about itself.

use std::fs;
use std::path::{Path, PathBuf};

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// Every source file of a folder under `src`, by its path from there, with its text.
fn sources(under: &str) -> Vec<(String, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut found = Vec::new();
    files(&root.join(under), &mut found);
    let name = |path: &Path| path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
    let mut found: Vec<_> =
        found.iter().map(|path| (name(path), fs::read_to_string(path).unwrap())).collect();
    found.sort();
    found
}

const UNSAFE: [&str; 5] = ["unsafe ", "unsafe(", "unsafe{", "unsafe_code", "extern \"C\""];

#[test]
fn unsafe_code_stands_in_the_doors_and_their_pointer_helpers() {
    let with = |(_, text): &(String, String)| {
        let mut code = text.lines().map(|line| line.split("//").next().unwrap_or(""));
        code.any(|line| UNSAFE.iter().any(|word| line.contains(word)))
    };
    let with: Vec<String> = sources("").into_iter().filter(with).map(|(name, _)| name).collect();
    let allowed = [
        "ffi/arguments.rs",
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
        let files = sources(folder);
        assert!(files.len() > count, "{folder}: {}", files.len());
        for (name, text) in files {
            for other in foreign {
                assert!(!text.contains(other), "{name} imports {other}");
            }
        }
    }
}

/// What can be exported by the doors is of any kind: no word of the machine for which they were made first, and no package of
/// this repository.
#[test]
fn the_doors_know_no_machine() {
    for (name, text) in sources("") {
        let lower = text.to_lowercase();
        for word in ["vibro", "impact", "restitution", "oscillator", "stop.gap"] {
            assert!(!lower.contains(word), "{name} knows {word}");
        }
    }
    let manifest = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let manifest = fs::read_to_string(manifest).unwrap();
    assert!(!manifest.contains("vibro") && !manifest.contains("path ="), "{manifest}");
}
