//! Factors L D Lᵀ of sparse symmetric matrices, with an elimination order that keeps them sparse.
//!
//! The signs of D are the signs of the eigenvalues (Sylvester's law of inertia). Therefore the
//! factors of K - λM count the eigenvalues below λ.

use std::collections::BTreeSet;

/// Arithmetic of a factorization.
pub trait Number: Copy {
    /// 0.
    const ZERO: Self;
    /// The number minus a product.
    fn less_product(self, a: Self, b: Self) -> Self;
    /// The quotient.
    fn over(self, by: Self) -> Self;
}

impl Number for f64 {
    const ZERO: Self = 0.0;

    fn less_product(self, a: Self, b: Self) -> Self {
        self - a * b
    }

    fn over(self, by: Self) -> Self {
        self / by
    }
}

/// Largest size of a matrix whose coordinates are eliminated in their own order. Up to this size,
/// a search for a better order takes longer than it saves.
const OWN_ORDER: usize = 64;

/// Elimination order of a symmetric matrix, and positions of the entries of L.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// For each step: the coordinate that is eliminated.
    order: Vec<usize>,
    /// For each coordinate: its step.
    step: Vec<usize>,
    /// For each step: later steps at which its column of L has an entry, ascending.
    below: Vec<Vec<usize>>,
}

impl Pattern {
    /// The pattern of a matrix with off-diagonal entries at these pairs. Small matrices are
    /// eliminated in their own order. In large matrices a coordinate with the fewest neighbours is
    /// always next, so that trees gain no entries.
    pub fn of(count: usize, pairs: impl Iterator<Item = (usize, usize)>) -> Self {
        let mut near: Vec<BTreeSet<usize>> = vec![BTreeSet::new(); count];
        for (a, b) in pairs.filter(|(a, b)| a != b) {
            near[a].insert(b);
            near[b].insert(a);
        }
        let degree = |near: &[BTreeSet<usize>], k: usize| if count <= OWN_ORDER { 0 } else { near[k].len() };
        let mut open: BTreeSet<(usize, usize)> = (0..count).map(|k| (degree(&near, k), k)).collect();
        let (mut order, mut step) = (Vec::with_capacity(count), vec![0; count]);
        let mut reached: Vec<Vec<usize>> = Vec::with_capacity(count);
        while let Some((_, k)) = open.pop_first() {
            step[k] = order.len();
            order.push(k);
            let own: Vec<usize> = std::mem::take(&mut near[k]).into_iter().collect();
            for &i in &own {
                open.remove(&(degree(&near, i), i));
                near[i].remove(&k);
                near[i].extend(own.iter().copied().filter(|&j| j != i));
                open.insert((degree(&near, i), i));
            }
            reached.push(own);
        }
        let sorted = |own: Vec<usize>| {
            let mut steps: Vec<usize> = own.into_iter().map(|k| step[k]).collect();
            steps.sort_unstable();
            steps
        };
        let below = reached.into_iter().map(sorted).collect();
        Self { order, step, below }
    }

    /// Number of coordinates.
    pub fn count(&self) -> usize {
        self.order.len()
    }
}

/// A symmetric matrix with a [`Pattern`], or its factors.
#[derive(Clone, Debug)]
pub struct SymmetricSparse<'p, T> {
    pattern: &'p Pattern,
    /// For each step: the diagonal entry.
    pub diagonal: Vec<T>,
    /// For each step: the entries at [`Pattern::below`].
    below: Vec<Vec<T>>,
}

impl<'p, T: Number> SymmetricSparse<'p, T> {
    /// The matrix of zeros.
    pub fn zeros(pattern: &'p Pattern) -> Self {
        let below = pattern.below.iter().map(|own| vec![T::ZERO; own.len()]).collect();
        Self { pattern, diagonal: vec![T::ZERO; pattern.count()], below }
    }

    /// The entry of two coordinates; each pair is stored once.
    pub fn entry_mut(&mut self, i: usize, j: usize) -> Option<&mut T> {
        let [a, b] = [self.pattern.step[i], self.pattern.step[j]];
        if a == b {
            return self.diagonal.get_mut(a);
        }
        let place = self.pattern.below[a.min(b)].binary_search(&a.max(b)).ok()?;
        self.below[a.min(b)].get_mut(place)
    }

    /// Replaces the matrix by its factors; `None` if `accept` returns `None` for a pivot.
    pub fn factor(mut self, accept: impl Fn(T, usize) -> Option<T>) -> Option<Self> {
        let mut shares = Vec::new();
        for j in 0..self.pattern.count() {
            let pivot = accept(self.diagonal[j], self.pattern.order[j])?;
            self.diagonal[j] = pivot;
            let (steps, own) = (&self.pattern.below[j], std::mem::take(&mut self.below[j]));
            shares.clear();
            shares.extend(own.iter().map(|x| x.over(pivot)));
            for (from, (&k, &x)) in steps.iter().zip(&own).enumerate() {
                self.diagonal[k] = self.diagonal[k].less_product(shares[from], x);
                let mut place = 0;
                for (&i, &share) in steps[from + 1..].iter().zip(&shares[from + 1..]) {
                    // Steps ascend in both lists, and the column of k has all these entries.
                    place += self.pattern.below[k][place..].partition_point(|&step| step < i);
                    self.below[k][place] = self.below[k][place].less_product(share, x);
                }
            }
            self.below[j] = shares.clone();
        }
        Some(self)
    }

    /// Replaces `x`, in the order of elimination, by L⁻¹ x.
    fn forward(&self, x: &mut [T]) {
        for j in 0..x.len() {
            let known = x[j];
            let entries = self.pattern.below[j].iter().zip(&self.below[j]);
            entries.for_each(|(&i, &share)| x[i] = x[i].less_product(share, known));
        }
    }

    /// A vector of coordinates in the order of elimination.
    fn by_steps(&self, x: &[T]) -> Vec<T> {
        self.pattern.order.iter().map(|&k| x[k]).collect()
    }

    /// Replaces `x` by the inverse of the factored matrix times `x`.
    pub fn solve(&self, x: &mut [T]) {
        let mut own = self.by_steps(x);
        self.forward(&mut own);
        for j in (0..own.len()).rev() {
            let entries = self.pattern.below[j].iter().zip(&self.below[j]);
            let scaled = own[j].over(self.diagonal[j]);
            own[j] = entries.fold(scaled, |sum, (&i, &share)| sum.less_product(share, own[i]));
        }
        self.pattern.order.iter().zip(own).for_each(|(&k, value)| x[k] = value);
    }

    /// L⁻¹ x in the order of elimination, for a vector of coordinates.
    pub fn half(&self, x: &[T]) -> Vec<T> {
        let mut own = self.by_steps(x);
        self.forward(&mut own);
        own
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::DMatrix;

    #[test]
    fn second_method_factors_solve_and_count_as_dense_ones() {
        // A ring of 80 with chords: larger than `OWN_ORDER`, and fill-in occurs.
        let n = 80;
        let pairs: Vec<(usize, usize)> =
            (0..n).flat_map(|k| [(k, (k + 1) % n), (k, (k * 7 + 3) % n)]).collect();
        let pattern = Pattern::of(n, pairs.iter().copied());
        let mut dense = DMatrix::<f64>::zeros(n, n);
        let mut own = SymmetricSparse::zeros(&pattern);
        let mut add = |i: usize, j: usize, x: f64| {
            *own.entry_mut(i, j).expect("an entry of the pattern") += x;
            dense[(i, j)] += x;
            if i != j {
                dense[(j, i)] += x;
            }
        };
        (0..n).for_each(|k| add(k, k, ((k + 1) as f64).sin()));
        pairs.iter().filter(|(a, b)| a != b).for_each(|&(i, j)| add(i, j, ((i + 2 * j) as f64).cos()));
        let factors = own.factor(|pivot, _| Some(pivot)).expect("pivots");
        let negative = factors.diagonal.iter().filter(|pivot| **pivot < 0.0).count();
        assert_eq!(negative, dense.clone().symmetric_eigenvalues().iter().filter(|x| **x < 0.0).count());
        let x: Vec<f64> = (0..n).map(|k| 1.0 / (k as f64 + 1.0)).collect();
        let row = |i: usize| (0..n).map(|j| dense[(i, j)] * x[j]).sum();
        let mut b: Vec<f64> = (0..n).map(row).collect();
        factors.solve(&mut b);
        // Rounding error of an elimination without pivoting, whose growth here is about 1e4.
        const NEAR: f64 = 1e-10;
        assert!(x.iter().zip(&b).all(|(x, b)| (x - b).abs() < NEAR), "{b:?}");
    }
}
