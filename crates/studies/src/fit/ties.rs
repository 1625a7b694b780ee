//! Segments tied into one motion. Each initial state is free, and its tie to the end of the
//! previous segment tightens until only rounding is left.

use super::bounds::Bounds;
use super::evaluated::{Point, Reach, Solved};
use super::model::Model;
use super::segments::{CONTINUOUS, DEFECTS, misses};
use super::solver::{Convergence, solve};
use crate::error::Result;

/// Defect, in standard deviations, at which a segment's start is removed; and the number of rounds
/// of removal at one standard deviation.
const APART: f64 = 20.0;
const GIVEN_UP: u32 = 3;
/// Standard deviation of the defects, relative to the states, at which removal begins.
const GIVES_UP: f64 = 3e-4;

/// Result of tying segments that begin near the motion. A start with a large defect is removed: it
/// is next to an impact that only one of the two segments has. In a chaotic motion all starts are
/// kept, and tying ends at a large defect.
pub(super) fn tied(
    model: &Model,
    bounds: &Bounds,
    ((nodes, mut point), is_chaotic): ((Vec<f64>, Point), bool),
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Solved> {
    let sizes = model.sizes_of_states(&point.values)?;
    let mut reach = Reach { nodes, ..Reach::whole(model.end()) };
    let mut is_continuous = false;
    for (k, defect) in DEFECTS.into_iter().enumerate() {
        let before = (point.clone(), reach.clone());
        reach.weights = sizes.iter().map(|size| 1.0 / (defect * size)).collect();
        let is_last = k + 1 == DEFECTS.len();
        let convergence = if is_last { Convergence::Whole } else { Convergence::Rough };
        let limit = (APART * defect).max(CONTINUOUS);
        let mut all = Vec::new();
        for _ in 0..GIVEN_UP {
            point = solve(model, bounds, &point, (&reach, convergence), go_on)?.point;
            all = misses(model, (&point, &reach), &sizes)?;
            if is_chaotic || defect > GIVES_UP || all.iter().all(|miss| *miss < limit) {
                break;
            }
            give_up(&mut point, &mut reach, |k| all[k] >= limit);
        }
        is_continuous = all.iter().all(|miss| *miss < CONTINUOUS);
        if is_chaotic && k > 0 && all.iter().any(|miss| *miss >= limit) {
            (point, reach) = before;
            is_continuous = false;
            break;
        }
    }
    Ok(Solved { point, reach, cost: f64::INFINITY, is_continuous })
}

/// Removes starts of segments, which then continue the previous segments.
pub(super) fn give_up(point: &mut Point, reach: &mut Reach, mut is_given_up: impl FnMut(usize) -> bool) {
    let kept: Vec<bool> = (0..reach.nodes.len()).map(|k| !is_given_up(k)).collect();
    let mut all = kept.iter();
    reach.nodes.retain(|_| *all.next().unwrap_or(&true));
    let mut all = kept.iter();
    point.states.retain(|_| *all.next().unwrap_or(&true));
}
