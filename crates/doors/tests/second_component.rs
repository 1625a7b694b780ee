//! The bouncing ball of the examples through the C interface, as a host would run it: both
//! versions, both interface types, event mode, saved states, and refused functions.
#![allow(unsafe_code)] // the C interface

#[path = "second_component/arguments.rs"]
mod arguments;
#[path = "../examples/bouncing_ball/main.rs"]
mod bouncing_ball;
#[path = "common/calls.rs"]
mod calls;
#[path = "second_component/host.rs"]
mod host;
#[path = "second_component/logging.rs"]
mod logging;
#[path = "second_component/looked_into.rs"]
mod looked_into;
#[path = "second_component/random_calls.rs"]
mod random_calls;
#[path = "second_component/states.rs"]
mod states;

use bouncing_ball as component; // what the calls are of
use bouncing_ball::*;
use fmi_doors::fmi2::abi::{FmiCallbackFunctions, FmiComponent};
use fmi_doors::fmi2::types::FmiEventInfo;
use fmi_doors::fmi3::abi::FmiInstance;
use fmi_doors::tabular::FromTable;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};

const OK: c_int = 0;
const ERROR: c_int = 3;
const HEIGHT: u32 = 4;
const SPEED: u32 = 5;
const BOUNCES: u32 = 8;
/// Rounding of some ten flights of about a metre.
const ROUNDING: f64 = 1e-13;

/// Height and number of bounces at a time by the geometric series of the flights, for the start
/// values.
fn closed_form(time: f64) -> (f64, i32) {
    let (g, e, h) = (9.81_f64, 0.7_f64, 1.0_f64);
    let (mut begin, mut speed, mut bounces) = ((2.0 * h / g).sqrt(), (2.0 * g * h).sqrt(), 0);
    if time < begin {
        return (h - 0.5 * g * time * time, bounces);
    }
    loop {
        (speed, bounces) = (e * speed, bounces + 1);
        let length = 2.0 * speed / g;
        if time < begin + length {
            let dt = time - begin;
            return (speed * dt - 0.5 * g * dt * dt, bounces);
        }
        begin += length;
    }
}

unsafe extern "C-unwind" fn keep(
    messages: *mut c_void,
    _: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    let text = |p| unsafe { CStr::from_ptr(p) }.to_str().unwrap();
    let line = format!("{} {}", text(category), text(message));
    unsafe { &mut *messages.cast::<Vec<String>>() }.push(line);
}

fn token() -> CString {
    CString::new(FromTable::<Ball>::token()).unwrap()
}

/// An instance of FMI 3.0 at the end of initialization mode.
fn of_fmi3(event_mode: u8, early_return: u8, messages: &mut Vec<String>) -> FmiInstance {
    let environment = std::ptr::from_mut(messages).cast();
    unsafe {
        let c = fmi3InstantiateCoSimulation(
            c"ball".as_ptr(),
            token().as_ptr(),
            null(),
            0,
            1,
            event_mode,
            early_return,
            null(),
            0,
            environment,
            Some(keep),
            None,
        );
        assert!(!c.is_null(), "{messages:?}");
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), OK);
        c
    }
}

fn height(c: FmiInstance) -> (f64, i32) {
    let (mut height, mut bounces) = (f64::NAN, -1);
    unsafe {
        assert_eq!(fmi3GetFloat64(c, &HEIGHT, 1, &mut height, 1), OK);
        assert_eq!(fmi3GetInt32(c, &BOUNCES, 1, &mut bounces, 1), OK);
    }
    (height, bounces)
}

fn assert_near((height, bounces): (f64, i32), time: f64) {
    let (expected, count) = closed_form(time);
    assert!((height - expected).abs() < ROUNDING, "{height} {expected} at {time}");
    assert_eq!(bounces, count, "at {time}");
}

fn of_fmi2(kind: c_int) -> FmiComponent {
    unsafe {
        let callbacks: *const FmiCallbackFunctions = null();
        let c = fmi2Instantiate(c"ball".as_ptr(), kind, token().as_ptr(), null(), callbacks, 0, 0);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
        c
    }
}

#[test]
fn closed_form_of_the_bounces_in_steps_of_both_versions() {
    let mut messages = Vec::new();
    let (c3, c2) = (of_fmi3(0, 0, &mut messages), of_fmi2(1));
    let (mut flags, mut reached) = ([7; 3], 0.0);
    for step in 0..22 {
        let time = f64::from(step) * 0.1;
        let [event, terminate, early] = &mut flags;
        unsafe {
            assert_eq!(fmi3DoStep(c3, time, 0.1, 1, event, terminate, early, &mut reached), OK);
            assert_eq!((*event, *terminate, *early), (0, 0, 0));
            assert_eq!(fmi2DoStep(c2, time, 0.1, 1), OK);
            assert_near(height(c3), time + 0.1);
            let mut of2 = 0.0;
            assert_eq!(fmi2GetReal(c2, &HEIGHT, 1, &mut of2), OK);
            assert_eq!(of2.to_bits(), height(c3).0.to_bits());
        }
    }
    assert!(messages[0].starts_with("logEvents bounce, upwards with 3.1"), "{messages:?}");
    unsafe {
        fmi3FreeInstance(c3);
        fmi2FreeInstance(c2);
    }
}

#[test]
fn closed_form_of_the_bounces_in_event_mode() {
    let mut messages = Vec::new();
    let c = of_fmi3(1, 1, &mut messages);
    let (mut time, mut events) = (0.0, 0);
    while time < 2.0 {
        let mut update = [7; 5];
        let [needed, terminate, nominals, values, defined] = &mut update;
        let mut next = 0.0;
        unsafe {
            assert_eq!(
                fmi3UpdateDiscreteStates(c, needed, terminate, nominals, values, defined, &mut next),
                OK
            );
            assert_eq!((*needed, *terminate, *nominals, *defined), (0, 0, 0, 1));
            assert_eq!(*values, u8::from(events > 0));
            assert_near(height(c), time);
            assert_eq!(fmi3EnterStepMode(c), OK);
            let (mut flags, mut reached) = ([7; 3], 0.0);
            let [event, terminate, early] = &mut flags;
            assert_eq!(fmi3DoStep(c, time, 10.0, 1, event, terminate, early, &mut reached), OK);
            assert_eq!((*event, *early), (1, 1));
            assert_eq!(reached, next, "the announced event");
            assert_eq!(fmi3EnterEventMode(c), OK);
            (time, events) = (reached, events + 1);
        }
    }
    assert_eq!(events, closed_form(time + 1e-9).1);
    unsafe { fmi3FreeInstance(c) };
}

/// A host that continues from an event without handling it: its law is then applied, once.
#[test]
fn closed_form_of_a_bounce_that_the_host_did_not_handle() {
    let mut messages = Vec::new();
    let c = of_fmi3(1, 1, &mut messages);
    let (mut flags, mut reached, mut update, mut next) = ([7; 3], 0.0, [7; 5], 0.0);
    let [event, terminate, early] = &mut flags;
    let [needed, ends, nominals, values, defined] = &mut update;
    unsafe {
        assert_eq!(fmi3UpdateDiscreteStates(c, needed, ends, nominals, values, defined, &mut next), OK);
        assert_eq!(fmi3EnterStepMode(c), OK);
        assert_eq!(fmi3DoStep(c, 0.0, 1.0, 1, event, terminate, early, &mut reached), OK);
        assert_eq!((*early, reached), (1, next));
        assert_eq!(fmi3DoStep(c, reached, 0.8 - reached, 1, event, terminate, early, &mut reached), OK);
        assert_eq!((*early, reached), (0, 0.8));
        assert_near(height(c), 0.8);
        // Nothing remains to be handled.
        assert_eq!(fmi3EnterEventMode(c), OK);
        assert_eq!(fmi3UpdateDiscreteStates(c, needed, ends, nominals, values, defined, &mut next), OK);
        assert_eq!(*values, 0);
        assert_near(height(c), 0.8);
        fmi3FreeInstance(c);
    }
}

/// A host's solver of second order is exact on a parabola; it halves its step until it reaches the
/// impact.
#[test]
fn closed_form_of_the_bounces_in_model_exchange() {
    const FINE: f64 = 1e-12;
    let c = of_fmi2(0);
    let (mut time, mut x, mut rate, mut z) = (0.0, [0.0; 2], [0.0; 2], [0.0]);
    let mut info = FmiEventInfo::default();
    unsafe {
        assert_eq!(fmi2NewDiscreteStates(c, &mut info), OK);
        assert_eq!(fmi2EnterContinuousTimeMode(c), OK);
        while time < 1.5 {
            let mut step = 0.01;
            assert_eq!(fmi2GetContinuousStates(c, x.as_mut_ptr(), 2), OK);
            assert_eq!(fmi2GetDerivatives(c, rate.as_mut_ptr(), 2), OK);
            let crossed = loop {
                let next = [x[0] + step * (x[1] + 0.5 * step * rate[1]), x[1] + step * rate[1]];
                assert_eq!(fmi2SetTime(c, time + step), OK);
                assert_eq!(fmi2SetContinuousStates(c, next.as_ptr(), 2), OK);
                assert_eq!(fmi2GetEventIndicators(c, z.as_mut_ptr(), 1), OK);
                if z[0] > 0.0 || step < FINE {
                    break z[0] <= 0.0;
                }
                step *= 0.5;
            };
            time += step;
            if crossed {
                assert_eq!(fmi2EnterEventMode(c), OK);
                assert_eq!(fmi2NewDiscreteStates(c, &mut info), OK);
                assert_eq!(info.values_of_continuous_states_changed, 1);
                assert_eq!(fmi2EnterContinuousTimeMode(c), OK);
            }
            let (mut height, mut bounces) = (0.0, 0);
            assert_eq!(fmi2GetReal(c, &HEIGHT, 1, &mut height), OK);
            assert_eq!(fmi2GetInteger(c, &BOUNCES, 1, &mut bounces), OK);
            let (expected, count) = closed_form(time);
            // The host finds an impact to within a multiple of its finest step.
            assert!((height - expected).abs() < 1e3 * FINE || bounces != count, "{height} {expected} {time}");
        }
        let mut bounces = 0;
        assert_eq!(fmi2GetInteger(c, &BOUNCES, 1, &mut bounces), OK);
        assert_eq!(bounces, closed_form(time).1);
        // The number of states must match.
        assert_eq!(fmi2SetContinuousStates(c, x.as_ptr(), 3), ERROR);
        assert_eq!(fmi2GetDerivatives(c, x.as_mut_ptr(), 1), ERROR);
        fmi2FreeInstance(c);
    }
}

#[test]
fn states_are_kept_as_bytes_and_go_on_with_the_same_bits() {
    let mut messages = Vec::new();
    let mut others = Vec::new(); // the logger's, as long as the instance lives
    let (a, b) = (of_fmi3(0, 0, &mut messages), of_fmi3(0, 0, &mut others));
    let step = |c, time: f64, size| unsafe {
        let (mut flags, mut reached) = ([7; 3], 0.0);
        let [event, terminate, early] = &mut flags;
        assert_eq!(fmi3DoStep(c, time, size, 1, event, terminate, early, &mut reached), OK);
    };
    let (mut state, mut size) = (null_mut(), 0);
    unsafe {
        step(a, 0.0, 1.0);
        assert_eq!(fmi3GetFMUState(a, &mut state), OK);
        assert_eq!(fmi3SerializedFMUStateSize(a, state, &mut size), OK);
        let mut bytes = vec![0; size];
        assert_eq!(fmi3SerializeFMUState(a, state, bytes.as_mut_ptr(), size), OK);
        step(a, 1.0, 0.7);
        let mut copy = null_mut();
        assert_eq!(fmi3DeserializeFMUState(b, bytes.as_ptr(), size, &mut copy), OK);
        assert_eq!(fmi3SetFMUState(b, copy), OK);
        step(b, 1.0, 0.7);
        assert_eq!(height(a).0.to_bits(), height(b).0.to_bits());
        assert_eq!(fmi3DeserializeFMUState(a, bytes.as_ptr(), size - 1, &mut copy), ERROR);
        let last = messages.last().unwrap();
        assert!(last.starts_with("logStatusError fmi3DeserializeFMUState: saved state refused: "), "{last}");
        fmi3FreeInstance(a);
        fmi3FreeInstance(b);
    }
}

#[test]
fn a_value_that_the_model_cannot_take_is_discarded_and_the_instance_continues() {
    let mut messages = Vec::new();
    let c = of_fmi3(0, 0, &mut messages);
    unsafe {
        assert_eq!(fmi3Reset(c), OK);
        assert_eq!(fmi3SetFloat64(c, &3, 1, &1.5, 1), 2);
        let refusal = "fmi3SetFloat64: e = 1.5: expected a number from 0 to 1";
        assert_eq!(messages.last().unwrap(), &format!("logStatusDiscard {refusal}"));
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        fmi3FreeInstance(c);
    }
}

/// A solver may set values that a user may not: a ball a little below the floor is saved and read
/// again.
#[test]
fn every_state_that_is_reached_goes_through_bytes() {
    let (c, below) = (of_fmi2(0), [-1e-9, -4.0]);
    let (mut state, mut copy, mut size, mut x) = (null_mut(), null_mut(), 0, [0.0; 2]);
    unsafe {
        assert_eq!(fmi2NewDiscreteStates(c, &mut FmiEventInfo::default()), OK);
        assert_eq!(fmi2EnterContinuousTimeMode(c), OK);
        assert_eq!(fmi2SetContinuousStates(c, below.as_ptr(), 2), OK);
        assert_eq!(fmi2GetFMUstate(c, &mut state), OK);
        assert_eq!(fmi2SerializedFMUstateSize(c, state, &mut size), OK);
        let mut bytes = vec![0; size];
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size), OK);
        assert_eq!(fmi2SetContinuousStates(c, [1.0, 0.0].as_ptr(), 2), OK);
        assert_eq!(fmi2DeSerializeFMUstate(c, bytes.as_ptr(), size, &mut copy), OK);
        assert_eq!(fmi2SetFMUstate(c, copy), OK);
        assert_eq!(fmi2GetContinuousStates(c, x.as_mut_ptr(), 2), OK);
        assert_eq!(x, below);
        fmi2FreeInstance(c);
    }
}

/// A ball that loses nothing bounces for ever: a step with more impacts than allowed is refused,
/// and the ball stays where it was.
#[test]
fn steps_without_end_are_refused_and_taken_back() {
    let mut messages = Vec::new();
    let c = of_fmi3(0, 0, &mut messages);
    let (mut flags, mut reached) = ([7; 3], 0.0);
    let [event, terminate, early] = &mut flags;
    unsafe {
        assert_eq!(fmi3Reset(c), OK);
        assert_eq!(fmi3SetFloat64(c, [3, HEIGHT].as_ptr(), 2, [1.0, 1e-6].as_ptr(), 2), OK);
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), OK);
        assert_eq!(fmi3SetDebugLogging(c, 0, 1, [c"logEvents".as_ptr()].as_ptr()), OK);
        assert_eq!(fmi3DoStep(c, 0.0, 1e9, 1, event, terminate, early, &mut reached), ERROR);
        let last = messages.last().unwrap();
        assert!(last.contains("fmi3DoStep: a step with 1000000 events up to t = "), "{last}");
        assert_eq!(height(c), (1e-6, 0));
        fmi3FreeInstance(c);
    }
}
