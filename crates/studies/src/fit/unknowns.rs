//! The free numbers of a fit: what each is, where it begins, and what it may be.

use super::FitRequest;
use super::filter::{self, Sensor};
use crate::Machine;
use crate::error::{Error, Result};
use std::sync::Arc;
use vibro_machine::derivative::By;
use vibro_machine::{Assembly, Quantity, Start};

/// A positive number's least value, in parts of the value from which the fit begins.
const LEAST: f64 = 1e-6;
/// Prefix of the numbers of a start among names of derivatives.
const OF_START: &str = "start.";

/// What a free number is.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Unknown {
    /// Of the machine or of the start; with the column of its derivatives.
    Number(usize),
    /// Time of the motion at the record's time 0.
    Shift,
    /// What a column shows above the quantity.
    Offset(usize),
}

/// The free numbers in their order.
pub(super) struct Unknowns<'a> {
    pub machine: &'a Machine,
    start: &'a Start,
    all: Vec<Unknown>,
    /// The names of those of the machine and of the start, as columns of derivatives.
    pub names: Vec<&'a str>,
    /// The values from which the fit begins.
    pub begin: Vec<f64>,
    columns: usize,
    sensors: Arc<[Sensor]>,
}

/// What values of the free numbers make.
pub(super) struct Made {
    pub machine: Machine,
    /// The machine's equations, which follow rounded signals as if they were not.
    pub assembly: Arc<Assembly>,
    pub start: Start,
    /// Time of the motion at the record's time 0, s.
    pub shift: f64,
    /// By column what it shows above the quantity.
    pub offsets: Vec<f64>,
}

impl<'a> Unknowns<'a> {
    /// The free numbers of a request. `rates` has the rate of each column's quantity, where a
    /// quantity has one; `sensors` has the filters that the machine carries.
    ///
    /// # Errors
    /// [`Error::Described`] for a column that the record does not have, and for a shift beside a
    /// column without a rate; [`Error::Refusal`] for a name that neither machine nor start has.
    pub fn new(request: &'a FitRequest, rates: &[Option<Quantity>], sensors: Arc<[Sensor]>) -> Result<Self> {
        let FitRequest { machine, start, measured, free, .. } = request;
        let refused = |problem: String| Err(Error::Described { problem });
        let columns: Vec<String> = measured.columns.iter().map(|(name, _)| name.to_string()).collect();
        let (mut all, mut names) = (Vec::new(), Vec::new());
        for own in free {
            all.push(match (own.name.as_str(), own.name.strip_prefix("record.offset.")) {
                ("record.shift", _) => match rates.iter().position(Option::is_none) {
                    None => Unknown::Shift,
                    Some(k) => {
                        let name = &columns[k];
                        return refused(format!(
                            "record.shift beside {name}: allowed are columns s, v of bodies and e of elements"
                        ));
                    }
                },
                (name, Some(column)) => match columns.iter().position(|own| own == column) {
                    Some(place) => Unknown::Offset(place),
                    None => {
                        let known = columns.join(", ");
                        return refused(format!(
                            "{name}: the record has no such column; allowed are {known}"
                        ));
                    }
                },
                (name, None) => {
                    names.push(name);
                    Unknown::Number(names.len() - 1)
                }
            });
        }
        let assembly = Assembly::new(machine.description.clone())?;
        start.columns(&assembly, &names)?;
        let state = start.state(&assembly)?;
        let of_state = Start::names(&assembly);
        let begin = |unknown: &Unknown| match unknown {
            Unknown::Number(k) => machine.description.get(names[*k]).ok().or_else(|| {
                let name = names[*k].strip_prefix(OF_START)?;
                if name == "time" {
                    Some(start.time)
                } else {
                    Some(state[of_state.iter().position(|own| own == name)?])
                }
            }),
            Unknown::Shift | Unknown::Offset(_) => Some(0.0),
        };
        let begin = all.iter().map(|unknown| begin(unknown).unwrap_or(0.0)).collect();
        Ok(Self { machine, start, all, names, begin, columns: columns.len(), sensors })
    }

    /// The name of a free number of the machine or of the start; `None` for a number of the record.
    pub fn name(&self, k: usize) -> Option<&'a str> {
        if let Unknown::Number(place) = self.all[k] { Some(self.names[place]) } else { None }
    }

    /// The values that a free number may have.
    pub fn allowed(&self, k: usize) -> (f64, f64) {
        let any = (f64::MIN, f64::MAX);
        let Some(name) = self.name(k) else { return any };
        let Ok(parameter) = self.machine.description.parameter(name) else { return any };
        let range = parameter.range();
        let low = if range.open_min { range.min + LEAST * parameter.value.abs() } else { range.min };
        (low.max(f64::MIN), range.max.min(f64::MAX))
    }

    /// The machine, its start, the shift and the offsets with some values.
    ///
    /// # Errors
    /// [`Error::Refusal`] for values that are not allowed.
    pub fn with(&self, values: &[f64]) -> Result<Made> {
        let (mut of_machine, mut start) = (Vec::new(), self.start.clone());
        let (mut shift, mut offsets) = (0.0, vec![0.0; self.columns]);
        for (unknown, &value) in self.all.iter().zip(values) {
            match *unknown {
                Unknown::Number(k) => match self.names[k].strip_prefix(OF_START) {
                    Some(name) => start.set(&self.machine.description, name, value)?,
                    None => of_machine.push((self.names[k], value)),
                },
                Unknown::Shift => shift = value,
                Unknown::Offset(k) => offsets[k] = value,
            }
        }
        let mut machine = self.machine.with(of_machine)?;
        filter::begin(&self.sensors, &mut machine, &start)?;
        let assembly = Arc::new(Assembly::new(machine.description.clone())?.varying_rounded());
        Ok(Made { machine, assembly, start, shift, offsets })
    }
}

impl Made {
    /// The columns of derivatives of a segment that begins with the start, or in a state of its own
    /// with a number of numbers.
    ///
    /// # Errors
    /// [`Error::Refusal`] for a name that neither machine nor start has.
    pub fn columns(&self, unknowns: &Unknowns, states: Option<usize>) -> Result<Columns> {
        let named = self.start.columns(&self.assembly, &unknowns.names)?;
        let is_first = states.is_none();
        let (mut by, mut of) = (Vec::new(), Vec::new());
        let mut add = |own: By| {
            by.push(own);
            by.len() - 1
        };
        for unknown in &unknowns.all {
            of.push(match *unknown {
                Unknown::Number(k) => match &named[k] {
                    // A later segment does not begin with the start.
                    By::Start(_) | By::Time if !is_first => Source::None,
                    own => Source::Motion(add(own.clone())),
                },
                Unknown::Shift if is_first => Source::Shift(None),
                Unknown::Shift => Source::Shift(Some(add(By::Time))),
                Unknown::Offset(k) => Source::Offset(k),
            });
        }
        of.extend((0..states.unwrap_or(0)).map(|i| Source::Motion(add(By::Start(i)))));
        Ok(Columns { by, of })
    }
}

/// Whence a derivative comes.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// Of the motion, by one of its columns.
    Motion(usize),
    /// By the shift; by the time of the segment's start too, with its column, where that is
    /// shifted.
    Shift(Option<usize>),
    /// By what a column shows above the quantity.
    Offset(usize),
    /// There is none: it is 0.
    None,
}

/// The columns of derivatives of a motion.
#[derive(Default)]
pub(super) struct Columns {
    pub by: Vec<By>,
    /// By free number, then by number of the segment's first state.
    of: Vec<Source>,
}

impl Columns {
    /// Derivatives by all that is fitted, from those of the motion by its columns, that by the time
    /// of the motion, and the column of an offset.
    pub fn all(
        &self,
        by: &dyn Fn(usize) -> Option<f64>,
        by_time: Option<f64>,
        column: Option<usize>,
    ) -> Vec<Option<f64>> {
        let of = |source: &Source| match *source {
            Source::Motion(k) => by(k),
            Source::Shift(None) => by_time,
            Source::Shift(Some(k)) => Some(by_time? + by(k)?),
            Source::Offset(k) => Some(if Some(k) == column { 1.0 } else { 0.0 }),
            Source::None => Some(0.0),
        };
        self.of.iter().map(of).collect()
    }
}
