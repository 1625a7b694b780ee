//! FMU archives.

use crate::file::read;
use fmi_doors::Version;
use vibro_machine_component::Plan;
use vibro_pack::{around, platforms_of};
use wasm_bindgen::prelude::*;

/// The FMU of a machine for FMI 2.0 or 3.0 (`version`), with the libraries of a kit, given as the
/// bytes of its file.
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
    Ok(around(version, &Plan::of(&machine.description)?, kit)?)
}

/// Platforms of the libraries of a kit, separated by commas.
///
/// # Errors
/// If `kit` is not a kit.
#[wasm_bindgen]
pub fn platforms(kit: &[u8]) -> Result<String, JsError> {
    Ok(platforms_of(kit)?.join(", "))
}
