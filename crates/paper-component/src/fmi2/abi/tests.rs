#![allow(unsafe_code)] // the C interface

use super::*;
use crate::component::Interface;
use crate::component::variables::reference;
use crate::fmi2::description;
use crate::fmi2::states::Function;
use crate::fmi2::types::{FmiEventInfo, FmiStatus};
use fmi_doors::fmi2::abi::{Shared, call};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};

mod random;
mod states;

const OK: FmiStatus = 0;
const DISCARD: FmiStatus = 2;
const ERROR: FmiStatus = 3;

/// Stands in for a host's logger: the arguments that are always there are those of the variadic
/// one.
unsafe extern "C" fn keep_message(
    environment: *mut c_void,
    name: *const c_char,
    status: FmiStatus,
    category: *const c_char,
    message: *const c_char,
) {
    let text = |p| unsafe { CStr::from_ptr(p) }.to_str().unwrap().to_owned();
    let messages = unsafe { &mut *environment.cast::<Vec<String>>() };
    messages.push(format!("{} {status} {} {}", text(name), text(category), text(message)));
}

type Plain = unsafe extern "C" fn(*mut c_void, *const c_char, FmiStatus, *const c_char, *const c_char);

/// Callbacks with that logger and nothing else. On the platforms of the tests a variadic call
/// without variadic arguments is an ordinary one.
unsafe fn callbacks(logger: Plain, environment: *mut c_void) -> FmiCallbackFunctions {
    FmiCallbackFunctions {
        // Miri knows the difference, and there is no other way to write one in stable Rust.
        logger: (!cfg!(miri)).then(|| unsafe { std::mem::transmute::<Plain, FmiLogger>(logger) }),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: environment,
    }
}

struct Host {
    #[allow(clippy::box_collection)] // its address is the logger's environment
    messages: Box<Vec<String>>,
    c: FmiComponent,
}

impl Host {
    fn new(interface: Interface) -> Self {
        let guid = CString::new(description::guid()).unwrap();
        let kind = match interface {
            Interface::ModelExchange => 0,
            Interface::CoSimulation => 1,
        };
        Self::with(c"box %d", kind, &guid)
    }

    fn with(name: &CStr, kind: c_int, guid: &CStr) -> Self {
        let mut messages = Box::new(Vec::<String>::new());
        let environment = std::ptr::from_mut(&mut *messages).cast();
        let functions = unsafe { callbacks(keep_message, environment) };
        let name = name.to_owned(); // freed after the call
        let c = unsafe { fmi2Instantiate(name.as_ptr(), kind, guid.as_ptr(), null(), &functions, 0, 1) };
        Self { messages, c }
    }

    fn initialized() -> Self {
        let host = Self::new(Interface::CoSimulation);
        unsafe {
            assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi2EnterInitializationMode(host.c), OK);
            assert_eq!(fmi2ExitInitializationMode(host.c), OK);
        }
        host
    }

    fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        let reference = reference(name);
        assert_eq!(unsafe { fmi2GetReal(self.c, &reference, 1, &mut value) }, OK);
        value
    }

    fn last(&self) -> &str {
        self.messages.last().map_or("", String::as_str)
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        unsafe { fmi2FreeInstance(self.c) }
    }
}

#[test]
fn version_and_platform() {
    let text = |p| unsafe { CStr::from_ptr(p) };
    assert_eq!(text(fmi2GetVersion()), c"2.0");
    assert_eq!(text(fmi2GetTypesPlatform()), c"default");
}

#[test]
fn a_step_through_the_c_interface() {
    let host = Host::initialized();
    assert_eq!(unsafe { fmi2DoStep(host.c, 0.0, 2.0, 1) }, OK);
    assert_eq!(host.get("time"), 2.0);
    let mut counts = [-1, -1];
    let references = [reference("impacts.upper"), reference("stop.state")];
    assert_eq!(unsafe { fmi2GetInteger(host.c, references.as_ptr(), 2, counts.as_mut_ptr()) }, OK);
    assert!(counts[0] >= 0 && counts[1] == 1);
    assert_eq!(unsafe { fmi2Terminate(host.c) }, OK);
    assert_eq!(host.get("time"), 2.0);
}

#[test]
fn failed_instantiation_says_why() {
    let guid = CString::new(description::guid()).unwrap();
    for (name, kind, guid, text) in [
        (c"a", 1, c"{no}", "a 3 logStatusError fmi2Instantiate: fmuGUID = \"{no}\": allowed is {"),
        (c" ", 1, &*guid, "  3 logStatusError fmi2Instantiate: instanceName = \" \": allowed is"),
        (c"a", 2, &*guid, "a 3 logStatusError fmi2Instantiate: fmuType = 2: allowed is 0"),
    ] {
        let host = Host::with(name, kind, guid);
        assert!(host.c.is_null());
        assert!(host.last().starts_with(text), "{}", host.last());
    }
    unsafe {
        assert!(fmi2Instantiate(null(), 1, guid.as_ptr(), null(), null(), 0, 0).is_null());
        assert!(fmi2Instantiate(c"a".as_ptr(), 1, null(), null(), null(), 0, 0).is_null());
        // No callbacks at all: an instance that logs nothing.
        let c = fmi2Instantiate(c"a".as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 1);
        assert!(!c.is_null());
        assert_eq!(fmi2DoStep(c, 0.0, 1.0, 0), ERROR);
        fmi2FreeInstance(c);
    }
}

#[test]
fn messages_are_finished_text() {
    let host = Host::new(Interface::CoSimulation);
    assert_eq!(unsafe { fmi2DoStep(host.c, 0.0, 1.0, 0) }, ERROR);
    assert_eq!(
        host.last(),
        "box %d 3 logStatusError fmi2DoStep: not allowed in state Instantiated of Co-Simulation"
    );
    let category = c"100 % #1".as_ptr();
    assert_eq!(unsafe { fmi2SetDebugLogging(host.c, 1, 1, &category) }, ERROR);
    assert!(host.last().contains("category = \"100 %% ##1\": allowed is logEvents, "), "{}", host.last());
}

/// A logger that calls back into the instance it is called by.
unsafe extern "C" fn call_back(
    environment: *mut c_void,
    _: *const c_char,
    _: FmiStatus,
    _: *const c_char,
    _: *const c_char,
) {
    let (c, statuses) = unsafe { &mut *environment.cast::<(FmiComponent, Vec<FmiStatus>)>() };
    unsafe {
        statuses.push(fmi2Reset(*c));
        fmi2FreeInstance(*c);
    }
}

#[test]
fn calls_from_inside_the_logger_are_refused() {
    let mut seen = Box::new((null_mut(), Vec::<FmiStatus>::new()));
    let guid = CString::new(description::guid()).unwrap();
    unsafe {
        let functions = callbacks(call_back, std::ptr::from_mut(&mut *seen).cast());
        let c = fmi2Instantiate(c"a".as_ptr(), 1, guid.as_ptr(), null(), &functions, 0, 1);
        seen.0 = c;
        assert_eq!(fmi2DoStep(c, 0.0, 1.0, 0), ERROR);
        assert_eq!(seen.1, [ERROR]);
        assert_eq!(fmi2Reset(c), OK);
        fmi2FreeInstance(c);
    }
}

#[test]
fn misaligned_pointers_are_errors() {
    let host = Host::initialized();
    let odd = |p: *mut c_void| p.wrapping_byte_add(1);
    let (mut reals, mut state) = ([0.0; 2], null_mut::<c_void>());
    let (vr, odd_reals) = (reference("box.s"), odd(reals.as_mut_ptr().cast()).cast());
    unsafe {
        assert_eq!(fmi2GetReal(odd(host.c), &vr, 1, reals.as_mut_ptr()), ERROR);
        assert_eq!(fmi2GetReal(host.c, &vr, 1, odd_reals), ERROR);
        assert!(host.last().ends_with("value is null or misaligned: allowed is a valid pointer"));
        assert_eq!(fmi2GetFMUstate(host.c, odd((&raw mut state).cast()).cast()), ERROR);
        assert_eq!(fmi2GetRealStatus(host.c, 2, odd_reals), ERROR);
    }
}

#[test]
fn null_pointers_and_impossible_counts_are_errors() {
    let host = Host::initialized();
    let c = host.c;
    let references = [reference("box.s"), reference("box.v")];
    let vr = references.as_ptr();
    let mut values = [0.0; 2];
    unsafe {
        assert_eq!(fmi2GetReal(c, null(), 2, values.as_mut_ptr()), ERROR);
        assert_eq!(
            host.last(),
            "box %d 3 logStatusError fmi2GetReal: vr is null or misaligned: allowed is a valid pointer"
        );
        assert_eq!(fmi2GetReal(c, vr, 2, null_mut()), ERROR);
        assert_eq!(fmi2GetReal(c, null(), 0, null_mut()), OK);
        assert_eq!(fmi2GetReal(c, vr, usize::MAX, values.as_mut_ptr()), ERROR);
        assert_eq!(fmi2GetReal(c, vr, 1 << 61, values.as_mut_ptr()), ERROR);
        assert_eq!(fmi2SetReal(c, null(), 1, values.as_ptr()), ERROR);
        assert_eq!(fmi2SetReal(c, vr, 1, null()), ERROR);
        assert_eq!(fmi2GetString(c, vr, 1, [null()].as_mut_ptr()), ERROR);
        assert_eq!(fmi2SetRealInputDerivatives(c, vr, 1, null(), values.as_ptr()), ERROR);
        assert_eq!(fmi2GetFMUstate(c, null_mut()), ERROR);
        assert_eq!(fmi2FreeFMUstate(c, null_mut()), OK);
        assert_eq!(fmi2SetFMUstate(c, null_mut()), ERROR);
        assert_eq!(fmi2GetRealStatus(c, 2, null_mut()), ERROR);
        assert_eq!(fmi2SetDebugLogging(c, 1, 1, null()), ERROR);
        assert_eq!(fmi2SetDebugLogging(c, 1, 1, [null()].as_ptr()), ERROR);
        for status in [fmi2Reset(null_mut()), fmi2DoStep(null_mut(), 0.0, 1.0, 0)] {
            assert_eq!(status, ERROR);
        }
        fmi2FreeInstance(null_mut());
    }
}

#[test]
fn statuses() {
    let host = Host::initialized();
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

#[test]
fn states_are_kept_serialized_and_freed() {
    let host = Host::initialized();
    let c = host.c;
    let mut state = null_mut();
    unsafe {
        assert_eq!(fmi2DoStep(c, 0.0, 13.7, 0), OK);
        assert_eq!(fmi2GetFMUstate(c, &mut state), OK);
        assert_eq!(fmi2DoStep(c, 13.7, 13.7, 0), OK);
        let end = host.get("block.s");
        assert_eq!(fmi2SetFMUstate(c, state), OK);
        assert_eq!(host.get("time"), 13.7);
        assert_eq!(fmi2DoStep(c, 13.7, 13.7, 0), OK);
        assert_eq!(host.get("block.s").to_bits(), end.to_bits());

        let mut size = 0;
        assert_eq!(fmi2SerializedFMUstateSize(c, state, &mut size), OK);
        let mut bytes = vec![0_u8; size];
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size - 1), ERROR);
        assert_eq!(fmi2SerializeFMUstate(c, state, bytes.as_mut_ptr(), size), OK);
        let other = Host::new(Interface::CoSimulation);
        let mut copy = null_mut();
        assert_eq!(fmi2DeSerializeFMUstate(other.c, bytes.as_ptr(), size - 1, &mut copy), ERROR);
        assert!(copy.is_null());
        assert_eq!(fmi2DeSerializeFMUstate(other.c, bytes.as_ptr(), size, &mut copy), OK);
        assert_eq!(fmi2SetFMUstate(other.c, state), ERROR); // another instance's
        assert_eq!(fmi2SetFMUstate(other.c, copy), OK);
        assert_eq!(fmi2DoStep(other.c, 13.7, 13.7, 0), OK);
        assert_eq!(other.get("block.s").to_bits(), end.to_bits());

        let dangling = state;
        assert_eq!(fmi2FreeFMUstate(c, &mut state), OK);
        assert!(state.is_null());
        assert_eq!(fmi2FreeFMUstate(c, &mut state), OK);
        assert_eq!(fmi2SetFMUstate(c, dangling), ERROR);
        // `copy` is freed with its instance.
    }
}

#[test]
fn a_step_after_an_impact_names_the_way_back() {
    let host = Host::new(Interface::CoSimulation);
    unsafe {
        assert_eq!(fmi2SetBoolean(host.c, &reference("stopAtImpact"), 1, &1), OK);
        assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(host.c), OK);
        assert_eq!(fmi2ExitInitializationMode(host.c), OK);
        assert_eq!(fmi2DoStep(host.c, 0.0, 40.0, 0), DISCARD);
        assert!(host.last().contains("2 logStatusDiscard fmi2DoStep: the step ended at the impact at t = "));
        let time = host.get("time");
        assert_eq!(fmi2DoStep(host.c, 40.0, 1.0, 0), ERROR);
        let refusal = format!(
            "currentCommunicationPoint = 40 s, but the last step ended at the impact at t = {time} s: restore the state saved \
             before the impact, or go on from lastSuccessfulTime"
        );
        assert!(host.last().ends_with(&refusal), "{}", host.last());
        assert_eq!(fmi2EnterInitializationMode(host.c), ERROR);
        let refusal = "StepFailed of Co-Simulation: restore the state saved before the impact, or go on from lastSuccessfulTime";
        assert!(host.last().ends_with(refusal), "{}", host.last());
    }
}

/// As fmusim does, with a load of its own; the same motion as of a host that goes back to the state
/// it saved.
#[test]
fn a_host_goes_on_from_an_impact_where_the_motion_stands() {
    const END: f64 = 60.0;
    const LOAD: f64 = 0.01;
    let begin = || {
        let host = Host::new(Interface::CoSimulation);
        unsafe {
            assert_eq!(fmi2SetBoolean(host.c, &reference("stopAtImpact"), 1, &1), OK);
            assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi2EnterInitializationMode(host.c), OK);
            assert_eq!(fmi2ExitInitializationMode(host.c), OK);
        }
        host
    };
    let (going_on, going_back) = (begin(), begin());
    let (mut time, mut stops) = (0.0, 0);
    while time < END {
        let load = if stops % 2 == 0 { LOAD } else { -LOAD };
        for host in [&going_on, &going_back] {
            assert_eq!(
                unsafe { fmi2SetReal(host.c, &reference("block.f"), 1, &load) },
                OK,
                "{}",
                host.last()
            );
        }
        let mut saved = null_mut();
        unsafe {
            assert_eq!(fmi2GetFMUstate(going_back.c, &mut saved), OK);
            let status = fmi2DoStep(going_on.c, time, END - time, 0);
            if status == OK {
                assert_eq!(fmi2DoStep(going_back.c, time, END - time, 0), OK);
                break;
            }
            assert_eq!(status, DISCARD, "{}", going_on.last());
            let mut reached = 0.0;
            assert_eq!(fmi2GetRealStatus(going_on.c, 2, &mut reached), OK);
            assert_eq!(fmi2DoStep(going_back.c, time, END - time, 0), DISCARD);
            assert_eq!(fmi2SetFMUstate(going_back.c, saved), OK);
            assert_eq!(fmi2DoStep(going_back.c, time, reached - time, 0), OK, "{}", going_back.last());
            (time, stops) = (reached, stops + 1);
        }
    }
    assert!(stops > 5, "{stops}");
    for name in ["box.s", "block.s", "block.v", "secondary.s", "energy.input"] {
        // A step up to the impact and one that stops there part by the last digit of its time.
        let (a, b) = (going_on.get(name), going_back.get(name));
        assert!((a - b).abs() < 1e-10, "{name}: {a} {b}");
    }
}

#[test]
fn a_panic_makes_the_instance_fatal() {
    let host = Host::initialized();
    let status = unsafe { call::<Instance>(host.c, Function::GetReal, |_, _| panic!("50 % of nothing")) };
    assert_eq!(status, 4);
    assert!(host.last().contains("4 logStatusFatal fmi2GetReal: internal error: 50 %% of nothing;"));
    unsafe {
        assert_eq!(fmi2Reset(host.c), ERROR);
        assert_eq!(
            host.last(),
            "box %d 3 logStatusError fmi2Reset: not allowed in state Fatal of Co-Simulation"
        );
    }
}
