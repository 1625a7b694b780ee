//! Curves of bifurcations and touches in two parameters: equations, ends, and follower.

mod following;
mod marks;
#[cfg(test)]
mod tests;

pub(crate) use following::{Located, both_ways};

use crate::curve::{Equations, least_vectors};
use crate::obstacle::Obstacle;
use nalgebra::{ComplexField, DMatrix, DVector};
use std::f64::consts::PI;

/// Equations of a curve in two parameters, which are the last two unknowns, in curve units.
pub(crate) trait TwoParameters: Equations + Clone {
    /// Smallest and largest value of parameter 0 or 1, in its curve unit.
    fn range(&self, k: usize) -> (f64, f64);

    /// Whether a point is an orbit of the machine, except for a touch that defines the curve.
    ///
    /// # Errors
    /// An obstacle if the equations are not defined at `u`.
    fn is_orbit(&self, u: &DVector<f64>) -> Result<bool, Obstacle>;

    /// Adapts the condition's borders to a point of the curve.
    fn adapt(&mut self, u: &DVector<f64>);

    /// The end of the curve that a point has passed.
    fn passed(&self, u: &DVector<f64>) -> Option<LocusEnd>;

    /// The end near a point beyond which the curve cannot be followed.
    fn near_end(&self, u: &DVector<f64>) -> Option<LocusEnd>;

    /// Products of a fold's left null vector with the columns of both parameters, as a continuous
    /// function along the curve; `None` on other curves.
    fn products(&self, _: &DVector<f64>) -> Option<[f64; 2]> {
        None
    }

    /// Test functions that vanish at special points of codimension two.
    fn tests_on_curve(&self, _: &DVector<f64>) -> Vec<(LocusEnd, f64)> {
        Vec::new()
    }

    /// Whether the curve ends at a special point of codimension two.
    fn ends_at(&self, mark: LocusEnd) -> bool {
        mark == LocusEnd::FoldPitchfork
    }
}

/// Bordered measure of a matrix's singularity: zero for a singular matrix, otherwise of the size
/// of its smallest singular value (W. Govaerts, Numerical Methods for Bifurcations of Dynamical
/// Equilibria, 2000).
pub(crate) fn smallness<T: ComplexField<RealField = f64>>(
    matrix: &DMatrix<T>,
    border: &Border<T>,
) -> Option<T> {
    let n = matrix.nrows();
    let mut whole = matrix.clone().resize(n + 1, n + 1, T::zero());
    whole.view_mut((0, n), (n, 1)).copy_from(&border.left);
    whole.view_mut((n, 0), (1, n)).copy_from(&border.right.adjoint());
    let mut right = DVector::from_element(n + 1, T::zero());
    right[n] = T::one();
    Some(whole.lu().solve(&right)?[n].clone())
}

/// The singular vectors of the smallest singular value.
#[derive(Clone, Debug)]
pub(crate) struct Border<T: ComplexField> {
    pub left: DVector<T>,
    pub right: DVector<T>,
}

impl<T: ComplexField<RealField = f64>> Border<T> {
    pub fn of(matrix: DMatrix<T>) -> Option<Self> {
        let (left, right) = least_vectors(matrix)?;
        Some(Self { left, right })
    }
}

impl Border<f64> {
    /// The same vectors, with signs aligned to a nearby point's. Each sign is arbitrary if the
    /// singular value is only rounding.
    pub fn aligned(self, other: &Self) -> Self {
        let align = |own: DVector<f64>, other: &DVector<f64>| if own.dot(other) < 0.0 { -own } else { own };
        Self { left: align(self.left, &other.left), right: align(self.right, &other.right) }
    }
}

/// A point of a curve in two parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct LocusPoint {
    /// The two parameters, SI or groups.
    pub values: [f64; 2],
    /// The orbit's period, s.
    pub period: f64,
    /// Phases of the drive at the impacts of the paper's machine, rad.
    pub phases: Vec<f64>,
    /// For Neimark-Sacker points the angle of the multipliers, rad.
    pub angle: Option<f64>,
    /// Type of end, if the point is one.
    pub end: Option<LocusEnd>,
}

/// End of a curve in two parameters, or a special point of codimension two on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LocusEnd {
    /// EP: the end of the range of a parameter.
    Range,
    /// GR: beyond it the orbit is not a motion of the machine, for example because a body would
    /// pass a stop or an impact would have zero speed.
    Touch,
    /// CP: a cusp of a fold curve, where both parameters reverse direction. The curve continues.
    Cusp,
    /// LPBP: a fold curve meets the pitchfork curve of a symmetric orbit.
    FoldPitchfork,
    /// LPPD: an orbit has a multiplier 1 and a multiplier -1. The curve continues.
    FoldFlip,
    /// R1 or R2: two multipliers meet at 1 or -1. A curve of Neimark-Sacker points ends there; a
    /// curve of folds or of period doublings continues.
    Resonance(i8),
    /// MX: continuation failed.
    NoConvergence,
    /// The curve is closed.
    Closed,
}

/// Angle of multipliers from 1 or -1, rad, within which a curve that cannot be continued ends at
/// this resonance. At the resonance itself, one of the equations is satisfied identically, so only
/// a step across the resonance detects it.
const RESONANT: f64 = 1e-2;

impl LocusEnd {
    /// The resonance near which multipliers have a given angle, rad.
    pub(super) fn resonance(angle: f64) -> Option<Self> {
        if angle < RESONANT {
            Some(Self::Resonance(1))
        } else if angle > PI - RESONANT {
            Some(Self::Resonance(-1))
        } else {
            None
        }
    }

    /// The two letters of the label.
    pub fn name(self) -> &'static str {
        match self {
            Self::Range => "EP",
            Self::Touch => "GR",
            Self::Cusp => "CP",
            Self::FoldPitchfork => "LPBP",
            Self::FoldFlip => "LPPD",
            Self::Resonance(1) => "R1",
            Self::Resonance(_) => "R2",
            Self::NoConvergence => "MX",
            Self::Closed => "closed",
        }
    }
}
