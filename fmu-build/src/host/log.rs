//! Log of an FMU of either version: a boxed list of lines whose address is passed to the FMU.

use crate::error::Error;
use std::ffi::{CStr, c_char, c_int};
use std::sync::{Mutex, PoisonError};

/// The lines so far. The FMU holds the address of the log; the log outlives the instance.
#[derive(Default)]
pub(super) struct Log(Mutex<Vec<String>>);

impl Log {
    /// Appends a message received by the logger callback.
    ///
    /// # Safety
    /// `log` is null or valid; category and message are null or C strings.
    pub(super) unsafe fn take(log: *const Self, category: *const c_char, message: *const c_char) {
        let text = |pointer: *const c_char| match pointer.is_null() {
            true => String::new(),
            // SAFETY: as the caller vouches.
            false => unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned(),
        };
        // SAFETY: as the caller vouches.
        if let Some(log) = unsafe { log.as_ref() } {
            let line = format!("[{}] {}", text(category), text(message));
            log.0.lock().unwrap_or_else(PoisonError::into_inner).push(line);
        }
    }

    /// The error of a call that did not return OK, with the logged messages.
    pub(super) fn failure(&self, call: &'static str, returned: &'static str) -> Error {
        let lines = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let log = if lines.is_empty() { "(nothing)".to_owned() } else { lines.join("; ") };
        Error::Call { call, status: returned, log }
    }

    /// Checks the status of a call.
    ///
    /// # Errors
    /// [`Error::Call`].
    pub(super) fn check(&self, call: &'static str, status: c_int) -> Result<(), Error> {
        let returned = match status {
            0 => return Ok(()),
            1 => "Warning",
            2 => "Discard",
            3 => "Error",
            4 => "Fatal",
            5 => "Pending",
            _ => "an unknown status",
        };
        Err(self.failure(call, returned))
    }
}
