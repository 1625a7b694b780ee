//! Runs the real `vibro orbits`, `orbit` and `locus`: the closed form, tables from which other
//! studies start, the same bytes for any number of threads, bad input.

#[path = "common/mod.rs"]
mod command;

use command::{begun, command as vibro, drawn, folder, killed, parts, refused, table};

/// Fifteen digits are written, and points are located with about as many.
const LOCATION: f64 = 1e-11;

#[test]
fn closed_form_of_the_branch_with_a_word_and_its_curve_in_two_parameters() {
    let out = folder("orbits-word");
    drawn(&out, &["orbits", "--word", "U-", "--vary", "f10=0.5:3"]);
    let rows = table(&out, "special-points.csv");
    let find =
        |label: &str| rows.iter().position(|r| r["label"] == label).unwrap_or_else(|| panic!("{label}"));
    // The symmetry breaks at the closed form's value.
    let breaking = find("BP");
    assert!((rows[breaking]["value"].parse::<f64>().unwrap() - 2.039_588_865_238_452).abs() < LOCATION);
    assert_eq!((&*rows[breaking]["stable_before"], &*rows[breaking]["stable_after"]), ("true", "false"));
    assert!(rows.iter().all(|r| r["word"] == "U" && r["closing"] == "-" && r["period"] == "1"));
    let point = |i: usize| format!("{}:{}", out.join("special-points.csv").display(), i + 1);
    let curves = folder("orbits-locus");
    let ranges = ["--vary", "f10=0.5:3", "--vary", "kappa=0.7:0.8"];
    let points = [point(find("BP")), point(find("LP"))];
    let from = ["--from", &points[0], "--from", &points[1]];
    drawn(&curves, &[&["locus"][..], &from, &ranges].concat());
    let rows = table(&curves, "locus.csv");
    assert!(rows.len() > 20 && curves.join("locus.png").exists());
    for row in rows.iter().filter(|r| r["label"] == "LP") {
        // At a fold the discriminant of the closed form is zero.
        let [f10, kappa] = ["f10", "kappa"].map(|c| row[c].parse::<f64>().unwrap());
        let mut set = vibro_studies::paper::ParameterSet::basic();
        set.apply(&[format!("f10={f10}"), format!("kappa={kappa}")]).unwrap();
        let family = vibro_impact::steady::exact_orbit::OrbitFamily::new(set.parameters()).unwrap();
        assert!(family.discriminant().abs() < LOCATION, "{row:?}");
    }
}

#[test]
fn a_tree_has_the_same_bytes_for_any_number_of_threads() {
    let bytes = |threads: &str| {
        let out = folder(&format!("orbits-tree-{threads}"));
        let range =
            ["--vary", "f10=2.0:2.6", "--seeds", "4", "--starts", "16", "--depth", "1", "--threads", threads];
        drawn(&out, &[&["orbits", "--tree"][..], &range].concat());
        ["branches.csv", "special-points.csv", "orbits-search.csv", "orbits.svg"]
            .map(|name| std::fs::read(out.join(name)).unwrap())
    };
    assert_eq!(bytes("1"), bytes("3"));
}

/// A tree of many rounds, each a fraction of a second.
const TREE: [&str; 10] =
    ["orbits", "--tree", "--vary", "f10=2:3", "--seeds", "5", "--starts", "8", "--depth", "3"];

#[test]
fn an_interrupted_tree_goes_on_to_the_same_bytes() {
    let (out, whole) = (folder("orbits-interrupted"), folder("orbits-whole"));
    killed(begun(&out, &[&TREE[..], &["--threads", "1"]].concat(), "orbits", 2));
    let kept = parts(&out, "orbits").len();
    assert!(kept >= 2 && !out.join("branches.csv").exists());
    // Another tree is refused and does not touch the parts.
    let other = [&TREE[..], &["--mark", "2.5"]].concat();
    let refusal = vibro(&out, &other).output().expect("vibro runs");
    let message = String::from_utf8_lossy(&refusal.stderr).into_owned();
    let words = format!("holds {kept} finished parts of another run");
    assert!(refusal.status.code() == Some(2) && message.contains(&words), "{message}");
    drawn(&out, &TREE);
    drawn(&whole, &TREE);
    for name in ["branches.csv", "special-points.csv", "orbits.svg"] {
        assert!(std::fs::read(out.join(name)).unwrap() == std::fs::read(whole.join(name)).unwrap(), "{name}");
    }
    assert!(!out.join("orbits.parts").exists());
}

#[test]
fn rows_are_chosen_by_label_and_value_and_one_that_fails_leaves_the_others() {
    let out = folder("orbits-rows");
    drawn(&out, &["orbits", "--word", "U-", "--vary", "f10=0.5:3"]);
    let rows = table(&out, "special-points.csv");
    let file = out.join("special-points.csv").display().to_string();
    let curves = |name: &str, from: &[&str]| {
        let folder = folder(name);
        let from: Vec<String> = from.iter().map(|choice| format!("{file}{choice}")).collect();
        let from: Vec<&str> = from.iter().flat_map(|f| ["--from", f]).collect();
        let said = drawn(
            &folder,
            &[&["locus"], &from[..], &["--vary", "f10=0.3:3", "--vary", "kappa=0.74:0.76"]].concat(),
        );
        let mut labels: Vec<String> =
            table(&folder, "locus.csv").iter().map(|r| r["label"].clone()).collect();
        labels.dedup();
        (labels, said)
    };
    // The symmetry breaks at 2.03958…, to the written digits.
    assert_eq!(curves("locus-value", &[":BP@2.04"]).0, ["BP"]);
    assert_eq!(curves("locus-any", &[":@2.0396", ":LP"]).0, ["BP", "LP"]);
    let (message, row) = (
        refused(&[
            "locus",
            "--from",
            &format!("{file}:BP@2.1"),
            "--vary",
            "f10=0.3:3",
            "--vary",
            "kappa=0.7:0.8",
        ]),
        rows.len(),
    );
    assert!(
        message.0 == 2 && message.1.contains("the nearest is row") && message.1.contains("2.0395"),
        "{message:?}"
    );
    let message = refused(&[
        "locus",
        "--from",
        &format!("{file}:{}", row + 1),
        "--vary",
        "f10=0.3:3",
        "--vary",
        "kappa=0.7:0.8",
    ]);
    assert!(message.1.contains(&format!("has no row {}", row + 1)), "{message:?}");
    // A row whose phases belong to another machine.
    let text = std::fs::read_to_string(&file).unwrap();
    let spoilt = text.lines().map(|line| match line.starts_with("NS,") {
        true => line.rsplit_once(',').map_or(line.to_owned(), |(rest, _)| format!("{rest},1.5")),
        false => line.to_owned(),
    });
    std::fs::write(&file, spoilt.collect::<Vec<_>>().join("\n")).unwrap();
    let (labels, said) = curves("locus-all", &[""]);
    assert!(
        labels.contains(&"BP".into()) && labels.contains(&"LP".into()) && !labels.contains(&"NS".into()),
        "{labels:?}"
    );
    assert!(said.contains("no curve from") && said.contains("use the machine of the point"), "{said}");
}

#[test]
fn a_curve_that_ends_at_a_touch_says_so_in_table_picture_and_words() {
    let (out, curves) = (folder("orbits-touch"), folder("locus-touch"));
    drawn(&out, &["orbits", "--word", "UL", "--set", "f10=2.2", "--vary", "f10=2:3"]);
    let file = format!("{}:PD", out.join("special-points.csv").display());
    let said = drawn(&curves, &["locus", "--from", &file, "--vary", "f10=1:4", "--vary", "kappa=0.4:0.95"]);
    let rows = table(&curves, "locus.csv");
    let ends = |end: &str| rows.iter().filter(|r| r["end"] == end).count();
    assert!(ends("GR") > 0, "{said}");
    assert!(said.contains("GR ends where a contact comes in at ("), "{said}");
    let picture = std::fs::read_to_string(curves.join("locus.svg")).unwrap();
    assert!(picture.contains("GR ends where a contact comes in"));
}

#[test]
fn an_orbit_that_is_a_shorter_one_passed_twice_is_said_to_be_that() {
    // UL doubles its period at 2.373: below this value no separate ULUL orbit exists.
    let (once, twice) = (folder("orbit-once"), folder("orbit-twice"));
    drawn(&once, &["orbit", "--word", "UL", "--set", "f10=2.2"]);
    let said = drawn(&twice, &["orbit", "--word", "ULUL", "--period", "2", "--set", "f10=2.2"]);
    assert!(said.contains("ULUL+ over 2T is UL+ of 1T passed 2 times"), "{said}");
    let [a, b] = [&once, &twice].map(|out| table(out, "orbit-multipliers.csv"));
    for (a, b) in a.iter().zip(&b) {
        assert_eq!(a["of"], "whole period");
        let [a, b] = [a, b].map(|row| row["modulus"].parse::<f64>().unwrap());
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }
    // Above it there is one, which comes first.
    let said =
        drawn(&folder("orbit-own"), &["orbit", "--word", "ULUL", "--period", "2", "--set", "f10=2.43"]);
    assert!(said.contains("ULUL+ (period 2T)") && !said.contains("passed 2 times;"), "{said}");
    // The whole word of a symmetric orbit.
    let half = folder("orbit-half");
    let said = drawn(&half, &["orbit", "--word", "UL", "--set", "f10=1.5"]);
    assert!(
        said.contains("UL+ is U-, a symmetric orbit") && said.contains("of half the period, so"),
        "{said}"
    );
    assert_eq!(table(&half, "orbit-multipliers.csv")[0]["of"], "half period");
}

#[test]
fn orbits_of_a_block_without_a_spring_by_word_branch_and_tree() {
    let damper = [
        "--set",
        "box.m=12kg",
        "--set",
        "box.k=48kN/m",
        "--set",
        "box.c=30N.s/m",
        "--set",
        "block.m=1.1kg",
        "--set",
        "secondary.m=1kg",
        "--set",
        "secondary.k=4kN/m",
        "--set",
        "secondary.c=5N.s/m",
        "--set",
        "coupling.k=0",
        "--set",
        "stop.gap=18mm",
        "--set",
        "stop.restitution=0.5",
        "--set",
        "drive.amplitude=75N",
        "--set",
        "drive.frequency=10.05Hz",
    ];
    let with = |more: &[&'static str]| [more, &damper[..]].concat();
    let out = folder("orbit-free");
    let said = drawn(&out, &with(&["orbit", "--word", "U-"]));
    assert!(said.contains("of half the period"), "{said}");
    // Under gravity the upper stop is hit later than half a period after the lower one.
    let said = drawn(&folder("orbit-falls"), &with(&["orbit", "--word", "UL", "--load", "block=-1"]));
    assert!(said.contains("UL+ (period 1T)"), "{said}");
    let tree = folder("orbits-free");
    let said = drawn(
        &tree,
        &with(&[
            "orbits",
            "--tree",
            "--vary",
            "drive.frequency=9.3Hz:11Hz",
            "--seeds",
            "4",
            "--starts",
            "8",
            "--depth",
            "1",
        ]),
    );
    assert!(said.contains("from 8 starts in 1.5 times the range of the visited states"), "{said}");
    assert!(table(&tree, "special-points.csv").len() > 2);
    let starts: u32 =
        table(&tree, "orbits-search.csv").iter().map(|r| r["starts"].parse::<u32>().unwrap()).sum();
    assert_eq!(starts, 8);
}

#[test]
fn marked_values_are_rows_of_the_table() {
    let out = folder("orbits-marks");
    drawn(&out, &["orbits", "--word", "U-", "--vary", "f10=0.5:3", "--mark", "1.7,2.5", "--mark", "1.5"]);
    let rows = table(&out, "special-points.csv");
    let marked = rows.iter().filter(|r| r["label"] == "UZ").map(|r| r["value"].parse::<f64>().unwrap());
    let mut marked: Vec<f64> = marked.collect();
    marked.sort_by(f64::total_cmp);
    marked.dedup();
    assert_eq!(marked, [1.5, 1.7, 2.5]);
}

#[test]
fn one_orbit_with_its_impacts_and_multipliers() {
    let out = folder("orbit-three");
    let said = drawn(&out, &["orbit", "--word", "UUL", "--set", "f10=2.7"]);
    assert!(said.contains("stable: largest multiplier"), "{said}");
    let impacts = table(&out, "orbit-impacts.csv");
    assert_eq!(impacts.iter().map(|r| r["stop"].clone()).collect::<Vec<_>>(), ["1", "1", "-1"]);
    assert_eq!(table(&out, "orbit-multipliers.csv").len(), 6);
    assert!(out.join("orbit.png").exists());
    // The settled motion is the same orbit; a load of 0 changes nothing.
    let settled = folder("orbit-settled");
    drawn(&settled, &["orbit", "--set", "f10=2.7", "--load", "box=0"]);
    assert_eq!(table(&settled, "orbit-impacts.csv").len(), 3);
}

#[test]
fn what_cannot_be_is_refused_with_what_to_do() {
    for (arguments, words) in [
        (&["orbit", "--word", "UX"][..], "letters U and L"),
        (&["orbit", "--word", "UUUUUL"], "none was found from 400 guesses"),
        (&["orbit", "--word", "U-", "--load", "box=0.1"], "give the whole word"),
        (&["orbit", "--word", "U", "--set", "coupling.k=0"], "must contain both U and L"),
        (&["orbit", "--word", "UU", "--set", "coupling.k=0", "--load", "block=-0.01"], "must contain an L"),
        (
            &["locus", "--from", "no.csv:XX@2", "--vary", "f10=1:2", "--vary", "kappa=0.5:0.9"],
            "FILE:LABEL@VALUE",
        ),
        (&["orbit", "--set", "kappa=0.05", "--set", "f10=4.5"], "rests at a stop"),
        (&["orbits", "--word", "UL", "--vary", "f10=3:4"], "must lie in the range"),
        (&["orbits", "--vary", "kappa=0.5:1.5"], "kappa = 1.5"),
        (&["orbits", "--vary", "f10=1:2:10"], "without a count"),
        (&["orbits", "--load", "stop=1"], "box, block, secondary"),
        (&["orbits", "--mark", "7"], "must lie in the range 0.5 to 5"),
        (&["orbits", "--mark", "one"], "--mark: f10 = `one` is not a number"),
        (&["orbits", "--step", "0"], "'0' for '--step <X>': expected a number from 1e-5 to 0.2"),
        (&["orbits", "--step", "nan"], "'nan' for '--step <X>': expected a number from 1e-5 to 0.2"),
        (&["lyapunov", "--threshold", "abc"], "'abc' for '--threshold <X>': expected a finite number >= 0"),
        (&["lyapunov", "--threshold", "-1"], "'-1' for '--threshold <X>': expected a finite number >= 0"),
        (&["lyapunov", "--at", "1,one"], "--at: f10 = `one` is not a number"),
        (&["compare", "--values", "f10=1,5"], "--values f10`: expected values of epsilon"),
        (
            &["locus", "--from", "no.csv:1", "--vary", "f10=1:2", "--vary", "kappa=0.5:0.9"],
            "--from: no.csv: ",
        ),
        (
            &["locus", "--from", "no.csv", "--vary", "f10=1:2", "--vary", "kappa=0.5:0.9"],
            "expected a table of",
        ),
        (&["locus", "--from", "", "--vary", "f10=1:2", "--vary", "kappa=0.5:0.9"], "for '--from <"),
        (&["locus", "--from", ":1", "--vary", "f10=1:2", "--vary", "kappa=0.5:0.9"], "FILE:LABEL@VALUE"),
        (&["locus", "--from", "no.csv:1", "--vary", "f10=1:2"], "two parameters, e.g."),
    ] {
        let (code, message) = refused(arguments);
        assert!(code == 2 && message.contains(words), "{arguments:?}: {code} {message}");
    }
}
