//! Items that must agree in the files of a release: names, versions, tokens, archives inside
//! wheels, libraries and licences.

use super::agreement::description;
use super::wheels::{ENTRY, FMU_FOLDER, WHEELS, WheelPlatform, python_version, sdist_file};
use crate::archive::{self, Content};
use crate::error::{Error, Result};
use crate::inspect;
use crate::kit::{KIT_FILE, Kit};
use crate::licences;
use crate::platforms::PLATFORMS;
use crate::version::{MODEL_DESCRIPTION, Version};
use flate2::read::GzDecoder;
use std::collections::BTreeSet;
use std::fs;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};
use vibro_paper_component::fmi2::description::{MODEL_IDENTIFIER, guid};
use vibro_paper_component::fmi3::description::{MAIN, instantiation_token};

/// Path of a version's archive in the folder of a release.
pub fn archive_of(dist: &Path, version: Version) -> PathBuf {
    version.beside(&dist.join(format!("{MODEL_IDENTIFIER}.fmu")))
}

/// All disagreements in a release's folder: both archives, and the available wheels and source
/// distribution.
///
/// # Errors
/// An error if a file cannot be read or is not an archive.
pub fn disagreements(dist: &Path, version: &str) -> Result<Vec<String>> {
    let mut wrong = archives(dist, version)?;
    let sdist = dist.join(sdist_file(version));
    let folder = format!("vibro_impact-{}/", python_version(version));
    let (mut described, mut kits) = (None, Vec::new());
    if sdist.exists() {
        let content = unpacked(&sdist)?;
        let place = sdist_file(version);
        let about = text(&content, &format!("{folder}PKG-INFO"));
        wrong.extend(metadata(&about, version).map(|why| format!("{place}: PKG-INFO {why}")));
        wrong.extend(same_archives(dist, &content, &format!("{folder}{FMU_FOLDER}/"), &place)?);
        kits.push((content.get(&format!("{folder}{FMU_FOLDER}/{KIT_FILE}")).cloned(), place));
        described = Some(about);
    }
    for platform in WHEELS {
        let path = dist.join(platform.file(version));
        if path.exists() {
            let (content, place) = (archive::read_all(&path)?, platform.file(version));
            wrong.extend(
                wheel(&platform, &content, version, described.as_deref())
                    .into_iter()
                    .map(|text| format!("{place}: {text}")),
            );
            wrong.extend(same_archives(dist, &content, "vibro_impact/fmu/", &place)?);
            kits.push((content.get(&format!("vibro_impact/fmu/{KIT_FILE}")).cloned(), place));
        }
    }
    wrong.extend(same_kits(dist, &kits)?);
    Ok(wrong)
}

/// Checks that all packages have the same kit, with a library for each platform of the archives.
fn same_kits(dist: &Path, kits: &[(Option<Vec<u8>>, String)]) -> Result<Vec<String>> {
    let archive = archive::read_all(&archive_of(dist, Version::Fmi3))?;
    let packed: Vec<&str> = PLATFORMS
        .iter()
        .filter(|platform| archive.contains_key(&platform.path(Version::Fmi3)))
        .map(|platform| platform.place.tuple)
        .collect();
    let mut wrong = Vec::new();
    for (bytes, place) in kits {
        let kit = bytes.as_ref().map(|bytes| archive::of(Cursor::new(bytes), Path::new(KIT_FILE)));
        let kit = kit.and_then(|content| Kit::from_entries(content.ok()?));
        let Some(kit) = kit else {
            wrong.push(format!("{place} lacks {KIT_FILE}, from which FMUs of other machines are made"));
            continue;
        };
        let lacking: Vec<&str> = packed
            .iter()
            .copied()
            .filter(|tuple| kit.binaries.folders().all(|(own, _)| own != *tuple))
            .collect();
        if !lacking.is_empty() {
            wrong.push(format!("{place}: {KIT_FILE} lacks the library for {}", lacking.join(", ")));
        }
        if *bytes != kits[0].0 {
            wrong.push(format!("{place}: {KIT_FILE} differs from that of {}", kits[0].1));
        }
    }
    Ok(wrong)
}

/// Versions and tokens of both archives, and their libraries.
fn archives(dist: &Path, version: &str) -> Result<Vec<String>> {
    let mut wrong = Vec::new();
    let mut libraries = Vec::new();
    for (edition, token) in [(Version::Fmi2, guid()), (Version::Fmi3, instantiation_token(MAIN))] {
        let path = archive_of(dist, edition);
        let place = file_name(&path);
        let content = archive::read_all(&path)?;
        let xml = text(&content, MODEL_DESCRIPTION);
        wrong.extend(description(&place, &xml, token, version));
        let mut of_platforms = Vec::new();
        for platform in PLATFORMS {
            let Some(bytes) = content.get(&platform.path(edition)) else { continue };
            of_platforms.push((platform.place.tuple, bytes.clone()));
            for (slice, target) in
                inspect::slices(bytes).unwrap_or_default().into_iter().zip(platform.targets)
            {
                if inspect::kind(slice) != Ok(inspect::kind_of_target(target)) {
                    wrong.push(format!("{place}: {} is not a library for {target}", platform.path(edition)));
                }
            }
        }
        libraries.push(of_platforms);
    }
    if libraries[0] != libraries[1] {
        wrong.push("the archives of FMI 2.0 and FMI 3.0 hold different libraries".into());
    }
    Ok(wrong)
}

/// Problems of a wheel, except of the archives inside it. Its metadata must equal the source
/// distribution's, if available.
fn wheel(platform: &WheelPlatform, content: &Content, version: &str, described: Option<&str>) -> Vec<String> {
    let information = format!("vibro_impact-{}.dist-info", python_version(version));
    let about = text(content, &format!("{information}/METADATA"));
    let mut wrong: Vec<String> =
        metadata(&about, version).into_iter().map(|why| format!("METADATA {why}")).collect();
    if described.is_some_and(|other| other != about) {
        wrong.push("METADATA differs from PKG-INFO of the source distribution".into());
    }
    let about = text(content, &format!("{information}/WHEEL"));
    let tags: BTreeSet<&str> =
        about.lines().filter_map(|line| line.strip_prefix("Tag: cp39-abi3-")).collect();
    let named: BTreeSet<&str> = platform.tag.split('.').collect();
    if tags != named {
        wrong.push(format!("its tags {tags:?} differ from the tags in its name"));
    }
    let own = ["LICENSE-MIT", "LICENSE-APACHE"];
    for name in own.iter().chain(&licences::OF_WHEEL) {
        if !content.contains_key(&format!("{information}/licenses/{name}")) {
            wrong.push(format!("{information}/licenses lacks {name}"));
        }
    }
    match content.get(platform.module) {
        None => wrong.push(format!("it lacks {}", platform.module)),
        Some(module) => {
            wrong.extend(native(platform, module).err().map(|why| format!("{}: {why}", platform.module)))
        }
    }
    wrong
}

/// Checks that a native module is for the platform: its format and processor, its exported
/// function, and the libraries that it needs.
fn native(platform: &WheelPlatform, module: &[u8]) -> std::result::Result<(), String> {
    let damaged = |error: object::Error| format!("cannot be read: {error}");
    let kind = inspect::kind(module).map_err(damaged)?;
    if kind != inspect::kind_of_target(platform.target) {
        return Err(format!("is {kind:?}, not a library for {}", platform.target));
    }
    let exported = inspect::exports(module).map_err(damaged)?;
    if !exported.contains(ENTRY) {
        return Err(format!("does not export {ENTRY}"));
    }
    let needs = inspect::needs(module).map_err(damaged)?;
    if let Some(version) = inspect::later_glibc(&needs) {
        return Err(format!("needs glibc {version}, later than {:?}", inspect::GLIBC));
    }
    match needs.iter().find(|name| !inspect::is_system(name) && !is_beside_python(name)) {
        Some(foreign) => Err(format!("needs {foreign}, which a machine may lack")),
        None => Ok(()),
    }
}

/// Whether a required library belongs to the interpreter, or is a library of Windows that Rust's
/// standard library uses.
fn is_beside_python(library: &str) -> bool {
    const WINDOWS: [&str; 6] =
        ["python3.dll", "userenv.dll", "ws2_32.dll", "dbghelp.dll", "advapi32.dll", "bcryptprimitives.dll"];
    // On macOS the interpreter's symbols are looked up when the module is loaded, and not in a
    // named library.
    library.is_empty() || WINDOWS.contains(&&*library.to_lowercase())
}

/// Name and version in the package's metadata.
fn metadata(about: &str, version: &str) -> Option<String> {
    let field = |key: &str| about.lines().find_map(|line| line.strip_prefix(key)).unwrap_or("none").trim();
    let (name, found, expected) = (field("Name:"), field("Version:"), python_version(version));
    ((name, found) != ("vibro-impact", &*expected))
        .then(|| format!("gives {name} {found}, where vibro-impact {expected} is expected"))
}

/// Problems if archives in a package differ from the archives next to it.
fn same_archives(dist: &Path, content: &Content, folder: &str, place: &str) -> Result<Vec<String>> {
    let mut wrong = Vec::new();
    for edition in Version::USUAL {
        let path = archive_of(dist, edition);
        let beside = fs::read(&path).map_err(Error::file("reading", &path))?;
        let name = file_name(&path);
        if content.get(&format!("{folder}{name}")) != Some(&beside) {
            wrong.push(format!("{place}: {folder}{name} is not the archive next to it"));
        }
    }
    Ok(wrong)
}

/// A file as text; empty if it does not exist.
fn text(content: &Content, name: &str) -> String {
    String::from_utf8_lossy(content.get(name).map_or(&[], Vec::as_slice)).into_owned()
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The files of a `.tar.gz`.
fn unpacked(path: &Path) -> Result<Content> {
    let failed = |error| Error::file("unpacking", path)(error);
    let mut tar = tar::Archive::new(GzDecoder::new(fs::File::open(path).map_err(failed)?));
    let mut content = Content::new();
    for entry in tar.entries().map_err(failed)? {
        let mut entry = entry.map_err(failed)?;
        let name = entry.path().map_err(failed)?.to_string_lossy().into_owned();
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).map_err(failed)?;
        content.insert(name, bytes);
    }
    Ok(content)
}
