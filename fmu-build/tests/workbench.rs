//! FMUs packed by the workbench in a browser: they equal the packager's in every entry except the
//! reference results, and run in FMPy. Runs only on request, because it compiles the page's core
//! for wasm32-unknown-unknown and requires node with npm, Chromium and Python.

mod common;

use fmi_doors::Version;
use fmu_build::compile;
use std::path::Path;
use std::process::Command;
use vibro_machine::file;
use vibro_machine_component::Plan;
use vibro_pack::{Kit, archive, content, reference};

const EXAMPLES: [&str; 3] = ["bouncing_ball", "damper_with_buffer", "gear_backlash"];

/// Runs an FMU over its default experiment in Co-Simulation and, on request, in Model Exchange,
/// and compares with the native rows of its reference results, which agree within 1e-8 of each
/// column's largest value. A solver's own error in Model Exchange is larger.
const SCRIPT: &str = "
import csv, sys, zipfile, numpy as np, fmpy
for path in sys.argv[1:]:
    with zipfile.ZipFile(path) as z:
        rows = list(csv.reader(z.read('extra/org.fmi-standard.fmi-ls-ref/default.csv').decode().splitlines()))
    names, data = rows[0], np.array(rows[1:], float)
    states = [n for n in names[1:] if n.endswith(('.s', '.v'))]
    step = data[1, 0] - data[0, 0]
    got = fmpy.simulate_fmu(path, fmi_type='CoSimulation', stop_time=data[-1, 0], output_interval=step, output=states)
    for n in states:
        own = data[:, names.index(n)]
        off = np.abs(np.interp(data[:, 0], got['time'], got[n]) - own).max()
        # Between communication points interp is no motion: they are the rows' own times.
        assert off <= 1e-8 * max(np.abs(own).max(), 1e-9), (path, n, off)
    end = min(data[-1, 0], 20 * step)
    got = fmpy.simulate_fmu(path, fmi_type='ModelExchange', stop_time=end, output=states, relative_tolerance=1e-10)
    assert np.isfinite([got[n][-1] for n in states]).all(), path
    print('ok', path)
";

#[test]
#[ignore = "needs the target wasm32-unknown-unknown, node with npm, Chromium and Python"]
fn second_method_fmus_packed_in_the_page_are_the_packagers_and_run_in_fmpy() {
    let kit = common::python::kit();
    let target = compile::target();
    let page = target.join("workbench/full.html");
    let mut build = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    build.current_dir(compile::workspace());
    build.args(["run", "--quiet", "--locked", "--package", "web-build", "--target-dir"]);
    build.arg(target.join("explorer/tool")).args(["--", "workbench", "--kit"]).arg(&kit);
    let built = build.arg("--out").arg(&page).output().unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));

    let folder = target.join("workbench/fmus");
    std::fs::create_dir_all(&folder).unwrap();
    let mut node = Command::new("node");
    node.arg(compile::workspace().join("web/workbench/page/test/fmu.mjs")).arg(target.join("explorer/npm"));
    let done = node.arg(&page).arg(&folder).args(EXAMPLES).output().unwrap();
    let printed = String::from_utf8_lossy(&done.stdout).into_owned();
    println!("{printed}");
    assert!(done.status.success(), "{printed}{}", String::from_utf8_lossy(&done.stderr));

    let kit = Kit::read(&kit).unwrap();
    let mut all = Vec::new();
    for example in EXAMPLES {
        let path = compile::workspace().join("examples/assembly").join(example).with_extension("toml");
        let plan = Plan::of(&file::read(&path).unwrap()).unwrap();
        for (number, version) in [(2, Version::Fmi2), (3, Version::Fmi3)] {
            let fmu = folder.join(format!("{example}-fmi{number}.fmu"));
            same(&archive::read_all(&fmu).unwrap(), &content(version, &plan, &kit).unwrap(), &fmu);
            all.push(fmu);
        }
    }
    let mut python = Command::new(common::python::python());
    let told = common::python::run("fmpy", python.args(["-c", SCRIPT]).args(&all));
    assert_eq!(told.matches("ok ").count(), 2 * EXAMPLES.len(), "{told}");
}

/// Asserts that two archives have the same entries, with the same bytes except reference results.
fn same(found: &archive::Content, own: &archive::Content, fmu: &Path) {
    let names: Vec<_> = found.keys().collect();
    assert_eq!(names, own.keys().collect::<Vec<_>>(), "{}", fmu.display());
    for (name, bytes) in own {
        let is_result = name.starts_with(reference::FOLDER);
        assert!(is_result || &found[name] == bytes, "{}: {name}", fmu.display());
    }
}
