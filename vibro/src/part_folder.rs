//! Finished parts of a long study in a folder on disk, so that an interrupted study continues and several machines can
//! share one.
//!
//! The folder holds `manifest.toml`, which says what is computed, and a file for each finished part. A file is written
//! under another name and then renamed, so that a part is there whole or not at all.

use crate::{Error, Result};
use serde::{Serialize, de::DeserializeOwned};
use std::path::{Path, PathBuf};
use vibro_analysis::parts::PartStore;

const MANIFEST: &str = "manifest.toml";
/// Ending of a part's file.
const PART: &str = "part";

/// A folder of finished parts.
#[derive(Debug)]
pub struct PartFolder {
    folder: PathBuf,
}

impl PartFolder {
    /// Opens or makes a folder of parts of the study that `manifest` describes. Parts of another study are removed.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Output`].
    pub fn open<M: Serialize>(folder: &Path, manifest: &M) -> Result<Self> {
        let text = toml::to_string(manifest).map_err(Error::output("a manifest"))?;
        let path = folder.join(MANIFEST);
        if std::fs::read_to_string(&path).ok().as_deref() != Some(text.as_str()) {
            if path.exists() {
                std::fs::remove_dir_all(folder).map_err(Error::file("writing", folder))?;
            }
            std::fs::create_dir_all(folder).map_err(Error::file("making folder", folder))?;
            write_whole(&path, text.as_bytes())?;
        }
        Ok(Self { folder: folder.into() })
    }

    /// Reads the manifest of a folder of parts.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Config`] for what is no manifest.
    pub fn manifest<M: DeserializeOwned>(folder: &Path) -> Result<M> {
        let path = folder.join(MANIFEST);
        let text = std::fs::read_to_string(&path).map_err(Error::file("reading", &path))?;
        toml::from_str(&text).map_err(|e| Error::Config { path, problem: e.to_string() })
    }

    fn path(&self, index: usize) -> PathBuf {
        self.folder.join(format!("{index:05}.{PART}"))
    }

    /// Copies the finished parts of another folder into this one.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn take_over(&self, other: &Path) -> Result<()> {
        let entries = std::fs::read_dir(other).map_err(Error::file("reading", other))?;
        for entry in entries {
            let path = entry.map_err(Error::file("reading", other))?.path();
            if let (Some(name), true) = (path.file_name(), path.extension().is_some_and(|e| e == PART)) {
                let bytes = std::fs::read(&path).map_err(Error::file("reading", &path))?;
                write_whole(&self.folder.join(name), &bytes)?;
            }
        }
        Ok(())
    }

    /// Removes the folder, whose study is finished.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn remove(self) -> Result<()> {
        std::fs::remove_dir_all(&self.folder).map_err(Error::file("writing", &self.folder))
    }
}

impl PartStore for PartFolder {
    fn load(&self, index: usize) -> Option<Vec<u8>> {
        std::fs::read(self.path(index)).ok()
    }

    fn save(&self, index: usize, bytes: &[u8]) -> vibro_analysis::Result<()> {
        write_whole(&self.path(index), bytes).map_err(vibro_analysis::Error::store)
    }

    fn contains(&self, index: usize) -> bool {
        self.path(index).exists()
    }
}

/// Writes a file so that it is there whole or not at all.
///
/// # Errors
/// [`Error::File`].
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let beside = path.with_extension(format!("{}.writing", std::process::id()));
    std::fs::write(&beside, bytes).map_err(Error::file("writing", &beside))?;
    std::fs::rename(&beside, path).map_err(Error::file("writing", path))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;
    use vibro_analysis::parts::{Shard, Task};

    fn manifest(name: &str) -> BTreeMap<&str, &str> {
        [("study", name)].into()
    }

    fn square(index: usize) -> vibro_analysis::Result<usize> {
        Ok(index * index)
    }

    #[test]
    fn parts_of_shards_come_together_in_one_folder() {
        let base = tempfile::tempdir().unwrap();
        let all = PartFolder::open(&base.path().join("all"), &manifest("squares")).unwrap();
        for index in 0..3 {
            let folder = base.path().join(format!("shard{index}"));
            let store = PartFolder::open(&folder, &manifest("squares")).unwrap();
            let task = Task { store: &store, shard: Shard { index, count: 3 }, ..Task::ALL };
            assert_eq!(task.complete(10, square).unwrap(), None);
            let missing = all.missing(10);
            all.take_over(&folder).unwrap();
            assert!(all.missing(10) < missing);
        }
        let nothing = |_| -> vibro_analysis::Result<usize> { panic!("all parts are there") };
        let whole = Task { store: &all, ..Task::ALL }.complete(10, nothing).unwrap().unwrap();
        assert_eq!(whole, (0..10).map(|i| i * i).collect::<Vec<_>>());
    }

    #[test]
    fn a_damaged_part_is_computed_again() {
        let base = tempfile::tempdir().unwrap();
        let store = PartFolder::open(&base.path().join("parts"), &manifest("squares")).unwrap();
        Task { store: &store, ..Task::ALL }.complete(4, square).unwrap();
        std::fs::write(store.path(3), []).unwrap();
        let again = Task { store: &store, ..Task::ALL }.complete(4, square).unwrap().unwrap();
        assert_eq!(again, [0, 1, 4, 9]);
    }

    #[test]
    fn parts_of_another_study_are_removed() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path().join("parts");
        let store = PartFolder::open(&folder, &manifest("one")).unwrap();
        Task { store: &store, ..Task::ALL }.complete(3, square).unwrap();
        assert_eq!(PartFolder::open(&folder, &manifest("one")).unwrap().missing(3), 0);
        assert_eq!(PartFolder::open(&folder, &manifest("two")).unwrap().missing(3), 3);
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_no_usage_error() {
        let base = tempfile::tempdir().unwrap();
        let store = PartFolder { folder: base.path().join("missing") };
        let error = Task { store: &store, ..Task::ALL }.complete(1, square).unwrap_err();
        let error = Error::from(error);
        assert!(error.to_string().starts_with("writing ") && !error.is_usage(), "{error}");
    }
}
