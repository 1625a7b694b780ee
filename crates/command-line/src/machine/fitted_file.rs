//! File of a fitted machine or a design: the text of the original file with changed numbers.

use crate::table::read_text;
use crate::whole_file::write_whole;
use crate::{Error, Result};
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::path::Path;
use vibro_machine::description::Description;
use vibro_machine::file::{records_beside, with_numbers};

/// Prefixes of a first line with a verdict, which a new verdict replaces.
const FIRST: [&str; 2] = ["# vibro fit: ", "# vibro design: "];

/// Writes the file of a machine with changed numbers. The file keeps the comments, units and
/// record paths of the file at `path`, and the records are copied next to it. If changed numbers
/// alone cannot describe the machine, or if the records would replace other files, the machine is
/// written out in full. The first line has the command and its verdict, e.g. `vibro fit: fits`.
///
/// # Errors
/// [`Error::File`].
pub fn write_with_numbers(
    path: &Path,
    machine: &Description,
    (name, verdict): (&str, &str),
    out: &Path,
) -> Result<()> {
    let records = RefCell::new(BTreeMap::new());
    let beside = records_beside(path.parent().unwrap_or(Path::new("")));
    let read = |name: &str| {
        let text = beside(name)?;
        records.borrow_mut().insert(name.to_owned(), text.clone());
        Ok(text)
    };
    let edited = read_text(path).ok().and_then(|text| with_numbers(&text, &read, machine));
    let records = records.into_inner();
    let text = match edited {
        Some(text) if records.iter().all(|(name, text)| is_free(&out.join(name), text)) => {
            for (name, text) in &records {
                copy(&out.join(name), text)?;
            }
            text
        }
        _ => machine.to_toml(),
    };
    let rest = match text.split_once('\n') {
        Some((first, rest)) if FIRST.iter().any(|own| first.starts_with(own)) => rest,
        _ => &text,
    };
    write_whole(&out.join(name), format!("# {verdict}\n{rest}").as_bytes())
}

/// Whether a record may be written to a path: no file exists there, or an identical one.
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
