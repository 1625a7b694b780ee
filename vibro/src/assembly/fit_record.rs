//! Records of a fit: tables of values over time, and of times of contacts.

use crate::table::read;
use crate::{Error, Result};
use csv::StringRecord;
use std::path::Path;
use vibro_analysis::assembly::QuantityName;
use vibro_analysis::assembly::fit::Measured;

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
        add_columns(path, &mut measured)?;
    }
    if let Some(path) = events {
        add_contacts(path, &mut measured)?;
    }
    Ok(measured)
}

fn wrong(path: &Path, problem: String) -> Error {
    Error::Config { path: path.into(), problem }
}

/// The place of a column.
fn place(path: &Path, header: &StringRecord, name: &str) -> Result<usize> {
    header.iter().position(|own| own == name).ok_or_else(|| {
        wrong(path, {
            let known: Vec<&str> = header.iter().collect();
            format!("has no column `{name}`, but {}; its first line names the columns", known.join(", "))
        })
    })
}

/// The number of a cell; `row` counts from 1, the line of names left out.
fn number(path: &Path, name: &str, row: usize, text: &str) -> Result<f64> {
    let finite = text.parse::<f64>().ok().filter(|x| x.is_finite());
    finite.ok_or_else(|| {
        wrong(path, format!("row {row}: {name} = `{text}` is no finite number; allowed are numbers in SI"))
    })
}

fn add_columns(path: &Path, measured: &mut Measured) -> Result<()> {
    let (header, rows) = read(path, RECORD)?;
    let time = place(path, &header, "time")?;
    for (i, name) in header.iter().enumerate().filter(|(i, _)| *i != time) {
        let quantity: QuantityName =
            name.parse().map_err(|error| wrong(path, format!("column {}: {error}", i + 1)))?;
        measured.columns.push((quantity, Vec::with_capacity(rows.len())));
    }
    for (row, cells) in rows.iter().enumerate() {
        let read = |i: usize| number(path, &header[i], row + 1, cells.get(i).unwrap_or_default());
        measured.times.push(read(time)?);
        let others = (0..header.len()).filter(|i| *i != time);
        for (i, (_, values)) in others.zip(&mut measured.columns) {
            values.push(read(i)?);
        }
    }
    Ok(())
}

fn add_contacts(path: &Path, measured: &mut Measured) -> Result<()> {
    let (header, rows) = read(path, RECORD)?;
    let (element, time) = (place(path, &header, "element")?, place(path, &header, "time")?);
    for (row, cells) in rows.iter().enumerate() {
        let name = cells.get(element).unwrap_or_default();
        let at = number(path, "time", row + 1, cells.get(time).unwrap_or_default())?;
        match measured.contacts.iter_mut().find(|(own, _)| own == name) {
            Some((_, times)) => times.push(at),
            None => measured.contacts.push((name.to_owned(), vec![at])),
        }
    }
    Ok(())
}
