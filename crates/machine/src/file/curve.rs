//! Reading of the coefficients of a spring's curve.

use super::powers;
use super::reading::{FileTable, Reading};
use crate::description::{Curve, Dimension};
use crate::kinds::{CURVE, CURVED_STIFFNESS};

/// Keys of a spring that cannot be combined with a curve.
pub(super) const EXCLUDED: [&str; 3] = ["points", "series_damping", "slip"];

/// Whether a table has a coefficient of a curve, or a power with two sides.
pub(super) fn is_given(table: &FileTable) -> bool {
    CURVE.iter().any(|(key, _)| table.has(key)) || powers::is_given(table)
}

/// Reads the coefficients; `None` if one of them, or a key next to them, is refused.
pub(super) fn read(reading: &mut Reading, table: &FileTable, dimension: Dimension) -> Option<Curve> {
    let mut curve = Curve::default();
    let mut is_sound = true;
    for ((key, kind), coefficient) in CURVE.into_iter().zip(&mut curve) {
        let Some(entry) = reading.optional(table, key) else { continue };
        *coefficient = reading.number(&entry, kind, dimension);
        is_sound &= coefficient.is_some();
        if let Some(other) = EXCLUDED.into_iter().find(|other| table.has(other)) {
            let text = format!("cannot be combined with `{other}`: use two springs in parallel");
            reading.refuse(&entry, text);
            is_sound = false;
        }
    }
    Some(curve).filter(|_| is_sound)
}

/// Reads the stiffness at e = 0 of a spring with a curve.
pub(super) fn stiffness(reading: &mut Reading, table: &FileTable, dimension: Dimension) -> Option<f64> {
    if let Some(entry) = reading.optional(table, "stiffness").filter(|own| own.value.is_table()) {
        let keys = CURVE.iter().map(|own| own.0).chain(powers::KEYS).chain(["force"]);
        let key = keys.into_iter().find(|key| table.has(key)).unwrap_or("points");
        let text = format!(
            "a stiffness that steps in time cannot be combined with `{key}`: use two springs in parallel"
        );
        reading.refuse(&entry, text);
        return None;
    }
    reading.number_or(table, "stiffness", CURVED_STIFFNESS, dimension, 0.0)
}
