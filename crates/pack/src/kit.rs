//! The kit: the part shared by the archives of all machines, and its file.

use crate::archive::{self, Content};
use crate::binaries::Binaries;
use crate::error::{Error, Result};
use std::path::Path;

/// Name of the kit's file in the Python package.
pub const KIT_FILE: &str = "machine-kit.zip";
/// Name, among the licences, of the list of linked packages.
pub const LICENCE_LIST: &str = "README.txt";

/// Folders of the entries of a kit file, and the entry with the date.
const BINARIES: &str = "binaries/";
const LICENCES: &str = "licences/";
pub(crate) const DATE: &str = "date.txt";

/// Compiled library and licences, shared by the archives of all machines.
///
///
/// A program can keep a kit as one file, as the Python package does:
///
/// ```
/// use vibro_pack::{Binaries, Kit};
///
/// let binaries = Binaries::own(b"the bytes of the compiled library".to_vec());
/// let kit = Kit { binaries, date: Some("2026-01-01T00:00:00Z".into()), ..Kit::default() };
/// let folder = tempfile::tempdir()?;
/// let path = folder.path().join("kit.zip");
/// kit.write(&path)?;
/// assert_eq!(Kit::read(&path)?, kit);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Kit {
    /// The compiled library, which serves all machines.
    pub binaries: Binaries,
    /// Licence texts of everything in the library.
    pub licences: Content,
    /// Date of the last change of its sources.
    pub date: Option<String>,
}

impl Kit {
    /// The kit as entries of its file.
    pub fn entries(&self) -> Content {
        let date = self.date.iter().map(|date| (DATE.to_owned(), date.clone().into_bytes()));
        let binaries =
            self.binaries.folders().map(|(name, bytes)| (format!("{BINARIES}{name}"), bytes.to_vec()));
        let licences = self.licences.iter().map(|(name, text)| (format!("{LICENCES}{name}"), text.clone()));
        date.chain(binaries).chain(licences).collect()
    }

    /// Reads a kit from entries, ignoring others; `None` for a library of an unknown platform.
    pub fn from_entries(entries: Content) -> Option<Self> {
        let (mut binaries, mut licences, mut date) = (Content::new(), Content::new(), None);
        for (name, bytes) in entries {
            if let Some(folder) = name.strip_prefix(BINARIES) {
                binaries.insert(folder.to_owned(), bytes);
            } else if let Some(name) = name.strip_prefix(LICENCES) {
                licences.insert(name.to_owned(), bytes);
            } else if name == DATE {
                date = String::from_utf8(bytes).ok();
            }
        }
        Some(Self { binaries: Binaries::from_folders(binaries)?, licences, date })
    }

    /// Writes the kit's file.
    ///
    /// # Errors
    /// [`Error::Archive`], [`Error::File`].
    pub fn write(&self, path: &Path) -> Result<()> {
        archive::write(&self.entries(), path)
    }

    /// Reads a kit's file.
    ///
    /// # Errors
    /// [`Error::Archive`], [`Error::File`]; [`Error::Missing`] for an archive that is not a kit.
    pub fn read(path: &Path) -> Result<Self> {
        let missing = || Error::Missing { path: path.to_owned(), name: format!("{BINARIES}PLATFORM") };
        let kit = Self::from_entries(archive::read_all(path)?).ok_or_else(missing)?;
        if kit.binaries.folders().next().is_none() { Err(missing()) } else { Ok(kit) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_a_kit_is_what_was_written_and_what_is_none_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(KIT_FILE);
        let kit = Kit {
            binaries: crate::PACKED_PLATFORMS
                .into_iter()
                .map(|place| (place, place.tuple.into()))
                .collect::<Binaries>()
                .with_component(b"component".to_vec()),
            licences: Content::from([("a/LICENSE".to_owned(), b"text".to_vec())]),
            date: Some("2026-01-01T00:00:00Z".into()),
        };
        kit.write(&path).unwrap();
        assert_eq!(Kit::read(&path).unwrap().entries(), kit.entries());
        for other in ["modelDescription.xml", "binaries/riscv64-haiku"] {
            archive::write(&Content::from([(other.to_owned(), Vec::new())]), &path).unwrap();
            assert!(matches!(Kit::read(&path), Err(Error::Missing { .. })), "{other}");
        }
        std::fs::write(&path, b"no archive").unwrap();
        assert!(matches!(Kit::read(&path), Err(Error::Archive { .. })));
    }
}
