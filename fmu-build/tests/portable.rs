//! The portable library: two builds in two folders give the same bytes, which contain neither
//! path, and require only the C library.

mod common;

use fmu_build::compile::{self, Compiler, PLATFORM};
use fmu_build::platforms::{self, PLATFORMS};
use fmu_build::version::Version;
use fmu_build::{archive, inspect};
use std::fs;
use std::path::Path;
use std::process::Command;

/// Generated folders in a work tree, which are not source.
const MADE: [&str; 4] = ["target", "dist", "vibro-out", "__pycache__"];

/// Copies changed files, so that a second run of this test finds everything compiled. Cargo
/// requires every package of the workspace, so everything is copied except generated and hidden
/// folders.
fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(from).unwrap() {
            let name = entry.unwrap().file_name();
            if name.to_str().is_some_and(|name| MADE.contains(&name) || name.starts_with('.')) {
                continue;
            }
            copy(&from.join(&name), &to.join(&name));
        }
        return;
    }
    let bytes = fs::read(from).unwrap();
    if fs::read(to).ok().as_ref() != Some(&bytes) {
        fs::create_dir_all(to.parent().unwrap()).unwrap();
        fs::write(to, bytes).unwrap();
    }
}

/// The second folder has a path of different length; everything in it is compiled again, including
/// dependencies.
#[test]
#[ignore = "compiles the library twice: cargo test -p fmu-build --test portable -- --ignored"]
fn another_folder_gives_the_same_bytes() {
    let second = compile::target().join("reproducible-in-another-folder");
    copy(compile::workspace(), &second.join("sources"));
    let here = Compiler::default().library().unwrap();
    let there = Compiler::in_folders(&second.join("sources"), &second.join("compiled")).library().unwrap();
    assert_ne!(here, there);
    let (here, there) = (fs::read(here).unwrap(), fs::read(there).unwrap());
    let differ = here.iter().zip(&there).position(|(a, b)| a != b);
    assert!(here == there, "{} and {} bytes, first difference at {differ:?}", here.len(), there.len());

    assert_eq!(inspect::exports(&here).unwrap(), common::functions());
    // For example, no libgcc_s, which a host's computer may lack.
    let needs = inspect::needs(&here).unwrap();
    assert!(!needs.is_empty(), "even sin() comes from somewhere");
    let foreign: Vec<&String> = needs.iter().filter(|name| !inspect::is_system(name)).collect();
    assert!(foreign.is_empty(), "{foreign:?} of {needs:?}");
    let home = std::env::home_dir().unwrap().join(".cargo");
    for folder in [compile::workspace(), &compile::target(), &home] {
        let name = folder.to_str().unwrap().as_bytes();
        assert!(!here.windows(name.len()).any(|window| window == name), "{}", folder.display());
    }
}

/// The archive of the corresponding option of the packager, which is also run.
#[test]
#[ignore = "compiles the library: cargo test -p fmu-build --test portable -- --ignored"]
fn the_portable_library_is_what_is_packed() {
    let folder = tempfile::tempdir().unwrap();
    let fmu = folder.path().join("x.fmu");
    let mut packager = Command::new(env!("CARGO_BIN_EXE_fmu-build"));
    let output = packager.args(["--portable", "--periods", "60", "--out"]).arg(&fmu).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(printed.contains("bit for bit"), "{printed}");
    let platform = PLATFORMS.into_iter().find(|platform| platform.place.folder == PLATFORM).unwrap();
    let packed = archive::read(&fmu, &platform.path(Version::Fmi2)).unwrap();
    assert!(packed == fs::read(Compiler::default().library().unwrap()).unwrap());
}

#[test]
#[ignore = "compiles the library: cargo test -p fmu-build --test portable -- --ignored"]
fn a_missing_tool_is_named_with_what_to_install() {
    let folder = tempfile::tempdir().unwrap();
    let fmu = folder.path().join("x.fmu");
    let path = std::env::var_os("PATH").unwrap_or_default();
    let without: Vec<_> =
        std::env::split_paths(&path).filter(|folder| !folder.join("cargo-zigbuild").exists()).collect();
    let output = Command::new(env!("CARGO_BIN_EXE_fmu-build"))
        .args(["--all-platforms", "--no-run", "--out"])
        .arg(&fmu)
        .env("PATH", std::env::join_paths(without).unwrap())
        .output()
        .unwrap();
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    for platform in PLATFORMS {
        let line = printed.lines().find(|line| line.starts_with(platform.place.folder)).unwrap();
        assert!(line.contains(platforms::TOOLS), "{line}");
        let packed = archive::read(&fmu, &platform.path(Version::Fmi2)).is_ok();
        assert_eq!(packed, platform.place.folder == PLATFORM, "{line}");
    }
}
