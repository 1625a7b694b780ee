//! Choice of the design with the least value of the first measure.
//!
//! Every number of a sweep has an error bar: its spread, which is zero where the motions repeat.
//! All designs that may be the best within their error bars are measured again. Each measurement is
//! four times as long as the one before, and also covers values between those of the parameters
//! over which the designs are summarized. The choice ends when one design is the best beyond its
//! error bar, when none of these designs can be measured more accurately, or when a given number of
//! periods is spent. The rows of the choice then replace those of the sweep everywhere.

use super::between::{BandMotions, MOST, search_between};
use super::{Again, DesignMachine, DesignRow, Summary, SweepRequest, design, motions, part, summary};
use crate::error::{Error, Result};
use crate::parts::{Shard, Task};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Factor by which each measurement is longer than the one before.
const LONGER: u32 = 4;
/// Most repeated measurements of a design.
const ROUNDS: u32 = 3;
/// Number of designs that are measured again in parallel.
const TOGETHER: usize = 16;
/// Least difference of two distinct values, in units of their spread.
const APART: f64 = 2.0;
/// Relative difference of values that is rounding.
const SAME: f64 = 1e-9;

/// Result of measuring again.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// Index of the measure that is compared: the first one that is taken from the window.
    pub measure: usize,
    /// Rows of designs that were measured again, by design index.
    pub rows: BTreeMap<usize, DesignRow>,
    /// Designs that may have the least value, in ascending order of value. If there is only one, it
    /// is the best beyond its error bar.
    pub possible: Vec<usize>,
    /// Number of designs that may have the least value and could be measured again, but for which
    /// no periods were left.
    pub left: usize,
    /// Periods of motion spent.
    pub spent: u64,
}

/// Estimate of a design's value.
#[derive(Clone, Copy, Debug)]
struct Estimate {
    value: f64,
    spread: f64,
    is_exact: bool,
    /// Whether the search between values is complete.
    is_searched: bool,
    /// Number of repeated measurements.
    rounds: u32,
}

impl Estimate {
    fn of(found: Summary, rounds: u32, is_searched: bool) -> Self {
        Self { value: found.largest, spread: found.spread, is_exact: found.is_exact(), is_searched, rounds }
    }

    /// Upper end of the error bar.
    fn most(&self) -> f64 {
        self.value + APART * self.spread
    }

    /// Whether the value may be less than that of another design.
    fn may_be_less(&self, other: &Self) -> bool {
        let bar = if self.is_exact && other.is_exact { 0.0 } else { APART * self.spread.hypot(other.spread) };
        self.value - other.value <= bar.max(SAME * other.value.abs())
    }
}

/// State of the choice between the designs of a sweep.
struct Race<'a, M: DesignMachine> {
    set: &'a M,
    request: &'a SweepRequest<M>,
    task: &'a Task<'a>,
    measure: usize,
    estimates: Vec<Option<Estimate>>,
    found: Choice,
}

impl<M: DesignMachine> Race<'_, M> {
    /// Whether a design can be measured again.
    fn is_open(&self, index: usize) -> bool {
        let Some(own) = self.estimates[index] else { return false };
        (!own.is_exact && own.rounds < ROUNDS) || !own.is_searched
    }

    /// The estimate whose error bar has the lowest upper end.
    fn surest(&self) -> Option<Estimate> {
        let known = self.estimates.iter().flatten().copied();
        known.reduce(|a, b| if b.most() < a.most() { b } else { a })
    }

    /// Designs that may have the least value, in ascending order of value.
    fn possible(&self) -> Vec<usize> {
        let Some(surest) = self.surest() else { return Vec::new() };
        let known = |i: usize| Some((i, self.estimates[i]?));
        let all = (0..self.estimates.len()).filter_map(known);
        let mut found: Vec<(usize, Estimate)> = all.filter(|(_, own)| own.may_be_less(&surest)).collect();
        found.sort_by(|a, b| a.1.value.total_cmp(&b.1.value).then(a.0.cmp(&b.0)));
        found.into_iter().map(|(i, _)| i).collect()
    }

    /// Periods of the next measurement of a design; unchanged where its motions repeat.
    fn periods(&self, index: usize) -> u32 {
        let rounds = self.estimates[index].filter(|own| !own.is_exact).map_or(0, |own| own.rounds + 1);
        self.request.periods.saturating_mul(LONGER.pow(rounds))
    }

    /// Most periods of motion that the next measurement may take.
    fn cost(&self, index: usize) -> u64 {
        let further = if has_intervals(self.request) { MOST * self.request.between.len() } else { 0 };
        let motions = self.request.motions() + further * self.request.starts.len();
        motions as u64 * (u64::from(self.request.discard) + u64::from(self.periods(index)))
    }

    /// A design's row in the sweep.
    fn row(&self, index: usize) -> Result<DesignRow> {
        let size = self.request.part_size();
        let quiet = Task { shard: Shard::ALL, done: &|_| (), ..*self.task };
        let rows = quiet.part(index / size, |i| Ok(part(self.set, self.request, i)))?;
        let found = rows.and_then(|rows| rows.into_iter().nth(index % size));
        found.ok_or_else(|| Error::Form { text: index.to_string(), expected: "a design of the sweep" })
    }

    /// Measures a design again; the search between values stops when the measure certainly exceeds
    /// `enough`. Returns the design's row, whether the search between values is complete, and the
    /// periods of motion spent.
    fn measured(&self, index: usize, enough: f64) -> Result<(DesignRow, bool, u64)> {
        let mut row = self.row(index)?;
        let periods = self.periods(index);
        let own = design(self.set, self.request, &row.values)?;
        let places_of_windows: Vec<usize> =
            (0..row.outputs.len()).filter(|&m| M::is_of_window(&self.request.measures[m])).collect();
        let measures = places_of_windows.iter().map(|&m| self.request.measures[m].clone()).collect();
        let request = SweepRequest { periods, measures, ..self.request.clone() };
        let measure = places_of_windows.iter().position(|&m| m == self.measure).unwrap_or(0);
        let asked = self.request.places();
        let mut looked = BandMotions { outcomes: motions(&own, &request, &asked), places: asked };
        let before = looked.places.len();
        if let Some(again) = self.found.rows.get(&index).and_then(|row| row.again.as_ref()) {
            looked.outcomes.extend(motions(&own, &request, &again.between));
            looked.places.extend(again.between.iter().cloned());
        }
        let is_searched = search_between(&own, &request, (measure, enough), &mut looked);
        let cost = looked.outcomes.len() as u64 * (u64::from(request.discard) + u64::from(periods));
        let again = Again { periods, between: looked.places.split_off(before) };
        let mut found = summary(self.set, row.values.clone(), &request, &looked.outcomes, Some(again));
        for (output, &place) in found.outputs.iter().zip(&places_of_windows) {
            row.outputs[place] = *output;
        }
        row.reason = row.reason.or(found.reason.take());
        row.again = found.again;
        Ok((row, is_searched, cost))
    }

    /// Measures again, a few designs at a time, until none is open or no more periods may be spent.
    fn run(mut self) -> Result<Choice> {
        loop {
            let possible = self.possible();
            let open: Vec<usize> = possible.iter().copied().filter(|&i| self.is_open(i)).collect();
            let mut spent = self.found.spent;
            let affordable = |i: &usize| {
                spent = spent.saturating_add(self.cost(*i));
                spent <= self.request.again
            };
            let next: Vec<usize> = open.iter().copied().take(TOGETHER).take_while(affordable).collect();
            if next.is_empty() {
                self.found.left = open.len();
                self.found.possible = possible;
                return Ok(self.found);
            }
            self.task.store.go_on()?;
            let enough = self.surest().map_or(f64::INFINITY, |surest| surest.most());
            let found: Vec<_> = next.par_iter().map(|&i| self.measured(i, enough)).collect::<Result<_>>()?;
            for (index, (row, is_searched, cost)) in next.into_iter().zip(found) {
                let rounds = self.estimates[index].map_or(0, |own| own.rounds + 1);
                self.estimates[index] =
                    row.outputs[self.measure].map(|s| Estimate::of(s, rounds, is_searched));
                self.found.rows.insert(index, row);
                self.found.spent += cost;
            }
        }
    }
}

/// Whether a request has values to search between.
fn has_intervals<M: DesignMachine>(request: &SweepRequest<M>) -> bool {
    request.over.iter().any(|axis| axis.values.len() > 1 && request.between.contains(&axis.name))
}

/// Chooses the best design of a sweep and stores the choice in the task's store, which must hold
/// all parts of the sweep. `None` if there is nothing to choose: a single design, no measure of a
/// window, or no periods to spend. The choice depends neither on threads nor on shards.
///
/// # Errors
/// Errors of the store.
pub fn choice<M: DesignMachine>(set: &M, request: &SweepRequest<M>, task: &Task) -> Result<Option<Choice>> {
    let Some(measure) = request.measures.iter().position(M::is_of_window) else { return Ok(None) };
    if request.designs.count() < 2 || request.again == 0 {
        return Ok(None);
    }
    let quiet = Task { shard: Shard::ALL, done: &|_| (), ..*task };
    quiet.part(request.count(), |_| {
        let is_searched = !has_intervals(request);
        let mut estimates = Vec::with_capacity(request.designs.count());
        super::each_row(set, request, &quiet, |row| -> Result<()> {
            estimates.push(row.outputs[measure].map(|found| Estimate::of(found, 0, is_searched)));
            Ok(())
        })?;
        let found = Choice { measure, ..Choice::default() };
        Race { set, request, task, measure, estimates, found }.run()
    })
}

/// Calls `visit` with each row in order, replaced by that of the choice where there is one.
///
/// # Errors
/// Errors of `visit` and of the store.
pub fn each_final_row<M: DesignMachine, E: From<Error>>(
    set: &M,
    request: &SweepRequest<M>,
    (task, choice): (&Task, Option<&Choice>),
    mut visit: impl FnMut(DesignRow) -> std::result::Result<(), E>,
) -> std::result::Result<(), E> {
    let mut index = 0;
    super::each_row(set, request, task, |row| {
        let own = choice.and_then(|choice| choice.rows.get(&index)).cloned();
        index += 1;
        visit(own.unwrap_or(row))
    })
}
