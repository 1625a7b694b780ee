//! Runs the real `vibro` with a machine's file: the summary of a machine, the files of a motion,
//! and errors.

#[path = "common/mod.rs"]
mod command;

use command::{command, drawn, folder, pixels, refused, table};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use vibro_figures::chart::Shape;
use vibro_machine::{Assembly, Motion, Start};

fn example(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/assembly")).join(name)
}

/// A file outside the folder of the output.
fn file(name: &str, text: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    std::fs::write(&path, text).expect("a file");
    path
}

fn machine(name: &str) -> String {
    example(name).display().to_string()
}

#[test]
fn check_tells_bodies_elements_equilibrium_and_frequencies() {
    let text = drawn(&folder("assembly-check"), &["check", &machine("damper_with_buffer.toml")]);
    for words in [
        "3 bodies, 2 springs, 2 stops, 1 friction, 1 load; 3 degrees of freedom",
        "box: 12 kg; s = -0.00293278 m",
        "stop.steel: rigid, open",
        "stop.buffer: compliant, pressed; e = 0.00600172 m, f = 3.4335 N",
        "friction.guide: sticks",
        "equilibrium under the loads at time 0: box = -0.00293278 m",
        "9.03537 Hz, damping ratio 0.0338977",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

/// An acceleration a sin(ωt + φ) from v = 0 has the mean speed a cos φ/ω; with the opposite
/// initial v, the mean speed is 0.
#[test]
fn check_says_with_what_mean_speed_a_prescribed_acceleration_drifts() {
    let text = "name = \"D\"\n[body.table]\nmotion = { acceleration = { amplitude = \"20 m/s2\", frequency = \"25 Hz\" } }\n\
                [body.a]\nmass = 2.0\n[spring.k]\nbetween = [\"table\", \"a\"]\nstiffness = 800.0\n";
    let path = file("assembly-drift.toml", text).display().to_string();
    let said = drawn(&folder("assembly-drift"), &["check", &path]);
    let words = "table drifts: its mean speed over the first period of 0.04 s is 0.127324 m/s; start with v = -0.127324 m/s for a mean speed of 0";
    assert!(said.contains(words) && said.contains("table: prescribed by its acceleration"), "{said}");
    let kept = ["check", &path, "--set", "body.table.motion.v=-0.12732395447351627"];
    let said = drawn(&folder("assembly-drift"), &kept);
    assert!(!said.contains("drifts"), "{said}");
}

#[test]
fn closed_form_frequencies_of_the_start() {
    let text = "name = \"M\"\n[body.a]\nmass = 2.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = \"800 N/m\"\ndamping = \"8 N s/m\"\n";
    let path = file("assembly-oscillator.toml", text).display().to_string();
    let text = drawn(&folder("assembly-frequencies"), &["check", &path]);
    // ω = 20, f = 3.1831 Hz, D = 8/(2 √(800·2)) = 0.1.
    assert!(
        text.contains("3.1831 Hz, damping ratio 0.1\n") || text.ends_with("3.1831 Hz, damping ratio 0.1\n"),
        "{text}"
    );
    let text = drawn(&folder("assembly-frequencies"), &["check", &path, "--set", "body.a.mass=8kg"]);
    assert!(text.contains("1.59155 Hz, damping ratio 0.05"), "{text}");
}

#[test]
fn golden_files_of_a_motion_are_the_librarys_numbers() {
    let out = folder("assembly-run");
    let text =
        drawn(&out, &["run", &machine("damper_with_buffer.toml"), "--until", "500ms", "--samples", "50"]);
    assert!(
        text.contains("simulated DamperWithBuffer up to 0.5 s") && text.contains("× impact stop.steel"),
        "{text}"
    );
    let description = vibro_machine::file::read(&example("damper_with_buffer.toml")).unwrap();
    let mut motion = Motion::new(Arc::new(Assembly::new(description).unwrap())).unwrap();
    let mut events = Vec::new();
    let rows = table(&out, "states.csv");
    assert_eq!(rows.len(), 51);
    let same = |cell: &str, value: f64| cell.parse::<f64>().unwrap().to_bits() == (value + 0.0).to_bits();
    for (k, row) in rows.iter().enumerate() {
        let time = if k == 50 { 0.5 } else { 0.5 * k as f64 / 50.0 };
        motion.advance_observed(time, &mut |event| events.push(event.clone())).unwrap();
        assert!(same(&row["time"], time), "{row:?}");
        for (names, values) in [
            (["block.s", "block.v", "block.a"], motion.body(1)),
            (["mount.e", "mount.rate", "mount.f"], motion.spring(0)),
            (["buffer.e", "buffer.rate", "buffer.f"], motion.stop(1)),
            (["guide.e", "guide.rate", "guide.f"], motion.friction(0)),
        ] {
            for (name, value) in names.iter().zip(values) {
                assert!(same(&row[*name], value), "{k} {name} {} {value}", row[*name]);
            }
        }
        assert!(same(&row["shaker.f"], motion.load(0)));
    }
    let told = table(&out, "events.csv");
    assert_eq!(told.len(), events.len());
    assert!(told.iter().zip(&events).all(|(row, event)| same(&row["time"], event.time)));
    let impact = told.iter().find(|row| row["kind"] == "impact").expect("an impact");
    assert!(
        impact["element"] == "stop.steel"
            && impact["stops"] == "1"
            && impact["value"].parse::<f64>().unwrap() > 0.0
    );
    let account = std::fs::read_to_string(out.join("account.txt")).unwrap();
    assert!(text.ends_with(&account) && account.contains("balance off by"), "{account}");
    let (width, height, _) = pixels(&out.join("motion.png"));
    assert!(width > 900 && height > 900);
    // The caption is a file, which the manifest names.
    let manifest = std::fs::read_to_string(out.join("run.manifest.toml")).unwrap();
    assert!(manifest.contains("\ncaption = \"motion.caption.txt\"\n"), "{manifest}");
    let caption = std::fs::read_to_string(out.join("motion.caption.txt")).unwrap();
    let lines: Vec<&str> = caption.lines().filter(|line| !line.is_empty()).collect();
    assert!(
        account.lines().all(|line| lines.contains(&line)) && lines[0] == "Damper with buffer",
        "{caption}"
    );
    let made = format!("Made by vibro {}: vibro run ", env!("CARGO_PKG_VERSION"));
    assert!(lines[lines.len() - 1].starts_with(&made), "{caption}");
    // The same run overwrites its result, also with another width; another machine is refused.
    let again = ["run", &machine("damper_with_buffer.toml"), "--until", "0.5", "--samples", "50"];
    drawn(&out, &[&again[..], &["--width", "84mm"]].concat());
    let svg = std::fs::read_to_string(out.join("motion.svg")).unwrap();
    assert!(svg.starts_with("<svg width=\"84mm\" ") && pixels(&out.join("motion.png")).0 == 1984, "{svg}");
    for (width, problem) in [("8mm", "expected a length from 50mm to 400mm"), ("84", "e.g. 84mm")] {
        let (code, error) = refused(&[&again[..], &["--width", width]].concat());
        assert!(code == 2 && error.contains("--width") && error.contains(problem), "{error}");
    }
    let arguments = [
        "run",
        &machine("damper_with_buffer.toml"),
        "--until",
        "0.5",
        "--samples",
        "50",
        "--set",
        "body.box.mass=13",
    ];
    let other = command(&out, &arguments).output().unwrap();
    let error = String::from_utf8(other.stderr).unwrap();
    // The error names only the difference.
    let words = "of another run; they differ in\n    body.box.mass: 12 there, 13 here\n  use another --out";
    assert!(other.status.code() == Some(2) && error.contains(words), "{error}");
}

/// Ten samples fall on no contact with the buffer; a contact lasts a millisecond.
#[test]
fn second_method_contacts_and_their_peaks_do_not_depend_on_the_samples() {
    let run = |samples| {
        let description = vibro_machine::file::read(&example("damper_with_buffer.toml")).unwrap();
        let times = vibro::machine::even_times((0.0, 1.0), samples).unwrap();
        vibro::machine::record(description, &Start::default(), &times, &Arc::default(), &mut |_| ()).unwrap()
    };
    let (few, many) = (run(10), run(20_000));
    let column = many.columns.iter().position(|c| c == "buffer.f").unwrap();
    let sampled = many.rows.iter().map(|row| row[1 + column]).fold(0.0, f64::max);
    let drawn = vibro::machine::figure(&few, Vec::new()).unwrap();
    let panel = drawn.panels.iter().find(|p| p.y.label == "force, N").unwrap();
    let Shape::Lines { pieces, .. } = &panel.layers[0].shape else { panic!("no curve") };
    let top = pieces.iter().flatten().map(|point| point.1).fold(0.0, f64::max);
    // 20,000 samples miss a half-sine of 1.3 ms by up to 0.2 %, and never exceed it.
    assert!(top >= sampled && top < 1.003 * sampled, "{top} {sampled}");
    for contact in few.followed.contacts.all().iter().filter(|c| c.element(&few.assembly) == "stop.buffer") {
        let (peak, end) = (contact.peak.unwrap(), contact.end.unwrap_or(1.0));
        let within = |point: &&(f64, f64)| (contact.begin - 1e-3..=end + 1e-3).contains(&point.0);
        let highest = pieces.iter().flatten().filter(within).map(|p| p.1).fold(0.0, f64::max);
        assert!(highest >= peak * (1.0 - 1e-9), "{highest} {contact:?}");
    }
    assert!(drawn.panels.iter().any(|p| p.y.label == "closing speed of steel, m/s"));
}

#[test]
fn invariant_the_file_of_contacts_has_the_accounts_losses_and_no_end_where_one_lasts() {
    let text = "name = \"Ball\"\ngravity = 10.0\n[body.ball]\nmass = 0.5\ngravity = 1.0\n[stop.floor]\n\
        between = [\"ground\", \"ball\"]\ngap = 0.2\nrestitution = 0.5\n";
    let path = file("assembly-ball.toml", text).display().to_string();
    let out = folder("assembly-contacts");
    let told = drawn(&out, &["run", &path, "--until", "2", "--samples", "2"]);
    assert!(told.contains("contacts, largest force 5 N, largest impulse 1.5 N·s"), "{told}");
    // The ball falls by 0.2 m, so that the largest |v| is the |v| at the first impact.
    assert!(told.contains("ball: largest |s| 0.2 m, largest |v| 2 m/s"), "{told}");
    let rows = table(&out, "contacts.csv");
    let number =
        |row: &std::collections::HashMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
    let (last, bounces) = rows.split_last().unwrap();
    assert!(last["end"].is_empty() && (number(last, "peak_force") - 5.0).abs() < 1e-12, "{last:?}");
    for bounce in bounces {
        assert!(bounce["begin"] == bounce["end"] && bounce["peak_force"].is_empty(), "{bounce:?}");
        assert!(bounce["element"] == "stop.floor" && number(bounce, "closing_speed") > 0.0, "{bounce:?}");
    }
    let lost: f64 = rows.iter().map(|row| number(row, "energy_lost")).sum();
    // Bounces below 1e-9 of the first bounce are ended at once.
    assert!((lost - 1.0).abs() < 1e-8, "{lost}");
}

/// Relative rounding of a sum of losses.
const LOSSES: f64 = 1e-12;

/// The losses of contacts with friction, with and without residual flexibility, add up to the
/// engine's account; the picture shows both forces, and `account.txt` counts the contacts.
#[test]
fn invariant_losses_of_contacts_with_friction_are_those_of_the_account() {
    let residual = std::fs::read_to_string(example("blade_tip.toml")).unwrap();
    let modes = residual.lines().filter(|line| !line.starts_with("residual")).collect::<Vec<_>>().join("\n");
    for (text, count) in [(residual, 9), (modes, 9)] {
        let path = file("assembly-rub.toml", &text);
        let times = vibro::machine::even_times((0.0, 0.12), 100).unwrap();
        let read = vibro_machine::file::read(&path).unwrap();
        let record =
            vibro::machine::record(read, &Start::default(), &times, &Arc::default(), &mut |_| ()).unwrap();
        let all = record.followed.contacts.all();
        let lost: f64 = all.iter().filter_map(|contact| contact.lost).sum();
        let account: f64 = record.motion.energy().branches.iter().map(|own| own.value()).sum();
        assert!(all.len() == count && account > 1e-3, "{} {account}", all.len());
        assert!((lost / account - 1.0).abs() < LOSSES, "{lost} {account}");
        let picture = vibro::machine::figure(&record, Vec::new()).unwrap();
        let panel = picture.panels.iter().find(|panel| panel.y.label == "force, N").unwrap();
        let names: Vec<&str> = panel.layers.iter().filter_map(|layer| layer.name.as_deref()).collect();
        assert_eq!(names, ["casing", "casing, tangential"]);
        let out = folder("assembly-rub");
        let path = path.display().to_string();
        let told = drawn(&out, &["run", &path, "--until", "0.12", "--samples", "100"]);
        assert!(told.contains(&format!("contact.casing: {count} contacts, largest force ")), "{told}");
    }
}

#[test]
fn times_from_a_file_are_the_rows() {
    let times = file("assembly-times.txt", "# s\n0\n\n0.1\n0.1\n0.30000000000000004\n").display().to_string();
    let out = folder("assembly-times");
    drawn(&out, &["run", &machine("bouncing_ball.toml"), "--times", &times]);
    let rows = table(&out, "states.csv");
    assert_eq!(
        rows.iter().map(|r| r["time"].as_str()).collect::<Vec<_>>(),
        ["0", "0.1", "0.1", "0.30000000000000004"]
    );
    // The motion continues to the end given by `--until`.
    let out = folder("assembly-times-until");
    drawn(&out, &["run", &machine("bouncing_ball.toml"), "--times", &times, "--until", "0.4"]);
    assert_eq!(table(&out, "states.csv").last().map(|row| row["time"].as_str()), Some("0.4"));
    let early = ["run", &machine("bouncing_ball.toml"), "--times", &times, "--until", "0.2"];
    let (code, error) = refused(&early);
    assert!(code == 2 && error.contains("times must not be after --until, 0.2 s"), "{error}");
    let times = file("assembly-falling.txt", "0\n2\n1\n").display().to_string();
    let (code, error) = refused(&["run", &machine("bouncing_ball.toml"), "--times", &times]);
    assert!(code == 2 && error.contains("line 3: 1: expected a time in s, not before 2.0"), "{error}");
}

#[test]
fn bad_files_and_parameters_are_refused_by_line_and_name() {
    let text = "name = \"M\"\n[body.box]\nmass = \"12 kg\"\n[spring.mount]\nbetween = [\"ground\", \"boks\"]\nstiffness = \"5 mN\"\n";
    let path = file("assembly-bad.toml", text).display().to_string();
    for command in [vec!["check", &path], vec!["run", &path, "--until", "1"]] {
        let (code, error) = refused(&command);
        assert!(code == 2, "{error}");
        for words in [
            "assembly-bad.toml:5: spring.mount.between[1] = \"boks\": no body has this name; did you mean `box`",
            "assembly-bad.toml:6: spring.mount.stiffness = \"5 mN\": cannot be in `mN`; expected one of N/m",
        ] {
            assert!(error.contains(words), "{words}: {error}");
        }
    }
    let ball = machine("bouncing_ball.toml");
    for (set, words) in [
        ("stop.flor.restitution=0.5", "did you mean `stop.floor.restitution`"),
        ("stop.floor.restitution=1.5", "stop.floor.restitution = \"1.5\": expected a number from 0 to 1"),
        ("stop.floor.restitution", "NAME=VALUE"),
    ] {
        let (code, error) = refused(&["check", &ball, "--set", set]);
        assert!(code == 2 && error.contains(words), "{error}");
    }
    let parameters = file("assembly-parameters.toml", "[groups]\nkappa = 0.6\n").display().to_string();
    for (arguments, words) in [
        // The error about the kind of file comes before errors of the command.
        (vec!["run", &parameters], "is a parameter file of the paper's machine"),
        (vec!["run", &ball], "--until"),
        (vec!["run", &ball, "--until", "2 Hz"], "expected a finite time > 0"),
        (vec!["run", "nowhere.toml", "--until", "2"], "nowhere.toml: no such file"),
    ] {
        let (code, error) = refused(&arguments);
        assert!(code == 2 && error.contains(words), "{error}");
    }
}

/// Standard output and error of a run that must succeed.
fn both(out: &Path, arguments: &[&str]) -> (String, String) {
    let run = command(out, arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let (told, noted) = (text(run.stdout), text(run.stderr));
    assert!(run.status.success(), "{noted}");
    (told, noted)
}

/// The file has `gap = "4 mm"`, so that 3 means 3 mm, for every position of the option.
#[test]
fn second_method_a_bare_number_is_in_the_files_unit_and_said() {
    let (damper, out) = (machine("damper_with_buffer.toml"), folder("assembly-bare"));
    let with_unit = drawn(&out, &["check", &damper, "--set", "stop.steel.gap=3mm"]);
    for arguments in [
        &["check", &damper, "--set", "stop.steel.gap=3"][..],
        &["--set", "stop.steel.gap=3", "check", &damper],
    ] {
        let (told, noted) = both(&out, arguments);
        assert_eq!(told, with_unit);
        let words = "note: stop.steel.gap=3 is read in mm, the unit in which that parameter was written\n";
        assert_eq!(noted, words);
    }
    // An axis in the file's unit, and a list in the unit of `--set`.
    let sweep = |vary: &str, set: &str| {
        let set = ["--set", set];
        let rest = ["--discard", "2", "--periods", "4", "--output", "amplitude.box.s", "--replace"];
        let (_, noted) = both(&out, &[&["sweep", &damper, "--vary", vary][..], &set, &rest].concat());
        let rows = table(&out, "sweep.csv");
        (rows.iter().map(|row| row["stop.steel.gap"].clone()).collect::<Vec<_>>(), noted)
    };
    let (values, noted) = sweep("stop.steel.gap=3:5:3", "body.box.mass=12kg");
    assert_eq!(values, ["0.003", "0.004", "0.005"]);
    assert!(noted.contains("stop.steel.gap=3:5:3 is read in mm"), "{noted}");
    let (values, noted) = sweep("stop.steel.gap=0.003,0.005", "stop.steel.gap=0.004m");
    assert!(values == ["0.003", "0.005"] && noted.is_empty(), "{values:?} {noted}");
}

/// A record of 3,000 knots on a body without a stop causes no other events.
#[test]
fn knots_are_counted_and_listed_where_they_are_asked_for() {
    let knots: String = (1..=3000).map(|k| format!("{},{}\n", f64::from(k) / 1000.0, k % 2)).collect();
    file("assembly-knots.csv", &knots);
    let text = "name = \"Knots\"\n[body.a]\nmass = 1.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 100.0\n\
        [load.f]\non = \"a\"\ntable = \"assembly-knots.csv\"\n";
    let path = file("assembly-knots.toml", text).display().to_string();
    let out = folder("assembly-knots");
    let run = ["run", &path, "--until", "3", "--samples", "10"];
    let told = drawn(&out, &run);
    assert!(told.contains("; not in events.csv: 3000 × knot (--knots lists them)"), "{told}");
    assert!(table(&out, "events.csv").is_empty());
    let told = drawn(&out, &[&run[..], &["--knots", "--replace"]].concat());
    assert!(told.contains("events: 3000 (3000 × knot)\n"), "{told}");
    assert_eq!(table(&out, "events.csv").len(), 3000);
}

#[test]
fn a_jam_ends_the_run_by_name_and_what_was_computed_is_written() {
    let text = "name = \"Jam\"\n[body.press]\nmotion = { rate = \"1 m/s\" }\n[body.block]\nmass = \"1 kg\"\n\
        [stop.front]\nbetween = [\"block\", \"press\"]\ngap = \"0.2 m\"\nrestitution = 0.5\n\
        [stop.wall]\nbetween = [\"ground\", \"block\"]\ngap = \"0.1 m\"\nrestitution = 0.0\n";
    let path = file("assembly-jam.toml", text).display().to_string();
    let out = folder("assembly-jam");
    let run = command(&out, &["run", &path, "--until", "1", "--samples", "100"]).output().unwrap();
    let error = String::from_utf8(run.stderr).unwrap();
    assert!(run.status.code() == Some(1), "{error}");
    assert!(
        error.contains("jammed at t = 0.3") && error.contains("stop.front") && error.contains("stop.wall"),
        "{error}"
    );
    let rows = table(&out, "states.csv");
    assert!(rows.len() > 20 && rows.len() < 50, "{}", rows.len());
    assert!(std::fs::read_to_string(out.join("account.txt")).unwrap().contains("ended early: jammed"));
}

#[test]
fn numbers_beyond_doubles_end_the_run_by_name_and_what_was_computed_is_written() {
    let text = "name = \"Beyond\"\n[body.a]\nmass = 1.0\n[load.push]\non = \"a\"\nsteps = [[0.25, 1e300]]\n";
    let path = file("assembly-beyond.toml", text).display().to_string();
    let out = folder("assembly-beyond");
    let run = command(&out, &["run", &path, "--until", "1", "--samples", "4"]).output().unwrap();
    let error = String::from_utf8(run.stderr).unwrap();
    assert!(run.status.code() == Some(1) && error.contains("body.a"), "{error}");
    assert!(error.contains("its size must be at most 1e100"), "{error}");
    let rows = table(&out, "states.csv");
    assert_eq!(rows.len(), 2, "{rows:?}");
    let account = std::fs::read_to_string(out.join("account.txt")).unwrap();
    assert!(
        account.contains("ended early") && !account.contains("NaN") && !account.contains("inf"),
        "{account}"
    );
}

#[test]
fn derivatives_are_the_librarys_and_name_what_has_none() {
    let out = folder("assembly-derivatives");
    let text = "name = \"D\"\ngravity = 10.0\n[body.ball]\nmass = 1.0\ngravity = 1.0\n\
                [stop.floor]\nbetween = [\"ground\", \"ball\"]\ngap = 5.0\nrestitution = 0.5\n\
                [body.sled]\nmass = 1.0\n[friction.f]\nbetween = [\"ground\", \"sled\"]\nforce = 0.0\n";
    let path = file("assembly-derivatives.toml", text).display().to_string();
    let names = "stop.floor.gap,friction.f.force";
    let said = drawn(&out, &["run", &path, "--until", "1.5", "--samples", "3", "--derivatives", names]);
    assert!(
        said.contains("by friction.f.force: no derivative from t = 0 s on: friction.f is at its"),
        "{said}"
    );
    let rows = table(&out, "derivatives.csv");
    assert_eq!(rows.len(), 4);
    let of = |row: &std::collections::HashMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
    // Impact at h = 5 after 1 s, t = √(2h/g), u = 10; then h - u/2 (1.5 - t) + g (1.5 - t)²/2.
    let by_gap = 1.0 - 0.5 * (1.0 * 0.5 - 10.0 * 0.1) - 10.0 * 0.5 * 0.1;
    assert!((of(&rows[3], "ball.s/stop.floor.gap") - by_gap).abs() < 1e-14, "{rows:?}");
    assert_eq!(rows[1]["ball.s/stop.floor.gap"], "0");
    assert!(rows.iter().all(|row| row["ball.s/friction.f.force"].is_empty()));
    let events = table(&out, "event-derivatives.csv");
    assert_eq!((events.len(), events[0]["row"].as_str()), (table(&out, "events.csv").len(), "1"));
    assert!(
        (of(&events[0], "stop.floor.gap") - 0.1).abs() < 1e-15 && events[0]["friction.f.force"].is_empty()
    );
    let run = ["run", &path, "--until", "1", "--derivatives"];
    let (code, error) = refused(&[&run[..], &["stop.flor.gap"]].concat());
    assert!(error.contains("stop.flor.gap") && error.contains("stop.floor.gap"), "{error}");
    let (again, error_again) = refused(&[&run[..], &["gravity,gravity"]].concat());
    assert!(error_again.contains("--derivatives gravity") && error_again.contains("once"), "{error_again}");
    assert_eq!((code, again), (2, 2));
}

#[test]
fn every_example_of_the_repository_moves() {
    let files = std::fs::read_dir(example("")).unwrap().map(|entry| entry.unwrap().path());
    let files: Vec<_> = files.filter(|path| path.extension().is_some_and(|e| e == "toml")).collect();
    assert!(files.len() > 20);
    for path in files {
        let description = vibro_machine::file::read(&path).unwrap_or_else(|e| panic!("{e}"));
        let times = vibro::machine::even_times((0.0, 0.5), 20).unwrap();
        let record =
            vibro::machine::record(description, &Start::default(), &times, &Arc::default(), &mut |_| ())
                .unwrap_or_else(|e| panic!("{path:?}: {e}"));
        assert!(record.ended.is_none() && record.rows.len() == 21, "{path:?} {:?}", record.ended);
        assert!(record.rows.iter().flatten().all(|x| x.is_finite()), "{path:?}");
    }
}

#[test]
fn draw_writes_the_sketch_with_every_name_and_nothing_over_the_edge() {
    let out = folder("assembly-draw");
    let text = drawn(&out, &["draw", &machine("damper_with_buffer.toml")]);
    assert!(text.contains("DamperWithBuffer.svg"), "{text}");
    let svg = std::fs::read_to_string(out.join("DamperWithBuffer.svg")).unwrap();
    for name in ["box", "block", "pump", "mount", "pump_mount", "steel", "buffer", "guide", "shaker"] {
        assert_eq!(svg.matches(&format!(">{name}<")).count(), 1, "{name}");
    }
    let (width, height, pixels) = pixels(&out.join("DamperWithBuffer.png"));
    let (width, height) = (width as usize, height as usize);
    let channels = pixels.len() / (width * height);
    let white =
        |x: usize, y: usize| pixels[(y * width + x) * channels..][..channels].iter().all(|part| *part == 255);
    assert!((0..width).all(|x| white(x, 0) && white(x, height - 1)));
    assert!((0..height).all(|y| white(0, y) && white(width - 1, y)));
}

/// At any width in print a sketch has this width and names of 7 points, at 72 points of an inch of
/// 25.4 mm; if it is too wide, a note tells the size of its names and the width that is needed.
#[test]
fn closed_form_draw_takes_a_width_in_print() {
    // The viewBox has a whole number of units, of at least 500.
    const UNIT: f64 = 1e-3;
    let out = folder("assembly-draw-width");
    let ball = machine("bouncing_ball.toml");
    drawn(&out, &["draw", &ball]);
    let of_screen = std::fs::read_to_string(out.join("BouncingBall.svg")).unwrap();
    let read = |name: &str| std::fs::read_to_string(out.join(format!("{name}.svg"))).unwrap();
    let view = |svg: &str| -> Vec<f64> {
        let rest = svg.split_once("viewBox=\"0 0 ").unwrap().1;
        rest.split('"').next().unwrap().split(' ').map(|side| side.parse().unwrap()).collect()
    };
    for millimetres in [84.0, 174.0] {
        drawn(&out, &["draw", &ball, "--width", &format!("{millimetres}mm")]);
        let svg = read("BouncingBall");
        assert!(svg.starts_with(&format!("<svg width=\"{millimetres}mm\"")), "{svg}");
        let points = 40.0 * millimetres / 25.4 * 72.0 / view(&svg)[0];
        assert!(svg.contains("font-size=\"40\"") && (points / 7.0 - 1.0).abs() < UNIT, "{points}");
        assert_eq!(view(&svg)[1], view(&of_screen)[1]);
        // The sketch is in the middle: both sides get half of the white.
        let side = 0.5 * (view(&svg)[0] - view(&of_screen)[0]);
        assert!(svg.contains(&format!("translate({side} 0)")), "{side}: {svg}");
        assert_eq!(pixels(&out.join("BouncingBall.png")).0, (millimetres / 25.4 * 600.0_f64).round() as u32);
    }
    let cradle = machine("cradle.toml");
    let done = command(&out, &["draw", &cradle, "--width", "84mm"]).output().unwrap();
    let note = String::from_utf8(done.stderr).unwrap();
    let wide = view(&read("Cradle"))[0];
    let points = 40.0 * 84.0 / 25.4 * 72.0 / wide;
    let full = (wide / 40.0 * 7.0 / 72.0 * 25.4).ceil();
    let told =
        format!("note: with --width 84mm names have {points:.1} points; --width {full}mm or more gives 7\n");
    assert_eq!(note, told);
    drawn(&out, &["draw", &cradle, "--width", &format!("{full}mm")]);
}

/// A mass under a sampled controller with limits, with a stop.
const CONTROLLED: &str = r#"
name = "Controlled"
body.mass = { mass = 1.0, start = { v = 1.0 } }
spring.k = { between = ["ground", "mass"], stiffness = 100.0 }
stop.wall = { between = ["ground", "mass"], gap = 0.05, stiffness = 1000.0 }
load.push = { on = "mass", from = "control.u" }
[block.control]
inputs = ["mass.s"]
a = [[0.5]]
b = [[1.0]]
c = [[0.1]]
d = [[-40.0]]
outputs = ["u"]
limits = { u = [-1, 1] }
sample = 0.01
delay = 0.005
"#;

#[test]
fn derivatives_of_events_have_the_rows_of_the_events_beside_samples() {
    let (path, out) = (file("controlled.toml", CONTROLLED), folder("assembly-controlled"));
    let path = path.display().to_string();
    let derivatives = ["--derivatives", "spring.k.stiffness"];
    drawn(&out, &[&["run", &path, "--until", "1"][..], &derivatives].concat());
    let rows = |name: &str| std::fs::read_to_string(out.join(name)).expect("a table").lines().count();
    assert!(rows("events.csv") > 8, "{}", rows("events.csv"));
    assert_eq!(rows("event-derivatives.csv"), rows("events.csv"));
}

#[test]
fn columns_are_states_of_blocks_by_their_names() {
    let (path, out) = (file("controlled_columns.toml", CONTROLLED), folder("assembly-block-columns"));
    let path = path.display().to_string();
    let run = ["run", &path, "--until", "0.2"];
    drawn(
        &out,
        &[&run[..], &["--columns", "control,control.x[0],control.u.held,control.u.next[0]"]].concat(),
    );
    let text = std::fs::read_to_string(out.join("states.csv")).expect("a table");
    assert_eq!(text.lines().next(), Some("time,control.u,control.x[0],control.u.held,control.u.next[0]"));
    let last = text.lines().last().expect("a row");
    assert!(last.split(',').all(|x| x.parse::<f64>().is_ok_and(|x| x != 0.0)), "{last}");
}

#[test]
fn check_says_what_blocks_have_to_do_with_equilibrium_and_frequencies() {
    let path = file("controlled_check.toml", CONTROLLED).display().to_string();
    let text = drawn(&folder("assembly-block-check"), &["check", &path]);
    for words in [
        "equilibrium: not computed, because block.control feeds back mass.s",
        "natural frequencies in the start's mode, with the outputs of sampled blocks held\n  1.59155 Hz",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
    // The state of a sampled block is not a coordinate.
    assert!(!text.contains("0 Hz:"), "{text}");
    // k = 100 N/m plus 44 N/m of the loop: 12 rad/s.
    let continuous =
        CONTROLLED.replace("sample = 0.01\ndelay = 0.005", "").replace("limits = { u = [-1, 1] }", "");
    let continuous =
        continuous.replace("-40.0", "-44.0").replace("0.1]", "0.0]").replace("[[0.5]]", "[[-0.5]]");
    let path = file("controlled_continuous.toml", &continuous).display().to_string();
    let text = drawn(&folder("assembly-block-continuous"), &["check", &path]);
    assert!(text.contains("mode, with continuous blocks\n  1.90986 Hz"), "{text}");
}
