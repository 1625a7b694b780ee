//! A step in pieces from event to event, for a host that looks into it, sets inputs for its course,
//! or ends it early.

use super::Machine;
use super::events::{AtEvent, run, tell};
use super::moving::Shown;
use crate::problem::MachineProblem;
use crate::saved_state::SavedState;
use crate::table::Quantity;
use fmi_doors::log::Log;
use fmi_doors::{Advance, Bases, Component, Phase, Piece, Problem};
use vibro_assembly::Error;
use vibro_assembly::motion::Event;
use vibro_assembly::signals::Input;

/// A step in progress.
#[derive(Debug)]
pub struct Pieces {
    end: f64,
    at_event: AtEvent,
    /// What was shown at the step's start of what changes at events only, where the host handles
    /// events.
    shown: Option<Shown>,
    /// Whether events were met so far.
    events: bool,
    /// Why the law of an event could not be applied; the step is then taken back.
    failed: Option<Error>,
    /// To take the step back.
    before: Box<SavedState>,
}

/// Value and derivatives at 0 of the cubic through `values` at 0, 1/3, 2/3 and 3/3 of `span`.
fn cubic([u0, u1, u2, u3]: [f64; 4], span: f64, time: f64) -> Input {
    // Newton's forward differences at the first value; three intervals to the span.
    let (first, second, third) = (u1 - u0, (u2 - u1) - (u1 - u0), (u3 - u2) - 2.0 * (u2 - u1) + (u1 - u0));
    let rate = 3.0 / span;
    let input = [
        u0,
        (first - 0.5 * second + third / 3.0) * rate,
        (second - third) * rate * rate,
        third * rate * rate * rate,
    ];
    // In a step of the length of rounding the differences say nothing.
    let says = span > f64::EPSILON * time.abs().max(1.0) && input.iter().all(|x| x.is_finite());
    if says { input } else { [u0, 0.0, 0.0, 0.0] }
}

impl Machine {
    pub(super) fn begin(&mut self, point: f64, size: f64) -> Result<Pieces, MachineProblem> {
        let own = self.time();
        self.life.check_step(point, size, own)?;
        self.present()?;
        let handling = self.life.handling;
        Ok(Pieces {
            end: (point + size).max(own),
            at_event: AtEvent::of(handling),
            shown: self.moving.as_ref().filter(|_| handling.event_mode).map(|moving| moving.discrete()),
            events: false,
            failed: None,
            before: Box::new(self.save()?),
        })
    }

    pub(super) fn left_of(&self, pieces: &Pieces) -> f64 {
        (pieces.end - self.time()).max(0.0)
    }

    fn input_of(&self, reference: u32) -> Option<usize> {
        match self.plan.table.row(reference, Bases::ANY).ok()?.quantity {
            Quantity::Input(i) => Some(i),
            _ => None,
        }
    }

    pub(super) fn interpolate(&mut self, reference: u32, values: [f64; 4], span: f64) {
        if let Some(i) = self.input_of(reference) {
            self.pending[i] = Some(cubic(values, span, self.time()));
            self.ahead = None;
        }
    }

    pub(super) fn hold(&mut self, reference: u32, value: f64) {
        if let Some(i) = self.input_of(reference) {
            self.pending[i] = Some([value, 0.0, 0.0, 0.0]);
            self.ahead = None;
        }
    }

    pub(super) fn start_course(&mut self, pieces: &mut Pieces) -> Result<Piece, MachineProblem> {
        if let Err(problem) = self.begin_step(pieces.end) {
            return Err(self.taken_back(pieces, problem));
        }
        self.end_taking_over();
        Ok(Piece::End)
    }

    pub(super) fn go_on(
        &mut self,
        pieces: &mut Pieces,
        until: Option<f64>,
        log: &mut dyn Log,
    ) -> Result<Piece, MachineProblem> {
        let failed = pieces.failed.take();
        let end = until.unwrap_or(pieces.end);
        let outcome = match (&mut self.moving, failed) {
            (_, Some(error)) => Err(error),
            (Some(moving), None) => run(&mut moving.motion, end, AtEvent::EndBefore, log),
            (None, None) => Ok(false),
        };
        self.matrices = None;
        match outcome {
            Ok(true) => Ok(Piece::Event),
            Ok(false) => Ok(Piece::End),
            Err(error) => Err(self.taken_back(pieces, error.into())),
        }
    }

    pub(super) fn ends_before(&self, pieces: &Pieces) -> bool {
        pieces.at_event == AtEvent::EndBefore
    }

    pub(super) fn pass(&mut self, pieces: &mut Pieces, log: &mut dyn Log) {
        let Some(moving) = &mut self.moving else { return };
        let (assembly, before) = (moving.motion.assembly().clone(), moving.motion.save());
        let mut observe = |event: &Event| tell(&assembly, event, log);
        if let Err(error) = moving.motion.apply_event(&mut observe) {
            moving.motion.restore(&before);
            pieces.failed = Some(error);
        }
        pieces.events = true;
        self.matrices = None;
        // What changes at events only stays as it was until the host has handled them.
        self.latched.clone_from(&pieces.shown);
    }

    /// Ends the step where it stands. Inputs that had a course hold their present values from here
    /// on.
    pub(super) fn end_course(&mut self, pieces: &Pieces) -> Advance {
        let time = self.time();
        if let Some(moving) = &self.moving {
            let event = pieces.shown.is_some() && (pieces.events || moving.motion.is_event_due());
            for (i, pending) in self.pending.iter_mut().enumerate() {
                let now = moving.motion.input(i);
                if now[1..] != [0.0; 3] {
                    *pending = Some([now[0], 0.0, 0.0, 0.0]);
                }
            }
            self.latched = pieces.shown.clone().filter(|_| event);
            self.life.phase = Phase::Step;
            self.ahead = None;
            return Advance { time, event, early: time < pieces.end };
        }
        Advance { time, event: false, early: false }
    }

    pub(super) fn take_back(&mut self, pieces: &Pieces) -> Result<(), MachineProblem> {
        self.restore(&pieces.before)
    }

    /// Takes a step back that has met a problem; the problem, or that the step could not be taken
    /// back.
    fn taken_back(&mut self, pieces: &Pieces, problem: MachineProblem) -> MachineProblem {
        match self.take_back(pieces) {
            Ok(()) => problem,
            Err(refused) => {
                let what = format!("{problem}; the step cannot be taken back: {refused}");
                Problem::Sequence { what: what.into() }.into()
            }
        }
    }
}
