//! Freewheels: rigid stops that act on e' instead of e (docs/assembly-law.md, section 18).
//!
//! In the law, a freewheel is a rigid stop with e' instead of e - gap. It is closed while a force
//! that is not negative keeps e' = 0, and open while e' < 0. Where it differs, the code uses
//! [`System::keeps_place`] and [`System::freewheels`]: a freewheel holds no place, and its impacts
//! follow (A53).

use super::{Part, StopRows, System};
use crate::description::{Description, StopLaw};
use crate::elements::Element;
use crate::mode::Contact;
use std::ops::Range;

impl System {
    /// Adds the freewheels after all other stops.
    pub(super) fn add_freewheels(&mut self, d: &Description) {
        self.first_freewheel = self.stops.len();
        for (i, element) in d.elements().enumerate() {
            let Element::Freewheel(wheel) = element else { continue };
            let elongation = self.elongation(&wheel.arms);
            let (excess, law) = (elongation.rate.clone(), StopLaw::Rigid { restitution: 0.0 });
            self.stops.push(StopRows { is_freewheel: true, ..StopRows::new(elongation, excess, law) });
            self.parts[i].push(Part::Stop(self.stops.len() - 1));
        }
    }

    /// The indices of the freewheels among the stops.
    pub fn freewheels(&self) -> Range<usize> {
        self.first_freewheel..self.stops.len()
    }

    /// Whether a contact keeps a place, e = gap, and not only a rate.
    pub fn keeps_place(&self, contact: Contact) -> bool {
        matches!(contact, Contact::Stop(i) if !self.stops[i].is_freewheel)
    }
}
