//! The command itself: it builds, runs and draws, and reports errors.

use std::path::Path;
use std::process::{Command, Output};

fn fmu_build(arguments: &[&str], output: &Path) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fmu-build"));
    command.args(arguments).arg("--out").arg(output).output().unwrap()
}

#[test]
fn builds_runs_and_draws() {
    let folder = tempfile::tempdir().unwrap();
    let fmu = folder.path().join("x.fmu");
    let output = fmu_build(&[], &fmu);
    let (printed, errors) =
        (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    assert!(output.status.success(), "{errors}");
    assert!(printed.contains("bit for bit, at all 40000 communication points"), "{printed}");
    // BASIC settles on one impact per side and period; the amplitudes of its exact orbit are from
    // an independent prototype.
    assert!(printed.contains("1.00 upper + 1.00 lower"), "{printed}");
    let simulated = printed.lines().find(|line| line.contains("simulated")).unwrap();
    let amplitudes: Vec<f64> =
        simulated.split_whitespace().rev().take(3).map(|word| word.parse().unwrap()).collect();
    for (amplitude, expected) in amplitudes.iter().rev().zip([0.3574008, 1.2801013, 0.9555490]) {
        // Sampling 200 times per period misses a smooth maximum by up to 1.2e-4 of it.
        assert!((amplitude / expected - 1.0).abs() < 2e-4, "{simulated}");
    }
    for name in ["exact orbit", "multiple scales"] {
        assert!(printed.lines().any(|line| line.contains(name) && !line.contains("not")), "{printed}");
    }
    let svg = std::fs::read_to_string(fmu.with_extension("svg")).unwrap();
    for label in ["time t/T", "displacement x (m)", "velocity v (m/s)", "relative displacement w (m)"] {
        assert!(svg.contains(label), "{label}");
    }
    let png = std::fs::read(fmu.with_extension("png")).unwrap();
    assert!(png.starts_with(b"\x89PNG") && png.len() > 50_000, "{} bytes", png.len());
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("file");
    std::fs::write(&file, "").unwrap();
    let output = fmu_build(&["--no-run"], &file.join("x.fmu"));
    assert!(!output.status.success());
    let errors = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(errors.contains("fmu-build: ") && errors.contains("file"), "{errors}");
}

#[test]
fn senseless_options_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let output = fmu_build(&["--periods", "0"], &folder.path().join("x.fmu"));
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("--periods"));
}

/// Names of the files that a command writes to its working folder.
fn written_in(folder: &Path, arguments: &[&str]) -> Vec<String> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_fmu-build"));
    let output = command.args(arguments).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<_> = names.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn archives_go_where_the_caller_stands_or_into_the_folder_that_is_named() {
    let both = ["VibroImpact3DOF-FMI3.fmu", "VibroImpact3DOF.fmu"];
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(written_in(folder.path(), &["--no-run"]), both);
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("fmus")).unwrap();
    assert_eq!(written_in(folder.path(), &["--no-run", "--out", "fmus"]), ["fmus"]);
    // The older option, and a folder that does not exist yet.
    assert_eq!(written_in(folder.path(), &["--no-run", "--output", "more/"]), ["fmus", "more"]);
    for name in ["fmus", "more"] {
        assert!(both.iter().all(|fmu| folder.path().join(name).join(fmu).is_file()), "{name}");
    }
}
