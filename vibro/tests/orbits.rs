//! Runs the real `vibro orbits`, `orbit` and `locus`: the closed form, tables that other studies start from, the same bytes for any
//! number of threads, bad input.

#[path = "common/mod.rs"]
mod command;

use command::{command as vibro, drawn, folder, refused, table};
use std::process::Stdio;
use std::time::{Duration, Instant};

/// Fifteen digits are written, and points are located to about as many.
const LOCATION: f64 = 1e-11;

#[test]
fn closed_form_of_the_branch_with_a_word_and_its_curve_in_two_parameters() {
    let out = folder("orbits-word");
    drawn(&out, &["orbits", "--word", "U-", "--vary", "f10=0.5:3"]);
    let rows = table(&out, "special-points.csv");
    let find =
        |label: &str| rows.iter().position(|r| r["label"] == label).unwrap_or_else(|| panic!("{label}"));
    // The symmetry breaks where the closed form says.
    let breaking = find("BP");
    assert!((rows[breaking]["value"].parse::<f64>().unwrap() - 2.039_588_865_238_452).abs() < LOCATION);
    assert_eq!((&*rows[breaking]["stable_before"], &*rows[breaking]["stable_after"]), ("true", "false"));
    assert!(rows.iter().all(|r| r["word"] == "U" && r["closing"] == "-" && r["period"] == "1"));
    let point = |i: usize| format!("{}:{}", out.join("special-points.csv").display(), i + 1);
    let curves = folder("orbits-locus");
    let ranges = ["--vary", "f10=0.5:3", "--vary", "kappa=0.7:0.8"];
    let points = [point(find("BP")), point(find("LP"))];
    let from = ["--from", &points[0], "--from", &points[1]];
    drawn(&curves, &[&["locus"][..], &from, &ranges].concat());
    let rows = table(&curves, "locus.csv");
    assert!(rows.len() > 20 && curves.join("locus.png").exists());
    for row in rows.iter().filter(|r| r["label"] == "LP") {
        // At a fold the discriminant of the closed form is zero.
        let [f10, kappa] = ["f10", "kappa"].map(|c| row[c].parse::<f64>().unwrap());
        let mut set = vibro_analysis::ParameterSet::basic();
        set.apply(&[format!("f10={f10}"), format!("kappa={kappa}")]).unwrap();
        let family = vibro_impact::steady::exact_orbit::OrbitFamily::new(set.parameters()).unwrap();
        assert!(family.discriminant().abs() < LOCATION, "{row:?}");
    }
}

#[test]
fn a_tree_has_the_same_bytes_for_any_number_of_threads() {
    let bytes = |threads: &str| {
        let out = folder(&format!("orbits-tree-{threads}"));
        let range = ["--vary", "f10=2.0:2.6", "--seeds", "4", "--depth", "1", "--threads", threads];
        drawn(&out, &[&["orbits", "--tree"][..], &range].concat());
        ["branches.csv", "special-points.csv", "orbits.svg"]
            .map(|name| std::fs::read(out.join(name)).unwrap())
    };
    assert_eq!(bytes("1"), bytes("3"));
}

/// A tree of many rounds, each a fraction of a second.
const TREE: [&str; 8] = ["orbits", "--tree", "--vary", "f10=2:3", "--seeds", "5", "--depth", "3"];
/// Far more than a round takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

#[test]
fn an_interrupted_tree_goes_on_to_the_same_bytes() {
    let (out, whole) = (folder("orbits-interrupted"), folder("orbits-whole"));
    let mut child = vibro(&out, &[&TREE[..], &["--threads", "1"]].concat())
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("vibro starts");
    let parts = || {
        let entries = std::fs::read_dir(out.join("orbits.parts")).into_iter().flatten().flatten();
        entries.filter(|e| e.path().extension().is_some_and(|x| x == "part")).count()
    };
    let begin = Instant::now();
    while parts() < 2 {
        assert!(begin.elapsed() < PATIENCE, "no parts in {PATIENCE:?}");
        assert!(child.try_wait().unwrap().is_none(), "it has ended already");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let kept = parts();
    assert!(kept >= 2 && !out.join("branches.csv").exists());
    // Another tree is refused and leaves the parts.
    let other = [&TREE[..], &["--mark", "2.5"]].concat();
    let refusal = vibro(&out, &other).output().expect("vibro runs");
    let message = String::from_utf8_lossy(&refusal.stderr).into_owned();
    let words = format!("holds {kept} finished parts of another run");
    assert!(refusal.status.code() == Some(2) && message.contains(&words), "{message}");
    drawn(&out, &TREE);
    drawn(&whole, &TREE);
    for name in ["branches.csv", "special-points.csv", "orbits.svg"] {
        assert!(std::fs::read(out.join(name)).unwrap() == std::fs::read(whole.join(name)).unwrap(), "{name}");
    }
    assert!(!out.join("orbits.parts").exists());
}

#[test]
fn marked_values_are_rows_of_the_table() {
    let out = folder("orbits-marks");
    drawn(&out, &["orbits", "--word", "U-", "--vary", "f10=0.5:3", "--mark", "1.7,2.5", "--mark", "1.5"]);
    let rows = table(&out, "special-points.csv");
    let marked = rows.iter().filter(|r| r["label"] == "UZ").map(|r| r["value"].parse::<f64>().unwrap());
    let mut marked: Vec<f64> = marked.collect();
    marked.sort_by(f64::total_cmp);
    marked.dedup();
    assert_eq!(marked, [1.5, 1.7, 2.5]);
}

#[test]
fn one_orbit_with_its_impacts_and_multipliers() {
    let out = folder("orbit-three");
    let said = drawn(&out, &["orbit", "--word", "UUL", "--set", "f10=2.7"]);
    assert!(said.contains("stable: largest multiplier"), "{said}");
    let impacts = table(&out, "orbit-impacts.csv");
    assert_eq!(impacts.iter().map(|r| r["stop"].clone()).collect::<Vec<_>>(), ["1", "1", "-1"]);
    assert_eq!(table(&out, "orbit-multipliers.csv").len(), 6);
    assert!(out.join("orbit.png").exists());
    // The settled motion is the same orbit; a load that does nothing changes nothing.
    let settled = folder("orbit-settled");
    drawn(&settled, &["orbit", "--set", "f10=2.7", "--load", "box=0"]);
    assert_eq!(table(&settled, "orbit-impacts.csv").len(), 3);
}

#[test]
fn what_cannot_be_is_refused_with_what_to_do() {
    for (arguments, words) in [
        (&["orbit", "--word", "UX"][..], "letters U and L"),
        (&["orbit", "--word", "UUUUUL"], "none was found from 400 guesses"),
        (&["orbit", "--word", "U-", "--load", "box=0.1"], "give the whole word"),
        (&["orbit", "--word", "UL", "--set", "coupling.k=0"], "coupling.k = 0"),
        (&["orbit", "--set", "kappa=0.05", "--set", "f10=4.5"], "rests at a stop"),
        (&["orbits", "--word", "UL", "--vary", "f10=3:4"], "must lie in the range"),
        (&["orbits", "--vary", "kappa=0.5:1.5"], "kappa = 1.5"),
        (&["orbits", "--vary", "f10=1:2:10"], "without a count"),
        (&["orbits", "--load", "stop=1"], "box, block, secondary"),
        (&["orbits", "--mark", "7"], "must lie in the range 0.5 to 5"),
        (&["orbits", "--mark", "one"], "`one`"),
        (&["orbits", "--step", "0"], "1e-5 to 0.2"),
        (&["locus", "--from", "no.csv:1", "--vary", "f10=1:2", "--vary", "kappa=0.5:0.9"], "no.csv"),
        (&["locus", "--from", "no.csv:1", "--vary", "f10=1:2"], "two, e.g."),
    ] {
        let (code, message) = refused(arguments);
        assert!(code == 2 && message.contains(words), "{arguments:?}: {code} {message}");
    }
}
