//! `vibro reduce`: with the feature `reduce` the written files, without it the way to get it.

use std::path::Path;
use std::process::{Command, Output};

fn vibro(folder: &Path, line: &str) -> Output {
    let mut vibro = Command::new(env!("CARGO_BIN_EXE_vibro"));
    vibro.args(line.split_whitespace()).current_dir(folder).output().expect("vibro runs")
}

fn said(output: &Output) -> String {
    [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes).into_owned()).concat()
}

/// Three masses of 1 kg in a row between springs of 1 kN/m, in N, mm, t.
#[cfg(feature = "reduce")]
fn chain(folder: &Path) {
    for (name, text) in [
        ("chain.sti", "1 1 2.0\n1 2 -1.0\n2 2 2.0\n2 3 -1.0\n3 3 1.0\n"),
        ("chain.mas", "1 1 1e-3\n2 2 1e-3\n3 3 1e-3\n"),
        ("chain.dof", "1.1\n2.1\n3.1\n"),
    ] {
        std::fs::write(folder.join(name), text).unwrap();
    }
}

#[cfg(feature = "reduce")]
const FILES: &str = "reduce chain.sti chain.mas chain.dof --units N,mm,t,s";

#[test]
#[cfg(not(feature = "reduce"))]
fn golden_without_the_feature_the_command_says_how_to_get_it() {
    let output = vibro(Path::new("."), "reduce a.sti a.mas --units SI --modes 2");
    assert_eq!(output.status.code(), Some(2));
    assert!(said(&output).contains("--features reduce"), "{}", said(&output));
}

#[test]
fn golden_units_and_modes_are_required() {
    let output = vibro(Path::new("."), "reduce a.sti a.mas --modes 2");
    assert!(said(&output).contains("--units"), "{}", said(&output));
    let output = vibro(Path::new("."), "reduce a.sti a.mas --units SI");
    assert!(said(&output).contains("--modes"), "{}", said(&output));
}

#[test]
#[cfg(feature = "reduce")]
fn closed_form_a_chain_is_reduced_checked_and_run() {
    let folder = tempfile::tempdir().unwrap();
    chain(folder.path());
    let output = vibro(folder.path(), &format!("{FILES} --interface end=3 --modes 3 --damping-ratio 0.01"));
    assert!(output.status.success(), "{}", said(&output));
    let text = said(&output);
    // 2 sin(pi/14) sqrt(k/m)/(2 pi)
    for expected in [
        "mass that moves: 3.00000 kg along x",
        "first frequency: 2.23986 Hz",
        "wrote chain.toml, chain.npz, chain.txt",
    ] {
        assert!(text.contains(expected), "{expected}\n{text}");
    }
    let machine = std::fs::read_to_string(folder.path().join("chain.toml")).unwrap();
    let load = "[load.pull]\non = \"chain.end\"\namplitude = 1.0\nfrequency = 2.0\n";
    std::fs::write(folder.path().join("machine.toml"), machine + load).unwrap();
    for line in ["check machine.toml", "run machine.toml --until 1s"] {
        let output = vibro(folder.path(), line);
        assert!(output.status.success(), "{}", said(&output));
    }
    let npz = std::fs::read(folder.path().join("chain.npz")).unwrap();
    assert!(npz.starts_with(b"PK\x03\x04") && npz.windows(9).any(|part| part == b"basis.npy"));
    let report = std::fs::read_to_string(folder.path().join("chain.txt")).unwrap();
    assert!(report.contains("these are all modes"), "{report}");
}

#[test]
#[cfg(feature = "reduce")]
fn invariant_a_machine_of_the_user_is_not_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    chain(folder.path());
    let path = folder.path().join("own.toml");
    std::fs::write(&path, "name = \"Own\"\n").unwrap();
    let line = format!("{FILES} --interface end=3 --modes 2 --out own");
    let output = vibro(folder.path(), &line);
    assert!(!output.status.success() && said(&output).contains("own.toml exists"), "{}", said(&output));
    let output = vibro(folder.path(), &format!("{line} --replace"));
    assert!(output.status.success(), "{}", said(&output));
    // A file that it made itself is replaced.
    let output = vibro(folder.path(), &line);
    assert!(output.status.success(), "{}", said(&output));
}

#[test]
#[cfg(feature = "reduce")]
fn invariant_what_does_not_fit_is_refused_by_words() {
    let folder = tempfile::tempdir().unwrap();
    chain(folder.path());
    for (line, expected) in [
        ("--interface end=4 --modes 2".to_owned(), "4: no such node; did you mean"),
        ("--interface end=3 --modes 2 --rayleigh 1".into(), "expected two numbers"),
        ("--interface end=3 --modes 2 --gravity y".into(), "expected one of x"),
        ("--interface end=3 --modes 2 --out 2nd".into(), "begins with a letter"),
        ("--interface end=3 --modes 0".into(), "from 1 to 500"),
        ("--interface end=3 --modes 2 --verify no.toml".into(), "--until"),
        ("--interface end=3 --modes 2 --verify no.toml --until 1s".into(), "no.toml"),
        ("--interface end=3 --modes 2 --verify chain.dof --until 1s".into(), "followed by chain.dof"),
    ] {
        let output = vibro(folder.path(), &format!("{FILES} {line}"));
        assert!(!output.status.success() && said(&output).contains(expected), "{line}: {}", said(&output));
    }
}

/// `--verify` prints the differences between the motions of two reductions, as runs of both files
/// have them.
#[test]
#[cfg(feature = "reduce")]
fn second_method_verify_compares_the_runs_of_both_reductions() {
    /// Half a unit of the last of three printed digits, relative.
    const PRINTED: f64 = 5e-3;
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    chain(folder);
    let rest = "[load.pull]\non = \"chain.end\"\namplitude = 40.0\nfrequency = 3.0\n\
                [stop.wall]\nbetween = [\"ground\", \"chain.end\"]\ngap = 0.05\nstiffness = 500.0\n";
    std::fs::write(folder.join("rest.toml"), rest).unwrap();
    let reduced = |modes: u32, out: &str, more: &str| {
        let line = format!("{FILES} --interface end=3 --modes {modes} --name chain --out {out} {more}");
        let output = vibro(folder, &line);
        assert!(output.status.success(), "{}", said(&output));
        said(&output)
    };
    let told = reduced(1, "one", "--verify rest.toml --until 2s");
    reduced(2, "two", "");
    let runs = ["one", "two"].map(|name| {
        let body = std::fs::read_to_string(folder.join(name).with_extension("toml")).unwrap();
        std::fs::write(folder.join("machine.toml"), body + rest).unwrap();
        let line =
            format!("run machine.toml --until 2s --samples 2000 --columns chain.end.s --out run-{name}");
        let output = vibro(folder, &line);
        assert!(output.status.success(), "{}", said(&output));
        let table = std::fs::read_to_string(folder.join(format!("run-{name}/states.csv"))).unwrap();
        let values =
            table.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse::<f64>().unwrap());
        values.collect::<Vec<_>>()
    });
    assert_eq!(runs[0].len(), runs[1].len());
    let apart = runs[0].iter().zip(&runs[1]).map(|(one, two)| (one - two).abs()).fold(0.0, f64::max);
    let line = told.lines().find(|line| line.contains("chain.end.s")).unwrap();
    let printed = line.split("at most ").nth(1).unwrap().split(' ').next().unwrap();
    let printed: f64 = printed.parse().unwrap();
    assert!(apart > 0.0 && (printed - apart).abs() <= PRINTED * apart, "{line} {apart}");
    assert!(told.contains("rest.toml with 1 and 2 modes over 2 s"), "{told}");
    assert!(told.contains("events: "), "{told}");
    assert!(reduced(3, "all", "--verify rest.toml --until 2s").contains("has all its modes"));
}

/// The blocks of a page with the words after their fence.
#[cfg(feature = "reduce")]
fn blocks(page: &str) -> Vec<(&str, &str)> {
    let blocks = page.split("\n```").skip(1).step_by(2);
    blocks.filter_map(|block| block.split_once('\n')).collect()
}

/// Runs a line of the tutorial and returns what it says; `None` if a program for it is missing.
#[cfg(feature = "reduce")]
fn performed(folder: &Path, line: &str) -> Option<String> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let output = match words[..] {
        ["cat", one, other, ">", whole] => {
            let text = [one, other].map(|name| std::fs::read_to_string(folder.join(name)).unwrap());
            std::fs::write(folder.join(whole), text.concat()).unwrap();
            return Some(String::new());
        }
        ["python3", script] => Command::new("python3").arg(script).current_dir(folder).output().ok()?,
        ["vibro", "fmu", machine] => {
            // Made by `cargo run --bin fmu-build`, which compiles the library.
            let kit = root().join("target/fmu/kits/own.zip");
            kit.exists().then(|| vibro(folder, &format!("fmu {machine} --kit {}", kit.display())))?
        }
        ["vibro", ..] => vibro(folder, &line["vibro ".len()..]),
        _ => return Some(String::new()),
    };
    assert!(output.status.success(), "{line}: {}", said(&output));
    Some(said(&output))
}

#[cfg(feature = "reduce")]
fn root() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The Python of the FMUs' tests, which has fmpy.
#[cfg(feature = "reduce")]
fn with_fmpy() -> Option<std::path::PathBuf> {
    let folders =
        std::fs::read_dir(root().join("target")).ok()?.filter_map(Result::ok).map(|entry| entry.path());
    let programs = folders.map(|folder| folder.join("bin/python"));
    let has = |python: &std::path::PathBuf| {
        let output = Command::new(python).args(["-c", "import fmpy"]).output();
        output.is_ok_and(|output| output.status.success())
    };
    programs.filter(|python| python.exists()).find(has)
}

/// The last row of a table that `vibro run` has written.
#[cfg(feature = "reduce")]
fn last(folder: &Path, table: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(folder.join(table)).unwrap();
    text.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect()
}

/// Rounding of the motion in other steps, m.
#[cfg(feature = "reduce")]
const ROUNDING: f64 = 1e-12;

/// Every command and file of docs/fe-to-fmu.md, the lines that it shows, and what it says of them.
#[test]
#[cfg(feature = "reduce")]
fn golden_the_tutorial_runs_and_shows_what_it_says() {
    let page = include_str!("../../../docs/fe-to-fmu.md");
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let (mut shown, mut expected) = (String::new(), Vec::new());
    for (info, block) in blocks(page) {
        match info.split_once(' ') {
            Some((_, name)) => std::fs::write(folder.join(name), format!("{block}\n")).unwrap(),
            None if info == "sh" => {
                for line in block.replace("\\\n", " ").lines() {
                    match performed(folder, line) {
                        Some(said) => shown += &said,
                        None => eprintln!("NOT RUN: {line}"),
                    }
                }
            }
            None => expected.extend(block.lines()),
        }
    }
    shown += &std::fs::read_to_string(folder.join("strip.txt")).unwrap();
    assert!(expected.len() > 10);
    for line in expected {
        assert!(
            shown.lines().any(|own| own.trim_end() == line.trim_end()),
            "the page shows\n{line}\nbut there is\n{shown}"
        );
    }
    // The FMU moves as the machine.
    let Some(python) = with_fmpy().filter(|_| folder.join("vibro-out/strip-FMI3.fmu").exists()) else {
        eprintln!("NOT RUN: the FMU, which needs `cargo run --bin fmu-build` and its Python");
        return;
    };
    let output = Command::new(python).arg("fmu.py").current_dir(folder).output().unwrap();
    let told = said(&output);
    let told: f64 = told.trim().rsplit(' ').next().unwrap().parse().unwrap_or_else(|_| panic!("{told}"));
    let run = vibro(folder, "run machine.toml --until 0.5s --samples 50 --columns strip.tip_z.s --out fmu");
    assert!(run.status.success(), "{}", said(&run));
    assert!((last(folder, "fmu/states.csv")[1] - told).abs() < ROUNDING, "{told}");
}
