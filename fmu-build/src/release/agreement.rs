//! Items that must agree before a release is built: versions, instantiation tokens, the changelog,
//! the tag, the work tree.

use super::changelog::{self, ChangelogSection};
use super::citation::{self, read};
use crate::error::{Error, Result};
use crate::xml::Element;
use std::path::Path;
use std::process::{Command, Stdio};
use toml::{Table, Value};
use vibro_paper_component::component::identity::VERSION;
use vibro_paper_component::fmi2::description::guid;
use vibro_paper_component::fmi3::description::{MAIN, instantiation_token};

/// Request for a release.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Intent {
    /// The released tag, e.g. `v0.1.0`.
    pub tag: Option<String>,
    /// Whether this is a preview: the changes come from "Unreleased", and the work tree may have
    /// uncommitted changes.
    pub preview: bool,
}

/// Version and changes on which all sources agree.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Agreed {
    /// The common version.
    pub version: String,
    /// The version's section of the changelog.
    pub changes: ChangelogSection,
}

/// Compares all versions, instantiation tokens, changelog entries and files of citation in the
/// workspace at `folder`.
///
/// # Errors
/// [`Error::Release`] with all disagreements; [`Error::File`] if a file cannot be read.
pub fn agreed(folder: &Path, intent: &Intent) -> Result<Agreed> {
    let manifest = toml(folder, "Cargo.toml")?;
    let workspace = &manifest["workspace"];
    let version = text(&workspace["package"]["version"]).to_owned();
    let mut wrong = Vec::new();
    if version != VERSION {
        wrong.push(format!(
            "Cargo.toml: version {version}, but this program was compiled from {VERSION}: compile it again"
        ));
    }
    wrong.extend(packages(folder, workspace)?);
    wrong.extend(python(folder, &version)?);
    for (name, token) in tokens() {
        let found = read(folder, name)?;
        wrong.extend(description(name, &found, token, &version));
    }
    if let Some(tag) = intent.tag.as_ref().filter(|tag| **tag != format!("v{version}")) {
        wrong.push(format!("tag {tag}: expected v{version}, the version in Cargo.toml"));
    }
    if !intent.preview {
        wrong.extend(uncommitted(folder));
    }
    let changes = changelog::of(&read(folder, "CHANGELOG.md")?, &version, intent.preview);
    let day = changes.as_ref().ok().and_then(|section| section.date.as_deref());
    wrong.extend(citation::disagreements(folder, &version, day)?);
    match changes {
        Ok(changes) if wrong.is_empty() => Ok(Agreed { version, changes }),
        Ok(_) => Err(Error::Release(wrong)),
        Err(problem) => {
            wrong.push(problem);
            Err(Error::Release(wrong))
        }
    }
}

/// Committed model descriptions, each with the token of the library that was compiled into this
/// program.
fn tokens() -> [(&'static str, String); 2] {
    [
        ("modelDescription/modelDescription.xml", guid()),
        ("modelDescription/fmi3.xml", instantiation_token(MAIN)),
    ]
}

/// Errors in version and token of a model description, of FMI 2.0 or 3.0.
pub(super) fn description(place: &str, xml: &str, token: String, version: &str) -> Vec<String> {
    const REMEDY: &str = "write it again with `cargo run --bin fmu-build -- refresh --description`";
    let root = Element::parse(xml).unwrap_or_default();
    let value = |names: &[&str]| names.iter().find_map(|name| root.attribute(name)).unwrap_or("none");
    let differs = |what: &str, found: &str, expected: &str| {
        (found != expected)
            .then(|| format!("{place}: {what} {found}, where {expected} is expected: {REMEDY}"))
    };
    let found = differs("version", value(&["version"]), version);
    let token = differs("instantiation token", value(&["guid", "instantiationToken"]), &token);
    found.into_iter().chain(token).collect()
}

/// Packages that do not inherit the workspace's version, and dependencies that name another
/// version beside their path. Packages under `tests/` are not shipped and not checked.
fn packages(folder: &Path, workspace: &Value) -> Result<Vec<String>> {
    let members = workspace["members"].as_array().into_iter().flatten().map(text);
    let mut wrong = Vec::new();
    let own = text(&workspace["package"]["version"]);
    for (name, dependency) in workspace["dependencies"].as_table().into_iter().flatten() {
        let required = dependency.get("version").filter(|_| dependency.get("path").is_some());
        if let Some(other) = required.map(text).filter(|required| *required != own) {
            wrong.push(format!("Cargo.toml: {name} is required in version {other}: expected {own}"));
        }
    }
    for member in members.filter(|member| !member.starts_with("tests/")) {
        let name = format!("{member}/Cargo.toml");
        let version = &toml(folder, &name)?["package"]["version"];
        if version.get("workspace").and_then(Value::as_bool) != Some(true) {
            wrong.push(format!("{name}: version {version}: expected `version.workspace = true`"));
        }
    }
    Ok(wrong)
}

/// Checks that the Python package has the workspace's version: taken from its crate, or as an
/// equal text.
fn python(folder: &Path, version: &str) -> Result<Option<String>> {
    const NAME: &str = "python/pyproject.toml";
    let manifest = toml(folder, NAME)?;
    let project = &manifest["project"];
    let dynamic = project.get("dynamic").and_then(Value::as_array);
    let of_crate = dynamic.is_some_and(|names| names.iter().any(|name| text(name) == "version"));
    Ok(match project.get("version").map(text) {
        None if of_crate => None,
        Some(own) if own == version => None,
        own => Some(format!(
            "{NAME}: version {}, where Cargo.toml has {version}: expected `dynamic = [\"version\"]`",
            own.unwrap_or("none")
        )),
    })
}

/// Uncommitted changes of the work tree, if it is a git repository.
fn uncommitted(folder: &Path) -> Option<String> {
    let mut git = Command::new("git");
    git.args(["status", "--porcelain"]).current_dir(folder).stderr(Stdio::null());
    let output = git.output().ok().filter(|output| output.status.success())?;
    let changed = String::from_utf8_lossy(&output.stdout).into_owned();
    let first = changed.lines().next()?;
    Some(format!(
        "the work tree has changes that are not committed ({} files, the first: {})",
        changed.lines().count(),
        first.get(3..).unwrap_or(first)
    ))
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or("none")
}

fn toml(folder: &Path, name: &str) -> Result<Table> {
    read(folder, name)?.parse().map_err(|e| Error::Release(vec![format!("{name}: {e}")]))
}
