//! Damaged texts: each is read or refused with a message, without a panic.

use proptest::prelude::*;
use proptest::sample::Index;
use vibro_machine::file::{no_records, parse};

use crate::refusals::SOUND;

/// Pieces of text with a meaning in TOML or in a machine's file.
const PIECES: [&str; 24] = [
    "[",
    "]",
    "{",
    "}",
    "=",
    "\"",
    "'",
    "\n",
    ",",
    ".",
    "#",
    "-",
    "1e999",
    "nan",
    "inf",
    "\"\"\"",
    "[[",
    "é",
    "\u{0}",
    "ground",
    "box",
    "1979-05-27",
    "true",
    "0x",
];

fn is_refused_with_words(text: &str) {
    if let Err(refusal) = parse(text, "damaged.toml", &no_records) {
        assert!(!refusal.problems.is_empty());
        assert!(refusal.to_string().starts_with("damaged.toml:"), "{refusal}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn invariant_a_damaged_file_never_panics(
        cuts in prop::collection::vec((any::<Index>(), 0..40_usize, prop::sample::select(&PIECES[..]), 0..3_usize), 1..6),
    ) {
        let mut text: Vec<char> = SOUND.chars().collect();
        for (at, length, piece, what) in cuts {
            let at = at.index(text.len().max(1)).min(text.len());
            let end = (at + length).min(text.len());
            match what {
                0 => { text.splice(at..end, piece.chars()); }
                1 => { text.splice(at..at, piece.chars()); }
                _ => text.truncate(at.max(1)),
            }
        }
        is_refused_with_words(&text.into_iter().collect::<String>());
    }

    #[test]
    fn invariant_any_text_is_read_or_refused(text in "\\PC{0,200}") {
        is_refused_with_words(&text);
    }
}

#[test]
fn invariant_deep_nesting_and_long_words_are_refused_at_once() {
    let deep = 100_000;
    for text in [
        format!("name = {}1{}", "[".repeat(deep), "]".repeat(deep)),
        format!("name = {}1{}", "{a=".repeat(deep), "}".repeat(deep)),
        format!("[{}a]\nb = 1", "a.".repeat(deep)),
        format!("{}a = 1", "a.".repeat(deep)),
        format!("name = \"{}\"", "n".repeat(1 << 20)),
        format!("name = \"Long\"\n[body.b]\nmass = \"{}\"", "1".repeat(1 << 20)),
        format!("name = \"Long\"\n[body.b]\n{} = 1.0", "m".repeat(1 << 20)),
        format!("name = \"Long\"\n[body.b]\nmass = {}", "1".repeat(1 << 20)),
    ] {
        let refusal = parse(&text, "m.toml", &no_records).expect_err("no machine");
        assert!(refusal.to_string().len() < 10_000, "{}", refusal.to_string().len());
    }
}

#[test]
fn invariant_more_elements_than_allowed_are_refused() {
    let spring = |i: usize| format!("[spring.s{i}]\nbetween = [\"ground\", \"b\"]\nstiffness = 1.0\n");
    let springs: String = (0..10_001).map(spring).collect();
    let text = format!("name = \"Many\"\n[body.b]\nmass = 1.0\n{springs}");
    let refusal = parse(&text, "m.toml", &no_records).unwrap_err();
    assert_eq!(refusal.to_string(), "m.toml: elements: there are 10001; expected at most 10000");
}

/// Thousands of problems are reported at once, in a readable message.
#[test]
fn invariant_thousands_of_problems_are_counted() {
    let body = |i: usize| format!("[body.b{i}]\nmass = 1.0\n[spring.s{i}]\nbetween = [\"c{i}\", \"d{i}\"]\n");
    let text: String = std::iter::once("name = \"Wrong\"\n".into()).chain((0..5_000).map(body)).collect();
    let refusal = parse(&text, "m.toml", &no_records).unwrap_err();
    assert_eq!(refusal.problems.len(), 15_000, "two ends and a stiffness each");
    let said = refusal.to_string();
    assert!(said.lines().count() == 51 && said.ends_with("and 14950 more"), "{said}");
}
