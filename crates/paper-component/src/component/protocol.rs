//! The protocol of an interface standard, given to a component when it is made.

use super::settings::Settings;
use super::variables::{Edition, Numbering};
use fmi_doors::EventHandling;

/// Properties that differ between protocols.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Protocol {
    /// The variable of each value reference.
    pub numbering: Numbering,
    /// Event handling by the host.
    pub handling: EventHandling,
    /// Start values of the settings.
    pub start: Settings,
    /// The variables of its description.
    pub edition: Edition,
}

impl Default for Protocol {
    /// The table's own references, a host that does not handle events, and the variables of every
    /// description.
    fn default() -> Self {
        Self {
            numbering: Numbering::ALL,
            handling: EventHandling::default(),
            start: Settings::default(),
            edition: Edition::Every,
        }
    }
}
