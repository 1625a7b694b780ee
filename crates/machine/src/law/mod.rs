//! The law at events: contact forces, impacts and the mode that follows (docs/assembly-law.md).

pub mod box_qp;
pub mod groups;
pub mod impact;
pub mod selection;

use crate::functional::{Functional, StateRow};
use crate::kernel::Sparse;
use crate::mode::Contact;
use crate::system::{Elongation, System};
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

/// Relative zero tolerance, some hundreds of roundings: a sum counts as zero below this fraction
/// of the sum of the largest magnitudes that its terms have had so far.
pub const ZERO: f64 = 1e-13;

/// Past maximum of the size of each component of the augmented state, which defines the zero
/// tolerance (docs/assembly-law.md (A18)).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sizes(#[serde(with = "crate::serialized")] pub DVector<f64>);

impl Sizes {
    /// The sum of the largest sizes of a row's terms.
    pub fn of(&self, row: &StateRow) -> f64 {
        row.as_slice().iter().zip(self.0.as_slice()).map(|(r, s)| r.abs() * s).sum()
    }

    /// [`Self::of`] for every row of a matrix.
    pub(crate) fn of_rows(&self, rows: &DMatrix<f64>) -> Vec<f64> {
        let mut sums = vec![0.0; rows.nrows()];
        // Whole columns are added, since each is contiguous.
        for (column, size) in rows.as_slice().chunks_exact(rows.nrows().max(1)).zip(self.0.as_slice()) {
            sums.iter_mut().zip(column).for_each(|(sum, x)| *sum += x.abs() * size);
        }
        sums
    }

    /// [`Self::zero`] for a sparse row.
    pub(crate) fn zero_of(&self, row: &impl AsRef<Sparse>) -> f64 {
        ZERO * row.as_ref().size(self.0.as_slice())
    }

    /// The size up to which a row's value counts as zero.
    pub fn zero(&self, row: &StateRow) -> f64 {
        ZERO * self.of(row)
    }

    /// Updates the largest sizes by a state.
    #[inline(always)]
    pub fn include(&mut self, z: &[f64]) {
        self.include_from(0, z);
    }

    /// Updates the largest sizes by coordinates of a state, starting at index `first`.
    #[inline(always)]
    pub fn include_from(&mut self, first: usize, z: &[f64]) {
        self.0.as_mut_slice()[first..].iter_mut().zip(z).for_each(|(s, x)| *s = s.max(x.abs()));
    }

    /// Raises the largest sizes of the coordinates that a contact constrains. Projection onto the
    /// contact gives each coordinate a share of the rounding of all terms. The largest size of a
    /// coordinate is therefore at least this share of the sizes of the other terms.
    pub(crate) fn include_contact(&mut self, system: &System, contact: Contact) {
        let (e, n) = (system.elongation_of(contact), system.coordinates);
        if let Contact::Stop(i) = contact
            && system.keeps_place(contact)
        {
            self.include_held(e, 0, &system.stops[i].excess);
        }
        self.include_held(e, n, &e.rate);
    }

    /// Raises the largest sizes of the coordinates (`first` = 0) or rates (`first` = n) for a row
    /// that a contact keeps at zero.
    fn include_held(&mut self, e: &Elongation, first: usize, row: &Functional) {
        let all = row.size(self.0.as_slice());
        let compliance = e.w.along(&e.mobility);
        for &k in &e.reach {
            // A coordinate's share of its own term is at most its own size, so this term is left
            // out.
            let others = all - e.w[k].abs() * self.0[first + k];
            self.0[first + k] = self.0[first + k].max(e.mobility[k].abs() / compliance * others);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::file::{no_records, parse};

    #[test]
    fn closed_form_what_is_held_has_the_rounding_of_what_holds_it() {
        // A body of 0.01 kg sticks to a body of 1 kg with largest sizes of 3 m and 2 m/s. The
        // light body takes 100/101 of a correction of e. The heavy body's share of the light
        // body's 0.5 m/s is 0.5/101 m/s, below 2 m/s, so the heavy body's size does not change.
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
        // A closed stop also constrains the coordinates. The other terms of its row are 3 m (heavy
        // body) and the gap of 0.5 m.
        let mut closed = begin();
        closed.include_contact(&system, Contact::Stop(0));
        let found = size(&closed);
        assert!((found[1] - share * 3.5).abs() < 1e-15 && found[3] == share * 2.0, "{found:?}");
    }
}
