//! Creation, logging and the life cycle of both interface types (FMI 2.0, 2.1.4 to 2.1.6).

use super::{
    Component, FmiBoolean, FmiCallbackFunctions, FmiComponent, FmiStatus, Host, call, slice, text, text_of,
};
use crate::fmi2::instance::{Instance, Outcome};
use crate::fmi2::logging::{Category, Log, Status};
use crate::fmi2::problem::Problem;
use crate::fmi2::states::{Function, Interface};
use std::ffi::{CStr, CString, c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// `fmi2GetTypesPlatform` (FMI 2.0, 2.1.4).
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

/// `fmi2GetVersion` (FMI 2.0, 2.1.4).
#[unsafe(no_mangle)]
pub extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

/// `fmi2Instantiate` (FMI 2.0, 2.1.5): a new instance, or null and a log message. The name is copied; resources and
/// visibility are not used. Instances are independent of each other and may be used from different threads, each from
/// one at a time.
///
/// # Safety
/// `instance_name` and `guid` are null or C strings; `functions` is null or points to the callbacks, which stay valid
/// until the instance is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instance_name: *const c_char,
    fmu_type: c_int,
    guid: *const c_char,
    _resource_location: *const c_char,
    functions: *const FmiCallbackFunctions,
    _visible: FmiBoolean,
    logging_on: FmiBoolean,
) -> FmiComponent {
    // SAFETY: null or valid.
    let functions = unsafe { functions.as_ref() };
    let mut host = Host {
        name: CString::default(),
        logger: functions.and_then(|functions| functions.logger),
        environment: functions.map_or(std::ptr::null_mut(), |functions| functions.component_environment),
    };
    let outcome = catch_unwind(AssertUnwindSafe(|| -> Outcome<Instance> {
        // SAFETY: null or C strings.
        let (name, guid) = unsafe { (text(instance_name, "instanceName")?, text(guid, "fmuGUID")?) };
        // SAFETY: not null, checked by `text`.
        host.name = unsafe { CStr::from_ptr(instance_name) }.to_owned();
        let interface = match fmu_type {
            0 => Interface::ModelExchange,
            1 => Interface::CoSimulation,
            _ => {
                return Err(Problem::Value {
                    name: "fmuType",
                    value: f64::from(fmu_type),
                    allowed: "0 (fmi2ModelExchange) or 1 (fmi2CoSimulation)",
                });
            }
        };
        Instance::new(&name, interface, &guid, logging_on != 0)
    }));
    let problem = match outcome {
        Ok(Ok(instance)) => return Box::into_raw(Box::new(Component { instance, host })).cast(),
        Ok(Err(problem)) => problem,
        Err(panic) => Problem::Panic { what: text_of(&*panic) },
    };
    let _ = catch_unwind(AssertUnwindSafe(|| {
        host.log(Status::Error, Category::Error, &format!("fmi2Instantiate: {problem}"));
    }));
    std::ptr::null_mut()
}

/// `fmi2FreeInstance` (FMI 2.0, 2.1.5); also frees FMU states that were not. Null is ignored.
///
/// # Safety
/// `c` is null or from [`fmi2Instantiate`] and not freed; nothing uses it or its FMU states afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: FmiComponent) {
    if !c.is_null() {
        // SAFETY: from `Box::into_raw` in `fmi2Instantiate`.
        let component = unsafe { Box::from_raw(c.cast::<Component>()) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(component)));
    }
}

/// `fmi2SetDebugLogging` (FMI 2.0, 2.1.5).
///
/// # Safety
/// `c` as in [`fmi2Reset`]; `categories` is null or points to `count` C strings.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetDebugLogging(
    c: FmiComponent,
    logging_on: FmiBoolean,
    count: usize,
    categories: *const *const c_char,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let categories = unsafe { slice(categories, count, "categories") }?;
        // SAFETY: as above.
        let names: Vec<_> = categories.iter().map(|name| unsafe { text(*name, "category") }).collect();
        let names = names.iter().map(|name| name.as_deref().map_err(Clone::clone));
        instance.set_debug_logging(logging_on != 0, names)
    };
    // SAFETY: as above.
    unsafe { call(c, Function::SetDebugLogging, body) }
}

/// `fmi2SetupExperiment` (FMI 2.0, 2.1.6).
///
/// # Safety
/// `c` as in [`fmi2Reset`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetupExperiment(
    c: FmiComponent,
    tolerance_defined: FmiBoolean,
    tolerance: f64,
    start_time: f64,
    stop_time_defined: FmiBoolean,
    stop_time: f64,
) -> FmiStatus {
    let tolerance = (tolerance_defined != 0).then_some(tolerance);
    let stop = (stop_time_defined != 0).then_some(stop_time);
    // SAFETY: as above.
    unsafe {
        call(c, Function::SetupExperiment, |instance, _| {
            instance.setup_experiment(tolerance, start_time, stop)
        })
    }
}

/// `fmi2EnterInitializationMode` (FMI 2.0, 2.1.6).
///
/// # Safety
/// `c` as in [`fmi2Reset`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterInitializationMode(c: FmiComponent) -> FmiStatus {
    // SAFETY: as above.
    unsafe { call(c, Function::EnterInitializationMode, |instance, _| instance.enter_initialization_mode()) }
}

/// `fmi2ExitInitializationMode` (FMI 2.0, 2.1.6).
///
/// # Safety
/// `c` as in [`fmi2Reset`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2ExitInitializationMode(c: FmiComponent) -> FmiStatus {
    // SAFETY: as above.
    unsafe {
        call(c, Function::ExitInitializationMode, |instance, host| instance.exit_initialization_mode(host))
    }
}

/// `fmi2Terminate` (FMI 2.0, 2.1.6).
///
/// # Safety
/// `c` as in [`fmi2Reset`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Terminate(c: FmiComponent) -> FmiStatus {
    // SAFETY: as above.
    unsafe { call(c, Function::Terminate, |instance, _| instance.terminate()) }
}

/// `fmi2Reset` (FMI 2.0, 2.1.6).
///
/// # Safety
/// `c` is null or from [`fmi2Instantiate`] and not freed, and no other call on it is running.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Reset(c: FmiComponent) -> FmiStatus {
    // SAFETY: as above.
    unsafe { call(c, Function::Reset, |instance, _| instance.reset()) }
}
