//! Results of steps and events.

/// Changes that an event has caused.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Handled {
    /// The continuous states.
    pub states: bool,
    /// Their nominal values.
    pub nominals: bool,
}

/// Result of a step, in either version: the returned arguments of `fmi3DoStep` (FMI 3.0.2, 4.2.1).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StepOutcome {
    /// The time reached, s (`lastSuccessfulTime`).
    pub time: f64,
    /// Whether the host must handle an event at this time (`eventHandlingNeeded`).
    pub event: bool,
    /// Whether the step ended before its requested end (`earlyReturn`; FMI 2.0: Discard).
    pub early: bool,
}

/// Position at which a piece of a step ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Piece {
    /// Before the law of an event.
    Event,
    /// At the end of the step.
    End,
}

/// Texts for messages about an FMI 2.0 step that ends early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EarlyEnd {
    /// The event at which the step ends.
    pub event: &'static str,
    /// The reason.
    pub because: &'static str,
}
