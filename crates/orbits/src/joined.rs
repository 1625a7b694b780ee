//! A branch from the paths in both directions from an orbit.

use super::branch::{Branch, OrbitPoint};
use super::path::{Path, PathEnd};
use super::problem::Problem;
use crate::label::Label;
use nalgebra::DVector;

/// Distance of a fold from a crossing at which it is the turn of the side branch.
const TURN: f64 = 1e-4;

impl Branch {
    /// The branch of a path in both directions from an orbit: the first path turned round, then the
    /// second.
    pub(super) fn joined(problem: Problem, back: Path, on: Path) -> (Self, [PathEnd; 2]) {
        let mut points: Vec<OrbitPoint> = back.points;
        points.reverse();
        // Each point has the stability of the piece that follows it, which was that before it.
        for k in 0..points.len().saturating_sub(1) {
            let next = points[k + 1].stability;
            if points[k].special.is_some() {
                points[k].stability = next;
            }
        }
        points.pop();
        let began_at = Some(points.len());
        points.extend(on.points);
        // The side branch of a crossing turns there: its fold is the crossing.
        let crossings: Vec<DVector<f64>> =
            points.iter().filter(|p| p.is(Label::BranchPoint)).map(|p| p.u.clone()).collect();
        for point in points.iter_mut().filter(|p| p.is(Label::Fold)) {
            if crossings.iter().any(|u| (u - &point.u).norm() < TURN) {
                point.special = None;
            }
        }
        let closed = matches!(on.end, PathEnd::Closed);
        let branch = Self { id: 0, parent: None, depth: 0, points, closed, began_at, problem };
        (branch, [back.end, on.end])
    }
}
