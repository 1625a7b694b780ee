//! Rows that act on the augmented state: elongations, rates and forces of bodies and elements.

use super::formula::FormulaRows;
use crate::description::{DampingLimit, StopLaw};
use crate::functional::Functional;
use crate::mode::StopState;
use nalgebra::DVector;

/// The elongation e = Σ arm · s of an element, with its rate.
#[derive(Clone, Debug)]
pub struct Elongation {
    /// Elongation e.
    pub e: Functional,
    /// Rate e'.
    pub rate: Functional,
    /// The direction of its force on the coordinates, w = ∂e'/∂v; e'' = w·a + drift·z.
    pub w: Functional,
    /// Part of e'' due to prescribed bodies.
    pub drift: Functional,
    /// L⁻¹ w, with the Cholesky factor L of the mass matrix.
    pub column: Functional,
    /// The change of the velocities by a unit impulse, M⁻¹ w.
    pub mobility: Functional,
    /// The coordinates at which w, L⁻¹ w or M⁻¹ w is not zero, ascending.
    pub reach: Vec<usize>,
}

/// Rows of a body's coordinate.
#[derive(Clone, Debug)]
pub struct BodyRows {
    /// Coordinate s.
    pub s: Functional,
    /// Its rate.
    pub v: Functional,
    /// Weights of the accelerations: s'' = weights·a + drift·z.
    pub weights: Functional,
    /// Part of s'' due to prescribed bodies.
    pub drift: Functional,
}

/// Rows of a spring with a dashpot.
#[derive(Clone, Debug)]
pub struct SpringRows {
    /// Its elongation.
    pub elongation: Elongation,
    /// Stiffness, N/m or N m/rad.
    pub stiffness: f64,
    /// Damping, N s/m or N m s/rad.
    pub damping: f64,
    /// Preload, N or N m.
    pub preload: f64,
    /// Its force.
    pub force: Functional,
    /// Its curved forces, each by its index in [`System::curved`](super::System::curved), with its
    /// factor in `force`.
    pub curves: Vec<(usize, f64)>,
    /// The formula in its force, which is part of `force`.
    pub(crate) formula: Option<FormulaRows>,
}

/// One side of the limits of a continuous block's output. It is stored as a stop whose excess and
/// force both equal the output's excess beyond the limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct OutputLimit {
    /// Index of the block.
    pub block: usize,
    /// Index among its outputs.
    pub output: usize,
    /// Whether it is the upper limit.
    pub is_upper: bool,
}

impl SpringRows {
    /// Whether the force depends on the rate.
    pub fn has_losses(&self) -> bool {
        self.damping != 0.0 || self.formula.as_ref().is_some_and(|own| own.acts(true))
    }
}

/// Condition under which a row of a stepped stiffness acts: the stiffness is at this level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopLevel {
    /// The coordinate of the signal that counts the levels.
    pub counter: usize,
    /// The counter's value while the row acts.
    pub level: f64,
    /// The stop to which the row belongs; `None` for a spring, which has no gap.
    pub stop: Option<usize>,
}

impl StopLevel {
    /// Whether the stiffness is at another level.
    #[inline]
    pub fn is_off(&self, z: &DVector<f64>) -> bool {
        (z[self.counter] - self.level).abs() > 0.5
    }
}

/// Rows of a stop.
#[derive(Clone, Debug)]
pub struct StopRows {
    /// Its elongation.
    pub elongation: Elongation,
    /// e - gap; for a freewheel e'. A closed freewheel holds e' = 0, like a closed rigid stop
    /// e = gap.
    pub excess: Functional,
    /// Contact law.
    pub law: StopLaw,
    /// A compliant stop's force without its limit: stiffness (e - gap) + damping e'.
    pub force: Functional,
    /// The spring's share of a compliant stop's force: stiffness (e - gap).
    pub spring: Functional,
    /// Whether a friction element uses the stop's force as its normal force.
    pub is_followed: bool,
    /// The level at which the stop acts, if its stiffness steps in time.
    pub level: Option<StopLevel>,
    /// Whether this is a freewheel, which constrains the rate e' and not the elongation e.
    pub is_freewheel: bool,
    /// The limit of a continuous block's output, if this is one.
    pub limit: Option<OutputLimit>,
    /// Exponent and dissipation, if the force is curved.
    pub contact: Option<ContactRows>,
    /// Indices of the first-order states on which the force acts, and the decrease of each state's
    /// rate per unit of force.
    pub further: Vec<(usize, f64)>,
}

/// Rows of a stop whose force is stiffness xᵖ (1 + 3/2 dissipation x') + damping x', with x = e -
/// gap and the exponent p.
#[derive(Clone, Debug)]
pub struct ContactRows {
    /// Exponent p.
    pub exponent: f64,
    /// Dissipation, s/m or s/rad; 0 if the file does not give it.
    pub dissipation: f64,
    /// xᵖ.
    pub power: Functional,
    /// xᵖ x'; zero if the file does not give a dissipation.
    pub product: Functional,
    /// 1 + 3/2 dissipation x', which has the sign of the force; `None` if the file does not give a
    /// dissipation.
    pub release: Option<Functional>,
}

impl StopRows {
    /// The row with the sign of the limited force; `None` if the force has no limit, or is zero only
    /// at the edge.
    pub fn limited(&self) -> Option<&Functional> {
        match &self.contact {
            _ if !self.is_limited() => None,
            Some(contact) if contact.release.is_some() => contact.release.as_ref(),
            Some(_) if !self.is_damped() => None,
            _ => Some(&self.force),
        }
    }

    /// The restitution coefficient; `None` for a compliant stop.
    pub fn restitution(&self) -> Option<f64> {
        match self.law {
            StopLaw::Rigid { restitution } => Some(restitution),
            StopLaw::Compliant { .. } => None,
        }
    }

    /// Whether this is a rigid stop that keeps e <= gap, which a freewheel does not.
    pub fn keeps_gap(&self) -> bool {
        self.restitution().is_some() && !self.is_freewheel
    }

    /// The stiffness of a compliant stop, N/m or N m/rad; 0 for a rigid one.
    pub fn stiffness(&self) -> f64 {
        match self.law {
            StopLaw::Rigid { .. } => 0.0,
            StopLaw::Compliant { stiffness, .. } => stiffness,
        }
    }

    /// The state of a compliant stop just after it closes with speed: an `ElastoGap`'s dashpot
    /// starts at its limit.
    pub fn entered(&self) -> StopState {
        if self.is_elastogap() && self.is_damped() { StopState::Capped } else { StopState::Pressed }
    }

    /// Whether the stop has a dashpot.
    pub fn is_damped(&self) -> bool {
        self.force != self.spring
    }

    /// Whether the force is bounded: below by 0 (`NoPull`), or between 0 and a multiple of the
    /// spring's force (`Elastogap`).
    pub fn is_limited(&self) -> bool {
        matches!(self.law, StopLaw::Compliant { limit: DampingLimit::NoPull | DampingLimit::Elastogap, .. })
    }

    /// Whether the stop is a curved contact with dissipation.
    pub fn releases(&self) -> bool {
        self.contact.as_ref().is_some_and(|contact| contact.release.is_some())
    }

    /// Whether the dashpot acts only while e grows.
    pub fn turns(&self) -> bool {
        self.is_damped() && self.may_rebound()
    }

    /// The states of a compliant stop that have a force.
    pub fn states_with_force(&self) -> Vec<StopState> {
        let other = match self.law {
            _ if !self.is_damped() => None,
            StopLaw::Compliant { limit: DampingLimit::Elastogap, .. } => Some(StopState::Capped),
            StopLaw::Compliant { limit: DampingLimit::UndampedRebound, .. } => Some(StopState::Rebounding),
            _ => None,
        };
        std::iter::once(StopState::Pressed).chain(other).collect()
    }

    /// Whether the force may be negative.
    pub fn may_pull(&self) -> bool {
        matches!(self.law, StopLaw::Compliant { limit: DampingLimit::Pull, .. })
    }

    /// Whether the stop's law has no dashpot in the rebound.
    pub fn may_rebound(&self) -> bool {
        matches!(self.law, StopLaw::Compliant { limit: DampingLimit::UndampedRebound, .. })
    }

    /// Whether the dashpot's force is limited as in an `ElastoGap`.
    pub fn is_elastogap(&self) -> bool {
        matches!(self.law, StopLaw::Compliant { limit: DampingLimit::Elastogap, .. })
    }
}

/// Rows of a friction.
#[derive(Clone, Debug)]
pub struct FrictionRows {
    /// Its elongation.
    pub elongation: Elongation,
    /// Pairs of sliding and static level: one pair; for a friction that follows a stop, one for
    /// each stop state with a force.
    pub levels: Vec<LevelRows>,
    /// For each entry of `levels`, the index and the state of the followed stop. A stop with a
    /// stepped stiffness has one index for each stiffness level.
    pub follows: Option<Vec<(usize, StopState)>>,
    /// Whether the levels may change sign during contact, because the stop's force may pull.
    pub passes: bool,
    /// Whether the static level is given separately.
    pub has_static: bool,
}

/// The levels of a friction.
#[derive(Clone, Debug)]
pub struct LevelRows {
    /// Sliding level.
    pub level: Functional,
    /// Static level.
    pub static_level: Functional,
}

impl FrictionRows {
    /// Index in `levels` for the given stop states; `None` if the followed stop has no force.
    #[inline]
    pub fn place(&self, stops: &[StopState]) -> Option<usize> {
        match &self.follows {
            None => Some(0),
            Some(all) => all.iter().position(|(stop, state)| Some(state) == stops.get(*stop)),
        }
    }

    /// Sliding and static level for the given stop states; `None` as in [`place`](Self::place).
    #[inline]
    pub fn at(&self, stops: &[StopState]) -> Option<&LevelRows> {
        self.place(stops).map(|place| &self.levels[place])
    }
}

/// A first-order state.
#[derive(Clone, Debug)]
pub struct FirstOrder {
    /// The state's rate while it moves.
    pub rate: Functional,
    /// If the state is the spring stretch of a branch with a slider, the branch's index. The state
    /// changes only while the slider is held.
    pub slider: Option<usize>,
}
