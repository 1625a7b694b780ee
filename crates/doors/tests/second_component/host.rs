//! Hosts of both versions with a logger that keeps the messages.

use super::bouncing_ball::*;
use super::{OK, token};
use fmi_doors::Interface;
use fmi_doors::fmi2::abi::{FmiCallbackFunctions, FmiLogger};
use std::ffi::{CStr, c_char, c_int, c_void};
use std::ptr::{from_mut, null};

/// A logger of FMI 2.0 with the arguments that every message has, before the variadic ones.
pub type Plain = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char);

/// Callbacks with this logger and nothing else. On the platforms of the tests a variadic call
/// without variadic arguments is an ordinary call.
pub unsafe fn callbacks(logger: Plain, environment: *mut c_void) -> FmiCallbackFunctions {
    FmiCallbackFunctions {
        // Miri sees the difference, and stable Rust has no variadic function.
        logger: (!cfg!(miri)).then(|| unsafe { std::mem::transmute::<Plain, FmiLogger>(logger) }),
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: environment,
    }
}

unsafe fn keep(messages: *mut c_void, [first, category, message]: [&str; 3]) {
    let messages = unsafe { &mut *messages.cast::<Vec<String>>() };
    messages.push(format!("{first} {category} {message}"));
}

unsafe fn text<'a>(text: *const c_char) -> &'a str {
    unsafe { CStr::from_ptr(text) }.to_str().unwrap()
}

unsafe extern "C" fn keep2(
    messages: *mut c_void,
    name: *const c_char,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    unsafe { keep(messages, [&format!("{} {status}", text(name)), text(category), text(message)]) }
}

unsafe extern "C-unwind" fn keep3(
    messages: *mut c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    unsafe { keep(messages, [&status.to_string(), text(category), text(message)]) }
}

/// An instance of either version with its messages.
pub struct Host {
    #[allow(clippy::box_collection)] // its address is the logger's environment
    messages: Box<Vec<String>>,
    pub c: *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
}

impl Host {
    fn made(make: impl FnOnce(*mut c_void) -> *mut c_void, free: unsafe extern "C" fn(*mut c_void)) -> Self {
        let mut messages = Box::new(Vec::new());
        let c = make(from_mut(&mut *messages).cast());
        Self { messages, c, free }
    }

    /// An instance of FMI 2.0 for a `fmi2Type`.
    pub fn of_fmi2(name: &CStr, kind: c_int, guid: &CStr) -> Self {
        let name = name.to_owned(); // freed after the call
        let make = |environment| unsafe {
            let callbacks = callbacks(keep2, environment);
            fmi2Instantiate(name.as_ptr(), kind, guid.as_ptr(), null(), &callbacks, 0, 1)
        };
        Self::made(make, fmi2FreeInstance)
    }

    /// An instance of FMI 3.0, with event mode and steps that may end early.
    pub fn of_fmi3(interface: Interface) -> Self {
        let (name, token) = (c"ball".as_ptr(), token());
        let make = |environment| unsafe {
            let (token, log) = (token.as_ptr(), Some(keep3 as _));
            if interface == Interface::ModelExchange {
                return fmi3InstantiateModelExchange(name, token, null(), 0, 1, environment, log);
            }
            fmi3InstantiateCoSimulation(name, token, null(), 0, 1, 1, 1, null(), 0, environment, log, None)
        };
        Self::made(make, fmi3FreeInstance)
    }

    /// An instance of FMI 2.0 for Co-Simulation, at the start of the motion.
    pub fn begun() -> Self {
        let host = Self::of_fmi2(c"ball %d", 1, &token());
        unsafe {
            assert_eq!(fmi2SetupExperiment(host.c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi2EnterInitializationMode(host.c), OK);
            assert_eq!(fmi2ExitInitializationMode(host.c), OK);
        }
        host
    }

    pub fn last(&self) -> &str {
        self.messages.last().map_or("", String::as_str)
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        unsafe { (self.free)(self.c) }
    }
}
