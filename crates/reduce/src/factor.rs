//! Factorisations of sparse symmetric matrices.

use crate::sparse::Symmetric;
use crate::{Error, Result};
use faer::dyn_stack::{MemBuffer, MemStack, StackReq};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::linalg::cholesky::llt::factor::{LltError, LltRegularization};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side, Spec};
use nalgebra::DMatrix;
use std::sync::Arc;

/// The cores share a solution above this number of right-hand sides.
const SHARED: usize = 16;
/// Largest memory of one factor, bytes.
const MOST_MEMORY: usize = 32 << 30;

/// Triangle of a matrix below its diagonal, as the factorisations read it.
struct Lower {
    count: usize,
    starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl Lower {
    fn of(a: &Symmetric) -> Self {
        let (starts, rows, values) = a.lower();
        Self { count: a.count(), starts, rows, values }
    }

    fn pattern(&self) -> SymbolicSparseColMatRef<'_, usize> {
        SymbolicSparseColMatRef::new_checked(self.count, self.count, &self.starts, None, &self.rows)
    }

    fn matrix(&self) -> SparseColMatRef<'_, usize, f64> {
        SparseColMatRef::new(self.pattern(), &self.values)
    }
}

/// Order of elimination and pattern of the factor, for all matrices of one pattern.
#[derive(Clone)]
pub struct Analysis {
    symbolic: Arc<SymbolicCholesky<usize>>,
}

/// Cores for a factorisation.
pub(crate) fn cores() -> Par {
    Par::rayon(0)
}

fn memory(request: StackReq) -> Result<MemBuffer> {
    MemBuffer::try_new(request).map_err(|_| {
        let bytes = request.size_bytes() >> 20;
        Error::new("factorisation", format!("requires {bytes} MiB of memory, more than is available; use a smaller model, or a computer with more memory"))
    })
}

/// Memory for the numbers of a factor.
fn numbers(count: usize) -> Result<Vec<f64>> {
    let mut values = Vec::new();
    if count.saturating_mul(8) > MOST_MEMORY || values.try_reserve_exact(count).is_err() {
        let problem = format!(
            "the factor of the matrix has {count} numbers, too many for the memory of this computer; use a smaller model"
        );
        return Err(Error::new("factorisation", problem));
    }
    values.resize(count, 0.0);
    Ok(values)
}

impl Analysis {
    /// Analyses the pattern of a matrix.
    ///
    /// # Errors
    /// An error if the pattern is too large.
    pub fn new(a: &Symmetric) -> Result<Self> {
        let lower = Lower::of(a);
        let parameters = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..Default::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(lower.pattern(), Side::Lower, SymmetricOrdering::Amd, parameters);
        let symbolic = symbolic.map_err(|e| Error::new("factorisation", format!("{e:?}")))?;
        Ok(Self { symbolic: Arc::new(symbolic) })
    }

    /// Number of numbers of a factor.
    pub fn size(&self) -> usize {
        self.symbolic.len_val()
    }

    /// Row of the matrix that is eliminated at a step.
    fn row(&self, step: usize) -> usize {
        self.symbolic.perm().map_or(step, |order| order.arrays().0[step])
    }

    /// The diagonal of a factor, in the order of elimination.
    fn diagonal(&self, values: &[f64]) -> Vec<f64> {
        let SymbolicCholeskyRaw::Supernodal(nodes) = self.symbolic.raw() else {
            unreachable!("the analysis asks for supernodes");
        };
        let mut found = Vec::with_capacity(nodes.nrows());
        let starts = nodes.col_ptr_for_val();
        for s in 0..nodes.n_supernodes() {
            let columns = nodes.supernode_end()[s] - nodes.supernode_begin()[s];
            let own = &values[starts[s]..starts[s + 1]];
            let rows = own.len() / columns.max(1);
            found.extend((0..columns).map(|k| own[k * rows + k]));
        }
        found
    }

    /// Cholesky's factor of a matrix.
    ///
    /// # Errors
    /// An error if it is not positive definite or does not fit into memory.
    pub fn cholesky(&self, a: &Symmetric) -> Result<std::result::Result<Factor, usize>> {
        let lower = Lower::of(a);
        let mut values = numbers(self.size())?;
        let parameters = Spec::default();
        let mut buffer = memory(self.symbolic.factorize_numeric_llt_scratch::<f64>(cores(), parameters))?;
        let done = self.symbolic.factorize_numeric_llt(
            &mut values,
            lower.matrix(),
            Side::Lower,
            LltRegularization::default(),
            cores(),
            MemStack::new(&mut buffer),
            parameters,
        );
        if let Err(LltError::NonPositivePivot { index }) = done {
            return Ok(Err(self.row(index.min(a.count() - 1))));
        }
        Ok(Ok(Factor { analysis: self.clone(), values }))
    }

    /// The row with the least ratio of its pivot to its diagonal entry, and this ratio. The
    /// diagonal is increased by `more` of itself, so that a semidefinite matrix has pivots > 0.
    ///
    /// # Errors
    /// An error if the factor does not fit into memory.
    pub fn least_pivot(&self, a: &Symmetric, more: f64) -> Result<(usize, f64)> {
        let diagonal = a.diagonal();
        let mut raised = a.clone();
        raised.scale(|i, j| if i == j { 1.0 + more } else { 1.0 });
        let lower = Lower::of(&raised);
        let mut values = numbers(self.size())?;
        let parameters = Spec::default();
        let mut buffer = memory(self.symbolic.factorize_numeric_ldlt_scratch::<f64>(cores(), parameters))?;
        let done = self.symbolic.factorize_numeric_ldlt(
            &mut values,
            lower.matrix(),
            Side::Lower,
            LdltRegularization::default(),
            cores(),
            MemStack::new(&mut buffer),
            parameters,
        );
        if let Err(faer::linalg::cholesky::ldlt::factor::LdltError::ZeroPivot { index }) = done {
            return Ok((self.row(index.min(a.count() - 1)), 0.0));
        }
        let ratios = self.diagonal(&values).into_iter().enumerate().map(|(step, pivot)| {
            let row = self.row(step);
            (row, pivot / diagonal[row].abs())
        });
        let least = ratios.min_by(|one, other| one.1.total_cmp(&other.1));
        Ok(least.unwrap_or((0, 1.0)))
    }

    /// Number of negative eigenvalues of a matrix, by Sylvester's law of inertia.
    ///
    /// # Errors
    /// An error if the factor does not fit into memory, or is too inexact to count.
    pub fn negative_eigenvalues(&self, a: &Symmetric) -> Result<usize> {
        let count = a.count();
        let lower = Lower::of(a);
        let (mut values, mut below) = (numbers(self.size())?, vec![0.0; count]);
        let (mut forward, mut inverse) = (vec![0; count], vec![0; count]);
        let parameters = Spec::default();
        let request = self.symbolic.factorize_numeric_intranode_lblt_scratch::<f64>(cores(), parameters);
        let mut buffer =
            memory(StackReq::any_of(&[request, self.symbolic.solve_in_place_scratch::<f64>(1, cores())]))?;
        let factor = self.symbolic.factorize_numeric_intranode_lblt(
            &mut values,
            &mut below,
            &mut forward,
            &mut inverse,
            lower.matrix(),
            Side::Lower,
            cores(),
            MemStack::new(&mut buffer),
            parameters,
        );
        let x = random(count, 1, 17);
        let mut solved = a.times(&x);
        let rhs = MatMut::from_column_major_slice_mut(solved.as_mut_slice(), count, 1);
        factor.solve_in_place_with_conj(Conj::No, rhs, Par::Seq, MemStack::new(&mut buffer));
        let wrong = (a.times(&solved) - a.times(&x)).norm() / (a.norm() * x.norm());
        if wrong.is_nan() || wrong > COUNTED {
            let problem = format!(
                "the relative residual of the factorisation is {wrong:.1e}; expected at most {COUNTED:.0e}"
            );
            return Err(Error::new("count of the eigenvalues", problem));
        }
        Ok(negative_pivots(&self.diagonal(&values), &below))
    }
}

/// Largest relative residual of a factor whose signs are counted: an inexact factor is the exact
/// one of a matrix that is this much different.
const COUNTED: f64 = 1e-11;

/// Number of negative eigenvalues of blocks of one or two rows along the diagonal.
fn negative_pivots(diagonal: &[f64], below: &[f64]) -> usize {
    let (mut found, mut k) = (0, 0);
    while k < diagonal.len() {
        if below[k] == 0.0 || k + 1 == diagonal.len() {
            found += usize::from(diagonal[k] < 0.0);
            k += 1;
            continue;
        }
        let determinant = diagonal[k] * diagonal[k + 1] - below[k] * below[k];
        found += if determinant < 0.0 { 1 } else { 2 * usize::from(diagonal[k] < 0.0) };
        k += 2;
    }
    found
}

/// Cholesky's factor.
pub struct Factor {
    analysis: Analysis,
    values: Vec<f64>,
}

impl Factor {
    /// Solves A x = b for each column, in place.
    ///
    /// # Errors
    /// An error if there is too little memory.
    pub fn solve(&self, b: &mut DMatrix<f64>) -> Result<()> {
        let (rows, columns) = b.shape();
        let symbolic = &self.analysis.symbolic;
        let mut buffer = memory(symbolic.solve_in_place_scratch::<f64>(columns, cores()))?;
        let factor = LltRef::new(symbolic, &self.values);
        let b = MatMut::from_column_major_slice_mut(b.as_mut_slice(), rows, columns);
        // The work on a few columns is too small to be shared.
        let par = if columns > SHARED { cores() } else { Par::Seq };
        factor.solve_in_place_with_conj(Conj::No, b, par, MemStack::new(&mut buffer));
        Ok(())
    }

    /// Least ratio of a pivot to the entry of the diagonal, with its row.
    pub fn least_pivot(&self, a: &Symmetric) -> (usize, f64) {
        let diagonal = a.diagonal();
        let pivots = self.analysis.diagonal(&self.values).into_iter().enumerate();
        let ratios = pivots.map(|(step, root)| {
            let row = self.analysis.row(step);
            (row, root * root / diagonal[row])
        });
        ratios.min_by(|one, other| one.1.total_cmp(&other.1)).unwrap_or((0, 1.0))
    }
}

/// Numbers in -1 to 1 that are the same in every run.
pub fn random(rows: usize, columns: usize, seed: u64) -> DMatrix<f64> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    DMatrix::from_fn(rows, columns, |_, _| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sparse::{Entry, Listed};

    /// Solutions of small systems: a few roundings.
    const ROUNDING: f64 = 1e-13;

    /// A chain to ground of unit springs, with one spring of another stiffness.
    fn chain(count: usize, at: usize, other: f64) -> Symmetric {
        let stiffness = |i: usize| if i == at { other } else { 1.0 };
        let mut entries = Vec::new();
        for i in 0..count {
            let after = if i + 1 < count { stiffness(i + 1) } else { 0.0 };
            entries.push(Entry { row: i, column: i, value: stiffness(i) + after });
            if i > 0 {
                entries.push(Entry { row: i, column: i - 1, value: -stiffness(i) });
            }
        }
        Symmetric::assemble(count, &entries, Listed::Once, &|i| i.to_string()).unwrap()
    }

    #[test]
    fn closed_form_a_chain_hangs_straight() {
        let a = chain(50, 0, 1.0);
        let analysis = Analysis::new(&a).unwrap();
        let factor = analysis.cholesky(&a).unwrap().unwrap();
        let mut x = DMatrix::zeros(50, 2);
        (x[(49, 0)], x[(24, 1)]) = (1.0, 2.0);
        factor.solve(&mut x).unwrap();
        for i in 0..50 {
            assert!((x[(i, 0)] - (i + 1) as f64).abs() < 50.0 * ROUNDING);
            assert!((x[(i, 1)] - 2.0 * (i + 1).min(25) as f64).abs() < 50.0 * ROUNDING);
        }
        let (_, ratio) = factor.least_pivot(&a);
        assert!(ratio > 0.0 && ratio < 1.0, "{ratio}");
    }

    #[test]
    fn closed_form_eigenvalues_of_a_chain_are_counted() {
        // 2 - 2 cos(pi (2k - 1)/(2n + 1)), k = 1, …, n
        let count = 40;
        let a = chain(count, 0, 1.0);
        let analysis = Analysis::new(&a).unwrap();
        let unit: Vec<Entry> = (0..count).map(|i| Entry { row: i, column: i, value: 1.0 }).collect();
        let unit = Symmetric::assemble(count, &unit, Listed::Once, &|i| i.to_string()).unwrap();
        let own =
            |k: usize| 2.0 - 2.0 * (std::f64::consts::PI * (2 * k - 1) as f64 / (2 * count + 1) as f64).cos();
        for k in 1..count {
            let between = 0.5 * (own(k) + own(k + 1));
            assert_eq!(analysis.negative_eigenvalues(&a.plus(-between, &unit)).unwrap(), k);
        }
    }

    #[test]
    fn invariant_a_negative_spring_is_found_by_its_pivot() {
        let a = chain(30, 17, -0.01);
        let analysis = Analysis::new(&a).unwrap();
        assert!(analysis.cholesky(&a).unwrap().is_err());
        let (_, ratio) = analysis.least_pivot(&a, 1e-12).unwrap();
        assert!(ratio < -1e-6, "{ratio}");
        let (_, ratio) = analysis.least_pivot(&chain(30, 17, 1.0), 1e-12).unwrap();
        assert!(ratio > 1e-3, "{ratio}");
    }
}
