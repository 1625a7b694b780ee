//! Runs the real `vibro`: one grammar of units, starts and loads for all commands, and the help on
//! limits of the model.

#[path = "common/mod.rs"]
mod command;

use command::{command, drawn, folder, refused, table};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};

/// A damper by its data sheet, its frequency in Hz and its gap in mm.
const MACHINE: &str = r#"[si]
box.m = "12 kg"
box.k = "48 kN/m"
box.c = "30 N.s/m"
block.m = "0.6 kg"
secondary.m = "1.2 kg"
secondary.k = "4.8 kN/m"
secondary.c = "5 N.s/m"
coupling.k = 0
stop.gap = "50 mm"
stop.restitution = 0.6
drive.amplitude = "75 N"
drive.frequency = "10 Hz"
"#;

/// Quick work: few periods.
const QUICK: [&str; 4] = ["--discard", "10", "--periods", "4"];

fn machine(name: &str) -> (PathBuf, String) {
    let out = folder(name);
    std::fs::create_dir_all(&out).unwrap();
    let file = out.join("machine.toml");
    std::fs::write(&file, MACHINE).unwrap();
    (out, file.to_str().unwrap().into())
}

/// Standard output and standard error of a run that must succeed.
fn told(out: &Path, arguments: &[&str]) -> (String, String) {
    let output = command(out, arguments).output().expect("vibro runs");
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).expect("text");
    assert!(output.status.success(), "{arguments:?}: {}", text(&output.stderr));
    (text(&output.stdout), text(&output.stderr))
}

fn numbers(out: &Path, file: &str, column: &str) -> Vec<f64> {
    table(out, file).iter().map(|row| row[column].parse().expect("a number")).collect()
}

#[test]
fn a_number_without_a_unit_is_in_the_unit_of_the_file_on_every_axis() {
    let (out, file) = machine("grammar-units");
    let with = |name: &str, arguments: &[&str]| {
        let folder = out.join(name);
        let found = told(&folder, &[arguments, &["--config", &file]].concat());
        (folder, found)
    };
    const NOTE: &str = "is read in Hz, the unit in which that parameter was written";
    let hertz = [9.0, 9.5, 10.0, 10.5, 11.0];
    // Sweeps: by a range, by a list, and over a band.
    for (name, axis) in [("range", "drive.frequency=9:11:5"), ("list", "drive.frequency=9,9.5,10,10.5,11")] {
        let (folder, (screen, notes)) =
            with(name, &[&["sweep", "--vary", axis, "--output", "amplitude.x1"], &QUICK[..]].concat());
        assert!(
            notes.contains(&format!("--vary {}", axis.split(':').next().unwrap())) && notes.contains(NOTE),
            "{notes}"
        );
        assert!(screen.contains("Hz") && !screen.contains("rad/s"), "{screen}");
        let si = numbers(&folder, "sweep.csv", "drive.frequency");
        assert!(si.iter().zip(hertz).all(|(si, hz)| (si - TAU * hz).abs() < 1e-12 * si), "{si:?}");
        assert_eq!(numbers(&folder, "sweep.csv", "drive.frequency [Hz]"), hertz);
    }
    let with_unit = with(
        "unit",
        &[&["sweep", "--vary", "drive.frequency=9Hz:11Hz:5", "--output", "amplitude.x1"], &QUICK[..]]
            .concat(),
    );
    assert_eq!(with_unit.1.1, "");
    let same = |file: &str| {
        std::fs::read(out.join("range").join(file)).unwrap() == std::fs::read(with_unit.0.join(file)).unwrap()
    };
    assert!(same("sweep.csv") && same("sweep.parquet"));
    let over =
        ["sweep", "--vary", "stop.gap=40,60", "--over", "drive.frequency=9:11:3", "--output", "amplitude.x1"];
    let (folder, (_, notes)) = with("over", &[&over, &QUICK[..], &["--again", "0"]].concat());
    assert!(notes.contains("in mm") && notes.contains("in Hz"), "{notes}");
    assert_eq!(numbers(&folder, "sweep.csv", "stop.gap"), [0.04, 0.06]);
    assert!(
        numbers(&folder, "sweep.csv", "amplitude.x1.max.drive.frequency [Hz]")
            .iter()
            .all(|f| hertz.contains(f))
    );
    // A design file, a range, a pair, the values of a list.
    std::fs::write(out.join("rows.csv"), "drive.frequency,stop.gap\n9.5,4 cm\n").unwrap();
    let rows = out.join("rows.csv");
    let (folder, _) = with(
        "design",
        &[&["sweep", "--design", rows.to_str().unwrap(), "--output", "impacts"], &QUICK[..]].concat(),
    );
    assert_eq!(numbers(&folder, "sweep.csv", "drive.frequency [Hz]"), [9.5]);
    assert_eq!(numbers(&folder, "sweep.csv", "stop.gap [mm]"), [40.0]);
    let few = ["--discard", "5", "--keep", "4"];
    let (folder, (_, notes)) =
        with("diagram", &[&["bifurcation", "--range", "drive.frequency=9:11:3"], &few[..]].concat());
    assert!(notes.contains(NOTE), "{notes}");
    let first = numbers(&folder, "bifurcation-points.csv", "drive.frequency [Hz]");
    assert_eq!(first[..3], [9.0, 10.0, 11.0]);
    let plane = [
        "isoperiodic",
        "--pair",
        "drive.frequency,stop.gap",
        "--range",
        "drive.frequency=9:11",
        "--range",
        "stop.gap=40:60",
    ];
    let (folder, _) =
        with("plane", &[&plane[..], &["--resolution", "2", "--discard", "5", "--periods", "0"]].concat());
    let name = "isoperiodic-drive.frequency-stop.gap.csv";
    assert_eq!(numbers(&folder, name, "stop.gap [mm]"), [40.0, 40.0, 60.0, 60.0]);
    // `--set` after the file and after another `--set`.
    let set = ["sweep", "--set", "drive.frequency=10.65", "--vary", "block.m=0.6", "--output", "impacts"];
    let (_, (screen, notes)) = with("set", &[&set[..], &QUICK[..]].concat());
    assert!(
        notes.contains("drive.frequency=10.65 is read in Hz") && screen.contains("10.65 Hz"),
        "{notes}{screen}"
    );
}

#[test]
fn a_value_is_checked_in_the_unit_in_which_it_is_read() {
    let (out, file) = machine("grammar-range");
    let arguments =
        ["sweep", "--config", &file, "--set", "stop.restitution=60%", "--vary", "stop.restitution=50:150:3"];
    let output = command(&out.join("refused"), &arguments).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(!output.status.success() && error.contains("stop.restitution = 1.5: expected"), "{error}");
    let fine = [
        "sweep",
        "--config",
        &file,
        "--set",
        "stop.restitution=60%",
        "--vary",
        "stop.restitution=50:70:3",
        "--output",
        "impacts",
    ];
    told(&out.join("fine"), &[&fine[..], &QUICK[..]].concat());
    assert_eq!(numbers(&out.join("fine"), "sweep.csv", "stop.restitution"), [0.5, 0.6, 0.7]);
}

#[test]
fn starts_have_one_grammar_in_every_command() {
    let (out, file) = machine("grammar-starts");
    let with = |name: &str, arguments: &[&str]| {
        let folder = out.join(name);
        told(&folder, &[arguments, &["--config", &file]].concat());
        folder
    };
    // 20 mm are 0.4 L.
    let sweep =
        |start| [&["sweep", "--output", "amplitude.x2,impacts", "--start", start], &QUICK[..]].concat();
    let bytes = |folder: &Path, name: &str| std::fs::read(folder.join(name)).unwrap();
    let (si, scaled) = (with("sweep-si", &sweep("block.s=20mm")), with("sweep-l", &sweep("x2=0.4")));
    assert_eq!(bytes(&si, "sweep.csv"), bytes(&scaled, "sweep.csv"));
    let diagram = |start| {
        ["bifurcation", "--vary", "stop.gap=40mm:60mm:2", "--discard", "5", "--keep", "4", "--start", start]
    };
    let (si, rest) = (with("diagram-si", &diagram("block.s=0.02")), with("diagram-rest", &diagram("x1=0")));
    assert_ne!(bytes(&si, "bifurcation.csv"), bytes(&rest, "bifurcation.csv"));
    let basin = |x, start| {
        ["basin", "--x", x, "--y", "v2=-1:1", "--start", start, "--resolution", "3", "--discard", "5"]
    };
    let si = with("basin-si", &basin("block.s=-25mm:25mm", "box.s=25mm"));
    let scaled = with("basin-l", &basin("x2=-0.5:0.5", "x1=0.5"));
    assert_eq!(bytes(&si, "basin.csv"), bytes(&scaled, "basin.csv"));
    let plane = |start| {
        let line =
            ["isoperiodic", "--pair", "block.m,stop.gap", "--range", "stop.gap=40mm:60mm", "--start", start];
        [&line[..], &["--resolution", "2", "--discard", "5", "--periods", "0"]].concat()
    };
    let (si, scaled) = (with("plane-si", &plane("block.v=0.2")), with("plane-l", &plane("block.v=20cm/s")));
    let name = "isoperiodic-block.m-stop.gap.csv";
    assert_eq!(bytes(&si, name), bytes(&scaled, name));
    // Giving a coordinate twice is refused with both names, by every command.
    for command in ["run", "sweep", "basin", "bifurcation", "isoperiodic"] {
        let (code, error) = refused(&[command, "--start", "x2=.1,block.s=.3"]);
        assert!(code == 2 && error.contains("x2 and block.s"), "{command}: {error}");
    }
}

#[test]
fn loads_have_one_grammar_in_every_command() {
    let (out, file) = machine("grammar-loads");
    let with = |name: &str, arguments: &[&str]| {
        let folder = out.join(name);
        told(&folder, &[arguments, &["--config", &file]].concat());
        folder
    };
    let bytes = |folder: &Path, name: &str| std::fs::read(folder.join(name)).unwrap();
    let outputs = ["--output", "amplitude.x2,impacts.upper,impacts.lower"];
    let sweep = |more: &[&'static str]| [&["sweep"], more, &outputs, &QUICK[..]].concat();
    let load = with("load", &sweep(&["--load", "block=-5.886N"]));
    let parameter = with("parameter", &sweep(&["--set", "load.block=-5886mN"]));
    let none = with("none", &sweep(&[]));
    assert_eq!(bytes(&load, "sweep.csv"), bytes(&parameter, "sweep.csv"));
    assert_ne!(bytes(&load, "sweep.csv"), bytes(&none, "sweep.csv"));
    // Loads on a body add up, and a load can be an axis.
    // Rows of the first measurement.
    let once = ["--again", "0"];
    let vary = ["--vary", "load.block=-6N:0N:3", "--load", "box=1N", "--load", "box=-1N"];
    let axis = with("axis", &[&sweep(&vary)[..], &once].concat());
    assert_eq!(numbers(&axis, "sweep.csv", "load.block"), [-6.0, -3.0, 0.0]);
    let last = |folder: &Path| table(folder, "sweep.csv").last().unwrap()["amplitude.x2"].clone();
    assert_eq!(last(&axis), last(&none));
    // Every command that simulates accepts loads.
    let few = ["--discard", "5", "--keep", "4"];
    let diagram = with("diagram", &[&["bifurcation", "--vary", "load.block=-6N:6N:3"], &few[..]].concat());
    assert_eq!(numbers(&diagram, "bifurcation-points.csv", "load.block")[..3], [-6.0, 0.0, 6.0]);
    with(
        "spectrum",
        &[&["lyapunov", "--vary", "stop.gap=40:60:2", "--periods", "9", "--load", "block=-5.9N"], &few[..]]
            .concat(),
    );
    with("basin", &["basin", "--resolution", "3", "--discard", "5", "--load", "block=-5.9N"]);
    let pair = [
        "isoperiodic",
        "--pair",
        "load.block,stop.gap",
        "--range",
        "load.block=-6:0",
        "--range",
        "stop.gap=40:60",
    ];
    let plane =
        with("plane", &[&pair[..], &["--resolution", "2", "--discard", "5", "--periods", "0"]].concat());
    let rows = table(&plane, "isoperiodic-load.block-stop.gap.csv");
    assert!(rows.iter().all(|row| row["exact_orbit"] == "undefined" || row["load.block"] == "0"), "{rows:?}");
    let run = with("run", &["run", "--load", "block=-5.9N", "--periods", "2", "--discard", "0"]);
    assert!(!table(&run, "run.csv").is_empty());
    // Only `run` accepts a file; theories do not support loads.
    for command in ["sweep", "bifurcation", "lyapunov", "basin", "isoperiodic", "orbits", "orbit"] {
        let (code, error) = refused(&[command, "--load", "box=record.csv"]);
        assert!(
            code == 2 && error.contains("--load box=record.csv") && error.contains("`vibro paper run`"),
            "{command}: {error}"
        );
    }
    for command in ["steady", "response", "manifold", "stability", "plane", "compare", "reproduce"] {
        let (code, error) = refused(&[command, "--set", "load.block=-5N"]);
        assert!(code == 2 && error.contains("load.block = -5: expected 0"), "{command}: {error}");
    }
    let (code, error) = refused(&["plane", "--pair", "load.block,f10"]);
    assert!(code == 2 && error.contains("load.block"), "{error}");
    let (code, error) =
        refused(&["isoperiodic", "--pair", "f10,kappa", "--start", "orbit", "--load", "block=0.01N"]);
    assert!(code == 2 && error.contains("load.block = 0.01: expected 0"), "{error}");
}

#[test]
fn help_says_what_the_model_has_not() {
    for command in ["", "run", "sweep", "bifurcation", "basin", "isoperiodic", "orbits", "steady", "template"]
    {
        let words = ["paper", command, "--help"];
        let arguments: Vec<&str> = words.into_iter().filter(|word| !word.is_empty()).collect();
        let text = drawn(&folder("grammar-help"), &arguments);
        for limit in ["Three bodies", "rigid", "one coefficient of restitution", "No friction"] {
            assert!(text.contains(limit), "vibro paper {command} --help lacks `{limit}`");
        }
    }
}

#[test]
fn defaults_of_the_python_package_are_those_of_the_command_line() {
    let default_of = |command: &str, option: &str| -> String {
        let help = drawn(&folder("grammar-defaults"), &["paper", command, "--help"]);
        let own =
            help.split(&format!("--{option} <")).nth(1).unwrap_or_else(|| panic!("{command} --{option}"));
        own.split("[default: ").nth(1).unwrap().split([']', ';']).next().unwrap().into()
    };
    let package = concat!(env!("CARGO_MANIFEST_DIR"), "/../../python/package/vibro_impact");
    let signature = |file: &str, function: &str| -> String {
        let text = std::fs::read_to_string(format!("{package}/{file}")).unwrap();
        let from = text.split(&format!("def {function}(")).nth(1).unwrap_or_else(|| panic!("{function}"));
        from.split("\"\"\"").next().unwrap().split_whitespace().collect::<Vec<_>>().join(" ")
    };
    let is_default = |file: &str, function: &str, words: String| {
        let found = signature(file, function);
        assert!(found.contains(&words), "{function}: {words} in {found}");
    };
    for (file, function) in [("_paper_machine.py", "measure"), ("_many.py", "measure_many")] {
        is_default(file, function, format!("periods: int = {}", default_of("sweep", "periods")));
        is_default(file, function, format!("settle: int = {}", default_of("sweep", "discard")));
    }
    let (discard, keep) = (default_of("bifurcation", "discard"), default_of("bifurcation", "keep"));
    is_default("_paper_machine.py", "bifurcation", format!("periods: tuple[int, int] = ({discard}, {keep})"));
    is_default("_paper_machine.py", "basins", format!("settle: int = {}", default_of("basin", "discard")));
    is_default(
        "_paper_machine.py",
        "spectrum",
        format!("periods: int = {}", default_of("lyapunov", "periods")),
    );
    is_default(
        "_paper_machine.py",
        "spectrum",
        format!("settle: int = {}", default_of("lyapunov", "discard")),
    );
}
