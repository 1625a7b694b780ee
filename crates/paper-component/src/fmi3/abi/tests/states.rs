//! Every function in every state of both state machines.

use super::*;
use crate::component::Phase;
use crate::fmi3::instance::Update;
use crate::fmi3::states::{FUNCTIONS, STAGES, Stage};

/// Calls a function with arguments that are legal wherever the call is.
unsafe fn play(c: FmiInstance, function: Function) -> FmiStatus {
    use Function as F;
    let (vr, none) = ([vr("box.f")], null::<u32>());
    let (vr, real) = (vr.as_ptr(), [0.0]);
    let (mut six, mut flags, mut size) = ([0.0; 6], [0_u8; 6], 0_usize);
    let (x, state) = (six.as_mut_ptr(), &mut null_mut());
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
            F::SetFloat64 => fmi3SetFloat64(c, vr, 1, real.as_ptr(), 1),
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
            F::SetContinuousStates => fmi3SetContinuousStates(c, x, 6),
            F::GetContinuousStateDerivatives => fmi3GetContinuousStateDerivatives(c, x, 6),
            F::GetEventIndicators => fmi3GetEventIndicators(c, x, 3),
            F::GetContinuousStates => fmi3GetContinuousStates(c, x, 6),
            F::GetNominalsOfContinuousStates => fmi3GetNominalsOfContinuousStates(c, x, 6),
            F::GetNumberOfEventIndicators => fmi3GetNumberOfEventIndicators(c, &mut size),
            F::GetNumberOfContinuousStates => fmi3GetNumberOfContinuousStates(c, &mut size),
            F::EnterStepMode => fmi3EnterStepMode(c),
            F::GetOutputDerivatives => fmi3GetOutputDerivatives(c, none, 0, null(), null_mut(), 0),
            F::DoStep => fmi3DoStep(c, 0.0, 1.0, 1, a, b, d, &mut *x),
            F::ActivateModelPartition => fmi3ActivateModelPartition(c, 1, 0.0),
        }
    }
}

/// An instance brought to a state by calls where there is a way, else put there; none where there
/// is no such state.
fn brought_to(interface: Interface, stage: Stage) -> Option<Box3> {
    use Function as F;
    let phase = match (interface, stage) {
        (_, Stage::Instantiated) => Phase::Instantiated,
        (_, Stage::InitializationMode) => Phase::Initialization,
        (_, Stage::EventMode) => Phase::Event,
        (Interface::CoSimulation, Stage::StepMode | Stage::IntermediateUpdateMode) => Phase::Step,
        (Interface::ModelExchange, Stage::ContinuousTimeMode) => Phase::Continuous,
        (_, Stage::Terminated) => Phase::Terminated,
        (_, Stage::Fatal) => Phase::Broken,
        _ => return None,
    };
    let host = Box3::new(interface);
    let initialized = [F::EnterInitializationMode, F::ExitInitializationMode];
    let way = match (interface, phase) {
        (_, Phase::Instantiated) => vec![],
        (_, Phase::Initialization) => vec![F::EnterInitializationMode],
        (_, Phase::Event) => initialized.to_vec(),
        (Interface::CoSimulation, _) => {
            [&initialized[..], &[F::UpdateDiscreteStates, F::EnterStepMode]].concat()
        }
        (Interface::ModelExchange, _) => {
            [&initialized[..], &[F::UpdateDiscreteStates, F::EnterContinuousTimeMode]].concat()
        }
    };
    for function in way {
        assert_eq!(unsafe { play(host.c, function) }, OK, "{function:?}: {}", host.last());
    }
    let shared = unsafe { &*host.c.cast::<Shared<Instance>>() };
    let instance = &mut shared.instance.borrow_mut().0;
    instance.component.force(phase);
    if stage == Stage::IntermediateUpdateMode {
        instance.update = Some(Update { time: 0.0, set_requested: false, can_return_early: false });
    }
    Some(host)
}

#[test]
fn every_cell_of_both_state_machines() {
    for interface in [Interface::CoSimulation, Interface::ModelExchange] {
        for stage in STAGES {
            for function in FUNCTIONS {
                if *function == Function::FreeInstance {
                    continue; // every instance is freed, in every state but inside a callback
                }
                let Some(host) = brought_to(interface, stage) else { continue };
                let saved = |host: &Box3| {
                    let shared = unsafe { &*host.c.cast::<Shared<Instance>>() };
                    let instance = &mut shared.instance.borrow_mut().0;
                    let phase = instance.component.phase();
                    instance.component.force(Phase::Instantiated);
                    let saved = instance.component.save();
                    instance.component.force(phase);
                    (saved, phase)
                };
                let (before, phase) = saved(&host);
                let status = unsafe { play(host.c, *function) };
                let refusal =
                    format!("{}: not allowed in state {stage:?} of {}", function.name(), interface.name());
                let refused = host.last().contains(&refusal);
                let allowed = function.allowed(interface, stage);
                assert_eq!(refused, !allowed, "{refusal}: {}", host.last());
                if !allowed {
                    assert_eq!(status, ERROR, "{refusal}");
                    let (after, now) = saved(&host);
                    assert_eq!(after, before, "{refusal}");
                    let terminated = if phase == Phase::Broken { phase } else { Phase::Terminated };
                    assert_eq!(now, terminated, "{refusal}");
                }
                // Where it is not freed below.
                unsafe { &*host.c.cast::<Shared<Instance>>() }.instance.borrow_mut().0.update = None;
            }
        }
    }
}

/// After an error only the row of Terminated answers; a saved state and Reset lead out.
#[test]
fn an_error_leaves_terminated() {
    for interface in [Interface::CoSimulation, Interface::ModelExchange] {
        let host = brought_to(interface, Stage::EventMode).unwrap();
        let mut state = null_mut();
        unsafe {
            assert_eq!(fmi3GetFMUState(host.c, &mut state), OK);
            for lead_out in [true, false] {
                assert_eq!(fmi3EnterInitializationMode(host.c, 0, 0.0, 0.0, 0, 0.0), ERROR);
                for function in FUNCTIONS {
                    let changes = matches!(function, Function::Reset | Function::SetFMUState);
                    let allowed = function.allowed(interface, Stage::Terminated) && !changes;
                    let status = play(host.c, *function);
                    let known = host.last().contains("not allowed in state Terminated");
                    assert!(allowed || known || changes, "{}: {status} {}", function.name(), host.last());
                    if *function == Function::Reset {
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
