//! Files that are either complete or absent, however the program ends.

use crate::{Error, Result};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// Ending of a file that is being written.
pub(crate) const WRITING: &str = "writing";

/// Writes a file atomically: even after a power failure it is either complete or absent.
///
/// # Errors
/// [`Error::File`].
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    write_whole_by(path, |file| file.write_all(bytes).map_err(Error::file("writing", path)))
}

/// Writes a file atomically, as [`write_whole`], from pieces that `fill` writes.
///
/// # Errors
/// [`Error::File`] if the file cannot be written; the errors of `fill`.
pub fn write_whole_by(path: &Path, fill: impl FnOnce(&mut BufWriter<File>) -> Result<()>) -> Result<()> {
    // The whole name is kept: files that differ only in their ending may be written at the same
    // time.
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.{WRITING}", std::process::id()));
    let beside = path.with_file_name(name);
    let failed = || Error::file("writing", path);
    let mut file = BufWriter::new(File::create(&beside).map_err(failed())?);
    fill(&mut file)?;
    file.flush().map_err(failed())?;
    file.get_ref().sync_all().map_err(failed())?;
    std::fs::rename(&beside, path).map_err(Error::file("writing", path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_differ_in_their_ending_alone_are_written_at_the_same_time() {
        let base = tempfile::tempdir().unwrap();
        let [table, picture] = ["csv", "svg"].map(|ending| base.path().join(format!("plane.{ending}")));
        write_whole_by(&table, |file| {
            file.write_all(b"a ta").unwrap();
            write_whole(&picture, b"a picture")?;
            file.write_all(b"ble").map_err(Error::file("writing", &table))
        })
        .unwrap();
        assert_eq!(std::fs::read(&table).unwrap(), b"a table");
        assert_eq!(std::fs::read(&picture).unwrap(), b"a picture");
    }
}
