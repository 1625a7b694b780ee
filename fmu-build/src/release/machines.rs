//! Parts of a release for machines described by text files: the examples with the library for
//! their FMUs, and the prebuilt command line `vibro`.

use crate::archive::{self, Content};
use crate::compile::{PLATFORM_TUPLE, PROGRAM, workspace};
use crate::error::{Error, Result};
use crate::kit::{KIT_FILE, Kit};
use crate::licences;
use crate::platforms::Binaries;
use std::fs;
use std::process::{Command, Stdio};

/// Name of the file with the examples.
pub const EXAMPLES: &str = "assembly-examples.zip";
/// Name of the file with the truth suite.
pub const SUITE: &str = "truth-suite.zip";

/// Introduction of the file with the examples.
const READ_ME: &str = "Machines of text files, and the library of which their FMUs are made, for all platforms.\n\n\
                       With `vibro` of this release, in this folder:\n\n    \
                       vibro run damper_with_buffer.toml --until 2s --out results\n    \
                       vibro fmu damper_with_buffer.toml --kit machine-kit.zip --out fmu\n\n\
                       With its Python package: vibro_impact.Machine(\"damper_with_buffer.toml\").fmu()\n\n\
                       Each file says what it is held against.\n";

/// The machine files of `examples/assembly`, with their records and matrices, and the kit, once:
/// name → content. An archive of each machine would repeat the library.
///
/// # Errors
/// [`Error::File`]; as [`archive::to_bytes`].
pub fn examples(kit: &Kit) -> Result<Content> {
    let folder = workspace().join("examples/assembly");
    let reading = || Error::file("reading the folder", &folder);
    let entries: std::io::Result<Vec<_>> = fs::read_dir(&folder).map_err(reading())?.collect();
    let mut content = Content::new();
    for path in entries.map_err(reading())?.into_iter().map(|entry| entry.path()) {
        let name = path.file_name().expect("a file has a name").to_string_lossy().into_owned();
        content.insert(name, fs::read(&path).map_err(Error::file("reading", &path))?);
    }
    content.insert("README.txt".into(), READ_ME.into());
    content.insert(KIT_FILE.into(), archive::to_bytes(&kit.entries())?);
    Ok(content)
}

/// The truth suite: scripts, and the machine, page and tables of each case; name → content. Its
/// FMUs, a library of some megabytes each, are made by its `build.py` with the kit of the examples.
///
/// # Errors
/// [`Error::File`].
pub fn suite() -> Result<Content> {
    let mut content = Content::new();
    let mut folders = vec![workspace().join("truth")];
    while let Some(folder) = folders.pop() {
        let reading = || Error::file("reading the folder", &folder);
        let entries: std::io::Result<Vec<_>> = fs::read_dir(&folder).map_err(reading())?.collect();
        for path in entries.map_err(reading())?.into_iter().map(|entry| entry.path()) {
            if path.is_dir() {
                // Python's own files.
                folders.extend((!path.ends_with("__pycache__")).then_some(path));
            } else {
                let name = path.strip_prefix(workspace()).expect("a file of the workspace");
                let name = name.components().map(|part| part.as_os_str().to_string_lossy());
                let name = name.collect::<Vec<_>>().join("/");
                content.insert(name, fs::read(&path).map_err(Error::file("reading", &path))?);
            }
        }
    }
    Ok(content)
}

/// An archive with the command line for each platform, by its name: the program, instructions, and
/// the licences.
///
/// # Errors
/// As [`licences::texts_of`].
pub fn programs(binaries: &Binaries, version: &str, texts: &Content) -> Result<Content> {
    let mut archives = Content::new();
    for (tuple, bytes) in binaries.folders() {
        let program = format!("{PROGRAM}{}", if tuple.ends_with("windows") { ".exe" } else { "" });
        let readme = format!(
            "vibro-impact {version}, the command line for {tuple}.\n\n{program} --help explains \
             what it does; for machines in text files:\n\n    \
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

/// The licences of all code linked into the command line.
///
/// # Errors
/// As [`licences::texts_of`].
pub fn licences_of_programs() -> Result<Content> {
    licences::texts_of(crate::compile::Product::CommandLine, false)
}

/// Runs the program for this platform on an example machine. Returns a description of the trial.
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
