//! The one table of variables (FMI 2.0, 2.2.7): the model description, start values, range checks, getters, setters,
//! reset and the documentation all come from it.
//!
//! A value reference is a variable's place in [`VARIABLES`], for all base types alike; new variables are appended, so
//! references stay. `ScalarVariable` indices (FMI 2.0, 2.2.8) are the reference + 1.

use super::settings::{Derived, Motion, Settings};
use super::units::{EnumerationType, RealType};

mod packed;
mod table;

pub(crate) use packed::{READERS, Reader, WRITERS, Writer};
pub use table::{COUNT, VARIABLES};

/// FMI 2.0, 2.2.7, attribute `causality`.
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
    /// Time.
    Independent,
}

/// FMI 2.0, 2.2.7, attribute `variability`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variability {
    /// Constant after initialization.
    Fixed,
    /// Constant between communication points or external events.
    Tunable,
    /// Changes at events only.
    Discrete,
    /// Changes any time.
    Continuous,
}

/// FMI 2.0, 2.2.7, attribute `initial`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Initial {
    /// Has a start value that is its initial value.
    Exact,
    /// Computed.
    Calculated,
}

/// The type specific part (FMI 2.0, 2.2.7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A Real.
    Real {
        /// Declared type, which gives quantity, unit and display unit.
        declared: RealType,
        /// Smallest allowed value.
        min: Option<f64>,
        /// Largest allowed value.
        max: Option<f64>,
        /// Nominal value.
        nominal: Option<f64>,
        /// Name of the variable whose time derivative this is.
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
    /// An Enumeration, read and set as Integer.
    Enumeration(EnumerationType),
}

/// Base type: which of `fmi2GetReal/Integer/Boolean/String` reads a variable (FMI 2.0, 2.1.7).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Base {
    /// Real.
    Real,
    /// Integer and Enumeration.
    Integer,
    /// Boolean.
    Boolean,
    /// String; no variable has it.
    String,
}

/// Where a variable's value lives. All values travel as `f64`: Integers and enumerations are exact in it, Booleans
/// are 0 and 1.
#[derive(Clone, Copy, Debug)]
pub enum Access {
    /// Kept in the settings.
    Setting {
        /// Reads it.
        get: fn(&Settings) -> f64,
        /// Writes it.
        set: fn(&mut Settings, f64),
    },
    /// A start value until initialization ends, then part of the motion.
    Start {
        /// Reads the start value.
        get: fn(&Settings) -> f64,
        /// Writes the start value.
        set: fn(&mut Settings, f64),
        /// Reads the present value.
        now: fn(&Motion) -> f64,
    },
    /// Part of the motion.
    Motion(fn(&Motion) -> f64),
    /// Follows from the parameters.
    Derived(fn(&Derived) -> f64),
}

/// One variable.
#[derive(Clone, Copy, Debug)]
pub struct Variable {
    /// Structured name (FMI 2.0, 2.2.9).
    pub name: &'static str,
    /// What it is.
    pub description: &'static str,
    /// Causality.
    pub causality: Causality,
    /// Variability.
    pub variability: Variability,
    /// `initial`; none for inputs and time.
    pub initial: Option<Initial>,
    /// Type specific part.
    pub kind: Kind,
    /// What a set value may be, in words.
    pub allowed: &'static str,
    /// Whether `min` itself is refused.
    pub open_min: bool,
    /// How to read and write it.
    pub access: Access,
}

impl Variable {
    /// Base type.
    pub const fn base(&self) -> Base {
        match self.kind {
            Kind::Real { .. } => Base::Real,
            Kind::Integer { .. } | Kind::Enumeration(_) => Base::Integer,
            Kind::Boolean => Base::Boolean,
        }
    }

    /// Start value as in the model description (FMI 2.0, 2.2.7, attribute `start`), for every variable that has one:
    /// parameters, inputs and those of `initial = exact`.
    pub fn start(&self) -> Option<f64> {
        match self.access {
            Access::Setting { get, .. } | Access::Start { get, .. } => Some(get(&Settings::default())),
            Access::Motion(_) | Access::Derived(_) => None,
        }
    }

    /// Declared type of a Real.
    pub fn real_type(&self) -> Option<&RealType> {
        match &self.kind {
            Kind::Real { declared, .. } => Some(declared),
            _ => None,
        }
    }

    /// Name of the declared type, where there is one.
    pub fn declared_type(&self) -> Option<&'static str> {
        match &self.kind {
            Kind::Real { declared, .. } => Some(declared.name),
            Kind::Enumeration(declared) => Some(declared.name),
            _ => None,
        }
    }

    /// Unit of a Real.
    pub fn unit(&self) -> Option<&'static str> {
        self.real_type().map(|declared| declared.unit)
    }

    /// Whether `value` may be set: finite, inside the range, an item of the enumeration.
    pub fn accepts(&self, value: f64) -> bool {
        match self.kind {
            Kind::Real { min, max, .. } => {
                value.is_finite()
                    && min.is_none_or(|min| value > min || (value == min && !self.open_min))
                    && max.is_none_or(|max| value <= max)
            }
            Kind::Integer { min } => value >= f64::from(min),
            Kind::Boolean => value == 0.0 || value == 1.0,
            Kind::Enumeration(declared) => declared.items.iter().any(|item| f64::from(item.value) == value),
        }
    }
}

/// The variable of that name and its value reference.
pub fn find(name: &str) -> Option<(u32, &'static Variable)> {
    (0..).zip(VARIABLES.iter()).find(|(_, variable)| variable.name == name)
}

/// Value reference of the variable of that name, at compile time.
///
/// # Panics
/// When there is none: a misspelt constant does not compile.
pub const fn reference(name: &str) -> u32 {
    let mut i = 0;
    while i < COUNT {
        if same(VARIABLES[i].name, name) {
            return i as u32;
        }
        i += 1;
    }
    panic!("no variable of that name")
}

const fn same(a: &str, b: &str) -> bool {
    let (a, b) = (a.as_bytes(), b.as_bytes());
    if a.len() != b.len() {
        return false;
    }
    let mut i = 0;
    while i < a.len() {
        if a[i] != b[i] {
            return false;
        }
        i += 1;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmi2::units;

    #[test]
    fn names_are_unique_and_structured() {
        for (i, variable) in VARIABLES.iter().enumerate() {
            assert_eq!(find(variable.name).unwrap().0 as usize, i, "{}", variable.name);
            assert!(variable.name.split('.').all(|part| {
                part.starts_with(|c: char| c.is_ascii_alphabetic())
                    && part.chars().all(|c| c.is_ascii_alphanumeric())
            }));
            assert!(units::REAL_TYPES.iter().all(|t| t.name != variable.name));
            assert!(!variable.description.is_empty());
        }
    }

    /// FMI 2.0, 2.2.7: combinations of causality, variability, initial and start.
    #[test]
    fn attributes_go_together() {
        for v in &VARIABLES {
            let exact = v.initial == Some(Initial::Exact);
            let (initial, start) = match v.causality {
                Causality::Parameter => (exact, true),
                Causality::CalculatedParameter => (v.initial == Some(Initial::Calculated), false),
                Causality::Input => (v.initial.is_none(), true),
                Causality::Output => (v.initial.is_some(), exact),
                Causality::Independent => (v.initial.is_none(), false),
            };
            assert!(initial, "{}", v.name);
            assert_eq!(v.start().is_some(), start, "{}", v.name);
            let data = matches!(v.variability, Variability::Fixed | Variability::Tunable);
            let parameter = matches!(v.causality, Causality::Parameter | Causality::CalculatedParameter);
            assert_eq!(data, parameter, "{}", v.name);
            assert!(v.variability != Variability::Continuous || v.base() == Base::Real, "{}", v.name);
        }
    }

    #[test]
    fn start_values_are_allowed_and_units_defined() {
        for v in &VARIABLES {
            if let Some(start) = v.start() {
                assert!(v.accepts(start), "{} = {start}", v.name);
                assert!(!v.allowed.is_empty(), "{}", v.name);
                assert!(!v.accepts(f64::NAN) && !v.accepts(f64::INFINITY), "{}", v.name);
            }
            if let Some(declared) = v.real_type() {
                let unit = units::find(declared.unit).unwrap();
                assert!(declared.display_unit.is_none_or(|name| unit.display.iter().any(|d| d.name == name)));
            }
        }
    }

    #[test]
    fn units_of_parameters_agree_with_the_parameters_module() {
        for field in vibro_impact::parameters::FIELDS {
            assert_eq!(find(field.name).unwrap().1.unit(), Some(field.unit));
        }
    }

    #[test]
    fn references_are_known_at_compile_time() {
        const TIME: u32 = reference("time");
        assert_eq!(TIME, 0);
        assert_eq!(reference("steady.spectralRadius") as usize, COUNT - 1);
    }
}
