//! Projection of the state onto the constraints of contacts (docs/assembly-law.md, section 6).

use super::{Hybrid, Motion};
use crate::functional::Functional;
use crate::law::groups::Triangle;
use crate::mode::{Contact, SliderState};
use crate::system::{Elongation, System};

/// Limits the drift of e of a contact that keeps e' at zero, in roundings of the terms of e.
/// Beyond it, e returns to the value at which the contact began to hold. The value of e itself may
/// have one such rounding.
const DRIFT: f64 = 2.0;

/// Two directions count as parallel up to this square of the sine of their angle.
const PARALLEL: f64 = 1e-12;

/// The distance of e from `from`; 0 within [`DRIFT`] roundings.
fn drift(e: &Functional, from: f64, z: &[f64]) -> f64 {
    let (value, size) = e.terms().iter().fold((0.0, 0.0), |(value, size), &(j, x)| {
        let term: f64 = x * z[j];
        (value + term, size + term.abs())
    });
    let off = value - from;
    if off.abs() > DRIFT * f64::EPSILON * size { off } else { 0.0 }
}

/// Whether two elements move bodies in the same direction.
fn is_parallel(a: &Elongation, b: &Elongation) -> bool {
    let [own, other, both] = [(a, a), (b, b), (a, b)].map(|(a, b)| a.w.along(&b.mobility));
    both * both >= (1.0 - PARALLEL) * own * other
}

/// Returns e when a contact began to hold; the list is sorted.
pub(super) fn place_of(contact: Contact, standing: &[(Contact, f64)]) -> Option<f64> {
    standing.binary_search_by_key(&contact, |held| held.0).ok().map(|place| standing[place].1)
}

impl Motion {
    /// Projects the state onto the constraints of the present mode, by the smallest change in the
    /// inertia's metric: e = gap and e' = 0 of closed stops; e' = 0 and the previous e of sticking
    /// friction and engaged freewheels. Then sets the stretches of slipping sliders so that their
    /// forces are at their levels.
    pub(super) fn keep_contacts(&mut self) {
        self.keep_inner_places();
        let drifts = self.find_drifts();
        let Hybrid { mode, z, .. } = &mut self.hybrid;
        // The basis is sorted: stops come first, with the leading part of the triangle.
        let system = &self.assembly.system;
        let stops = mode.basis.iter().take_while(|c| system.keeps_place(**c)).count();
        let r = &self.tables.at(self.place).table.triangle;
        if drifts {
            displace(system, (&mode.basis, r, 0), z.as_mut_slice(), &mut self.scratch.off);
        } else if stops > 0 {
            project(system, &mode.basis[..stops], r, false, z.as_mut_slice(), &mut self.scratch.off);
        }
        self.keep_rates();
        let Hybrid { mode, z, .. } = &mut self.hybrid;
        self.assembly.system.keep_levels(&mode.sliders, z.as_mut_slice());
        self.assembly.system.fill_curved(z.as_mut_slice());
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

    /// Moves the bodies at held sliders so that drifted inner places return. The flow carries the
    /// stretch as a state, without the rounding of the drifting places. The stretch changes if no
    /// body can move, or if the bodies move for a parallel slider.
    fn keep_inner_places(&mut self) {
        let Hybrid { mode, z, standing, .. } = &mut self.hybrid;
        let (system, z) = (&self.assembly.system, z.as_mut_slice());
        let held = |&(contact, from): &(Contact, f64)| match contact {
            Contact::Slider(i) if mode.sliders[i] == SliderState::Held => Some((i, from)),
            _ => None,
        };
        for (i, from) in standing.iter().filter_map(held) {
            let branch = &system.branches[i];
            let off = drift(&branch.inner, from, z);
            if off == 0.0 {
                continue;
            }
            let e = &branch.elongation;
            let before = standing.iter().filter_map(held).take_while(|own| own.0 < i);
            let follows = before.into_iter().any(|(j, _)| is_parallel(e, &system.branches[j].elongation));
            let compliance = e.w.along(&e.mobility);
            if compliance > 0.0 && !follows {
                e.reach.iter().for_each(|&k| z[k] -= off / compliance * e.mobility[k]);
            } else {
                z[branch.place] += off;
            }
        }
    }

    /// Returns whether a contact that keeps only e' has drifted. If so, writes the place
    /// deviations of the whole basis to the scratch memory.
    fn find_drifts(&mut self) -> bool {
        let Hybrid { mode, z, standing, .. } = &self.hybrid;
        let (system, z) = (&self.assembly.system, z.as_slice());
        let own = |&(contact, from): &(Contact, f64)| drift(system.place_row(contact), from, z);
        let is_contact = |held: &&(Contact, f64)| !matches!(held.0, Contact::Slider(_));
        if !standing.iter().filter(is_contact).any(|held| own(held) != 0.0) {
            return false;
        }
        self.scratch.off.clear();
        self.scratch.off.extend(mode.basis.iter().map(|&contact| match contact {
            Contact::Stop(i) if system.keeps_place(contact) => system.stops[i].excess.at(z),
            _ => place_of(contact, standing).map_or(0.0, |from| own(&(contact, from))),
        }));
        true
    }

    /// Forgets the places of contacts that a jump has moved, and of sliders moved by `ways`.
    pub(super) fn forget_moved(&mut self, ways: &[f64]) {
        let Hybrid { z, standing, .. } = &mut self.hybrid;
        let (system, z) = (&self.assembly.system, z.as_slice());
        standing.retain(|&(contact, from)| match contact {
            Contact::Slider(i) => ways[i] == 0.0,
            contact => drift(system.place_row(contact), from, z) == 0.0,
        });
    }

    /// Records the present e of each contact that begins to keep e' at zero, but not e, and the
    /// inner place of each slider that begins to be held. A contact that already held keeps its
    /// place, unless a jump or an impact has moved it. For a host's solver, whose states have
    /// errors, records only all inner places.
    pub(super) fn note_standing(&mut self) {
        let Hybrid { mode, z, standing, .. } = &mut self.hybrid;
        let (system, z) = (&self.assembly.system, z.as_slice());
        let exact = self.overshoot == 0.0;
        let is_noted = |i: usize| {
            let is_held = mode.sliders[i] == SliderState::Held && system.branches[i].is_slider();
            !exact || is_held
        };
        standing.retain(|&(contact, from)| {
            let stays = drift(system.place_row(contact), from, z) == 0.0;
            match contact {
                Contact::Slider(i) => is_noted(i) && (exact || stays),
                contact => exact && stays && mode.basis.binary_search(&contact).is_ok(),
            }
        });
        let before = standing.len();
        let contacts = mode.basis.iter().filter(|&&contact| exact && !system.keeps_place(contact));
        let sliders = (0..system.branches.len()).filter(|&i| is_noted(i)).map(Contact::Slider);
        for contact in contacts.copied().chain(sliders) {
            if place_of(contact, &standing[..before]).is_none() {
                standing.push((contact, system.place_row(contact).at(z)));
            }
        }
        standing.sort_unstable_by_key(|held| held.0);
    }
}

impl System {
    /// The row of the place that a held contact or slider keeps.
    fn place_row(&self, contact: Contact) -> &Functional {
        match contact {
            Contact::Slider(i) => &self.branches[i].inner,
            contact => &self.elongation_of(contact).e,
        }
    }
}

/// Projects a state onto constraints by the smallest change in the inertia's metric: e = gap of
/// stops or, with `rates`, e' = 0 of contacts. `r` is the triangle of a list that begins with the
/// contacts; `off` is scratch memory.
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
    displace(system, (contacts, r, if rates { system.coordinates } else { 0 }), z, off);
}

/// Removes the deviations `off` of contacts from the coordinates or rates that begin at `first`.
fn displace(
    system: &System,
    (contacts, r, first): (&[Contact], &Triangle, usize),
    z: &mut [f64],
    off: &mut [f64],
) {
    r.solve(off);
    for (&contact, off) in contacts.iter().zip(off.iter()) {
        let e = system.elongation_of(contact);
        e.reach.iter().for_each(|&k| z[first + k] -= off * e.mobility[k]);
    }
}
