//! The FMU archives: one for FMI 2.0, one for FMI 3.0 and, on request, two more for FMI 3.0, one
//! with arrays, one with arrays and a clock. Several importers cannot read these two. All archives
//! contain the same library.

use crate::check;
use crate::error::{Error, Result};
use fmi_doors::description::Description;
use std::path::{Path, PathBuf};
use vibro_pack::{PackedPlatform, binary_path};
use vibro_paper_component::fmi2;
use vibro_paper_component::fmi3::description::{self, ARRAYS, CLOCKED, Edition, MAIN, MODEL_IDENTIFIER};

pub use vibro_pack::MODEL_DESCRIPTION;

/// Version of an archive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// FMI 2.0.
    Fmi2,
    /// FMI 3.0.
    Fmi3,
    /// FMI 3.0 with arrays.
    Arrays,
    /// FMI 3.0 with arrays and a clock of impacts.
    Clocked,
}

impl Version {
    /// Archives that are always made.
    pub const USUAL: [Self; 2] = [Self::Fmi2, Self::Fmi3];
    /// All archives.
    pub const ALL: [Self; 4] = [Self::Fmi2, Self::Fmi3, Self::Arrays, Self::Clocked];

    /// Edition of the variable table in an archive of FMI 3.0; `None` for FMI 2.0.
    pub fn edition(self) -> Option<Edition> {
        match self {
            Self::Fmi2 => None,
            Self::Fmi3 => Some(MAIN),
            Self::Arrays => Some(ARRAYS),
            Self::Clocked => Some(CLOCKED),
        }
    }

    /// Suffix of the file name.
    fn suffix(self) -> &'static str {
        match self {
            Self::Fmi2 | Self::Fmi3 => vibro_pack::suffix(self.fmi()),
            Self::Arrays => "-FMI3-arrays",
            Self::Clocked => "-FMI3-clocked",
        }
    }

    /// Name of the version as shown to users.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fmi2 => "FMI 2.0",
            Self::Fmi3 => "FMI 3.0",
            Self::Arrays => "FMI 3.0 with arrays",
            Self::Clocked => "FMI 3.0 with arrays and a clock",
        }
    }

    /// Path of this archive next to the archive of FMI 2.0.
    pub fn beside(self, fmi2: &Path) -> PathBuf {
        let stem = fmi2.file_stem().unwrap_or_default().to_string_lossy();
        fmi2.with_file_name(format!("{stem}{}.fmu", self.suffix()))
    }

    /// The version of FMI.
    pub fn fmi(self) -> fmi_doors::Version {
        if self == Self::Fmi2 { fmi_doors::Version::Fmi2 } else { fmi_doors::Version::Fmi3 }
    }

    /// Path of a platform's binary inside the archive.
    pub fn binary(self, place: PackedPlatform) -> String {
        binary_path(self.fmi(), MODEL_IDENTIFIER, place)
    }

    /// Path, inside the archive, of the binary for the computer that runs this program.
    pub fn own_binary(self) -> String {
        self.binary(PackedPlatform::OWN)
    }

    /// Checked text of [`MODEL_DESCRIPTION`], with `generationDateAndTime` if a date is given.
    ///
    /// # Errors
    /// [`Error::Invalid`] with all problems if the description is not valid.
    pub fn description(self, date: Option<String>) -> Result<String> {
        let described = Description {
            generation_tool: concat!("fmu-build ", env!("CARGO_PKG_VERSION")).into(),
            generation_date_and_time: date.map(Into::into),
            ..self.edition().map_or_else(fmi2::description::description, description::description)
        };
        let text = described.xml(self.fmi());
        let problems = check::problems(&text, self.fmi())?;
        if problems.is_empty() { Ok(text) } else { Err(Error::Invalid(problems)) }
    }
}
