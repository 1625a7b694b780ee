//! Why a motion has no derivative from an instant on (docs/assembly-law.md, section 14).

use std::fmt;

/// The instant at which a motion loses its derivative by a parameter, and the reason.
#[derive(Clone, Debug, PartialEq)]
pub struct Lost {
    /// Time, s.
    pub time: f64,
    /// The element, such as `stop.NAME`, or the parameter of a step.
    pub element: String,
    /// The reason.
    pub cause: Cause,
}

impl Lost {
    /// The loss of a derivative whose value is not finite.
    pub(super) fn unknown(time: f64) -> Self {
        Self { time, element: "a value".into(), cause: Cause::Limit }
    }
}

/// The reason why a derivative does not exist.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// A limit is touched without speed, so that the changed motion may not reach it.
    Touch,
    /// Two events at one instant: their order depends on the change, and matters.
    Together,
    /// An extreme value that is reached at several times.
    Equal,
    /// A force that the law may divide between dependent contacts in any way.
    Shared,
    /// A value at its limit, so that the changed motion follows another law on each side.
    Limit,
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let reason = match self.cause {
            Cause::Touch => "only touches its limit",
            Cause::Together => "has an event together with another, and their order matters",
            Cause::Equal => "has its extreme value at several times",
            Cause::Shared => "shares its force with other contacts in a way that the law leaves open",
            Cause::Limit => "is at its limit, so that derivatives differ on both sides",
        };
        write!(f, "no derivative from t = {} s on: {} {reason}", self.time, self.element)
    }
}
