//! Runs the real `vibro run`: its files, its summary, loads from files, errors.

#[path = "common/mod.rs"]
mod command;

use command::{command, drawn, folder, pixels};
use std::path::{Path, PathBuf};
use vibro_impact::load::{Body, Interpolation, Load};
use vibro_impact::simulator::Pause;
use vibro_impact::{Parameters, Simulator, State};

/// Tolerance between rows of a run and a single advance, whose steps and rounding differ.
const ROUNDING: f64 = 1e-10;

fn columns(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let header = reader.headers().expect("a header").iter().map(String::from).collect();
    let rows = reader.records().map(|r| r.expect("a row").iter().map(String::from).collect()).collect();
    (header, rows)
}

fn number(cell: &str) -> f64 {
    cell.parse().expect("a number")
}

/// A file outside the folder of the output.
fn file(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

#[test]
fn second_method_the_default_run_is_the_settled_motion() {
    let out = folder("run-default");
    let text = drawn(&out, &["run"]);
    assert!(text.contains("class: 1T") && text.contains("its own mirror image"), "{text}");
    assert!(
        text.contains("impacts: 40 in all; 1 a drive period at the upper stop, 1 at the lower"),
        "{text}"
    );
    assert!(text.contains("400 drive periods discarded") && text.contains("v2=1"), "{text}");
    let orbit =
        vibro_impact::steady::exact_orbit::solve(&Parameters::default()).unwrap().upper.expect("an orbit");
    let (header, rows) = columns(&out.join("run.csv"));
    assert_eq!(header.join(","), "time,x1,x2,x3,w,v1,v2,v3,dw,contact");
    assert_eq!(rows.len(), 2001);
    let p = Parameters::default();
    for row in &rows {
        let exact = orbit.state(p.drive_frequency * number(&row[0]) + p.drive_phase);
        assert!((number(&row[1]) - exact.x[0]).abs() < 1e-8 && row[9] == "flight", "{row:?}");
    }
    let (header, impacts) = columns(&out.join("run-impacts.csv"));
    assert_eq!((header.join(","), impacts.len()), ("time,side,speed,impulse".into(), 40));
    let (width, height, _) = pixels(&out.join("run.png"));
    assert!(width > 900 && height > 500);
}

#[test]
fn second_method_a_load_from_a_file_is_the_librarys() {
    let samples = [(0.0, 0.0), (2.0, 0.4), (3.0, -0.1), (9.0, 0.05)];
    let rows: String = samples.iter().map(|(t, f)| format!("{t};{f}\n")).collect();
    let record = file("run-record.csv", &format!("t [s];f [N]\n{rows}"));
    let load = Load::new(Body::Block, &samples, Interpolation::Cubic).unwrap();
    let out = folder("run-load");
    let given = format!("block={}", record.display());
    let cubic = ["--interpolation", "cubic", "--duration", "30", "--start", "x2=0.5"];
    let text = drawn(&out, &[&["run", "--load", &given], &cubic[..]].concat());
    assert!(text.contains("load on block from 0 to 9 s") && !text.contains("class:"), "{text}");
    let start = State { x: [0.0, 0.5, 0.0], v: [0.0; 3] };
    let mut simulator = Simulator::new(&Parameters::default(), &start, 0.0).unwrap();
    simulator.advance_under(&[load], 30.0, Pause::Never, None).unwrap();
    let (_, rows) = columns(&out.join("run.csv"));
    let last = rows.last().expect("rows");
    assert_eq!(number(&last[0]), 30.0);
    for i in 0..3 {
        assert!((number(&last[1 + i]) - simulator.state().x[i]).abs() < ROUNDING, "{last:?}");
    }
    let impacts = columns(&out.join("run-impacts.csv")).1.len() as u64;
    assert_eq!(impacts, simulator.impacts().upper + simulator.impacts().lower);
}

#[test]
fn closed_form_of_units_in_duration_and_start() {
    // Without load, drive and coupling the block flies freely from x2 = 5 mm with 0.2 m/s, in a
    // wide gap.
    let out = folder("run-units");
    let set = ["drive.amplitude=0", "coupling.k=0", "stop.gap=2", "box.m=1"].map(|a| ["--set", a]).concat();
    let start = ["run", "--duration", "1500 ms", "--start", "block.s=5mm,block.v=20 cm/s"];
    command(&out, &[&start[..], &set].concat()).status().expect("vibro runs");
    let (_, rows) = columns(&out.join("run.csv"));
    let last = rows.last().expect("rows");
    assert_eq!(number(&last[0]), 1.5);
    assert!((number(&last[2]) - (0.005 + 0.2 * 1.5)).abs() < 1e-15, "{last:?}");
    let out = folder("run-periods");
    let text = drawn(&out, &["run", "--duration", "2.5 periods", "--start", "orbit"]);
    assert!(text.contains("(2.5 drive periods)"), "{text}");
}

#[test]
fn a_changed_record_is_another_study() {
    let record = file("run-changing.csv", "0,0\n1,0.5\n2,0\n");
    let given = format!("box={}", record.display());
    let out = folder("run-changing");
    drawn(&out, &["run", "--load", &given, "--duration", "2"]);
    // Another file with the same contents, and the same duration in another unit, are the same
    // study.
    let copy = format!("box={}", file("run-moved.csv", "0,0\n1,0.5\n2,0\n").display());
    drawn(&out, &["run", "--load", &copy, "--duration", "2000ms"]);
    file("run-changing.csv", "0,0\n1,0.6\n2,0\n");
    let output = command(&out, &["run", "--load", &given, "--duration", "2"]).output().expect("vibro runs");
    let error = String::from_utf8(output.stderr).expect("text");
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(error.contains("--load: box=file of ") && error.contains("--replace"), "{error}");
}

#[test]
fn what_cannot_be_run_is_refused_by_name_and_nothing_is_written() {
    let bad = file("run-bad.csv", "t,f\n0,1\n0.5,2\n0.25,3\n");
    let units = file("run-units.csv", "t [kg],f [N]\n0,1\n1,3\n");
    let (bad, units) = (format!("box={}", bad.display()), format!("box={}", units.display()));
    for (arguments, words) in [
        (vec!["--load", &bad], "run-bad.csv: line 4, time 0.25 s, force 3 N: expected a time later"),
        (vec!["--load", &units], "line 1: `t` has the unit `kg`; expected one of s, ms"),
        (vec!["--load", "lid=a.csv"], "a body of box, block, secondary"),
        (vec!["--load", "box=no-such.csv"], "--load: no-such.csv: no such file"),
        (vec!["--duration", "-1"], "a finite time > 0"),
        (vec!["--duration", "2 Hz"], "200 periods"),
        (vec!["--start", "block.s=5kg"], "block.s=5mm"),
        (vec!["--duration", "nan"], "a finite time > 0"),
        (vec!["--start", "x2=1.5"], "block.s - box.s = 1.5 m"),
        (
            vec!["--periods", "4000000"],
            "a run of 4000000 drive periods with 100 rows in each: expected at most",
        ),
    ] {
        let out = folder("run-refused");
        let output = command(&out, &[&["run"], &arguments[..]].concat()).output().expect("vibro runs");
        let text = String::from_utf8(output.stderr).expect("text");
        assert!(text.contains(words), "{arguments:?}: {text}");
        assert_eq!((output.status.code(), out.exists()), (Some(2), false), "{arguments:?}");
    }
}

/// The texts of a run's picture and the lines of its caption, and the picture's size in bytes.
fn picture(out: &Path) -> (Vec<String>, usize) {
    let svg = std::fs::read_to_string(out.join("run.svg")).expect("a picture");
    assert!(!svg.contains("NaN"));
    let texts = svg.split("<text").skip(1).filter_map(|t| t.split_once('>')?.1.split('<').next());
    let caption = std::fs::read_to_string(out.join("run.caption.txt")).expect("a caption");
    (texts.chain(caption.lines()).map(String::from).collect(), svg.len())
}

/// Whether a picture's joined texts contain these words.
fn says(texts: &[String], words: &str) -> bool {
    texts.join(" ").contains(words)
}

#[test]
fn invariant_a_run_of_many_periods_is_an_envelope_and_its_picture_bounded() {
    // Largest picture, bytes: 20 periods of chaos take some 100 kB.
    const LARGEST: usize = 500_000;
    for (periods, window) in [("41", "in each drive period"), ("900", "in every 3 drive periods")] {
        let out = folder("run-many");
        drawn(&out, &["run", "--periods", periods, "--discard", "0", "--set", "f10=3.6"]);
        let (texts, size) = picture(&out);
        assert!(size < LARGEST, "{periods}: {size} bytes");
        for words in [
            "(a) Box, block and secondary, the whole run: least and largest",
            "(b) Box, block and secondary, the last 10 drive periods",
            "(e) Impact speeds",
            &format!("Areas: from the least to the largest value {window}."),
        ] {
            assert!(says(&texts, words), "{periods}: {words} in {texts:?}");
        }
    }
    let out = folder("run-forty");
    drawn(&out, &["run", "--periods", "40", "--discard", "0"]);
    let texts = picture(&out).0;
    assert!(says(&texts, "(a) Box, block and secondary") && !says(&texts, "whole run"), "{texts:?}");
}

/// The machine of docs/design-a-damper.md.
const DAMPER: &str = "[si]\nbox.m = 12\nbox.k = 48e3\nbox.c = 30\nblock.m = 1.2\nstop.gap = \"0.015 m\"\nstop.restitution = 0.6\n\
    drive.amplitude = 75\ndrive.frequency = \"10 Hz\"\ncoupling.k = 0\nsecondary.m = 1\nsecondary.k = 1e3\nsecondary.c = 1\n";

#[test]
fn what_does_not_change_is_told_and_not_drawn() {
    let machine = file("run-damper.toml", DAMPER);
    let machine = machine.to_str().expect("a path");
    let out = folder("run-damper");
    drawn(&out, &["run", "--config", machine]);
    let texts = picture(&out).0;
    // The gap was given in m, but lengths are in mm, and speeds of about 1 m/s in m/s.
    for words in [
        "(a) Box and block",
        "displacement (mm)",
        "dw/dt (m/s)",
        "x₃, the secondary, to which nothing couples the block, stays at 0 mm",
        "all 40 impacts have a speed of 1.01",
    ] {
        assert!(says(&texts, words), "{words} in {texts:?}");
    }
    assert!(
        !texts.iter().any(|t| t.starts_with("x₃, secondary") || t.contains("Impact speeds")),
        "{texts:?}"
    );
    // A block in the middle that touches nothing; only the box moves.
    let few = ["--start", "box.v=0.01", "--set", "drive.amplitude=0N", "--periods", "5"];
    let out = folder("run-alone");
    drawn(&out, &[&["run", "--config", machine], &few[..]].concat());
    let texts = picture(&out).0;
    assert!(says(&texts, "(a) Box") && says(&texts, "x₂, the block, stays at 0 mm"), "{texts:?}");
    assert!(says(&texts, "there are no impacts") && !says(&texts, "No impacts"), "{texts:?}");
    // Nothing moves: no picture, and the reason.
    let still = ["--start", "box.v=0", "--set", "drive.amplitude=0N", "--periods", "5"];
    let out = folder("run-still");
    let text = drawn(&out, &[&["run", "--config", machine], &still[..]].concat());
    assert!(text.contains("no picture, because nothing changes"), "{text}");
    assert!(out.join("run.csv").exists() && !out.join("run.svg").exists());
}

#[test]
fn second_method_bifurcation_of_the_box_has_the_orbits_amplitude() {
    let out = folder("run-bifurcation-of-x1");
    let few = ["--range", "f10=1.4:1.6", "--resolution", "3", "--keep", "20"];
    let text = drawn(&out, &[&["bifurcation", "--of", "x1"], &few[..]].concat());
    assert!(text.contains("local maxima of X₁ over"), "{text}");
    let (header, rows) = columns(&out.join("bifurcation-x1.csv"));
    assert_eq!(header[2], "X1_maximum");
    let row = rows.iter().find(|r| r[0] == "1.5").expect("a row");
    let orbit =
        vibro_impact::steady::exact_orbit::solve(&Parameters::default()).unwrap().upper.expect("an orbit");
    // Maxima are kept to six decimals.
    assert!((number(&row[2]) - orbit.amplitudes()[0]).abs() < 1e-6, "{row:?}");
}
