//! Source files as text, for tests of promises about a package's source: of this package, and of
//! packages whose tests include this file.

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

/// Every source file of a folder under `src` of a package, by its path from there, with its text.
pub fn sources(package: &str, under: &str) -> Vec<(String, String)> {
    let root = Path::new(package).join("src");
    let mut found = Vec::new();
    files(&root.join(under), &mut found);
    let name = |path: &Path| path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/");
    let mut found: Vec<_> =
        found.iter().map(|path| (name(path), fs::read_to_string(path).unwrap())).collect();
    found.sort();
    found
}

/// Unsafe code contains at least one of these words.
const UNSAFE: [&str; 5] = ["unsafe ", "unsafe(", "unsafe{", "unsafe_code", "extern \"C\""];

/// The source files of a package that have unsafe code.
pub fn with_unsafe_code(package: &str) -> Vec<String> {
    let with = |(_, text): &(String, String)| {
        let mut code = text.lines().map(|line| line.split("//").next().unwrap_or(""));
        code.any(|line| UNSAFE.iter().any(|word| line.contains(word)))
    };
    sources(package, "").into_iter().filter(with).map(|(name, _)| name).collect()
}
