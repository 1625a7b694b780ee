//! Advance of a motion from instant to instant, with everything in between observed.

use super::contacts::ContactRecorder;
use super::extremes::Extremes;
use super::flight::{Flow, Flows, ObservedFlight, Observer, Passage, follow};
use std::cell::Cell;
use vibro_machine::mode::Mode;
use vibro_machine::motion::Event;
use vibro_machine::system::System;
use vibro_machine::{Error, Motion};

/// Limit of the events in an advance: an initial number, and an addition for each sub-step of its
/// flights. The engine's own limit does not count across pauses.
const WORK: (f64, f64) = (20_000.0, 64.0);
/// Length of a flight, in stretches, up to which every stretch is observed.
const USUAL: f64 = 64.0;
/// Number of further stretches observed in a whole motion, some seconds of work. A machine with a
/// body far faster than all others needs more; this body is mostly at rest during them.
const MOST: f64 = 500_000.0;

/// Contacts and extremes of a motion.
///
/// The extremes are the motion's own, not the largest of some samples:
///
/// ```
/// use vibro_machine::{Assembly, Motion, Quantity, What, file};
/// use vibro_studies::{ContactRecorder, Extremes, Followed};
///
/// # let text = r#"
/// #     name = "Oscillator"
/// #     body.a = { mass = 1.0, start = { v = 6.0 } }
/// #     spring.k = { between = ["ground", "a"], stiffness = 4.0 }
/// # "#;
/// let machine = file::parse(text, "oscillator.toml", &file::no_records)?;
/// let mut motion = Motion::new(Assembly::new(machine)?.into())?;
/// let extremes = Extremes::new(&[Quantity::of_body(0, What::S)], (0.0, 1.0));
/// let mut followed = Followed::new(ContactRecorder::new(&motion, &[]), extremes);
/// followed.advance(&mut motion, 1.0, &mut |_| (), &mut |_| ())?;
/// assert!((followed.extremes.all[0].largest - 3.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Followed {
    /// Contacts of the motion.
    pub contacts: ContactRecorder,
    /// Extremes of quantities.
    pub extremes: Extremes,
    /// Duration of flights with only their ends observed, s.
    pub left_out: f64,
    /// Number of further stretches to observe.
    left: f64,
    mode: Option<Mode>,
    flows: Flows,
}

struct Tell<'a>(&'a mut dyn FnMut(&Event));

impl Observer for Tell<'_> {
    fn flight(&mut self, _: &System, _: ObservedFlight<'_>) {}
    fn passage(&mut self, _: &System, _: Passage<'_>) {}
    fn told(&mut self, event: &Event) {
        (self.0)(event);
    }
}

/// Counter of the remaining work of an advance.
struct WorkMeter<'a>(&'a Cell<f64>);

impl Observer for WorkMeter<'_> {
    fn flight(&mut self, _: &System, flight: ObservedFlight<'_>) {
        self.0.set(self.0.get() + WORK.1 * flight.flow.sub_steps_of(flight.span));
    }
    fn passage(&mut self, _: &System, _: Passage<'_>) {
        self.0.set(self.0.get() - 1.0);
    }
}

impl Followed {
    /// Starts the record of a motion.
    pub fn new(contacts: ContactRecorder, extremes: Extremes) -> Self {
        Self { contacts, extremes, left_out: 0.0, left: MOST, mode: None, flows: Flows::default() }
    }

    /// Advances to a time, bit-identical to [`Motion::advance_observed`]; `met` receives the time
    /// of each event.
    ///
    /// # Errors
    /// As [`Motion::advance_to`].
    pub fn advance(
        &mut self,
        motion: &mut Motion,
        end: f64,
        tell: &mut dyn FnMut(&Event),
        met: &mut dyn FnMut(f64),
    ) -> Result<(), Error> {
        let mut flows = std::mem::take(&mut self.flows);
        let done = self.follow(motion, &mut flows, end, tell, met);
        self.flows = flows;
        done
    }

    fn follow(
        &mut self,
        motion: &mut Motion,
        flows: &mut Flows,
        end: f64,
        tell: &mut dyn FnMut(&Event),
        met: &mut dyn FnMut(f64),
    ) -> Result<(), Error> {
        let work = Cell::new(WORK.0);
        let mut many = |events: &[Event]| {
            events.last().into_iter().for_each(|event| met(event.time));
            work.get() < 0.0
        };
        let mut teller = Tell(tell);
        let is_left = follow(motion, flows, end, &mut [&mut teller, &mut WorkMeter(&work), self], &mut many)?;
        let from = motion.time();
        if is_left {
            self.contacts.leave_out();
        }
        // Covers a remainder left by rounding of the clock, and returns the engine's own error
        // beyond the limit of work.
        let mut events: Vec<Event> = Vec::new();
        let rest = motion.advance_observed(end, &mut |event| {
            tell(event);
            met(event.time);
            events.push(event.clone());
        });
        if is_left {
            self.left_out += motion.time() - from;
        }
        let system = motion.assembly().system();
        events.chunk_by(|a, b| a.time == b.time).for_each(|now| self.contacts.meet(system, now, None));
        rest.map(drop)
    }

    fn enter(&mut self, system: &System, flow: &Flow) {
        if self.mode.as_ref() != Some(&flow.mode) {
            self.extremes.enter(system, flow);
            self.contacts.enter(system, flow);
            self.mode = Some(flow.mode.clone());
        }
    }
}

impl Observer for Followed {
    fn flight(&mut self, system: &System, flight: ObservedFlight<'_>) {
        self.enter(system, flight.flow);
        let beyond = flight.flow.stretches_of(flight.span) - USUAL;
        if beyond > self.left {
            self.left_out += flight.span;
            self.contacts.leave_out();
            self.extremes.state(flight.start, flight.time);
            return;
        }
        self.left -= beyond.max(0.0);
        let mut time = flight.time;
        flight.flow.stretches(flight.start, flight.span, &mut |series, length| {
            self.extremes.stretch(series, time, length);
            self.contacts.stretch(series, length);
            time += length;
        });
    }

    fn passage(&mut self, system: &System, passage: Passage<'_>) {
        self.contacts.meet(system, passage.events, Some(passage.lost));
        self.enter(system, passage.flows[1]);
        self.extremes.state(passage.states[1], passage.time);
    }
}

#[cfg(test)]
mod tests;
