//! What the analyses refuse.

/// Errors of the analyses; every message names what was given and what is allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The model or the simulator refuses.
    #[error(transparent)]
    Model(#[from] vibro_impact::Error),
    /// No parameter has this name.
    #[error("no parameter is named `{name}`; the nearest is `{nearest}`: {description}, {allowed}")]
    UnknownName {
        /// What was given.
        name: String,
        /// The nearest valid name.
        nearest: &'static str,
        /// What that one is.
        description: &'static str,
        /// The range of that one.
        allowed: &'static str,
    },
    /// The value of a parameter is no number.
    #[error("{name} = `{text}` is not a number: allowed is {allowed}")]
    NotANumber {
        /// The parameter.
        name: &'static str,
        /// What was given.
        text: String,
        /// Its range.
        allowed: &'static str,
    },
    /// A text of another form than the one expected.
    #[error("`{text}`: expected {expected}")]
    Form {
        /// What was given.
        text: String,
        /// The form, with an example.
        expected: &'static str,
    },
    /// The [store](crate::parts::PartStore) of finished parts failed.
    #[error(transparent)]
    Store(Box<dyn std::error::Error + Send + Sync>),
}

/// Result with the analyses' error.
pub type Result<T> = std::result::Result<T, Error>;

impl Error {
    /// For `map_err` on what a [store](crate::parts::PartStore) does.
    pub fn store(reason: impl std::error::Error + Send + Sync + 'static) -> Self {
        Self::Store(Box::new(reason))
    }
}
