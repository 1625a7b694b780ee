//! `fmi3DoStep`, with the host's callback inside it (FMI 3.0.2, 4.2.1 and 4.2.2).

use super::super::instance::Update;
use super::super::intermediate::{Progress, Turn};
use super::*;
use crate::events::StepOutcome;
use crate::ffi::Fault;
use crate::ffi::pointers::variable;
use std::cell::Cell;
use std::mem::MaybeUninit;

/// A variable of the host that is only written; `None` if its pointer is null or misaligned.
type Place<'a, T> = Option<&'a Cell<MaybeUninit<T>>>;

/// Values that `fmi3DoStep` returns through pointers.
struct Returned<'a> {
    event_handling_needed: Place<'a, FmiBoolean>,
    terminate_simulation: Place<'a, FmiBoolean>,
    early_return: Place<'a, FmiBoolean>,
    last_successful_time: Place<'a, f64>,
}

impl Returned<'_> {
    /// Refuses a step if its result could not be returned.
    #[inline]
    fn check(&self) -> Result<(), Fault> {
        let Self { event_handling_needed, terminate_simulation, early_return, last_successful_time } = self;
        let argument = match (event_handling_needed, terminate_simulation, early_return, last_successful_time)
        {
            (Some(_), Some(_), Some(_), Some(_)) => return Ok(()),
            (None, ..) => "eventHandlingNeeded",
            (_, None, ..) => "terminateSimulation",
            (_, _, None, _) => "earlyReturn",
            (.., None) => "lastSuccessfulTime",
        };
        Err(Fault::Pointer { argument })
    }

    #[inline]
    fn put(&self, outcome: StepOutcome) {
        put(self.event_handling_needed, outcome.event.into());
        put(self.terminate_simulation, false.into());
        put(self.early_return, outcome.early.into());
        put(self.last_successful_time, outcome.time);
    }
}

#[inline]
fn put<T>(place: Place<'_, T>, value: T) {
    if let Some(place) = place {
        place.set(MaybeUninit::new(value));
    }
}

/// `fmi3DoStep` (FMI 3.0.2, 4.2.1) with a point and a size. `last_successful_time` is always
/// written, even on an error.
///
/// # Safety
/// The instance is null or from an instantiation of the same component and not freed, and no call
/// on it is running in another thread. Every other pointer is null or valid for one element.
#[inline]
pub unsafe fn do_step<C: Component>(
    instance: FmiInstance,
    (point, size): (f64, f64),
    [event_handling_needed, terminate_simulation, early_return]: [*mut FmiBoolean; 3],
    last_successful_time: *mut f64,
) -> FmiStatus {
    // SAFETY: null or valid for one element, as the caller ensures; the instance likewise.
    let (returned, callback) = unsafe {
        let returned = Returned {
            event_handling_needed: variable(event_handling_needed),
            terminate_simulation: variable(terminate_simulation),
            early_return: variable(early_return),
            last_successful_time: variable(last_successful_time),
        };
        let callback =
            shared::<C>(instance).and_then(|shared| Some((shared.intermediate_update?, shared.environment)));
        (returned, callback)
    };
    let mut outcome = StepOutcome::default();
    // SAFETY: as above.
    let status = unsafe {
        match callback {
            None => call::<C>(instance, Function::DoStep, |instance, host| {
                returned.check()?;
                outcome = instance.do_step(point, size, host)?;
                Ok(())
            }),
            Some(callback) => {
                step_with_callback::<C>(instance, (point, size), callback, || returned.check(), &mut outcome)
            }
        }
    };
    if status == Status::Error as FmiStatus {
        // SAFETY: as above.
        let Some(time) = (unsafe { present_time::<C>(instance) }) else { return status };
        outcome = StepOutcome { time, ..StepOutcome::default() };
    }
    returned.put(outcome);
    status
}

/// Present time of the motion, s; `None` without an instance, or inside the instance's logger.
///
/// # Safety
/// `instance` is null or from an instantiation and not freed.
#[cold]
unsafe fn present_time<C: Component>(instance: FmiInstance) -> Option<f64> {
    // SAFETY: as above.
    let borrowed = unsafe { shared::<C>(instance) }?.instance.try_borrow().ok()?;
    Some(borrowed.0.component.time())
}

/// A step that calls the host's callback; the instance is not borrowed during the callback.
///
/// # Safety
/// As for [`call`]; the callback is the host's.
#[inline(never)] // it would make the step without a callback slower
unsafe fn step_with_callback<C: Component>(
    instance: FmiInstance,
    (point, size): (f64, f64),
    (callback, environment): (FmiIntermediateUpdate, *mut c_void),
    check: impl FnOnce() -> Result<(), Fault>,
    outcome: &mut StepOutcome,
) -> FmiStatus {
    let mut step: Option<(Progress<C>, Turn)> = None;
    // SAFETY: as above.
    let mut status = unsafe {
        call::<C>(instance, Function::DoStep, |instance, host| {
            check()?;
            step = Some(instance.begin_step(point, size, host)?);
            Ok(())
        })
    };
    while status == Status::Ok as FmiStatus {
        let Some((progress, turn)) = &mut step else { break };
        let update = match *turn {
            Turn::Done(reached) => {
                *outcome = reached;
                break;
            }
            Turn::Ask(update) => update,
        };
        // SAFETY: the host's callback, valid until the instance is freed.
        let answer = unsafe { ask(callback, environment, update) };
        // SAFETY: as above.
        status = unsafe {
            go_on::<C>(instance, Function::DoStep, |instance, host| {
                let until = answer.inspect_err(|_| instance.callback_failed())?;
                *turn = instance.answered(progress, until, host)?;
                Ok(())
            })
        };
    }
    status
}

/// Calls the host's callback. Returns the time at which the host wants the step to end, if it
/// requests one.
///
/// # Errors
/// [`Fault::Panic`] if the callback unwinds.
///
/// # Safety
/// The callback is valid, and the environment is the one given with the callback.
unsafe fn ask(
    callback: FmiIntermediateUpdate,
    environment: *mut c_void,
    update: Update,
) -> Result<Option<f64>, Fault> {
    let (mut early, mut time) = (0, update.time);
    let Update { set_requested, can_return_early, .. } = update;
    guarded(|| {
        let shown = FmiBoolean::from(!set_requested);
        // SAFETY: as the caller ensures; both addresses are valid for the call.
        unsafe {
            callback(
                environment,
                update.time,
                set_requested.into(),
                shown,
                shown,
                can_return_early.into(),
                &raw mut early,
                &raw mut time,
            );
        }
    })?;
    Ok((early != 0 && can_return_early).then_some(time))
}
