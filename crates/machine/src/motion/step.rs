//! Advances a motion by sub-steps, each proved to be without an event or ended at the first one.

use super::instant::end_of_instant;
use super::jump::Parted;
use super::limits::PACE;
use super::passage::{LEAVES_ZERO, PassageSearch, StepPoint};
use super::{Due, Hybrid, Motion, Observer, Reached, Scratch};
use crate::energy::{EIGHT, NODES, Rule, Samples};
use crate::error::Error;
use crate::flow::ORDERS;
use vibro_numerics::double_double::DoubleDouble;

/// Allowed number of sub-steps: per call, and additionally per sub-step's length of time.
const WORK: (u64, f64) = (20_000, 64.0);
/// Default of the largest number of sub-steps in one call: some seconds for a few bodies. It is
/// lower under a fuzzer, whose code is many times slower.
pub(super) const MOST_WORK: u64 = if cfg!(fuzzing) { 200_000 } else { 20_000_000 };
/// Number of sub-steps between two computations of signals from the time; in between the signals
/// advance with the state. The rounding over all of these sub-steps is like the rounding of one. A
/// long step is tried after this number of whole sub-steps in a row.
const RENEW: u32 = 16;
/// Largest number of events without progress of time, per event function and one more.
const CHAIN: usize = 100;
/// Smallest progress of time relative to the mode's sub-step: a few roundings.
const PROGRESS: f64 = 1e-15;

/// Whether an advance pauses at events.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Pause {
    Never,
    AfterEvent,
    BeforeEvent,
    /// Before events, and where coordinates of signals are reset.
    AtFlightEnd,
}

impl Motion {
    /// Advances to a time, or to the last time event of its instant, and passes that event.
    ///
    /// # Errors
    /// [`Error::Step`] for an end that is before the present or not finite. [`Error::Jammed`],
    /// [`Error::Violated`], [`Error::Stuck`] and [`Error::Beyond`] if the motion cannot continue.
    /// [`Error::TooStiff`] and [`Error::Interrupted`] if another call continues; the state is then
    /// the state at the time reached.
    pub fn advance_to(&mut self, end: f64) -> Result<(), Error> {
        self.advance(end, Pause::Never, &mut None).map(drop)
    }

    /// Advances to a time and reports all events.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_observed(
        &mut self,
        end: f64,
        observer: &mut dyn FnMut(&super::Event),
    ) -> Result<(), Error> {
        self.advance(end, Pause::Never, &mut Some(observer)).map(drop)
    }

    /// Advances to a time or, if it is earlier, to the state after the next event.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_to_event(
        &mut self,
        end: f64,
        observer: &mut dyn FnMut(&super::Event),
    ) -> Result<Reached, Error> {
        self.advance(end, Pause::AfterEvent, &mut Some(observer))
    }

    /// Advances to a time or, if it is earlier, to the next event, before its law.
    /// [`apply_event`](Self::apply_event) or any further advance applies the law.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_before_event(
        &mut self,
        end: f64,
        observer: &mut dyn FnMut(&super::Event),
    ) -> Result<Reached, Error> {
        self.advance(end, Pause::BeforeEvent, &mut Some(observer))
    }

    /// Advances to a time or, if it is earlier, to the end of a flight: the next event, before its
    /// law, or a time at which a sweep continues with another polynomial, which is not an event.
    /// [`apply_event`](Self::apply_event) or any further advance then applies the law or the
    /// polynomial.
    ///
    /// # Errors
    /// As [`advance_to`](Self::advance_to).
    pub fn advance_flight(
        &mut self,
        end: f64,
        observer: &mut dyn FnMut(&super::Event),
    ) -> Result<Reached, Error> {
        self.advance(end, Pause::AtFlightEnd, &mut Some(observer))
    }

    /// Whether an event is pending: reached, but its law not applied yet.
    pub fn is_event_due(&self) -> bool {
        self.hybrid.due.is_some()
    }

    /// Applies the law of the pending event, if there is one.
    ///
    /// # Errors
    /// [`Error::Jammed`], [`Error::Violated`] and [`Error::Stuck`] if the motion cannot continue.
    pub fn apply_event(&mut self, observer: &mut dyn FnMut(&super::Event)) -> Result<(), Error> {
        self.pass_event(&mut Some(observer))
    }

    /// Applies the law of the pending event, if there is one.
    pub(super) fn pass_event(&mut self, observer: &mut Observer) -> Result<(), Error> {
        match self.hybrid.due.take() {
            Some(Due::Passage(watch)) => self.settle(&[watch], &Parted::default(), observer),
            Some(Due::Knot) => {
                let stood = self.before_jump();
                self.refill();
                self.apply_knot(stood, observer)
            }
            Some(Due::Renewal) => {
                self.refill();
                Ok(())
            }
            Some(Due::Sample) => self.apply_samples(observer),
            None => Ok(()),
        }
    }

    fn advance(&mut self, end: f64, pause: Pause, observer: &mut Observer) -> Result<Reached, Error> {
        if !(end.is_finite() && end_of_instant(end) >= self.time()) {
            return Err(Error::Step { time: self.time(), end });
        }
        self.pass_event(observer)?;
        let end = self.assembly.system.last_of_instant(end).max(self.time());
        let target = DoubleDouble::new(end);
        let began = self.time();
        let (mut work, mut from) = (WORK.0 as f64, began);
        let mut seen = began;
        for sub_steps in 0..self.most_work {
            self.check_interruption(sub_steps)?;
            if sub_steps > 0 && sub_steps % PACE.0 == 0 {
                self.check_pace(end - self.time(), self.time() - seen)?;
                seen = self.time();
            }
            let sample = if self.hybrid.clocks.is_empty() { None } else { self.next_sample() };
            let sample = sample.filter(|sample| *sample <= end).map(DoubleDouble::new);
            let remaining = target.minus(self.hybrid.time).value();
            if remaining <= 0.0 && sample.is_none() {
                self.hybrid.time = target;
                self.check_sizes()?;
                return Ok(Reached::End);
            }
            let knot = self.assembly.system.signals.next_knot_exactly(self.time());
            let knot = knot.filter(|knot| knot.value() <= end);
            let (goal, at_knot) = knot.map_or((target, false), |knot| (knot, true));
            let renewal = self.assembly.system.signals.next_renewal(self.time());
            let renewal = renewal.filter(|own| own.value() <= end && own.minus(goal).value() < 0.0);
            let goal = renewal.unwrap_or(goal);
            let at_knot = at_knot && renewal.is_none();
            let is_first = |own: &DoubleDouble| {
                let left = own.minus(goal).value();
                left < 0.0 || (left == 0.0 && !at_knot && renewal.is_none())
            };
            let sample = sample.filter(is_first);
            let (goal, at_knot) = sample.map_or((goal, at_knot), |sample| (sample, false));
            let renewal = renewal.filter(|_| sample.is_none());
            if goal.minus(self.hybrid.time).value() <= 0.0 {
                // This sample belongs to the instant of another sample or of a knot.
                self.hybrid.due = None;
            } else if self.hybrid.carried == RENEW && self.long_step(goal) {
                self.hybrid.due = None;
            } else {
                self.hybrid.due = self.vectors.dispatch(Substep {
                    motion: self,
                    goal,
                    at: [at_knot, at_knot || renewal.is_some()],
                })?;
            }
            if self.hybrid.carried == RENEW || self.hybrid.due.is_some() {
                self.check_sizes()?;
            }
            if sample.is_some() && self.hybrid.due.is_none() && goal.minus(self.hybrid.time).value() <= 0.0 {
                self.hybrid.due = Some(Due::Sample);
            }
            let is_event = self.hybrid.due.is_some();
            let is_renewal = renewal.is_some() && !is_event && goal.minus(self.hybrid.time).value() <= 0.0;
            let is_knot = is_renewal || matches!(self.hybrid.due, Some(Due::Knot | Due::Sample));
            if is_renewal {
                self.hybrid.due = Some(Due::Renewal);
                match pause {
                    Pause::AtFlightEnd => return Ok(Reached::Event),
                    _ => self.pass_event(observer)?,
                }
            } else if is_event {
                if !matches!(pause, Pause::BeforeEvent | Pause::AtFlightEnd) {
                    self.pass_event(observer)?;
                }
                if pause != Pause::Never {
                    return Ok(Reached::Event);
                }
            }
            // Knots and resets of signals are finite in number and do not count as work. The
            // length of a series with curved forces follows from its remainder. A flight without
            // an event makes progress, however short its series are.
            let is_series = self.table().is_curved() && !is_event;
            work -= f64::from(u8::from(!is_knot && !is_series));
            work += WORK.1 * (self.time() - from) / self.full_length();
            from = self.time();
            if work < 0.0 {
                return Err(self.too_many(sub_steps + 1, began));
            }
        }
        Err(self.too_stiff(self.most_work))
    }

    /// Length of a sub-step without an event, s; with curved forces, the length of the last
    /// series.
    pub(super) fn full_length(&self) -> f64 {
        if self.table().is_curved() { self.scratch.ahead.span } else { self.table().length }
    }

    /// Advances by a sub-step towards `goal`, or to the event at its end. If `keeps` is true, the
    /// signals at the goal keep their advanced values.
    #[inline(always)]
    fn substep(&mut self, goal: DoubleDouble, [at_knot, keeps]: [bool; 2]) -> Result<Option<Due>, Error> {
        let left = goal.minus(self.hybrid.time).value();
        let flown = if self.table().is_dense() {
            Some(self.by_tables(goal, at_knot))
        } else {
            self.by_series(goal, at_knot)
        };
        let Some(Flown { place, dt, whole, reaches }) = flown else { return Err(self.too_large()) };
        self.hybrid.time = if reaches { goal } else { self.hybrid.time.plus(dt) };
        let progresses = dt > PROGRESS * self.full_length();
        if progresses {
            self.hybrid.chain = 0;
        }
        let knot = reaches && at_knot;
        let carried = self.hybrid.carried % RENEW;
        self.hybrid.carried = if place.is_some() { 0 } else { carried + u32::from(whole) };
        self.hybrid.turns = self.hybrid.turns % RENEW + 1;
        let carries = whole || place.is_some();
        if !(reaches && keeps) && (!carries || self.hybrid.turns == RENEW) {
            self.refill();
        }
        self.include_state();
        self.check_domains()?;
        if self.table().is_curved() && place.is_none() && self.scratch.ahead.span < left {
            self.check_series(self.scratch.ahead.span, left)?;
        }
        self.keep_contacts();
        if let Some(place) = place {
            let watch = self.table().watched[place].watch;
            self.hybrid.chain += 1;
            self.hybrid.last = Some(watch);
            if self.hybrid.chain > CHAIN * (self.hybrid.departing.len() + 1) {
                return Err(self.stuck("the modes change without end"));
            }
            return Ok(Some(Due::Passage(watch)));
        }
        self.watch_again(progresses);
        Ok(knot.then_some(Due::Knot))
    }

    /// Flies a sub-step of at most the table's length by the mode's stored tables.
    #[inline(always)]
    fn by_tables(&mut self, goal: DoubleDouble, at_knot: bool) -> Flown {
        let Self { tables, place, hybrid, scratch, assembly, .. } = self;
        let met = tables.at(*place);
        let table = &*met.table;
        let remaining = goal.minus(hybrid.time).value();
        scratch.interval = None;
        let Scratch { rates, second, heads, .. } = scratch;
        table.look_ahead(hybrid.z.as_slice(), [rates, second], heads);
        let flight = PassageSearch { table, hybrid };
        let span = flight.within_reach(table.length.min(remaining), &scratch.heads);
        let mut passage = flight.first_passage(span, scratch);
        if at_knot && span >= remaining {
            let knot = (span, goal.value());
            passage = passage.filter(|passage| !flight.is_at_knot(passage, knot, scratch));
        }
        let whole = span == table.length && passage.is_none();
        let end = passage.as_ref().map_or_else(|| StepPoint::end(span, table), |p| p.at);
        let dt = if passage.is_none() { span } else { end.time(table) };
        // An event function that was zero throughout the mode has no event: it is now watched.
        let leaves = passage.as_ref().is_some_and(|passage| flight.is_unwatched(passage.place));
        let passage = passage.filter(|_| !leaves);
        let reaches = passage.is_none() && !leaves && span >= remaining;
        if let Scratch { near, touches: Some(touches), .. } = scratch {
            let goes_on = passage.is_none() && !(at_knot && reaches);
            flight.note_touches(near, (end, goes_on), touches);
        }
        if hybrid.energy.are_kept() {
            let samples = Samples::Start(hybrid.z.as_slice(), dt / table.length);
            hybrid.energy.add(met.powers(&assembly.system), dt, &samples, &mut scratch.values);
        }
        let Scratch { start, interval, ahead, rates, second, .. } = scratch;
        let z = hybrid.z.as_mut_slice();
        if whole {
            table.at_end(z, [rates, second], start.as_mut_slice());
            std::mem::swap(&mut hybrid.z, start);
        } else {
            let start = start.as_mut_slice();
            if *interval != Some(end.interval) {
                table.at_interval_start(end.interval, z, start);
            }
            table.within(start, end.dt, at_knot, ahead, z);
            if passage.is_some() {
                assembly.system.signals.carry_within(start, end.dt, z);
            }
        }
        Flown { place: passage.map(|passage| passage.place), dt, whole, reaches }
    }

    /// Flies a sub-step by one series of the actual state; the series ends a little after the
    /// predicted event. `None` if the curved forces are so large that no length of the series is
    /// proved.
    #[inline(always)]
    fn by_series(&mut self, goal: DoubleDouble, at_knot: bool) -> Option<Flown> {
        let Self { tables, place, hybrid, scratch, assembly, .. } = self;
        let met = tables.at(*place);
        let table = &*met.table;
        let remaining = goal.minus(hybrid.time).value();
        let flight = PassageSearch { table, hybrid };
        let ahead = &mut scratch.ahead;
        let leaving = |place: usize| (flight.order(place), flight.short_limit(place));
        ahead.find(table, hybrid.z.as_slice(), remaining, leaving);
        if ahead.span == 0.0 {
            return None;
        }
        let part = flight.part_within_reach(ahead);
        let is_end = part == 1.0 && ahead.span == remaining;
        let mut passage = flight.passage_ahead(part, ahead);
        if at_knot && is_end {
            let knot = (part, goal.value());
            passage = passage.filter(|passage| !flight.is_at_knot_ahead(*passage, knot, ahead));
        }
        let leaves = passage.is_some_and(|(_, place)| flight.is_unwatched(place));
        let part = passage.map_or(part, |(part, _)| part);
        let place = passage.filter(|_| !leaves).map(|(_, place)| place);
        let dt = part * ahead.span;
        let reaches = passage.is_none() && is_end;
        if let Some(touches) = &mut scratch.touches {
            flight.note_touches_ahead((part, passage.is_none() && !(at_knot && reaches)), ahead, touches);
        }
        if hybrid.energy.are_kept() {
            let powers = met.powers(&assembly.system);
            let rule = if table.is_curved() { Rule::Twelve } else { Rule::of(table.rate * dt) };
            let first = powers.first(assembly.system.coordinates);
            match rule {
                Rule::Eight => ahead.series.at_nodes(&EIGHT, part, first, &mut scratch.nodes),
                Rule::Twelve => ahead.series.at_nodes(&NODES, part, first, &mut scratch.nodes),
            }
            let samples = Samples::Coordinates(&scratch.nodes, rule);
            hybrid.energy.add(powers, dt, &samples, &mut scratch.values);
        }
        ahead.series.at(part, hybrid.z.as_mut_slice());
        assembly.system.fill_curved(hybrid.z.as_mut_slice());
        // The length of a series with curved forces follows from its remainder.
        let is_full = if table.is_curved() { !is_end } else { ahead.span >= table.length };
        let whole = passage.is_none() && part == 1.0 && is_full;
        Some(Flown { place, dt, whole, reaches })
    }

    /// Prepares the next sub-step, at whose start event functions are no longer at zero. If the
    /// last sub-step was as short as the rounding of time, this does not apply: the signs of
    /// values are still rounding. Event functions that are zero throughout the mode stay so unless
    /// they exceed their rounding.
    #[inline(always)]
    pub(super) fn watch_again(&mut self, progresses: bool) {
        let Hybrid { departing, z, sizes, .. } = &mut self.hybrid;
        let mut any_leaves = false;
        for (order, w) in departing.iter_mut().zip(&self.tables.at(self.place).table.watched) {
            if *order == ORDERS {
                any_leaves |= w.row.dot(z.as_slice()).abs() > LEAVES_ZERO * sizes.zero_of(&w.row);
            } else if progresses {
                *order = 0;
            }
        }
        if any_leaves {
            self.rewatch_departed();
        }
    }

    /// Watches event functions again that exceed their rounding. Sizes then include the time since
    /// the mode began, as a body at rest has no size of its own.
    #[inline(never)]
    fn rewatch_departed(&mut self) {
        self.include_flight();
        let Hybrid { departing, z, sizes, .. } = &mut self.hybrid;
        for (order, w) in departing.iter_mut().zip(&self.tables.at(self.place).table.watched) {
            if *order == ORDERS && w.row.dot(z.as_slice()).abs() > LEAVES_ZERO * sizes.zero_of(&w.row) {
                *order = 0;
            }
        }
    }
}

/// Outcome of a sub-step.
struct Flown {
    /// Index of the event function that passes zero at the end.
    place: Option<usize>,
    /// Length, s.
    dt: f64,
    /// Whether it had the full length of the mode's sub-steps.
    whole: bool,
    /// Whether it has reached its goal.
    reaches: bool,
}

/// A sub-step, compiled for each vector instruction set of a computer. Products are not fused, so
/// that all give the same bits.
struct Substep<'a> {
    motion: &'a mut Motion,
    goal: DoubleDouble,
    /// Whether the goal is a knot, and whether signals are reset there.
    at: [bool; 2],
}

impl pulp::WithSimd for Substep<'_> {
    type Output = Result<Option<Due>, Error>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        self.motion.substep(self.goal, self.at)
    }
}
