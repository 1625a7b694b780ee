//! Branches of the paper's machine: their words, orbits and maxima.

use super::family::Family;
use super::orbit::Orbit;
use crate::branch::OrbitPoint;
use crate::stop_word::OrbitWord;
use vibro_studies::Result;

/// A branch of orbits with one canonical word.
pub type Branch = crate::branch::Branch<OrbitWord>;

impl OrbitPoint {
    /// At an orbit of the paper's machine, the phases of the drive at the impacts, rad.
    pub fn phases(&self) -> &[f64] {
        &self.u.as_slice()[..self.u.len() - 1]
    }
}

impl Branch {
    /// The branch of traced points.
    pub(super) fn new(word: OrbitWord, points: Vec<OrbitPoint>, closed: bool) -> Self {
        let (depth, periods, began_at) = (0, Some(word.period()), None);
        Self { id: 0, parent: None, depth, periods, points, closed, began_at, of: word }
    }

    /// Canonical word of all its orbits.
    pub fn word(&self) -> &OrbitWord {
        &self.of
    }

    /// The orbit of one of its points.
    ///
    /// # Errors
    /// The error of [`Family::system`] at the point; an error if the point's phases do not give an
    /// orbit.
    pub fn orbit(&self, family: &Family, point: &OrbitPoint) -> Result<Orbit> {
        let system = family.system(&[point.value])?;
        Orbit::at(&system, &self.of, point.phases()).map_err(|obstacle| obstacle.error(&system, &self.of))
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
}
