//! Segments that become one motion: each start is free, and ties to the ends before the starts grow
//! until they leave rounding alone.

use super::bounds::Bounds;
use super::evaluated::{Point, Reach, Solved};
use super::model::Model;
use super::segments::{CONTINUOUS, DEFECTS, misses};
use super::solver::{Convergence, solve};
use crate::error::Result;

/// Miss of a start, in standard deviations, above which the start is given up, and the number of
/// times that starts are given up at one standard deviation.
const APART: f64 = 20.0;
const GIVEN_UP: u32 = 3;
/// The standard deviation of misses from which on starts are given up.
const GIVES_UP: f64 = 3e-4;

/// The point reached from segments whose starts are near the motion. A start that stays apart from
/// the end before it is given up: it is beside an impact that only one of the two has. The starts of
/// a chaotic motion stay, and the ties end where a start stays apart.
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

/// Gives up starts of segments: these continue the segments before.
fn give_up(point: &mut Point, reach: &mut Reach, is_given_up: impl Fn(usize) -> bool) {
    let kept: Vec<bool> = (0..reach.nodes.len()).map(|k| !is_given_up(k)).collect();
    let mut all = kept.iter();
    reach.nodes.retain(|_| *all.next().unwrap_or(&true));
    let mut all = kept.iter();
    point.states.retain(|_| *all.next().unwrap_or(&true));
}
