//! The callback of an intermediate update that misbehaves.

use super::*;

/// What the callback does, and what came of it.
struct Environment {
    c: FmiInstance,
    what: fn(FmiInstance) -> FmiStatus,
    statuses: Vec<FmiStatus>,
}

#[allow(clippy::too_many_arguments)]
unsafe extern "C-unwind" fn misbehave(
    environment: *mut c_void,
    _: f64,
    _: FmiBoolean,
    _: FmiBoolean,
    _: FmiBoolean,
    _: FmiBoolean,
    _: *mut FmiBoolean,
    _: *mut f64,
) {
    let environment = unsafe { &mut *environment.cast::<Environment>() };
    let status = (environment.what)(environment.c);
    environment.statuses.push(status);
}

/// A step with that callback: its status, the last successful time, the statuses inside, and the
/// instance.
fn step(what: fn(FmiInstance) -> FmiStatus) -> (FmiStatus, f64, Vec<FmiStatus>, FmiInstance) {
    let mut environment = Box::new(Environment { c: null_mut(), what, statuses: Vec::new() });
    let required = [vr("box.f")];
    let (mut flags, mut time) = ([7; 3], f64::NAN);
    unsafe {
        let c = fmi3InstantiateCoSimulation(
            c"a".as_ptr(),
            token().as_ptr(),
            null(),
            0,
            0,
            0,
            0,
            required.as_ptr(),
            1,
            std::ptr::from_mut(&mut *environment).cast(),
            None,
            Some(misbehave),
        );
        environment.c = c;
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), OK);
        let [event, terminate, early] = &mut flags;
        let status = fmi3DoStep(c, 0.0, 0.5, 1, event, terminate, early, &mut time);
        (status, time, environment.statuses.clone(), c)
    }
}

fn calls_back(c: FmiInstance) -> FmiStatus {
    let (mut flags, mut time) = ([7; 3], 0.0);
    let [event, terminate, early] = &mut flags;
    unsafe { fmi3DoStep(c, 0.0, 0.5, 1, event, terminate, early, &mut time) }
}

/// Steps, resets, and states of the whole FMU inside are errors; the step is taken back, and Reset
/// leads out.
#[test]
fn calls_that_change_the_step_are_refused() {
    let cases: [fn(FmiInstance) -> FmiStatus; 6] = [
        calls_back,
        |c| unsafe { fmi3Reset(c) },
        |c| unsafe { fmi3GetFMUState(c, &mut null_mut()) },
        |c| unsafe { fmi3Terminate(c) },
        |c| unsafe { fmi3GetFloat64(c, &vr("box.s"), 1, &mut 0.0, 1) }, // while inputs are asked for
        |c| unsafe { fmi3SetFloat64(c, &vr("block.f"), 1, &0.0, 1) },   // not required
    ];
    for what in cases {
        let (status, time, inside, c) = step(what);
        assert_eq!((status, time), (ERROR, 0.0));
        assert_eq!(inside, [ERROR]);
        unsafe {
            assert_eq!(fmi3Reset(c), OK);
            fmi3FreeInstance(c);
        }
    }
}

#[test]
fn freeing_inside_the_callback_is_ignored() {
    let (status, time, inside, c) = step(|c| {
        unsafe { fmi3FreeInstance(c) };
        OK
    });
    assert_eq!((status, time), (OK, 0.5));
    assert_eq!(inside.len(), 4, "three for inputs, one at the end");
    unsafe { fmi3FreeInstance(c) };
}

#[test]
fn a_callback_that_unwinds_is_fatal() {
    let (status, _, inside, c) = step(|_| panic!("in the callback"));
    assert_eq!((status, inside.len()), (FATAL, 0));
    unsafe {
        assert_eq!(fmi3Reset(c), ERROR);
        fmi3FreeInstance(c);
    }
}
