//! `vibro fit`: docs/fit.md compared with the machine that made its record, and errors.

#[path = "common/mod.rs"]
mod command;
#[path = "common/guide.rs"]
mod guide;
#[path = "fit/shaken_box.rs"]
mod shaken_box;
#[path = "fit/together.rs"]
mod together;

use command::{folder, numbers};
use guide::Guide;
use std::path::Path;
use std::process::Command;
use std::sync::Arc;
use vibro_figures::canvas::palette::{BLUE, VERMILLION};
use vibro_figures::canvas::svg;
use vibro_figures::chart::{Axis, Dash, Figure, Layer, Panel, Path as Line};
use vibro_machine::{Assembly, Description, Motion};

/// Tolerance of a picture's coordinates, which have few digits; another mathematical library
/// changes them by less.
const MOVED: f64 = 2.0;

/// Distance of an estimate, in standard errors; about one in ten thousand is beyond it.
const FAR: f64 = 4.0;

/// Number after a key of a JSON text, searched from `place`.
fn number_after(text: &str, place: &str, key: &str) -> f64 {
    let from = text.find(place).unwrap_or_else(|| panic!("{place}: {text}"));
    let rest = text[from..].split_once(&format!("\"{key}\": ")).unwrap().1;
    rest.split([',', '}']).next().unwrap().parse().unwrap()
}

/// Compares a picture of docs/fit/, or writes it again with `VIBRO_IMPACT_UPDATE=1`.
fn is_kept(name: &str, now: &str) {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../docs/fit/{name}.svg"));
    if std::env::var("VIBRO_IMPACT_UPDATE").is_ok_and(|v| v == "1") {
        std::fs::write(&kept, now).unwrap();
    }
    let before = std::fs::read_to_string(&kept).expect("a picture; VIBRO_IMPACT_UPDATE=1 writes it");
    let (old, new) = (numbers(&before), numbers(now));
    let is_near = old.len() == new.len() && old.iter().zip(&new).all(|(a, b)| (a - b).abs() <= MOVED);
    assert!(is_near, "{name}.svg is stale; VIBRO_IMPACT_UPDATE=1 writes it anew");
}

/// Root mean square difference, in µm, between the record and the motion of the page's fitted
/// machine with some parameters multiplied by a factor.
fn off(machine: &Description, factor: f64, names: &[&str], record: &[Vec<f64>]) -> f64 {
    let changes = names.iter().map(|name| (*name, factor * machine.get(name).unwrap()));
    let changed = machine.with(changes).unwrap();
    let mut motion = Motion::new(Arc::new(Assembly::new(changed).unwrap())).unwrap();
    let mut squares = 0.0;
    for row in record {
        motion.advance_to(row[0]).unwrap();
        squares += (motion.state()[0] - row[1]).powi(2);
    }
    1e6 * (squares / record.len() as f64).sqrt()
}

/// Picture of a flat valley: residuals over one parameter, and over all three together.
fn valley_picture(home: &Path) -> String {
    let machine = vibro_machine::file::read(&home.join("fit/fitted.toml")).unwrap();
    let record = guide::rows("fit", "record.csv");
    let three = ["body.slide.mass", "spring.mount.stiffness", "friction.guide.force"];
    let factors: Vec<f64> = (0..=80).map(|i| 0.8 + 0.005 * f64::from(i)).collect();
    let line = |names: &[&str]| -> Line {
        factors.iter().map(|factor| (*factor, off(&machine, *factor, names, &record))).collect()
    };
    let (alone, together) = (line(&three[1..2]), line(&three));
    let flat = together.iter().map(|point| (point.1 / alone[40].1 - 1.0).abs()).fold(0.0, f64::max);
    assert!(flat < 1e-9 && alone[0].1 > 10.0 * alone[40].1, "{flat}");
    let figure = Figure {
        title: "A valley, and a flat one".into(),
        caption: Vec::new(),
        panels: vec![Panel {
            title: String::new(),
            x: Axis::new("number over its fitted value"),
            y: Axis::new("rms of motion less record (µm)"),
            layers: vec![
                Layer::line("stiffness alone", BLUE, Dash::Solid, alone),
                Layer::line("mass, stiffness and friction together", VERMILLION, Dash::Solid, together),
            ],
        }],
        columns: 1,
        panel: (2000, 900),
        shared_legend: false,
    };
    svg(&figure).unwrap()
}

#[test]
fn made_record_of_the_page() {
    let guide = Guide::read("fit.md");
    let said = guide.perform("fit", &[]);
    let home = Path::new(env!("CARGO_TARGET_TMPDIR")).join("fit");
    let json = std::fs::read_to_string(home.join("fit/fit.json")).unwrap();
    for (name, truth) in [("spring.mount.stiffness", 1e4), ("friction.guide.force", 1.0)] {
        let (value, error) = (number_after(&json, name, "value"), number_after(&json, name, "error"));
        assert!((value - truth).abs() < FAR * error && error < 0.01 * truth, "{name} {value} ± {error}");
    }
    assert!(said[0].contains("spring.mount.stiffness ="), "{}", said[0]);
    assert!(said[0].contains("verdict: fits") && json.contains("\"verdict\": \"fits\""), "{}", said[0]);
    // Mass, stiffness and friction change by the same fraction.
    let valley = std::fs::read_to_string(home.join("valley/fit.json")).unwrap();
    let part = |name: &str| number_after(&valley, "combination", name).abs();
    for name in ["body.slide.mass", "spring.mount.stiffness", "friction.guide.force"] {
        assert!((part(name) - 3f64.sqrt().recip()).abs() < 1e-3, "{name}: {valley}");
    }
    assert!(valley.contains("\"error\": null") && said[1].contains("does not determine"), "{}", said[1]);
    // A range without a unit is in the file's unit, kN/m.
    let line = "fit drive.toml --data record.csv --free spring.mount.stiffness --within spring.mount.stiffness=7:9 --out within";
    let output =
        Command::new(env!("CARGO_BIN_EXE_vibro")).args(line.split(' ')).current_dir(&home).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let within = std::fs::read_to_string(home.join("within/fit.json")).unwrap();
    assert_eq!(number_after(&within, "spring.mount.stiffness", "value"), 9e3);
    // The range excludes the record's stiffness, so the fit fails and shows no errors.
    let shown = String::from_utf8_lossy(&output.stdout);
    let page = std::fs::read_to_string(home.join("within/report.html")).unwrap();
    for text in [&shown, &*page] {
        assert!(
            !text.contains('±') && text.contains("spring.mount.stiffness is at an end of its range"),
            "{text}"
        );
    }
    assert!(said[0].contains("spring.mount.stiffness = 10") && said[0].contains('±'), "{}", said[0]);
    assert!(within.contains("\"at_bounds\": {\"spring.mount.stiffness\": 9000.0}"), "{within}");
    let drawn = std::fs::read_to_string(home.join("fit/fit.svg")).unwrap();
    is_kept("fit", &drawn);
    is_kept("valley", &valley_picture(&home));
    let page = std::fs::read_to_string(home.join("fit/report.html")).unwrap();
    for words in ["<b>fits</b>", "spring.mount.stiffness</th>", "<td class=\"n\">kN/m</td>", "<svg role"] {
        assert!(page.contains(words), "{words}: {page}");
    }
    // One file without network: the only address is the SVG namespace.
    assert_eq!(page.matches("http").count(), page.matches("xmlns=\"http").count());
    assert!(!page.contains("<script") && !page.contains("src="));
}

#[test]
fn what_is_no_record_is_refused_by_name_and_row() {
    let out = folder("fit-refused");
    std::fs::create_dir_all(&out).unwrap();
    let table = |name: &str, text: &str| {
        let path = out.join(name);
        std::fs::write(&path, text).unwrap();
        path.display().to_string()
    };
    let sound = table("sound.csv", "time,mass.s\n0,1e-3\n0.01,2e-3\n0.02,1e-3\n");
    let cases = [
        (
            table("columns.csv", "time,mas.s\n0,1\n1,2\n"),
            "friction.floor.force",
            "the machine has no `mas.s`",
        ),
        (
            table("time.csv", "t,mass.s\n0,1\n1,2\n"),
            "friction.floor.force",
            "no column is called `time` (found t, mass.s)",
        ),
        (
            table("falls.csv", "time,mass.s\n0,1\n1,2\n0.5,2\n"),
            "friction.floor.force",
            "row 3 has the time 0.5 s",
        ),
        (
            table("nan.csv", "time,mass.s\n0,1\n1,NaN\n"),
            "friction.floor.force",
            "line 3: `NaN` is not a number",
        ),
        (table("empty.csv", "time,mass.s\n"), "friction.floor.force", "no sample"),
        (table("near.csv", "time,mas.s\n0,1\n1,2\n"), "friction.floor.force", "did you mean `mass.s`?"),
        (sound.clone(), "friction.floor.forc", "did you mean `friction.floor.force`"),
        (sound.clone(), "friction.floor.force,record.offset.floor.f", "the record has no such column"),
        (
            sound.clone(),
            "friction.floor.force,spring.mount.stiffness,body.mass.mass,body.mass.start.s",
            "3 samples for 4 free parameters",
        ),
    ];
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (record, free, words) in cases {
        let output = Command::new(env!("CARGO_BIN_EXE_vibro"))
            .args([
                "fit",
                "examples/assembly/coulomb_oscillator.toml",
                "--data",
                &record,
                "--free",
                free,
                "--out",
            ])
            .arg(out.join("fit"))
            .current_dir(&root)
            .output()
            .unwrap();
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && error.contains(words), "{free}: {error}");
    }
}

/// Output of `vibro fit` for a machine's text, with tables by name.
fn said(name: &str, machine: &str, tables: &[(&str, &str)], arguments: &str) -> (std::path::PathBuf, String) {
    let out = folder(name);
    std::fs::create_dir_all(&out).unwrap();
    std::fs::write(out.join("m.toml"), machine).unwrap();
    tables.iter().for_each(|(name, text)| std::fs::write(out.join(name), text).unwrap());
    let folder = if arguments.contains("--out ") { "" } else { "--out fit " };
    let line = format!("fit m.toml {folder}--replace {arguments}");
    let output =
        Command::new(env!("CARGO_BIN_EXE_vibro")).args(line.split(' ')).current_dir(&out).output().unwrap();
    let text =
        [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat();
    (out.join("fit"), text)
}

const BALL: &str = "name = \"Ball\"\ngravity = 9.81\nbody.b = { mass = 1.0, gravity = 1.0 }\n\
                    stop.floor = { between = [\"ground\", \"b\"], gap = 1.0, restitution = 0.8 }\n";

#[test]
fn refused_records_ranges_and_deviations_are_named_with_their_file() {
    let tables = [
        ("falls.csv", "time,b.s\n0,1\n1,2\n0.5,2\n"),
        ("unknown.csv", "time,c.s\n0,1\n1,2\n"),
        ("empty.csv", "time,b.s\n"),
        ("twice.csv", "time,b.s,b.s\n0,1,1\n1,2,2\n"),
        ("early.csv", "time,b.s\n-2,1\n-1,2\n"),
        ("shown.csv", "time,b.a\n0,0\n0.1,9\n0.2,10\n"),
        ("order.csv", "element,time\nfloor,1\nfloor,0.5\n"),
        ("sound.csv", "time,b.s\n0,0\n0.1,0.05\n0.2,0.2\n"),
    ];
    let sound = "--data sound.csv --free stop.floor.gap --within stop.floor.gap";
    let cases = [
        ("--data falls.csv --free stop.floor.gap", "falls.csv: time: row 3 has the time 0.5 s"),
        ("--data unknown.csv --free stop.floor.gap", "unknown.csv: the machine has no `c.s`"),
        ("--data empty.csv --free stop.floor.gap", "empty.csv: has no sample"),
        ("--data twice.csv --free stop.floor.gap", "twice.csv: b.s has two columns"),
        ("--data early.csv --free stop.floor.gap", "early.csv: time: row 1 is -2.0 s, before"),
        ("--events order.csv --free stop.floor.gap", "order.csv: floor: contact 2 has the time 0.5 s"),
        (&format!("{sound}=3:2"), "stop.floor.gap=3:2: LOW must be less than HIGH"),
        (&format!("{sound}=0.5:2 --within stop.floor.gap=0.6:2"), "stop.floor.gap has two ranges"),
        (
            "--data shown.csv --free stop.floor.gap",
            "b.a has no filter; an acceleration requires the filter of its sensor",
        ),
        (
            "--data shown.csv --free stop.floor.gap --filter b.a=2",
            "COLUMN=ORDER,FREQUENCY, e.g. box.a=2,400Hz",
        ),
        ("--data shown.csv --free stop.floor.gap --filter b.a=9,40Hz", "expected an order from 1 to 8"),
        ("--data sound.csv --free stop.floor.gap --sigma b.s=1,b.s=2", "b.s has two standard deviations"),
    ];
    for (arguments, words) in cases {
        let (_, text) = said("fit-named", BALL, &tables, arguments);
        assert!(text.contains(words), "{arguments}: {text}");
    }
}

#[test]
fn closed_form_residuals_of_contacts_are_in_a_table_of_their_own() {
    // Contacts of a ball that falls 1 m: √(2 h / g), then twice the time of each rise.
    let fall = (2f64 / 9.81).sqrt();
    let times: Vec<f64> =
        (0..8).map(|k| fall + (1..=k).map(|i| 2.0 * fall * 0.8f64.powi(i)).sum::<f64>()).collect();
    let rows = times.iter().enumerate().map(|(k, t)| format!("floor,{:?}\n", t + 1e-4 * (k as f64).sin()));
    let table = "element,time\n".to_owned() + &rows.collect::<String>();
    let arguments = "--events t.csv --free stop.floor.gap,stop.floor.restitution";
    let (out, text) = said("fit-contacts", BALL, &[("t.csv", &table)], arguments);
    assert!(!out.join("residuals.csv").exists() && text.contains("residuals-contacts.csv"), "{text}");
    let found = std::fs::read_to_string(out.join("residuals-contacts.csv")).unwrap();
    let mut lines = found.lines();
    assert_eq!(lines.next(), Some("element,time,time.fit,time.residual"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').skip(1).map(|cell| cell.parse().unwrap()).collect()).collect();
    assert_eq!(rows.len(), 8);
    for (row, time) in rows.iter().zip(times) {
        assert!((row[1] - row[0] - row[2]).abs() < 1e-15 && (row[1] - time).abs() < 3e-4, "{row:?} {time}");
    }
}

/// A mass of 1 kg on 100 N/m from 10 mm moves as 10 mm cos 10t.
const COSINE: &str = "name = \"C\"\n[body.m]\nmass = 1.0\nstart = { s = 0.01 }\n[spring.k]\nbetween = [\"ground\", \"m\"]\nstiffness = 90.0\n";

/// Error of a stiffness of 100 N/m from displacements of 10 mm rounded to 0.1 µm.
const ROUNDED: f64 = 1e-2;

#[test]
fn closed_form_of_a_fit_to_a_record_in_other_units() {
    // Rounded to 0.1 µm.
    let row = |k: i32, separator: char, (time, way): (f64, f64)| {
        let (t, digits) = (0.05 * f64::from(k), if way == 1.0 { 7 } else { 4 });
        format!("{}{separator}{:.digits$}\n", t * time, 0.01 * (10.0 * t).cos() * way)
    };
    let rows = |separator, units| (0..20).map(|k| row(k, separator, units)).collect::<String>();
    let tables = [
        ("si.csv", format!("time,m.s\n{}", rows(',', (1.0, 1.0)))),
        ("comment.csv", format!("# shaker 3\n\ntime [s],m.s [m]\n# run 7\n{}", rows(',', (1.0, 1.0)))),
        ("units.csv", format!("time [ms];m.s [mm]\n{}", rows(';', (1e3, 1e3)))),
        ("wrong.csv", format!("time [ms],m.s [kN]\n{}", rows(',', (1e3, 1e3)))),
        ("comma.csv", "time;m.s\n0;0,01\n0,05;0,0088\n".into()),
    ];
    let tables: Vec<(&str, &str)> = tables.iter().map(|(name, text)| (*name, &text[..])).collect();
    let fit = |name: &str| {
        said(&format!("fit-{name}"), COSINE, &tables, &format!("--data {name} --free spring.k.stiffness")).1
    };
    let value = |name: &str| {
        let told = fit(name);
        let (_, value) = told.split_once("spring.k.stiffness = ").unwrap_or_else(|| panic!("{name}: {told}"));
        value.split_whitespace().next().unwrap().parse::<f64>().unwrap()
    };
    for name in ["si.csv", "comment.csv", "units.csv"] {
        assert!((value(name) - 100.0).abs() < ROUNDED, "{name}");
    }
    for (name, words) in [
        ("wrong.csv", "wrong.csv: line 1: `m.s` has the unit `kN`; expected one of m, cm, mm"),
        ("comma.csv", "comma.csv: line 2: `0,01` has a decimal comma; expected a decimal point"),
    ] {
        let told = fit(name);
        assert!(told.contains(words), "{told}");
    }
}

/// Lines of a text that another text lacks.
fn new_lines<'t>(text: &'t str, other: &str) -> Vec<&'t str> {
    text.lines().filter(|line| !other.lines().any(|own| own == *line)).collect()
}

#[test]
fn invariant_a_fitted_file_keeps_comments_units_and_records() {
    const MACHINE: &str = "name = \"Pushed\" # by hand\n[body.b]\nmass = \"2000 g\"\n# the bench\n\
                           [spring.k]\nbetween = [\"ground\", \"b\"]\nstiffness = \"0.3 kN/m\" # guessed\n\
                           [load.push]\non = \"b\"\ntable = \"records/push.csv\"\n";
    const PUSH: &str = "# made by hand\ntime [ms];f [N]\n0;1\n2000;1\n";
    // 1 N on 200 N/m and 2 kg: the body moves by 5 mm (1 - cos 10 t).
    let row = |k: u32| format!("{k},{:?}\n", 5.0 - 5.0 * (0.01 * f64::from(k)).cos());
    let table =
        "# a sensor\ntime [ms],b.s [mm]\n".to_owned() + &(0..200).map(|k| row(5 * k)).collect::<String>();
    let out = folder("fit-kept");
    std::fs::create_dir_all(out.join("records")).unwrap();
    std::fs::write(out.join("records/push.csv"), PUSH).unwrap();
    let run = |line: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_vibro"));
        let output = command.args(line.split(' ')).current_dir(&out).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    };
    std::fs::write(out.join("m.toml"), MACHINE).unwrap();
    std::fs::write(out.join("t.csv"), table).unwrap();
    run("fit m.toml --data t.csv --free spring.k.stiffness,body.b.start.v --out fit");
    let text = std::fs::read_to_string(out.join("fit/fitted.toml")).unwrap();
    let new = new_lines(&text, MACHINE);
    // The text has no start, so it is added to the body.
    let begins = ["# vibro fit: ", "start.v = ", "stiffness = \"0."];
    assert!(new.len() == 3 && new.iter().zip(begins).all(|(line, begin)| line.starts_with(begin)), "{text}");
    assert!(new[2].ends_with(" kN/m\" # guessed") && new_lines(MACHINE, &text).len() == 1, "{text}");
    assert_eq!(std::fs::read_to_string(out.join("fit/records/push.csv")).unwrap(), PUSH);
    // The file is a machine, whose motion matches the record.
    run("run fit/fitted.toml --until 0.1s --samples 1 --out run");
    let states = std::fs::read_to_string(out.join("run/states.csv")).unwrap();
    let last: Vec<f64> =
        states.lines().last().unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    assert!((last[1] - 5e-3 * (1.0 - 1f64.cos())).abs() < 1e-8, "{states}");
}

/// Whether a process handles Ctrl-C itself, from the mask of its caught signals.
#[cfg(target_os = "linux")]
fn catches_ctrl_c(pid: u32) -> bool {
    let status = std::fs::read_to_string(format!("/proc/{pid}/status")).unwrap();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap();
    // Signal 2 is bit 1.
    u64::from_str_radix(mask.trim(), 16).unwrap() & 2 != 0
}

#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_writes_the_best_values_so_far_as_undecided() {
    let out = folder("fit-ended");
    std::fs::create_dir_all(&out).unwrap();
    // No ball moves like this: without an interruption, the fit takes a minute and fails.
    let row = |k: usize| format!("{:?},{}\n", 1e-3 * k as f64, (k * k) % 7);
    let table = "time,b.s\n".to_owned() + &(0..20_000).map(row).collect::<String>();
    std::fs::write(out.join("m.toml"), BALL).unwrap();
    std::fs::write(out.join("t.csv"), table).unwrap();
    let line = "fit m.toml --data t.csv --free stop.floor.gap,stop.floor.restitution --out fit";
    let mut command = Command::new(env!("CARGO_BIN_EXE_vibro"));
    command.args(line.split(' ')).current_dir(&out).stdout(std::process::Stdio::piped());
    let child = command.spawn().unwrap();
    while !catches_ctrl_c(child.id()) {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    let pid = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill runs").success());
    let output = child.wait_with_output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert!(
        output.status.code() == Some(130) && text.contains("verdict: undecided: ended by hand"),
        "{text}"
    );
    let json = std::fs::read_to_string(out.join("fit/fit.json")).unwrap();
    assert!(json.contains("\"verdict\": \"undecided: ended by hand"), "{json}");
    // The motion is the written values' motion.
    assert!(number_after(&json, "stop.floor.gap", "value") > 0.0 && out.join("fit/fitted.toml").exists());
}
