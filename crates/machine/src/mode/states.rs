//! The states of stops, frictions and sliders in a mode.

use serde::{Deserialize, Serialize};
use std::ops::{Mul, Neg};

/// The state of a stop.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum StopState {
    /// A rigid stop with e < gap, or with e = gap and separating; a freewheel with e' < 0.
    Open,
    /// A rigid stop held at e = gap; a freewheel held at e' = 0.
    Closed,
    /// A compliant stop with e < gap.
    Below,
    /// A compliant stop with its linear force.
    Pressed,
    /// A compliant stop beyond its gap whose linear force would pull: the force is 0.
    Free,
    /// An `ElastoGap` stop whose dashpot force is limited to its spring force: the force is 2
    /// stiffness (e - gap).
    Capped,
    /// A stop with the law `undamped-rebound` while e falls: the spring's force alone.
    Rebounding,
    /// A part of an element whose stiffness steps in time and now has another level.
    Off,
}

impl StopState {
    /// The force of a compliant stop in this state, given the linear force of spring and dashpot
    /// and the spring's share of it; `None` if the force is zero.
    pub fn force<R: Clone>(self, linear: &R, spring: &R) -> Option<R>
    where
        f64: for<'r> Mul<&'r R, Output = R>,
    {
        match self {
            Self::Pressed => Some(linear.clone()),
            Self::Capped => Some(2.0 * spring),
            Self::Rebounding => Some(spring.clone()),
            Self::Open | Self::Closed | Self::Below | Self::Free | Self::Off => None,
        }
    }

    /// Whether the stop is compliant and has a force.
    pub fn has_force(self) -> bool {
        matches!(self, Self::Pressed | Self::Capped | Self::Rebounding)
    }

    /// Whether the stop is compliant and e is beyond the gap.
    pub fn is_inside(self) -> bool {
        matches!(self, Self::Pressed | Self::Free | Self::Capped | Self::Rebounding)
    }
}

/// The state of a friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum FrictionState {
    /// The level is not positive.
    Off,
    /// e' > 0.
    Up,
    /// e' < 0.
    Down,
    /// e' = 0. The force follows from the motion, or is 0 if the contact depends on others.
    Stuck,
    /// e' = 0. The contact depends on others; its share of their force is its level upwards.
    HeldUp,
    /// e' = 0. The contact depends on others; its share of their force is its level downwards.
    HeldDown,
}

impl FrictionState {
    /// The force of a friction in this state, given its sliding and static levels; `None` if the
    /// state does not determine it.
    pub fn force<R: Clone>(self, level: &R, static_level: &R) -> Option<R>
    where
        for<'r> &'r R: Neg<Output = R>,
    {
        match self {
            Self::Up => Some(level.clone()),
            Self::Down => Some(-level),
            Self::HeldUp => Some(static_level.clone()),
            Self::HeldDown => Some(-static_level),
            Self::Off | Self::Stuck => None,
        }
    }

    /// Sign of e' while slipping, otherwise 0.
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

/// The state of a branch: a spring in series with a dashpot or slider.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum SliderState {
    /// The slider is at rest. A branch with a dashpot is always in this state.
    Held,
    /// The force is at its level, and the slider follows e' > 0.
    Up,
    /// The force is at its level, and the slider follows e' < 0.
    Down,
    /// The slider of an open contact: it follows e without a force.
    Off,
}

impl SliderState {
    /// Sign of e' while slipping, otherwise 0.
    pub fn direction(self) -> f64 {
        match self {
            Self::Up => 1.0,
            Self::Down => -1.0,
            Self::Held | Self::Off => 0.0,
        }
    }

    /// The slipping state in a direction.
    pub fn slipping(direction: f64) -> Self {
        if direction > 0.0 { Self::Up } else { Self::Down }
    }
}
