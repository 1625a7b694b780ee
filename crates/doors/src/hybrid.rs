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
//! A simulation alternates between smooth motion and events. At an event a law changes the motion
//! at once. The event handling agreed with the host decides what a step does at an event
//! ([`AtEvent`]): it passes over the event, ends after it, ends before its law, or passes over it
//! but shows the new values of the discrete outputs only when the host handles the event. The
//! start, the undoing, the pieces and the end of a step are the same for every simulation and are
//! implemented here. The parts that differ are [`Hybrid`].
//!
//! Two orders of calls are required. First, a step saves its beginning before it takes over the
//! values that were set. Second, a whole step calls [`taken_over`](Hybrid::taken_over) after the
//! run, since the run may fail. A step in pieces calls it immediately, since the host may read
//! dependent values; if the step fails, the state saved before it is restored.
//!
//! To change the behaviour of a step at an event, edit [`AtEvent`], the function `whole` of
//! `steps.rs` and [`Pieces`]; this changes every component. A new function of [`Hybrid`] gets a
//! default that leaves the components unchanged.

mod pieces;
pub(crate) mod steps;

pub use pieces::Pieces;
pub use steps::{AtEvent, Ended, Met, StepEnd, Until};

use crate::events::Handled;
use crate::log::Log;
use crate::model::Model;
use crate::problem::not_offered;
use std::fmt::Debug;

/// A simulation with events, which the layer turns into a [`Component`](crate::Component).
///
/// Required methods: [`start`](Self::start), [`take_over`](Self::take_over), [`run`](Self::run),
/// [`undo`](Self::undo), [`apply_law`](Self::apply_law), [`carry_out`](Self::carry_out). The other
/// methods have defaults.
#[allow(unused_variables)] // of the defaults
pub trait Hybrid: Model {
    /// The values that change at events only, as shown to a host; `()` if there are none.
    type Shown: Clone + Debug;
    /// Data that undo a step.
    type Undo: Debug;

    /// Tolerance for an event at a step's end, in units in the last place of the end: an event at
    /// most this long before the end counts as at the end.
    const ROUNDING: f64 = 0.0;

    /// Discards values computed for the start, since the experiment has been set.
    fn forget(&mut self) {}

    /// The motion begins from the start values.
    ///
    /// # Errors
    /// If the start values are not possible; then nothing has changed.
    fn start(&mut self, log: &mut dyn Log) -> Result<(), Self::Problem>;

    /// Whether a step from `point` (s) over `size` (s) is possible at all.
    ///
    /// # Errors
    /// The default has the errors of [`Life::check_step`](crate::Life::check_step).
    fn check(&self, point: f64, size: f64) -> Result<(), Self::Problem> {
        Ok(self.life().check_step(point, size, self.time())?)
    }

    /// Whether a step that may end early ends at an event. The default ends it if the host handles
    /// events.
    fn ends_at_events(&self) -> bool {
        self.life().handling.event_mode
    }

    /// Called at the beginning of a step: saves the beginning and takes over the values that were
    /// set. The flag is whether taking them over was an event.
    ///
    /// # Errors
    /// If a value that was set is not possible; then nothing has changed.
    fn take_over(&mut self, end: StepEnd, log: &mut dyn Log) -> Result<(Self::Undo, bool), Self::Problem>;

    /// Marks the values that were set as taken over.
    fn taken_over(&mut self) {}

    /// Advances to `end` or to an event before it, and applies the laws of the events that it
    /// passes.
    ///
    /// # Errors
    /// If the motion cannot continue; then [`undo`](Self::undo) is called.
    fn run(&mut self, end: StepEnd, until: Until, log: &mut dyn Log) -> Result<Met, Self::Problem>;

    /// Undoes the step because of `problem`. Returns `problem`, or a problem that states that
    /// undoing failed.
    fn undo(&mut self, undo: Self::Undo, problem: Self::Problem) -> Self::Problem;

    /// Applies the law of the event that is due.
    ///
    /// # Errors
    /// If no motion exists after the event; the component then stays before the law.
    fn apply_law(&mut self, log: &mut dyn Log) -> Result<(), Self::Problem>;

    /// Present values of the quantities that change at events only.
    fn shown(&self) -> Self::Shown;

    /// Shows the given earlier values of the quantities that change at events only, until the host
    /// handles events. `None` shows the present values again.
    fn latch(&mut self, shown: Option<Self::Shown>) {}

    /// Called at the end of a step. Inputs may have followed polynomials during the step.
    fn end_step(&mut self, ended: Ended) {}

    /// Lets an input follow a polynomial from now on: value and time derivatives 1 to 3.
    fn set_input(&mut self, reference: u32, polynomial: [f64; 4]) {}

    /// Called when the host enters an event. From now on the present values of the quantities that
    /// change at events only are shown.
    fn begin_event(&mut self) {
        self.latch(None);
    }

    /// `fmi2NewDiscreteStates`, `fmi3UpdateDiscreteStates`: applies the law of an event that is
    /// due at the present time, and takes over the values that were set, in one call.
    ///
    /// # Errors
    /// If a value that was set is not possible; then nothing has changed.
    fn carry_out(&mut self, log: &mut dyn Log) -> Result<Handled, Self::Problem>;

    /// The motion continues from the event. FMI 2.0 does not give a log.
    ///
    /// # Errors
    /// If a value that was set at the event is not possible; the component then stays at the
    /// event.
    fn go_on(&mut self, log: Option<&mut dyn Log>) -> Result<(), Self::Problem> {
        Ok(())
    }

    /// The simulation ends; `failed` is whether an error has ended it.
    fn end(&mut self, failed: bool) {}

    /// Sets the time to a finite time of the host's solver, s.
    ///
    /// # Errors
    /// If the time is not possible; by default always.
    fn put_time(&mut self, time: f64) -> Result<(), Self::Problem> {
        not_offered("Model Exchange")
    }

    /// Accepts the present point of the host's solver. Returns whether an event was passed.
    ///
    /// # Errors
    /// The default never fails.
    fn accept(&mut self) -> Result<bool, Self::Problem> {
        Ok(false)
    }
}
