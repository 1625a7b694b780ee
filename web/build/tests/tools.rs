//! The message for a missing tool names it and what to install.

use std::process::Command;

#[test]
fn a_missing_target_is_told_with_what_to_install() {
    let output =
        Command::new(env!("CARGO_BIN_EXE_web-build")).env("RUSTC", "no-such-rustc").output().unwrap();
    assert!(!output.status.success());
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.starts_with("web-build: the Rust target wasm32-unknown-unknown is missing"), "{told}");
    assert!(told.contains("`rustup target add wasm32-unknown-unknown`"), "{told}");
}

/// A compiler that reports the target as installed, and a node that does not run.
#[cfg(unix)]
#[test]
fn a_missing_node_is_told_with_what_to_install() {
    use std::os::unix::fs::PermissionsExt;
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("tools");
    std::fs::create_dir_all(&folder).unwrap();
    for (name, script) in [("rustc", format!("echo {}", folder.display())), ("node", "exit 1".to_owned())] {
        let file = folder.join(name);
        std::fs::write(&file, format!("#!/bin/sh\n{script}\n")).unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o755)).unwrap();
    }
    let output = Command::new(env!("CARGO_BIN_EXE_web-build"))
        .env("RUSTC", folder.join("rustc"))
        .env("PATH", &folder)
        .output()
        .unwrap();
    assert!(!output.status.success());
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(told.starts_with("web-build: node is missing: install Node.js 18 or later with npm"), "{told}");
}
