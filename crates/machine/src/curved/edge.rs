//! Powers with an edge at 0: the force of a contact and powers with two sides
//! (docs/assembly-law.md, section 22).
//!
//! On each side of its edge such a power is an operation without an edge. If its exponent is not an
//! integer, it has no power series at the edge itself. So near is the edge that the force is below
//! the rounding of the motion, the operation then counts as 0: the bound of the remainder includes
//! its largest value.

use super::{LOWEST, Operation, POWERS, Polynomial};

/// The side of the edge on which a power series begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Piece {
    /// An operation without an edge; for a power with an edge, the side of its argument.
    #[default]
    Whole,
    /// The value counts as 0: the argument is at the edge, or the power does not act.
    Still,
    /// The argument is positive.
    Positive,
    /// The argument is negative.
    Negative,
}

/// A power as a polynomial, if its exponent is an integer up to the highest one of a polynomial.
fn polynomial(exponent: f64) -> Option<Polynomial> {
    let place = (0..POWERS).find(|i| (i + LOWEST) as f64 == exponent)?;
    let mut force = Polynomial::default();
    force.coefficients[place] = 1.0;
    Some(force)
}

impl Piece {
    /// The side of an argument. Within `rounding` of the edge a power with an exponent that is not
    /// an integer counts as 0.
    pub fn of(operation: &Operation, a: f64, rounding: f64) -> Self {
        let is_near = a.abs() <= rounding;
        match operation {
            Operation::OneSided(p) if polynomial(*p).is_some() => Self::Positive,
            Operation::OneSided(_) if is_near || a < 0.0 => Self::Still,
            Operation::TwoSided(_) | Operation::Decay if is_near => Self::Still,
            Operation::OneSided(_) => Self::Positive,
            Operation::TwoSided(_) | Operation::Decay if a < 0.0 => Self::Negative,
            Operation::TwoSided(_) | Operation::Decay => Self::Positive,
            _ => Self::Whole,
        }
    }

    /// Sign of the argument; 0 if the value counts as 0.
    pub fn sign(self) -> f64 {
        match self {
            Self::Still => 0.0,
            Self::Whole | Self::Positive => 1.0,
            Self::Negative => -1.0,
        }
    }
}

impl Operation {
    /// Whether the power series of a power with an edge ends at the edge.
    pub fn ends_at_edge(&self) -> bool {
        self.edge().is_some_and(|p| polynomial(p).is_none())
    }

    /// The operation without an edge that has the value, up to its sign, on one side, of the
    /// argument times the sign of the side. At the edge it is this operation itself.
    #[inline(always)]
    pub fn on(&self, piece: Piece) -> Self {
        match self.edge() {
            Some(p) if piece != Piece::Still => polynomial(p).map_or(Self::Power(p), Self::Polynomial),
            _ => *self,
        }
    }
}
