//! What else than the table `modelDescription.xml` says (FMI 3.0.2, 2.4).

use crate::component::identity;

/// A log category (FMI 3.0.2, 2.4.5).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Category {
    /// Name.
    pub name: &'static str,
    /// What it logs.
    pub description: &'static str,
}

/// The log categories.
pub const LOG_CATEGORIES: [Category; 6] = [
    Category { name: "logEvents", description: "Each impact, rest and release" },
    Category {
        name: "logStatusWarning",
        description: "Things worth knowing that do not stop the simulation",
    },
    Category { name: "logStatusDiscard", description: "Why a value was not taken" },
    Category { name: "logStatusError", description: "Why a call was refused" },
    Category { name: "logStatusFatal", description: "Why the instance can no longer be used" },
    Category { name: "logAll", description: "All of the above" },
];

/// `instantiationToken`.
pub fn instantiation_token() -> String {
    format!("{{{:032x}}}", identity::fnv1a(identity::text().as_bytes()))
}
