//! A row of the table: one variable.

use crate::life::Phase;
use crate::problem::Problem;
use crate::values::Base;

/// The variables that may be set, for messages.
pub(super) const SETTABLE: &str = "inputs (and parameters and states until initialization ends)";

/// Role of a variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Time.
    Time,
    /// Set before the motion begins.
    Parameter,
    /// Set at any time.
    Input,
    /// A continuous state and output, whose start may be set; events may change it.
    State,
    /// The time derivative of the state with this index in the table.
    Derivative(usize),
    /// A Real that is computed from other variables.
    Output,
    /// An Integer that changes at events.
    Counter,
}

impl Role {
    /// The type of its values.
    pub(super) const fn base(self) -> Base {
        if matches!(self, Self::Counter) { Base::Integer } else { Base::Real }
    }

    /// Whether a host may set the variable now.
    pub(super) fn is_settable(self, phase: Phase) -> bool {
        match self {
            Self::Parameter | Self::State => [Phase::Instantiated, Phase::Initialization].contains(&phase),
            Self::Input => true,
            _ => false,
        }
    }

    /// Whether its description has `intermediateUpdate="true"`.
    pub(super) fn is_intermediate(self) -> bool {
        matches!(self, Self::Input | Self::State | Self::Output)
    }
}

/// A variable of the table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) start: f64,
    pub(super) description: &'static str,
    pub(super) role: Role,
    pub(super) min: f64,
    pub(super) max: f64,
}

impl Row {
    /// Time, s.
    pub const fn time(name: &'static str) -> Self {
        Self::new(Role::Time, name, "s", 0.0, "Time")
    }

    /// A parameter: name, unit, start value, description. Units are written as in `kg.m/s2`, with
    /// the symbols of the SI base units, N, Pa, J, W and V; `1` means no unit.
    pub const fn parameter(
        name: &'static str,
        unit: &'static str,
        start: f64,
        description: &'static str,
    ) -> Self {
        Self::new(Role::Parameter, name, unit, start, description)
    }

    /// An input, as [`parameter`](Self::parameter).
    pub const fn input(
        name: &'static str,
        unit: &'static str,
        start: f64,
        description: &'static str,
    ) -> Self {
        Self::new(Role::Input, name, unit, start, description)
    }

    /// A continuous state, as [`parameter`](Self::parameter).
    pub const fn state(
        name: &'static str,
        unit: &'static str,
        start: f64,
        description: &'static str,
    ) -> Self {
        Self::new(Role::State, name, unit, start, description)
    }

    /// The derivative of the state with an index in the table.
    pub const fn derivative(
        name: &'static str,
        unit: &'static str,
        of: usize,
        description: &'static str,
    ) -> Self {
        Self::new(Role::Derivative(of), name, unit, 0.0, description)
    }

    /// An output that follows from other values.
    pub const fn output(name: &'static str, unit: &'static str, description: &'static str) -> Self {
        Self::new(Role::Output, name, unit, 0.0, description)
    }

    /// A number of events, starting from 0.
    pub const fn counter(name: &'static str, description: &'static str) -> Self {
        Self::new(Role::Counter, name, "", 0.0, description).within(0.0, i32::MAX as f64)
    }

    const fn new(
        role: Role,
        name: &'static str,
        unit: &'static str,
        start: f64,
        description: &'static str,
    ) -> Self {
        Self { name, unit, start, description, role, min: f64::MIN, max: f64::MAX }
    }

    /// Sets the range of valid values. The lower bound `f64::MIN_POSITIVE` means more than 0;
    /// `f64::MIN` and `f64::MAX` mean no bound.
    #[must_use]
    pub const fn within(self, min: f64, max: f64) -> Self {
        Self { min, max, ..self }
    }

    /// Checks that a motion can have reached a value. Because of rounding or its motion, a state
    /// may be outside the range of set values.
    pub(super) fn check_reached(&self, value: f64) -> Result<(), Problem> {
        let anything = Self { min: f64::MIN, max: f64::MAX, ..*self };
        match self.role {
            Role::Parameter | Role::Input | Role::Counter => self.check(value),
            _ => anything.check(value),
        }
    }

    /// Checks that a value is within the range.
    pub(super) fn check(&self, value: f64) -> Result<(), Problem> {
        let whole = self.role != Role::Counter || value.fract() == 0.0;
        if (self.min..=self.max).contains(&value) && whole {
            return Ok(());
        }
        let allowed = match (self.min, self.max) {
            (f64::MIN, f64::MAX) => "a finite number".into(),
            (0.0, f64::MAX) => "a finite number >= 0".into(),
            (f64::MIN_POSITIVE, f64::MAX) => "a finite number > 0".into(),
            (min, max) => format!("a number from {min} to {max}"),
        };
        Err(Problem::value(self.name, value, allowed))
    }
}

/// The index of the row of time. It is found at compile time; a table without such a row does not
/// compile.
pub(super) const fn place_of_time(rows: &[Row]) -> usize {
    let mut place = 0;
    while !matches!(rows[place].role, Role::Time) {
        place += 1;
    }
    place
}
