//! The complete FMU state (FMI 2.0, 2.1.8).

use super::{FmiComponent, FmiStatus, Host, call, check_pointer, slice, write_one};
use crate::fmi2::instance::{FmuState, Instance, Outcome};
use crate::fmi2::problem::Problem;
use crate::fmi2::states::Function;
use std::ffi::c_void;

/// `fmi2GetFMUstate` (FMI 2.0, 2.1.8).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `state` is null or points to a pointer.
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
/// `c` as in [`fmi2Reset`](super::fmi2Reset). Any `state` is safe: only those this instance gave out are accepted.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetFMUstate(c: FmiComponent, state: *mut c_void) -> FmiStatus {
    // SAFETY: as above.
    unsafe { call(c, Function::SetFMUstate, |instance, _| instance.restore_kept(state.addr())) }
}

/// `fmi2FreeFMUstate` (FMI 2.0, 2.1.8). A null state is ignored.
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `state` is null or points to a pointer.
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
/// `c` as in [`fmi2Reset`](super::fmi2Reset); any `state` is safe; `size` is null or points to a `size_t`.
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
/// `c` as in [`fmi2Reset`](super::fmi2Reset); any `state` is safe; `serialized` is null or points to `size` bytes.
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
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `serialized` is null or points to `size` bytes; `state` is null or points to a pointer.
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
        let saved = instance.deserialize(bytes)?;
        // SAFETY: as above.
        unsafe { keep(instance, saved, state) }
    };
    // SAFETY: as above.
    unsafe { call(c, Function::DeSerializeFMUstate, body) }
}
