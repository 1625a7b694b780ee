//! Sparse symmetric matrices.

use crate::{Error, Result};
use nalgebra::DMatrix;
use rayon::prelude::*;

/// Relative tolerance for the rounding of printed entries across the diagonal, as in the matrices
/// of a machine's file.
pub const SYMMETRY: f64 = 1e-9;

/// Entry of a matrix.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Row, counted from 0.
    pub row: usize,
    /// Column, counted from 0.
    pub column: usize,
    /// Value; finite.
    pub value: f64,
}

/// Entries that a file lists.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Listed {
    /// Each pair of entries across the diagonal once.
    Once,
    /// Both entries of each pair.
    Both,
    /// Both if most pairs are listed twice, else once.
    Either,
}

/// A symmetric matrix by columns, with both triangles; rows rise within a column.
#[derive(Clone, Debug)]
pub struct Symmetric {
    starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl Symmetric {
    /// The matrix of a list of entries in any order. `name` names a row in messages.
    ///
    /// # Errors
    /// An error if an entry is listed twice, and if the matrix is not symmetric to [`SYMMETRY`].
    pub fn assemble(
        count: usize,
        entries: &[Entry],
        listed: Listed,
        name: &dyn Fn(usize) -> String,
    ) -> Result<Self> {
        let mut order: Vec<u32> = (0..entries.len() as u32).collect();
        let pair = |e: &Entry| (e.row.min(e.column), e.row.max(e.column));
        order.par_sort_unstable_by_key(|&k| {
            let e = &entries[k as usize];
            (pair(e), e.row > e.column)
        });
        let both = match listed {
            Listed::Once => false,
            Listed::Both => true,
            Listed::Either => {
                let is_second = |two: &[u32]| {
                    let [one, other] = [two[0], two[1]].map(|k| &entries[k as usize]);
                    pair(one) == pair(other) && one.row != other.row
                };
                let beside = entries.iter().filter(|e| e.row != e.column).count();
                let twice = order.windows(2).filter(|two| is_second(two)).count();
                // Most pairs decide.
                twice > 0 && beside <= 3 * twice
            }
        };
        let mut found: Vec<(usize, usize, f64)> = Vec::with_capacity(entries.len());
        let mut k = 0;
        while k < order.len() {
            let at = pair(&entries[order[k] as usize]);
            let same = order[k..].iter().take_while(|&&o| pair(&entries[o as usize]) == at).count();
            let group: Vec<&Entry> = order[k..k + same].iter().map(|&o| &entries[o as usize]).collect();
            found.push((at.0, at.1, one_value(&group, both, name)?));
            k += same;
        }
        let matrix = Self::of_pairs(count, &found);
        matrix.check_symmetry(entries, both, name)?;
        Ok(matrix)
    }

    /// A matrix of entries on and above the diagonal, each once and in rising order.
    fn of_pairs(count: usize, pairs: &[(usize, usize, f64)]) -> Self {
        let mut starts = vec![0; count + 1];
        for &(i, j, _) in pairs {
            starts[j + 1] += 1;
            if i != j {
                starts[i + 1] += 1;
            }
        }
        for j in 0..count {
            starts[j + 1] += starts[j];
        }
        let mut next = starts.clone();
        let (mut rows, mut values) = (vec![0; starts[count]], vec![0.0; starts[count]]);
        let mut put = |i: usize, j: usize, x: f64| {
            (rows[next[j]], values[next[j]]) = (i, x);
            next[j] += 1;
        };
        // Pairs rise by their smaller index, so that rows rise within each column.
        let mut sorted: Vec<(usize, usize, f64)> = pairs.to_vec();
        sorted.par_sort_unstable_by_key(|&(i, j, _)| (i, j));
        for &(i, j, x) in &sorted {
            put(i, j, x);
        }
        for &(i, j, x) in &sorted {
            if i != j {
                put(j, i, x);
            }
        }
        let mut made = Self { starts, rows, values };
        made.sort_columns();
        made
    }

    fn sort_columns(&mut self) {
        for j in 0..self.count() {
            let own = self.starts[j]..self.starts[j + 1];
            if self.rows[own.clone()].windows(2).all(|two| two[0] < two[1]) {
                continue;
            }
            let (rows, values) = (&self.rows[own.clone()], &self.values[own.clone()]);
            let mut column: Vec<(usize, f64)> = rows.iter().copied().zip(values.iter().copied()).collect();
            column.sort_unstable_by_key(|term| term.0);
            for (k, (row, value)) in own.zip(column) {
                (self.rows[k], self.values[k]) = (row, value);
            }
        }
    }

    /// Refuses entries that differ from their pair's mean. If `both` is true, the file lists both.
    fn check_symmetry(&self, entries: &[Entry], both: bool, name: &dyn Fn(usize) -> String) -> Result<()> {
        if !both {
            return Ok(());
        }
        let diagonal = self.diagonal();
        for e in entries.iter().filter(|e| e.row != e.column) {
            let scale = (diagonal[e.row] * diagonal[e.column]).abs().sqrt().max(e.value.abs());
            let mean = self.at(e.row, e.column);
            // The mean is half the difference away.
            if 2.0 * (e.value - mean).abs() > SYMMETRY * scale {
                return Err(unsymmetric(e, 2.0 * mean - e.value, name));
            }
        }
        Ok(())
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of stored entries, of both triangles.
    pub fn entries(&self) -> usize {
        self.values.len()
    }

    /// Rows and values of a column.
    pub fn column(&self, j: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let own = self.starts[j]..self.starts[j + 1];
        self.rows[own.clone()].iter().copied().zip(self.values[own].iter().copied())
    }

    /// An entry.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        let own = self.starts[j]..self.starts[j + 1];
        self.rows[own.clone()].binary_search(&i).map_or(0.0, |k| self.values[own.start + k])
    }

    /// The diagonal.
    pub fn diagonal(&self) -> Vec<f64> {
        (0..self.count()).map(|i| self.at(i, i)).collect()
    }

    /// Whether all entries off the diagonal are 0.
    pub fn is_diagonal(&self) -> bool {
        (0..self.count()).all(|j| self.column(j).all(|(i, x)| i == j || x == 0.0))
    }

    /// A x for each column of x.
    pub fn times(&self, x: &DMatrix<f64>) -> DMatrix<f64> {
        let count = self.count();
        let mut y = DMatrix::zeros(count, x.ncols());
        if count == 0 {
            return y;
        }
        y.as_mut_slice().par_chunks_mut(count).zip(x.as_slice().par_chunks(count)).for_each(|(y, x)| {
            // Columns are rows; blocks of them for the cores.
            y.par_chunks_mut(4096).enumerate().for_each(|(part, y)| {
                for (k, y) in y.iter_mut().enumerate() {
                    *y = self.column(4096 * part + k).map(|(i, a)| a * x[i]).sum();
                }
            });
        });
        y
    }

    /// A + factor B.
    pub fn plus(&self, factor: f64, other: &Self) -> Self {
        let mut starts = vec![0];
        let (mut rows, mut values) = (Vec::with_capacity(self.entries()), Vec::with_capacity(self.entries()));
        for j in 0..self.count() {
            let (mut own, mut others) = (self.column(j).peekable(), other.column(j).peekable());
            loop {
                let next = match (own.peek(), others.peek()) {
                    (None, None) => break,
                    (Some(a), None) => a.0,
                    (None, Some(b)) => b.0,
                    (Some(a), Some(b)) => a.0.min(b.0),
                };
                let a = own.next_if(|term| term.0 == next).map_or(0.0, |term| term.1);
                let b = others.next_if(|term| term.0 == next).map_or(0.0, |term| term.1);
                rows.push(next);
                values.push(a + factor * b);
            }
            starts.push(rows.len());
        }
        Self { starts, rows, values }
    }

    /// The matrix of these rows and columns, in rising order.
    pub fn kept(&self, kept: &[usize]) -> Self {
        let mut place = vec![usize::MAX; self.count()];
        kept.iter().enumerate().for_each(|(new, &old)| place[old] = new);
        let mut starts = vec![0];
        let (mut rows, mut values) = (Vec::new(), Vec::new());
        for &j in kept {
            for (i, x) in self.column(j).filter(|term| place[term.0] != usize::MAX) {
                rows.push(place[i]);
                values.push(x);
            }
            starts.push(rows.len());
        }
        Self { starts, rows, values }
    }

    /// Multiplies each entry by a factor of its row and its column.
    pub fn scale(&mut self, factor: impl Fn(usize, usize) -> f64) {
        for j in 0..self.count() {
            for k in self.starts[j]..self.starts[j + 1] {
                self.values[k] *= factor(self.rows[k], j);
            }
        }
    }

    /// The triangle on and below the diagonal, by columns: starts, rows, values.
    pub fn lower(&self) -> (Vec<usize>, Vec<usize>, Vec<f64>) {
        let mut starts = vec![0];
        let (mut rows, mut values) = (Vec::new(), Vec::new());
        for j in 0..self.count() {
            for (i, x) in self.column(j).filter(|term| term.0 >= j) {
                rows.push(i);
                values.push(x);
            }
            starts.push(rows.len());
        }
        (starts, rows, values)
    }

    /// Largest sum of absolute values of a row.
    pub fn norm(&self) -> f64 {
        (0..self.count()).map(|j| self.column(j).map(|term| term.1.abs()).sum()).fold(0.0, f64::max)
    }
}

/// The value of a pair of entries across the diagonal: the mean if both are listed.
fn one_value(group: &[&Entry], both: bool, name: &dyn Fn(usize) -> String) -> Result<f64> {
    let first = group[0];
    if group.windows(2).any(|two| two[0].row == two[1].row) {
        let problem = "this entry of the matrix is listed twice; expected each entry once";
        return Err(Error::new(format!("row {}, column {}", name(first.row), name(first.column)), problem));
    }
    if let ([one, other], false) = (group, both)
        && (one.value - other.value).abs() > SYMMETRY * one.value.abs().max(other.value.abs())
    {
        return Err(unsymmetric(one, other.value, name));
    }
    // In a file that lists both, an entry that is not listed is 0.
    let count = if both && first.row != first.column { 2 } else { group.len() };
    Ok(group.iter().map(|e| e.value).sum::<f64>() / count as f64)
}

fn unsymmetric(entry: &Entry, other: f64, name: &dyn Fn(usize) -> String) -> Error {
    let problem = format!(
        "not symmetric: the entry of row {} and column {} is {:?}, but across the diagonal {other:?}; \
         expected differences below {SYMMETRY:?} of the diagonal",
        name(entry.row),
        name(entry.column),
        entry.value
    );
    Error::new(format!("dof {}", name(entry.row)), problem)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entries(list: &[(usize, usize, f64)]) -> Vec<Entry> {
        list.iter().map(|&(row, column, value)| Entry { row, column, value }).collect()
    }

    fn assembled(list: &[(usize, usize, f64)], listed: Listed) -> Result<Symmetric> {
        Symmetric::assemble(3, &entries(list), listed, &|i| format!("n{i}"))
    }

    #[test]
    fn closed_form_half_a_matrix_and_a_whole_one_are_the_same() {
        let half = [(0, 0, 2.0), (1, 0, -1.0), (1, 1, 2.0), (2, 1, -1.0), (2, 2, 1.0)];
        let whole = [half.to_vec(), vec![(0, 1, -1.0), (1, 2, -1.0)]].concat();
        for (list, listed) in [
            (half.to_vec(), Listed::Once),
            (half.to_vec(), Listed::Either),
            (whole.clone(), Listed::Both),
            (whole, Listed::Either),
        ] {
            let a = assembled(&list, listed).unwrap();
            let x = DMatrix::from_column_slice(3, 1, &[1.0, 10.0, 100.0]);
            assert_eq!(a.times(&x).as_slice(), [-8.0, -81.0, 90.0]);
            assert_eq!((a.at(0, 1), a.at(0, 2), a.entries()), (-1.0, 0.0, 7));
            assert_eq!(a.plus(2.0, &a).times(&x).as_slice(), [-24.0, -243.0, 270.0]);
            assert_eq!(a.kept(&[1, 2]).times(&x.rows(1, 2).into_owned()).as_slice(), [-80.0, 90.0]);
        }
    }

    #[test]
    fn invariant_entries_twice_and_unsymmetric_ones_are_refused_with_their_dof() {
        let twice = assembled(&[(0, 0, 1.0), (1, 0, 2.0), (1, 0, 2.0)], Listed::Either).unwrap_err();
        assert!(twice.to_string().contains("row n1, column n0"), "{twice}");
        let one_sided =
            assembled(&[(0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0), (1, 0, 0.5)], Listed::Both).unwrap_err();
        assert!(one_sided.to_string().contains("not symmetric"), "{one_sided}");
        // Most pairs are listed once: the one that is listed twice is named.
        let list = [(0, 0, 1.0), (1, 0, 0.5), (2, 0, 0.5), (2, 1, 0.2), (1, 2, 0.1)];
        let odd = assembled(&list, Listed::Either).unwrap_err().to_string();
        assert!(odd.contains("row n1 and column n2 is 0.1, but across the diagonal 0.2"), "{odd}");
        for (difference, good) in [(1e-10, true), (1e-8, false)] {
            let list = [(0, 0, 1.0), (1, 1, 1.0), (2, 2, 1.0), (1, 0, 0.5), (0, 1, 0.5 + difference)];
            assert_eq!(assembled(&list, Listed::Either).is_ok(), good);
        }
    }
}
