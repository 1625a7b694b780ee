//! What elements consist of: the springs, stops, frictions and loads on which the law acts.
//!
//! An element of the description is one thing to its user, with one name, one force and one energy;
//! the law knows its parts alone.

use super::{Elongation, StateRow, System};
use crate::mode::{Contact, Mode, StopState};

/// A part of an element, by its place among the system's own.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Among [`System::springs`].
    Spring(usize),
    /// Among [`System::stops`].
    Stop(usize),
    /// Among [`System::frictions`].
    Friction(usize),
    /// Among [`System::loads`].
    Load(usize),
}

impl System {
    /// The place, among all elements, of the one that has a part.
    pub fn element_of(&self, part: Part) -> usize {
        self.parts.iter().position(|parts| parts.contains(&part)).unwrap_or_default()
    }

    /// The elongation of a part; a load has none.
    pub fn elongation_of_part(&self, part: Part) -> Option<&Elongation> {
        match part {
            Part::Spring(i) => Some(&self.springs[i].elongation),
            Part::Stop(i) => Some(&self.stops[i].elongation),
            Part::Friction(i) => Some(&self.frictions[i].elongation),
            Part::Load(_) => None,
        }
    }

    /// The force of a part in a mode as a row on the augmented state, where `lambda` are the rows of
    /// the forces of the mode's [basis](Mode::basis).
    pub fn force_row(&self, part: Part, mode: &Mode, lambda: &[StateRow]) -> StateRow {
        let held =
            |contact: Contact| mode.basis.iter().position(|&c| c == contact).map(|k| lambda[k].clone());
        let row = match part {
            Part::Spring(i) => Some(self.springs[i].force.clone()),
            Part::Stop(i) => match mode.stops[i] {
                StopState::Closed => held(Contact::Stop(i)),
                state => self.stop_force(i, state),
            },
            Part::Friction(i) => {
                self.friction_force(i, mode.frictions[i]).or_else(|| held(Contact::Friction(i)))
            }
            Part::Load(i) => Some(self.loads[i].clone()),
        };
        row.unwrap_or_else(|| StateRow::zeros(self.signals.size))
    }
}
