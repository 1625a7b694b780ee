//! Fits by segments that begin in the states which the record shows: the way to motions with many
//! impacts from numbers that are far off. Short segments are nearly linear in the numbers, whatever
//! the whole motion does.
//!
//! The start of each segment is free, and each pass binds it more closely to the end of the segment
//! before it. During these passes a Huber loss limits large residuals (P. Huber, Robust
//! Statistics, 1981), because a segment with an impact too many does not determine the numbers.

use super::evaluated::{Evaluated, Point, Reach, Segment, Solved};
use super::horizons::LEAST_ROWS;
use super::loss::Loss;
use super::model::Model;
use super::segments::{CONTINUOUS, DEFECTS, misses};
use super::solver::{Bounds, Convergence, solve};
use crate::error::Result;

/// Standard deviations of what starts miss of the ends before them, in parts of the states' sizes,
/// during a pass with the shortest segments; a pass with longer ones has the last alone.
const LOOSE: [f64; 2] = [0.1, 1e-2];
/// Length of the segments of the first pass and of the last one, over the length that has as many
/// rows as there are numbers and states.
const SHORTEST: f64 = 3.0;
const LONGEST: f64 = 6.0;
/// Factors of the length from one pass to the next: where hardly a segment stands out, and where
/// more do.
const LONGER_BY: f64 = 2.0;
const SHORTER_BY: f64 = 0.7;
/// Most passes.
const PASSES: u32 = 8;
/// Mean square of a segment's residuals over that of the median one, above which it stands out: of
/// some twenty residuals that are noise it is within 1 ± 1.4 nearly always.
const STANDS_OUT: f64 = 3.0;
/// Part of the segments that may stand out: longer ones begin elsewhere.
const STAND_OUT: f64 = 0.05;
/// Part of a length by which passes differ, so that their segments begin elsewhere.
const ELSEWHERE: f64 = 0.15;
/// As [`LOOSE`], after the last pass. A segment that stands out then continues the one before it.
const CLOSER: [f64; 4] = [1e-2, 3e-3, 1e-3, 3e-4];
/// Segments of a pass, at least.
const FEWEST: f64 = 4.0;
/// Miss of a start, in standard deviations, above which the start is given up, and the number of
/// times that starts are given up at one standard deviation.
const APART: f64 = 20.0;
const GIVEN_UP: u32 = 3;

/// The numbers reached from a start by segments that begin in the states which the record shows.
/// Short segments come first, whose residuals are nearly linear in the numbers. Where they leave
/// noise alone, longer ones follow; else new ones from the numbers so far.
pub(super) fn over_recorded(
    model: &Model,
    bounds: &Bounds,
    start: &[f64],
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Solved> {
    let (first, end) = (model.first(), model.end());
    let bounds = &bounds.inside(start);
    // A segment that has an impact too many says nothing of the numbers.
    let mut robust = model.clone();
    robust.loss = Loss::Huber;
    let mut values = start.to_vec();
    let mut factor = SHORTEST;
    let mut left = PASSES;
    let rows = (LEAST_ROWS * start.len() + model.sizes_of_states(&values)?.len()) as f64;
    let least = (end - first) * rows / model.rows() as f64;
    loop {
        let sizes = model.sizes_of_states(&values)?;
        let shift = 1.0 + ELSEWHERE * f64::from(left % 3);
        let length = (factor * shift * least).min((end - first) / FEWEST);
        let (nodes, mut point) = model.by_record(&values, length, &sizes)?;
        let mut reach = Reach { nodes, ..Reach::whole(end) };
        for defect in LOOSE.into_iter().skip(usize::from(factor > SHORTEST)) {
            reach.weights = weights(&sizes, defect);
            point = solve(&robust, bounds, &point, (&reach, Convergence::Rough), go_on)?.point;
        }
        left -= 1;
        let out = stand_out(&model.evaluate(&point, &reach)?).len();
        let is_noise = out <= 1.max((STAND_OUT * reach.nodes.len() as f64) as usize);
        if left == 0 || is_noise && factor >= LONGEST || !go_on() {
            for defect in CLOSER {
                reach.weights = weights(&sizes, defect);
                point = solve(&robust, bounds, &point, (&reach, Convergence::Rough), go_on)?.point;
                let out = stand_out(&model.evaluate(&point, &reach)?);
                give_up(&mut point, &mut reach, |k| out.contains(&(k + 1)));
            }
            return joined(model, bounds, point, reach, &sizes, go_on);
        }
        values = point.values;
        factor = (factor * if is_noise { LONGER_BY } else { SHORTER_BY }).max(SHORTEST);
    }
}

/// How much misses of the next starts count, by the number of the state.
fn weights(sizes: &[f64], defect: f64) -> Vec<f64> {
    sizes.iter().map(|size| 1.0 / (defect * size)).collect()
}

/// The segments whose residuals stand out, as those do of one with an impact too many.
fn stand_out(at: &Evaluated) -> Vec<usize> {
    let mean = |own: &Segment| {
        let rows = &own.rows.residuals;
        rows.iter().map(|r| r * r).sum::<f64>() / rows.len().max(1) as f64
    };
    let all: Vec<f64> = at.0.iter().map(mean).collect();
    let mut sorted = all.clone();
    sorted.sort_by(f64::total_cmp);
    let limit = STANDS_OUT * sorted[all.len() / 2].max(1.0);
    (0..all.len()).filter(|&k| all[k] > limit).collect()
}

/// Gives up starts of segments: these go on from the segments before.
fn give_up(point: &mut Point, reach: &mut Reach, is_given_up: impl Fn(usize) -> bool) {
    let kept: Vec<bool> = (0..reach.nodes.len()).map(|k| !is_given_up(k)).collect();
    let mut all = kept.iter();
    reach.nodes.retain(|_| *all.next().unwrap_or(&true));
    let mut all = kept.iter();
    point.states.retain(|_| *all.next().unwrap_or(&true));
}

/// The point reached where segments are bound to each other ever more closely. A start that stays
/// apart from the end before it is given up: it is beside an impact that only one of the two has.
fn joined(
    model: &Model,
    bounds: &Bounds,
    mut point: Point,
    mut reach: Reach,
    sizes: &[f64],
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Solved> {
    for (k, defect) in DEFECTS[2..].iter().enumerate() {
        reach.weights = weights(sizes, *defect);
        let is_last = k + 3 == DEFECTS.len();
        let convergence = if is_last { Convergence::Whole } else { Convergence::Rough };
        for _ in 0..GIVEN_UP {
            point = solve(model, bounds, &point, (&reach, convergence), go_on)?.point;
            let misses = misses(model, (&point, &reach), sizes)?;
            let limit = (APART * defect).max(CONTINUOUS);
            if misses.iter().all(|miss| *miss < limit) {
                break;
            }
            give_up(&mut point, &mut reach, |k| misses[k] >= limit);
        }
    }
    let is_continuous = misses(model, (&point, &reach), sizes)?.iter().all(|miss| *miss < CONTINUOUS);
    Ok(Solved { point, reach, cost: f64::INFINITY, is_continuous })
}
