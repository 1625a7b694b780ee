//! Parts whose force depends on that of others: corners of springs by points, friction that follows
//! a stop.

use super::{FrictionRows, Functional, LevelRows, Part, System};
use crate::description::{Arms, DampingLimit, Description, Follows, StopLaw};
use crate::polyline::Polyline;

impl System {
    /// Adds the corners of springs by points, behind all stops.
    pub(super) fn add_corners(&mut self, d: &Description) {
        for (i, spring) in d.springs.iter().enumerate().filter(|(_, spring)| !spring.points.is_empty()) {
            let line = Polyline::new(&spring.points);
            self.stored_at_zero += line.energy_at_zero();
            for &(e, stiffness) in &line.corners {
                let law = StopLaw::Compliant { stiffness, damping: 0.0, limit: DampingLimit::Pull };
                let corner = self.add_stop(&spring.arms, e, law);
                self.parts[i].extend(corner);
            }
        }
    }

    /// Whether a stop is a corner of a spring's force.
    pub fn is_corner(&self, stop: usize) -> bool {
        (self.first_corner..self.first_freewheel).contains(&stop)
    }

    /// Adds a friction whose levels follow the force of a stop.
    pub(super) fn add_following(&mut self, arms: &Arms, follows: &Follows) -> Vec<Part> {
        let stop = &self.stops[follows.stop];
        let states = stop.states_with_force();
        let largest = follows.static_coefficient.unwrap_or(follows.coefficient);
        let levels = states.iter().filter_map(|&state| {
            let force = self.stop_force(follows.stop, state)?;
            let (level, largest) = (follows.coefficient * &force, largest * &force);
            Some(LevelRows { level, static_level: Functional::of(largest) })
        });
        let rows = FrictionRows {
            elongation: self.elongation(arms),
            levels: levels.collect(),
            passes: stop.may_pull(),
            follows: Some((follows.stop, states)),
            has_static: follows.static_coefficient.is_some(),
        };
        self.stops[follows.stop].is_followed = true;
        self.frictions.push(rows);
        vec![Part::Friction(self.frictions.len() - 1)]
    }
}
