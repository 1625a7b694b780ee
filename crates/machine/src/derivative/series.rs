//! Ingredients of flights: power series, and matrices that vary with columns.

use super::columns::width_of;
use std::sync::LazyLock;
use vibro_numerics::sorting::sort_by_key;

/// Bound of the omitted terms of a power series, relative to its largest term.
const REMAINDER: f64 = 1e-18;
/// Size of the table of orders; no series needs this many.
const MOST: usize = 64;

/// Limit of rate × time r for a power series, by number of orders. Its terms r^k/k! at least halve
/// from the last order onwards.
static REACH: LazyLock<[f64; MOST]> = LazyLock::new(|| {
    let mut factorial = 1.0;
    std::array::from_fn(|k| {
        factorial *= (k as f64).max(1.0);
        let reach = (REMAINDER * factorial).powf(1.0 / (k as f64).max(1.0));
        if k == 0 { 0.0 } else { reach.min(0.5 * k as f64) }
    })
});

/// Number of orders of a power series over rate × time.
pub(super) fn orders(radius: f64) -> usize {
    REACH.partition_point(|&reach| reach < radius)
}

/// A matrix that acts on a state and its derivatives, stored by rows: entries with their column
/// index, and the contribution of the state to each column of derivatives.
#[derive(Clone, Debug, Default)]
pub(super) struct Varied {
    /// End of each row's entries.
    pub(super) ends: Vec<usize>,
    pub(super) entries: Vec<(usize, f64)>,
    /// Derivatives of each entry, at the columns' indices; 0 at the index of the state.
    pub(super) by: Vec<f64>,
}

impl Varied {
    /// Number of stored numbers.
    pub(super) fn numbers(&self) -> usize {
        self.ends.len() + 2 * self.entries.len() + self.by.len()
    }

    /// Range of a row's entries.
    #[inline(always)]
    pub(super) fn row(&self, i: usize) -> std::ops::Range<usize> {
        i.checked_sub(1).map_or(0, |before| self.ends[before])..self.ends[i]
    }

    /// Adds a row, leaving out entries whose value and derivatives are all zero.
    pub(super) fn push(&mut self, row: &[f64], by: &[f64]) {
        let width = by.len() / row.len();
        for (j, (&x, by)) in row.iter().zip(by.chunks_exact(width)).enumerate() {
            if x != 0.0 || by.iter().any(|x| *x != 0.0) {
                self.entries.push((j, x));
                self.by.extend_from_slice(by);
            }
        }
        self.ends.push(self.entries.len());
    }
}

/// The flow over 2^k parts of a length: exp(A t) - 1, and its derivative by column.
pub(super) type Rung = Varied;

/// The entries of A that vary, by row, with their derivatives by column.
#[derive(Clone, Debug, Default)]
pub(super) struct Sources(pub(super) Varied);

impl Sources {
    /// Collects terms (row, place, column, derivative) of a matrix with `size` rows.
    pub fn of(size: usize, count: usize, mut all: Vec<(usize, usize, usize, f64)>) -> Self {
        let width = width_of(count);
        let mut own = Varied::default();
        sort_by_key(&mut all, |&(i, j, ..)| (i, j));
        let mut terms = all.into_iter().peekable();
        for row in 0..size {
            while let Some(&(_, j, ..)) = terms.peek().filter(|term| term.0 == row) {
                own.entries.push((j, 0.0));
                let begin = own.by.len();
                own.by.resize(begin + width, 0.0);
                while let Some((_, _, p, x)) = terms.next_if(|term| (term.0, term.1) == (row, j)) {
                    own.by[begin + 1 + p] += x;
                }
            }
            own.ends.push(own.entries.len());
        }
        Self(own)
    }
}
