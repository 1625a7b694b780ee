//! Rows of the special points of the paper's machine, as `vibro orbits` writes them.

use super::{PointOfTable, PointRow};
use crate::Result;
use vibro_orbits::Label;
use vibro_orbits::paper::OrbitWord;

/// A special point of the paper's machine.
#[derive(Clone, Debug, PartialEq)]
pub struct SpecialPoint {
    /// The row, counted from 1.
    pub row: usize,
    /// The type of the point.
    pub label: Label,
    /// The word of the orbit.
    pub word: OrbitWord,
    /// Phases of the drive at the impacts, rad.
    pub phases: Vec<f64>,
    /// The parameter.
    pub value: f64,
}

impl PointOfTable for SpecialPoint {
    fn row(&self) -> usize {
        self.row
    }

    fn label(&self) -> Label {
        self.label
    }

    fn value(&self) -> f64 {
        self.value
    }

    fn told(&self) -> String {
        format!("{} of {}", self.label, self.word)
    }

    fn read(row: &PointRow, label: Label) -> Result<Option<Self>> {
        let phases =
            row.cell("phases")?.split_whitespace().map(|x| row.number(x)).collect::<Result<Vec<_>>>()?;
        let closing: i8 = if row.cell("closing")? == "-" { -1 } else { 1 };
        let period: Option<u32> = row.cell("period")?.parse().ok();
        let half = period.and_then(|period| if closing < 0 { Some(period) } else { period.checked_mul(2) });
        let half = half.ok_or_else(|| row.wrong(format!("row {}: no period", row.number)))?;
        let word = OrbitWord::new(row.cell("word")?, closing, half)?;
        let value = row.number(row.cell("value")?)?;
        Ok(Some(Self { row: row.number, label, word, phases, value }))
    }
}
