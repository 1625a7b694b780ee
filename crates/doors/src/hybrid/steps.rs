//! Whole steps.

use super::Hybrid;
use crate::events::StepOutcome;
use crate::life::{EventHandling, Phase};
use crate::log::Log;

/// Behaviour of a step at an event inside it.
///
/// | event mode | may end early, and ends at events | at an event |
/// |---|---|---|
/// | no | no | [`Pass`](Self::Pass) |
/// | no | yes | [`EndAfter`](Self::EndAfter) |
/// | yes | yes | [`EndBefore`](Self::EndBefore) |
/// | yes | no | [`Latch`](Self::Latch) |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtEvent {
    /// Applies its law and continues.
    Pass,
    /// Applies its law and continues. Values that change at events only are shown when the host
    /// handles events.
    Latch,
    /// Applies its law and ends.
    EndAfter,
    /// Ends before its law.
    EndBefore,
}

impl AtEvent {
    /// The behaviour for an event handling; `ends` is whether the model's steps end at events.
    pub(crate) fn of(handling: EventHandling, ends: bool) -> Self {
        match (handling.event_mode, handling.early_return && ends) {
            (false, false) => Self::Pass,
            (false, true) => Self::EndAfter,
            (true, true) => Self::EndBefore,
            (true, false) => Self::Latch,
        }
    }
}

/// Requested end of a step: the unrounded sum `point + size`, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepEnd {
    /// Beginning of the step by the host's time, s.
    pub point: f64,
    /// Length, s; 0 for an end that the host has chosen during the step.
    pub size: f64,
}

impl StepEnd {
    /// The end as a double, s.
    pub fn value(self) -> f64 {
        self.point + self.size
    }

    /// Whether the host has chosen this end during the step. Later events do not belong to the
    /// step.
    pub fn is_chosen(self) -> bool {
        self.size == 0.0
    }
}

/// Distance of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// To the end, past all events.
    End,
    /// To the first event, before its law.
    Event,
    /// To the first event at which the step ends, after its law.
    After,
}

/// The events of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Met {
    /// Whether the law of an event is still to be applied.
    pub due: bool,
    /// Number of events whose laws were applied.
    pub events: usize,
    /// Whether the run has ended early, after the law of an event.
    pub stopped: bool,
}

/// State at the end of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ended {
    /// Whether the host must handle an event.
    pub event: bool,
    /// Whether the law of an event is still to be applied.
    pub due: bool,
    /// Whether the step has ended early, after the law of an event; the next step continues from
    /// there.
    pub stopped: bool,
    /// Whether inputs may have followed polynomials through values from the host's callback.
    pub interpolated: bool,
}

/// Whether the step has ended before its end.
pub(super) fn is_early<H: Hybrid>(h: &H, end: StepEnd) -> bool {
    end.value() - h.time() > H::ROUNDING * f64::EPSILON * end.value().abs()
}

/// Values that change at events only, if the host handles events.
pub(super) fn shown<H: Hybrid>(h: &H) -> Option<H::Shown> {
    h.life().handling.event_mode.then(|| h.shown())
}

/// A whole step, with `at_event` at each event.
#[inline]
pub(crate) fn whole_step<H: Hybrid>(
    h: &mut H,
    (point, size): (f64, f64),
    at_event: AtEvent,
    log: &mut dyn Log,
) -> Result<StepOutcome, H::Problem> {
    h.check(point, size)?;
    let (end, shown) = (StepEnd { point, size }, shown(h));
    let (undo, moved) = h.take_over(end, log)?;
    let met = match whole(h, end, (at_event, moved), log) {
        Ok(met) => met,
        Err(problem) => return Err(h.undo(undo, problem)),
    };
    h.taken_over();
    h.life_mut().phase = Phase::Step;
    let event = match at_event {
        AtEvent::Latch | AtEvent::EndBefore => shown.is_some() && (met.due || met.events > 0),
        AtEvent::Pass | AtEvent::EndAfter => false,
    };
    h.latch(shown.filter(|_| event));
    let early = met.stopped || at_event == AtEvent::EndBefore && is_early(h, end);
    h.end_step(Ended { event, due: met.due, stopped: met.stopped, interpolated: false });
    Ok(StepOutcome { time: h.time(), event, early })
}

/// Runs a step whose new set values may have caused an event.
#[inline]
fn whole<H: Hybrid>(
    h: &mut H,
    end: StepEnd,
    (at_event, moved): (AtEvent, bool),
    log: &mut dyn Log,
) -> Result<Met, H::Problem> {
    let mut met = match at_event {
        AtEvent::EndBefore if moved => Met::default(),
        AtEvent::EndBefore => h.run(end, Until::Event, log)?,
        AtEvent::EndAfter => h.run(end, Until::After, log)?,
        AtEvent::Pass | AtEvent::Latch => h.run(end, Until::End, log)?,
    };
    met.events += usize::from(moved);
    if met.due && matches!(at_event, AtEvent::Pass | AtEvent::EndAfter) {
        h.apply_law(log)?;
        met.due = false;
    }
    Ok(met)
}
