//! Citations have targets (invariant): documents, equations, sections, tests.

use crate::texts::{all, root, shown};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

/// Words that may name a file: letters, digits and `/._-`.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || "/._-".contains(c))).map(|word| word.trim_end_matches('.'))
}

#[test]
fn invariant_every_document_that_is_cited_is_in_the_repository() {
    let mut missing = BTreeSet::new();
    for (path, text) in all() {
        for word in
            words(&text).filter(|word| word.ends_with(".md") && word.len() > 3 && !word.starts_with('/'))
        {
            // Relative to the file, to its package, to the root, or the name of a page in docs/.
            let beside = path.parent().expect("a file is in a folder");
            let package = beside.ancestors().find(|folder| folder.join("Cargo.toml").exists());
            let folders = [beside, package.unwrap_or(root()), root(), &root().join("docs")];
            let there = folders.iter().any(|folder| folder.join(word).exists());
            // Licences in the packed archive and in other packages, the notes that a release makes, and
            // pages that a build copies into the Python package are not in the repository.
            let copied = word.starts_with("package/vibro_impact/");
            let others = word.contains("LICENSE") || word.ends_with("RELEASE_NOTES.md") || copied;
            if !there && !others {
                missing.insert(format!("{}: {word}", shown(&path)));
            }
        }
    }
    assert!(missing.is_empty(), "cited and not there: {missing:#?}");
}

/// Texts before and after each mention of a page, where a part of the page may be cited:
/// `(12) of docs/theory.md`, `theory.md (12)`, `[theory.md](theory.md), section 2`.
fn around<'t>(text: &'t str, page: &'t str) -> impl Iterator<Item = (&'t str, &'t str)> {
    text.match_indices(page).map(move |(at, _)| {
        let before = text[..at].trim_end_matches("docs/").trim_end_matches(['`', '[']);
        (before, text[at + page.len()..].trim_start_matches(['`', ')', ']']))
    })
}

/// Separators between the parts of one citation.
pub const LINKS: [&str; 3] = [", ", " and ", " to "];

/// Label of an equation in brackets at the beginning of a text, such as `(12)` or `(A3)`, and the
/// text after it.
fn leading_label(text: &str) -> Option<(&str, &str)> {
    let (label, rest) = text.strip_prefix('(')?.split_once(')')?;
    let digits = label.trim_start_matches(['A', 'N']);
    let number = !digits.is_empty() && digits.len() <= 3 && digits.bytes().all(|b| b.is_ascii_digit());
    (number && label.len() - digits.len() <= 1).then_some((label, rest))
}

/// Labels at the beginning of a text such as `(12)`, `(12), (13)`, `(12) to (14)`.
fn leading_labels(mut text: &str) -> Vec<&str> {
    let mut labels = Vec::new();
    while let Some((label, rest)) = leading_label(text) {
        labels.push(label);
        text = LINKS.iter().find_map(|link| rest.strip_prefix(link)).unwrap_or("");
    }
    labels
}

/// All labels in a text, without arguments of calls and numbers in formulas.
fn labels(text: &str) -> impl Iterator<Item = &str> {
    let begins = text.match_indices(" (").map(|(at, _)| &text[at + 1..]);
    begins.filter_map(leading_label).map(|(label, _)| label)
}

/// The labels of a page's equations with this letter, in the order of the page.
fn ordered_equations(page: &str, letter: &str) -> Vec<String> {
    let text = fs::read_to_string(root().join("docs").join(page)).expect("a page of docs");
    let of = |mark: &str| -> Vec<String> {
        let ends = text.split(mark).skip(1).filter_map(|rest| rest.split_once('}'));
        ends.map(|(label, _)| label.to_owned()).collect()
    };
    let own =
        |label: &String| label.trim_start_matches(char::is_alphabetic).len() + letter.len() == label.len();
    let of_letter = |label: &String| label.starts_with(letter) && own(label);
    of("\\tag{").into_iter().chain(of("(\\mathrm{")).filter(of_letter).collect()
}

/// Pages with numbered equations, and the letter of their labels. The rules of studies are an
/// appendix of the page of theory.
const NUMBERED: [(&str, &str); 3] = [("theory.md", ""), ("assembly-law.md", "A"), ("theory.md", "N")];

#[test]
fn invariant_equations_are_numbered_in_the_order_of_their_page() {
    for (page, letter) in NUMBERED {
        let found = ordered_equations(page, letter);
        let expected: Vec<String> = (1..=found.len()).map(|number| format!("{letter}{number}")).collect();
        assert_eq!(found, expected, "{page}: renumber the equations and all citations of them");
    }
}

#[test]
fn invariant_every_equation_that_is_cited_is_on_its_page() {
    let [theory, law, studies] =
        NUMBERED.map(|(page, letter)| ordered_equations(page, letter).into_iter().collect::<BTreeSet<_>>());
    assert!(theory.len() > 50 && law.len() > 20 && studies.len() > 4, "{law:?} {studies:?}");
    let (mut wrong, mut cited) = (Vec::new(), 0);
    for (path, text) in all() {
        let text = flowing(&text);
        let mut found: Vec<&str> = Vec::new();
        for (before, after) in around(&text, "theory.md") {
            found.extend(leading_labels(after.trim_start()));
            let last = before.strip_suffix(" of ").and_then(|b| leading_label(&b[b.rfind('(')?..]));
            found.extend(last.map(|(label, _)| label));
        }
        // Labels with a letter belong to one page each. On these pages any other label is one of
        // the theory page.
        let bare = ["theory.md", "numerics.md", "guarantees.md"].iter().any(|page| path.ends_with(page));
        found.extend(labels(&text).filter(|label| bare || label.starts_with(['A', 'N'])));
        cited += found.len();
        let of = |label: &str| match label.as_bytes()[0] {
            b'A' => law.contains(label),
            b'N' => studies.contains(label),
            _ => theory.contains(label),
        };
        wrong.extend(found.iter().filter(|l| !of(l)).map(|label| format!("{}: ({label})", shown(&path))));
    }
    assert!(wrong.is_empty(), "cited and not there: {wrong:#?}");
    println!("{cited} citations");
    assert!(cited > 400, "{cited} citations");
    // Each form of a citation is found.
    assert_eq!(leading_labels("(12) to (14)."), ["12", "14"]);
    assert_eq!(labels("as in (A3) f(x) (N5)").collect::<Vec<_>>(), ["A3", "N5"]);
    let before = around("the balance (90) of docs/theory.md is", "theory.md").next().expect("a mention").0;
    assert_eq!(before, "the balance (90) of ");
}

/// A text as one line, without the marks at the beginnings of comments' lines.
pub fn flowing(text: &str) -> String {
    let mut flowing = String::new();
    for line in text.lines() {
        let line = line.trim_start();
        let marks = ["///", "//!", "//", "#", "* "];
        let line = marks.iter().find_map(|mark| line.strip_prefix(mark)).unwrap_or(line);
        flowing.push_str(line.trim());
        flowing.push(' ');
    }
    flowing
}

/// Numbers and titles of a page's sections, with the paragraphs that begin in bold or italics.
fn sections(page: &str) -> (BTreeSet<usize>, String) {
    let mut numbers = BTreeSet::new();
    let mut titles = String::new();
    for line in page.lines() {
        let (heading, begun) = (line.trim_start_matches('#'), line.trim_start_matches(['-', ' ']));
        if heading != line {
            let number = heading.trim().split_once(". ").and_then(|(number, _)| number.parse().ok());
            numbers.extend::<Option<usize>>(number);
            titles.push_str(heading);
            titles.push('\n');
        } else if begun.starts_with('*') {
            titles.push_str(begun);
            titles.push('\n');
        }
    }
    (numbers, titles)
}

/// Numbers at the beginning of a text such as `1`, `1 and 2`, `6 to 9`, `1, 2 and 4`.
fn leading_numbers(mut rest: &str) -> Vec<usize> {
    let mut numbers = Vec::new();
    loop {
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let Ok(number) = rest[..digits].parse() else { return numbers };
        numbers.push(number);
        let tail = &rest[digits..];
        let Some(next) = [" and ", " to ", ", "].iter().find_map(|link| tail.strip_prefix(link)) else {
            return numbers;
        };
        rest = next;
    }
}

/// Numbers of sections that are cited right after a page's name or before it.
fn cited_sections(before: &str, after: &str) -> Vec<usize> {
    let behind = after.strip_prefix(", ").or(after.strip_prefix(" ")).unwrap_or("");
    let behind = behind.trim_start_matches("end of ").trim_start_matches("table in ");
    let front = before.strip_suffix(" of ").and_then(|b| Some(&b[b.rfind("section")?..]));
    let whole = |text: &str| text.rsplit(' ').next().is_some_and(|last| last.parse::<usize>().is_ok());
    let front = front.filter(|front| whole(front)).unwrap_or("");
    let numbers = [behind, front].map(|text| {
        let rest = text.strip_prefix("sections ").or(text.strip_prefix("section "));
        rest.map(leading_numbers).unwrap_or_default()
    });
    numbers.concat()
}

/// Numbers of a page's own sections that the page cites, without sections of other pages and of
/// the paper.
fn own_sections(page: &str) -> Vec<usize> {
    let own = page.match_indices("section").filter(|(at, _)| {
        let before = page[..*at].trim_end_matches([' ', '(', ',', ')']);
        !before.ends_with(".md") && !before.ends_with("paper") && !before.ends_with("paper's")
    });
    let behind = own.filter_map(|(at, _)| page[at..].trim_start_matches("sections").split_once(' '));
    let behind = behind.filter(|(word, _)| word.is_empty() || *word == "section");
    behind.flat_map(|(_, rest)| leading_numbers(rest)).collect()
}

#[test]
fn invariant_every_section_that_is_cited_is_on_its_page() {
    const PAGES: [&str; 8] = [
        "theory",
        "numerics",
        "design",
        "guarantees",
        "assemblies",
        "assembly-law",
        "python",
        "paper-machine",
    ];
    let (mut wrong, mut cited) = (Vec::new(), 0);
    let texts: Vec<_> = all().into_iter().map(|(path, text)| (path, flowing(&text))).collect();
    for name in PAGES.map(|page| format!("{page}.md")) {
        let page = fs::read_to_string(root().join("docs").join(&name)).expect("a page of docs");
        let (numbers, titles) = sections(&page);
        for (path, text) in &texts {
            let mut found: Vec<usize> = Vec::new();
            if path.ends_with(&name) && !numbers.is_empty() {
                found = own_sections(text);
            }
            for (before, after) in around(text, &name) {
                found.extend(cited_sections(before, after));
                let title = after.strip_prefix(", ").or(after.strip_prefix(" "));
                let title = title.and_then(|rest| rest.strip_prefix('"')?.split_once('"'));
                let Some((title, _)) = title else { continue };
                cited += 1;
                if !titles.contains(title.trim_end_matches('.')) {
                    wrong.push(format!("{}: {name}, \"{title}\"", shown(path)));
                }
            }
            cited += found.len();
            let missing = found.iter().filter(|number| !numbers.contains(number));
            wrong.extend(missing.map(|n| format!("{}: {name}, section {n}", shown(path))));
        }
    }
    assert!(wrong.is_empty(), "cited and not there: {wrong:#?}");
    println!("{cited} citations");
    assert!(cited > 100, "{cited} citations");
    // A missing section and a title that no section has are noticed.
    let (numbers, titles) = sections("# Page\n## 1. One\n**Two.** Text\n- *Three* and more");
    assert!(numbers.contains(&1) && !numbers.contains(&2));
    assert!(["One", "Two", "Three"].iter().all(|title| titles.contains(title)) && !titles.contains("Four"));
    assert_eq!(leading_numbers("6 to 9, and so on"), [6, 9]);
    assert_eq!(cited_sections("by section 14 of ", ", end of section 4: a set"), [4, 14]);
    assert_eq!(own_sections("as in section 7; see [a](a.md), section 8, and sections 1 and 2"), [7, 1, 2]);
}

/// Prose of a text: all of a page, or the comments of code.
fn prose(path: &Path, text: &str) -> String {
    let page = path.extension().is_some_and(|ending| ending == "md");
    let comment = |line: &&str| page || ["//", "#"].iter().any(|mark| line.trim_start().starts_with(mark));
    text.lines().filter(comment).collect::<Vec<_>>().join("\n")
}

#[test]
fn invariant_every_test_that_is_cited_is_there() {
    const KINDS: [&str; 4] = ["closed_form_", "second_method_", "invariant_", "golden_"];
    let texts = all();
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let defined: BTreeSet<&str> = texts
        .iter()
        .flat_map(|(_, text)| text.split("fn ").skip(1))
        .map(|rest| rest.split(|c| !is_name(c)).next().unwrap_or(""))
        .collect();
    let (mut missing, mut cited) = (Vec::new(), 0);
    for (path, text) in &texts {
        let said = prose(path, text);
        for name in said.split(|c| !is_name(c)).filter(|name| KINDS.iter().any(|kind| name.starts_with(kind)))
        {
            // `closed_form_…` names a kind.
            let whole = !name.ends_with('_');
            cited += usize::from(whole);
            if whole && !defined.contains(name) {
                missing.push(format!("{}: {name}", shown(path)));
            }
        }
    }
    assert!(missing.is_empty(), "cited and not there: {missing:#?}");
    assert!(cited > 150, "{cited} citations");
}
