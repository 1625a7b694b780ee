//! Which design has the least of the first measure.
//!
//! Every number of a sweep has an error bar: its spread, which is nothing where the motions repeat.
//! All designs that the error bars leave possible as the best are measured again, each time four
//! times as long, and between the values of the parameters over which they are taken together,
//! until one is the best by its error bar, or nothing more would tell them apart, or a stated
//! number of periods is spent. What was found then stands in place of the rows of the sweep, for
//! all that speaks of it.

use super::between::{Looked, MOST, look_between};
use super::{Again, DesignMachine, SweepRequest, DesignRow, Summary, design, motions, part, summary};
use crate::error::{Error, Result};
use crate::parts::{Shard, Task};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// How many times as long a design is measured as the time before.
const LONGER: u32 = 4;
/// How often at most.
const ROUNDS: u32 = 3;
/// Designs that are measured again together.
const TOGETHER: usize = 16;
/// Two values are told apart that differ by as many times their spread.
const APART: f64 = 2.0;
/// Values that differ by less than this part are the same but for rounding.
const SAME: f64 = 1e-9;

/// What was measured again, and which design is the best.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// The first measure that is a number, by its place: the one that counts.
    pub measure: usize,
    /// The rows of designs that were measured again, by the design's number.
    pub rows: BTreeMap<usize, DesignRow>,
    /// The designs that may have the least value, the least first: one where it is the best by its
    /// error bar.
    pub possible: Vec<usize>,
    /// Designs that may have the least value and could still be measured again, for which there
    /// were no periods left.
    pub left: usize,
    /// Periods of motion that were spent.
    pub spent: u64,
}

/// What is known of a design.
#[derive(Clone, Copy, Debug)]
struct Estimate {
    value: f64,
    spread: f64,
    is_exact: bool,
    /// Whether nothing is left to look at between values.
    is_looked: bool,
    /// How often it was measured again.
    rounds: u32,
}

impl Estimate {
    fn of(found: Summary, rounds: u32, is_looked: bool) -> Self {
        Self { value: found.largest, spread: found.spread, is_exact: found.is_exact(), is_looked, rounds }
    }

    /// What no other may pass by more than twice its spread and still be less than this.
    fn most(&self) -> f64 {
        self.value + APART * self.spread
    }

    /// Whether it may be less than another.
    fn may_be_less(&self, other: &Self) -> bool {
        let bar = if self.is_exact && other.is_exact { 0.0 } else { APART * self.spread.hypot(other.spread) };
        self.value - other.value <= bar.max(SAME * other.value.abs())
    }
}

/// A race between the designs of a sweep.
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
        (!own.is_exact && own.rounds < ROUNDS) || !own.is_looked
    }

    /// What has the least value for certain: nothing has a lower upper end of its error bar.
    fn surest(&self) -> Option<Estimate> {
        let known = self.estimates.iter().flatten().copied();
        known.reduce(|a, b| if b.most() < a.most() { b } else { a })
    }

    /// The designs that may have the least value, the least first.
    fn possible(&self) -> Vec<usize> {
        let Some(surest) = self.surest() else { return Vec::new() };
        let known = |i: usize| Some((i, self.estimates[i]?));
        let all = (0..self.estimates.len()).filter_map(known);
        let mut found: Vec<(usize, Estimate)> = all.filter(|(_, own)| own.may_be_less(&surest)).collect();
        found.sort_by(|a, b| a.1.value.total_cmp(&b.1.value).then(a.0.cmp(&b.0)));
        found.into_iter().map(|(i, _)| i).collect()
    }

    /// Periods over which a design is measured next: as before where its motions repeat.
    fn periods(&self, index: usize) -> u32 {
        let rounds = self.estimates[index].filter(|own| !own.is_exact).map_or(0, |own| own.rounds + 1);
        self.request.periods.saturating_mul(LONGER.pow(rounds))
    }

    /// Most periods of motion that this takes.
    fn cost(&self, index: usize) -> u64 {
        let further = if looks_between(self.request) { MOST * self.request.between.len() } else { 0 };
        let motions = self.request.motions() + further * self.request.starts.len();
        motions as u64 * (u64::from(self.request.discard) + u64::from(self.periods(index)))
    }

    /// A row of the sweep.
    fn row(&self, index: usize) -> Result<DesignRow> {
        let size = self.request.part_size();
        let quiet = Task { shard: Shard::ALL, done: &|_| (), ..*self.task };
        let rows = quiet.part(index / size, |i| Ok(part(self.set, self.request, i)))?;
        let found = rows.and_then(|rows| rows.into_iter().nth(index % size));
        found.ok_or_else(|| Error::Form { text: index.to_string(), expected: "a design of the sweep" })
    }

    /// Measures a design again as long as it may be less than `enough`; returns its row, whether
    /// all was looked at, and the periods of motion that it took.
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
        let mut looked = Looked { outcomes: motions(&own, &request, &asked), places: asked };
        let before = looked.places.len();
        if let Some(again) = self.found.rows.get(&index).and_then(|row| row.again.as_ref()) {
            looked.outcomes.extend(motions(&own, &request, &again.between));
            looked.places.extend(again.between.iter().cloned());
        }
        let is_looked = look_between(&own, &request, (measure, enough), &mut looked);
        let cost = looked.outcomes.len() as u64 * (u64::from(request.discard) + u64::from(periods));
        let again = Again { periods, between: looked.places.split_off(before) };
        let mut found = summary(self.set, row.values.clone(), &request, &looked.outcomes, Some(again));
        for (output, &place) in found.outputs.iter().zip(&places_of_windows) {
            row.outputs[place] = *output;
        }
        row.reason = row.reason.or(found.reason.take());
        row.again = found.again;
        Ok((row, is_looked, cost))
    }

    /// Measures again, a few at a time, until nothing is open or nothing more may be spent.
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
            for (index, (row, is_looked, cost)) in next.into_iter().zip(found) {
                let rounds = self.estimates[index].map_or(0, |own| own.rounds + 1);
                self.estimates[index] = row.outputs[self.measure].map(|s| Estimate::of(s, rounds, is_looked));
                self.found.rows.insert(index, row);
                self.found.spent += cost;
            }
        }
    }
}

/// Whether anything between values is to be looked at.
fn looks_between<M: DesignMachine>(request: &SweepRequest<M>) -> bool {
    request.over.iter().any(|axis| axis.values.len() > 1 && request.between.contains(&axis.name))
}

/// The best design of a sweep whose parts are all in the task's store, where the choice is then
/// kept too; `None` where there is nothing to choose: one design, no measure of a window. It
/// depends neither on threads nor on shards.
///
/// # Errors
/// What the store refuses.
pub fn choice<M: DesignMachine>(set: &M, request: &SweepRequest<M>, task: &Task) -> Result<Option<Choice>> {
    let Some(measure) = request.measures.iter().position(M::is_of_window) else { return Ok(None) };
    if request.designs.count() < 2 || request.again == 0 {
        return Ok(None);
    }
    let quiet = Task { shard: Shard::ALL, done: &|_| (), ..*task };
    quiet.part(request.count(), |_| {
        let is_looked = !looks_between(request);
        let mut estimates = Vec::with_capacity(request.designs.count());
        super::each_row(set, request, &quiet, |row| -> Result<()> {
            estimates.push(row.outputs[measure].map(|found| Estimate::of(found, 0, is_looked)));
            Ok(())
        })?;
        let found = Choice { measure, ..Choice::default() };
        Race { set, request, task, measure, estimates, found }.run()
    })
}

/// Calls `visit` with each row in order, that of the choice where a design was measured again.
///
/// # Errors
/// What `visit` returns; what the store refuses.
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
