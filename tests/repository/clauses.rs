//! Citations of the FMI standard (invariant): each clause exists and defines the cited names.

use crate::citations::{LINKS, flowing};
use crate::texts::{all, shown};

/// Clauses of the FMI standard, with the names that each defines.
const CLAUSES: &str = include_str!("../data/fmi-clauses.txt");

/// Clauses at the beginning of a text such as `2.3.1`, `2.4, 3.4 and 4.4`, `2.2.7 to 2.2.12`.
fn leading_clauses(mut text: &str) -> Vec<&str> {
    let mut clauses = Vec::new();
    loop {
        let end = text.find(|c: char| !(c.is_ascii_digit() || c == '.')).unwrap_or(text.len());
        let clause = text[..end].trim_end_matches('.');
        if !clause.contains('.') {
            return clauses;
        }
        clauses.push(clause);
        let rest = &text[clause.len()..];
        let Some(next) = LINKS.iter().find_map(|link| rest.strip_prefix(link)) else { return clauses };
        text = next;
    }
}

/// Functions and types in backquotes right before the bracket at the end of a text.
fn named_before(text: &str) -> Vec<&str> {
    let Some((mut text, bracket)) = text.rsplit_once('(') else { return Vec::new() };
    let mut names = Vec::new();
    while let Some(rest) = text.trim_end().strip_suffix('`')
        && let Some((before, name)) = rest.rsplit_once('`')
        && !bracket.contains(')')
    {
        names.push(name);
        text = before.strip_suffix(" and ").or(before.strip_suffix(", ")).unwrap_or("");
    }
    names
}

/// Citation of the standard: its version, the clauses, and the names said to be defined there.
type Citation<'t> = (&'t str, Vec<&'t str>, Vec<&'t str>);

/// Citations in a text: `FMI 2.0, 2.1.5`, `FMI 3.0.2 (2.4.8)`.
fn cited_clauses(text: &str) -> Vec<Citation<'_>> {
    let mentions = text.match_indices("FMI ").map(|(at, mark)| (&text[..at], &text[at + mark.len()..]));
    let cited = mentions.filter_map(|(before, rest)| {
        let (version, rest) = rest.split_at_checked(3).filter(|(v, _)| ["2.0", "3.0"].contains(v))?;
        let patch = rest.strip_prefix('.').and_then(|rest| rest.get(1..)).unwrap_or(rest);
        let clauses = leading_clauses(patch.strip_prefix(", ").or(patch.strip_prefix(" ("))?);
        (!clauses.is_empty()).then(|| (version, clauses, named_before(before)))
    });
    cited.collect()
}

/// Functions of a door's tables, with the clauses above them.
fn headed_clauses<'t>(text: &'t str, version: &'t str) -> Vec<Citation<'t>> {
    let (mut clauses, mut cited) = (Vec::new(), Vec::new());
    for line in text.lines().map(str::trim) {
        if let Some(heading) = line.strip_prefix('"').and_then(|rest| rest.strip_suffix("\":")) {
            clauses = leading_clauses(heading);
        } else if let Some((name, _)) = line.split_once(", ").filter(|(name, _)| name.starts_with("fmi"))
            && name.bytes().all(|b| b.is_ascii_alphanumeric())
            && !clauses.is_empty()
        {
            cited.push((version, clauses.clone(), vec![name]));
        }
    }
    cited
}

/// Version, number and title of each listed clause; the names that it defines follow a colon in
/// the title.
fn listed_clauses() -> Vec<(&'static str, &'static str, &'static str)> {
    let lines = CLAUSES.lines().filter(|line| !line.starts_with('#'));
    let parts = lines
        .map(|line| line.split_once(' ').and_then(|(version, rest)| Some((version, rest.split_once(' ')?))));
    parts
        .map(|parts| parts.map(|(version, (number, title))| (version, number, title)).expect("three parts"))
        .collect()
}

/// Errors of a citation: missing clauses, and names defined by other clauses.
fn problems((version, clauses, names): &Citation<'_>, listed: &[(&str, &str, &str)]) -> Vec<String> {
    let there = |clause: &str| listed.iter().any(|(v, c, _)| v == version && *c == clause);
    let missing = clauses.iter().filter(|clause| !there(clause));
    let mut wrong: Vec<String> = missing.map(|clause| format!("FMI {version} has no {clause}")).collect();
    for name in names {
        let defined =
            |text: &str| text.split_once(": ").is_some_and(|(_, own)| own.split(' ').any(|n| n == *name));
        let defining = listed.iter().filter(|(v, _, text)| v == version && defined(text));
        let at: Vec<&str> = defining.map(|line| line.1).collect();
        let within = |own: &&str| clauses.iter().any(|c| own == c || own.starts_with(&format!("{c}.")));
        if !at.is_empty() && !at.iter().any(within) {
            wrong.push(format!("{name} is defined in {at:?}, not in {clauses:?}"));
        }
    }
    wrong
}

#[test]
fn invariant_every_clause_of_fmi_that_is_cited_defines_what_is_said() {
    let listed = listed_clauses();
    let (mut wrong, mut cited, mut named) = (Vec::new(), 0, 0);
    for (path, text) in all() {
        let place = shown(&path);
        let text = if place == "docs/fmu.md" { standing_apart(&text) } else { text };
        let flowing = flowing(&text);
        let mut found = cited_clauses(&flowing);
        for (folder, version) in [("crates/doors/src/fmi2/abi", "2.0"), ("crates/doors/src/fmi3/abi", "3.0")]
        {
            if place.starts_with(folder) {
                found.extend(headed_clauses(&text, version));
            }
        }
        for citation in found {
            cited += citation.1.len();
            named += citation.2.len();
            wrong.extend(problems(&citation, &listed).into_iter().map(|what| format!("{place}: {what}")));
        }
    }
    assert!(wrong.is_empty(), "not so in the standard: {wrong:#?}");
    println!("{cited} citations, {named} names");
    assert!(cited > 200 && named > 150, "{cited} citations, {named} names");
    // The parts of a citation are found; a missing clause and a clause that does not define the
    // names are reported.
    let text = "`fmi2A` and `fmi3DoStep` (FMI 2.0, 2.1.8; FMI 3.0.2, 2.2.7 to 2.2.99)";
    let names = vec!["fmi3DoStep", "fmi2A"];
    let expected = [("2.0", vec!["2.1.8"], names.clone()), ("3.0", vec!["2.2.7", "2.2.99"], names)];
    assert_eq!(cited_clauses(text), expected);
    assert_eq!(problems(&expected[0], &listed), [""; 0]);
    assert_eq!(problems(&expected[1], &listed).len(), 2);
}

/// The page of FMUs, with the standard's name inserted before each clause of the section that
/// omits it.
fn standing_apart(page: &str) -> String {
    let (before, rest) = page.split_once("The clauses are from version 3.0.2.").expect("the section");
    let (section, after) = rest.split_once("\n## ").expect("a section behind it");
    let marked = section.split('(').map(|part| {
        let digit = part.starts_with(|c: char| c.is_ascii_digit());
        if digit { format!("(FMI 3.0.2, {part}") } else { format!("({part}") }
    });
    format!("{before}{}\n{after}", marked.collect::<String>())
}
