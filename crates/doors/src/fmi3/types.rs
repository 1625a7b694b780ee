//! C types of the standard that are plain numbers (FMI 3.0.2, 2.2.3 and 2.2.4), with std's names
//! for the C types.

use crate::events::Handled;
use crate::values::DependencyKind;
use ::core::ffi::c_int;

/// `fmi3Boolean` and `fmi3Clock`: `bool` in C, read as a byte, since a host may have written any
/// byte.
pub type FmiBoolean = u8;
/// `fmi3Status`, as an integer.
pub type FmiStatus = c_int;
/// `fmi3DependencyKind`, as an integer.
pub type FmiDependencyKind = c_int;
/// `fmi3IntervalQualifier`, as an integer.
pub type FmiIntervalQualifier = c_int;

/// `fmi3DependencyKind` of a kind.
pub fn dependency_kind(kind: DependencyKind) -> FmiDependencyKind {
    match kind {
        DependencyKind::Constant => 1,
        DependencyKind::Fixed => 2,
        DependencyKind::Tunable => 3,
        DependencyKind::Discrete => 4,
        DependencyKind::Dependent => 5,
    }
}

/// The returned arguments of `fmi3UpdateDiscreteStates` (FMI 3.0.2, 2.3.5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscreteStates {
    /// Changes by the event.
    pub changed: Handled,
    /// The time of the next event, s, if known.
    pub next_event_time: Option<f64>,
}
