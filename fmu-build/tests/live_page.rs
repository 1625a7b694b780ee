//! `fmu-build --explorer` from end to end: the archives, unpacked, and the live page in them in
//! Chromium. Runs only on request, because it compiles the core for wasm32-unknown-unknown and
//! requires node with npm, and Chromium; missing tools are named.

use fmu_build::version::Version;
use fmu_build::{compile, explorer};
use std::ffi::OsString;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Output};

fn packed(fmu: &Path, environment: &[(&str, OsString)]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fmu-build"));
    command.args(["--explorer", "--no-run", "--out"]).arg(fmu).envs(environment.iter().cloned());
    command.output().unwrap()
}

fn unpack(archive: &Path, folder: &Path) {
    zip::ZipArchive::new(File::open(archive).unwrap()).unwrap().extract(folder).unwrap();
}

#[test]
#[ignore = "needs the target wasm32-unknown-unknown, node with npm, and Chromium"]
fn chromium_plays_the_live_page_of_an_unpacked_archive() {
    let folder = tempfile::tempdir().unwrap();
    let fmu = folder.path().join("x.fmu");
    let output = packed(&fmu, &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(!told.contains("left out"), "{told}");
    for version in Version::USUAL {
        let unpacked = folder.path().join(version.name());
        unpack(&version.beside(&fmu), &unpacked);
        let index = fs::read_to_string(unpacked.join("documentation/index.html")).unwrap();
        assert_eq!(index.matches("<a href=\"explorer.html\">").count(), 1);
        assert!(!index.contains("<script"));
        // Opened as a file: it loads nothing, describes its motion, moves, and has no error.
        let mut node = Command::new("node");
        node.arg(compile::workspace().join("web/explorer/page/test/page.mjs"));
        node.arg(compile::target().join("explorer/npm")).arg(unpacked.join(explorer::PATH));
        let done = node.arg(folder.path().join("shown")).arg("opens from a file").output().unwrap();
        let printed = String::from_utf8_lossy(&done.stdout).into_owned();
        assert!(done.status.success(), "{printed}{}", String::from_utf8_lossy(&done.stderr));
        assert!(printed.starts_with("ok "), "{printed}");
    }
}

/// If node does not run, the archives are complete except for the page, and the message names the
/// tool to install.
#[cfg(unix)]
#[test]
#[ignore = "compiles the tool that makes the page"]
fn what_the_live_page_lacks_is_named_and_the_archives_are_packed_without_it() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let node = folder.path().join("node");
    fs::write(&node, "#!/bin/sh\nexit 1\n").unwrap();
    fs::set_permissions(&node, fs::Permissions::from_mode(0o755)).unwrap();
    let mut path = folder.path().as_os_str().to_owned();
    path.push(":");
    path.push(std::env::var_os("PATH").unwrap());
    let fmu = folder.path().join("x.fmu");
    let output = packed(&fmu, &[("PATH", path)]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    let expected =
        "documentation/explorer.html is left out: node is missing: install Node.js 18 or later with npm";
    assert!(told.lines().any(|line| line.starts_with(expected)), "{told}");
    for version in Version::USUAL {
        let unpacked = folder.path().join(version.name());
        unpack(&version.beside(&fmu), &unpacked);
        assert!(!unpacked.join(explorer::PATH).exists());
        let index = fs::read_to_string(unpacked.join("documentation/index.html")).unwrap();
        assert!(!index.contains("explorer.html"));
    }
}
