//! Statements of the paper and the results compared with them.

use crate::studies::paper::{DiagramOrbits, Modulation};
use vibro_studies::paper::ParameterSet;
use vibro_studies::paper::bifurcation::Diagram;

/// How a statement compares with the results.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The statement holds.
    Agrees,
    /// Part of it holds.
    Partly,
    /// It does not hold.
    Differs,
}

impl Verdict {
    /// Text of the verdict.
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

/// A statement with the results.
#[derive(Clone, Debug, PartialEq)]
pub struct Statement {
    /// Place of the statement in the paper.
    pub place: &'static str,
    /// The statement.
    pub paper: &'static str,
    /// The results, in numbers.
    pub found: String,
    /// How the two compare.
    pub verdict: Verdict,
}

/// Results with which statements are compared.
pub(super) struct Findings<'a> {
    pub(super) set: &'a ParameterSet,
    pub(super) coarse: &'a Diagram,
    pub(super) fine: &'a Diagram,
    /// The branches over the coarse diagram, if orbits can be followed.
    pub(super) orbits: Option<&'a DiagramOrbits>,
    pub(super) modulation: Modulation,
    /// The CSV of figure 17.
    pub(super) errors: &'a [u8],
}
