//! Steps, whole or in pieces from event to event.

use super::Hybrid;
use crate::events::{Advance, Piece};
use crate::life::{EventHandling, Phase};
use crate::log::Log;
use crate::problem::Problem;

/// What a step does at an event inside it.
///
/// | event mode | may end early, and ends at events | at an event |
/// |---|---|---|
/// | no | no | [`Pass`](Self::Pass) |
/// | no | yes | [`EndAfter`](Self::EndAfter) |
/// | yes | yes | [`EndBefore`](Self::EndBefore) |
/// | yes | no | [`Latch`](Self::Latch) |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtEvent {
    /// Applies its law and goes on.
    Pass,
    /// Applies its law and goes on; what changes at events only is shown when the host handles
    /// events.
    Latch,
    /// Applies its law and ends.
    EndAfter,
    /// Ends before its law.
    EndBefore,
}

impl AtEvent {
    /// As it was agreed with the host, of a model whose steps may end at events or not.
    pub(super) fn of(handling: EventHandling, ends: bool) -> Self {
        match (handling.event_mode, handling.early_return && ends) {
            (false, false) => Self::Pass,
            (false, true) => Self::EndAfter,
            (true, true) => Self::EndBefore,
            (true, false) => Self::Latch,
        }
    }
}

/// Where a step is to end: `point + size`, s, of which the rounding is not lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepEnd {
    /// Begin by the host's clock, s.
    pub point: f64,
    /// Length, s; 0 for an end that the host has chosen under way.
    pub size: f64,
}

impl StepEnd {
    /// As a double, s.
    pub fn value(self) -> f64 {
        self.point + self.size
    }

    /// Whether the host has chosen it under way: no event beyond it is taken with it.
    pub fn is_chosen(self) -> bool {
        self.size == 0.0
    }
}

/// How far a run goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// To the end, over all events.
    End,
    /// Before the law of the first event.
    Event,
    /// After the law of the first event at which a step is to end.
    After,
}

/// What a run has met.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Met {
    /// Whether it stands before the law of an event.
    pub due: bool,
    /// Events whose laws it has applied.
    pub events: usize,
    /// Whether it has ended after the law of an event before the end.
    pub stopped: bool,
}

/// How a step has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ended {
    /// Whether the host must handle an event.
    pub event: bool,
    /// Whether the law of an event is still to be applied.
    pub due: bool,
    /// Whether it has ended after an event before its end, from where the next step goes on.
    pub stopped: bool,
    /// Whether inputs may have followed a course that the host's callback has given.
    pub interpolated: bool,
}

/// A step in progress that a host looks into.
#[derive(Debug)]
pub struct Pieces<H: Hybrid> {
    pub(super) end: StepEnd,
    pub(super) at_event: AtEvent,
    /// To take the step back.
    pub(super) before: H::State,
    undo: Option<H::Undo>,
    /// What was shown at the step's start of what changes at events only, where the host handles
    /// events.
    shown: Option<H::Shown>,
    /// Whether it stands before the law of an event, and events so far.
    met: Met,
    /// Why the law of an event could not be applied; the step is then taken back.
    failed: Option<H::Problem>,
}

/// Whether the step has ended before its end.
fn is_early<H: Hybrid>(h: &H, end: StepEnd) -> bool {
    end.value() - h.time() > H::ROUNDING * f64::EPSILON * end.value().abs()
}

/// What changes at events only, where the host handles events.
fn shown<H: Hybrid>(h: &H) -> Option<H::Shown> {
    h.life().handling.event_mode.then(|| h.shown())
}

/// A whole step.
#[inline]
pub(super) fn advance<H: Hybrid>(
    h: &mut H,
    (point, size): (f64, f64),
    at_event: AtEvent,
    log: &mut dyn Log,
) -> Result<Advance, H::Problem> {
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
    Ok(Advance { time: h.time(), event, early })
}

/// Runs a step of which taking over may have been an event.
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

impl<H: Hybrid> Pieces<H> {
    pub(super) fn begin(h: &H, point: f64, size: f64) -> Result<Self, H::Problem> {
        h.check(point, size)?;
        Ok(Self {
            end: StepEnd { point, size },
            at_event: AtEvent::of(h.life().handling, h.ends_at_events()),
            before: h.save()?,
            undo: None,
            shown: shown(h),
            met: Met::default(),
            failed: None,
        })
    }

    pub(super) fn start(&mut self, h: &mut H, log: &mut dyn Log) -> Result<Piece, H::Problem> {
        match h.take_over(self.end, log) {
            Err(problem) => Err(self.taken_back(h, problem)),
            Ok((undo, moved)) => {
                self.undo = Some(undo);
                self.met.events += usize::from(moved);
                h.taken_over();
                let ends = moved && self.at_event == AtEvent::EndBefore;
                Ok(if ends { Piece::Event } else { Piece::End })
            }
        }
    }

    pub(super) fn next(
        &mut self,
        h: &mut H,
        until: Option<f64>,
        log: &mut dyn Log,
    ) -> Result<Piece, H::Problem> {
        let end = until.map_or(self.end, |point| StepEnd { point, size: 0.0 });
        let met = match self.failed.take() {
            Some(problem) => Err(problem),
            None => h.run(end, Until::Event, log),
        };
        match met {
            Err(problem) => Err(self.taken_back(h, problem)),
            Ok(met) => {
                self.met.due = met.due;
                Ok(if met.due { Piece::Event } else { Piece::End })
            }
        }
    }

    /// Applies the law of the event before which the last piece has ended; true where the step ends
    /// after it. A law that cannot be applied is told with the next piece.
    pub(super) fn pass_event(&mut self, h: &mut H, log: &mut dyn Log) -> bool {
        self.failed = h.apply_law(log).err();
        self.met = Met { due: self.failed.is_some(), events: self.met.events + 1, ..self.met };
        if let Some(shown) = &self.shown {
            h.latch(Some(shown.clone()));
        }
        self.at_event == AtEvent::EndAfter
    }

    pub(super) fn end(&self, h: &mut H) -> Advance {
        let Met { due, events, .. } = self.met;
        let (event, early) = (self.shown.is_some() && (due || events > 0), is_early(h, self.end));
        h.life_mut().phase = Phase::Step;
        h.latch(self.shown.clone().filter(|_| event));
        h.end_step(Ended { event, due, stopped: false, interpolated: true });
        Advance { time: h.time(), event, early }
    }

    /// Takes a step back that has met a problem; the problem, or that the step could not be taken
    /// back.
    fn taken_back(&mut self, h: &mut H, problem: H::Problem) -> H::Problem {
        let problem = match self.undo.take() {
            Some(undo) => h.undo(undo, problem),
            None => problem,
        };
        match h.restore(&self.before) {
            Ok(()) => problem,
            Err(refused) => Problem::not_taken_back(&problem, &refused).into(),
        }
    }
}

/// Value and derivatives at 0 of the cubic through `values` at 0, 1/3, 2/3 and 3/3 of `span` s, at
/// a time of the motion.
pub(super) fn cubic([u0, u1, u2, u3]: [f64; 4], span: f64, time: f64) -> [f64; 4] {
    // Newton's forward differences at the first value; three intervals to the span.
    let (first, second, third) = (u1 - u0, (u2 - u1) - (u1 - u0), (u3 - u2) - 2.0 * (u2 - u1) + (u1 - u0));
    let rate = 3.0 / span;
    let slopes = [first - 0.5 * second + third / 3.0, second - third, third];
    let scale = [rate, rate * rate, rate * rate * rate];
    let polynomial = [u0, slopes[0] * scale[0], slopes[1] * scale[1], slopes[2] * scale[2]];
    // In a step of the length of rounding the differences say nothing.
    let says = span > f64::EPSILON * time.abs().max(1.0) && polynomial.iter().all(|x| x.is_finite());
    if says { polynomial } else { [u0, 0.0, 0.0, 0.0] }
}

#[cfg(test)]
mod tests {
    use super::cubic;

    #[test]
    fn closed_form_derivatives_of_a_cubic() {
        // 1 - 2 t + 3 t² - 4 t³ over 3 s, of which all numbers are exact.
        let values = [0.0, 1.0, 2.0, 3.0].map(|t: f64| 1.0 - 2.0 * t + 3.0 * t * t - 4.0 * t * t * t);
        assert_eq!(cubic(values, 3.0, 0.0), [1.0, -2.0, 6.0, -24.0]);
        assert_eq!(cubic(values, 1e-17, 0.0), [1.0, 0.0, 0.0, 0.0]);
    }
}
