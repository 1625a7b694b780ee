//! Runs the real `vibro bifurcation|lyapunov|sweep FILE`: compared with the library, in shards;
//! and errors.

#[path = "common/mod.rs"]
mod command;

use command::{DAMPER, command, drawn, folder, refused, table};
use std::path::Path;
use vibro_studies::{Machine, Start, discard, measure};

const SWEEP: [&str; 13] = [
    "sweep",
    DAMPER,
    "--vary",
    "stop.steel.gap=4mm:5mm:2",
    "--vary",
    "stop.buffer.gap=6mm,-20mm",
    "--output",
    "amplitude.box.s,impacts.steel,power.buffer,class",
    "--discard",
    "60",
    "--periods=6",
    // No row is measured again.
    "--again",
    "0",
];

fn read(out: &Path, name: &str) -> Vec<u8> {
    std::fs::read(out.join(name)).expect("a file")
}

#[test]
fn second_method_a_sweep_has_the_librarys_numbers() {
    let out = folder("assembly-sweep");
    let said = drawn(&out, &SWEEP);
    assert!(said.contains("4 designs over stop.steel.gap, stop.buffer.gap"), "{said}");
    assert!(said.contains("amplitude.box.s: smallest"), "{said}");
    let rows = table(&out, "sweep.csv");
    assert_eq!(rows.len(), 4);
    let measures: Vec<_> = SWEEP[7].split(',').map(|name| name.parse().unwrap()).collect();
    let machine = Machine::new(vibro_machine::file::read(DAMPER.as_ref()).unwrap());
    for row in rows.iter().take(1) {
        let value = |name: &str| row[name].parse::<f64>().unwrap();
        let names = ["stop.steel.gap", "stop.buffer.gap"];
        let own = machine.with(names.map(|name| (name, value(name)))).unwrap();
        let (mut motion, section) = own.motion(&Start::default()).unwrap();
        discard(&mut motion, &section, 60).unwrap();
        let found = measure(&mut motion, &section, &measures, 6).unwrap();
        for (name, number) in ["amplitude.box.s", "impacts.steel", "power.buffer"].iter().zip(&found.numbers)
        {
            assert_eq!(value(name).to_bits(), number.unwrap().to_bits(), "{name}");
        }
        assert_eq!(row["class"], found.class.unwrap().name());
        // The gap is written in mm, so that it has a column in mm.
        assert_eq!(value("stop.steel.gap [mm]"), 4.0);
    }
    // If the start presses a buffer far in, no equilibrium exists; such a design has a row with
    // the reason.
    assert!(rows.iter().all(|row| row["reason"].is_empty() != row["amplitude.box.s"].is_empty()));
}

#[test]
fn screen_and_picture_tell_the_values_that_are_not_those_of_the_file() {
    let out = folder("assembly-set");
    let line = ["bifurcation", DAMPER, "--vary", "stop.steel.gap=60mm:61mm:2", "--of", "box.s"];
    let rest = ["--discard", "20", "--keep", "4", "--set", "body.block.mass=400g"];
    let said = drawn(&out, &[&line[..], &rest].concat());
    let words = "DamperWithBuffer with body.block.mass = 400 g";
    assert!(said.contains(words), "{said}");
    let picture = std::fs::read_to_string(out.join("bifurcation.svg")).unwrap();
    assert!(picture.contains(words));
}

#[test]
fn what_a_sweep_says_of_the_best_stands_in_its_table_and_its_picture() {
    let out = folder("assembly-best");
    let line = ["sweep", DAMPER, "--vary", "stop.steel.gap=60mm,90mm,92mm"];
    let over = ["--vary", "stop.buffer.gap=75mm,90mm", "--over", "load.shaker.frequency=9Hz:11Hz:2"];
    let rest =
        ["--output", "amplitude.box.s,power.buffer", "--discard", "20", "--periods", "6", "--again", "20000"];
    let said = drawn(&out, &[&line[..], &over, &rest].concat());
    assert!(said.contains("best by amplitude.box.s: "), "{said}");
    // No verdict is possible if no design can be measured again.
    let few = [&line[..], &over, &rest[..6], &["--again", "1"]].concat();
    let undecided = drawn(&folder("assembly-undecided"), &few);
    assert!(undecided.contains("best by amplitude.box.s: undecided between "), "{undecided}");
    assert!(said.contains("sampled once per common period of its harmonics, which varies"), "{said}");
    let rows = table(&out, "sweep.csv");
    let number =
        |row: &std::collections::HashMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
    let least = rows.iter().map(|row| number(row, "amplitude.box.s.max")).fold(f64::INFINITY, f64::min);
    let best = rows.iter().find(|row| number(row, "amplitude.box.s.max") == least).unwrap();
    assert!(number(best, "periods") >= 24.0 && number(best, "between") >= 1.0, "{best:?}");
    // Digits significant given the spread, in m on the screen and in mm in the picture.
    let spread = number(best, "amplitude.box.s.spread");
    let power = spread.log10().floor();
    let decimals = |power: f64| {
        ((if spread / 10f64.powf(spread.log10().floor()) < 2.0 { 1.0 } else { 0.0 }) - power).max(0.0)
            as usize
    };
    let (metres, millimetres) = (decimals(power), decimals(power + 3.0));
    assert!(said.contains(&format!("{least:.metres$} ± {spread:.metres$} m")), "{said}");
    let svg = String::from_utf8(read(&out, "sweep.svg")).unwrap();
    let (shown, bar) = (1e3 * least, 1e3 * spread);
    assert!(svg.contains(&format!("least, {shown:.millimetres$} ± {bar:.millimetres$} mm")), "{shown} {bar}");
}

#[test]
fn a_sweep_of_which_every_design_fails_says_so_by_its_exit() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("assembly-failed.toml");
    let text = "name = \"F\"\n[body.a]\nmass = 2.0\n[stop.s]\nbetween = [\"ground\", \"a\"]\ngap = 0.01\nrestitution = 0.5\n\
        [load.f]\non = \"a\"\namplitude = 10.0\nfrequency = \"5 Hz\"\n";
    std::fs::write(&path, text).unwrap();
    let path = path.display().to_string();
    for output in ["class", "amplitude.a.s"] {
        // The start at 0 is beyond the stop.
        let line = ["sweep", &path, "--vary", "stop.s.gap=-20mm,-30mm", "--output", output];
        let found = command(&folder(&format!("assembly-failed-{output}")), &line).output().unwrap();
        let error = String::from_utf8_lossy(&found.stderr).into_owned();
        assert_eq!(found.status.code(), Some(1), "{error}");
        assert!(error.contains("all 2 designs failed; first: stop.s.gap = "), "{error}");
    }
}

#[test]
fn invariant_a_diagram_in_shards_is_the_diagram() {
    let arguments = [
        "bifurcation",
        DAMPER,
        "--vary",
        "stop.steel.gap=4mm:5mm:3",
        "--of",
        "block.s",
        "--discard",
        "20",
        "--keep",
        "6",
    ];
    let (out, parts) = (folder("assembly-diagram"), folder("assembly-diagram-shards"));
    let said = drawn(&out, &arguments);
    assert!(said.contains("local maxima of block.s over stop.steel.gap, both directions"), "{said}");
    assert!(said.contains("stop.steel.gap 4 mm"), "{said}");
    let [one, two] = ["one", "two"].map(|name| parts.join(name));
    drawn(&one, &[&arguments[..], &["--shard", "1/2"]].concat());
    drawn(&two, &[&arguments[..], &["--shard", "2/2"]].concat());
    let merged = parts.join("merged");
    drawn(&merged, &["merge", &one.display().to_string(), &two.display().to_string()]);
    for name in ["", "-points", "-windows"] {
        let file = format!("bifurcation{name}.csv");
        assert_eq!(read(&merged, &file), read(&out, &file), "{file}");
    }
    assert_eq!(read(&merged, "bifurcation.svg"), read(&out, "bifurcation.svg"));
    // Another machine's results are refused, with the difference.
    let other = [&arguments[..], &["--set", "body.box.mass=13kg"]].concat();
    let found = command(&out, &other).output().unwrap();
    let error = String::from_utf8_lossy(&found.stderr).into_owned();
    assert!(found.status.code() == Some(2) && error.contains("body.box.mass: 12 there, 13 here"), "{error}");
}

#[test]
fn closed_form_exponent_of_an_oscillator() {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("assembly-exponent.toml");
    let text = "name = \"O\"\n[body.a]\nmass = 2.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\ndamping = 8.0\n\
        [load.f]\non = \"a\"\namplitude = 10.0\nfrequency = \"5 Hz\"\n";
    std::fs::write(&path, text).unwrap();
    let out = folder("assembly-exponent");
    drawn(&out, &["lyapunov", &path.display().to_string(), "--periods", "160"]);
    let row = &table(&out, "lyapunov.csv")[0];
    // δ'' + 4 δ' + 400 δ = 0 decays with e^-2t; its length oscillates by some percent of one
    // e-fold in 25 s.
    let exponent: f64 = row["exponent"].parse().unwrap();
    assert!((exponent + 2.0).abs() < 4e-3 && row["class"] == "1T", "{row:?}");
}

#[test]
fn bad_ranges_names_and_sections_are_refused_before_work() {
    let sweep = |rest: &[&str]| refused(&[&["sweep", DAMPER][..], rest].concat());
    let diagram = |rest: &[&str]| refused(&[&["bifurcation", DAMPER][..], rest].concat());
    let plane = |rest: &[&str]| {
        let ranges = ["--vary", "stop.steel.gap=4mm:6mm", "--vary", "stop.buffer.gap=5mm:8mm"];
        diagram(&[&ranges[..], rest].concat())
    };
    for ((code, error), words) in [
        (diagram(&["--vary", "stop.stel.gap=1mm:2mm"]), "did you mean `stop.steel.gap`"),
        (
            diagram(&["--vary", "stop.steel.gap=2mm:1mm"]),
            "`stop.steel.gap=2mm:1mm`: expected NAME=FROM:TO with FROM < TO",
        ),
        (diagram(&["--vary", "stop.steel.gap=1:2mm"]), "a unit on every number"),
        (
            diagram(&["--vary", "stop.steel.gap=1mm:2mm:1"]),
            "`stop.steel.gap=1mm:2mm:1`: expected a count of 2 or more",
        ),
        (diagram(&["--vary", "stop.steel.gap=1mm:2mm", "--of", "blok.s"]), "did you mean `block.s`?"),
        (
            diagram(&["--vary", "stop.steel.gap=1mm:2mm", "--section", "stop.x"]),
            "no stop, contact or friction has this name",
        ),
        (diagram(&["--vary", "stop.steel.restitution=0.5:1.5"]), "expected a number from 0 to 1"),
        (
            diagram(&["--vary", "stop.steel.gap=1mm:2mm", "--vary", "stop.buffer.gap=1mm:2mm"]),
            "--pair NAME,NAME",
        ),
        (plane(&["--pair", "stop.steel.gap"]), "two names separated by a comma"),
        (
            plane(&["--pair", "stop.steel.gap,body.block.mass"]),
            "body.block.mass has no range; add --vary body.block.mass=FROM:TO",
        ),
        (plane(&["--pair", "stop.steel.gap,stop.steel.gap"]), "two independent parameters"),
        (plane(&["--pair", "stop.steel.gap,stop.buffer.gap", "--resolution", "20000"]), "expected 2 to 3000"),
        (plane(&["--pair", "stop.steel.gap,stop.buffer.gap", "--resolution", "2900"]), "points of the plane"),
        (plane(&["--pair", "stop.steel.gap,stop.buffer.gap", "--section", "stop.x"]), "has this name"),
        (plane(&["--pair", "stop.steel.gap,stop.buffer.gap", "--of", "box.s"]), "cannot be used with"),
        (sweep(&["--vary", "stop.steel.gap=1mm:2mm:3", "--samples", "4"]), "without a count"),
        (sweep(&["--output", "amplitude.bx.s"]), "did you mean `box.s`?"),
        (sweep(&["--output", "loudness"]), "amplitude.Q"),
        (sweep(&["--vary", "stop.steel.gap=1mm,2mm", "--vary", "stop.steel.gap=1mm,2mm"]), "is varied twice"),
    ] {
        assert!(code == 2 && error.contains(words), "{words}: {error}");
    }
    let said = drawn(&folder("assembly-list"), &["sweep", DAMPER, "--list"]);
    assert!(said.contains("impact.speed.steel") && said.contains("power.guide"), "{said}");
}

const PLANE: [&str; 12] = [
    "bifurcation",
    DAMPER,
    "--vary",
    "stop.steel.gap=4mm:6mm:8",
    "--vary",
    "stop.buffer.gap=5mm:8mm",
    "--resolution",
    "7",
    "--pair",
    "stop.steel.gap,stop.buffer.gap",
    "--discard",
    "100",
];
const PLANE_NAME: &str = "bifurcation-stop.steel.gap-stop.buffer.gap";

#[test]
fn second_method_points_of_a_plane_are_single_motions_and_its_picture_shows_them() {
    let out = folder("assembly-plane");
    let said = drawn(&out, &PLANE);
    assert!(said.contains("simulated motion over (stop.steel.gap, stop.buffer.gap)"), "{said}");
    let rows = table(&out, &format!("{PLANE_NAME}.csv"));
    assert_eq!(rows.len(), 56);
    let machine = Machine::new(vibro_machine::file::read(DAMPER.as_ref()).unwrap());
    let measures = ["impacts".parse().unwrap(), "class".parse().unwrap()];
    let mut compared = 0;
    for (index, row) in rows.iter().enumerate() {
        let value = |name: &str| row[name].parse::<f64>().unwrap();
        let [x, y] = ["stop.steel.gap", "stop.buffer.gap"].map(value);
        let (i, j) = (index % 8, index / 8);
        let part = |from: f64, to: f64, part: f64| from * (1.0 - part) + to * part;
        assert_eq!((x, y), (part(4e-3, 6e-3, i as f64 / 7.0), part(5e-3, 8e-3, j as f64 / 6.0)), "{index}");
        // A mean over 12 periods is exact for motions with a period of 1, 2, 3, 4, 6 or 12.
        let has_measured_period = ["1T", "2T", "3T", "4T", "6T", "12T"].contains(&row["class"].as_str());
        if index % 5 == 0 && has_measured_period {
            let own = machine.with([("stop.steel.gap", x), ("stop.buffer.gap", y)]).unwrap();
            let (mut motion, section) = own.motion(&Start::default()).unwrap();
            discard(&mut motion, &section, 140).unwrap();
            let found = measure(&mut motion, &section, &measures, 12).unwrap();
            assert_eq!(found.class.unwrap().name(), row["class"], "{row:?}");
            assert_eq!(found.numbers[0].unwrap(), value("contacts"), "{row:?}");
            compared += 1;
        }
    }
    assert!(compared > 3, "{compared}");
    let svg = String::from_utf8(read(&out, &format!("{PLANE_NAME}.svg"))).unwrap();
    for words in
        ["(a) Class of the motion", "(b) Impacts and first touches a period", "gap of steel stop, mm"]
    {
        assert!(svg.contains(words), "{words}");
    }
    // The file's own gaps, 4 and 6 mm, lie in the plane.
    assert!(svg.contains("the machine as it is"));
}

#[test]
fn second_method_exponents_over_a_plane_are_those_of_a_diagram() {
    let machine = "name = \"O\"\n[body.a]\nmass = 2.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\ndamping = 8.0\n\
        [load.f]\non = \"a\"\namplitude = 10.0\nfrequency = \"5 Hz\"\n";
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("assembly-plane-exponents.toml");
    std::fs::write(&path, machine).unwrap();
    let out = folder("assembly-plane-exponents");
    let file = path.display().to_string();
    drawn(
        &out,
        &[
            "lyapunov",
            &file,
            "--periods",
            "160",
            "--vary",
            "spring.k.damping=4:16:3",
            "--vary",
            "load.f.amplitude=5:20:2",
            "--pair",
            "load.f.amplitude,spring.k.damping",
        ],
    );
    let rows = table(&out, "lyapunov-load.f.amplitude-spring.k.damping.csv");
    assert_eq!(rows.len(), 6);
    for row in rows {
        // A variation decays with e^(-c t / 2m), whatever the load.
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        assert!((number("exponent") + number("spring.k.damping") / 4.0).abs() < 2e-2, "{row:?}");
    }
}

/// The study varies the frequency, so it has no single period.
#[test]
fn a_study_of_a_frequency_names_no_period_as_its_own() {
    let vary = ["--vary", "load.shaker.frequency=9:10:2", "--discard", "2", "--keep", "2"];
    let out = folder("assembly-frequency");
    let run = command(&out, &[&["bifurcation", DAMPER][..], &vary].concat()).output().unwrap();
    let told = String::from_utf8(run.stdout).unwrap();
    assert!(run.status.success() && !told.contains("periods of 0.1 s"), "{told}");
    assert!(told.contains("once per common period of its harmonics, which varies"), "{told}");
}
