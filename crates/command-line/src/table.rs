//! Tables for CSV files.

use crate::subject::Subject;
use crate::{Error, Result};
use rayon::prelude::*;
use std::borrow::Cow;
use std::path::Path;
use vibro_studies::paper::Unit;

/// A table with a header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TextTable {
    /// Names of the columns.
    pub header: Vec<String>,
    /// The rows, each of the header's length.
    pub rows: Vec<Vec<String>>,
}

impl TextTable {
    /// An empty table.
    pub fn new(header: &[&str]) -> Self {
        Self { header: header.iter().map(|h| (*h).into()).collect(), rows: Vec::new() }
    }

    /// As CSV text.
    ///
    /// # Errors
    /// [`Error::Output`] if a row and the header have different lengths.
    pub fn csv(&self) -> Result<Vec<u8>> {
        let mut csv = CsvRows::new(&self.header)?;
        self.rows.iter().try_for_each(|row| csv.push(row))?;
        csv.text()
    }
}

/// CSV text written row by row, for millions of rows: as a [`TextTable`] they would take hundreds
/// of megabytes.
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
    /// [`Error::Output`] if the row and the header have different lengths.
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

/// CSV text of `count` groups of rows in order; `fill` appends the rows of one group. Groups are
/// formatted on all threads.
///
/// # Errors
/// [`Error::Output`] if a row and the header have different lengths; the errors of `fill`.
pub fn csv_in_groups(
    header: &[&str],
    count: usize,
    fill: impl Fn(&mut CsvRows, usize) -> Result<()> + Sync,
) -> Result<Vec<u8>> {
    /// Number of groups formatted in parallel. Their text is in memory in addition to the whole
    /// text.
    const TOGETHER: usize = 64;
    let mut text = CsvRows::new(header)?.text()?;
    let head = text.len();
    // Each group gets a header, so that the length of its rows is checked, and the header is then
    // cut off.
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

/// Name of the column that repeats a column in another unit.
pub fn column_in(column: &str, unit: &Unit) -> String {
    format!("{column} [{}]", unit.plain())
}

/// The table with an additional column at its end for each parameter that was written in a unit
/// other than SI. The column has the values in that unit, and its name contains the unit.
///
/// # Errors
/// [`Error::Output`] if the text is not a table.
pub fn in_written_units<'t>(subject: &dyn Subject, csv: &'t [u8]) -> Result<Cow<'t, [u8]>> {
    let problem = Error::output("a table");
    let mut reader = csv::Reader::from_reader(csv);
    let mut header = reader.byte_headers().map_err(&problem)?.clone();
    let unit =
        |(i, name): (usize, &[u8])| Some((i, subject.unit_of_column(std::str::from_utf8(name).ok()?)?));
    let written: Vec<(usize, &Unit)> = header.iter().enumerate().filter_map(unit).collect();
    if written.is_empty() {
        return Ok(Cow::Borrowed(csv));
    }
    for (i, unit) in &written {
        let name = column_in(&String::from_utf8_lossy(&header[*i]), unit);
        header.push_field(name.as_bytes());
    }
    let mut rows = CsvRows::new(&header)?;
    let mut record = csv::ByteRecord::new();
    while reader.read_byte_record(&mut record).map_err(&problem)? {
        for (i, unit) in &written {
            let number = std::str::from_utf8(&record[*i]).ok().and_then(|cell| cell.parse::<f64>().ok());
            let cell = number.map_or(String::new(), |si| exact(shown(unit, si)));
            record.push_field(cell.as_bytes());
        }
        rows.push(&record)?;
    }
    Ok(Cow::Owned(rows.text()?))
}

/// A value in a unit, without the rounding of the conversion to SI and back: 10 Hz is 10 and not
/// 10.000000000000002.
pub fn shown(unit: &Unit, si: f64) -> f64 {
    let number = unit.number(si);
    format!("{number:.14e}").parse().unwrap_or(number)
}

/// Decimal digits of a number that read back to the same bits.
pub fn exact(value: f64) -> String {
    format!("{value}")
}

/// The header and the rows of a table, without blanks around cells. `allowed` describes the valid
/// files.
///
/// # Errors
/// [`Error::Config`] for a file that is not a table.
pub(crate) fn read(path: &Path, allowed: &str) -> Result<(csv::StringRecord, Vec<csv::StringRecord>)> {
    let unread =
        |e: csv::Error| Error::Config { path: path.into(), problem: format!("{e}; expected {allowed}") };
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_path(path).map_err(unread)?;
    let header = reader.headers().map_err(unread)?.clone();
    let rows = reader.records().collect::<std::result::Result<_, _>>().map_err(unread)?;
    Ok((header, rows))
}

/// The text of a file.
///
/// # Errors
/// [`Error::File`] for a file that cannot be read; [`Error::Config`] with the line of a byte that
/// is not UTF-8.
pub(crate) fn read_text(path: &Path) -> Result<String> {
    let bytes = std::fs::read(path).map_err(Error::file("reading", path))?;
    String::from_utf8(bytes).map_err(|e| {
        let valid = &e.as_bytes()[..e.utf8_error().valid_up_to()];
        let line = 1 + valid.iter().filter(|b| **b == b'\n').count();
        let problem = format!("line {line} is not UTF-8 text; expected a table as text");
        Error::Config { path: path.into(), problem }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibro_studies::paper::ParameterSet;

    #[test]
    fn a_table_answers_in_the_unit_in_which_a_parameter_was_written() {
        let mut set = ParameterSet::basic();
        set.apply(&["drive.frequency=10Hz", "stop.gap=5 mm", "box.m=12 kg"]).unwrap();
        let si = [10.0, 10.3, 11.0].map(|f: f64| f * std::f64::consts::TAU);
        let csv = format!("drive.frequency,class,box.m\n{},1T,12\n{},2T,12\n{},,12\n", si[0], si[1], si[2]);
        let found = in_written_units(&set, csv.as_bytes()).unwrap();
        let expected = format!(
            "drive.frequency,class,box.m,drive.frequency [Hz]\n{},1T,12,10\n{},2T,12,10.3\n{},,12,11\n",
            si[0], si[1], si[2]
        );
        assert_eq!(String::from_utf8_lossy(&found), expected);
        let named =
            [("stop.gap_from", true), ("amplitude.x1.max.stop.gap", true), ("box.m", false), ("gap", false)];
        for (column, is_written) in named {
            assert_eq!(set.unit_of_column(column).is_some(), is_written, "{column}");
        }
        let without = in_written_units(&ParameterSet::basic(), csv.as_bytes()).unwrap();
        assert!(matches!(without, Cow::Borrowed(same) if same == csv.as_bytes()));
    }
}
