//! Ways to advance: to a time, to an impact, with an observer, to an event and through it. The
//! next event can also be found on a copy.

use super::step::EventObserver;
use super::{AdvanceOutcome, DueEvent, Event, Pause, Simulator, check_time};
use crate::error::{Error, Result};
use vibro_numerics::double_double::DoubleDouble;

impl Simulator {
    /// Advances to exactly `end` (s), through all events.
    ///
    /// # Errors
    /// As [`advance_until`](Self::advance_until).
    pub fn advance_to(&mut self, end: f64) -> Result<()> {
        self.advance_until(end, Pause::Never, None).map(|_| ())
    }

    /// Advances to just after the first impact, or to `end` (s) if none comes before.
    ///
    /// # Errors
    /// As [`advance_until`](Self::advance_until).
    pub fn advance_to_impact(&mut self, end: f64) -> Result<AdvanceOutcome> {
        self.advance_until(end, Pause::AfterImpact, None)
    }

    /// Advances to exactly `end` (s) and shows `observer` each event in order of time.
    ///
    /// # Errors
    /// As [`advance_until`](Self::advance_until).
    pub fn advance_observed(&mut self, end: f64, observer: &mut dyn FnMut(&Event)) -> Result<()> {
        self.advance_until(end, Pause::Never, Some(observer)).map(|_| ())
    }

    /// Advances to `end` (s, a double or a double-double) or to the event at which to `pause`, and
    /// shows `observer` each event in order of time. The law of an event that is
    /// [due](Self::due_event) is applied first; an impact then counts as the first for
    /// [`Pause::AfterImpact`].
    ///
    /// An end before the present by no more than the rounding of [`time`](Self::time) to a double
    /// counts as the present.
    ///
    /// # Errors
    /// [`Error::Step`] if the end is before the present or not finite, and
    /// [`Error::PrecisionLost`] if it is so late that a double no longer resolves the motion;
    /// nothing has changed then. [`Error::WorkLimit`] if the motion hardly progresses; the state
    /// then belongs to the error's time.
    pub fn advance_until(
        &mut self,
        end: impl Into<DoubleDouble>,
        pause: Pause,
        mut observer: EventObserver<'_, '_>,
    ) -> Result<AdvanceOutcome> {
        let end = end.into();
        let present = self.check_end(end)?;
        let applied = self.apply_due_event(observer.as_deref_mut());
        if pause == Pause::AfterImpact && matches!(applied, Some(DueEvent::Impact { .. })) {
            return Ok(AdvanceOutcome::Impact);
        }
        if present {
            return Ok(AdvanceOutcome::End);
        }
        self.run(end, pause, observer)
    }

    /// Checks the end of an advance. True if it is before the present only by rounding, so that
    /// the state does not change.
    pub(super) fn check_end(&self, end: DoubleDouble) -> Result<bool> {
        let span = end.minus(self.hybrid.time).value();
        let rounded = span < 0.0 && span >= -f64::EPSILON * self.time().abs();
        if !(end.value().is_finite() && (span >= 0.0 || rounded)) {
            return Err(Error::Step { time: self.time(), end: end.value() });
        }
        check_time(self.model.rate, end.value())?;
        Ok(rounded)
    }

    /// Event at which an advance with [`Pause::BeforeEvent`] has stopped. Its law is not yet
    /// applied: state, accelerations and contact are from before the event.
    pub fn due_event(&self) -> Option<DueEvent> {
        self.hybrid.due
    }

    /// Applies the law of the event that is due, if any, and returns the event. Without this call
    /// the next advance applies the law. The motion continues bit-identical to one after
    /// [`Pause::AfterImpact`], except for the account of input energy, which is summed in another
    /// order.
    pub fn apply_due_event(&mut self, mut observer: EventObserver<'_, '_>) -> Option<DueEvent> {
        let due = self.hybrid.due.take()?;
        let (mut z, side) = (self.augmented(), f64::from(due.side()));
        self.work.events += 1;
        if self.loaded() {
            self.apply_event_law::<1>(&mut z, side, &mut observer);
        } else {
            self.apply_event_law::<0>(&mut z, side, &mut observer);
        }
        self.hybrid.y.copy_from_slice(&z[..6]);
        Some(due)
    }

    /// Next event up to `horizon` (s), found on a copy: this simulator does not change. An event
    /// that is due is the next one.
    ///
    /// The event's time is rounded to a double, and an advance to that time may end just before
    /// the event. To reach it, advance to a later end with [`Pause::BeforeEvent`] or
    /// [`Pause::AfterImpact`].
    ///
    /// # Errors
    /// As [`advance_until`](Self::advance_until).
    pub fn next_event(&self, horizon: f64) -> Result<Option<Event>> {
        let mut ahead = self.clone().without_energy_accounts();
        if ahead.hybrid.due.is_none() {
            ahead.advance_until(horizon, Pause::BeforeEvent, None)?;
        }
        let mut next = None;
        ahead.apply_due_event(Some(&mut |event: &Event| next = next.or(Some(*event))));
        Ok(next)
    }
}
