//! The texts of the repository that people read.

use std::fs;
use std::path::{Path, PathBuf};

/// Extensions of files whose text people read.
const TEXTS: [&str; 11] = ["rs", "py", "md", "toml", "html", "ts", "js", "mjs", "yml", "cff", "m"];
/// Folders that are made, fetched, or input of another program.
pub const PASSED_OVER: [&str; 7] =
    ["target", "dist", ".git", "corpus", "node_modules", "snapshots", "vibro-out"];
/// The tests of texts, which contain the forbidden words.
const OWN: [&str; 3] =
    ["tests/repository.rs", "tests/repository/citations.rs", "tests/repository/clauses.rs"];

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Whether a file is one of the tests of texts.
pub fn is_own(path: &Path) -> bool {
    OWN.iter().any(|own| *path == root().join(own))
}

/// Every file under a folder.
pub fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of the repository") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or("");
        if !path.is_dir() {
            found.push(path);
        } else if !PASSED_OVER.contains(&name) && !path.join("pyvenv.cfg").exists() {
            walk(&path, found);
        }
    }
}

/// Every text of the repository with its path, except the texts of these tests.
pub fn all() -> Vec<(PathBuf, String)> {
    let mut paths = Vec::new();
    walk(root(), &mut paths);
    let is_text = |path: &PathBuf| {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        (TEXTS.contains(&ending) || path.ends_with(".ci/run")) && !is_own(path)
    };
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).expect("UTF-8");
        (path, text)
    };
    paths.into_iter().filter(is_text).map(read).collect()
}

pub fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}
