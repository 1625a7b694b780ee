//! The lowest modes of K φ = λ M φ by Lanczos' method with shift and invert.
//!
//! Blocks of vectors find multiple eigenvalues; every block is orthogonalised in M against all
//! earlier ones, twice. The number of eigenvalues below a value between two found ones is counted
//! by the inertia of K - s M; if one is missing, random vectors widen the next block.

use crate::dense::{add_product, transposed_times};
use crate::factor::random;
use crate::problem::Problem;
use crate::{Error, Result};
use nalgebra::DMatrix;

/// Vectors in a block: elastic modes of solids are at most threefold.
const BLOCK: usize = 4;
/// Largest residual of a converged pair in the norm of M, relative to 1/(λ - σ). The error of λ is
/// its square.
const CONVERGED: f64 = 1e-11;
/// Ratio of norms after and before orthogonalisation below which a vector counts as dependent on
/// earlier vectors.
const DEPENDENT: f64 = 1e-11;
/// Relative gap above which two eigenvalues count as separate; the count is taken within such a
/// gap.
const GAP: f64 = 1e-7;
/// Largest number of searches for missing eigenvalues; a sixfold eigenvalue takes two.
const ROUNDS: usize = 12;

/// How the number of eigenvalues is checked.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Check {
    /// Not at all: for estimates.
    None,
    /// An inertia count must agree with the number of eigenvalues found.
    Inertia,
}

/// The lowest modes.
#[derive(Clone, Debug)]
pub struct Modes {
    /// λ = ω², rising.
    pub values: Vec<f64>,
    /// φ, of mass 1.
    pub vectors: DMatrix<f64>,
    /// ‖K φ - λ M φ‖/‖K‖‖φ‖ of each mode.
    pub residuals: Vec<f64>,
    /// The value below which the eigenvalues were counted, and their number; none if the modes are
    /// all that the model has.
    pub counted: Option<(f64, usize)>,
    /// Whether the model has no further modes.
    pub exhausted: bool,
    /// Number of vectors of the Krylov space.
    pub steps: usize,
}

/// The Krylov space: its basis V, M V, and T = Vᵀ M (K - σ M)⁻¹ M V.
struct Space<'p, 'm> {
    problem: &'p Problem<'m>,
    basis: DMatrix<f64>,
    mass_basis: DMatrix<f64>,
    projected: DMatrix<f64>,
    /// Number of vectors.
    count: usize,
    /// Number of vectors whose image is known.
    applied: usize,
    /// Number of the last random block.
    seed: u64,
}

impl Space<'_, '_> {
    /// Adds vectors after orthogonalisation; a vector that depends on others is left out.
    /// Returns the number of added vectors.
    fn add(&mut self, mut block: DMatrix<f64>) -> usize {
        let mass = self.problem.mass;
        let before = mass.times(&block);
        let norms: Vec<f64> =
            (0..block.ncols()).map(|j| block.column(j).dot(&before.column(j)).max(0.0).sqrt()).collect();
        for _ in 0..2 {
            self.remove_known(&mut block);
        }
        let first = self.count;
        for (j, norm) in norms.iter().enumerate() {
            let mut x = block.columns(j, 1).into_owned();
            let mut own = mass.times(&x);
            for _ in 0..2 {
                let (known, known_mass) = (
                    self.basis.columns(first, self.count - first),
                    self.mass_basis.columns(first, self.count - first),
                );
                x -= known * known_mass.tr_mul(&x);
                own = mass.times(&x);
            }
            let left = x.dot(&own).max(0.0).sqrt();
            if left <= DEPENDENT * norm || left == 0.0 || !left.is_finite() {
                continue;
            }
            self.reserve();
            self.basis.set_column(self.count, &(x.column(0) / left));
            self.mass_basis.set_column(self.count, &(own.column(0) / left));
            self.count += 1;
        }
        self.count - first
    }

    /// Makes room for one more vector.
    fn reserve(&mut self) {
        if self.count == self.basis.ncols() {
            let more = 2 * self.count + 4 * BLOCK;
            for own in [&mut self.basis, &mut self.mass_basis] {
                *own = std::mem::replace(own, DMatrix::zeros(0, 0)).resize_horizontally(more, 0.0);
            }
        }
    }

    fn remove_known(&self, block: &mut DMatrix<f64>) {
        let known = 0..self.count;
        let parts = transposed_times(&self.mass_basis, known.clone(), block);
        add_product(block, -1.0, &self.basis, known, &parts);
    }

    /// Applies the operator to the last block, and widens the space by its image and by `more`
    /// random vectors. Returns the number of added vectors.
    fn grow(&mut self, more: usize) -> Result<usize> {
        let (first, width) = (self.applied, self.count - self.applied);
        let images = self.problem.solve(self.mass_basis.columns(first, width).into_owned())?;
        self.applied = self.count;
        let rows = images.nrows();
        let mut block = images.clone().resize_horizontally(width + more, 0.0);
        if more > 0 {
            self.seed += 1;
            let start = self.problem.solve(self.problem.mass.times(&random(rows, more, self.seed)))?;
            block.columns_mut(width, more).copy_from(&start);
        }
        let added = self.add(block);
        let inner = transposed_times(&self.mass_basis, 0..self.count, &images);
        self.projected.resize_mut(self.count, self.count, 0.0);
        for j in 0..width {
            for i in 0..self.count {
                self.projected[(i, first + j)] = inner[(i, j)];
                self.projected[(first + j, i)] = inner[(i, j)];
            }
        }
        Ok(added)
    }

    /// Ritz values of the applied vectors, falling, with their vectors and residuals.
    fn ritz(&self) -> (Vec<f64>, DMatrix<f64>, Vec<f64>) {
        let known = self.applied;
        let t = self.projected.view((0, 0), (known, known)).into_owned();
        let coupling = self.projected.view((known, 0), (self.count - known, known)).into_owned();
        let found = t.symmetric_eigen();
        let mut order: Vec<usize> = (0..known).collect();
        order.sort_by(|&a, &b| found.eigenvalues[b].total_cmp(&found.eigenvalues[a]));
        let values = order.iter().map(|&k| found.eigenvalues[k]).collect();
        let vectors = DMatrix::from_fn(known, known, |i, j| found.eigenvectors[(i, order[j])]);
        let outside = coupling * &vectors;
        let residuals = (0..known).map(|j| outside.column(j).norm()).collect();
        (values, vectors, residuals)
    }
}

/// The `wanted` lowest modes, or all modes of a smaller model.
///
/// # Errors
/// An error if they do not converge or if some remain missing.
pub fn lowest(problem: &Problem, wanted: usize, check: Check) -> Result<Modes> {
    let rows = problem.stiffness.count();
    let width = BLOCK.min(rows);
    let mut space = Space {
        problem,
        basis: DMatrix::zeros(rows, 0),
        mass_basis: DMatrix::zeros(rows, 0),
        projected: DMatrix::zeros(0, 0),
        count: 0,
        applied: 0,
        seed: 1,
    };
    let start = problem.solve(problem.mass.times(&random(rows, width, 1)))?;
    space.add(start);
    let most = (10 * wanted + 400).min(rows);
    // Fewer vectors than this do not settle.
    let (mut more, mut rounds, mut next_look) = (0, 0, (wanted + wanted / 2).min(rows));
    loop {
        let mut added = space.grow(std::mem::take(&mut more))?;
        if added == 0 {
            // An invariant space: only a random vector may leave it.
            let start = problem.solve(problem.mass.times(&random(rows, width, 1000 + space.seed)))?;
            space.seed += 1;
            added = space.add(start);
            let count = space.count;
            space.projected.resize_mut(count, count, 0.0);
        }
        let exhausted = added == 0;
        if space.applied < next_look && !exhausted {
            continue;
        }
        next_look = space.applied + (space.applied / 12).max(width);
        let (inverse, small, outside) = space.ritz();
        let settled =
            inverse.iter().zip(&outside).take_while(|(v, r)| **v > 0.0 && **r <= CONVERGED * **v).count();
        let values: Vec<f64> = inverse[..settled].iter().map(|v| problem.shift + 1.0 / v).collect();
        if exhausted || (check == Check::None && settled >= wanted) {
            return Ok(finish(&space, &small, &values, wanted, None, exhausted && settled <= wanted));
        }
        if let Some(separated) = separated(&values, wanted) {
            let between = 0.5 * (values[separated - 1] + values[separated]);
            let count = problem.below(between)?;
            if count == separated {
                return Ok(finish(&space, &small, &values, wanted, Some((between, count)), false));
            }
            rounds += 1;
            if rounds > ROUNDS || count < separated {
                let problem = format!(
                    "{separated} eigenvalues were found below {between:.6e} (rad/s)², but a count by inertia gives {count}; try another number of modes"
                );
                return Err(Error::new("eigenvalues", problem));
            }
            more = (count - separated).min(2 * BLOCK);
        }
        if space.count > most * (1 + rounds) {
            let text = format!(
                "{settled} of {wanted} modes converged in {} steps; reduce to fewer modes",
                space.count
            );
            return Err(Error::new("modes", text));
        }
    }
}

/// Number of values up to the first gap after `wanted` values, if there is one.
fn separated(values: &[f64], wanted: usize) -> Option<usize> {
    (wanted.max(1)..values.len()).find(|&k| values[k] - values[k - 1] > GAP * values[k].abs())
}

/// The first `wanted` modes in coordinates of the model, with their residuals.
fn finish(
    space: &Space,
    small: &DMatrix<f64>,
    values: &[f64],
    wanted: usize,
    counted: Option<(f64, usize)>,
    exhausted: bool,
) -> Modes {
    let problem = space.problem;
    let count = wanted.min(values.len());
    let mut vectors = DMatrix::zeros(space.basis.nrows(), count);
    let small = small.columns(0, count).into_owned();
    add_product(&mut vectors, 1.0, &space.basis, 0..space.applied, &small);
    for mut column in vectors.column_iter_mut() {
        // One sign for all runs: the largest component is positive.
        let largest = column.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(1.0);
        if largest < 0.0 {
            column.neg_mut();
        }
    }
    let (forces, inertias) = (problem.stiffness.times(&vectors), problem.mass.times(&vectors));
    let norm = problem.stiffness.norm();
    let residual = |i: usize| {
        let left = forces.column(i) - inertias.column(i) * values[i];
        left.norm() / (norm * vectors.column(i).norm())
    };
    let residuals = (0..count).map(residual).collect();
    let values = values[..count].to_vec();
    Modes { values, vectors, residuals, counted, exhausted, steps: space.count }
}
