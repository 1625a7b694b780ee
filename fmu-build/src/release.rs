//! Assembles a release with one command: archives, wheels, pages, checksums and notes, in one
//! folder that can be distributed as it is.
//!
//! ```text
//! agreement (versions, tokens, changelog) ─▶ archives ─▶ example machines, command line
//!     ─▶ sdist ─▶ wheels ─▶ contents (the same checks on the built files) ─▶ notes, checksums
//! ```

pub mod agreement;
pub mod changelog;
mod citation;
pub mod contents;
pub mod machines;
pub mod notes;
pub mod trial;
pub mod wheels;

use crate::archive::write_file;
use crate::compile::{PLATFORM_TUPLE, Product, target};
use crate::error::{Error, Result};
use crate::kit::Kit;
use crate::version::Version;
use crate::{archive, explorer, kit, licences, package, page, platforms, run};
use agreement::{Agreed, Intent, agreed};
use contents::archive_of;
use notes::Part;
use sha2::{Digest, Sha256};
use std::fs;
use std::path::Path;
use wheels::WHEELS;

/// Name of the checksum file.
pub const SUMS: &str = "SHA256SUMS";
/// Name of the notes.
pub const NOTES: &str = "RELEASE_NOTES.md";
/// Name of the documentation page.
pub const PAGE: &str = "documentation.html";
/// Name of the live page, to which the documentation page links.
pub const LIVE: &str = "explorer.html";

/// Drive periods over which the archives are compared with the native library.
const PERIODS: u32 = 200;

/// A release that is being assembled.
struct Assembly<'a> {
    folder: &'a Path,
    agreed: &'a Agreed,
    /// Selected platforms by their FMI 3.0 tuples; empty selects all.
    only: &'a [String],
    parts: Vec<Part>,
    left_out: Vec<String>,
}

/// Assembles a release and replaces the contents of the folder `into` by it. Returns the files of
/// the release and the parts that were left out. `only` selects platforms by FMI 3.0 tuples; an
/// empty list selects all.
///
/// # Errors
/// [`Error::Release`] if the sources disagree, if the built files disagree, or if a tag is
/// released and a part is missing. On these errors the folder is unchanged.
pub fn assemble(
    workspace: &Path,
    intent: &Intent,
    only: &[String],
    into: &Path,
) -> Result<(Vec<Part>, Vec<String>)> {
    check_names(only)?;
    check_replaceable(into)?;
    let agreed = agreed(workspace, intent)?;
    let folder = target().join("dist/new");
    clear(&folder)?;
    let mut assembly =
        Assembly { folder: &folder, agreed: &agreed, only, parts: Vec::new(), left_out: Vec::new() };
    if !only.is_empty() {
        assembly.left_out.push(format!("all platforms but {}, which alone were asked for", only.join(", ")));
    }
    assembly.archives_and_pages()?;
    let kit = assembly.machines()?;
    assembly.python_package(&kit)?;
    let wrong = contents::disagreements(&folder, &agreed.version)?;
    if !wrong.is_empty() {
        return Err(Error::Release(wrong));
    }
    assembly.try_own_wheel()?;
    let Assembly { parts, left_out, .. } = assembly;
    if intent.tag.is_some() && !left_out.is_empty() {
        return Err(Error::Release(left_out));
    }
    write_file(&folder.join(NOTES), notes::notes(&agreed, &parts, &left_out).as_bytes())?;
    write_file(&folder.join(SUMS), sums(&folder)?.as_bytes())?;
    copy(&folder, into)?;
    Ok((parts, left_out))
}

impl Assembly<'_> {
    fn add(&mut self, file: &str, what: &str, tried: String) -> Result<()> {
        let path = self.folder.join(file);
        let size = fs::metadata(&path).map_err(Error::file("reading", &path))?.len();
        self.parts.push(Part { file: file.to_owned(), size, what: what.to_owned(), tried });
        Ok(())
    }

    /// Makes and runs both archives, and copies the pages inside them to the folder.
    fn archives_and_pages(&mut self) -> Result<()> {
        let live = explorer::page().map_err(|left_out| self.left_out.push(left_out.to_string())).ok();
        let (binaries, left_out) = platforms::all(self.only)?;
        self.left_out.extend(left_out.iter().map(ToString::to_string));
        let fmi2 = archive_of(self.folder, Version::Fmi2);
        package::write(&fmi2, &Version::USUAL, &binaries, live.as_deref())?;
        run::run(&fmi2, PERIODS)?;
        for version in Version::USUAL {
            let names = binaries.names(version.fmi());
            let tried = format!(
                "`{}` ran {PERIODS} drive periods here, the native library's bits at every point{}",
                names[0],
                if names.len() > 1 { "; the others are built and inspected only" } else { "" }
            );
            let what = format!("FMU, {}: {}", version.name(), names.join(", "));
            let file = archive_of(Path::new(""), version);
            self.add(&file.to_string_lossy(), &what, tried)?;
        }
        write_file(&self.folder.join(PAGE), page::page(live.is_some()).as_bytes())?;
        self.add(PAGE, "documentation of the FMU, as inside it", "-".into())?;
        if let Some(live) = live {
            write_file(&self.folder.join(LIVE), &live)?;
            self.add(LIVE, "the machine, live in a browser, as inside the FMU", "-".into())?;
        }
        Ok(())
    }

    /// The example machines with their kit, the truth suite, and the command line for each platform.
    /// Returns the kit that makes archives of other machines.
    fn machines(&mut self) -> Result<Kit> {
        let (kit, left_out) = kit::of(self.only)?;
        self.left_out.extend(left_out.iter().map(|part| format!("machines of text files: {part}")));
        archive::write(&machines::examples(&kit)?, &self.folder.join(machines::EXAMPLES))?;
        let what = "example machines as text files, and the library of which `vibro fmu` makes FMUs";
        self.add(machines::EXAMPLES, what, "as the tests pack and run it".into())?;
        archive::write(&machines::suite()?, &self.folder.join(machines::SUITE))?;
        let what = "the truth suite for hosts and solvers: cases in 30 digits, and their score";
        self.add(machines::SUITE, what, "as the tests run it".into())?;
        let (binaries, left_out) = platforms::all_of(Product::CommandLine, self.only)?;
        self.left_out.extend(left_out.iter().map(|part| format!("the command line: {part}")));
        let own = binaries.folders().find(|(tuple, _)| *tuple == PLATFORM_TUPLE);
        let tried = own.map(|(_, program)| machines::tried(program)).transpose()?.unwrap_or_default();
        let texts = machines::licences_of_programs()?;
        for (name, bytes) in machines::programs(&binaries, &self.agreed.version, &texts)? {
            write_file(&self.folder.join(&name), &bytes)?;
            self.add(&name, "the command line `vibro`, which needs no Rust toolchain", tried.clone())?;
        }
        Ok(kit)
    }

    /// Source distribution and wheels.
    fn python_package(&mut self, kit: &Kit) -> Result<()> {
        if let Some(tools) = wheels::missing_tool() {
            self.left_out.push(format!("the Python package is left out: {tools}"));
            return Ok(());
        }
        let version = &self.agreed.version;
        let sdist = wheels::sdist(self.folder, kit, &licences::of_wheel()?, version, self.folder)?;
        let source = wheels::unpack(&sdist, version, &target().join("dist/source"))?;
        let tried = "the wheels are built from it".to_owned();
        self.add(&wheels::sdist_file(version), "Python package, sources (needs a Rust toolchain)", tried)?;
        for platform in WHEELS.iter().filter(|p| platforms::is_asked_for(p.tuple, self.only)) {
            match wheels::wheel(platform, &source, self.folder) {
                Ok(()) => {
                    let what = format!("Python package, Python 3.9 or later: {}", platform.words);
                    self.add(&platform.file(version), &what, "built and inspected only".into())?;
                }
                Err(reason) => {
                    self.left_out.push(format!("the wheel for {} is left out: {reason}", platform.words));
                }
            }
        }
        Ok(())
    }

    /// Installs the wheel for this computer in a clean Python environment and compares its results
    /// with the native library.
    fn try_own_wheel(&mut self) -> Result<()> {
        let version = &self.agreed.version;
        let own = WHEELS.iter().find(|p| p.is_own()).map(|p| p.file(version));
        let Some(part) = self.parts.iter_mut().find(|part| Some(&part.file) == own.as_ref()) else {
            return Ok(());
        };
        part.tried = match trial::installed(self.folder, &part.file, version)? {
            Ok(python) => format!("installed in a clean environment ({python}), the native library's bits"),
            Err(reason) => format!("built and inspected only: {reason}"),
        };
        Ok(())
    }
}

/// Checks that the selected platforms exist.
fn check_names(only: &[String]) -> Result<()> {
    let known = |name: &&String| platforms::PLATFORMS.iter().any(|p| p.place.tuple == **name);
    match only.iter().find(|name| !known(name)) {
        None => Ok(()),
        Some(unknown) => Err(Error::Option {
            name: "--platform",
            value: unknown.clone(),
            allowed: format!("one of {}", platforms::PLATFORMS.map(|p| p.place.tuple).join(", ")).into(),
        }),
    }
}

/// Checks that a folder is absent, empty or an earlier release: nothing else is replaced.
fn check_replaceable(folder: &Path) -> Result<()> {
    let empty = fs::read_dir(folder).map_or(true, |mut entries| entries.next().is_none());
    if empty || folder.join(SUMS).is_file() {
        return Ok(());
    }
    Err(Error::Option {
        name: "--out",
        value: folder.display().to_string(),
        allowed: "a folder that is empty, does not exist yet, or holds an earlier release".into(),
    })
}

/// Replaces a folder by the files of another, which may be on another disk. The checksum file is
/// copied last, so that a folder with this file is complete.
fn copy(folder: &Path, into: &Path) -> Result<()> {
    clear(into)?;
    let reading = || Error::file("reading the folder", folder);
    let entries: std::io::Result<Vec<_>> = fs::read_dir(folder).map_err(reading())?.collect();
    let mut names: Vec<_> = entries.map_err(reading())?.into_iter().map(|entry| entry.file_name()).collect();
    names.sort_by_key(|name| name == SUMS);
    for name in names {
        let path = into.join(&name);
        fs::copy(folder.join(&name), &path).map_err(Error::file("writing", &path))?;
    }
    Ok(())
}

/// Makes an empty folder, deleting its earlier content.
fn clear(folder: &Path) -> Result<()> {
    if folder.exists() {
        fs::remove_dir_all(folder).map_err(Error::file("removing", folder))?;
    }
    fs::create_dir_all(folder).map_err(Error::file("making the folder", folder))
}

/// SHA-256 checksums of all files, in the format of `sha256sum`.
fn sums(folder: &Path) -> Result<String> {
    let reading = || Error::file("reading the folder", folder);
    let mut lines = Vec::new();
    for entry in fs::read_dir(folder).map_err(reading())? {
        let path = entry.map_err(reading())?.path();
        let bytes = fs::read(&path).map_err(Error::file("reading", &path))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        lines.push((name, sum(&bytes)));
    }
    lines.sort();
    Ok(lines.into_iter().map(|(name, sum)| format!("{sum}  {name}\n")).collect())
}

/// SHA-256 in hexadecimal digits.
fn sum(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
