//! Long work in parts: each finished part goes to disk at once, so that an interrupted study goes on where it was, and
//! several machines can share one.
//!
//! A folder of parts holds `manifest.toml`, which says what is computed, and a file for each finished part. A file is
//! written under another name and renamed, so that a part is there whole or not at all.

use super::error::{Error, Result};
use rayon::prelude::*;
use serde::{Serialize, de::DeserializeOwned};
use std::path::{Path, PathBuf};

/// Which parts are computed here: those whose number leaves `index` when divided by `count`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// 0 … count - 1.
    pub index: usize,
    /// Number of shards.
    pub count: usize,
}

impl Shard {
    /// Everything.
    pub const ALL: Self = Self { index: 0, count: 1 };
}

impl std::str::FromStr for Shard {
    type Err = Error;

    /// Reads `i/n` with i from 1 to n.
    fn from_str(text: &str) -> Result<Self> {
        let form = || Error::Form { text: text.into(), expected: "i/n with i from 1 to n, e.g. 2/4" };
        let (i, n) = text.split_once('/').ok_or_else(form)?;
        match (i.trim().parse::<usize>(), n.trim().parse::<usize>()) {
            (Ok(i), Ok(n)) if i >= 1 && i <= n => Ok(Self { index: i - 1, count: n }),
            _ => Err(form()),
        }
    }
}

/// What one machine has to do of a long study.
#[derive(Clone, Copy)]
pub struct Task<'a> {
    /// Where finished parts are kept.
    pub parts: &'a Parts,
    /// Which of them are made here.
    pub shard: Shard,
    /// Hears of each part, and whether it had been there.
    pub done: &'a (dyn Fn(bool) + Sync),
}

impl Task<'static> {
    /// Everything, kept nowhere and told to nobody.
    pub const ALL: Self = Self { parts: &Parts { folder: None }, shard: Shard::ALL, done: &|_| () };
}

/// A folder of parts, or nothing at all where results need not outlive the program.
#[derive(Debug)]
pub struct Parts {
    folder: Option<PathBuf>,
}

const MANIFEST: &str = "manifest.toml";

impl Parts {
    /// Opens or makes a folder of parts for the work that `manifest` describes. Parts of other work are removed.
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
        Ok(Self { folder: Some(folder.into()) })
    }

    /// The manifest of a folder of parts.
    ///
    /// # Errors
    /// [`Error::File`], [`Error::Config`] for what is no manifest.
    pub fn manifest<M: DeserializeOwned>(folder: &Path) -> Result<M> {
        let path = folder.join(MANIFEST);
        let text = std::fs::read_to_string(&path).map_err(Error::file("reading", &path))?;
        toml::from_str(&text).map_err(|e| Error::Config { path, problem: e.to_string() })
    }

    fn path(&self, index: usize) -> Option<PathBuf> {
        self.folder.as_ref().map(|f| f.join(format!("{index:05}.part")))
    }

    /// Takes over the finished parts of another folder.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn take_over(&self, other: &Path) -> Result<()> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let entries = std::fs::read_dir(other).map_err(Error::file("reading", other))?;
        for entry in entries {
            let path = entry.map_err(Error::file("reading", other))?.path();
            if let (Some(name), true) = (path.file_name(), path.extension().is_some_and(|e| e == "part")) {
                let bytes = std::fs::read(&path).map_err(Error::file("reading", &path))?;
                write_whole(&folder.join(name), &bytes)?;
            }
        }
        Ok(())
    }

    /// A finished part. One that cannot be read counts as not finished.
    pub fn get<T: DeserializeOwned>(&self, index: usize) -> Option<T> {
        postcard::from_bytes(&std::fs::read(self.path(index)?).ok()?).ok()
    }

    fn put<T: Serialize>(&self, index: usize, part: &T) -> Result<()> {
        let Some(path) = self.path(index) else { return Ok(()) };
        write_whole(&path, &postcard::to_stdvec(part).map_err(Error::output("a part"))?)
    }

    /// The parts that are not there.
    pub fn missing(&self, count: usize) -> usize {
        (0..count).filter(|&i| !self.path(i).is_some_and(|p| p.exists())).count()
    }

    /// Removes the folder: its work is done.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn remove(self) -> Result<()> {
        let Some(folder) = self.folder else { return Ok(()) };
        std::fs::remove_dir_all(&folder).map_err(Error::file("writing", &folder))
    }
}

impl Task<'_> {
    /// Makes the parts 0 … `count` - 1 that are not there and belong to the shard, on all threads. All parts in order, or
    /// `None` where some belong to other shards and are not there.
    ///
    /// # Errors
    /// What `make` returns, [`Error::File`].
    pub fn complete<T: Serialize + DeserializeOwned + Send>(
        &self,
        count: usize,
        make: impl Fn(usize) -> Result<T> + Sync,
    ) -> Result<Option<Vec<T>>> {
        let Self { parts, shard, done } = self;
        let one = |index: usize| -> Result<Option<T>> {
            if let Some(part) = parts.get(index) {
                done(true);
                return Ok(Some(part));
            }
            if index % shard.count != shard.index {
                return Ok(None);
            }
            let part = make(index)?;
            parts.put(index, &part)?;
            done(false);
            Ok(Some(part))
        };
        let parts: Vec<Option<T>> = (0..count).into_par_iter().map(one).collect::<Result<_>>()?;
        Ok(parts.into_iter().collect())
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
    use std::sync::atomic::{AtomicUsize, Ordering};

    fn square(index: usize) -> Result<Vec<f64>> {
        Ok(vec![(index * index) as f64, f64::NEG_INFINITY])
    }

    #[test]
    fn interrupted_work_goes_on_where_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("parts");
        let parts = Parts::open(
            &folder,
            &[("study", "squares")].into_iter().collect::<std::collections::BTreeMap<_, _>>(),
        );
        let parts = parts.unwrap();
        // Interrupted: part 5 fails; part 3 is damaged afterwards.
        let failing = |i: usize| {
            if i == 5 { Err(Error::Form { text: "5".into(), expected: "none" }) } else { square(i) }
        };
        assert!(Task { parts: &parts, ..Task::ALL }.complete(8, failing).is_err());
        std::fs::write(folder.join("00003.part"), [255; 3]).unwrap();
        let (made, found) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let count = |was: bool| {
            (if was { &found } else { &made }).fetch_add(1, Ordering::Relaxed);
        };
        let all = Task { parts: &parts, done: &count, ..Task::ALL }.complete(8, square).unwrap().unwrap();
        assert_eq!(all, (0..8).map(|i| square(i).unwrap()).collect::<Vec<_>>());
        assert!(found.load(Ordering::Relaxed) >= 1 && made.load(Ordering::Relaxed) >= 2);
        assert_eq!(found.into_inner() + made.into_inner(), 8);
    }

    #[test]
    fn shards_together_make_the_whole() {
        let base = tempfile::tempdir().unwrap();
        let manifest: std::collections::BTreeMap<_, _> = [("study", "squares")].into();
        let shards = ["1/3", "2/3", "3/3"].map(|text| text.parse::<Shard>().unwrap());
        let all = Parts::open(&base.path().join("all"), &manifest).unwrap();
        for (i, shard) in shards.into_iter().enumerate() {
            let folder = base.path().join(format!("shard{i}"));
            let parts = Parts::open(&folder, &manifest).unwrap();
            assert_eq!(Task { parts: &parts, shard, ..Task::ALL }.complete(10, square).unwrap(), None);
            let missing = all.missing(10);
            assert!(missing > 0);
            all.take_over(&folder).unwrap();
            assert!(all.missing(10) < missing);
        }
        assert_eq!(all.missing(10), 0);
        let nothing = |_| -> Result<Vec<f64>> { panic!("all parts are there") };
        let whole = Task { parts: &all, ..Task::ALL }.complete(10, nothing).unwrap().unwrap();
        assert_eq!(whole, (0..10).map(|i| square(i).unwrap()).collect::<Vec<_>>());
    }

    #[test]
    fn other_work_starts_anew() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path().join("parts");
        let manifest = |name| -> std::collections::BTreeMap<_, _> { [("study", name)].into() };
        let parts = Parts::open(&folder, &manifest("one")).unwrap();
        Task { parts: &parts, ..Task::ALL }.complete(3, square).unwrap();
        assert_eq!(Parts::open(&folder, &manifest("one")).unwrap().missing(3), 0);
        assert_eq!(Parts::open(&folder, &manifest("two")).unwrap().missing(3), 3);
        for wrong in ["0/2", "3/2", "1", "a/b", ""] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
