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

#[test]
fn unsafe_code_and_the_c_interface_stand_in_one_file() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut sources = Vec::new();
    files(&root, &mut sources);
    let name = |path: &Path| path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
    let mut with: Vec<String> = sources
        .iter()
        .filter(|path| {
            let text = fs::read_to_string(path).unwrap();
            let code = text.lines().map(|line| line.split("//").next().unwrap_or(""));
            code.into_iter().any(|line| {
                ["unsafe ", "unsafe(", "unsafe{", "unsafe_code", "extern \"C\""]
                    .iter()
                    .any(|w| line.contains(w))
            })
        })
        .map(|path| name(path))
        .collect();
    with.sort();
    // The interface, and its tests, which are its callers.
    assert_eq!(
        with,
        ["fmi2/abi.rs", "fmi2/abi/tests.rs", "fmi2/abi/tests/random.rs", "fmi2/abi/tests/states.rs"]
    );
}
