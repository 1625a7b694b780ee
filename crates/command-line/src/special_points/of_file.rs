//! Rows of the special points of a described machine, as `vibro orbits FILE` writes them.

use super::{PointOfTable, PointRow};
use crate::Result;
use vibro_machine::Start;
use vibro_orbits::{Label, Special};

/// A special point of a described machine.
#[derive(Clone, Debug, PartialEq)]
pub struct PointOfFile {
    /// The row, counted from 1.
    pub row: usize,
    /// Type and element.
    pub special: Special,
    /// The parameter's value, SI.
    pub value: f64,
    /// Value of the parameter, period (s) and start of an orbit of the branch next to the point.
    pub beside: (f64, f64, Start),
}

impl PointOfTable for PointOfFile {
    fn row(&self) -> usize {
        self.row
    }

    fn label(&self) -> Label {
        self.special.label
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn told(&self) -> String {
        self.special.label.to_string()
    }

    fn read(row: &PointRow, label: Label) -> Result<Option<Self>> {
        let special = Special::new(label, row.cell("element")?);
        let start = row.cell("beside_start")?;
        if start.is_empty() {
            return Ok(None);
        }
        let start = Start::try_from(start.to_owned()).map_err(|problem| row.wrong(problem))?;
        let of = |name: &str| row.number(row.cell(name)?);
        let beside = (of("beside_value")?, of("beside_period")?, start);
        Ok(Some(Self { row: row.number, special, value: of("value")?, beside }))
    }
}
