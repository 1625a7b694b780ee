//! Records of a fit: tables of values over time, and of times of contacts.

use crate::table::read;
use crate::{Error, Result};
use csv::StringRecord;
use std::path::Path;
use vibro_analysis::assembly::Machine;
use vibro_analysis::assembly::fit::{Free, Measured};
use vibro_assembly::Start;

/// What a record may be.
const RECORD: &str = "a table whose first line names its columns";

/// Reads the record of a fit: a table whose first line names `time` and columns such as `box.s`,
/// SI, and a table with the columns `element` and `time`.
///
/// # Errors
/// [`Error::Config`] for a file that is no such table, with the row of a number that cannot be
/// read.
pub fn read_record(data: Option<&Path>, events: Option<&Path>) -> Result<Measured> {
    let mut measured = Measured::default();
    if let Some(path) = data {
        add(path, &read(path, RECORD)?, |header, rows| measured.add_columns(header, rows))?;
    }
    if let Some(path) = events {
        add(path, &read(path, RECORD)?, |header, rows| measured.add_contacts(header, rows))?;
    }
    if measured.samples() == 0 {
        let paths: Vec<String> =
            [data, events].into_iter().flatten().map(|path| path.display().to_string()).collect();
        let problem = "has no sample; allowed is a record with columns or times of contacts".into();
        return Err(Error::Refused { what: paths.join(", "), problem });
    }
    Ok(measured)
}

/// Refuses what is no record of a machine's motion from a start on, with numbers that are fitted.
///
/// # Errors
/// [`Error::Config`] for the file, with the column or stop, the row, and what is allowed.
pub fn check_record(
    measured: &Measured,
    (data, events): (Option<&Path>, Option<&Path>),
    (machine, start): (&Machine, &Start),
    free: &[Free],
) -> Result<()> {
    let of = |path: Option<&Path>, found: vibro_analysis::Result<()>| match (path, found) {
        (Some(path), Err(error)) => Err(Error::Config { path: path.into(), problem: error.to_string() }),
        (_, found) => Ok(found?),
    };
    of(data, measured.check_columns(&machine.description, start, free))?;
    of(events, measured.check_contacts(&machine.description, start, free))
}

/// Adds a table by `add`, whose problems are those of the file.
fn add<'t>(
    path: &Path,
    (header, rows): &'t (StringRecord, Vec<StringRecord>),
    add: impl FnOnce(&[&'t str], &mut dyn Iterator<Item = Vec<&'t str>>) -> vibro_analysis::Result<()>,
) -> Result<()> {
    let names: Vec<&str> = header.iter().collect();
    add(&names, &mut rows.iter().map(|row| row.iter().collect()))
        .map_err(|error| Error::Config { path: path.into(), problem: error.to_string() })
}
