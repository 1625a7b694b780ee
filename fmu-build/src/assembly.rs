//! Archives of a machine of the user's own: the library that serves all machines, under the machine's name, and the machine's file
//! in the resources. All but this is generated from the file, so that nothing is compiled for a machine.

use crate::archive::{self, Content};
use crate::error::Result;
use crate::kit::Kit;
use crate::version::{MODEL_DESCRIPTION, Version};
use crate::{described_page, described_reference, described_terminals, licences, reference};
use std::path::{Path, PathBuf};
use vibro_assembly_fmi::{FILE, Plan};
use vibro_figures::canvas;
use vibro_sketch::Sketch;

/// Everything that the archive of a version holds, of the plan with arrays where it is that of the version with them.
///
/// # Errors
/// [`Error::Picture`](crate::Error::Picture), which would be a mistake of ours.
pub fn content(version: Version, plan: &Plan, kit: &Kit) -> Result<Content> {
    let fmi = if version == Version::Fmi2 { fmi_doors::Version::Fmi2 } else { fmi_doors::Version::Fmi3 };
    let mut content = Content::from([
        (MODEL_DESCRIPTION.to_owned(), plan.xml(fmi, kit.date.clone()).into_bytes()),
        (format!("resources/{FILE}"), plan.text().as_bytes().to_vec()),
        ("documentation/index.html".to_owned(), described_page::page(plan)?.into_bytes()),
    ]);
    content.extend(pictures(version, plan)?);
    let folder = if version == Version::Fmi2 { "licenses" } else { "documentation/licenses" };
    for (name, text) in &kit.licences {
        // FMI 3.0.2, 2.5.1.3: the file of this name is where one begins to read.
        let first = version != Version::Fmi2 && name == licences::LIST;
        let name = if first { "license.txt" } else { name };
        content.insert(format!("{folder}/{name}"), text.clone());
    }
    let results = described_reference::files(plan);
    if !results.is_empty() {
        let text = described_reference::EXPLANATION.as_bytes().to_vec();
        content.insert("documentation/fmi-ls-ref.txt".to_owned(), text);
    }
    content.extend(results.into_iter().map(|(name, text)| (format!("{}/{name}", reference::FOLDER), text)));
    content.extend(kit.binaries.named(version, plan.name()));
    Ok(content)
}

/// Writes the archives of the machine in a file, that of FMI 2.0 to `output` or, without it, under the machine's name here, and those
/// of FMI 3.0 beside it, the one with arrays where it is asked for; returns their paths.
///
/// # Errors
/// [`Error::Refusal`](crate::Error::Refusal) with everything that is wrong with the file,
/// [`Error::Machine`](crate::Error::Machine) for a machine that has no start, [`Error::File`](crate::Error::File).
pub fn write(file: &Path, output: Option<&Path>, arrays: bool, kit: &Kit) -> Result<Vec<PathBuf>> {
    let mut plan = Plan::of(&vibro_assembly::file::read(file)?)?;
    let output = output.map_or_else(|| PathBuf::from(format!("{}.fmu", plan.name())), Path::to_owned);
    let mut written = Vec::new();
    for version in Version::USUAL.into_iter().chain(arrays.then_some(Version::Arrays)) {
        if version == Version::Arrays {
            plan = plan.with_arrays();
        }
        let path = version.beside(&output);
        archive::write(&content(version, &plan, kit)?, &path)?;
        written.push(path);
    }
    Ok(written)
}

/// Icon, diagram and terminals, by the names that the version gives them (FMI 2.0, 2.3; FMI 3.0.2, 2.5.1 and 2.4.9).
fn pictures(version: Version, plan: &Plan) -> Result<Content> {
    let machine = &plan.assembly.description;
    let (icon_svg, icon) = canvas::svg_and_png(&Sketch::icon(machine))?;
    if version == Version::Fmi2 {
        return Ok(Content::from([("model.png".to_owned(), icon)]));
    }
    let (svg, png) = canvas::svg_and_png(&Sketch::new(machine))?;
    let terminals = described_terminals::xml(plan).into_bytes();
    Ok(Content::from([
        ("documentation/diagram.svg".to_owned(), svg.into_bytes()),
        ("documentation/diagram.png".to_owned(), png),
        ("terminalsAndIcons/terminalsAndIcons.xml".to_owned(), terminals),
        ("terminalsAndIcons/icon.svg".to_owned(), icon_svg.into_bytes()),
        ("terminalsAndIcons/icon.png".to_owned(), icon),
    ]))
}
