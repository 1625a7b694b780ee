//! Instantiation, and the log messages about it and about calls, through both doors.

use super::arguments::step;
use super::bouncing_ball::*;
use super::host::{Host, callbacks};
use super::{ERROR, OK, token};
use fmi_doors::Interface;
use std::ffi::{c_char, c_int, c_void};
use std::ptr::{from_mut, null, null_mut};

#[test]
fn instantiations_of_fmi2_that_cannot_be_are_null_and_logged() {
    let token = token();
    for (name, kind, guid, text) in [
        (c"a", 1, c"{no}", "a 3 logStatusError fmi2Instantiate: fmuGUID = \"{no}\": expected {"),
        (c" ", 1, &*token, "  3 logStatusError fmi2Instantiate: instanceName = \" \": expected"),
        (c"a", 2, &*token, "a 3 logStatusError fmi2Instantiate: fmuType = 2: expected 0"),
    ] {
        let host = Host::of_fmi2(name, kind, guid);
        assert!(host.c.is_null());
        assert!(host.last().starts_with(text), "{}", host.last());
    }
    unsafe {
        assert!(fmi2Instantiate(null(), 1, token.as_ptr(), null(), null(), 0, 0).is_null());
        assert!(fmi2Instantiate(c"a".as_ptr(), 1, null(), null(), null(), 0, 0).is_null());
        // An instance without callbacks logs nothing.
        let c = fmi2Instantiate(c"a".as_ptr(), 1, token.as_ptr(), null(), null(), 0, 1);
        assert_eq!(fmi2DoStep(c, 0.0, 1.0, 0), ERROR);
        fmi2FreeInstance(c);
    }
}

#[test]
fn instantiations_of_fmi3_that_cannot_be_are_null_and_logged() {
    let (mut log, name, token) = (Vec::<String>::new(), c"a".as_ptr(), token());
    let (host, keep, token) = (from_mut(&mut log).cast(), Some(super::keep as _), token.as_ptr());
    let mut texts = Vec::new();
    unsafe {
        let make = |name, token, logging, required: &[u32]| {
            let (list, count) = (required.as_ptr(), required.len());
            fmi3InstantiateCoSimulation(name, token, null(), 0, logging, 0, 0, list, count, host, keep, None)
        };
        for (c, text) in [
            (make(name, c"{no}".as_ptr(), 1, &[]), "CoSimulation: instantiationToken = \"{no}\": expected {"),
            (make(c" ".as_ptr(), token, 1, &[]), "CoSimulation: instanceName = \" \": expected text"),
            (make(null(), token, 1, &[]), "CoSimulation: instanceName is null"),
            (make(name, null(), 1, &[]), "CoSimulation: instantiationToken is null"),
            (make(name, token, 1, &[9999]), "CoSimulation: value reference 9999 is no"),
            (
                fmi3InstantiateScheduledExecution(name, token, null(), 0, 1, host, keep, None, None, None),
                "ScheduledExecution: the model has no partitions",
            ),
        ] {
            assert!(c.is_null(), "{text}");
            texts.push(format!("logStatusError fmi3Instantiate{text}"));
        }
        let log = &mut *host.cast::<Vec<String>>();
        assert_eq!(log.len(), texts.len());
        assert!(log.iter().zip(&texts).all(|(line, text)| line.starts_with(text)), "{log:?} {texts:?}");
        log.clear();
        // Without logging, and without a logger.
        assert!(make(name, c"{no}".as_ptr(), 0, &[]).is_null());
        assert!((*host.cast::<Vec<String>>()).is_empty());
        let quiet = fmi3InstantiateModelExchange(name, token, null(), 1, 1, null_mut(), None);
        assert_eq!(fmi3EnterStepMode(quiet), ERROR);
        fmi3FreeInstance(quiet);
    }
}

#[test]
fn logging_is_switched_by_category() {
    let mut messages = Vec::new();
    let c = super::of_fmi3(0, 0, &mut messages);
    unsafe {
        assert_eq!(fmi3SetDebugLogging(c, 0, 0, null()), OK);
        assert_eq!(step(c, 0.0, 1.0).0, OK);
        assert!(messages.is_empty(), "{messages:?}");
        assert_eq!(fmi3SetDebugLogging(c, 1, 1, &c"logEvents".as_ptr()), OK);
        assert_eq!(step(c, 1.0, 1.0).0, OK);
        let events = messages.len();
        assert!(events > 1 && messages.iter().all(|line| line.starts_with("logEvents bounce")));
        assert_eq!(fmi3SetTime(c, 0.0), ERROR);
        assert_eq!(messages.len(), events, "errors are off");
        fmi3FreeInstance(c);
    }
}

/// FMI 2.0 formats messages as printf does, and both versions read # as a reference.
#[test]
fn messages_are_finished_text() {
    let (host, category) = (Host::of_fmi2(c"ball %d", 1, &token()), c"100 % #1".as_ptr());
    assert_eq!(unsafe { fmi2DoStep(host.c, 0.0, 1.0, 0) }, ERROR);
    let refusal = "fmi2DoStep: cannot be called in state Instantiated of Co-Simulation";
    assert_eq!(host.last(), format!("ball %d 3 logStatusError {refusal}"));
    assert_eq!(unsafe { fmi2SetDebugLogging(host.c, 1, 1, &category) }, ERROR);
    assert!(
        host.last().contains("category = \"100 %% ##1\": expected one of logEvents, "),
        "{}",
        host.last()
    );
    let host = Host::of_fmi3(Interface::CoSimulation);
    assert_eq!(unsafe { fmi3SetDebugLogging(host.c, 1, 1, &category) }, ERROR);
    assert!(host.last().contains("category = \"100 % ##1\": expected one of logEvents, "), "{}", host.last());
}

/// Calls into the instance from its own logger: the instance, and the statuses.
type Within = (*mut c_void, Vec<c_int>);

unsafe extern "C" fn call_back2(
    within: *mut c_void,
    _: *const c_char,
    _: c_int,
    _: *const c_char,
    _: *const c_char,
) {
    let (c, statuses) = unsafe { &mut *within.cast::<Within>() };
    unsafe {
        statuses.push(fmi2Reset(*c));
        fmi2FreeInstance(*c);
    }
}

unsafe extern "C-unwind" fn call_back3(within: *mut c_void, _: c_int, _: *const c_char, _: *const c_char) {
    let (c, statuses) = unsafe { &mut *within.cast::<Within>() };
    unsafe {
        statuses.push(fmi3Reset(*c));
        fmi3FreeInstance(*c);
    }
}

unsafe extern "C-unwind" fn unwind(_: *mut c_void, _: c_int, _: *const c_char, _: *const c_char) {
    panic!("in the logger");
}

#[test]
fn calls_from_inside_the_logger_are_refused_and_its_panics_are_caught() {
    let (name, token) = (c"a".as_ptr(), token());
    let (mut two, mut three): (Within, Within) = ((null_mut(), vec![]), (null_mut(), vec![]));
    let (two, three) = (&raw mut two, &raw mut three);
    unsafe {
        let callbacks = callbacks(call_back2, two.cast());
        let c = fmi2Instantiate(name, 1, token.as_ptr(), null(), &callbacks, 0, 1);
        (*two).0 = c;
        assert_eq!(fmi2DoStep(c, 0.0, 1.0, 0), ERROR);
        assert_eq!((*two).1, [ERROR]);
        assert_eq!(fmi2Reset(c), OK);
        fmi2FreeInstance(c);
        let make = |environment, log| {
            fmi3InstantiateModelExchange(name, token.as_ptr(), null(), 0, 1, environment, Some(log))
        };
        let c = make(three.cast(), call_back3);
        (*three).0 = c;
        assert_eq!(fmi3EnterStepMode(c), ERROR);
        assert_eq!((*three).1, [ERROR]);
        assert_eq!(fmi3Reset(c), OK);
        fmi3FreeInstance(c);
        let c = make(null_mut(), unwind);
        assert_eq!(fmi3EnterStepMode(c), ERROR);
        fmi3FreeInstance(c);
    }
}
