//! Free parameters of a fit: kind, initial value and range of each.

use super::FitRequest;
use super::filter::{self, Sensor};
use crate::Machine;
use crate::error::{Error, Result};
use std::sync::Arc;
use vibro_machine::derivative::By;
use vibro_machine::{Assembly, Quantity, Start};

/// Lower bound of a positive parameter, relative to its initial value.
const LEAST: f64 = 1e-6;
/// Prefix of start parameters in the names of derivatives.
const OF_START: &str = "start.";

/// Kind of a free parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Unknown {
    /// Parameter of the machine or of the start, with its column of derivatives.
    Number(usize),
    /// Time of the motion at the record's time 0.
    Shift,
    /// Offset of a record's column: its value minus the quantity.
    Offset(usize),
}

/// Free parameters in the given order.
pub(super) struct Unknowns<'a> {
    pub machine: &'a Machine,
    start: &'a Start,
    all: Vec<Unknown>,
    /// Names of the parameters of machine and start, which have columns of derivatives.
    pub names: Vec<&'a str>,
    /// Columns of derivatives by these parameters, for a motion from the start.
    by: Vec<By>,
    /// Initial values of the fit.
    pub begin: Vec<f64>,
    columns: usize,
    sensors: Arc<[Sensor]>,
}

/// Machine, start and record offsets for given parameter values.
pub(super) struct Made {
    pub machine: Machine,
    /// Equations of the machine, where rounded signals vary smoothly.
    pub assembly: Arc<Assembly>,
    pub start: Start,
    /// Time of the motion at the record's time 0, s.
    pub shift: f64,
    /// Offset of each column.
    pub offsets: Vec<f64>,
}

impl<'a> Unknowns<'a> {
    /// Free parameters of a request. `rates` has the rate of each column's quantity, if it has
    /// one; `sensors` has the filters in the machine.
    ///
    /// # Errors
    /// [`Error::Described`] for a column missing from the record, and for a shift with a column
    /// without a rate; [`Error::Refusal`] for a name that neither machine nor start has.
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
                            "record.shift cannot be combined with {name}: use columns s or v of \
                             bodies, or e of elements"
                        ));
                    }
                },
                (name, Some(column)) => match columns.iter().position(|own| own == column) {
                    Some(place) => Unknown::Offset(place),
                    None => {
                        let known = columns.join(", ");
                        return refused(format!(
                            "{name}: the record has no such column; expected one of {known}"
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
        let (by, columns) = (Vec::new(), columns.len());
        let mut found = Self { machine, start, all, names, by, begin, columns, sensors };
        // Free start values make the start another one than the machine's own.
        let made = found.with(&found.begin)?;
        found.by = made.start.columns(&made.assembly, &found.names)?;
        Ok(found)
    }

    /// Name of a parameter of machine or start; `None` for a parameter of the record.
    pub fn name(&self, k: usize) -> Option<&'a str> {
        if let Unknown::Number(place) = self.all[k] { Some(self.names[place]) } else { None }
    }

    /// Range of a free parameter.
    pub fn allowed(&self, k: usize) -> (f64, f64) {
        let any = (f64::MIN, f64::MAX);
        let Some(name) = self.name(k) else { return any };
        let Ok(parameter) = self.machine.description.parameter(name) else { return any };
        let range = parameter.range();
        let low = if range.open_min { range.min + LEAST * parameter.value.abs() } else { range.min };
        (low.max(f64::MIN), range.max.min(f64::MAX))
    }

    /// Machine, start, shift and offsets for given parameter values.
    ///
    /// # Errors
    /// [`Error::Refusal`] for values outside their range.
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

    /// Columns of derivatives of a segment. The first segment begins with the start; a later one
    /// begins with its own state of `states` components.
    pub fn columns(&self, states: Option<usize>) -> Columns {
        let is_first = states.is_none();
        let (mut by, mut of) = (Vec::new(), Vec::new());
        let mut add = |own: By| {
            by.push(own);
            by.len() - 1
        };
        for unknown in &self.all {
            of.push(match *unknown {
                Unknown::Number(k) => match &self.by[k] {
                    // Only the first segment begins with the start.
                    By::Start(_) | By::Time if !is_first => Source::None,
                    own => Source::Motion(add(own.clone())),
                },
                Unknown::Shift if is_first => Source::Shift(None),
                Unknown::Shift => Source::Shift(Some(add(By::Time))),
                Unknown::Offset(k) => Source::Offset(k),
            });
        }
        of.extend((0..states.unwrap_or(0)).map(|i| Source::Motion(add(By::Start(i)))));
        Columns { by, of }
    }
}

/// Source of a derivative.
#[derive(Clone, Copy, Debug)]
enum Source {
    /// A column of the motion's derivatives.
    Motion(usize),
    /// Derivative with respect to the record's shift. In a later segment, whose start time is
    /// shifted too, it includes the column of the start time.
    Shift(Option<usize>),
    /// Derivative with respect to the offset of a column.
    Offset(usize),
    /// None: the derivative is 0.
    None,
}

/// Columns of derivatives of a motion.
#[derive(Default)]
pub(super) struct Columns {
    pub by: Vec<By>,
    /// For each free parameter, then for each component of the segment's initial state.
    of: Vec<Source>,
}

impl Columns {
    /// Derivatives with respect to all that is fitted, given the motion's derivatives by column
    /// and by time, and the index of the record's column.
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
