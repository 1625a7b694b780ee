//! Tables of special points, as `vibro orbits` writes them, and the choice of the rows that start
//! curves in two parameters.
//!
//! ```text
//! special-points.csv          every row that starts a curve
//! special-points.csv:12       row 12, counted from 1
//! special-points.csv:LP       every fold
//! special-points.csv:LP@2.3   every fold whose value, rounded to one decimal, is 2.3
//! special-points.csv:@2.3     every special point at that value
//! ```

mod of_file;
mod of_paper;

pub use of_file::PointOfFile;
pub use of_paper::SpecialPoint;

use crate::{Error, Result, table};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use vibro_orbits::Label;

/// Tolerance of a value in units of its last digit: one half, and a little more for ties.
const LAST_DIGIT: f64 = 0.51;

/// Rows of a table of special points, as `FILE`, `FILE:ROW`, `FILE:LABEL` or `FILE:LABEL@VALUE`.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// The table.
    pub path: PathBuf,
    /// The chosen rows.
    rows: ChosenRows,
}

#[derive(Clone, Debug, PartialEq)]
enum ChosenRows {
    All,
    Row(usize),
    Kind { label: Option<Label>, value: Option<String> },
}

/// A special point of a table of a machine.
pub trait PointOfTable: Sized {
    /// The row, counted from 1.
    fn row(&self) -> usize;

    /// The type of the point.
    fn label(&self) -> Label;

    /// The parameter's value.
    fn value(&self) -> f64;

    /// Description of the point with its events.
    fn told(&self) -> String;

    /// The point of a row, as the start of a curve; `None` if the table has no orbit next to it.
    #[doc(hidden)]
    fn read(row: &PointRow, label: Label) -> Result<Option<Self>>;
}

impl FromStr for Selection {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let all = || Self { path: text.into(), rows: ChosenRows::All };
        let form = || Error::form(text, "FILE, FILE:ROW (rows count from 1), FILE:LABEL or FILE:LABEL@VALUE");
        let (path, choice) = match text.rsplit_once(':') {
            None if text.trim().is_empty() => return Err(form()),
            None => return Ok(all()),
            Some((path, _)) if path.trim().is_empty() => return Err(form()),
            Some(parts) => parts,
        };
        let rows = if let Ok(row) = choice.parse::<usize>() {
            if row == 0 {
                return Err(form());
            }
            ChosenRows::Row(row)
        } else {
            let (label, value) = choice.split_once('@').map_or((choice, None), |(l, v)| (l, Some(v)));
            let label = label.trim();
            let known = Label::STARTS.into_iter().find(|own| own.name().eq_ignore_ascii_case(label));
            // A colon may belong to the path.
            if known.is_none() && !(label.is_empty() && value.is_some()) {
                return if Path::new(text).exists() { Ok(all()) } else { Err(form()) };
            }
            ChosenRows::Kind { label: known, value: value.map(|v| v.trim().to_owned()) }
        };
        Ok(Self { path: path.into(), rows })
    }
}

impl Selection {
    /// The chosen points. `along` is the parameter that the table must have, and `number` reads a
    /// value of this parameter.
    ///
    /// # Errors
    /// [`Error::Config`] if the file is not such a table, if the table does not have the row, if
    /// no curve starts from the row, or if no row meets the choice. If rows have the chosen label
    /// but not the chosen value, the error names the nearest row.
    pub fn points<P: PointOfTable>(
        &self,
        along: &str,
        number: &dyn Fn(&str) -> Result<f64>,
    ) -> Result<Vec<P>> {
        let table = Table::read(&self.path)?;
        let rows = table.rows();
        if let Some(first) = rows.first()
            && first.cell("parameter")? != along
        {
            let own = first.cell("parameter")?;
            return Err(first.wrong(format!("has points over {own}, but the first --vary is {along}")));
        }
        let wrong = |problem: String| Error::Config { path: self.path.clone(), problem };
        let (label, value) = match &self.rows {
            ChosenRows::Row(number) => {
                let row = rows
                    .get(number - 1)
                    .ok_or_else(|| wrong(format!("has no row {number}, only {} rows", rows.len())))?;
                let label = row.cell("label")?;
                let starts = Label::STARTS.map(Label::name);
                return Ok(vec![row.point()?.ok_or_else(|| {
                    wrong(match starts.contains(&label) {
                        true => format!(
                            "row {number} is {label} without an admissible orbit next to it, so no \
                             curve starts here; use a row of another branch at this value"
                        ),
                        false => format!("row {number} is {label}; expected one of {}", starts.join(", ")),
                    })
                })?]);
            }
            ChosenRows::All => (None, None),
            ChosenRows::Kind { label, value } => (*label, value.as_deref()),
        };
        let all = rows.iter().map(PointRow::point).collect::<Result<Vec<Option<P>>>>()?;
        let mut found: Vec<P> =
            all.into_iter().flatten().filter(|p| label.is_none_or(|label| p.label() == label)).collect();
        let what = label.map_or("point from which a curve starts", Label::name);
        if found.is_empty() {
            return Err(wrong(format!("has no {what}")));
        }
        if let Some(text) = value {
            let wanted = number(text)?;
            let room = last_digit(text, wanted);
            let distance = |p: &P| (p.value() - wanted).abs();
            let nearest = found.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            let nearest = nearest.map(|p| (p.row(), p.value()));
            found.retain(|p| distance(p) <= room);
            if let (true, Some((row, value))) = (found.is_empty(), nearest) {
                return Err(wrong(format!("has no {what} at {text}; the nearest is row {row} at {value}")));
            }
        }
        Ok(found)
    }
}

/// A table as it was read.
struct Table<'a> {
    path: &'a Path,
    header: csv::StringRecord,
    records: Vec<csv::StringRecord>,
}

impl<'a> Table<'a> {
    fn read(path: &'a Path) -> Result<Self> {
        let allowed = "a table of special points, as `vibro orbits` or `vibro paper orbits` writes it";
        let (header, records) = table::read(path, allowed)?;
        Ok(Self { path, header, records })
    }

    fn rows(&self) -> Vec<PointRow<'_>> {
        let numbered = self.records.iter().zip(1..);
        numbered
            .map(|(record, number)| PointRow { number, record, header: &self.header, path: self.path })
            .collect()
    }
}

/// Tolerance of a value that is given as text: [`LAST_DIGIT`] units of the text's last digit, in
/// SI.
fn last_digit(text: &str, value: f64) -> f64 {
    let mantissa = text.trim().trim_start_matches(['+', '-']);
    let plain: String = mantissa.chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect();
    let digits = plain.split_once('.').map_or(0, |(_, fraction)| fraction.len());
    let written: f64 = plain.parse().unwrap_or(0.0);
    let unit = if written == 0.0 { 1.0 } else { (value / written).abs() };
    LAST_DIGIT * unit / 10f64.powi(i32::try_from(digits).unwrap_or(i32::MAX))
}

/// A row of a table.
pub struct PointRow<'a> {
    number: usize,
    record: &'a csv::StringRecord,
    header: &'a csv::StringRecord,
    path: &'a Path,
}

impl PointRow<'_> {
    fn wrong(&self, problem: String) -> Error {
        Error::Config { path: self.path.into(), problem }
    }

    fn cell(&self, name: &str) -> Result<&str> {
        let index = self.header.iter().position(|h| h == name);
        let missing =
            || self.wrong(format!("has no column `{name}`; expected special-points.csv of `vibro orbits`"));
        index.and_then(|i| self.record.get(i)).ok_or_else(missing)
    }

    fn number(&self, text: &str) -> Result<f64> {
        let finite = text.parse::<f64>().ok().filter(|x| x.is_finite());
        finite.ok_or_else(|| self.wrong(format!("row {}: `{text}` is not a finite number", self.number)))
    }

    /// The point; `None` for a row that starts no curve: an end of the range, a branch that was
    /// not followed further, or a marked value.
    fn point<P: PointOfTable>(&self) -> Result<Option<P>> {
        let label = Label::find(self.cell("label")?).filter(|label| Label::STARTS.contains(label));
        label.map_or(Ok(None), |label| P::read(self, label))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use vibro_studies::paper::{Name, number};

    #[test]
    fn selections_are_read_as_they_are_written() {
        let rows = |text: &str| text.parse::<Selection>().unwrap().rows;
        let kind = |label, value: Option<&str>| ChosenRows::Kind { label, value: value.map(str::to_owned) };
        assert_eq!(rows("a.csv"), ChosenRows::All);
        assert_eq!(rows("a.csv:3"), ChosenRows::Row(3));
        assert_eq!(rows("C:/b/a.csv:lp"), kind(Some(Label::Fold), None));
        assert_eq!(rows("a.csv:PD@2.3041"), kind(Some(Label::PeriodDoubling), Some("2.3041")));
        assert_eq!(rows("a.csv:@10.65 Hz"), kind(None, Some("10.65 Hz")));
        for text in ["a.csv:0", "a.csv:XX", "a.csv:XX@2", "a.csv:"] {
            assert!(text.parse::<Selection>().is_err(), "{text}");
        }
    }

    #[test]
    fn closed_form_room_of_a_value_as_it_is_written() {
        let [f10, frequency] = ["f10", "drive.frequency"].map(|name| Name::find(name).unwrap());
        let room = |name: Name, text: &str| last_digit(text, number(name, text).unwrap());
        assert_eq!(room(f10, "2.30"), LAST_DIGIT / 100.0);
        assert_eq!(room(f10, "-2"), LAST_DIGIT);
        let hertz = room(frequency, "10.6Hz");
        assert!((hertz - LAST_DIGIT * 0.1 * std::f64::consts::TAU).abs() < 1e-12, "{hertz}");
    }
}
