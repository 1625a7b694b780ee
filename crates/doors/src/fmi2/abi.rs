//! The C interface of FMI 2.0: every `extern "C"` of this door (FMI 2.0, 2.1, 3.2 and 4.2).
//!
//! The macro [`export_fmi2!`](crate::export_fmi2) makes the functions for one component. It is
//! expanded in the component's library, which exports the functions by name. It declares each
//! function as in the C prototype of the standard, and adds the kind of each argument. From these
//! kinds the function checks handle, state, pointers and counts, turns pointers into safe types
//! and calls the [`Instance`]. The outcome becomes a status and a log message. This module makes
//! no decisions about the model. A panic does not leave a function: it becomes `fmi2Fatal` and
//! marks the instance unusable. C enumerations arrive as integers and are checked, never taken as
//! Rust enums.

#![allow(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn)]

use super::instance::Instance;
use super::problem::{CallProblem, Outcome};
use super::states::Function;
use super::status;
use super::types::{FmiBoolean, FmiStatus};
use crate::component::Component;
use crate::ffi::panics::{guarded, silence};
use crate::ffi::pointers::{aligned, c_str};
use crate::log::{Categories, Category};
use crate::messages::{self, Sink, Status, c_text, report};
use core::ffi::{c_char, c_int, c_void};
use std::cell::RefCell;
use std::ffi::CString;
use std::ptr;

/// `fmi2Component`: opaque to the host.
pub type FmiComponent = *mut c_void;

/// `fmi2CallbackLogger`: variadic in C; called here with a finished message and no further
/// arguments.
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

/// Target of a host's `fmi2Component`. It is borrowed while a call runs, so that a call from
/// inside the logger is refused.
#[doc(hidden)]
pub type Shared<C> = RefCell<(Instance<C>, Host)>;

/// Destination of log messages.
#[derive(Debug)]
pub struct Host {
    name: CString,
    logger: Option<FmiLogger>,
    environment: *mut c_void,
}

impl Sink for Host {
    fn send(&mut self, status: Status, category: Category, message: &str) {
        let Some(logger) = self.logger else { return };
        let (category, message) = (c_text(messages::name(category)), status::finished(message));
        // SAFETY: the host ensures that its logger and environment stay valid until the instance
        // is freed (FMI 2.0, 2.1.5); all strings live until it returns; no % in the message
        // requires a further argument.
        unsafe {
            let (name, category, message) = (self.name.as_ptr(), category.as_ptr(), message.as_ptr());
            logger(self.environment, name, status as c_int, category, message);
        }
    }
}

/// Runs `body` on the instance behind `c`: handle, state machine, unwind guard, status and log
/// message.
///
/// # Safety
/// `c` is null or from [`instantiate`] of the same component and not freed, and no call on it is
/// running in another thread.
#[inline]
pub unsafe fn call<C: Component>(
    c: FmiComponent,
    function: Function,
    body: impl FnOnce(&mut Instance<C>, &mut Host) -> Outcome<C>,
) -> FmiStatus {
    // SAFETY: null or from `Box::into_raw` in `instantiate`; only shared, so a second simultaneous
    // call finds it borrowed.
    let component = aligned(c.cast::<Shared<C>>(), "c").map(|c| unsafe { c.as_ref() });
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
            instance.break_down();
            refuse(instance, host, function, &panic.into())
        }
    }
}

/// Logs a problem and returns its status.
#[cold]
#[inline(never)]
fn refuse<C: Component>(
    instance: &Instance<C>,
    host: &mut Host,
    function: Function,
    problem: &CallProblem<C::Problem>,
) -> FmiStatus {
    report(instance.enabled(), host, function.name(), problem.status(), problem);
    problem.status() as FmiStatus
}

/// `fmi2Instantiate` (FMI 2.0, 2.1.5): a new instance, or null and a log message. Name, GUID and
/// location of the resources are passed to the component; visibility is not used.
///
/// # Safety
/// `name`, `guid` and `resources` are null or C strings; `functions` is null or points to the
/// callbacks, with a logger and an environment that stay valid until the instance is freed.
pub unsafe fn instantiate<C: Component>(
    (name, kind, guid, resources): (*const c_char, c_int, *const c_char, *const c_char),
    functions: *const FmiCallbackFunctions,
    logging_on: FmiBoolean,
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
        let (name, guid, resources) = unsafe {
            (
                c_str(name, "instanceName")?,
                c_str(guid, "fmuGUID")?,
                c_str(resources, "fmuResourceLocation").ok(),
            )
        };
        host.name = name.to_owned();
        let resources = resources.map(|resources| resources.to_string_lossy());
        let files = (&*guid.to_string_lossy(), resources.as_deref());
        let instance = Instance::<C>::new(&name.to_string_lossy(), kind, files, logging_on != 0)?;
        instance.tell("fmi2Instantiate", &mut host);
        Ok(instance)
    });
    match outcome.map_err(CallProblem::from).flatten() {
        Ok(instance) => Box::into_raw(Box::new(Shared::<C>::new((instance, host)))).cast(),
        Err(problem) => {
            report(Categories::ALL, &mut host, "fmi2Instantiate", problem.status(), &problem);
            ptr::null_mut()
        }
    }
}

/// `fmi2FreeInstance` (FMI 2.0, 2.1.5). It also frees the FMU states that the host has not freed.
/// Null is ignored, and so is a call from inside the instance's logger.
///
/// # Safety
/// `c` is null or from [`instantiate`] of the same component and not freed; nothing uses it or its
/// FMU states afterwards.
pub unsafe fn free<C: Component>(c: FmiComponent) {
    let component = c.cast::<Shared<C>>();
    // SAFETY: null or from `Box::into_raw` in `instantiate`.
    if unsafe { component.as_ref() }.is_some_and(|component| component.try_borrow_mut().is_ok()) {
        // SAFETY: as above, and no call is running.
        let component = unsafe { Box::from_raw(component) };
        let _ = guarded(|| drop(component));
    }
}

/// Makes the functions of a table, for `export_fmi2!`. The table is ordered by the clauses of the
/// standard. An entry has the function's name, its row of the state tables, the arguments after
/// the component as `kind name: type[count]`, and the body.
#[doc(hidden)]
#[macro_export]
macro_rules! __functions_of_fmi2 {
    ($component:ty; $($clause:literal: $($(#[$doc:meta])* $name:ident, $function:ident
        ($($kind:ident $argument:ident $(: $type:ty)? $([$count:expr])?),*)
        |$instance:ident, $host:pat_param| $body:expr;)*)*) => {$($(
        #[doc = concat!("`", stringify!($name), "` (FMI 2.0, ", $clause, ").")]
        $(#[$doc])*
        ///
        /// # Safety
        /// The component is null or from [`fmi2Instantiate`] and not freed, and no call on it is
        /// running in another thread. Every other pointer is null or valid for the standard's type
        /// and the given count.
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case)]
        pub unsafe extern "C" fn $name(
            c: $crate::fmi2::abi::FmiComponent,
            $($argument: $crate::__c_type!($kind $($type)?),)*
        ) -> $crate::fmi2::types::FmiStatus {
            let body = |$instance: &mut $crate::fmi2::instance::Instance<$component>,
                $host: &mut $crate::fmi2::abi::Host| -> $crate::fmi2::problem::Outcome<$component> {
                #[allow(unused_imports)]
                use $crate::component::Component;
                $(#[allow(unused_mut, unused_variables)]
                let mut $argument = $crate::__checked!($instance $kind $argument $($count)?);)*
                Ok($body?)
            };
            // SAFETY: as above.
            unsafe { $crate::fmi2::abi::call(c, $crate::fmi2::states::Function::$function, body) }
        }
    )*)*};
}

/// Exports a [`Component`] by FMI 2.0: the 44 functions of the standard, each a public function
/// with its C name. The macro belongs in a module of the library that hosts load, with the type in
/// scope.
#[macro_export]
macro_rules! export_fmi2 {
    ($component:ty) => {
        /// `fmi2GetTypesPlatform` (FMI 2.0, 2.1.4).
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case)]
        pub extern "C" fn fmi2GetTypesPlatform() -> *const ::core::ffi::c_char {
            c"default".as_ptr()
        }

        /// `fmi2GetVersion` (FMI 2.0, 2.1.4).
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case)]
        pub extern "C" fn fmi2GetVersion() -> *const ::core::ffi::c_char {
            c"2.0".as_ptr()
        }

        /// `fmi2Instantiate` (FMI 2.0, 2.1.5): a new instance, or null and a log message.
        /// Instances are independent and may be used from different threads, each from one thread
        /// at a time.
        ///
        /// # Safety
        /// `instanceName`, `fmuGUID` and `fmuResourceLocation` are null or C strings; `functions`
        /// is null or points to the callbacks, with a logger and an environment that stay valid
        /// until the instance is freed.
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case)]
        pub unsafe extern "C" fn fmi2Instantiate(
            instanceName: *const ::core::ffi::c_char,
            fmuType: ::core::ffi::c_int,
            fmuGUID: *const ::core::ffi::c_char,
            fmuResourceLocation: *const ::core::ffi::c_char,
            functions: *const $crate::fmi2::abi::FmiCallbackFunctions,
            _visible: $crate::fmi2::types::FmiBoolean,
            loggingOn: $crate::fmi2::types::FmiBoolean,
        ) -> $crate::fmi2::abi::FmiComponent {
            let who = (instanceName, fmuType, fmuGUID, fmuResourceLocation);
            // SAFETY: as the caller ensures.
            unsafe { $crate::fmi2::abi::instantiate::<$component>(who, functions, loggingOn) }
        }

        /// `fmi2FreeInstance` (FMI 2.0, 2.1.5). It also frees the remaining FMU states. Null is
        /// ignored, and so is a call from inside the instance's own logger.
        ///
        /// # Safety
        /// `c` is null or from [`fmi2Instantiate`] and not freed; nothing uses it or its FMU
        /// states afterwards.
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case)]
        pub unsafe extern "C" fn fmi2FreeInstance(c: $crate::fmi2::abi::FmiComponent) {
            // SAFETY: as the caller ensures.
            unsafe { $crate::fmi2::abi::free::<$component>(c) }
        }

        $crate::__functions_of_fmi2! {
            $component;
            "2.1.5":
            fmi2SetDebugLogging, SetDebugLogging(flag loggingOn: $crate::fmi2::types::FmiBoolean, value nCategories: usize, texts categories[nCategories])
                |instance, _| instance.set_debug_logging(loggingOn, categories);

            "2.1.6":
            fmi2SetupExperiment, SetupExperiment(flag toleranceDefined: $crate::fmi2::types::FmiBoolean, value tolerance: f64, value startTime: f64,
                flag stopTimeDefined: $crate::fmi2::types::FmiBoolean, value stopTime: f64)
                |instance, _| Component::set_experiment(&mut instance.component,
                    toleranceDefined.then_some(tolerance), startTime, stopTimeDefined.then_some(stopTime));
            fmi2EnterInitializationMode, EnterInitializationMode() |instance, _| instance.enter_initialization_mode();
            fmi2ExitInitializationMode, ExitInitializationMode() |instance, host| instance.exit_initialization_mode(host);
            fmi2Terminate, Terminate() |instance, _| Ok::<(), $crate::ffi::Fault>(Component::terminate(&mut instance.component));
            fmi2Reset, Reset() |instance, _| Ok::<(), $crate::ffi::Fault>($crate::Model::reset(&mut instance.component));

            "2.1.7":
            fmi2GetReal, GetReal(array vr: u32[nvr], value nvr: usize, out value: f64[nvr])
                |instance, _| instance.get($crate::fmi2::instance::REAL, vr, |i, x| value.put(i, x));
            fmi2GetInteger, GetInteger(array vr: u32[nvr], value nvr: usize, out value: ::core::ffi::c_int[nvr])
                |instance, _| instance.get_any($crate::fmi2::instance::INTEGER, vr, &mut |i, x| value.put(i, x as ::core::ffi::c_int));
            fmi2GetBoolean, GetBoolean(array vr: u32[nvr], value nvr: usize, out value: $crate::fmi2::types::FmiBoolean[nvr])
                |instance, _| instance.get_any($crate::fmi2::instance::BOOLEAN, vr, &mut |i, x| value.put(i, (x != 0.0).into()));
            /// Fails for any reference, since no variable is a String.
            fmi2GetString, GetString(array vr: u32[nvr], value nvr: usize, out value: *const ::core::ffi::c_char[nvr])
                |instance, _| instance.get_any($crate::fmi2::instance::STRING, vr, &mut |i, _| value.put(i, c"".as_ptr()));
            fmi2SetReal, SetReal(array vr: u32[nvr], value nvr: usize, array value: f64[nvr])
                |instance, _| instance.set($crate::fmi2::instance::REAL, vr, |i| value[i]);
            fmi2SetInteger, SetInteger(array vr: u32[nvr], value nvr: usize, array value: ::core::ffi::c_int[nvr])
                |instance, _| instance.set_any($crate::fmi2::instance::INTEGER, vr, &|i| value[i].into());
            fmi2SetBoolean, SetBoolean(array vr: u32[nvr], value nvr: usize, array value: $crate::fmi2::types::FmiBoolean[nvr])
                |instance, _| instance.set_any($crate::fmi2::instance::BOOLEAN, vr, &|i| value[i].into());
            /// Fails for any reference, since no variable is a String.
            fmi2SetString, SetString(array vr: u32[nvr], value nvr: usize, array value: *const ::core::ffi::c_char[nvr])
                |instance, _| instance.set_any($crate::fmi2::instance::STRING, vr, &|_| 0.0);

            "2.1.8":
            /// Writes into a new FMU state, or over one that this instance has returned.
            fmi2GetFMUstate, GetFMUstate(handle FMUstate)
                |instance, _| FMUstate.replace(|old| instance.save(old));
            /// Any address is safe: only addresses that this instance has returned are accepted.
            fmi2SetFMUstate, SetFMUstate(state FMUstate) |instance, _| instance.restore(FMUstate);
            /// A null state is ignored.
            fmi2FreeFMUstate, FreeFMUstate(handle FMUstate) |instance, _| FMUstate.free(|old| instance.free(old));
            fmi2SerializedFMUstateSize, SerializedFMUstateSize(state FMUstate, out size: usize[1])
                |instance, _| size.give(instance.serialized(FMUstate).map(|bytes| bytes.len()));
            /// The array must have the size that `fmi2SerializedFMUstateSize` returns.
            fmi2SerializeFMUstate, SerializeFMUstate(state FMUstate, out serializedState: u8[size], value size: usize)
                |instance, _| serializedState.copy(&instance.serialized(FMUstate)?, "size");
            /// Writes into a new FMU state, or over one that this instance has returned.
            fmi2DeSerializeFMUstate, DeSerializeFMUstate(array serializedState: u8[size], value size: usize, handle FMUstate)
                |instance, _| FMUstate.replace(|old| instance.deserialize(serializedState, old));

            "2.1.9":
            fmi2GetDirectionalDerivative, GetDirectionalDerivative(
                array vUnknown_ref: u32[nUnknown], value nUnknown: usize,
                array vKnown_ref: u32[nKnown], value nKnown: usize,
                array dvKnown: f64[nKnown], out dvUnknown: f64[nUnknown])
                |instance, _| $crate::Model::directional_derivative(&mut instance.component,
                    vUnknown_ref, vKnown_ref, dvKnown, |i, x| dvUnknown.put(i, x));

            "3.2.2":
            fmi2EnterEventMode, EnterEventMode() |instance, _| Component::enter_event(&mut instance.component);
            fmi2NewDiscreteStates, NewDiscreteStates(out eventInfo: $crate::fmi2::types::FmiEventInfo[1])
                |instance, host| eventInfo.give(instance.new_discrete_states(host));
            fmi2EnterContinuousTimeMode, EnterContinuousTimeMode() |instance, _| Component::enter_continuous(&mut instance.component);
            fmi2CompletedIntegratorStep, CompletedIntegratorStep(flag noSetFMUStatePriorToCurrentPoint: $crate::fmi2::types::FmiBoolean,
                out enterEventMode: $crate::fmi2::types::FmiBoolean[1], out terminateSimulation: $crate::fmi2::types::FmiBoolean[1])
                |instance, _| {
                    enterEventMode.give(Component::complete_integrator_step(&mut instance.component).map(Into::into))?;
                    terminateSimulation.put(0, 0);
                    Ok::<(), $crate::ffi::Fault>(())
                };

            "3.2.1":
            fmi2SetTime, SetTime(value time: f64) |instance, _| Component::set_time(&mut instance.component, time);
            fmi2SetContinuousStates, SetContinuousStates(states x: f64[nx], value nx: usize)
                |instance, _| $crate::Model::set_continuous_states(&mut instance.component, x);

            "3.2.2":
            fmi2GetDerivatives, GetDerivatives(out derivatives: f64[nx], value nx: usize)
                |instance, _| derivatives.copy($crate::Model::state_derivatives(&instance.component)?.as_ref(), "nx");
            fmi2GetEventIndicators, GetEventIndicators(out eventIndicators: f64[ni], value ni: usize)
                |instance, _| eventIndicators.copy($crate::Model::event_indicators(&instance.component)?.as_ref(), "ni");
            fmi2GetContinuousStates, GetContinuousStates(out x: f64[nx], value nx: usize)
                |instance, _| x.copy($crate::Model::continuous_states(&instance.component)?.as_ref(), "nx");
            fmi2GetNominalsOfContinuousStates, GetNominalsOfContinuousStates(out x_nominal: f64[nx], value nx: usize)
                |instance, _| x_nominal.copy($crate::Model::nominals(&instance.component).as_ref(), "nx");

            "4.2.1":
            fmi2SetRealInputDerivatives, SetRealInputDerivatives(
                array vr: u32[nvr], value nvr: usize, array order: ::core::ffi::c_int[nvr], array value: f64[nvr])
                |instance, _| $crate::Model::set_input_derivatives(&mut instance.component, vr, order, value);
            fmi2GetRealOutputDerivatives, GetRealOutputDerivatives(
                array vr: u32[nvr], value nvr: usize, array order: ::core::ffi::c_int[nvr], out value: f64[nvr])
                |instance, _| $crate::Model::output_derivatives(&mut instance.component, vr, order, |i, x| value.put(i, x));

            "4.2.2":
            /// `noSetFMUStatePriorToCurrentPoint` has no effect: nothing is buffered.
            fmi2DoStep, DoStep(value currentCommunicationPoint: f64, value communicationStepSize: f64,
                flag noSetFMUStatePriorToCurrentPoint: $crate::fmi2::types::FmiBoolean)
                |instance, host| instance.do_step(currentCommunicationPoint, communicationStepSize, host);
            /// Never allowed, since steps are synchronous.
            fmi2CancelStep, CancelStep() |instance, _| instance.cancel_step();

            "4.2.3":
            /// The status of an asynchronous step; no step is asynchronous.
            fmi2GetStatus, GetStatus(value s: ::core::ffi::c_int, out value: $crate::fmi2::types::FmiStatus[1])
                |instance, _| instance.no_status(s);
            /// `fmi2LastSuccessfulTime`.
            fmi2GetRealStatus, GetRealStatus(value s: ::core::ffi::c_int, out value: f64[1])
                |instance, _| value.give(instance.real_status(s));
            /// Fails for any status, since none is an Integer.
            fmi2GetIntegerStatus, GetIntegerStatus(value s: ::core::ffi::c_int, out value: ::core::ffi::c_int[1])
                |instance, _| instance.no_status(s);
            /// `fmi2Terminated`.
            fmi2GetBooleanStatus, GetBooleanStatus(value s: ::core::ffi::c_int, out value: $crate::fmi2::types::FmiBoolean[1])
                |instance, _| value.give(instance.boolean_status(s).map(Into::into));
            /// The status of an asynchronous step; no step is asynchronous.
            fmi2GetStringStatus, GetStringStatus(value s: ::core::ffi::c_int, out value: *const ::core::ffi::c_char[1])
                |instance, _| instance.no_status(s);
        }
    };
}
