//! `fmi3DoStep`, with the host's callback inside it (FMI 3.0.2, 4.2.1 and 4.2.2).

use super::super::instance::Update;
use super::super::intermediate::{Progress, Turn};
use super::super::types::StepEnd;
use super::*;
use crate::ffi::Fault;
use crate::ffi::pointers::Out;

/// What `fmi3DoStep` returns through pointers.
struct Returned<'a> {
    flags: [Out<'a, FmiBoolean>; 3],
    time: Out<'a, f64>,
}

impl Returned<'_> {
    fn put(&self, end: StepEnd) {
        let flags = [end.event_handling_needed, false, end.early_return];
        for (place, flag) in self.flags.iter().zip(flags) {
            place.put(0, flag.into());
        }
        self.time.put(0, end.last_successful_time);
    }
}

/// `fmi3DoStep` (FMI 3.0.2, 4.2.1). `lastSuccessfulTime` is given in any case, also beside an error.
///
/// # Safety
/// The instance is null or from an instantiation and not freed, and no call on it is running in another thread. Every other
/// pointer is null or valid for one element.
#[unsafe(no_mangle)]
#[allow(clippy::too_many_arguments)] // the standard's
pub unsafe extern "C" fn fmi3DoStep(
    instance: FmiInstance,
    currentCommunicationPoint: f64,
    communicationStepSize: f64,
    _noSetFMUStatePriorToCurrentPoint: FmiBoolean,
    eventHandlingNeeded: *mut FmiBoolean,
    terminateSimulation: *mut FmiBoolean,
    earlyReturn: *mut FmiBoolean,
    lastSuccessfulTime: *mut f64,
) -> FmiStatus {
    // SAFETY: null or valid for one element, as the caller says; the instance likewise.
    let (returned, callback) = unsafe {
        let returned = || -> Result<Returned<'_>, Fault> {
            Ok(Returned {
                flags: [
                    out(eventHandlingNeeded, 1, "eventHandlingNeeded")?,
                    out(terminateSimulation, 1, "terminateSimulation")?,
                    out(earlyReturn, 1, "earlyReturn")?,
                ],
                time: out(lastSuccessfulTime, 1, "lastSuccessfulTime")?,
            })
        };
        (
            returned(),
            shared(instance).and_then(|shared| Some((shared.intermediate_update?, shared.environment))),
        )
    };
    let (point, size) = (currentCommunicationPoint, communicationStepSize);
    let mut end = StepEnd::default();
    let check = || match &returned {
        Ok(_) => Ok(()),
        Err(fault) => Err(fault.clone().into()),
    };
    // SAFETY: as above.
    let status = unsafe {
        match callback {
            None => call(instance, Function::DoStep, |instance, host| {
                check()?;
                end = instance.do_step(point, size, host)?;
                Ok(())
            }),
            Some(callback) => step_with_callback(instance, (point, size), callback, check, &mut end),
        }
    };
    if let Ok(returned) = &returned {
        if status == Status::Error as FmiStatus {
            // SAFETY: as above.
            let borrowed = unsafe { shared(instance) }.and_then(|shared| shared.instance.try_borrow().ok());
            let Some(borrowed) = borrowed else { return status };
            end = StepEnd { last_successful_time: borrowed.0.component.time(), ..StepEnd::default() };
        }
        returned.put(end);
    }
    status
}

/// A step that calls the host back; the instance is not borrowed while it does.
///
/// # Safety
/// As for [`call`]; the callback is the host's.
unsafe fn step_with_callback(
    instance: FmiInstance,
    (point, size): (f64, f64),
    (callback, environment): (FmiIntermediateUpdate, *mut c_void),
    check: impl FnOnce() -> Outcome,
    end: &mut StepEnd,
) -> FmiStatus {
    let mut step: Option<(Progress, Turn)> = None;
    // SAFETY: as above.
    let mut status = unsafe {
        call(instance, Function::DoStep, |instance, host| {
            check()?;
            step = Some(instance.begin_step(point, size, host)?);
            Ok(())
        })
    };
    while status == Status::Ok as FmiStatus {
        let Some((progress, turn)) = &mut step else { break };
        let update = match *turn {
            Turn::Done(reached) => {
                *end = reached;
                break;
            }
            Turn::Ask(update) => update,
        };
        // SAFETY: the host's callback, valid until the instance is freed.
        let answer = unsafe { ask(callback, environment, update) };
        // SAFETY: as above.
        status = unsafe {
            go_on(instance, Function::DoStep, |instance, host| {
                let until = answer.inspect_err(|_| instance.callback_failed())?;
                *turn = instance.answered(progress, until, host)?;
                Ok(())
            })
        };
    }
    status
}

/// Calls the host back; returns the time at which it wants the step to end, if it does.
///
/// # Errors
/// [`Fault::Panic`] where the callback unwinds.
///
/// # Safety
/// The callback is valid, and the environment is what it expects.
unsafe fn ask(
    callback: FmiIntermediateUpdate,
    environment: *mut c_void,
    update: Update,
) -> Result<Option<f64>, Fault> {
    let (mut early, mut time) = (0, update.time);
    let Update { set_requested, can_return_early, .. } = update;
    guarded(|| {
        let shown = FmiBoolean::from(!set_requested);
        // SAFETY: as the caller says; both addresses are valid for the call.
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
