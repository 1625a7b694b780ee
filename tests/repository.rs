//! Invariants of the repository's texts: links have targets, comments are narrow, pages are
//! listed.

#[path = "repository/circles.rs"]
mod circles;
#[path = "repository/citations.rs"]
mod citations;
#[path = "repository/clauses.rs"]
mod clauses;
#[path = "repository/paper.rs"]
mod paper;
#[path = "repository/published.rs"]
mod published;
#[path = "repository/texts.rs"]
mod texts;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use texts::{PASSED_OVER, all, is_own, root, shown, walk};

/// Largest width of a comment, in characters.
const WIDEST: usize = 160;

#[test]
fn invariant_comments_are_not_wider_than_a_screen() {
    let mut found = Vec::new();
    for (path, text) in all() {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        if !["rs", "py", "js", "mjs", "toml", "m"].contains(&ending) {
            continue;
        }
        for (number, line) in text.lines().enumerate() {
            let line = line.trim_start();
            // Tables and diagrams count too, and in a Cargo.toml comments after an entry.
            let comment = ["//", "# ", "* ", "% "].iter().any(|mark| line.starts_with(mark));
            let behind = ending == "toml" && line.contains(" # ");
            if (comment || behind) && line.chars().count() > WIDEST {
                found.push(format!("{}:{}", shown(&path), number + 1));
            }
        }
    }
    assert!(found.is_empty(), "comments wider than {WIDEST} characters: {found:#?}");
}

/// Every row of a table has a head, because a row after a blank line would be rendered as text.
#[test]
fn invariant_every_row_of_a_table_stands_under_its_head() {
    let is_rule = |line: &str| line.starts_with('|') && line.chars().all(|c| "|-: ".contains(c));
    let cells = |line: &str| line.replace("\\|", "").matches('|').count();
    let mut found = Vec::new();
    for (path, text) in all().into_iter().filter(|(path, _)| path.extension().is_some_and(|e| e == "md")) {
        let (mut fenced, mut columns) = (false, None);
        let lines: Vec<&str> = text.lines().collect();
        for (i, line) in lines.iter().enumerate() {
            fenced ^= line.starts_with("```");
            if fenced || !line.starts_with('|') {
                columns = None;
                continue;
            }
            let heads = columns.is_none() && lines.get(i + 1).is_some_and(|next| is_rule(next));
            if heads {
                columns = Some(cells(line));
            }
            if columns != Some(cells(line)) {
                found.push(format!("{}:{}", shown(&path), i + 1));
            }
        }
    }
    assert!(found.is_empty(), "rows without a head, or with other columns: {found:#?}");
}

/// Whether a text contains these words, not as parts of longer words.
fn has_words(text: &str, words: &str) -> bool {
    let inside = |c: Option<char>| c.is_some_and(char::is_alphabetic);
    let mut places = text.match_indices(words);
    places.any(|(at, _)| {
        !inside(text[..at].chars().next_back()) && !inside(text[at + words.len()..].chars().next())
    })
}

#[test]
fn invariant_motions_progress_and_results_are_reported_and_passed_on() {
    const ANYWHERE: [&str; 6] = ["get on", "gets on", "got on", "hand over", "hands over", "handed over"];
    const IN_PAGES: [&str; 4] = ["is told", "are told", "was told", "told as"];
    let mut found = Vec::new();
    for (path, text) in all() {
        if path.ends_with("CHANGELOG.md") {
            continue; // history keeps its own words
        }
        let page = path.extension().is_some_and(|e| e == "md");
        let avoided = ANYWHERE.iter().chain(IN_PAGES.iter().filter(|_| page));
        let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let here = avoided.filter(|words| has_words(&text, words));
        found.extend(here.map(|words| format!("{}: {words}", shown(&path))));
    }
    assert!(found.is_empty(), "{found:#?}");
    assert!(has_words("it gets on.", "gets on") && !has_words("budget one", "get on"));
}

/// Relative paths of a text that go up, e.g. `../README.md`.
fn climbing(text: &str) -> impl Iterator<Item = &str> {
    let paths = text.split(|c: char| !(c.is_alphanumeric() || "/._-".contains(c)));
    // A path after `env!("CARGO_MANIFEST_DIR")` begins with the separator, and one at the end of a
    // sentence ends with a full stop.
    let paths = paths.map(|path| path.strip_prefix("/").unwrap_or(path));
    let paths = paths.map(|path| if path.ends_with("..") { path } else { path.trim_end_matches('.') });
    paths.filter(|path| path.contains('/') && path.split('/').any(|name| name == ".."))
}

/// Target of a path from a folder of the repository; `None` if it leads out of the repository.
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

/// Whether a path in a file leads to a file or folder of the repository, or to a generated one.
/// The path starts in the file's folder or in its package's, like paths after
/// `env!("CARGO_MANIFEST_DIR")`.
fn leads_into_the_repository(file: &Path, path: &str) -> bool {
    let beside = file.parent().expect("a file is in a folder");
    let package = beside.ancestors().find(|folder| folder.join("Cargo.toml").exists()).expect("a package");
    let made = |place: &Path| PASSED_OVER.iter().any(|folder| place.starts_with(folder));
    let places = [beside, package].map(|folder| followed(folder, path));
    places.into_iter().flatten().any(|place| root().join(&place).exists() || made(&place))
}

#[test]
fn invariant_every_relative_path_that_goes_up_stays_in_the_repository() {
    // Entries of an archive, relative to the archive's folder; and paths that a machine's file
    // must not reach.
    const ELSEWHERE: [&str; 4] =
        ["../../documentation/fmi-ls-ref.txt", "../resources/", "../../../etc/passwd", "../../secret.csv"];
    let mut files = Vec::new();
    walk(root(), &mut files);
    let (mut found, mut followed) = (Vec::new(), 0);
    for file in files.iter().filter(|file| !is_own(file)) {
        // Pictures and fonts are not text.
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
    // The rule refuses paths that lead out, even through a folder inside, and missing files.
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

/// A page without its code: without fenced blocks, and without text between backquotes.
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

/// Targets of the links and pictures of a page.
fn links(page: &str) -> Vec<String> {
    let prose = prose(page);
    let ends = prose.split("](").skip(1).filter_map(|after| after.split_once(')'));
    ends.map(|(link, _)| link.to_owned()).collect()
}

/// Anchors of a page's headings, as generated by GitHub: in lower case, with a hyphen for each
/// space and no other signs.
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

/// Reason why a link of a page has no target; `None` for a valid link.
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
    // The rule refuses a missing file and a missing heading, and ignores code.
    let page = root().join("docs/README.md");
    for link in ["nothing.md", "fmu.md#nothing", "#nothing"] {
        assert!(broken(&page, link).is_some(), "{link}");
    }
    assert_eq!(broken(&page, "fmu.md#fmi-30-both-sides-of-every-impact"), None);
    assert!(links("`a[i](b)`\n```rust\nx[0](1)\n```\n[a](b.md)").eq(&["b.md"]));
}

#[test]
fn invariant_the_readme_is_short_and_the_index_has_every_page() {
    // Words that can be read in a few minutes; longer texts belong on a page of docs/.
    const MOST_WORDS: usize = 1000;
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

/// Paths of the repository that a page names between backquotes.
fn named_paths(page: &str) -> Vec<&str> {
    const FOLDERS: [&str; 10] = [
        "crates/",
        "src/",
        "web/",
        "python/",
        "fmu-build/",
        "tests/",
        "benches/",
        "examples/",
        "docs/",
        "matlab/",
    ];
    let quoted = page
        .lines()
        .filter(|line| !line.starts_with("```"))
        .flat_map(|line| line.split('`').skip(1).step_by(2));
    quoted
        .filter(|path| FOLDERS.iter().any(|folder| path.starts_with(folder)) && !path.contains(' '))
        .collect()
}

/// A reader can follow every path on a page. Paths begin at the root, on a package's page also at
/// the package.
#[test]
fn invariant_every_path_that_a_page_names_is_there() {
    let (mut missing, mut of_map, mut pages) = (Vec::new(), 0, 0);
    for (page, text) in all() {
        if page.extension().is_none_or(|ending| ending != "md") {
            continue;
        }
        let named = named_paths(&text);
        let beside = page.parent().expect("a page is in a folder");
        let is_there = |path: &&&str| root().join(path).exists() || beside.join(path).exists();
        missing.extend(
            named.iter().filter(|path| !is_there(path)).map(|path| format!("{}: {path}", shown(&page))),
        );
        pages += 1;
        of_map += if page.ends_with("docs/design.md") { named.len() } else { 0 };
    }
    assert!(missing.is_empty(), "named and not there: {missing:#?}");
    assert!(of_map > 100 && pages > 20, "{of_map} {pages}");
    assert_eq!(named_paths("`src/a.rs`, `Model::b` in `crates/c/`"), ["src/a.rs", "crates/c/"]);
}

/// Names that the crate's root shows: its public modules and re-exports that are not hidden from
/// the documentation.
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
