//! `modelDescription.xml` of FMI 2.0: its text from the component's own description, and what is read of a text.

use crate::error::{Error, Result};
use crate::schema::ModelDescription;
use fmi_doors::Version;
use fmi_doors::description::Description;
use serde::Serialize;
use vibro_fmi::fmi2::description;

/// The text of a description of either version, with the date on which it was made, where there is one.
pub(crate) fn text(description: Description, version: Version, date: Option<String>) -> String {
    let described = Description {
        generation_tool: concat!("fmu-build ", env!("CARGO_PKG_VERSION")).into(),
        generation_date_and_time: date.map(Into::into),
        ..description
    };
    described.xml(version)
}

/// The model description, made from the table.
///
/// # Errors
/// [`Error::Xml`] when its text is none.
pub fn model_description() -> Result<ModelDescription> {
    from_xml(&text(description::description(), Version::Fmi2, None))
}

/// A description as text, of any version.
///
/// # Errors
/// [`Error::Xml`] when it cannot be written.
pub fn to_xml(model: &impl Serialize) -> Result<String> {
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let mut serializer = quick_xml::se::Serializer::new(&mut text);
    serializer.indent(' ', 2);
    model.serialize(serializer).map_err(|e| Error::Xml(e.to_string()))?;
    text.push('\n');
    Ok(text)
}

/// The model description of a text.
///
/// # Errors
/// [`Error::Xml`] when the text is none.
pub fn from_xml(text: &str) -> Result<ModelDescription> {
    quick_xml::de::from_str(text).map_err(|e| Error::Xml(e.to_string()))
}
