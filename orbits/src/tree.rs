//! All branches that were found of a family, and what is traced of them.

use super::branch::{Branch, OrbitPoint};
use super::path::PathEnd;
use super::seeds::Searched;
use serde::{Deserialize, Serialize};

/// All branches that were found.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// In the order in which they were found, which depends on nothing but the family and the
    /// options.
    pub branches: Vec<Branch>,
    /// Starts that led nowhere: no branch could be followed from them.
    pub failures: usize,
    /// Where orbits were sought.
    pub searched: Searched,
}

/// What was found from a start: the points of a branch, with how its ends continue.
#[derive(Serialize, Deserialize)]
pub(super) struct Traced {
    pub points: Vec<OrbitPoint>,
    pub closed: bool,
    /// Indices of points with what continues there.
    pub ends: Vec<(usize, PathEnd)>,
}
