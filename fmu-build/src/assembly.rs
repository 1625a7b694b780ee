//! Archives of the user's own machine: the library that serves all machines, under the machine's
//! name, and the machine's file in the resources. The rest of the archive is generated from the
//! file, so nothing is compiled for a machine.

use crate::archive::{self, Content};
use crate::error::Result;
use crate::package::placed;
use crate::version::Version;
use std::path::{Path, PathBuf};
use vibro_machine_component::Plan;
use vibro_pack::Kit;

/// Content of a version's archive. For [`Version::Arrays`] `plan` must be the plan with arrays.
///
/// # Errors
/// [`Error::Pack`](crate::Error::Pack): only in case of a defect in this crate.
pub fn content(version: Version, plan: &Plan, kit: &Kit) -> Result<Content> {
    Ok(vibro_pack::content(version.fmi(), plan, kit)?)
}

/// Writes the archives of the machine in a file and returns their paths. The archive of FMI 2.0 is
/// [placed at `out`](placed); the archives of FMI 3.0 are next to it. The archive with arrays is
/// written only if `arrays` is set.
///
/// # Errors
/// [`Error::Refusal`](crate::Error::Refusal) with all problems of the file,
/// [`Error::Machine`](crate::Error::Machine) for a machine that cannot start,
/// [`Error::File`](crate::Error::File).
pub fn write(file: &Path, out: Option<&Path>, arrays: bool, kit: &Kit) -> Result<Vec<PathBuf>> {
    let mut plan = Plan::of(&vibro_machine::file::read(file)?)?;
    let output = placed(out, plan.name());
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
