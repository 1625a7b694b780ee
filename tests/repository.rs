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

fn texts(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of the repository") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().and_then(|n| n.to_str()).unwrap_or("");
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        if path.is_dir() {
            if !PASSED_OVER.contains(&name) && !path.join("pyvenv.cfg").exists() {
                texts(&path, found);
            }
        } else if TEXTS.contains(&ending) || path.ends_with(".ci/run") {
            found.push(path);
        }
    }
}

/// Every text of the repository with its path, this test's own apart.
fn all() -> Vec<(PathBuf, String)> {
    let mut paths = Vec::new();
    texts(root(), &mut paths);
    let own = root().join("tests/repository.rs");
    let read = |path: PathBuf| {
        let text = fs::read_to_string(&path).expect("UTF-8");
        (path, text)
    };
    paths.into_iter().filter(|path| *path != own).map(read).collect()
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

#[test]
fn invariant_nothing_points_outside_the_repository() {
    let mut found = Vec::new();
    for (path, text) in all() {
        for (number, line) in text.lines().enumerate() {
            let outside = line.contains("../shared");
            let issue = ["issue #", "Issue #", "see issue "].iter().any(|w| line.contains(w))
                && !line.contains("://");
            if outside || issue {
                found.push(format!("{}:{}: {line}", shown(&path), number + 1));
            }
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}
