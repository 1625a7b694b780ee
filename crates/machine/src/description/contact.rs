//! Contacts with a normal stiffness, and friction along one or two tangents.

use super::{Arms, DampingLimit, StopLaw};

/// A contact with a finite normal stiffness. Let x = e - gap. Its normal force is N = max(0,
/// stiffness x + damping e') where x >= 0 and 0 elsewhere. Each [`Tangent`] adds a spring and a
/// slider along the tangent; the slider's limit is the coefficient of friction times N, also for
/// each of two tangents (docs/assembly-law.md, section 24).
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Its name, unique among the elements.
    pub name: String,
    /// Its normal elongation e.
    pub normal: Arms,
    /// Where the contact closes.
    pub closing: Closing,
    /// Normal stiffness, N/m; positive. It is infinite for a rigid contact, whose ends have residual
    /// flexibility.
    pub stiffness: f64,
    /// Damping along the normal, N s/m; not negative, and 0 with friction.
    pub damping: f64,
    /// Coefficient of friction, not negative; 0 without tangents.
    pub friction: f64,
    /// Tangents along which friction acts: none, one, or two with the cone "box".
    pub tangents: Vec<Tangent>,
}

/// Where a contact closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Closing {
    /// The value of e at which the contact closes, m.
    Gap(f64),
    /// The normal force at e = 0, N. The gap is -preload / stiffness.
    Preload(f64),
}

/// Spring and slider of a contact along a tangent: |T| <= friction N, with T = stiffness (e - w)
/// and the place w of the slider.
#[derive(Clone, Debug, PartialEq)]
pub struct Tangent {
    /// The tangential elongation e.
    pub arms: Arms,
    /// Tangential stiffness, N/m; positive.
    pub stiffness: f64,
    /// w at time 0, m.
    pub slider: f64,
}

impl Contact {
    /// The end of the names of what belongs to a tangent: empty for the only one, `[0]` and `[1]`
    /// for two.
    pub(crate) fn index_of(&self, tangent: usize) -> &'static str {
        match (self.tangents.len(), tangent) {
            (..=1, _) => "",
            (_, 0) => "[0]",
            _ => "[1]",
        }
    }

    /// The value of e at which the contact closes.
    pub fn gap(&self) -> f64 {
        match self.closing {
            Closing::Gap(gap) => gap,
            Closing::Preload(preload) => -preload / self.stiffness,
        }
    }

    /// The derivative of the gap; `along` has the derivatives of this contact's numbers.
    pub(crate) fn gap_along(&self, along: &Self) -> f64 {
        match along.closing {
            Closing::Gap(gap) => gap,
            Closing::Preload(preload) => -(preload + self.gap() * along.stiffness) / self.stiffness,
        }
    }

    /// The law along the normal. A contact with friction has no dashpot, so that its force ends at
    /// the gap.
    pub(crate) fn law(&self) -> StopLaw {
        let Self { stiffness, damping, .. } = *self;
        let limit = if self.tangents.is_empty() { DampingLimit::NoPull } else { DampingLimit::Pull };
        StopLaw::Compliant { stiffness, damping, limit }
    }
}
