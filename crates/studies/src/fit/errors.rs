//! Standard errors of a fit, their correlations, and undetermined combinations.
//!
//! If residuals are white, the covariance is s² (JᵀJ)⁻¹. Real residuals are correlated: their
//! covariance is (JᵀJ)⁻¹ S (JᵀJ)⁻¹, where S sums products of J's rows and residuals over lags (W.
//! Newey and K. West, Econometrica 55, 1987). The residuals' correlation sets the number of lags
//! (D. Andrews, Econometrica 59, 1991).
//!
//! If the loss is robust, s² is the mean square of the scores over the square of their mean slope
//! (P. Huber, Robust Statistics, 1981, chapter 7): neither grows with the size of outliers.

use super::elimination::Triangle;
use super::evaluated::{Evaluated, Point};
use super::loss::Loss;
use nalgebra::{DMatrix, DVector};

/// Singular values of the Jacobian with columns of unit length, relative to the largest, below
/// which a combination is undetermined. Exact derivatives are accurate to some 1e-15. Their growth
/// over segments ends where a segment may miss the next one's start, by a billionth of its size.
/// Differences over a millionth of a parameter are accurate to some 1e-6.
const SINGULAR: f64 = 1e-12;
const SINGULAR_BY_DIFFERENCES: f64 = 1e-5;
/// Component of a parameter in an undetermined combination, with columns of unit length, above
/// which the parameter is undetermined. It is well above the combination's error, which is about
/// the derivatives' accuracy divided by the other singular values.
const TAKES_PART: f64 = 1e-4;
/// Coefficient below which a combination does not name the parameter.
const COUNTS: f64 = 1e-3;

/// Correlation of successive residuals, in standard deviations, below which they count as white.
const WHITE: f64 = 2.0;

/// Fraction of the change that moves the motion by its size; a smaller value counts as 0.
const HARDLY: f64 = 1e-3;

/// Combination of relative parameter changes that leaves the motion at the samples unchanged.
#[derive(Clone, Debug, PartialEq)]
pub struct Undetermined {
    /// Component of each free parameter, in multiples of its value (if the value is 0, of the
    /// change that moves the motion by the record's size).
    pub combination: Vec<(String, f64)>,
    /// Change of the residuals by this combination relative to the best determined one, with each
    /// parameter scaled by its own effect.
    pub singular_value: f64,
}

impl std::fmt::Display for Undetermined {
    /// Components with their names: `+0.577 body.a.mass -0.577 spring.k.stiffness`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let parts = self.combination.iter().map(|(name, part)| format!("{part:+.3} {name}"));
        f.write_str(&parts.collect::<Vec<_>>().join(" "))
    }
}

/// Standard errors of the free parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    /// Names of the free parameters.
    pub names: Vec<String>,
    /// Standard error of each, SI; `None` if the record does not determine it.
    pub errors: Vec<Option<f64>>,
    /// Standard error of each for white residuals, from the curvature of the cost, SI.
    pub white: Vec<Option<f64>>,
    /// Correlations; 0 for an undetermined parameter.
    pub correlation: DMatrix<f64>,
    /// Combinations that the record does not determine.
    pub undetermined: Vec<Undetermined>,
    /// Correlation of successive residuals.
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
        // Segment states follow the parameters: the errors include their freedom.
        let sizes = Point::default();
        let triangle = Triangle::of(at, Loss::Linear, &sizes, 0.0, &vec![false; p]);
        let Some(mut matrix) = triangle.reduced(at, p) else { return Self::none(names) };
        let scales: Vec<f64> = (0..p).map(|j| size_of_part(&matrix, values[j], j)).collect();
        let Some(scores) = Scores::of(at, loss, (has_sigma, p)) else { return Self::none(names) };
        let idle: Vec<bool> = (0..p).map(|j| at.is_idle(j, values[j])).collect();
        let cut = if at.has_differences() { SINGULAR_BY_DIFFERENCES } else { SINGULAR };
        let Some(basis) = Basis::of(triangle.of_numbers(), &idle, cut) else { return Self::none(names) };
        for (mut column, length) in matrix.column_iter_mut().zip(&basis.lengths) {
            column *= if *length > 0.0 { length.recip() } else { 0.0 };
        }
        let inverse = basis.inverse() / scores.slope;
        let persistence = persistence(at, &scores.all);
        let white = &inverse * (scores.variance / scores.slope);
        let covariance = if is_white(persistence, scores.all.len()) {
            white.clone()
        } else {
            &inverse * lagged(at, &matrix, &scores.all, persistence) * &inverse
        };
        let errors = basis.errors(&covariance);
        Self {
            names: names.to_vec(),
            white: basis.errors(&white),
            correlation: correlation(&covariance, &errors),
            undetermined: basis.undetermined(names, &scales),
            persistence,
            errors,
        }
    }

    /// Multiplies the errors by factors of at least 1, from the profile of the cost. The errors
    /// for white noise are unchanged.
    pub(super) fn widen(&mut self, factors: &[f64]) {
        for (error, factor) in self.errors.iter_mut().zip(factors) {
            if let Some(error) = error {
                *error *= factor;
            }
        }
    }

    /// Errors of one record's parameters, given their indices among the joint parameters.
    pub(super) fn of_record(&self, places: &[usize], names: Vec<String>) -> Self {
        let of = |all: &[Option<f64>]| places.iter().map(|&place| all[place]).collect();
        Self {
            errors: of(&self.errors),
            white: of(&self.white),
            correlation: self.correlation.select_rows(places).select_columns(places),
            undetermined: self.undetermined.clone(),
            persistence: self.persistence,
            names,
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

/// Statistics of the residuals.
struct Scores {
    /// Score of each residual; the residual itself under the quadratic loss.
    all: Vec<f64>,
    /// Mean slope of the scores, divided by the correction for few residuals per parameter.
    slope: f64,
    variance: f64,
}

impl Scores {
    /// `None` if the variance cannot be estimated: no more residuals than parameters, or only
    /// outliers.
    fn of(at: &Evaluated, loss: Loss, (has_sigma, p): (bool, usize)) -> Option<Self> {
        let all: Vec<f64> = at.residuals().map(|r| loss.score(r)).collect();
        let is_told = all.len() > p;
        if has_sigma && (loss == Loss::Linear || !is_told) {
            return Some(Self { all, slope: 1.0, variance: 1.0 });
        }
        let m = all.len() as f64;
        let slopes = || at.residuals().map(|r| loss.slope(r));
        let mean = slopes().sum::<f64>() / m;
        let spread = slopes().map(|slope| (slope - mean).powi(2)).sum::<f64>() / m;
        let correction = 1.0 + p as f64 / m * spread / (mean * mean);
        let variance = all.iter().map(|score| score * score).sum::<f64>() / (m - p as f64);
        (is_told && mean > 0.0).then(|| Self { all, slope: mean / correction, variance })
    }
}

/// Combinations of parameters, ordered by their effect on the residuals. Columns of the Jacobian
/// have unit length, so the units of parameters do not matter.
struct Basis {
    /// Lengths of the columns; 0 for a parameter without effect.
    lengths: Vec<f64>,
    /// Combinations in rows, with their singular values.
    rows: DMatrix<f64>,
    singular: Vec<f64>,
    /// Threshold relative to the largest singular value; smaller ones count as 0.
    cut: f64,
}

impl Basis {
    /// Combinations of a Jacobian; `None` if it is not finite. An idle parameter is a combination
    /// of its own.
    fn of(mut matrix: DMatrix<f64>, idle: &[bool], cut: f64) -> Option<Self> {
        let p = idle.len();
        let mut lengths = vec![0.0; p];
        for (j, mut column) in matrix.column_iter_mut().enumerate() {
            let length = column.norm();
            if !idle[j] && length > 0.0 {
                lengths[j] = length;
                column /= length;
            }
        }
        if matrix.iter().any(|x| !x.is_finite()) {
            return None;
        }
        let moves: Vec<usize> = (0..p).filter(|&j| lengths[j] > 0.0).collect();
        let (mut rows, mut singular) = (DMatrix::zeros(p, p), vec![0.0; p]);
        if !moves.is_empty() {
            // Padding with zero rows: each parameter then has a combination even with few samples.
            let own = matrix.select_columns(&moves);
            let height = own.nrows().max(moves.len());
            let svd = own.resize_vertically(height, 0.0).qr().r().svd(false, true);
            let right = svd.v_t?;
            for k in 0..moves.len() {
                singular[k] = svd.singular_values[k];
                moves.iter().enumerate().for_each(|(c, &j)| rows[(k, j)] = right[(k, c)]);
            }
        }
        let idle = (0..p).filter(|&j| lengths[j] == 0.0);
        idle.enumerate().for_each(|(i, j)| rows[(moves.len() + i, j)] = 1.0);
        Some(Self { lengths, rows, singular, cut })
    }

    fn largest(&self) -> f64 {
        self.singular.iter().fold(f64::MIN_POSITIVE, |most, x| most.max(*x))
    }

    /// Whether a combination's singular value exceeds the error of the derivatives.
    fn is_known(&self, k: usize) -> bool {
        self.singular[k] > self.cut * self.largest()
    }

    fn unknown(&self) -> impl Iterator<Item = usize> {
        (0..self.singular.len()).filter(|&k| !self.is_known(k))
    }

    /// Inverse of JᵀJ over the determined combinations.
    fn inverse(&self) -> DMatrix<f64> {
        let p = self.lengths.len();
        let mut inverse = DMatrix::zeros(p, p);
        for k in (0..p).filter(|&k| self.is_known(k)) {
            let v = self.rows.row(k).transpose();
            inverse.ger(self.singular[k].powi(-2), &v, &v, 1.0);
        }
        inverse
    }

    /// Standard errors from a covariance; `None` for parameters in undetermined combinations.
    fn errors(&self, covariance: &DMatrix<f64>) -> Vec<Option<f64>> {
        let takes_part = |j: usize| self.unknown().any(|k| self.rows[(k, j)].abs() > TAKES_PART);
        let error = |j: usize| covariance[(j, j)].max(0.0).sqrt() / self.lengths[j];
        (0..self.lengths.len()).map(|j| (!takes_part(j)).then(|| error(j))).collect()
    }

    /// Undetermined combinations, in units of the parameters' scales.
    fn undetermined(&self, names: &[String], scales: &[f64]) -> Vec<Undetermined> {
        let of = |k: usize| {
            let part = |j: usize, _| match (self.rows[(k, j)], self.lengths[j] * scales[j]) {
                (part, 0.0) => part,
                (part, unit) => part / unit,
            };
            let parts = DVector::from_fn(names.len(), part).normalize();
            let named = names.iter().cloned().zip(parts.iter().copied());
            Undetermined {
                combination: named.filter(|(_, part)| part.abs() > COUNTS).collect(),
                singular_value: self.singular[k] / self.largest(),
            }
        };
        self.unknown().map(of).collect()
    }
}

/// Correlations of a covariance; 0 for a parameter without a standard error.
fn correlation(covariance: &DMatrix<f64>, errors: &[Option<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(errors.len(), errors.len(), |i, j| {
        let size = (covariance[(i, i)] * covariance[(j, j)]).sqrt();
        match (i == j, errors[i].is_some() && errors[j].is_some() && size > 0.0) {
            (true, _) => 1.0,
            (false, true) => (covariance[(i, j)] / size).clamp(-1.0, 1.0),
            (false, false) => 0.0,
        }
    })
}

/// Unit change of a parameter: its own value. For a value of 0, it is the change that moves each
/// sample by one standard deviation (root mean square).
pub(super) fn scale(jacobian: &DMatrix<f64>, value: f64, j: usize) -> f64 {
    if value != 0.0 {
        return value.abs();
    }
    let norm = jacobian.column(j).norm();
    if norm > 0.0 { (jacobian.nrows() as f64).sqrt() / norm } else { 1.0 }
}

/// Unit change of a parameter in a combination. As [`scale`], but a value that hardly moves the
/// motion counts as 0, for example a shift that is fitted to be 0.
fn size_of_part(jacobian: &DMatrix<f64>, value: f64, j: usize) -> f64 {
    let of_zero = scale(jacobian, 0.0, j);
    if value.abs() > HARDLY * of_zero { value.abs() } else { of_zero }
}

/// Whether a correlation of successive residuals is one that white residuals have by chance.
pub(super) fn is_white(persistence: f64, count: usize) -> bool {
    persistence.abs() < WHITE / (count.max(1) as f64).sqrt()
}

/// Correlation of successive residuals within a column, over all columns.
pub(super) fn persistence(at: &Evaluated, residuals: &[f64]) -> f64 {
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

/// Sum S over lags with decreasing weights; rows at one time count together.
fn lagged(at: &Evaluated, matrix: &DMatrix<f64>, residuals: &[f64], persistence: f64) -> DMatrix<f64> {
    let p = matrix.ncols();
    let mut scores: Vec<(usize, DVector<f64>)> = Vec::new();
    let mut present = (usize::MAX, f64::NAN);
    let rows = at.0.iter().flat_map(|own| own.places.iter().map(|(time, _)| (own.record, *time)));
    for (i, own) in rows.enumerate() {
        if own != present {
            scores.push((own.0, DVector::zeros(p)));
            present = own;
        }
        if let Some((_, last)) = scores.last_mut() {
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
            let ((record, a), (before, b)) = (&scores[t], &scores[t - lag]);
            // Residuals of different records are independent.
            if record != before {
                continue;
            }
            sum.ger(weight, a, b, 1.0);
            if lag > 0 {
                sum.ger(weight, b, a, 1.0);
            }
        }
    }
    sum
}
