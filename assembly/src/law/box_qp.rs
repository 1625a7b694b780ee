//! Contact forces and impulses as a convex quadratic problem in a box (docs/assembly-law.md (A7)).
//!
//! Given columns a_i = L⁻¹ w_i of the contacts' directions, scaled by the Cholesky factor of the
//! inertia M = L Lᵀ, so that G = AᵀA, find λ within lo ≤ λ ≤ hi that minimizes ½ λᵀGλ - bᵀλ. The
//! residual r = b - Gλ is what is left of the relative accelerations (or velocities): zero where
//! λ_i lies inside its bounds, not positive at the lower and not negative at the upper one. The
//! minimum exists unless a direction lowers the value without end; r is unique even where λ is not.

use nalgebra::{DMatrix, DVector};

/// Two contacts count as dependent where the sine of the angle between a column and those before it
/// is under this: far above the rounding of the columns (1e-16 each), far below the 1e-5 that a
/// mass ratio of 1e10 leaves between two contacts.
const DEPENDENT: f64 = 1e-11;

/// Rounding of a force on a coordinate in parts of the sizes of its terms: some tens of roundings
/// of solving for them.
const ROUNDING: f64 = 1e-14;
/// Contacts over which rounding is passed on.
const NEIGHBOURS: usize = 2;

/// The contacts' problem. Bounds may be infinite; an equality has both infinite.
#[derive(Clone, Debug)]
pub struct BoxProblem {
    /// L⁻¹ w_i, one column a contact.
    pub columns: DMatrix<f64>,
    /// The residual at λ = 0.
    pub b: DVector<f64>,
    /// Lower bounds of λ.
    pub lo: DVector<f64>,
    /// Upper bounds of λ.
    pub hi: DVector<f64>,
    /// Below this a residual counts as zero.
    pub zero: DVector<f64>,
}

/// What solves a [`BoxProblem`].
#[derive(Clone, Debug)]
pub struct Solution {
    /// The forces or impulses.
    pub lambda: DVector<f64>,
    /// b - Gλ.
    pub residual: DVector<f64>,
    /// Below this each counts as zero.
    pub zero: DVector<f64>,
    /// Independent contacts whose λ lies inside its bounds, by their places.
    pub free: Vec<usize>,
}

/// Nothing gives way: along a direction the value falls without end.
#[derive(Clone, Debug, PartialEq)]
pub struct Jam {
    /// The contacts that take part, by their places.
    pub contacts: Vec<usize>,
}

/// An orthonormal basis of some of the columns, with the triangle that leads back to them.
struct Basis {
    places: Vec<usize>,
    q: Vec<DVector<f64>>,
    /// Upper triangle, column by column.
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

    /// Becomes the basis of `places`; what stands at the beginning of both stays.
    fn become_of(&mut self, columns: &DMatrix<f64>, places: &[usize]) {
        let stays = self.places.iter().zip(places).take_while(|(a, b)| a == b).count();
        self.places.truncate(stays);
        self.q.truncate(stays);
        self.r.truncate(stays);
        for &place in &places[stays..] {
            self.push(columns, place);
        }
    }

    /// The part of a column outside the span, and its coefficients in `q`: Gram–Schmidt, twice, so
    /// that what is left is orthogonal to rounding.
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

    /// Adds a column unless it depends on those there.
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

    /// The coefficients c of the columns in a vector of their span, given its coefficients in `q`:
    /// R c = y.
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

    /// The solution of Rᵀ y = b.
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

/// The columns' entries without signs, and their squared norms.
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

/// The largest independent part of `places`, taken in their order.
pub fn independent(columns: &DMatrix<f64>, places: &[usize]) -> Vec<usize> {
    Basis::of(columns, places).places
}

/// The upper triangle R with RᵀR = AᵀA, by orthogonalization of the columns, which does not square
/// their condition and leaves exact zeros between contacts that share no coordinate.
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
    /// Below this a contact's λ counts as zero: it makes no more of a residual than what counts as
    /// zero there.
    pub fn zero_force(&self, contact: usize, solution: &Solution) -> f64 {
        let compliance = self.columns.column(contact).norm_squared();
        if compliance > 0.0 { solution.zero[contact] / compliance } else { 0.0 }
    }

    /// Below this a residual counts as zero for given λ. What is given, and the rounding of the λ,
    /// are errors of forces on the coordinates; what they change at a contact is passed on to those
    /// that share a coordinate with it.
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

    /// The λ of the free contacts that make their residual zero, the others staying as they are.
    fn stationary(&self, basis: &Basis, lambda: &DVector<f64>) -> Vec<f64> {
        let mut others = lambda.clone();
        for &i in &basis.places {
            others[i] = 0.0;
        }
        let residual = self.residual(&others);
        let b: Vec<f64> = basis.places.iter().map(|&i| residual[i]).collect();
        basis.back(&basis.forward(&b))
    }

    /// Moves the free contacts from λ towards `target`, up to the first bound; returns those that
    /// reach it.
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

    /// The contact whose residual violates its bound most, in parts of its column's size; `first`
    /// takes the first one instead, by which the search cannot cycle (Bland's rule).
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

    /// Solves it by an active set: the free contacts have zero residual, the others stand at a
    /// bound; the most violated one becomes free, and what meets a bound on the way is no longer.
    /// Each turn lowers the value, so that no set comes twice; Bland's rule takes over where
    /// rounding would let one.
    ///
    /// # Errors
    /// [`Jam`] where nothing gives way.
    pub fn solve(&self) -> Result<Solution, Jam> {
        let m = self.b.len();
        // Not by `clamp`, which panics where levels beyond what doubles carry have left bounds that
        // are none.
        let mut lambda = DVector::from_fn(m, |i, _| 0.0f64.max(self.lo[i]).min(self.hi[i]));
        let equality = |i: usize| self.lo[i] == f64::NEG_INFINITY && self.hi[i] == f64::INFINITY;
        let mut free = independent(&self.columns, &(0..m).filter(|&i| equality(i)).collect::<Vec<_>>());
        let (sizes, mut basis) = (ColumnSizes::of(&self.columns), Basis::new());
        for turn in 0..100 * (m + 1) {
            // Free contacts at their stationary point, or as far as bounds allow.
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

    /// Makes a contact free. One whose column depends on the free ones moves along the direction
    /// that leaves the motion as it is, until one of them meets a bound and makes room.
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
