//! Comparison of the best designs of a search by longer measurements, and the verdict on the best.

use crate::attractors::attractors;
use crate::candidate::Signed;
use crate::descent::refined;
use crate::evaluation::{Control, Evaluation, Evaluator, Value, is_near};
use crate::outcome::{Best, Check, Designed, Rival, Verdict};
use crate::request::Limit;
use rayon::prelude::*;
use vibro_studies::design_sweep::{Designs, SearchedRow, SweepRequest, choice, row, searched};
use vibro_studies::parts::{PartStore, Task};
use vibro_studies::{Error, Machine, Result};

/// Distance in the unit box beyond which designs count as different basins, and as rivals.
pub(crate) const APART: f64 = 0.08;
/// Assumed bound on how far a peak between two values of a band, missed by the search, exceeds the
/// goal; relative to the goal.
const BETWEEN: f64 = 0.01;
/// Relative tolerance for equal values: rounding.
const SAME: f64 = 1e-9;
/// Largest number of compared designs.
const RIVALS: usize = 8;
/// Distance to the end of a range, in the unit box, that counts as being at it.
const AT_END: f64 = 1e-6;
/// Number of Sobol points inside the tolerances for measuring the best design.
const INSIDE: u32 = 32;

/// Asks whether a choice between designs should continue.
struct Wanted<'a>(&'a Control<'a>);

impl PartStore for Wanted<'_> {
    fn load(&self, _: usize) -> Option<Vec<u8>> {
        None
    }

    fn save(&self, _: usize, _: &[u8]) -> Result<()> {
        Ok(())
    }

    fn go_on(&self) -> Result<()> {
        if (self.0.go_on)() { Ok(()) } else { Err(Error::store(std::io::Error::other("ended by hand"))) }
    }
}

/// A design in the comparison.
struct Contender {
    own: Evaluation,
    /// Whether its peaks over the band are exact peaks of orbits; also true without a band.
    has_peaks: bool,
    /// Number of returns of its longest window.
    periods: u32,
}

impl Contender {
    /// The goal, signed, with its error bar: value, lower end, upper end. Without exact peaks, the
    /// upper end includes the excess that may be missed between the values of a band.
    fn bar(&self, signed: &Signed) -> Option<(f64, f64, f64)> {
        let goal = self.own.goal?;
        let ends = [goal.bar.0, goal.bar.1].map(|x| signed.sign() * x);
        let unseen = if self.has_peaks { 0.0 } else { BETWEEN * goal.value.abs() };
        let value = signed.sign() * goal.value;
        Some((value, ends[0].min(ends[1]), ends[0].max(ends[1]) + unseen))
    }

    /// The goal with the error bar of [`bar`](Self::bar).
    fn goal(&self, signed: &Signed) -> Option<Value> {
        let (_, lower, upper) = self.bar(signed)?;
        let ends = [lower, upper].map(|x| signed.sign() * x);
        Some(Value { bar: (ends[0].min(ends[1]), ends[0].max(ends[1])), ..self.own.goal? })
    }

    /// Whether this design is worse than another one, beyond the error bars.
    fn is_worse(&self, other: &Self, signed: &Signed) -> bool {
        let (Some(own), Some(other)) = (self.bar(signed), other.bar(signed)) else { return false };
        own.1 > other.2 && own.0 - other.0 > SAME * other.0.abs()
    }
}

/// A design with the exact peaks of its band.
fn with_peaks(evaluator: &Evaluator, own: &Evaluation) -> Contender {
    let periods = evaluator.sweep.periods;
    if evaluator.sweep.between.is_empty() {
        return Contender { own: own.clone(), has_peaks: true, periods };
    }
    let row = searched(&evaluator.candidate, &evaluator.sweep, own.values.clone());
    match refined(evaluator, &(own.clone(), row)) {
        Some((own, _)) => Contender { own, has_peaks: true, periods },
        None => Contender { own: own.clone(), has_peaks: false, periods },
    }
}

/// The designs to compare, best first: the best ones that are apart from each other and meet the
/// limits, or only the best one if it does not meet them. `found` are the results of descents.
fn contenders(evaluator: &Evaluator, found: &[Evaluation]) -> Vec<Contender> {
    let mut tops = evaluator.apart(APART, RIVALS);
    tops.extend(found.iter().cloned());
    let mut all: Vec<Contender> = tops.par_iter().map(|own| with_peaks(evaluator, own)).collect();
    all.sort_by(|a, b| a.own.score.order(&b.own.score));
    let mut kept: Vec<Contender> = Vec::new();
    for contender in all {
        let unit = evaluator.unit(&contender.own.values);
        let is_beside = |other: &Contender| is_near(&evaluator.unit(&other.own.values), &unit, APART);
        if kept.len() < RIVALS && !kept.iter().any(is_beside) {
            kept.push(contender);
        }
    }
    match kept.first().is_some_and(|own| own.own.is_feasible()) {
        true => kept.retain(|own| own.own.is_feasible()),
        false => kept.truncate(1),
    }
    kept
}

/// Compares the best designs by longer measurements; searches for other motions of the best.
pub(crate) fn finish(evaluator: &Evaluator, orbits: usize, found: &[Evaluation]) -> Result<Designed> {
    let stopped = || !(evaluator.control.go_on)();
    let mut designed = Designed {
        verdict: Verdict::Undecided("ended by hand".into()),
        best: None,
        rivals: Vec::new(),
        evaluations: evaluator.all(),
        orbits,
        has_gradients: false,
    };
    if stopped() {
        let best = found.iter().chain(&evaluator.ranked()).min_by(|a, b| a.score.order(&b.score)).cloned();
        designed.best = best.and_then(|own| {
            best_of(evaluator, &Contender { own, has_peaks: false, periods: evaluator.sweep.periods })
        });
        return Ok(designed);
    }
    let mut all = contenders(evaluator, found);
    if all.is_empty() {
        let reason = designed.evaluations.iter().find_map(|own| own.reason.clone());
        let why = format!("no design has a value; the first reason: {}", reason.unwrap_or_default());
        designed.verdict = Verdict::NoneFound(why);
        return Ok(designed);
    }
    let left = longer(evaluator, &mut all);
    all.sort_by(|a, b| a.own.score.order(&b.own.score));
    let signed = &evaluator.sweep.measures[0];
    let (first, others) = all.split_at(1);
    let rival = |other: &Contender| {
        let is_told_apart = other.is_worse(&first[0], signed);
        Some(Rival { values: other.own.values.clone(), goal: other.goal(signed)?, is_told_apart })
    };
    designed.rivals = others.iter().filter_map(rival).collect();
    designed.has_gradients = found.iter().any(|own| own.values == first[0].own.values);
    let Some(mut best) = best_of(evaluator, &first[0]) else { return Ok(designed) };
    inside_tolerances(evaluator, &mut best);
    if let Some(machine) = at_worst(evaluator, &best.values) {
        best.attractors = attractors(evaluator, &machine, best.goal);
    }
    if let (false, Some(left)) = (stopped(), left) {
        designed.verdict = verdict(evaluator, &best, &designed.rivals, left);
    }
    designed.best = Some(best);
    Ok(designed)
}

/// Extends the measurements of contenders that may be the best and whose motions do not repeat.
/// Returns how many could be extended further, or `None` if the search was cancelled.
fn longer(evaluator: &Evaluator, all: &mut [Contender]) -> Option<usize> {
    let is_known = |own: &Contender| own.has_peaks && own.own.goal.is_some_and(|goal| goal.is_exact);
    if all.iter().all(is_known) {
        return Some(0);
    }
    let rows: Vec<Vec<f64>> = all.iter().map(|own| own.own.values.clone()).collect();
    let designs = Designs::Rows { names: evaluator.request.names(), rows };
    let sweep = SweepRequest { designs, ..evaluator.sweep.clone() };
    let wanted = Wanted(evaluator.control);
    let task = Task { store: &wanted, ..Task::ALL };
    let chosen = choice(&evaluator.candidate, &sweep, &task).ok()?;
    let Some(chosen) = chosen else { return Some(0) };
    for (index, contender) in all.iter_mut().enumerate() {
        let Some(row) = chosen.rows.get(&index) else { continue };
        contender.periods = row.again.as_ref().map_or(sweep.periods, |again| again.periods);
        if contender.own.goal.is_some_and(|goal| goal.is_exact) {
            continue;
        }
        let parts = (&evaluator.candidate, &evaluator.sweep);
        let mut found = Evaluation::of(evaluator.request, parts, (row, contender.own.stage));
        // For limits, only the search looked between the values of a band; so keep its value where
        // it is worse.
        for ((found, before), signed) in
            found.limits.iter_mut().zip(&contender.own.limits).zip(&sweep.measures[1..])
        {
            *found = worse(signed, *found, *before);
        }
        contender.own = found;
    }
    Some(chosen.left)
}

/// The worse of two values of a measure.
fn worse(signed: &Signed, a: Option<Value>, b: Option<Value>) -> Option<Value> {
    let (a, b) = (a?, b?);
    Some(if signed.sign() * b.value > signed.sign() * a.value { b } else { a })
}

/// Whether a limit is met.
fn check(limit: &Limit, signed: &Signed, value: Option<Value>) -> Check {
    let Some(value) = value else { return Check::Undecided };
    let most = signed.sign() * limit.value;
    let ends = [value.bar.0, value.bar.1].map(|x| signed.sign() * x);
    match (ends[0].max(ends[1]) <= most, ends[0].min(ends[1]) > most) {
        (true, _) => Check::Met,
        (_, true) => Check::NotMet,
        _ => Check::Undecided,
    }
}

/// The best design without its attractors; `None` if it has no value.
fn best_of(evaluator: &Evaluator, contender: &Contender) -> Option<Best> {
    let own = contender.own.clone();
    let unit = evaluator.unit(&own.values);
    let names = evaluator.request.names().into_iter().zip(unit);
    let at_ends = names.filter(|(_, u)| *u < AT_END || *u > 1.0 - AT_END).map(|(name, _)| name);
    let checks = evaluator.request.limits.iter().zip(&evaluator.sweep.measures[1..]).zip(&own.limits);
    Some(Best {
        at_ends: at_ends.collect(),
        goal: contender.goal(&evaluator.sweep.measures[0])?,
        limits: checks.map(|((limit, signed), value)| (*value, check(limit, signed, *value))).collect(),
        values: own.values,
        place: own.place,
        periods: contender.periods,
        reason: own.reason,
        attractors: Vec::new(),
    })
}

/// Measures the best design inside its tolerances as well, and keeps values worse than at the
/// corners.
fn inside_tolerances(evaluator: &Evaluator, best: &mut Best) {
    let request = evaluator.request;
    if request.robust == 0.0 {
        return;
    }
    let candidate = evaluator.candidate.inside(request.robust, INSIDE);
    let names = request.names();
    let mut sweep = request.sweep(&candidate);
    sweep.designs = Designs::Rows { names, rows: vec![best.values.clone()] };
    let found = row(&candidate, &sweep, 0);
    for (k, signed) in sweep.measures.iter().enumerate() {
        let inside = found.outputs[k].map(|own| (own.at, Value::of(&own, signed)));
        match (k, inside) {
            (0, Some((at, value))) if signed.sign() * (value.value - best.goal.value) > 0.0 => {
                best.goal = value;
                best.place = sweep.place_in_words(&candidate, found.motion(&sweep, at));
            }
            (0, _) => {}
            (k, inside) => {
                let own = worse(signed, best.limits[k - 1].0, inside.map(|own| own.1));
                best.limits[k - 1] = (own, check(&request.limits[k - 1], signed, own));
            }
        }
    }
    best.reason = best.reason.take().or(found.reason);
}

/// The machine of a design at the place of its worst motion.
fn at_worst(evaluator: &Evaluator, values: &[f64]) -> Option<Machine> {
    let SearchedRow { row, .. } = searched(&evaluator.candidate, &evaluator.sweep, values.to_vec());
    let (place, _) = row.motion(&evaluator.sweep, row.outputs[0]?.at);
    evaluator.machine(values, &place)
}

/// The verdict on the best design.
fn verdict(evaluator: &Evaluator, best: &Best, rivals: &[Rival], left: usize) -> Verdict {
    let limited = || evaluator.request.limits.iter().zip(&best.limits);
    let of = |check: Check| -> Vec<String> {
        limited().filter(|own| own.1.1 == check).map(|own| own.0.measure.to_string()).collect()
    };
    let missed = of(Check::NotMet);
    if !missed.is_empty() {
        let why = format!(
            "no design meets the limits; the nearest design violates the limit of {}",
            missed.join(", ")
        );
        return Verdict::NoneFound(why);
    }
    let mut open: Vec<String> = Vec::new();
    let near = rivals.iter().filter(|own| !own.is_told_apart).count();
    if near > 0 {
        open.push(format!("{} designs may be the best within their error bars", near + 1));
    }
    if left > 0 {
        open.push(format!("{left} of the compared designs could be measured longer"));
    }
    open.extend(
        of(Check::Undecided).iter().map(|name| format!("the limit of {name} is within the error bar")),
    );
    open.extend(best.reason.clone());
    if open.is_empty() { Verdict::Decided } else { Verdict::Undecided(open.join("; ")) }
}
