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
    ] {
        let output = vibro(folder.path(), &format!("{FILES} {line}"));
        assert!(!output.status.success() && said(&output).contains(expected), "{line}: {}", said(&output));
    }
}

/// The blocks of a page with the words after their fence.
#[cfg(feature = "reduce")]
fn blocks(page: &str) -> Vec<(&str, &str)> {
    let blocks = page.split("\n```").skip(1).step_by(2);
    blocks.filter_map(|block| block.split_once('\n')).collect()
}

#[test]
#[cfg(feature = "reduce")]
fn golden_the_page_runs_and_shows_what_it_says() {
    let page = include_str!("../../../docs/reduce.md");
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    for (info, block) in blocks(page) {
        if let Some((_, name)) = info.split_once(' ') {
            write(name, block);
        }
    }
    let python = Command::new("python3").arg("matrices.py").current_dir(folder.path()).output();
    let Ok(python) = python else {
        eprintln!("NOT RUN: python3 is missing");
        return;
    };
    assert!(python.status.success(), "{}", said(&python));
    let joined = page.replace("\\\n", " ");
    let mut shown = String::new();
    for line in joined.lines().filter(|line| line.starts_with("vibro ") && !line.starts_with("vibro fmu")) {
        if line.starts_with("vibro check") {
            let [one, other] = ["beam.toml", "surroundings.toml"]
                .map(|name| std::fs::read_to_string(folder.path().join(name)).unwrap());
            write("machine.toml", &(one + &other));
        }
        let output = vibro(folder.path(), &line["vibro ".len()..]);
        assert!(output.status.success(), "{line}: {}", said(&output));
        shown += &said(&output);
    }
    shown += &std::fs::read_to_string(folder.path().join("beam.txt")).unwrap();
    let outputs: Vec<&str> =
        blocks(page).into_iter().filter(|(info, _)| *info == "text").map(|own| own.1).collect();
    assert_eq!(outputs.len(), 3);
    for line in outputs.iter().flat_map(|block| block.lines()) {
        assert!(
            shown.lines().any(|own| own.trim_end() == line.trim_end()),
            "the page shows\n{line}\nbut there is\n{shown}"
        );
    }
}
