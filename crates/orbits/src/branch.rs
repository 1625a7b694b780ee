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
    /// The element that is meant, as `stop.NAME`; empty where none is.
    pub element: String,
    /// At a touch of the paper's machine: the word that lists it.
    pub longer: Option<OrbitWord>,
    /// At a touch of the paper's machine: whether the orbits with and without the impact exist on
    /// the same side of it, so that the touch is a fold of the family.
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
    /// The multipliers that are not 1 by theory, largest first; at a touch those of the orbit
    /// before it.
    #[serde(with = "super::stored::multipliers")]
    pub multipliers: Vec<Complex<f64>>,
    /// Whether the orbit attracts its neighbourhood; at a special point what holds on the way to
    /// the next point, at the last point what holds on the way from the point before.
    pub stability: Stability,
    /// The special point here, if it is one.
    pub special: Option<Special>,
    /// The unknowns of the orbit's equations; the parameter in its unit comes last.
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

/// A connected family of orbits along a parameter; `C` has the equations of its orbits.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch<C = super::problem::Problem> {
    /// Index in the list of branches.
    pub id: usize,
    /// Index of the branch and of its point from which this branch begins; `None` for one that
    /// starts from a motion.
    pub parent: Option<(usize, usize)>,
    /// Number of switches, at doublings, crossings and touches of rigid stops, since a motion.
    pub depth: u32,
    /// Period of its orbits in periods of the drive; `None` for an autonomous machine.
    pub periods: Option<u32>,
    /// Points in order.
    pub points: Vec<OrbitPoint>,
    /// Whether the branch ends where it begins.
    pub closed: bool,
    /// The point from which it was followed in both directions.
    pub(super) began_at: Option<usize>,
    pub(super) of: C,
}

impl<C> Branch<C> {
    /// Stability of the piece before a point and of the piece after it; at an end both are that of
    /// the only piece.
    pub fn stability_around(&self, point: usize) -> [Stability; 2] {
        let after = self.points[point].stability;
        [point.checked_sub(1).map_or(after, |last| self.points[last].stability), after]
    }

    /// Whether it gains or loses its stability at a point, or ends there while stable.
    pub fn bounds_stability(&self, point: usize) -> bool {
        let [before, after] = self.stability_around(point);
        let ends = point == 0 || point + 1 == self.points.len();
        before != after || (ends && after == Stability::Stable)
    }

    /// Whether one of its orbits is stable.
    pub fn is_somewhere_stable(&self) -> bool {
        self.points.iter().any(OrbitPoint::is_stable)
    }
}
