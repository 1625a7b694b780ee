//! Compiles the library that goes into the archive, by a nested cargo.

use crate::error::{Error, Result};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Folder of this platform's binary inside the archive (FMI 2.0, 2.3), as hosts look for it: they go by
/// operating system and pointer width alone, whatever the processor.
pub const PLATFORM: &str = match (cfg!(target_os = "windows"), cfg!(target_os = "macos"), usize::BITS) {
    (true, _, 64) => "win64",
    (true, _, _) => "win32",
    (_, true, _) => "darwin64",
    (_, _, 64) => "linux64",
    _ => "linux32",
};

/// Ending of a shared library's name on this platform, with its dot.
pub const SHARED_LIBRARY: &str = std::env::consts::DLL_SUFFIX;

/// Folder of the workspace this packager was compiled from.
pub fn workspace() -> &'static Path {
    let here = Path::new(env!("CARGO_MANIFEST_DIR"));
    here.parent().unwrap_or(here)
}

/// Folder for everything built.
pub fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| workspace().join("target"), PathBuf::from)
}

/// Compiles the library and returns its path.
///
/// The nested cargo has a target folder of its own, so that it never waits for the lock of a cargo that runs us.
///
/// # Errors
/// [`Error::Cargo`] when cargo cannot be run or fails.
pub fn library() -> Result<PathBuf> {
    let mut cargo = cargo();
    // `rustc` with the one crate type, since cargo leaves out link-time optimization where an rlib is made as well.
    cargo.args(["rustc", "--package", "vibro-impact", "--lib", "--crate-type", "cdylib"]);
    cargo.args(["--no-default-features", "--profile", "fmu", "--locked", "--message-format"]);
    cargo.args(["json-render-diagnostics", "--target-dir"]);
    cargo.arg(target().join("fmu")).env("CARGO_ENCODED_RUSTFLAGS", flags());
    // Incremental builds of a cdylib have left undefined symbols, which show only when a host loads it.
    cargo.env("CARGO_INCREMENTAL", "0");
    let messages = output(&mut cargo)?;
    let mut libraries = messages.lines().filter_map(shared_library);
    libraries
        .next()
        .ok_or_else(|| Error::Cargo { command: line(&cargo), problem: "made no shared library".into() })
}

/// The cargo that runs us, or the one on the path, in the workspace.
pub(crate) fn cargo() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(workspace());
    cargo
}

/// Runs cargo with its own messages shown, and returns what it prints for machines.
pub(crate) fn output(cargo: &mut Command) -> Result<String> {
    let command = line(cargo);
    let failed = |problem: String| Error::Cargo { command: command.clone(), problem };
    cargo.stdin(Stdio::null()).stderr(Stdio::inherit());
    let output =
        cargo.output().map_err(|e| failed(format!("cannot be run: {e}; install the Rust toolchain")))?;
    if !output.status.success() {
        return Err(failed(format!("failed ({}); its messages are above", output.status)));
    }
    String::from_utf8(output.stdout).map_err(|e| failed(format!("printed no UTF-8: {e}")))
}

fn line(command: &Command) -> String {
    let words = std::iter::once(command.get_program()).chain(command.get_args());
    words.map(|word| word.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ")
}

/// Compiler flags: no folder of this machine in the binary, so that builds in two folders are equal. They take the
/// place of the user's own, which must not change what is shipped.
fn flags() -> String {
    let remap = |from: &Path, to: &str| format!("--remap-path-prefix={}={to}", from.to_string_lossy());
    let mut flags = vec![remap(workspace(), "/vibro-impact")];
    let home = std::env::var_os("CARGO_HOME").map(PathBuf::from);
    if let Some(home) = home.or_else(|| Some(std::env::home_dir()?.join(".cargo"))) {
        flags.push(remap(&home, "/cargo"));
    }
    flags.join("\u{1f}")
}

fn shared_library(message: &str) -> Option<PathBuf> {
    let message: serde_json::Value = serde_json::from_str(message).ok()?;
    let ours = message["reason"] == "compiler-artifact" && message["target"]["name"] == "vibro_impact";
    let files = message["filenames"].as_array().filter(|_| ours)?;
    files.iter().filter_map(|f| f.as_str()).find(|f| f.ends_with(SHARED_LIBRARY)).map(PathBuf::from)
}
