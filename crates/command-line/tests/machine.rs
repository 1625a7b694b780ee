//! Runs the real `vibro` for 3-DOF machines with parameters other than the defaults: set values,
//! units, axes of any parameter, templates, refusals.

#[path = "common/mod.rs"]
mod command;

use command::{command, drawn, folder, number, refused, table};
use std::collections::HashMap;
use std::path::Path;
use vibro_impact::steady::{exact_orbit, multiple_scales};
use vibro_studies::paper::ParameterSet;

/// A machine as data sheets describe it: all values in the table `[si]`, all but two with a unit.
const MACHINE: &str = r#"[si]
box.m = "12 kg"
box.k = "48 kN/m"
box.c = "60 N.s/m"
block.m = "1.2 kg"
secondary.m = "1200 g"
secondary.k = "4.8 N/mm"
secondary.c = 5.0
coupling.k = "288 N/m"
stop.gap = "5 mm"
stop.restitution = 0.6
drive.amplitude = "75 N"
drive.frequency = "10.4 Hz"
"#;

/// All words of a picture on one line.
fn words(out: &Path, stem: &str) -> String {
    let svg = std::fs::read_to_string(out.join(format!("{stem}.svg"))).expect("an SVG file");
    let texts = svg.split('<').filter_map(|tag| tag.split_once('>')).map(|tag| tag.1);
    texts.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

/// Writes a parameter file into a fresh folder.
fn machine(name: &str, text: &str) -> (std::path::PathBuf, String) {
    let out = folder(name);
    std::fs::create_dir_all(&out).unwrap();
    let file = out.join("m.toml");
    std::fs::write(&file, text).unwrap();
    (out, file.to_str().unwrap().into())
}

/// The distinct values of a parameter in a response's table.
fn members(out: &Path, file: &str, name: &str) -> Vec<f64> {
    let mut found: Vec<f64> = Vec::new();
    for row in table(out, file).iter().filter(|r| r["member"] == name) {
        let value = row["member_value"].parse().unwrap();
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

#[test]
fn a_response_draws_the_machine_that_was_given() {
    let (out, file) = machine("cli-own", MACHINE);
    drawn(&out, &["response", "--config", &file]);
    // f10 = F10/(k1 L ε) = 75/(48000 · 0.005 · 0.1) = 3.125.
    let forces = members(&out, "response-frequency.csv", "f10");
    assert!(matches!(forces[..], [f10] if (f10 - 3.125).abs() < 1e-12), "{forces:?}");
    let omega10 = (48_000.0_f64 / 12.0).sqrt();
    let sigma1 = (10.4 * std::f64::consts::TAU / omega10 - 1.0) / 0.1;
    let detunings = members(&out, "response-force.csv", "sigma1");
    assert!(matches!(detunings[..], [s] if (s - sigma1).abs() < 1e-12), "{detunings:?} {sigma1}");
    let text = words(&out, "response-frequency");
    // The caption lists the machine's physical parameters, except parameters that vary along a
    // curve or from curve to curve.
    assert!(text.contains("k₁ = 48 kN/m") && text.contains("₁₀ = 3.125"), "{text}");
    assert!(!text.contains("F₁₀ =") && !text.contains("₁₀ = 2.5"), "{text}");
    // A listed value is added to the machine's own.
    drawn(&out, &["response", "--config", &file, "--kind", "frequency", "--values", "f10=1", "--replace"]);
    assert_eq!(members(&out, "response-frequency.csv", "f10").len(), 2);
}

#[test]
fn a_value_that_was_set_is_the_only_member() {
    let out = folder("cli-member");
    drawn(&out, &["response", "--kind", "force", "--set", "sigma1=0.7"]);
    assert_eq!(members(&out, "response-force.csv", "sigma1"), [0.7]);
    drawn(&out, &["response", "--kind", "frequency", "--set", "f10=3"]);
    assert_eq!(members(&out, "response-frequency.csv", "f10"), [3.0]);
    assert_eq!(members(&out, "response-frequency.csv", "gamma1"), [0.2, 0.5, 1.0, 1.5]);
    drawn(&out, &["manifold", "--figure", "9", "--set", "f10=3"]);
    assert!(table(&out, "manifold-9.csv").iter().all(|r| r["f10"] == "3"));
    drawn(&out, &["compare", "--figure", "17", "--set", "epsilon=0.05"]);
    assert!(table(&out, "compare-17.csv").iter().all(|r| r["epsilon"] == "0.05"));
    assert!(!std::fs::read_to_string(out.join("compare-17.svg")).unwrap().contains("NaN"));
}

#[test]
fn a_value_that_a_study_does_not_use_is_refused_by_name() {
    for (arguments, name) in [
        (vec!["reproduce", "--set", "sigma1=0.7"], "sigma1 = 0.7: reproduce does not use"),
        (vec!["response", "--kind", "force", "--values", "f10=1"], "values of sigma1 for the force response"),
    ] {
        let (code, error) = refused(&arguments);
        assert!(code == 2 && error.contains(name), "{arguments:?}: {error}");
    }
}

#[test]
fn second_method_stability_marks_the_machine_that_was_given() {
    for (name, text) in [
        ("cli-stability", MACHINE.to_owned()),
        ("cli-stability-template", vibro::parameter_file::template(false)),
    ] {
        let (out, file) = machine(name, &text);
        let said = drawn(&out, &["stability", "--config", &file]);
        let mut set = ParameterSet::basic();
        vibro::parameter_file::apply(&mut set, &text).unwrap();
        let g = set.groups();
        let motion = multiple_scales::fixed_points(g).unwrap().unwrap().upper;
        assert!(said.contains(&format!("this set's own force: C = {:.5}", motion.c)), "{said}");
        // xi = k1 L/F10, computed from the machine.
        let p = set.parameters();
        let xi = p.box_stiffness * p.stop_gap / p.drive_amplitude;
        assert!(said.contains(&format!("xi = {xi:.5}")), "{said}");
        for stem in ["stability-5", "stability-6"] {
            assert!(words(&out, stem).contains("this set of parameters"), "{stem}");
        }
        // The title shows the machine's own mass ratio and damping ratio c1/(2 sqrt(k1 m1)), not
        // the paper's.
        let zeta = vibro_studies::paper::short(p.box_damping / (2.0 * (p.box_stiffness * p.box_mass).sqrt()));
        assert!(words(&out, "stability-6").contains(&format!("ε = 0.1, ζ = {zeta}")), "{zeta}");
    }
    // `alpha23` changes neither the ratios nor the force: figure 6 has the paper's ε and ζ, and no
    // force is marked.
    let out = folder("cli-stability-paper");
    drawn(&out, &["stability", "--set", "alpha23=0.5"]);
    let text = words(&out, "stability-6");
    assert!(text.contains("ε = 0.05, ζ = 0.01") && !text.contains("this set of parameters"), "{text}");
}

#[test]
fn a_machine_that_is_not_complete_is_told() {
    let (out, file) = machine("cli-partial", "[si]\nbox.m = 12\nbox.k = \"48 kN/m\"\n");
    let output = command(&out, &["steady", "--config", &file]).output().unwrap();
    assert!(output.status.success());
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        error.starts_with("warning: the machine is given in SI, but not box.c = 0.1 N·s/m, block.m"),
        "{error}"
    );
    assert!(error.contains("stop.gap = 1 m") && error.contains("drive.amplitude = 0.15 N"), "{error}");
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("not given, and taken from the default set") && text.contains("stop.gap = 1 m"),
        "{text}"
    );
}

#[test]
fn a_template_is_a_parameter_file() {
    for form in ["--si", "--groups"] {
        let text = drawn(&folder("cli-template"), &["template", form]);
        let (out, file) = machine("cli-template", &text);
        drawn(&out, &["steady", "--config", &file]);
        let rows = table(&out, "steady.csv");
        // The default machine.
        assert!((number(&rows, "C", "multiple scales", "upper") - 1.340127767).abs() < 1e-9, "{form}");
    }
}

#[test]
fn axes_are_of_any_parameter_with_units() {
    let (out, file) = machine("cli-axes", MACHINE);
    // The folder already contains results of other options.
    let with = |arguments: &[&str]| drawn(&out, &[arguments, &["--config", &file, "--replace"]].concat());
    let values = |file: &str, name: &str| -> Vec<f64> {
        table(&out, file).iter().map(|r| r[name].parse().unwrap()).collect()
    };
    let hertz = std::f64::consts::TAU;
    with(&["bifurcation", "--vary", "drive.frequency=9Hz:11Hz:5", "--discard", "50", "--keep", "20"]);
    let found = values("bifurcation-points.csv", "drive.frequency");
    assert!(found[0] == 9.0 * hertz && found.contains(&(11.0 * hertz)), "{found:?}");
    let text = words(&out, "bifurcation");
    assert!(text.contains("ω₁/2π (Hz)") && text.contains("this set: ω₁/2π = 10.4 Hz"), "{text}");
    assert!(text.contains("m₂ = 1.2 kg") && !text.contains(", ω₁"), "{text}");
    assert!(text.contains("x₂ (mm)") && !text.contains("units of L"), "{text}");
    // The block's position at one value may be beyond the stops at the next value.
    with(&["bifurcation", "--vary", "L=1mm:9mm:9", "--discard", "20", "--keep", "9"]);
    assert_eq!(table(&out, "bifurcation-points.csv").len(), 2 * 9);
    with(&["plane", "--pair", "block.m,stop.gap", "--vary", "stop.gap=1mm:20mm:12", "--resolution", "10"]);
    let rows = table(&out, "plane-block.m-stop.gap.csv");
    assert_eq!(rows.len(), 120);
    assert_eq!((rows[0]["stop.gap"].as_str(), rows[119]["stop.gap"].as_str()), ("0.001", "0.02"));
    let mut own = ParameterSet::basic();
    vibro::parameter_file::apply(&mut own, MACHINE).unwrap();
    for row in &rows {
        let mut set = own.clone();
        set.apply(&[format!("block.m={} kg", row["block.m"]), format!("stop.gap={} m", row["stop.gap"])])
            .unwrap();
        let roots = multiple_scales::fixed_points(set.groups()).unwrap();
        let stable = roots.into_iter().flat_map(|r| [r.lower, r.upper]).any(|p| p.admissibility.all());
        assert_eq!(row["class"] == "stable", stable, "{row:?}");
    }
    with(&["isoperiodic", "--pair", "L,f10", "--range", "L=4mm:6mm", "--resolution", "3", "--discard", "20"]);
    assert_eq!(table(&out, "isoperiodic-stop.gap-f10.csv").len(), 9);
    let lyapunov = ["--vary", "stop.gap=4mm:6mm:3", "--discard", "20", "--keep", "9", "--periods", "220"];
    with(&[&["lyapunov"], &lyapunov[..]].concat());
    assert_eq!(values("lyapunov-spectra.csv", "stop.gap"), [0.005]);
    with(&["response", "--vary", "drive.frequency=9Hz:11.5Hz", "--values", "stop.gap=4mm,6mm"]);
    assert_eq!(members(&out, "response-drive.frequency.csv", "stop.gap"), [0.005, 0.004, 0.006]);
    assert!(out.join("response-drive.frequency.png").exists());
    // Each label has the unit in which its parameter was given: the axis from 9 to 11.5 is in Hz,
    // the gaps of the curves are in mm. Amplitudes are in the gap's unit.
    let text = words(&out, "response-drive.frequency");
    for expected in ["ω₁/2π (Hz)", "9.0 9.5 10.0 10.5 11.0 11.5", "L = 4 mm", "C·L (mm)", "A₃·L (mm)"]
    {
        assert!(text.contains(expected), "{expected}: {text}");
    }
    assert!(!text.contains("units of L"), "{text}");
}

/// Amplitudes of any coordinate, compared with the exact orbit for the same force.
#[test]
fn closed_form_a_response_is_of_any_coordinate() {
    let (out, file) = machine("cli-of", MACHINE);
    let with = |arguments: &[&str]| drawn(&out, &[arguments, &["--config", &file]].concat());
    with(&["response", "--kind", "force", "--of", "x1"]);
    let rows = table(&out, "response-force-x1.csv");
    let mut own = ParameterSet::basic();
    vibro::parameter_file::apply(&mut own, MACHINE).unwrap();
    let mut compared = 0;
    for row in rows.iter().filter(|r| r["theory"] == "exact orbit" && r["clear"] == "true").step_by(50) {
        let mut set = own.clone();
        set.apply(&[format!("f10={}", row["value"])]).unwrap();
        let orbits = exact_orbit::solve(set.parameters()).unwrap();
        let gap = set.parameters().stop_gap;
        let a1 = |o: &exact_orbit::ExactOrbit| o.amplitudes()[0] / gap;
        let number = |name: &str| row[name].parse::<f64>().unwrap();
        let orbits: Vec<_> = [orbits.upper, orbits.lower].into_iter().flatten().collect();
        assert!(orbits.iter().any(|o| (a1(o) - number("A1")).abs() < 1e-6), "{row:?}");
        // The block flies from stop to stop, so that |w| is the gap.
        assert!((number("W") - 1.0).abs() < 1e-9, "{row:?}");
        compared += 1;
    }
    assert!(compared > 3, "{compared}");
    let text = words(&out, "response-force-x1");
    assert!(text.contains("amplitude of x₁ (mm)") && !text.contains("C·L"), "{text}");
    with(&["response", "--kind", "frequency", "--of", "w"]);
    assert!(words(&out, "response-frequency-w").contains("amplitude of w (mm)"));
    let (code, error) = refused(&["response", "--of", "x4"]);
    assert!(code == 2 && error.contains("x4") && error.contains("one of x1, x2, x3, w"), "{error}");
}

/// A range is labelled in the unit in which it was given, whatever the unit of the machine's own
/// value.
#[test]
fn labels_are_in_the_unit_that_was_written() {
    let out = folder("cli-unit");
    drawn(&out, &["plane", "--pair", "stop.gap,f10", "--vary", "stop.gap=5mm:30mm:8", "--resolution", "6"]);
    let text = words(&out, "plane");
    assert!(text.contains("L (mm)") && text.contains("5 10 15 20 25 30"), "{text}");
    drawn(&out, &["plane", "--pair", "k1,f10", "--vary", "k1=1:2:8", "--resolution", "6", "--replace"]);
    assert!(words(&out, "plane").contains("k₁ (N/m)"));
    // Shards store the unit for the computer that merges them.
    let (one, two) = (folder("cli-unit-1"), folder("cli-unit-2"));
    let work = ["bifurcation", "--vary", "drive.frequency=0.15Hz:0.17Hz:20", "--discard", "9", "--keep", "9"];
    for (out, share) in [(&one, "1/2"), (&two, "2/2")] {
        drawn(out, &[&work[..], &["--shard", share]].concat());
    }
    let merged = folder("cli-unit-merged");
    drawn(&merged, &["merge", one.to_str().unwrap(), two.to_str().unwrap()]);
    assert!(words(&merged, "bifurcation").contains("ω₁/2π (Hz)"));
}

#[test]
fn the_response_along_the_frequency_is_that_along_its_detuning() {
    let (out, file) = machine("cli-along", MACHINE);
    drawn(&out, &["response", "--config", &file, "--vary", "drive.frequency=9Hz:11.5Hz"]);
    drawn(&out, &["response", "--config", &file, "--kind", "frequency"]);
    let omega10 = (48_000.0_f64 / 12.0).sqrt();
    let breaking = |file: &str, scale: &dyn Fn(f64) -> f64| -> f64 {
        let rows = table(&out, file);
        let special =
            |r: &&HashMap<String, String>| !r["special"].is_empty() && r["special"] != "end of range";
        let own = rows.iter().filter(|r| {
            ["f10", "drive.amplitude"].contains(&r["member"].as_str()) && r["theory"] == "exact orbit"
        });
        let values = own.filter(special).map(|r| scale(r["value"].parse().unwrap()));
        values.filter(|v| (9.2..11.3).contains(v)).sum()
    };
    let by_frequency = breaking("response-drive.frequency.csv", &|v| v / std::f64::consts::TAU);
    let by_detuning =
        breaking("response-frequency.csv", &|s| (1.0 + 0.1 * s) * omega10 / std::f64::consts::TAU);
    // Both locate the same special points, to the tolerance of their search.
    assert!(
        by_frequency > 0.0 && (by_frequency / by_detuning - 1.0).abs() < 1e-6,
        "{by_frequency} {by_detuning}"
    );
}

#[test]
fn bad_input_is_refused_by_name() {
    for (arguments, expected) in [
        (
            vec!["steady", "--set", "stop.gap=2kg"],
            "stop.gap: `kg` is not one of its units; expected one of m, cm, mm, um, in",
        ),
        (vec!["steady", "--set", "speed=2"], "no parameter is named `speed`; expected one of"),
        (vec!["bifurcation", "--vary", "drive.frequency=9:11Hz"], "a unit on every number or on none"),
        (vec!["bifurcation", "--vary", "drive.frequency=11Hz:9Hz"], "from < to"),
        (vec!["bifurcation", "--vary", "f10=1:2:1"], "f10: 1 values: expected 2 to 20000"),
        (vec!["plane", "--pair", "f10,drive.amplitude"], "two independent parameters"),
        (vec!["plane", "--pair", "f10,kappa", "--vary", "f10=1:2:9999999"], "expected 2 to 10000"),
        (
            vec!["lyapunov", "--vary", "stop.gap=1mm:2mm", "--at", "1kg"],
            "stop.gap: `kg` is not one of its units",
        ),
    ] {
        let (code, error) = refused(&arguments);
        assert!(code == 2 && error.contains(expected), "{arguments:?}: {error}");
    }
    let (_, file) = machine("cli-twelve", "[si]\nbox.m = twelve\n");
    let (code, error) = refused(&["steady", "--config", &file]);
    assert!(code == 2 && error.contains("line 2: box.m = `twelve` is not a number"), "{error}");
}
