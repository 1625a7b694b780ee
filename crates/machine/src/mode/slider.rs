//! The states of sliders in series with springs (docs/assembly-law.md, section 15).

use super::Watch;
use crate::description::SeriesLaw;
use crate::system::{Functional, System};
use serde::{Deserialize, Serialize};

/// The state of a branch: a spring in series with its partner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum SliderState {
    /// The slider stands; so does that of every branch with a dashpot, which has none.
    Held,
    /// The force is at its level, and the slider follows e' > 0.
    Up,
    /// The same downwards.
    Down,
}

impl SliderState {
    /// The sign of e' while slipping, else 0.
    pub fn direction(self) -> f64 {
        match self {
            Self::Up => 1.0,
            Self::Down => -1.0,
            Self::Held => 0.0,
        }
    }

    /// The slipping state in a direction.
    pub fn slipping(direction: f64) -> Self {
        if direction > 0.0 { Self::Up } else { Self::Down }
    }
}

impl System {
    /// All branches with their sliders held.
    pub fn held_sliders(&self) -> Vec<SliderState> {
        vec![SliderState::Held; self.branches.len()]
    }

    /// The level of a branch with a slider, as a row.
    pub(crate) fn slip_level(&self, i: usize) -> Option<Functional> {
        match self.branches[i].law {
            SeriesLaw::Slider { slip } => Some(self.constant(slip)),
            SeriesLaw::Dashpot { .. } => None,
        }
    }

    /// Functionals that are watched for a branch in a state.
    pub(crate) fn watched_of_slider(&self, i: usize, state: SliderState) -> Vec<(Watch, Functional)> {
        let (branch, Some(level)) = (&self.branches[i], self.slip_level(i)) else { return Vec::new() };
        match state {
            SliderState::Held => vec![
                (Watch::Yields(i, true), &branch.force - &level),
                (Watch::Yields(i, false), -&(&branch.force + &level)),
            ],
            state => vec![(Watch::Reverses(i), -state.direction() * &branch.elongation.rate)],
        }
    }
}
