//! Fits over growing horizons: the horizon grows while the fitted motion is near the record.

use super::bounds::Bounds;
use super::evaluated::{Point, Reach, Solved};
use super::model::Model;
use super::restarts::from_rest;
use super::solver::{Convergence, solve};
use super::{CLOSE, Way};
use crate::error::Result;

/// Largest number of horizons of a fit.
const HORIZONS: u32 = 200;
/// Cap on the growth of a horizon, in contacts, if the record has only contacts.
const MOST_CONTACTS: usize = 10;
/// Smallest number of rows per free parameter in the first horizon.
pub(super) const LEAST_ROWS: usize = 3;

/// Result of growing horizons from an initial point.
pub(super) fn over_horizons(
    model: &Model,
    bounds: &Bounds,
    start: &[f64],
    way: Way,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Solved> {
    let mut point = Point::from(start.to_vec());
    let (first, end) = (model.first(), model.end());
    // The length of a horizon counts from the record's first time.
    let longer = |horizon: f64, factor: f64| first + factor * (horizon - first).max(0.0);
    // Contacts matched in order are near only while none appears or disappears.
    let is_of_contacts = model.is_of_contacts();
    let rows = if is_of_contacts { start.len() + 1 } else { LEAST_ROWS * start.len() };
    let least = model.least_horizon(rows);
    let mut horizon = model.near_until(&point, &[], way).max(least).min(end);
    let mut left = HORIZONS;
    loop {
        model.watch.share((horizon - first) / (end - first).max(f64::MIN_POSITIVE));
        let is_last = horizon >= end || left == 0;
        let convergence = if is_last { Convergence::Whole } else { Convergence::Rough };
        let reach = Reach::whole(if is_last { end } else { horizon });
        let mut found = solve(model, bounds, &point, (&reach, convergence), go_on)?;
        if left == HORIZONS {
            found = from_rest(model, bounds, found, go_on)?;
        }
        if is_last || !go_on() {
            return Ok(Solved { reach: Reach::whole(end), ..found });
        }
        (point, left) = (found.point, left - 1);
        let near = model.near_until(&point, &[], way);
        // Contacts that one horizon could not match are not matched by a longer one.
        if is_of_contacts && near + model.slack() < horizon {
            return Ok(Solved { point, reach: Reach::whole(end), cost: f64::INFINITY, is_continuous: true });
        }
        // Without stops, a motion close to the whole record needs no growing horizons.
        if near >= end && !model.has_stops() && model.is_near(&point.values, CLOSE) {
            horizon = end;
            continue;
        }
        horizon = if is_of_contacts {
            near.clamp(model.next_row(horizon, 1), model.next_row(horizon, MOST_CONTACTS)).min(end)
        } else {
            near.clamp(longer(horizon, way.growth.0), longer(horizon, way.growth.1)).min(end)
        };
    }
}
