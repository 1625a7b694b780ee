//! What the repository promises about itself: what a text cites is there (invariant).

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Endings of files whose text is read, by people.
const TEXTS: [&str; 10] = ["rs", "py", "md", "toml", "html", "ts", "js", "mjs", "yml", "cff"];
/// Folders that are made, fetched or another program's input.
const PASSED_OVER: [&str; 7] = ["target", "dist", ".git", "corpus", "node_modules", "snapshots", "vibro-out"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The file of these tests, which names what they forbid.
fn own() -> PathBuf {
    root().join("tests/repository.rs")
}

/// Every file under a folder.
fn walk(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of the repository") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or("");
        if !path.is_dir() {
            found.push(path);
        } else if !PASSED_OVER.contains(&name) && !path.join("pyvenv.cfg").exists() {
            walk(&path, found);
        }
    }
}

/// Every text of the repository with its path, that of these tests apart.
fn all() -> Vec<(PathBuf, String)> {
    let mut paths = Vec::new();
    walk(root(), &mut paths);
    let is_text = |path: &PathBuf| {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        (TEXTS.contains(&ending) || path.ends_with(".ci/run")) && *path != own()
    };
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).expect("UTF-8");
        (path, text)
    };
    paths.into_iter().filter(is_text).map(read).collect()
}

/// Words that may name a file: letters, digits and `/._-`.
fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| !(c.is_alphanumeric() || "/._-".contains(c))).map(|word| word.trim_end_matches('.'))
}

fn shown(path: &Path) -> String {
    path.strip_prefix(root()).unwrap_or(path).display().to_string()
}

#[test]
fn invariant_every_document_that_is_cited_is_in_the_repository() {
    let mut missing = BTreeSet::new();
    for (path, text) in all() {
        for word in
            words(&text).filter(|word| word.ends_with(".md") && word.len() > 3 && !word.starts_with('/'))
        {
            // Relative to the file, to the root, or the name of a page in docs/.
            let beside = path.parent().expect("a file is in a folder").join(word);
            let there =
                [beside, root().join(word), root().join("docs").join(word)].iter().any(|p| p.exists());
            // A licence's text in the packed archive and in packages of others; the notes, which a release makes.
            let others = word.contains("LICENSE") || word.ends_with("RELEASE_NOTES.md");
            if !there && !others {
                missing.insert(format!("{}: {word}", shown(&path)));
            }
        }
    }
    assert!(missing.is_empty(), "cited and not there: {missing:#?}");
}

#[test]
fn invariant_every_equation_that_is_cited_is_on_the_theory_page() {
    let page = fs::read_to_string(root().join("docs/theory.md")).expect("docs/theory.md");
    let count = page.matches("\\tag{").count();
    assert!(count > 50, "docs/theory.md numbers {count} equations");
    let (mut wrong, mut cited) = (Vec::new(), 0);
    for (path, text) in all() {
        for after in text.split("theory.md").skip(1) {
            // `theory.md (12)`, `theory.md (12), (13)` and `theory.md (12) to (14)`.
            let mut rest = after.trim_start_matches(['`', ']']);
            while let Some((number, tail)) = rest.strip_prefix(" (").and_then(|r| r.split_once(')')) {
                let Ok(number) = number.parse::<usize>() else { break };
                cited += 1;
                if number == 0 || number > count {
                    wrong.push(format!("{}: theory.md ({number})", shown(&path)));
                }
                rest = tail
                    .strip_prefix(',')
                    .or(tail.strip_prefix(" and"))
                    .or(tail.strip_prefix(" to"))
                    .unwrap_or(tail);
            }
        }
    }
    assert!(wrong.is_empty(), "of {count} equations: {wrong:#?}");
    println!("{cited} citations of {count} equations");
    assert!(cited > 0, "no comment cites an equation");
}

/// A text as one line, without the marks at the beginnings of comments' lines.
fn flowing(text: &str) -> String {
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

/// The numbers and the titles of a page's sections, and what its paragraphs begin with in bold or italics.
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

/// The numbers at the beginning of `1`, `1 and 2`, `6 to 9`, `1, 2 and 4`.
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

#[test]
fn invariant_every_section_that_is_cited_is_on_its_page() {
    const PAGES: [&str; 9] = [
        "theory",
        "numerics",
        "design",
        "guarantees",
        "studies",
        "assemblies",
        "assembly-law",
        "python",
        "recipes",
    ];
    let (mut wrong, mut cited) = (Vec::new(), 0);
    let texts: Vec<_> = all().into_iter().map(|(path, text)| (path, flowing(&text))).collect();
    for name in PAGES {
        let page = fs::read_to_string(root().join(format!("docs/{name}.md"))).expect("a page of docs");
        let (numbers, titles) = sections(&page);
        for (path, text) in &texts {
            for after in text.split(&format!("{name}.md")).skip(1) {
                let after = after.trim_start_matches(['`', ')', ']']);
                let Some(after) = after.strip_prefix(", ").or(after.strip_prefix(" ")) else { continue };
                if let Some(rest) = after.strip_prefix("sections ").or(after.strip_prefix("section ")) {
                    let found = leading_numbers(rest);
                    cited += found.len();
                    let missing = found.iter().filter(|number| !numbers.contains(number));
                    wrong.extend(missing.map(|n| format!("{}: {name}.md, section {n}", shown(path))));
                } else if let Some((title, _)) = after.strip_prefix('"').and_then(|rest| rest.split_once('"'))
                {
                    cited += 1;
                    if !titles.contains(title.trim_end_matches('.')) {
                        wrong.push(format!("{}: {name}.md, \"{title}\"", shown(path)));
                    }
                }
            }
        }
    }
    assert!(wrong.is_empty(), "cited and not there: {wrong:#?}");
    assert!(cited > 30, "{cited} citations");
    // What the test looks for is found: a section too many, a title that no section has.
    let (numbers, titles) = sections("# Page\n## 1. One\n**Two.** Text\n- *Three* and more");
    assert!(numbers.contains(&1) && !numbers.contains(&2));
    assert!(["One", "Two", "Three"].iter().all(|title| titles.contains(title)) && !titles.contains("Four"));
    assert_eq!(leading_numbers("6 to 9, and so on"), [6, 9]);
}

#[test]
fn invariant_every_test_that_a_page_cites_is_there() {
    const KINDS: [&str; 4] = ["closed_form_", "second_method_", "invariant_", "golden_"];
    let (pages, code): (Vec<_>, Vec<_>) =
        all().into_iter().partition(|(path, _)| path.extension().is_some_and(|ending| ending == "md"));
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let defined: BTreeSet<&str> = code
        .iter()
        .flat_map(|(_, text)| text.split("fn ").skip(1))
        .map(|rest| rest.split(|c| !is_name(c)).next().unwrap_or(""))
        .collect();
    let (mut missing, mut cited) = (Vec::new(), 0);
    for (path, text) in &pages {
        for name in text.split(|c| !is_name(c)).filter(|name| KINDS.iter().any(|kind| name.starts_with(kind)))
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
    assert!(cited > 30, "{cited} citations");
}

/// A line of prose that is wider than this is not read beside code.
const WIDEST: usize = 160;

#[test]
fn invariant_comments_are_not_wider_than_a_screen() {
    let mut found = Vec::new();
    for (path, text) in all() {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        if !["rs", "py", "js", "mjs"].contains(&ending) {
            continue;
        }
        for (number, line) in text.lines().enumerate() {
            let comment = line.trim_start();
            // Tables and diagrams have no other place to break.
            let drawn = comment.contains(" | ") || comment.contains('─');
            let prose = ["//", "# ", "* "].iter().any(|mark| comment.starts_with(mark)) && !drawn;
            if prose && line.chars().count() > WIDEST {
                found.push(format!("{}:{}", shown(&path), number + 1));
            }
        }
    }
    assert!(found.is_empty(), "comments wider than {WIDEST} characters: {found:#?}");
}

/// The relative paths of a text that go up, e.g. `../README.md`.
fn climbing(text: &str) -> impl Iterator<Item = &str> {
    let paths = text.split(|c: char| !(c.is_alphanumeric() || "/._-".contains(c)));
    // A path behind `env!("CARGO_MANIFEST_DIR")` begins with the separator, and one at the end of a sentence ends with its stop.
    let paths = paths.map(|path| path.strip_prefix("/").unwrap_or(path));
    let paths = paths.map(|path| if path.ends_with("..") { path } else { path.trim_end_matches('.') });
    paths.filter(|path| path.contains('/') && path.split('/').any(|name| name == ".."))
}

/// Where a path leads from a folder of the repository, or nothing where it leads out.
fn followed(folder: &Path, path: &str) -> Option<PathBuf> {
    let mut place = folder.strip_prefix(root()).expect("a folder of the repository").to_owned();
    for name in Path::new(path) {
        if name != ".." {
            place.push(name);
        } else if !place.pop() {
            return None;
        }
    }
    Some(place)
}

/// Whether a path in a file leads to something of the repository, or to what is made there: read from the file's folder, or from
/// that of its package, as paths behind `env!("CARGO_MANIFEST_DIR")` are.
fn leads_into_the_repository(file: &Path, path: &str) -> bool {
    let beside = file.parent().expect("a file is in a folder");
    let package = beside.ancestors().find(|folder| folder.join("Cargo.toml").exists()).expect("a package");
    let made = |place: &Path| PASSED_OVER.iter().any(|folder| place.starts_with(folder));
    let places = [beside, package].map(|folder| followed(folder, path));
    places.into_iter().flatten().any(|place| root().join(&place).exists() || made(&place))
}

#[test]
fn invariant_every_relative_path_that_goes_up_stays_in_the_repository() {
    // Entries of an archive, from the folder of the archive in which they are named; and what a machine's file must not reach.
    const ELSEWHERE: [&str; 4] =
        ["../../documentation/fmi-ls-ref.txt", "../resources/", "../../../etc/passwd", "../../secret.csv"];
    let mut files = Vec::new();
    walk(root(), &mut files);
    let (mut found, mut followed) = (Vec::new(), 0);
    for file in files.iter().filter(|file| **file != own()) {
        // Pictures and fonts are no text.
        let Ok(text) = fs::read_to_string(file) else { continue };
        for path in climbing(&text).filter(|path| !ELSEWHERE.contains(path)) {
            followed += 1;
            if !leads_into_the_repository(file, path) {
                found.push(format!("{}: {path}", shown(file)));
            }
        }
    }
    assert!(found.is_empty(), "not in the repository: {found:#?}");
    assert!(followed > 0, "no file cites a path that goes up");
    // The rule refuses what leads out, also by way of a folder inside, and what is not there.
    let page = root().join("docs/theory.md");
    for outside in ["../../other/data.csv", "../docs/../../other", "../other/data.csv"] {
        assert!(climbing(outside).eq([outside]) && !leads_into_the_repository(&page, outside), "{outside}");
    }
}

#[test]
fn invariant_no_text_cites_an_issue_without_its_address() {
    let mut found = Vec::new();
    for (path, text) in all() {
        for (number, line) in text.lines().enumerate() {
            let issue = ["issue #", "Issue #", "see issue "].iter().any(|w| line.contains(w));
            if issue && !line.contains("://") {
                found.push(format!("{}:{}: {line}", shown(&path), number + 1));
            }
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}

/// A page without its code: fenced blocks, and what stands between backquotes in a line.
fn prose(page: &str) -> String {
    let mut fenced = false;
    let mut text = String::new();
    for line in page.lines() {
        let fence = line.starts_with("```");
        fenced ^= fence;
        if !fenced && !fence {
            text.extend(line.split('`').step_by(2));
            text.push('\n');
        }
    }
    text
}

/// What the links and pictures of a page lead to.
fn links(page: &str) -> Vec<String> {
    let prose = prose(page);
    let ends = prose.split("](").skip(1).filter_map(|after| after.split_once(')'));
    ends.map(|(link, _)| link.to_owned()).collect()
}

/// The anchors of a page's headings, as GitHub makes them: lower case, a hyphen for each space, no other signs.
fn anchors(page: &str) -> BTreeSet<String> {
    let mut fenced = false;
    let mut found = BTreeSet::new();
    for line in page.lines() {
        fenced ^= line.starts_with("```");
        let heading = line.trim_start_matches('#');
        if !fenced && heading.len() < line.len() && heading.starts_with(' ') {
            let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
            found.insert(kept.collect::<String>().to_lowercase().replace(' ', "-"));
        }
    }
    found
}

/// Why a link of a page leads nowhere, if it does.
fn broken(page: &Path, link: &str) -> Option<String> {
    if link.contains("://") {
        return None;
    }
    let (file, anchor) = link.split_once('#').map_or((link, None), |(file, anchor)| (file, Some(anchor)));
    let target = match file {
        "" => page.to_owned(),
        _ => page.parent().expect("a page is in a folder").join(file),
    };
    if !target.exists() {
        return Some("no such file".into());
    }
    let anchor = anchor?;
    let text = fs::read_to_string(&target).expect("a page can be read");
    (!anchors(&text).contains(anchor)).then(|| "no such heading".into())
}

#[test]
fn invariant_every_link_of_a_page_leads_somewhere() {
    let (mut wrong, mut followed) = (Vec::new(), 0);
    for (path, text) in all().into_iter().filter(|(path, _)| path.extension().is_some_and(|e| e == "md")) {
        for link in links(&text) {
            followed += 1;
            if let Some(reason) = broken(&path, &link) {
                wrong.push(format!("{}: {link}: {reason}", shown(&path)));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(followed > 50, "{followed} links were followed");
    // The rule refuses a file and a heading that are not there, and passes over code.
    let page = root().join("docs/README.md");
    for link in ["nothing.md", "speed.md#nothing", "#nothing"] {
        assert!(broken(&page, link).is_some(), "{link}");
    }
    assert_eq!(broken(&page, "hosts.md#fmi-30-both-sides-of-every-impact"), None);
    assert!(links("`a[i](b)`\n```rust\nx[0](1)\n```\n[a](b.md)").eq(&["b.md"]));
}

#[test]
fn invariant_the_readme_is_short_and_the_index_has_every_page() {
    // What is read in a few minutes; more belongs to a page of docs/.
    const MOST_WORDS: usize = 1200;
    let readme = fs::read_to_string(root().join("README.md")).expect("README.md");
    let words = readme.split_whitespace().count();
    assert!(words <= MOST_WORDS, "README.md has {words} words");
    let index = fs::read_to_string(root().join("docs/README.md")).expect("docs/README.md");
    let listed: BTreeSet<String> = links(&index).into_iter().collect();
    for entry in fs::read_dir(root().join("docs")).expect("docs") {
        let name = entry.expect("an entry").file_name().into_string().expect("a name");
        let is_page = name.ends_with(".md") && name != "README.md";
        assert!(!is_page || listed.contains(&name), "docs/README.md does not list {name}");
    }
}

/// The names that the crate's root shows: its public modules and re-exports that are not hidden from the documentation.
fn shown_names(root: &str) -> BTreeSet<String> {
    let (mut shown, mut hidden) = (BTreeSet::new(), false);
    for line in root.lines() {
        if line.starts_with("#[") {
            hidden |= line == "#[doc(hidden)]";
            continue;
        }
        let public = line.strip_prefix("pub ").filter(|_| !hidden);
        hidden = false;
        let Some(item) = public else { continue };
        if let Some(module) = item.strip_prefix("mod ") {
            shown.insert(module.trim_end_matches([';', '{', '}', ' ']).to_owned());
            continue;
        }
        let path = item.strip_prefix("use ").and_then(|path| path.strip_suffix(';'));
        let path = path.unwrap_or_else(|| panic!("neither a module nor a re-export in one line: {line}"));
        let names = path.rsplit_once("::").map_or(path, |(_, names)| names);
        let names = names.trim_matches(['{', '}']).split(',').map(|name| name.trim().to_owned());
        shown.extend(names);
    }
    shown
}

#[test]
fn invariant_the_library_shows_what_the_design_page_lists() {
    let read = |path: &str| fs::read_to_string(root().join(path)).expect("a file of the repository");
    let design = read("docs/design.md");
    let (_, section) = design.split_once("### What the library shows\n").expect("its section");
    let listed = section.split("All else").next().expect("a list");
    let listed: BTreeSet<String> = listed
        .split('`')
        .skip(1)
        .step_by(2)
        .map(str::to_owned)
        .filter(|name| name != "vibro-impact")
        .collect();
    let shown = shown_names(&read("src/lib.rs"));
    assert!(shown.contains("simulator") && shown.contains("State") && !shown.contains("flow"), "{shown:?}");
    assert_eq!(shown, listed);
}
