//! Combinations of free parameters by their effect on the residuals at a point.

use super::elimination::Triangle;
use super::errors::scale;
use super::evaluated::{Evaluated, Point};
use super::problem::Problem;
use nalgebra::{DMatrix, DVector};

/// Singular value decomposition of the Jacobian of all residuals, with parameters in units of
/// their scales.
pub(super) struct Directions {
    pub triangle: Triangle,
    /// Jacobian by free parameters, where segment states follow by least squares.
    pub jacobian: DMatrix<f64>,
    pub scales: Vec<f64>,
    pub singular: DVector<f64>,
    /// Combinations of scaled parameters, one in each row.
    pub right: DMatrix<f64>,
}

impl Directions {
    /// Directions at a point; `None` if a derivative is not finite.
    pub fn of(model: &dyn Problem, values: &[f64], at: &Evaluated) -> Option<Self> {
        let p = values.len();
        let triangle = Triangle::of(at, model.loss(), &Point::default(), 0.0, &vec![false; p]);
        let jacobian = triangle.reduced(at, p)?;
        let scales: Vec<f64> = (0..p).map(|j| scale(&jacobian, values[j], j)).collect();
        let mut scaled = jacobian.clone();
        scaled.column_iter_mut().zip(&scales).for_each(|(mut column, scale)| column *= *scale);
        let triangular = scaled.qr().r();
        if triangular.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let svd = triangular.svd(false, true);
        Some(Self { triangle, jacobian, scales, singular: svd.singular_values, right: svd.v_t? })
    }
}
