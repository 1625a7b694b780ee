//! The permitted functions of each state: the common states and the states of Model Exchange and
//! Co-Simulation as one table (FMI 3.0.2, 2.3, 3.2 and 4.2).

use crate::allowed::function_table;
use crate::life::Phase;

/// The states of both state machines, named as in the standard. Configuration Mode and
/// Reconfiguration Mode never occur, since no parameter is structural.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Just instantiated or reset.
    Instantiated,
    /// Between `fmi3EnterInitializationMode` and `fmi3ExitInitializationMode`.
    InitializationMode,
    /// At an event.
    EventMode,
    /// Co-Simulation: at a communication point.
    StepMode,
    /// Co-Simulation: inside the host's callback in a step.
    IntermediateUpdateMode,
    /// Model Exchange: between events.
    ContinuousTimeMode,
    /// After `fmi3Terminate`, or after an error.
    Terminated,
    /// After a panic.
    Fatal,
}

/// All states.
pub const STAGES: [Stage; 8] = [
    Stage::Instantiated,
    Stage::InitializationMode,
    Stage::EventMode,
    Stage::StepMode,
    Stage::IntermediateUpdateMode,
    Stage::ContinuousTimeMode,
    Stage::Terminated,
    Stage::Fatal,
];

impl Stage {
    /// State of the standard's state machines that corresponds to a phase of the component,
    /// outside the host's callback.
    pub fn of(phase: Phase) -> Self {
        match phase {
            Phase::Instantiated => Self::Instantiated,
            Phase::Initialization => Self::InitializationMode,
            Phase::Event => Self::EventMode,
            Phase::Continuous => Self::ContinuousTimeMode,
            // A step that ended early ended at a communication point.
            Phase::Step | Phase::StoppedEarly => Self::StepMode,
            Phase::Terminated => Self::Terminated,
            Phase::Broken => Self::Fatal,
        }
    }
}

// One letter per state.
const I: u16 = 1 << Stage::Instantiated as u16;
const N: u16 = 1 << Stage::InitializationMode as u16;
const E: u16 = 1 << Stage::EventMode as u16;
const S: u16 = 1 << Stage::StepMode as u16;
const U: u16 = 1 << Stage::IntermediateUpdateMode as u16;
const C: u16 = 1 << Stage::ContinuousTimeMode as u16;
const T: u16 = 1 << Stage::Terminated as u16;

const ANY_EXCHANGE: u16 = I | N | E | C | T;
const ANY_COSIMULATION: u16 = I | N | E | S | T;
/// Getters are also allowed before initialization: by the standard's table (2.3.2) they return the
/// start values there. The list of allowed calls below that table omits them.
const GET_EXCHANGE: u16 = ANY_EXCHANGE;
const GET_COSIMULATION: u16 = ANY_COSIMULATION | U;
const SET_EXCHANGE: u16 = I | N | E | C;
const SET_COSIMULATION: u16 = I | N | E | S | U;

#[rustfmt::skip]
function_table! {
    /// The functions that act on an instance (FMI 3.0.2, 2.2, 2.3, 3.2, 4.2 and 5.2).
    "fmi3";

    SetDebugLogging:                 ANY_EXCHANGE,  ANY_COSIMULATION | U;
    FreeInstance:                    ANY_EXCHANGE,  ANY_COSIMULATION;
    EnterInitializationMode:         I,             I;
    ExitInitializationMode:          N,             N;
    EnterEventMode:                  C,             S;
    Terminate:                       E | C,         E | S;
    Reset:                           ANY_EXCHANGE,  ANY_COSIMULATION;
    GetFloat32:                      GET_EXCHANGE,  GET_COSIMULATION;
    GetFloat64:                      GET_EXCHANGE,  GET_COSIMULATION;
    GetInt8:                         GET_EXCHANGE,  GET_COSIMULATION;
    GetUInt8:                        GET_EXCHANGE,  GET_COSIMULATION;
    GetInt16:                        GET_EXCHANGE,  GET_COSIMULATION;
    GetUInt16:                       GET_EXCHANGE,  GET_COSIMULATION;
    GetInt32:                        GET_EXCHANGE,  GET_COSIMULATION;
    GetUInt32:                       GET_EXCHANGE,  GET_COSIMULATION;
    GetInt64:                        GET_EXCHANGE,  GET_COSIMULATION;
    GetUInt64:                       GET_EXCHANGE,  GET_COSIMULATION;
    GetBoolean:                      GET_EXCHANGE,  GET_COSIMULATION;
    GetString:                       GET_EXCHANGE,  GET_COSIMULATION;
    GetBinary:                       GET_EXCHANGE,  GET_COSIMULATION;
    // Outside Event Mode no clock is active.
    GetClock:                        GET_EXCHANGE,  GET_COSIMULATION;
    SetFloat32:                      SET_EXCHANGE,  SET_COSIMULATION;
    SetFloat64:                      SET_EXCHANGE,  SET_COSIMULATION;
    SetInt8:                         SET_EXCHANGE,  SET_COSIMULATION;
    SetUInt8:                        SET_EXCHANGE,  SET_COSIMULATION;
    SetInt16:                        SET_EXCHANGE,  SET_COSIMULATION;
    SetUInt16:                       SET_EXCHANGE,  SET_COSIMULATION;
    SetInt32:                        SET_EXCHANGE,  SET_COSIMULATION;
    SetUInt32:                       SET_EXCHANGE,  SET_COSIMULATION;
    SetInt64:                        SET_EXCHANGE,  SET_COSIMULATION;
    SetUInt64:                       SET_EXCHANGE,  SET_COSIMULATION;
    SetBoolean:                      SET_EXCHANGE,  SET_COSIMULATION;
    SetString:                       SET_EXCHANGE,  SET_COSIMULATION;
    SetBinary:                       SET_EXCHANGE,  SET_COSIMULATION;
    SetClock:                        E,             E;
    GetNumberOfVariableDependencies: ANY_EXCHANGE,  ANY_COSIMULATION;
    GetVariableDependencies:         ANY_EXCHANGE,  ANY_COSIMULATION;
    GetFMUState:                     ANY_EXCHANGE,  ANY_COSIMULATION;
    SetFMUState:                     ANY_EXCHANGE,  ANY_COSIMULATION;
    FreeFMUState:                    ANY_EXCHANGE,  ANY_COSIMULATION;
    SerializedFMUStateSize:          ANY_EXCHANGE,  ANY_COSIMULATION;
    SerializeFMUState:               ANY_EXCHANGE,  ANY_COSIMULATION;
    DeserializeFMUState:             ANY_EXCHANGE,  ANY_COSIMULATION;
    GetDirectionalDerivative:        N | E | C | T, N | E | S | T;
    GetAdjointDerivative:            N | E | C | T, N | E | S | T;
    // Never permitted: no parameter is structural.
    EnterConfigurationMode:          0,             0;
    ExitConfigurationMode:           0,             0;
    // Never permitted: no variable is an input clock.
    GetIntervalDecimal:              0,             0;
    GetIntervalFraction:             0,             0;
    GetShiftDecimal:                 0,             0;
    GetShiftFraction:                0,             0;
    SetIntervalDecimal:              0,             0;
    SetIntervalFraction:             0,             0;
    SetShiftDecimal:                 0,             0;
    SetShiftFraction:                0,             0;
    // Never: providesEvaluateDiscreteStates is false.
    EvaluateDiscreteStates:          0,             0;
    UpdateDiscreteStates:            E,             E;

    EnterContinuousTimeMode:         E,             0;
    CompletedIntegratorStep:         C,             0;
    // In Event Mode only to the present time: some hosts set the present time again.
    SetTime:                         E | C,         0;
    SetContinuousStates:             C,             0;
    GetContinuousStateDerivatives:   N | E | C | T, 0;
    GetEventIndicators:              N | E | C | T, 0;
    GetContinuousStates:             N | E | C | T, 0;
    GetNominalsOfContinuousStates:   N | E | C | T, 0;
    GetNumberOfEventIndicators:      ANY_EXCHANGE,  0;
    GetNumberOfContinuousStates:     ANY_EXCHANGE,  0;

    EnterStepMode:                   0,             E;
    // In Event Mode these are the derivatives after the event.
    GetOutputDerivatives:            0,             E | S | U | T;
    DoStep:                          0,             S;

    // Never: Scheduled Execution is not offered.
    ActivateModelPartition:          0,             0;
}

impl Function {
    /// Whether the function passes values to the model, or evaluates the model at values passed
    /// before. If the model cannot take these values, the call returns `fmi3Discard`.
    pub fn takes_values(self) -> bool {
        let name = self.name();
        (name.starts_with("fmi3Set")
            || name.starts_with("fmi3Get")
            || name == "fmi3ExitInitializationMode"
            || name == "fmi3UpdateDiscreteStates"
            || name == "fmi3EnterStepMode")
            && !matches!(self, Self::SetTime | Self::GetOutputDerivatives)
    }
}

#[cfg(test)]
mod tests;
