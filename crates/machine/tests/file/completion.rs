//! Completion of a text that is being written, which uses the file's reader itself.

use std::collections::BTreeSet;
use vibro_machine::elements::SECTIONS;
use vibro_machine::file::{Completion, completion, no_records, parse};

use crate::refusals::SOUND;

/// The completion at the mark `|` in a text.
fn at(text: &str) -> Completion {
    let (head, tail) = text.split_once('|').expect("a mark");
    completion(head, tail)
}

fn names(text: &str) -> Vec<String> {
    at(text).offers.into_iter().map(|own| own.0).collect()
}

/// The text with the first offer taken.
fn taken(text: &str) -> String {
    let (head, tail) = text.split_once('|').expect("a mark");
    let found = completion(head, tail);
    let [before, after] = found.replaced;
    format!("{}{}{}", &head[..head.len() - before], found.offers[0].1, &tail[after..])
}

const MACHINE: &str = "name = \"A\"\n[body.ball]\nmass = 1.0\n[body.wheel]\ninertia = 1.0\n[body.table]\nmotion = { amplitude = \"1 mm\", frequency = 3.0 }\n";

#[test]
fn second_method_names_are_those_of_the_readers_refusal() {
    // The reader's error for a wrong word in the same place lists "expected one of …".
    for (open, wrong) in [
        (
            "[stop.a]\nbetween = [\"ground\", \"ball\"]\n|",
            "[stop.a]\nbetween = [\"ground\", \"ball\"]\nqqqqqqqqqq = 0",
        ),
        ("[body.ball2]\nmass = 1.0\nstart = { |", "[body.ball2]\nmass = 1.0\nstart = { qqqqqqqqqq = 0 }"),
        ("[damper.a]\nbetween = [\"|", "[damper.a]\nbetween = [\"qqqqqqqqqq\", \"ball\"]"),
        ("[link.a]\narms = { |", "[link.a]\narms = { qqqqqqqqqq = 1.0 }"),
        ("[block.c]\ninputs = [\"|", "[block.c]\ninputs = [\"qqqqqqqqqq\"]"),
        ("[load.a]\non = \"|", "[load.a]\non = \"qqqqqqqqqq\""),
        ("[load.a]\non = \"ball\"\nsweep = { |", "[load.a]\non = \"ball\"\nsweep = { qqqqqqqqqq = 1 }"),
    ] {
        let refused = parse(&format!("{MACHINE}{wrong}\n"), "a.toml", &no_records).unwrap_err().to_string();
        let told = refused.split("; expected one of ").nth(1).unwrap_or_else(|| panic!("{wrong}: {refused}"));
        let told: BTreeSet<&str> = told.lines().next().unwrap().split(", ").collect();
        let offered = names(&format!("{MACHINE}{open}"));
        let offered: BTreeSet<&str> = offered.iter().map(String::as_str).collect();
        let free: BTreeSet<&str> =
            told.into_iter().filter(|key| !open.contains(&format!("\n{key} ="))).collect();
        assert_eq!(offered, free, "{open}");
    }
}

#[test]
fn kinds_of_tables_keys_words_and_units_are_offered_where_they_may_stand() {
    let after = |text: &str| format!("{MACHINE}{text}");
    let all: Vec<&str> = ["parameters", "body"].into_iter().chain(SECTIONS.iter().map(|own| own.0)).collect();
    assert_eq!(names(&after("[|")), all);
    assert_eq!(names(&after("[fr|")), ["friction", "freewheel"]);
    assert_eq!(names("|"), ["name", "gravity", "start"]);
    assert_eq!(names("name = \"A\"\ngra|"), ["gravity"]);
    assert_eq!(names("start = \"|"), ["rest"]);
    let stop = "[stop.a]\nbetween = [\"ground\", \"ball\"]\n";
    assert_eq!(names(&after(&format!("{stop}gap = 4|"))), ["m", "cm", "mm", "um", "in"]);
    assert_eq!(names(&after(&format!("{stop}gap = \"-0.50 m|\"\nlaw"))), ["mm"]);
    assert_eq!(names(&after(&format!("{stop}stiffness = 1.0\nlaw = \"p|"))), ["pull"]);
    assert_eq!(
        names(&after("[friction.f]\nbetween = [\"ground\", \"|")),
        ["ball", "wheel", "table", "ground"]
    );
    assert_eq!(
        names(&after("[spring.s]\nbetween = [\"ground\", \"wheel\"]\nstiffness = 2|")).first().unwrap(),
        "N.m/rad"
    );
    assert_eq!(
        at(&after(&format!("{stop}gap = |"))).allowed,
        "expected a number in m, or with a unit: m, cm, mm, um, in"
    );
    assert_eq!(
        names(&after("[parameters]\nplay = 1.0\n[stop.b]\nbetween = [\"ground\", \"ball\"]\ngap = \"|")),
        ["= play"]
    );
    assert!(names(&after("[parameters]\nplay = \"1 rp|")).contains(&"rpm".to_owned()));
    // A list over several lines, unfinished.
    assert_eq!(
        names(&after("[load.a]\non = \"ball\"\nharmonics = [\n  { amplitude = 1.0, fr|\n")),
        ["frequency"]
    );
    // None in a comment, and none for a name that may be chosen freely.
    assert!(names(&after("# sti|")).is_empty());
    assert!(names(&after("[spring.s|")).is_empty());
    // Existing keys are not offered again.
    assert!(!names(&after("[body.b]\nmass = 1.0\n|")).contains(&"mass".to_owned()));
}

#[test]
fn an_offer_takes_the_place_of_the_whole_word() {
    for (text, found) in [
        ("[spring.s]\nst|if = 3.0\n", "[spring.s]\nstiffness = 3.0\n"),
        (
            "[spring.s]\nstif|\nbetween = [\"ground\", \"ball\"]",
            "[spring.s]\nstiffness = \nbetween = [\"ground\", \"ball\"]",
        ),
        (
            "[stop.a]\nbetween = [\"ground\", \"ball\"]\ngap = 4 c|",
            "[stop.a]\nbetween = [\"ground\", \"ball\"]\ngap = \"4 cm\"",
        ),
        ("[stop.a]\nbetween = [\"gr|\", \"ball\"]", "[stop.a]\nbetween = [\"ground\", \"ball\"]"),
        ("[stop.a]\nbetween = [\"ground\", \"ba|", "[stop.a]\nbetween = [\"ground\", \"ball\""),
        ("[fric|]", "[friction]"),
        ("[stop.a]\nbetween = [wh|, \"ball\"]", "[stop.a]\nbetween = [\"wheel\", \"ball\"]"),
    ] {
        assert_eq!(taken(&format!("{MACHINE}{text}")), format!("{MACHINE}{found}"));
    }
}

#[test]
fn invariant_every_key_and_unit_of_a_machine_is_offered_where_it_stands() {
    let (mut keys, mut units, mut begin) = (0, 0, 0);
    for line in SOUND.split_inclusive('\n') {
        // Complete words are not offered again: bytes after the position are omitted.
        let offered = |at: usize, left_out: usize| {
            let (head, tail) = SOUND.split_at(begin + at);
            completion(head, &tail[left_out..]).offers.into_iter().map(|own| own.0).collect::<Vec<String>>()
        };
        if let Some((key, _)) =
            line.split_once(" = ").filter(|(key, _)| key.chars().all(|c| c.is_alphabetic() || c == '_'))
        {
            assert!(offered(1, key.len() - 1).iter().any(|own| own == key), "{line}");
            keys += 1;
        }
        for (at, word) in line
            .match_indices('"')
            .collect::<Vec<_>>()
            .chunks(2)
            .map(|pair| (pair[0].0 + 1, &line[pair[0].0 + 1..pair[1].0]))
        {
            let Some((number, unit)) = word
                .split_once(' ')
                .filter(|(number, unit)| number.parse::<f64>().is_ok() && !unit.contains([' ', '·']))
            else {
                continue;
            };
            assert!(offered(at + number.len() + 1, unit.len()).iter().any(|own| own == unit), "{line}");
            units += 1;
        }
        begin += line.len();
    }
    assert!(keys > 30 && units > 10, "{keys} {units}");
}

#[test]
fn invariant_every_place_of_a_machine_is_answered_within_its_text() {
    for (at, _) in SOUND.char_indices() {
        let (head, tail) = SOUND.split_at(at);
        let [before, after] = completion(head, tail).replaced;
        assert!(head.is_char_boundary(head.len() - before) && tail.is_char_boundary(after));
    }
}
