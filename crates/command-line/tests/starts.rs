//! Runs the real `vibro` from starts: a motion continues another motion, numbers by name, and
//! errors.

#[path = "common/mod.rs"]
mod command;

use command::{command, drawn, folder, refused, table};
use std::collections::HashMap;

/// Rounding of a state times the growth of errors over the compared time.
const ROUNDING: f64 = 1e-9;

fn damper() -> String {
    format!("{}/../../examples/assembly/damper_with_buffer.toml", env!("CARGO_MANIFEST_DIR"))
}

fn number(row: &HashMap<String, String>, name: &str) -> f64 {
    row[name].parse().unwrap()
}

#[test]
fn invariant_a_run_goes_on_from_the_end_of_another() {
    let damper = damper();
    let run = |name: &str, more: &[&str]| {
        let out = folder(name);
        drawn(&out, &[&["run", &damper][..], more].concat());
        out
    };
    let first = run("starts-first", &["--until", "0.5s", "--samples", "10"]);
    let end = first.join("end.toml").display().to_string();
    let derivatives = ["--derivatives", "body.box.mass"];
    let on = ["--until", "1s", "--samples", "50"];
    let second = run("starts-second", &[&on[..], &["--start", &end], &derivatives].concat());
    let whole = run("starts-whole", &["--until", "1s", "--samples", "100"]);
    let (rows, all) = (table(&second, "states.csv"), table(&whole, "states.csv"));
    assert_eq!((rows.len(), number(&rows[0], "time")), (51, 0.5));
    for (row, whole) in rows.iter().zip(&all[50..]) {
        for name in ["time", "box.s", "block.v", "buffer.f"] {
            let (one, other) = (number(row, name), number(whole, name));
            assert!((one - other).abs() < ROUNDING * (1.0 + other.abs()), "{name}: {one} {other}");
        }
    }
    // The state is given, so that it does not depend on any number of the machine.
    assert_eq!(table(&second, "derivatives.csv")[0]["box.s/body.box.mass"], "0");
    // Numbers after the file override the file's numbers.
    let still = format!("{end},box.v=0,time=0.75s");
    let third = run("starts-third", &["--until", "1s", "--samples", "5", "--start", &still]);
    let row = &table(&third, "states.csv")[0];
    assert_eq!((number(row, "time"), number(row, "box.v")), (0.75, 0.0));
    assert_eq!(row["box.s"], rows[0]["box.s"]);
    let manifest = std::fs::read_to_string(third.join("run.manifest.toml")).unwrap();
    assert!(manifest.contains("start = \"time=0.75,"), "{manifest}");
}

#[test]
fn closed_form_numbers_of_a_start_have_units_and_what_is_not_named_is_the_files() {
    let text = "name = \"S\"\n[body.a]\nmass = 1.0\nstart = { s = \"2 mm\", v = 1.0 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 1.0\n";
    let file = folder("starts-machine").with_extension("toml");
    std::fs::write(&file, text).unwrap();
    let file = file.display().to_string();
    let first = |start: &str| {
        let out = folder("starts-units");
        let line = ["run", &file, "--until", "1", "--samples", "2", "--start", start, "--replace"];
        let run = command(&out, &line).output().unwrap();
        let said = String::from_utf8(run.stderr).unwrap();
        assert!(run.status.success(), "{said}");
        let row = table(&out, "states.csv").swap_remove(0);
        (number(&row, "time"), number(&row, "a.s"), number(&row, "a.v"), said)
    };
    for (start, expected) in [
        ("a.s=5mm", (0.0, 0.005, 1.0)),
        // In the unit that the file uses.
        ("a.s=5", (0.0, 0.005, 1.0)),
        ("body.a.v=20 cm/s,time=250ms", (0.25, 0.002, 0.2)),
        ("time=-1s", (-1.0, 0.002, 1.0)),
    ] {
        let (time, s, v, said) = first(start);
        assert_eq!((time, s, v), expected, "{start}: {said}");
        let note = "note: a.s=5 is read in mm, the unit in which that parameter was written\n";
        assert_eq!(said, if start == "a.s=5" { note } else { "" });
    }
}

#[test]
fn what_is_no_start_is_refused_by_name_with_what_is_allowed() {
    let damper = damper();
    for (start, words) in [
        ("bix.s=1mm", "--start bix.s=1mm: bix.s: no start value has this name; did you mean `box.s`"),
        ("box.s=1N", "--start box.s=1N: box.s = \"1N\": cannot be in `N`; expected one of m, cm, mm, um, in"),
        ("box.s=1,body.box.s=2", "box.s is given twice; give it once"),
        ("block.s=1m", "stop.steel.gap = 0.004 m: e - gap = "),
        (
            "nowhere.toml",
            "--start nowhere.toml: no such file; expected a start file, or NAME=VALUE, such as box.s=1mm",
        ),
        ("box.s=1,nowhere.toml", "expected NAME=VALUE,…, a start's file, or FILE,NAME=VALUE,…"),
        ("time=2s", "--until 1.0: must be after 2.0 s, the time of the start"),
    ] {
        let (code, error) = refused(&["run", &damper, "--until", "1s", "--start", start]);
        assert!(code == 2 && error.contains(words), "{start}: {error}");
    }
    let vary = ["--vary", "body.box.mass=11kg:12kg:2", "--discard", "2"];
    for command in ["bifurcation", "lyapunov"] {
        let (code, error) = refused(&[&[command, &damper][..], &vary, &["--start", "block.s=1m"]].concat());
        assert!(
            code == 2 && error.contains("at the start, t = 0.0 s; a rigid stop requires e <= gap"),
            "{error}"
        );
    }
    let (code, error) = refused(&["lyapunov", &damper, "--start", "block.s=1m"]);
    assert!(
        code == 2 && error.contains("at the start, t = 0.0 s; a rigid stop requires e <= gap"),
        "{error}"
    );
    let (code, error) = refused(&["sweep", &damper, "--start", "boks.s=1m"]);
    assert!(code == 2 && error.contains("did you mean `box.s`"), "{error}");
}

/// A machine's file in the test's folder.
fn written(name: &str, text: &str) -> String {
    let out = folder(name);
    std::fs::create_dir_all(&out).unwrap();
    let path = out.join("m.toml");
    std::fs::write(&path, text).unwrap();
    path.display().to_string()
}

/// A body at 5 mm, beyond a rigid stop at 2 mm.
const BEYOND: &str = "name = \"B\"\n[body.b]\nmass = 1.0\nstart = { s = \"5 mm\" }\n[spring.k]\nbetween = [\"ground\", \"b\"]\n\
    stiffness = \"1 kN/m\"\n[stop.w]\nbetween = [\"ground\", \"b\"]\ngap = \"2 mm\"\nrestitution = 0.5\n";

#[test]
fn set_mends_a_file_whose_start_violates_a_gap() {
    let path = written("starts-beyond", BEYOND);
    let out = folder("starts-beyond-out");
    for set in ["stop.w.gap=6mm", "body.b.start.s=1mm"] {
        let said = drawn(&out, &["check", &path, "--set", set]);
        assert!(said.contains("b: 1 kg; s = "), "{said}");
    }
    // A remaining error is reported with its line, and a new error without one.
    let (_, error) = refused(&["check", &path, "--set", "body.b.start.s=4mm"]);
    assert!(
        error.contains("m.toml:10: stop.w.gap = 2 mm: e = 0.004 m at the start is beyond the gap"),
        "{error}"
    );
    let sound = written("starts-within", &BEYOND.replace("5 mm", "1 mm"));
    let (_, error) = refused(&["check", &sound, "--set", "body.b.start.s=4mm"]);
    assert!(error.contains("error: stop.w.gap = 2 mm: e = 0.004 m at the start"), "{error}");
}

/// A record of 20 mm/s² moves a table by ½ 0.02 10² = 1 m in its 10 s, at 0.1 m/s on average; a
/// load of 5 Hz does not change this.
#[test]
fn closed_form_of_the_mean_speed_that_check_says_of_a_record_with_a_mean() {
    let text = "name = \"R\"\n[body.table]\nmotion = { acceleration = { table = [[0, 0.02], [10, 0.02]] } }\n[body.m]\nmass = 1.0\n\
        [spring.k]\nbetween = [\"table\", \"m\"]\nstiffness = 100.0\n[load.f]\non = \"m\"\namplitude = 1.0\nfrequency = 5.0\n";
    let said = drawn(&folder("starts-record-out"), &["check", &written("starts-record", text)]);
    let words = "table drifts: its mean speed over its record of 10 s is 0.1 m/s and it moves by 1 m; start with v = -0.1 m/s for a mean speed of 0";
    assert!(said.contains(words), "{said}");
}

/// Friction of 1.2 N on a spring of 8 kN/m holds within ±0.15 mm; a dashpot gives one position.
#[test]
fn closed_form_of_where_motions_come_to_rest() {
    let text = "name = \"D\"\n[body.slide]\nmass = \"1 kg\"\n[spring.mount]\nbetween = [\"ground\", \"slide\"]\nstiffness = \"8 kN/m\"\n\
        [friction.guide]\nbetween = [\"ground\", \"slide\"]\nforce = \"1.2 N\"\n";
    let axes = ["--start", "slide.s=-1mm:1mm:5", "--start", "slide.v=-1:1:5"];
    let basin = |name: &str, text: &str| {
        let path = written(&format!("starts-{name}"), text);
        let out = folder(&format!("starts-{name}-out"));
        (drawn(&out, &[&["basin", &path][..], &axes].concat()), table(&out, "basin.csv"))
    };
    let (said, cells) = basin("held", text);
    let (_, places) = said
        .split_once("all 25 motions came to rest (at a range of positions, held by friction): slide.s from ")
        .expect(&said);
    let places = places.replace('−', "-");
    let ends: Vec<f64> = places.split_whitespace().filter_map(|word| word.parse().ok()).take(2).collect();
    assert!(ends[0] < ends[1] && ends.iter().all(|s| s.abs() <= 1.2 / 8e3), "{said}");
    assert!(said.contains("basins of rest over slide.s and slide.v"), "{said}");
    assert!(cells.iter().all(|cell| cell["class"] == "rest"));
    // A preload of 2 N shifts the rest position by 2/8000 m.
    let damped = text.replace("\"8 kN/m\"", "\"8 kN/m\"\ndamping = 40.0\npreload = 2.0");
    let damped = damped
        .replace("[friction.guide]", "[stop.guide]")
        .replace("force = \"1.2 N\"", "gap = 1e-3\nrestitution = 0.5");
    let (said, _) = basin("damped", &damped);
    assert!(said.contains("came to rest (at one position): slide.s = −0.00025 m"), "{said}");
}
