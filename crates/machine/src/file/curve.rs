//! Reading of the coefficients of a spring's curve.

use super::reading::{FileTable, Reading};
use crate::description::{Curve, Dimension};
use crate::kinds::CURVE;

/// Keys of a spring that cannot be combined with a curve.
const EXCLUDED: [&str; 4] = ["points", "series_damping", "slip", "slider"];

/// Whether a table has a coefficient of a curve.
pub(super) fn is_given(table: &FileTable) -> bool {
    CURVE.iter().any(|(key, _)| table.has(key))
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
            let text = format!("cannot be combined with `{other}`: use two springs side by side");
            reading.refuse(&entry, text);
            is_sound = false;
        }
    }
    Some(curve).filter(|_| is_sound)
}
