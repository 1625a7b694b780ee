//! docs/against-experiment.md: its commands, with the published bounces of a table tennis ball.

#[path = "common/mod.rs"]
mod command;

use command::folder;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Rounding of the times of bounces, s: of a series in the program, of inverse functions here.
const ROUNDING: f64 = 1e-9;
/// Acceleration of gravity, m/s².
const G: f64 = 9.81;
/// Mass of the ball, kg.
const MASS: f64 = 2.7e-3;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).expect("the workspace")
}

/// The page, and a folder with the page's files in which its commands were run.
fn performed() -> (String, PathBuf) {
    let page = fs::read_to_string(root().join("docs/against-experiment.md")).expect("the page");
    let home = folder("experiment");
    fs::create_dir_all(&home).expect("target can be written");
    for entry in fs::read_dir(root().join("examples/experiment")).expect("the records") {
        let path = entry.expect("an entry").path();
        fs::copy(&path, home.join(path.file_name().expect("a name"))).expect("target can be written");
    }
    let commands: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("vibro ")).collect();
    assert_eq!(commands.len(), 3);
    for line in commands {
        let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
        let output = vibro.args(line.split(' ')).current_dir(&home).output().expect("vibro runs");
        assert!(output.status.success(), "{line}: {}", String::from_utf8_lossy(&output.stderr));
    }
    (page, home)
}

/// The value of a number of a fit's record.
fn fitted(home: &Path, fit: &str, record: &str, name: &str) -> f64 {
    let table = fs::read_to_string(home.join(fit).join("numbers.csv")).expect("numbers.csv");
    let row = table.lines().find(|row| row.starts_with(&format!("{record},{name},"))).expect("a row");
    row.split(',').nth(2).and_then(|cell| cell.parse().ok()).expect("a number")
}

/// Columns `time.fit` and `time.residual` of a record's contacts.
fn contacts(home: &Path, fit: &str, record: &str) -> Vec<[f64; 2]> {
    let path = home.join(fit).join(record).join("residuals-contacts.csv");
    let table = fs::read_to_string(path).expect("residuals-contacts.csv");
    let number = |row: &str, k: usize| row.split(',').nth(k).and_then(|cell| cell.parse().ok());
    table.lines().skip(1).map(|row| [2, 3].map(|k| number(row, k).expect("a number"))).collect()
}

/// Root mean square of the residuals of a record, ms.
fn rms(home: &Path, fit: &str, record: &str) -> f64 {
    let rows = contacts(home, fit, record);
    1e3 * (rows.iter().map(|[_, r]| r * r).sum::<f64>() / rows.len() as f64).sqrt()
}

/// Duration of a flight upwards with speed v and back, and the speed at its end, by the closed
/// forms of m v' = -m g ∓ c v².
fn flight(v: f64, drag: f64) -> (f64, f64) {
    let terminal = (MASS * G / drag).sqrt();
    let (up, height) =
        (terminal / G * (v / terminal).atan(), terminal.powi(2) / (2.0 * G) * (v / terminal).powi(2).ln_1p());
    let depth = G * height / terminal.powi(2);
    let down = terminal / G * depth.exp().acosh();
    (up + down, terminal * (-(-2.0 * depth).exp_m1()).sqrt())
}

#[test]
fn closed_form_of_the_fitted_bounces_and_what_the_page_says_of_them() {
    let (page, home) = performed();
    let names = |height: &str| [1, 2, 3, 4, 5].map(|k| format!("drop-{height}-{k}"));
    // The program's times are those of the closed form, with the fitted numbers.
    let drag = fitted(&home, "with-air", "drop-30cm-1", "damper.air.quadratic");
    let restitution = fitted(&home, "with-air", "drop-30cm-1", "stop.table.restitution");
    for name in names("30cm") {
        let mut speed = -fitted(&home, "with-air", &name, "body.ball.start.v");
        let mut time = 0.0;
        for [found, _] in contacts(&home, "with-air", &name) {
            let (duration, arriving) = flight(speed, drag);
            time += duration;
            speed = restitution * arriving;
            assert!((found - time).abs() < ROUNDING, "{name}: {found} {time}");
        }
    }
    // Numbers, residuals and verdicts as on the page.
    let without = fitted(&home, "without-air", "drop-30cm-1", "stop.table.restitution");
    for shown in [
        format!("The restitution is {without:.4}"),
        format!("{restitution:.3} ± 0.002"),
        format!("({:.2} ± 0.35)·10⁻⁴", 1e4 * drag),
    ] {
        assert!(page.contains(&shown), "the page lacks {shown:?}");
    }
    let listed = |fit: &str, height: &str| names(height).map(|name| format!("{:.1}", rms(&home, fit, &name)));
    let (one, two) = (listed("without-air", "30cm"), listed("with-air", "30cm"));
    assert!(page.contains(&format!("| {} | {} |", one.join(", "), two.join(", "))), "{one:?} {two:?}");
    let third = listed("predicted", "15cm");
    assert!(page.contains(&format!("{} and {} ms", third[..4].join(", "), third[4])), "{third:?}");
    for (fit, record, verdict) in [
        ("without-air", "drop-30cm-1", "does not fit"),
        ("with-air", "drop-30cm-1", "fits"),
        ("predicted", "drop-15cm-1", "undecided"),
    ] {
        let json = fs::read_to_string(home.join(fit).join(record).join("fit.json")).expect("fit.json");
        assert!(json.contains(&format!("\"verdict\": \"{verdict}")), "{fit}: {json}");
    }
}

/// The machine of the page is the file of the example.
#[test]
fn golden_the_page_shows_the_machine() {
    let page = fs::read_to_string(root().join("docs/against-experiment.md")).expect("the page");
    let file = root().join("examples/experiment/table_tennis_ball.toml");
    let file = fs::read_to_string(file).expect("the machine");
    let lines = file.lines().filter(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n");
    assert!(page.contains(&format!("```toml\n{lines}\n```")), "{lines}");
}
