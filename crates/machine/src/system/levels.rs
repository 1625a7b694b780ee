//! Parts of elements whose stiffness steps in time: one part for each level (docs/assembly-law.md
//! (A16)).

use super::{Part, StopLevel, StopRows, System};
use crate::mode::StopState;
use nalgebra::DVector;

impl StopRows {
    /// Whether the stiffness is at another level in an augmented state.
    pub fn is_off(&self, z: &DVector<f64>) -> bool {
        self.level.is_some_and(|own| own.is_off(z))
    }

    /// Whether this is a level of a spring, which acts at any elongation.
    pub fn is_gapless(&self) -> bool {
        self.level.is_some_and(|own| own.stop.is_none())
    }

    /// The energy stored in an augmented state while the stop acts: ½ k max(0, e - gap)², or ½ k
    /// e² for a level of a spring.
    pub(crate) fn stored(&self, z: &DVector<f64>) -> f64 {
        let excess = self.excess.dot(z);
        let excess = if self.is_gapless() { excess } else { excess.max(0.0) };
        0.5 * self.stiffness() * excess * excess
    }

    /// The state while nothing touches, with the stiffness at its first level.
    pub fn state_apart(&self) -> StopState {
        match (self.level, self.restitution()) {
            (_, Some(_)) => StopState::Open,
            (Some(own), _) if own.level != 0.0 => StopState::Off,
            (Some(StopLevel { stop: None, .. }), _) => StopState::Pressed,
            _ => StopState::Below,
        }
    }
}

impl System {
    /// Whether any stiffness steps.
    pub(crate) fn has_levels(&self) -> bool {
        self.stops.iter().any(|stop| stop.level.is_some())
    }

    /// The stop to which a part belongs; the part itself unless it is a further level.
    pub fn stop_of(&self, i: usize) -> usize {
        self.stops[i].level.and_then(|own| own.stop).unwrap_or(i)
    }

    /// The part of a stop at the mode's level.
    pub fn present(&self, i: usize, stops: &[StopState]) -> usize {
        self.levels_of(i).find(|&own| stops[own] != StopState::Off).unwrap_or(i)
    }

    /// The part of a stop at the level of an augmented state.
    pub(crate) fn present_at(&self, i: usize, z: &DVector<f64>) -> usize {
        self.levels_of(i).find(|&own| !self.stops[own].is_off(z)).unwrap_or(i)
    }

    /// The parts of a stop, by level; only itself if its stiffness does not step.
    pub(crate) fn levels_of(&self, i: usize) -> impl Iterator<Item = usize> {
        let own = self.stops[i].level.map(|_| Part::Stop(i));
        let parts = own.map(|part| &self.parts[self.element_of(part)][..]).unwrap_or_default();
        let all = parts.iter().filter_map(|part| if let Part::Stop(i) = *part { Some(i) } else { None });
        all.chain(own.is_none().then_some(i))
    }

    /// The energy, J, that steps of stiffnesses add on the way from the levels of a mode to the
    /// levels of an augmented state.
    pub(crate) fn switched(&self, stops: &[StopState], z: &DVector<f64>) -> f64 {
        let change = |(stop, state): (&StopRows, &StopState)| match (*state == StopState::Off, stop.is_off(z))
        {
            (true, false) => stop.stored(z),
            (false, true) => -stop.stored(z),
            _ => 0.0,
        };
        let stepped = self.stops.iter().zip(stops).filter(|(stop, _)| stop.level.is_some());
        stepped.map(change).sum()
    }
}
