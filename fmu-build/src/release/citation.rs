//! Citation, archive metadata, conda recipe and paper: the version of `Cargo.toml`, and one title,
//! abstract and day.

use crate::error::{Error, Result};
use serde_json::Value;
use std::path::Path;

/// The citation file.
const CITATION: &str = "CITATION.cff";
/// Files in JSON, each with its keys for the title, the abstract, the version and the day.
const IN_JSON: [(&str, [&str; 4]); 2] = [
    ("codemeta.json", ["name", "description", "version", "dateModified"]),
    (".zenodo.json", ["title", "description", "version", "publication_date"]),
];
/// The recipe of the conda package.
const RECIPE: &str = "python/conda/meta.yaml";
/// The paper about the software.
const PAPER: &str = "docs/paper/paper.md";

/// Disagreements of these files with the version of `Cargo.toml` and, if it is known, with the
/// day of the version in the changelog.
///
/// # Errors
/// [`Error::File`] if a file cannot be read.
pub(super) fn disagreements(folder: &Path, version: &str, day: Option<&str>) -> Result<Vec<String>> {
    let citation = read(folder, CITATION)?;
    let value = |key: &str| scalar(&citation, key).unwrap_or_default();
    let (title, stated) = (value("title"), value("date-released"));
    let facts = [title.clone(), folded(&citation, "abstract"), version.to_owned(), stated.clone()];
    let mut wrong: Vec<String> = Vec::new();
    let mut compare = |file: &str, key: &str, found: &str, expected: &str| {
        if found != expected || expected.is_empty() {
            wrong.push(format!("{file}: {key} {found:?}, expected {expected:?}"));
        }
    };
    compare(CITATION, "version", &value("version"), version);
    if let Some(day) = day {
        compare(CITATION, "date-released", &stated, day);
    }
    for (file, keys) in IN_JSON {
        let json: Value = match serde_json::from_str(&read(folder, file)?) {
            Ok(json) => json,
            Err(problem) => {
                compare(file, "text", &problem.to_string(), "JSON");
                continue;
            }
        };
        for (key, expected) in keys.iter().zip(&facts) {
            compare(file, key, json[key].as_str().unwrap_or("none"), expected);
        }
    }
    let recipe = read(folder, RECIPE)?;
    let packaged = recipe.split("set version = \"").nth(1).and_then(|rest| rest.split('"').next());
    compare(RECIPE, "version", packaged.unwrap_or("none"), version);
    compare(PAPER, "title", &scalar(&read(folder, PAPER)?, "title").unwrap_or_default(), &title);
    Ok(wrong)
}

/// The value of a key of YAML that is on one line, without quotation marks.
fn scalar(yaml: &str, key: &str) -> Option<String> {
    let line = yaml.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(": "))?;
    Some(line.trim().trim_matches('"').to_owned())
}

/// The value of a key of YAML that is folded over indented lines (`>-`).
fn folded(yaml: &str, key: &str) -> String {
    let after = yaml.split(&format!("\n{key}: >-\n")).nth(1).unwrap_or_default();
    let lines = after.lines().take_while(|line| line.starts_with(' '));
    lines.flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

/// The text of a file of the workspace.
pub(super) fn read(folder: &Path, name: &str) -> Result<String> {
    let path = folder.join(name);
    std::fs::read_to_string(&path).map_err(Error::file("reading", &path))
}
