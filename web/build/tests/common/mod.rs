//! Functions shared by the tests of both pages.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

pub fn workspace() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the package is in the workspace")
}

/// Builds a page; returns the build folder with the page in it.
pub fn built(argument: &str) -> PathBuf {
    let output = Command::new(env!("CARGO_BIN_EXE_web-build")).arg(argument).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let page = String::from_utf8(output.stdout).unwrap();
    Path::new(page.trim()).parent().unwrap().to_owned()
}

/// Runs node; returns whether it succeeds, and its output.
pub fn node(arguments: &[&Path], input: &str) -> (bool, String) {
    let mut node =
        Command::new("node").args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    node.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
    let output = node.wait_with_output().unwrap();
    (output.status.success(), String::from_utf8_lossy(&output.stdout).into_owned())
}
