//! Licences of all code that is linked into the packaged binary.

use crate::archive::Content;
use crate::compile::{Product, cargo, output, workspace};
use crate::error::{Error, Result};
use crate::platforms::PLATFORMS;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// List of linked code other than crates; the texts of the standard library are in `place`.
fn run_time(place: &str) -> String {
    format!(
        "
The Rust standard library: MIT OR Apache-2.0 and what COPYRIGHT-library.html lists ({place}).
Run-time code of the linker, for unwinding and start-up: LLVM's libunwind (Apache-2.0 WITH LLVM-exception) or GCC's
libgcc (GPL-3.0-or-later WITH GCC-exception-3.1, which puts no condition on what it is linked into), and on Windows that
of mingw-w64 (public domain and Zope Public License 2.1).
"
    )
}

/// Licence texts of the Rust toolchain (`share/doc/rust`) and their names in an archive. A licence
/// and its exception are in one file: the exception makes it a licence of linked code, so a reader
/// of the licence must see both.
const TOOLCHAIN: [(&str, &[&str]); 3] = [
    ("COPYRIGHT-library.html", &["COPYRIGHT-library.html"]),
    ("LLVM-exception.txt", &["licenses/LLVM-exception.txt"]),
    (
        "GPL-3.0-or-later-WITH-GCC-exception-3.1.txt",
        &["licenses/GCC-exception-3.1.txt", "licenses/GPL-3.0-or-later.txt"],
    ),
];

pub use vibro_pack::LICENCE_LIST as LIST;

/// The texts of an archive by their paths in its folder of licences: our licence, the licences of
/// every crate that is linked into the binaries or, if it is packed, into the live page, and a
/// list of them.
///
/// # Errors
/// [`Error::Cargo`] if cargo cannot list the dependencies; [`Error::File`] if a text cannot be
/// read.
pub fn texts(live: bool) -> Result<Content> {
    texts_of(Product::Vibro, live)
}

/// The licence texts of an archive that holds another product's library.
///
/// # Errors
/// As [`texts`].
pub fn texts_of(product: Product, live: bool) -> Result<Content> {
    let mut content = Content::new();
    for name in ["LICENSE-MIT", "LICENSE-APACHE"] {
        let path = workspace().join(name);
        let text = fs::read(&path).map_err(Error::file("reading", &path))?;
        content.insert(name.to_owned(), text);
    }
    let into = if live { "binaries and the live page" } else { "binaries" };
    let mut names = tree(product.package())?;
    if live {
        names.extend(tree_for("vibro-explorer", &["wasm32-unknown-unknown"])?);
    }
    let of = if product == Product::CommandLine { "this program" } else { "this FMU" };
    let (list, files) = third_party(&format!("{into} of {of}"), &names)?;
    content.extend(files);
    content.insert(LIST.into(), (list + &run_time("rust-standard-library/")).into_bytes());
    content.extend(standard_library()?.into_iter().map(|(n, t)| (format!("rust-standard-library/{n}"), t)));
    Ok(content)
}

/// Files of licences that every wheel has in addition to our licence: the list of linked code,
/// with all texts.
pub const OF_WHEEL: [&str; 1] = ["LICENSE-THIRD-PARTY.txt"];

/// The page of the standard library's licences, next to the other files.
const STANDARD_LIBRARY: &str = "LICENSE-RUST-STANDARD-LIBRARY.html";

/// The texts of the Python package's wheels, in files covered by `license-files` in its
/// `pyproject.toml`. Equal texts occur only once.
///
/// # Errors
/// As [`texts`].
pub fn of_wheel() -> Result<Content> {
    let (mut all, files) = third_party("native module of this package", &tree("vibro-impact-python")?)?;
    all += &run_time(STANDARD_LIBRARY);
    let (pages, plain): (Content, Content) =
        standard_library()?.into_iter().partition(|(name, _)| name.ends_with(".html"));
    let plain = plain.into_iter().map(|(name, text)| (format!("rust-standard-library/{name}"), text));
    let mut places: BTreeMap<Vec<u8>, Vec<String>> = BTreeMap::new();
    for (name, text) in files.into_iter().chain(plain) {
        places.entry(text).or_default().push(name);
    }
    let mut texts: Vec<_> = places.into_iter().collect();
    texts.sort_by(|(_, a), (_, b)| a.cmp(b));
    for (text, names) in texts {
        let names = names.join("\n");
        all += &format!("\n{}\n{names}\n\n{}\n", "=".repeat(80), String::from_utf8_lossy(&text).trim_end());
    }
    let mut content = Content::from([(OF_WHEEL[0].to_owned(), all.into_bytes())]);
    content.extend(pages.into_values().map(|page| (STANDARD_LIBRARY.to_owned(), page)));
    Ok(content)
}

/// The list of linked code, and the texts by `name-version/file`.
fn third_party(into: &str, names: &BTreeSet<(String, String)>) -> Result<(String, Content)> {
    let mut content = Content::new();
    let mut list = format!("Linked into the {into}, beside its own code (MIT OR Apache-2.0):\n");
    for package in packages(names)? {
        let (name, version) = (text(&package["name"]), text(&package["version"]));
        list += &format!("\n{name} {version}: {}", text(&package["license"]));
        let folder = Path::new(text(&package["manifest_path"])).parent().unwrap_or(Path::new("."));
        let files = licence_files(folder)?;
        if files.is_empty() {
            list += " (its package holds no text; the licence in general is among the others here)";
        }
        for file in files {
            let path = folder.join(&file);
            let bytes = fs::read(&path).map_err(Error::file("reading", &path))?;
            content.insert(format!("{name}-{version}/{file}"), bytes);
        }
    }
    Ok((list + "\n", content))
}

/// The texts of the standard library, if the toolchain has them, like rustup's toolchains.
fn standard_library() -> Result<Content> {
    let rustc = std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into());
    let asked = Command::new(rustc).args(["--print", "sysroot"]).stderr(Stdio::null()).output();
    let sysroot = asked.map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned()).unwrap_or_default();
    let folder = PathBuf::from(sysroot).join("share/doc/rust");
    let mut content = Content::new();
    for (name, parts) in TOOLCHAIN {
        let paths: Vec<PathBuf> = parts.iter().map(|part| folder.join(part)).collect();
        if paths.iter().all(|path| path.is_file()) {
            let texts = paths.iter().map(|path| fs::read(path).map_err(Error::file("reading", path)));
            content.insert(name.to_owned(), texts.collect::<Result<Vec<_>>>()?.join(&b"\n\n"[..]));
        }
    }
    Ok(content)
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or("unknown")
}

/// Cargo's metadata of packages by name and version, sorted by name, without packages of this
/// workspace.
fn packages(names: &BTreeSet<(String, String)>) -> Result<Vec<Value>> {
    let mut metadata = cargo();
    metadata.args(["metadata", "--format-version", "1", "--locked"]);
    let metadata: Value = serde_json::from_str(&output(&mut metadata)?).map_err(|e| Error::Cargo {
        command: "cargo metadata".into(),
        problem: format!("did not print JSON: {e}"),
    })?;
    let mut packages: Vec<Value> = metadata["packages"]
        .as_array()
        .into_iter()
        .flatten()
        .filter(|p| names.contains(&(text(&p["name"]).to_owned(), text(&p["version"]).to_owned())))
        .filter(|p| !p["source"].is_null()) // our own have no source but this workspace
        .cloned()
        .collect();
    packages.sort_by_key(|p| (text(&p["name"]).to_owned(), text(&p["version"]).to_owned()));
    Ok(packages)
}

/// Names and versions in the normal dependency tree of one of our packages on all packed
/// platforms, without build dependencies and procedural macros.
fn tree(package: &str) -> Result<BTreeSet<(String, String)>> {
    let targets: Vec<&str> = PLATFORMS.iter().flat_map(|p| p.targets).copied().collect();
    tree_for(package, &targets)
}

/// Names and versions in the normal dependency tree of one of our packages on the given targets,
/// without build dependencies and procedural macros.
fn tree_for(package: &str, targets: &[&str]) -> Result<BTreeSet<(String, String)>> {
    let mut tree = cargo();
    tree.args(["tree", "--package", package, "--edges", "normal,no-proc-macro"]);
    tree.args(["--prefix", "none", "--format", "{p}", "--locked"]);
    tree.args(targets.iter().flat_map(|target| ["--target", target]));
    // A line reads `name vVERSION` and perhaps `(…)`.
    let entry = |line: &str| {
        let mut words = line.split(' ');
        Some((words.next()?.to_owned(), words.next()?.trim_start_matches('v').to_owned()))
    };
    Ok(output(&mut tree)?.lines().filter_map(entry).collect())
}

/// Folders of the workspace's packages in a product, relative to the workspace; empty for the root
/// package.
///
/// # Errors
/// [`Error::Cargo`].
pub(crate) fn own_packages(product: Product) -> Result<Vec<String>> {
    let mut tree = cargo();
    tree.args(["tree", "--package", product.package(), "--edges", "normal", "--target", "all"]);
    tree.args(["--prefix", "none", "--format", "{p}", "--locked"]);
    // A line of ours reads `name vVERSION (FOLDER)`.
    let folder = |line: &str| {
        let (_, folder) = line.strip_suffix(" (*)").unwrap_or(line).split_once(" (")?;
        let folder = Path::new(folder.strip_suffix(')')?).strip_prefix(workspace()).ok()?;
        Some(folder.to_string_lossy().into_owned())
    };
    let folders: BTreeSet<String> = output(&mut tree)?.lines().filter_map(folder).collect();
    Ok(folders.into_iter().collect())
}

fn licence_files(folder: &Path) -> Result<BTreeSet<String>> {
    let reading = || Error::file("reading the folder", folder);
    let mut found = BTreeSet::new();
    for entry in fs::read_dir(folder).map_err(reading())? {
        let entry = entry.map_err(reading())?;
        let name = entry.file_name().to_string_lossy().into_owned();
        let upper = name.to_uppercase();
        let licence =
            ["LICENSE", "LICENCE", "COPYING", "NOTICE", "UNLICENSE"].iter().any(|s| upper.starts_with(s));
        if licence && entry.path().is_file() {
            found.insert(name);
        }
    }
    Ok(found)
}
