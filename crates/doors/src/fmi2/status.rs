//! Kinds of status, and the rules for log messages that only FMI 2.0 has (FMI 2.0, 2.1.5 and
//! 4.2.3).

use crate::log::{Categories, Category};
use crate::messages::c_text;
use crate::problem::Problem;
use std::ffi::CString;

/// `fmi2StatusKind` (FMI 2.0, 4.2.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StatusKind {
    /// Status of an asynchronous step; no step is asynchronous.
    DoStepStatus,
    /// Pending status of an asynchronous step; no step is asynchronous.
    PendingStatus,
    /// Time reached by the last step.
    LastSuccessfulTime,
    /// Whether the instance wants to end the simulation; it never does.
    Terminated,
}

impl StatusKind {
    /// The kind for a number of the C enumeration.
    ///
    /// # Errors
    /// [`Problem::Value`] for any other number.
    pub fn from_number(number: i32) -> Result<Self, Problem> {
        match number {
            0 => Ok(Self::DoStepStatus),
            1 => Ok(Self::PendingStatus),
            2 => Ok(Self::LastSuccessfulTime),
            3 => Ok(Self::Terminated),
            _ => Err(Problem::value(
                "fmi2StatusKind",
                f64::from(number),
                "0 (fmi2DoStepStatus), 1 (fmi2PendingStatus), 2 (fmi2LastSuccessfulTime) or 3 (fmi2Terminated)",
            )),
        }
    }

    /// The message for a status that is not available, or is read with the wrong function.
    pub fn not_available(self) -> &'static str {
        match self {
            Self::DoStepStatus => "fmi2DoStepStatus is not available: steps are synchronous",
            Self::PendingStatus => "fmi2PendingStatus is not available: steps are synchronous",
            Self::LastSuccessfulTime => "fmi2LastSuccessfulTime is a Real: use fmi2GetRealStatus",
            Self::Terminated => "fmi2Terminated is a Boolean: use fmi2GetBooleanStatus",
        }
    }
}

/// Categories enabled at instantiation: all of them if debug logging is on, otherwise the ones
/// that a user should always see (FMI 2.0, 2.1.3), which are warnings, errors and fatal errors.
pub fn enabled_at_start(logging_on: bool) -> Categories {
    if logging_on {
        return Categories::ALL;
    }
    let always = [Category::Warnings, Category::Refusals, Category::Failures];
    always.into_iter().fold(Categories::NONE, |set, category| set.with(category, true))
}

/// A message for the host's logger: the host formats it as printf does, without arguments, and
/// reads # as the start of a variable reference (FMI 2.0, 2.1.5).
pub fn finished(message: &str) -> CString {
    c_text(&message.replace('%', "%%").replace('#', "##"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invariant_what_a_user_should_see_in_any_case_is_enabled_at_start() {
        let quiet = enabled_at_start(false);
        assert!(quiet.contains(Category::Refusals) && !quiet.contains(Category::Events));
        assert_eq!(enabled_at_start(true), Categories::ALL);
    }
}
