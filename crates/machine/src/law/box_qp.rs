//! Contact forces and impulses as a convex quadratic program with box constraints
//! (docs/assembly-law.md (A7)).
//!
//! Columns a_i = L⁻¹ w_i are the contacts' directions, scaled by the Cholesky factor of the
//! inertia M = L Lᵀ, so that G = AᵀA. Find λ within lo ≤ λ ≤ hi that minimizes ½ λᵀGλ - bᵀλ. The
//! residual r = b - Gλ is the remaining relative acceleration (or velocity). It is zero if λ_i
//! lies inside its bounds, not positive at the lower bound and not negative at the upper one. The
//! minimum exists unless the objective is unbounded below along a direction. r is unique, even if
//! λ is not.

use nalgebra::{DMatrix, DVector};

/// A column depends on earlier columns if the sine of its angle to their span is below this limit.
/// It is far above the rounding of the columns (1e-16 each), and far below the 1e-5 that a mass
/// ratio of 1e10 leaves between two contacts.
const DEPENDENT: f64 = 1e-11;

/// Rounding error of a force on a coordinate, relative to the sum of the absolute values of its
/// terms: some tens of rounding errors of the solution.
const ROUNDING: f64 = 1e-14;
/// Range of the rounding of one contact, in neighbouring contacts.
const NEIGHBOURS: usize = 2;

/// The quadratic program of the contacts. Bounds may be infinite; for an equality both are.
#[derive(Clone, Debug)]
pub struct BoxProblem {
    /// Columns L⁻¹ w_i, one for each contact.
    pub columns: DMatrix<f64>,
    /// The residual at λ = 0.
    pub b: DVector<f64>,
    /// Lower bounds of λ.
    pub lo: DVector<f64>,
    /// Upper bounds of λ.
    pub hi: DVector<f64>,
    /// Tolerance of each contact: a residual up to it counts as zero.
    pub zero: DVector<f64>,
}

/// The solution of a [`BoxProblem`].
#[derive(Clone, Debug)]
pub struct Solution {
    /// The forces or impulses.
    pub lambda: DVector<f64>,
    /// The residual b - Gλ.
    pub residual: DVector<f64>,
    /// Tolerance of each contact: a residual up to it counts as zero.
    pub zero: DVector<f64>,
    /// Indices of independent contacts whose λ lies inside its bounds.
    pub free: Vec<usize>,
}

/// The objective is unbounded below along a direction, so a solution does not exist: mechanically,
/// nothing can give way.
#[derive(Clone, Debug, PartialEq)]
pub struct Jam {
    /// Indices of the contacts involved.
    pub contacts: Vec<usize>,
}

/// A QR factorization of some of the columns.
struct Basis {
    /// Indices of the columns.
    places: Vec<usize>,
    /// Orthonormal vectors.
    q: Vec<DVector<f64>>,
    /// Upper triangle R, column by column.
    r: Vec<Vec<f64>>,
}

impl Basis {
    fn new() -> Self {
        Self { places: Vec::new(), q: Vec::new(), r: Vec::new() }
    }

    fn of(columns: &DMatrix<f64>, places: &[usize]) -> Self {
        let mut basis = Self::new();
        basis.become_of(columns, places);
        basis
    }

    /// Turns this into the factorization of the columns `places`, keeping the leading columns that
    /// both have in common.
    fn become_of(&mut self, columns: &DMatrix<f64>, places: &[usize]) {
        let stays = self.places.iter().zip(places).take_while(|(a, b)| a == b).count();
        self.places.truncate(stays);
        self.q.truncate(stays);
        self.r.truncate(stays);
        for &place in &places[stays..] {
            self.push(columns, place);
        }
    }

    /// Splits a column into its part outside the span and its coefficients in `q`. Gram–Schmidt is
    /// done twice, so that the rest is orthogonal up to rounding.
    fn split(&self, column: DVector<f64>) -> (DVector<f64>, Vec<f64>) {
        let (mut rest, mut coefficients) = (column, vec![0.0; self.q.len()]);
        for _ in 0..2 {
            for (q, c) in self.q.iter().zip(&mut coefficients) {
                let part = q.dot(&rest);
                *c += part;
                rest.axpy(-part, q, 1.0);
            }
        }
        (rest, coefficients)
    }

    /// Adds a column; returns `false` if it depends on earlier columns.
    fn push(&mut self, columns: &DMatrix<f64>, place: usize) -> bool {
        let column = columns.column(place).into_owned();
        let size = column.norm();
        let (rest, mut coefficients) = self.split(column);
        let length = rest.norm();
        if length <= DEPENDENT * size || size == 0.0 {
            return false;
        }
        coefficients.push(length);
        self.q.push(rest / length);
        self.r.push(coefficients);
        self.places.push(place);
        true
    }

    /// Solves R c = y. A vector with coefficients y in `q` has coefficients c in the columns.
    fn back(&self, y: &[f64]) -> Vec<f64> {
        let mut c = y.to_vec();
        for j in (0..c.len()).rev() {
            c[j] /= self.r[j][j];
            for i in 0..j {
                c[i] -= self.r[j][i] * c[j];
            }
        }
        c
    }

    /// Solves Rᵀ y = b.
    fn forward(&self, b: &[f64]) -> Vec<f64> {
        let mut y = b.to_vec();
        for j in 0..y.len() {
            for i in 0..j {
                y[j] -= self.r[j][i] * y[i];
            }
            y[j] /= self.r[j][j];
        }
        y
    }
}

/// Absolute values of the columns' entries, and the columns' squared norms.
struct ColumnSizes {
    sizes: DMatrix<f64>,
    norms: Vec<f64>,
}

impl ColumnSizes {
    fn of(columns: &DMatrix<f64>) -> Self {
        let sizes = columns.abs();
        let norms = sizes.column_iter().map(|c| c.norm_squared().max(f64::MIN_POSITIVE)).collect();
        Self { sizes, norms }
    }
}

/// Returns the group number of each column. Two columns with nonzero entries in the same row are
/// in one group, and so are columns connected through a chain of such columns.
pub fn groups_by_columns(columns: &DMatrix<f64>) -> Vec<usize> {
    let mut group_of: Vec<usize> = (0..columns.ncols()).collect();
    let mut first: Vec<Option<usize>> = vec![None; columns.nrows()];
    for (place, column) in columns.column_iter().enumerate() {
        for (row, _) in column.iter().enumerate().filter(|(_, x)| **x != 0.0) {
            let (own, other) = (group_of[place], group_of[*first[row].get_or_insert(place)]);
            if own != other {
                group_of.iter_mut().filter(|group| **group == own).for_each(|group| *group = other);
            }
        }
    }
    group_of
}

/// Returns a maximal independent subset of `places`, preferring earlier ones.
pub fn independent(columns: &DMatrix<f64>, places: &[usize]) -> Vec<usize> {
    Basis::of(columns, places).places
}

/// Returns the upper triangle R with RᵀR = AᵀA. Orthogonalizing the columns does not square their
/// condition number, and leaves exact zeros between different groups ([`groups_by_columns`]).
pub fn triangle(columns: &DMatrix<f64>) -> DMatrix<f64> {
    let (count, mut basis) = (columns.ncols(), Basis::new());
    for place in 0..count {
        let (rest, mut coefficients) = basis.split(columns.column(place).into_owned());
        let length = rest.norm().max(f64::MIN_POSITIVE);
        coefficients.push(length);
        basis.q.push(rest / length);
        basis.r.push(coefficients);
    }
    DMatrix::from_fn(count, count, |i, j| if i <= j { basis.r[j][i] } else { 0.0 })
}

impl BoxProblem {
    /// Returns the largest |λ| of a contact that counts as zero: such a λ changes the contact's
    /// own residual by no more than its tolerance.
    pub fn zero_force(&self, contact: usize, solution: &Solution) -> f64 {
        let compliance = self.columns.column(contact).norm_squared();
        if compliance > 0.0 { solution.zero[contact] / compliance } else { 0.0 }
    }

    /// Returns the tolerance of each contact's residual for a given λ. The tolerance `self.zero`,
    /// converted to an error of λ, and the rounding of λ cause errors in the forces on the
    /// coordinates. These propagate to contacts that share a coordinate.
    fn zero(&self, lambda: &DVector<f64>, ColumnSizes { sizes, norms }: &ColumnSizes) -> DVector<f64> {
        let errors = |i: usize, residual: f64| residual / norms[i];
        let own = DVector::from_fn(lambda.len(), |i, _| errors(i, self.zero[i]) + ROUNDING * lambda[i].abs());
        let mut forces = sizes * own;
        for _ in 0..NEIGHBOURS {
            let residuals = sizes.tr_mul(&forces);
            forces = sizes * DVector::from_fn(lambda.len(), |i, _| errors(i, residuals[i]));
        }
        sizes.tr_mul(&forces)
    }

    fn residual(&self, lambda: &DVector<f64>) -> DVector<f64> {
        let force = &self.columns * lambda;
        &self.b - self.columns.tr_mul(&force)
    }

    /// Returns the λ of the free contacts that make their residual zero, with the other λ fixed.
    fn stationary(&self, basis: &Basis, lambda: &DVector<f64>) -> Vec<f64> {
        let mut others = lambda.clone();
        for &i in &basis.places {
            others[i] = 0.0;
        }
        let residual = self.residual(&others);
        let b: Vec<f64> = basis.places.iter().map(|&i| residual[i]).collect();
        basis.back(&basis.forward(&b))
    }

    /// Moves the free contacts' λ towards `target` up to the first bound; returns the contacts
    /// that reach it.
    fn step(&self, free: &[usize], target: &[f64], lambda: &mut DVector<f64>) -> Vec<usize> {
        let mut part = 1.0f64;
        for (&i, &to) in free.iter().zip(target) {
            let bound = to.clamp(self.lo[i], self.hi[i]);
            if bound != to {
                part = part.min(((bound - lambda[i]) / (to - lambda[i])).max(0.0));
            }
        }
        let mut reached = Vec::new();
        for (&i, &to) in free.iter().zip(target) {
            let from = lambda[i];
            let next = if part == 1.0 { to } else { from + part * (to - from) };
            let outside = to < self.lo[i] || to > self.hi[i];
            let bound = to.clamp(self.lo[i], self.hi[i]);
            if outside && part < 1.0 && ((bound - from) / (to - from)).max(0.0) <= part {
                lambda[i] = bound;
                reached.push(i);
            } else {
                lambda[i] = next.clamp(self.lo[i], self.hi[i]);
            }
        }
        reached
    }

    /// Returns the contact with the largest violation relative to the norm of its column. If
    /// `first`, returns the violating contact with the lowest index instead, so that the search
    /// cannot cycle (Bland's rule).
    fn violated(
        &self,
        lambda: &DVector<f64>,
        [residual, zero]: [&DVector<f64>; 2],
        sizes: &ColumnSizes,
        first: bool,
    ) -> Option<usize> {
        let mut best: Option<(usize, f64)> = None;
        for i in 0..lambda.len() {
            let r = residual[i];
            let wants_more = r > zero[i] && lambda[i] < self.hi[i];
            let wants_less = r < -zero[i] && lambda[i] > self.lo[i];
            if wants_more || wants_less {
                let norm = sizes.norms[i];
                let share = if norm > f64::MIN_POSITIVE { r.abs() / norm.sqrt() } else { f64::INFINITY };
                if first {
                    return Some(i);
                }
                if best.is_none_or(|(_, most)| share > most) {
                    best = Some((i, share));
                }
            }
        }
        best.map(|(i, _)| i)
    }

    /// Solves the problem, one group of contacts that share coordinates at a time.
    ///
    /// # Errors
    /// [`Jam`] if the objective is unbounded below.
    pub fn solve(&self) -> Result<Solution, Jam> {
        let (groups, m) = (self.groups(), self.b.len());
        if groups.len() == 1 {
            return self.solve_coupled();
        }
        let [lambda, residual, zero] = [0.0; 3].map(|x| DVector::from_element(m, x));
        let mut all = Solution { lambda, residual, zero, free: Vec::new() };
        for (places, rows) in groups {
            let own = |of: &DVector<f64>| DVector::from_fn(places.len(), |k, _| of[places[k]]);
            let part = Self {
                columns: DMatrix::from_fn(rows.len(), places.len(), |i, k| {
                    self.columns[(rows[i], places[k])]
                }),
                b: own(&self.b),
                lo: own(&self.lo),
                hi: own(&self.hi),
                zero: own(&self.zero),
            };
            let named = |jam: Jam| Jam { contacts: jam.contacts.into_iter().map(|k| places[k]).collect() };
            let solution = part.solve_coupled().map_err(named)?;
            for (k, &place) in places.iter().enumerate() {
                all.lambda[place] = solution.lambda[k];
                all.residual[place] = solution.residual[k];
                all.zero[place] = solution.zero[k];
            }
            all.free.extend(solution.free.into_iter().map(|k| places[k]));
        }
        Ok(all)
    }

    /// Returns groups of contacts that share coordinates, directly or through others: the indices
    /// of the contacts and of the rows of their columns.
    fn groups(&self) -> Vec<(Vec<usize>, Vec<usize>)> {
        let group_of = groups_by_columns(&self.columns);
        let mut groups: Vec<(Vec<usize>, Vec<usize>)> = vec![Default::default(); group_of.len()];
        group_of.iter().enumerate().for_each(|(place, &group)| groups[group].0.push(place));
        for (row, entries) in self.columns.row_iter().enumerate() {
            let first = entries.iter().position(|x| *x != 0.0);
            first.into_iter().for_each(|place| groups[group_of[place]].1.push(row));
        }
        groups.retain(|(places, _)| !places.is_empty());
        groups
    }

    /// Solves the problem of one group by an active-set method: free contacts have zero residual,
    /// the others are at a bound. In each turn the most violated contact becomes free, and
    /// contacts that reach a bound on the way stop being free. No turn raises the objective. After
    /// 10 (m + 1) turns Bland's rule is used, in case rounding makes a set recur.
    fn solve_coupled(&self) -> Result<Solution, Jam> {
        let m = self.b.len();
        // `clamp` would panic for NaN bounds, which overflowing friction levels cause.
        let mut lambda = DVector::from_fn(m, |i, _| 0.0f64.max(self.lo[i]).min(self.hi[i]));
        let equality = |i: usize| self.lo[i] == f64::NEG_INFINITY && self.hi[i] == f64::INFINITY;
        let mut free = independent(&self.columns, &(0..m).filter(|&i| equality(i)).collect::<Vec<_>>());
        let (sizes, mut basis) = (ColumnSizes::of(&self.columns), Basis::new());
        for turn in 0..100 * (m + 1) {
            // Move the free contacts to their stationary point, or as far as bounds allow.
            loop {
                basis.become_of(&self.columns, &free);
                let target = self.stationary(&basis, &lambda);
                let reached = self.step(&basis.places, &target, &mut lambda);
                if reached.is_empty() {
                    break;
                }
                free.retain(|i| !reached.contains(i));
            }
            let residual = self.residual(&lambda);
            let mut left = residual.clone();
            for &i in &free {
                left[i] = 0.0;
            }
            let zero = self.zero(&lambda, &sizes);
            let Some(entering) = self.violated(&lambda, [&left, &zero], &sizes, turn > 10 * (m + 1)) else {
                return Ok(Solution { lambda, residual: left, zero, free });
            };
            self.enter(&basis, entering, left[entering].signum(), &mut lambda, &mut free)?;
        }
        let (residual, zero) = (self.residual(&lambda), self.zero(&lambda, &sizes));
        Ok(Solution { lambda, residual, zero, free })
    }

    /// Makes a contact free. If its column depends on free columns, λ moves along the direction
    /// that does not change the motion, until a contact reaches its bound and leaves.
    fn enter(
        &self,
        basis: &Basis,
        entering: usize,
        direction: f64,
        lambda: &mut DVector<f64>,
        free: &mut Vec<usize>,
    ) -> Result<(), Jam> {
        let column = self.columns.column(entering).into_owned();
        let size = column.norm();
        let (rest, coefficients) = basis.split(column);
        if size > 0.0 && rest.norm() > DEPENDENT * size {
            free.push(entering);
            return Ok(());
        }
        let shares = basis.back(&coefficients);
        // λ_entering += t · direction, λ_free -= t · direction · share.
        let own = if direction > 0.0 { self.hi[entering] } else { self.lo[entering] };
        let mut length = (own - lambda[entering]).abs();
        let mut leaving = None;
        for (&i, share) in basis.places.iter().zip(&shares) {
            let rate = -direction * share;
            if rate.abs() <= DEPENDENT {
                continue;
            }
            let bound = if rate > 0.0 { self.hi[i] } else { self.lo[i] };
            let room = ((bound - lambda[i]) / rate).max(0.0);
            if room < length {
                (length, leaving) = (room, Some((i, bound)));
            }
        }
        if !length.is_finite() {
            let mut contacts: Vec<usize> = basis
                .places
                .iter()
                .zip(&shares)
                .filter(|(_, s)| s.abs() > DEPENDENT)
                .map(|(&i, _)| i)
                .collect();
            contacts.push(entering);
            return Err(Jam { contacts });
        }
        for (&i, share) in basis.places.iter().zip(&shares) {
            lambda[i] = (lambda[i] - length * direction * share).clamp(self.lo[i], self.hi[i]);
        }
        lambda[entering] += length * direction;
        match leaving {
            Some((i, bound)) => {
                lambda[i] = bound;
                free.retain(|&f| f != i);
                free.push(entering);
            }
            None => lambda[entering] = own,
        }
        Ok(())
    }
}
