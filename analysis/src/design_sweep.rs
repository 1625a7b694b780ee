//! Measures of settled motions over any number of parameters: a row for each design.
//!
//! A design is one combination of values of the parameters that vary: of a grid, of a list, or a point of a Sobol sequence. It
//! is judged by one motion, or by several: from several starts, and over parameters that are not the designer's to choose,
//! such as the drive's frequency in a band. Of several, each measure has its least, mean and largest value. A design that makes
//! no machine, and a motion that the simulator refuses, end nothing: the row says why it has no values.
//!
//! ```
//! use vibro_analysis::design_sweep::{Designs, Request, SampledAxis, row};
//! use vibro_analysis::{Name, ParameterSet};
//!
//! let axis = SampledAxis { name: Name::find("f10")?, values: vec![1.5, 2.0] };
//! let request = Request {
//!     designs: Designs::Grid(vec![axis]),
//!     measures: vec!["amplitude.x1".parse()?],
//!     ..Request::default()
//! };
//! let second = row(&ParameterSet::basic(), &request, 1);
//! assert_eq!((second.values, second.reason), (vec![2.0], None));
//! assert!(second.outputs[0].unwrap().largest > 0.3);
//! # Ok::<(), vibro_analysis::Error>(())
//! ```

mod designs;
mod three_dof;

pub use designs::{Designs, ParameterInterval, SampledAxis, spread_starts};

use crate::attractor::MotionClass;
use crate::error::{Error, Result};
use crate::measures::Measured;
use crate::parameter_set::ParameterSet;
use crate::parts::Task;
use crate::plane::AxisName;
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt::{Debug, Display};

/// Most designs.
pub const MOST_DESIGNS: usize = 1_000_000;
/// Most motions of one design.
pub const MOST_MOTIONS: usize = 100_000;

/// What a machine's parameters, starts and measures are for a sweep: plain data that a manifest holds.
pub trait Plain: Clone + PartialEq + Debug + Serialize + DeserializeOwned + Send + Sync {}

impl<T: Clone + PartialEq + Debug + Serialize + DeserializeOwned + Send + Sync> Plain for T {}

/// A machine of which designs are measured: the 3-DOF machine by a [`ParameterSet`], or a
/// [described one](crate::assembly::Machine). Designs, parts, rows and what is made of them are the same for both.
pub trait Machine: Clone + Send + Sync {
    /// A parameter.
    type Name: Plain + AxisName;
    /// Where a motion starts.
    type Start: Plain + Default + Display;
    /// What is measured.
    type Measure: Plain + Display;
    /// Motions in a part, as near as whole designs come to it: about a second's work.
    const PART: usize;

    /// A parameter's name in tables.
    fn name(name: &Self::Name) -> String;
    /// Whether two names are one quantity.
    fn is_same_quantity(a: &Self::Name, b: &Self::Name) -> bool;
    /// A value of a parameter with the unit in which it is shown.
    fn with_unit(&self, name: &Self::Name, value: f64) -> String;
    /// The machine with other values, SI.
    ///
    /// # Errors
    /// Values that make no machine.
    fn varied(&self, values: &[(Self::Name, f64)]) -> Result<Self>;
    /// The motions of one machine from all starts of a request, measured.
    fn outcomes(&self, request: &Request<Self>) -> Vec<Outcome>;
    /// At least as many starts, spread evenly; fewer where the machine has no more.
    fn spread_starts(count: u32) -> Vec<Self::Start>;
}

/// What to compute.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct Request<M: Machine = ParameterSet> {
    /// The designs.
    pub designs: Designs<M::Name>,
    /// Parameters over which the motions of each design are taken together, the last one varying fastest.
    pub over: Vec<SampledAxis<M::Name>>,
    /// Where the motions start, each from every one of these.
    pub starts: Vec<M::Start>,
    /// Drive periods discarded before a motion is measured.
    pub discard: u32,
    /// Drive periods over which it is measured.
    pub periods: u32,
    /// What is measured.
    pub measures: Vec<M::Measure>,
}

impl<M: Machine> Default for Request<M> {
    /// One motion of the one design that is the machine itself, without measures.
    fn default() -> Self {
        let starts = vec![M::Start::default()];
        let (designs, over, measures) = (Designs::Grid(Vec::new()), Vec::new(), Vec::new());
        Self { designs, over, starts, discard: 400, periods: 60, measures }
    }
}

/// A measure over the motions of a design.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// The least.
    pub least: f64,
    /// The mean of all motions.
    pub mean: f64,
    /// The largest.
    pub largest: f64,
    /// The first motion that has the largest, for [`Request::motion`].
    pub at: usize,
    /// How much the largest would scatter from one window of the motion to the next: [`Measured::spreads`].
    pub spread: f64,
}

/// What was found of one design.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// Values of the parameters that vary, in their order, SI.
    pub values: Vec<f64>,
    /// For each measure what the motions make together; `None` for the class, and where a motion has no value.
    pub outputs: Vec<Option<Summary>>,
    /// The different classes in the order in which they are met, where the class was asked for and every motion has one.
    pub classes: Vec<MotionClass>,
    /// Why there are values missing.
    pub reason: Option<String>,
}

impl<M: Machine> Request<M> {
    /// Checks what every row depends on.
    ///
    /// # Errors
    /// [`Error::Form`] for parameters that are one quantity, lists without values, too many designs or motions.
    pub fn check(&self) -> Result<()> {
        let refused = |text: String, expected| Err(Error::Form { text, expected });
        let names: Vec<M::Name> =
            self.designs.names().into_iter().chain(self.over.iter().map(|a| a.name.clone())).collect();
        for (i, name) in names.iter().enumerate() {
            if let Some(other) = names[..i].iter().find(|other| M::is_same_quantity(other, name)) {
                let text = format!("{}, {}", M::name(other), M::name(name));
                return refused(text, "parameters that vary independently, each once");
            }
        }
        let (designs, motions) = (self.designs.count(), self.motions());
        if !(1..=MOST_DESIGNS).contains(&designs) {
            return refused(format!("{designs} designs"), "1 to 1000000 designs");
        }
        if !(1..=MOST_MOTIONS).contains(&motions) {
            return refused(
                format!("{motions} motions of each design"),
                "1 to 100000 motions of each design",
            );
        }
        if self.measures.is_empty() || self.periods == 0 {
            return refused(
                format!("{} outputs", self.measures.len()),
                "an output and a drive period at least",
            );
        }
        Ok(())
    }

    /// Motions of each design.
    pub fn motions(&self) -> usize {
        let over = self.over.iter().map(|a| a.values.len());
        over.fold(self.starts.len(), usize::saturating_mul)
    }

    /// What tells a motion of a design from the others: the values of [`over`](Self::over) and the start.
    pub fn motion(&self, index: usize) -> (Vec<f64>, M::Start) {
        let starts = self.starts.len().max(1);
        let start = self.starts.get(index % starts).cloned().unwrap_or_default();
        (designs::combination(&self.over, index / starts), start)
    }

    /// A motion in words: `drive.frequency = 10 Hz, start v2=1`, in the units in which the machine was written, without what all
    /// motions have in common.
    pub fn motion_in_words(&self, set: &M, index: usize) -> String {
        let (values, start) = self.motion(index);
        let told = |(axis, value): (&SampledAxis<M::Name>, f64)| {
            format!("{} = {}", M::name(&axis.name), set.with_unit(&axis.name, value))
        };
        let mut words: Vec<String> = self.over.iter().zip(values).map(told).collect();
        if self.starts.len() > 1 {
            words.push(format!("start {start}"));
        }
        words.join(", ")
    }

    /// Designs in a part.
    fn part_size(&self) -> usize {
        (M::PART / self.motions().max(1)).max(1)
    }

    /// Number of parts.
    pub fn count(&self) -> usize {
        self.designs.count().div_ceil(self.part_size())
    }
}

/// The rows of a part, on all threads.
pub fn part<M: Machine>(set: &M, request: &Request<M>, index: usize) -> Vec<Row> {
    let size = request.part_size();
    let until = ((index + 1) * size).min(request.designs.count());
    (index * size..until).into_par_iter().map(|design| row(set, request, design)).collect()
}

/// Computes the parts that are not in the task's store, on all threads, and leaves them there; returns whether all are there.
/// The rows depend neither on threads nor on shards.
///
/// # Errors
/// As [`Request::check`]; what the store refuses.
pub fn fill<M: Machine>(set: &M, request: &Request<M>, task: &Task) -> Result<bool> {
    request.check()?;
    task.fill(request.count(), |index| Ok(part(set, request, index)))
}

/// Calls `visit` with each row in order, of parts that [`fill`] has left in the task's store.
///
/// # Errors
/// What `visit` returns; what the store refuses.
pub fn each_row<M: Machine, E: From<Error>>(
    set: &M,
    request: &Request<M>,
    task: &Task,
    mut visit: impl FnMut(Row) -> std::result::Result<(), E>,
) -> std::result::Result<(), E> {
    for index in 0..request.count() {
        let rows = task.part(index, |index| Ok(part(set, request, index)))?;
        rows.into_iter().flatten().try_for_each(&mut visit)?;
    }
    Ok(())
}

/// One design.
pub fn row<M: Machine>(set: &M, request: &Request<M>, index: usize) -> Row {
    let values = request.designs.values(index);
    let assigned = request.designs.names().into_iter().zip(values.iter().copied());
    let count = request.measures.len();
    match set.varied(&assigned.collect::<Vec<_>>()) {
        Ok(own) => summary(set, values, request, &motions(&own, request)),
        Err(error) => {
            let reason = Some(error.to_string());
            Row { values, outputs: vec![None; count], classes: Vec::new(), reason }
        }
    }
}

/// What was measured of one motion, and what there was against it.
pub type Outcome = (Measured, Option<String>);

/// All motions of a design.
fn motions<M: Machine>(set: &M, request: &Request<M>) -> Vec<Outcome> {
    let mut found = Vec::with_capacity(request.motions());
    for index in 0..request.motions() / request.starts.len() {
        let values = designs::combination(&request.over, index);
        let assigned: Vec<_> = request.over.iter().map(|a| a.name.clone()).zip(values).collect();
        match set.varied(&assigned) {
            Ok(own) => found.extend(own.outcomes(request)),
            Err(error) => {
                let failed = failed(&error, request.measures.len());
                found.extend(vec![failed; request.starts.len()]);
            }
        }
    }
    found
}

/// A motion that there is not.
pub(crate) fn failed(error: &Error, measures: usize) -> Outcome {
    let nothing = Measured { numbers: vec![None; measures], class: None, spreads: vec![0.0; measures] };
    (nothing, Some(error.to_string()))
}

/// The row of all motions of a design.
fn summary<M: Machine>(set: &M, values: Vec<f64>, request: &Request<M>, motions: &[Outcome]) -> Row {
    let outputs = (0..request.measures.len())
        .map(|m| {
            let one = |(found, _): &Outcome| {
                Some((found.numbers.get(m).copied().flatten()?, found.spreads.get(m).copied().unwrap_or(0.0)))
            };
            together(motions.iter().map(one))
        })
        .collect();
    let mut classes: Vec<MotionClass> = Vec::new();
    if motions.iter().all(|(found, _)| found.class.is_some()) {
        for class in motions.iter().filter_map(|(found, _)| found.class) {
            if !classes.contains(&class) {
                classes.push(class);
            }
        }
    }
    let bad: Vec<(usize, &String)> =
        motions.iter().enumerate().filter_map(|(i, (_, reason))| Some((i, reason.as_ref()?))).collect();
    let reason =
        bad.first().map(|(index, reason)| match (motions.len(), request.motion_in_words(set, *index)) {
            (1, _) => (*reason).clone(),
            (all, words) => format!("{} of {all} motions, the first at {words}: {reason}", bad.len()),
        });
    Row { values, outputs, classes, reason }
}

/// Least, mean and largest of numbers, all of which must be there, with their spreads.
fn together(numbers: impl Iterator<Item = Option<(f64, f64)>>) -> Option<Summary> {
    let (numbers, spreads): (Vec<f64>, Vec<f64>) =
        numbers.collect::<Option<Vec<(f64, f64)>>>()?.into_iter().unzip();
    let at = (1..numbers.len()).fold(0, |best, i| if numbers[i] > numbers[best] { i } else { best });
    let largest = *numbers.get(at)?;
    let least = numbers.iter().copied().fold(largest, f64::min);
    let mean = if least == largest { largest } else { numbers.iter().sum::<f64>() / numbers.len() as f64 };
    Some(Summary { least, mean, largest, at, spread: spreads[at] })
}

/// Starts that are added when designs are measured again.
pub const MORE_STARTS: u32 = 8;
/// How many times as long they are then measured.
pub const LONGER: u32 = 10;

impl<M: Machine> Request<M> {
    /// Some of its designs measured again by one measure, ten times as long and from eight more starts.
    pub fn again(&self, designs: Vec<Vec<f64>>, measure: M::Measure) -> Self {
        let mut starts = self.starts.clone();
        for start in M::spread_starts(self.starts.len() as u32 + MORE_STARTS) {
            if starts.len() < self.starts.len() + MORE_STARTS as usize && !starts.contains(&start) {
                starts.push(start);
            }
        }
        Self {
            designs: Designs::Rows { names: self.designs.names(), rows: designs },
            over: self.over.clone(),
            starts,
            discard: self.discard,
            periods: self.periods.saturating_mul(LONGER),
            measures: vec![measure],
        }
    }
}

/// The rows of all designs of a request that are few, on all threads.
pub fn rows<M: Machine>(set: &M, request: &Request<M>) -> Vec<Row> {
    (0..request.designs.count()).into_par_iter().map(|design| row(set, request, design)).collect()
}

#[cfg(test)]
mod tests;
