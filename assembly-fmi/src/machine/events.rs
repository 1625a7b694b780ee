//! Steps and events.

use super::Machine;
use super::last_step::LastStep;
use super::moving::Moving;
use crate::problem::MachineProblem;
use fmi_doors::log::{Category, Log};
use fmi_doors::{Advance, EventHandling, Handled, Phase, Problem};
use vibro_assembly::Assembly;
use vibro_assembly::motion::{Event, EventKind, Reached};
use vibro_assembly::{Error, Motion};

/// What a step does at an event inside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum AtEvent {
    /// Applies its law and goes on.
    Pass,
    /// Ends before its law.
    EndBefore,
}

impl AtEvent {
    /// As it is agreed with the host.
    pub(super) fn of(handling: EventHandling) -> Self {
        if handling.event_mode && handling.early_return { Self::EndBefore } else { Self::Pass }
    }
}

/// What brings a motion back to where a step began.
pub(super) enum Undo {
    /// The motion itself, where another one goes on in its place.
    Other(Box<Moving>),
    /// The energy's origin; the rest was kept with the step's begin.
    Same(f64),
}

impl Machine {
    /// From the present time to `point + size`, or before the next event where the host handles
    /// events and takes steps that end early. Where it handles events but takes whole steps alone,
    /// what changes at events only stays as it was until then.
    pub(super) fn go(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Result<Advance, MachineProblem> {
        let own = fmi_doors::Component::time(self);
        self.life.check_step(point, size, own)?;
        // Own time may be past the end by the rounding that `point` is allowed: then nothing is
        // left to do.
        let end = (point + size).max(own);
        let handling = self.life.handling;
        let shown = self.moving.as_ref().filter(|_| handling.event_mode).map(Moving::discrete);
        let undo = self.begin_step(end)?;
        let events = match &mut self.moving {
            Some(moving) => run(&mut moving.motion, end, AtEvent::of(handling), log),
            None => Ok(false),
        };
        let events = match events {
            Ok(events) => events,
            Err(error) => {
                self.undo(undo);
                return Err(error.into());
            }
        };
        self.end_taking_over();
        self.life.phase = Phase::Step;
        let event = handling.event_mode && events;
        self.latched = shown.filter(|_| event);
        let time = fmi_doors::Component::time(self);
        Ok(Advance { time, event, early: time < end })
    }

    /// Begins a step towards `end`: the motion takes over what was set, and where it begins is
    /// kept.
    ///
    /// # Errors
    /// As [`take_over`](Self::take_over); nothing has changed then.
    pub(super) fn begin_step(&mut self, end: f64) -> Result<Undo, MachineProblem> {
        let none = || Problem::Sequence { what: "the instance is not initialized".into() };
        self.matrices = None;
        // With changed parameters it is another motion that goes on.
        let changed = self.changed && self.ahead.is_none();
        let ahead = changed.then(|| self.taken_over(self.moving.as_ref().ok_or_else(none)?)).transpose()?;
        let ahead = ahead.or_else(|| self.ahead.take());
        let moving = self.moving.as_mut().ok_or_else(none)?;
        if let Some(ahead) = ahead {
            let (assembly, begin) = (ahead.motion.assembly().clone(), ahead.motion.save());
            self.last_step = Some(LastStep { assembly, begin, inputs: Vec::new(), end });
            return Ok(Undo::Other(Box::new(std::mem::replace(moving, ahead))));
        }
        let step = LastStep {
            assembly: moving.motion.assembly().clone(),
            begin: moving.motion.save(),
            inputs: self.pending.clone(),
            end,
        };
        let undo = Undo::Same(moving.origin);
        let taken = moving.set_inputs(&step.inputs);
        self.last_step = Some(step);
        match taken {
            Ok(()) => Ok(undo),
            Err(error) => {
                self.undo(undo);
                Err(error.into())
            }
        }
    }

    /// Goes back to where a step began, as if it had not.
    fn undo(&mut self, undo: Undo) {
        let step = self.last_step.take();
        match (undo, &mut self.moving, step) {
            (Undo::Other(moving), _, _) => self.moving = Some(*moving),
            (Undo::Same(origin), Some(moving), Some(step)) => {
                moving.motion.restore(&step.begin);
                moving.origin = origin;
            }
            _ => {}
        }
    }

    /// What was set has been taken over.
    pub(super) fn end_taking_over(&mut self) {
        self.pending.fill(None);
        self.changed = false;
    }

    /// Applies the law of the event at which it stands, and takes over inputs that were set.
    pub(super) fn handle(&mut self, log: &mut dyn Log) -> Result<Handled, MachineProblem> {
        (self.latched, self.matrices) = (None, None);
        let set = self.is_set();
        let due = |moving: &&Moving| moving.is_on_course() || moving.motion.is_event_due();
        let Some(mut next) = self.moving.as_ref().filter(|moving| set || due(moving)).cloned() else {
            return Ok(Handled::default());
        };
        let assembly = next.motion.assembly().clone();
        let states = next.handle(&mut |event| tell(&assembly, event, log))?;
        self.take_over(&mut next)?;
        self.pending.fill(None);
        (self.moving, self.ahead, self.changed) = (Some(next), None, false);
        Ok(Handled { states: states || set, nominals: false })
    }
}

/// Runs to a time; true where events were met.
pub(super) fn run(
    motion: &mut Motion,
    end: f64,
    at_event: AtEvent,
    log: &mut dyn Log,
) -> Result<bool, Error> {
    let assembly = motion.assembly().clone();
    let mut events = 0;
    let mut observe = |event: &Event| {
        events += 1;
        tell(&assembly, event, log);
    };
    match at_event {
        AtEvent::EndBefore => Ok(motion.advance_before_event(end, &mut observe)? == Reached::Event),
        AtEvent::Pass => {
            motion.advance_observed(end, &mut observe)?;
            Ok(events > 0)
        }
    }
}

/// Tells an event where that is wanted.
pub(super) fn tell(machine: &Assembly, event: &Event, log: &mut dyn Log) {
    if log.wants(Category::Events) {
        log.log(Category::Events, &in_words(machine, event));
    }
}

fn in_words(machine: &Assembly, event: &Event) -> String {
    let stop = |i: usize| machine.name_of_stop(i);
    let friction = |i: usize| machine.name_of_friction(i);
    let text = match event.kind {
        EventKind::Impact { stop: i, speed, impulse, .. } => {
            format!("{} is hit, closing with {speed} (SI), impulse {impulse} (SI)", stop(i))
        }
        EventKind::Close { stop: i } => format!("{} closes", stop(i)),
        EventKind::Open { stop: i } => format!("{} opens", stop(i)),
        EventKind::Press { stop: i, speed } => format!("{} is pressed, closing with {speed} (SI)", stop(i)),
        EventKind::Free { stop: i } => format!("{} is free", stop(i)),
        EventKind::Cap { stop: i, acts } => {
            format!(
                "{} {}",
                stop(i),
                if acts { "comes to its dashpot's cap" } else { "leaves its dashpot's cap" }
            )
        }
        EventKind::Stick { friction: i } => format!("{} sticks", friction(i)),
        EventKind::Slip { friction: i, direction, .. } => {
            format!("{} slips {}", friction(i), if direction > 0.0 { "upwards" } else { "downwards" })
        }
        EventKind::Level { friction: i, acts } => {
            format!("{} {}", friction(i), if acts { "acts" } else { "no longer acts" })
        }
        EventKind::Knot => "a signal's knot".into(),
    };
    format!("{text} at t = {} s", event.time)
}
