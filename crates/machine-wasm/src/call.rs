//! Calls of the C functions of FMI 3.0, and the functions of the host as C callbacks.

#![allow(unsafe_code)] // pointers to own slices, and those that the doors give to callbacks

use crate::fmi::fmi3::types::Status;
use crate::fmi::fmi3::{callbacks, intermediate_update_callbacks, resource_dir_callbacks};
use fmi_doors::fmi3::abi::{FmiInstance, FmiIntermediateUpdate, FmiLogMessage};
use fmi_doors::fmi3::types::{FmiBoolean, FmiStatus};
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr;
use std::sync::Once;

/// The C functions.
pub mod c {
    use vibro_machine_component::Machine;
    fmi_doors::export_fmi3!(Machine);
}

/// The path of the resources, as the doors require one. Files are read by the host.
const RESOURCES: &CStr = c"resources/";

/// The status of WIT for a status of C.
pub fn status_of(status: FmiStatus) -> Status {
    match status {
        0 => Status::Ok,
        1 => Status::Warning,
        2 => Status::Discard,
        3 => Status::Error,
        _ => Status::Fatal,
    }
}

/// A result of WIT: `value`, or the status of a call that failed.
pub fn result<T>(status: FmiStatus, value: T) -> Result<T, Status> {
    match status_of(status) {
        Status::Ok | Status::Warning => Ok(value),
        failed => Err(failed),
    }
}

/// An instance of the C functions, freed when dropped.
pub struct Instance {
    /// The handle of the C functions.
    pub handle: FmiInstance,
    /// The instance's name, which messages have. Its address is the instance environment.
    name: CString,
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: from an instantiation, and freed once.
        unsafe { c::fmi3FreeInstance(self.handle) }
    }
}

/// Arguments of the host for a new instance.
pub struct Asked {
    /// Its name.
    pub name: String,
    /// The instantiation token.
    pub token: String,
    /// `visible` and `loggingOn`.
    pub flags: [bool; 2],
}

/// `eventModeUsed`, `earlyReturnAllowed` and `requiredIntermediateVariables`.
pub type Steps = (bool, bool, Vec<u32>);

impl Instance {
    /// A new instance, for Co-Simulation if `steps` is given; `None` after a log message.
    pub fn new(asked: Asked, steps: Option<Steps>) -> Option<Self> {
        static ONCE: Once = Once::new();
        ONCE.call_once(begin);
        let [visible, logging] = asked.flags.map(FmiBoolean::from);
        let (Ok(name), Ok(token)) = (CString::new(asked.name.as_str()), CString::new(asked.token)) else {
            let message = "instance-name or instantiation-token contains a zero character; expected none";
            callbacks::log_message(&asked.name, Status::Error, "logStatusError", message);
            return None;
        };
        let environment = name.as_ptr().cast_mut().cast::<c_void>();
        let log: Option<FmiLogMessage> = Some(log_message);
        let texts = [name.as_ptr(), token.as_ptr(), RESOURCES.as_ptr()];
        // SAFETY: C strings that live through the call; name and callbacks outlive the instance.
        let handle = unsafe {
            match steps {
                None => {
                    let [name, token, path] = texts;
                    c::fmi3InstantiateModelExchange(name, token, path, visible, logging, environment, log)
                }
                Some((event_mode, early, required)) => {
                    let asks = early || !required.is_empty();
                    let update = asks.then_some(intermediate_update as FmiIntermediateUpdate);
                    let [name, token, path] = texts;
                    let [event_mode, early] = [event_mode, early].map(FmiBoolean::from);
                    let (required, count) = (required.as_ptr(), required.len());
                    c::fmi3InstantiateCoSimulation(
                        name,
                        token,
                        path,
                        visible,
                        logging,
                        event_mode,
                        early,
                        required,
                        count,
                        environment,
                        log,
                        update,
                    )
                }
            }
        };
        (!handle.is_null()).then_some(Self { handle, name })
    }

    /// Logs a refusal of a function that FMI 3.0 does not have.
    pub fn refuse(&self, function: &str) -> Status {
        let message = format!("{function}: FMI 3.0 has no such function; derivatives of inputs are not used");
        callbacks::log_message(&self.name.to_string_lossy(), Status::Error, "logStatusError", &message);
        Status::Error
    }
}

/// Directs the reading of resources and the messages of panics to the host.
fn begin() {
    vibro_machine_component::read_resources_by(resource_dir_callbacks::read_file);
    std::panic::set_hook(Box::new(|panic| {
        callbacks::log_message("", Status::Fatal, "logStatusFatal", &panic.to_string());
    }));
}

/// `fmi3LogMessageCallback`.
unsafe extern "C-unwind" fn log_message(
    environment: *mut c_void,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    let texts = [environment.cast_const().cast(), category, message];
    // SAFETY: the doors give the instance's environment, and C strings.
    let [name, category, message] = unsafe { texts.map(|text| CStr::from_ptr(text).to_string_lossy()) };
    callbacks::log_message(&name, status_of(status), &category, &message);
}

/// `fmi3IntermediateUpdateCallback`.
unsafe extern "C-unwind" fn intermediate_update(
    _environment: *mut c_void,
    time: f64,
    set_requested: FmiBoolean,
    get_allowed: FmiBoolean,
    step_finished: FmiBoolean,
    can_return_early: FmiBoolean,
    early: *mut FmiBoolean,
    early_time: *mut f64,
) {
    let [set, get, finished, can] =
        [set_requested, get_allowed, step_finished, can_return_early].map(|flag| flag != 0);
    let (requested, at) = intermediate_update_callbacks::intermediate_update(time, set, get, finished, can);
    // SAFETY: the doors give addresses that are valid for the call.
    unsafe {
        early.write(requested.into());
        early_time.write(at);
    }
}

/// Calls a C function on an instance, with arguments that end with pointers to own slices.
macro_rules! called {
    ($instance:expr, $function:ident $(, $argument:expr)* $(,)?) => {
        // SAFETY: the instance is not freed; pointers are to slices of the given lengths, which live
        // through the call.
        unsafe { $crate::call::c::$function($instance.handle $(, $argument)*) }
    };
}
pub(crate) use called;

/// A saved state as bytes.
pub fn saved(instance: &Instance) -> Result<Vec<u8>, Status> {
    let (mut state, mut size) = (ptr::null_mut(), 0);
    result(called!(instance, fmi3GetFMUState, &raw mut state), ())?;
    let mut status = called!(instance, fmi3SerializedFMUStateSize, state, &raw mut size);
    let mut bytes = vec![0; size];
    if result(status, ()).is_ok() {
        status = called!(instance, fmi3SerializeFMUState, state, bytes.as_mut_ptr(), size);
    }
    called!(instance, fmi3FreeFMUState, &raw mut state);
    result(status, bytes)
}

/// Restores a saved state.
pub fn restore(instance: &Instance, bytes: &[u8]) -> Status {
    let mut state = ptr::null_mut();
    let mut status = called!(instance, fmi3DeserializeFMUState, bytes.as_ptr(), bytes.len(), &raw mut state);
    if result(status, ()).is_ok() {
        status = called!(instance, fmi3SetFMUState, state);
        called!(instance, fmi3FreeFMUState, &raw mut state);
    }
    status_of(status)
}
