//! Tables for CSV files.

use crate::{Error, Result};
use rayon::prelude::*;

/// A table with a header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names of the columns.
    pub header: Vec<String>,
    /// The rows, each as long as the header.
    pub rows: Vec<Vec<String>>,
}

impl Table {
    /// An empty table.
    pub fn new(header: &[&str]) -> Self {
        Self { header: header.iter().map(|h| (*h).into()).collect(), rows: Vec::new() }
    }

    /// As CSV text.
    ///
    /// # Errors
    /// [`Error::Output`] when a row has another length than the header.
    pub fn csv(&self) -> Result<Vec<u8>> {
        let mut csv = CsvRows::new(&self.header)?;
        self.rows.iter().try_for_each(|row| csv.push(row))?;
        csv.text()
    }
}

/// CSV text that is written row by row: a [`Table`] of millions of rows would take hundreds of megabytes.
pub struct CsvRows(csv::Writer<Vec<u8>>);

impl CsvRows {
    /// Text with a header only.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn new<T: AsRef<[u8]>>(header: impl IntoIterator<Item = T>) -> Result<Self> {
        let mut rows = Self(csv::Writer::from_writer(Vec::new()));
        rows.push(header)?;
        Ok(rows)
    }

    /// Appends a row.
    ///
    /// # Errors
    /// [`Error::Output`] when it has another length than the header.
    pub fn push<T: AsRef<[u8]>>(&mut self, cells: impl IntoIterator<Item = T>) -> Result<()> {
        self.0.write_record(cells).map_err(Error::output("a table"))
    }

    /// The text.
    ///
    /// # Errors
    /// [`Error::Output`].
    pub fn text(self) -> Result<Vec<u8>> {
        self.0.into_inner().map_err(Error::output("a table"))
    }
}

/// CSV text of `count` groups of rows in their order; `fill` appends the rows of one. They are formatted on all threads.
///
/// # Errors
/// [`Error::Output`]; what `fill` returns.
pub fn csv_in_groups(
    header: &[&str],
    count: usize,
    fill: impl Fn(&mut CsvRows, usize) -> Result<()> + Sync,
) -> Result<Vec<u8>> {
    /// Groups whose text is in memory beside the whole.
    const TOGETHER: usize = 64;
    let mut text = CsvRows::new(header)?.text()?;
    let head = text.len();
    // Each has the header, to whose length its rows are held, and which is then cut off.
    let group = |index| {
        let mut rows = CsvRows::new(header)?;
        fill(&mut rows, index)?;
        rows.text()
    };
    for first in (0..count).step_by(TOGETHER) {
        let indices = first..count.min(first + TOGETHER);
        let groups: Vec<Vec<u8>> = indices.into_par_iter().map(group).collect::<Result<_>>()?;
        groups.iter().for_each(|group| text.extend_from_slice(&group[head..]));
    }
    Ok(text)
}

/// A number in decimals that read back as the same bits.
pub fn exact(value: f64) -> String {
    format!("{value}")
}
