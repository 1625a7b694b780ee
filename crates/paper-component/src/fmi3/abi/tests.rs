#![allow(unsafe_code)] // the C interface

use super::*;
use crate::component::Interface;
use crate::fmi3::description;
use crate::fmi3::states::Function;
use crate::fmi3::types::{FmiBoolean, FmiStatus};
use fmi_doors::fmi3::abi::{Shared, call};
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};

mod callback;
mod random;
mod states;

const OK: FmiStatus = 0;
const ERROR: FmiStatus = 3;
const FATAL: FmiStatus = 4;

/// A host's logger.
unsafe extern "C-unwind" fn keep_message(
    environment: *mut c_void,
    status: FmiStatus,
    category: *const c_char,
    message: *const c_char,
) {
    let text = |p| unsafe { CStr::from_ptr(p) }.to_str().unwrap().to_owned();
    let messages = unsafe { &mut *environment.cast::<Vec<String>>() };
    messages.push(format!("{status} {} {}", text(category), text(message)));
}

struct Box3 {
    #[allow(clippy::box_collection)] // its address is the logger's environment
    messages: Box<Vec<String>>,
    c: FmiInstance,
}

fn vr(name: &str) -> u32 {
    description::value_reference(description::MAIN, name).unwrap()
}

fn token() -> CString {
    CString::new(description::instantiation_token(description::MAIN)).unwrap()
}

impl Box3 {
    fn new(interface: Interface) -> Self {
        let mut messages = Box::new(Vec::<String>::new());
        let (token, environment) = (token(), std::ptr::from_mut(&mut *messages).cast());
        let name = c"box".as_ptr();
        let c = unsafe {
            match interface {
                Interface::ModelExchange => fmi3InstantiateModelExchange(
                    name,
                    token.as_ptr(),
                    null(),
                    0,
                    1,
                    environment,
                    Some(keep_message),
                ),
                Interface::CoSimulation => fmi3InstantiateCoSimulation(
                    name,
                    token.as_ptr(),
                    null(),
                    0,
                    1,
                    1,
                    1,
                    null(),
                    0,
                    environment,
                    Some(keep_message),
                    None,
                ),
            }
        };
        Self { messages, c }
    }

    fn last(&self) -> &str {
        self.messages.last().map_or("", String::as_str)
    }
}

impl Drop for Box3 {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.c) }
    }
}

#[test]
fn the_version_is_3() {
    assert_eq!(unsafe { CStr::from_ptr(fmi3GetVersion()) }, c"3.0");
}

#[test]
fn null_and_misaligned_instances_are_errors() {
    let host = Box3::new(Interface::CoSimulation);
    unsafe {
        assert_eq!(fmi3Reset(null_mut()), ERROR);
        assert_eq!(fmi3Reset(host.c.wrapping_byte_add(1)), ERROR);
        assert_eq!(fmi3Reset(host.c), OK);
        fmi3FreeInstance(null_mut());
        fmi3FreeInstance(host.c.wrapping_byte_add(1));
    }
}

#[test]
fn a_panic_makes_the_instance_fatal() {
    let host = Box3::new(Interface::CoSimulation);
    let status = unsafe { call::<Instance>(host.c, Function::GetFloat64, |_, _| panic!("50 % of nothing")) };
    assert_eq!(status, FATAL);
    assert!(host.last().contains("4 logStatusFatal fmi3GetFloat64: internal error: 50 % of nothing;"));
    unsafe {
        // Nothing leads out of that.
        for _ in 0..2 {
            assert_eq!(fmi3Reset(host.c), ERROR);
            assert_eq!(
                host.last(),
                "3 logStatusError fmi3Reset: not allowed in state Fatal of Co-Simulation"
            );
        }
    }
}

/// A logger that calls back into the instance it is called by.
unsafe extern "C-unwind" fn call_back(
    environment: *mut c_void,
    _: FmiStatus,
    _: *const c_char,
    _: *const c_char,
) {
    let (c, statuses) = unsafe { &mut *environment.cast::<(FmiInstance, Vec<FmiStatus>)>() };
    unsafe {
        statuses.push(fmi3Reset(*c));
        fmi3FreeInstance(*c);
    }
}

#[test]
fn calls_from_inside_the_logger_are_refused_and_not_logged() {
    let mut seen = Box::new((null_mut(), Vec::<FmiStatus>::new()));
    let environment = std::ptr::from_mut(&mut *seen).cast();
    unsafe {
        let c = fmi3InstantiateModelExchange(
            c"a".as_ptr(),
            token().as_ptr(),
            null(),
            0,
            1,
            environment,
            Some(call_back),
        );
        seen.0 = c;
        assert_eq!(fmi3EnterStepMode(c), ERROR);
        assert_eq!(seen.1, [ERROR]);
        assert_eq!(fmi3Reset(c), OK);
        fmi3FreeInstance(c);
    }
}

/// A logger that unwinds: nothing crosses our frames.
unsafe extern "C-unwind" fn unwind(_: *mut c_void, _: FmiStatus, _: *const c_char, _: *const c_char) {
    panic!("in the logger");
}

#[test]
fn a_logger_that_unwinds_is_caught() {
    unsafe {
        let logger: FmiLogMessage = unwind;
        let c = fmi3InstantiateModelExchange(
            c"a".as_ptr(),
            token().as_ptr(),
            null(),
            0,
            1,
            null_mut(),
            Some(logger),
        );
        assert_eq!(fmi3EnterStepMode(c), ERROR);
        fmi3FreeInstance(c);
    }
}

#[test]
fn instances_live_side_by_side_in_threads() {
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                for _ in 0..25 {
                    let host = Box3::new(Interface::CoSimulation);
                    unsafe {
                        assert_eq!(fmi3EnterInitializationMode(host.c, 0, 0.0, 0.0, 0, 0.0), OK);
                        assert_eq!(fmi3ExitInitializationMode(host.c), OK);
                        assert_eq!(fmi3EnterStepMode(host.c), OK);
                        let (mut flags, mut time) = ([7; 3], 0.0);
                        let [event, terminate, early] = &mut flags;
                        assert_eq!(fmi3DoStep(host.c, 0.0, 50.0, 1, event, terminate, early, &mut time), OK);
                        assert!(time > 0.0 && *event == 1 && *early == 1 && *terminate == 0);
                    }
                }
            });
        }
    });
}
