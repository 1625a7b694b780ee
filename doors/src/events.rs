//! How steps and events end.

/// What an event has changed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Handled {
    /// The continuous states.
    pub states: bool,
    /// Their nominal values.
    pub nominals: bool,
}

/// How an advance ended, for a host that may handle events itself or take steps that end early.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advance {
    /// The time reached, s.
    pub time: f64,
    /// Whether the host must handle an event there.
    pub event: bool,
    /// Whether it is before the end asked for.
    pub early: bool,
}

/// How a step ended, for a host that knows nothing of events.
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
    /// It stands at an event before its end, as was asked for; the event has been carried out.
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

/// What messages say of a step of FMI 2.0 that ends early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EarlyEnd {
    /// What it ends at.
    pub event: &'static str,
    /// Why it does.
    pub because: &'static str,
}
