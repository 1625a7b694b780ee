//! Residuals of a motion beside a record, and their derivatives by the free numbers.

use nalgebra::DMatrix;

/// Residuals over a horizon in units of the standard deviations, and their derivatives; rows of one
/// time stand together.
pub(super) struct Evaluated {
    pub residuals: Vec<f64>,
    pub jacobian: DMatrix<f64>,
    /// Time and column of each row; the columns of contacts follow those of quantities.
    pub places: Vec<(f64, usize)>,
}

/// A number of a motion with its derivatives by the free numbers, where it has them.
pub(super) type Varied = (f64, Vec<Option<f64>>);

impl Evaluated {
    /// The rows of a record: place, and residual with its derivatives; `sigma` is by column.
    pub fn of(mut rows: Vec<((f64, usize), Varied)>, unknowns: usize, sigma: &[f64]) -> Self {
        rows.sort_by(|(a, _), (b, _)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let mut jacobian = DMatrix::zeros(rows.len(), unknowns);
        let (mut residuals, mut places) = (Vec::new(), Vec::new());
        for (i, (place, (residual, by))) in rows.into_iter().enumerate() {
            let sigma = sigma[place.1];
            residuals.push(residual / sigma);
            by.iter().enumerate().for_each(|(j, by)| jacobian[(i, j)] = by.unwrap_or(0.0) / sigma);
            places.push(place);
        }
        Self { residuals, jacobian, places }
    }

    /// Whether all its numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.residuals.iter().chain(self.jacobian.iter()).all(|x| x.is_finite())
    }
}
