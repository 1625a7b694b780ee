//! Branches as plain data: points, labels, stability.

use super::family::Family;
use super::orbit::Orbit;
use super::word::OrbitWord;
use crate::label::Label;
use nalgebra::Complex;
use serde::{Deserialize, Serialize};
use vibro_studies::Result;

/// A special point of a branch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Special {
    /// Type of the point.
    pub label: Label,
    /// At a touch: the word that lists it.
    pub longer: Option<OrbitWord>,
    /// At a touch: whether the orbits with and without the impact exist on the same side of it, so
    /// that the touch is a fold of the family.
    pub fold: Option<bool>,
}

impl Special {
    pub(super) fn of(label: Label) -> Self {
        Self { label, longer: None, fold: None }
    }
}

/// One orbit of a branch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct OrbitPoint {
    /// The parameter.
    pub value: f64,
    /// Phases of the drive at the impacts, rad.
    pub phases: Vec<f64>,
    /// The multipliers, largest first; at a touch those of the orbit without the touching impact.
    #[serde(with = "super::stored::multipliers")]
    pub multipliers: [Complex<f64>; 6],
    /// Whether the piece of the branch from here to the next point is stable; at the last point the
    /// piece before it.
    pub stable: bool,
    /// The special point here, if it is one.
    pub special: Option<Special>,
}

impl OrbitPoint {
    /// The label of a special point.
    pub fn label(&self) -> Option<Label> {
        self.special.as_ref().map(|s| s.label)
    }
}

/// A connected family of orbits along the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// Index in the tree.
    pub id: usize,
    /// Index of the parent branch and of its point at which this branch begins; `None` for a branch
    /// that starts from a simulated motion.
    pub parent: Option<(usize, usize)>,
    /// Number of switches of branches since a simulated motion.
    pub depth: u32,
    /// Canonical word of all orbits of the branch.
    pub word: OrbitWord,
    /// Points in order.
    pub points: Vec<OrbitPoint>,
    /// Whether the branch ends where it begins.
    pub closed: bool,
}

impl Branch {
    /// The orbit of one of its points.
    ///
    /// # Errors
    /// The error of [`Family::system`] at the point; an error if the phases of the point do not
    /// give an orbit.
    pub fn orbit(&self, family: &Family, point: &OrbitPoint) -> Result<Orbit> {
        let system = family.system(&[point.value])?;
        Orbit::at(&system, &self.word, &point.phases).map_err(|obstacle| obstacle.error(&system, &self.word))
    }

    /// The local maxima, at each point, of the sum of x1, x2, x3 with the given weights, units of
    /// L, the largest first. The list of a point is empty if its orbit cannot be computed.
    pub fn maxima(&self, family: &Family, weights: [f64; 3]) -> Vec<Vec<f64>> {
        let at = |point: &OrbitPoint| {
            let mut found = self.orbit(family, point).map_or(Vec::new(), |orbit| orbit.maxima(weights));
            found.sort_by(|a, b| b.total_cmp(a));
            found
        };
        self.points.iter().map(at).collect()
    }

    /// Stability of the piece before a point and of the piece after it; at an end both are that of
    /// the only piece.
    pub fn stability_around(&self, point: usize) -> (bool, bool) {
        let after = self.points[point].stable;
        let before = point.checked_sub(1).map_or(after, |last| self.points[last].stable);
        (before, after)
    }
}
