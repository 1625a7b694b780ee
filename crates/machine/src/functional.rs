//! Rows on the augmented state and directions of the coordinates, by their nonzero terms.

use crate::kernel::Sparse;
use nalgebra::{DVector, Dyn, Storage, U1, Vector};
use std::ops::{Add, Deref, Index, Mul, Neg, Sub};
use std::sync::OnceLock;

/// A row that acts on the augmented state.
pub type StateRow = DVector<f64>;

/// A row on the augmented state, or a direction of the coordinates, by its nonzero terms. The
/// dense row, to which it dereferences, is made on first use: a machine of thousands of bodies has
/// no room for a dense row of each element.
#[derive(Clone, Debug)]
pub struct Functional {
    length: usize,
    terms: Sparse,
    row: OnceLock<StateRow>,
}

impl Functional {
    /// The functional of a row.
    pub fn of(row: StateRow) -> Self {
        let (length, terms) = (row.len(), Sparse::of(row.as_slice()));
        Self { length, terms, row: OnceLock::from(row) }
    }

    /// A row of a given length by its terms, in ascending order of their indices.
    pub(crate) fn from_terms(length: usize, terms: impl Iterator<Item = (usize, f64)>) -> Self {
        Self { length, terms: Sparse::from_terms(terms), row: OnceLock::new() }
    }

    /// The row without terms.
    pub(crate) fn zeros(length: usize) -> Self {
        Self::from_terms(length, std::iter::empty())
    }

    /// The row with one term.
    pub(crate) fn unit(length: usize, place: usize, value: f64) -> Self {
        Self::from_terms(length, std::iter::once((place, value)))
    }

    /// Σ factor · row, with the terms added up in the order given.
    pub(crate) fn sum<'a>(length: usize, parts: impl IntoIterator<Item = (f64, &'a Self)>) -> Self {
        let mut terms = Vec::new();
        for (factor, part) in parts {
            terms.extend(part.terms().iter().map(|&(j, x)| (j, factor * x)));
        }
        Self { length, terms: Sparse::summed(terms), row: OnceLock::new() }
    }

    /// Number of entries.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Whether the row has no entries.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// All entries.
    pub(crate) fn into_row(self) -> StateRow {
        (*self).clone()
    }

    /// Value at `z`.
    #[inline(always)]
    pub fn at(&self, z: &[f64]) -> f64 {
        self.terms.dot(z)
    }

    /// The product with a vector; it has the same bits as the product of the dense row.
    #[inline]
    pub fn dot<S: Storage<f64, Dyn, U1>>(&self, z: &Vector<f64, Dyn, S>) -> f64 {
        self.terms.sum_in_lanes(z.len(), |j| z[j])
    }

    /// The product with another row.
    #[inline]
    pub fn along(&self, other: &Self) -> f64 {
        self.terms.sum_in_lanes(self.length, |j| other[j])
    }

    /// Sum of the squares of the entries.
    pub fn norm_squared(&self) -> f64 {
        self.along(self)
    }

    /// Nonzero terms, with their indices.
    #[inline(always)]
    pub fn terms(&self) -> &[(usize, f64)] {
        self.terms.terms()
    }

    /// Sum of the terms' absolute values, given a vector of absolute values.
    #[inline(always)]
    pub fn size(&self, sizes: &[f64]) -> f64 {
        self.terms.size(sizes)
    }
}

impl Mul<&Functional> for f64 {
    type Output = Functional;

    fn mul(self, row: &Functional) -> Functional {
        Functional::sum(row.length, [(self, row)])
    }
}

impl Neg for &Functional {
    type Output = Functional;

    fn neg(self) -> Functional {
        -1.0 * self
    }
}

impl Add for &Functional {
    type Output = Functional;

    fn add(self, other: Self) -> Functional {
        Functional::sum(self.length, [(1.0, self), (1.0, other)])
    }
}

impl Sub for &Functional {
    type Output = Functional;

    fn sub(self, other: Self) -> Functional {
        Functional::sum(self.length, [(1.0, self), (-1.0, other)])
    }
}

impl PartialEq for Functional {
    fn eq(&self, other: &Self) -> bool {
        self.length == other.length && self.terms == other.terms
    }
}

impl AsRef<Sparse> for Functional {
    fn as_ref(&self) -> &Sparse {
        &self.terms
    }
}

impl Index<usize> for Functional {
    type Output = f64;

    fn index(&self, j: usize) -> &f64 {
        let found = self.terms().binary_search_by_key(&j, |term| term.0);
        found.map_or(&0.0, |place| &self.terms()[place].1)
    }
}

impl Deref for Functional {
    type Target = StateRow;

    fn deref(&self) -> &StateRow {
        self.row.get_or_init(|| StateRow::from_vec(self.terms.dense(self.length)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn golden_a_product_has_the_bits_of_the_list_of_all_entries() {
        // Lengths below, at and beyond the eight lanes of nalgebra's product.
        for length in [1, 5, 8, 9, 23, 40] {
            let x = DVector::from_fn(length, |k, _| if k % 3 == 1 { 0.0 } else { (k as f64 + 0.3).sin() });
            let z = DVector::from_fn(length, |k, _| 1.0 / (k as f64 + 0.7));
            let own = Functional::of(x.clone());
            assert_eq!(own.dot(&z).to_bits(), x.dot(&z).to_bits(), "{length}");
            assert_eq!(own.norm_squared().to_bits(), x.norm_squared().to_bits(), "{length}");
            assert_eq!(*Functional::from_terms(length, own.terms().iter().copied()), x);
        }
    }
}
