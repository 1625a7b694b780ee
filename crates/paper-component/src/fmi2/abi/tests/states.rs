//! Every function in every state of both state machines.

use super::*;
use crate::component::Phase;
use crate::fmi2::states::{FUNCTIONS, Stage};

/// Calls a function with arguments that are legal wherever the call is.
unsafe fn play(c: FmiComponent, function: Function) -> FmiStatus {
    let vr = [reference("box.f")];
    let (vr, mut real, mut flag, mut other) = (vr.as_ptr(), 0.0, 0, 0);
    let mut six = [0.0; 6];
    let (x, one, state) = (six.as_mut_ptr(), [1].as_ptr(), &mut null_mut());
    unsafe {
        match function {
            Function::SetDebugLogging => fmi2SetDebugLogging(c, 1, 0, null()),
            Function::FreeInstance => OK,
            Function::SetupExperiment => fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
            Function::EnterInitializationMode => fmi2EnterInitializationMode(c),
            Function::ExitInitializationMode => fmi2ExitInitializationMode(c),
            Function::Terminate => fmi2Terminate(c),
            Function::Reset => fmi2Reset(c),
            Function::GetReal => fmi2GetReal(c, vr, 1, &mut real),
            Function::GetInteger => fmi2GetInteger(c, vr, 0, &mut flag),
            Function::GetBoolean => fmi2GetBoolean(c, vr, 0, &mut flag),
            Function::GetString => fmi2GetString(c, vr, 0, &mut null()),
            Function::SetReal => fmi2SetReal(c, vr, 1, &real),
            Function::SetInteger => fmi2SetInteger(c, vr, 0, &flag),
            Function::SetBoolean => fmi2SetBoolean(c, vr, 0, &flag),
            Function::SetString => fmi2SetString(c, vr, 0, &null()),
            Function::GetFMUstate => fmi2GetFMUstate(c, state),
            Function::SetFMUstate => fmi2SetFMUstate(c, *state),
            Function::FreeFMUstate => fmi2FreeFMUstate(c, state),
            Function::SerializedFMUstateSize => fmi2SerializedFMUstateSize(c, *state, &mut 0),
            Function::SerializeFMUstate => fmi2SerializeFMUstate(c, *state, null_mut(), 0),
            Function::DeSerializeFMUstate => fmi2DeSerializeFMUstate(c, null(), 0, state),
            Function::GetDirectionalDerivative => {
                fmi2GetDirectionalDerivative(c, vr, 0, vr, 0, &real, &mut 0.0)
            }
            Function::EnterEventMode => fmi2EnterEventMode(c),
            Function::NewDiscreteStates => fmi2NewDiscreteStates(c, &mut FmiEventInfo::default()),
            Function::EnterContinuousTimeMode => fmi2EnterContinuousTimeMode(c),
            Function::CompletedIntegratorStep => fmi2CompletedIntegratorStep(c, 1, &mut flag, &mut other),
            Function::SetTime => fmi2SetTime(c, 0.0),
            Function::SetContinuousStates => fmi2SetContinuousStates(c, x, 6),
            Function::GetEventIndicators => fmi2GetEventIndicators(c, x, 3),
            Function::GetContinuousStates => fmi2GetContinuousStates(c, x, 6),
            Function::GetDerivatives => fmi2GetDerivatives(c, x, 6),
            Function::GetNominalsOfContinuousStates => fmi2GetNominalsOfContinuousStates(c, x, 6),
            Function::SetRealInputDerivatives => fmi2SetRealInputDerivatives(c, vr, 1, one, &real),
            Function::GetRealOutputDerivatives => {
                fmi2GetRealOutputDerivatives(c, &reference("box.s"), 1, one, &mut real)
            }
            Function::DoStep => fmi2DoStep(c, 0.0, 1.0, 1),
            Function::CancelStep => fmi2CancelStep(c),
            Function::GetStatus => fmi2GetStatus(c, 0, &mut flag),
            Function::GetRealStatus => fmi2GetRealStatus(c, 2, &mut real),
            Function::GetIntegerStatus => fmi2GetIntegerStatus(c, 0, &mut flag),
            Function::GetBooleanStatus => fmi2GetBooleanStatus(c, 3, &mut flag),
            Function::GetStringStatus => fmi2GetStringStatus(c, 1, &mut null()),
        }
    }
}

/// The phases of a component of either interface type; the standard's other states are never met.
const PHASES: [Phase; 8] = [
    Phase::Instantiated,
    Phase::Initialization,
    Phase::Event,
    Phase::Continuous,
    Phase::Step,
    Phase::StoppedEarly,
    Phase::Terminated,
    Phase::Broken,
];

/// An instance brought to `phase` by calls where there is a way, else put there.
fn brought_to(interface: Interface, phase: Phase) -> Host {
    let host = Host::new(interface);
    let way: &[Function] = match (interface, phase) {
        (_, Phase::Instantiated) => &[],
        (_, Phase::Initialization) => &[Function::SetupExperiment, Function::EnterInitializationMode],
        (Interface::CoSimulation, _) | (_, Phase::Event) => {
            &[Function::SetupExperiment, Function::EnterInitializationMode, Function::ExitInitializationMode]
        }
        (Interface::ModelExchange, _) => &[
            Function::SetupExperiment,
            Function::EnterInitializationMode,
            Function::ExitInitializationMode,
            Function::NewDiscreteStates,
            Function::EnterContinuousTimeMode,
        ],
    };
    for function in way {
        assert_eq!(unsafe { play(host.c, *function) }, OK, "{function:?}: {}", host.last());
    }
    let component = unsafe { &*host.c.cast::<Shared<Instance>>() };
    component.borrow_mut().0.component.force(phase);
    host
}

fn belongs(interface: Interface, phase: Phase) -> bool {
    match interface {
        Interface::CoSimulation => !matches!(phase, Phase::Event | Phase::Continuous),
        Interface::ModelExchange => !matches!(phase, Phase::Step | Phase::StoppedEarly),
    }
}

#[test]
fn every_cell_of_both_state_machines() {
    for interface in [Interface::CoSimulation, Interface::ModelExchange] {
        if interface == Interface::ModelExchange && !description::MODEL_EXCHANGE {
            continue;
        }
        for phase in PHASES.into_iter().filter(|phase| belongs(interface, *phase)) {
            let stage = Stage::of(phase);
            for function in FUNCTIONS {
                if *function == Function::FreeInstance {
                    continue; // every instance is freed, in every state
                }
                let host = brought_to(interface, phase);
                let instance =
                    |host: &Host| unsafe { &*host.c.cast::<Shared<Instance>>() }.borrow().0.component.save();
                let before = instance(&host);
                let status = unsafe { play(host.c, *function) };
                let refusal =
                    format!("{}: not allowed in state {stage:?} of {}", function.name(), interface.name());
                let refused = host.last().contains(&refusal);
                let allowed = function.allowed(interface, stage);
                assert_eq!(refused, !allowed, "{refusal}: {}", host.last());
                if !allowed {
                    assert_eq!(status, ERROR, "{refusal}");
                    assert_eq!(instance(&host), before, "{refusal}");
                }
            }
        }
    }
}
