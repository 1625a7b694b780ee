//! Errors of components.

use crate::ffi::Fault;
use std::borrow::Cow;

/// Type of a component's refusals. It can be made from a [`Problem`], which the doors return for
/// the component, for instance for a function that it does not offer.
pub trait Refusal: std::error::Error + From<Problem> + 'static {
    /// Whether the refusal is due to a value that the model cannot accept. The component is then
    /// unchanged, and the host may continue with another value. FMI 3.0 has the status Discard for
    /// it (FMI 3.0.2, 2.2.4).
    fn is_of_a_value(&self) -> bool {
        false
    }
}

/// Reason why a call was refused, in either version.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refused<P: Refusal> {
    /// The component refuses.
    #[error(transparent)]
    Component(P),
    /// An impossible argument, or a panic.
    #[error(transparent)]
    Fault(Fault),
}

impl<P: Refusal> From<P> for Refused<P> {
    fn from(problem: P) -> Self {
        Self::Component(problem)
    }
}

impl<P: Refusal> From<Fault> for Refused<P> {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

/// Words about the type of a variable.
fn of_type(wanted: &str) -> String {
    if wanted.is_empty() { String::new() } else { format!(" of type {wanted}") }
}

/// Reason why a call was refused; the component is then unchanged. Each text states the variable,
/// its value and the valid values. A component may use this as its type of refusals.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// No variable of the requested types has that reference.
    #[error("value reference {reference} is not a variable{}: {found}", of_type(.wanted))]
    Reference {
        /// The reference.
        reference: u32,
        /// Description of the requested types; empty if any type will do.
        wanted: &'static str,
        /// Text about the variable with the reference or, without one, about the valid references.
        found: String,
    },
    /// The variable cannot be set in the present phase, or never.
    #[error("{name} cannot be set {phase}: only {allowed} can be set")]
    NotSettable {
        /// The variable.
        name: Cow<'static, str>,
        /// Description of the present phase.
        phase: &'static str,
        /// Variables that may be set.
        allowed: &'static str,
    },
    /// A value outside its range.
    #[error("{name} = {value}: expected {allowed}")]
    Value {
        /// The variable.
        name: Cow<'static, str>,
        /// The value.
        value: f64,
        /// The valid values.
        allowed: Cow<'static, str>,
    },
    /// The host's time is not the component's.
    #[error(
        "currentCommunicationPoint = {given} s, but the instance is at t = {own} s: the difference \
         must be at most 1e-9 max(1, |t|)"
    )]
    Time {
        /// The host's time.
        given: f64,
        /// The component's time.
        own: f64,
    },
    /// A step beyond the stop time.
    #[error("step to t = {end} s: must end by the stop time {stop} s, which was given before initialization")]
    StopTime {
        /// End of the step.
        end: f64,
        /// Stop time.
        stop: f64,
    },
    /// Another action must come first.
    #[error("{what}")]
    Sequence {
        /// The required action.
        what: Cow<'static, str>,
    },
    /// A saved state that does not fit or is damaged.
    #[error("saved state refused: {what}")]
    SavedState {
        /// The reason.
        what: Cow<'static, str>,
    },
    /// A step or an event that failed and could not be undone; the state of the instance is
    /// unknown.
    #[error(
        "{cause}. That could not be taken back: {refused}. Remedy: restore a saved state, or reset the instance"
    )]
    NotTakenBack {
        /// Reason of the failure.
        cause: String,
        /// Reason why the state before it was refused.
        refused: String,
    },
    /// A capability that this component does not offer.
    #[error("this FMU does not offer {what}: its model description says so")]
    NotOffered {
        /// The capability.
        what: &'static str,
    },
    /// An impossible argument.
    #[error(transparent)]
    Fault(#[from] Fault),
}

impl Problem {
    /// Error for a step or an event that failed and could not be undone.
    pub fn not_taken_back(cause: &impl ToString, refused: &impl ToString) -> Self {
        Self::NotTakenBack { cause: cause.to_string(), refused: refused.to_string() }
    }

    /// Error for a value outside its range.
    pub fn value(
        name: impl Into<Cow<'static, str>>,
        value: f64,
        allowed: impl Into<Cow<'static, str>>,
    ) -> Self {
        Self::Value { name: name.into(), value, allowed: allowed.into() }
    }
}

impl Refusal for Problem {
    fn is_of_a_value(&self) -> bool {
        matches!(self, Self::Value { .. })
    }
}

/// Refuses a capability that a component does not offer, by name.
pub(crate) fn not_offered<T, P: Refusal>(what: &'static str) -> Result<T, P> {
    Err(Problem::NotOffered { what }.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_a_reference_of_any_type_is_refused_without_a_type() {
        let of = |wanted| Problem::Reference { reference: 7, wanted, found: "expected 0 to 3".into() };
        assert_eq!(of("").to_string(), "value reference 7 is not a variable: expected 0 to 3");
        assert_eq!(
            of("Real").to_string(),
            "value reference 7 is not a variable of type Real: expected 0 to 3"
        );
    }
}
