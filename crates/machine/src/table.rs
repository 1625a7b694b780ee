//! Tables of text: records of signals and of fits, matrices, lists of designs.
//!
//! A table has one row per line. Cells are separated by commas, or by semicolons if the first line
//! has one. Numbers have a decimal point. Empty lines and lines that begin with `#` are skipped.
//! The first line may be a heading. It names a column's unit in brackets, in parentheses or after
//! a slash: `box.s [mm]`, `force (kN)`, `t/ms`.
//!
//! ```
//! use vibro_machine::table::Table;
//!
//! let table = Table::read("time [ms], box.s [mm]\n0, 1.5\n10, 2.5\n");
//! let units = |name: &str| Some(if name == "time" { "s" } else { "m" });
//! let columns = table.columns(&units)?;
//! assert_eq!(columns[1], ("box.s".to_owned(), vec![0.0015, 0.0025]));
//! # Ok::<(), String>(())
//! ```

use vibro_numerics::quantities::{UNITS, Unit, in_si, symbols};

/// Separator of cells, unless the first line has a semicolon.
const COMMA: char = ',';
/// Largest number of letters of a line shown in a message.
const SHOWN: usize = 60;

/// A table of text.
#[derive(Clone, Debug)]
pub struct Table<'t> {
    /// All rows, the heading included.
    pub rows: Vec<Row<'t>>,
    separator: char,
}

/// A row of a table.
#[derive(Clone, Debug)]
pub struct Row<'t> {
    /// Line number, from 1.
    pub line: usize,
    /// Cells without surrounding blanks and quotes.
    pub cells: Vec<&'t str>,
    text: &'t str,
}

/// Name and unit of a column, from its cell of a heading.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heading<'t> {
    /// The text before the unit.
    pub name: &'t str,
    /// Symbol of the unit, if there is one.
    pub unit: Option<&'t str>,
}

/// Cells of a line. A separator within quotes does not separate.
fn cells(line: &str, separator: char) -> Vec<&str> {
    let mut is_quoted = false;
    let split = |c: char| {
        is_quoted ^= c == '"';
        c == separator && !is_quoted
    };
    line.split(split).map(|cell| cell.trim().trim_matches('"').trim()).collect()
}

impl<'t> Table<'t> {
    /// The rows of a text.
    pub fn read(text: &'t str) -> Self {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let lines = (1..).zip(text.lines()).map(|(line, text)| (line, text.trim()));
        let mut lines = lines.filter(|(_, text)| !text.is_empty() && !text.starts_with('#')).peekable();
        let has_semicolon = lines.peek().is_some_and(|(_, first)| cells(first, ';').len() > 1);
        let separator = if has_semicolon { ';' } else { COMMA };
        let rows = lines.map(|(line, text)| Row { line, cells: cells(text, separator), text });
        Self { rows: rows.collect(), separator }
    }

    /// The first row as a heading; `None` if one of its cells is a number.
    pub fn heading(&self) -> Option<Vec<Heading<'t>>> {
        let first = self.rows.first()?;
        let is_number = |cell: &&str| cell.parse::<f64>().is_ok() || has_decimal_comma(cell);
        (!first.cells.iter().any(is_number)).then(|| self.names())
    }

    /// The cells of the first row as names with units; empty without a row.
    pub fn names(&self) -> Vec<Heading<'t>> {
        self.rows.first().map_or(Vec::new(), |row| row.cells.iter().map(|cell| heading(cell)).collect())
    }

    /// The finite numbers of a row of `count` cells.
    ///
    /// # Errors
    /// A text that begins with the line, followed by the fault and the expected value.
    pub fn numbers(&self, row: &Row, count: usize) -> Result<Vec<f64>, String> {
        self.check(row, count)?;
        row.cells.iter().map(|cell| self.number(row, cell)).collect()
    }

    /// The finite number of a cell.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn number(&self, row: &Row, cell: &str) -> Result<f64, String> {
        let found = cell.parse().ok().filter(|x: &f64| x.is_finite());
        found.ok_or_else(|| {
            row.refused(&match cell {
                "" => "has an empty cell; expected a number, such as 0.5".into(),
                _ if has_decimal_comma(cell) => {
                    format!("`{cell}` has a decimal comma; expected a decimal point, such as 0.5")
                }
                _ => format!("`{cell}` is not a number; expected a number such as 0.5"),
            })
        })
    }

    /// Checks the number of a row's cells.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers).
    pub fn check(&self, row: &Row, count: usize) -> Result<(), String> {
        if row.cells.len() == count {
            return Ok(());
        }
        let (own, other) = if self.separator == COMMA {
            ("commas", ("semicolon", ';'))
        } else {
            ("semicolons", ("comma", COMMA))
        };
        let found = match row.cells.len() {
            1 if row.text.contains(other.1) => format!("is separated by a {}", other.0),
            1 if row.text.contains('\t') => "is separated by a tab".into(),
            1 if row.text.contains(char::is_whitespace) => "is separated by a blank".into(),
            1 => "has 1 cell".into(),
            cells => format!("has {cells} cells"),
        };
        let point = "and numbers with a decimal point";
        Err(row.refused(&format!(
            "{found}; expected {count} cells separated by {own}, {point}, as in the first line"
        )))
    }

    /// The columns under a heading, in SI; `unit` returns the SI unit of a column, given its name.
    /// A column without a unit keeps the numbers of the table.
    ///
    /// # Errors
    /// As [`numbers`](Self::numbers); for a unit in the heading that is not a unit of its column.
    pub fn columns<'u>(
        &self,
        unit: &dyn Fn(&str) -> Option<&'u str>,
    ) -> Result<Vec<(String, Vec<f64>)>, String> {
        let Some(first) = self.rows.first() else { return Ok(Vec::new()) };
        let names = self.names();
        let units = names.iter().map(|own| match unit(own.name) {
            Some(si) => own.unit(si).map_err(|text| first.refused(&text)),
            None => Ok(None),
        });
        let units = units.collect::<Result<Vec<_>, String>>()?;
        let mut columns: Vec<_> = names.iter().map(|own| (own.name.to_owned(), Vec::new())).collect();
        for row in &self.rows[1..] {
            let numbers = self.numbers(row, names.len())?;
            for (((_, values), number), unit) in columns.iter_mut().zip(numbers).zip(&units) {
                values.push(in_unit(*unit, number));
            }
        }
        Ok(columns)
    }
}

/// A number in SI, given its unit; without a unit it is in SI already.
pub fn in_unit(unit: Option<&Unit>, number: f64) -> f64 {
    unit.map_or(number, |unit| unit.si(number))
}

impl Row<'_> {
    /// A message about the row, beginning with its line.
    pub fn refused(&self, problem: &str) -> String {
        let shown: String = self.text.chars().take(SHOWN).collect();
        match problem.starts_with('`') {
            true => format!("line {}: {problem}", self.line),
            false => format!("line {}: `{shown}` {problem}", self.line),
        }
    }
}

impl Heading<'_> {
    /// Unit of the column, given the SI unit of its quantity; `None` if the heading has no unit.
    ///
    /// # Errors
    /// A text with the units that are expected.
    pub fn unit(&self, si: &str) -> Result<Option<&'static Unit>, String> {
        let Some(symbol) = self.unit.filter(|symbol| !(si == "1" && ["", "-"].contains(symbol))) else {
            return Ok(None);
        };
        in_si(si, 1.0, symbol).filter(|_| !symbol.is_empty()).map(|found| found.unit).ok_or_else(|| {
            let known: Vec<&str> = symbols(si).collect();
            format!("`{}` has the unit `{symbol}`; expected one of {}", self.name, known.join(", "))
        })
    }
}

/// Name and unit of a cell of a heading.
fn heading(cell: &str) -> Heading<'_> {
    let within = |open: char, close: char| {
        let end = cell.rfind(close)?;
        let mut depth = 0;
        let begin = cell[..=end].char_indices().rev().find(|(_, c)| {
            depth += i32::from(*c == close) - i32::from(*c == open);
            depth == 0
        });
        begin
            .map(|(begin, _)| Heading { name: cell[..begin].trim(), unit: Some(cell[begin + 1..end].trim()) })
    };
    let after_slash = || {
        let (name, symbol) = cell.split_once('/')?;
        let is_unit = UNITS.iter().any(|unit| in_si(unit.si, 1.0, symbol.trim()).is_some());
        (is_unit && !symbol.trim().is_empty())
            .then(|| Heading { name: name.trim(), unit: Some(symbol.trim()) })
    };
    within('[', ']')
        .or_else(after_slash)
        .or_else(|| within('(', ')'))
        .unwrap_or(Heading { name: cell, unit: None })
}

/// Whether a text is a number if its comma is a decimal point.
pub(crate) fn has_decimal_comma(text: &str) -> bool {
    text.matches(COMMA).count() == 1 && text.replace(COMMA, ".").parse::<f64>().is_ok()
}

#[cfg(test)]
mod tests;
