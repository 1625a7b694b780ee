//! Machines along one or two parameters, and the equations of orbits over them.

use super::cycle::{Cycle, Functional};
use super::orbit::{Orbit, unfolded_phases};
use super::system::System;
use crate::curve::{Equations, Linearization, slope};
use crate::obstacle::Obstacle;
use crate::stop_word::{OrbitWord, REPETITION};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};
use vibro_studies::Error;
use vibro_studies::paper::{Name, ParameterSet};

/// Step of the differences with respect to the parameter, in its curve unit. It affects the speed
/// of convergence, not the result.
const DIFFERENCE: f64 = 1e-5;

/// Number of curve units in the range of a parameter. The curve unit of phases is 1 rad.
const UNITS: f64 = 5.0;

/// A parameter with its range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Span {
    /// The parameter.
    pub name: Name,
    /// Smallest value.
    pub from: f64,
    /// Largest value.
    pub to: f64,
}

impl Span {
    /// A range of a parameter.
    ///
    /// # Errors
    /// [`Error::Form`] if the range is empty or not finite; the error of [`Name::check`] if an end
    /// of the range is not allowed.
    pub fn new(name: impl Into<Name>, from: f64, to: f64) -> Result<Self, Error> {
        let name = name.into();
        if !(from < to && (to - from).is_finite()) {
            let text = format!("{}={from}:{to}", name.name());
            return Err(Error::Form { text, expected: "from < to, both finite" });
        }
        name.check(from)?;
        name.check(to)?;
        Ok(Self { name, from, to })
    }

    pub(super) fn unit(&self) -> f64 {
        (self.to - self.from) / UNITS
    }

    pub(super) fn contains(&self, value: f64) -> bool {
        (self.from..=self.to).contains(&value)
    }
}

/// The machines over one or two parameters; all other parameters are fixed.
#[derive(Clone, Debug)]
pub struct Family {
    set: ParameterSet,
    spans: Vec<Span>,
}

impl Family {
    /// The machines along one parameter.
    ///
    /// # Errors
    /// The error of [`system`](Self::system) for the machine at either end of the range.
    pub fn new(set: &ParameterSet, span: Span) -> Result<Self, Error> {
        Self::over(set, vec![span])
    }

    /// The machines over two parameters.
    ///
    /// # Errors
    /// As [`new`](Self::new); [`Error::Form`] if both names denote one parameter.
    pub fn over_two(set: &ParameterSet, first: Span, second: Span) -> Result<Self, Error> {
        if first.name.is_same_quantity(second.name) {
            let text = format!("{},{}", first.name.name(), second.name.name());
            return Err(Error::Form { text, expected: "two independent parameters, e.g. f10,kappa" });
        }
        Self::over(set, vec![first, second])
    }

    fn over(set: &ParameterSet, spans: Vec<Span>) -> Result<Self, Error> {
        // The fields of a span are public: a caller can make one without `Span::new`.
        spans.iter().try_for_each(|s| Span::new(s.name, s.from, s.to).map(drop))?;
        let family = Self { set: set.clone(), spans };
        let (from, to): (Vec<f64>, Vec<f64>) = family.spans.iter().map(|s| (s.from, s.to)).unzip();
        // If two parameters vary, the machines at the other two corners need not exist.
        family.system(&from)?;
        family.system(&to)?;
        Ok(family)
    }

    /// The varied parameters.
    pub fn spans(&self) -> &[Span] {
        &self.spans
    }

    /// The first varied parameter.
    pub fn span(&self) -> &Span {
        &self.spans[0]
    }

    /// The parameters of a machine of the family.
    ///
    /// # Errors
    /// An error if a parameter's value is not allowed.
    pub fn parameter_set(&self, values: &[f64]) -> Result<ParameterSet, Error> {
        let mut set = self.set.clone();
        for (span, value) in self.spans.iter().zip(values) {
            set = set.with(span.name, *value)?;
        }
        Ok(set)
    }

    /// A machine of the family.
    ///
    /// # Errors
    /// As [`System::new`] and [`parameter_set`](Self::parameter_set).
    pub fn system(&self, values: &[f64]) -> Result<System, Error> {
        System::new(self.parameter_set(values)?.parameters())
    }

    /// Whether the mirror image of every orbit is an orbit: only if no machine has loads.
    pub fn is_symmetric(&self) -> bool {
        self.set.parameters().constant_loads == [0.0; 3] && !self.spans.iter().any(|span| span.name.is_load())
    }

    /// The shortest word of an orbit in the family, with its phases. A symmetric orbit is reduced
    /// to half of its word only if no machine of the family has loads.
    pub(super) fn shortest(&self, orbit: &Orbit) -> (OrbitWord, Vec<f64>) {
        let (word, phases) = (orbit.word(), orbit.phases());
        let mirror = self.is_symmetric();
        if word.closing() < 0 && !mirror {
            word.unfolded().reduced(&unfolded_phases(word, phases), mirror, REPETITION)
        } else {
            word.reduced(phases, mirror, REPETITION)
        }
    }

    /// The parameters' values at a point of a curve, which contains the phases and then the scaled
    /// parameters.
    pub(super) fn values(&self, u: &DVector<f64>) -> Vec<f64> {
        let first = u.len() - self.spans.len();
        self.spans.iter().enumerate().map(|(i, span)| u[first + i] * span.unit()).collect()
    }

    /// The point of a curve with given phases and parameters.
    pub(super) fn point(&self, phases: &[f64], values: &[f64]) -> DVector<f64> {
        let scaled = self.spans.iter().zip(values).map(|(span, value)| value / span.unit());
        DVector::from_iterator(phases.len() + self.spans.len(), phases.iter().copied().chain(scaled))
    }

    /// The machine at a point of a curve.
    pub(super) fn system_at(&self, u: &DVector<f64>) -> Result<System, Obstacle> {
        Ok(self.system(&self.values(u))?)
    }

    /// Derivatives of a quantity of the cycle with respect to the parameters, by differences
    /// between machines with the same anchor as this cycle's machine.
    pub(super) fn by_parameters(
        &self,
        u: &DVector<f64>,
        cycle: &Cycle,
        quantity: impl Fn(&Cycle) -> Vec<f64>,
    ) -> Result<Vec<DVector<f64>>, Obstacle> {
        let first = u.len() - self.spans.len();
        let at = |k: usize, by: f64| -> Result<Vec<f64>, Obstacle> {
            let mut moved = u.clone();
            moved[first + k] += by;
            let system = self.system_at(&moved)?.anchored(cycle.system.anchor());
            Ok(quantity(&cycle.in_system(&system)?))
        };
        let step = |k: usize| DIFFERENCE * u[first + k].abs().max(1.0);
        (0..self.spans.len()).map(|k| slope(step(k), |by| at(k, by))).collect()
    }
}

/// The contact equations of a word over a family: one equation for each impact.
#[derive(Clone, Copy)]
pub(super) struct ContactEquations<'a> {
    pub family: &'a Family,
    pub word: &'a OrbitWord,
}

impl ContactEquations<'_> {
    /// Value and derivative of the residual. The parameters' columns are taken from `known`, if
    /// given.
    pub fn linearize(
        &self,
        cycle: &Cycle,
        u: &DVector<f64>,
        known: Option<&DMatrix<f64>>,
    ) -> Result<Linearization, Obstacle> {
        let n = self.word.len();
        let by_phases = cycle.derivative(Functional::Gap, 1.0).ok_or(Obstacle::Singular)?;
        let mut matrix = by_phases.resize_horizontally(u.len(), 0.0);
        match known {
            Some(known) => {
                matrix.columns_mut(n, u.len() - n).copy_from(&known.view((0, n), (n, u.len() - n)))
            }
            None => {
                let columns = self.family.by_parameters(u, cycle, |c| c.residual.clone())?;
                columns.iter().enumerate().for_each(|(k, column)| matrix.set_column(n + k, column));
            }
        }
        Ok(Linearization { value: cycle.residual_vector(), matrix })
    }
}

impl Equations for ContactEquations<'_> {
    fn linearize(&self, u: &DVector<f64>, known: Option<&DMatrix<f64>>) -> Result<Linearization, Obstacle> {
        let system = self.family.system_at(u)?;
        let phases = &u.as_slice()[..self.word.len()];
        let cycle = Cycle::new(&system, self.word, phases)?;
        ContactEquations::linearize(self, &cycle, u, known)
    }
}
