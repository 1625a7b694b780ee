//! Events, Model Exchange and Co-Simulation (FMI 3.0.2, 2.3.5, 3.2 and 4.2).

use super::super::types::{DiscreteStates, FmiBoolean};
use super::*;
use crate::component::structure::{EVENT_INDICATORS, STATES};

export! {
    "2.3.2":
    /// Never allowed, since there are no structural parameters.
    fmi3EnterConfigurationMode, EnterConfigurationMode() |_, _| Outcome::Ok(());
    /// Never allowed.
    fmi3ExitConfigurationMode, ExitConfigurationMode() |_, _| Outcome::Ok(());

    "2.3.5":
    fmi3EnterEventMode, EnterEventMode() |instance, _| instance.enter_event_mode();
    /// Never allowed, since getters in Event Mode show what comes after the event.
    fmi3EvaluateDiscreteStates, EvaluateDiscreteStates() |_, _| Outcome::Ok(());
    /// One call does all that happens at an instant, and nothing ends the simulation.
    fmi3UpdateDiscreteStates, UpdateDiscreteStates(out discreteStatesNeedUpdate: FmiBoolean[1],
        out terminateSimulation: FmiBoolean[1], out nominalsOfContinuousStatesChanged: FmiBoolean[1],
        out valuesOfContinuousStatesChanged: FmiBoolean[1], out nextEventTimeDefined: FmiBoolean[1],
        out nextEventTime: f64[1])
        |instance, host| {
            let DiscreteStates { changed, next_event_time: next } = instance.update_discrete_states(host)?;
            for never in [discreteStatesNeedUpdate, terminateSimulation] {
                never.put(0, 0);
            }
            nominalsOfContinuousStatesChanged.put(0, changed.nominals.into());
            valuesOfContinuousStatesChanged.put(0, changed.states.into());
            nextEventTimeDefined.put(0, next.is_some().into());
            nextEventTime.put(0, next.unwrap_or(0.0));
            Outcome::Ok(())
        };
    fmi3EnterContinuousTimeMode, EnterContinuousTimeMode()
        |instance, host| instance.leave_event_mode(Function::EnterContinuousTimeMode, host);
    fmi3EnterStepMode, EnterStepMode() |instance, host| instance.leave_event_mode(Function::EnterStepMode, host);

    "3.2.1":
    fmi3CompletedIntegratorStep, CompletedIntegratorStep(flag noSetFMUStatePriorToCurrentPoint,
        out enterEventMode: FmiBoolean[1], out terminateSimulation: FmiBoolean[1])
        |instance, _| {
            enterEventMode.give(instance.component.complete_integrator_step().map(Into::into))?;
            terminateSimulation.give(Outcome::Ok(0))
        };
    fmi3SetTime, SetTime(value time: f64) |instance, _| instance.component.set_time(time);
    fmi3SetContinuousStates, SetContinuousStates(vector continuousStates: f64[nContinuousStates],
        value nContinuousStates: usize)
        |instance, _| instance.set_continuous_states(continuousStates);
    fmi3GetContinuousStateDerivatives, GetContinuousStateDerivatives(out derivatives: f64[nContinuousStates],
        value nContinuousStates: usize)
        |instance, _| derivatives.copy(&instance.component.state_derivatives()?, "nContinuousStates");
    fmi3GetEventIndicators, GetEventIndicators(out eventIndicators: f64[nEventIndicators],
        value nEventIndicators: usize)
        |instance, _| eventIndicators.copy(&instance.component.event_indicators()?, "nEventIndicators");
    fmi3GetContinuousStates, GetContinuousStates(out continuousStates: f64[nContinuousStates],
        value nContinuousStates: usize)
        |instance, _| continuousStates.copy(&instance.component.continuous_states()?, "nContinuousStates");
    fmi3GetNominalsOfContinuousStates, GetNominalsOfContinuousStates(out nominals: f64[nContinuousStates],
        value nContinuousStates: usize)
        |instance, _| nominals.copy(&instance.component.nominals(), "nContinuousStates");
    fmi3GetNumberOfEventIndicators, GetNumberOfEventIndicators(out nEventIndicators: usize[1])
        |_, _| nEventIndicators.give(Outcome::Ok(EVENT_INDICATORS));
    fmi3GetNumberOfContinuousStates, GetNumberOfContinuousStates(out nContinuousStates: usize[1])
        |_, _| nContinuousStates.give(Outcome::Ok(STATES.len()));

    "4.1.2":
    fmi3GetOutputDerivatives, GetOutputDerivatives(array valueReferences: u32[nValueReferences],
        value nValueReferences: usize, array orders: i32[nValueReferences], out values: f64[nValues],
        value nValues: usize)
        |instance, _| {
            check_count("nValues", nValues, nValueReferences)?;
            instance.output_derivatives(valueReferences, orders, |i, x| values.put(i, x))
        };

    "5.2.2":
    /// Never allowed: Scheduled Execution is not offered.
    fmi3ActivateModelPartition, ActivateModelPartition(value clockReference: u32, value activationTime: f64)
        |_, _| Outcome::Ok(());
}
