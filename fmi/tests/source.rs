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

#[test]
fn unsafe_code_stands_in_the_tests_alone() {
    const WORDS: [&str; 5] = ["unsafe ", "unsafe(", "unsafe{", "unsafe_code", "extern \"C\""];
    let with = |(_, text): &(String, String)| {
        let mut code = text.lines().map(|line| line.split("//").next().unwrap_or(""));
        code.any(|line| WORDS.iter().any(|word| line.contains(word)))
    };
    let with: Vec<String> = sources("").into_iter().filter(with).map(|(name, _)| name).collect();
    // Callers of the interface, which the doors' macros export.
    assert!(with.len() == 7 && with.iter().all(|name| name.contains("/tests")), "{with:?}");
}

#[test]
fn neither_version_imports_the_other() {
    for (version, other) in [("fmi2", "fmi3"), ("fmi3", "fmi2")] {
        let files = sources(version);
        assert!(files.len() > 4, "{version}: {}", files.len());
        for (name, text) in files {
            assert!(!text.contains(&format!("{other}::")), "{name} imports {other}");
        }
    }
}

#[test]
fn the_component_knows_no_version_of_fmi_and_nothing_imports_upward() {
    // Words of one version: its name, its functions and types, its statuses and its states.
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
    let files = sources("component");
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

/// The worked example of the README: every piece of code in it stands in the file that it names.
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
