//! `vibro orbit FILE` and `vibro orbits FILE`: the page docs/machine-studies.md compared with
//! closed forms and tables; errors.

#[path = "common/mod.rs"]
mod command;
#[path = "common/guide.rs"]
mod guide;

use command::folder;
use guide::Guide;
use std::f64::consts::{PI, TAU};
use std::path::Path;
use std::process::{Command, Output};

/// Rounding of an orbit's numbers, relative.
const ROUNDING: f64 = 1e-11;
/// Rounding of a fold's parameter along a curve; the equations are singular at a fold.
const LOCATED: f64 = 1e-9;
/// Share of a picture's points that may differ because of the last digits of the starts.
const POINTS: f64 = 0.1;

fn vibro(line: &str) -> Output {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let words = line.split_whitespace();
    Command::new(env!("CARGO_BIN_EXE_vibro")).args(words).current_dir(root).output().expect("vibro runs")
}

/// A table's header and rows.
fn table(path: &Path) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::Reader::from_path(path).expect("a table");
    let header = reader.headers().unwrap().iter().map(str::to_owned).collect();
    let rows = reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect());
    (header, rows.collect())
}

/// The words of a drawing.
fn texts(svg: &str) -> Vec<&str> {
    svg.split("<text").skip(1).filter_map(|t| t.split_once('>')?.1.split('<').next()).collect()
}

#[test]
fn closed_form_of_the_page_and_its_picture() {
    let guide = Guide::read("machine-studies.md");
    let said = guide.perform("machine-studies", &[]);
    assert!(
        said[0].contains("events: impact right, impact left") && said[0].contains("stable"),
        "{}",
        said[0]
    );
    let home = Path::new(env!("CARGO_TARGET_TMPDIR")).join("machine-studies");

    // Two impacts a period at the speed of flight V.
    let (a, d, omega, r): (f64, f64, f64, f64) = (1e-3, 3e-3, TAU * 25.0, 0.4 / 1.6);
    // (π V - d)²/4 + (r V)² = A²; the larger root is stable.
    let (square, linear, rest) = (PI * PI / 4.0 + r * r, -PI * d / 2.0, d * d / 4.0 - a * a);
    let flight = omega * (-linear + (linear * linear - 4.0 * square * rest).sqrt()) / (2.0 * square);
    // The joint moves at -r V at the impact.
    let closing = flight * (1.0 + r);
    let (_, events) = table(&home.join("one/orbit-events.csv"));
    assert_eq!(events.len(), 2);
    for event in &events {
        assert!((event[3].parse::<f64>().unwrap() / closing - 1.0).abs() < ROUNDING, "{event:?} {closing}");
    }
    let fold = d * r / (4.0 * r * r + PI * PI).sqrt();
    let (header, special) = table(&home.join("all/special-points.csv"));
    assert_eq!(header[..5], ["label", "branch", "point", "parameter", "value"]);
    let folds = special.iter().filter(|row| row[0] == "LP").map(|row| row[4].parse::<f64>().unwrap());
    assert!(folds.map(|x| (x / fold - 1.0).abs()).fold(f64::INFINITY, f64::min) < ROUNDING, "{fold}");

    // The fold's amplitude does not depend on the frequency.
    let (header, curve) = table(&home.join("curves/locus.csv"));
    assert_eq!(header[4..6], ["body.joint.motion.amplitude", "body.joint.motion.frequency"]);
    let curve: Vec<Vec<String>> = curve.into_iter().filter(|row| row[0] == "0").collect();
    let number = |row: &Vec<String>, column: usize| row[column].parse::<f64>().unwrap();
    assert!(curve.iter().all(|row| (number(row, 4) / fold - 1.0).abs() < LOCATED), "{fold}");
    let ends: Vec<f64> = curve.iter().filter(|row| row[8] == "EP").map(|row| number(row, 5)).collect();
    assert!(ends.len() == 2 && (ends[0] - ends[1]).abs() == 25.0, "{ends:?}");

    let drawn = std::fs::read_to_string(home.join("all/orbits.svg")).unwrap();
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/machine-studies/rattle.svg");
    if std::env::var("VIBRO_IMPACT_UPDATE").is_ok_and(|v| v == "1") {
        std::fs::write(&kept, &drawn).unwrap();
    }
    let kept = std::fs::read_to_string(kept).unwrap();
    assert_eq!(texts(&drawn), texts(&kept), "the picture is stale; VIBRO_IMPACT_UPDATE=1 writes it anew");
    // Where the last digit of a start decides, a branch may have one point more or less.
    let share = drawn.len() as f64 / kept.len() as f64;
    assert!((share - 1.0).abs() < POINTS, "{share}");
}

#[test]
fn invariant_a_motion_stays_on_the_orbit_whose_start_was_written() {
    let out = folder("orbit-start");
    let (orbit, run) = (out.join("orbit"), out.join("run"));
    let file = "examples/assembly/damper_with_buffer.toml";
    assert!(vibro(&format!("orbit {file} --out {}", orbit.display())).status.success());
    let start = orbit.join("start.toml");
    let line = format!(
        "run {file} --start {} --until 0.3657196912223158s --samples 3 --out {}",
        start.display(),
        run.display()
    );
    let output = vibro(&line);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let (header, rows) = table(&run.join("states.csv"));
    let column = header.iter().position(|name| name == "box.s").unwrap();
    let value = |row: &Vec<String>| row[column].parse::<f64>().unwrap();
    assert!((value(&rows[0]) - value(&rows[3])).abs() < 1e-12, "{rows:?}");
    // The energy that the load supplies is the energy that the other elements take.
    let (_, energies) = table(&orbit.join("orbit-energies.csv"));
    let sum: f64 = energies
        .iter()
        .map(|row| if row[0].starts_with("load") { -1.0 } else { 1.0 } * row[1].parse::<f64>().unwrap())
        .sum();
    assert!(energies.len() == 7 && sum.abs() < 1e-12, "{energies:?}");
}

#[test]
fn what_has_no_orbit_is_refused_by_name() {
    for (line, words) in [
        ("orbit examples/assembly/relay_bounce.toml", "load.magnet has a step at 0.001 s"),
        ("orbit examples/assembly/two_blocks.toml", "it is chaotic at periods of 0.1 s"),
        ("orbits examples/assembly/impact_pair.toml", "expected one parameter"),
        (
            "orbits examples/assembly/impact_pair.toml --vary body.base.amplitude=1:2",
            "did you mean `body.base.motion.amplitude`",
        ),
        (
            "orbits examples/assembly/impact_pair.toml --vary body.base.motion.amplitude=2:3",
            "must lie in the range 2 m to 3 m",
        ),
        (
            "orbits examples/assembly/impact_pair.toml --vary body.base.motion.amplitude=0.5:2 --of power.lost",
            "--of: power.lost: is not a measure of an orbit",
        ),
        (
            "orbits examples/assembly/impact_pair.toml --vary body.base.motion.amplitude=0.5:2 --word U",
            "--word: is not an option of `vibro orbits` for a machine file, but of `vibro orbit`",
        ),
        (
            "response examples/assembly/impact_pair.toml --vary body.base.motion.amplitude=0.5:2 --section up",
            "no stop, contact or friction has this name",
        ),
        ("orbit --section right", "FILE: use `vibro orbit FILE --section …`"),
        (
            "locus examples/assembly/impact_pair.toml --from none.csv --vary body.base.motion.amplitude=0.5:2",
            "expected two parameters",
        ),
        (
            "locus examples/assembly/impact_pair.toml --from none.csv --vary body.base.motion.amplitude=0.5:2 \
             --vary body.base.motion.amplitude=0.5:2",
            "expected two different parameters",
        ),
        (
            "locus examples/assembly/impact_pair.toml --from none.csv --vary body.base.motion.amplitude=0.5:2 \
             --vary stop.right.restitution=0.1:0.2",
            "must lie in the range 0.1 to 0.2",
        ),
        (
            "locus examples/assembly/impact_pair.toml --from none.csv --vary body.base.motion.amplitude=0.5:2 \
             --vary stop.right.restitution=0.1:0.9",
            "none.csv",
        ),
    ] {
        let output = vibro(&format!("{line} --out {}", folder("orbit-refused").display()));
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && error.contains(words), "{line}: {error}");
    }
}
