//! What an FMU is an instance of, apart from how it moves: variables, continuous states, saved
//! states. How it moves is [`Hybrid`](crate::Hybrid).

use crate::events::EarlyEnd;
use crate::instantiation::{Instantiation, Named};
use crate::life::Life;
use crate::log::Log;
use crate::problem::{Refusal, not_offered};
use crate::values::{Bases, Dependency};
use std::fmt::Debug;

/// Variables, continuous states and saved states of a component.
///
/// Each method checks everything it was given and only then changes anything, so that a refused
/// call leaves the component as it was. What is not offered is left out: the defaults refuse by
/// name.
///
/// All values travel as `f64`: Integers and enumerations are exact in it, Booleans and clocks are 0
/// and 1. Which variables there are is asked of an instance, so that they may be known at
/// instantiation only. There are no String, Binary and structural variables, no input clocks and no
/// Scheduled Execution.
#[allow(unused_variables)] // of the defaults
pub trait Model: Sized + Debug + 'static {
    /// Why it refuses; [`Problem`](crate::Problem) where it has nothing of its own to say.
    type Problem: Refusal;
    /// Everything it needs to continue from somewhere; `()` where states cannot be saved.
    type State: Debug;

    /// More elements than this in one call are taken for a mistake, which keeps a wrong count from
    /// walking through the host's memory: above the largest number of values of one call, and of
    /// the bytes of a saved state.
    const MAX_COUNT: usize = 1 << 24;
    /// What messages say of a step of FMI 2.0 that ends early.
    const EARLY_END: EarlyEnd = EarlyEnd { event: "event", because: "" };

    /// `fmi2Instantiate`, `fmi3Instantiate…`: a new instance with all variables at their start
    /// values.
    ///
    /// # Errors
    /// A token that is not this component's ([`Instantiation::check_token`]), resources that cannot
    /// be read, an interface type that is not offered.
    fn instantiate(request: &Instantiation<'_>) -> Result<Self, Self::Problem>;

    /// Lifecycle state: interface type, phase, what was agreed with the host.
    fn life(&self) -> &Life;

    /// Lifecycle state, to be changed.
    fn life_mut(&mut self) -> &mut Life;

    /// Tells what is worth knowing about the way in which it was made.
    fn tell_at_instantiation(&self, log: &mut dyn Log) {}

    /// `fmi2Reset`, `fmi3Reset`: as just made.
    fn reset(&mut self);

    /// Present time, s; before initialization ends, the start.
    fn time(&self) -> f64;

    /// What a door must know of the variable of that reference.
    ///
    /// # Errors
    /// [`Problem::Reference`](crate::Problem::Reference) when there is none.
    fn variable(&self, reference: u32) -> Result<Named<'_>, Self::Problem>;

    /// `fmi2Get…`, `fmi3Get…`: hands value `i` to `write`, those of the variables in their order,
    /// of an array in row-major order. No value is NaN or infinite.
    ///
    /// # Errors
    /// Before anything is written: a reference that is not of these types
    /// ([`Problem::Reference`](crate::Problem::Reference)).
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

    /// `fmi3GetVariableDependencies`: what a variable depends on now.
    ///
    /// # Errors
    /// By default always.
    fn dependencies(&self, reference: u32) -> Result<Vec<Dependency>, Self::Problem> {
        not_offered("dependencies of variables at run time")
    }

    /// The time of the next event, s, where it is known: a time event in Model Exchange, any event
    /// in Co-Simulation.
    fn next_event_time(&mut self) -> Option<f64> {
        None
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

    /// `fmi2GetNominalsOfContinuousStates`, `fmi3GetNominalsOfContinuousStates`: one positive
    /// number for each continuous state; by default there is none.
    fn nominals(&self) -> impl AsRef<[f64]> {
        []
    }

    /// Number of event indicators.
    fn number_of_event_indicators(&self) -> usize {
        0
    }

    /// `fmi2GetFMUstate`, `fmi3GetFMUState`: everything it needs to continue from here.
    ///
    /// # Errors
    /// By default always.
    fn save(&self) -> Result<Self::State, Self::Problem> {
        not_offered("saved states")
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
    /// [`Problem::SavedState`](crate::Problem::SavedState) for bytes that are truncated, altered or
    /// of another build; by default always.
    fn deserialize(&self, bytes: &[u8]) -> Result<Self::State, Self::Problem> {
        not_offered("saved states as bytes")
    }
}
