//! `vibro new`, which writes a machine's file as a start, and `vibro fmu`, which packs a machine's
//! file.

use crate::common_arguments::Common;
use crate::output;
use crate::study_arguments::{Fmu, New};
use fmi_doors::Version;
use std::path::{Path, PathBuf};
use vibro::gallery::{EXAMPLES, Example};
use vibro::{Error, Result};
use vibro_machine::description::Description;
use vibro_pack::{KIT_FILE, Kit};

/// Environment variable with the folder of archives.
const ARCHIVES: &str = "VIBRO_IMPACT_ARCHIVES";

/// Writes the file of a machine of the gallery, or lists the machines.
///
/// # Errors
/// [`Error::Refused`] for an unknown name, and for a file that already exists; [`Error::File`].
pub fn begin(arguments: &New) -> Result<()> {
    let Some(name) = &arguments.name else {
        let lines: Vec<String> = EXAMPLES.iter().map(|e| format!("{:20} {}", e.name, e.about())).collect();
        return output::say(&format!("{}\n\nvibro new NAME writes NAME.toml", lines.join("\n")));
    };
    let example = Example::find(name)?;
    if name != example.name {
        let new = example.name;
        crate::note(&format!("`vibro new {name}` is now `vibro new {new}`; the old name works until 0.5"));
    }
    let path = arguments.to.clone().unwrap_or_else(|| format!("{name}.toml").into());
    let written = example.write(&path)?;
    let names: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    let file = path.display();
    output::say(&format!("wrote {}\nnext: vibro draw {file}, vibro run {file} --until 1s", names.join(", ")))
}

/// Packs a machine as an FMU in the folder of results: NAME.fmu for FMI 2.0, NAME-FMI3.fmu for
/// FMI 3.0. An archive that it replaces is named.
///
/// # Errors
/// [`Error::Refused`] if no library is available, and for a machine that cannot be packed;
/// [`Error::File`].
pub fn pack(machine: &Description, arguments: &Fmu, common: &Common) -> Result<()> {
    let refused =
        |what: String| move |error: vibro_pack::Error| Error::Refused { what, problem: error.to_string() };
    let path = kit(arguments.kit.as_deref())?;
    let kit = Kit::read(&path).map_err(refused("--kit".into()))?;
    let version = if arguments.fmi == "2" { Version::Fmi2 } else { Version::Fmi3 };
    std::fs::create_dir_all(&common.out).map_err(Error::file("making folder", &common.out))?;
    let to = common.out.join(vibro_pack::file_name(&machine.name, version));
    let replaced = if to.exists() { ", replacing the previous file" } else { "" };
    vibro_pack::write(machine, version, &kit, &to).map_err(refused(format!("fmu {}", to.display())))?;
    output::say(&format!("wrote {} (FMI {}.0){replaced}", to.display(), arguments.fmi))
}

/// The library: the one named by the user, or the first one found.
fn kit(named: Option<&Path>) -> Result<PathBuf> {
    if let Some(path) = named {
        if !path.is_file() {
            let what = format!("--kit {}", path.display());
            let problem = if path.is_dir() {
                format!("is a folder; expected a file, such as {KIT_FILE} in it")
            } else {
                "no such file".into()
            };
            return Err(Error::Refused { what, problem });
        }
        return Ok(path.to_owned());
    }
    let folder = std::env::var_os(ARCHIVES).map(PathBuf::from);
    // The program of the repository is in target/release, and the kit in target.
    let program = std::env::current_exe().ok();
    let above = program.iter().flat_map(|program| program.ancestors().skip(1).take(2).map(Path::to_owned));
    let mut places = folder.into_iter().chain(above).map(|folder| folder.join(KIT_FILE));
    places.find(|path| path.is_file()).ok_or_else(|| Error::Refused {
        what: "fmu".into(),
        problem: format!(
            "found no {KIT_FILE}, the prebuilt library that an FMU contains; give it by --kit FILE, or its \
             folder by the environment variable {ARCHIVES}. The Python package of a release contains it \
             (`python -c \"import vibro_impact as vi; print(vi.fmu_path().parent)\"`); in the repository \
             `cargo run --bin fmu-build` writes it to target/"
        ),
    })
}
