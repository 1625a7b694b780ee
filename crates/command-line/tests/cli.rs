//! Runs the real `vibro`: first lines, tables compared with the library, pictures, exit codes,
//! error messages.

#[path = "common/mod.rs"]
mod command;

use command::{command, drawn, folder, number, pixels, refused, table};
use std::path::Path;
use vibro_impact::steady::{exact_orbit, multiple_scales, strong_coupling};
use vibro_studies::paper::ParameterSet;

/// Requires a valid PNG that is not blank, and an SVG with text and shapes.
fn check_picture(out: &Path, stem: &str) {
    let (width, height, pixels) = pixels(&out.join(format!("{stem}.png")));
    assert!(width >= 900 && height >= 500, "{stem}: {width} x {height}");
    let inked = pixels.chunks(3).filter(|p| *p != [255, 255, 255]).count();
    let coloured =
        pixels.chunks(3).filter(|p| p.iter().max().unwrap() - p.iter().min().unwrap() > 60).count();
    let all = pixels.len() / 3;
    assert!(inked * 100 > all && coloured * 1000 > all, "{stem}: {inked} and {coloured} of {all}");
    let svg = std::fs::read_to_string(out.join(format!("{stem}.svg"))).expect("an SVG file");
    assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"), "{stem}");
    assert!(svg.matches("<text ").count() > 10 && svg.contains("units of L") | svg.contains("(–)"), "{stem}");
    assert_eq!(svg.matches("<text ").count(), svg.matches("</text>").count(), "{stem}");
}

#[test]
fn steady_writes_the_librarys_values() {
    let out = folder("cli-steady");
    let text = drawn(&out, &["steady", "--set", "kappa=0.7", "--set", "f10=1.4"]);
    let first = text.lines().next().unwrap();
    assert!(first.starts_with("drew time histories and phase portraits as in figure 8"), "{first}");
    assert!(first.contains("steady.svg") && first.contains("steady.csv"), "{first}");
    assert!(text.contains("the default set, a reconstruction, not the paper's own data"), "{text}");
    check_picture(&out, "steady");
    let rows = table(&out, "steady.csv");
    let mut set = ParameterSet::basic();
    set.apply(&["kappa=0.7", "f10=1.4"]).unwrap();
    let p = multiple_scales::fixed_points(set.groups()).unwrap().unwrap().upper;
    for (quantity, value) in [("C", p.c), ("B", p.b), ("A1", p.a1()), ("A2", p.a2()), ("A3", p.a3)] {
        assert_eq!(number(&rows, quantity, "multiple scales", "upper"), value);
    }
    let s = strong_coupling::solve(set.groups()).unwrap().unwrap().upper;
    assert_eq!(number(&rows, "C", "strong coupling", "upper"), s.c);
    let orbit = exact_orbit::solve(set.parameters()).unwrap().upper.unwrap();
    assert_eq!(number(&rows, "impulse p", "exact orbit", "upper"), orbit.impulse());
    assert_eq!(number(&rows, "spectral radius", "exact orbit", "upper"), orbit.spectral_radius());
    assert!(text.contains("symmetry breaking") && !text.contains("SymmetryBreaking"), "{text}");
    assert!(text.lines().any(|l| l.starts_with("C [L]") && l.contains(&format!("{:.9}", p.c))), "{text}");
}

#[test]
fn steady_without_a_motion_says_so() {
    let out = folder("cli-nothing");
    let text = drawn(&out, &["steady", "--set", "f10=0.01"]);
    assert!(text.starts_with("no picture, because there is no motion with two symmetric impacts"), "{text}");
    assert!(out.join("steady.csv").exists() && !out.join("steady.png").exists());
}

#[test]
fn parameters_come_from_a_file_in_either_form() {
    let out = folder("cli-config");
    std::fs::create_dir_all(&out).unwrap();
    let file = out.join("p.toml");
    // The same system in other units: 2 kg, 8 N/m, 1 cm.
    let si = "[si]\nbox.m = 2.0\nbox.k = 8.0\nblock.m = 0.2\nsecondary.m = 0.2\nstop.gap = 0.01\n";
    std::fs::write(&file, format!("{si}[groups]\nf10 = 1.5\nsigma1 = 0.4\ngamma1 = 1.0\nalpha23 = 0.6\nsigma30 = 0.0\ngamma3 = 0.6\nkappa = 0.75\n"))
        .unwrap();
    drawn(&out, &["steady", "--config", file.to_str().unwrap()]);
    let rows = table(&out, "steady.csv");
    assert!((number(&rows, "C", "multiple scales", "upper") - 1.340127767).abs() < 1e-9);
    // p/m2 in units of L ω10 = 0.01 m · 2 rad/s.
    assert!((number(&rows, "p/m2", "exact orbit", "upper") / 0.02 - 1.597276346).abs() < 1e-8);
    std::fs::write(&file, "[groups]\nkapa = 1\n").unwrap();
    let (code, error) = refused(&["steady", "--config", file.to_str().unwrap()]);
    assert_eq!(code, 2);
    assert!(error.contains("p.toml: no parameter is named `kapa`; did you mean `kappa`?"), "{error}");
    let (code, error) = refused(&["steady", "--config", "absent.toml"]);
    assert!(code == 2 && error.contains("absent.toml: no such file"), "{code} {error}");
}

#[test]
fn errors_name_the_nearest_name_and_the_range() {
    for (arguments, expected) in [
        (
            ["--set", "sigma=1"],
            "error: no parameter is named `sigma`; did you mean `sigma1`? `sigma1`: detuning of the excitation",
        ),
        (["--set", "stop.restitution=2"], "error: stop.restitution = 2: expected 0 <= stop.restitution <= 1"),
        (["--set", "epsilon=0"], "error: epsilon = 0: expected 0 < epsilon <= 1"),
        (["--set", "kappa=high"], "error: kappa = `high` is not a number: expected 0 <= kappa <= 1"),
        (["--set", "kappa"], "error: `kappa`: expected name=value, e.g. kappa=0.75"),
    ] {
        let (code, error) = refused(&["steady", arguments[0], arguments[1]]);
        assert_eq!(code, 2, "{error}");
        assert!(error.starts_with(expected), "{error}");
    }
    for (arguments, expected) in [
        (vec!["plane", "--pair", "sigma1,f1"], "did you mean `f10`?"),
        (vec!["plane", "--pair", "f10,f10"], "two independent parameters"),
        (vec!["plane", "--pair", "f10,kappa", "--range", "kappa=0:2"], "kappa = 2: expected 0 <= kappa <= 1"),
        (
            vec!["plane", "--pair", "f10,kappa", "--range", "sigma1=0:2"],
            "a range of a parameter that is on an axis",
        ),
        (vec!["response", "--values", "gama1=0.1"], "did you mean `gamma1`?"),
        (vec!["compare", "--values", "epsilon=0.1,2"], "epsilon = 2: expected 0 < epsilon <= 1"),
        (vec!["stedy"], "steady"),
    ] {
        let (code, error) = refused(&arguments);
        assert_eq!(code, 2, "{error}");
        assert!(error.contains(expected), "{arguments:?}: {error}");
    }
}

#[test]
fn errors_of_long_studies_name_what_is_allowed() {
    for (arguments, expected) in [
        (vec!["bifurcation", "--range", "f1=0:1"], "did you mean `f10`?"),
        (vec!["bifurcation", "--shard", "3/2"], "I/N with I from 1 to N"),
        (vec!["basin", "--x", "y1=0:1"], "x1 x2 x3 v1 v2 v3"),
        (vec!["basin", "--x", "v2=0:1"], "two different initial values"),
        (vec!["lyapunov", "--threshold", "-1"], "--threshold"),
        (vec!["isoperiodic", "--pair", "alpha23,beta2"], "two independent parameters"),
        (vec!["isoperiodic", "--start", "x4=1"], "x1=0.2,v2=1 or block.s=5mm; or orbit"),
        (vec!["isoperiodic", "--start", "x2=3"], "stop"),
        (vec!["merge", "absent"], "absent: no such folder"),
    ] {
        let (code, error) = refused(&arguments);
        assert!(code == 2 && error.contains(expected), "{arguments:?}: {error}");
    }
}

#[test]
fn a_folder_that_cannot_be_is_another_exit_code() {
    let file = folder("cli-file");
    std::fs::write(&file, "in the way").unwrap();
    let output = command(&file, &["manifold", "--figure", "2"]).output().expect("vibro runs");
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("cli-file: is a file; expected a folder"));
    std::fs::remove_file(&file).unwrap();
}

#[test]
fn every_command_draws() {
    let out = folder("cli-all");
    for (command, pictures) in [
        (vec!["response"], vec!["response-frequency", "response-force"]),
        (vec!["manifold"], vec!["manifold-2", "manifold-7", "manifold-9"]),
        (vec!["stability"], vec!["stability-5", "stability-6"]),
        (vec!["plane", "--resolution", "40"], vec!["plane"]),
        (vec!["compare", "--resolution", "26"], vec!["compare-8", "compare-16", "compare-17", "compare-19"]),
    ] {
        let text = drawn(&out, &command);
        let first = text.lines().next().unwrap();
        assert!(first.starts_with("drew ") && first.contains(out.to_str().unwrap()), "{first}");
        for stem in pictures {
            assert!(text.contains(stem), "{stem}: {text}");
            check_picture(&out, stem);
        }
    }
}

#[test]
fn responses_end_where_the_library_says() {
    let out = folder("cli-response");
    drawn(&out, &["response", "--kind", "force", "--values", "sigma1=0.4"]);
    let rows = table(&out, "response-force.csv");
    let stable = rows.iter().filter(|r| r["theory"] == "multiple scales" && r["stable"] == "true");
    let values: Vec<f64> = stable.map(|r| r["value"].parse().unwrap()).collect();
    let (low, high) = values.iter().fold((f64::INFINITY, 0.0_f64), |(a, b), v| (a.min(*v), b.max(*v)));
    // The admissible forces by docs/theory.md (46), (49) and (56): 0.891 … 2.136. The last stable
    // point is the point before the located end.
    assert!((low - 0.891).abs() < 1e-3 && (2.10..=2.1356).contains(&high), "{low} {high}");
    let special = |name: &str, theory: &str| {
        let row =
            rows.iter().find(|r| r["special"] == name && r["theory"] == theory).expect("a special point");
        row["value"].parse::<f64>().unwrap()
    };
    assert!((special("symmetry breaking", "multiple scales") - 2.1355556).abs() < 1e-6);
    assert!((special("symmetry breaking", "exact orbit") - 2.04).abs() < 0.01);
}

#[test]
fn planes_do_not_depend_on_threads_and_agree_with_the_library() {
    let (one, two) = (folder("cli-plane-1"), folder("cli-plane-2"));
    let arguments = ["plane", "--pair", "sigma1,f10", "--resolution", "60", "--method"];
    for method in ["multiple-scales", "exact-orbit", "strong-coupling"] {
        for (out, threads) in [(&one, "1"), (&two, "2")] {
            drawn(out, &[&arguments[..], &[method, "--threads", threads, "--replace"]].concat());
        }
        for file in ["plane.svg", "plane.png", "plane-sigma1-f10.csv"] {
            let same = std::fs::read(one.join(file)).unwrap() == std::fs::read(two.join(file)).unwrap();
            assert!(same, "{method}, {file}");
        }
    }
    let out = folder("cli-plane-values");
    drawn(&out, &["plane", "--pair", "kappa,f10", "--resolution", "30"]);
    let rows = table(&out, "plane-kappa-f10.csv");
    assert_eq!(rows.len(), 900);
    for row in rows {
        let mut set = ParameterSet::basic();
        set.apply(&[format!("kappa={}", row["kappa"]), format!("f10={}", row["f10"])]).unwrap();
        let roots = multiple_scales::fixed_points(set.groups()).unwrap();
        let points: Vec<_> = roots.into_iter().flat_map(|r| [r.lower, r.upper]).collect();
        let expected = if points.iter().any(|p| p.admissibility.all()) {
            "stable"
        } else if points.iter().any(|p| p.admissibility.geometric) {
            "unstable"
        } else {
            "none"
        };
        assert_eq!(row["class"], expected, "{row:?}");
    }
}

#[test]
fn comparisons_find_the_papers_errors() {
    let out = folder("cli-compare");
    let text = drawn(&out, &["compare", "--figure", "17"]);
    assert!(
        text.starts_with("drew U and W for some ε and the amplitudes' errors over ε as in figure 17"),
        "{text}"
    );
    let rows = table(&out, "compare-17.csv");
    let error = |epsilon: &str, name: &str| {
        let row = rows.iter().find(|r| r["epsilon"] == epsilon && r["amplitude"] == name).expect("a row");
        row["relative_error"].parse::<f64>().unwrap().abs()
    };
    // Paper section 5: about 20 % for B and A1, at most 8 % for A2 and A3 at ε = 0.1; linear in ε.
    assert!((0.17..0.25).contains(&error("0.1", "B")) && (0.17..0.25).contains(&error("0.1", "A1")));
    assert!(error("0.1", "A2") < 0.08 && error("0.1", "A3") < 0.08);
    for name in ["B", "A1", "A2", "A3"] {
        let ratio = error("0.01", name) / error("0.005", name);
        assert!((1.9..2.1).contains(&ratio), "{name}: {ratio}");
    }
    let text = drawn(&out, &["compare", "--figure", "19"]);
    assert!(
        text.contains("the strongly coupled set, chosen for this program, not the paper's own data"),
        "{text}"
    );
    for row in table(&out, "compare-19.csv") {
        assert!(row["relative_error"].parse::<f64>().unwrap().abs() < 0.12, "{row:?}");
    }
}

/// At f10 = 2.7 the theory's motion is unstable and the simulated motion has three impacts per
/// period: both are reported, without errors.
#[test]
fn motions_of_different_kinds_are_not_compared_in_per_cent() {
    let out = folder("cli-another-motion");
    let text = drawn(&out, &["compare", "--figure", "8", "--figure", "17", "--set", "f10=2.7"]);
    assert!(text.contains("theory unstable") && text.contains("another motion"), "{text}");
    let words = text.lines().find(|l| l.contains("another motion")).unwrap();
    assert!(words.contains("not symmetric") && words.contains("has 3 impacts a period"), "{words}");
    assert!(!text.contains('%'), "{text}");
    assert!(std::fs::read_to_string(out.join("compare-8.svg")).unwrap().contains("theory unstable"));
    for file in ["compare-8.csv", "compare-17.csv"] {
        let rows = table(&out, file);
        assert!(rows.len() >= 4);
        for row in rows.iter().filter(|r| r.get("epsilon").is_none_or(|e| e == "0.1")) {
            assert!(
                row["relative_error"].is_empty() && row["not_compared"].contains("theory unstable"),
                "{row:?}"
            );
            assert!(row["simulation"].parse::<f64>().unwrap() > 0.0, "{row:?}");
        }
    }
    drawn(&out, &["compare", "--figure", "8", "--replace"]);
    for row in table(&out, "compare-8.csv") {
        assert!(row["not_compared"].is_empty() && row["relative_error"].parse::<f64>().is_ok(), "{row:?}");
    }
}

#[test]
fn help_of_the_papers_machine_lists_its_commands() {
    let text = drawn(&folder("cli-help"), &["paper", "--help"]);
    let long = ["bifurcation", "lyapunov", "basin", "isoperiodic", "reproduce"];
    for command in ["steady", "response", "manifold", "stability", "plane", "compare"].into_iter().chain(long)
    {
        assert!(text.contains(command), "{command}");
    }
    assert!(text.contains("a reconstruction"));
}
