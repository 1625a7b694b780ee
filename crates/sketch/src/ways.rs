//! Direction of the coordinates in the picture. Layouts have places (along, across): along the
//! row of bodies in the direction of their coordinates, and across it.

use crate::order::Side;
use vibro_machine::Description;
use vibro_machine::description::BodyKind;

/// Direction of the coordinates in the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Way {
    /// Without gravity; also if gravity acts along one body's coordinate and against another's:
    /// then no direction is right.
    #[default]
    Right,
    /// Gravity along the coordinates.
    Down,
    /// Gravity against the coordinates.
    Up,
}

impl Way {
    /// The direction for a machine: bodies fall downwards.
    pub(crate) fn of(machine: &Description) -> Self {
        let cosine = |body: &BodyKind| match body {
            BodyKind::Free(free) if machine.gravity > 0.0 => free.gravity,
            _ => 0.0,
        };
        let cosines = || machine.bodies.iter().map(|body| cosine(&body.kind));
        match (cosines().any(|x| x > 0.0), cosines().any(|x| x < 0.0)) {
            (true, false) => Self::Down,
            (false, true) => Self::Up,
            _ => Self::Right,
        }
    }

    pub(crate) fn is_upright(self) -> bool {
        self != Self::Right
    }

    /// The side of the row that is below.
    pub(crate) fn floor(self) -> Option<Side> {
        match self {
            Self::Right => None,
            Self::Down => Some(Side::Right),
            Self::Up => Some(Side::Left),
        }
    }

    /// The point of the picture for a place of a row of some length.
    pub(crate) fn point(self, (along, across): (f64, f64), length: f64) -> (f64, f64) {
        match self {
            Self::Right => (along, across),
            Self::Down => (across, along),
            Self::Up => (across, length - along),
        }
    }
}
