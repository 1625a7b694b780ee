//! Every code block of README.md works: Python blocks are run, shell commands are known to be tested.

mod common;

use fmu_build::version::Version;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Shell commands of the README and what runs them.
const COVERED: [(&str, &str); 15] = [
    ("pip install ./python", "fmu-build/tests/examples.rs does the same by way of a wheel"),
    ("cargo run --release -p fmu-build", "fmu-build/tests/command.rs runs the same binary"),
    ("cargo test --workspace", "is running now"),
    (TARGETS, "the test below compares it with the platforms"),
    (ZIG, "fmu-build/tests/platforms.rs runs with what it installs"),
    (
        "PATH=\"$PWD/target/zig/bin:$PATH\" cargo run --release -p fmu-build -- --all-platforms",
        "fmu-build/tests/platforms.rs",
    ),
    ("cargo test -p fmu-build --test examples -- --ignored", "fmu-build/tests/examples.rs, asked for"),
    ("cargo test -p fmu-build --test page -- --ignored", "fmu-build/tests/page.rs, asked for"),
    ("rustup target add wasm32-unknown-unknown", "the test of the page needs it and says so"),
    ("cargo run --release -p fmu-build -- --explorer", "fmu-build/tests/live_page.rs, asked for"),
    ("cargo test -p explorer-build --test page -- --ignored", "explorer-build/tests/page.rs, asked for"),
    ("cargo test -p fmu-build --test live_page -- --ignored", "fmu-build/tests/live_page.rs, asked for"),
    (
        "cargo test -p fmu-build --test platforms -- --ignored --nocapture",
        "fmu-build/tests/platforms.rs, asked for",
    ),
    (
        "PATH=\"$PWD/target/zig/bin:$PATH\" cargo run --release -p fmu-build -- release --preview",
        "fmu-build/tests/release.rs, asked for",
    ),
    (
        "cargo test -p fmu-build --test release -- --ignored --nocapture",
        "fmu-build/tests/release.rs, asked for",
    ),
];

const ZIG: &str =
    "python3 -m venv target/zig && target/zig/bin/pip install --requirement fmu-build/requirements.txt";
const TARGETS: &str = "rustup target add x86_64-pc-windows-gnu i686-pc-windows-gnu i686-unknown-linux-gnu \
                       aarch64-unknown-linux-gnu x86_64-apple-darwin aarch64-apple-darwin";

#[test]
fn the_targets_named_are_those_of_the_platforms() {
    let named: BTreeSet<&str> = TARGETS.split_whitespace().skip(3).collect();
    // That of the machine the README is written for comes with the toolchain.
    let needed = fmu_build::platforms::PLATFORMS.iter().flat_map(|p| p.targets).copied();
    assert_eq!(named, needed.filter(|target| *target != "x86_64-unknown-linux-gnu").collect());
}

#[test]
fn every_code_block_works() {
    let readme = fs::read_to_string(common::python::root().join("README.md")).expect("README.md can be read");
    let blocks = common::blocks(&readme);
    assert!(blocks.iter().any(|(language, _)| language == "python"), "the README shows the use in fmpy");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readme");
    fs::create_dir_all(folder.join("target")).expect("target can be written");
    let fmu = common::python::fmu();
    for version in Version::USUAL {
        let copy = version.beside(&folder.join("target/VibroImpact3DOF.fmu"));
        fs::copy(version.beside(&fmu), copy).expect("target can be written");
    }
    let requirements = fs::read_to_string(common::python::root().join("tests/fmpy/requirements.txt"))
        .expect("requirements.txt can be read");
    let example_tests: String = ["test_scripts.py", "test_dask_sweep.py"]
        .map(|name| fs::read_to_string(common::python::root().join("tests/examples").join(name)).unwrap())
        .concat();
    for (language, text) in blocks {
        match language.as_str() {
            "python" => {
                let of_package = text.contains("vibro_impact");
                let program =
                    if of_package { common::python::python_with_package() } else { common::python::python() };
                let mut python = Command::new(program);
                let printed = common::python::run(
                    "a Python block of README.md",
                    python.args(["-c", &text]).current_dir(&folder),
                );
                assert!(!printed.trim().is_empty(), "the block prints nothing to look at:\n{text}");
            }
            "sh" => {
                for line in text.lines().map(|line| line.split('#').next().unwrap_or("").trim()) {
                    // What is installed is what the tests have installed.
                    let installed = line.strip_prefix("pip install ").is_some_and(|list| {
                        list.split_whitespace().all(|name| requirements.contains(&format!("\n{name}==")))
                    });
                    // Run by vibro/tests/readme.rs, whose program it is.
                    if line.starts_with("cargo run --release -p vibro -- ") {
                        continue;
                    }
                    // Run by tests/examples, which has what they need.
                    let script =
                        line.strip_prefix("python examples/").and_then(|rest| rest.split(' ').next());
                    if script.is_some_and(|script| example_tests.contains(&format!("\"{script}\""))) {
                        continue;
                    }
                    let covered = line.is_empty() || COVERED.iter().any(|(command, _)| *command == line);
                    assert!(
                        covered || installed,
                        "no test runs `{line}` of README.md; add one and name it here"
                    );
                }
            }
            "text" => {
                let run = fmu_build::run::run(&fmu, 200).expect("the FMU runs");
                let table = fmu_build::table::Table(&run).to_string();
                assert!(table.starts_with(&text), "README.md shows\n{text}\nbut the run gives\n{table}");
            }
            // Run by the documentation tests of vibro-impact (`src/lib.rs`).
            "rust" => {}
            other => panic!("README.md has a block in {other:?}, which no test runs"),
        }
    }
}
