//! Every `extern "C"` and every `unsafe` of the crate (FMI 2.0, 2.1, 3.2 and 4.2).
//!
//! A function here turns pointers into slices and numbers, calls the [`Instance`], and turns its outcome into a status and
//! a log message; it decides nothing. No panic leaves it: one becomes `fmi2Fatal` and marks the instance unusable.
//! C enumerations arrive as integers and are checked, never taken as Rust enums.

#![allow(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn)]
#![allow(non_snake_case)] // the standard's names

mod common;
mod cosimulation;
mod exchange;
mod memory;
mod values;

pub use common::*;
pub use cosimulation::*;
pub use exchange::*;
pub use memory::*;
pub use values::*;

#[cfg(test)]
mod tests;

use super::instance::{Instance, Outcome};
use super::logging::{Category, Log, Status};
use super::problem::Problem;
use super::states::Function;
use std::any::Any;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// `fmi2Component`: opaque to the host.
pub type FmiComponent = *mut c_void;
/// `fmi2Boolean`.
pub type FmiBoolean = c_int;
/// `fmi2Status`, as an integer.
pub type FmiStatus = c_int;

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

/// More references than this in one call are taken for a mistake (there are fewer than 100 variables): it keeps a
/// wrong count from walking through the host's memory.
const MAX_COUNT: usize = 4096;

/// What a host's `fmi2Component` points to.
struct Component {
    instance: Instance,
    host: Host,
}

/// Where log messages go.
struct Host {
    name: CString,
    logger: Option<FmiLogger>,
    environment: *mut c_void,
}

impl Log for Host {
    fn log(&mut self, status: Status, category: Category, message: &str) {
        let Some(logger) = self.logger else { return };
        // The host formats the message as printf does and reads # as the start of a variable reference.
        let finished = message.replace('%', "%%").replace('#', "##").replace('\0', "?");
        let (Ok(category), Ok(message)) = (CString::new(category.name()), CString::new(finished)) else {
            return;
        };
        // SAFETY: the host vouches for its logger and environment until the instance is freed (FMI 2.0, 2.1.5); all
        // strings live until it returns; no % in the message asks for a further argument.
        unsafe {
            logger(
                self.environment,
                self.name.as_ptr(),
                status as c_int,
                category.as_ptr(),
                message.as_ptr(),
            );
        }
    }
}

/// Runs `body` on the instance behind `c`: null check, state machine, unwind guard, status and log message.
///
/// # Safety
/// `c` is null or from [`fmi2Instantiate`] and not freed, and no other call on it is running.
#[inline]
unsafe fn call(
    c: FmiComponent,
    function: Function,
    body: impl FnOnce(&mut Instance, &mut Host) -> Outcome,
) -> FmiStatus {
    // SAFETY: as above.
    let Some(component) = (unsafe { c.cast::<Component>().as_mut() }) else {
        return Status::Error as FmiStatus;
    };
    let Component { instance, host } = &mut *component;
    let guarded = || {
        instance.guard(function)?;
        body(instance, host)
    };
    match catch_unwind(AssertUnwindSafe(guarded)) {
        Ok(Ok(())) => Status::Ok as FmiStatus,
        Ok(Err(problem)) => report(component, function, &problem),
        Err(panic) => {
            component.instance.break_down();
            report(component, function, &Problem::Panic { what: text_of(&*panic) })
        }
    }
}

/// Logs a problem where its category is enabled and returns its status.
#[cold]
fn report(component: &mut Component, function: Function, problem: &Problem) -> FmiStatus {
    if component.instance.enabled().contains(problem.category()) {
        let host = &mut component.host;
        // A second panic has nowhere to go but the status.
        let _ = catch_unwind(AssertUnwindSafe(|| {
            host.log(problem.status(), problem.category(), &format!("{}: {problem}", function.name()));
        }));
    }
    problem.status() as FmiStatus
}

fn text_of(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().map(|text| (*text).to_owned());
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "panic".to_owned())
}

fn check_array<T>(pointer: *const T, count: usize, argument: &'static str) -> Outcome {
    if count > MAX_COUNT {
        return Err(Problem::Count {
            argument: "number of elements",
            value: count,
            allowed: format!("up to {MAX_COUNT}"),
        });
    }
    check_pointer(pointer, argument)
}

fn check_pointer<T>(pointer: *const T, argument: &'static str) -> Outcome {
    if pointer.is_null() || !pointer.is_aligned() {
        return Err(Problem::Null { argument });
    }
    Ok(())
}

/// The host's array as a slice; empty when `count` is 0, whatever the pointer.
///
/// # Safety
/// `pointer` is null or points to `count` elements that live and stay unchanged while the slice is used.
#[inline]
unsafe fn slice<'a, T>(pointer: *const T, count: usize, argument: &'static str) -> Outcome<&'a [T]> {
    if count == 0 {
        return Ok(&[]);
    }
    check_array(pointer, count, argument)?;
    // SAFETY: not null, aligned, of `count` elements as the caller says.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

/// Writes into the host's array; the array is only written, never read, since it may hold anything.
///
/// # Safety
/// `pointer` is null or points to `count` elements to which nothing else refers meanwhile.
#[inline]
unsafe fn writer<T>(
    pointer: *mut T,
    count: usize,
    argument: &'static str,
) -> Outcome<impl FnMut(usize, T) + use<T>> {
    if count > 0 {
        check_array(pointer, count, argument)?;
    }
    Ok(move |i: usize, value: T| {
        if i < count {
            // SAFETY: inside the array, checked above.
            unsafe { pointer.add(i).write(value) };
        }
    })
}

/// Writes one value.
///
/// # Safety
/// `pointer` is null or points to a `T` to which nothing else refers meanwhile.
unsafe fn write_one<T>(
    pointer: *mut T,
    argument: &'static str,
    value: impl FnOnce() -> Outcome<T>,
) -> Outcome {
    check_pointer(pointer, argument)?;
    let value = value()?;
    // SAFETY: not null, aligned.
    unsafe { pointer.write(value) };
    Ok(())
}

/// A C string as text; bytes that are not UTF-8 are replaced.
///
/// # Safety
/// `pointer` is null or points to a string that ends with a null byte and lives while the text is used.
unsafe fn text<'a>(pointer: *const c_char, argument: &'static str) -> Outcome<std::borrow::Cow<'a, str>> {
    check_pointer(pointer, argument)?;
    // SAFETY: not null, ends with a null byte as the caller says.
    Ok(unsafe { CStr::from_ptr(pointer) }.to_string_lossy())
}
