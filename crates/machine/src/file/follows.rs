//! Reading of friction that follows the force of a stop.

use super::reading::{FileTable, Reading};
use crate::check::FOLLOWS;
use crate::description::{Dimension, Follows, Stop, StopLaw};
use crate::kinds;

/// Keys of a friction whose levels are given directly.
const OTHERS: [&str; 2] = ["force", "static"];

/// Reads the followed stop and the coefficients.
pub(super) fn read(reading: &mut Reading, table: &FileTable, stops: &[Stop]) -> Option<Follows> {
    let mut alone = true;
    for key in OTHERS {
        if let Some(other) = reading.optional(table, key) {
            alone = false;
            let text = "cannot be combined with `follows`: use `coefficient` and `static_coefficient` for \
                        friction at a stop, or `force` and `static` for a given friction force";
            reading.refuse(&other, text);
        }
    }
    let stop = stop(reading, table, stops);
    let (kind, plain) = (kinds::COEFFICIENT, Dimension::Translation);
    let coefficient = reading.required_number(table, "coefficient", kind, plain);
    let static_coefficient = match table.has("static_coefficient") {
        true => reading.required_number(table, "static_coefficient", kind, plain).map(Some),
        false => Some(None),
    };
    let follows = Follows { stop: stop?, coefficient: coefficient?, static_coefficient: static_coefficient? };
    Some(follows).filter(|_| alone)
}

/// Reads the followed stop, which must be compliant.
fn stop(reading: &mut Reading, table: &FileTable, stops: &[Stop]) -> Option<usize> {
    let allowed = "expected the name of a compliant stop";
    let entry = reading.required(table, "follows", allowed)?;
    let name = reading.string(&entry, allowed)?;
    let plain = name.strip_prefix("stop.").unwrap_or(&name);
    let Some(found) = stops.iter().position(|stop| stop.name == plain) else {
        reading.refuse_name(&entry, &name, "no stop has this name", stops.iter().map(|s| s.name.as_str()));
        return None;
    };
    if matches!(stops[found].law, StopLaw::Rigid { .. }) {
        let text = "this stop is rigid, and impacts with friction are not supported; \
                    use a compliant stop, with `stiffness`";
        reading.refuse(&entry, text);
        return None;
    }
    if stops[found].contact.is_some() {
        reading.refuse(&entry, FOLLOWS);
        return None;
    }
    Some(found)
}
