//! The table compared with the standard's lists of allowed calls, transcribed a second time from
//! its text.

use super::*;
use crate::allowed::assert_is_the_standards;
use crate::life::Interface;

/// "Allowed Function Calls" of FMI 3.0.2, states in this order. Model Exchange: Instantiated,
/// Initialization Mode, Event Mode, Continuous-Time Mode, Terminated, fatal; Co-Simulation:
/// Instantiated, Initialization Mode, Event Mode, Step Mode, Intermediate Update Mode, Terminated,
/// fatal.
///
/// x: listed, and allowed here. l: allowed here only. n: listed for FMUs with structural
/// parameters, input clocks or `providesEvaluateDiscreteStates`, unlike this one. -: neither.
const STANDARD: &str = "
    fmi3SetDebugLogging                 xxxxx- xxxxlx-
    fmi3FreeInstance                    xxxxx- xxxx-x-
    fmi3EnterInitializationMode         x----- x------
    fmi3ExitInitializationMode          -x---- -x-----
    fmi3EnterEventMode                  ---x-- ---x---
    fmi3Terminate                       --xx-- --xx---
    fmi3Reset                           xxxxx- xxxx-x-
    fmi3GetFloat32                      xxxxx- xxxxxx-
    fmi3GetFloat64                      xxxxx- xxxxxx-
    fmi3GetInt8                         xxxxx- xxxxxx-
    fmi3GetUInt8                        xxxxx- xxxxxx-
    fmi3GetInt16                        xxxxx- xxxxxx-
    fmi3GetUInt16                       xxxxx- xxxxxx-
    fmi3GetInt32                        xxxxx- xxxxxx-
    fmi3GetUInt32                       xxxxx- xxxxxx-
    fmi3GetInt64                        xxxxx- xxxxxx-
    fmi3GetUInt64                       xxxxx- xxxxxx-
    fmi3GetBoolean                      xxxxx- xxxxxx-
    fmi3GetString                       xxxxx- xxxxxx-
    fmi3GetBinary                       xxxxx- xxxxxx-
    fmi3GetClock                        lxxll- lxxlll-
    fmi3SetFloat32                      xxxx-- xxxxx--
    fmi3SetFloat64                      xxxx-- xxxxx--
    fmi3SetInt8                         xxxx-- xxxxx--
    fmi3SetUInt8                        xxxx-- xxxxx--
    fmi3SetInt16                        xxxx-- xxxxx--
    fmi3SetUInt16                       xxxx-- xxxxx--
    fmi3SetInt32                        xxxx-- xxxxx--
    fmi3SetUInt32                       xxxx-- xxxxx--
    fmi3SetInt64                        xxxx-- xxxxx--
    fmi3SetUInt64                       xxxx-- xxxxx--
    fmi3SetBoolean                      xxxx-- xxxxx--
    fmi3SetString                       xxxx-- xxxxx--
    fmi3SetBinary                       xxxx-- xxxxx--
    fmi3SetClock                        --x--- --x----
    fmi3GetNumberOfVariableDependencies xxxxx- xxxx-x-
    fmi3GetVariableDependencies         xxxxx- xxxx-x-
    fmi3GetFMUState                     xxxxx- xxxx-x-
    fmi3SetFMUState                     xxxxx- xxxx-x-
    fmi3FreeFMUState                    xxxxx- xxxx-x-
    fmi3SerializedFMUStateSize          xxxxx- xxxx-x-
    fmi3SerializeFMUState               xxxxx- xxxx-x-
    fmi3DeserializeFMUState             xxxxx- xxxx-x-
    fmi3GetDirectionalDerivative        -xxxx- -xxx-x-
    fmi3GetAdjointDerivative            -xxxx- -xxx-x-
    fmi3EnterConfigurationMode          n-n--- n--n---
    fmi3ExitConfigurationMode           ------ -------
    fmi3GetIntervalDecimal              -nn--- -nn----
    fmi3GetIntervalFraction             -nn--- -nn----
    fmi3GetShiftDecimal                 -n---- -n-----
    fmi3GetShiftFraction                -n---- -n-----
    fmi3SetIntervalDecimal              -n---- -n-----
    fmi3SetIntervalFraction             -n---- -n-----
    fmi3SetShiftDecimal                 -n---- -n-----
    fmi3SetShiftFraction                -n---- -n-----
    fmi3EvaluateDiscreteStates          --n--- --n----
    fmi3UpdateDiscreteStates            --x--- --x----
    fmi3EnterContinuousTimeMode         --x--- -------
    fmi3CompletedIntegratorStep         ---x-- -------
    fmi3SetTime                         --lx-- -------
    fmi3SetContinuousStates             ---x-- -------
    fmi3GetContinuousStateDerivatives   -xxxx- -------
    fmi3GetEventIndicators              -xxxx- -------
    fmi3GetContinuousStates             -xxxx- -------
    fmi3GetNominalsOfContinuousStates   -xxxx- -------
    fmi3GetNumberOfEventIndicators      xlxll- -------
    fmi3GetNumberOfContinuousStates     xlxll- -------
    fmi3EnterStepMode                   ------ --x----
    fmi3GetOutputDerivatives            ------ --lxxx-
    fmi3DoStep                          ------ ---x---
    fmi3ActivateModelPartition          ------ -------";

#[test]
fn table_is_the_standards() {
    use Stage::*;
    let exchange = [Instantiated, InitializationMode, EventMode, ContinuousTimeMode, Terminated, Fatal];
    let cosimulation =
        [Instantiated, InitializationMode, EventMode, StepMode, IntermediateUpdateMode, Terminated, Fatal];
    assert_is_the_standards!(
        STANDARD,
        [(Interface::ModelExchange, &exchange[..]), (Interface::CoSimulation, &cosimulation[..])],
        |_, _, mark| "xl".contains(mark)
    );
}

/// 75 functions, including those without an instance: version and three instantiations.
#[test]
fn every_function_of_the_header_is_there() {
    assert_eq!(FUNCTIONS.len() + 4, 75);
}

#[test]
fn values_that_the_model_cannot_take_are_discarded_where_they_are_handed_over() {
    let takes = |name: &str| FUNCTIONS.iter().find(|f| f.name() == name).unwrap().takes_values();
    for name in ["fmi3SetFloat64", "fmi3SetContinuousStates", "fmi3ExitInitializationMode", "fmi3GetFloat64"]
    {
        assert!(takes(name), "{name}");
    }
    for name in ["fmi3DoStep", "fmi3SetTime", "fmi3EnterInitializationMode", "fmi3Terminate"] {
        assert!(!takes(name), "{name}");
    }
}
