//! What the protocols of different interface standards agree on with a component when it is made.

use super::settings::Settings;
use super::variables::Edition;

/// What a host does about events; agreed when the component is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EventHandling {
    /// It handles events itself: what changes at events only is shown from the event's handling on.
    pub event_mode: bool,
    /// It takes steps that end before their end.
    pub early_return: bool,
}

/// What protocols differ in.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Protocol {
    /// The value reference of the table's first variable.
    pub first_reference: u32,
    /// What the host does about events.
    pub handling: EventHandling,
    /// What settings start from.
    pub start: Settings,
    /// The variables that its description has.
    pub edition: Edition,
}

impl Default for Protocol {
    /// References count from 0, the host does nothing about events, and there is what every description has.
    fn default() -> Self {
        Self {
            first_reference: 0,
            handling: EventHandling::default(),
            start: Settings::default(),
            edition: Edition::Every,
        }
    }
}
