//! Instantiation, and what is logged of it and of calls (FMI 3.0.2, 2.3.1).

use super::host::*;
use std::ffi::{CStr, CString};
use std::ptr::{null, null_mut};
use vibro_paper_component::fmi3::abi::*;

#[test]
fn instantiations_that_cannot_be_are_null_and_logged() {
    unsafe extern "C-unwind" fn keep(
        environment: *mut std::ffi::c_void,
        status: i32,
        category: *const std::ffi::c_char,
        message: *const std::ffi::c_char,
    ) {
        // SAFETY: as the test sets it up.
        unsafe {
            let text = |p| CStr::from_ptr(p).to_str().unwrap().to_owned();
            (*environment.cast::<Vec<Record>>()).push((status, text(category), text(message)));
        }
    }
    let mut log = Vec::<Record>::new();
    let environment = (&raw mut log).cast();
    let token = token();
    // SAFETY: valid strings or null; the logger is called inside only.
    unsafe {
        let make = |name: *const _, token: *const _, on| {
            fmi3InstantiateCoSimulation(
                name,
                token,
                null(),
                0,
                on,
                0,
                0,
                null(),
                0,
                environment,
                Some(keep),
                None,
            )
        };
        assert!(make(c"a".as_ptr(), c"{no}".as_ptr(), 1).is_null());
        assert!(make(c" ".as_ptr(), token.as_ptr(), 1).is_null());
        assert!(make(null(), token.as_ptr(), 1).is_null());
        assert!(make(c"a".as_ptr(), null(), 1).is_null());
        let scheduled = fmi3InstantiateScheduledExecution(
            c"a".as_ptr(),
            token.as_ptr(),
            null(),
            0,
            1,
            environment,
            Some(keep),
            None,
            None,
            None,
        );
        assert!(scheduled.is_null());
        let unknown = [9999];
        let required = fmi3InstantiateCoSimulation(
            c"a".as_ptr(),
            token.as_ptr(),
            null(),
            0,
            1,
            0,
            0,
            unknown.as_ptr(),
            1,
            environment,
            Some(keep),
            None,
        );
        assert!(required.is_null());
        let texts: Vec<_> = log.iter().map(|record| (record.0, &*record.2)).collect();
        let expected = [
            "fmi3InstantiateCoSimulation: instantiationToken = \"{no}\": allowed is {",
            "fmi3InstantiateCoSimulation: instanceName = \" \": allowed is text",
            "fmi3InstantiateCoSimulation: instanceName is null",
            "fmi3InstantiateCoSimulation: instantiationToken is null",
            "fmi3InstantiateScheduledExecution: the model has no partitions",
            "fmi3InstantiateCoSimulation: value reference 9999 is no",
        ];
        assert_eq!(texts.len(), expected.len());
        for ((status, text), expected) in texts.iter().zip(expected) {
            assert!(*status == ERROR && text.starts_with(expected), "{text}");
        }
        // Silent where logging is off; no logger at all; version 2's GUID is none of version 3.
        assert!(make(c"a".as_ptr(), c"{no}".as_ptr(), 0).is_null());
        assert_eq!(log.len(), expected.len());
        let guid = CString::new(vibro_paper_component::fmi2::description::guid()).unwrap();
        assert!(make(c"a".as_ptr(), guid.as_ptr(), 0).is_null());
        let quiet =
            fmi3InstantiateModelExchange(c"a".as_ptr(), token.as_ptr(), null(), 1, 1, null_mut(), None);
        assert!(!quiet.is_null());
        assert_eq!(fmi3EnterStepMode(quiet), ERROR);
        fmi3FreeInstance(quiet);
    }
}

#[test]
fn messages_escape_references_only() {
    let fmu = Fmu::new(FF);
    let category = c"100 % #1".as_ptr();
    // SAFETY: one C string.
    assert_eq!(unsafe { fmi3SetDebugLogging(fmu.c, 1, 1, &category) }, ERROR);
    assert!(fmu.last().contains("category = \"100 % ##1\": allowed is logEvents, "), "{}", fmu.last());
}

#[test]
fn logging_is_switched_by_category() {
    let fmu = Fmu::started(FF, &[("block.s", 0.9)]);
    let categories = [c"logEvents".as_ptr()];
    // SAFETY: one C string.
    unsafe {
        assert_eq!(fmi3SetDebugLogging(fmu.c, 0, 0, null()), OK);
        fmu.step(0.0, 10.0);
        assert!(fmu.log().is_empty());
        assert_eq!(fmi3SetDebugLogging(fmu.c, 1, 1, categories.as_ptr()), OK);
        fmu.step(10.0, 10.0);
        assert!(fmu.log().len() > 1 && fmu.log().iter().all(|r| r.0 == OK && r.1 == "logEvents"));
        let logged = fmu.log().len();
        assert_eq!(fmi3SetTime(fmu.c, 0.0), ERROR);
        assert_eq!(fmu.log().len(), logged, "errors are off");
    }
}
