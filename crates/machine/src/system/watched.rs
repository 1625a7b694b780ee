//! The event functions of an element in a state. Each is negative while the state lasts
//! (docs/assembly-law.md (A5)).

use super::System;
use crate::functional::Functional;
use crate::kernel::Sparse;
use crate::mode::{FrictionState, SliderState, StopState, Watch};

impl System {
    /// Event functions of a stop in a state, without the force of a closed stop.
    pub(crate) fn watched_of_stop(&self, i: usize, state: StopState) -> Vec<(Watch, Functional)> {
        let stop = &self.stops[i];
        let damped = stop.is_damped();
        let leaves = || (Watch::Leaves(i), -&stop.excess);
        match state {
            StopState::Open => vec![(Watch::Meets(i), stop.excess.clone())],
            StopState::Closed => Vec::new(),
            StopState::Below => vec![(Watch::Presses(i), stop.excess.clone())],
            StopState::Off => Vec::new(),
            StopState::Pressed if stop.is_gapless() => Vec::new(),
            // Without stiffness the force does not show where it ends.
            StopState::Pressed if stop.level.is_some() && !damped => vec![leaves()],
            StopState::Pressed if stop.turns() => vec![(Watch::Turns(i), -&stop.elongation.rate)],
            StopState::Pressed => {
                let Some(limited) = stop.limited() else { return vec![leaves()] };
                let cap = (stop.is_elastogap() && damped)
                    .then(|| (Watch::Changes(i), &stop.force - &(2.0 * &stop.spring)));
                // The force of a curved contact with dissipation is zero at the edge, too.
                let edge = stop.releases().then(leaves);
                std::iter::once((Watch::Changes(i), -limited)).chain(cap).chain(edge).collect()
            }
            StopState::Free => {
                let rises = stop.limited().map(|limited| (Watch::Changes(i), limited.clone()));
                rises.into_iter().chain([leaves()]).collect()
            }
            StopState::Capped => vec![(Watch::Changes(i), &(2.0 * &stop.spring) - &stop.force), leaves()],
            StopState::Rebounding => {
                vec![(Watch::Turns(i), stop.elongation.rate.clone()), leaves()]
            }
        }
    }

    /// Event functions of a friction in a state, with the levels of index `levels`, without the
    /// force of a sticking friction. If a level passes zero with the force of a stop that never
    /// pulls, the stop's own event function ends the mode.
    pub(crate) fn watched_of_friction(
        &self,
        i: usize,
        levels: Option<usize>,
        state: FrictionState,
    ) -> Vec<(Watch, Functional)> {
        let friction = &self.frictions[i];
        let Some(own) = levels.map(|place| &friction.levels[place]) else { return Vec::new() };
        let sign = if state == FrictionState::Off { 1.0 } else { -1.0 };
        let level = friction.passes.then(|| (Watch::Level(i), sign * &own.level));
        let slips = matches!(state, FrictionState::Up | FrictionState::Down);
        let stops = slips.then(|| (Watch::Stops(i), -state.direction() * &friction.elongation.rate));
        stops.into_iter().chain(level).collect()
    }

    /// Event functions of a branch in a state.
    pub(crate) fn watched_of_slider(&self, i: usize, state: SliderState) -> Vec<(Watch, Functional)> {
        let (branch, Some(level)) = (&self.branches[i], self.slip_level(i)) else { return Vec::new() };
        match state {
            SliderState::Off => Vec::new(),
            SliderState::Held => vec![
                (Watch::Yields(i, true), &branch.force - level),
                (Watch::Yields(i, false), -&(&branch.force + level)),
            ],
            state => vec![(Watch::Reverses(i), -&branch.slip_rate(state.direction()))],
        }
    }

    /// Whether a row is a negative constant, for example a constant friction level.
    pub(crate) fn is_constant_and_negative(&self, row: &Sparse) -> bool {
        matches!(row.terms(), [(j, x)] if *j == self.signals.one && *x < 0.0)
    }
}
