//! Runs the real `vibro sweep`: its table compared with single motions and closed forms, its two
//! formats, bad designs, bad input, and the same bytes for any number of threads and shards and
//! after an interruption.

#[path = "common/mod.rs"]
mod command;

use command::{command, drawn, folder, refused, table};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use std::fs::File;
use std::path::Path;
use vibro_impact::steady::exact_orbit;
use vibro_studies::paper::ParameterSet;

/// Transient of a settled motion, in units of L.
const SETTLED: f64 = 1e-9;

/// Quick work: few periods.
const QUICK: [&str; 4] = ["--discard", "20", "--periods", "6"];

fn swept(name: &str, arguments: &[&str]) -> std::path::PathBuf {
    let out = folder(name);
    drawn(&out, &[&["sweep"], arguments].concat());
    out
}

/// Cells of the Parquet file by rows: text unchanged, numbers in Rust's format, null as an empty
/// cell.
fn parquet_rows(out: &Path) -> Vec<Vec<(String, String)>> {
    let reader = SerializedFileReader::new(File::open(out.join("sweep.parquet")).unwrap()).unwrap();
    let cell = |(name, field): (&String, &Field)| {
        let text = match field {
            Field::Double(value) => value.to_string(),
            Field::Str(words) => words.clone(),
            Field::Null => String::new(),
            other => panic!("{name}: {other:?}"),
        };
        (name.clone(), text)
    };
    let rows = reader.get_row_iter(None).unwrap();
    rows.map(|row| row.unwrap().get_column_iter().map(cell).collect()).collect()
}

#[test]
fn closed_form_amplitudes_of_the_stable_orbit_and_of_the_box_alone() {
    let out = swept(
        "sweep-orbit",
        &["--vary", "f10=1.2,1.5,1.8", "--output", "amplitude.x1,amplitude.without_block,impacts,class"],
    );
    let rows = table(&out, "sweep.csv");
    assert_eq!(rows.len(), 3);
    for row in rows {
        let mut set = ParameterSet::basic();
        set.apply(&[format!("f10={}", row["f10"])]).unwrap();
        let p = set.parameters();
        let orbit = exact_orbit::solve(p).unwrap().upper.unwrap();
        let number = |column: &str| row[column].parse::<f64>().unwrap();
        assert!((number("amplitude.x1") - orbit.amplitudes()[0]).abs() < SETTLED, "{row:?}");
        let stiffness = p.box_stiffness - p.box_mass * p.drive_frequency.powi(2);
        let alone = p.drive_amplitude / stiffness.hypot(p.box_damping * p.drive_frequency);
        assert!((number("amplitude.without_block") - alone).abs() < 1e-14, "{row:?}");
        assert_eq!((row["impacts"].as_str(), row["class"].as_str(), row["reason"].as_str()), ("2", "1T", ""));
    }
    assert!(out.join("sweep.svg").exists() && out.join("sweep.png").exists());
}

#[test]
fn second_method_the_table_is_the_same_in_both_formats() {
    let list = folder("sweep-list-file");
    std::fs::create_dir_all(&list).unwrap();
    let file = list.join("designs.csv");
    let text = "stop.gap,stop.restitution\n1000 mm,0.5\n0.9,1.5\n-1,0.5\n1.1,0.6\n";
    std::fs::write(&file, text).unwrap();
    let file = file.to_str().unwrap();
    // Measured at only these two values.
    let over = ["--over", "drive.frequency=1,1.05", "--start", "v2=1", "--start", "x1=0.1"];
    let out = swept("sweep-formats", &[&["--design", file], &over[..], &QUICK[..]].concat());
    let csv = table(&out, "sweep.csv");
    let parquet = parquet_rows(&out);
    assert_eq!((csv.len(), parquet.len()), (4, 4));
    for (row, other) in csv.iter().zip(&parquet) {
        assert_eq!(row.len(), other.len());
        for (name, text) in other {
            assert_eq!(&row[name], text, "{name}");
        }
    }
    // Two designs are bad: rows with their reasons and without values.
    assert_eq!(csv[0]["stop.gap"], "1");
    for (index, reason) in [(1, "stop.restitution = 1.5: expected"), (2, "stop.gap = -1: expected")] {
        let row = &csv[index];
        assert!(row["reason"].starts_with(reason), "{row:?}");
        assert!(row.iter().filter(|c| c.0.starts_with("amplitude")).all(|c| c.1.is_empty()), "{row:?}");
    }
    for row in [&csv[0], &csv[3]] {
        let number = |column: &str| row[column].parse::<f64>().unwrap();
        let [least, mean, largest] = ["min", "mean", "max"].map(|w| number(&format!("amplitude.x1.{w}")));
        assert!(0.0 < least && least <= mean && mean <= largest);
        // After few periods, some motions had not settled when they were measured.
        assert!(row["reason"].is_empty() || row["reason"].contains("not settled: "), "{row:?}");
        assert!([1.0, 1.05].contains(&number("amplitude.x1.max.drive.frequency")));
        assert!(["v2=1", "x1=0.1"].contains(&row["amplitude.x1.max.start"].as_str()));
    }
    let text = std::fs::read_to_string(out.join("sweep.csv")).unwrap().to_lowercase();
    assert!(!text.contains("nan") && !text.contains("inf"));
}

#[test]
fn units_and_symbols_name_the_same_sweep() {
    let line = |vary: [&'static str; 2]| {
        [&["--vary", vary[0], "--vary", vary[1], "--output", "impacts"], &QUICK[..]].concat()
    };
    let out = swept("sweep-units", &line(["L=900mm:1.1m:3", "m2=100g,120g"]));
    // Columns in SI, followed by columns in the axes' units.
    let in_si = || {
        let text = std::fs::read_to_string(out.join("sweep.csv")).unwrap();
        let cut = |line: &str| line.split(',').take(4).collect::<Vec<_>>().join(",");
        text.lines().map(cut).collect::<Vec<_>>().join("\n")
    };
    let found = in_si();
    assert!(found.starts_with("stop.gap,block.m,impacts,reason\n0.9,0.1,"), "{found}");
    // Equal values written differently make an equal run, whose result is overwritten.
    drawn(&out, &[&["sweep"], &line(["stop.gap=0.9:1.1:3", "block.m=0.1,0.12"])[..]].concat());
    assert_eq!(in_si(), found);
    // Different values make another run.
    let other = [&["sweep"], &line(["stop.gap=0.9:1.1:3", "block.m=0.1,0.13"])[..]].concat();
    let output = command(&out, &other).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(2));
    assert!(error.contains("--vary: stop.gap=0.9:1.1:3 block.m=0.1,0.12 there"), "{error}");
    assert_eq!(in_si(), found);
}

#[test]
fn a_file_of_designs_counts_by_what_is_in_it() {
    let (out, file) = (folder("sweep-file"), folder("sweep-file-list").with_extension("csv"));
    let line = [&["sweep", "--design", file.to_str().unwrap(), "--output", "impacts"], &QUICK[..]].concat();
    std::fs::write(&file, "L\n0.9\n1.0\n").unwrap();
    drawn(&out, &line);
    std::fs::write(&file, "stop.gap\n900 mm\n1\n").unwrap();
    drawn(&out, &line);
    std::fs::write(&file, "L\n0.9\n1.1\n").unwrap();
    let output = command(&out, &line).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && error.contains("--design: 2 designs of stop.gap, digest"),
        "{error}"
    );
}

#[test]
fn invariant_bytes_depend_neither_on_threads_nor_on_shards_nor_on_an_interruption() {
    let line = [
        "sweep",
        "--vary",
        "L=0.8:1.2:4",
        "--vary",
        "kappa=0.3:0.7:3",
        "--over",
        "drive.frequency=0.95:1.05:40",
    ];
    let line = [&line[..], &["--starts", "8", "--output", "amplitude.x1,power.impact,class"]].concat();
    // Designs are measured again, but no longer than the comparison requires.
    let line = [&line[..], &["--discard", "3", "--periods", "2", "--again", "100000"]].concat();
    let [one, two, whole] = ["sweep-one", "sweep-two", "sweep-whole"].map(folder);
    drawn(&whole, &[&line[..], &["--threads", "2"]].concat());
    for (out, shard) in [(&one, "1/2"), (&two, "2/2")] {
        let said = drawn(out, &[&line[..], &["--shard", shard, "--threads", "1"]].concat());
        assert!(said.contains("3 of 6 parts of `sweep`"), "{said}");
    }
    let merged = folder("sweep-merged");
    drawn(&merged, &["merge", one.to_str().unwrap(), two.to_str().unwrap()]);
    // A stopped program leaves parts, which an equal command continues.
    drawn(&two, &line);
    for name in ["sweep.csv", "sweep.parquet", "sweep.svg", "sweep.png"] {
        let bytes = |out: &Path| std::fs::read(out.join(name)).unwrap();
        assert!(bytes(&merged) == bytes(&whole) && bytes(&two) == bytes(&whole), "{name}");
    }
    assert!(!merged.join("sweep.parts").exists() && !two.join("sweep.parts").exists());
}

#[test]
fn parts_of_another_sweep_are_refused_and_kept() {
    let out = folder("sweep-foreign");
    let line = ["sweep", "--vary", "L=0.8:1.2:40", "--starts", "63", "--output", "impacts", "--shard", "1/2"];
    drawn(&out, &[&line[..], &QUICK[..]].concat());
    let other = ["sweep", "--vary", "L=0.8:1.2:41", "--starts", "63", "--output", "impacts"];
    let output = command(&out, &[&other[..], &QUICK[..]].concat()).output().unwrap();
    let error = String::from_utf8(output.stderr).unwrap();
    assert!(
        output.status.code() == Some(2) && error.contains("--vary: stop.gap=0.8:1.2:40 there"),
        "{error}"
    );
    assert!(out.join("sweep.parts").exists());
}

#[test]
fn each_kind_of_designs_has_its_picture() {
    let has = |name: &str, arguments: &[&str], words: &[&str]| {
        let out = swept(name, &[arguments, &QUICK[..]].concat());
        let svg = std::fs::read_to_string(out.join("sweep.svg")).unwrap();
        words.iter().for_each(|word| assert!(svg.contains(word), "{name}: {word}"));
        assert!(!svg.contains("NaN"));
    };
    has(
        "sweep-lines",
        &["--vary", "f10=1:2:4", "--output", "amplitude.x1,amplitude.w"],
        &["amplitude of x₁ (m)", "Not drawn, since it is the same at all designs: amplitude of w is 1 m."],
    );
    // A small gap, given in m: lengths in mm; constant parameters are listed with their units.
    let machine = Path::new(env!("CARGO_TARGET_TMPDIR")).join("sweep-damper.toml");
    let text = "[si]\nbox.m = 12\nbox.k = 48e3\nbox.c = 30\nblock.m = 1.2\nstop.gap = 0.015\nstop.restitution = 0.6\n\
        drive.amplitude = 75\ndrive.frequency = \"10 Hz\"\ncoupling.k = 0\nsecondary.m = 1\nsecondary.k = 1e3\nsecondary.c = 1\n";
    std::fs::write(&machine, text).unwrap();
    let over = ["--config", machine.to_str().unwrap(), "--vary", "drive.frequency=9.9Hz,10Hz"];
    let told = ["amplitude of x₁ (mm)", "Designs over ω₁/2π", "amplitude of w is 15 mm."];
    has("sweep-mm", &[&over[..], &["--output", "amplitude.x1,amplitude.w"]].concat(), &told);
    let masses = ["--vary", "block.m=1kg,1.2kg", "--output", "amplitude.x1"];
    has("sweep-mm-map", &[&over[..], &masses].concat(), &["least, ", " mm<"]);
    has(
        "sweep-map",
        &["--vary", "f10=1:2:4", "--vary", "kappa=0.4,0.5,0.8", "--output", "amplitude.x1"],
        &["least, ", "0.8"],
    );
    let three = ["--vary", "f10=1:2:3", "--vary", "kappa=0.4:0.8:3", "--vary", "L=0.9:1.1:2"];
    has("sweep-three", &[&three[..], &["--output", "rms.x1"]].concat(), &["rms of x₁; least over L"]);
    let sobol = ["--vary", "f10=1:2", "--vary", "kappa=0.4:0.8", "--sobol", "9", "--output", "rms.x1"];
    has("sweep-sobol", &sobol, &["9 designs (points of the Sobol sequence)"]);
    // A design whose mass ratio excludes its frequency.
    let bad = ["--vary", "epsilon=0.1,0.5,0.9", "--vary", "sigma1=-2,1", "--output", "impacts"];
    has("sweep-bad", &bad, &["no value"]);
    let one = swept("sweep-single", &[&["--output", "impacts"], &QUICK[..]].concat());
    assert!(!one.join("sweep.svg").exists() && table(&one, "sweep.csv").len() == 1);
}

#[test]
fn bad_input_is_refused_by_name() {
    for (arguments, expected) in [
        (vec!["--output", "amplitud.x1"], "did you mean `amplitude.x1`? `amplitude.x1`: largest |x1|"),
        (vec!["--output", "temperature"], "expected one of amplitude.x1"),
        (vec!["--vary", "stop.gape=1:2:3"], "did you mean `stop.gap`?"),
        (vec!["--vary", "stop.gap=1kg:2kg:3"], "`kg` is not one of its units"),
        (vec!["--vary", "kappa=0.5:1.5:3"], "kappa = 1.5: expected 0 <= kappa <= 1"),
        (
            vec!["--vary", "kappa=0.1:0.5:3", "--over", "stop.restitution=0.5"],
            "determine the same quantity; vary one of them",
        ),
        (vec!["--vary", "f10=1:2:999999", "--vary", "kappa=0:1:9"], "1 to 1000000 designs"),
        (vec!["--vary", "f10=1:2:5", "--sobol", "8"], "without a count"),
        (vec!["--sobol", "8"], "--sobol with 0 parameters"),
        (vec!["--design", "none.csv"], "none.csv"),
        (vec!["--design", "none.csv", "--vary", "f10=1:2"], "cannot be used with"),
        (vec!["--start", "x9=1"], "x1=0.2,v2=1"),
        (vec!["--periods", "0"], "expected a whole number from 1"),
        (vec!["--periods", "1e3"], "'1e3' for '--periods <N>': expected a whole number from 1 to 1000000"),
        (vec!["--threads=-1"], "'-1' for '--threads <N>': expected a whole number from 1 to 65535"),
        (vec!["--discard=99999999999"], "for '--discard <N>': expected a whole number from 0 to 4294967295"),
    ] {
        let (code, error) = refused(&[&["sweep"], &arguments[..]].concat());
        assert!(code == 2 && error.contains(expected), "{arguments:?}: {error}");
    }
}

#[test]
fn all_outputs_are_listed_and_can_be_asked_for() {
    let text = drawn(&folder("sweep-list"), &["sweep", "--list"]);
    let names: Vec<&str> = text.lines().skip(1).filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(names.len(), 44);
    let out = swept("sweep-all", &["--output", &names.join(","), "--discard", "5", "--periods", "2"]);
    let rows = table(&out, "sweep.csv");
    assert!(names.iter().all(|name| !rows[0][*name].is_empty()), "{rows:?}");
}
