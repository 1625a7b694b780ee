//! All branches found of a family.

use super::branch::Branch;
use super::seeds::Searched;

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
