//! The law at events: contact forces and impulses, impacts, and the mode that follows
//! (docs/assembly-law.md).

pub mod box_qp;
pub mod impact;
pub mod selection;

use crate::mode::Contact;
use crate::system::{Elongation, Functional, Row, System};
use nalgebra::DVector;
use serde::{Deserialize, Serialize};

/// Relative value under which a functional counts as zero, by the sum of its terms' [`Sizes`]: some
/// hundreds of roundings (docs/assembly-law.md (A14)).
pub const ZERO: f64 = 1e-13;

/// Largest absolute value so far of each component of the augmented state, by which rounding is
/// measured (docs/assembly-law.md (A14)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sizes(#[serde(with = "crate::motion::saved::vector")] pub DVector<f64>);

impl Sizes {
    /// The sum of the sizes of a row's terms.
    pub fn of(&self, row: &Row) -> f64 {
        row.iter().zip(self.0.iter()).map(|(r, s)| r.abs() * s).sum()
    }

    /// Value under which a functional counts as zero.
    pub(crate) fn zero_of(&self, row: &Functional) -> f64 {
        ZERO * row.size(self.0.as_slice())
    }

    /// Value under which a row's value counts as zero.
    pub fn zero(&self, row: &Row) -> f64 {
        ZERO * self.of(row)
    }

    /// Includes a state.
    #[inline(always)]
    pub fn include(&mut self, z: &[f64]) {
        self.include_from(0, z);
    }

    /// Includes components of a state, from index `first` on.
    #[inline(always)]
    pub fn include_from(&mut self, first: usize, z: &[f64]) {
        self.0.as_mut_slice()[first..].iter_mut().zip(z).for_each(|(s, x)| *s = s.max(x.abs()));
    }

    /// Includes a contact's constraint: projecting onto it moves each coordinate by a share of the
    /// constraint's rounding, which is that of all its terms. A coordinate held to larger ones gets
    /// at least the size of that share.
    pub(crate) fn include_contact(&mut self, system: &System, contact: Contact) {
        let (e, n) = (system.elongation_of(contact), system.coordinates);
        if let Contact::Stop(i) = contact {
            self.include_held(e, 0, &system.stops[i].excess);
        }
        self.include_held(e, n, &e.rate);
    }

    /// Includes the constraint `row` = 0 in the sizes of the coordinates or rates from `first` on.
    fn include_held(&mut self, e: &Elongation, first: usize, row: &Functional) {
        let all = row.size(self.0.as_slice());
        let compliance = e.w.dot(&e.mobility);
        for (k, mobility) in e.mobility.iter().enumerate().filter(|(_, m)| **m != 0.0) {
            // A coordinate's own term needs no share.
            let others = all - e.w[k].abs() * self.0[first + k];
            self.0[first + k] = self.0[first + k].max(mobility.abs() / compliance * others);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::{no_records, parse};

    #[test]
    fn closed_form_a_light_body_held_to_a_heavy_one_has_its_rounding() {
        // 0.01 kg is held to 1 kg, whose sizes are 3 m and 2 m/s: of a correction of e the light
        // body takes 100/(100 + 1); the heavy one's share of 0.5 m/s is less than its own size.
        let text = "name = \"A\"\n[body.heavy]\nmass = 1.0\n[body.light]\nmass = 0.01\n\
                    [friction.f]\nbetween = [\"heavy\", \"light\"]\nforce = 1.0\n\
                    [stop.s]\nbetween = [\"heavy\", \"light\"]\ngap = 0.5\nrestitution = 0.0\n";
        let system = System::new(&parse(text, "a.toml", &no_records).unwrap()).unwrap();
        let (share, size) = (100.0 / 101.0, |sizes: &Sizes| sizes.0.as_slice()[..4].to_vec());
        let begin = || {
            let mut sizes = Sizes(DVector::zeros(system.signals.size));
            sizes.include(&[3.0, 0.0, 2.0, 0.5, 1.0]);
            sizes
        };
        let mut stuck = begin();
        stuck.include_contact(&system, Contact::Friction(0));
        assert_eq!(size(&stuck), [3.0, 0.0, 2.0, share * 2.0]);
        // A closed stop constrains coordinates, too, with terms 3 m and its gap.
        let mut closed = begin();
        closed.include_contact(&system, Contact::Stop(0));
        let found = size(&closed);
        assert!((found[1] - share * 3.5).abs() < 1e-15 && found[3] == share * 2.0, "{found:?}");
    }
}
