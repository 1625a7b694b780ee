//! Arguments of a C interface as safe types, and the checks that the conversion needs.

#![allow(unsafe_code)]
#![deny(unsafe_op_in_unsafe_fn)]

use super::Fault;
use core::ffi::{c_char, c_void};
use std::cell::Cell;
use std::ffi::CStr;
use std::mem::MaybeUninit;
use std::ptr;

/// Whether an address can be accessed: it is neither null nor misaligned.
#[inline]
fn can_be_followed<T>(pointer: *const T) -> bool {
    !pointer.is_null() && pointer.is_aligned()
}

/// Refuses a pointer that cannot be followed.
///
/// # Errors
/// [`Fault::Pointer`].
#[inline]
pub fn check_pointer<T>(pointer: *const T, argument: &'static str) -> Result<(), Fault> {
    if can_be_followed(pointer) { Ok(()) } else { Err(Fault::Pointer { argument }) }
}

/// The pointer, if it is null or aligned.
///
/// # Errors
/// [`Fault::Pointer`] otherwise.
#[inline]
pub fn aligned<T>(pointer: *mut T, argument: &'static str) -> Result<*mut T, Fault> {
    if pointer.is_aligned() { Ok(pointer) } else { Err(Fault::Pointer { argument }) }
}

/// Checks a host array: a count above `limit` and an invalid pointer are refused; an empty array
/// may have any pointer. The limit prevents reads far outside the array if a count is wrong.
///
/// # Errors
/// [`Fault`] for more elements than any call has, or an invalid pointer.
#[inline]
pub fn check_array<T>(
    pointer: *const T,
    count: usize,
    (argument, limit): (&'static str, usize),
) -> Result<(), Fault> {
    if count > limit {
        let allowed = format!("at most {limit}");
        return Err(Fault::Count { argument: "number of elements", value: count, allowed });
    }
    if count == 0 { Ok(()) } else { check_pointer(pointer, argument) }
}

/// Refuses a number of elements that differs from `count`.
///
/// # Errors
/// [`Fault::Count`].
pub fn check_count(number: &'static str, value: usize, count: usize) -> Result<(), Fault> {
    let problem = || Fault::Count { argument: number, value, allowed: count.to_string() };
    if value == count { Ok(()) } else { Err(problem()) }
}

/// The host's array as a slice; empty if `count` is 0, whatever the pointer. `argument` is the
/// array's name and the largest count that any call allows.
///
/// # Errors
/// [`Fault`] for an invalid pointer or count.
///
/// # Safety
/// `pointer` is null or points to `count` elements that live and stay unchanged while the slice is
/// used.
#[inline]
pub unsafe fn array<'a, T>(
    pointer: *const T,
    count: usize,
    argument: (&'static str, usize),
) -> Result<&'a [T], Fault> {
    check_array(pointer, count, argument)?;
    // SAFETY: not null, aligned, of `count` elements as the caller ensures.
    Ok(if count == 0 { &[] } else { unsafe { std::slice::from_raw_parts(pointer, count) } })
}

/// Host array of exactly `expected` elements; the two names are the array's and its count's.
///
/// # Errors
/// [`Fault`] for an invalid pointer or count.
///
/// # Safety
/// As [`array()`].
#[inline]
pub unsafe fn vector<'a, T>(
    pointer: *const T,
    count: usize,
    expected: usize,
    (argument, number): (&'static str, &'static str),
) -> Result<&'a [T], Fault> {
    check_count(number, count, expected)?;
    // SAFETY: `count` elements, as the caller ensures.
    unsafe { array(pointer, count, (argument, count)) }
}

/// The host's C string.
///
/// # Errors
/// [`Fault`] for an invalid pointer or count.
///
/// # Safety
/// `pointer` is null or points to a string that ends with a null byte and lives while the text is
/// used.
pub unsafe fn c_str<'a>(pointer: *const c_char, argument: &'static str) -> Result<&'a CStr, Fault> {
    check_pointer(pointer, argument)?;
    // SAFETY: not null, ends with a null byte as the caller ensures.
    Ok(unsafe { CStr::from_ptr(pointer) })
}

/// The host's array, or its single value, to be written.
///
/// # Errors
/// [`Fault`] for an invalid pointer or count.
///
/// # Safety
/// `pointer` is null or points to `count` elements that live and are not read while this is used.
#[inline]
pub unsafe fn out<'a, T>(
    pointer: *mut T,
    count: usize,
    argument: (&'static str, usize),
) -> Result<Out<'a, T>, Fault> {
    // SAFETY: as above; any bytes are valid as these cells.
    Ok(Out(unsafe { array(pointer.cast::<Cell<MaybeUninit<T>>>(), count, argument) }?))
}

/// The host's variable, to be written; `None` if its pointer is null or misaligned.
///
/// # Safety
/// `pointer` is null or points to a variable that lives and is not read while this is used.
#[inline]
pub unsafe fn variable<'a, T>(pointer: *mut T) -> Option<&'a Cell<MaybeUninit<T>>> {
    // SAFETY: not null, aligned, living as the caller ensures; any bytes are valid as this cell.
    can_be_followed(pointer).then(|| unsafe { &*pointer.cast() })
}

/// The host's array, or its single value: only written, never read, since it may hold any bytes.
pub struct Out<'a, T>(pub &'a [Cell<MaybeUninit<T>>]);

impl<T: Copy> Out<'_, T> {
    /// Writes value `i`.
    #[inline]
    pub fn put(&self, i: usize, value: T) {
        if let Some(cell) = self.0.get(i) {
            cell.set(MaybeUninit::new(value));
        }
    }

    /// Writes the value of a scalar argument.
    ///
    /// # Errors
    /// The error of `value`.
    #[inline]
    pub fn give<E>(&self, value: Result<T, E>) -> Result<(), E> {
        self.put(0, value?);
        Ok(())
    }

    /// Writes all values of an array that must have exactly this number of elements; `number` is
    /// the name of its count.
    ///
    /// # Errors
    /// [`Fault::Count`] for any other number of elements.
    #[inline]
    pub fn copy(&self, values: &[T], number: &'static str) -> Result<(), Fault> {
        check_count(number, self.0.len(), values.len())?;
        self.0.iter().zip(values).for_each(|(cell, value)| cell.set(MaybeUninit::new(*value)));
        Ok(())
    }
}

/// The host's variable for a handle; `None` if the host's pointer was null. The address in the
/// variable is compared and returned, never followed.
pub struct Handle<'a> {
    variable: Option<&'a mut *mut c_void>,
    argument: &'static str,
}

/// The host's variable for a handle.
///
/// # Errors
/// [`Fault::Pointer`] for a misaligned pointer; null is an error only when the variable is needed.
///
/// # Safety
/// `pointer` is null or points to a pointer that lives and is not used elsewhere meanwhile.
pub unsafe fn handle<'a>(pointer: *mut *mut c_void, argument: &'static str) -> Result<Handle<'a>, Fault> {
    // SAFETY: null, or aligned and valid as the caller ensures.
    Ok(Handle { variable: unsafe { aligned(pointer, argument)?.as_mut() }, argument })
}

impl Handle<'_> {
    /// Replaces the address by the result of `new`, which receives the present address (0 for
    /// null).
    ///
    /// # Errors
    /// Errors of `new`; [`Fault::Pointer`] without a variable.
    pub fn replace<E: From<Fault>>(self, new: impl FnOnce(usize) -> Result<usize, E>) -> Result<(), E> {
        let variable = self.variable.ok_or(Fault::Pointer { argument: self.argument })?;
        *variable = ptr::without_provenance_mut(new(variable.addr())?);
        Ok(())
    }

    /// Frees the state at the present address, if any, and replaces it by null.
    ///
    /// # Errors
    /// Errors of `free`.
    pub fn free<E>(self, free: impl FnOnce(usize) -> Result<(), E>) -> Result<(), E> {
        match self.variable {
            Some(variable) if !variable.is_null() => {
                free(variable.addr())?;
                *variable = ptr::null_mut();
                Ok(())
            }
            _ => Ok(()),
        }
    }
}
