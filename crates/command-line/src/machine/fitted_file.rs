//! The file of a fitted machine: the text of the file from which it came, with the fitted numbers.

use crate::table::read_text;
use crate::whole_file::write_whole;
use crate::{Error, Result};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use vibro_machine::description::Description;
use vibro_machine::file::{records_beside, with_numbers};

/// Name of the file.
const NAME: &str = "fitted.toml";
/// Begin of the first line, which has the verdict; an older one is replaced.
const FIRST: &str = "# vibro fit: ";

/// Writes the file of a fitted machine: comments, units and paths of records are those of the file
/// at `path`, and the records are copied next to it. A machine that its text cannot give by numbers
/// alone, and one whose records would replace other files, is written out.
///
/// # Errors
/// [`Error::File`].
pub fn write_fitted(path: &Path, fitted: &Description, verdict: &str, out: &Path) -> Result<()> {
    let records = RefCell::new(BTreeMap::new());
    let beside = records_beside(path.parent().unwrap_or(Path::new("")));
    let read = |name: &str| {
        let text = beside(name)?;
        records.borrow_mut().insert(name.to_owned(), text.clone());
        Ok(text)
    };
    let edited = read_text(path).ok().and_then(|text| with_numbers(&text, &read, fitted));
    let records = records.into_inner();
    let text = match edited {
        Some(text) if records.iter().all(|(name, text)| is_free(&out.join(name), text)) => {
            for (name, text) in &records {
                copy(&out.join(name), text)?;
            }
            text
        }
        _ => fitted.to_toml(),
    };
    let rest = match text.split_once('\n') {
        Some((first, rest)) if first.starts_with(FIRST) => rest,
        _ => &text,
    };
    write_whole(&out.join(NAME), format!("{FIRST}{verdict}\n{rest}").as_bytes())
}

/// Whether a record may be written to a path: nothing is there, or the same.
fn is_free(path: &Path, text: &str) -> bool {
    match std::fs::read(path) {
        Ok(found) => found == text.as_bytes(),
        Err(error) => error.kind() == std::io::ErrorKind::NotFound,
    }
}

fn copy(path: &Path, text: &str) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new(""));
    std::fs::create_dir_all(folder).map_err(Error::file("making folder", folder))?;
    if path.exists() { Ok(()) } else { write_whole(path, text.as_bytes()) }
}
