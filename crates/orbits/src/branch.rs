//! Branches of orbits as plain data: points, special points, stability.

use super::orbit::Stability;
use crate::label::Label;
use crate::stop_word::OrbitWord;
use nalgebra::{Complex, DVector};
use serde::{Deserialize, Serialize};

/// A special point of a branch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Special {
    /// Type of the point.
    pub label: Label,
    /// The element concerned, as `stop.NAME`; empty if there is none.
    pub element: String,
    /// At a touch of the paper's machine: the word that lists the touch.
    pub longer: Option<OrbitWord>,
    /// At a touch of the paper's machine: whether the orbits with and without the impact exist on
    /// the same side, so that the touch is a fold of the family.
    pub fold: Option<bool>,
}

impl Special {
    /// A special point of an element.
    pub fn new(label: Label, element: impl Into<String>) -> Self {
        Self { label, element: element.into(), longer: None, fold: None }
    }

    pub(super) fn of(label: Label) -> Self {
        Self::new(label, "")
    }
}

/// One orbit of a branch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrbitPoint {
    /// The parameter, SI or a group.
    pub value: f64,
    /// The orbit's period, s.
    pub period: f64,
    /// The nontrivial multipliers, largest first; at a touch, the multipliers of the orbit before
    /// it.
    #[serde(with = "super::stored::multipliers")]
    pub multipliers: Vec<Complex<f64>>,
    /// Whether the orbit attracts its neighbourhood; at a special point, the stability up to the
    /// next point; at the last point, the stability from the previous point.
    pub stability: Stability,
    /// The special point here, if it is one.
    pub special: Option<Special>,
    /// The unknowns of the orbit's equations; the scaled parameter comes last.
    #[serde(with = "super::stored::vector")]
    pub(super) u: DVector<f64>,
}

impl OrbitPoint {
    /// The label of a special point.
    pub fn label(&self) -> Option<Label> {
        self.special.as_ref().map(|special| special.label)
    }

    /// Whether the orbit attracts its neighbourhood.
    pub fn is_stable(&self) -> bool {
        self.stability == Stability::Stable
    }
}

/// A connected family of orbits along a parameter; `C` contains the equations of its orbits.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch<C = super::problem::Problem> {
    /// Index in the list of branches.
    pub id: usize,
    /// Indices of the branch and of its point where this branch begins; `None` for a branch that
    /// starts from a motion.
    pub parent: Option<(usize, usize)>,
    /// Number of switches, at doublings, crossings and touches of rigid stops, since a motion.
    pub depth: u32,
    /// Period of its orbits in drive periods; `None` for an autonomous machine.
    pub periods: Option<u32>,
    /// Points in order.
    pub points: Vec<OrbitPoint>,
    /// Whether the branch ends where it begins.
    pub closed: bool,
    /// Index of the starting point of both directions.
    pub(super) began_at: Option<usize>,
    pub(super) of: C,
}

impl<C> Branch<C> {
    /// Stability of the pieces before and after a point; at an end both are the stability of the
    /// only piece.
    pub fn stability_around(&self, point: usize) -> [Stability; 2] {
        let after = self.points[point].stability;
        [point.checked_sub(1).map_or(after, |last| self.points[last].stability), after]
    }

    /// Whether the branch gains or loses stability at a point, or ends there while stable.
    pub fn bounds_stability(&self, point: usize) -> bool {
        let [before, after] = self.stability_around(point);
        let ends = point == 0 || point + 1 == self.points.len();
        before != after || (ends && after == Stability::Stable)
    }

    /// Whether any of its orbits is stable.
    pub fn is_somewhere_stable(&self) -> bool {
        self.points.iter().any(OrbitPoint::is_stable)
    }
}
