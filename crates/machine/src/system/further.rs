//! Corners and levels of springs among the stops, and friction that follows a stop.

use super::{FrictionRows, LevelRows, Part, System};
use crate::description::{Arms, Follows};

impl System {
    /// Whether a stop is a corner of a spring's force, or one of a spring's levels.
    pub fn is_corner(&self, stop: usize) -> bool {
        let is_own = (self.first_corner..self.first_freewheel).contains(&stop);
        is_own && self.stops[stop].level.is_none_or(|own| own.stop.is_none())
    }

    /// Adds a friction whose levels follow the force of a stop.
    pub(super) fn add_following(&mut self, arms: &Arms, follows: &Follows) -> Vec<Part> {
        let all = self.levels_of(follows.stop);
        let states: Vec<_> =
            all.flat_map(|i| self.stops[i].states_with_force().into_iter().map(move |s| (i, s))).collect();
        let largest = follows.static_coefficient.unwrap_or(follows.coefficient);
        let levels = states.iter().filter_map(|&(i, state)| {
            let force = self.stop_force(i, state)?;
            let (level, largest) = (follows.coefficient * &force, largest * &force);
            Some(LevelRows { level, static_level: largest })
        });
        let rows = FrictionRows {
            elongation: self.elongation(arms),
            levels: levels.collect(),
            passes: self.stops[follows.stop].may_pull(),
            follows: Some(states.clone()),
            has_static: follows.static_coefficient.is_some(),
        };
        states.iter().for_each(|own| self.stops[own.0].is_followed = true);
        self.frictions.push(rows);
        vec![Part::Friction(self.frictions.len() - 1)]
    }
}
