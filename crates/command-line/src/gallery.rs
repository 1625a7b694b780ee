//! The gallery's machines as files to start from (`vibro new`).

use crate::whole_file::write_whole;
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// A machine of the gallery.
#[derive(Debug)]
pub struct Example {
    /// The name of its file and of its page in the gallery.
    pub name: &'static str,
    /// Contents of its file.
    pub text: &'static str,
    /// Records and matrices that the file needs, with their names.
    beside: &'static [(&'static str, &'static str)],
}

macro_rules! examples {
    ($($name:literal $($beside:literal)*,)+) => {
        &[$(Example {
            name: $name,
            text: include_str!(concat!("../../../examples/assembly/", $name, ".toml")),
            beside: &[$(($beside, include_str!(concat!("../../../examples/assembly/", $beside))),)*],
        },)+]
    };
}

/// All examples, in the gallery's order.
pub static EXAMPLES: &[Example] = examples! {
    "damper_with_buffer",
    "gear_backlash",
    "brake_squeal",
    "msl_coupled_clutches",
    "valve_train" "cam_lift.csv",
    "vibratory_conveyor",
    "pipe_supports",
    "percussion_drill",
    "servo",
    "relay_bounce",
    "bead_column",
    "two_blocks",
    "paper_machine",
    "cantilever" "cantilever_mass.mtx" "cantilever_stiffness.mtx",
    "gear_mesh",
    "iwan_joint",
    "shaken_rig" "shaken_rig.csv",
    "run_up",
    "impact_damper",
    "duffing_stop",
    "pull_in",
    "energy_sink",
    "stribeck_brake",
    "hammer_drill",
    "shaken_box" "shaken_box.csv",
    "blade_tip",
    "underplatform_damper",
    "bar_on_wall",
};

/// Names of machines in version 0.3 that are still accepted, each with the present name.
const OLD_NAMES: [(&str, &str); 16] = [
    ("damper", "damper_with_buffer"),
    ("gears", "gear_backlash"),
    ("brake", "brake_squeal"),
    ("clutches", "msl_coupled_clutches"),
    ("valve-train", "valve_train"),
    ("conveyor", "vibratory_conveyor"),
    ("pipe", "pipe_supports"),
    ("drill", "percussion_drill"),
    ("relay", "relay_bounce"),
    ("beads", "bead_column"),
    ("blocks", "two_blocks"),
    ("paper", "paper_machine"),
    ("mesh", "gear_mesh"),
    ("joint", "iwan_joint"),
    ("shock", "shaken_rig"),
    ("run-up", "run_up"),
];

impl Example {
    /// Finds the machine by its name in this version or in version 0.3.
    ///
    /// # Errors
    /// [`Error::Refused`] for an unknown name, with the nearest name of this version.
    pub fn find(name: &str) -> Result<&'static Self> {
        let new = OLD_NAMES.iter().find(|(old, _)| *old == name).map_or(name, |(_, new)| new);
        EXAMPLES.iter().find(|example| example.name == new).ok_or_else(|| {
            let advice = vibro_machine::refusal::advice(name, EXAMPLES.iter().map(|example| example.name));
            let problem =
                format!("no machine of the gallery has this name; {advice} (`vibro new` lists all)");
            Error::Refused { what: format!("new {name}"), problem }
        })
    }

    /// The description: the first sentence of the file.
    pub fn about(&self) -> String {
        let comment = self.text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim);
        let text = comment.collect::<Vec<_>>().join(" ");
        text.find(". ").map_or(text.as_str(), |end| &text[..=end]).to_owned()
    }

    /// Writes the example's file and the files that it needs. Nothing is overwritten.
    ///
    /// # Errors
    /// [`Error::Refused`] if a file already exists; [`Error::File`].
    pub fn write(&self, path: &Path) -> Result<Vec<PathBuf>> {
        let beside = self.beside.iter().map(|(name, text)| (path.with_file_name(name), *text));
        let files: Vec<(PathBuf, &str)> =
            std::iter::once((path.to_owned(), self.text)).chain(beside).collect();
        if let Some((there, _)) = files.iter().find(|(path, _)| path.exists()) {
            let problem = "exists already and is not overwritten; use another name".into();
            return Err(Error::Refused { what: there.display().to_string(), problem });
        }
        files.iter().try_for_each(|(path, text)| write_whole(path, text.as_bytes()))?;
        Ok(files.into_iter().map(|(path, _)| path).collect())
    }
}
