//! Properties that the source promises of itself.

#[path = "../../doors/tests/common/sources.rs"]
mod sources;

use sources::{sources, with_unsafe_code};
use std::fs;
use std::path::Path;

/// The folder of this package.
const PACKAGE: &str = env!("CARGO_MANIFEST_DIR");

#[test]
fn unsafe_code_stands_in_the_doors_alone() {
    // The C interface is exported by the doors' macros.
    let with = with_unsafe_code(PACKAGE);
    assert!(with.is_empty(), "{with:?}");
}

#[test]
fn neither_version_imports_the_other() {
    for (version, other) in [("fmi2", "fmi3"), ("fmi3", "fmi2")] {
        let files = sources(PACKAGE, version);
        assert!(files.len() >= 3, "{version}: {}", files.len());
        for (name, text) in files {
            assert!(!text.contains(&format!("{other}::")), "{name} imports {other}");
        }
    }
}

#[test]
fn the_component_knows_no_version_of_fmi_and_nothing_imports_upward() {
    // Words of one FMI version: its name, functions, types, statuses and states.
    const OF_A_VERSION: [&str; 13] = [
        "fmi2",
        "fmi3",
        "fmi 2",
        "fmi 3",
        "fmistatus",
        "discard",
        "scalarvariable",
        "stepcomplete",
        "stepfailed",
        "initializationmode",
        "continuoustimemode",
        "fmustate",
        "guid",
    ];
    const FOREIGN: [&str; 5] =
        ["crate::ffi", "crate::fmi", "crate::exported", "crate::messages", "fmi_doors::ffi"];
    let files = sources(PACKAGE, "component");
    assert!(files.len() > 2, "{}", files.len());
    for (name, text) in files {
        for (number, line) in (1..).zip(text.lines()) {
            let lower = line.to_lowercase();
            let word = OF_A_VERSION.iter().find(|word| lower.contains(**word));
            assert!(word.is_none(), "{name}:{number} names {}: {line}", word.unwrap_or(&""));
            assert!(!FOREIGN.iter().any(|path| line.contains(path)), "{name}:{number}: {line}");
        }
    }
}

/// The worked example of the README: every code fragment in it occurs in the file that it names.
#[test]
fn the_example_of_a_variable_is_a_real_one() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let plain = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let (mut found, mut lines) = (0, readme.lines());
    while let Some(line) = lines.next() {
        let Some((_, file)) = line.trim().strip_prefix("```").and_then(|fence| fence.split_once(' ')) else {
            continue;
        };
        let block: Vec<&str> = lines.by_ref().take_while(|line| line.trim() != "```").collect();
        let code = fs::read_to_string(root.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        assert!(plain(&code).contains(&plain(&block.join("\n"))), "{file} has no {block:?}");
        found += 1;
    }
    assert_eq!(found, 6, "pieces of the example");
}
