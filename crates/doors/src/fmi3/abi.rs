//! The C interface of FMI 3.0: the code that every `extern "C"` function of this door uses, and
//! the functions that make and free instances (FMI 3.0.2, 2.2 and 2.3). The other functions are in
//! the modules below.
//!
//! The macro [`export_fmi3!`](crate::export_fmi3) makes the functions for one component. It is
//! expanded in the component's library, which exports the functions by name. It declares each
//! function as in the C prototype of the standard, and adds the kind of each argument. From these
//! kinds the function checks handle, state, pointers and counts, turns pointers into safe types
//! and calls the [`Instance`]. The outcome becomes a status and a log message. This module makes
//! no decisions about the model. A panic does not leave a function: it becomes `fmi3Fatal` and
//! marks the instance unusable. C enumerations and Booleans arrive as integers, never as Rust's
//! own types.

#![allow(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn)]

mod functions;
mod instantiation;
mod step;
mod values;

use super::instance::Instance;
use super::problem::{CallProblem, Outcome};
use super::states::Function;
use super::status;
use super::types::{FmiBoolean, FmiStatus};
use crate::component::Component;
use crate::ffi::panics::guarded;
use crate::ffi::pointers::{aligned, array, c_str};
use crate::log::Category;
use crate::messages::{self, Sink, Status, c_text, report};
use core::ffi::{c_char, c_void};
use std::cell::RefCell;

pub use instantiation::{
    Request, instantiate_co_simulation, instantiate_model_exchange, instantiate_scheduled,
};
pub use step::do_step;

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

/// Target of a host's `fmi3Instance`. It is borrowed while a call runs, so that a call from inside
/// the logger is refused. It is not borrowed while the host's callback runs in a step, since the
/// callback may get and set variables.
#[doc(hidden)]
#[derive(Debug)]
pub struct Shared<C: Component> {
    #[doc(hidden)]
    pub instance: RefCell<(Instance<C>, Host)>,
    environment: *mut c_void,
    intermediate_update: Option<FmiIntermediateUpdate>,
}

/// Destination of log messages.
#[derive(Debug)]
pub struct Host {
    logger: Option<FmiLogMessage>,
    environment: *mut c_void,
}

impl Sink for Host {
    fn send(&mut self, status: Status, category: Category, message: &str) {
        let Some(logger) = self.logger else { return };
        let (category, message) = (c_text(messages::name(category)), status::finished(message));
        // SAFETY: the host ensures that its logger and environment stay valid until the instance
        // is freed (FMI 3.0.2, 2.3.1); all strings live until it returns.
        unsafe { logger(self.environment, status as FmiStatus, category.as_ptr(), message.as_ptr()) }
    }
}

/// Target of the handle; `None` if the handle is null or misaligned.
///
/// # Safety
/// `instance` is null or from an instantiation and not freed.
#[inline]
unsafe fn shared<'a, C: Component>(instance: FmiInstance) -> Option<&'a Shared<C>> {
    // SAFETY: null or from `Box::into_raw`; only shared, so a second simultaneous call finds it
    // borrowed.
    aligned(instance.cast::<Shared<C>>(), "instance").ok().and_then(|shared| unsafe { shared.as_ref() })
}

/// Runs `body` on the instance behind the handle: state machine, unwind guard, status and log
/// message.
///
/// # Safety
/// `instance` is null or from an instantiation of the same component and not freed, and no call on
/// it is running in another thread.
#[inline]
pub unsafe fn call<C: Component>(
    instance: FmiInstance,
    function: Function,
    body: impl FnOnce(&mut Instance<C>, &mut Host) -> Outcome<C>,
) -> FmiStatus {
    // SAFETY: as above.
    unsafe {
        go_on::<C>(instance, function, |instance, host| {
            instance.guard(function)?;
            body(instance, host)
        })
    }
}

/// Runs `body` as [`call`] does, without checking the state machine: for the later parts of a call
/// that it has allowed.
///
/// # Safety
/// As for [`call`].
#[inline]
unsafe fn go_on<C: Component>(
    instance: FmiInstance,
    function: Function,
    body: impl FnOnce(&mut Instance<C>, &mut Host) -> Outcome<C>,
) -> FmiStatus {
    // SAFETY: as above.
    let Some(Ok(mut borrowed)) =
        unsafe { shared::<C>(instance) }.map(|shared| shared.instance.try_borrow_mut())
    else {
        return Status::Error as FmiStatus;
    };
    let (instance, host) = &mut *borrowed;
    // The result is matched in place: moving it would cost more per step than all its checks.
    match guarded(|| body(instance, host)) {
        Ok(Ok(())) => Status::Ok as FmiStatus,
        Ok(Err(problem)) => refuse(instance, host, function, &problem),
        Err(fault) => refuse(instance, host, function, &fault.into()),
    }
}

/// Logs a problem, and puts the instance into the state that its status implies.
#[cold]
#[inline(never)]
fn refuse<C: Component>(
    instance: &mut Instance<C>,
    host: &mut Host,
    function: Function,
    problem: &CallProblem<C::Problem>,
) -> FmiStatus {
    let status = problem.status(function);
    report(instance.enabled(), host, function.name(), status, problem);
    instance.after(function, status);
    status as FmiStatus
}

/// `fmi3FreeInstance` (FMI 3.0.2, 2.3.1). It also frees the FMU states that the host has not
/// freed. Null is ignored, and so is a call from inside the instance's logger or callback.
///
/// # Safety
/// `instance` is null or from an instantiation of the same component and not freed; nothing uses
/// it or its FMU states afterwards.
pub unsafe fn free<C: Component>(instance: FmiInstance) {
    // SAFETY: as above.
    let free = unsafe { shared::<C>(instance) }
        .and_then(|shared| shared.instance.try_borrow_mut().ok())
        .is_some_and(|borrowed| !borrowed.0.in_callback());
    if free {
        // SAFETY: from `Box::into_raw` in an instantiation, and no call is running.
        let instance = unsafe { Box::from_raw(instance.cast::<Shared<C>>()) };
        let _ = guarded(|| drop(instance));
    }
}

/// Makes the functions of a table, for `export_fmi3!`. The table is ordered by the clauses of the
/// standard. An entry has the function's name, its row of the state tables, the arguments after
/// the instance as `kind name: type[count]`, and the body.
#[doc(hidden)]
#[macro_export]
macro_rules! __functions_of_fmi3 {
    ($component:ty; $($clause:literal: $($(#[$doc:meta])* $name:ident, $function:ident
        ($($kind:ident $argument:ident $(: $type:ty)? $([$count:expr])?),* $(,)?)
        |$instance:ident, $host:pat_param| $body:expr;)*)*) => {$($(
        #[doc = concat!("`", stringify!($name), "` (FMI 3.0.2, ", $clause, ").")]
        $(#[$doc])*
        ///
        /// # Safety
        /// The instance is null or from an instantiation and not freed, and no call on it is
        /// running in another thread. Every other pointer is null or valid for the standard's type
        /// and the given count.
        #[unsafe(no_mangle)]
        #[allow(unsafe_code, non_snake_case)]
        pub unsafe extern "C" fn $name(
            instance: $crate::fmi3::abi::FmiInstance,
            $($argument: $crate::__c_type!($kind $($type)?),)*
        ) -> $crate::fmi3::types::FmiStatus {
            let body = |$instance: &mut $crate::fmi3::instance::Instance<$component>,
                $host: &mut $crate::fmi3::abi::Host| -> $crate::fmi3::problem::Outcome<$component> {
                #[allow(unused_imports)]
                use $crate::component::Component;
                $(#[allow(unused_mut, unused_variables)]
                let mut $argument = $crate::__checked!($instance $kind $argument $($count)?);)*
                Ok($body?)
            };
            // SAFETY: as above.
            unsafe { $crate::fmi3::abi::call(instance, $crate::fmi3::states::Function::$function, body) }
        }
    )*)*};
}
