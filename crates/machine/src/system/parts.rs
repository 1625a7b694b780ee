//! Parts of elements: the springs, stops, frictions, branches and loads of the law.
//!
//! The user sees an element, with one name, one force and one energy; the law sees its parts.

use super::{Elongation, System};
use crate::functional::Functional;
use crate::kernel::Sparse;
use crate::mode::{Contact, Mode, StopState};
pub use crate::part::Part;
use crate::quantity::What;
use std::borrow::Cow;

impl System {
    /// The index of the element that has a part, among all elements.
    pub fn element_of(&self, part: Part) -> usize {
        self.parts.iter().position(|parts| parts.contains(&part)).unwrap_or_default()
    }

    /// The parts of an element to which a quantity belongs: of a contact the stop, or along a
    /// tangent the tangent's branch.
    pub fn parts_of(&self, element: usize, what: What) -> &[Part] {
        let parts = &self.parts[element][..];
        match (parts, what) {
            ([Part::Stop(_), tangents @ ..], What::TangentE(k) | What::TangentF(k)) => {
                let k = k.unwrap_or_default();
                tangents.get(k..=k).unwrap_or_default()
            }
            ([Part::Stop(_), Part::Branch(_), ..], What::E | What::Rate | What::F) => &parts[..1],
            _ => parts,
        }
    }

    /// The elongation of a part; `None` for a load.
    pub fn elongation_of_part(&self, part: Part) -> Option<&Elongation> {
        match part {
            Part::Spring(i) => Some(&self.springs[i].elongation),
            Part::Stop(i) => Some(&self.stops[i].elongation),
            Part::Friction(i) => Some(&self.frictions[i].elongation),
            Part::Branch(i) => Some(&self.branches[i].elongation),
            Part::Load(_) => None,
        }
    }

    /// The row of a part's force in a mode. `lambda` has the rows of the contact forces of the
    /// mode's [basis](Mode::basis).
    pub fn force_row(&self, part: Part, mode: &Mode, lambda: &[Sparse]) -> Functional {
        if let Cow::Owned(own) = self.at_mode(mode) {
            return own.force_row(part, mode, lambda);
        }
        let held = |contact: Contact| {
            let place = mode.basis.iter().position(|&c| c == contact);
            place.map(|k| Functional::from_terms(self.signals.size, lambda[k].terms().iter().copied()))
        };
        let row = match part {
            Part::Spring(i) => Some(self.springs[i].force.clone()),
            Part::Stop(i) => match mode.stops[i] {
                StopState::Closed => held(Contact::Stop(i)),
                state => self.stop_force(i, state),
            },
            Part::Friction(i) => {
                self.friction_force(i, mode.frictions[i], &mode.stops).or_else(|| held(Contact::Friction(i)))
            }
            Part::Branch(i) => Some(self.branch_force(i, mode.sliders[i])),
            Part::Load(i) => Some(Functional::of(self.load_row(i, &mode.stops))),
        };
        row.unwrap_or_else(|| Functional::zeros(self.signals.size))
    }
}
