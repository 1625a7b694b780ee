//! Runs the real `vibro` twice in one folder: no run's files are lost through another run, through
//! Ctrl-C or through a second program at the same time.

#[path = "common/mod.rs"]
mod command;

use command::{begun, command, drawn, files, folder, killed, parts};
use std::path::Path;
use std::process::{Command, Output};

/// A basin in some parts, each a fraction of a second.
const BASIN: [&str; 5] = ["basin", "--resolution", "16", "--discard", "60"];
const LONGER: [&str; 7] = ["basin", "--resolution", "64", "--discard", "300", "--threads", "1"];

/// Exit code and standard error.
fn outcome(output: &Output) -> (Option<i32>, String) {
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// Standard error of a run that exits with 2 and leaves the folder unchanged.
fn refused(out: &Path, arguments: &[&str]) -> String {
    let before = files(out);
    let (code, error) = outcome(&command(out, arguments).output().expect("vibro runs"));
    assert_eq!(code, Some(2), "{arguments:?}: {error}");
    assert!(before == files(out), "{arguments:?} changed the folder");
    error
}

/// Runs in the default folder of a working folder.
fn by_default(home: &Path, arguments: &[&str]) -> String {
    let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
    let output = vibro.arg("paper").args(arguments).current_dir(home).output().expect("vibro runs");
    assert!(output.status.success(), "{arguments:?}: {}", outcome(&output).1);
    String::from_utf8(output.stdout).expect("text")
}

#[test]
fn a_run_with_other_parameters_is_refused_and_keeps_the_parts_of_the_first() {
    let out = folder("folders-parts");
    drawn(&out, &[&BASIN[..], &["--shard", "1/2"]].concat());
    let error = refused(&out, &[&BASIN[..], &["--set", "kappa=0.6"]].concat());
    for word in [
        "basin.parts: holds ",
        "begun by: vibro paper basin --resolution 16 --discard 60 (version ",
        "kappa: 0.75 there, 0.6 here",
        "stop.restitution: 0.75 there, 0.6 here",
        "another --out",
        "vibro merge",
        "--discard-unfinished",
    ] {
        assert!(error.contains(word), "{word}: {error}");
    }
    // Other options make another study too.
    let error = refused(&out, &["basin", "--resolution", "16", "--discard", "61"]);
    assert!(error.contains("--discard: 60 there, 61 here"), "{error}");
    // `--replace` is for results, not for parts.
    refused(&out, &[&BASIN[..], &["--set", "kappa=0.6", "--replace"]].concat());
    drawn(&out, &[&BASIN[..], &["--set", "kappa=0.6", "--discard-unfinished"]].concat());
    assert!(out.join("basin.csv").exists() && !out.join("basin.parts").exists());
}

#[test]
fn the_default_folder_gives_a_run_with_other_parameters_a_folder_of_its_own() {
    let (home, out) = (folder("folders-default"), folder("folders-default-alone"));
    std::fs::create_dir_all(&home).unwrap();
    let share = |assignment: &str, share: &str| {
        by_default(&home, &[&BASIN[..], &["--set", assignment, "--shard", share]].concat())
    };
    share("kappa=0.5", "1/2");
    let before = files(&home);
    let text = share("kappa=0.6", "1/2");
    let after = files(&home);
    assert!(before.iter().all(|(path, bytes)| after.get(path) == Some(bytes)), "the first lost a file");
    assert!(text.contains("parts of `basin` are in vibro-out/basin-"), "{text}");
    // Each study continues its own parts.
    let text = share("kappa=0.6", "2/2");
    assert!(
        text.contains("vibro-out holds results of other parameters; the new results are in vibro-out/basin-"),
        "{text}"
    );
    share("kappa=0.5", "2/2");
    drawn(&out, &[&BASIN[..], &["--set", "kappa=0.5"]].concat());
    let drawn_alone = std::fs::read(out.join("basin.csv")).unwrap();
    assert!(std::fs::read(home.join("vibro-out/basin.csv")).unwrap() == drawn_alone);
    // An equal run has the same folder and prints no note.
    let again = by_default(&home, &[&BASIN[..], &["--set", "kappa=0.5"]].concat());
    assert!(again.contains("into vibro-out/basin.svg") && !again.contains("the new results are"), "{again}");
}

#[test]
fn finished_results_are_overwritten_by_the_same_command_only() {
    let out = folder("folders-results");
    drawn(&out, &["steady", "--set", "kappa=0.7"]);
    let first = files(&out);
    drawn(&out, &["steady", "--set", "kappa=0.7", "--threads", "1"]);
    assert!(first == files(&out), "the same command makes the same files");
    let error = refused(&out, &["steady", "--set", "kappa=0.8"]);
    for word in [
        "holds the result `steady` of another run",
        "kappa: 0.7 there, 0.8 here",
        "use another --out, or overwrite it with --replace",
    ] {
        assert!(error.contains(word), "{word}: {error}");
    }
    drawn(&out, &["steady", "--set", "kappa=0.8", "--replace"]);
    assert!(files(&out)["steady.csv"] != first["steady.csv"]);
    // Different figures of one command share a folder.
    drawn(&out, &["manifold", "--figure", "2"]);
    drawn(&out, &["manifold", "--figure", "7"]);
    // Long studies are refused before any work.
    drawn(&out, &BASIN);
    let error = refused(&out, &[&BASIN[..], &["--set", "kappa=0.6"]].concat());
    assert!(error.contains("holds the result `basin` of another run"), "{error}");
}

#[test]
fn manifests_say_what_a_result_was_computed_from() {
    let out = folder("folders-manifest");
    drawn(&out, &["response", "--kind", "force", "--set", "kappa=0.7", "--threads", "2"]);
    let text = std::fs::read_to_string(out.join("response-force.manifest.toml")).unwrap();
    let manifest: toml::Table = text.parse().unwrap();
    assert_eq!(manifest["program"].as_str(), Some("vibro"));
    assert_eq!(manifest["version"].as_str(), Some(env!("CARGO_PKG_VERSION")));
    assert_eq!(manifest["study"].as_str(), Some("response-force"));
    let line = manifest["invocation"]["command_line"].as_str();
    assert_eq!(line, Some("vibro paper response --kind force --set kappa=0.7"));
    let (si, groups) = (manifest["si"].as_table().unwrap(), manifest["groups"].as_table().unwrap());
    assert_eq!((si.len(), groups.len()), (13, 10));
    assert_eq!((si["stop.restitution"].as_float(), groups["kappa"].as_float()), (Some(0.7), Some(0.7)));
}

#[test]
fn planes_whose_tables_do_not_fit_into_memory_are_refused_before_anything_is_written() {
    let out = folder("folders-memory");
    std::fs::create_dir_all(&out).unwrap();
    // Each plane fits into memory, but not with its table.
    for (study, resolution) in [("plane", "5000"), ("isoperiodic", "2500"), ("basin", "5000")] {
        let error = refused(&out, &[study, "--resolution", resolution]);
        let side: f64 = resolution.parse().unwrap();
        assert!(error.contains(&format!("points of the plane: {} requested", side * side)), "{error}");
        assert!(error.contains("fit into memory"), "{error}");
    }
    assert!(std::fs::read_dir(&out).unwrap().next().is_none());
}

#[test]
fn what_others_have_written_is_refused_by_name_and_never_removed() {
    let out = folder("folders-foreign");
    std::fs::create_dir_all(out.join("basin.parts")).unwrap();
    std::fs::write(out.join("steady.csv"), "somebody's").unwrap();
    std::fs::write(out.join("plane.manifest.toml"), "half a manif").unwrap();
    std::fs::write(out.join("basin.parts/manifest.toml"), "program = \"another\"").unwrap();
    let error = refused(&out, &["steady"]);
    assert!(error.contains("holds steady.csv without steady.manifest.toml"), "{error}");
    let error = refused(&out, &["plane", "--resolution", "10"]);
    assert!(error.contains("plane.manifest.toml: is not a manifest of vibro, or is damaged"), "{error}");
    let error = refused(&out, &[&BASIN[..], &["--discard-unfinished"]].concat());
    assert!(error.contains("manifest.toml: is not a manifest of vibro, or is damaged"), "{error}");
}

#[cfg(unix)]
#[test]
fn ctrl_c_says_what_is_kept_and_which_command_goes_on() {
    use std::os::unix::process::ExitStatusExt;
    let (out, whole) = (folder("folders-interrupted"), folder("folders-whole"));
    let child = begun(&out, &LONGER, LONGER[0], 1);
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill runs").success());
    let output = child.wait_with_output().unwrap();
    let (code, error) = outcome(&output);
    assert_eq!((code, output.status.signal()), (Some(130), None), "{error}");
    let count = format!("interrupted: {} of ", parts(&out, LONGER[0]).len());
    assert!(error.starts_with(&count) && error.contains("parts of `basin` are kept in"), "{count}: {error}");
    let line = format!("vibro paper {} --out {}", LONGER.join(" "), out.display());
    assert!(error.trim_end().ends_with(&line), "{line}: {error}");
    drawn(&out, &LONGER);
    drawn(&whole, &LONGER);
    assert!(files(&out) == files(&whole), "an interrupted study ends as one in one piece");
}

#[test]
fn invariant_a_killed_plane_goes_on_to_the_same_bytes() {
    const PLANE: [&str; 11] = [
        "isoperiodic",
        "--pair",
        "sigma1,f10",
        "--resolution",
        "48",
        "--discard",
        "200",
        "--periods",
        "0",
        "--threads",
        "1",
    ];
    const NAME: &str = "isoperiodic-sigma1-f10";
    let (out, whole) = (folder("folders-killed"), folder("folders-not-killed"));
    let child = begun(&out, &PLANE, NAME, 1);
    killed(child);
    assert!(!parts(&out, NAME).is_empty() && !out.join(format!("{NAME}.csv")).exists());
    drawn(&out, &PLANE);
    // In one run, on another number of threads.
    drawn(&whole, &PLANE[..9]);
    let drawings = |home: &Path| {
        let mut files = files(home);
        files.retain(|name, _| !name.ends_with(".toml"));
        files
    };
    let (killed, not_killed) = (drawings(&out), drawings(&whole));
    assert!(killed == not_killed && killed.contains_key(&format!("{NAME}.csv")));
}

#[test]
fn a_second_program_in_the_folder_is_refused() {
    let out = folder("folders-two");
    let first = begun(&out, &LONGER, LONGER[0], 1);
    let (code, error) = outcome(&command(&out, &LONGER).output().expect("vibro runs"));
    killed(first);
    assert_eq!(code, Some(2), "{error}");
    assert!(error.contains("basin.parts: another vibro is computing parts in this folder"), "{error}");
    assert!(!parts(&out, LONGER[0]).is_empty());
}
