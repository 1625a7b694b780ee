//! Archives of described machines: their content, and runs of them in FMPy compared with the
//! engine's motion.

mod common;

use common::python::{command, python, root, run};
use fmu_build::assembly::{content, write};
use fmu_build::check;
use fmu_build::compile::SHARED_LIBRARY;
use fmu_build::kit::Kit;
use fmu_build::platforms::{Binaries, PLATFORMS, Platform};
use fmu_build::reference::FOLDER;
use fmu_build::version::Version;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vibro_machine::{Assembly, Motion, file};
use vibro_machine_component::Plan;

/// Machines that are run in every way: with a closed form, with every kind of element, with
/// rotation, with friction of changing level. All others are run in steps.
const EXAMPLES: [&str; 5] =
    ["bouncing_ball", "paper_machine", "damper_with_buffer", "gear_backlash", "msl_coupled_clutches"];

fn example(name: &str) -> PathBuf {
    root().join("examples/assembly").join(name).with_extension("toml")
}

/// The library that cargo compiled for this test, without release optimisations, which do not
/// affect any bit.
fn kit() -> Kit {
    let name = format!("{}vibro_machine_fmu{SHARED_LIBRARY}", std::env::consts::DLL_PREFIX);
    let library = std::env::current_exe().expect("a test has a file").with_file_name(name);
    Kit { binaries: Binaries::own(fs::read(library).expect("it lies beside the test")), ..Kit::default() }
}

/// Writes the engine's motion at the communication points of a machine's description, in the form
/// of the FMU's outputs.
fn native(path: &Path, to: &Path) {
    let assembly = Arc::new(Assembly::new(file::read(path).expect("an example")).expect("it has matrices"));
    let experiment = Plan::of(&assembly.description).expect("an example").description().experiment;
    // A power of two, so that sums of steps are exact in every host.
    let step = experiment.step_size.log2().round().exp2();
    let mut motion = Motion::new(assembly.clone()).expect("it has a start");
    let names: Vec<_> = assembly.description.bodies.iter().map(|body| body.name.as_str()).collect();
    let columns = names.iter().flat_map(|name| ["s", "v", "a"].map(|what| format!(",{name}.{what}")));
    let mut csv = format!("time{}\n", columns.collect::<String>());
    for k in 0..=1000 {
        let time = f64::from(k) * step;
        motion.advance_to(time).expect("it moves");
        write!(csv, "{time}").expect("a String takes all");
        for value in (0..names.len()).flat_map(|i| motion.body(i)) {
            write!(csv, ",{}", value + 0.0).expect("a String takes all");
        }
        csv.push('\n');
    }
    fs::write(to, csv).expect("target can be written");
}

/// Packs machines and runs them in FMPy: the first list in every way, the second in steps.
fn run_in_fmpy(folder: &str, names: &[&str], stepped: &[&str]) {
    let (kit, folder) = (kit(), fmu_build::compile::target().join(folder));
    fs::create_dir_all(&folder).expect("target can be written");
    for name in names.iter().chain(stepped) {
        let archives = write(&example(name), Some(&folder.join(name).with_extension("fmu")), true, &kit);
        assert_eq!(archives.expect("it is packed").len(), 3);
        native(&example(name), &folder.join(name).with_extension("csv"));
    }
    let mut script = command(python());
    script.arg(root().join("tests/fmpy/described_machines.py")).arg(&folder).args(names).arg("--");
    run("running them in FMPy", script.args(stepped));
}

#[test]
fn second_method_described_machines_in_fmpy_against_the_engine() {
    run_in_fmpy("described", &EXAMPLES, &[]);
}

#[test]
#[ignore = "packs and runs twenty more machines: 45 s of processor time"]
fn second_method_every_other_example_in_fmpy_against_the_engine() {
    let files = fs::read_dir(root().join("examples/assembly")).expect("the folder of examples");
    let paths = files.map(|entry| entry.expect("an entry").path());
    let names: Vec<String> = paths
        .filter(|path| path.extension().is_some_and(|ending| ending == "toml"))
        .map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned())
        .filter(|name| !EXAMPLES.contains(&name.as_str()))
        .collect();
    assert!(names.len() > 10, "{names:?}");
    run_in_fmpy("others", &["bouncing_ball"], &names.iter().map(String::as_str).collect::<Vec<_>>());
}

#[test]
fn invariant_an_archive_holds_the_machine_under_its_name() {
    let machine = file::read(&example("damper_with_buffer")).unwrap();
    let plan = Plan::of(&machine).unwrap();
    let kit = Kit { binaries: Binaries::own(b"library".to_vec()), ..Kit::default() };
    for version in Version::USUAL {
        let content = content(version, &plan, &kit).unwrap();
        let text = |name: &str| std::str::from_utf8(&content[name]).unwrap();
        assert!(text("modelDescription.xml").contains(plan.token()));
        assert!(text("modelDescription.xml").contains("modelIdentifier=\"DamperWithBuffer\""));
        assert_eq!(file::parse(text("resources/machine.toml"), "", &file::no_records).unwrap(), machine);
        let binaries: Vec<_> = content.keys().filter(|name| name.starts_with("binaries/")).collect();
        assert!(binaries[0].ends_with(&format!("/DamperWithBuffer{SHARED_LIBRARY}")), "{binaries:?}");
        assert!(
            text("documentation/index.html").contains("<code>stop.buffer.stiffness</code></td><td>N/m</td>")
        );
        // On a narrow page the sketch keeps a width at which its names are readable: seven tenths
        // of its full width.
        let sketch = text("documentation/index.html").split("<svg style=\"min-width:").nth(1).unwrap();
        let number =
            |text: &str| text.split(|c: char| !c.is_ascii_digit()).next().unwrap().parse::<f64>().unwrap();
        let width = number(sketch.split(" width=\"").nth(1).unwrap());
        assert!((number(sketch) - 0.7 * width).abs() < 1.0, "{}", &sketch[..200]);
        // The picture is a PNG; terminals name existing variables.
        let icon = if version == Version::Fmi2 { "model.png" } else { "terminalsAndIcons/icon.png" };
        assert!(content[icon].starts_with(b"\x89PNG"));
        if version == Version::Fmi3 {
            let terminals = text("terminalsAndIcons/terminalsAndIcons.xml");
            let names: Vec<_> = terminals
                .split("variableName=\"")
                .skip(1)
                .map(|rest| rest.split('"').next().unwrap())
                .collect();
            assert!(names.len() >= 9, "{names:?}");
            assert!(names.iter().all(|name| plan.table.reference(name).is_some()), "{names:?}");
        }
    }
}

/// Whether a problem concerns only the 3-DOF machine: no state may be the derivative of another.
fn is_of_the_3_dof_machine(problem: &str) -> bool {
    problem.ends_with("is not a state")
}

#[test]
fn invariant_descriptions_of_all_examples_pass_our_own_checks() {
    let folder = fs::read_dir(root().join("examples/assembly")).unwrap();
    let paths = folder.map(|entry| entry.unwrap().path());
    for path in paths.filter(|path| path.extension().is_some_and(|ending| ending == "toml")) {
        let machine = file::read(&path).unwrap();
        let usual = Plan::of(&machine).unwrap();
        let problems = |plan: &Plan, version| check::problems(&plan.xml(version, None), version).unwrap();
        let mut found = problems(&usual, fmi_doors::Version::Fmi2);
        for plan in [usual, Plan::of(&machine).unwrap().with_arrays()] {
            found.extend(problems(&plan, fmi_doors::Version::Fmi3));
        }
        found.retain(|problem| !is_of_the_3_dof_machine(problem));
        assert!(found.is_empty(), "{}: {found:?}", path.display());
    }
}

#[test]
fn closed_form_reference_results_are_those_of_the_file() {
    let kit = Kit { binaries: Binaries::own(b"library".to_vec()), ..Kit::default() };
    let ball = file::read(&example("bouncing_ball")).unwrap();
    let content = content(Version::Fmi2, &Plan::of(&ball).unwrap(), &kit).unwrap();
    let text = |name: &str| std::str::from_utf8(&content[&format!("{FOLDER}/{name}")]).unwrap();
    let numbers = |line: &str| -> Vec<f64> { line.split(',').map(|x| x.parse().unwrap()).collect() };
    let mut lines = text("default.csv").lines();
    assert_eq!(lines.next().unwrap(), "time,ball.s,ball.v,floor.impacts");
    let rows: Vec<_> = lines.map(numbers).collect();
    assert_eq!((rows.len(), rows[0].as_slice()), (257, &[0.0; 4][..]));
    // The fall, and rest on the floor after 8.58 s.
    for row in rows.iter().filter(|row| row[0] * row[0] < 2.0 / 9.81) {
        assert!((row[1] - 0.5 * 9.81 * row[0] * row[0]).abs() < 1e-9, "{row:?}");
    }
    assert!(rows[256][1] == 1.0 && rows[256][2].abs() < 1e-30, "{:?}", rows[256]);
    let events: Vec<_> = text("events.csv").lines().skip(1).map(numbers).collect();
    assert!((events[0][2] - (2.0 * 9.81_f64).sqrt()).abs() < 1e-8 && events[0][0] == events[1][0]);
    assert!((events[1][2] + 0.9 * events[0][2]).abs() < 1e-8);
    assert!(
        text("smoke-test.xml").contains("stopTime=\"9.1\" stepSize=\"0.035546875\""),
        "{}",
        text("smoke-test.xml")
    );
    for name in ["default.csv", "events.csv", "smoke-test.xml", "../../documentation/fmi-ls-ref.txt"] {
        assert!(text("fmi-ls-manifest.xml").contains(&format!("source=\"{name}\"")), "{name}");
    }
    assert!(content.contains_key("documentation/fmi-ls-ref.txt"));
    // Values that rounding decides are not given: this machine's motion is chaotic.
    let blocks = file::read(&example("two_blocks")).unwrap();
    let plan = Plan::of(&blocks).unwrap();
    let rows = vibro_pack::reference::files(&plan)["default.csv"].clone();
    let rows = String::from_utf8(rows).unwrap().lines().count();
    assert!((20..251).contains(&rows), "{rows}");
}

#[test]
fn invariant_archives_for_all_platforms_hold_the_library_of_each_under_the_machines_name() {
    let library =
        |platform: &Platform| (platform.place.tuple.to_owned(), platform.place.folder.as_bytes().to_vec());
    let folders = PLATFORMS.iter().map(library).collect();
    let kit = Kit { binaries: Binaries::from_folders(folders).unwrap(), ..Kit::default() };
    let plan = Plan::of(&file::read(&example("bouncing_ball")).unwrap()).unwrap();
    for version in Version::USUAL {
        let content = content(version, &plan, &kit).unwrap();
        let binaries = content.iter().filter(|(name, _)| name.starts_with("binaries/"));
        let found: Vec<_> = binaries.map(|(name, bytes)| (name.clone(), bytes.clone())).collect();
        assert_eq!(found.len(), PLATFORMS.len());
        for p in PLATFORMS {
            let name = vibro_pack::binary_path(version.fmi(), "BouncingBall", p.place);
            assert!(found.contains(&(name.clone(), p.place.folder.as_bytes().to_vec())), "{name}: {found:?}");
        }
    }
}
