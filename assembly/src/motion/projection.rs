//! Projection of the state onto the constraints of contacts (docs/assembly-law.md, section 6).

use super::{Hybrid, Motion};
use crate::mode::{Contact, Triangle};
use crate::system::System;

impl Motion {
    /// Projects the state onto the constraints of the present mode, by the least change in the
    /// inertia's metric: e = gap and e' = 0 of closed stops, e' = 0 of sticking friction.
    pub(super) fn keep_contacts(&mut self) {
        let Hybrid { mode, z, .. } = &mut self.hybrid;
        // The basis is sorted: stops come first, with the leading part of the triangle.
        let system = &self.assembly.system;
        let stops = mode.basis.iter().take_while(|c| system.keeps_place(**c)).count();
        if stops > 0 {
            let r = &self.tables.at(self.place).table.triangle;
            project(system, &mode.basis[..stops], r, false, z.as_mut_slice(), &mut self.scratch.off);
        }
        self.keep_rates();
    }

    /// Projects the rates alone onto the constraints of the present mode.
    pub(super) fn keep_rates(&mut self) {
        let Hybrid { mode, z, .. } = &mut self.hybrid;
        if mode.basis.is_empty() {
            return;
        }
        let (system, r) = (&self.assembly.system, &self.tables.at(self.place).table.triangle);
        project(system, &mode.basis, r, true, z.as_mut_slice(), &mut self.scratch.off);
    }
}

/// Projects a state onto constraints by the least change in the inertia's metric: e = gap of stops,
/// or e' = 0 of contacts with `rates`. `r` is the triangle of a list that begins with the contacts.
/// `off` is scratch memory.
pub(super) fn project(
    system: &System,
    contacts: &[Contact],
    r: &Triangle,
    rates: bool,
    z: &mut [f64],
    off: &mut Vec<f64>,
) {
    off.clear();
    off.extend(contacts.iter().map(|&contact| match (contact, rates) {
        (Contact::Stop(i), false) => system.stops[i].excess.at(z),
        _ => system.elongation_of(contact).rate.at(z),
    }));
    r.solve(off);
    let first = if rates { system.coordinates } else { 0 };
    for (&contact, off) in contacts.iter().zip(off.iter()) {
        let e = system.elongation_of(contact);
        e.reach.iter().for_each(|&k| z[first + k] -= off * e.mobility[k]);
    }
}
