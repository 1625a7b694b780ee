//! What a Rust type must be able to do to be exported as an FMU.

use crate::events::{Advance, EarlyEnd, Handled, Piece, StepOutcome, StepReason};
use crate::instantiation::{Instantiation, Named};
use crate::life::{Experiment, Life, Phase};
use crate::log::Log;
use crate::problem::{Problem, Refusal};
use crate::values::{Bases, Dependency};
use std::fmt::Debug;

/// A component that a host can set, step or integrate, read, save and restore: what an FMU is an
/// instance of.
///
/// Which call is allowed in which state of which version is the doors' to say; they check
/// arguments, keep saved states, and turn outcomes into statuses and messages. A component keeps a
/// [`Life`]; each of its methods checks everything it was given and only then changes anything, so
/// that a refused call leaves it as it was. What it does not offer it leaves out: the defaults
/// refuse by name.
///
/// What is offered, and what to write for it:
///
/// - anything: [`instantiate`](Self::instantiate), [`life`](Self::life),
///   [`life_mut`](Self::life_mut), [`variable`](Self::variable), [`get`](Self::get),
///   [`set`](Self::set), [`exit_initialization`](Self::exit_initialization),
///   [`reset`](Self::reset), [`time`](Self::time);
/// - Co-Simulation: [`advance`](Self::advance);
/// - events: [`handle_events`](Self::handle_events), [`next_event_time`](Self::next_event_time);
/// - Model Exchange: [`set_time`](Self::set_time),
///   [`set_continuous_states`](Self::set_continuous_states) and the getters beside them;
/// - saved states: [`save`](Self::save), [`restore`](Self::restore); as bytes
///   [`serialize`](Self::serialize), [`deserialize`](Self::deserialize);
/// - intermediate update: [`INTERMEDIATE_UPDATE`](Self::INTERMEDIATE_UPDATE),
///   [`begin_pieces`](Self::begin_pieces) and what follows it.
///
/// All values travel as `f64`: Integers and enumerations are exact in it, Booleans and clocks are 0
/// and 1. Which variables there are is asked of an instance, so that they may be known at
/// instantiation only. There are no String, Binary and structural variables, no input clocks and no
/// Scheduled Execution.
#[allow(unused_variables)] // of the defaults
pub trait Component: Sized + Debug + 'static {
    /// Why it refuses; [`Problem`] where it has nothing of its own to say.
    type Problem: Refusal;
    /// Everything it needs to continue from somewhere; `()` where states cannot be saved.
    type State: Debug;
    /// A step in progress that looks at its course; `()` without intermediate update.
    type Pieces: Debug;

    /// More elements than this in one call are taken for a mistake, which keeps a wrong count from
    /// walking through the host's memory: above the largest number of values of one call, and of
    /// the bytes of a saved state.
    const MAX_COUNT: usize = 1 << 24;
    /// Whether steps ask the host's callback (`providesIntermediateUpdate`); otherwise it is never
    /// called.
    const INTERMEDIATE_UPDATE: bool = false;
    /// What messages say of a step of FMI 2.0 that ends early.
    const EARLY_END: EarlyEnd = EarlyEnd { event: "event", because: "" };

    // Making and life

    /// `fmi2Instantiate`, `fmi3Instantiate…`: a new instance with all variables at their start
    /// values.
    ///
    /// # Errors
    /// A token that is not this component's ([`Instantiation::check_token`]), resources that cannot
    /// be read, an interface type that is not offered.
    fn instantiate(request: &Instantiation<'_>) -> Result<Self, Self::Problem>;

    /// Its dealings with the host.
    fn life(&self) -> &Life;

    /// The same, to be changed.
    fn life_mut(&mut self) -> &mut Life;

    /// Tells what is worth knowing about the way in which it was made.
    fn tell_at_instantiation(&self, log: &mut dyn Log) {}

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
    /// [`Life::begin`].
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

    /// Marks it unusable after a panic.
    fn break_down(&mut self) {
        self.life_mut().phase = Phase::Broken;
    }

    /// `fmi2Reset`, `fmi3Reset`: as just made.
    fn reset(&mut self);

    /// Present time, s; before initialization ends, the start.
    fn time(&self) -> f64;

    // Variables

    /// What a door must know of the variable of that reference.
    ///
    /// # Errors
    /// [`Problem::Reference`] when there is none.
    fn variable(&self, reference: u32) -> Result<Named<'_>, Self::Problem>;

    /// `fmi2Get…`, `fmi3Get…`: hands value `i` to `write`, those of the variables in their order,
    /// of an array in row-major order. No value is NaN or infinite.
    ///
    /// # Errors
    /// Before anything is written: a reference that is not of these types ([`Problem::Reference`]).
    fn get(
        &mut self,
        bases: Bases,
        references: &[u32],
        write: impl FnMut(usize, f64),
    ) -> Result<(), Self::Problem>;

    /// `fmi2Set…`, `fmi3Set…`: takes the value of variable `i` from `read`. All are checked before
    /// the first is set.
    ///
    /// # Errors
    /// A wrong reference, a variable that cannot be set in this phase, a value outside its range.
    fn set(
        &mut self,
        bases: Bases,
        references: &[u32],
        read: impl Fn(usize) -> f64,
    ) -> Result<(), Self::Problem>;

    /// `fmi2SetRealInputDerivatives` (`canInterpolateInputs`).
    ///
    /// # Errors
    /// By default always.
    fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), Self::Problem> {
        not_offered("derivatives of inputs")
    }

    /// `fmi2GetRealOutputDerivatives`, `fmi3GetOutputDerivatives` (`maxOutputDerivativeOrder`):
    /// hands derivative `i` to `write`.
    ///
    /// # Errors
    /// By default always.
    fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        write: impl FnMut(usize, f64),
    ) -> Result<(), Self::Problem> {
        not_offered("derivatives of outputs")
    }

    /// `fmi2GetDirectionalDerivative`, `fmi3GetDirectionalDerivative`: hands the derivative of
    /// unknown `i` along `seed` in the space of knowns to `write`.
    ///
    /// # Errors
    /// By default always.
    fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        write: impl FnMut(usize, f64),
    ) -> Result<(), Self::Problem> {
        not_offered("directional derivatives")
    }

    /// `fmi3GetAdjointDerivative`: hands the sum over the unknowns of seed times derivative with
    /// respect to known `k` to `write`; by default from directional derivatives.
    ///
    /// # Errors
    /// As [`directional_derivative`](Self::directional_derivative); a seed or a sum that is not
    /// finite. By default nothing is written then.
    fn adjoint_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        mut write: impl FnMut(usize, f64),
    ) -> Result<(), Self::Problem> {
        for (unknown, &part) in unknowns.iter().zip(seed) {
            if !part.is_finite() {
                let what = format!("seed of {}", self.variable(*unknown)?.name);
                return Err(Problem::value(what, part, "a finite number").into());
            }
        }
        let mut sums = vec![0.0; knowns.len()];
        for (known, sum) in knowns.iter().zip(&mut sums) {
            self.directional_derivative(unknowns, &[*known], &[1.0], |i, x| *sum += seed[i] * x)?;
            if !sum.is_finite() {
                let what = format!("adjoint derivative by {}", self.variable(*known)?.name);
                let allowed = "a finite number: seed and derivatives are too large together";
                return Err(Problem::value(what, *sum, allowed).into());
            }
        }
        sums.into_iter().enumerate().for_each(|(k, sum)| write(k, sum));
        Ok(())
    }

    /// `fmi3GetVariableDependencies`: what a variable depends on now.
    ///
    /// # Errors
    /// By default always.
    fn dependencies(&self, reference: u32) -> Result<Vec<Dependency>, Self::Problem> {
        not_offered("dependencies of variables at run time")
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

    /// The time of the next event, s, where it is known: a time event in Model Exchange, any event
    /// in Co-Simulation.
    fn next_event_time(&mut self) -> Option<f64> {
        None
    }

    /// `fmi3EnterStepMode`, `fmi3EnterContinuousTimeMode`: the motion goes on, by [`Life::go_on`].
    ///
    /// # Errors
    /// By default none.
    fn leave_event(&mut self, log: &mut dyn Log) -> Result<(), Self::Problem> {
        self.life_mut().go_on();
        Ok(())
    }

    // Co-Simulation

    /// `fmi3DoStep`: from the present time towards `point + size`. Own time is the truth; `point`
    /// may be off by rounding ([`Life::check_step`]). What happens at an event inside is agreed by
    /// [`EventHandling`](crate::EventHandling).
    ///
    /// # Errors
    /// When the step was not carried out at all; it stands where it stood. By default always.
    fn advance(&mut self, point: f64, size: f64, log: &mut dyn Log) -> Result<Advance, Self::Problem> {
        not_offered("Co-Simulation")
    }

    /// `fmi2DoStep`: the same for a host that knows nothing of events. Where it ends early, the
    /// phase is then [`Phase::StoppedEarly`].
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

    /// Number of continuous states.
    fn number_of_continuous_states(&self) -> usize {
        0
    }

    /// Number of event indicators.
    fn number_of_event_indicators(&self) -> usize {
        0
    }

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

    /// `fmi2SetContinuousStates`, `fmi3SetContinuousStates`: as many as there are.
    ///
    /// # Errors
    /// States that are not possible, nothing having changed; by default always.
    fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), Self::Problem> {
        not_offered("continuous states")
    }

    /// `fmi2GetContinuousStates`, `fmi3GetContinuousStates`.
    ///
    /// # Errors
    /// By default none, of none.
    fn continuous_states(&self) -> Result<impl AsRef<[f64]>, Self::Problem> {
        Ok([])
    }

    /// `fmi2GetDerivatives`, `fmi3GetContinuousStateDerivatives`.
    ///
    /// # Errors
    /// By default none, of none.
    fn state_derivatives(&self) -> Result<impl AsRef<[f64]>, Self::Problem> {
        Ok([])
    }

    /// `fmi2GetEventIndicators`, `fmi3GetEventIndicators`: an event is where one changes its sign.
    ///
    /// # Errors
    /// By default none, of none.
    fn event_indicators(&self) -> Result<impl AsRef<[f64]>, Self::Problem> {
        Ok([])
    }

    /// `fmi2GetNominalsOfContinuousStates`, `fmi3GetNominalsOfContinuousStates`: positive numbers,
    /// 1 by default.
    fn nominals(&self) -> impl AsRef<[f64]> {
        vec![1.0; self.number_of_continuous_states()]
    }

    // Saved states

    /// `fmi2GetFMUstate`, `fmi3GetFMUState`: everything it needs to continue from here.
    ///
    /// # Errors
    /// By default always.
    fn save(&self) -> Result<Self::State, Self::Problem> {
        not_offered("saved states")
    }

    /// The same into the place of a saved state that is no longer wanted.
    ///
    /// # Errors
    /// As [`save`](Self::save).
    fn save_into(&self, place: &mut Self::State) -> Result<(), Self::Problem> {
        *place = self.save()?;
        Ok(())
    }

    /// `fmi2SetFMUstate`, `fmi3SetFMUState`: goes back to a saved state of this instance or one
    /// that was read from bytes; also where it was never initialized. Continuing gives the same
    /// bits as not having left.
    ///
    /// # Errors
    /// A state that does not fit, nothing having changed; by default always.
    fn restore(&mut self, saved: &Self::State) -> Result<(), Self::Problem> {
        not_offered("saved states")
    }

    /// `fmi2SerializeFMUstate`, `fmi3SerializeFMUState`.
    ///
    /// # Errors
    /// By default always.
    fn serialize(&self, saved: &Self::State) -> Result<Vec<u8>, Self::Problem> {
        not_offered("saved states as bytes")
    }

    /// `fmi2DeSerializeFMUstate`, `fmi3DeserializeFMUState`: any bytes may come.
    ///
    /// # Errors
    /// [`Problem::SavedState`] for bytes that are truncated, altered or of another build; by
    /// default always.
    fn deserialize(&self, bytes: &[u8]) -> Result<Self::State, Self::Problem> {
        not_offered("saved states as bytes")
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
    /// As [`restore`](Self::restore); by default always.
    fn take_pieces_back(&mut self, pieces: &Self::Pieces) -> Result<(), Self::Problem> {
        not_offered("intermediate update")
    }
}

/// Refuses by name.
fn not_offered<T, P: Refusal>(what: &'static str) -> Result<T, P> {
    Err(Problem::NotOffered { what }.into())
}
