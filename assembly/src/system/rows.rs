//! Rows that act on the augmented state: elongations, rates and forces of bodies and elements.

use crate::description::{DampingLimit, StopLaw};
use crate::kernel::Sparse;
use crate::mode::states::StopState;
use nalgebra::DVector;
use std::ops::Deref;

/// A row that acts on the augmented state.
pub type StateRow = DVector<f64>;

/// A row with the list of its terms, by which its values are found.
#[derive(Clone, Debug, PartialEq)]
pub struct Functional {
    row: StateRow,
    terms: Sparse,
}

impl Functional {
    /// Of a row.
    pub fn of(row: StateRow) -> Self {
        let terms = Sparse::of(row.as_slice());
        Self { row, terms }
    }

    /// Its value.
    #[inline(always)]
    pub fn at(&self, z: &[f64]) -> f64 {
        self.terms.dot(z)
    }

    /// Its terms that are not zero, with their places.
    #[inline(always)]
    pub fn terms(&self) -> &[(usize, f64)] {
        self.terms.terms()
    }

    /// The sum of its terms' sizes, for a vector of sizes.
    #[inline(always)]
    pub fn size(&self, sizes: &[f64]) -> f64 {
        self.terms.size(sizes)
    }
}

impl Deref for Functional {
    type Target = StateRow;

    fn deref(&self) -> &StateRow {
        &self.row
    }
}

/// What is common to all elements: the elongation e = Σ arm · s and its rate.
#[derive(Clone, Debug)]
pub struct Elongation {
    /// e.
    pub e: StateRow,
    /// e'.
    pub rate: Functional,
    /// The direction in which its force acts on the coordinates, w = ∂e'/∂v; the acceleration is
    /// e'' = w·a + drift·z.
    pub w: DVector<f64>,
    /// The part of e'' that prescribed bodies make.
    pub drift: StateRow,
    /// L⁻¹ w.
    pub column: DVector<f64>,
    /// The change of the velocities by a unit of impulse, M⁻¹ w.
    pub mobility: DVector<f64>,
}

/// A body's coordinate.
#[derive(Clone, Debug)]
pub struct BodyRows {
    /// s.
    pub s: StateRow,
    /// Its rate.
    pub v: StateRow,
    /// s'' = weights·a + drift·z.
    pub weights: DVector<f64>,
    /// The part that prescribed bodies make.
    pub drift: StateRow,
}

/// A spring with its dashpot.
#[derive(Clone, Debug)]
pub struct SpringRows {
    /// Its elongation.
    pub elongation: Elongation,
    /// N/m.
    pub stiffness: f64,
    /// N s/m.
    pub damping: f64,
    /// N.
    pub preload: f64,
    /// Its force.
    pub force: StateRow,
}

/// A stop.
#[derive(Clone, Debug)]
pub struct StopRows {
    /// Its elongation.
    pub elongation: Elongation,
    /// e - gap.
    pub excess: Functional,
    /// What it does.
    pub law: StopLaw,
    /// A compliant stop's force where its law is linear: stiffness (e - gap) + damping e'.
    pub force: Functional,
    /// The force of its spring alone: stiffness (e - gap).
    pub spring: Functional,
}

impl StopRows {
    /// The restitution coefficient of a rigid stop.
    pub fn restitution(&self) -> Option<f64> {
        match self.law {
            StopLaw::Rigid { restitution } => Some(restitution),
            StopLaw::Compliant { .. } => None,
        }
    }

    /// The stiffness of a compliant stop; 0 of a rigid one, N/m or N m/rad.
    pub fn stiffness(&self) -> f64 {
        match self.law {
            StopLaw::Rigid { .. } => 0.0,
            StopLaw::Compliant { stiffness, .. } => stiffness,
        }
    }

    /// The state of a compliant stop that is entered with speed: an `ElastoGap`'s dashpot is at its
    /// cap there.
    pub fn entered(&self) -> StopState {
        if self.is_elastogap() && self.force != self.spring { StopState::Capped } else { StopState::Pressed }
    }

    /// Whether the dashpot's share is limited as in an `ElastoGap`.
    pub fn is_elastogap(&self) -> bool {
        matches!(self.law, StopLaw::Compliant { limit: DampingLimit::Elastogap, .. })
    }
}

/// Friction.
#[derive(Clone, Debug)]
pub struct FrictionRows {
    /// Its elongation.
    pub elongation: Elongation,
    /// The level while slipping.
    pub level: StateRow,
    /// The level up to which it sticks.
    pub static_level: StateRow,
    /// Whether the two differ.
    pub has_static: bool,
}
