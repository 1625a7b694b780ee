//! Bodies with a mass and a stiffness matrix, in normal coordinates (docs/assembly-law.md (A51)).

use super::{Arms, Body, BodyKind, Description, Dimension, Free, Inner};
use crate::refusal::Problem;
use nalgebra::{Cholesky, DMatrix, DVector, SymmetricEigen};
use vibro_numerics::sorting::sort_by;

/// Relative tolerance for equality of entries across the diagonal, and for negative eigenvalues
/// that count as rounding errors: files have six to sixteen digits.
const DIGITS: f64 = 1e-9;

/// Fraction of the largest eigenvalue below which an eigenvalue counts as zero.
const ZERO: f64 = 1e-13;

/// Data of a body with matrices, in the file's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct Given {
    /// M, symmetric, positive definite.
    pub mass: DMatrix<f64>,
    /// K, symmetric, positive semidefinite.
    pub stiffness: DMatrix<f64>,
    /// C.
    pub damping: MatrixDamping,
    /// G, skew.
    pub gyroscopic: Option<DMatrix<f64>>,
    /// r; the weight on the coordinates is M r g.
    pub gravity: DVector<f64>,
    /// Coordinates at time 0.
    pub q: DVector<f64>,
    /// Rates at time 0.
    pub v: DVector<f64>,
    /// Nodes.
    pub nodes: Vec<GivenNode>,
}

/// A node in the file's coordinates.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenNode {
    /// Its name, unique among the nodes of its body.
    pub name: String,
    /// Dimension of its coordinate.
    pub dimension: Dimension,
    /// s = row · q.
    pub row: DVector<f64>,
}

/// The damping of a body with matrices.
#[derive(Clone, Debug, PartialEq)]
pub enum MatrixDamping {
    /// No damping.
    None,
    /// C, symmetric, positive semidefinite.
    Matrix(DMatrix<f64>),
    /// C = α M + β K.
    Rayleigh([f64; 2]),
    /// Damping ratios: one for all modes, or one for each mode in the order of frequency.
    Ratios(Vec<f64>),
}

/// A body with matrices. Its normal coordinates, of modal mass 1, begin with body `first`.
#[derive(Clone, Debug, PartialEq)]
pub struct Matrix {
    /// Its name, unique among the elements.
    pub name: String,
    /// Index of the body that is its first normal coordinate.
    pub first: usize,
    /// Data from the file.
    pub given: Given,
    /// Squares of the angular frequencies, increasing.
    pub(crate) squares: Vec<f64>,
    /// For each mode: damping that does not couple it to other modes.
    pub(crate) dampings: Vec<f64>,
    /// Dashpots that couple modes: damping and row.
    pub(crate) dashpots: Vec<(f64, DVector<f64>)>,
    /// G in normal coordinates.
    pub(crate) gyroscopic: Option<DMatrix<f64>>,
}

impl Matrix {
    /// Springs and dashpots: one for each mode, then the dashpots that couple modes.
    pub(crate) fn springs(&self) -> Vec<Inner> {
        let of_mode = |(i, (&stiffness, &damping)): (usize, (&f64, &f64))| {
            let arms = Arms::between(None, Some(self.first + i), Dimension::Translation);
            Inner { arms, stiffness, damping }
        };
        let coupling = |(damping, row): &(f64, DVector<f64>)| {
            let terms = row.iter().enumerate().filter(|(_, arm)| **arm != 0.0);
            let terms = terms.map(|(i, arm)| (self.first + i, *arm)).collect();
            let arms = Arms { terms, dimension: Dimension::Translation, levers: true };
            Inner { arms, stiffness: 0.0, damping: *damping }
        };
        let modes = self.squares.iter().zip(&self.dampings).enumerate().map(of_mode);
        modes.chain(self.dashpots.iter().map(coupling)).collect()
    }
}

impl Description {
    /// Adds a body with matrices, its normal coordinates and its nodes.
    ///
    /// # Errors
    /// Every [`Problem`] of symmetry or definiteness, with indices of entries counted from 0.
    pub fn add_matrix(&mut self, name: &str, given: Given) -> Result<(), Vec<Problem>> {
        let of = format!("matrix.{name}");
        let mut given = given;
        let mut problems = Vec::new();
        check_sizes(&of, &given, &mut problems);
        if !problems.is_empty() {
            return Err(problems);
        }
        problems.extend(massless(&of, &given.mass));
        problems.extend(symmetric(&format!("{of}.mass"), &mut given.mass, 1.0));
        problems.extend(symmetric(&format!("{of}.stiffness"), &mut given.stiffness, 1.0));
        if let MatrixDamping::Matrix(damping) = &mut given.damping {
            problems.extend(symmetric(&format!("{of}.damping"), damping, 1.0));
        }
        if let Some(gyroscopic) = &mut given.gyroscopic {
            problems.extend(symmetric(&format!("{of}.gyroscopic"), gyroscopic, -1.0));
        }
        if !problems.is_empty() {
            return Err(problems);
        }
        let first = self.bodies.len();
        let (modes, matrix) = normal(name, first, given).map_err(|problem| vec![problem])?;
        let by_mass = modes.tr_mul(&matrix.given.mass);
        let of_vector = |x: &DVector<f64>| &by_mass * x;
        let (s, v, gravity) =
            (of_vector(&matrix.given.q), of_vector(&matrix.given.v), of_vector(&matrix.given.gravity));
        for i in 0..modes.ncols() {
            let free = Free { inertia: 1.0, gravity: gravity[i], s: s[i], v: v[i] };
            let (name, dimension) = (Self::name_of_coordinate(name, i), Dimension::Translation);
            self.bodies.push(Body { name, dimension, kind: BodyKind::Free(free) });
        }
        for node in &matrix.given.nodes {
            let row = modes.tr_mul(&node.row);
            let row = row.iter().enumerate().filter(|(_, factor)| **factor != 0.0);
            let kind = BodyKind::Node(row.map(|(i, factor)| (first + i, *factor)).collect());
            self.bodies.push(Body { name: format!("{name}.{}", node.name), dimension: node.dimension, kind });
        }
        self.matrices.push(matrix);
        Ok(())
    }
}

/// Reports matrices and vectors of a wrong size.
fn check_sizes(of: &str, given: &Given, problems: &mut Vec<Problem>) {
    let n = given.mass.nrows();
    let damping = if let MatrixDamping::Matrix(own) = &given.damping { Some(own) } else { None };
    let squares = [("mass", Some(&given.mass)), ("stiffness", Some(&given.stiffness)), ("damping", damping)];
    for (key, own) in squares.into_iter().chain([("gyroscopic", given.gyroscopic.as_ref())]) {
        let Some(own) = own.filter(|own| own.shape() != (n, n) || n == 0) else { continue };
        let text = format!(
            "has {} rows and {} columns; expected {n} of each, as in the mass matrix",
            own.nrows(),
            own.ncols()
        );
        problems.push(Problem::new(format!("{of}.{key}"), None, text));
    }
    let ratios = if let MatrixDamping::Ratios(own) = &given.damping { own.len() } else { 1 };
    let vectors = [("gravity", given.gravity.len()), ("start.q", given.q.len()), ("start.v", given.v.len())];
    let nodes = given.nodes.iter().map(|node| ("nodes", node.row.len()));
    for (key, len) in
        vectors.into_iter().chain(nodes).chain([("damping_ratio", if ratios == 1 { n } else { ratios })])
    {
        if len != n {
            let text = format!("has {len} numbers; expected one for each of {n} coordinates");
            problems.push(Problem::new(format!("{of}.{key}"), None, text));
        }
    }
}

/// The problem of a coordinate without mass, if there is one.
fn massless(of: &str, mass: &DMatrix<f64>) -> Option<Problem> {
    let i = (0..mass.nrows()).find(|&i| mass.row(i).iter().all(|x| *x == 0.0))?;
    let text = format!(
        "row {i}, counted from 0, is zero: the coordinate has no mass; condense it out of the matrices"
    );
    Some(Problem::new(format!("{of}.mass"), None, text))
}

/// Makes a matrix symmetric (`sign` 1) or skew (-1) if it is so to the digits of a file.
fn symmetric(name: &str, a: &mut DMatrix<f64>, sign: f64) -> Option<Problem> {
    let largest = a.amax();
    for i in 0..a.nrows() {
        for j in 0..=i {
            let (x, y) = (a[(i, j)], sign * a[(j, i)]);
            let own = (a[(i, i)] * a[(j, j)]).abs().sqrt();
            let size = if own > 0.0 { own.max(x.abs()) } else { largest };
            if (x - y).abs() > DIGITS * size {
                let what = if sign > 0.0 { "symmetric" } else { "skew" };
                let text = match (i == j, sign > 0.0) {
                    (true, _) => format!(
                        "is not {what}: the entry in row {i} and column {i}, counted from 0, is {x:?}; \
                         expected 0 on the diagonal"
                    ),
                    (false, alike) => format!(
                        "is not {what}: the entry in row {i} and column {j}, counted from 0, is {x:?}, \
                         but the entry in row {j} and column {i} is {:?}; expected {}",
                        a[(j, i)],
                        if alike { "equal entries" } else { "entries of equal size and opposite sign" }
                    ),
                };
                return Some(Problem::new(name, None, text));
            }
            let mean = if i == j && sign < 0.0 { 0.0 } else { 0.5 * (x + y) };
            a[(i, j)] = mean;
            a[(j, i)] = sign * mean;
        }
    }
    None
}

/// Eigenvalues in increasing order, and their vectors.
fn eigen(a: DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let found = SymmetricEigen::new(a);
    let mut order: Vec<usize> = (0..found.eigenvalues.len()).collect();
    sort_by(&mut order, |&i, &j| found.eigenvalues[i].total_cmp(&found.eigenvalues[j]));
    let columns: Vec<_> = order.iter().map(|&i| found.eigenvectors.column(i)).collect();
    (order.iter().map(|&i| found.eigenvalues[i]).collect(), DMatrix::from_columns(&columns))
}

/// Sets eigenvalues of a semidefinite matrix that are rounding errors to zero.
fn not_negative(name: &str, values: &mut [f64]) -> Result<(), Problem> {
    let largest = values.last().map_or(0.0, |last| last.abs()).max(f64::MIN_POSITIVE);
    if let Some(least) = values.first().filter(|least| **least < -DIGITS * largest) {
        let text = format!(
            "its smallest eigenvalue is {least:?}, its largest is {largest:?}; expected a positive \
             semidefinite matrix"
        );
        return Err(Problem::new(name, None, text));
    }
    values.iter_mut().filter(|x| **x < ZERO * largest).for_each(|x| *x = 0.0);
    Ok(())
}

/// The normal modes as columns, and the body in normal coordinates.
fn normal(name: &str, first: usize, given: Given) -> Result<(DMatrix<f64>, Matrix), Problem> {
    let of = format!("matrix.{name}");
    let Some(factor) = Cholesky::new(given.mass.clone()) else {
        let least = eigen(given.mass).0.iter().copied().fold(f64::INFINITY, f64::min);
        let text = format!(
            "is not positive definite: its smallest eigenvalue is {least:?}; expected a matrix with positive \
             kinetic energy for all rates"
        );
        return Err(Problem::new(format!("{of}.mass"), None, text));
    };
    let lower = factor.l();
    let solved = |a: &DMatrix<f64>| lower.solve_lower_triangular(a);
    let half = solved(&given.stiffness).and_then(|half| solved(&half.transpose()));
    let Some(half) = half else { return Err(Problem::new(format!("{of}.mass"), None, "is singular")) };
    let (mut squares, vectors) = eigen(0.5 * (&half + half.transpose()));
    not_negative(&format!("{of}.stiffness"), &mut squares)?;
    let modes = lower.tr_solve_lower_triangular(&vectors).unwrap_or(vectors);
    let own = |a: &DMatrix<f64>| modes.tr_mul(&(a * &modes));
    let mut dampings = vec![0.0; squares.len()];
    let mut dashpots = Vec::new();
    match &given.damping {
        MatrixDamping::None => {}
        MatrixDamping::Rayleigh([alpha, beta]) => {
            dampings.iter_mut().zip(&squares).for_each(|(c, square)| *c = alpha + beta * square);
        }
        MatrixDamping::Ratios(ratios) => {
            let ratio = |i: usize| if ratios.len() == 1 { ratios[0] } else { ratios[i] };
            (0..squares.len()).for_each(|i| dampings[i] = 2.0 * ratio(i) * squares[i].sqrt());
        }
        MatrixDamping::Matrix(damping) => {
            let damping = own(damping);
            let (mut values, rows) = eigen(0.5 * (&damping + damping.transpose()));
            not_negative(&format!("{of}.damping"), &mut values)?;
            let act = values.iter().zip(rows.column_iter()).filter(|(value, _)| **value > 0.0);
            dashpots.extend(act.map(|(value, row)| (*value, row.into_owned())));
        }
    }
    let gyroscopic = given.gyroscopic.as_ref().map(|g| {
        let g = own(g);
        0.5 * (&g - g.transpose())
    });
    Ok((modes, Matrix { name: name.into(), first, given, squares, dampings, dashpots, gyroscopic }))
}
