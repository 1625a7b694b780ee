//! The C interface of FMI 3.0: what every `extern "C"` of this door goes through, and those that make, free and save
//! instances (FMI 3.0.2, 2.2 and 2.3). The others stand in the modules below.
//!
//! The macro `export!` declares a function of the standard as in its C prototype, with the kind of each argument; from that it
//! checks handle, state, pointers and counts, turns pointers into safe types and calls the [`Instance`] or its component,
//! whose outcome becomes a status and a log message. Nothing is decided here. No panic leaves a function: one becomes
//! `fmi3Fatal` and marks the instance unusable. C enumerations and Booleans arrive as integers, never as Rust's own types.

#![allow(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn)]
#![allow(non_snake_case)] // the standard's names

#[cfg(test)]
mod tests;

use super::instance::Instance;
use super::problem::{Outcome, Problem};
use super::states::Function;
use super::status;
use super::types::{FmiBoolean, FmiStatus};
use crate::component::log::Category;
use crate::ffi::panics::guarded;
use crate::ffi::pointers::{aligned, array, c_str, check_count, handle};
use crate::messages::{self, Sink, Status, c_text, report};
use std::cell::RefCell;
use std::ffi::{c_char, c_void};

/// `fmi3Instance`: opaque to the host.
pub type FmiInstance = *mut c_void;

/// `fmi3LogMessageCallback`.
pub type FmiLogMessage = unsafe extern "C-unwind" fn(*mut c_void, FmiStatus, *const c_char, *const c_char);

/// `fmi3IntermediateUpdateCallback`. A callback that unwinds is caught.
pub type FmiIntermediateUpdate = unsafe extern "C-unwind" fn(
    *mut c_void,
    f64,
    FmiBoolean,
    FmiBoolean,
    FmiBoolean,
    FmiBoolean,
    *mut FmiBoolean,
    *mut f64,
);

/// What a host's `fmi3Instance` points to; borrowed while a call runs, so that a call from inside the logger is refused. It is
/// not borrowed while the host's callback runs in a step, which may get and set.
struct Shared {
    instance: RefCell<(Instance, Host)>,
    environment: *mut c_void,
    intermediate_update: Option<FmiIntermediateUpdate>,
}

/// Where log messages go.
struct Host {
    logger: Option<FmiLogMessage>,
    environment: *mut c_void,
}

impl Sink for Host {
    fn send(&mut self, status: Status, category: Category, message: &str) {
        let Some(logger) = self.logger else { return };
        let (category, message) = (c_text(messages::name(category)), status::finished(message));
        // SAFETY: the host vouches for its logger and environment until the instance is freed (FMI 3.0.2, 2.3.1); all
        // strings live until it returns.
        unsafe { logger(self.environment, status as FmiStatus, category.as_ptr(), message.as_ptr()) }
    }
}

/// What the handle points to; none for null or a misaligned one.
///
/// # Safety
/// `instance` is null or from an instantiation and not freed.
#[inline]
unsafe fn shared<'a>(instance: FmiInstance) -> Option<&'a Shared> {
    // SAFETY: null or from `Box::into_raw`; only shared, so a second call at a time finds it borrowed.
    aligned(instance.cast::<Shared>(), "instance").ok().and_then(|shared| unsafe { shared.as_ref() })
}

/// Runs `body` on the instance behind the handle: state machine, unwind guard, status and log message.
///
/// # Safety
/// `instance` is null or from an instantiation and not freed, and no call on it is running in another thread.
#[inline]
unsafe fn call(
    instance: FmiInstance,
    function: Function,
    body: impl FnOnce(&mut Instance, &mut Host) -> Outcome,
) -> FmiStatus {
    // SAFETY: as above.
    unsafe {
        go_on(instance, function, |instance, host| {
            instance.guard(function)?;
            body(instance, host)
        })
    }
}

/// The same where a call goes on that was let in before.
///
/// # Safety
/// As for [`call`].
#[inline]
unsafe fn go_on(
    instance: FmiInstance,
    function: Function,
    body: impl FnOnce(&mut Instance, &mut Host) -> Outcome,
) -> FmiStatus {
    // SAFETY: as above.
    let Some(Ok(mut borrowed)) = unsafe { shared(instance) }.map(|shared| shared.instance.try_borrow_mut())
    else {
        return Status::Error as FmiStatus;
    };
    let (instance, host) = &mut *borrowed;
    // Matched in its place: to move a problem that is not there costs a step more than all its checks.
    match guarded(|| body(instance, host)) {
        Ok(Ok(())) => Status::Ok as FmiStatus,
        Ok(Err(problem)) => refuse(instance, host, function, &problem),
        Err(fault) => refuse(instance, host, function, &fault.into()),
    }
}

/// Logs a problem, and leaves the instance in the state that its status means.
#[cold]
fn refuse(instance: &mut Instance, host: &mut Host, function: Function, problem: &Problem) -> FmiStatus {
    let status = problem.status(function);
    report(instance.enabled(), host, function.name(), status, problem);
    instance.after(function, status);
    status as FmiStatus
}

/// What cannot fail.
fn done((): ()) -> Outcome {
    Ok(())
}

/// C type of an argument of this kind.
#[rustfmt::skip]
macro_rules! c_type {
    (flag) => { $crate::fmi3::types::FmiBoolean };
    (value $type:ty) => { $type };
    (array $type:ty) => { *const $type };
    (vector $type:ty) => { *const $type };
    (out $type:ty) => { *mut $type };
    (texts) => { *const *const ::std::ffi::c_char };
    (state) => { *mut ::std::ffi::c_void };
    (handle) => { *mut *mut ::std::ffi::c_void };
}

/// An argument of this kind in safe types; to be used where `?` is.
#[rustfmt::skip]
macro_rules! checked {
    (flag $name:ident) => { $name != 0 };
    (value $name:ident) => { $name };
    (state $name:ident) => { $name.addr() };
    // SAFETY (all below): null or valid for that count, as the exported function's caller says.
    (array $name:ident $count:expr) => {
        unsafe { $crate::ffi::pointers::array($name, $count, stringify!($name)) }?
    };
    (vector $name:ident $count:expr) => {
        unsafe { $crate::ffi::pointers::vector($name, $count, (stringify!($name), stringify!($count))) }?
    };
    (out $name:ident $count:expr) => {
        unsafe { $crate::ffi::pointers::out($name, $count, stringify!($name)) }?
    };
    (handle $name:ident) => { unsafe { handle($name, stringify!($name)) }? };
    (texts $name:ident $count:expr) => {
        unsafe { array($name, $count, stringify!($name)) }?
            .iter()
            .map(|name| Ok(unsafe { c_str(*name, "category") }?.to_string_lossy()))
    };
}

/// Exports functions of the standard, by its clauses: name, row of the state tables, arguments after the instance as
/// `kind name: type[count]`, and what is done with them.
macro_rules! export {
    ($($clause:literal: $($(#[$doc:meta])* $name:ident, $function:ident
        ($($kind:ident $argument:ident $(: $type:ty)? $([$count:expr])?),* $(,)?)
        |$instance:pat_param, $host:pat_param| $body:expr;)*)*) => {$($(
        #[doc = concat!("`", stringify!($name), "` (FMI 3.0.2, ", $clause, ").")]
        $(#[$doc])*
        ///
        /// # Safety
        /// The instance is null or from an instantiation and not freed, and no call on it is running in another thread. Every
        /// other pointer is null or valid for what the standard has there, with as many elements as the count says.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            instance: $crate::fmi3::abi::FmiInstance,
            $($argument: c_type!($kind $($type)?),)*
        ) -> $crate::fmi3::types::FmiStatus {
            let body = |$instance: &mut $crate::fmi3::instance::Instance, $host: &mut $crate::fmi3::abi::Host|
                -> $crate::fmi3::problem::Outcome {
                $(#[allow(unused_mut, unused_variables)]
                let mut $argument = checked!($kind $argument $($count)?);)*
                Ok($body?)
            };
            // SAFETY: as above.
            unsafe { $crate::fmi3::abi::call(instance, $crate::fmi3::states::Function::$function, body) }
        }
    )*)*};
}

mod instantiation;
mod models;
mod step;
mod values;

pub use instantiation::*;
pub use models::*;
pub use step::*;
pub use values::*;

/// `fmi3GetVersion` (FMI 3.0.2, 2.2.4).
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// `fmi3FreeInstance` (FMI 3.0.2, 2.3.1); also frees FMU states that were not. Null is ignored, and so is a call from inside
/// the instance's own logger or callback.
///
/// # Safety
/// `instance` is null or from an instantiation and not freed; nothing uses it or its FMU states afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: FmiInstance) {
    // SAFETY: as above.
    let free = unsafe { shared(instance) }
        .and_then(|shared| shared.instance.try_borrow_mut().ok())
        .is_some_and(|borrowed| !borrowed.0.in_callback());
    if free {
        // SAFETY: from `Box::into_raw` in an instantiation, and no call is running.
        let instance = unsafe { Box::from_raw(instance.cast::<Shared>()) };
        let _ = guarded(|| drop(instance));
    }
}

export! {
    "2.3.1":
    fmi3SetDebugLogging, SetDebugLogging(flag loggingOn, value nCategories: usize, texts categories[nCategories])
        |instance, _| instance.set_debug_logging(loggingOn, categories);
    fmi3Reset, Reset() |instance, _| done(instance.component.reset());

    "2.3.2":
    fmi3EnterInitializationMode, EnterInitializationMode(flag toleranceDefined, value tolerance: f64,
        value startTime: f64, flag stopTimeDefined, value stopTime: f64)
        |instance, _| instance.enter_initialization_mode(
            toleranceDefined.then_some(tolerance), startTime, stopTimeDefined.then_some(stopTime));

    "2.3.3":
    fmi3ExitInitializationMode, ExitInitializationMode() |instance, host| instance.exit_initialization_mode(host);

    "2.3.4":
    fmi3Terminate, Terminate() |instance, _| done(instance.terminate());

    "2.2.6.4":
    /// Writes into a new FMU state, or over one that this instance gave out.
    fmi3GetFMUState, GetFMUState(handle FMUState)
        |instance, _| FMUState.replace(|old| instance.save(old));
    /// Any address is safe: only those this instance gave out are accepted.
    fmi3SetFMUState, SetFMUState(state FMUState) |instance, _| instance.restore(FMUState);
    /// A null state is ignored.
    fmi3FreeFMUState, FreeFMUState(handle FMUState) |instance, _| FMUState.free(|old| instance.free(old));
    fmi3SerializedFMUStateSize, SerializedFMUStateSize(state FMUState, out size: usize[1])
        |instance, _| size.give(instance.serialized(FMUState).map(|bytes| bytes.len()));
    /// Into as many bytes as `fmi3SerializedFMUStateSize` says.
    fmi3SerializeFMUState, SerializeFMUState(state FMUState, out serializedState: u8[size], value size: usize)
        |instance, _| serializedState.copy(&instance.serialized(FMUState)?, "size");
    /// Writes into a new FMU state, or over one that this instance gave out.
    fmi3DeserializeFMUState, DeserializeFMUState(array serializedState: u8[size], value size: usize, handle FMUState)
        |instance, _| FMUState.replace(|old| instance.deserialize(serializedState, old));
}
