//! The type that an FMU instantiates, apart from its motion: variables, continuous states, saved
//! states. Its motion is [`Hybrid`](crate::Hybrid).

use crate::events::EarlyEnd;
use crate::instantiation::{Instantiation, Named};
use crate::life::Life;
use crate::log::Log;
use crate::problem::{Refusal, not_offered};
use crate::values::{Bases, Dependency};
use std::fmt::Debug;

/// Variables, continuous states and saved states of a component.
///
/// Each method checks all its arguments before it changes anything, so that a refused call leaves
/// the component unchanged. A type omits the methods of capabilities that it does not offer. Their
/// defaults do nothing, return an empty result, or refuse the call with the name of the missing
/// capability.
///
/// All values are passed as `f64`: Integers and enumerations are exact in it, Booleans and clocks
/// are 0 and 1. The FMI 2.0 and 3.0 interfaces ("doors") query the variables of an instance, so a
/// component may determine its variables only at instantiation. String, Binary and structural
/// variables, input clocks and Scheduled Execution are not supported.
#[allow(unused_variables)] // the default methods do not use their arguments
pub trait Model: Sized + Debug + 'static {
    /// Type of the component's refusals; [`Problem`](crate::Problem) if it needs no others.
    type Problem: Refusal;
    /// A saved state: all data that the component needs to continue. `()` if states cannot be
    /// saved.
    type State: Debug;

    /// Cap on the elements of one call. A larger count is refused, so that a wrong count does not
    /// lead to reads far outside the host's array. The cap must be at least the largest number of
    /// values of one call and the number of bytes of a saved state.
    const MAX_COUNT: usize = 1 << 24;
    /// Texts for messages about an FMI 2.0 step that ends early.
    const EARLY_END: EarlyEnd = EarlyEnd { event: "event", because: "" };

    /// `fmi2Instantiate`, `fmi3Instantiate…`: a new instance with all variables at their start
    /// values.
    ///
    /// # Errors
    /// If the token belongs to another component ([`Instantiation::check_token`]), the resources
    /// cannot be read, or the interface type is not offered.
    fn instantiate(request: &Instantiation<'_>) -> Result<Self, Self::Problem>;

    /// Lifecycle state: interface type, phase, and the event handling agreed with the host.
    fn life(&self) -> &Life;

    /// Lifecycle state, mutable.
    fn life_mut(&mut self) -> &mut Life;

    /// Logs how the instance was made, for the user.
    fn tell_at_instantiation(&self, log: &mut dyn Log) {}

    /// `fmi2Reset`, `fmi3Reset`: puts the component into the state after instantiation.
    fn reset(&mut self);

    /// Present time, s; the start time before initialization ends.
    fn time(&self) -> f64;

    /// Name of the variable with a value reference, and the properties that a door needs.
    ///
    /// # Errors
    /// [`Problem::Reference`](crate::Problem::Reference) if no variable has the reference.
    fn variable(&self, reference: u32) -> Result<Named<'_>, Self::Problem>;

    /// `fmi2Get…`, `fmi3Get…`: passes value `i` to `write`. The values are in the order of the
    /// variables, and arrays are in row-major order. No value is NaN or infinite.
    ///
    /// # Errors
    /// [`Problem::Reference`](crate::Problem::Reference) if a reference belongs to no variable of
    /// these types; then nothing has been written.
    fn get(
        &mut self,
        bases: Bases,
        references: &[u32],
        write: impl FnMut(usize, f64),
    ) -> Result<(), Self::Problem>;

    /// `fmi2Set…`, `fmi3Set…`: takes the value of variable `i` from `read`. All values are checked
    /// before the first is set.
    ///
    /// # Errors
    /// If a reference is wrong, a variable cannot be set in this phase, or a value is outside its
    /// range.
    fn set(
        &mut self,
        bases: Bases,
        references: &[u32],
        read: impl Fn(usize) -> f64,
    ) -> Result<(), Self::Problem>;

    /// `fmi2SetRealInputDerivatives` (`canInterpolateInputs`).
    ///
    /// # Errors
    /// The default always fails.
    fn set_input_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        values: &[f64],
    ) -> Result<(), Self::Problem> {
        not_offered("derivatives of inputs")
    }

    /// `fmi2GetRealOutputDerivatives`, `fmi3GetOutputDerivatives` (`maxOutputDerivativeOrder`):
    /// passes derivative `i` to `write`.
    ///
    /// # Errors
    /// The default always fails.
    fn output_derivatives(
        &mut self,
        references: &[u32],
        orders: &[i32],
        write: impl FnMut(usize, f64),
    ) -> Result<(), Self::Problem> {
        not_offered("derivatives of outputs")
    }

    /// `fmi2GetDirectionalDerivative`, `fmi3GetDirectionalDerivative`: passes to `write`, for each
    /// unknown `i`, its directional derivative Σ ∂unknown/∂known · seed.
    ///
    /// # Errors
    /// The default always fails.
    fn directional_derivative(
        &mut self,
        unknowns: &[u32],
        knowns: &[u32],
        seed: &[f64],
        write: impl FnMut(usize, f64),
    ) -> Result<(), Self::Problem> {
        not_offered("directional derivatives")
    }

    /// `fmi3GetVariableDependencies`: present dependencies of a variable.
    ///
    /// # Errors
    /// The default always fails.
    fn dependencies(&self, reference: u32) -> Result<Vec<Dependency>, Self::Problem> {
        not_offered("dependencies of variables at run time")
    }

    /// Time of the next event, s, if it is known. In Model Exchange it is the next time event; in
    /// Co-Simulation it may be an event of any kind.
    fn next_event_time(&mut self) -> Option<f64> {
        None
    }

    /// `fmi2SetContinuousStates`, `fmi3SetContinuousStates`: sets all continuous states.
    ///
    /// # Errors
    /// If the states are not admissible; then nothing has changed. The default always fails.
    fn set_continuous_states(&mut self, states: &[f64]) -> Result<(), Self::Problem> {
        not_offered("continuous states")
    }

    /// `fmi2GetContinuousStates`, `fmi3GetContinuousStates`.
    ///
    /// # Errors
    /// The default never fails, since the component has no states.
    fn continuous_states(&self) -> Result<impl AsRef<[f64]>, Self::Problem> {
        Ok([])
    }

    /// `fmi2GetDerivatives`, `fmi3GetContinuousStateDerivatives`.
    ///
    /// # Errors
    /// The default never fails, since the component has no states.
    fn state_derivatives(&self) -> Result<impl AsRef<[f64]>, Self::Problem> {
        Ok([])
    }

    /// `fmi2GetEventIndicators`, `fmi3GetEventIndicators`: an event occurs where an indicator
    /// changes its sign.
    ///
    /// # Errors
    /// The default never fails, since the component has no indicators.
    fn event_indicators(&self) -> Result<impl AsRef<[f64]>, Self::Problem> {
        Ok([])
    }

    /// `fmi2GetNominalsOfContinuousStates`, `fmi3GetNominalsOfContinuousStates`: one positive
    /// number for each continuous state; by default empty.
    fn nominals(&self) -> impl AsRef<[f64]> {
        []
    }

    /// Number of event indicators.
    fn number_of_event_indicators(&self) -> usize {
        0
    }

    /// `fmi2GetFMUstate`, `fmi3GetFMUState`: all data that the component needs to continue.
    ///
    /// # Errors
    /// The default always fails.
    fn save(&self) -> Result<Self::State, Self::Problem> {
        not_offered("saved states")
    }

    /// `fmi2SetFMUstate`, `fmi3SetFMUState`: returns to a saved state. The state was saved by this
    /// instance or read from bytes; the instance may be uninitialized. A motion continued from a
    /// restored state is bitwise equal to the original motion.
    ///
    /// # Errors
    /// If the state does not fit; then nothing has changed. The default always fails.
    fn restore(&mut self, saved: &Self::State) -> Result<(), Self::Problem> {
        not_offered("saved states")
    }

    /// `fmi2SerializeFMUstate`, `fmi3SerializeFMUState`.
    ///
    /// # Errors
    /// The default always fails.
    fn serialize(&self, saved: &Self::State) -> Result<Vec<u8>, Self::Problem> {
        not_offered("saved states as bytes")
    }

    /// `fmi2DeSerializeFMUstate`, `fmi3DeserializeFMUState`: must accept arbitrary bytes without a
    /// panic.
    ///
    /// # Errors
    /// [`Problem::SavedState`](crate::Problem::SavedState) if the bytes are truncated, altered or
    /// from another build. The default always fails.
    fn deserialize(&self, bytes: &[u8]) -> Result<Self::State, Self::Problem> {
        not_offered("saved states as bytes")
    }
}
