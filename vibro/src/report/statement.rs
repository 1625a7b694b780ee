//! A statement of the paper, what it is compared with, and the outcome.

use crate::studies::{DiagramOrbits, Modulation};
use vibro_analysis::ParameterSet;
use vibro_analysis::bifurcation::Diagram;

/// How a statement compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The statement holds for what was found.
    Agrees,
    /// Part of it holds.
    Partly,
    /// It does not hold.
    Differs,
}

impl Verdict {
    /// In words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Partly => "agrees in part",
            Self::Differs => "does not agree",
        }
    }

    pub(super) fn of(agrees: bool, partly: bool) -> Self {
        match (agrees, partly) {
            (true, _) => Self::Agrees,
            (_, true) => Self::Partly,
            _ => Self::Differs,
        }
    }
}

/// A statement and what was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Where the paper makes it.
    pub place: &'static str,
    /// What it says.
    pub paper: &'static str,
    /// What was found, in numbers.
    pub found: String,
    /// How the two compare.
    pub verdict: Verdict,
}

/// What the statements are compared with.
pub(super) struct Findings<'a> {
    pub(super) set: &'a ParameterSet,
    pub(super) coarse: &'a Diagram,
    pub(super) fine: &'a Diagram,
    /// The branches over the coarse diagram, where orbits can be followed.
    pub(super) orbits: Option<&'a DiagramOrbits>,
    pub(super) modulation: Modulation,
    /// The CSV of figure 17.
    pub(super) errors: &'a [u8],
}
