//! Reasons for a failed step of an iteration.

use vibro_studies::Error;

/// Reason why some phases and parameters have no orbit.
#[derive(Debug)]
pub(super) enum Obstacle {
    /// The impacts are not in the order of the word.
    Order,
    /// The motion without impacts has a neutral direction: σI - M is singular.
    Singular,
    /// The impulses of the word cannot balance the load on a body without a spring.
    Unbalanced,
    /// A symmetric orbit was requested of an asymmetric machine.
    Asymmetric,
    /// Newton's method did not converge.
    NoConvergence,
    /// The phases given for a special point are far from any orbit of the machine.
    OtherMachine,
    /// The parameters are refused with an error.
    Refused(Error),
}

impl From<Error> for Obstacle {
    fn from(error: Error) -> Self {
        Self::Refused(error)
    }
}
