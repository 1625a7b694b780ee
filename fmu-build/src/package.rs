//! Puts the archives together: description, binary, documentation, icon, licences.

use crate::archive::{self, Content};
use crate::compile;
use crate::error::Result;
use crate::platforms::{self, Binaries, LeftOut};
use crate::sketch::Sketch;
use crate::version::{MODEL_DESCRIPTION, Version};
use crate::{date, explorer, icon, licences, page, reference, terminals};
use std::path::{Path, PathBuf};
use vibro_figures::canvas;
use vibro_paper_component::fmi2::description::MODEL_IDENTIFIER;

/// Path of an archive: `out` itself; if `out` is a folder, a file with the archive's name in it;
/// without `out`, a file with that name in the current folder.
pub fn placed(out: Option<&Path>, name: &str) -> PathBuf {
    let file = PathBuf::from(format!("{name}.fmu"));
    let is_folder = |out: &Path| out.is_dir() || out.to_string_lossy().ends_with(['/', '\\']);
    match out {
        Some(folder) if is_folder(folder) => folder.join(file),
        Some(out) => out.to_owned(),
        None => file,
    }
}

/// Whether the current folder is in the repository of this program's sources.
pub fn is_here() -> bool {
    let real = |path: &Path| path.canonicalize().ok();
    let here = std::env::current_dir().ok().and_then(|here| real(&here));
    here.zip(real(compile::workspace())).is_some_and(|(here, home)| here.starts_with(home))
}

/// Default path of the archive when the packager runs in the repository.
pub fn default_output() -> PathBuf {
    compile::target().join(format!("{MODEL_IDENTIFIER}.fmu"))
}

/// The icon as PNG.
///
/// # Errors
/// [`Error::Picture`](crate::Error::Picture).
pub fn icon() -> Result<Vec<u8>> {
    Ok(canvas::png(&icon::Icon)?)
}

/// Files that are generated and committed: path in the workspace → content. A test fails if one of
/// them is out of date.
///
/// # Errors
/// As [`Version::description`] and [`icon()`].
pub fn committed() -> Result<Content> {
    let mut files = described()?;
    files.insert("modelDescription/model.png".to_owned(), icon()?);
    files.insert("modelDescription/documentation/sketch.svg".to_owned(), canvas::svg(&Sketch)?.into_bytes());
    Ok(files)
}

/// Descriptions of the usual archives, generated from the table of variables. They do not have a
/// date; the date of the sources is put into the archive. Descriptions of the other editions are
/// checked when they are generated (`tests/description.rs`) and are not committed.
///
/// # Errors
/// As [`Version::description`].
pub fn described() -> Result<Content> {
    let files = [
        ("modelDescription/modelDescription.xml", Version::Fmi2),
        ("modelDescription/fmi3.xml", Version::Fmi3),
    ];
    let text =
        |(name, version): (&str, Version)| Ok((name.to_owned(), version.description(None)?.into_bytes()));
    files.into_iter().map(text).collect()
}

/// Content of the archive of a version, with binaries that are already compiled, and with the live
/// page if there is one.
///
/// # Errors
/// [`Error::File`](crate::Error::File) if a licence cannot be read; the errors of
/// [`Version::description`] and [`icon()`].
pub fn content(version: Version, binaries: &Binaries, live: Option<&[u8]>) -> Result<Content> {
    let mut content = Content::from([
        (MODEL_DESCRIPTION.to_owned(), version.description(date::of_sources())?.into_bytes()),
        ("documentation/index.html".to_owned(), page::page(live.is_some()).into_bytes()),
        // The FMU reads no resources, but hosts pass the path of the folder.
        ("resources/README.txt".to_owned(), b"This FMU needs no resources.\n".to_vec()),
    ]);
    content.extend(live.map(|page| (explorer::PATH.to_owned(), page.to_vec())));
    content.insert("documentation/fmi-ls-ref.txt".to_owned(), reference::EXPLANATION.as_bytes().to_vec());
    let mut under = |folder: &str, files: Content| {
        content.extend(files.into_iter().map(|(name, bytes)| (format!("{folder}/{name}"), bytes)));
    };
    under(reference::FOLDER, reference::files()?);
    if version != Version::Fmi2 {
        // The file has fmiVersion 3.0, which the FMI Library reports as a fatal error in an
        // archive of FMI 2.0.
        under("terminalsAndIcons", terminals::files()?);
    }
    match version {
        Version::Fmi2 => {
            content.insert("model.png".to_owned(), icon()?);
            content.extend(
                licences::texts(live.is_some())?
                    .into_iter()
                    .map(|(name, text)| (format!("licenses/{name}"), text)),
            );
        }
        // FMI 3.0.2, 2.5.1: file names with a defined meaning.
        Version::Fmi3 | Version::Arrays | Version::Clocked => {
            content.insert("documentation/diagram.png".to_owned(), canvas::png(&Sketch)?);
            content.insert("documentation/diagram.svg".to_owned(), canvas::svg(&Sketch)?.into_bytes());
            content.insert("documentation/externalDependencies.txt".to_owned(), NEEDS.as_bytes().to_vec());
            let place =
                |name: &str| if name == licences::LIST { "license.txt".to_owned() } else { name.to_owned() };
            let texts = licences::texts(live.is_some())?.into_iter();
            content
                .extend(texts.map(|(name, text)| (format!("documentation/licenses/{}", place(&name)), text)));
        }
    }
    content.extend(binaries.of(version.fmi(), MODEL_IDENTIFIER));
    Ok(content)
}

/// System requirements for loading the library.
const NEEDS: &str = "The library needs the C library of the system and its mathematics alone: on Linux glibc 2.17 or later where \
it was built for all platforms, else that of the machine that built it; on Windows the universal C run time (part of Windows 10 \
and later); on macOS libSystem.\n";

/// Writes the usual archives for this computer: FMI 2.0 to `output`, and FMI 3.0 next to it.
///
/// # Errors
/// All errors of [`platforms::at_hand`] and [`write()`].
pub fn build(output: &Path) -> Result<()> {
    write(output, &Version::USUAL, &platforms::at_hand()?, None)
}

/// Writes archives with binaries that are already compiled.
///
/// # Errors
/// The errors of [`content`]; [`Error::File`](crate::Error::File) if a file cannot be written.
pub fn write(output: &Path, versions: &[Version], binaries: &Binaries, live: Option<&[u8]>) -> Result<()> {
    for version in versions {
        archive::write(&content(*version, binaries, live)?, &version.beside(output))?;
    }
    Ok(())
}

/// Compiles the library for every platform that can be built here and writes the archives. Returns
/// the platforms that cannot be built.
///
/// # Errors
/// As [`build`].
pub fn build_all(output: &Path, versions: &[Version], live: Option<&[u8]>) -> Result<Vec<LeftOut>> {
    let (binaries, left_out) = platforms::all(&[])?;
    write(output, versions, &binaries, live)?;
    Ok(left_out)
}
