//! Rows of the special points of a described machine, as `vibro orbits FILE` writes them.

use super::{PointRow, Seen, Selection, Table};
use crate::Result;
use vibro_machine::Start;
use vibro_orbits::{Kind, Special};

/// A special point of a described machine with its row, counted from 1.
#[derive(Clone, Debug, PartialEq)]
pub struct PointOfFile {
    /// The row.
    pub row: usize,
    /// Kind and element.
    pub special: Special,
    /// The parameter's value, SI.
    pub value: f64,
    /// Value of the parameter, period (s) and start of an orbit of the branch beside it.
    pub beside: (f64, f64, Start),
}

impl Selection {
    /// The chosen points of the table over a parameter of a described machine. `number` reads a
    /// value of the parameter.
    ///
    /// # Errors
    /// As [`points`](Self::points).
    pub fn points_of_file(
        &self,
        along: &str,
        number: &dyn Fn(&str) -> Result<f64>,
    ) -> Result<Vec<PointOfFile>> {
        let table = Table::read(&self.path)?;
        let rows = table.rows();
        let other = rows.first().map(|row| row.cell("parameter")).transpose()?;
        if let Some(other) = other.filter(|own| *own != along) {
            return Err(rows[0].other_parameter(other, along));
        }
        let seen = |p: &PointOfFile| Seen { row: p.row, label: p.special.kind.name(), value: p.value };
        self.chosen(&rows, &|row| row.point_of_file(), &seen, number)
    }
}

impl PointRow<'_> {
    /// The point; `None` for a row from which no curve starts.
    fn point_of_file(&self) -> Result<Option<PointOfFile>> {
        let label = self.cell("label")?;
        let Some(kind) = Kind::starts().find(|kind| kind.name() == label) else { return Ok(None) };
        let special = Special { kind, element: self.cell("element")?.to_owned() };
        let start = self.cell("beside_start")?;
        if start.is_empty() {
            // No orbit near the point can be reached by a motion.
            return Ok(None);
        }
        let start = Start::try_from(start.to_owned()).map_err(|problem| self.wrong(problem))?;
        let of = |name: &str| self.number(self.cell(name)?);
        let beside = (of("beside_value")?, of("beside_period")?, start);
        Ok(Some(PointOfFile { row: self.number, special, value: self.number(self.cell("value")?)?, beside }))
    }
}
