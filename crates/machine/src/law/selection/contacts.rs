//! The slider of a contact. It is off while the contact is open, and without friction. Elsewhere
//! the first nonzero derivative of the rate of slip decides between stick and slip
//! (docs/assembly-law.md (A66)).

use super::{Selection, Slider, SliderFlag, Stop};
use crate::mode::{SliderState, StopState};

/// The directions of slip.
const BOTH: [f64; 2] = [1.0, -1.0];

impl Selection<'_> {
    /// Classifies the slider of a contact by its stop, its force and the event. `is_edge` says
    /// whether the event has brought the stop to its edge.
    pub(super) fn classify_contact(
        &self,
        i: usize,
        flag: SliderFlag,
        (stop, is_edge): (usize, bool),
    ) -> Slider {
        match self.stops[stop] {
            _ if self.system.branches[i].is_frictionless() => return Slider::Is(SliderState::Off),
            Stop::Is(StopState::Pressed) => {}
            Stop::Is(_) => return Slider::Is(SliderState::Off),
            _ => return Slider::AtEdge,
        }
        let (branch, excess) = (&self.system.branches[i], &self.system.stops[stop].excess);
        let Some(level) = &branch.level else { return Slider::Is(SliderState::Held) };
        if is_edge || self.sign(excess, 0) == 0.0 {
            return self.entered(i, 0);
        }
        let is_at = |direction: f64| self.sign(&(&(direction * &branch.force) - level), 0) >= 0.0;
        let direction = match flag.level {
            0.0 => match BOTH.map(is_at) {
                [true, true] => 0.0,
                [true, false] => 1.0,
                [false, true] => -1.0,
                [false, false] => return Slider::Is(SliderState::Held),
            },
            level => level,
        };
        if flag.turns { Slider::AtLevel(direction) } else { self.slip_of(i, direction, 0) }
    }

    /// Decides the sliders of contacts at an order, at which the states of their stops are known.
    pub(super) fn decide_contacts(&mut self, order: usize) {
        for i in 0..self.sliders.len() {
            let Some(stop) = self.system.branches[i].stop() else { continue };
            match (self.sliders[i], self.stops[stop]) {
                (Slider::AtEdge, Stop::Is(StopState::Pressed)) => self.sliders[i] = self.entered(i, order),
                (Slider::AtEdge, Stop::Is(_)) => self.sliders[i] = Slider::Is(SliderState::Off),
                (Slider::AtLevel(direction), _) if order > 0 => {
                    self.sliders[i] = self.slip_of(i, direction, order);
                }
                _ => {}
            }
        }
    }

    /// The slider of a contact that closes with its normal rate's first nonzero derivative at
    /// `order`. Up to this order the contact had no force, so that lower derivatives of the rate of
    /// slip are derivatives of the tangential rate.
    fn entered(&self, i: usize, order: usize) -> Slider {
        let rate = &self.system.branches[i].elongation.rate;
        for lower in 0..order {
            let sign = self.sign(rate, lower);
            if sign != 0.0 {
                return Slider::Is(SliderState::slipping(sign));
            }
        }
        self.slip_of(i, 0.0, order)
    }

    /// The slider of a contact at its level in a direction, or with 0 in both, by the derivative of
    /// the rate of slip of this order.
    fn slip_of(&self, i: usize, direction: f64, order: usize) -> Slider {
        let branch = &self.system.branches[i];
        let own = BOTH.into_iter().filter(|own| direction == 0.0 || *own == direction);
        let signs: Vec<(f64, f64)> = own.map(|own| (own, self.sign(&branch.slip_rate(own), order))).collect();
        if let Some(&(own, _)) = signs.iter().find(|own| own.1 > 0.0) {
            return Slider::Is(SliderState::slipping(own));
        }
        let left: Vec<f64> = signs.iter().filter(|own| own.1 == 0.0).map(|own| own.0).collect();
        match left[..] {
            [] => Slider::Is(SliderState::Held),
            [own] => Slider::AtLevel(own),
            _ => Slider::AtLevel(0.0),
        }
    }
}
