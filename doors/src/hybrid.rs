//! The hybrid layer: from a simulation with events to a [`Component`](crate::Component).
//!
//! ```text
//! Component   life, steps, event mode, intermediate update, time of a host's solver: here, once
//!     ▲
//!   Hybrid    one motion: take over what was set, run to a time or before an event, apply its law
//!     ▲
//!   Model     variables, continuous states, saved states
//! ```
//!
//! A simulation alternates between a smooth motion and events, at each of which a law changes it at
//! once. A host sees that in one of four ways, by what it has agreed to ([`AtEvent`]): the step
//! goes over the event, ends after it, ends before its law, or goes over it while the host is shown
//! what changes at events only from the event's handling on. How a step begins, is taken back, is
//! cut into pieces and ends is the same for every simulation; what differs is [`Hybrid`].
//!
//! Two orders must stay. A step keeps where it began before it takes over what was set. In a whole
//! step what was set counts as taken over after the run, which may fail; in a step in pieces at
//! once, since the host may read what follows from it, and the state saved before takes it back.
//!
//! To change what a step does at an event: [`AtEvent`], the function `whole` of `steps.rs` and
//! [`Pieces`]; every component follows. A new function of [`Hybrid`] gets a default that leaves the
//! components as they are.

mod pieces;
pub(crate) mod steps;

pub use pieces::Pieces;
pub use steps::{AtEvent, Ended, Met, StepEnd, Until};

use crate::events::Handled;
use crate::log::Log;
use crate::model::Model;
use crate::problem::not_offered;
use std::fmt::Debug;

/// A simulation with events, from which the layer makes a [`Component`](crate::Component).
///
/// Required are the motion's start, its run to a time or before an event, the law of an event, and
/// what was set: [`start`](Self::start), [`take_over`](Self::take_over), [`run`](Self::run),
/// [`undo`](Self::undo), [`apply_law`](Self::apply_law), [`carry_out`](Self::carry_out). The rest
/// has defaults.
#[allow(unused_variables)] // of the defaults
pub trait Hybrid: Model {
    /// What changes at events only, as a host sees it; `()` where nothing does.
    type Shown: Clone + Debug;
    /// What brings it back to where a step began.
    type Undo: Debug;

    /// By how many units in the last place of a step's end an event may come before it and still be
    /// at it.
    const ROUNDING: f64 = 0.0;

    /// What was computed of the start no longer holds: the experiment has been given.
    fn forget(&mut self) {}

    /// The motion begins from the start values.
    ///
    /// # Errors
    /// Where these are not possible; nothing has changed then.
    fn start(&mut self, log: &mut dyn Log) -> Result<(), Self::Problem>;

    /// Whether a step from `point` (s) over `size` (s) can be made at all.
    ///
    /// # Errors
    /// By default as [`Life::check_step`](crate::Life::check_step).
    fn check(&self, point: f64, size: f64) -> Result<(), Self::Problem> {
        Ok(self.life().check_step(point, size, self.time())?)
    }

    /// Whether a step that may end early does so at an event; by default where the host handles
    /// events.
    fn ends_at_events(&self) -> bool {
        self.life().handling.event_mode
    }

    /// At the begin of a step: keeps where it begins, and takes over what was set. True where that
    /// has been an event of its own.
    ///
    /// # Errors
    /// For what is not possible; nothing has changed then.
    fn take_over(&mut self, end: StepEnd, log: &mut dyn Log) -> Result<(Self::Undo, bool), Self::Problem>;

    /// What was set has been taken over for good.
    fn taken_over(&mut self) {}

    /// Moves on to `end` or to an event before it, and applies the laws of the events that it goes
    /// over.
    ///
    /// # Errors
    /// Where the motion cannot go on; [`undo`](Self::undo) is called then.
    fn run(&mut self, end: StepEnd, until: Until, log: &mut dyn Log) -> Result<Met, Self::Problem>;

    /// Goes back to where the step began, for a problem that it returns, or that it could not go
    /// back.
    fn undo(&mut self, undo: Self::Undo, problem: Self::Problem) -> Self::Problem;

    /// Applies the law of the event that is due.
    ///
    /// # Errors
    /// Where there is no motion after it; it stands before the law then.
    fn apply_law(&mut self, log: &mut dyn Log) -> Result<(), Self::Problem>;

    /// What changes at events only, as it is now.
    fn shown(&self) -> Self::Shown;

    /// Shows what changes at events only as it was, until the host handles events; `None` ends it.
    fn latch(&mut self, shown: Option<Self::Shown>) {}

    /// A step has ended, whose inputs may have followed polynomials.
    fn end_step(&mut self, ended: Ended) {}

    /// Lets an input follow a polynomial from here on: value and time derivatives 1 to 3.
    fn set_input(&mut self, reference: u32, polynomial: [f64; 4]) {}

    /// The host comes to an event: what changes at events only is shown from now on.
    fn begin_event(&mut self) {
        self.latch(None);
    }

    /// `fmi2NewDiscreteStates`, `fmi3UpdateDiscreteStates`: applies the law where one is due at the
    /// present instant, and takes over what was set, all in one call.
    ///
    /// # Errors
    /// When what was set is not possible; nothing has changed then.
    fn carry_out(&mut self, log: &mut dyn Log) -> Result<Handled, Self::Problem>;

    /// The motion goes on from the event; without a log in FMI 2.0.
    ///
    /// # Errors
    /// When what was set at the event is not possible; it stands at the event then.
    fn go_on(&mut self, log: Option<&mut dyn Log>) -> Result<(), Self::Problem> {
        Ok(())
    }

    /// The simulation ends; by an error where it has `failed`.
    fn end(&mut self, failed: bool) {}

    /// Goes to a time of the host's solver, s, which is finite.
    ///
    /// # Errors
    /// A time that is not possible; by default always.
    fn put_time(&mut self, time: f64) -> Result<(), Self::Problem> {
        not_offered("Model Exchange")
    }

    /// Accepts the present point of the host's solver; true where it has passed over an event.
    ///
    /// # Errors
    /// By default none.
    fn accept(&mut self) -> Result<bool, Self::Problem> {
        Ok(false)
    }
}
