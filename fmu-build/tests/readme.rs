//! Every code block of README.md and of the pages in docs/ works: Python blocks are run, and each
//! shell command is known to be tested.

mod common;

use fmu_build::version::Version;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Pages of docs/ whose blocks and commands of an installed `vibro` another test runs, and that
/// test.
const RUN_ELSEWHERE: [(&str, &str); 11] = [
    ("paper-machine.md", "fmu-build/tests/guides.rs"),
    ("design-a-damper.md", "fmu-build/tests/guides.rs"),
    ("python.md", "tests/python/test_guide.py"),
    ("derivatives.md", "tests/python/test_guide.py"),
    ("machine-studies.md", "crates/command-line/tests/assembly_orbits.rs"),
    ("fit.md", "crates/command-line/tests/fit.rs"),
    ("fe-to-fmu.md", "crates/command-line/tests/reduce.rs"),
    ("against-experiment.md", "crates/command-line/tests/experiment.rs"),
    ("matlab.md", "crates/command-line/tests/octave.rs"),
    ("assemblies.md", "crates/machine/tests/file/examples.rs"),
    ("machine-file.md", "crates/machine/tests/file/examples.rs"),
];

/// Pages outside docs/ that show commands.
const OUTSIDE: [&str; 4] = ["README.md", "CONTRIBUTING.md", "tests/README.md", "web/explorer/README.md"];

/// The commands below this heading of tests/README.md are run by hand, and their results recorded.
const BY_HAND: &str = "\n## Memory and random input, by hand";

/// Shell commands and the tests that run them.
const COVERED: [(&str, &str); 22] = [
    ("python3 truth/build.py", "fmu-build/tests/truth.rs packs the same machines"),
    ("python3 truth/score.py fmpy", "fmu-build/tests/truth.rs, run by .ci/run"),
    ("python3 docs/site/build.py", "fmu-build/tests/site.rs, run by .ci/run"),
    ("pip install ./python", "fmu-build/tests/examples.rs does the same by way of a wheel"),
    ("pip install \"./python[plot]\"", "the same, and tests/python/requirements.txt has matplotlib"),
    (
        "cargo build --release -p vibro --features reduce",
        "crates/command-line/tests/reduce.rs, run by .ci/run with the feature",
    ),
    ("python3 matrices.py", TUTORIAL),
    ("cat strip.toml surroundings.toml > machine.toml", TUTORIAL),
    ("cat finer.toml surroundings.toml > finer_machine.toml", TUTORIAL),
    ("cat rubin.toml surroundings.toml > rubin_machine.toml", TUTORIAL),
    ("cargo run --bin fmu-build", "fmu-build/tests/command.rs runs the same binary"),
    (
        "cargo run --bin fmu-build -- assembly examples/assembly/damper_with_buffer.toml",
        "fmu-build/tests/assembly.rs packs this machine",
    ),
    ("cargo run --bin fmu-build -- --portable", "fmu-build/tests/portable.rs, run by .ci/run"),
    (TARGETS, "the test below compares it with the platforms"),
    (ZIG, "fmu-build/tests/platforms.rs runs with what it installs"),
    (
        "PATH=\"$PWD/target/zig/bin:$PATH\" cargo run --bin fmu-build -- --all-platforms",
        "fmu-build/tests/platforms.rs",
    ),
    ("rustup target add wasm32-wasip2", "the test of the component needs it and says so"),
    (
        "cargo run --bin fmu-build -- assembly examples/assembly/damper_with_buffer.toml --wasm",
        "fmu-build/tests/component.rs packs the same archive, run by .ci/run",
    ),
    ("rustup target add wasm32-unknown-unknown", "the test of the page needs it and says so"),
    ("cargo run --bin fmu-build -- --explorer", "fmu-build/tests/live_page.rs, run by .ci/run"),
    ("cargo run --release -p web-build", "web/build/tests/page.rs, run by .ci/run"),
    (
        "PATH=\"$PWD/target/zig/bin:$PATH\" cargo run --bin fmu-build -- release --preview",
        "fmu-build/tests/release.rs, run by .ci/run",
    ),
];

/// docs/fe-to-fmu.md.
const TUTORIAL: &str = "crates/command-line/tests/reduce.rs, run by .ci/run with the feature";
const ZIG: &str =
    "python3 -m venv target/zig && target/zig/bin/pip install --requirement fmu-build/requirements.txt";
const TARGETS: &str = "rustup target add x86_64-pc-windows-gnu i686-pc-windows-gnu i686-unknown-linux-gnu \
                       aarch64-unknown-linux-gnu x86_64-apple-darwin aarch64-apple-darwin";

#[test]
fn the_targets_named_are_those_of_the_platforms() {
    let named: BTreeSet<&str> = TARGETS.split_whitespace().skip(3).collect();
    // The target of the computer for which the page is written comes with the toolchain.
    let needed = fmu_build::platforms::PLATFORMS.iter().flat_map(|p| p.targets).copied();
    assert_eq!(named, needed.filter(|target| *target != "x86_64-unknown-linux-gnu").collect());
}

/// The pages, by their paths in the repository.
fn pages() -> Vec<String> {
    let docs = fs::read_dir(common::python::root().join("docs")).expect("docs can be read");
    let names = docs.map(|entry| entry.expect("an entry").file_name().into_string().expect("a name"));
    let own = names.filter(|name| name.ends_with(".md")).map(|name| format!("docs/{name}"));
    let mut pages: Vec<String> = own.chain(OUTSIDE.map(str::to_owned)).collect();
    pages.sort();
    pages
}

/// Whether another test runs the blocks of a page.
fn is_run_elsewhere(page: &str) -> bool {
    RUN_ELSEWHERE.iter().any(|(name, _)| page == format!("docs/{name}"))
}

fn read(path: &str) -> String {
    fs::read_to_string(common::python::root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

#[test]
fn the_pages_that_are_left_out_here_are_read_by_their_own_tests() {
    for (page, test) in RUN_ELSEWHERE {
        assert!(read(test).contains(page), "{test} does not read {page}");
    }
}

/// The packages of the workspace: name and folder.
fn packages() -> Vec<(String, PathBuf)> {
    let root = common::python::root();
    let folders =
        [".", "crates", "web"].map(|folder| fs::read_dir(root.join(folder)).expect("the workspace"));
    let children = folders.into_iter().flatten().map(|entry| entry.expect("an entry").path());
    let named = |folder: PathBuf| {
        let manifest = fs::read_to_string(folder.join("Cargo.toml")).ok()?;
        let package = manifest.split("[package]").nth(1)?;
        let name = package.lines().find_map(|line| line.strip_prefix("name = \"")?.strip_suffix('"'))?;
        Some((name.to_owned(), folder))
    };
    children.chain([root.to_owned()]).filter_map(named).collect()
}

/// The file of a test: from the package's manifest, or else by its name.
fn file_of(test: &str, folder: &Path) -> PathBuf {
    let manifest = fs::read_to_string(folder.join("Cargo.toml")).unwrap_or_default();
    let named = manifest.split_once(&format!("[[test]]\nname = \"{test}\"\npath = \""));
    let path = named.and_then(|(_, rest)| rest.split('"').next()).map(str::to_owned);
    let usual = if manifest.contains("autotests = false") { "none" } else { "tests" };
    folder.join(path.unwrap_or_else(|| format!("{usual}/{test}.rs")))
}

/// Errors in a call of `cargo test`: a missing package or test, or `--ignored` for a test without
/// such cases.
fn wrong_in(call: &str) -> Option<String> {
    let words: Vec<&str> = call.split_whitespace().collect();
    let after =
        |option: &str| words.windows(2).filter(move |w| w[0] == option).map(|w| w[1]).collect::<Vec<_>>();
    let packages = packages();
    let chosen = after("-p");
    if let Some(name) = chosen.iter().find(|name| !packages.iter().any(|(package, _)| package == *name)) {
        return Some(format!("no package is called {name}"));
    }
    let of_call = packages.iter().filter(|(name, _)| chosen.is_empty() || chosen.contains(&name.as_str()));
    let folders: Vec<&PathBuf> = of_call.map(|(_, folder)| folder).collect();
    for test in after("--test") {
        let files = folders.iter().map(|folder| file_of(test, folder));
        let Some(text) = files.filter_map(|file| fs::read_to_string(file).ok()).next() else {
            return Some(format!("no test is called {test}"));
        };
        if words.contains(&"--ignored") && !text.contains("#[ignore") {
            return Some(format!("{test} ignores nothing"));
        }
    }
    None
}

#[test]
fn calls_of_cargo_test_are_checked() {
    assert_eq!(wrong_in("cargo test -p vibro-impact --test golden"), None);
    assert_eq!(wrong_in("cargo test --test golden --test repository"), None);
    assert_eq!(wrong_in("cargo test -p vibro-machine --test motions points::"), None);
    assert_eq!(wrong_in("cargo test -p fmu-build --test python_package -- --ignored"), None);
    for call in [
        "cargo test -p vibro-nothing",
        "cargo test -p vibro-machine --test second_method",
        "cargo test -p vibro-paper-component --test golden",
        "cargo test -p vibro-impact --test golden -- --ignored",
    ] {
        assert!(wrong_in(call).is_some(), "{call}");
    }
}

/// Fails unless every command of a block is run by a test.
fn check_commands(page: &str, block: &str) {
    let requirements = read("tests/fmpy/requirements.txt");
    let example_tests = read("tests/examples/test_scripts.py") + &read("tests/examples/test_dask_sweep.py");
    let block = block.replace("\\\n", " ");
    for line in block.lines().map(|line| line.split('#').next().unwrap_or("").trim()) {
        // The tests install the same requirements.
        let installed = line.strip_prefix("pip install ").is_some_and(|list| {
            list.split_whitespace().all(|name| requirements.contains(&format!("\n{name}==")))
        });
        // Run by crates/command-line/tests/readme.rs, which has the program.
        let of_vibro = (page == "README.md" || page.starts_with("docs/"))
            && line.starts_with("cargo run --release -p vibro -- ");
        // Run by tests/examples, which has the requirements.
        let script = line.strip_prefix("python examples/").and_then(|rest| rest.split(' ').next());
        let script = script.is_some_and(|script| example_tests.contains(&format!("\"{script}\"")));
        if line.starts_with("vibro ") && is_run_elsewhere(page) {
            continue;
        }
        if line == "cargo test" || line.starts_with("cargo test ") {
            assert_eq!(wrong_in(line), None, "`{line}` of {page}");
            continue;
        }
        let covered = line.is_empty() || COVERED.iter().any(|(command, _)| *command == line);
        assert!(
            covered || installed || of_vibro || script,
            "no test runs `{line}` of {page}; add one and name it here"
        );
    }
}

#[test]
fn every_code_block_works() {
    let fmu = common::python::fmu();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("readme");
    fs::create_dir_all(folder.join("target")).expect("target can be written");
    for version in Version::USUAL {
        let copy = version.beside(&folder.join("target/VibroImpact3DOF.fmu"));
        fs::copy(version.beside(&fmu), copy).expect("target can be written");
    }
    let machine = common::python::root().join("examples/assembly/damper_with_buffer.toml");
    let kit = fmu_build::kit::at_hand().expect("the library of described machines");
    fmu_build::assembly::write(&machine, Some(&folder), false, &kit)
        .expect("both archives of the page of FMUs");
    let mut ran = BTreeSet::new();
    for page in pages() {
        let text = read(&page);
        let text = text.split(BY_HAND).next().expect("a part");
        for (language, block) in common::blocks(text) {
            match (language.as_str(), page.as_str()) {
                ("sh", _) => check_commands(&page, &block),
                _ if is_run_elsewhere(&page) => {}
                ("python", _) => {
                    let of_package = block.contains("vibro_impact");
                    let program = if of_package {
                        common::python::python_with_package()
                    } else {
                        common::python::python()
                    };
                    let mut python = common::python::command(program);
                    let printed = common::python::run(
                        &format!("a Python block of {page}"),
                        python.args(["-c", &block]).current_dir(&folder),
                    );
                    assert!(!printed.trim().is_empty(), "the block prints nothing to look at:\n{block}");
                    ran.insert((page.clone(), of_package));
                }
                ("text", "README.md") => {
                    let run = fmu_build::run::run(&fmu, 200).expect("the FMU runs");
                    let table = fmu_build::table::RunTable(&run).to_string();
                    assert!(
                        table.starts_with(&block),
                        "README.md shows\n{block}\nbut the run gives\n{table}"
                    );
                }
                // Written and used by crates/command-line/tests/readme.rs.
                ("toml damper.toml", "README.md") => {}
                // Maps of the code.
                ("text", "docs/design.md") => {}
                // The calls of tests/reduce/test_reduce.py, with the reader's own matrices.
                ("text", "docs/reduce.md") => {}
                // Run by the documentation tests of vibro-impact (`src/lib.rs`).
                ("rust", "README.md") => {}
                (other, _) => panic!("{page} has a block in {other:?}, which no test runs"),
            }
        }
    }
    for shown in [("README.md", false), ("README.md", true), ("docs/fmu.md", false)] {
        assert!(ran.contains(&(shown.0.to_owned(), shown.1)), "{shown:?}: no such Python block in {ran:?}");
    }
}
