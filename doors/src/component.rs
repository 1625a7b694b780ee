//! How a component lives and steps, as the doors ask for it.

use crate::events::{Advance, Handled, Piece, StepOutcome, StepReason};
use crate::life::{Experiment, Phase};
use crate::log::Log;
use crate::model::Model;
use crate::problem::{Problem, Refusal};
use std::fmt::Debug;

/// The life and the steps of a component: what a host may do with what the component is
/// ([`Model`]).
///
/// Which call is allowed in which state of which version is the doors' to say; they check
/// arguments, keep saved states, and turn outcomes into statuses and messages. A component keeps a
/// [`Life`](crate::Life); what it does not offer it leaves out, since the defaults refuse by name.
///
/// A simulation with events implements [`Hybrid`](crate::hybrid::Hybrid) instead and gets all of
/// this. For others:
///
/// - anything: [`exit_initialization`](Self::exit_initialization);
/// - Co-Simulation: [`advance`](Self::advance);
/// - events: [`handle_events`](Self::handle_events);
/// - Model Exchange: [`set_time`](Self::set_time) and the continuous states of [`Model`];
/// - intermediate update: [`INTERMEDIATE_UPDATE`](Self::INTERMEDIATE_UPDATE),
///   [`begin_pieces`](Self::begin_pieces) and what follows it.
#[allow(unused_variables)] // of the defaults
pub trait Component: Model {
    /// A step in progress that looks at its course; `()` without intermediate update.
    type Pieces: Debug;

    /// Whether steps ask the host's callback (`providesIntermediateUpdate`); otherwise it is never
    /// called.
    const INTERMEDIATE_UPDATE: bool = false;

    /// `fmi2SetupExperiment`, and what `fmi3EnterInitializationMode` says of it.
    ///
    /// # Errors
    /// As [`Experiment::new`].
    fn set_experiment(
        &mut self,
        tolerance: Option<f64>,
        start: f64,
        stop: Option<f64>,
    ) -> Result<(), Self::Problem> {
        self.life_mut().experiment = Some(Experiment::new(tolerance, start, stop)?);
        Ok(())
    }

    /// `fmi2EnterInitializationMode`, `fmi3EnterInitializationMode`: from now on outputs show the
    /// start.
    fn enter_initialization(&mut self) {
        self.life_mut().phase = Phase::Initialization;
    }

    /// `fmi2ExitInitializationMode`, `fmi3ExitInitializationMode`: the motion begins, by
    /// [`Life::begin`](crate::Life::begin).
    ///
    /// # Errors
    /// When start values or parameters are not possible; it stays in initialization.
    fn exit_initialization(&mut self, log: &mut dyn Log) -> Result<(), Self::Problem>;

    /// `fmi2Terminate`, `fmi3Terminate`.
    fn terminate(&mut self) {
        self.life_mut().phase = Phase::Terminated;
    }

    /// An error has ended it (FMI 3.0.2, 2.3.1). Nothing else has changed, so that what was shown
    /// of an event that was not carried out is not shown any more.
    fn fail(&mut self) {
        self.life_mut().phase = Phase::Terminated;
    }

    // Events

    /// `fmi2EnterEventMode`, `fmi3EnterEventMode`: the host comes to handle an event; there need
    /// not be one.
    ///
    /// # Errors
    /// By default none.
    fn enter_event(&mut self) -> Result<(), Self::Problem> {
        self.life_mut().phase = Phase::Event;
        Ok(())
    }

    /// `fmi2NewDiscreteStates`, `fmi3UpdateDiscreteStates`: carries out what is due at the present
    /// instant, all in one call, and tells what has changed.
    ///
    /// # Errors
    /// When what was set is not possible; nothing has changed then.
    fn handle_events(&mut self, log: &mut dyn Log) -> Result<Handled, Self::Problem> {
        Ok(Handled::default())
    }

    /// `fmi3EnterStepMode`, `fmi3EnterContinuousTimeMode`: the motion goes on, by [`Life::go_on`](crate::Life::go_on).
    ///
    /// # Errors
    /// By default none.
    fn leave_event(&mut self, log: &mut dyn Log) -> Result<(), Self::Problem> {
        self.life_mut().go_on();
        Ok(())
    }

    // Co-Simulation

    /// `fmi3DoStep`: from the present time towards `point + size`. Own time is the truth; `point`
    /// may be off by rounding ([`Life::check_step`](crate::Life::check_step)). What happens at an event inside is agreed by
    /// [`EventHandling`](crate::EventHandling).
    ///
    /// # Errors
    /// When the step was not carried out at all; it stands where it stood. By default always.
    fn advance(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Result<Advance, Self::Problem> {
        not_offered("Co-Simulation")
    }

    /// `fmi2DoStep`: [`advance`](Self::advance) for a host that knows nothing of events. Where it ends
    /// early, the phase is then [`Phase::StoppedEarly`].
    ///
    /// # Errors
    /// As [`advance`](Self::advance).
    fn step(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Result<StepOutcome, Self::Problem> {
        let Advance { time, early, .. } = self.advance(point, size, log)?;
        if early {
            self.life_mut().phase = Phase::StoppedEarly;
        }
        Ok(StepOutcome { time, reason: if early { StepReason::Stopped } else { StepReason::EndReached } })
    }

    // Model Exchange

    /// `fmi2EnterContinuousTimeMode`: the host's solver goes on from here.
    ///
    /// # Errors
    /// When what was set at the event is not possible; it stands at the event then. By default
    /// none.
    fn enter_continuous(&mut self) -> Result<(), Self::Problem> {
        self.life_mut().phase = Phase::Continuous;
        Ok(())
    }

    /// `fmi2CompletedIntegratorStep`, `fmi3CompletedIntegratorStep`: whether the host must enter
    /// Event Mode.
    ///
    /// # Errors
    /// By default none.
    fn complete_integrator_step(&mut self) -> Result<bool, Self::Problem> {
        Ok(false)
    }

    /// `fmi2SetTime`, `fmi3SetTime`.
    ///
    /// # Errors
    /// A time that is not possible; by default always.
    fn set_time(&mut self, time: f64) -> Result<(), Self::Problem> {
        not_offered("Model Exchange")
    }

    // A step in pieces from event to event, for a host that looks into it, sets inputs for its
    // course, or ends it early.

    /// Begins a step as [`advance`](Self::advance) would make it.
    ///
    /// # Errors
    /// As [`advance`](Self::advance), nothing having changed; by default always.
    fn begin_pieces(&mut self, point: f64, size: f64) -> Result<Self::Pieces, Self::Problem> {
        not_offered("intermediate update")
    }

    /// The time from here to the step's end, s.
    fn left(&self, pieces: &Self::Pieces) -> f64 {
        0.0
    }

    /// Lets an input follow the cubic through `values` at 0, 1/3, 2/3 and 3/3 of the next `span` s.
    fn interpolate_input(&mut self, reference: u32, values: [f64; 4], span: f64) {}

    /// Lets an input hold a value from here on.
    fn hold_input(&mut self, reference: u32, value: f64) {}

    /// Takes over what was set; where that is an event of its own, the step of a host that handles
    /// events ends here.
    ///
    /// # Errors
    /// For what is not possible; the step has been taken back then. By default always.
    fn start_pieces(&mut self, pieces: &mut Self::Pieces, log: &mut dyn Log) -> Result<Piece, Self::Problem> {
        not_offered("intermediate update")
    }

    /// To the next event, or to `until` (s; the step's end without it) if none comes before.
    ///
    /// # Errors
    /// As [`advance`](Self::advance); the step has been taken back then. By default always.
    fn next_piece(
        &mut self,
        pieces: &mut Self::Pieces,
        until: Option<f64>,
        log: &mut dyn Log,
    ) -> Result<Piece, Self::Problem> {
        not_offered("intermediate update")
    }

    /// Whether a step that meets an event ends before its law.
    fn ends_before_event(&self, pieces: &Self::Pieces) -> bool {
        false
    }

    /// Applies the law of the event before which the last piece has ended; true where the step ends
    /// after it.
    fn pass_event(&mut self, pieces: &mut Self::Pieces, log: &mut dyn Log) -> bool {
        true
    }

    /// Ends the step where it stands.
    fn end_pieces(&mut self, pieces: &Self::Pieces) -> Advance {
        Advance { time: self.time(), event: false, early: false }
    }

    /// As before [`begin_pieces`](Self::begin_pieces).
    ///
    /// # Errors
    /// As [`restore`](Model::restore); by default always.
    fn take_pieces_back(&mut self, pieces: &Self::Pieces) -> Result<(), Self::Problem> {
        not_offered("intermediate update")
    }
}

/// Refuses by name.
pub(crate) fn not_offered<T, P: Refusal>(what: &'static str) -> Result<T, P> {
    Err(Problem::NotOffered { what }.into())
}
