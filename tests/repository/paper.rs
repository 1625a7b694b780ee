//! The paper about the software: sections and length that the journal asks for (invariant).

use crate::texts::root;
use std::fs;

/// Sections of a paper of the Journal of Open Source Software, in its order (its page "JOSS Paper
/// Format", read in November 2026).
const SECTIONS: [&str; 8] = [
    "Summary",
    "Statement of need",
    "State of the field",
    "Software design",
    "Research impact statement",
    "AI usage disclosure",
    "Acknowledgements",
    "References",
];
/// Number of words that the journal asks for.
const WORDS: std::ops::RangeInclusive<usize> = 750..=1750;
/// Fewest words of a section that has a text.
const SECTION: usize = 15;

#[test]
fn invariant_the_paper_has_the_journals_sections_and_length() {
    let text = fs::read_to_string(root().join("docs/paper/paper.md")).expect("docs/paper/paper.md");
    let (_, body) = text.split_once("\n---\n").expect("a header");
    let words = body.split_whitespace().count();
    assert!(WORDS.contains(&words), "{words} words, expected {WORDS:?}");
    let sections: Vec<&str> = body.split("\n# ").skip(1).collect();
    let names: Vec<&str> = sections.iter().map(|section| section.lines().next().unwrap_or("")).collect();
    assert_eq!(names, SECTIONS);
    for section in &sections[..SECTIONS.len() - 1] {
        assert!(section.split_whitespace().count() > SECTION, "a section without a text: {section}");
    }
    let bibliography = fs::read_to_string(root().join("docs/paper/paper.bib")).expect("paper.bib");
    let cited = body
        .split('@')
        .skip(1)
        .map(|rest| rest.split(|c: char| !c.is_alphanumeric()).next().expect("the key of a reference"));
    let keys: Vec<&str> = cited.collect();
    assert!(keys.len() > 5, "{keys:?}");
    for key in keys {
        assert!(bibliography.contains(&format!("{{{key},")), "paper.bib has no {key}");
    }
}
