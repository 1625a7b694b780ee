//! Functions of both interface types (FMI 2.0, 2.1).
#![allow(clippy::missing_safety_doc)] // each has its section; the first states the rule for `c` once

use super::{
    Component, FmiBoolean, FmiCallbackFunctions, FmiComponent, FmiStatus, Host, call, check_pointer, slice,
    text, text_of, write_one, writer,
};
use crate::fmi2::instance::{FmuState, Instance, Outcome};
use crate::fmi2::logging::{Category, Log, Status};
use crate::fmi2::problem::Problem;
use crate::fmi2::states::{Function, Interface};
use crate::fmi2::variables::Base;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
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

/// `fmi2GetReal` (FMI 2.0, 2.1.7).
///
/// # Safety
/// `c` as in [`fmi2Reset`]; `vr` and `value` are null or point to `nvr` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetReal(
    c: FmiComponent,
    vr: *const u32,
    nvr: usize,
    value: *mut f64,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let (references, write) = unsafe { (slice(vr, nvr, "vr")?, writer(value, nvr, "value")?) };
        instance.get(Base::Real, references, write)
    };
    // SAFETY: as above.
    unsafe { call(c, Function::GetReal, body) }
}

/// `fmi2GetInteger` (FMI 2.0, 2.1.7).
///
/// # Safety
/// As [`fmi2GetReal`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetInteger(
    c: FmiComponent,
    vr: *const u32,
    nvr: usize,
    value: *mut c_int,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let (references, mut write) = unsafe { (slice(vr, nvr, "vr")?, writer(value, nvr, "value")?) };
        instance.get(Base::Integer, references, |i, value| write(i, value as c_int))
    };
    // SAFETY: as above.
    unsafe { call(c, Function::GetInteger, body) }
}

/// `fmi2GetBoolean` (FMI 2.0, 2.1.7).
///
/// # Safety
/// As [`fmi2GetReal`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBoolean(
    c: FmiComponent,
    vr: *const u32,
    nvr: usize,
    value: *mut FmiBoolean,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let (references, mut write) = unsafe { (slice(vr, nvr, "vr")?, writer(value, nvr, "value")?) };
        instance.get(Base::Boolean, references, |i, value| write(i, FmiBoolean::from(value != 0.0)))
    };
    // SAFETY: as above.
    unsafe { call(c, Function::GetBoolean, body) }
}

/// `fmi2GetString` (FMI 2.0, 2.1.7): there are no String variables, so any reference is an error.
///
/// # Safety
/// As [`fmi2GetReal`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetString(
    c: FmiComponent,
    vr: *const u32,
    nvr: usize,
    value: *mut *const c_char,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let (references, mut write) = unsafe { (slice(vr, nvr, "vr")?, writer(value, nvr, "value")?) };
        instance.get(Base::String, references, |i, _| write(i, c"".as_ptr()))
    };
    // SAFETY: as above.
    unsafe { call(c, Function::GetString, body) }
}

/// `fmi2SetReal` (FMI 2.0, 2.1.7).
///
/// # Safety
/// `c` as in [`fmi2Reset`]; `vr` and `value` are null or point to `nvr` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetReal(
    c: FmiComponent,
    vr: *const u32,
    nvr: usize,
    value: *const f64,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let (references, values) = unsafe { (slice(vr, nvr, "vr")?, slice(value, nvr, "value")?) };
        instance.set(Base::Real, references, |i| values[i])
    };
    // SAFETY: as above.
    unsafe { call(c, Function::SetReal, body) }
}

/// `fmi2SetInteger` (FMI 2.0, 2.1.7).
///
/// # Safety
/// As [`fmi2SetReal`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetInteger(
    c: FmiComponent,
    vr: *const u32,
    nvr: usize,
    value: *const c_int,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let (references, values) = unsafe { (slice(vr, nvr, "vr")?, slice(value, nvr, "value")?) };
        instance.set(Base::Integer, references, |i| f64::from(values[i]))
    };
    // SAFETY: as above.
    unsafe { call(c, Function::SetInteger, body) }
}

/// `fmi2SetBoolean` (FMI 2.0, 2.1.7).
///
/// # Safety
/// As [`fmi2SetReal`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetBoolean(
    c: FmiComponent,
    vr: *const u32,
    nvr: usize,
    value: *const FmiBoolean,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let (references, values) = unsafe { (slice(vr, nvr, "vr")?, slice(value, nvr, "value")?) };
        instance.set(Base::Boolean, references, |i| f64::from(values[i]))
    };
    // SAFETY: as above.
    unsafe { call(c, Function::SetBoolean, body) }
}

/// `fmi2SetString` (FMI 2.0, 2.1.7): there are no String variables, so any reference is an error.
///
/// # Safety
/// As [`fmi2SetReal`].
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetString(
    c: FmiComponent,
    vr: *const u32,
    nvr: usize,
    value: *const *const c_char,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let (references, _) = unsafe { (slice(vr, nvr, "vr")?, slice(value, nvr, "value")?) };
        instance.set(Base::String, references, |_| 0.0)
    };
    // SAFETY: as above.
    unsafe { call(c, Function::SetString, body) }
}

/// `fmi2GetFMUstate` (FMI 2.0, 2.1.8).
///
/// # Safety
/// `c` as in [`fmi2Reset`]; `state` is null or points to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetFMUstate(c: FmiComponent, state: *mut *mut c_void) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        let saved = instance.fmu_state()?;
        // SAFETY: as above.
        unsafe { keep(instance, saved, state) }
    };
    // SAFETY: as above.
    unsafe { call(c, Function::GetFMUstate, body) }
}

/// Keeps a state and hands its address out; that address is only ever compared, never followed.
///
/// # Safety
/// `state` is null or points to a pointer.
unsafe fn keep(instance: &mut Instance, saved: FmuState, state: *mut *mut c_void) -> Outcome {
    check_pointer(state, "FMUstate")?;
    // SAFETY: not null.
    let old = unsafe { state.read() };
    let handle = instance.keep(saved, old.addr())?;
    // SAFETY: not null.
    unsafe { state.write(std::ptr::without_provenance_mut(handle)) };
    Ok(())
}

/// `fmi2SetFMUstate` (FMI 2.0, 2.1.8).
///
/// # Safety
/// `c` as in [`fmi2Reset`]. Any `state` is safe: only those this instance gave out are accepted.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: FmiComponent, state: *mut c_void) -> FmiStatus {
    // SAFETY: as above.
    unsafe { call(c, Function::SetFMUstate, |instance, _| instance.restore_kept(state.addr())) }
}

/// `fmi2FreeFMUstate` (FMI 2.0, 2.1.8). A null state is ignored.
///
/// # Safety
/// `c` as in [`fmi2Reset`]; `state` is null or points to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeFMUstate(c: FmiComponent, state: *mut *mut c_void) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        if state.is_null() {
            return Ok(());
        }
        check_pointer(state, "FMUstate")?;
        // SAFETY: not null.
        let handle = unsafe { state.read() }.addr();
        if handle != 0 {
            instance.free_kept(handle)?;
        }
        // SAFETY: not null.
        unsafe { state.write(std::ptr::null_mut()) };
        Ok(())
    };
    // SAFETY: as above.
    unsafe { call(c, Function::FreeFMUstate, body) }
}

/// `fmi2SerializedFMUstateSize` (FMI 2.0, 2.1.8).
///
/// # Safety
/// `c` as in [`fmi2Reset`]; any `state` is safe; `size` is null or points to a `size_t`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializedFMUstateSize(
    c: FmiComponent,
    state: *mut c_void,
    size: *mut usize,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        let count = || Ok(instance.kept(state.addr())?.serialize()?.len());
        // SAFETY: as above.
        unsafe { write_one(size, "size", count) }
    };
    // SAFETY: as above.
    unsafe { call(c, Function::SerializedFMUstateSize, body) }
}

/// `fmi2SerializeFMUstate` (FMI 2.0, 2.1.8).
///
/// # Safety
/// `c` as in [`fmi2Reset`]; any `state` is safe; `serialized` is null or points to `size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SerializeFMUstate(
    c: FmiComponent,
    state: *mut c_void,
    serialized: *mut u8,
    size: usize,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        let bytes = instance.kept(state.addr())?.serialize()?;
        check_pointer(serialized, "serializedState")?;
        if size != bytes.len() {
            return Err(Problem::Count {
                argument: "size",
                value: size,
                allowed: format!("{}, as fmi2SerializedFMUstateSize says", bytes.len()),
            });
        }
        // SAFETY: `size` bytes at a pointer that is not null, and ours do not overlap the host's.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), serialized, size) };
        Ok(())
    };
    // SAFETY: as above.
    unsafe { call(c, Function::SerializeFMUstate, body) }
}

/// `fmi2DeSerializeFMUstate` (FMI 2.0, 2.1.8).
///
/// # Safety
/// `c` as in [`fmi2Reset`]; `serialized` is null or points to `size` bytes; `state` is null or points to a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DeSerializeFMUstate(
    c: FmiComponent,
    serialized: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        check_pointer(serialized, "serializedState")?;
        // SAFETY: as above.
        let bytes = unsafe { slice(serialized, size, "serializedState") }?;
        let saved = FmuState::deserialize(bytes)?;
        // SAFETY: as above.
        unsafe { keep(instance, saved, state) }
    };
    // SAFETY: as above.
    unsafe { call(c, Function::DeSerializeFMUstate, body) }
}

/// `fmi2GetDirectionalDerivative` (FMI 2.0, 2.1.9).
///
/// # Safety
/// `c` as in [`fmi2Reset`]; the arrays are null or of `n_unknown` and `n_known` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDirectionalDerivative(
    c: FmiComponent,
    unknowns: *const u32,
    n_unknown: usize,
    knowns: *const u32,
    n_known: usize,
    seed: *const f64,
    result: *mut f64,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let (unknowns, knowns, seed, write) = unsafe {
            (
                slice(unknowns, n_unknown, "vUnknown_ref")?,
                slice(knowns, n_known, "vKnown_ref")?,
                slice(seed, n_known, "dvKnown")?,
                writer(result, n_unknown, "dvUnknown")?,
            )
        };
        instance.directional_derivative(unknowns, knowns, seed, write)
    };
    // SAFETY: as above.
    unsafe { call(c, Function::GetDirectionalDerivative, body) }
}
