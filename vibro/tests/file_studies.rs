//! `vibro response FILE` and the other studies of a machine's file that stand on its orbits: tables
//! against closed forms, refusals by name.

#[path = "common/mod.rs"]
mod command;

use command::{drawn, folder, refused, table};
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// Rounding of an orbit's numbers, relative.
const ROUNDING: f64 = 1e-11;

/// A driven box on a spring that may hit a wall.
const OSCILLATOR: &str = r#"name = "Oscillator"
[body.box]
mass = "1 kg"
[spring.mount]
between = ["ground", "box"]
stiffness = "400 N/m"
damping = "2 N s/m"
[stop.wall]
between = ["ground", "box"]
gap = "1 cm"
restitution = 0.8
[load.shaker]
on = "box"
amplitude = "2 N"
frequency = "3 Hz"
"#;

/// A fresh folder with a machine's file.
fn file(name: &str, text: &str) -> (PathBuf, String) {
    let out = folder(name);
    std::fs::create_dir_all(&out).unwrap();
    let file = out.join("machine.toml");
    std::fs::write(&file, text).unwrap();
    (out, file.to_str().unwrap().into())
}

fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {:?}", row[column]))
}

/// The amplitude without impacts at a frequency, m.
fn amplitude(frequency: f64) -> f64 {
    let omega = TAU * frequency;
    2.0 / (400.0 - omega * omega).hypot(2.0 * omega)
}

#[test]
fn closed_form_a_response_is_linear_up_to_the_frequency_at_which_the_wall_is_touched() {
    let (out, file) = file("file-response", OSCILLATOR);
    let line =
        ["response", &file, "--vary", "load.shaker.frequency=1.5Hz:6Hz", "--of", "amplitude.box.s"];
    let said = drawn(&out.join("r"), &[&line[..], &["--seeds", "8"]].concat());
    assert!(said.contains("branch 0: 1T [no event], from EP 1.5 Hz to GR stop.wall"), "{said}");
    let rows = table(&out.join("r"), "response.csv");
    let free: Vec<_> = rows.iter().filter(|row| row["word"].is_empty()).collect();
    assert!(free.len() > 20 && rows.len() > 2 * free.len(), "{} of {}", free.len(), rows.len());
    for row in free {
        let expected = amplitude(number(row, "load.shaker.frequency"));
        assert!((number(row, "amplitude.box.s") / expected - 1.0).abs() < ROUNDING, "{row:?}");
    }
    // The wall is touched where the amplitude is the gap of 1 cm: |k - m w² + i c w| = F/gap.
    let (b, c): (f64, f64) = (2.0 * 2.0 - 2.0 * 400.0, 400.0 * 400.0 - (2.0f64 / 0.01).powi(2));
    let roots = [-1.0, 1.0].map(|sign| (0.5 * (-b + sign * (b * b - 4.0 * c).sqrt())).sqrt() / TAU);
    let special = table(&out.join("r"), "special-points.csv");
    for root in roots {
        let touched = |row: &&HashMap<String, String>| row["label"] == "GR" && row["element"] == "stop.wall";
        let nearest = special.iter().filter(touched).map(|row| (number(row, "value") / root - 1.0).abs());
        assert!(nearest.fold(f64::INFINITY, f64::min) < ROUNDING, "{root}: {special:?}");
    }
    assert!(Path::new(&out.join("r/response.svg")).exists());
    // Unstable parts too, with the stability named.
    assert!(rows.iter().any(|row| row["stability"] == "unstable"));

    for (words, named) in [
        (&["--kind", "force"][..], "an option of the paper's machine"),
        (&["--depth", "41"], "41"),
        (&["--set", "stop.wall.restitution=2"], "stop.wall.restitution"),
    ] {
        let (_, error) = refused(&[&line, words].concat());
        assert!(error.contains(named), "{words:?}: {error}");
    }
    let (_, error) = refused(&[&line[..4], &["--of", "power.lost"]].concat());
    assert!(error.contains("no measure of an orbit"), "{error}");
    let (_, error) = refused(&["response", "--seeds", "3"]);
    assert!(error.contains("an option of a machine's file"), "{error}");
}
