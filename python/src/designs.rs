//! Machines of many motions: given one by one, or as one machine with rows of parameter values.
//! If rows are given, the thread that runs a motion creates its machine, without a Python object.

use crate::arrays::rows_of_states;
use crate::failure::Failure;
use crate::machine::{Described, Numbers};
use crate::paper_system::{System, find};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;
use vibro_impact::{Parameters, State};
use vibro_machine::Assembly;
use vibro_studies::paper::Name;
use vibro_studies::paper::start::{Coordinate, StartRule};
use vibro_studies::{Measure, Section, SectionRule};

/// Described machines as Python gives them.
#[derive(FromPyObject)]
pub enum GivenAssemblies<'py> {
    /// A machine, names of parameters, and their values in rows, SI.
    Rows(PyRef<'py, Described>, Vec<String>, PyReadonlyArray2<'py, f64>),
    Several(Vec<PyRef<'py, Described>>),
}

/// Owned copies of the described machines, which can be sent to another thread.
pub enum Assemblies {
    Rows(Described, Vec<String>, Rows),
    Several(Vec<Described>),
}

/// Rows of numbers, one number for each name.
pub struct Rows {
    numbers: Vec<f64>,
    width: usize,
    count: usize,
}

impl Rows {
    fn new(table: &PyReadonlyArray2<'_, f64>) -> PyResult<Self> {
        let &[count, width] = table.as_array().shape() else { unreachable!("two dimensions") };
        Ok(Self { numbers: table.as_slice()?.to_vec(), width, count })
    }

    fn row(&self, index: usize) -> &[f64] {
        &self.numbers[index * self.width..][..self.width]
    }
}

impl GivenAssemblies<'_> {
    /// Owned copies of the machines.
    pub fn owned(&self) -> PyResult<Assemblies> {
        Ok(match self {
            Self::Rows(machine, names, table) => {
                Assemblies::Rows((**machine).clone(), names.clone(), Rows::new(table)?)
            }
            Self::Several(machines) => Assemblies::Several(machines.iter().map(|m| (**m).clone()).collect()),
        })
    }
}

impl Assemblies {
    pub fn len(&self) -> usize {
        match self {
            Self::Rows(_, _, rows) => rows.count,
            Self::Several(machines) => machines.len(),
        }
    }

    /// Number of columns of a motion, the same for all machines.
    pub fn columns(&self) -> usize {
        let count = |machine: &Described| machine.description().quantities().count();
        match self {
            Self::Rows(machine, ..) => count(machine),
            Self::Several(machines) => machines.first().map_or(0, count),
        }
    }

    /// Checks the names of the measures and of the section's element, for all machines.
    ///
    /// # Errors
    /// If no machine has all of these names.
    pub fn check(&self, measures: &[Measure], rule: &SectionRule) -> Result<(), Failure> {
        let one = |machine: &Described| -> Result<(), vibro_studies::Error> {
            let d = machine.description();
            if let SectionRule::Element(_) = rule {
                Section::of(d, rule)?;
            }
            measures.iter().try_for_each(|measure| measure.check(d))
        };
        match self {
            Self::Rows(base, ..) => one(base)?,
            Self::Several(machines) => match machines.split_first() {
                Some((first, rest)) if rest.iter().all(|machine| one(machine).is_err()) => one(first)?,
                _ => {}
            },
        }
        Ok(())
    }

    /// The machine of a motion.
    ///
    /// # Errors
    /// If values are refused.
    pub fn machine(&self, index: usize) -> Result<Described, Failure> {
        match self {
            Self::Several(machines) => Ok(machines[index].clone()),
            Self::Rows(base, names, rows) => {
                let values = names.iter().map(String::as_str).zip(rows.row(index).iter().copied());
                let description = base.description().with(values)?;
                Assembly::new(description.clone())?; // checks matrices and start
                Ok(Described::of(description))
            }
        }
    }
}

/// The start of a motion: one of several, or the common start.
pub fn start_of(starts: &[Numbers], index: usize) -> &Numbers {
    &starts[if starts.len() == 1 { 0 } else { index }]
}

/// The paper's machines as Python gives them.
#[derive(FromPyObject)]
pub enum GivenSystems<'py> {
    /// Values in SI; dimensionless groups; indices of the values that change from motion to
    /// motion, counted through the first list, then the second; and these values, a row for each
    /// motion.
    Rows(Vec<(String, f64)>, Vec<(String, f64)>, Vec<usize>, PyReadonlyArray2<'py, f64>),
    Several(Vec<PyRef<'py, System>>),
}

/// Starts of the paper's machines as Python gives them: a state for each motion, in SI, or one
/// start for all motions. Each coordinate of the common start is in units of L or L ω10, or in SI.
#[derive(FromPyObject)]
pub enum GivenStarts<'py> {
    States(PyReadonlyArray2<'py, f64>),
    Rule([f64; 6], [Option<f64>; 6]),
}

/// Owned parameters of the paper's machines, which can be sent to another thread.
pub enum Systems {
    Rows(Vec<(Name, f64)>, Vec<(Name, f64)>, Vec<usize>, Rows),
    Several(Vec<Parameters>),
}

/// Owned starts of the paper's machines, which can be sent to another thread.
pub enum Starts {
    States(Vec<State>),
    Rule(StartRule),
}

impl GivenSystems<'_> {
    /// Owned copies of the machines.
    pub fn owned(&self) -> PyResult<Systems> {
        Ok(match self {
            Self::Rows(si, groups, places, table) => {
                let named = |part: &[(String, f64)]| {
                    part.iter().map(|(name, value)| Ok((find(name)?, *value))).collect::<PyResult<Vec<_>>>()
                };
                Systems::Rows(named(si)?, named(groups)?, places.clone(), Rows::new(table)?)
            }
            Self::Several(systems) => Systems::Several(systems.iter().map(|s| *s.parameters()).collect()),
        })
    }
}

impl GivenStarts<'_> {
    /// Owned copies of the starts.
    pub fn owned(&self) -> PyResult<Starts> {
        Ok(match self {
            Self::States(states) => Starts::States(rows_of_states(states)?),
            Self::Rule(scaled, si) => {
                let one = |(scaled, si): (&f64, &Option<f64>)| {
                    si.map_or(Coordinate::Scaled(*scaled), Coordinate::Si)
                };
                let mut start = [Coordinate::Scaled(0.0); 6];
                start.iter_mut().zip(scaled.iter().zip(si)).for_each(|(to, from)| *to = one(from));
                Starts::Rule(StartRule::State(start))
            }
        })
    }
}

impl Systems {
    pub fn len(&self) -> usize {
        match self {
            Self::Rows(.., rows) => rows.count,
            Self::Several(systems) => systems.len(),
        }
    }

    /// The parameters and the start of a motion.
    ///
    /// # Errors
    /// If values are refused, or a machine's drive has no period.
    pub fn motion(&self, starts: &Starts, index: usize) -> Result<(Parameters, State), Failure> {
        let parameters = match self {
            Self::Several(systems) => systems[index],
            Self::Rows(si, groups, places, rows) => {
                let (mut si, mut groups) = (si.clone(), groups.clone());
                for (&place, &value) in places.iter().zip(rows.row(index)) {
                    let count = si.len();
                    let slot = if place < count { &mut si[place] } else { &mut groups[place - count] };
                    slot.1 = value;
                }
                *System::of(&si, &groups)?.parameters()
            }
        };
        if !parameters.period().is_finite() {
            return Err(vibro_impact::Error::OutOfRange {
                name: "drive.frequency",
                value: parameters.drive_frequency,
                allowed: "> 0, since the motion is counted in drive periods",
            }
            .into());
        }
        let state = match starts {
            Starts::States(states) => states[index],
            Starts::Rule(rule) => rule.state(&parameters)?,
        };
        Ok((parameters, state))
    }
}
