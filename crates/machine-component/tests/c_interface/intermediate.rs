//! Steps with intermediate updates: inputs as functions of time, outputs before each event and at
//! the end, early return.

use crate::host::*;
use crate::*;
use fmi_doors::fmi3::abi::FmiInstance;
use std::ffi::{CString, c_void};
use std::ptr::{from_mut, null, null_mut};
use vibro_machine_component::{FILE, Plan};

/// Actions and observations of a host in its callback.
#[derive(Default)]
struct Course {
    c: Option<FmiInstance>,
    /// The input to set, as a function of time.
    input: Option<u32>,
    course: Option<fn(f64) -> f64>,
    /// Variables to read.
    output: u32,
    /// Requested end of the step.
    until: Option<f64>,
    seen: Vec<(f64, f64)>,
    asked: Vec<f64>,
}

unsafe extern "C-unwind" fn update(
    host: *mut c_void,
    time: f64,
    set: u8,
    get: u8,
    finished: u8,
    may_return: u8,
    early: *mut u8,
    end: *mut f64,
) {
    let host = unsafe { &mut *host.cast::<Course>() };
    let c = host.c.unwrap();
    unsafe { *early = 0 };
    if set != 0 {
        host.asked.push(time);
        let (reference, value) = (host.input.unwrap(), host.course.unwrap());
        assert_eq!(unsafe { fmi3SetFloat64(c, &reference, 1, &value(time), 1) }, OK);
        return;
    }
    assert_eq!([get, finished], [1, 1]);
    let mut value = f64::NAN;
    assert_eq!(unsafe { fmi3GetFloat64(c, &host.output, 1, &mut value, 1) }, OK);
    host.seen.push((time, value));
    if let Some(until) = host.until.filter(|_| may_return != 0) {
        unsafe { (*early, *end) = (1, until) };
    }
}

/// An initialized instance with a callback, which requires the inputs.
fn instance(plan: &Plan, name: &str, host: &mut Course, event_mode: bool) -> FmiInstance {
    let folder = CString::new(resources(name, plan).to_str().unwrap()).unwrap();
    let token = CString::new(plan.token()).unwrap();
    let required: Vec<u32> = host.input.into_iter().collect();
    let events = u8::from(event_mode);
    unsafe {
        let c = fmi3InstantiateCoSimulation(
            c"a".as_ptr(),
            token.as_ptr(),
            folder.as_ptr(),
            0,
            0,
            events,
            1,
            if required.is_empty() { null() } else { required.as_ptr() },
            required.len(),
            from_mut(host).cast(),
            None,
            Some(update),
        );
        assert!(!c.is_null());
        host.c = Some(c);
        assert_eq!(fmi3EnterInitializationMode(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(c), OK);
        if event_mode {
            assert_eq!(fmi3EnterStepMode(c), OK);
        }
        c
    }
}

/// Makes a step. Returns its status, whether an event has to be handled, whether it ended early,
/// and the time reached.
fn step(c: FmiInstance, point: f64, size: f64) -> (i32, bool, bool, f64) {
    let (mut event, mut end, mut early, mut time) = (0, 0, 0, 0.0);
    let status = unsafe { fmi3DoStep(c, point, size, 1, &mut event, &mut end, &mut early, &mut time) };
    (status, event != 0, early != 0, time)
}

fn value(c: FmiInstance, plan: &Plan, name: &str) -> f64 {
    let mut value = f64::NAN;
    let reference = plan.table.reference(name).unwrap();
    assert_eq!(unsafe { fmi3GetFloat64(c, &reference, 1, &mut value, 1) }, OK);
    value
}

#[test]
fn closed_form_an_input_that_is_a_cubic_within_the_step() {
    // Rounding over a flight of half a second.
    const ROUNDING: f64 = 1e-14;
    let text = "name = \"Sled\"\n[body.sled]\nmass = 4.0\n[load.push]\non = \"sled\"\ninput = true\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let reference = |name: &str| plan.table.reference(name).unwrap();
    let push = |t: f64| 1.0 + 2.0 * t - 3.0 * t * t + 5.0 * t.powi(3);
    let mut host = Course {
        input: Some(reference("load.push.input")),
        course: Some(push),
        output: reference("sled.v"),
        ..Course::default()
    };
    let c = instance(&plan, "cubic", &mut host, false);
    for k in 0..2 {
        // The value at the step's start is the one set before it.
        let begin = 0.5 * f64::from(k);
        unsafe { assert_eq!(fmi3SetFloat64(c, &reference("load.push.input"), 1, &push(begin), 1), OK) };
        assert_eq!(step(c, begin, 0.5), (OK, false, false, begin + 0.5));
    }
    let (s, v) = (0.5 + 1.0 / 3.0 - 0.25 + 0.25, 1.0 + 1.0 - 1.0 + 1.25);
    assert!((value(c, &plan, "sled.s") - s / 4.0).abs() < ROUNDING, "{}", value(c, &plan, "sled.s"));
    assert!((value(c, &plan, "sled.v") - v / 4.0).abs() < ROUNDING);
    assert_eq!(value(c, &plan, "load.push.input"), push(1.0));
    assert!(host.asked.len() == 6 && host.asked[2] == 0.5 && host.asked[5] == 1.0, "{:?}", host.asked);
    assert_eq!(host.seen.last().unwrap(), &(1.0, value(c, &plan, "sled.v")));
    unsafe { fmi3FreeInstance(c) };
}

#[test]
fn invariant_a_host_sees_both_ends_of_every_flight_and_the_motion_is_the_same() {
    let plan = plan("damper_with_buffer.toml", unchanged);
    let (events, _) = native_events(&plan, 1.0);
    let mut native = native(&plan);
    native.advance_to(1.0).unwrap();
    let mut host = Course { output: plan.table.reference("block.v").unwrap(), ..Course::default() };
    let c = instance(&plan, "looked at", &mut host, false);
    assert_eq!(step(c, 0.0, 1.0), (OK, false, false, 1.0));
    let mut times: Vec<f64> = host.seen.iter().map(|seen| seen.0).collect();
    times.dedup();
    assert_eq!(times.pop(), Some(1.0));
    assert!(times.len() > 20 && times.iter().all(|time| events.contains(time)), "{times:?}");
    assert_eq!(value(c, &plan, "block.v"), native.body(1)[1] + 0.0);
    unsafe { fmi3FreeInstance(c) };
    // If event mode is used, the step ends at the first event.
    let mut host = Course { output: plan.table.reference("block.v").unwrap(), ..Course::default() };
    let c = instance(&plan, "looked at", &mut host, true);
    assert_eq!(step(c, 0.0, 1.0), (OK, true, true, events[0]));
    unsafe { fmi3FreeInstance(c) };
}

#[test]
fn closed_form_a_host_ends_a_step_within_and_goes_on() {
    let plan = plan("bouncing_ball.toml", unchanged);
    let (g, impact) = (9.81_f64, (2.0 / 9.81_f64).sqrt());
    let mut host = Course {
        output: plan.table.reference("ball.v").unwrap(),
        until: Some(impact + 0.1),
        ..Course::default()
    };
    let c = instance(&plan, "ended", &mut host, false);
    // Before the impact the host requests an end slightly later.
    let (status, event, early, time) = step(c, 0.0, 2.0);
    assert_eq!((status, event, early, time), (OK, false, true, impact + 0.1));
    assert!((host.seen[0].0 - impact).abs() < 1e-15 && (host.seen[0].1 - g * impact).abs() < 1e-14);
    let v = -0.9 * g * impact + g * 0.1;
    assert!((value(c, &plan, "ball.v") - v).abs() < 1e-14, "{} {v}", value(c, &plan, "ball.v"));
    host.until = None;
    assert_eq!(step(c, time, 0.05), (OK, false, false, time + 0.05));
    assert!((value(c, &plan, "ball.v") - v - g * 0.05).abs() < 1e-14);
    unsafe { fmi3FreeInstance(c) };
}

#[test]
fn a_step_that_jams_is_taken_back_also_with_a_callback() {
    let text = "name = \"Press\"\n[body.piston]\nmotion = { rate = 1.0 }\n[body.wall]\nmotion = { constant = 0.0 }\n\
                [stop.face]\nbetween = [\"wall\", \"piston\"]\ngap = 0.5\nrestitution = 0.5\n\
                [body.weight]\nmass = 1.0\n[spring.s]\nbetween = [\"ground\", \"weight\"]\nstiffness = 1.0\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let mut host = Course { output: plan.table.reference("piston.s").unwrap(), ..Course::default() };
    let c = instance(&plan, "jammed", &mut host, false);
    let mut state = null_mut();
    unsafe {
        assert_eq!(fmi3GetFMUState(c, &mut state), OK);
        assert!(step(c, 0.0, 1.0).0 > 1);
        assert_eq!(value(c, &plan, "time"), 0.0);
        assert_eq!(fmi3SetFMUState(c, state), OK);
        assert_eq!(step(c, 0.0, 0.25), (OK, false, false, 0.25));
        assert_eq!(fmi3FreeFMUState(c, &mut state), OK);
        fmi3FreeInstance(c);
    }
}
