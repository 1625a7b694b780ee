//! A machine at one value of a parameter, and over a range of values.

use std::sync::{Arc, Mutex, PoisonError};
use vibro_machine::Assembly;
use vibro_machine::description::{Block, Description};
use vibro_machine::mode::Mode;
use vibro_machine::system::System;
use vibro_numerics::double_double::DoubleDouble;
use vibro_studies::flight::{Flow, Flows};
use vibro_studies::{Error, Result};
use vibro_studies::{Machine, common_period, is_steady, require_free, runs_on};

/// A machine with fixed parameters, and the linear systems of the modes used so far.
#[derive(Debug)]
pub struct Place {
    /// The machine with its matrices.
    pub assembly: Arc<Assembly>,
    /// The common period of all signals, s; `None` for an autonomous machine.
    pub period: Option<f64>,
    flows: Mutex<Flows>,
}

/// Reason why a machine's blocks have no orbits: a block rounds an input, so its output jumps.
fn rounded_input(d: &Description) -> Option<String> {
    let rounds = |block: &&Block| {
        let sampling = block.sampling.as_ref();
        sampling.is_some_and(|own| own.quanta.iter().flatten().any(|quantum| *quantum > 0.0))
    };
    let block = d.blocks.iter().find(rounds)?;
    Some(format!(
        "block.{} rounds an input to a quantum; orbits of such a machine are not supported, \
         because its motion is not differentiable: remove `quantum` from the file, or simulate \
         motions (run, bifurcation)",
        block.name
    ))
}

/// Fills in the signals of an augmented state at a time.
pub(super) fn with_signals(system: &System, time: f64, z: &mut [f64]) {
    let inputs = system.signals.no_inputs();
    system.signals.fill(DoubleDouble::new(time), &inputs, z);
}

impl Place {
    /// The place of a description with its present parameter values.
    ///
    /// # Errors
    /// If its matrices are refused; [`Error::Described`] for a machine with aperiodic signals.
    pub fn new(description: Description) -> Result<Self> {
        let d = &description;
        let period = common_period(d);
        let problem = match runs_on(d, 0.0) {
            Some(why) => format!(
                "{why}, so the machine has no periodic orbit; expected loads and motions that are \
                 harmonic, constant, uniform or repeated"
            ),
            None if period.is_none() && !is_steady(d) => {
                "the harmonics' frequencies have no common period up to 1000 periods of the \
                 slowest, so the machine has no periodic orbit; expected frequencies in ratios of \
                 small integers"
                    .into()
            }
            None => rounded_input(d).unwrap_or_default(),
        };
        if !problem.is_empty() {
            return Err(Error::Described { problem });
        }
        let assembly = Arc::new(Assembly::new(description)?);
        require_free(&assembly)?;
        Ok(Self { assembly, period, flows: Mutex::default() })
    }

    /// The linear system of a mode.
    pub(super) fn flow(&self, mode: &Mode) -> Arc<Flow> {
        let mut flows = self.flows.lock().unwrap_or_else(PoisonError::into_inner);
        flows.of(self.assembly.system(), mode)
    }
}

/// A machine over a range of one of its parameters.
#[derive(Clone, Debug)]
pub struct Family {
    /// The machine.
    pub machine: Machine,
    /// Name of the parameter.
    pub parameter: String,
    /// Smallest and largest value, SI.
    pub range: (f64, f64),
}

/// Number of curve units in a parameter's range; one unit is weighted like one radian of phase.
const PARTS: f64 = 5.0;

impl Family {
    /// A machine over a range of parameter values, SI.
    ///
    /// # Errors
    /// [`Error::Refusal`] for an unknown name or a value that is not allowed; [`Error::Described`]
    /// for a parameter of the start and for an empty range; otherwise as [`Place::new`] at both
    /// ends.
    pub fn new(machine: &Machine, parameter: &str, range: (f64, f64)) -> Result<Self> {
        let name = machine.description.parameter(parameter)?.name;
        if !(range.0 < range.1 && (range.1 - range.0).is_finite()) {
            let problem =
                format!("{name}: {} to {}; the lower end must be less than the upper end", range.0, range.1);
            return Err(Error::Described { problem });
        }
        if name.contains(".start.") {
            let problem =
                format!("{name}: orbits do not depend on the start; use another parameter of the machine");
            return Err(Error::Described { problem });
        }
        let family = Self { machine: machine.clone(), parameter: name, range };
        family.place(range.0)?;
        family.place(range.1)?;
        Ok(family)
    }

    /// The family of a machine's first parameter, used only at the present value.
    ///
    /// # Errors
    /// As [`Place::new`].
    pub(super) fn of_one(machine: &Machine) -> Result<Self> {
        Place::new(machine.description.clone())?;
        let parameter = machine.description.parameters().into_iter().next().map(|p| p.name);
        let parameter = parameter.unwrap_or_default();
        Ok(Self { machine: machine.clone(), parameter, range: (0.0, PARTS) })
    }

    /// The parameter's present value.
    pub(super) fn present(&self) -> Result<f64> {
        Ok(self.machine.description.get(&self.parameter)?)
    }

    /// The machine at a value.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn place(&self, value: f64) -> Result<Place> {
        Place::new(self.described(value)?)
    }

    /// The described machine at a value, with its section and units.
    ///
    /// # Errors
    /// [`Error::Refusal`] for a value that is not allowed.
    pub fn at(&self, value: f64) -> Result<Machine> {
        let Machine { section, units, changes, .. } = &self.machine;
        let (section, units, changes) = (section.clone(), units.clone(), changes.clone());
        Ok(Machine { description: self.described(value)?, section, units, changes })
    }

    /// The description at a value.
    fn described(&self, value: f64) -> Result<Description> {
        // An orbit has its own initial state, so the start in the file is not checked.
        Ok(self.machine.description.under_way([(self.parameter.as_str(), value)])?)
    }

    /// The unit of the parameter along a branch.
    pub fn unit(&self) -> f64 {
        (self.range.1 - self.range.0) / PARTS
    }
}
