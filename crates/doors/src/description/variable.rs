//! Variables and their dependencies.

use super::{Text, Type};
use crate::values::DependencyKind;

/// Role of a variable: who sets it and who reads it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Causality {
    /// Set by the environment, constant during simulation.
    Parameter,
    /// Follows from parameters.
    CalculatedParameter,
    /// Set by the environment.
    Input,
    /// Read by the environment.
    Output,
    /// Read by the environment, but not meant to be connected.
    Local,
    /// Time.
    Independent,
}

impl Causality {
    /// Name in the standard.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Parameter => "parameter",
            Self::CalculatedParameter => "calculatedParameter",
            Self::Input => "input",
            Self::Output => "output",
            Self::Local => "local",
            Self::Independent => "independent",
        }
    }
}

/// Variability: the times of a variable's changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Constant after initialization.
    Fixed,
    /// Constant between communication points or external events.
    Tunable,
    /// Changes at events only.
    Discrete,
    /// Changes at any time.
    Continuous,
}

impl Variability {
    /// Name in the standard.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fixed => "fixed",
            Self::Tunable => "tunable",
            Self::Discrete => "discrete",
            Self::Continuous => "continuous",
        }
    }
}

/// Origin of the initial value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Initial {
    /// Has a start value, which is its initial value.
    Exact,
    /// Computed.
    Calculated,
}

impl Initial {
    /// Name in the standard.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Exact => "exact",
            Self::Calculated => "calculated",
        }
    }
}

/// The type specific part of a variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A Real.
    Real {
        /// Name of its unit. In FMI 3.0 a declared type may give the unit instead.
        unit: Option<Text>,
        /// Default display unit. In FMI 3.0 a declared type may give it instead.
        display_unit: Option<Text>,
        /// Nominal value.
        nominal: Option<f64>,
        /// Value reference of the state, if this is its time derivative.
        derivative_of: Option<u32>,
        /// Whether events may change this continuous state.
        reinit: bool,
    },
    /// An Integer.
    Integer,
    /// A Boolean.
    Boolean,
    /// An Enumeration.
    Enumeration,
    /// FMI 3.0: a clock that ticks at events of the component.
    Clock,
}

/// A variable.
#[derive(Clone, Debug, PartialEq)]
pub struct Variable {
    /// Name.
    pub name: Text,
    /// Value reference, unique among the variables.
    pub reference: u32,
    /// Description.
    pub description: Text,
    /// Causality.
    pub causality: Causality,
    /// Variability.
    pub variability: Variability,
    /// Origin of the initial value; `None` for inputs and time.
    pub initial: Option<Initial>,
    /// Type.
    pub kind: Kind,
    /// Name of its declared type.
    pub declared_type: Option<Text>,
    /// Lower limit of a set value.
    pub min: Option<f64>,
    /// Upper limit of a set value.
    pub max: Option<f64>,
    /// Start value. A variable that can be set has one. Booleans are 0 and 1.
    pub start: Option<f64>,
    /// FMI 3.0: lengths of an array, the slowest index first; empty for a scalar.
    pub dimensions: Vec<usize>,
    /// FMI 3.0: whether the variable can be read or set within a step.
    pub intermediate_update: bool,
    /// FMI 3.0: value reference of its clock.
    pub clock: Option<u32>,
    /// FMI 3.0: another name.
    pub alias: Option<Text>,
}

impl Variable {
    /// A Real of a declared type, with the unit of that type. It has no range and no start value;
    /// all other optional fields are empty.
    pub fn real(
        reference: u32,
        name: impl Into<Text>,
        declared: &Type,
        causality: Causality,
        description: impl Into<Text>,
    ) -> Self {
        let (unit, display_unit) = declared.units();
        let mut variable = Self::of_unit(reference, name, unit, causality, description);
        variable.declared_type = Some(declared.name.clone());
        if let Kind::Real { display_unit: place, .. } = &mut variable.kind {
            *place = display_unit;
        }
        variable
    }

    /// A Real with or without a unit, and without a declared type; otherwise as
    /// [`real`](Self::real).
    pub fn of_unit(
        reference: u32,
        name: impl Into<Text>,
        unit: Option<Text>,
        causality: Causality,
        description: impl Into<Text>,
    ) -> Self {
        let (variability, initial) = match causality {
            Causality::Parameter => (Variability::Fixed, Some(Initial::Exact)),
            Causality::CalculatedParameter => (Variability::Fixed, Some(Initial::Calculated)),
            Causality::Input | Causality::Independent => (Variability::Continuous, None),
            Causality::Output | Causality::Local => (Variability::Continuous, Some(Initial::Calculated)),
        };
        let kind = Kind::Real { unit, display_unit: None, nominal: None, derivative_of: None, reinit: false };
        Self {
            name: name.into(),
            reference,
            description: description.into(),
            causality,
            variability,
            initial,
            kind,
            declared_type: None,
            min: None,
            max: None,
            start: None,
            dimensions: Vec::new(),
            intermediate_update: matches!(causality, Causality::Input | Causality::Output),
            clock: None,
            alias: None,
        }
    }

    /// Adds a start value, which is the initial value unless the variable is an input.
    #[must_use]
    pub fn starting_at(self, start: f64) -> Self {
        let initial = if self.causality == Causality::Input { None } else { Some(Initial::Exact) };
        Self { start: Some(start), initial, ..self }
    }

    /// Marks the derivative of a state, given by the state's value reference.
    #[must_use]
    pub fn derivative_of(mut self, state: u32) -> Self {
        if let Kind::Real { derivative_of, .. } = &mut self.kind {
            *derivative_of = Some(state);
        }
        self
    }

    /// Marks a state that events change.
    #[must_use]
    pub fn reinitialized(mut self) -> Self {
        if let Kind::Real { reinit, .. } = &mut self.kind {
            *reinit = true;
        }
        self
    }

    /// Makes it an Integer that changes at events only.
    #[must_use]
    pub fn counting(self) -> Self {
        let variability = Variability::Discrete;
        Self { kind: Kind::Integer, declared_type: None, variability, intermediate_update: false, ..self }
    }
}

/// An unknown and its dependencies, by value references.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown {
    /// Its value reference.
    pub reference: u32,
    /// The knowns on which it depends, with the kind of dependency. `None` means that it may
    /// depend on all knowns.
    pub dependencies: Option<Vec<(u32, DependencyKind)>>,
}

impl Unknown {
    /// An unknown that depends on these knowns, with [`DependencyKind::Dependent`].
    pub fn on(reference: u32, knowns: impl IntoIterator<Item = u32>) -> Self {
        let dependencies = knowns.into_iter().map(|known| (known, DependencyKind::Dependent)).collect();
        Self { reference, dependencies: Some(dependencies) }
    }

    /// An unknown that may depend on all knowns.
    pub fn on_anything(reference: u32) -> Self {
        Self { reference, dependencies: None }
    }
}
