//! Intermediate update: inputs during a step, outputs at its events, early return at a requested
//! time.

use super::host::*;
use std::ffi::{CString, c_void};
use std::ptr::{null, null_mut};
use vibro_impact::{Parameters, Simulator, State};
use vibro_paper_component::component::variables::reference;
use vibro_paper_component::fmi2::abi::*;
use vibro_paper_component::fmi2::description;
use vibro_paper_component::fmi3::abi::*;

/// One call of the callback.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Call {
    time: f64,
    set: bool,
    get: bool,
    finished: bool,
    can_return: bool,
    shown: [f64; 3],
}

/// Data of the callback.
struct Course {
    c: FmiInstance,
    /// The load on the block over time.
    load: fn(f64) -> f64,
    /// Requested time of an early return, if any.
    stop: Option<f64>,
    calls: Vec<Call>,
}

const SHOWN: [&str; 3] = ["time", "stop.v", "impacts.lastTime"];

#[allow(clippy::too_many_arguments)]
unsafe extern "C-unwind" fn update(
    environment: *mut c_void,
    time: f64,
    set: u8,
    get: u8,
    finished: u8,
    can_return: u8,
    early: *mut u8,
    early_time: *mut f64,
) {
    // SAFETY: the environment is the test's; the instance is inside its step.
    unsafe {
        let course = &mut *environment.cast::<Course>();
        assert_eq!(*early, 0, "initialised");
        let mut shown = [f64::NAN; 3];
        if get != 0 {
            let references = SHOWN.map(vr);
            assert_eq!(fmi3GetFloat64(course.c, references.as_ptr(), 3, shown.as_mut_ptr(), 3), OK);
        }
        if set != 0 {
            assert_eq!(fmi3SetFloat64(course.c, &vr("block.f"), 1, &(course.load)(time), 1), OK);
        }
        course.calls.push(Call {
            time,
            set: set != 0,
            get: get != 0,
            finished: finished != 0,
            can_return: can_return != 0,
            shown,
        });
        if let Some(stop) = course.stop
            && can_return != 0
        {
            (*early, *early_time) = (1, stop);
        }
    }
}

/// An initialized instance whose callback sets `block.f`, and the callback's data.
fn with_load(flags: Flags, load: fn(f64) -> f64) -> (Fmu, Box<Course>) {
    let mut course = Box::new(Course { c: null_mut(), load, stop: None, calls: Vec::new() });
    let environment = std::ptr::from_mut(&mut *course).cast();
    let fmu = Fmu::with_callback(flags, &[vr("block.f")], Some(update), environment);
    course.c = fmu.c;
    assert_eq!(fmu.set("block.s", 0.9), OK);
    assert_eq!(fmu.set("block.f", load(0.0)), OK);
    fmu.initialize();
    if flags.event_mode {
        fmu.update();
        fmu.enter_step_mode();
    }
    (fmu, course)
}

fn cubic(t: f64) -> f64 {
    0.02 - 0.01 * t + 0.004 * t * t - 0.0002 * t * t * t
}

/// Value and derivatives 1 to 3 of [`cubic`].
fn cubic_derivatives(t: f64) -> [f64; 4] {
    [cubic(t), -0.01 + 0.008 * t - 0.0006 * t * t, 0.008 - 0.0012 * t, -0.0012]
}

/// Intermediate update compared with FMI 2.0's `SetRealInputDerivatives`, for one cubic load.
#[test]
fn second_method_a_cubic_load_is_that_of_input_derivatives() {
    const SAME: f64 = 1e-13;
    let guid = CString::new(description::guid()).unwrap();
    let (fmu, _course) = with_load(FF, cubic);
    // SAFETY: valid strings, a live component, one of each.
    unsafe {
        let c = fmi2Instantiate(c"two".as_ptr(), 1, guid.as_ptr(), null(), null(), 0, 0);
        assert_eq!(fmi2SetReal(c, &reference("block.s"), 1, &0.9), OK);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
        for i in 0..20 {
            let (time, r) = (f64::from(i) * 0.5, [reference("block.f"); 3]);
            let [value, slopes @ ..] = cubic_derivatives(time);
            assert_eq!(fmi2SetReal(c, r.as_ptr(), 1, &value), OK);
            assert_eq!(
                fmi2SetRealInputDerivatives(c, r.as_ptr(), 3, [1, 2, 3].as_ptr(), slopes.as_ptr()),
                OK
            );
            assert_eq!(fmi2DoStep(c, time, 0.5, 1), OK);
            fmu.step(time, 0.5);
            for name in MOTION {
                let mut two = 0.0;
                assert_eq!(fmi2GetReal(c, &reference(name), 1, &mut two), OK);
                let three = fmu.get(name);
                assert!((two - three).abs() <= SAME * (1.0 + two.abs()), "{name} at {time}: {two} {three}");
            }
            assert!((fmu.get("block.f") - cubic(time + 0.5)).abs() < SAME);
        }
        fmi2FreeInstance(c);
    }
    assert!(fmu.get("impacts.upper") + fmu.get("impacts.lower") > 1.0);
}

fn quintic(t: f64) -> f64 {
    0.05 * (1.3 * t).sin() + 1e-4 * t.powi(5)
}

/// A cubic through four values of a smooth load has an error of h⁴, and so has the motion before
/// its first impact.
#[test]
fn order_of_a_smooth_load_is_four() {
    // Half the step gives a sixteenth of the error, within a margin.
    const ORDER: std::ops::Range<f64> = 3.6..4.6;
    let end = |steps: u32| {
        let (fmu, _course) = with_load(FF, quintic);
        let size = 1.0 / f64::from(steps);
        for i in 0..steps {
            fmu.step(f64::from(i) * size, size);
        }
        assert_eq!(fmu.get("impacts.upper") + fmu.get("impacts.lower"), 0.0);
        fmu.get("block.v")
    };
    let reference = end(64);
    let errors = [2, 4, 8].map(|steps| (end(steps) - reference).abs());
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!(ORDER.contains(&order), "{errors:?}: {order}");
    }
}

/// Three calls for inputs, one before each event, one at the end; none is useless, and finished
/// times do not decrease.
#[test]
fn the_calls_of_a_step() {
    for (flags, can_return) in [(FF, false), (FT, true), (TF, false)] {
        let (fmu, mut course) = with_load(flags, cubic);
        fmu.step(0.0, 1.0);
        if flags.event_mode && fmu.get("time") < 1.0 {
            fmu.handle_event();
        }
        course.calls.clear();
        let begin = fmu.get("time");
        let before = fmu.get("impacts.upper") + fmu.get("impacts.lower");
        let end = fmu.step(begin, 6.0);
        let calls = &course.calls;
        for (i, call) in calls.iter().enumerate() {
            let inputs = i < 3;
            assert_eq!((call.set, call.get, call.finished), (inputs, !inputs, !inputs));
            assert_eq!(call.can_return, can_return && !inputs);
        }
        assert_eq!(
            [calls[0].time, calls[1].time, calls[2].time],
            [begin + 6.0 / 3.0, begin + 6.0 * 2.0 / 3.0, begin + 6.0]
        );
        let finished: Vec<f64> = calls[3..].iter().map(|call| call.time).collect();
        assert!(finished.windows(2).all(|pair| pair[0] <= pair[1]), "{finished:?}");
        assert!(calls[3..].iter().all(|call| call.shown[0] == call.time));
        let events = if flags.early_return { 1 } else { finished.len() - 1 };
        assert!(events > 0);
        // Before the law: the last impact shown is an earlier one.
        assert!(calls[3..3 + events].iter().all(|call| call.shown[2] < call.time && call.shown[1] != 0.0));
        if flags.event_mode {
            assert!(end.event);
            fmu.handle_event();
        }
        let after = fmu.get("impacts.upper") + fmu.get("impacts.lower");
        assert_eq!(after - before, events as f64);
    }
    // Event mode with early return: the step returns at the event instead of calling there.
    let (fmu, course) = with_load(TT, cubic);
    assert!(fmu.step(0.0, 30.0).event);
    assert_eq!(course.calls.len(), 3);
}

/// A host that gives a callback but requires no input is shown only outputs, like the example of
/// the Reference FMUs.
#[test]
fn outputs_alone() {
    let mut course = Box::new(Course { c: null_mut(), load: cubic, stop: None, calls: Vec::new() });
    let environment = std::ptr::from_mut(&mut *course).cast();
    let fmu = Fmu::with_callback(FF, &[], Some(update), environment);
    course.c = fmu.c;
    fmu.initialize();
    fmu.step(0.0, 0.5);
    assert!(course.calls.iter().all(|call| !call.set) && course.calls.len() == 1);
    // Inputs are then held, as without a callback.
    let plain = Fmu::started(FF, &[]);
    plain.step(0.0, 0.5);
    for i in 1..100 {
        for fmu in [&fmu, &plain] {
            assert_eq!(fmu.set("box.f", 0.01 * f64::from(i % 5)), OK);
            fmu.step(f64::from(i) * 0.5, 0.5);
        }
    }
    for (name, (a, b)) in MOTION.iter().zip(fmu.motion().into_iter().zip(plain.motion())) {
        assert!((a - b).abs() < 1e-10, "{name}: {a} {b}"); // pauses before events: round-off
    }
}

/// A requested early return ends exactly at that time, for any events before and after it.
#[test]
fn early_return_at_a_requested_time() {
    // The cubic has other nodes, and the motion other sub-steps.
    const SAME: f64 = 1e-12;
    let (find, _course) = with_load(FT, cubic);
    let impact = find.step(0.0, 40.0).time;
    // FT returns at the event anyway; stopAtImpact = false continues to the requested time.
    for stop in [impact * 0.5, impact, impact + 0.3, f64::NAN, 1e9] {
        let mut course = Box::new(Course { c: null_mut(), load: cubic, stop: Some(stop), calls: Vec::new() });
        let environment = std::ptr::from_mut(&mut *course).cast();
        let fmu = Fmu::with_callback(FT, &[vr("block.f")], Some(update), environment);
        course.c = fmu.c;
        assert_eq!(fmu.set("block.s", 0.9), OK);
        assert_eq!(fmu.set("stopAtImpact", 0.0), OK);
        assert_eq!(fmu.set("block.f", cubic(0.0)), OK);
        fmu.initialize();
        let end = fmu.step(0.0, impact + 1.0);
        let expected = if stop > impact { stop.min(impact + 1.0) } else { impact };
        assert_eq!(end.early, expected < impact + 1.0, "{stop}");
        assert!((end.time - expected).abs() <= SAME, "{stop}: {} {expected}", end.time);
        if stop == impact + 0.3 {
            assert_eq!(end.time, stop, "exactly");
        }
        assert!((fmu.get("block.f") - cubic(end.time)).abs() < 1e-13);
        // The motion equals the motion in steps that end there.
        let after = fmu.get("impacts.upper") + fmu.get("impacts.lower");
        assert!(after >= 1.0);
        course.stop = None;
        fmu.step(end.time, 0.1);
    }
}

/// Inputs that are not set keep their last value; a load held by the callback is a held load.
#[test]
fn held_inputs_are_held() {
    let (fmu, _course) = with_load(FF, |_| 0.05);
    let mut simulator =
        Simulator::new(&Parameters::default(), &State { x: [0.0, 0.9, 0.0], v: [0.0; 3] }, 0.0).unwrap();
    let mut loads = vibro_impact::simulator::Loads::default();
    loads.derivatives[1][0] = 0.05;
    simulator.set_loads(&loads).unwrap();
    for i in 0..40 {
        fmu.step(f64::from(i) * 0.5, 0.5);
    }
    simulator.advance_to(20.0).unwrap();
    let State { x, v } = simulator.state();
    for (name, (a, b)) in
        MOTION.iter().zip(fmu.motion().into_iter().zip([x[0], x[1], x[2], v[0], v[1], v[2]]))
    {
        assert!((a - b).abs() < 1e-10, "{name}: {a} {b}");
    }
}

/// Steps as short as rounding, like the last step of many hosts.
#[test]
fn the_smallest_steps_are_steps() {
    let (fmu, _course) = with_load(FF, cubic);
    fmu.step(0.0, 1.0);
    let before = fmu.motion();
    fmu.step(1.0, 1e-14);
    fmu.step(1.0 + 1e-14, 1e-9);
    for (a, b) in fmu.motion().into_iter().zip(before) {
        assert!((a - b).abs() < 1e-8);
    }
    fmu.step(1.0 + 1e-14 + 1e-9, 1.0);
}
