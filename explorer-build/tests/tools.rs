//! A tool that is missing is said, with what to install.

use std::process::Command;

#[test]
fn a_missing_target_is_told_with_what_to_install() {
    let output =
        Command::new(env!("CARGO_BIN_EXE_explorer-build")).env("RUSTC", "no-such-rustc").output().unwrap();
    assert!(!output.status.success());
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.starts_with("explorer-build: the Rust target wasm32-unknown-unknown is missing"), "{told}");
    assert!(told.contains("`rustup target add wasm32-unknown-unknown`"), "{told}");
}
