//! Records of a fit: tables of values over time, and of contact times.

use crate::table::read_text;
use crate::{Error, Result};
use std::path::Path;
use vibro_machine::Start;
use vibro_machine::description::Description;
use vibro_machine::table::Table;
use vibro_studies::Machine;
use vibro_studies::fit::{Free, Measured};

/// Reads the record of a fit: a [`Table`] whose first line names `time` and columns, for example
/// `box.s`, and a table with the columns `element` and `time`.
///
/// # Errors
/// [`Error::Config`] for a file that is not such a table, with the line of an unreadable number.
pub fn read_record(data: Option<&Path>, events: Option<&Path>, machine: &Description) -> Result<Measured> {
    let mut measured = Measured::default();
    let of = |path: &Path, found: vibro_studies::Result<()>| {
        found.map_err(|error| Error::Config { path: path.into(), problem: error.to_string() })
    };
    if let Some(path) = data {
        let text = read_text(path)?;
        of(path, measured.add_columns(&Table::read(&text), Some(machine)))?;
    }
    if let Some(path) = events {
        let text = read_text(path)?;
        of(path, measured.add_contacts(&Table::read(&text)))?;
    }
    if measured.samples() == 0 {
        let paths: Vec<String> =
            [data, events].into_iter().flatten().map(|path| path.display().to_string()).collect();
        let problem = "has no samples; expected columns or times of contacts".into();
        return Err(Error::Refused { what: paths.join(", "), problem });
    }
    Ok(measured)
}

/// Error unless a record is valid for a machine's motion from a start, with the given free
/// parameters.
///
/// # Errors
/// [`Error::Config`] for the file, with the column or stop, the row, and the valid values.
pub fn check_record(
    measured: &Measured,
    (data, events): (Option<&Path>, Option<&Path>),
    (machine, start): (&Machine, &Start),
    free: &[Free],
) -> Result<()> {
    let of = |path: Option<&Path>, found: vibro_studies::Result<()>| match (path, found) {
        (Some(path), Err(error)) => Err(Error::Config { path: path.into(), problem: error.to_string() }),
        (_, found) => Ok(found?),
    };
    of(data, measured.check_columns(&machine.description, start, free))?;
    of(events, measured.check_contacts(&machine.description, start, free))
}
