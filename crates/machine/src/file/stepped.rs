//! Reading of a stiffness: a number, or a signal that steps in time.

use super::reading::{FileTable, Reading};
use super::series;
use super::signals::{self, Values};
use crate::description::{Dimension, Signal};
use crate::kinds::{self, NumberKind};

/// Reads `stiffness`: a number of this kind, or 0 and the signal of a stepped stiffness.
pub(super) fn read(
    reading: &mut Reading,
    table: &FileTable,
    kind: NumberKind,
    dimension: Dimension,
) -> Option<(f64, Option<Signal>)> {
    let allowed = kind.allowed(dimension);
    let allowed = match series::is_given(table) {
        true => allowed,
        false => format!("{allowed}; `points` or a curve, such as `cubic`, may replace it"),
    };
    let entry = reading.required(table, "stiffness", &allowed)?;
    if !entry.value.is_table() {
        return Some((reading.number(&entry, kind, dimension)?, None));
    }
    if series::is_given(table) {
        reading.refuse(&entry, "cannot step in time with `series_damping` or `slip`; expected a number");
        return None;
    }
    let values = Values { kind: kinds::STEPPED, alone: kind, dimension };
    Some((0.0, Some(signals::value(reading, &entry, values)?)))
}
