//! Functions of Model Exchange (FMI 2.0, 3.2).

use super::{FmiBoolean, FmiComponent, FmiStatus, Host, call, check_pointer, slice, write_one, writer};
use crate::fmi2::instance::{Instance, Outcome};
use crate::fmi2::problem::Problem;
use crate::fmi2::states::Function;

/// `fmi2EventInfo` (FMI 2.0, 3.2.2).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct FmiEventInfo {
    /// `fmi2NewDiscreteStates` must be called again.
    pub new_discrete_states_needed: FmiBoolean,
    /// The simulation must end.
    pub terminate_simulation: FmiBoolean,
    /// Nominal values have changed.
    pub nominals_of_continuous_states_changed: FmiBoolean,
    /// Continuous states have changed.
    pub values_of_continuous_states_changed: FmiBoolean,
    /// Whether the next time event is known.
    pub next_event_time_defined: FmiBoolean,
    /// When it is.
    pub next_event_time: f64,
}

/// `fmi2EnterEventMode` (FMI 2.0, 3.2.2).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterEventMode(c: FmiComponent) -> FmiStatus {
    // SAFETY: as above.
    unsafe { call(c, Function::EnterEventMode, |instance, _| instance.enter_event_mode()) }
}

/// `fmi2NewDiscreteStates` (FMI 2.0, 3.2.2).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `info` is null or points to the structure.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2NewDiscreteStates(c: FmiComponent, info: *mut FmiEventInfo) -> FmiStatus {
    let body = |instance: &mut Instance, host: &mut Host| {
        let result = || {
            let event = instance.new_discrete_states(host)?;
            Ok(FmiEventInfo {
                new_discrete_states_needed: event.new_discrete_states_needed.into(),
                terminate_simulation: event.terminate_simulation.into(),
                nominals_of_continuous_states_changed: event.nominals_changed.into(),
                values_of_continuous_states_changed: event.values_changed.into(),
                next_event_time_defined: event.next_event_time.is_some().into(),
                next_event_time: event.next_event_time.unwrap_or(0.0),
            })
        };
        // SAFETY: as above.
        unsafe { write_one(info, "eventInfo", result) }
    };
    // SAFETY: as above.
    unsafe { call(c, Function::NewDiscreteStates, body) }
}

/// `fmi2EnterContinuousTimeMode` (FMI 2.0, 3.2.2).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2EnterContinuousTimeMode(c: FmiComponent) -> FmiStatus {
    // SAFETY: as above.
    unsafe { call(c, Function::EnterContinuousTimeMode, |instance, _| instance.enter_continuous_time_mode()) }
}

/// `fmi2CompletedIntegratorStep` (FMI 2.0, 3.2.2).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); the others are null or point to a Boolean.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2CompletedIntegratorStep(
    c: FmiComponent,
    _no_set_fmu_state_prior_to_current_point: FmiBoolean,
    enter_event_mode: *mut FmiBoolean,
    terminate_simulation: *mut FmiBoolean,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        check_pointer(terminate_simulation, "terminateSimulation")?;
        let enter = || instance.completed_integrator_step().map(FmiBoolean::from);
        // SAFETY: as above; `terminate_simulation` was checked.
        unsafe {
            write_one(enter_event_mode, "enterEventMode", enter)?;
            terminate_simulation.write(0);
        }
        Ok(())
    };
    // SAFETY: as above.
    unsafe { call(c, Function::CompletedIntegratorStep, body) }
}

/// `fmi2SetTime` (FMI 2.0, 3.2.1).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetTime(c: FmiComponent, time: f64) -> FmiStatus {
    // SAFETY: as above.
    unsafe { call(c, Function::SetTime, |instance, _| instance.set_time(time)) }
}

/// `fmi2SetContinuousStates` (FMI 2.0, 3.2.1).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `x` is null or points to `nx` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2SetContinuousStates(c: FmiComponent, x: *const f64, nx: usize) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        check_length("nx", nx, 6)?;
        // SAFETY: as above.
        let states = unsafe { slice(x, nx, "x") }?;
        let states = <&[f64; 6]>::try_from(states).map_err(|_| wrong_length("nx", nx, 6))?;
        instance.set_continuous_states(states)
    };
    // SAFETY: as above.
    unsafe { call(c, Function::SetContinuousStates, body) }
}

/// `fmi2GetDerivatives` (FMI 2.0, 3.2.2).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `derivatives` is null or points to `nx` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetDerivatives(c: FmiComponent, derivatives: *mut f64, nx: usize) -> FmiStatus {
    // SAFETY: as above.
    unsafe {
        get_vector(
            c,
            Function::GetDerivatives,
            ("derivatives", "nx"),
            derivatives,
            nx,
            Instance::state_derivatives,
        )
    }
}

/// `fmi2GetEventIndicators` (FMI 2.0, 3.2.2).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `indicators` is null or points to `ni` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetEventIndicators(
    c: FmiComponent,
    indicators: *mut f64,
    ni: usize,
) -> FmiStatus {
    // SAFETY: as above.
    unsafe {
        get_vector(
            c,
            Function::GetEventIndicators,
            ("eventIndicators", "ni"),
            indicators,
            ni,
            Instance::event_indicators,
        )
    }
}

/// `fmi2GetContinuousStates` (FMI 2.0, 3.2.2).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `x` is null or points to `nx` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetContinuousStates(c: FmiComponent, x: *mut f64, nx: usize) -> FmiStatus {
    // SAFETY: as above.
    unsafe { get_vector(c, Function::GetContinuousStates, ("x", "nx"), x, nx, Instance::continuous_states) }
}

/// `fmi2GetNominalsOfContinuousStates` (FMI 2.0, 3.2.2).
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `nominals` is null or points to `nx` elements.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi2GetNominalsOfContinuousStates(
    c: FmiComponent,
    nominals: *mut f64,
    nx: usize,
) -> FmiStatus {
    let function = Function::GetNominalsOfContinuousStates;
    // SAFETY: as above.
    unsafe { get_vector(c, function, ("x_nominal", "nx"), nominals, nx, |instance| instance.nominals()) }
}

/// Reads a vector of fixed length.
///
/// # Safety
/// `c` as in [`fmi2Reset`](super::fmi2Reset); `values` is null or points to `count` elements.
unsafe fn get_vector<const N: usize>(
    c: FmiComponent,
    function: Function,
    (name, count_name): (&'static str, &'static str),
    values: *mut f64,
    count: usize,
    get: impl FnOnce(&mut Instance) -> Outcome<[f64; N]>,
) -> FmiStatus {
    let body = |instance: &mut Instance, _: &mut Host| {
        check_length(count_name, count, N)?;
        // SAFETY: as above.
        let mut write = unsafe { writer(values, count, name) }?;
        for (i, value) in get(instance)?.into_iter().enumerate() {
            write(i, value);
        }
        Ok(())
    };
    // SAFETY: as above.
    unsafe { call(c, function, body) }
}

fn check_length(argument: &'static str, value: usize, length: usize) -> Outcome {
    if value == length { Ok(()) } else { Err(wrong_length(argument, value, length)) }
}

fn wrong_length(argument: &'static str, value: usize, length: usize) -> Problem {
    Problem::Count { argument, value, allowed: length.to_string() }
}
