//! Reading of the points of a spring's force.

use super::reading::{Entry, FileTable, Reading};
use crate::description::{Dimension, ForcePoint};
use crate::kinds;

/// Keys of a spring that are not allowed with points.
const OTHERS: [&str; 5] = ["stiffness", "preload", "slip", "series_damping", "slider"];

/// Message that lists the allowed points.
const ALLOWED: &str = "expected two or more pairs [e, f] with increasing e, \
                       such as [[\"-2 mm\", \"-40 N\"], [\"1 mm\", \"10 N\"]]";

/// Reads `points`; empty if there are none, `None` if they are refused.
pub(super) fn read(
    reading: &mut Reading,
    table: &FileTable,
    dimension: Dimension,
) -> Option<Vec<ForcePoint>> {
    let Some(entry) = reading.optional(table, "points") else { return Some(Vec::new()) };
    let mut alone = true;
    for key in OTHERS {
        if let Some(other) = reading.optional(table, key) {
            alone = false;
            let text = "cannot be combined with `points`: use `points` (with `damping`) for a curve, \
                        or `stiffness` for a linear spring";
            reading.refuse(&other, text);
        }
    }
    let Some(items) = reading.items(&entry).filter(|items| items.len() > 1 && items[0].value.is_array())
    else {
        reading.refuse(&entry, ALLOWED);
        return None;
    };
    let points: Vec<_> = items.iter().map(|item| point(reading, item, dimension)).collect();
    points.into_iter().collect::<Option<Vec<_>>>().filter(|_| alone)
}

fn point(reading: &mut Reading, entry: &Entry, dimension: Dimension) -> Option<ForcePoint> {
    let Some([e, f]) = reading.items(entry).and_then(|pair| <[Entry; 2]>::try_from(pair).ok()) else {
        reading.refuse(entry, ALLOWED);
        return None;
    };
    let e = reading.number(&e, kinds::POINT, dimension);
    let f = reading.number(&f, kinds::POINT_FORCE, dimension);
    Some(ForcePoint { e: e?, f: f? })
}
