//! Puts the archive together: description, binary, documentation, icon, licences.

use crate::archive::{self, Content};
use crate::compile;
use crate::error::{Error, Result};
use crate::platforms::{self, Binaries, LeftOut};
use crate::sketch::Sketch;
use crate::{check, describe, fmi3, icon, licences, page};
use std::path::{Path, PathBuf};
use vibro::figures::canvas;
use vibro_fmi::fmi2::description::MODEL_IDENTIFIER;
use vibro_fmi::fmi3::description::{CLOCKED, Edition, MAIN};

/// Where the archive goes when nobody says otherwise.
pub fn default_output() -> PathBuf {
    compile::target().join(format!("{MODEL_IDENTIFIER}.fmu"))
}

/// `modelDescription.xml`, checked.
///
/// # Errors
/// [`Error::Invalid`] with everything that is wrong.
pub fn description() -> Result<String> {
    let text = describe::to_xml(&describe::model_description())?;
    let problems = check::problems(&text)?;
    if problems.is_empty() { Ok(text) } else { Err(Error::Invalid(problems)) }
}

/// The same of FMI 3.0.
///
/// # Errors
/// As [`description`].
pub fn description3(edition: Edition) -> Result<String> {
    let text = describe::to_xml(&fmi3::model_description(edition))?;
    let problems = fmi3::check::problems(&text)?;
    if problems.is_empty() { Ok(text) } else { Err(Error::Invalid(problems)) }
}

/// The icon as PNG.
///
/// # Errors
/// [`Error::Picture`].
pub fn icon() -> Result<Vec<u8>> {
    Ok(canvas::png(&icon::Icon)?)
}

/// Files that are generated and committed: path in the workspace → content. A test fails when one is stale.
///
/// # Errors
/// As [`description`] and [`icon()`].
pub fn committed() -> Result<Content> {
    let mut files = described()?;
    files.insert("modelDescription/model.png".to_owned(), icon()?);
    files.insert("modelDescription/documentation/sketch.svg".to_owned(), canvas::svg(&Sketch)?.into_bytes());
    Ok(files)
}

/// Those of them that follow from the table of variables.
///
/// # Errors
/// As [`description`].
pub fn described() -> Result<Content> {
    let text = |edition| Ok::<_, Error>(description3(edition)?.into_bytes());
    Ok(Content::from([
        ("modelDescription/modelDescription.xml".to_owned(), description()?.into_bytes()),
        ("modelDescription/fmi3.xml".to_owned(), text(MAIN)?),
        ("modelDescription/fmi3-clocked.xml".to_owned(), text(CLOCKED)?),
    ]))
}

/// Everything the archive holds, around binaries compiled before.
///
/// # Errors
/// [`Error::File`] when a licence cannot be read, and as [`description`] and [`icon()`].
pub fn content(binaries: Binaries) -> Result<Content> {
    let mut content = Content::from([
        ("modelDescription.xml".to_owned(), description()?.into_bytes()),
        ("model.png".to_owned(), icon()?),
        ("documentation/index.html".to_owned(), page::page().into_bytes()),
        // Nothing is read from it; hosts hand over its place all the same.
        ("resources/README.txt".to_owned(), b"This FMU needs no resources.\n".to_vec()),
    ]);
    licences::add(&mut content)?;
    content.extend(binaries);
    Ok(content)
}

/// Compiles the library for this machine and writes the archive.
///
/// # Errors
/// Everything that can go wrong on the way.
pub fn build(output: &Path) -> Result<()> {
    archive::write(&content(platforms::own()?)?, output)
}

/// Compiles the library for every platform that can be built here and writes the archive; returns the others.
///
/// # Errors
/// As [`build`].
pub fn build_all(output: &Path) -> Result<Vec<LeftOut>> {
    let (binaries, left_out) = platforms::all()?;
    archive::write(&content(binaries)?, output)?;
    Ok(left_out)
}
