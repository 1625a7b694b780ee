//! The commands of docs/design-a-damper.md, with a grid reduced to the neighbourhood of the
//! choice, and the numbers that the page states.

#[path = "common/guide.rs"]
mod guide;

use guide::Guide;
use std::collections::HashMap;
use std::path::Path;

/// Relative tolerance of irregular motion: its largest amplitude over 60 periods depends on last
/// digits, which depend on the processor.
const IRREGULAR: f64 = 0.1;
/// Relative tolerance of a number with about three digits.
const THREE_DIGITS: f64 = 0.006;

/// Mass (kg), gap (m) and restitution coefficient of the choice.
const CHOICE: [f64; 3] = [1.2, 0.016, 0.5];

/// The grid reduced to the choice and its neighbours.
const SHORTENED: [(&str, &str); 3] = [
    ("block.m=0.2kg:1.2kg:11", "block.m=1.1kg,1.2kg"),
    ("stop.gap=2mm:24mm:12", "stop.gap=14mm,16mm,18mm"),
    ("stop.restitution=0.5:0.9:9", "stop.restitution=0.5,0.55"),
];

fn home() -> std::path::PathBuf {
    Path::new(env!("CARGO_TARGET_TMPDIR")).join("tutorial")
}

/// The rows of a table by their columns.
fn table(name: &str) -> Vec<HashMap<String, String>> {
    let mut reader = csv::Reader::from_path(home().join(name)).expect("a table");
    reader.deserialize().collect::<Result<_, _>>().expect("rows")
}

fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    row[column].parse().expect("a number")
}

fn largest(rows: &[HashMap<String, String>], column: &str) -> f64 {
    rows.iter().map(|row| number(row, column)).fold(0.0, f64::max)
}

/// The number at the `#` of these words, where they first occur in the page.
fn told(page: &str, words: &str) -> f64 {
    let plain = page.split_whitespace().collect::<Vec<_>>().join(" ");
    let (before, after) = words.split_once('#').expect("a # for the number");
    let found = plain.match_indices(before).find_map(|(i, _)| {
        let rest = &plain[i + before.len()..];
        let end = rest.find(|c: char| !(c.is_ascii_digit() || c == '.'))?;
        // A full stop ends the sentence and is not part of the number.
        let end = rest[..end].trim_end_matches('.').len();
        rest[end..].starts_with(after).then(|| rest[..end].parse().ok()).flatten()
    });
    found.unwrap_or_else(|| panic!("the page does not say `{words}`"))
}

fn close(told: f64, found: f64, tolerance: f64) {
    assert!((told / found - 1.0).abs() < tolerance, "the page says {told}, the commands {found}");
}

/// All texts of a picture.
fn texts(svg: &str) -> Vec<&str> {
    svg.split("<text").skip(1).filter_map(|t| t.split_once('>')?.1.split('<').next()).collect()
}

#[test]
fn the_tutorial_says_what_its_commands_find() {
    let guide = Guide::read("design-a-damper.md");
    let page = guide.text();
    let said = guide.perform("tutorial", &SHORTENED);

    // 2. Over the band.
    let first = table("first/sweep.csv");
    close(
        told(page, "the box moves by # mm at resonance"),
        1e3 * largest(&first, "amplitude.without_block"),
        THREE_DIGITS,
    );
    close(told(page, "the box now moves by # mm"), 1e3 * largest(&first, "amplitude.x1"), IRREGULAR);
    // 3. One motion, periodic.
    let rows = guide::rows("tutorial", "look/run.csv");
    let amplitude = rows.iter().map(|row| row[1].abs()).fold(0.0, f64::max);
    close(told(page, "(of the box # mm)"), 1e3 * amplitude, THREE_DIGITS);
    let impacts = guide::rows("tutorial", "look/run-impacts.csv");
    close(
        told(page, "the impacts (# m/s and "),
        impacts.iter().map(|row| row[2]).fold(0.0, f64::max),
        THREE_DIGITS,
    );
    assert!(said.iter().any(|text| text.contains("class: 1T")));
    // 4. The choice and its neighbours.
    let designs = table("designs/sweep.csv");
    assert_eq!(designs.len(), 2 * 3 * 2);
    let design = |mass: f64, gap: f64, coefficient: f64| {
        let same = |row: &HashMap<String, String>, name, value: f64| (number(row, name) - value).abs() < 1e-9;
        let of = |row: &&HashMap<String, String>| {
            same(row, "block.m", mass)
                && same(row, "stop.gap", gap)
                && same(row, "stop.restitution", coefficient)
        };
        designs.iter().find(of).expect("a design")
    };
    let (mass, gap) = (told(page, "has a block of # kg"), told(page, "a gap of # mm and stops") / 1e3);
    let coefficient = told(page, "a coefficient of #. It brings");
    assert_eq!([mass, gap, coefficient], CHOICE);
    let choice = design(mass, gap, coefficient);
    close(
        told(page, "brings the box from # mm"),
        1e3 * number(choice, "amplitude.without_block.max"),
        THREE_DIGITS,
    );
    close(told(page, "to # mm at worst"), 1e3 * number(choice, "amplitude.x1.max"), IRREGULAR);
    close(told(page, "impacts of up to # N s"), number(choice, "impact.impulse.max"), IRREGULAR);
    let below = 1e-3 * told(page, "stay below # mm");
    for (m, l, k) in [(1.1, gap, 0.5), (mass, 0.014, 0.5), (mass, 0.018, 0.5), (mass, gap, 0.55)] {
        assert!(number(design(m, l, k), "amplitude.x1.max") < below * (1.0 + IRREGULAR), "{m} {l} {k}");
    }
    // After measuring again the choice is the best; after 60 periods last digits decide which one
    // is.
    let text =
        said.iter().find(|text| text.contains("designs over block.m")).expect("the best are measured again");
    let mut lines = text.lines().skip_while(|line| !line.contains("by amplitude.x1: "));
    let first = lines.find(|line| line.contains(" at block.m = ")).expect("the best");
    assert!(first.contains("block.m = 1.2 kg, stop.gap = 16 mm, stop.restitution = 0.5"), "{first}");
    // The parameter file of the page describes the choice.
    let mut set = vibro_studies::paper::ParameterSet::basic();
    vibro::parameter_file::apply(&mut set, &std::fs::read_to_string(home().join("design.toml")).unwrap())
        .unwrap();
    let p = set.parameters();
    assert_eq!([p.block_mass, p.stop_gap, p.stop_restitution], CHOICE);
    // 5. The check.
    let check = table("check/sweep.csv");
    assert!(check.iter().all(|row| row["reason"].is_empty()));
    close(told(page, "The worst amplitude is # mm"), 1e3 * largest(&check, "amplitude.x1.max"), IRREGULAR);

    // The pictures of the page equal the commands' pictures. Words are compared, because curves
    // may differ in last digits.
    for (picture, file) in [
        ("first", "first/sweep.svg"),
        ("look", "look/run.svg"),
        ("check", "check/sweep.svg"),
        ("theory", "theory/response-drive.frequency-x1.svg"),
        ("maxima", "maxima/bifurcation-x1.svg"),
    ] {
        let committed =
            Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../docs/design-a-damper/{picture}.svg"));
        if std::env::var_os("UPDATE").is_some() {
            std::fs::copy(home().join(file), &committed).expect("docs can be written");
        }
        let (drawn, committed) = (
            std::fs::read_to_string(home().join(file)).unwrap(),
            std::fs::read_to_string(&committed).unwrap(),
        );
        assert_eq!(
            texts(&drawn),
            texts(&committed),
            "{picture}: UPDATE=1 draws the pictures anew; look at them"
        );
    }
}
