//! Measures of settled motions over any number of parameters: a row for each design.
//!
//! A design is one combination of values of the parameters that vary: a point of a grid, an entry
//! of a list, or a point of a Sobol sequence. It is measured by one motion or by several: from
//! several starts, and at several values of parameters that the designer cannot choose, such as
//! the drive's frequency in a band. Over several motions each measure has its smallest, mean and
//! largest value. A design that does not make a machine, or whose motion the simulator refuses,
//! does not end the sweep: its row states why it has no values.
//!
//! ```
//! use vibro_studies::design_sweep::{Designs, SampledAxis, SweepRequest, row};
//! use vibro_studies::paper::{Name, ParameterSet};
//!
//! let axis = SampledAxis { name: Name::find("f10")?, values: vec![1.5, 2.0] };
//! let request = SweepRequest {
//!     designs: Designs::Grid(vec![axis]),
//!     measures: vec!["amplitude.x1".parse()?],
//!     ..SweepRequest::default()
//! };
//! let second = row(&ParameterSet::basic(), &request, 1);
//! assert_eq!((second.values, second.reason), (vec![2.0], None));
//! assert!(second.outputs[0].unwrap().largest > 0.3);
//! # Ok::<(), vibro_studies::Error>(())
//! ```

mod between;
mod choice;
mod designs;
mod row;
mod searched;

pub use choice::{Choice, choice, each_final_row};
pub use designs::{Designs, ParameterInterval, SampledAxis};
pub use row::{Again, BARS, DesignRow, Summary};
pub use searched::{SearchedRow, searched};

use crate::axis::AxisName;
use crate::error::{Error, Result};
use crate::measured::Measured;
use crate::parts::Task;
use rayon::prelude::*;
use row::summary;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt::{Debug, Display};

/// Largest number of designs.
pub const MOST_DESIGNS: usize = 1_000_000;
/// Largest number of motions of one design.
pub const MOST_MOTIONS: usize = 100_000;
/// Plain data that a manifest can hold: a machine's parameters, starts and measures.
pub trait Plain: Clone + PartialEq + Debug + Serialize + DeserializeOwned + Send + Sync {}

impl<T: Clone + PartialEq + Debug + Serialize + DeserializeOwned + Send + Sync> Plain for T {}

/// A machine whose designs are measured: the 3-DOF machine as a
/// [`ParameterSet`](crate::paper::ParameterSet), or a [described one](crate::Machine). Designs,
/// parts, rows and choices are common to both.
pub trait DesignMachine: Clone + Send + Sync {
    /// Name of a parameter.
    type Name: Plain + AxisName;
    /// Start of a motion.
    type Start: Plain + Default + Display;
    /// Quantity to measure.
    type Measure: Plain + Display;
    /// Number of motions in a part, rounded to whole designs: about a second's work.
    const PART: usize;
    /// Default number of periods of motion that a [`choice`] may spend: some seconds' work.
    const AGAIN: u64;

    /// A parameter's name in tables.
    fn name(name: &Self::Name) -> String;
    /// Whether two names denote the same quantity.
    fn is_same_quantity(a: &Self::Name, b: &Self::Name) -> bool;
    /// A parameter's value with its unit of display.
    fn with_unit(&self, name: &Self::Name, value: f64) -> String;
    /// The machine with other values, SI.
    ///
    /// # Errors
    /// Error for values that do not describe a valid machine.
    fn varied(&self, values: &[(Self::Name, f64)]) -> Result<Self>;
    /// Measures of the motions of one machine from all starts of a request.
    fn outcomes(&self, request: &SweepRequest<Self>) -> Vec<MotionMeasures>;
    /// Evenly spread starts: at least `count`, or all starts of a machine that has fewer.
    fn spread_starts(count: u32) -> Vec<Self::Start>;
    /// Whether a measure is taken from the window of a motion, so that a longer window gives a
    /// better value. False for the class, the exponent and closed forms.
    fn is_of_window(measure: &Self::Measure) -> bool;
    /// Values of a frequency parameter at which the machine may resonate.
    fn resonances(&self, name: &Self::Name) -> Vec<f64>;
}

/// Request of a design sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(bound = "")]
pub struct SweepRequest<M: DesignMachine> {
    /// The designs.
    pub designs: Designs<M::Name>,
    /// Parameters over which each design's motions are summarized, the last one varying fastest.
    pub over: Vec<SampledAxis<M::Name>>,
    /// Starts of the motions of each design.
    pub starts: Vec<M::Start>,
    /// Drive periods discarded before a motion is measured.
    pub discard: u32,
    /// Drive periods over which a motion is measured.
    pub periods: u32,
    /// Measures.
    pub measures: Vec<M::Measure>,
    /// Parameters of [`over`](Self::over) whose values sample an interval. Designs that may be the
    /// best are also measured between these values.
    pub between: Vec<M::Name>,
    /// Periods of motion that [`choice`] may spend on repeated measurements of designs that may be
    /// the best.
    pub again: u64,
}

impl<M: DesignMachine> Default for SweepRequest<M> {
    /// A request for one motion of the unchanged machine, without measures.
    fn default() -> Self {
        let starts = vec![M::Start::default()];
        let (designs, over, measures) = (Designs::Grid(Vec::new()), Vec::new(), Vec::new());
        Self {
            designs,
            over,
            starts,
            discard: 400,
            periods: 60,
            measures,
            between: Vec::new(),
            again: M::AGAIN,
        }
    }
}

impl<M: DesignMachine> SweepRequest<M> {
    /// Checks the properties on which every row depends.
    ///
    /// # Errors
    /// [`Error::Form`] for two names of one quantity, lists without values, no measures or
    /// periods, and too many designs or motions.
    pub fn check(&self) -> Result<()> {
        let refused = |text: String, expected| Err(Error::Form { text, expected });
        let names: Vec<M::Name> =
            self.designs.names().into_iter().chain(self.over.iter().map(|a| a.name.clone())).collect();
        for (i, name) in names.iter().enumerate() {
            if let Some(other) = names[..i].iter().find(|other| M::is_same_quantity(other, name)) {
                let (a, b) = (M::name(other), M::name(name));
                let problem = match a == b {
                    true => format!("{a}: is varied twice; vary each parameter once"),
                    false => format!("{a} and {b}: determine the same quantity; vary one of them"),
                };
                return Err(Error::Described { problem });
            }
        }
        let (designs, motions) = (self.designs.count(), self.motions());
        if !(1..=MOST_DESIGNS).contains(&designs) {
            return refused(
                format!("{designs} designs"),
                "1 to 1000000 designs: reduce the counts, or use --sobol",
            );
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

    /// Number of motions of each design.
    pub fn motions(&self) -> usize {
        let over = self.over.iter().map(|a| a.values.len());
        over.fold(self.starts.len(), usize::saturating_mul)
    }

    /// Values of [`over`](Self::over) and the start that distinguish a motion of a design.
    pub fn motion(&self, index: usize) -> (Vec<f64>, M::Start) {
        let starts = self.starts.len().max(1);
        let start = self.starts.get(index % starts).cloned().unwrap_or_default();
        (designs::combination(&self.over, index / starts), start)
    }

    /// Description of a motion, such as `drive.frequency = 10 Hz, start v2=1`: in the units in
    /// which the machine was written, without values common to all motions.
    pub fn motion_in_words(&self, set: &M, index: usize) -> String {
        let (values, start) = self.motion(index);
        self.place_in_words(set, (values, start))
    }

    /// Description of values of [`over`](Self::over) and a start, as
    /// [`motion_in_words`](Self::motion_in_words).
    pub fn place_in_words(&self, set: &M, (values, start): (Vec<f64>, M::Start)) -> String {
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
pub fn part<M: DesignMachine>(set: &M, request: &SweepRequest<M>, index: usize) -> Vec<DesignRow> {
    let size = request.part_size();
    let until = ((index + 1) * size).min(request.designs.count());
    (index * size..until).into_par_iter().map(|design| row(set, request, design)).collect()
}

/// Computes, on all threads, the parts that are missing in the task's store, and stores them.
/// Returns whether all are stored. The rows depend neither on threads nor on shards.
///
/// # Errors
/// As [`SweepRequest::check`]; errors of the store.
pub fn fill<M: DesignMachine>(set: &M, request: &SweepRequest<M>, task: &Task) -> Result<bool> {
    request.check()?;
    task.fill(request.count(), |index| Ok(part(set, request, index)))
}

/// Calls `visit` with each row in order, from parts that [`fill`] has stored.
///
/// # Errors
/// Errors of `visit` and of the store.
pub fn each_row<M: DesignMachine, E: From<Error>>(
    set: &M,
    request: &SweepRequest<M>,
    task: &Task,
    mut visit: impl FnMut(DesignRow) -> std::result::Result<(), E>,
) -> std::result::Result<(), E> {
    for index in 0..request.count() {
        let rows = task.part(index, |index| Ok(part(set, request, index)))?;
        rows.into_iter().flatten().try_for_each(&mut visit)?;
    }
    Ok(())
}

/// The row of one design.
pub fn row<M: DesignMachine>(set: &M, request: &SweepRequest<M>, index: usize) -> DesignRow {
    let values = request.designs.values(index);
    match design(set, request, &values) {
        Ok(own) => summary(set, values, request, &motions(&own, request, &request.places()), None),
        Err(error) => {
            let (outputs, reason) = (vec![None; request.measures.len()], Some(error.to_string()));
            DesignRow { values, outputs, classes: Vec::new(), reason, again: None }
        }
    }
}

/// The machine of a design.
fn design<M: DesignMachine>(set: &M, request: &SweepRequest<M>, values: &[f64]) -> Result<M> {
    let assigned = request.designs.names().into_iter().zip(values.iter().copied());
    set.varied(&assigned.collect::<Vec<_>>())
}

/// Measures of one motion, and an objection to them, if any.
pub type MotionMeasures = (Measured, Option<String>);

/// Measures of a design's motions at some values of [`SweepRequest::over`], from all starts for
/// each.
fn motions<M: DesignMachine>(set: &M, request: &SweepRequest<M>, places: &[Vec<f64>]) -> Vec<MotionMeasures> {
    let mut found = Vec::with_capacity(places.len() * request.starts.len());
    for values in places {
        let names = request.over.iter().map(|a| a.name.clone());
        let assigned: Vec<_> = names.zip(values.iter().copied()).collect();
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

/// Measures of a motion that could not be computed: no numbers, and the error as the objection.
pub(crate) fn failed(error: &Error, measures: usize) -> MotionMeasures {
    let nothing =
        Measured { numbers: vec![None; measures], spreads: vec![0.0; measures], ..Measured::default() };
    (nothing, Some(error.to_string()))
}

/// Largest number of starts added to search for other motions of a design.
pub const MORE_STARTS: u32 = 8;

impl<M: DesignMachine> SweepRequest<M> {
    /// A request for one design and one measure from more starts; `None` if the machine has no
    /// more.
    pub fn from_more_starts(&self, design: Vec<f64>, measure: M::Measure) -> Option<Self> {
        let mut starts = self.starts.clone();
        for start in M::spread_starts(self.starts.len() as u32 + MORE_STARTS) {
            if starts.len() < self.starts.len() + MORE_STARTS as usize && !starts.contains(&start) {
                starts.push(start);
            }
        }
        let designs = Designs::Rows { names: self.designs.names(), rows: vec![design] };
        let is_more = starts.len() > self.starts.len();
        is_more.then(|| Self { designs, starts, measures: vec![measure], ..self.clone() })
    }

    /// All combinations of the values of [`over`](Self::over).
    fn places(&self) -> Vec<Vec<f64>> {
        let count = self.motions() / self.starts.len().max(1);
        (0..count).map(|index| designs::combination(&self.over, index)).collect()
    }
}

/// The rows of all designs of a small request, on all threads.
///
/// The peak of an oscillator at k = mω² has the amplitude F/(cω):
///
/// ```
/// use vibro_studies::Machine;
/// use vibro_studies::design_sweep::{Designs, SampledAxis, SweepRequest, rows};
///
/// # let text = r#"
/// #     name = "Shaken"
/// #     body.a = { mass = 1.0 }
/// #     spring.k = { between = ["ground", "a"], stiffness = 4.0, damping = 1.25 }
/// #     load.f = { on = "a", amplitude = 26.0, frequency = "4 rad/s" }
/// # "#;
/// let machine = Machine::parse(text, "shaken.toml", &vibro_machine::file::no_records)?;
/// let axis = SampledAxis { name: "spring.k.stiffness".to_owned(), values: vec![4.0, 16.0] };
/// let (designs, measures) = (Designs::Grid(vec![axis]), vec!["amplitude.a.s".parse()?]);
/// let found = rows(&machine, &SweepRequest { designs, measures, ..SweepRequest::default() });
/// let amplitude = |design: usize| found[design].outputs[0].unwrap().largest;
/// // A motion counts as settled when its returns differ by less than 1e-9.
/// assert!((amplitude(0) - 2.0).abs() < 1e-8 && (amplitude(1) - 26.0 / 5.0).abs() < 1e-8);
/// # Ok::<(), vibro_studies::Error>(())
/// ```
pub fn rows<M: DesignMachine>(set: &M, request: &SweepRequest<M>) -> Vec<DesignRow> {
    (0..request.designs.count()).into_par_iter().map(|design| row(set, request, design)).collect()
}

#[cfg(test)]
mod tests;
