//! A row of the table and its columns, the properties of a variable.

use super::bases::{Base, Edition};
use super::sections::Section;
use crate::component::jets::Jet;
use crate::component::settings::{Derived, Settings};
use crate::component::units::{EnumerationType, RealType};
use crate::component::values::{OutputValues, Prediction, StepMatrices, Tick, Varied};
pub use fmi_doors::DependencyKind;
pub use fmi_doors::description::{Causality, Initial, Variability};
use vibro_impact::parameters::Range;

/// The type specific part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A Real.
    Real {
        /// Declared type, which gives quantity, unit and display unit.
        declared: RealType,
        /// Valid values of a variable that can be set; all numbers for a variable that is only
        /// read.
        range: Range,
        /// Nominal value.
        nominal: Option<f64>,
        /// Name of the state, if the variable is its time derivative.
        derivative_of: Option<&'static str>,
        /// Whether events may change this continuous state.
        reinit: bool,
    },
    /// An Integer.
    Integer {
        /// Smallest value.
        min: i32,
    },
    /// A Boolean.
    Boolean,
    /// An Enumeration.
    Enumeration(EnumerationType),
    /// A Clock that ticks at events of the component.
    Clock,
}

/// Functions that read an output.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// Its value.
    pub value: fn(&OutputValues) -> f64,
    /// Its value with a variation; `None` for a value that changes at events only.
    pub varied: Option<fn(&OutputValues<Varied>) -> Varied>,
    /// Its value with its time derivatives; `None` for a value that changes at events only.
    pub jet: Option<fn(&OutputValues<Jet>) -> Jet>,
}

/// Location of a variable's value. All values are passed as `f64`: Integers and enumerations are
/// exact in it, Booleans are 0 and 1.
#[derive(Clone, Copy, Debug)]
pub enum Access {
    /// Kept in the settings.
    Setting {
        /// Reads it.
        get: fn(&Settings) -> f64,
        /// Writes it.
        set: fn(&mut Settings, f64),
    },
    /// A start value until initialization ends, then an output of the motion.
    Start {
        /// Reads the start value.
        get: fn(&Settings) -> f64,
        /// Writes the start value.
        set: fn(&mut Settings, f64),
        /// Reads the present value.
        now: Reading,
    },
    /// An output of the motion.
    Output(Reading),
    /// An array of the motion, element by element in row-major order.
    Elements(fn(&OutputValues, usize) -> f64),
    /// A value that follows from the parameters.
    Derived(fn(&Derived) -> f64),
    /// The next event.
    Prediction(fn(&Prediction) -> f64),
    /// An array of derivatives over the last step, element by element in row-major order.
    Step(fn(&StepMatrices, usize) -> f64),
    /// The shown values of the clock of impacts.
    Tick(fn(&Tick) -> f64),
}

/// Knowns by name, with the kind of dependency on each.
pub type Knowns = &'static [(&'static str, DependencyKind)];

/// Dependencies of a variable at a given time: of an output on inputs, continuous states and time;
/// of a calculated parameter on parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dependencies {
    /// The variable is not an unknown of the model's structure: it is set, it is time, or its
    /// value belongs to the last step or to the next event.
    NotUnknown,
    /// The variable depends on these knowns only.
    On(Knowns),
}

/// Dependencies of an unknown in initialization, where inputs, start values, parameters and time
/// are the knowns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Initially {
    /// The dependencies after initialization.
    AsLater,
    /// In addition to these, the given variables and all variables that determine a closed form,
    /// [`START`](super::START), since the start may be taken from a closed form.
    OnStartAnd(&'static [&'static str]),
    /// Only the given variables.
    On(&'static [&'static str]),
}

/// One variable: every column of its row. Code that needs a property of a variable reads a column;
/// it never derives the property from the name.
#[derive(Clone, Copy, Debug)]
pub struct Variable {
    /// Value reference, given in the table. It is never used for another variable.
    pub reference: u32,
    /// Structured name: identifiers with dots between them.
    pub name: &'static str,
    /// Description, with the sign convention if there is one.
    pub description: &'static str,
    /// Section of the documentation.
    pub section: Section,
    /// The descriptions that contain the variable.
    pub edition: Edition,
    /// Lengths of an array, the slowest index first; empty for a scalar.
    pub dimensions: &'static [usize],
    /// Symbol in the theory, if any.
    pub symbol: Option<&'static str>,
    /// Causality.
    pub causality: Causality,
    /// Variability.
    pub variability: Variability,
    /// Origin of the initial value; `None` for inputs and time.
    pub initial: Option<Initial>,
    /// Type specific part.
    pub kind: Kind,
    /// Functions that read and write the variable.
    pub access: Access,
    /// Its dependencies.
    pub dependencies: Dependencies,
    /// Names of further knowns in later descriptions: their knowns include parameters and the
    /// variables that decide the contact at an event.
    pub further: &'static [&'static str],
    /// Its dependencies in initialization.
    pub initially: Initially,
    /// The body on which an input acts: 0 the box, 1 the block, 2 the secondary oscillator. `None`
    /// for other variables.
    pub body: Option<usize>,
}

impl Variable {
    /// Whether the host's callback can set or read the variable within a step: continuous inputs
    /// and outputs.
    pub fn is_seen_within_steps(&self) -> bool {
        matches!(self.causality, Causality::Input | Causality::Output)
            && self.variability == Variability::Continuous
    }

    /// Type of its values.
    pub const fn base(&self) -> Base {
        match self.kind {
            Kind::Real { .. } => Base::Real,
            Kind::Integer { .. } => Base::Integer,
            Kind::Boolean => Base::Boolean,
            Kind::Enumeration(_) => Base::Enumeration,
            Kind::Clock => Base::Clock,
        }
    }

    /// Number of its values: 1, or the product of the dimensions.
    pub const fn size(&self) -> usize {
        let (mut size, mut i) = (1, 0);
        while i < self.dimensions.len() {
            size *= self.dimensions[i];
            i += 1;
        }
        size
    }

    /// Start value of every variable that has one: parameters, inputs and variables whose initial
    /// value is exact.
    pub fn start(&self) -> Option<f64> {
        self.start_in(&Settings::default())
    }

    /// Start value in a description that starts from `settings`.
    pub fn start_in(&self, settings: &Settings) -> Option<f64> {
        match self.access {
            Access::Setting { get, .. } | Access::Start { get, .. } => Some(get(settings)),
            _ => None,
        }
    }

    /// Smallest and largest valid value of a Real; `None` without a bound.
    pub fn bounds(&self) -> (Option<f64>, Option<f64>) {
        let Kind::Real { range, .. } = self.kind else { return (None, None) };
        (Some(range.min).filter(|x| x.is_finite()), Some(range.max).filter(|x| x.is_finite()))
    }

    /// Text of the values that may be set.
    pub fn allowed(&self) -> &'static str {
        match self.kind {
            Kind::Real { range, .. } => range.allowed,
            Kind::Integer { .. } => "a whole number",
            Kind::Boolean => "0 (false) or 1 (true)",
            Kind::Enumeration(declared) => declared.allowed,
            Kind::Clock => "false (inactive) or true (active)",
        }
    }

    /// Declared type of a Real.
    pub fn real_type(&self) -> Option<&RealType> {
        match &self.kind {
            Kind::Real { declared, .. } => Some(declared),
            _ => None,
        }
    }

    /// Name of the declared type, if any.
    pub fn declared_type(&self) -> Option<&'static str> {
        match &self.kind {
            Kind::Real { declared, .. } => Some(declared.name),
            Kind::Enumeration(declared) => Some(declared.name),
            _ => None,
        }
    }

    /// Unit of a Real.
    pub fn unit(&self) -> Option<&'static str> {
        self.real_type().and_then(|declared| declared.unit)
    }

    /// Whether `value` may be set: finite, inside the range, an item of the enumeration.
    pub fn accepts(&self, value: f64) -> bool {
        match self.kind {
            Kind::Real { range, .. } => range.contains(value),
            Kind::Integer { min } => value >= f64::from(min),
            Kind::Boolean | Kind::Clock => value == 0.0 || value == 1.0,
            Kind::Enumeration(declared) => declared.items.iter().any(|item| f64::from(item.value) == value),
        }
    }
}
