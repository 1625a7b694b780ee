//! Records as tables of text: values over time, and times of contacts.

use super::Measured;
use crate::assembly::QuantityName;
use crate::error::{Error, Result};

/// The place of a column.
fn place(header: &[&str], name: &str) -> Result<usize> {
    header.iter().position(|own| *own == name).ok_or_else(|| {
        let known = header.join(", ");
        wrong(format!("has no column `{name}`, but {known}; its first line names the columns"))
    })
}

fn wrong(problem: String) -> Error {
    Error::Described { problem }
}

/// The number of a cell; `row` counts from 1, the line of names left out.
fn number(name: &str, row: usize, text: &str) -> Result<f64> {
    let finite = text.parse::<f64>().ok().filter(|x| x.is_finite());
    finite.ok_or_else(|| {
        wrong(format!("row {row}: {name} = `{text}` is no finite number; allowed are numbers in SI"))
    })
}

impl Measured {
    /// Adds the columns of a table whose first line names `time` and quantities such as `box.s`,
    /// SI.
    ///
    /// # Errors
    /// [`Error::Described`] for a column without a meaning, and for a cell that is no number.
    pub fn add_columns<'c>(
        &mut self,
        header: &[&str],
        rows: impl Iterator<Item = Vec<&'c str>>,
    ) -> Result<()> {
        let time = place(header, "time")?;
        for (i, name) in header.iter().enumerate().filter(|(i, _)| *i != time) {
            let quantity: QuantityName =
                name.parse().map_err(|error| wrong(format!("column {}: {error}", i + 1)))?;
            self.columns.push((quantity, Vec::new()));
        }
        for (row, cells) in rows.enumerate() {
            let read = |i: usize| number(header[i], row + 1, cells.get(i).copied().unwrap_or_default());
            self.times.push(read(time)?);
            let others = (0..header.len()).filter(|i| *i != time);
            for (i, (_, values)) in others.zip(&mut self.columns) {
                values.push(read(i)?);
            }
        }
        Ok(())
    }

    /// Adds the times of contacts of a table with the columns `element` and `time`.
    ///
    /// # Errors
    /// [`Error::Described`] for a table without these columns, and for a time that is no number.
    pub fn add_contacts<'c>(
        &mut self,
        header: &[&str],
        rows: impl Iterator<Item = Vec<&'c str>>,
    ) -> Result<()> {
        let (element, time) = (place(header, "element")?, place(header, "time")?);
        for (row, cells) in rows.enumerate() {
            let cell = |i: usize| cells.get(i).copied().unwrap_or_default();
            let at = number("time", row + 1, cell(time))?;
            match self.contacts.iter_mut().find(|(own, _)| own == cell(element)) {
                Some((_, times)) => times.push(at),
                None => self.contacts.push((cell(element).to_owned(), vec![at])),
            }
        }
        Ok(())
    }
}
