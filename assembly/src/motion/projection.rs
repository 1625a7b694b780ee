//! Projection of the state onto the constraints of contacts (docs/assembly-law.md, section 6).

use super::{Hybrid, Motion};
use crate::mode::Contact;
use crate::system::System;
use nalgebra::DMatrix;

impl Motion {
    /// Projects the state onto the constraints of the present mode, by the least change in the
    /// inertia's metric: e = gap and e' = 0 of closed stops, e' = 0 of sticking friction.
    pub(super) fn keep_contacts(&mut self) {
        let Hybrid { mode, z, .. } = &mut self.hybrid;
        // The basis is sorted: stops come first, with the leading part of the triangle.
        let stops = mode.basis.iter().take_while(|c| matches!(c, Contact::Stop(_))).count();
        if stops > 0 {
            let (system, r) = (&self.assembly.system, &self.tables.at(self.place).table.triangle);
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
/// or e' = 0 of contacts with `rates`. A leading part R of `r` has RᵀR = WᵀM⁻¹W of the contacts.
/// `off` is scratch memory.
pub(super) fn project(
    system: &System,
    contacts: &[Contact],
    r: &DMatrix<f64>,
    rates: bool,
    z: &mut [f64],
    off: &mut Vec<f64>,
) {
    let m = contacts.len();
    off.clear();
    off.extend(contacts.iter().map(|&contact| match (contact, rates) {
        (Contact::Stop(i), false) => system.stops[i].excess.at(z),
        _ => system.elongation_of(contact).rate.at(z),
    }));
    for j in 0..m {
        let known: f64 = (0..j).map(|i| r[(i, j)] * off[i]).sum();
        off[j] = (off[j] - known) / r[(j, j)];
    }
    for j in (0..m).rev() {
        let known: f64 = (j + 1..m).map(|k| r[(j, k)] * off[k]).sum();
        off[j] = (off[j] - known) / r[(j, j)];
    }
    let first = if rates { system.coordinates } else { 0 };
    for (&contact, off) in contacts.iter().zip(off.iter()) {
        let mobility = system.elongation_of(contact).mobility.iter();
        z[first..].iter_mut().zip(mobility).for_each(|(x, m)| *x -= off * m);
    }
}
