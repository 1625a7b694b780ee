//! The reduction: MacNeal's, Rubin's, and Craig and Bampton's.

use crate::eigen::{self, Check, Modes};
use crate::interface::Interface;
use crate::model::Model;
use crate::problem::Problem;
use crate::shift::factorise;
use crate::sparse::Symmetric;
use crate::{Error, Result};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::PI;

/// Largest number of coordinates of a machine.
pub const MOST_COORDINATES: usize = 500;
/// Relative tolerance, as an eigenvalue, for a dependent combination of shapes.
const DEPENDENT: f64 = 1e-12;
/// Relative tolerance of the refinement of a static shape: rounding.
const REFINED: f64 = 1e-15;
/// Number of elastic free modes for the first frequency of a Craig-Bampton body.
const COMPARED: usize = 6;

/// Method of reduction.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Method {
    /// Free-interface modes; the residual flexibility at the interface is computed and reported.
    MacNeal,
    /// Free-interface modes and the residual shapes as modes of their own.
    Rubin,
    /// Fixed-interface modes and constraint modes.
    CraigBampton,
}

impl Method {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::MacNeal => "macneal",
            Self::Rubin => "rubin",
            Self::CraigBampton => "craig-bampton",
        }
    }
}

/// A reduced body in modal coordinates of mass 1.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// The method.
    pub method: Method,
    /// ω² of each coordinate, rising; exactly 0 of a rigid-body mode.
    pub values: Vec<f64>,
    /// Displacement of each dof by each coordinate.
    pub basis: DMatrix<f64>,
    /// Rows of the basis at the interface dofs, in their order.
    pub rows: DMatrix<f64>,
    /// Static flexibility at the interface dofs, of a free body without its rigid motion.
    pub flexibility: DMatrix<f64>,
    /// The part of the flexibility that the coordinates lack.
    pub residual: DMatrix<f64>,
    /// The computed modes of the model: all that are kept, or a few of them for Craig and Bampton.
    pub modes: Modes,
    /// The fixed-interface modes of Craig and Bampton.
    pub fixed: Option<Modes>,
    /// Number of rigid-body modes.
    pub rigid: usize,
    /// Displacement of all dofs under their weight in each direction, if the body is held.
    pub sag: Vec<DVector<f64>>,
}

impl Reduced {
    /// Natural frequencies, Hz.
    pub fn frequencies(&self) -> Vec<f64> {
        self.values.iter().map(|value| value.sqrt() / (2.0 * PI)).collect()
    }
}

/// Reduces a model to `wanted` modes (of Rubin and of Craig and Bampton, further ones for the
/// interface).
///
/// # Errors
/// An error if the matrices are not positive semidefinite, or modes are missing.
pub fn reduce(model: &Model, interfaces: &[Interface], method: Method, wanted: usize) -> Result<Reduced> {
    // On a thread of the pool, so that no part of the work waits to be taken up by one.
    let mut reduced = None;
    rayon::scope(|_| reduced = Some(reduce_here(model, interfaces, method, wanted)));
    reduced.expect("the scope runs its closure")
}

fn reduce_here(model: &Model, interfaces: &[Interface], method: Method, wanted: usize) -> Result<Reduced> {
    model.check()?;
    let at: Vec<usize> = interfaces.iter().flat_map(|own| own.dofs.iter().map(|(_, row)| *row)).collect();
    let most = wanted + if method == Method::MacNeal { 0 } else { at.len() };
    if wanted == 0 || most > MOST_COORDINATES {
        let problem = format!("gives {most} coordinates; expected 1 to {MOST_COORDINATES}");
        return Err(Error::new(format!("--modes {wanted}"), problem));
    }
    if at.is_empty() && method != Method::MacNeal {
        return Err(Error::new(format!("--method {}", method.name()), "requires --interface"));
    }
    let name = |row: usize| model.name(row);
    let problem = factorise(&model.stiffness, &model.mass, &name)?;
    let free = if method == Method::CraigBampton { wanted.min(problem.rigid + COMPARED) } else { wanted };
    let (modes, rigid) = modes(&problem, free.max(problem.rigid))?;
    if rigid > wanted {
        let text =
            format!("the body has {rigid} rigid-body modes; expected at least as many modes, or --clamp");
        return Err(Error::new(format!("--modes {wanted}"), text));
    }
    let loads = loads(&at, model.dofs.len());
    let shapes = residual_shapes(&problem, &modes, &loads)?;
    let residual = symmetric(rows(&shapes, &at));
    let flexibility = &residual + static_part(&rows(&modes.vectors, &at), &modes.values);
    let sag = sag(model, &problem)?;
    let made = Made { model, problem: &problem, at: &at, wanted };
    let (values, basis, fixed) = match method {
        Method::MacNeal => (modes.values.clone(), modes.vectors.clone(), None),
        Method::Rubin => made.rubin(&modes, &shapes)?,
        Method::CraigBampton => made.craig_bampton()?,
    };
    let rows = rows(&basis, &at);
    let residual = match method {
        Method::MacNeal => residual,
        _ => symmetric(&flexibility - static_part(&rows, &values)),
    };
    Ok(Reduced { method, values, basis, rows, flexibility, residual, modes, fixed, rigid, sag })
}

/// The lowest modes, counted; eigenvalues of rigid-body modes are 0.
fn modes(problem: &Problem, wanted: usize) -> Result<(Modes, usize)> {
    let mut modes = eigen::lowest(problem, wanted, Check::Inertia)?;
    let count = modes.values.len();
    let rigid = problem.rigid.min(count);
    modes.values[..rigid].fill(0.0);
    if let Some(value) = modes.values.iter().find(|value| **value < 0.0) {
        let text = format!(
            "the stiffness matrix has a negative eigenvalue, {value:.3e}; expected a positive semidefinite matrix"
        );
        return Err(Error::new("stiffness", text));
    }
    Ok((modes, rigid))
}

/// A unit load on each of these dofs.
fn loads(at: &[usize], count: usize) -> DMatrix<f64> {
    let mut loads = DMatrix::zeros(count, at.len());
    at.iter().enumerate().for_each(|(j, &row)| loads[(row, j)] = 1.0);
    loads
}

fn rows(shapes: &DMatrix<f64>, at: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(at.len(), shapes.ncols(), |i, j| shapes[(at[i], j)])
}

fn symmetric(a: DMatrix<f64>) -> DMatrix<f64> {
    0.5 * (&a + a.transpose())
}

/// Σ b bᵀ/ω² of the modes that are not rigid.
fn static_part(rows: &DMatrix<f64>, values: &[f64]) -> DMatrix<f64> {
    let scaled = DMatrix::from_fn(rows.nrows(), rows.ncols(), |i, j| match values[j] {
        0.0 => 0.0,
        value => rows[(i, j)] / value,
    });
    scaled * rows.transpose()
}

/// Static shapes of loads without their part in the modes: K u = (1 - M Φ Φᵀ) b, Φᵀ M u = 0. The
/// shift of a free body is removed by refinement. Each step reduces the error by σ/(λ - σ) of
/// the first left-out λ.
fn residual_shapes(problem: &Problem, modes: &Modes, loads: &DMatrix<f64>) -> Result<DMatrix<f64>> {
    let phi = &modes.vectors;
    let mass_phi = problem.mass.times(phi);
    let without = |shapes: DMatrix<f64>| &shapes - phi * mass_phi.tr_mul(&shapes);
    let own = loads - &mass_phi * phi.tr_mul(loads);
    let mut shapes = without(problem.solve(own.clone())?);
    let mut before = f64::INFINITY;
    for _ in 0..40 {
        let left = &own - problem.stiffness.times(&shapes);
        let change = without(problem.solve(&left - &mass_phi * phi.tr_mul(&left))?);
        let size = change.norm();
        // Rounding: it no longer falls.
        if size <= REFINED * shapes.norm() || size > 0.5 * before {
            break;
        }
        shapes += change;
        before = size;
    }
    Ok(shapes)
}

/// Displacements under the weight in each direction of a body that is held.
fn sag(model: &Model, problem: &Problem) -> Result<Vec<DVector<f64>>> {
    if problem.shift < 0.0 {
        return Ok(Vec::new());
    }
    let one = |direction| {
        let weight = model.mass.times(&model.translation(direction)) * crate::model::STANDARD_GRAVITY;
        Ok(problem.solve(weight)?.column(0).into_owned())
    };
    model.directions().into_iter().map(one).collect()
}

/// Values, basis, and fixed-interface modes.
type Coordinates = (Vec<f64>, DMatrix<f64>, Option<Modes>);

struct Made<'m, 'p> {
    model: &'m Model,
    problem: &'p Problem<'m>,
    at: &'p [usize],
    wanted: usize,
}

impl Made<'_, '_> {
    /// Free modes, and the residual shapes made diagonal; both are orthogonal in M and in K.
    fn rubin(&self, modes: &Modes, shapes: &DMatrix<f64>) -> Result<Coordinates> {
        let (k, m) = projected(&self.model.stiffness, &self.model.mass, shapes);
        let (values, own) = diagonal(&k, &m, 0.0)?;
        let basis = join(&modes.vectors, &(shapes * own));
        let (values, basis) = in_order([modes.values.clone(), values].concat(), &basis);
        Ok((values, basis, None))
    }

    /// Fixed-interface modes and constraint modes, made diagonal.
    fn craig_bampton(&self) -> Result<Coordinates> {
        let count = self.model.dofs.len();
        let inner: Vec<usize> = (0..count).filter(|row| !self.at.contains(row)).collect();
        let (mut shapes, mut fixed) = (loads(self.at, count), None);
        if !inner.is_empty() {
            let (k, m) = (self.model.stiffness.kept(&inner), self.model.mass.kept(&inner));
            let held = factorise(&k, &m, &|row| self.model.name(inner[row]))?;
            self.constrain(&held, &inner, &mut shapes)?;
            let found = eigen::lowest(&held, self.wanted.min(inner.len()), Check::Inertia)?;
            let mut whole = DMatrix::zeros(count, found.vectors.ncols());
            inner.iter().enumerate().for_each(|(i, &row)| whole.set_row(row, &found.vectors.row(i)));
            (shapes, fixed) = (join(&whole, &shapes), Some(found));
        }
        let (k, m) = projected(&self.model.stiffness, &self.model.mass, &shapes);
        let (values, own) = diagonal(&k, &m, -self.problem.shift)?;
        let (mut values, basis) = in_order(values, &(shapes * own));
        let rigid = self.problem.rigid.min(values.len());
        values[..rigid].fill(0.0);
        Ok((values, basis, fixed))
    }

    /// Completes unit displacements of the interface dofs by the static displacements of the
    /// inner ones.
    fn constrain(&self, held: &Problem, inner: &[usize], whole: &mut DMatrix<f64>) -> Result<()> {
        if held.shift < 0.0 {
            let text = "the body is still movable with its interface nodes held; use more interface dofs or \
                        --method rubin";
            return Err(Error::new("--method craig-bampton", text));
        }
        let forces = self.model.stiffness.times(whole);
        let solved =
            held.solve(DMatrix::from_fn(inner.len(), self.at.len(), |i, j| -forces[(inner[i], j)]))?;
        inner.iter().enumerate().for_each(|(i, &row)| whole.set_row(row, &solved.row(i)));
        Ok(())
    }
}

fn join(one: &DMatrix<f64>, other: &DMatrix<f64>) -> DMatrix<f64> {
    let mut both = one.clone().resize_horizontally(one.ncols() + other.ncols(), 0.0);
    both.columns_mut(one.ncols(), other.ncols()).copy_from(other);
    both
}

fn in_order(values: Vec<f64>, basis: &DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    (order.iter().map(|&k| values[k]).collect(), basis.select_columns(&order))
}

fn projected(k: &Symmetric, m: &Symmetric, shapes: &DMatrix<f64>) -> (DMatrix<f64>, DMatrix<f64>) {
    (symmetric(shapes.tr_mul(&k.times(shapes))), symmetric(shapes.tr_mul(&m.times(shapes))))
}

/// Modes of small matrices, of mass 1: eigenvalues of M against K + s M, so that the low modes
/// have all their digits. Motions without mass are left out: their flexibility stays residual.
fn diagonal(k: &DMatrix<f64>, m: &DMatrix<f64>, s: f64) -> Result<(Vec<f64>, DMatrix<f64>)> {
    let mut shifted = k + m * s;
    // Each shape in units of its own stiffness.
    let units: Vec<f64> = shifted.diagonal().iter().map(|own| own.max(0.0).sqrt().recip()).collect();
    let units: Vec<f64> = units.into_iter().map(|unit| if unit.is_finite() { unit } else { 0.0 }).collect();
    let scaled =
        |a: &DMatrix<f64>| DMatrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * units[i] * units[j]);
    shifted = scaled(&shifted);
    // Shapes that depend on others: directions without stiffness.
    let own = shifted.symmetric_eigen();
    let kept: Vec<usize> = (0..own.eigenvalues.len()).filter(|&i| own.eigenvalues[i] > DEPENDENT).collect();
    let roots = DMatrix::from_fn(units.len(), kept.len(), |i, j| {
        own.eigenvectors[(i, kept[j])] / own.eigenvalues[kept[j]].sqrt()
    });
    let found = symmetric(roots.tr_mul(&(scaled(m) * &roots))).symmetric_eigen();
    let largest = found.eigenvalues.amax();
    let massive: Vec<usize> =
        (0..found.eigenvalues.len()).filter(|&i| found.eigenvalues[i] > DEPENDENT * largest).collect();
    let values = massive.iter().map(|&i| found.eigenvalues[i].recip() - s).collect();
    let vectors = DMatrix::from_fn(kept.len(), massive.len(), |i, j| {
        found.eigenvectors[(i, massive[j])] / found.eigenvalues[massive[j]].sqrt()
    });
    let mut shapes = roots * vectors;
    for (i, unit) in units.iter().enumerate() {
        shapes.row_mut(i).scale_mut(*unit);
    }
    Ok((values, shapes))
}
