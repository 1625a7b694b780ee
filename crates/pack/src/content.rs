//! Content of a machine's archive: the library that serves all machines, under the machine's name,
//! and the machine's file in the resources. Everything else is generated from this file.

use crate::archive::{self, Content};
use crate::error::Result;
use crate::kit::{Kit, LICENCE_LIST};
use crate::{page, reference, terminals};
use fmi_doors::Version;
use std::path::Path;
use vibro_figures::canvas;
use vibro_machine::Description;
use vibro_machine_component::{FILE, Plan};
use vibro_sketch::Sketch;

/// Path of the model description inside every archive.
pub const MODEL_DESCRIPTION: &str = "modelDescription.xml";

/// Suffix of an archive's file name, which depends on the FMI version.
pub const fn suffix(version: Version) -> &'static str {
    match version {
        Version::Fmi2 => "",
        Version::Fmi3 => "-FMI3",
    }
}

/// File name of a machine's archive: `NAME.fmu` for FMI 2.0, `NAME-FMI3.fmu` for FMI 3.0, so that
/// both fit into one folder.
pub fn file_name(machine: &str, version: Version) -> String {
    format!("{machine}{}.fmu", suffix(version))
}

/// Content of a version's archive; a plan with arrays gives the FMI 3.0 archive with arrays.
///
/// # Errors
/// [`Error::Picture`](crate::Error::Picture), only through a defect of this crate.
///
/// # Examples
///
/// ```
/// use fmi_doors::Version;
/// use vibro_machine_component::Plan;
/// use vibro_pack::{Binaries, Kit, MODEL_DESCRIPTION, content};
///
/// # let text = r#"
/// #     name = "Ball"
/// #     gravity = 9.81
/// #     body.ball = { mass = "20 g", gravity = 1.0 }
/// #     stop.floor = { between = ["ground", "ball"], gap = "1 m", restitution = 0.9 }
/// # "#;
/// let plan = Plan::new(text.to_owned(), "ball.toml").unwrap();
/// let library = b"the bytes of the compiled library".to_vec();
/// let kit = Kit { binaries: Binaries::own(library), ..Kit::default() };
/// let files = content(Version::Fmi3, &plan, &kit)?;
/// assert_eq!(files["resources/machine.toml"], text.as_bytes());
/// let description = String::from_utf8_lossy(&files[MODEL_DESCRIPTION]);
/// assert!(description.contains("modelName=\"Ball\""));
/// # Ok::<(), vibro_pack::Error>(())
/// ```
pub fn content(version: Version, plan: &Plan, kit: &Kit) -> Result<Content> {
    let mut content = Content::from([
        (MODEL_DESCRIPTION.to_owned(), plan.xml(version, kit.date.clone()).into_bytes()),
        (format!("resources/{FILE}"), plan.text().as_bytes().to_vec()),
        ("documentation/index.html".to_owned(), page::page(plan)?.into_bytes()),
    ]);
    content.extend(pictures(version, plan)?);
    let folder = if version == Version::Fmi2 { "licenses" } else { "documentation/licenses" };
    for (name, text) in &kit.licences {
        // FMI 3.0.2, 2.5.1.1.1: `index.html` is the entry point of the documentation.
        let first = version != Version::Fmi2 && name == LICENCE_LIST;
        let name = if first { "license.txt" } else { name };
        content.insert(format!("{folder}/{name}"), text.clone());
    }
    let results = reference::files(plan);
    if !results.is_empty() {
        let text = reference::EXPLANATION.as_bytes().to_vec();
        content.insert("documentation/fmi-ls-ref.txt".to_owned(), text);
    }
    content.extend(results.into_iter().map(|(name, text)| (format!("{}/{name}", reference::FOLDER), text)));
    content.extend(kit.binaries.of(version, plan.name()));
    if kit.binaries.has_component(version) {
        content.insert(WASM_MANIFEST.0.to_owned(), WASM_MANIFEST.1.as_bytes().to_vec());
    }
    Ok(content)
}

/// Manifest of the layered standard for WebAssembly in archives with its component: path and text.
/// The version is the one that the working draft gives as an example.
const WASM_MANIFEST: (&str, &str) = (
    "extra/org.modelica.fmi-ls-wasm/manifest.xml",
    r#"<?xml version="1.0" encoding="UTF-8"?>
<fmiLayeredStandardManifest
  xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"
  fmi-ls:fmi-ls-name="org.modelica.fmi-ls-wasm"
  fmi-ls:fmi-ls-version="0.1.0"
  fmi-ls:fmi-ls-description="FMI Layered Standard for WebAssembly"/>
"#,
);

/// Writes the archive of a machine for an FMI version, atomically.
///
/// # Errors
/// [`Error::Machine`](crate::Error::Machine) for a machine that cannot start,
/// [`Error::File`](crate::Error::File).
///
/// # Examples
///
/// ```
/// use fmi_doors::Version;
/// use vibro_pack::{Binaries, Kit, archive, file_name, write};
///
/// # let text = r#"
/// #     name = "Ball"
/// #     gravity = 9.81
/// #     body.ball = { mass = "20 g", gravity = 1.0 }
/// #     stop.floor = { between = ["ground", "ball"], gap = "1 m", restitution = 0.9 }
/// # "#;
/// let ball = vibro_machine::file::parse(text, "ball.toml", &vibro_machine::file::no_records)?;
/// let library = b"the bytes of the compiled library".to_vec();
/// let kit = Kit { binaries: Binaries::own(library.clone()), ..Kit::default() };
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join(file_name("Ball", Version::Fmi2));
/// write(&ball, Version::Fmi2, &kit, &path)?;
/// let files = archive::read_all(&path)?;
/// assert!(path.ends_with("Ball.fmu") && files.values().any(|bytes| *bytes == library));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write(machine: &Description, version: Version, kit: &Kit, path: &Path) -> Result<()> {
    archive::write(&content(version, &Plan::of(machine)?, kit)?, path)
}

/// Icon, diagram and terminals, with the names required by the version (FMI 2.0, 2.3; FMI 3.0.2,
/// 2.5.1 and 2.4.9).
fn pictures(version: Version, plan: &Plan) -> Result<Content> {
    let machine = &plan.assembly.description;
    let (icon_svg, icon) = canvas::svg_and_png(&Sketch::icon(machine))?;
    if version == Version::Fmi2 {
        return Ok(Content::from([("model.png".to_owned(), icon)]));
    }
    let (svg, png) = canvas::svg_and_png(&Sketch::new(machine))?;
    let terminals = terminals::xml(plan).into_bytes();
    Ok(Content::from([
        ("documentation/diagram.svg".to_owned(), svg.into_bytes()),
        ("documentation/diagram.png".to_owned(), png),
        ("terminalsAndIcons/terminalsAndIcons.xml".to_owned(), terminals),
        ("terminalsAndIcons/icon.svg".to_owned(), icon_svg.into_bytes()),
        ("terminalsAndIcons/icon.png".to_owned(), icon),
    ]))
}
