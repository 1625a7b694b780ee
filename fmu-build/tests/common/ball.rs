//! The doors' second component, the bouncing ball: its library and its descriptions.

use super::python::{root, run};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::SystemTime;

/// Time of the last change of a file; for a folder, of its newest file.
fn written(path: &Path) -> Option<SystemTime> {
    if path.is_dir() {
        let entries = fs::read_dir(path).expect("a folder of the repository can be read");
        return entries.filter_map(|entry| written(&entry.expect("an entry").path())).max();
    }
    fs::metadata(path).and_then(|data| data.modified()).ok()
}

/// The folder of that name under `target/`, created afresh with the descriptions of both versions,
/// and the library. If all tests run, cargo has compiled the library already; if a test runs
/// alone, the test asks cargo to.
pub fn described(name: &str) -> (PathBuf, PathBuf) {
    let target = fmu_build::compile::target();
    let examples = target.join("debug/examples");
    let library = format!("{}bouncing_ball{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let library = examples.join(library);
    let describe = examples.join(format!("describe{}", std::env::consts::EXE_SUFFIX));
    let sources = written(&root().join("doors"));
    if [&library, &describe].into_iter().any(|file| written(file) < sources) {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.current_dir(root()).args(["build", "--example", "bouncing_ball", "--example", "describe"]);
        run("building it", cargo.arg("--locked"));
    }
    let folder = target.join(name);
    // Archives of an earlier run would be packed again.
    let _ = fs::remove_dir_all(&folder);
    run("describing it", Command::new(describe).arg(&folder));
    (folder, library)
}
