//! Sections of the documentation's table of variables.

/// Section of a variable in the documentation's table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Section {
    /// Time.
    Time,
    /// Physical parameters.
    Parameters,
    /// Method that gives the motion.
    Solution,
    /// Loads.
    Loads,
    /// The bodies' motion.
    Motion,
    /// Stops and coupling.
    Contact,
    /// Energy accounts.
    Energy,
    /// Dimensionless groups.
    Groups,
    /// Steady state.
    Steady,
    /// Derivatives over the last step.
    Sensitivity,
    /// The clock of impacts.
    Clock,
}

/// All sections, in the order of the documentation.
pub const SECTIONS: &[Section] = &[
    Section::Time,
    Section::Parameters,
    Section::Solution,
    Section::Loads,
    Section::Motion,
    Section::Contact,
    Section::Energy,
    Section::Groups,
    Section::Steady,
    Section::Sensitivity,
    Section::Clock,
];

impl Section {
    /// Heading in the documentation.
    pub const fn heading(self) -> &'static str {
        match self {
            Self::Time => "Time",
            Self::Parameters => "Physical parameters",
            Self::Solution => "How the motion is obtained",
            Self::Loads => "Loads",
            Self::Motion => "Motion",
            Self::Contact => "Contact",
            Self::Energy => "Energy",
            Self::Groups => "Dimensionless groups",
            Self::Steady => "Steady state",
            Self::Sensitivity => "Sensitivities over the last step",
            Self::Clock => "Clock of impacts",
        }
    }
}
