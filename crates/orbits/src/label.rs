//! Types of special points of a branch.

use serde::{Deserialize, Serialize};

/// Type of a special point, with the names of AUTO and MatCont if they exist there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub enum Label {
    /// LP: a fold, where the parameter has an extremum along the branch.
    Fold,
    /// BP: two branches cross. On a symmetric orbit the symmetry breaks.
    BranchPoint,
    /// PD: a branch of twice the period is born.
    PeriodDoubling,
    /// NS: a second frequency appears.
    NeimarkSacker,
    /// GR: a stop is touched at zero speed; another word begins.
    Grazing,
    /// EP: the end of the parameter's range.
    EndPoint,
    /// MX: continuation failed here.
    NoConvergence,
    /// UZ: a requested value of the parameter.
    UserValue,
    /// CH: an impact at zero speed after which the body stays on the stop. Beyond this point the
    /// motion chatters.
    Chatter,
    /// ST: a friction element starts or stops sticking, or slips once more.
    Stick,
    /// CC: two events of different elements change order.
    Crossing,
    /// SA: an output of a block reaches or leaves a limit, at a sample or in between.
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
