//! The C interface of FMI 2.0: every `extern "C"` of this door (FMI 2.0, 2.1, 3.2 and 4.2).
//!
//! The macro `export!` declares a function of the standard as in its C prototype, with the kind of each argument; from that it
//! checks handle, state, pointers and counts, turns pointers into safe types and calls the [`Instance`] or its component,
//! whose outcome becomes a status and a log message. Nothing is decided here. No panic leaves a function: one becomes
//! `fmi2Fatal` and marks the instance unusable. C enumerations arrive as integers and are checked, never taken as Rust
//! enums.

#![allow(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn)]
#![allow(non_snake_case)] // the standard's names

#[cfg(test)]
mod tests;

use super::instance::{BOOLEAN, INTEGER, Instance, REAL, STRING};
use super::problem::{Outcome, Problem};
use super::states::{self, Function};
use super::status::{self, StatusKind};
use super::types::{FmiBoolean, FmiEventInfo, FmiStatus};
use crate::component::log::{Categories, Category};
use crate::ffi::panics::{guarded, silence};
use crate::ffi::pointers::{aligned, array, c_str, handle, out, vector};
use crate::messages::{self, Sink, Status, c_text, report};
use std::cell::RefCell;
use std::ffi::{CString, c_char, c_int, c_void};
use std::ptr;

/// `fmi2Component`: opaque to the host.
pub type FmiComponent = *mut c_void;

/// `fmi2CallbackLogger`: variadic in C; called here with a finished message and no further arguments.
pub type FmiLogger =
    unsafe extern "C" fn(*mut c_void, *const c_char, FmiStatus, *const c_char, *const c_char, ...);

/// `fmi2CallbackFunctions` (FMI 2.0, 2.1.5). Only the logger is used; every member may be null.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct FmiCallbackFunctions {
    /// Takes log messages.
    pub logger: Option<FmiLogger>,
    /// Not used (`canNotUseMemoryManagementFunctions`).
    pub allocate_memory: Option<unsafe extern "C" fn(usize, usize) -> *mut c_void>,
    /// Not used.
    pub free_memory: Option<unsafe extern "C" fn(*mut c_void)>,
    /// Not used: steps are synchronous.
    pub step_finished: Option<unsafe extern "C" fn(*mut c_void, FmiStatus)>,
    /// Handed to the logger.
    pub component_environment: *mut c_void,
}

/// What a host's `fmi2Component` points to; borrowed while a call runs, so that a call from inside the logger is refused.
type Component = RefCell<(Instance, Host)>;

/// Where log messages go.
struct Host {
    name: CString,
    logger: Option<FmiLogger>,
    environment: *mut c_void,
}

impl Sink for Host {
    fn send(&mut self, status: Status, category: Category, message: &str) {
        let Some(logger) = self.logger else { return };
        let (category, message) = (c_text(messages::name(category)), status::finished(message));
        // SAFETY: the host vouches for its logger and environment until the instance is freed (FMI 2.0, 2.1.5); all
        // strings live until it returns; no % in the message asks for a further argument.
        unsafe {
            let (name, category, message) = (self.name.as_ptr(), category.as_ptr(), message.as_ptr());
            logger(self.environment, name, status as c_int, category, message);
        }
    }
}

/// Runs `body` on the instance behind `c`: handle, state machine, unwind guard, status and log message.
///
/// # Safety
/// `c` is null or from [`fmi2Instantiate`] and not freed, and no call on it is running in another thread.
#[inline]
unsafe fn call(
    c: FmiComponent,
    function: Function,
    body: impl FnOnce(&mut Instance, &mut Host) -> Outcome,
) -> FmiStatus {
    // SAFETY: null or from `Box::into_raw` in `fmi2Instantiate`; only shared, so a second call at a time finds it borrowed.
    let component = aligned(c.cast::<Component>(), "c").map(|c| unsafe { c.as_ref() });
    let Ok(Some(Ok(mut component))) = component.map(|c| c.map(RefCell::try_borrow_mut)) else {
        return Status::Error as FmiStatus;
    };
    let (instance, host) = &mut *component;
    let outcome = guarded(|| {
        instance.guard(function)?;
        body(instance, host)
    });
    match outcome {
        Ok(Ok(())) => Status::Ok as FmiStatus,
        Ok(Err(problem)) => refuse(instance, host, function, &problem),
        Err(panic) => {
            instance.component.break_down();
            refuse(instance, host, function, &panic.into())
        }
    }
}

/// Logs a problem and returns its status.
#[cold]
fn refuse(instance: &Instance, host: &mut Host, function: Function, problem: &Problem) -> FmiStatus {
    report(instance.enabled(), host, function.name(), problem.status(), problem);
    problem.status() as FmiStatus
}

/// What cannot fail.
fn done((): ()) -> Outcome {
    Ok(())
}

/// C type of an argument of this kind.
#[rustfmt::skip]
macro_rules! c_type {
    (flag) => { FmiBoolean };
    (value $type:ty) => { $type };
    (array $type:ty) => { *const $type };
    (vector $type:ty) => { *const $type };
    (out $type:ty) => { *mut $type };
    (texts) => { *const *const c_char };
    (state) => { *mut c_void };
    (handle) => { *mut *mut c_void };
}

/// An argument of this kind in safe types; to be used where `?` is.
#[rustfmt::skip]
macro_rules! checked {
    (flag $name:ident) => { $name != 0 };
    (value $name:ident) => { $name };
    (state $name:ident) => { $name.addr() };
    // SAFETY (all below): null or valid for that count, as the exported function's caller says.
    (array $name:ident $count:expr) => { unsafe { array($name, $count, stringify!($name)) }? };
    (vector $name:ident $count:expr) => {
        unsafe { vector($name, $count, (stringify!($name), stringify!($count))) }?
    };
    (out $name:ident $count:expr) => { unsafe { out($name, $count, stringify!($name)) }? };
    (handle $name:ident) => { unsafe { handle($name, stringify!($name)) }? };
    (texts $name:ident $count:expr) => {
        unsafe { array($name, $count, stringify!($name)) }?
            .iter()
            .map(|name| Ok(unsafe { c_str(*name, "category") }?.to_string_lossy()))
    };
}

/// Exports functions of the standard, by its clauses: name, row of the state tables, arguments after the component as
/// `kind name: type[count]`, and what is done with them.
macro_rules! export {
    ($($clause:literal: $($(#[$doc:meta])* $name:ident, $function:ident
        ($($kind:ident $argument:ident $(: $type:ty)? $([$count:expr])?),*)
        |$instance:ident, $host:pat_param| $body:expr;)*)*) => {$($(
        #[doc = concat!("`", stringify!($name), "` (FMI 2.0, ", $clause, ").")]
        $(#[$doc])*
        ///
        /// # Safety
        /// The component is null or from [`fmi2Instantiate`] and not freed, and no call on it is running in another thread.
        /// Every other pointer is null or valid for what the standard has there, with as many elements as the count says.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            c: FmiComponent,
            $($argument: c_type!($kind $($type)?),)*
        ) -> FmiStatus {
            let body = |$instance: &mut Instance, $host: &mut Host| -> Outcome {
                $(#[allow(unused_mut, unused_variables)]
                let mut $argument = checked!($kind $argument $($count)?);)*
                Ok($body?)
            };
            // SAFETY: as above.
            unsafe { call(c, Function::$function, body) }
        }
    )*)*};
}

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
/// `instanceName` and `fmuGUID` are null or C strings; `functions` is null or points to the callbacks, of which logger
/// and environment stay valid until the instance is freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2Instantiate(
    instanceName: *const c_char,
    fmuType: c_int,
    fmuGUID: *const c_char,
    _fmuResourceLocation: *const c_char,
    functions: *const FmiCallbackFunctions,
    _visible: FmiBoolean,
    loggingOn: FmiBoolean,
) -> FmiComponent {
    silence();
    // SAFETY: null or valid.
    let functions = aligned(functions.cast_mut(), "functions").ok().and_then(|f| unsafe { f.as_ref() });
    let mut host = Host {
        name: CString::default(),
        logger: functions.and_then(|functions| functions.logger),
        environment: functions.map_or(ptr::null_mut(), |functions| functions.component_environment),
    };
    let outcome = guarded(|| {
        // SAFETY: null or C strings.
        let (name, guid) = unsafe { (c_str(instanceName, "instanceName")?, c_str(fmuGUID, "fmuGUID")?) };
        host.name = name.to_owned();
        let interface = states::interface(fmuType)?;
        Instance::new(&name.to_string_lossy(), interface, &guid.to_string_lossy(), loggingOn != 0)
    });
    match outcome.map_err(Problem::from).flatten() {
        Ok(instance) => Box::into_raw(Box::new(Component::new((instance, host)))).cast(),
        Err(problem) => {
            report(Categories::ALL, &mut host, "fmi2Instantiate", problem.status(), &problem);
            ptr::null_mut()
        }
    }
}

/// `fmi2FreeInstance` (FMI 2.0, 2.1.5); also frees FMU states that were not. Null is ignored, and so is a call from inside
/// the instance's own logger.
///
/// # Safety
/// `c` is null or from [`fmi2Instantiate`] and not freed; nothing uses it or its FMU states afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2FreeInstance(c: FmiComponent) {
    let component = c.cast::<Component>();
    // SAFETY: null or from `Box::into_raw` in `fmi2Instantiate`.
    if unsafe { component.as_ref() }.is_some_and(|component| component.try_borrow_mut().is_ok()) {
        // SAFETY: as above, and no call is running.
        let component = unsafe { Box::from_raw(component) };
        let _ = guarded(|| drop(component));
    }
}

export! {
    "2.1.5":
    fmi2SetDebugLogging, SetDebugLogging(flag loggingOn, value nCategories: usize, texts categories[nCategories])
        |instance, _| instance.set_debug_logging(loggingOn, categories);

    "2.1.6":
    fmi2SetupExperiment, SetupExperiment(flag toleranceDefined, value tolerance: f64, value startTime: f64,
        flag stopTimeDefined, value stopTime: f64)
        |instance, _| instance.component.set_experiment(
            toleranceDefined.then_some(tolerance), startTime, stopTimeDefined.then_some(stopTime));
    fmi2EnterInitializationMode, EnterInitializationMode() |instance, _| instance.enter_initialization_mode();
    fmi2ExitInitializationMode, ExitInitializationMode() |instance, host| instance.exit_initialization_mode(host);
    fmi2Terminate, Terminate() |instance, _| done(instance.component.terminate());
    fmi2Reset, Reset() |instance, _| done(instance.component.reset());

    "2.1.7":
    fmi2GetReal, GetReal(array vr: u32[nvr], value nvr: usize, out value: f64[nvr])
        |instance, _| instance.component.get(REAL, vr, |i, x| value.put(i, x));
    fmi2GetInteger, GetInteger(array vr: u32[nvr], value nvr: usize, out value: c_int[nvr])
        |instance, _| instance.component.get(INTEGER, vr, |i, x| value.put(i, x as c_int));
    fmi2GetBoolean, GetBoolean(array vr: u32[nvr], value nvr: usize, out value: FmiBoolean[nvr])
        |instance, _| instance.component.get(BOOLEAN, vr, |i, x| value.put(i, (x != 0.0).into()));
    /// There are no String variables, so any reference is an error.
    fmi2GetString, GetString(array vr: u32[nvr], value nvr: usize, out value: *const c_char[nvr])
        |instance, _| instance.component.get(STRING, vr, |i, _| value.put(i, c"".as_ptr()));
    fmi2SetReal, SetReal(array vr: u32[nvr], value nvr: usize, array value: f64[nvr])
        |instance, _| instance.component.set(REAL, vr, |i| value[i]);
    fmi2SetInteger, SetInteger(array vr: u32[nvr], value nvr: usize, array value: c_int[nvr])
        |instance, _| instance.component.set(INTEGER, vr, |i| value[i].into());
    fmi2SetBoolean, SetBoolean(array vr: u32[nvr], value nvr: usize, array value: FmiBoolean[nvr])
        |instance, _| instance.component.set(BOOLEAN, vr, |i| value[i].into());
    /// There are no String variables, so any reference is an error.
    fmi2SetString, SetString(array vr: u32[nvr], value nvr: usize, array value: *const c_char[nvr])
        |instance, _| instance.component.set(STRING, vr, |_| 0.0);

    "2.1.8":
    /// Writes into a new FMU state, or over one that this instance gave out.
    fmi2GetFMUstate, GetFMUstate(handle FMUstate)
        |instance, _| FMUstate.replace(|old| instance.save(old));
    /// Any address is safe: only those this instance gave out are accepted.
    fmi2SetFMUstate, SetFMUstate(state FMUstate) |instance, _| instance.restore(FMUstate);
    /// A null state is ignored.
    fmi2FreeFMUstate, FreeFMUstate(handle FMUstate) |instance, _| FMUstate.free(|old| instance.free(old));
    fmi2SerializedFMUstateSize, SerializedFMUstateSize(state FMUstate, out size: usize[1])
        |instance, _| size.give(instance.serialized(FMUstate).map(|bytes| bytes.len()));
    /// Into as many bytes as `fmi2SerializedFMUstateSize` says.
    fmi2SerializeFMUstate, SerializeFMUstate(state FMUstate, out serializedState: u8[size], value size: usize)
        |instance, _| serializedState.copy(&instance.serialized(FMUstate)?, "size");
    /// Writes into a new FMU state, or over one that this instance gave out.
    fmi2DeSerializeFMUstate, DeSerializeFMUstate(array serializedState: u8[size], value size: usize, handle FMUstate)
        |instance, _| FMUstate.replace(|old| instance.deserialize(serializedState, old));

    "2.1.9":
    fmi2GetDirectionalDerivative, GetDirectionalDerivative(
        array vUnknown_ref: u32[nUnknown], value nUnknown: usize,
        array vKnown_ref: u32[nKnown], value nKnown: usize,
        array dvKnown: f64[nKnown], out dvUnknown: f64[nUnknown])
        |instance, _| instance.component.directional_derivative(
            vUnknown_ref, vKnown_ref, dvKnown, |i, x| dvUnknown.put(i, x));

    "3.2.2":
    fmi2EnterEventMode, EnterEventMode() |instance, _| instance.component.enter_event();
    fmi2NewDiscreteStates, NewDiscreteStates(out eventInfo: FmiEventInfo[1])
        |instance, host| eventInfo.give(instance.new_discrete_states(host).map(FmiEventInfo::after_event));
    fmi2EnterContinuousTimeMode, EnterContinuousTimeMode() |instance, _| done(instance.component.enter_continuous());
    fmi2CompletedIntegratorStep, CompletedIntegratorStep(flag noSetFMUStatePriorToCurrentPoint,
        out enterEventMode: FmiBoolean[1], out terminateSimulation: FmiBoolean[1])
        |instance, _| {
            enterEventMode.give(instance.component.complete_integrator_step().map(Into::into))?;
            terminateSimulation.give(Outcome::Ok(0))
        };

    "3.2.1":
    fmi2SetTime, SetTime(value time: f64) |instance, _| instance.component.set_time(time);
    fmi2SetContinuousStates, SetContinuousStates(vector x: f64[nx], value nx: usize)
        |instance, _| instance.component.set_continuous_states(x);

    "3.2.2":
    fmi2GetDerivatives, GetDerivatives(out derivatives: f64[nx], value nx: usize)
        |instance, _| derivatives.copy(&instance.component.state_derivatives()?, "nx");
    fmi2GetEventIndicators, GetEventIndicators(out eventIndicators: f64[ni], value ni: usize)
        |instance, _| eventIndicators.copy(&instance.component.event_indicators()?, "ni");
    fmi2GetContinuousStates, GetContinuousStates(out x: f64[nx], value nx: usize)
        |instance, _| x.copy(&instance.component.continuous_states()?, "nx");
    fmi2GetNominalsOfContinuousStates, GetNominalsOfContinuousStates(out x_nominal: f64[nx], value nx: usize)
        |instance, _| x_nominal.copy(&instance.component.nominals(), "nx");

    "4.2.1":
    fmi2SetRealInputDerivatives, SetRealInputDerivatives(
        array vr: u32[nvr], value nvr: usize, array order: c_int[nvr], array value: f64[nvr])
        |instance, _| instance.component.set_input_derivatives(vr, order, value);
    fmi2GetRealOutputDerivatives, GetRealOutputDerivatives(
        array vr: u32[nvr], value nvr: usize, array order: c_int[nvr], out value: f64[nvr])
        |instance, _| instance.component.output_derivatives(vr, order, |i, x| value.put(i, x));

    "4.2.2":
    /// Whether the host may come back to an earlier time makes no difference here: nothing
    /// is buffered.
    fmi2DoStep, DoStep(value currentCommunicationPoint: f64, value communicationStepSize: f64,
        flag noSetFMUStatePriorToCurrentPoint)
        |instance, host| instance.do_step(currentCommunicationPoint, communicationStepSize, host);
    /// Never allowed, since steps are synchronous.
    fmi2CancelStep, CancelStep() |instance, _| instance.cancel_step();

    "4.2.3":
    /// The status of asynchronous steps, of which there are none.
    fmi2GetStatus, GetStatus(value s: c_int, out value: FmiStatus[1])
        |_instance, _| Outcome::Err(StatusKind::from_number(s)?.not_available());
    /// `fmi2LastSuccessfulTime`.
    fmi2GetRealStatus, GetRealStatus(value s: c_int, out value: f64[1])
        |instance, _| value.give(instance.real_status(StatusKind::from_number(s)?));
    /// There is no status of this type.
    fmi2GetIntegerStatus, GetIntegerStatus(value s: c_int, out value: c_int[1])
        |_instance, _| Outcome::Err(StatusKind::from_number(s)?.not_available());
    /// `fmi2Terminated`.
    fmi2GetBooleanStatus, GetBooleanStatus(value s: c_int, out value: FmiBoolean[1])
        |instance, _| value.give(instance.boolean_status(StatusKind::from_number(s)?).map(Into::into));
    /// The status of asynchronous steps, of which there are none.
    fmi2GetStringStatus, GetStringStatus(value s: c_int, out value: *const c_char[1])
        |_instance, _| Outcome::Err(StatusKind::from_number(s)?.not_available());
}
