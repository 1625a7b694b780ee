//! Archives of a machine of the user's own: the library that serves all machines, under the machine's name, and the machine's file
//! in the resources. All but this is generated from the file, so that nothing is compiled for a machine.

use crate::archive::{self, Content};
use crate::error::Result;
use crate::kit::Kit;
use crate::licences;
use crate::version::{MODEL_DESCRIPTION, Version};
use std::path::{Path, PathBuf};
use vibro_assembly_fmi::{FILE, Plan, Quantity};

/// Everything that the archive of a version holds.
pub fn content(version: Version, plan: &Plan, kit: &Kit) -> Content {
    let fmi = if version == Version::Fmi2 { fmi_doors::Version::Fmi2 } else { fmi_doors::Version::Fmi3 };
    let mut content = Content::from([
        (MODEL_DESCRIPTION.to_owned(), plan.xml(fmi, kit.date.clone()).into_bytes()),
        (format!("resources/{FILE}"), plan.text().as_bytes().to_vec()),
        ("documentation/index.html".to_owned(), page(plan).into_bytes()),
    ]);
    let folder = if version == Version::Fmi2 { "licenses" } else { "documentation/licenses" };
    for (name, text) in &kit.licences {
        // FMI 3.0.2, 2.5.1.3: the file of this name is where one begins to read.
        let first = version != Version::Fmi2 && name == licences::LIST;
        let name = if first { "license.txt" } else { name };
        content.insert(format!("{folder}/{name}"), text.clone());
    }
    content.extend(kit.binaries.named(version, plan.name()));
    content
}

/// Writes the archives of the machine in a file, that of FMI 2.0 to `output` or, without it, under the machine's name here, and that
/// of FMI 3.0 beside it; returns their paths.
///
/// # Errors
/// [`Error::Refusal`](crate::Error::Refusal) with everything that is wrong with the file,
/// [`Error::Machine`](crate::Error::Machine) for a machine that has no start, [`Error::File`](crate::Error::File).
pub fn write(file: &Path, output: Option<&Path>, kit: &Kit) -> Result<Vec<PathBuf>> {
    let plan = Plan::of(&vibro_assembly::file::read(file)?)?;
    let output = output.map_or_else(|| PathBuf::from(format!("{}.fmu", plan.name())), Path::to_owned);
    let mut written = Vec::new();
    for version in Version::USUAL {
        let path = version.beside(&output);
        archive::write(&content(version, &plan, kit), &path)?;
        written.push(path);
    }
    Ok(written)
}

/// The page of documentation: what variables there are. Names and units consist of letters, digits and signs that HTML gives no
/// meaning.
fn page(plan: &Plan) -> String {
    let name = plan.name();
    let mut text = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head><meta charset=\"utf-8\"><title>{name}</title></head>\n<body>\n<h1>{name}</h1>\n\
         <p>A piecewise linear machine, advanced by its exact flow from event to event: its answer depends on no tolerance and on no \
         step size. The machine stands in <a href=\"../resources/{FILE}\">resources/{FILE}</a>.</p>\n\
         <table>\n<tr><th>Variable</th><th>Unit</th><th>What it is</th><th>Start</th></tr>\n"
    );
    for row in &plan.table.rows {
        let start = match row.quantity {
            Quantity::Parameter(i) => plan.table.parameters[i].value.to_string(),
            Quantity::Input(_) => "0".to_owned(),
            _ => String::new(),
        };
        text += &format!(
            "<tr><td><code>{}</code></td><td>{}</td><td>{}</td><td>{start}</td></tr>\n",
            row.name, row.unit, row.meaning
        );
    }
    text + "</table>\n</body>\n</html>\n"
}
