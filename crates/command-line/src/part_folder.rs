//! Finished parts of a long study in a folder on disk, so that an interrupted study continues and
//! several machines can share one.
//!
//! The folder holds `manifest.toml` with a description of the computation, a file for each
//! finished part, and `lock`, which the working program holds. A file is written under a temporary
//! name and then renamed, so that a part is either complete or absent. Parts of another study are
//! kept unless the user asks to discard them; other files are never removed.

use crate::long_study::FORMAT;
use crate::manifest::Manifest;
use crate::whole_file::{WRITING, write_whole};
use crate::{Error, Result};
use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::sync::{PoisonError, RwLock};
use vibro_studies::parts::PartStore;

const MANIFEST: &str = "manifest.toml";
const LOCK: &str = "lock";
/// Ending of a part's file.
const PART: &str = "part";

/// Content of a folder with respect to a study.
#[derive(Clone, Debug, PartialEq)]
pub enum Occupancy {
    /// Nothing.
    Free,
    /// Parts of this study.
    Own,
    /// Parts of another study, which the manifest describes.
    Foreign(Box<Manifest>),
}

/// A folder of finished parts, locked while this value lives.
#[derive(Debug)]
pub struct PartFolder {
    folder: PathBuf,
    /// The lock ends when the file is closed. The system closes the file if the program is killed.
    _lock: File,
}

impl PartFolder {
    /// Opens or makes a folder of parts of the study that `manifest` describes, and locks it.
    /// Parts of another study are refused, or removed if `discard` is true.
    ///
    /// # Errors
    /// [`Error::Config`] if another program works in the folder, if `discard` is false and the
    /// folder holds parts of another study or of another [form](FORMAT), if the parts of
    /// `manifest` have another form, or if the folder's manifest is damaged, or missing although
    /// there are other files; [`Error::File`] and [`Error::Output`] if a file cannot be read or
    /// written.
    pub fn open(folder: &Path, manifest: &Manifest, discard: bool) -> Result<Self> {
        // A study read from shards may have parts of another form.
        if let Some(format) = format_of(manifest).filter(|format| *format != FORMAT) {
            return Err(other_format(folder, format));
        }
        // Refused before the folder is created.
        if let (Occupancy::Foreign(there), false) = (Self::occupancy(folder, manifest)?, discard) {
            return Err(other_study(folder, &there, manifest));
        }
        std::fs::create_dir_all(folder).map_err(Error::file("making folder", folder))?;
        let opened = Self { folder: folder.into(), _lock: lock(folder)? };
        // Checked again: another program may have used the folder until it was locked.
        match Self::occupancy(folder, manifest)? {
            Occupancy::Own => opened.remove_files(&[WRITING])?,
            Occupancy::Free => write_whole(&folder.join(MANIFEST), manifest.text()?.as_bytes())?,
            Occupancy::Foreign(there) if !discard => return Err(other_study(folder, &there, manifest)),
            Occupancy::Foreign(_) => {
                opened.remove_files(&[WRITING, PART])?;
                write_whole(&folder.join(MANIFEST), manifest.text()?.as_bytes())?;
            }
        }
        Ok(opened)
    }

    /// Content of a folder with respect to the study that `manifest` describes.
    ///
    /// # Errors
    /// [`Error::Config`] if the manifest is damaged or is not a manifest of parts, or if the
    /// folder has files but no manifest; [`Error::File`] if the folder cannot be read.
    pub fn occupancy(folder: &Path, manifest: &Manifest) -> Result<Occupancy> {
        let path = folder.join(MANIFEST);
        if path.exists() {
            let there = Self::manifest(folder)?;
            let same = there.describes_same(manifest);
            return Ok(if same { Occupancy::Own } else { Occupancy::Foreign(Box::new(there)) });
        }
        let foreign = |p: &&PathBuf| p.file_name().is_some_and(|n| n != LOCK) && !has_ending(p, WRITING);
        match entries(folder)?.iter().find(foreign) {
            None => Ok(Occupancy::Free),
            Some(file) => {
                let name = file.file_name().unwrap_or_default().to_string_lossy();
                let problem = format!(
                    "holds `{name}` but no {MANIFEST}, so it is not a folder of parts and was not \
                     changed; use another --out"
                );
                Err(Error::Config { path: folder.into(), problem })
            }
        }
    }

    /// Reads the manifest of a folder of parts.
    ///
    /// # Errors
    /// [`Error::File`] if the manifest cannot be read; [`Error::Config`] if it is not a manifest
    /// of parts.
    pub fn manifest(folder: &Path) -> Result<Manifest> {
        let path = folder.join(MANIFEST);
        let found = Manifest::read(&path)?;
        if found.long_study.is_none() {
            let problem =
                "has no table [long_study], so it is not a manifest of parts, and was not changed".into();
            return Err(Error::Config { path, problem });
        }
        Ok(found)
    }

    /// Number of finished parts in a folder.
    pub fn kept(folder: &Path) -> usize {
        entries(folder).map_or(0, |all| all.iter().filter(|p| has_ending(p, PART)).count())
    }

    fn path(&self, index: usize) -> PathBuf {
        self.folder.join(format!("{index:05}.{PART}"))
    }

    /// Copies the finished parts of another folder that are missing in this one.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn take_over(&self, other: &Path) -> Result<()> {
        for path in entries(other)?.iter().filter(|p| has_ending(p, PART)) {
            let own = self.folder.join(path.file_name().unwrap_or_default());
            if !own.exists() {
                let bytes = std::fs::read(path).map_err(Error::file("reading", path))?;
                write_whole(&own, &bytes)?;
            }
        }
        Ok(())
    }

    /// Removes parts and manifest of a finished study, and the folder if nothing else is in it.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn remove(self) -> Result<()> {
        self.remove_files(&[PART, WRITING])?;
        for name in [MANIFEST, LOCK] {
            let path = self.folder.join(name);
            std::fs::remove_file(&path).map_err(Error::file("writing", &path))?;
        }
        // Files of other programs are kept.
        let _ = std::fs::remove_dir(&self.folder);
        Ok(())
    }

    fn remove_files(&self, endings: &[&str]) -> Result<()> {
        for path in entries(&self.folder)?.iter().filter(|p| endings.iter().any(|e| has_ending(p, e))) {
            std::fs::remove_file(path).map_err(Error::file("writing", path))?;
        }
        Ok(())
    }
}

/// Read lock: a part is being written. Write lock: no further part may be completed.
static SAVING: RwLock<()> = RwLock::new(());

/// Prevents the completion of further parts while the returned guard lives, so that a program can
/// count its parts and exit.
pub fn stop_saving() -> impl Drop {
    SAVING.write().unwrap_or_else(PoisonError::into_inner)
}

impl PartStore for PartFolder {
    fn load(&self, index: usize) -> Option<Vec<u8>> {
        std::fs::read(self.path(index)).ok()
    }

    fn save(&self, index: usize, bytes: &[u8]) -> vibro_studies::Result<()> {
        let _saving = SAVING.read();
        write_whole(&self.path(index), bytes).map_err(vibro_studies::Error::store)
    }

    fn contains(&self, index: usize) -> bool {
        self.path(index).exists()
    }
}

/// The files in a folder; an empty list if the folder does not exist.
fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let all = match std::fs::read_dir(folder) {
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.map_err(Error::file("reading", folder))?,
    };
    all.map(|e| e.map(|e| e.path()).map_err(Error::file("reading", folder))).collect()
}

fn has_ending(path: &Path, ending: &str) -> bool {
    path.extension().is_some_and(|e| e == ending)
}

/// Locks a folder for this program.
fn lock(folder: &Path) -> Result<File> {
    let path = folder.join(LOCK);
    let mut options = File::options();
    let file = options.create(true).truncate(false).write(true).open(&path);
    let file = file.map_err(Error::file("writing", &path))?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            let problem = "another vibro is computing parts in this folder; wait for it, use \
                           another --out, or divide the study by --shard with an --out for each \
                           share"
                .into();
            Err(Error::Config { path: folder.into(), problem })
        }
        // The file system has no locks. Parts are still complete, and two programs compute equal
        // parts.
        Ok(()) | Err(TryLockError::Error(_)) => Ok(file),
    }
}

/// `3 of 8 parts`; `count` 0 is an unknown total. Parts beyond the total are branches.
pub fn parts_in_words(kept: usize, count: usize, parts: &str) -> String {
    match (kept.checked_sub(count), count) {
        (_, 0) => format!("{kept} {parts}"),
        (Some(behind), _) if behind > 0 => format!("all {count} {parts} and {behind} of branches"),
        _ => format!("{kept} of {count} {parts}"),
    }
}

/// Error for parts of another study; `there` is in the folder and `here` is requested.
pub fn other_study(folder: &Path, there: &Manifest, here: &Manifest) -> Error {
    if let Some(format) = format_of(there).filter(|format| *format != FORMAT) {
        return other_format(folder, format);
    }
    let count = there.long_study.as_ref().map_or(0, |s| s.count());
    let problem = format!(
        "holds {} of another run; they differ in\n{}\n  begun by: {} (version {})\n  use another \
         --out; or finish that run first by its command line; or use `vibro merge` if it is a \
         share of a study; or delete its parts by --discard-unfinished",
        parts_in_words(PartFolder::kept(folder), count, "finished parts"),
        there.differences_in_lines(here),
        there.invocation.command_line,
        there.version
    );
    Error::Config { path: folder.into(), problem }
}

/// Form of a study's parts.
fn format_of(manifest: &Manifest) -> Option<u32> {
    manifest.long_study.as_ref().map(|study| study.format)
}

/// Error for parts that were made by a build with another [form](FORMAT).
fn other_format(folder: &Path, format: u32) -> Error {
    let problem = format!(
        "holds {} finished parts in form {format}, but this version of vibro reads and writes form \
         {FORMAT}\n  use another --out; or finish that run first with the version of vibro that \
         began it; or delete its parts by --discard-unfinished",
        PartFolder::kept(folder)
    );
    Error::Config { path: folder.into(), problem }
}

#[cfg(test)]
mod tests;
