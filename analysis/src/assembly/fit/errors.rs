//! Standard errors of a fit, their correlations, and what the record does not determine.
//!
//! With white residuals the covariance is s² (JᵀJ)⁻¹. Real residuals are correlated: their
//! covariance is (JᵀJ)⁻¹ S (JᵀJ)⁻¹ with the sum S of products of J's rows with their residuals over
//! lags (W. Newey and K. West, Econometrica 55, 1987), as many as the residuals' own correlation
//! asks for (D. Andrews, Econometrica 59, 1991).

use super::elimination::Triangle;
use super::evaluated::{Evaluated, Point};
use super::loss::Loss;
use nalgebra::{DMatrix, DVector};

/// Singular value, relative to the largest, below which a combination of numbers is not determined.
const SINGULAR: f64 = 1e-8;
/// Relative standard error of a combination above which it is not determined.
const VAGUE: f64 = 1.0;
/// Share of an undetermined combination above which a number is not determined.
const SHARE: f64 = 1e-4;
/// Coefficient below which a number does not count to a combination.
const COUNTS: f64 = 1e-3;

/// A combination of relative changes that leaves the motion at the record as it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Undetermined {
    /// By free number its part: the number changes by so many of its own values (of a number that
    /// is 0, of the change that moves the motion by the record's own size).
    pub combination: Vec<(String, f64)>,
    /// Change of the residuals by such a change, relative to that of the best determined one.
    pub singular_value: f64,
}

impl std::fmt::Display for Undetermined {
    /// The parts with their names: `+0.577 body.a.mass -0.577 spring.k.stiffness`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let parts = self.combination.iter().map(|(name, part)| format!("{part:+.3} {name}"));
        f.write_str(&parts.collect::<Vec<_>>().join(" "))
    }
}

/// Standard errors of the free numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    /// The names of the free numbers.
    pub names: Vec<String>,
    /// Standard error of each, SI; `None` where the record does not determine it.
    pub errors: Vec<Option<f64>>,
    /// Standard error of each if its residuals were white noise, SI.
    pub white: Vec<Option<f64>>,
    /// Correlations; 0 beside a number that is not determined.
    pub correlation: DMatrix<f64>,
    /// What the record does not determine.
    pub undetermined: Vec<Undetermined>,
    /// Correlation of a residual with the next one.
    pub persistence: f64,
}

impl Uncertainty {
    pub(super) fn of(
        at: &Evaluated,
        names: &[String],
        values: &[f64],
        (loss, has_sigma): (Loss, bool),
    ) -> Self {
        let p = values.len();
        // States of segments follow the numbers: errors are of all that is free.
        let sizes = Point::default();
        let triangle = Triangle::of(at, loss, &sizes, 0.0, &vec![false; p]);
        let Some(jacobian) = triangle.reduced(at, p) else { return Self::none(names) };
        let residuals: Vec<f64> = at.residuals().collect();
        let m = residuals.len();
        let weights: Vec<f64> = residuals.iter().map(|r| loss.weight(*r)).collect();
        let scales: Vec<f64> = (0..p).map(|j| scale(&jacobian, values[j], j)).collect();
        let mut matrix = jacobian;
        for i in 0..m {
            for j in 0..p {
                matrix[(i, j)] *= weights[i] * scales[j];
            }
        }
        let residuals: Vec<f64> = residuals.iter().zip(&weights).map(|(r, w)| r * w).collect();
        let squares: f64 = residuals.iter().map(|r| r * r).sum();
        let variance = if has_sigma { 1.0 } else { squares / m.saturating_sub(p).max(1) as f64 };
        let r = matrix.clone().qr().r();
        let svd = r.svd(false, true);
        let Some(right) = svd.v_t.as_ref() else { return Self::none(names) };
        let largest = svd.singular_values.max().max(f64::MIN_POSITIVE);
        let is_known = |k: usize| {
            let value = svd.singular_values[k];
            value > SINGULAR * largest && variance.sqrt() / value < VAGUE
        };
        let known: Vec<usize> = (0..p).filter(|&k| is_known(k)).collect();
        // The inverse of JᵀJ over what is determined.
        let mut inverse = DMatrix::zeros(p, p);
        for &k in &known {
            let v = right.row(k).transpose();
            inverse.ger(svd.singular_values[k].powi(-2), &v, &v, 1.0);
        }
        let persistence = persistence(at, &residuals);
        let white = &inverse * variance;
        let is_white = persistence.abs() < 2.0 / (m.max(1) as f64).sqrt();
        let covariance = if is_white {
            white.clone()
        } else {
            &inverse * lagged(at, &matrix, &residuals, persistence) * &inverse
        };
        let share =
            |j: usize| (0..p).filter(|k| !known.contains(k)).map(|k| right[(k, j)].powi(2)).sum::<f64>();
        let error = |covariance: &DMatrix<f64>, j: usize| {
            (share(j) < SHARE).then(|| scales[j] * covariance[(j, j)].max(0.0).sqrt())
        };
        let errors: Vec<Option<f64>> = (0..p).map(|j| error(&covariance, j)).collect();
        let correlation = DMatrix::from_fn(p, p, |i, j| {
            let size = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
            match (i == j, errors[i].is_some() && errors[j].is_some() && size > 0.0) {
                (true, _) => 1.0,
                (false, true) => (covariance[(i, j)] / size).clamp(-1.0, 1.0),
                (false, false) => 0.0,
            }
        });
        let undetermined = (0..p).filter(|k| !known.contains(k)).map(|k| Undetermined {
            combination: names
                .iter()
                .enumerate()
                .map(|(j, name)| (name.clone(), right[(k, j)]))
                .filter(|(_, part)| part.abs() > COUNTS)
                .collect(),
            singular_value: svd.singular_values[k] / largest,
        });
        Self {
            names: names.to_vec(),
            white: (0..p).map(|j| error(&white, j)).collect(),
            correlation,
            undetermined: undetermined.collect(),
            persistence,
            errors,
        }
    }

    fn none(names: &[String]) -> Self {
        let p = names.len();
        Self {
            names: names.to_vec(),
            errors: vec![None; p],
            white: vec![None; p],
            correlation: DMatrix::identity(p, p),
            undetermined: Vec::new(),
            persistence: 0.0,
        }
    }
}

/// The change of a number that counts as one: its own value, or that which moves the motion by one
/// standard deviation of a column throughout.
pub(super) fn scale(jacobian: &DMatrix<f64>, value: f64, j: usize) -> f64 {
    if value != 0.0 {
        return value.abs();
    }
    let norm = jacobian.column(j).norm();
    if norm > 0.0 { (jacobian.nrows() as f64).sqrt() / norm } else { 1.0 }
}

/// Correlation of a residual with the next one of its column, over all columns.
fn persistence(at: &Evaluated, residuals: &[f64]) -> f64 {
    let columns = at.places().map(|place| place.1).max().unwrap_or(0) + 1;
    let mut last: Vec<Option<f64>> = vec![None; columns];
    let (mut products, mut squares) = (0.0, f64::MIN_POSITIVE);
    for ((_, column), r) in at.places().zip(residuals) {
        if let Some(before) = last[column] {
            products += before * r;
            squares += before * before;
        }
        last[column] = Some(*r);
    }
    (products / squares).clamp(-0.999, 0.999)
}

/// The sum S over lags with falling weights; rows of one time count together.
fn lagged(at: &Evaluated, matrix: &DMatrix<f64>, residuals: &[f64], persistence: f64) -> DMatrix<f64> {
    let p = matrix.ncols();
    let mut scores: Vec<DVector<f64>> = Vec::new();
    let mut time = f64::NAN;
    for (i, (own, _)) in at.places().enumerate() {
        if own != time {
            scores.push(DVector::zeros(p));
            time = own;
        }
        if let Some(last) = scores.last_mut() {
            last.axpy(residuals[i], &matrix.row(i).transpose(), 1.0);
        }
    }
    let n = scores.len() as f64;
    let rho = persistence;
    let alpha = 4.0 * rho * rho / ((1.0 - rho).powi(2) * (1.0 + rho).powi(2));
    let lags = (1.1447 * (alpha * n).cbrt()).min(0.25 * n).floor() as usize;
    let mut sum = DMatrix::zeros(p, p);
    for lag in 0..=lags {
        let weight = 1.0 - lag as f64 / (lags as f64 + 1.0);
        for t in lag..scores.len() {
            let (a, b) = (&scores[t], &scores[t - lag]);
            sum.ger(weight, a, b, 1.0);
            if lag > 0 {
                sum.ger(weight, b, a, 1.0);
            }
        }
    }
    sum
}
