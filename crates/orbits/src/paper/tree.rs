//! All branches found of a family, and the result of tracing one start.

use super::branch::{Branch, OrbitPoint};
use super::path::PathEnd;
use super::seeds::Searched;
use serde::{Deserialize, Serialize};

/// All branches found of a family.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// Branches in the order in which they were found, which depends only on the family and the
    /// options.
    pub branches: Vec<Branch>,
    /// Number of starts from which no branch could be followed.
    pub failures: usize,
    /// The search for orbits by simulation.
    pub searched: Searched,
}

/// Result of a start: the points of a branch, and its ends.
#[derive(Serialize, Deserialize)]
pub(super) struct Traced {
    pub points: Vec<OrbitPoint>,
    pub closed: bool,
    /// Indices of end points with the ends there.
    pub ends: Vec<(usize, PathEnd)>,
}
