//! Results of steps and events.

/// What an event has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Handled {
    /// The continuous states.
    pub states: bool,
    /// Their nominal values.
    pub nominals: bool,
}

/// Result of an advance, for a host that may handle events itself or accept steps that end early.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advance {
    /// The time reached, s.
    pub time: f64,
    /// Whether the host must handle an event there.
    pub event: bool,
    /// Whether it is before the end asked for.
    pub early: bool,
}

/// Result of a step, for a host that does not handle events.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepOutcome {
    /// The time reached, s.
    pub time: f64,
    /// Why it ended there.
    pub reason: StepReason,
}

/// Why a step ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StepReason {
    /// It reached its end.
    EndReached,
    /// It ended early at an event, as requested; the event has been carried out.
    Stopped,
}

/// Where a piece of a step ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Piece {
    /// Before the law of an event.
    Event,
    /// At its end.
    End,
}

/// Words of the messages about an FMI 2.0 step that ends early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EarlyEnd {
    /// The event at which the step ends.
    pub event: &'static str,
    /// The reason.
    pub because: &'static str,
}
