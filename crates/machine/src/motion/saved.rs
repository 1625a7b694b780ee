//! Checks of saved states that come from outside.

use super::{Due, Hybrid};
use crate::assembly::Assembly;
use crate::description::StopLaw;
use crate::mode::{Contact, SliderState, StopState, Watch};
use crate::system::BranchRows;

impl Hybrid {
    /// Whether this can be a state of a motion of the machine: lengths agree, numbers are finite,
    /// and elements exist and are in states of their law. Required before
    /// [`restore`](super::Motion::restore) of a state that was read from bytes.
    pub fn fits(&self, assembly: &Assembly) -> bool {
        let system = assembly.system();
        let (size, stops, frictions) = (system.signals.size, system.stops.len(), system.frictions.len());
        let finite = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite());
        let is_slider = |i: usize| system.branches.get(i).is_some_and(BranchRows::is_slider);
        let slides = |(i, state): (usize, &SliderState)| match system.branches[i].stop() {
            Some(stop) => {
                let is_off =
                    system.branches[i].is_frictionless() || self.mode.stops[stop] != StopState::Pressed;
                (*state == SliderState::Off) == is_off
            }
            None => *state == SliderState::Held || (*state != SliderState::Off && is_slider(i)),
        };
        let known = |watch: &Watch| match *watch {
            Watch::Meets(i)
            | Watch::Opens(i)
            | Watch::Presses(i)
            | Watch::Changes(i)
            | Watch::Leaves(i)
            | Watch::Turns(i) => i < stops,
            Watch::Stops(i) | Watch::Slips(i, _) | Watch::Level(i) => i < frictions,
            Watch::Yields(i, _) | Watch::Reverses(i) => is_slider(i),
        };
        let there = |contact: &Contact| match *contact {
            Contact::Stop(i) => self.mode.stops.get(i) == Some(&StopState::Closed),
            Contact::Friction(i) => self.mode.frictions.get(i).is_some_and(|state| state.sticks()),
            Contact::Slider(_) => false,
        };
        let of_its_law = self.mode.stops.iter().zip(&system.stops).all(|(state, stop)| {
            let rigid = matches!(state, StopState::Open | StopState::Closed);
            let law = match state {
                StopState::Free | StopState::Capped => stop.is_limited(),
                StopState::Rebounding => stop.may_rebound(),
                StopState::Off => stop.level.is_some(),
                _ => true,
            };
            rigid == matches!(stop.law, StopLaw::Rigid { .. }) && law
        });
        let due = match &self.due {
            Some(Due::Passage(watch)) => known(watch),
            Some(Due::Knot | Due::Renewal | Due::Sample) | None => true,
        };
        let stands = |contact: &Contact| match *contact {
            Contact::Slider(i) => i < system.branches.len(),
            _ => self.mode.basis.contains(contact),
        };
        let energy = &self.energy;
        [self.z.len(), self.sizes.0.len()] == [size; 2]
            && [self.mode.stops.len(), self.impacts.len(), energy.stops.len()] == [stops; 3]
            && [self.mode.frictions.len(), energy.frictions.len()] == [frictions; 2]
            && [energy.branches.len(), self.mode.sliders.len()] == [system.branches.len(); 2]
            && self.mode.sliders.iter().enumerate().all(slides)
            && system.fits_clocks(&self.clocks)
            && self.inputs.len() == system.signals.no_inputs().len()
            && [energy.loads.len(), energy.dashpots.len()] == [system.loads.len(), system.springs.len()]
            && self.time.value().is_finite()
            && self.since.is_finite()
            && finite(self.z.as_slice())
            && finite(self.sizes.0.as_slice())
            && self.inputs.iter().all(|(from, input)| from.is_finite() && finite(input))
            && self.impacts.iter().all(|record| record.impulse.is_finite())
            && energy.balance().is_finite()
            && self.mode.basis.is_sorted_by(|a, b| a < b)
            && self.mode.basis.iter().all(there)
            && of_its_law
            && self.standing.is_sorted_by(|a, b| a.0 < b.0)
            && self.standing.iter().all(|(contact, place)| stands(contact) && place.is_finite())
            && self.last.as_ref().is_none_or(known)
            && due
    }
}
