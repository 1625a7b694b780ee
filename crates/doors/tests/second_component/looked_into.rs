//! Steps of the bouncing ball that a host observes with its callback, and counters that are shown
//! once the host has handled the events of a step.

use super::bouncing_ball::*;
use super::{OK, ROUNDING, assert_near, closed_form, height, of_fmi3, token};
use fmi_doors::fmi3::abi::FmiInstance;
use std::cell::{Cell, RefCell};
use std::ffi::c_void;
use std::ptr::{from_ref, null, null_mut};

/// The present time for which a ball that falls from a metre has bounced `n` times.
fn bounce(n: i32) -> f64 {
    let first = (2.0 / 9.81f64).sqrt();
    first + (1..n).map(|k| 2.0 * first * 0.7f64.powi(k)).sum::<f64>()
}

#[test]
fn closed_form_counters_are_shown_once_the_events_of_a_step_are_handled() {
    let (mut messages, mut flags, mut reached) = (Vec::new(), [7; 3], 0.0);
    let c = of_fmi3(1, 0, &mut messages);
    let [event, terminate, early] = &mut flags;
    let (mut update, mut next) = ([7; 5], 0.0);
    let [needed, ends, nominals, values, defined] = &mut update;
    unsafe {
        assert_eq!(fmi3UpdateDiscreteStates(c, needed, ends, nominals, values, defined, &mut next), OK);
        assert_eq!(fmi3EnterStepMode(c), OK);
        assert_eq!(fmi3DoStep(c, 0.0, 1.5, 1, event, terminate, early, &mut reached), OK);
        assert_eq!((*event, *early, reached), (1, 0, 1.5));
        let (expected, count) = closed_form(1.5);
        let (shown, bounces) = height(c);
        assert!((shown - expected).abs() < ROUNDING && count > 1, "{shown} {expected} {count}");
        assert_eq!(bounces, 0);
        // Saved states contain the shown values.
        let mut state = null_mut();
        assert_eq!(fmi3GetFMUState(c, &mut state), OK);
        assert_eq!(fmi3EnterEventMode(c), OK);
        assert_near(height(c), 1.5);
        assert_eq!(fmi3SetFMUState(c, state), OK);
        assert_eq!(height(c).1, 0);
        assert_eq!(fmi3EnterEventMode(c), OK);
        assert_eq!(fmi3UpdateDiscreteStates(c, needed, ends, nominals, values, defined, &mut next), OK);
        assert_near(height(c), 1.5);
        fmi3FreeInstance(c);
    }
}

/// Observations of the callback.
struct Seen {
    instance: Cell<FmiInstance>,
    /// Time, height and bounces of each call.
    calls: RefCell<Vec<(f64, f64, i32)>>,
    /// Number of calls after which the step is to end.
    ends_after: usize,
}

unsafe extern "C-unwind" fn look(
    host: *mut c_void,
    time: f64,
    set: u8,
    _: u8,
    _: u8,
    may_return: u8,
    early: *mut u8,
    end: *mut f64,
) {
    // SAFETY: the host's own data, which live as long as the instance, and two valid variables.
    unsafe {
        let seen = &*host.cast::<Seen>();
        assert_eq!((set, may_return), (0, 1));
        let (height, bounces) = height(seen.instance.get());
        seen.calls.borrow_mut().push((time, height, bounces));
        (*early, *end) = (u8::from(seen.calls.borrow().len() == seen.ends_after), time);
    }
}

#[test]
fn closed_form_bounces_that_a_callback_sees() {
    for (ends_after, calls, reached_at) in [(usize::MAX, 4, 1.8), (2, 2, bounce(2))] {
        let seen = Seen { instance: Cell::new(null_mut()), calls: RefCell::default(), ends_after };
        let (mut flags, mut reached) = ([7; 3], 0.0);
        let [event, terminate, early] = &mut flags;
        unsafe {
            let host = from_ref(&seen).cast_mut().cast();
            let (token, none) = (token(), null());
            let c = fmi3InstantiateCoSimulation(
                c"ball".as_ptr(),
                token.as_ptr(),
                none,
                0,
                0,
                0,
                1,
                null(),
                0,
                host,
                None,
                Some(look),
            );
            seen.instance.set(c);
            assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi3ExitInitializationMode(c), OK);
            assert_eq!(fmi3DoStep(c, 0.0, 1.8, 1, event, terminate, early, &mut reached), OK);
            assert_eq!((*event, *early), (0, u8::from(ends_after == 2)));
            assert!((reached - reached_at).abs() < ROUNDING, "{reached} {reached_at}");
            let calls_seen = seen.calls.borrow();
            assert_eq!(calls_seen.len(), calls);
            // Each bounce before its law, then the step's end.
            for (n, &(time, height, bounces)) in (1..).zip(&*calls_seen) {
                assert_eq!(bounces, n - 1);
                let (at, expected) = if n == 4 { (1.8, closed_form(1.8).0) } else { (bounce(n), 0.0) };
                assert!((time - at).abs() < ROUNDING, "{time} {at}");
                assert!((height - expected).abs() < ROUNDING, "{height} {expected}");
            }
            if ends_after == usize::MAX {
                assert_near(height(c), 1.8);
            }
            fmi3FreeInstance(c);
        }
    }
}
