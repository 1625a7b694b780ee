//! Stiffness that steps in time (docs/assembly-law.md (A16)): its levels, and the signal of time
//! that counts the current level.
//!
//! Each step has a level, and one level precedes the first step. A held record has one level for
//! each of its values. The number of levels therefore does not depend on heights and times, and
//! each level has a derivative.

use crate::description::{Description, Record, Signal, Step};

/// Fraction of the largest stiffness below which a level is rounding and counts as 0.
const ZERO: f64 = 1e-12;

/// Largest number of levels of a stiffness; each level is a part of its element.
pub(crate) const MOST_LEVELS: usize = 64;

/// The distinct values of a record in their order, without its scale.
fn values(record: &Record) -> Vec<f64> {
    let mut all: Vec<f64> = record.knots.iter().map(|knot| knot.1).collect();
    all.sort_by(f64::total_cmp);
    all.dedup();
    all
}

/// The number of levels.
pub(crate) fn count(signal: &Signal) -> usize {
    signal.table.as_ref().map_or(signal.steps.len() + 1, |record| values(record).len())
}

/// Stiffness of each level, as the signal gives it.
pub(crate) fn given(signal: &Signal) -> Vec<f64> {
    if let Some(record) = &signal.table {
        return values(record).iter().map(|value| signal.constant + record.factor() * value).collect();
    }
    let mut sum = signal.constant;
    let after = signal.steps.iter().map(|step| {
        sum += step.height;
        sum
    });
    let after: Vec<f64> = after.collect();
    std::iter::once(signal.constant).chain(after).collect()
}

/// Stiffness of each level, at least 0.
pub(crate) fn levels(signal: &Signal) -> Vec<f64> {
    let all = given(signal);
    let zero = zero(&all);
    all.into_iter().map(|k| if k < zero { 0.0 } else { k }).collect()
}

/// Magnitude below which a level counts as 0.
pub(crate) fn zero(levels: &[f64]) -> f64 {
    ZERO * levels.iter().fold(0.0, |most, k| k.abs().max(most))
}

/// Derivative of each level's stiffness, if the signal's numbers have the derivatives `along`.
pub(crate) fn along(signal: &Signal, along: &Signal) -> Vec<f64> {
    let Some(record) = &signal.table else { return given(along) };
    let scale = along.table.as_ref().and_then(|along| along.scale).unwrap_or(0.0);
    values(record).iter().map(|value| along.constant + scale * value).collect()
}

/// The signal whose value is the index of the current level. Its steps have the times of the
/// stiffness's steps.
pub(crate) fn counter(signal: &Signal) -> Signal {
    let up = |step: &Step| Step { height: 1.0, ..*step };
    let table = signal.table.as_ref().map(|record| {
        let all = values(record);
        let place = |value: f64| all.partition_point(|own| own.total_cmp(&value).is_lt()) as f64;
        let knots = record.knots.iter().map(|&(time, value)| (time, place(value)));
        Record { knots: knots.collect(), scale: None, interpolation: record.interpolation }
    });
    let steps = if table.is_some() { Vec::new() } else { signal.steps.iter().map(up).collect() };
    Signal { steps, table, repeat: signal.repeat, ..Signal::default() }
}

/// The [`counter`] of a stiffness whose numbers have the derivatives `along`: only its times vary.
pub(crate) fn counter_along(signal: &Signal, along: &Signal) -> Signal {
    let mut counter = counter(signal);
    for (step, by) in counter.steps.iter_mut().zip(&along.steps) {
        *step = Step { time: by.time, height: 0.0 };
    }
    counter
}

/// The stepped stiffnesses of a machine: first of stops, then of springs.
pub(crate) fn all(d: &Description) -> impl Iterator<Item = &Signal> {
    let stops = d.stops.iter().filter_map(|stop| stop.stepped.as_ref());
    stops.chain(d.springs.iter().filter_map(|spring| spring.stepped.as_ref()))
}

/// Number of parts of the law for levels, in addition to the stops of the sections: one for each
/// level of a spring, and one for each level of a stop except its first.
pub(crate) fn further(d: &Description) -> usize {
    let stops = d.stops.iter().filter_map(|stop| stop.stepped.as_ref());
    let springs = d.springs.iter().filter_map(|spring| spring.stepped.as_ref());
    stops.map(|signal| count(signal).saturating_sub(1)).chain(springs.map(count)).sum()
}
