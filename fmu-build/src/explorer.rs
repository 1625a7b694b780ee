//! The live page of the archives, made by the program `web-build`. A nested cargo compiles and
//! runs this program. Its requirements (the target wasm32-unknown-unknown, node, the generator of
//! WebAssembly bindings) therefore do not apply to an archive without the page.

use crate::compile::{cargo, target};
use crate::platforms::LeftOut;
use std::process::Stdio;

/// Path of the page in the archives.
pub const PATH: &str = "documentation/explorer.html";

/// The live page, or the reason why it cannot be made and what to install.
///
/// # Errors
/// Text of the reason.
pub fn page() -> Result<Vec<u8>, LeftOut> {
    let left_out = |reason: String| LeftOut { folder: PATH, reason, replaced: false };
    let file = target().join("explorer/explorer.html");
    let mut build = cargo();
    build.args(["run", "--package", "web-build", "--release", "--locked", "--quiet", "--target-dir"]);
    // The nested cargo has a separate target folder, so that it never waits for the lock of a
    // cargo that runs this program.
    build
        .arg(target().join("explorer/tool"))
        .args(["--config", "profile.release.lto=false", "--", "--out"])
        .arg(&file);
    let output =
        build.stdin(Stdio::null()).output().map_err(|e| left_out(format!("cargo cannot be run: {e}")))?;
    if !output.status.success() {
        let told = String::from_utf8_lossy(&output.stderr);
        let reason = told.lines().rev().find_map(|line| line.strip_prefix("web-build: "));
        let reason = reason.map_or_else(|| format!("web-build failed:\n{told}"), str::to_owned);
        return Err(left_out(reason));
    }
    std::fs::read(&file).map_err(|e| left_out(format!("{}: {e}", file.display())))
}
