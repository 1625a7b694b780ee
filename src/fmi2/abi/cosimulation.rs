//! Functions of Co-Simulation (FMI 2.0, 4.2).

use super::{FmiBoolean, FmiComponent, FmiStatus, Host, call, check_pointer, slice, write_one, writer};
use crate::fmi2::instance::{Instance, StatusKind};
use crate::fmi2::states::Function;
use std::ffi::{c_char, c_int};

/// `fmi2SetRealInputDerivatives` (FMI 2.0, 4.2.1).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); the arrays are null or of `nvr` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetRealInputDerivatives(
    c: FmiComponent,
    vr: *const u32,
    nvr: usize,
    order: *const c_int,
    value: *const f64,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let (references, orders, values) =
            unsafe { (slice(vr, nvr, "vr")?, slice(order, nvr, "order")?, slice(value, nvr, "value")?) };
        instance.set_real_input_derivatives(references, orders, values)
    };
    // SAFETY: as above.
    unsafe { call(c, Function::SetRealInputDerivatives, body) }
}

/// `fmi2GetRealOutputDerivatives` (FMI 2.0, 4.2.1).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); the arrays are null or of `nvr` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealOutputDerivatives(
    c: FmiComponent,
    vr: *const u32,
    nvr: usize,
    order: *const c_int,
    value: *mut f64,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        // SAFETY: as above.
        let (references, orders, write) =
            unsafe { (slice(vr, nvr, "vr")?, slice(order, nvr, "order")?, writer(value, nvr, "value")?) };
        instance.get_real_output_derivatives(references, orders, write)
    };
    // SAFETY: as above.
    unsafe { call(c, Function::GetRealOutputDerivatives, body) }
}

/// `fmi2DoStep` (FMI 2.0, 4.2.2). Whether the host may come back to an earlier time makes no difference here: nothing is
/// buffered.
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2DoStep(
    c: FmiComponent,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_fmu_state_prior_to_current_point: FmiBoolean,
) -> FmiStatus {
    // SAFETY: as above.
    unsafe {
        call(c, Function::DoStep, |instance, host| {
            instance.do_step(current_communication_point, communication_step_size, host)
        })
    }
}

/// `fmi2CancelStep` (FMI 2.0, 4.2.2): never allowed, since steps are synchronous.
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CancelStep(c: FmiComponent) -> FmiStatus {
    // SAFETY: as above.
    unsafe { call(c, Function::CancelStep, |instance, _| instance.cancel_step()) }
}

/// `fmi2GetStatus` (FMI 2.0, 4.2.3): of asynchronous steps, which there are none of.
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `value` is null or points to a status.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStatus(c: FmiComponent, kind: c_int, value: *mut FmiStatus) -> FmiStatus {
    // SAFETY: as above.
    unsafe { other_status(c, Function::GetStatus, kind, value) }
}

/// `fmi2GetRealStatus` (FMI 2.0, 4.2.3): `fmi2LastSuccessfulTime`.
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `value` is null or points to a Real.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetRealStatus(c: FmiComponent, kind: c_int, value: *mut f64) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        let status = || instance.real_status(StatusKind::from_number(kind)?);
        // SAFETY: as above.
        unsafe { write_one(value, "value", status) }
    };
    // SAFETY: as above.
    unsafe { call(c, Function::GetRealStatus, body) }
}

/// `fmi2GetIntegerStatus` (FMI 2.0, 4.2.3): there is no status of this type.
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `value` is null or points to an Integer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetIntegerStatus(c: FmiComponent, kind: c_int, value: *mut c_int) -> FmiStatus {
    // SAFETY: as above.
    unsafe { other_status(c, Function::GetIntegerStatus, kind, value) }
}

/// `fmi2GetBooleanStatus` (FMI 2.0, 4.2.3): `fmi2Terminated`.
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `value` is null or points to a Boolean.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetBooleanStatus(
    c: FmiComponent,
    kind: c_int,
    value: *mut FmiBoolean,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        let status = || instance.boolean_status(StatusKind::from_number(kind)?).map(FmiBoolean::from);
        // SAFETY: as above.
        unsafe { write_one(value, "value", status) }
    };
    // SAFETY: as above.
    unsafe { call(c, Function::GetBooleanStatus, body) }
}

/// `fmi2GetStringStatus` (FMI 2.0, 4.2.3): of asynchronous steps, which there are none of.
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `value` is null or points to a string pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetStringStatus(
    c: FmiComponent,
    kind: c_int,
    value: *mut *const c_char,
) -> FmiStatus {
    // SAFETY: as above.
    unsafe { other_status(c, Function::GetStringStatus, kind, value) }
}

/// Statuses that never are available.
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset).
unsafe fn other_status<T>(c: FmiComponent, function: Function, kind: c_int, value: *mut T) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        check_pointer(value, "value")?;
        instance.other_status(function, StatusKind::from_number(kind)?)
    };
    // SAFETY: as above.
    unsafe { call(c, function, body) }
}
