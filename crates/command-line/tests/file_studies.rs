//! `vibro response FILE` and the other studies of a machine's file that use its orbits: tables
//! compared with closed forms, errors by name.

#[path = "common/mod.rs"]
mod command;

use command::{begun, command, drawn, files, folder, killed, parts, refused, table};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};
use std::path::{Path, PathBuf};

/// Rounding of an orbit's numbers, relative.
const ROUNDING: f64 = 1e-11;
/// Distance of a settled motion from its orbit, relative.
const SETTLED: f64 = 1e-8;

/// A driven box on a spring that may hit a wall.
const OSCILLATOR: &str = r#"name = "Oscillator"
[body.box]
mass = "1 kg"
[spring.mount]
between = ["ground", "box"]
stiffness = "400 N/m"
damping = "2 N s/m"
[stop.wall]
between = ["ground", "box"]
gap = "1 cm"
restitution = 0.8
[load.shaker]
on = "box"
amplitude = "2 N"
frequency = "3 Hz"
"#;

/// A part that rattles between two flanks of a shaken joint.
const RATTLE: &str = r#"name = "Rattle"
[body.part]
mass = "200 g"
start = { v = "0.2 m/s" }
[body.joint]
motion = { amplitude = "1 mm", frequency = "25 Hz" }
[stop.right]
between = ["joint", "part"]
gap = "1.5 mm"
restitution = 0.6
[stop.left]
between = ["part", "joint"]
gap = "1.5 mm"
restitution = 0.6
"#;

/// A fresh folder with a machine's file.
fn file(name: &str, text: &str) -> (PathBuf, String) {
    let out = folder(name);
    std::fs::create_dir_all(&out).unwrap();
    let file = out.join("machine.toml");
    std::fs::write(&file, text).unwrap();
    (out, file.to_str().unwrap().into())
}

fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().unwrap_or_else(|_| panic!("{column}: {:?}", row[column]))
}

/// The amplitude without impacts at a frequency, m.
fn amplitude(frequency: f64) -> f64 {
    let omega = TAU * frequency;
    2.0 / (400.0 - omega * omega).hypot(2.0 * omega)
}

#[test]
fn closed_form_a_response_is_linear_up_to_the_frequency_at_which_the_wall_is_touched() {
    let (out, file) = file("file-response", OSCILLATOR);
    let line = ["response", &file, "--vary", "load.shaker.frequency=1.5Hz:6Hz", "--of", "amplitude.box.s"];
    let said = drawn(&out.join("r"), &[&line[..], &["--seeds", "8"]].concat());
    assert!(said.contains("branch 0: 1T [no event], from EP 1.5 Hz to GR stop.wall"), "{said}");
    // An interrupted study would continue these parts.
    assert!(!out.join("r/response-paths").exists());
    let rows = table(&out.join("r"), "response.csv");
    let free: Vec<_> = rows.iter().filter(|row| row["word"].is_empty()).collect();
    assert!(free.len() > 20 && rows.len() > 2 * free.len(), "{} of {}", free.len(), rows.len());
    for row in free {
        let expected = amplitude(number(row, "load.shaker.frequency"));
        assert!((number(row, "amplitude.box.s") / expected - 1.0).abs() < ROUNDING, "{row:?}");
    }
    // The wall is touched if the amplitude is the gap of 1 cm: |k - m w² + i c w| = F/gap.
    let (b, c): (f64, f64) = (2.0 * 2.0 - 2.0 * 400.0, 400.0 * 400.0 - (2.0f64 / 0.01).powi(2));
    let roots = [-1.0, 1.0].map(|sign| (0.5 * (-b + sign * (b * b - 4.0 * c).sqrt())).sqrt() / TAU);
    let special = table(&out.join("r"), "special-points.csv");
    for root in roots {
        let touched = |row: &&HashMap<String, String>| row["label"] == "GR" && row["element"] == "stop.wall";
        let nearest = special.iter().filter(touched).map(|row| (number(row, "value") / root - 1.0).abs());
        assert!(nearest.fold(f64::INFINITY, f64::min) < ROUNDING, "{root}: {special:?}");
    }
    assert!(Path::new(&out.join("r/response.svg")).exists());
    // Unstable parts are included, with their stability.
    assert!(rows.iter().any(|row| row["stability"] == "unstable"));

    for (words, named) in [
        (&["--kind", "force"][..], "an option of the paper's machine"),
        (&["--depth", "41"], "41"),
        (&["--set", "stop.wall.restitution=2"], "stop.wall.restitution"),
    ] {
        let (_, error) = refused(&[&line, words].concat());
        assert!(error.contains(named), "{words:?}: {error}");
    }
    let (_, error) = refused(&[&line[..4], &["--of", "power.lost"]].concat());
    assert!(error.contains("is not a measure of an orbit"), "{error}");
    let (_, error) = refused(&["response", "--seeds", "3"]);
    assert!(error.contains("an option of a machine's file"), "{error}");
}

/// Maximum of the linear motion from a start at time 0, by samples, m.
fn highest([place, rate]: [f64; 2], frequency: f64) -> f64 {
    let (omega, decay) = (TAU * frequency, 1.0);
    let own = (400.0f64 - decay * decay).sqrt();
    // x = p cos w t + q sin w t + e^(-d t) (a cos + b sin), for the drive 2 sin w t.
    let (re, im) = (400.0 - omega * omega, 2.0 * omega);
    let size = re * re + im * im;
    let (p, q) = (-2.0 * im / size, 2.0 * re / size);
    let a = place - p;
    let b = (rate - q * omega + decay * a) / own;
    let at = |t: f64| {
        p * (omega * t).cos()
            + q * (omega * t).sin()
            + (-decay * t).exp() * (a * (own * t).cos() + b * (own * t).sin())
    };
    (0..40_000).map(|k| at(f64::from(k) * 2e-4)).fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn second_method_starts_whose_linear_motion_keeps_clear_of_the_wall_lead_to_the_orbit_without_impacts() {
    /// Relative distance to the gap within which samples do not show whether the wall is touched.
    const UNSURE: f64 = 1e-3;
    let (out, file) = file("file-basin", OSCILLATOR);
    let plane = ["--start", "box.s=-10mm:9.9mm:12", "--start", "box.v=-0.5:0.5:12"];
    let line = [&["basin", &file, "--set", "load.shaker.frequency=4.2Hz"][..], &plane].concat();
    let said = drawn(&out.join("b"), &line);
    assert!(said.contains("basins of 2 attractors over box.s and box.v"), "{said}");
    let attractors = table(&out.join("b"), "basin-attractors.csv");
    let quiet = attractors.iter().find(|row| row["word"].is_empty()).expect("an orbit without impacts");
    let loud = attractors.iter().find(|row| row["word"] == "impact wall").expect("one with an impact");
    assert_eq!((quiet["class"].as_str(), loud["stability"].as_str()), ("1T", "stable"));
    let shares: f64 = attractors.iter().map(|row| number(row, "share")).sum();
    assert!((shares - 1.0).abs() < ROUNDING);
    let cells = table(&out.join("b"), "basin.csv");
    let mut clear = 0;
    for cell in &cells {
        let top = highest([number(cell, "box.s"), number(cell, "box.v")], 4.2);
        if top < 0.01 * (1.0 - UNSURE) {
            clear += 1;
            assert_eq!(cell["attractor"], quiet["attractor"], "{cell:?} comes up to {top}");
        }
    }
    assert!(clear > 10 && cells.iter().any(|cell| cell["attractor"] == loud["attractor"]), "{clear}");

    // Shards are bit-identical to the whole.
    for shard in ["1/2", "2/2"] {
        drawn(&out.join(&shard[..1]), &[&line[..], &["--shard", shard]].concat());
    }
    let [one, two] = ["1", "2"].map(|name| out.join(name).to_str().unwrap().to_owned());
    drawn(&out.join("merged"), &["merge", &one, &two]);
    let bytes = |folder: &str| std::fs::read(out.join(folder).join("basin.csv")).unwrap();
    assert_eq!(bytes("merged"), bytes("b"));

    for (words, named) in [
        (&["--start", "box.s=0:1"][..], "--start: expected two ranges"),
        (&["--start", "box.s=0:1", "--start", "box.s=0:1"], "two different initial values"),
        (&["--start", "boz.s=0:1", "--start", "box.v=0:1"], "box.s"),
        (&["--start", "box.s=1:0", "--start", "box.v=0:1"], "FROM < TO"),
        (&["--start", "box.s=0:1:9999", "--start", "box.v=0:1"], "expected 1 to 5000 cells"),
        (
            &["--start", "box.s=0:1", "--start", "box.v=0:1", "--x", "x1=0:1"],
            "an option of the paper's machine",
        ),
    ] {
        let (_, error) = refused(&[&["basin", &file][..], words].concat());
        assert!(error.contains(named), "{words:?}: {error}");
    }
}

#[test]
fn closed_form_sections_of_the_rattle_at_a_flank_and_of_a_linear_motion_at_a_phase() {
    let (out, file) = file("file-section", RATTLE);
    let said = drawn(&out.join("flank"), &["section", &file, "--section", "right", "--keep", "20"]);
    assert!(said.contains("events of stop.right: 20 points") && said.contains("1 distinct"), "{said}");
    // (π V/w - d)²/4 + (r V/w)² = A² with the speed of flight V; flanks close at V (1 + r).
    let (a, d, r): (f64, f64, f64) = (1e-3, 3e-3, 0.25);
    let (square, linear, rest) = (PI * PI / 4.0 + r * r, -PI * d / 2.0, d * d / 4.0 - a * a);
    let flight = TAU * 25.0 * (-linear + (linear * linear - 4.0 * square * rest).sqrt()) / (2.0 * square);
    for row in table(&out.join("flank"), "section.csv") {
        // Settled to 1e-9 of its size.
        assert!((number(&row, "speed") / (flight * (1.0 + r)) - 1.0).abs() < SETTLED, "{row:?}");
        assert!((number(&row, "part.v") + flight).abs() < SETTLED, "{row:?} {flight}");
    }

    let (out, file) = self::file("file-section-phase", OSCILLATOR);
    let line = ["section", &file, "--set", "load.shaker.frequency=1.5Hz", "--keep", "6"];
    drawn(&out.join("phase"), &[&line[..], &["--phase", "90deg", "--of", "box.v,wall.e"]].concat());
    let omega = TAU * 1.5;
    let (re, im) = (400.0 - omega * omega, 2.0 * omega);
    for row in table(&out.join("phase"), "section.csv") {
        // q sin + p cos at a quarter of the period.
        let expected = 2.0 * re / (re * re + im * im);
        assert!((number(&row, "box.s") / expected - 1.0).abs() < SETTLED, "{row:?} {expected}");
        assert!((number(&row, "phase") - 0.5 * PI).abs() < SETTLED && row["speed"].is_empty());
    }
    for (words, named) in [
        (
            &["--section", "wall", "--phase", "1"][..],
            "phase 1: cannot be combined with a section of an element's events",
        ),
        (&["--section", "wal"], "no stop, contact or friction has this name"),
        (&["--of", "box.s"], "two names separated by a comma"),
        (&["--of", "box.s,speed"], "expected one of time, phase, box.s"),
        (&["--phase", "1m"], "expected a finite angle"),
        (&["--config", "a.toml"], "does not use this option"),
    ] {
        let (_, error) = refused(&[&["section", &file][..], words].concat());
        assert!(error.contains(named), "{words:?}: {error}");
    }
}

#[test]
fn second_method_a_spectrum_has_the_multipliers_of_the_orbit() {
    /// Errors of multipliers are proportional to the distance from the orbit, 1e-9 of its size.
    const BESIDE: f64 = 1e-8;
    let (out, file) = file("file-spectrum", RATTLE);
    let said = drawn(&out.join("all"), &["lyapunov", &file, "--spectrum", "--periods", "20"]);
    assert!(said.contains("spectrum of 2 Lyapunov exponents"), "{said}");
    assert!(said.contains("by the multipliers of the periodic orbit (period in returns: 1)"), "{said}");
    drawn(&out.join("orbit"), &["orbit", &file]);
    let multipliers = table(&out.join("orbit"), "orbit-multipliers.csv");
    let exponents = table(&out.join("all"), "lyapunov.csv");
    for (multiplier, exponent) in multipliers.iter().zip(&exponents) {
        let expected = number(multiplier, "modulus").ln() / 0.04;
        assert!((number(exponent, "exponent") / expected - 1.0).abs() < BESIDE, "{exponent:?} {expected}");
    }
    assert_eq!((multipliers.len(), exponents.len()), (2, 2));
    let (_, error) = refused(&["lyapunov", &file, "--spectrum", "--vary", "stop.left.gap=1mm:2mm"]);
    assert!(error.contains("'--spectrum' cannot be used with '--vary"), "{error}");
    let (_, error) = refused(&["lyapunov", "--spectrum"]);
    assert!(error.contains("an option of a machine's file"), "{error}");
}

#[test]
fn closed_form_the_gradient_of_the_rattles_closing_speed() {
    /// Differences of fourth order, relative.
    const DIFFERENCES: f64 = 1e-9;
    let (out, file) = file("file-gradient", RATTLE);
    let said = drawn(&out.join("g"), &["orbit", &file, "--gradient", "impact.speed.right"]);
    assert!(
        said.contains("largest changes for a 1 % larger parameter: body.joint.motion.frequency 1 %"),
        "{said}"
    );
    // F(V, d, r) = (π V/w - d)²/4 + (r V/w)² - A² = 0, and the flanks close at V (1 + r).
    let (a, d, epsilon, omega): (f64, f64, f64, f64) = (1e-3, 3e-3, 0.6, TAU * 25.0);
    let r = (1.0 - epsilon) / (1.0 + epsilon);
    let (square, linear, rest) = (PI * PI / 4.0 + r * r, -PI * d / 2.0, d * d / 4.0 - a * a);
    let flight = omega * (-linear + (linear * linear - 4.0 * square * rest).sqrt()) / (2.0 * square);
    let by_speed = (PI * flight / omega - d) * PI / (2.0 * omega) + 2.0 * r * r * flight / (omega * omega);
    let by_amplitude = (1.0 + r) * 2.0 * a / by_speed;
    let by_gap = (1.0 + r) * 0.5 * (PI * flight / omega - d) / by_speed;
    let by_r = flight - (1.0 + r) * 2.0 * r * flight * flight / (omega * omega) / by_speed;
    let by_restitution = -by_r * 2.0 / (1.0 + epsilon).powi(2);
    let rows = table(&out.join("g"), "gradient.csv");
    let found = |name: &str| {
        let row = rows.iter().find(|row| row["parameter"] == name).expect("a parameter");
        number(row, "d impact.speed.right")
    };
    for (own, expected) in [
        (found("body.joint.motion.amplitude"), by_amplitude),
        (found("stop.right.gap"), by_gap),
        (found("stop.left.gap"), by_gap),
        (found("stop.right.restitution") + found("stop.left.restitution"), by_restitution),
        (found("body.joint.motion.frequency"), flight * (1.0 + r) / 25.0),
    ] {
        assert!((own / expected - 1.0).abs() < DIFFERENCES, "{own} {expected}");
    }
    // Neither the phase nor the mass nor a slow drift of both moves the closing speed.
    for name in ["body.joint.motion.phase", "body.part.mass", "body.joint.motion.rate"] {
        assert!(found(name).abs() < DIFFERENCES, "{name}: {}", found(name));
    }
    assert!(rows.iter().all(|row| !row["parameter"].contains(".start.")));
    let (_, error) = refused(&["orbit", &file, "--gradient", "class"]);
    assert!(error.contains("is not a measure of an orbit"), "{error}");
}

#[test]
fn invariant_the_force_of_a_rigid_stop_has_no_derivatives_and_a_period_lost_in_rounding_is_refused() {
    let (out, file) = file("file-nothing", RATTLE);
    let said = drawn(&out.join("g"), &["orbit", &file, "--gradient", "amplitude.right.f"]);
    assert!(said.contains("amplitude.right.f = 0 N: relative changes are not available"), "{said}");
    let (_, error) = refused(&["orbit", &file, "--start", "time=1e18"]);
    assert!(error.contains("at t = 1000000000000000000 s") && error.contains("lost in rounding"), "{error}");
}

#[test]
fn closed_form_an_unstable_orbit_is_found_by_its_word_and_words_that_cannot_close_are_refused() {
    let (out, file) = file("file-word", OSCILLATOR);
    // At 3 Hz the motion settles on 2T; the orbit with one impact per period is unstable.
    let line = ["orbit", &file, "--word", "impact wall", "--period", "1T"];
    let said = drawn(&out.join("o"), &line);
    assert!(said.contains("1 period of the drive") && said.contains("unstable"), "{said}");
    let events = table(&out.join("o"), "orbit-events.csv");
    // Between impacts x = R sin(w t + th) + e^(-d t) (a cos + b sin), with x = g at both and
    // v(0) = -ε v(T): b = κ a, R sin th = g - a and R cos th = -a L/(w (1 + ε)).
    let (omega, d, g, epsilon): (f64, f64, f64, f64) = (TAU * 3.0, 1.0, 0.01, 0.8);
    let (own, period) = ((400.0f64 - d * d).sqrt(), 1.0 / 3.0);
    let (e, c, s) = ((-d * period).exp(), (own * period).cos(), (own * period).sin());
    let kappa = (1.0 - e * c) / (e * s);
    let end = e * (-d * (c + kappa * s) + own * (-s + kappa * c));
    let l = (-d + own * kappa) + epsilon * end;
    let square = 1.0 + (l / (omega * (1.0 + epsilon))).powi(2);
    let r = amplitude(3.0);
    let root = (g * g - square * (g * g - r * r)).sqrt();
    let speeds = [-1.0, 1.0].map(|sign| {
        let a = (g + sign * root) / square;
        a * end - a * l / (1.0 + epsilon)
    });
    let speed = number(&events[0], "value");
    assert!(speeds.iter().any(|own| (speed / own - 1.0).abs() < ROUNDING), "{speed} {speeds:?}");

    for (words, named) in [
        (
            &["--word", "impact wall, impact wall", "--period", "1T", "--starts", "2"][..],
            "orbits found: 2T [impact wall]",
        ),
        (&["--word", "press wall"], "is called `wall`; such elements: none in this machine"),
        (&["--word", "open wall, impact wall"], "the word cannot repeat: open wall requires close wall"),
        (
            &["--word", "close wall, close wall, open wall"],
            "close wall requires open wall before the next one",
        ),
        (&["--word", "hit wall"], "`hit` is not a kind of event"),
        (&["--word", "wall"], "`wall` is not an event"),
        (&["--period", "0.1s"], "a multiple of the drive's period"),
        (&["--period", "33T"], "--period 33T: expected 1T to 32T"),
        (&["--period", "2m"], "--period 2m: expected 1T to 32T, or a finite time > 0"),
        (&["--load", "box=1N"], "an option of the paper's machine"),
    ] {
        let (_, error) = refused(&[&["orbit", &file][..], words].concat());
        assert!(error.contains(named), "{words:?}: {error}");
    }
    let (_, error) = refused(&["orbit", "--period", "40"]);
    assert!(error.contains("--period 40: expected a whole number from 1 to 32"), "{error}");
}

#[test]
fn closed_form_branches_over_a_diagram_and_the_rows_they_explain() {
    let (out, file) = file("file-diagram", OSCILLATOR);
    let vary = "load.shaker.frequency=3.4Hz:6Hz:14";
    let line = ["bifurcation", &file, "--vary", vary, "--orbits", "--keep", "20"];
    let said = drawn(&out.join("d"), &line);
    assert!(said.contains("28 of 28 periodic rows of both directions lie on a stable branch"), "{said}");
    let rows = table(&out.join("d"), "bifurcation-orbits-rows.csv");
    assert!(rows.len() == 28 && rows.iter().all(|row| row["not_covered"].is_empty()));
    // Below the touch at 3.879 Hz the wall is hit, above the fold at 5.002 Hz it is not. In
    // between, both are possible, and with rising frequency the wall is hit.
    for row in &rows {
        let (value, hits) = (number(row, "load.shaker.frequency"), row["word"] == "impact wall");
        let rising = row["direction"] == "rising";
        assert!(hits || row["word"].is_empty(), "{row:?}");
        assert!(
            if value < 3.879 || (rising && value < 5.002) { hits } else { !hits || value < 5.002 },
            "{row:?}"
        );
    }
    assert!(rows.iter().filter(|row| row["word"].is_empty()).count() > 10);
    let curves = table(&out.join("d"), "bifurcation-orbits.csv");
    let free: Vec<_> = curves.iter().filter(|row| number(row, "load.shaker.frequency") > 5.1).collect();
    assert!(free.len() > 5);
    for row in free {
        let expected = amplitude(number(row, "load.shaker.frequency"));
        // Maxima are printed with seven digits.
        assert!((number(row, "box.s_maxima") / expected - 1.0).abs() < 1e-6, "{row:?} {expected}");
    }
    for words in [&["--at-section"][..], &["--pair", "stop.wall.gap,stop.wall.restitution"]] {
        let (_, error) = refused(&[&line[..], words].concat());
        assert!(error.contains("'--orbits' cannot be used with"), "{error}");
    }
    // Killed while branches are followed: diagram and branches continue to the same bytes.
    let (broken, study) = (out.join("k"), "bifurcation");
    // The diagram's parts: one in each direction.
    let count = 2;
    killed(begun(&broken, &[&line[..], &["--threads", "1"]].concat(), study, count + 2));
    let kept = parts(&broken, study).len();
    let other = command(&broken, &[&line[..], &["--discard", "7"]].concat()).output().expect("vibro runs");
    let refusal = String::from_utf8_lossy(&other.stderr).into_owned();
    let words = format!("holds all {count} finished parts and {} of branches", kept - count);
    assert!(kept > count && refusal.contains(&words), "{refusal}");
    drawn(&broken, &line);
    assert!(parts(&broken, study).is_empty());
    let tables = |out: &Path| {
        let mut all = files(out);
        all.retain(|name, _| name.ends_with(".csv") || name.ends_with(".svg"));
        all
    };
    assert!(tables(&broken) == tables(&out.join("d")) && tables(&broken).len() >= 6);
}
