//! The states of stops and frictions in a mode.

use serde::{Deserialize, Serialize};

/// The state of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum StopState {
    /// A rigid stop with e < gap, or with e = gap and separating.
    Open,
    /// A rigid stop held at e = gap.
    Closed,
    /// A compliant stop with e < gap.
    Below,
    /// A compliant stop with its linear force.
    Pressed,
    /// A compliant stop beyond its gap whose linear force would pull: the force is 0.
    Free,
    /// An `ElastoGap` whose dashpot's force is limited to its spring's: the force is 2 stiffness (e
    /// - gap).
    Capped,
}

impl StopState {
    /// Whether it is a compliant stop with e beyond the gap.
    pub fn is_inside(self) -> bool {
        matches!(self, Self::Pressed | Self::Free | Self::Capped)
    }
}

/// The state of a friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum FrictionState {
    /// Its level is not positive.
    Off,
    /// e' > 0.
    Up,
    /// e' < 0.
    Down,
    /// e' = 0. The force follows from the motion, or is 0 where the contact depends on others.
    Stuck,
    /// e' = 0. The contact depends on others, and its share of their force is its level upwards.
    HeldUp,
    /// e' = 0. The contact depends on others, and its share of their force is its level downwards.
    HeldDown,
}

impl FrictionState {
    /// The sign of e' while slipping, else 0.
    pub fn direction(self) -> f64 {
        match self {
            Self::Up => 1.0,
            Self::Down => -1.0,
            Self::Off | Self::Stuck | Self::HeldUp | Self::HeldDown => 0.0,
        }
    }

    /// Whether e' is kept at zero.
    pub fn sticks(self) -> bool {
        matches!(self, Self::Stuck | Self::HeldUp | Self::HeldDown)
    }
}
