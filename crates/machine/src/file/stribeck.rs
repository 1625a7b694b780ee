//! Reading of Stribeck's curve and of the viscous part of a friction.

use super::numbers::finite;
use super::reading::{FileTable, Reading};
use crate::description::{Dimension, Stribeck, StribeckExponent};
use crate::kinds;

/// Keys of a friction whose force depends on its rate.
const KEYS: [&str; 3] = ["stribeck", "stribeck_exponent", "viscous"];

/// Reads Stribeck's curve and the viscous damping; `None` if one of them is refused.
pub(super) fn read(
    reading: &mut Reading,
    table: &FileTable,
    dimension: Dimension,
) -> Option<(Option<Stribeck>, Option<f64>)> {
    let viscous = match reading.optional(table, "viscous") {
        Some(entry) => reading.number(&entry, kinds::VISCOUS, dimension).map(Some),
        None => Some(None),
    };
    let exponent = exponent(reading, table);
    let Some(entry) = reading.optional(table, "stribeck") else {
        return exponent.and(Some((None, viscous?)));
    };
    if !table.has("static") {
        let text = "requires `static`: the level falls from `static` to `force` as the speed grows";
        reading.refuse(&entry, text);
        return None;
    }
    let speed = reading.number(&entry, kinds::STRIBECK, dimension);
    Some((Some(Stribeck { speed: speed?, exponent: exponent? }), viscous?))
}

/// Reads the exponent of the curve, which requires a speed.
fn exponent(reading: &mut Reading, table: &FileTable) -> Option<StribeckExponent> {
    let Some(entry) = reading.optional(table, "stribeck_exponent") else { return Some(Default::default()) };
    if !table.has("stribeck") {
        let text = "requires `stribeck`, the speed at which the level falls from `static` to `force`";
        reading.refuse(&entry, text);
        return None;
    }
    let found = match finite(entry.value) {
        Some(1.0) => Some(StribeckExponent::One),
        Some(2.0) => Some(StribeckExponent::Two),
        _ => None,
    };
    if found.is_none() {
        reading.refuse(&entry, "expected the number 1 or 2");
    }
    found
}

/// Whether a friction that follows a stop has none of these keys; refuses them otherwise.
pub(super) fn none(reading: &mut Reading, table: &FileTable) -> bool {
    let mut is_sound = true;
    for key in KEYS {
        let Some(entry) = reading.optional(table, key) else { continue };
        let advice = match key {
            "viscous" => "use a damper between the same ends",
            _ => "use `force` and `static`",
        };
        reading.refuse(&entry, format!("cannot be combined with `follows`: {advice}"));
        is_sound = false;
    }
    is_sound
}
