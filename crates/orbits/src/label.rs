//! Types of special points of a branch.

use serde::{Deserialize, Serialize};

/// Type of a special point, named as in AUTO and MatCont where these have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Label {
    /// LP: a fold, at which the parameter has an extremum along the branch.
    Fold,
    /// BP: two branches cross. On a symmetric orbit the symmetry breaks.
    BranchPoint,
    /// PD: a branch of twice the period is born.
    PeriodDoubling,
    /// NS: a second frequency appears.
    NeimarkSacker,
    /// GR: the block touches a stop with speed zero; another word begins.
    Grazing,
    /// EP: the end of the parameter's range.
    EndPoint,
    /// MX: continuation failed here.
    NoConvergence,
    /// UZ: a value of the parameter that was asked for.
    UserValue,
    /// CH: an impact with speed zero after which the block stays on its stop. Beyond this point the
    /// motion chatters.
    Chatter,
    /// ST: a friction begins or ceases to stick, or slips once more.
    Stick,
    /// CC: two events of different elements change places.
    Crossing,
    /// SA: an output of a block comes to a limit or leaves it, at a sample or between.
    Saturation,
}

impl Label {
    /// Labels at which a curve in two parameters may start.
    pub const STARTS: [Self; 9] = [
        Self::Fold,
        Self::BranchPoint,
        Self::PeriodDoubling,
        Self::NeimarkSacker,
        Self::Grazing,
        Self::Chatter,
        Self::Stick,
        Self::Crossing,
        Self::Saturation,
    ];

    /// The label with two letters.
    pub fn find(name: &str) -> Option<Self> {
        let others = [Self::EndPoint, Self::NoConvergence, Self::UserValue];
        Self::STARTS.into_iter().chain(others).find(|label| label.name() == name)
    }

    /// The two letters of the label.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fold => "LP",
            Self::BranchPoint => "BP",
            Self::PeriodDoubling => "PD",
            Self::NeimarkSacker => "NS",
            Self::Grazing => "GR",
            Self::EndPoint => "EP",
            Self::NoConvergence => "MX",
            Self::UserValue => "UZ",
            Self::Chatter => "CH",
            Self::Stick => "ST",
            Self::Crossing => "CC",
            Self::Saturation => "SA",
        }
    }
}

impl std::fmt::Display for Label {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
