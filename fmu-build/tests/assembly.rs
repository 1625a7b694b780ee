//! Archives of described machines: what is in them, and runs of them in FMPy against the engine's own motion.

mod common;

use common::python::{python, root, run};
use fmu_build::assembly::{content, write};
use fmu_build::compile::SHARED_LIBRARY;
use fmu_build::kit::Kit;
use fmu_build::platforms::Binaries;
use fmu_build::version::Version;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use vibro_assembly::{Assembly, Motion, file};
use vibro_assembly_fmi::Plan;

/// Machines that are run: with a closed form, with every kind of element, with rotation, with friction of a changing level.
const EXAMPLES: [&str; 5] =
    ["bouncing_ball", "paper_machine", "damper_with_buffer", "gear_backlash", "msl_coupled_clutches"];

fn example(name: &str) -> PathBuf {
    root().join("examples/assembly").join(name).with_extension("toml")
}

/// The library that cargo compiled for this test, without the optimisations of a release, on which no bit depends.
fn kit() -> Kit {
    let name = format!("{}vibro_machine{SHARED_LIBRARY}", std::env::consts::DLL_PREFIX);
    let library = std::env::current_exe().expect("a test has a file").with_file_name(name);
    Kit { binaries: Binaries::own(fs::read(library).expect("it lies beside the test")), ..Kit::default() }
}

/// The engine's motion at the communication points of a machine's description, as the FMU's outputs have it.
fn native(path: &Path, to: &Path) {
    let assembly = Arc::new(Assembly::new(file::read(path).expect("an example")).expect("it has matrices"));
    let experiment = Plan::of(&assembly.description).expect("an example").description().experiment;
    // A power of two, in which sums of steps are exact whoever makes them.
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

#[test]
fn second_method_described_machines_in_fmpy_against_the_engine() {
    let (kit, folder) = (kit(), fmu_build::compile::target().join("described"));
    fs::create_dir_all(&folder).expect("target can be written");
    for name in EXAMPLES {
        let archives = write(&example(name), Some(&folder.join(name).with_extension("fmu")), &kit);
        assert_eq!(archives.expect("it is packed").len(), 2);
        native(&example(name), &folder.join(name).with_extension("csv"));
    }
    let mut script = Command::new(python());
    script.arg(root().join("tests/fmpy/described_machines.py")).arg(&folder);
    run("running them in FMPy", script.args(EXAMPLES));
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
        assert!(text("documentation/index.html").contains("<svg"));
        // A picture is a PNG; terminals name variables that there are.
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
