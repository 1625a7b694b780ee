//! Every function in every state of the state machines of both versions.

use super::bouncing_ball::*;
use super::host::Host;
use super::{ERROR, HEIGHT, OK, token};
use fmi_doors::fmi2::{self, types::FmiEventInfo};
use fmi_doors::fmi3::{self, instance::Update};
use fmi_doors::tabular::{FromTable, Saved};
use fmi_doors::{Interface, Model, Phase};
use std::ffi::{c_int, c_void};
use std::ptr::{null, null_mut};

type Ball = FromTable<super::Ball>;

/// Calls a function with arguments that are right wherever the call is allowed.
unsafe fn play2(c: *mut c_void, function: fmi2::states::Function) -> c_int {
    use fmi2::states::Function as F;
    let (vr, mut real, mut flag, mut other) = (std::ptr::from_ref(&HEIGHT), 1.0, 0, 0);
    let (mut two, state) = ([0.0; 2], &mut null_mut());
    let x = two.as_mut_ptr();
    unsafe {
        match function {
            F::SetDebugLogging => fmi2SetDebugLogging(c, 1, 0, null()),
            F::FreeInstance => OK,
            F::SetupExperiment => fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
            F::EnterInitializationMode => fmi2EnterInitializationMode(c),
            F::ExitInitializationMode => fmi2ExitInitializationMode(c),
            F::Terminate => fmi2Terminate(c),
            F::Reset => fmi2Reset(c),
            F::GetReal => fmi2GetReal(c, vr, 1, &mut real),
            F::GetInteger => fmi2GetInteger(c, vr, 0, &mut flag),
            F::GetBoolean => fmi2GetBoolean(c, vr, 0, &mut flag),
            F::GetString => fmi2GetString(c, vr, 0, &mut null()),
            F::SetReal => fmi2SetReal(c, vr, 1, &real),
            F::SetInteger => fmi2SetInteger(c, vr, 0, &flag),
            F::SetBoolean => fmi2SetBoolean(c, vr, 0, &flag),
            F::SetString => fmi2SetString(c, vr, 0, &null()),
            F::GetFMUstate => fmi2GetFMUstate(c, state),
            F::SetFMUstate => fmi2SetFMUstate(c, *state),
            F::FreeFMUstate => fmi2FreeFMUstate(c, state),
            F::SerializedFMUstateSize => fmi2SerializedFMUstateSize(c, *state, &mut 0),
            F::SerializeFMUstate => fmi2SerializeFMUstate(c, *state, null_mut(), 0),
            F::DeSerializeFMUstate => fmi2DeSerializeFMUstate(c, null(), 0, state),
            F::GetDirectionalDerivative => fmi2GetDirectionalDerivative(c, vr, 0, vr, 0, &real, &mut 0.0),
            F::EnterEventMode => fmi2EnterEventMode(c),
            F::NewDiscreteStates => fmi2NewDiscreteStates(c, &mut FmiEventInfo::default()),
            F::EnterContinuousTimeMode => fmi2EnterContinuousTimeMode(c),
            F::CompletedIntegratorStep => fmi2CompletedIntegratorStep(c, 1, &mut flag, &mut other),
            F::SetTime => fmi2SetTime(c, 0.0),
            F::SetContinuousStates => fmi2SetContinuousStates(c, x, 2),
            F::GetEventIndicators => fmi2GetEventIndicators(c, x, 1),
            F::GetContinuousStates => fmi2GetContinuousStates(c, x, 2),
            F::GetDerivatives => fmi2GetDerivatives(c, x, 2),
            F::GetNominalsOfContinuousStates => fmi2GetNominalsOfContinuousStates(c, x, 2),
            F::SetRealInputDerivatives => fmi2SetRealInputDerivatives(c, vr, 1, &1, &real),
            F::GetRealOutputDerivatives => fmi2GetRealOutputDerivatives(c, vr, 1, &1, &mut real),
            F::DoStep => fmi2DoStep(c, 0.0, 1.0, 1),
            F::CancelStep => fmi2CancelStep(c),
            F::GetStatus => fmi2GetStatus(c, 0, &mut flag),
            F::GetRealStatus => fmi2GetRealStatus(c, 2, &mut real),
            F::GetIntegerStatus => fmi2GetIntegerStatus(c, 0, &mut flag),
            F::GetBooleanStatus => fmi2GetBooleanStatus(c, 3, &mut flag),
            F::GetStringStatus => fmi2GetStringStatus(c, 1, &mut null()),
        }
    }
}

/// Calls a function with arguments that are right wherever the call is allowed.
unsafe fn play3(c: *mut c_void, function: fmi3::states::Function) -> c_int {
    use fmi3::states::Function as F;
    let (vr, none) = (std::ptr::from_ref(&HEIGHT), null::<u32>());
    let (mut two, mut flags, mut size) = ([0.0; 2], [0_u8; 6], 0_usize);
    let (x, state) = (two.as_mut_ptr(), &mut null_mut());
    let [a, b, d, e, f, _] = &mut flags;
    unsafe {
        match function {
            F::SetDebugLogging => fmi3SetDebugLogging(c, 1, 0, null()),
            F::FreeInstance => OK,
            F::EnterInitializationMode => fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0),
            F::ExitInitializationMode => fmi3ExitInitializationMode(c),
            F::EnterEventMode => fmi3EnterEventMode(c),
            F::Terminate => fmi3Terminate(c),
            F::Reset => fmi3Reset(c),
            F::GetFloat32 => fmi3GetFloat32(c, none, 0, null_mut(), 0),
            F::GetFloat64 => fmi3GetFloat64(c, vr, 1, x, 1),
            F::GetInt8 => fmi3GetInt8(c, none, 0, null_mut(), 0),
            F::GetUInt8 => fmi3GetUInt8(c, none, 0, null_mut(), 0),
            F::GetInt16 => fmi3GetInt16(c, none, 0, null_mut(), 0),
            F::GetUInt16 => fmi3GetUInt16(c, none, 0, null_mut(), 0),
            F::GetInt32 => fmi3GetInt32(c, none, 0, null_mut(), 0),
            F::GetUInt32 => fmi3GetUInt32(c, none, 0, null_mut(), 0),
            F::GetInt64 => fmi3GetInt64(c, none, 0, null_mut(), 0),
            F::GetUInt64 => fmi3GetUInt64(c, none, 0, null_mut(), 0),
            F::GetBoolean => fmi3GetBoolean(c, none, 0, null_mut(), 0),
            F::GetString => fmi3GetString(c, none, 0, null_mut(), 0),
            F::GetBinary => fmi3GetBinary(c, none, 0, null_mut(), null_mut(), 0),
            F::GetClock => fmi3GetClock(c, none, 0, null_mut()),
            F::SetFloat32 => fmi3SetFloat32(c, none, 0, null(), 0),
            F::SetFloat64 => fmi3SetFloat64(c, vr, 1, &1.0, 1),
            F::SetInt8 => fmi3SetInt8(c, none, 0, null(), 0),
            F::SetUInt8 => fmi3SetUInt8(c, none, 0, null(), 0),
            F::SetInt16 => fmi3SetInt16(c, none, 0, null(), 0),
            F::SetUInt16 => fmi3SetUInt16(c, none, 0, null(), 0),
            F::SetInt32 => fmi3SetInt32(c, none, 0, null(), 0),
            F::SetUInt32 => fmi3SetUInt32(c, none, 0, null(), 0),
            F::SetInt64 => fmi3SetInt64(c, none, 0, null(), 0),
            F::SetUInt64 => fmi3SetUInt64(c, none, 0, null(), 0),
            F::SetBoolean => fmi3SetBoolean(c, none, 0, null(), 0),
            F::SetString => fmi3SetString(c, none, 0, null(), 0),
            F::SetBinary => fmi3SetBinary(c, none, 0, null(), null(), 0),
            F::SetClock => fmi3SetClock(c, none, 0, null()),
            F::GetNumberOfVariableDependencies => fmi3GetNumberOfVariableDependencies(c, *vr, &mut size),
            F::GetVariableDependencies => {
                fmi3GetVariableDependencies(c, *vr, null_mut(), null_mut(), null_mut(), null_mut(), 0)
            }
            F::GetFMUState => fmi3GetFMUState(c, state),
            F::SetFMUState => fmi3SetFMUState(c, *state),
            F::FreeFMUState => fmi3FreeFMUState(c, state),
            F::SerializedFMUStateSize => fmi3SerializedFMUStateSize(c, *state, &mut size),
            F::SerializeFMUState => fmi3SerializeFMUState(c, *state, null_mut(), 0),
            F::DeserializeFMUState => fmi3DeserializeFMUState(c, null(), 0, state),
            F::GetDirectionalDerivative => {
                fmi3GetDirectionalDerivative(c, none, 0, none, 0, null(), 0, null_mut(), 0)
            }
            F::GetAdjointDerivative => {
                fmi3GetAdjointDerivative(c, none, 0, none, 0, null(), 0, null_mut(), 0)
            }
            F::EnterConfigurationMode => fmi3EnterConfigurationMode(c),
            F::ExitConfigurationMode => fmi3ExitConfigurationMode(c),
            F::GetIntervalDecimal => fmi3GetIntervalDecimal(c, none, 0, null_mut(), null_mut()),
            F::GetIntervalFraction => fmi3GetIntervalFraction(c, none, 0, null_mut(), null_mut(), null_mut()),
            F::GetShiftDecimal => fmi3GetShiftDecimal(c, none, 0, null_mut()),
            F::GetShiftFraction => fmi3GetShiftFraction(c, none, 0, null_mut(), null_mut()),
            F::SetIntervalDecimal => fmi3SetIntervalDecimal(c, none, 0, null()),
            F::SetIntervalFraction => fmi3SetIntervalFraction(c, none, 0, null(), null()),
            F::SetShiftDecimal => fmi3SetShiftDecimal(c, none, 0, null()),
            F::SetShiftFraction => fmi3SetShiftFraction(c, none, 0, null(), null()),
            F::EvaluateDiscreteStates => fmi3EvaluateDiscreteStates(c),
            F::UpdateDiscreteStates => fmi3UpdateDiscreteStates(c, a, b, d, e, f, &mut *x),
            F::EnterContinuousTimeMode => fmi3EnterContinuousTimeMode(c),
            F::CompletedIntegratorStep => fmi3CompletedIntegratorStep(c, 1, a, b),
            F::SetTime => fmi3SetTime(c, 0.0),
            F::SetContinuousStates => fmi3SetContinuousStates(c, x, 2),
            F::GetContinuousStateDerivatives => fmi3GetContinuousStateDerivatives(c, x, 2),
            F::GetEventIndicators => fmi3GetEventIndicators(c, x, 1),
            F::GetContinuousStates => fmi3GetContinuousStates(c, x, 2),
            F::GetNominalsOfContinuousStates => fmi3GetNominalsOfContinuousStates(c, x, 2),
            F::GetNumberOfEventIndicators => fmi3GetNumberOfEventIndicators(c, &mut size),
            F::GetNumberOfContinuousStates => fmi3GetNumberOfContinuousStates(c, &mut size),
            F::EnterStepMode => fmi3EnterStepMode(c),
            F::GetOutputDerivatives => fmi3GetOutputDerivatives(c, none, 0, null(), null_mut(), 0),
            F::DoStep => fmi3DoStep(c, 0.0, 1.0, 1, a, b, d, &mut *x),
            F::ActivateModelPartition => fmi3ActivateModelPartition(c, 1, 0.0),
        }
    }
}

const INTERFACES: [Interface; 2] = [Interface::CoSimulation, Interface::ModelExchange];

/// Whether the function reads or writes no elements in [`play3`], which is allowed with null
/// pointers and any type.
fn has_no_elements(function: fmi3::states::Function) -> bool {
    let name = function.name();
    let is_typed = |kind: &str| {
        let rest = name.strip_prefix(kind).unwrap_or_default();
        rest.contains("Int") && !rest.contains("Interval")
            || ["Float32", "Boolean", "String", "Binary", "Clock"].contains(&rest)
    };
    is_typed("fmi3Get") || is_typed("fmi3Set")
}

/// An instance of FMI 2.0 in a phase, reached by calls if possible.
fn brought_to2(interface: Interface, phase: Phase) -> Host {
    use fmi2::states::Function as F;
    let host = Host::of_fmi2(c"ball", c_int::from(interface == Interface::CoSimulation), &token());
    let way = [F::SetupExperiment, F::EnterInitializationMode, F::ExitInitializationMode];
    let way = match phase {
        Phase::Instantiated => &way[..0],
        Phase::Initialization => &way[..2],
        _ => &way,
    };
    for function in way {
        assert_eq!(unsafe { play2(host.c, *function) }, OK, "{function:?}: {}", host.last());
    }
    let shared = unsafe { &*host.c.cast::<fmi2::abi::Shared<Ball>>() };
    shared.borrow_mut().0.component.life_mut().phase = phase;
    host
}

#[test]
fn every_cell_of_both_state_machines_of_fmi2() {
    use Phase as P;
    let saved = |host: &Host| -> Saved {
        unsafe { &*host.c.cast::<fmi2::abi::Shared<Ball>>() }.borrow().0.component.save().unwrap()
    };
    let own = |interface| match interface {
        Interface::CoSimulation => [P::Step, P::StoppedEarly],
        Interface::ModelExchange => [P::Event, P::Continuous],
    };
    for interface in INTERFACES {
        let common = [P::Instantiated, P::Initialization, P::Terminated, P::Broken];
        for phase in common.into_iter().chain(own(interface)) {
            let stage = fmi2::states::Stage::of(phase);
            for function in fmi2::states::FUNCTIONS {
                if *function == fmi2::states::Function::FreeInstance {
                    continue; // every instance is freed, in every state
                }
                let host = brought_to2(interface, phase);
                let before = saved(&host);
                let status = unsafe { play2(host.c, *function) };
                let refusal = format!(
                    "{}: cannot be called in state {stage:?} of {}",
                    function.name(),
                    interface.name()
                );
                let allowed = function.allowed(interface, stage);
                assert_eq!(host.last().contains(&refusal), !allowed, "{refusal}: {}", host.last());
                if !allowed {
                    assert_eq!((status, saved(&host)), (ERROR, before), "{refusal}");
                }
            }
        }
    }
}

/// An instance of FMI 3.0 in a state, reached by calls if possible; `None` if the interface type
/// does not have the state.
fn brought_to3(interface: Interface, stage: fmi3::states::Stage) -> Option<Host> {
    use fmi3::states::{Function as F, Stage as S};
    let (phase, calls) = match (interface, stage) {
        (_, S::Instantiated) => (Phase::Instantiated, 0),
        (_, S::InitializationMode) => (Phase::Initialization, 1),
        (_, S::EventMode) => (Phase::Event, 2),
        (Interface::CoSimulation, S::StepMode | S::IntermediateUpdateMode) => (Phase::Step, 4),
        (Interface::ModelExchange, S::ContinuousTimeMode) => (Phase::Continuous, 4),
        (_, S::Terminated) => (Phase::Terminated, 4),
        (_, S::Fatal) => (Phase::Broken, 4),
        _ => return None,
    };
    let leave = match interface {
        Interface::CoSimulation => F::EnterStepMode,
        Interface::ModelExchange => F::EnterContinuousTimeMode,
    };
    let host = Host::of_fmi3(interface);
    let way = [F::EnterInitializationMode, F::ExitInitializationMode, F::UpdateDiscreteStates, leave];
    for function in &way[..calls] {
        assert_eq!(unsafe { play3(host.c, *function) }, OK, "{function:?}: {}", host.last());
    }
    let shared = unsafe { &*host.c.cast::<fmi3::abi::Shared<Ball>>() };
    let instance = &mut shared.instance.borrow_mut().0;
    instance.component.life_mut().phase = phase;
    if stage == S::IntermediateUpdateMode {
        instance.update = Some(Update { time: 0.0, set_requested: false, can_return_early: false });
    }
    Some(host)
}

#[test]
fn every_cell_of_both_state_machines_of_fmi3() {
    for interface in INTERFACES {
        for stage in fmi3::states::STAGES {
            for function in fmi3::states::FUNCTIONS {
                if *function == fmi3::states::Function::FreeInstance {
                    continue; // every instance is freed, in every state but inside a callback
                }
                let Some(host) = brought_to3(interface, stage) else { continue };
                let instance = || {
                    let shared = unsafe { &*host.c.cast::<fmi3::abi::Shared<Ball>>() };
                    std::cell::RefMut::map(shared.instance.borrow_mut(), |both| &mut both.0)
                };
                let before = instance().component.save().unwrap();
                let phase = instance().component.life().phase;
                let status = unsafe { play3(host.c, *function) };
                let refusal = format!(
                    "{}: cannot be called in state {stage:?} of {}",
                    function.name(),
                    interface.name()
                );
                let allowed = function.allowed(interface, stage);
                assert_eq!(host.last().contains(&refusal), !allowed, "{refusal}: {}", host.last());
                if allowed && has_no_elements(*function) {
                    assert_eq!(status, OK, "{function:?}: {}", host.last());
                }
                let mut instance = instance();
                if !allowed {
                    let terminated = if phase == Phase::Broken { phase } else { Phase::Terminated };
                    assert_eq!((status, instance.component.life().phase), (ERROR, terminated), "{refusal}");
                    instance.component.life_mut().phase = phase;
                    assert_eq!(instance.component.save().unwrap(), before, "{refusal}");
                }
                instance.update = None; // inside a callback it would not be freed
            }
        }
    }
}

/// After an error only the functions of Terminated work; a saved state and Reset end this state.
#[test]
fn an_error_of_fmi3_leaves_terminated() {
    use fmi3::states::{Function as F, Stage as S};
    for interface in INTERFACES {
        let host = brought_to3(interface, S::EventMode).unwrap();
        let mut state = null_mut();
        unsafe {
            assert_eq!(fmi3GetFMUState(host.c, &mut state), OK);
            for lead_out in [true, false] {
                assert_eq!(fmi3EnterInitializationMode(host.c, 0, 0.0, 0.0, 0, 0.0), ERROR);
                for function in fmi3::states::FUNCTIONS {
                    let changes = matches!(function, F::Reset | F::SetFMUState);
                    let allowed = function.allowed(interface, S::Terminated) && !changes;
                    let status = play3(host.c, *function);
                    let known = host.last().contains("cannot be called in state Terminated");
                    assert!(allowed || known || changes, "{}: {status} {}", function.name(), host.last());
                    if *function == F::Reset {
                        assert_eq!(status, OK);
                        assert_eq!(fmi3SetTime(host.c, 0.0), ERROR);
                    }
                }
                let status = if lead_out { fmi3SetFMUState(host.c, state) } else { fmi3Reset(host.c) };
                assert_eq!(status, OK);
            }
            assert_eq!(fmi3EnterInitializationMode(host.c, 0, 0.0, 0.0, 0, 0.0), OK);
        }
    }
}
