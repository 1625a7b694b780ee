//! What the protocols of different interface standards agree on with a component when it is made.

use super::settings::Settings;
use super::variables::{Edition, Numbering};
use fmi_doors::EventHandling;

/// What protocols differ in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Protocol {
    /// Which variable a value reference stands for.
    pub numbering: Numbering,
    /// What the host does about events.
    pub handling: EventHandling,
    /// What settings start from.
    pub start: Settings,
    /// The variables that its description has.
    pub edition: Edition,
}

impl Default for Protocol {
    /// Every variable by the table's own reference, the host does nothing about events, and there
    /// is what every description has.
    fn default() -> Self {
        Self {
            numbering: Numbering::ALL,
            handling: EventHandling::default(),
            start: Settings::default(),
            edition: Edition::Every,
        }
    }
}
