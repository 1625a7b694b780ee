//! Bad input, case by case: what is answered, and what the instance is afterwards.

use super::host::*;
use std::ptr::{null, null_mut};
use vibro_paper_component::fmi3::abi::*;

/// After an error getters answer, steps and sets do not; Reset or a saved state leads out.
fn assert_terminated(fmu: &Fmu) {
    let point = fmu.get("time");
    assert_eq!(fmu.try_step(point, 0.1).0, ERROR);
    assert!(fmu.last().contains("not allowed in state Terminated of Co-Simulation, after an error in fmi3"));
    assert_eq!(fmu.set("box.f", 0.0), ERROR);
    // SAFETY: a live instance.
    assert_eq!(unsafe { fmi3Reset(fmu.c) }, OK);
    fmu.initialize();
    fmu.step(0.0, 0.1);
}

#[test]
fn wrong_calls_are_errors_that_terminate() {
    let (box_s, mode) = (vr("box.s"), vr("mode"));
    let odd = |p: *mut f64| p.wrapping_byte_add(1);
    let mut values = [0.0; 2];
    let v = values.as_mut_ptr();
    type Wrong<'a> = (&'a str, &'a dyn Fn(FmiInstance) -> i32);
    // SAFETY (all): wrong as intended, and checked before anything is followed.
    let cases: [Wrong; 14] = unsafe {
        [
            (
                "value reference 0 is no Float64 variable: allowed are those of the model description, from 1 to ",
                &|c| fmi3GetFloat64(c, &0, 1, [0.0].as_mut_ptr(), 1),
            ),
            ("value reference 4294967295 is no Float64 variable", &|c| {
                fmi3GetFloat64(c, &u32::MAX, 1, [0.0].as_mut_ptr(), 1)
            }),
            ("is no Int32 variable: mode is", &|c| fmi3GetInt32(c, &mode, 1, &mut 0, 1)),
            ("is no Float32 variable: box.s is", &|c| fmi3GetFloat32(c, &box_s, 1, &mut 0.0, 1)),
            ("is no Binary variable: box.s is", &|c| {
                fmi3GetBinary(c, &box_s, 1, &mut 0, [null()].as_mut_ptr(), 1)
            }),
            ("nValues = 2: allowed is 1", &|c| fmi3GetFloat64(c, &box_s, 1, [0.0; 2].as_mut_ptr(), 2)),
            ("nValues = 0: allowed is 1", &|c| fmi3SetFloat64(c, &vr("box.f"), 1, null(), 0)),
            ("nValues = 3: allowed is 1", &|c| fmi3GetFloat64(c, &box_s, 1, [0.0; 3].as_mut_ptr(), 3)),
            ("values is null or misaligned", &|c| fmi3GetFloat64(c, &box_s, 1, null_mut(), 1)),
            ("values is null or misaligned", &|c| fmi3GetFloat64(c, &box_s, 1, odd(v), 1)),
            ("valueReferences is null or misaligned", &|c| fmi3GetFloat64(c, null(), 1, v, 1)),
            ("number of elements", &|c| fmi3GetFloat64(c, &box_s, usize::MAX, v, 1)),
            ("not allowed in state StepMode of Co-Simulation", &|c| fmi3SetTime(c, 1.0)),
            ("not allowed in state StepMode of Co-Simulation", &|c| fmi3EvaluateDiscreteStates(c)),
        ]
    };
    for (text, wrong) in cases {
        let fmu = Fmu::started(FF, &[]);
        fmu.step(0.0, 1.0);
        let before = fmu.motion();
        assert_eq!(wrong(fmu.c), ERROR, "{text}");
        assert!(fmu.last().contains(text), "{} instead of {text}", fmu.last());
        assert_eq!(fmu.log().last().map(|r| (r.0, &*r.1)), Some((ERROR, "logStatusError")));
        assert_eq!(fmu.motion(), before, "{text}");
        assert_terminated(&fmu);
    }
}

#[test]
fn variables_that_cannot_be_set_now_are_errors() {
    for (name, value) in
        [("box.m", 1.0), ("box.a", 1.0), ("impacts.upper", 1.0), ("stopAtImpact", 0.0), ("box.s", 0.0)]
    {
        let fmu = Fmu::started(FF, &[]);
        assert_eq!(fmu.set(name, value), ERROR, "{name}");
        assert!(fmu.last().contains(name) && fmu.last().contains("cannot be set"), "{}", fmu.last());
        assert_terminated(&fmu);
    }
}

#[test]
fn values_the_model_cannot_take_are_discarded_and_nothing_changes() {
    let fmu = Fmu::started(FF, &[]);
    fmu.step(0.0, 1.0);
    for (name, value) in [
        ("stop.restitution", 1.5),
        ("stop.restitution", -0.1),
        ("drive.amplitude", f64::NAN),
        ("box.f", f64::INFINITY),
        ("box.k", -1.0),
    ] {
        let before = fmu.get(name);
        assert_eq!(fmu.set(name, value), DISCARD, "{name}");
        assert_eq!(fmu.log().last().map(|r| (r.0, &*r.1)), Some((DISCARD, "logStatusDiscard")));
        assert!(fmu.last().contains(&format!("{name} = {value}: allowed is")), "{}", fmu.last());
        assert_eq!(fmu.get(name), before);
    }
    // All are checked before any is set.
    let (references, values) = ([vr("box.f"), vr("block.f")], [0.5, f64::NAN]);
    // SAFETY: two of each.
    assert_eq!(unsafe { fmi3SetFloat64(fmu.c, references.as_ptr(), 2, values.as_ptr(), 2) }, DISCARD);
    assert_eq!(fmu.get("box.f"), 0.0);
    fmu.step(1.0, 1.0);
}

#[test]
fn impossible_starts_are_discarded_and_can_be_mended() {
    let fmu = Fmu::new(FF);
    assert_eq!(fmu.set("block.s", 1.5), OK);
    // SAFETY: a live instance.
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(fmu.c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(fmu.c), DISCARD, "{}", fmu.last());
        assert_eq!(fmu.set("block.s", 0.5), OK);
        assert_eq!(fmi3ExitInitializationMode(fmu.c), OK);
    }
}

#[test]
fn loads_in_a_closed_form_are_discarded() {
    for flags in [FF, TT] {
        let fmu = Fmu::started(flags, &[("mode", 3.0)]);
        fmu.step(0.0, 0.1);
        assert_eq!(fmu.set("box.f", 0.1), DISCARD);
        assert!(fmu.last().contains("box.f = 0.1: allowed is 0 in a closed-form mode"), "{}", fmu.last());
        assert_eq!(fmu.set("box.f", 0.0), OK);
        fmu.step(0.1, 0.1);
    }
}

#[test]
fn steps_that_cannot_be_are_errors_at_the_time_reached() {
    for (point, size, text) in [
        (3.0, 1.0, "currentCommunicationPoint = 3 s"),
        (f64::NAN, 1.0, "currentCommunicationPoint = NaN"),
        (2.0, 0.0, "communicationStepSize = 0"),
        (2.0, -1.0, "communicationStepSize = -1"),
        (2.0, f64::INFINITY, "communicationStepSize = inf"),
        (2.0, 9.0, "step to t = 11 s: allowed is up to the stop time 10 s"),
    ] {
        let fmu = Fmu::new(FF);
        // SAFETY: a live instance.
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(fmu.c, 1, 1e-6, 0.0, 1, 10.0), OK);
            assert_eq!(fmi3ExitInitializationMode(fmu.c), OK);
        }
        fmu.step(0.0, 2.0);
        let (status, end) = fmu.try_step(point, size);
        assert_eq!((status, end), (ERROR, End { time: 2.0, ..End::default() }), "{text}");
        assert!(fmu.last().contains(text), "{}", fmu.last());
        assert_terminated(&fmu);
    }
}

/// Elastic stops against which the block is pressed, the box being driven the other way: more
/// events than one step may take. It is taken back, and the state saved before leads on in smaller
/// steps.
#[test]
fn a_step_with_too_many_events_is_an_error_and_is_taken_back() {
    let fmu = Fmu::started(
        FF,
        &[("stop.restitution", 1.0), ("block.s", 0.99), ("box.f", -100.0), ("block.f", 100.0)],
    );
    // Quiet, so that events are not logged one by one.
    // SAFETY: one C string.
    assert_eq!(unsafe { fmi3SetDebugLogging(fmu.c, 0, 1, &c"logEvents".as_ptr()) }, OK);
    fmu.step(0.0, 1.0);
    let (state, before) = (fmu.save(), fmu.motion());
    let (status, end) = fmu.try_step(1.0, 1e5);
    assert_eq!((status, end), (ERROR, End { time: 1.0, ..End::default() }));
    for part in ["fmi3DoStep: ", "stop.restitution = 1 ", "t = 1 s", "smaller steps"] {
        assert!(fmu.last().contains(part), "{part}: {}", fmu.last());
    }
    assert_eq!(fmu.motion(), before);
    // SAFETY: a live instance and its own state.
    assert_eq!(unsafe { fmi3SetFMUState(fmu.c, state) }, OK);
    for i in 1..=20 {
        let end = fmu.step(f64::from(i), 1.0);
        assert_eq!(end.time, f64::from(i + 1));
    }
}

#[test]
fn broken_saved_states_are_errors_and_change_nothing() {
    let fmu = Fmu::started(FF, &[]);
    fmu.step(0.0, 3.0);
    let bytes = fmu.bytes();
    let mut flipped = bytes.clone();
    flipped[40] ^= 1;
    let mut foreign = bytes.clone();
    foreign[8] ^= 1;
    for broken in [&bytes[..bytes.len() - 1], &flipped, &foreign, &bytes[..3]] {
        let fmu = Fmu::started(FF, &[]);
        let (mut state, before) = (null_mut(), fmu.motion());
        // SAFETY: a live instance; as many bytes as are said.
        unsafe {
            assert_eq!(fmi3DeserializeFMUState(fmu.c, broken.as_ptr(), broken.len(), &mut state), ERROR);
        }
        assert!(state.is_null() && fmu.last().contains("saved state refused"), "{}", fmu.last());
        assert_eq!(fmu.motion(), before);
        // A good one leads out of Terminated.
        fmu.restore(&bytes);
        fmu.step(3.0, 1.0);
    }
    // SAFETY: any address is safe.
    assert_eq!(unsafe { fmi3SetFMUState(fmu.c, 12345 as *mut _) }, ERROR);
    assert_terminated(&fmu);
}

/// `fmi3Boolean` is one byte; any but 0 is true.
#[test]
fn booleans_are_bytes() {
    let fmu = Fmu::new(FF);
    let r = vr("startOnOrbit");
    for (byte, expected) in [(1_u8, 1), (255, 1), (2, 1), (0, 0)] {
        let mut read = [7_u8; 3];
        // SAFETY: one of each; the byte beside is not touched.
        unsafe {
            assert_eq!(fmi3SetBoolean(fmu.c, &r, 1, &byte, 1), OK);
            assert_eq!(fmi3GetBoolean(fmu.c, &r, 1, &mut read[1], 1), OK);
        }
        assert_eq!(read, [7, expected, 7]);
    }
}

/// No elements: any pointers are accepted, of every type.
#[test]
fn no_elements_are_no_error() {
    let fmu = Fmu::started(TT, &[]);
    let c = fmu.c;
    // SAFETY: nothing is followed.
    let statuses = unsafe {
        [
            fmi3GetFloat32(c, null(), 0, null_mut(), 0),
            fmi3GetFloat64(c, null(), 0, null_mut(), 0),
            fmi3GetInt8(c, null(), 0, null_mut(), 0),
            fmi3GetUInt8(c, null(), 0, null_mut(), 0),
            fmi3GetInt16(c, null(), 0, null_mut(), 0),
            fmi3GetUInt16(c, null(), 0, null_mut(), 0),
            fmi3GetInt32(c, null(), 0, null_mut(), 0),
            fmi3GetUInt32(c, null(), 0, null_mut(), 0),
            fmi3GetInt64(c, null(), 0, null_mut(), 0),
            fmi3GetUInt64(c, null(), 0, null_mut(), 0),
            fmi3GetBoolean(c, null(), 0, null_mut(), 0),
            fmi3GetString(c, null(), 0, null_mut(), 0),
            fmi3GetBinary(c, null(), 0, null_mut(), null_mut(), 0),
            fmi3GetClock(c, null(), 0, null_mut()),
            fmi3SetFloat32(c, null(), 0, null(), 0),
            fmi3SetFloat64(c, null(), 0, null(), 0),
            fmi3SetInt8(c, null(), 0, null(), 0),
            fmi3SetUInt8(c, null(), 0, null(), 0),
            fmi3SetInt16(c, null(), 0, null(), 0),
            fmi3SetUInt16(c, null(), 0, null(), 0),
            fmi3SetInt32(c, null(), 0, null(), 0),
            fmi3SetUInt32(c, null(), 0, null(), 0),
            fmi3SetInt64(c, null(), 0, null(), 0),
            fmi3SetUInt64(c, null(), 0, null(), 0),
            fmi3SetBoolean(c, null(), 0, null(), 0),
            fmi3SetString(c, null(), 0, null(), 0),
            fmi3SetBinary(c, null(), 0, null(), null(), 0),
        ]
    };
    assert_eq!(statuses, [OK; 27]);
}

/// Start values can be read before initialization, as hosts do that show them.
#[test]
fn start_values_are_read_before_initialization() {
    let fmu = Fmu::new(FF);
    assert_eq!(fmu.get("stopAtImpact"), 1.0);
    assert_eq!(fmu.set("block.s", 0.25), OK);
    assert_eq!((fmu.get("block.s"), fmu.get("mode")), (0.25, 1.0));
    for (_, variable) in
        vibro_paper_component::fmi3::description::variables(vibro_paper_component::fmi3::description::MAIN)
    {
        let _ = fmu.get(variable.name);
    }
    assert!(fmu.log().is_empty(), "{:?}", fmu.log());
}

#[test]
fn event_mode_that_was_not_agreed_on_is_an_error() {
    let fmu = Fmu::started(FT, &[]);
    // SAFETY: a live instance.
    assert_eq!(unsafe { fmi3EnterEventMode(fmu.c) }, ERROR);
    assert!(fmu.last().ends_with("eventModeUsed was false at the instantiation"), "{}", fmu.last());
    assert_terminated(&fmu);
}

/// OMSimulator asks for several derivatives with one seed: strict, with the count in the message.
#[test]
fn a_seed_of_another_length_is_an_error() {
    let fmu = Fmu::started(FF, &[]);
    let (unknowns, knowns) = ([vr("box.a")], [vr("box.f"), vr("block.f")]);
    let mut sensitivity = [0.0; 2];
    // SAFETY: as many elements as are said.
    let status = unsafe {
        fmi3GetDirectionalDerivative(
            fmu.c,
            unknowns.as_ptr(),
            1,
            knowns.as_ptr(),
            2,
            [1.0].as_ptr(),
            1,
            sensitivity.as_mut_ptr(),
            1,
        )
    };
    assert_eq!(status, ERROR);
    assert!(fmu.last().contains("nSeed = 1: allowed is 2"), "{}", fmu.last());
}

/// Who calls on after an error learns which call it was; after `fmi3Terminate` there was none.
#[test]
fn a_refused_call_in_terminated_names_the_error_that_led_there() {
    let fmu = Fmu::started(FF, &[]);
    // SAFETY (all): live instances, wrong as intended.
    unsafe { assert_eq!(fmi3GetFloat64(fmu.c, &9999, 1, &mut 0.0, 1), ERROR) };
    assert_eq!(fmu.try_step(0.0, 1.0).0, ERROR);
    assert!(
        fmu.last().contains(
            "not allowed in state Terminated of Co-Simulation, after an error in fmi3GetFloat64: restore"
        ),
        "{}",
        fmu.last()
    );
    // The first error stays the cause.
    assert_eq!(fmu.try_step(0.0, 1.0).0, ERROR);
    assert!(fmu.last().contains("after an error in fmi3GetFloat64"), "{}", fmu.last());
    let fmu = Fmu::started(FF, &[]);
    assert_eq!(unsafe { fmi3Terminate(fmu.c) }, OK);
    assert_eq!(fmu.try_step(0.0, 1.0).0, ERROR);
    assert!(fmu.last().contains("Terminated of Co-Simulation: restore"), "{}", fmu.last());
}
