//! Contacts at rest whose rate a column varies (docs/assembly-law.md, section 14, Limit).

use super::lost::{Cause, Lost};
use super::machine::{Instant, Machine, STILL, Varied};
use crate::law::box_qp::groups_by_columns;
use crate::mode::{Contact, FrictionState};

impl Machine {
    /// Refuses a rate that a column gives to contacts at rest, unless they come to rest again at
    /// once, on both sides.
    ///
    /// This is so if forces λ hold all coupled contacts, with 0 < λ for stops and |λ| < F (the
    /// slip level) for frictions. The rates vanish within a time of their size, by impulses of the
    /// contacts alone (A38), and the derivative is the projection.
    pub fn returns(&self, column: Varied, at: &Instant) -> Result<(), Lost> {
        let contacts: Vec<Contact> = at.mode.mode.contacts().collect();
        let point = self.point(column, at);
        let is_moved = |contact: Contact| {
            let (row, by) = self.held_row(contact, true, column.p);
            // The rate of a body between others may be the rounding error of their impacts.
            let all = column.scale.rows(self.system.coordinates, self.system.coordinates).amax();
            let size = point.size(row, by) + all * self.system.elongation_of(contact).w.amax();
            point.of(row, by).abs() > STILL * size
        };
        let moved: Vec<bool> = contacts.iter().map(|&contact| is_moved(contact)).collect();
        if !moved.contains(&true) {
            return Ok(());
        }
        let groups = groups_by_columns(&self.system.columns(&contacts));
        let is_coupled =
            |k: usize| groups.iter().zip(&moved).any(|(group, moved)| *moved && *group == groups[k]);
        match (0..contacts.len()).find(|&k| is_coupled(k) && !self.is_inside(contacts[k], at)) {
            None => Ok(()),
            Some(k) => {
                let element = self.name_of(contacts[k]);
                Err(Lost { time: at.time, element, cause: Cause::Limit })
            }
        }
    }

    /// Whether a contact's force is inside its limits by more than rounding; for friction the
    /// limit is the level at which it slips. A stop with restitution 1 does not come to rest. A
    /// contact that depends on others has the force zero.
    fn is_inside(&self, contact: Contact, at: &Instant) -> bool {
        let mode = &at.mode.mode;
        let place = mode.basis.iter().position(|&own| own == contact);
        let (force, size) = place.map_or((0.0, 0.0), |k| {
            let row = &at.mode.lambda[k];
            (row.dot(at.z), STILL * self.terms_of(row, at.z))
        });
        match contact {
            Contact::Stop(i) => force > size && self.system.stops[i].restitution() < Some(1.0),
            Contact::Slider(_) => true,
            Contact::Friction(i) => {
                let level = self.system.frictions[i].at(&mode.stops).map_or(0.0, |own| own.level.dot(at.z));
                mode.frictions[i] == FrictionState::Stuck && force.abs() + size < (1.0 - STILL) * level
            }
        }
    }
}
