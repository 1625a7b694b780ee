//! Linear least squares of a step. Each segment is a block: neighbours share a state, and all
//! share the free parameters. QR eliminates the states one after another, so time and memory grow
//! linearly with the number of segments (G. Bierman, Factorization Methods for Discrete Sequential
//! Estimation, 1977, chapter 5).

use super::evaluated::{Change, Evaluated, Point, Rows};
use super::loss::Loss;
use nalgebra::{DMatrix, DMatrixView, DVector};

/// Rows left of a state after its elimination: R x + S y + T p = r with the next state y.
struct Left {
    own: DMatrix<f64>,
    next: DMatrix<f64>,
    numbers: DMatrix<f64>,
}

/// Triangular factor of all segment states, and the remaining rows of the parameters alone.
pub(super) struct Triangle {
    states: Vec<Left>,
    /// Remaining rows of the parameters that are not held; the last column is the right side.
    numbers: DMatrix<f64>,
    /// Indices of these parameters.
    free: Vec<usize>,
}

/// Rows of a matrix with the columns `x`, `y`, `p` and the right side.
struct Builder {
    matrix: DMatrix<f64>,
    filled: usize,
}

impl Builder {
    /// Copies a block to a column, starting at the next free row.
    fn put(&mut self, column: usize, block: DMatrixView<f64>) {
        self.matrix.view_mut((self.filled, column), block.shape()).copy_from(&block);
    }
}

/// Number of a segment's rows, and size of its initial state.
fn shape(rows: &Rows) -> (usize, usize) {
    rows.by_state.shape()
}

impl Triangle {
    /// Eliminates the states. A row of its scale times √damping draws each unknown towards 0.
    pub fn of(at: &Evaluated, loss: Loss, sizes: &Change, damping: f64, held: &[bool]) -> Self {
        let free: Vec<usize> = (0..held.len()).filter(|&j| !held[j]).collect();
        let (p, root) = (free.len(), damping.sqrt());
        // Information from the segments so far on the present state and the parameters.
        let mut so_far = DMatrix::zeros(0, shape(&at.0[0].rows).1 + p + 1);
        let mut states = Vec::new();
        for (k, own) in at.0.iter().enumerate() {
            let (m, n) = shape(&own.rows);
            let joint = own.defect.as_ref().map_or(0, |rows| rows.residuals.len());
            let extra = if damping > 0.0 { n } else { 0 };
            let width = n + joint + p + 1;
            let mut all =
                Builder { matrix: DMatrix::zeros(joint + so_far.nrows() + m + extra, width), filled: 0 };
            // Heavy rows first: Householder reflections then preserve the light ones.
            if let Some(rows) = &own.defect {
                put_rows(&mut all, rows, (n, joint), &free, |_| 1.0);
                (0..joint).for_each(|i| all.matrix[(i, n + i)] = -own.weights[i]);
                all.filled += joint;
            }
            all.put(0, so_far.columns(0, n).as_view());
            all.put(n + joint, so_far.columns(n, p + 1).as_view());
            all.filled += so_far.nrows();
            put_rows(&mut all, &own.rows, (n, joint), &free, |r| loss.weight(r));
            all.filled += m;
            for i in 0..extra {
                all.matrix[(all.filled + i, i)] = root * sizes.states[k - 1][i];
            }
            let r = all.matrix.qr().r();
            let rows = r.nrows().min(n);
            if n > 0 || k > 0 {
                states.push(Left {
                    own: r.view((0, 0), (rows, n)).into_owned(),
                    next: r.view((0, n), (rows, joint)).into_owned(),
                    numbers: r.view((0, n + joint), (rows, p + 1)).into_owned(),
                });
            }
            so_far = r.view((rows, n), (r.nrows() - rows, width - n)).into_owned();
        }
        let extra = if damping > 0.0 { p } else { 0 };
        let mut numbers = DMatrix::zeros(so_far.nrows() + extra, p + 1);
        numbers.rows_mut(0, so_far.nrows()).copy_from(&so_far);
        for i in 0..extra {
            numbers[(so_far.nrows() + i, i)] = root * sizes.values[free[i]];
        }
        Self { states, numbers: numbers.qr().r(), free }
    }

    /// Remaining triangle R of the parameters that are not held. RᵀR is their information with the
    /// states eliminated by least squares, including the defects.
    pub fn of_numbers(&self) -> DMatrix<f64> {
        let p = self.free.len();
        self.numbers.view((0, 0), (self.numbers.nrows().min(p), p)).into_owned()
    }

    /// Step: the negative solution; `None` if the parameters are undetermined.
    pub fn step(&self, count: usize) -> Option<Change> {
        let p = self.free.len();
        if self.numbers.nrows() < p {
            return None;
        }
        let right = -self.numbers.view((0, p), (p, 1)).column(0);
        let part = self.numbers.view((0, 0), (p, p)).solve_upper_triangular(&right)?;
        let mut values = vec![0.0; count];
        self.free.iter().zip(part.iter()).for_each(|(&j, x)| values[j] = *x);
        let states = self.states_of(&part, 1.0)?;
        let step = Point { values, states };
        let finite = step.values.iter().chain(step.states.iter().flatten()).all(|x| x.is_finite());
        finite.then_some(step)
    }

    /// Least squares states for given parameter changes; `share` multiplies the right sides.
    pub fn states_of(&self, numbers: &DVector<f64>, share: f64) -> Option<Vec<Vec<f64>>> {
        let p = numbers.len();
        let mut found: Vec<Vec<f64>> = Vec::new();
        let mut next = DVector::zeros(0);
        for own in self.states.iter().rev() {
            let mut right = -(own.numbers.columns(0, p) * numbers) - own.numbers.column(p) * share;
            if own.next.ncols() > 0 {
                right -= &own.next * &next;
            }
            if own.own.nrows() < own.own.ncols() {
                return None;
            }
            next = own.own.solve_upper_triangular(&right)?;
            found.push(next.iter().copied().collect());
        }
        found.reverse();
        Some(found)
    }

    /// Jacobian of all residuals with respect to the free parameters, where the states follow by
    /// least squares.
    pub fn reduced(&self, at: &Evaluated, count: usize) -> Option<DMatrix<f64>> {
        let p = self.free.len();
        let rows: usize = at.0.iter().map(|own| own.places.len()).sum();
        let mut all = DMatrix::zeros(rows, count);
        for (c, &j) in self.free.iter().enumerate() {
            let mut unit = DVector::zeros(p);
            unit[c] = 1.0;
            let states = self.states_of(&unit, 0.0)?;
            let mut first = 0;
            let without = usize::from(shape(&at.0[0].rows).1 == 0);
            for (k, own) in at.0.iter().enumerate() {
                let mut column = own.rows.by_numbers.column(j).into_owned();
                if k >= without {
                    column += &own.rows.by_state * DVector::from_column_slice(&states[k - without]);
                }
                all.view_mut((first, j), (column.len(), 1)).copy_from(&column);
                first += column.len();
            }
        }
        Some(all)
    }
}

/// Appends weighted rows: by state, by free parameters, right side.
fn put_rows(
    all: &mut Builder,
    rows: &Rows,
    (n, joint): (usize, usize),
    free: &[usize],
    weight: impl Fn(f64) -> f64,
) {
    let weights: Vec<f64> = rows.residuals.iter().map(|r| weight(*r)).collect();
    let first = all.filled;
    for (i, weight) in weights.iter().enumerate() {
        for j in 0..n {
            all.matrix[(first + i, j)] = weight * rows.by_state[(i, j)];
        }
        for (c, &j) in free.iter().enumerate() {
            all.matrix[(first + i, n + joint + c)] = weight * rows.by_numbers[(i, j)];
        }
        all.matrix[(first + i, n + joint + free.len())] = weight * rows.residuals[i];
    }
}
