//! The motion of a described machine: steps, events, and the time of a host's solver.

use super::Machine;
use super::events::tell;
use super::last_step::LastStep;
use super::moving::{Moving, Shown};
use crate::problem::MachineProblem;
use crate::table::Quantity;
use fmi_doors::hybrid::{Ended, Met, StepEnd, Until};
use fmi_doors::log::Log;
use fmi_doors::{Bases, Handled, Hybrid, Interface, Model, Problem};
use vibro_machine::motion::{Event, Reached};

/// Data that restore the motion at the beginning of a step.
#[derive(Debug)]
pub enum Undo {
    /// The motion itself, if another motion has replaced it.
    Other(Box<Moving>),
    /// The origin of the energy balance, J; `last_step` holds the other data.
    Same(f64),
}

/// The problem of a call before the end of initialization: the motion does not exist yet.
fn none() -> Problem {
    Problem::Sequence { what: "the instance is not initialized".into() }
}

impl Hybrid for Machine {
    type Shown = Shown;
    type Undo = Undo;

    fn forget(&mut self) {
        self.ahead = None;
    }

    fn start(&mut self, _: &mut dyn Log) -> Result<(), MachineProblem> {
        self.present()?;
        self.moving = self.ahead.take();
        self.pending.fill(None);
        Ok(())
    }

    fn take_over(&mut self, end: StepEnd, _: &mut dyn Log) -> Result<(Undo, bool), MachineProblem> {
        let end = end.value().max(self.time());
        self.matrices = None;
        // If parameters have changed, another motion replaces the present one.
        let changed = self.changed && self.ahead.is_none();
        let ahead = changed.then(|| self.ahead_of(self.moving.as_ref().ok_or_else(none)?)).transpose()?;
        let ahead = ahead.or_else(|| self.ahead.take());
        let moving = self.moving.as_mut().ok_or_else(none)?;
        if let Some(ahead) = ahead {
            let (assembly, begin) = (ahead.motion.assembly().clone(), ahead.motion.save());
            self.last_step = Some(LastStep { assembly, begin, inputs: Vec::new(), end });
            return Ok((Undo::Other(Box::new(std::mem::replace(moving, ahead))), false));
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
            Ok(()) => Ok((undo, false)),
            Err(error) => Err(self.undo(undo, error.into())),
        }
    }

    fn taken_over(&mut self) {
        self.pending.fill(None);
        self.changed = false;
    }

    fn run(&mut self, end: StepEnd, until: Until, log: &mut dyn Log) -> Result<Met, MachineProblem> {
        self.matrices = None;
        let motion = &mut self.moving.as_mut().ok_or_else(none)?.motion;
        // The motion's time may exceed the end by the rounding of the host's time. Then nothing
        // remains to be done.
        let (end, assembly) = (end.value().max(motion.time()), motion.assembly().clone());
        let mut events = 0;
        let mut observe = |event: &Event| {
            events += 1;
            tell(&assembly, event, log);
        };
        if until == Until::Event {
            let due = motion.advance_before_event(end, &mut observe)? == Reached::Event;
            return Ok(Met { due, ..Met::default() });
        }
        motion.advance_observed(end, &mut observe)?;
        Ok(Met { events, ..Met::default() })
    }

    fn undo(&mut self, undo: Undo, problem: MachineProblem) -> MachineProblem {
        match (undo, &mut self.moving, self.last_step.take()) {
            (Undo::Other(moving), _, _) => self.moving = Some(*moving),
            (Undo::Same(origin), Some(moving), Some(step)) => {
                moving.motion.restore(&step.begin);
                moving.origin = origin;
            }
            _ => {}
        }
        problem
    }

    fn apply_law(&mut self, log: &mut dyn Log) -> Result<(), MachineProblem> {
        self.matrices = None;
        let motion = &mut self.moving.as_mut().ok_or_else(none)?.motion;
        let (assembly, before) = (motion.assembly().clone(), motion.save());
        motion.apply_event(&mut |event| tell(&assembly, event, log)).map_err(|error| {
            motion.restore(&before);
            error.into()
        })
    }

    fn shown(&self) -> Shown {
        self.moving.as_ref().map(Moving::discrete).unwrap_or_default()
    }

    fn latch(&mut self, shown: Option<Shown>) {
        (self.latched, self.matrices) = (shown, None);
    }

    /// Inputs that were polynomials in the step hold their present values after it.
    fn end_step(&mut self, ended: Ended) {
        self.ahead = None;
        for (i, pending) in self.pending.iter_mut().enumerate().filter(|_| ended.interpolated) {
            let now = self.moving.as_ref().map_or([0.0; 4], |moving| moving.motion.input(i));
            if now[1..] != [0.0; 3] {
                *pending = Some([now[0], 0.0, 0.0, 0.0]);
            }
        }
    }

    fn set_input(&mut self, reference: u32, polynomial: [f64; 4]) {
        let row = self.plan.table.row(reference, Bases::ANY);
        if let Ok(Quantity::Input(i)) = row.map(|row| row.quantity) {
            self.pending[i] = Some(polynomial);
            self.ahead = None;
        }
    }

    fn carry_out(&mut self, log: &mut dyn Log) -> Result<Handled, MachineProblem> {
        (self.latched, self.matrices) = (None, None);
        let set = self.is_set();
        let due = |moving: &&Moving| moving.is_on_course() || moving.motion.is_event_due();
        let Some(mut next) = self.moving.as_ref().filter(|moving| set || due(moving)).cloned() else {
            return Ok(Handled::default());
        };
        let assembly = next.motion.assembly().clone();
        let states = next.handle(&mut |event| tell(&assembly, event, log))?;
        self.give(&mut next)?;
        (self.moving, self.ahead) = (Some(next), None);
        self.taken_over();
        Ok(Handled { states: states || set, nominals: false })
    }

    /// In Model Exchange, values set at an event without an update of the discrete states now act.
    /// In Co-Simulation the next step takes them over.
    fn go_on(&mut self, _: Option<&mut dyn Log>) -> Result<(), MachineProblem> {
        if self.life.interface == Interface::CoSimulation {
            return Ok(());
        }
        let ahead = self.ahead.take();
        if let Some(moving) = self.moving.as_ref().filter(|_| self.is_set()) {
            self.moving = Some(ahead.map_or_else(|| self.ahead_of(moving), Ok)?);
            self.taken_over();
        }
        Ok(())
    }

    fn put_time(&mut self, time: f64) -> Result<(), MachineProblem> {
        let moving = self.moving.as_mut().ok_or_else(none)?;
        let course = moving.course.as_ref().ok_or_else(none)?;
        moving.motion.place_at(course, time);
        Ok(())
    }

    fn accept(&mut self) -> Result<bool, MachineProblem> {
        Ok(self.moving.as_mut().is_some_and(Moving::accept))
    }
}
