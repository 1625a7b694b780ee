//! Reading of records: two columns of numbers, time and value.

use super::{Records, any_unit, read_text};
use crate::check::{MOST_KNOTS, too_few};
use crate::description::Dimension;
use crate::kinds::{self, NumberKind};
use crate::table::{Heading, Table, in_unit};
use std::io;
use std::path::{Component, Path, PathBuf};
use vibro_numerics::quantities::Unit;

/// A reader for texts without records; it finds no file.
///
/// # Errors
/// Always.
pub fn no_records(_: &str) -> io::Result<String> {
    Err(io::Error::other(
        "a text that is not in a file cannot refer to other files; write the values into the text",
    ))
}

/// Returns a reader of records in a folder.
pub fn records_beside(folder: &Path) -> impl Fn(&str) -> io::Result<String> + use<> {
    let folder = PathBuf::from(folder);
    move |path| read_regular(&folder.join(path))
}

/// Reads a regular file; a pipe could block without end.
fn read_regular(path: &Path) -> io::Result<String> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::other("it is a folder, pipe or device; expected a regular file"));
    }
    read_text(path)
}

/// Kind of a record's values.
#[derive(Clone, Copy)]
pub(super) struct RecordValues {
    /// Kind of a value.
    pub kind: NumberKind,
    /// Dimension of a value.
    pub dimension: Dimension,
    /// Whether the record's `scale` has the unit of the values.
    pub has_scale: bool,
}

/// Reads the knots of a record. The error is the problem's text.
pub(super) fn read(path: &str, records: Records, values: RecordValues) -> Result<Vec<(f64, f64)>, String> {
    stays_inside(path)?;
    let text = records(path).map_err(|e| super::unread(&e, "export the record as CSV"))?;
    knots(&text, values)
}

/// Checks that a path is below the file's folder and means the same on every system.
pub(super) fn stays_inside(path: &str) -> Result<(), String> {
    let plain = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    if path.is_empty() || path.contains(['\\', ':', '\0']) || !Path::new(path).components().all(plain) {
        let text = "expected a path below the file's folder, with / between its parts, \
                    such as \"data/record.csv\"";
        return Err(text.into());
    }
    Ok(())
}

/// Reads the knots of a [table](Table) with two columns, time and value, in SI or in the units of
/// its heading.
fn knots(text: &str, values: RecordValues) -> Result<Vec<(f64, f64)>, String> {
    let table = Table::read(text);
    let heading = table.heading();
    let (mut units, mut rows) = ([None, None], &table.rows[..]);
    if let Some(names) = &heading {
        let first = &table.rows[0];
        table.check(first, 2)?;
        let refused = |text: String| first.refused(&text);
        let value = unit_of_values(&names[1], values).map_err(refused)?;
        units = [names[0].unit(kinds::TIME.units[0]).map_err(refused)?, value];
        rows = &table.rows[1..];
    }
    let mut knots: Vec<(f64, f64)> = Vec::new();
    for row in rows {
        let numbers = table.numbers(row, 2)?;
        let (time, value) = (in_unit(units[0], numbers[0]), in_unit(units[1], numbers[1]));
        if knots.last().is_some_and(|last| time <= last.0) {
            return Err(
                row.refused("has a time that is not after the previous one; expected increasing times")
            );
        }
        knots.push((time, value));
        if knots.len() > MOST_KNOTS {
            return Err(row.refused(&format!("is beyond the limit; expected at most {MOST_KNOTS} rows")));
        }
    }
    if knots.len() < 2 {
        return Err(too_few(knots.len()));
    }
    Ok(knots)
}

/// Returns the unit of a record's values, from its heading.
fn unit_of_values(heading: &Heading, values: RecordValues) -> Result<Option<&'static Unit>, String> {
    match heading.unit {
        Some(symbol) if values.kind.any_unit => {
            let (_, si) = any_unit::quantity(&format!("1 {symbol}"), "expected a unit such as mm, N or rad/s")?;
            heading.unit(si)
        }
        Some(symbol) if values.has_scale => heading.unit("1").map_err(|_| {
            format!(
                "`{}` has the unit `{symbol}`, which cannot be combined with `scale`: remove the unit or `scale`",
                heading.name
            )
        }),
        _ => heading.unit(values.kind.unit(values.dimension)),
    }
}
