//! FMU archives.

use crate::file::read;
use fmi_doors::Version;
use std::io::Cursor;
use std::path::Path;
use vibro_assembly_fmi::Plan;
use vibro_pack::{Kit, archive, content};
use wasm_bindgen::prelude::*;

/// The FMU of a machine for FMI 2.0 or 3.0 (`version`), around the libraries of a kit, which is the
/// content of its file.
///
/// # Errors
/// The problems of the text as JSON; a kit without a library; a machine without a start.
#[wasm_bindgen]
pub fn pack(
    text: &str,
    names: Vec<String>,
    texts: Vec<String>,
    version: u32,
    kit: &[u8],
) -> Result<Vec<u8>, JsError> {
    let machine = read(text, &names, &texts)?;
    let version = if version == 2 { Version::Fmi2 } else { Version::Fmi3 };
    let entries = archive::of(Cursor::new(kit), Path::new("kit"))?;
    let kit = Kit::from_entries(entries).ok_or_else(|| JsError::new("the kit has no library of a known platform"))?;
    Ok(archive::to_bytes(&content(version, &Plan::of(&machine.description)?, &kit)?)?)
}

/// Platforms of the libraries of a kit, with commas.
///
/// # Errors
/// What is no kit.
#[wasm_bindgen]
pub fn platforms(kit: &[u8]) -> Result<String, JsError> {
    let entries = archive::of(Cursor::new(kit), Path::new("kit"))?;
    let kit = Kit::from_entries(entries).ok_or_else(|| JsError::new("the kit has no library of a known platform"))?;
    Ok(kit.binaries.folders().map(|(tuple, _)| tuple).collect::<Vec<_>>().join(", "))
}
