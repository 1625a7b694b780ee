//! Parts of a release for machines that text files describe: archives of the examples, and the
//! prebuilt command line `vibro`.

use crate::archive::{self, Content};
use crate::compile::{PLATFORM_TUPLE, PROGRAM, workspace};
use crate::error::{Error, Result};
use crate::kit::Kit;
use crate::platforms::Binaries;
use crate::version::Version;
use crate::{assembly, licences};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use vibro_assembly_fmi::Plan;

/// Name of the file with the archives of the examples.
pub const EXAMPLES: &str = "assembly-examples.zip";

/// Platforms of the example archives. Each archive holds one library per platform; all platforms
/// would make hundreds of megabytes.
const PLATFORMS: [&str; 3] = ["x86_64-linux", "x86_64-windows", "aarch64-darwin"];

/// The files of the example machines, sorted by name.
fn example_files() -> Result<Vec<PathBuf>> {
    let folder = workspace().join("examples/assembly");
    let reading = || Error::file("reading the folder", &folder);
    let entries: std::io::Result<Vec<_>> = fs::read_dir(&folder).map_err(reading())?.collect();
    let paths = entries.map_err(reading())?.into_iter().map(|entry| entry.path());
    let mut files: Vec<_> = paths.filter(|p| p.extension().is_some_and(|ending| ending == "toml")).collect();
    files.sort();
    Ok(files)
}

/// The archives of all example machines, with the libraries of the commonest platforms that the kit
/// has, or the library of this machine's platform if the kit has none of them: name → archive.
///
/// # Errors
/// As [`assembly::content`].
pub fn examples(kit: &Kit) -> Result<Content> {
    let mut binaries = kit.binaries.only(&PLATFORMS);
    if binaries.folders().next().is_none() {
        binaries = kit.binaries.clone();
    }
    let kit = Kit { binaries, ..kit.clone() };
    let mut archives = Content::new();
    for file in example_files()? {
        let plan = Plan::of(&vibro_assembly::file::read(&file)?)?;
        for version in Version::USUAL {
            let name = version.beside(Path::new(&format!("{}.fmu", plan.name())));
            let bytes = archive::to_bytes(&assembly::content(version, &plan, &kit)?)?;
            archives.insert(name.to_string_lossy().into_owned(), bytes);
        }
    }
    Ok(archives)
}

/// An archive with the command line for each platform, by its name: the program, what to call, and
/// the licences.
///
/// # Errors
/// As [`licences::texts_of`].
pub fn programs(binaries: &Binaries, version: &str, texts: &Content) -> Result<Content> {
    let mut archives = Content::new();
    for (tuple, bytes) in binaries.folders() {
        let program = format!("{PROGRAM}{}", if tuple.ends_with("windows") { ".exe" } else { "" });
        let readme = format!(
            "vibro-impact {version}, the command line for {tuple}.\n\n{program} --help tells what it does, and of machines of text files:\n\n    \
             {program} check machine.toml\n    {program} run machine.toml --until 2s --out results\n    \
             {program} draw machine.toml --out sketch\n\nLicences of what is linked in are in licenses/.\n"
        );
        let mut content =
            Content::from([(program, bytes.to_vec()), ("README.txt".into(), readme.into_bytes())]);
        content.extend(texts.iter().map(|(name, text)| (format!("licenses/{name}"), text.clone())));
        archives.insert(format!("{PROGRAM}-{version}-{tuple}.zip"), archive::to_bytes(&content)?);
    }
    Ok(archives)
}

/// The licences of what is linked into the command line.
///
/// # Errors
/// As [`licences::texts_of`].
pub fn licences_of_programs() -> Result<Content> {
    licences::texts_of(crate::compile::Product::CommandLine, false)
}

/// Runs the program for this platform on an example machine; returns a description of the trial.
///
/// # Errors
/// [`Error::Release`] if it fails.
pub fn tried(program: &[u8]) -> Result<String> {
    let folder = tempfile::tempdir().map_err(Error::file("making a folder in", &std::env::temp_dir()))?;
    let path = folder.path().join(format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX));
    archive::write_file(&path, program)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755))
            .map_err(Error::file("writing", &path))?;
    }
    let machine = workspace().join("examples/assembly/bouncing_ball.toml");
    let mut check = Command::new(&path);
    let run = check.arg("check").arg(&machine).stdin(Stdio::null()).output();
    let output = run.map_err(Error::file("running", &path))?;
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    if output.status.success() && told.contains("ball") {
        return Ok(format!("`{PROGRAM} check` on {PLATFORM_TUPLE} here; of other platforms built only"));
    }
    let words = String::from_utf8_lossy(&output.stderr).into_owned();
    Err(Error::Release(vec![format!("{PROGRAM} check fails: {words}{told}")]))
}
