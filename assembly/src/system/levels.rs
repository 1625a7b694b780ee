//! Parts of elements whose stiffness steps in time: one for each level (docs/assembly-law.md
//! (A16)).

use super::{Part, StopRows, System};
use crate::description::{DampingLimit, Description, StopLaw};
use crate::functional::Functional;
use crate::mode::StopState;
use crate::stepped;
use nalgebra::DVector;

/// A part that acts while a stiffness that steps has one of its levels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopLevel {
    /// The coordinate of the signal that counts the levels.
    pub counter: usize,
    /// The level, which the counter has while the part acts.
    pub level: f64,
    /// The stop to whose section it belongs; `None` for that of a spring, which has no gap.
    pub stop: Option<usize>,
}

impl StopLevel {
    /// Whether another level holds.
    #[inline]
    pub fn is_off(&self, z: &DVector<f64>) -> bool {
        (z[self.counter] - self.level).abs() > 0.5
    }
}

impl StopRows {
    /// Whether its stiffness has another level in an augmented state.
    pub fn is_off(&self, z: &DVector<f64>) -> bool {
        self.level.is_some_and(|own| own.is_off(z))
    }

    /// Whether it is a level of a spring, which acts whatever its elongation.
    pub fn is_gapless(&self) -> bool {
        self.level.is_some_and(|own| own.stop.is_none())
    }

    /// The energy that it stores in an augmented state in which it acts, ½ k max(0, e - gap)².
    pub(crate) fn stored(&self, z: &DVector<f64>) -> f64 {
        let excess = self.excess.dot(z);
        let excess = if self.is_gapless() { excess } else { excess.max(0.0) };
        0.5 * self.stiffness() * excess * excess
    }

    /// The state of a machine's elements apart from each other, with stiffness at its first level.
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
    /// Adds a part for each further level of stops, and for each level of springs, behind the stops
    /// of the sections.
    pub(super) fn add_levels(&mut self, d: &Description, counters: &[Functional]) {
        let mut counters = counters.iter().map(|row| row.imax());
        for (i, stop) in d.stops.iter().enumerate() {
            let Some(signal) = &stop.stepped else { continue };
            let counter = counters.next().unwrap_or_default();
            let StopLaw::Compliant { damping, limit, .. } = stop.law else { continue };
            let element = self.element_of(Part::Stop(i));
            for (level, stiffness) in stepped::levels(signal).into_iter().enumerate() {
                let law = StopLaw::Compliant { stiffness, damping, limit };
                let own = StopLevel { counter, level: level as f64, stop: Some(i) };
                if level == 0 {
                    self.put_level(i, own, law);
                } else {
                    let parts = self.add_stop(&stop.arms, stop.gap, law);
                    self.put_level(self.stops.len() - 1, own, law);
                    self.parts[element].extend(parts);
                }
            }
        }
        for (i, spring) in d.springs.iter().enumerate() {
            let Some(signal) = &spring.stepped else { continue };
            let counter = counters.next().unwrap_or_default();
            for (level, stiffness) in stepped::levels(signal).into_iter().enumerate() {
                let law = StopLaw::Compliant { stiffness, damping: 0.0, limit: DampingLimit::Pull };
                let parts = self.add_stop(&spring.arms, 0.0, law);
                let own = StopLevel { counter, level: level as f64, stop: None };
                self.put_level(self.stops.len() - 1, own, law);
                self.parts[i].extend(parts);
            }
        }
    }

    /// Gives a stop the stiffness of a level.
    fn put_level(&mut self, i: usize, level: StopLevel, law: StopLaw) {
        let StopLaw::Compliant { stiffness, damping, .. } = law else { return };
        let stop = &mut self.stops[i];
        let spring = stiffness * &stop.excess;
        let force = &spring + &(damping * &stop.elongation.rate);
        (stop.law, stop.level) = (law, Some(level));
        [stop.force, stop.spring] = [force, spring];
    }

    /// Whether any stiffness steps.
    pub(crate) fn has_levels(&self) -> bool {
        self.stops.iter().any(|stop| stop.level.is_some())
    }

    /// The stop of whose section a stop's part is; itself but for a further level.
    pub fn stop_of(&self, i: usize) -> usize {
        self.stops[i].level.and_then(|own| own.stop).unwrap_or(i)
    }

    /// The part of a stop that has the present level.
    pub fn present(&self, i: usize, stops: &[StopState]) -> usize {
        self.levels_of(i).find(|&own| stops[own] != StopState::Off).unwrap_or(i)
    }

    /// The part of a stop that has the level of an augmented state.
    pub(crate) fn present_at(&self, i: usize, z: &DVector<f64>) -> usize {
        self.levels_of(i).find(|&own| !self.stops[own].is_off(z)).unwrap_or(i)
    }

    /// The parts of a stop, by level; itself alone where its stiffness does not step.
    pub(crate) fn levels_of(&self, i: usize) -> impl Iterator<Item = usize> {
        let own = self.stops[i].level.map(|_| Part::Stop(i));
        let parts = own.map(|part| &self.parts[self.element_of(part)][..]).unwrap_or_default();
        let all = parts.iter().filter_map(|part| if let Part::Stop(i) = *part { Some(i) } else { None });
        all.chain(own.is_none().then_some(i))
    }

    /// What the steps of stiffnesses put in from the levels of a mode to those of an augmented
    /// state, J.
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
