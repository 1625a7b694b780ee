//! Rows, stored as their nonzero entries.

use super::SLICE;

/// Sorts entries by their columns; entries of one column keep their order.
#[inline(never)]
pub fn sort_by_place(terms: &mut [(usize, f64)]) {
    terms.sort_by_key(|term| term.0);
}

/// A row, stored as its nonzero entries with their columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sparse(Vec<(usize, f64)>);

impl Sparse {
    /// The nonzero entries of a row.
    pub fn of(row: &[f64]) -> Self {
        Self(row.iter().copied().enumerate().filter(|&(_, x)| x != 0.0).collect())
    }

    /// The row with these entries; zeros are left out.
    pub fn from_terms(terms: impl Iterator<Item = (usize, f64)>) -> Self {
        let mut own = Vec::with_capacity(terms.size_hint().1.unwrap_or(0));
        own.extend(terms.filter(|&(_, x)| x != 0.0));
        Self(own)
    }

    /// The row with these entries in any order. Entries of one column are added up in the order
    /// given.
    pub fn summed(mut terms: Vec<(usize, f64)>) -> Self {
        sort_by_place(&mut terms);
        terms.dedup_by(|next, sum| {
            let is_same = next.0 == sum.0;
            if is_same {
                sum.1 += next.1;
            }
            is_same
        });
        terms.retain(|term| term.1 != 0.0);
        Self(terms)
    }

    /// The row times a vector.
    #[inline(always)]
    pub fn dot(&self, z: &[f64]) -> f64 {
        self.0.iter().map(|&(j, x)| x * z[j]).sum()
    }

    /// The row times a vector of a given length, whose entries `of` returns. The sum has the order
    /// of nalgebra's products: eight lanes, then the rest.
    #[inline(always)]
    pub fn sum_in_lanes(&self, length: usize, of: impl Fn(usize) -> f64) -> f64 {
        let begin = length - length % SLICE;
        let first = self.0.partition_point(|term| term.0 < begin);
        let mut lanes = [0.0; SLICE];
        self.0[..first].iter().for_each(|&(j, x)| lanes[j % SLICE] += x * of(j));
        let half = SLICE / 2;
        let sum = (0..half).fold(0.0, |sum, k| sum + (lanes[k] + lanes[k + half]));
        self.0[first..].iter().fold(sum, |sum, &(j, x)| sum + x * of(j))
    }

    /// Sum of |entry| · size over the row; `sizes` holds the absolute values of the vector.
    #[inline(always)]
    pub fn size(&self, sizes: &[f64]) -> f64 {
        self.0.iter().map(|&(j, x)| x.abs() * sizes[j]).sum()
    }

    /// `factor` times the row.
    pub fn times(&self, factor: f64) -> Self {
        Self::from_terms(self.0.iter().map(|&(j, x)| (j, factor * x)))
    }

    /// The row minus another row.
    pub fn less(&self, other: &Self) -> Self {
        let mut left: Vec<(usize, f64)> = Vec::with_capacity(self.0.len() + other.0.len());
        let (mut own, mut others) = (self.0.iter().peekable(), other.0.iter().peekable());
        loop {
            let places = [own.peek(), others.peek()].map(|term| term.map(|term| term.0));
            let Some(place) = places.into_iter().flatten().min() else {
                return Self::from_terms(left.into_iter());
            };
            let x = own.next_if(|term| term.0 == place).map_or(0.0, |term| term.1);
            let less = others.next_if(|term| term.0 == place).map_or(0.0, |term| term.1);
            left.push((place, x - less));
        }
    }

    /// The entry in column `j`.
    pub fn entry(&self, j: usize) -> f64 {
        self.0.iter().find(|term| term.0 == j).map_or(0.0, |term| term.1)
    }

    /// The row as a dense vector.
    pub fn dense(&self, size: usize) -> Vec<f64> {
        let mut row = vec![0.0; size];
        self.0.iter().for_each(|&(j, x)| row[j] = x);
        row
    }

    /// The nonzero entries with their columns.
    pub fn terms(&self) -> &[(usize, f64)] {
        &self.0
    }
}

impl AsRef<Self> for Sparse {
    fn as_ref(&self) -> &Self {
        self
    }
}
