//! Getting and setting values, and their derivatives (FMI 2.0, 2.1.7 and 2.1.9).

use super::{FmiBoolean, FmiComponent, FmiStatus, Host, call, slice, writer};
use crate::fmi2::instance::Instance;
use crate::fmi2::states::Function;
use crate::fmi2::variables::Base;
use std::ffi::{c_char, c_int};

/// `fmi2GetReal` (FMI 2.0, 2.1.7).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `vr` and `value` are null or point to `nvr` elements.
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
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `vr` and `value` are null or point to `nvr` elements.
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

/// `fmi2GetDirectionalDerivative` (FMI 2.0, 2.1.9).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); the arrays are null or of `n_unknown` and `n_known` elements.
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
