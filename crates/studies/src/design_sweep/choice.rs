//! Choice of the design with the smallest value of the first measure.
//!
//! Every number of a sweep has an error bar: two spreads up and down, which are zero if the motion
//! repeats. The value of a design is the largest value of its motions. Its error bar reaches from
//! the largest of their lower ends to the largest of their upper ends. All designs that may be the
//! best within their error bars are measured again. Each measurement is four times as long as its
//! predecessor. It also covers values between the given values of the parameters over which the
//! designs are summarized. All motions of a design are measured equally long, except motions that
//! repeat: a chaotic motion below the largest may exceed it in a longer window.
//!
//! The choice ends when none of these designs can be measured more accurately, or when a given
//! number of periods is spent. The rows of the choice then replace the sweep's rows everywhere.

use super::between::{BandMotions, MOST, search_between};
use super::row::{BARS, upper};
use super::{Again, DesignMachine, DesignRow, Summary, SweepRequest, design, part, summary};
use crate::error::{Error, Result};
use crate::parts::{Shard, Task};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use vibro_numerics::sorting::sort_by;

/// Ratio of the lengths of successive measurements.
const LONGER: u32 = 4;
/// Largest number of repeated measurements of a design.
const ROUNDS: u32 = 3;
/// Cap on the designs in one parallel measurement.
const TOGETHER: usize = 16;
/// Relative tolerance of equal values.
const SAME: f64 = 1e-9;

/// Result of the repeated measurements.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// Index of the measure that is compared: the first one taken from the window.
    pub measure: usize,
    /// Rows of the remeasured designs, by design index.
    pub rows: BTreeMap<usize, DesignRow>,
    /// Designs that may have the smallest value, in ascending order of value. A single one is the
    /// best beyond its error bar.
    pub possible: Vec<usize>,
    /// Number of designs left undecided: each may have the smallest value, but all periods were
    /// spent.
    pub left: usize,
    /// Periods of motion spent.
    pub spent: u64,
}

impl Choice {
    /// Whether a single design is the best, and all possible measurements were made.
    pub fn is_decided(&self) -> bool {
        self.possible.len() == 1 && self.left == 0
    }
}

/// Estimate of a design's value.
#[derive(Clone, Copy, Debug)]
struct Estimate {
    value: f64,
    /// Ends of the error bar.
    lower: f64,
    upper: f64,
    /// Whether all motions repeat.
    is_exact: bool,
    /// Whether the search between values is complete.
    is_searched: bool,
    /// Number of repeated measurements.
    rounds: u32,
}

impl Estimate {
    fn of(found: Summary, rounds: u32, is_searched: bool) -> Self {
        let upper = upper((found.largest, found.spread));
        let Summary { largest: value, lower, is_exact, .. } = found;
        Self { value, lower, upper, is_exact, is_searched, rounds }
    }

    /// Whether the value may be smaller than the value of another design.
    fn may_be_less(&self, other: &Self) -> bool {
        let bar = (self.value - self.lower).hypot(other.upper - other.value);
        let bar = if self.is_exact && other.is_exact { 0.0 } else { bar };
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
    /// Motions of remeasured designs that may be the best.
    motions: BTreeMap<usize, BandMotions>,
    found: Choice,
}

/// Repeated measurement of a design.
struct Remeasured {
    row: DesignRow,
    motions: BandMotions,
    /// Whether the search between values is complete.
    is_searched: bool,
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
        known.reduce(|a, b| if b.upper < a.upper { b } else { a })
    }

    /// Designs that may have the smallest value, in ascending order of value.
    fn possible(&self) -> Vec<usize> {
        let Some(surest) = self.surest() else { return Vec::new() };
        let known = |i: usize| Some((i, self.estimates[i]?));
        let all = (0..self.estimates.len()).filter_map(known);
        let mut found: Vec<(usize, Estimate)> = all.filter(|(_, own)| own.may_be_less(&surest)).collect();
        sort_by(&mut found, |a, b| a.1.value.total_cmp(&b.1.value).then(a.0.cmp(&b.0)));
        found.into_iter().map(|(i, _)| i).collect()
    }

    /// Number of periods of the next measurement of a design; as in the sweep if its motions
    /// repeat.
    fn periods(&self, index: usize) -> u32 {
        let rounds = self.estimates[index].filter(|own| !own.is_exact).map_or(0, |own| own.rounds + 1);
        self.request.periods.saturating_mul(LONGER.pow(rounds.min(ROUNDS)))
    }

    /// Upper bound of the periods in a design's next measurement.
    fn cost(&self, index: usize) -> u64 {
        let known = self.motions.get(&index);
        let between = known.map_or(0, |known| known.places.len() - self.request.places().len());
        let most = if has_intervals(self.request) { MOST * self.request.between.len() } else { 0 };
        let further = most.saturating_sub(between) * self.request.starts.len();
        let motions = known.map_or(self.request.motions(), BandMotions::open) + further;
        self.periods_of(motions, self.periods(index))
    }

    /// Number of periods of some motions, each measured over a window.
    fn periods_of(&self, motions: usize, window: u32) -> u64 {
        motions as u64 * (u64::from(self.request.discard) + u64::from(window))
    }

    /// A design's row in the sweep.
    fn row(&self, index: usize) -> Result<DesignRow> {
        let size = self.request.part_size();
        let quiet = Task { shard: Shard::ALL, done: &|_| (), ..*self.task };
        let rows = quiet.part(index / size, |i| Ok(part(self.set, self.request, i)))?;
        let found = rows.and_then(|rows| rows.into_iter().nth(index % size));
        found.ok_or_else(|| Error::Form { text: index.to_string(), expected: "a design of the sweep" })
    }

    /// Measures a design again. The search between values stops when the measure certainly exceeds
    /// `enough`.
    fn measured(&self, index: usize, enough: f64) -> Result<Remeasured> {
        let mut row = self.row(index)?;
        let periods = self.periods(index);
        let own = design(self.set, self.request, &row.values)?;
        let places_of_windows: Vec<usize> =
            (0..row.outputs.len()).filter(|&m| M::is_of_window(&self.request.measures[m])).collect();
        let measures = places_of_windows.iter().map(|&m| self.request.measures[m].clone()).collect();
        let request = SweepRequest { periods, measures, ..self.request.clone() };
        let measure = places_of_windows.iter().position(|&m| m == self.measure).unwrap_or(0);
        let asked = self.request.places();
        let count = asked.len();
        let mut looked = match self.motions.get(&index) {
            Some(known) => known.over(&own, &request),
            None => BandMotions::new(&own, &request, asked),
        };
        let is_searched = search_between(&own, &request, (measure, enough), &mut looked);
        let again = Again { periods, between: looked.places[count..].to_vec() };
        let found = summary(self.set, row.values.clone(), &request, &looked.outcomes, Some(again));
        for (output, &place) in found.outputs.iter().zip(&places_of_windows) {
            row.outputs[place] = *output;
        }
        if let Some(output) = row.outputs[self.measure].as_mut().filter(|_| looked.unseen > 0.0) {
            (output.spread, output.is_exact) = (output.spread.max(looked.unseen / BARS), false);
        }
        row.reason = row.reason.or(found.reason);
        row.again = found.again;
        Ok(Remeasured { row, motions: looked, is_searched })
    }

    /// Measures again, a few designs at a time, until none is open or all periods are spent.
    fn run(mut self) -> Result<Choice> {
        loop {
            let possible = self.possible();
            self.motions.retain(|i, _| possible.contains(i));
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
            let enough = self.surest().map_or(f64::INFINITY, |surest| surest.upper);
            let found: Vec<_> = next.par_iter().map(|&i| self.measured(i, enough)).collect::<Result<_>>()?;
            for (index, Remeasured { row, motions, is_searched }) in next.into_iter().zip(found) {
                let rounds = self.estimates[index].map_or(0, |own| own.rounds + 1);
                let window = row.again.as_ref().map_or(0, |again| again.periods);
                self.found.spent += self.periods_of(motions.computed, window);
                self.estimates[index] =
                    row.outputs[self.measure].map(|s| Estimate::of(s, rounds, is_searched));
                self.found.rows.insert(index, row);
                self.motions.insert(index, motions);
            }
        }
    }
}

/// Whether a request has intervals to search.
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
        Race { set, request, task, measure, estimates, motions: BTreeMap::new(), found }.run()
    })
}

/// Calls `visit` with each row in order; a row of the choice replaces the row of the sweep.
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
