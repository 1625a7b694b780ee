//! Wrong arguments and calls at wrong times through both doors: each is an error with a message,
//! no pointer is followed, nothing is changed, and no panic leaves a function.

use super::bouncing_ball::*;
use super::host::Host;
use super::{BOUNCES, ERROR, HEIGHT, OK, SPEED, token};
use fmi_doors::Interface;
use fmi_doors::tabular::FromTable;
use fmi_doors::{fmi2, fmi3};
use std::ffi::{CStr, c_int, c_void};
use std::ptr::{null, null_mut};

const DISCARD: c_int = 2;
const FATAL: c_int = 4;

/// A time of the fall, s: before the first bounce.
const FALL: f64 = 0.25;

#[test]
fn versions_and_platform_are_those_of_the_standards() {
    let text = |p| unsafe { CStr::from_ptr(p) };
    assert_eq!(text(fmi2GetVersion()), c"2.0");
    assert_eq!(text(fmi2GetTypesPlatform()), c"default");
    assert_eq!(text(fmi3GetVersion()), c"3.0");
}

#[test]
fn null_and_misaligned_pointers_and_impossible_counts_are_errors_of_fmi2() {
    let host = Host::begun();
    let c = host.c;
    let odd = |p: *mut c_void| p.wrapping_byte_add(1);
    let (references, mut values, mut state) = ([HEIGHT, SPEED], [0.0; 2], null_mut::<c_void>());
    let (vr, x) = (references.as_ptr(), values.as_mut_ptr());
    let odd_x = odd(x.cast()).cast::<f64>();
    unsafe {
        assert_eq!(fmi2GetReal(c, null(), 2, x), ERROR);
        let refusal = "fmi2GetReal: vr is null or misaligned: expected a valid pointer";
        assert_eq!(host.last(), format!("ball %d 3 logStatusError {refusal}"));
        assert_eq!(fmi2GetReal(c, vr, 1, odd_x), ERROR);
        assert!(host.last().ends_with("value is null or misaligned: expected a valid pointer"));
        assert_eq!(fmi2GetReal(c, null(), 0, null_mut()), OK);
        for status in [
            fmi2GetReal(odd(c), vr, 1, x),
            fmi2GetReal(c, vr, 2, null_mut()),
            fmi2GetReal(c, vr, usize::MAX, x),
            fmi2GetReal(c, vr, 1 << 61, x),
            fmi2SetReal(c, null(), 1, x),
            fmi2SetReal(c, vr, 1, null()),
            fmi2GetString(c, vr, 1, [null()].as_mut_ptr()),
            fmi2SetRealInputDerivatives(c, vr, 1, null(), x),
            fmi2GetFMUstate(c, null_mut()),
            fmi2GetFMUstate(c, odd((&raw mut state).cast()).cast()),
            fmi2SetFMUstate(c, null_mut()),
            fmi2GetRealStatus(c, 2, null_mut()),
            fmi2GetRealStatus(c, 2, odd_x),
            fmi2SetDebugLogging(c, 1, 1, null()),
            fmi2SetDebugLogging(c, 1, 1, [null()].as_ptr()),
            fmi2Reset(null_mut()),
            fmi2DoStep(null_mut(), 0.0, 1.0, 0),
        ] {
            assert_eq!(status, ERROR);
        }
        assert_eq!(fmi2FreeFMUstate(c, null_mut()), OK);
        fmi2FreeInstance(null_mut());
    }
}

/// FMI 3.0: the text of each error; then the instance is Terminated, and names the call that
/// caused it. Reset ends this state.
#[test]
fn wrong_calls_are_errors_of_fmi3_that_terminate_and_are_named() {
    let mut values = [0.0; 2];
    let v = values.as_mut_ptr();
    let odd = |p: *mut f64| p.wrapping_byte_add(1);
    type Wrong<'a> = (&'a str, &'a str, &'a dyn Fn(*mut c_void) -> c_int);
    // SAFETY (all): wrong as intended, and checked before anything is followed.
    let cases: [Wrong<'_>; 16] = unsafe {
        [
            (
                "GetFloat64",
                "value reference 0 is not a variable of type Float64: expected a value reference of the model",
                &|c| fmi3GetFloat64(c, &0, 1, v, 1),
            ),
            ("GetFloat64", "value reference 4294967295 is not a variable of type Float64", &|c| {
                fmi3GetFloat64(c, &u32::MAX, 1, v, 1)
            }),
            ("GetFloat64", "value reference 8 is not a variable of type Float64", &|c| {
                fmi3GetFloat64(c, &BOUNCES, 1, v, 1)
            }),
            ("GetFloat32", "is not a variable of type Float32", &|c| {
                fmi3GetFloat32(c, &HEIGHT, 1, &mut 0.0, 1)
            }),
            ("GetBinary", "is not a variable of type Binary", &|c| {
                fmi3GetBinary(c, &HEIGHT, 1, &mut 0, [null()].as_mut_ptr(), 1)
            }),
            ("GetFloat64", "nValues = 2: expected 1", &|c| fmi3GetFloat64(c, &HEIGHT, 1, v, 2)),
            ("SetFloat64", "nValues = 0: expected 1", &|c| fmi3SetFloat64(c, &HEIGHT, 1, null(), 0)),
            ("GetFloat64", "values is null or misaligned", &|c| fmi3GetFloat64(c, &HEIGHT, 1, null_mut(), 1)),
            ("GetFloat64", "values is null or misaligned", &|c| fmi3GetFloat64(c, &HEIGHT, 1, odd(v), 1)),
            ("GetFloat64", "valueReferences is null or misaligned", &|c| fmi3GetFloat64(c, null(), 1, v, 1)),
            ("GetFloat64", "number of elements", &|c| fmi3GetFloat64(c, &HEIGHT, usize::MAX, v, 1)),
            ("SetTime", "cannot be called in state StepMode of Co-Simulation", &|c| fmi3SetTime(c, 1.0)),
            ("SetFMUState", "", &|c| fmi3SetFMUState(c, std::ptr::without_provenance_mut(12345))),
            ("GetDirectionalDerivative", "nSeed = 1: expected 2", &|c| {
                fmi3GetDirectionalDerivative(c, &HEIGHT, 1, [2, 3].as_ptr(), 2, &1.0, 1, v, 1)
            }),
            ("SetFloat64", "v cannot be set at a communication point: only", &|c| {
                fmi3SetFloat64(c, &SPEED, 1, &1.0, 1)
            }),
            ("GetOutputDerivatives", "this FMU does not offer derivatives of outputs: its model", &|c| {
                fmi3GetOutputDerivatives(c, &HEIGHT, 1, &1, v, 1)
            }),
        ]
    };
    let host = Host::of_fmi3(Interface::CoSimulation);
    let c = host.c;
    unsafe {
        assert_eq!(fmi3Reset(null_mut()), ERROR);
        assert_eq!(fmi3Reset(c.wrapping_byte_add(1)), ERROR);
        fmi3FreeInstance(null_mut());
        fmi3FreeInstance(c.wrapping_byte_add(1));
    }
    let mut height = f64::NAN;
    for (function, text, wrong) in cases {
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi3ExitInitializationMode(c), OK);
            assert_eq!(fmi3EnterStepMode(c), OK);
            assert_eq!(step(c, 0.0, FALL), (OK, 0, 0, FALL));
            assert_eq!(wrong(c), ERROR, "{text}");
            assert!(
                host.last().starts_with("3 logStatusError") && host.last().contains(text),
                "{}",
                host.last()
            );
            // Getters work; a step does not, and always names the first error.
            assert_eq!(fmi3GetFloat64(c, &HEIGHT, 1, &mut height, 1), OK);
            assert_eq!(height, 1.0 - 0.5 * 9.81 * FALL * FALL);
            for _ in 0..2 {
                assert_eq!(step(c, FALL, 0.1), (ERROR, 0, 0, FALL));
                let cause = format!("Terminated of Co-Simulation, after an error in fmi3{function}: restore");
                assert!(host.last().contains(&cause), "{}", host.last());
            }
            assert_eq!(fmi3Reset(c), OK);
        }
    }
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), OK);
        assert_eq!(fmi3Terminate(c), OK);
        assert_eq!(step(c, 0.0, 1.0).0, ERROR);
        assert!(host.last().contains("Terminated of Co-Simulation: restore"), "{}", host.last());
    }
}

/// A step of FMI 3.0: status, eventHandlingNeeded, earlyReturn, lastSuccessfulTime.
pub unsafe fn step(c: *mut c_void, point: f64, size: f64) -> (c_int, u8, u8, f64) {
    let (mut event, mut terminate, mut early, mut time) = (7, 7, 7, f64::NAN);
    let status = unsafe { fmi3DoStep(c, point, size, 1, &mut event, &mut terminate, &mut early, &mut time) };
    (status, event, early, time)
}

/// In FMI 3.0 as well, an error of a step returns the time reached.
#[test]
fn steps_that_cannot_be_made_are_errors_at_the_time_reached() {
    for (point, size, text) in [
        (3.0, 1.0, "currentCommunicationPoint = 3 s"),
        (f64::NAN, 1.0, "currentCommunicationPoint = NaN"),
        (FALL, 0.0, "communicationStepSize = 0"),
        (FALL, -1.0, "communicationStepSize = -1"),
        (FALL, f64::INFINITY, "communicationStepSize = inf"),
        (FALL, 9.75, "step to t = 10 s: must end by the stop time 2 s"),
    ] {
        let host = Host::of_fmi3(Interface::CoSimulation);
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(host.c, 1, 1e-6, 0.0, 1, 2.0), OK);
            assert_eq!(fmi3ExitInitializationMode(host.c), OK);
            assert_eq!(fmi3EnterStepMode(host.c), OK);
            assert_eq!(step(host.c, 0.0, FALL).0, OK);
            assert_eq!(step(host.c, point, size), (ERROR, 0, 0, FALL), "{text}");
        }
        assert!(host.last().contains(text), "{}", host.last());
    }
}

#[test]
fn initialization_of_fmi2_without_an_experiment_is_an_error() {
    let host = Host::of_fmi2(c"ball", 1, &token());
    assert_eq!(unsafe { fmi2EnterInitializationMode(host.c) }, ERROR);
    assert!(host.last().ends_with("fmi2SetupExperiment must be called before"), "{}", host.last());
    assert_eq!(unsafe { fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 0, 0.0) }, OK);
    assert_eq!(unsafe { fmi2EnterInitializationMode(host.c) }, OK);
}

#[test]
fn event_mode_without_agreement_is_an_error() {
    let mut messages = Vec::new();
    let c = super::of_fmi3(0, 1, &mut messages);
    assert_eq!(unsafe { fmi3EnterEventMode(c) }, ERROR);
    let last = messages.last().unwrap();
    assert!(last.ends_with("eventModeUsed was false at the instantiation"), "{last}");
    unsafe { fmi3FreeInstance(c) };
}

#[test]
fn statuses_of_fmi2_are_those_of_synchronous_steps() {
    let host = Host::begun();
    let (mut time, mut flag, mut number) = (0.0, 1, 0);
    unsafe {
        assert_eq!(fmi2DoStep(host.c, 0.0, 1.5, 0), OK);
        assert_eq!(fmi2GetRealStatus(host.c, 2, &mut time), OK);
        assert_eq!(fmi2GetBooleanStatus(host.c, 3, &mut flag), OK);
        assert_eq!((time, flag), (1.5, 0));
        assert_eq!(fmi2GetStatus(host.c, 0, &mut number), DISCARD);
        assert!(host.last().contains("2 logStatusDiscard fmi2GetStatus: fmi2DoStepStatus is not"));
        assert_eq!(fmi2GetStringStatus(host.c, 1, &mut null()), DISCARD);
        assert_eq!(fmi2GetIntegerStatus(host.c, 0, &mut number), DISCARD);
        assert_eq!(fmi2GetRealStatus(host.c, 17, &mut time), ERROR);
        assert_eq!(fmi2CancelStep(host.c), ERROR);
    }
}

/// In FMI 2.0, and with the sizes and handles of another instance and of a freed state.
#[test]
fn states_belong_to_their_instance_and_have_their_size() {
    let (host, other) = (Host::begun(), Host::of_fmi2(c"b", 1, &token()));
    let c = host.c;
    let (mut state, mut copy, mut size) = (null_mut(), null_mut(), 0);
    let height = |c| {
        let mut height = f64::NAN;
        assert_eq!(unsafe { fmi2GetReal(c, &HEIGHT, 1, &mut height) }, OK);
        height.to_bits()
    };
    unsafe {
        assert_eq!(fmi2DoStep(c, 0.0, 1.1, 0), OK);
        assert_eq!(fmi2GetFMUstate(c, &mut state), OK);
        assert_eq!(fmi2DoStep(c, 1.1, 0.5, 0), OK);
        let end = height(c);
        assert_eq!(fmi2SetFMUstate(c, state), OK);
        assert_eq!(fmi2DoStep(c, 1.1, 0.5, 0), OK);
        assert_eq!(height(c), end);
        assert_eq!(fmi2SerializedFMUstateSize(c, state, &mut size), OK);
        let mut bytes = vec![0_u8; size];
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size - 1), ERROR);
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size), OK);
        assert_eq!(fmi2DeSerializeFMUstate(other.c, bytes.as_ptr(), size - 1, &mut copy), ERROR);
        assert!(copy.is_null());
        assert_eq!(fmi2DeSerializeFMUstate(other.c, bytes.as_ptr(), size, &mut copy), OK);
        assert_eq!(fmi2SetFMUstate(other.c, state), ERROR);
        assert_eq!(fmi2SetFMUstate(other.c, copy), OK);
        assert_eq!(fmi2DoStep(other.c, 1.1, 0.5, 0), OK);
        assert_eq!(height(other.c), end);
        let dangling = state;
        assert_eq!(fmi2FreeFMUstate(c, &mut state), OK);
        assert!(state.is_null());
        assert_eq!(fmi2FreeFMUstate(c, &mut state), OK);
        assert_eq!(fmi2SetFMUstate(c, dangling), ERROR);
        // `copy` is freed with its instance.
    }
}

#[test]
fn a_panic_makes_the_instance_fatal_and_nothing_leads_out() {
    let (two, three) = (Host::begun(), Host::of_fmi3(Interface::CoSimulation));
    type Ball = FromTable<super::Ball>;
    unsafe {
        let get = fmi2::states::Function::GetReal;
        assert_eq!(fmi2::abi::call::<Ball>(two.c, get, |_, _| panic!("50 % of nothing")), FATAL);
        assert!(two.last().contains("4 logStatusFatal fmi2GetReal: internal error: 50 %% of nothing;"));
        let get = fmi3::states::Function::GetFloat64;
        assert_eq!(fmi3::abi::call::<Ball>(three.c, get, |_, _| panic!("50 % of nothing")), FATAL);
        assert!(three.last().contains("4 logStatusFatal fmi3GetFloat64: internal error: 50 % of nothing;"));
        for _ in 0..2 {
            assert_eq!(fmi2Reset(two.c), ERROR);
            assert!(two.last().ends_with("fmi2Reset: cannot be called in state Fatal of Co-Simulation"));
            assert_eq!(fmi3Reset(three.c), ERROR);
            assert!(three.last().ends_with("fmi3Reset: cannot be called in state Fatal of Co-Simulation"));
        }
    }
}
