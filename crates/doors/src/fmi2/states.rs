//! The permitted functions of each state: the two state machines as one table (FMI 2.0, 3.2.3 and
//! 4.2.4).

use crate::allowed::function_table;
use crate::life::{Interface, Phase};
use crate::problem::Problem;

/// The interface type of a `fmi2Type` (FMI 2.0, 2.1.5).
///
/// # Errors
/// [`Problem::Value`] for any other number.
pub fn interface(number: i32) -> Result<Interface, Problem> {
    match number {
        0 => Ok(Interface::ModelExchange),
        1 => Ok(Interface::CoSimulation),
        _ => {
            Err(Problem::value("fmuType", f64::from(number), "0 (fmi2ModelExchange) or 1 (fmi2CoSimulation)"))
        }
    }
}

/// The states of both state machines, named as in the standard (FMI 2.0, 3.2.3 and 4.2.4).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Just instantiated or reset.
    Instantiated,
    /// Between `fmi2EnterInitializationMode` and `fmi2ExitInitializationMode`.
    InitializationMode,
    /// Model Exchange: at an event.
    EventMode,
    /// Model Exchange: between events.
    ContinuousTimeMode,
    /// Co-Simulation: at a communication point.
    StepComplete,
    /// Co-Simulation: never reached, since steps are synchronous.
    StepInProgress,
    /// Co-Simulation: the last step ended early with `fmi2Discard`.
    StepFailed,
    /// Co-Simulation: never reached, since steps are synchronous.
    StepCanceled,
    /// After `fmi2Terminate`.
    Terminated,
    /// Never reached: a refused call leaves an instance unchanged.
    Error,
    /// After a panic.
    Fatal,
}

/// All states.
pub const STAGES: [Stage; 11] = [
    Stage::Instantiated,
    Stage::InitializationMode,
    Stage::EventMode,
    Stage::ContinuousTimeMode,
    Stage::StepComplete,
    Stage::StepInProgress,
    Stage::StepFailed,
    Stage::StepCanceled,
    Stage::Terminated,
    Stage::Error,
    Stage::Fatal,
];

impl Stage {
    /// State of the standard's state machines that corresponds to a phase of the component. Steps
    /// are synchronous and refused calls change nothing, so `StepInProgress`, `StepCanceled` and
    /// `Error` never occur.
    pub fn of(phase: Phase) -> Self {
        match phase {
            Phase::Instantiated => Self::Instantiated,
            Phase::Initialization => Self::InitializationMode,
            Phase::Event => Self::EventMode,
            Phase::Continuous => Self::ContinuousTimeMode,
            Phase::Step => Self::StepComplete,
            Phase::StoppedEarly => Self::StepFailed,
            Phase::Terminated => Self::Terminated,
            Phase::Broken => Self::Fatal,
        }
    }
}

// One letter per state, in the order of the standard's tables.
const I: u16 = 1 << Stage::Instantiated as u16;
const N: u16 = 1 << Stage::InitializationMode as u16;
const E: u16 = 1 << Stage::EventMode as u16;
const C: u16 = 1 << Stage::ContinuousTimeMode as u16;
const S: u16 = 1 << Stage::StepComplete as u16;
const P: u16 = 1 << Stage::StepInProgress as u16;
const F: u16 = 1 << Stage::StepFailed as u16;
const X: u16 = 1 << Stage::StepCanceled as u16;
const T: u16 = 1 << Stage::Terminated as u16;
const R: u16 = 1 << Stage::Error as u16;

const GET_EXCHANGE: u16 = N | E | C | T | R;
const GET_COSIMULATION: u16 = N | S | F | X | T | R;
const KEEP_EXCHANGE: u16 = I | N | E | C | T | R;
const KEEP_COSIMULATION: u16 = I | N | S | F | X | T | R;

#[rustfmt::skip]
function_table! {
    /// The functions that act on an instance (FMI 2.0, 2.1, 3.2 and 4.2).
    "fmi2";

    SetDebugLogging:              KEEP_EXCHANGE,      KEEP_COSIMULATION | P;
    FreeInstance:                 KEEP_EXCHANGE,      KEEP_COSIMULATION;
    SetupExperiment:              I,                  I;
    EnterInitializationMode:      I,                  I;
    ExitInitializationMode:       N,                  N;
    Terminate:                    E | C,              S | F;
    Reset:                        KEEP_EXCHANGE,      KEEP_COSIMULATION;
    GetReal:                      GET_EXCHANGE,       GET_COSIMULATION;
    GetInteger:                   GET_EXCHANGE,       GET_COSIMULATION;
    GetBoolean:                   GET_EXCHANGE,       GET_COSIMULATION;
    GetString:                    GET_EXCHANGE,       GET_COSIMULATION;
    // After Discard the standard requires the host to restore a saved state. Here the motion is at
    // the event, and the calls of a communication point are allowed as well: some hosts continue
    // from fmi2LastSuccessfulTime.
    SetReal:                      I | N | E | C,      I | N | S | F;
    SetInteger:                   I | N | E,          I | N | S | F;
    SetBoolean:                   I | N | E,          I | N | S | F;
    SetString:                    I | N | E,          I | N | S | F;
    GetFMUstate:                  KEEP_EXCHANGE,      KEEP_COSIMULATION;
    SetFMUstate:                  KEEP_EXCHANGE,      KEEP_COSIMULATION;
    FreeFMUstate:                 KEEP_EXCHANGE,      KEEP_COSIMULATION;
    SerializedFMUstateSize:       KEEP_EXCHANGE,      KEEP_COSIMULATION;
    SerializeFMUstate:            KEEP_EXCHANGE,      KEEP_COSIMULATION;
    DeSerializeFMUstate:          KEEP_EXCHANGE,      KEEP_COSIMULATION;
    GetDirectionalDerivative:     GET_EXCHANGE,       GET_COSIMULATION;

    EnterEventMode:               E | C,              0;
    NewDiscreteStates:            E,                  0;
    EnterContinuousTimeMode:      E,                  0;
    CompletedIntegratorStep:      C,                  0;
    // In Event Mode only to the present time: some hosts set the present time again.
    SetTime:                      E | C,              0;
    SetContinuousStates:          C,                  0;
    GetEventIndicators:           GET_EXCHANGE,       0;
    GetContinuousStates:          GET_EXCHANGE,       0;
    GetDerivatives:               GET_EXCHANGE,       0;
    GetNominalsOfContinuousStates: KEEP_EXCHANGE,     0;

    SetRealInputDerivatives:      0,                  I | N | S | F;
    GetRealOutputDerivatives:     0,                  S | F | X | T | R;
    DoStep:                       0,                  S | F;
    CancelStep:                   0,                  P;
    GetStatus:                    0,                  S | P | F | T;
    GetRealStatus:                0,                  S | P | F | T;
    GetIntegerStatus:             0,                  S | P | F | T;
    GetBooleanStatus:             0,                  S | P | F | T;
    GetStringStatus:              0,                  S | P | F | T;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allowed::assert_is_the_standards;

    /// Functions permitted in addition to the standard, in `StepFailed`.
    const BESIDE: [Function; 6] = [
        Function::SetReal,
        Function::SetInteger,
        Function::SetBoolean,
        Function::SetString,
        Function::SetRealInputDerivatives,
        Function::DoStep,
    ];

    /// The standard's tables, states in its order: co-simulation ins, init, complete, in progress,
    /// failed, canceled, terminated, error, fatal; model exchange ins, init, event, continuous,
    /// terminated, error, fatal.
    const STANDARD: &str = "
        fmi2SetDebugLogging              xxxxxxxx- xxxxxx-
        fmi2FreeInstance                 xxx-xxxx- xxxxxx-
        fmi2SetupExperiment              x-------- x------
        fmi2EnterInitializationMode      x-------- x------
        fmi2ExitInitializationMode       -x------- -x-----
        fmi2Terminate                    --x-x---- --xx---
        fmi2Reset                        xxx-xxxx- xxxxxx-
        fmi2GetReal                      -xx-xxxx- -xxxxx-
        fmi2GetInteger                   -xx-xxxx- -xxxxx-
        fmi2GetBoolean                   -xx-xxxx- -xxxxx-
        fmi2GetString                    -xx-xxxx- -xxxxx-
        fmi2SetReal                      xxx------ xxxx---
        fmi2SetInteger                   xxx------ xxx----
        fmi2SetBoolean                   xxx------ xxx----
        fmi2SetString                    xxx------ xxx----
        fmi2GetFMUstate                  xxx-xxxx- xxxxxx-
        fmi2SetFMUstate                  xxx-xxxx- xxxxxx-
        fmi2FreeFMUstate                 xxx-xxxx- xxxxxx-
        fmi2SerializedFMUstateSize       xxx-xxxx- xxxxxx-
        fmi2SerializeFMUstate            xxx-xxxx- xxxxxx-
        fmi2DeSerializeFMUstate          xxx-xxxx- xxxxxx-
        fmi2GetDirectionalDerivative     -xx-xxxx- -xxxxx-
        fmi2EnterEventMode               --------- --xx---
        fmi2NewDiscreteStates            --------- --x----
        fmi2EnterContinuousTimeMode      --------- --x----
        fmi2CompletedIntegratorStep      --------- ---x---
        fmi2SetTime                      --------- --xx---
        fmi2SetContinuousStates          --------- ---x---
        fmi2GetEventIndicators           --------- -xxxxx-
        fmi2GetContinuousStates          --------- -xxxxx-
        fmi2GetDerivatives               --------- -xxxxx-
        fmi2GetNominalsOfContinuousStates --------- xxxxxx-
        fmi2SetRealInputDerivatives      xxx------ -------
        fmi2GetRealOutputDerivatives     --x-xxxx- -------
        fmi2DoStep                       --x------ -------
        fmi2CancelStep                   ---x----- -------
        fmi2GetStatus                    --xxx-x-- -------
        fmi2GetRealStatus                --xxx-x-- -------
        fmi2GetIntegerStatus             --xxx-x-- -------
        fmi2GetBooleanStatus             --xxx-x-- -------
        fmi2GetStringStatus              --xxx-x-- -------";

    #[test]
    fn table_is_the_standards() {
        use Stage::*;
        let cosimulation = [
            Instantiated,
            InitializationMode,
            StepComplete,
            StepInProgress,
            StepFailed,
            StepCanceled,
            Terminated,
            Error,
            Fatal,
        ];
        let exchange =
            [Instantiated, InitializationMode, EventMode, ContinuousTimeMode, Terminated, Error, Fatal];
        assert_is_the_standards!(
            STANDARD,
            [(Interface::CoSimulation, &cosimulation[..]), (Interface::ModelExchange, &exchange[..])],
            |function, state, mark| mark == 'x' || state == StepFailed && BESIDE.contains(&function)
        );
    }
}
