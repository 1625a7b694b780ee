//! All branches found in a family.

use super::branch::Branch;
use super::seeds::Searched;

/// All branches found in a family.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    /// Branches in order of discovery, which depends only on the family and the options.
    pub branches: Vec<Branch>,
    /// Number of starts without a branch.
    pub failures: usize,
    /// The search for orbits by simulation.
    pub searched: Searched,
}
