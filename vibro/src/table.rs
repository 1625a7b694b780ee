//! Tables for CSV files.

use crate::{Error, Result};

/// A table with a header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// Names of the columns.
    pub header: Vec<String>,
    /// The rows.
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
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in std::iter::once(&self.header).chain(&self.rows) {
            writer.write_record(row).map_err(Error::output("a table"))?;
        }
        writer.into_inner().map_err(Error::output("a table"))
    }
}

/// A number such that reading it gives the same bits.
pub fn exact(value: f64) -> String {
    format!("{value}")
}
