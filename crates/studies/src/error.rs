//! Errors of the studies.

/// Error of a study. Every message states the given input and the valid choices.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The model or the simulator refuses its input.
    #[error(transparent)]
    Model(#[from] vibro_impact::Error),
    /// A described machine or its motion is refused.
    #[error(transparent)]
    Assembly(#[from] vibro_machine::Error),
    /// A described machine's new values are refused.
    #[error(transparent)]
    Refusal(#[from] vibro_machine::Refusal),
    /// A study of a described machine is refused: the machine lacks something that the study
    /// needs, or the motion has no section.
    #[error("{problem}")]
    Described {
        /// The given study, and the valid choices.
        problem: String,
    },
    /// The motion has no section, and needs a period or an element as section.
    #[error("{problem}; give a period (--period){}", if *has_elements { OR_ELEMENT } else { OR_NEW_SECTION })]
    NoSection {
        /// Why the motion has no section.
        problem: String,
        /// Whether the machine has a stop or friction.
        has_elements: bool,
    },
    /// No parameter has this name.
    #[error("no parameter is named `{name}`; {advice}")]
    UnknownName {
        /// The given name.
        name: String,
        /// The nearest valid name with its meaning and range. If none is near, all valid names.
        advice: String,
    },
    /// No measure has this name.
    #[error("no output is named `{name}`; {advice}")]
    UnknownMeasure {
        /// The given name.
        name: String,
        /// The nearest valid name with its meaning. If none is near, all valid names.
        advice: String,
    },
    /// A number has an unknown unit, or a unit of another dimension than the parameter's.
    #[error(
        "{name}: `{unit}` is not one of its units; expected one of {allowed}, or a number without a \
         unit, which is read in the first of these"
    )]
    Unit {
        /// The parameter.
        name: &'static str,
        /// The unit given.
        unit: String,
        /// The units of the parameter's dimension.
        allowed: String,
    },
    /// The value of a parameter is not a number.
    #[error("{name} = `{text}` is not a number: expected {allowed}")]
    NotANumber {
        /// The parameter.
        name: &'static str,
        /// The given text.
        text: String,
        /// Range of the parameter.
        allowed: &'static str,
    },
    /// A text does not have the expected form.
    #[error("`{text}`: expected {expected}")]
    Form {
        /// The given text.
        text: String,
        /// The form, with an example.
        expected: &'static str,
    },
    /// The requested results do not fit into memory.
    #[error("{what}: {count} requested, but at most {most} fit into memory{}", in_a_square(*.side))]
    TooMany {
        /// Kind of the results.
        what: &'static str,
        /// The requested number.
        count: f64,
        /// The largest number that fits.
        most: usize,
        /// For a plane, the largest side of a square that fits.
        side: Option<usize>,
    },
    /// The starts of a plane lead to more attractors than can be numbered.
    #[error(
        "the starts lead to more than {most} attractors, the largest number that is supported; if \
         nothing holds or damps a body, each start may have its own attractor; use fewer cells"
    )]
    TooManyAttractors {
        /// The largest number.
        most: usize,
    },
    /// No periodic orbit with an impact word was found.
    #[error("no orbit with the word {word}, closing {closing}, period {period}T: {reason}")]
    NoOrbit {
        /// The word in letters U and L.
        word: String,
        /// Closing sign of the word.
        closing: char,
        /// Period in drive periods.
        period: u32,
        /// The obstacle, with advice.
        reason: String,
    },
    /// A settled motion is not a periodic orbit with impacts only.
    #[error("the settled motion {reason}")]
    NoPeriodicMotion {
        /// The observed motion, with advice.
        reason: String,
    },
    /// The [store](crate::parts::PartStore) of finished parts failed.
    #[error(transparent)]
    Store(Box<dyn std::error::Error + Send + Sync>),
}

/// The second remedy for a motion without a section.
const OR_ELEMENT: &str = " or a stop or friction as section (--section)";

/// Advice for a machine without stops and friction.
pub const OR_NEW_SECTION: &str = ", or add a stop without effect as section: \
    `stop.section = { between = [\"ground\", \"BODY\"], gap = 0, stiffness = 1e-9 }`";

/// Result with the studies' error.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// Converts a failure of a [store](crate::parts::PartStore), for `map_err`.
    pub fn store(reason: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Store(Box::new(reason))
    }
}

/// Text about the side of a square for [`Error::TooMany`].
fn in_a_square(side: Option<usize>) -> String {
    side.map_or_else(String::new, |side| format!(", that is {side} × {side} in a square"))
}
