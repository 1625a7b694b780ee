//! `modelDescription.xml` of FMI 3.0: its text from the component's own description, and what is read of a text.

use super::schema::ModelDescription;
use crate::describe::text;
use crate::error::{Error, Result};
use fmi_doors::Version;
use vibro_fmi::component::variables::Edition;
use vibro_fmi::fmi3::description;

/// The model description of an edition, made from the table.
///
/// # Errors
/// [`Error::Xml`] when its text is none.
pub fn model_description(edition: Edition) -> Result<ModelDescription> {
    from_xml(&text(description::description(edition), Version::Fmi3, None))
}

/// The model description of a text.
///
/// # Errors
/// [`Error::Xml`] when the text is none.
pub fn from_xml(text: &str) -> Result<ModelDescription> {
    quick_xml::de::from_str(text).map_err(|e| Error::Xml(e.to_string()))
}
