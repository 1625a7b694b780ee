//! The `.fmu` archive: it is written so that equal content gives equal bytes, and read as a host
//! reads it.

use crate::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{Cursor, Read, Seek, Write};
use std::path::{Path, PathBuf};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipArchive, ZipWriter};

/// File name of the command line, without `.exe`.
pub const PROGRAM: &str = "vibro";

/// Content of an archive: path and bytes of each file, in the order of the paths.
pub type Content = BTreeMap<String, Vec<u8>>;

/// The archive's bytes: entries sorted, times 1980-01-01, permissions fixed.
///
/// # Errors
/// [`Error::Archive`] if an entry cannot be written.
///
/// # Examples
///
/// ```
/// use std::io::Cursor;
/// use std::path::Path;
/// use vibro_pack::{Content, archive};
///
/// let content = Content::from([("resources/machine.toml".to_owned(), b"name = \"A\"".to_vec())]);
/// let bytes = archive::to_bytes(&content)?;
/// assert_eq!(archive::of(Cursor::new(&bytes), Path::new("a.fmu"))?, content);
/// assert_eq!(archive::to_bytes(&content)?, bytes);
/// # Ok::<(), vibro_pack::Error>(())
/// ```
pub fn to_bytes(content: &Content) -> Result<Vec<u8>> {
    let mut none = ZipArchive::new(Cursor::new(EMPTY)).map_err(in_memory)?;
    to_bytes_with(content, &BTreeMap::new(), &mut none)
}

/// An archive without entries.
const EMPTY: &[u8] = b"PK\x05\x06\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0";

fn in_memory(source: zip::result::ZipError) -> Error {
    Error::Archive { path: PathBuf::from("(in memory)"), source }
}

/// As [`to_bytes`], with further entries copied from `held` in compressed form; `borrowed` maps a
/// path to the path in `held`.
///
/// # Errors
/// [`Error::Archive`] if an entry cannot be written or is not in `held`.
pub(crate) fn to_bytes_with(
    content: &Content,
    borrowed: &BTreeMap<String, String>,
    held: &mut ZipArchive<Cursor<&[u8]>>,
) -> Result<Vec<u8>> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    let names: BTreeSet<&String> = content.keys().chain(borrowed.keys()).collect();
    for name in names {
        if let Some(of) = borrowed.get(name) {
            let place = held.index_for_name(of).ok_or(zip::result::ZipError::FileNotFound);
            let entry = held.by_index_raw(place.map_err(in_memory)?).map_err(in_memory)?;
            zip.raw_copy_file_rename(entry, name).map_err(in_memory)?;
            continue;
        }
        let mode = if name.starts_with("binaries/") || name == PROGRAM { 0o755 } else { 0o644 };
        // An archive within an archive is already compressed.
        let packed = name.ends_with(".fmu");
        let method = if packed { CompressionMethod::Stored } else { CompressionMethod::Deflated };
        let options = SimpleFileOptions::default()
            .compression_method(method)
            .last_modified_time(DateTime::default())
            .unix_permissions(mode);
        zip.start_file(name.as_str(), options).map_err(in_memory)?;
        zip.write_all(&content[name]).map_err(|e| in_memory(e.into()))?;
    }
    Ok(zip.finish().map_err(in_memory)?.into_inner())
}

/// Writes the archive atomically: another process never sees a half-written one.
///
/// # Errors
/// [`Error::Archive`], [`Error::File`].
pub fn write(content: &Content, path: &Path) -> Result<()> {
    write_file(path, &to_bytes(content)?)
}

/// Writes a file through a temporary file in the same folder; creates the folder.
///
/// # Errors
/// [`Error::File`].
pub fn write_file(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(folder).map_err(Error::file("making the folder", folder))?;
    let mut file = tempfile::Builder::new()
        .permissions_if_supported()
        .tempfile_in(folder)
        .map_err(Error::file("writing into", folder))?;
    file.write_all(bytes).map_err(Error::file("writing", path))?;
    file.persist(path).map_err(|e| Error::file("writing", path)(e.error))?;
    Ok(())
}

/// Temporary files are private by default; written files get the usual permissions.
trait Permissions {
    fn permissions_if_supported(&mut self) -> &mut Self;
}

impl Permissions for tempfile::Builder<'_, '_> {
    #[cfg(unix)]
    fn permissions_if_supported(&mut self) -> &mut Self {
        use std::os::unix::fs::PermissionsExt;
        self.permissions(fs::Permissions::from_mode(0o666)) // reduced by the umask
    }
    #[cfg(not(unix))]
    fn permissions_if_supported(&mut self) -> &mut Self {
        self
    }
}

/// Reads an archive: every file in it.
///
/// # Errors
/// [`Error::Archive`], [`Error::File`].
pub fn read_all(path: &Path) -> Result<Content> {
    of(fs::File::open(path).map_err(Error::file("opening", path))?, path)
}

/// Reads every file of an archive from a reader; `path` is its name in messages.
///
/// # Errors
/// [`Error::Archive`].
pub fn of(held: impl Read + Seek, path: &Path) -> Result<Content> {
    let failed = |source| Error::Archive { path: path.to_owned(), source };
    let mut zip = ZipArchive::new(held).map_err(failed)?;
    let mut content = Content::new();
    for i in 0..zip.len() {
        let mut entry = zip.by_index(i).map_err(failed)?;
        let mut bytes = Vec::new();
        entry.read_to_end(&mut bytes).map_err(|e| failed(e.into()))?;
        let name = entry.name().map_err(failed)?.into_owned();
        content.insert(name, bytes);
    }
    Ok(content)
}

/// Reads one file out of an archive.
///
/// # Errors
/// [`Error::Missing`], [`Error::Archive`], [`Error::File`].
pub fn read(path: &Path, name: &str) -> Result<Vec<u8>> {
    let failed = |source| Error::Archive { path: path.to_owned(), source };
    let file = fs::File::open(path).map_err(Error::file("opening", path))?;
    let mut zip = ZipArchive::new(file).map_err(failed)?;
    let mut entry = match zip.by_name(name) {
        Ok(entry) => entry,
        Err(zip::result::ZipError::FileNotFound) => {
            return Err(Error::Missing { path: path.to_owned(), name: name.to_owned() });
        }
        Err(source) => return Err(failed(source)),
    };
    let mut bytes = Vec::new();
    entry.read_to_end(&mut bytes).map_err(|e| failed(e.into()))?;
    Ok(bytes)
}
