//! Arguments of the C interface once they are safe types, and the checks that make them so.

use super::instance::Outcome;
use super::problem::Problem;
use std::cell::Cell;
use std::ffi::c_void;
use std::mem::MaybeUninit;
use std::ptr;

/// More elements than this in one call are taken for a mistake (there are fewer than 100 variables): it keeps a wrong
/// count from walking through the host's memory.
const MAX_COUNT: usize = 4096;

/// Refuses a pointer that cannot be followed.
#[inline]
pub fn check_pointer<T>(pointer: *const T, argument: &'static str) -> Outcome {
    let valid = !pointer.is_null() && pointer.is_aligned();
    if valid { Ok(()) } else { Err(Problem::Null { argument }) }
}

/// The pointer, if it is null or aligned.
#[inline]
pub fn aligned<T>(pointer: *mut T, argument: &'static str) -> Outcome<*mut T> {
    if pointer.is_aligned() { Ok(pointer) } else { Err(Problem::Null { argument }) }
}

/// Refuses an array that cannot be; one without elements may have any pointer.
#[inline]
pub fn check_array<T>(pointer: *const T, count: usize, argument: &'static str) -> Outcome {
    if count > MAX_COUNT {
        let allowed = format!("up to {MAX_COUNT}");
        return Err(Problem::Count { argument: "number of elements", value: count, allowed });
    }
    if count == 0 { Ok(()) } else { check_pointer(pointer, argument) }
}

/// Refuses any other number of elements than `count`.
pub fn check_count(number: &'static str, value: usize, count: usize) -> Outcome {
    let problem = || Problem::Count { argument: number, value, allowed: count.to_string() };
    if value == count { Ok(()) } else { Err(problem()) }
}

/// The host's array, or its single value: only written, never read, since it may hold anything.
pub struct Out<'a, T>(pub &'a [Cell<MaybeUninit<T>>]);

impl<T: Copy> Out<'_, T> {
    /// Puts value `i`.
    #[inline]
    pub fn put(&self, i: usize, value: T) {
        if let Some(cell) = self.0.get(i) {
            cell.set(MaybeUninit::new(value));
        }
    }

    /// Puts the one value of an argument that is no array.
    #[inline]
    pub fn give(&self, value: Outcome<T>) -> Outcome {
        self.put(0, value?);
        Ok(())
    }

    /// Puts all values of an array that must have exactly as many elements; `number` is the name of its count.
    #[inline]
    pub fn copy(&self, values: &[T], number: &'static str) -> Outcome {
        check_count(number, self.0.len(), values.len())?;
        self.0.iter().zip(values).for_each(|(cell, value)| cell.set(MaybeUninit::new(*value)));
        Ok(())
    }
}

/// The host's variable for an FMU state; none where its pointer was null. The address in it is compared and handed out,
/// never followed.
pub struct Handle<'a>(pub Option<&'a mut *mut c_void>);

impl Handle<'_> {
    /// Puts what `new` makes of the present address (0 for null) in its place.
    ///
    /// # Errors
    /// Those of `new`, and when there is no variable.
    pub fn replace(self, new: impl FnOnce(usize) -> Outcome<usize>) -> Outcome {
        let variable = self.0.ok_or(Problem::Null { argument: "FMUstate" })?;
        *variable = ptr::without_provenance_mut(new(variable.addr())?);
        Ok(())
    }

    /// Frees the state at the present address, if any, and puts null in its place.
    ///
    /// # Errors
    /// Those of `free`.
    pub fn free(self, free: impl FnOnce(usize) -> Outcome) -> Outcome {
        match self.0 {
            Some(variable) if !variable.is_null() => {
                free(variable.addr())?;
                *variable = ptr::null_mut();
                Ok(())
            }
            _ => Ok(()),
        }
    }
}
