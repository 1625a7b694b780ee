//! What hosts do with an FMU through the C interface: each test is an observed habit of a host
//! (named where known).
#![allow(unsafe_code)] // the C interface

#[path = "common/fmi2.rs"]
mod fmi2;

use fmi2::{ERROR, Fmu2, MOTION, OK, WARNING};
use vibro_impact::{Parameters, Simulator, State};
use vibro_paper_component::component::variables::reference;
use vibro_paper_component::fmi2::abi::*;

/// Largest difference of a motion computed with other steps: the default motion is stable, so
/// rounding is not amplified.
const SAME: f64 = 1e-10;

/// The native library's states at a time, from the default start.
fn native(time: f64) -> [f64; 6] {
    let mut simulator = Simulator::new(&Parameters::default(), &State::default(), 0.0).unwrap();
    simulator.advance_to(time).unwrap();
    let State { x: [x1, x2, x3], v: [v1, v2, v3] } = simulator.state();
    [x1, x2, x3, v1, v2, v3]
}

fn assert_same(a: [f64; 6], b: [f64; 6]) {
    for (name, (a, b)) in MOTION.iter().zip(a.into_iter().zip(b)) {
        assert!((a - b).abs() <= SAME, "{name}: {a} {b}");
    }
}

/// fmpy and others make a last step as small as a rounding error.
#[test]
fn the_last_step_is_2e_14_long() {
    let host = Fmu2::logged().start(&[]);
    host.step(0.0, 100.0);
    let before = host.motion();
    host.step(100.0, 2e-14);
    assert_eq!(host.time(), 100.0 + 2e-14);
    assert_same(host.motion(), before);
    host.step(100.0 + 2e-14, 1.0);
    assert_same(host.motion(), native(101.0));
}

/// Hosts that add up step sizes: the point drifts away from k h, and the end of a step is another
/// sum than the next point.
#[test]
fn the_communication_point_drifts_by_1e_14_a_step() {
    let host = Fmu2::logged().start(&[]);
    let (step, count) = (0.1, 6000);
    let mut point = 0.0;
    for _ in 0..count {
        host.step(point, step);
        point += step + 1e-14;
    }
    assert!((point - 600.0).abs() > 5e-11, "no drift, no test: {point}");
    assert_same(host.motion(), native(host.time()));
    assert!(host.log().iter().all(|(status, ..)| *status == OK), "{:?}", host.log().last());
}

#[test]
fn a_point_that_is_off_by_more_than_1e_9_is_an_error_with_both_times() {
    let host = Fmu2::logged().start(&[]);
    host.step(0.0, 2.5);
    // The accepted mismatch is 1e-9 max(1, |t|), 2.5e-9 here.
    host.step(2.5 + 2e-9, 1e-12);
    let before = host.motion().map(f64::to_bits);
    for point in [2.5 + 6e-9, 2.5 - 1e-8, 0.0] {
        assert_eq!(host.try_step(point, 1e-12), ERROR, "{point}");
        assert_eq!(host.motion().map(f64::to_bits), before);
    }
    let (status, category, message) = host.log().last().unwrap();
    assert_eq!((*status, category.as_str()), (ERROR, "logStatusError"));
    assert!(
        message.contains("currentCommunicationPoint = 0 s") && message.contains("at t = 2.5"),
        "{message}"
    );
}

/// `fmi2Warning` from a step makes OMSimulator fail and PyFMI stop: warnings only go to the log.
#[test]
fn valid_steps_are_ok_and_warnings_go_to_the_log() {
    let host = Fmu2::logged();
    host.set("mode", 2.0);
    // Above the stability limit: simulated, with a warning.
    // SAFETY: one of each.
    assert_eq!(unsafe { fmi2SetReal(host.c, &reference("drive.amplitude"), 1, &0.25) }, OK);
    host.initialize();
    assert!(host.log().iter().any(|(status, ..)| *status == WARNING), "{:?}", host.log());
    for i in 0..100 {
        host.step(f64::from(i) * 0.7, 0.7);
    }
    // Impacts, chatter and rest too.
    let host = Fmu2::logged();
    let names = ["stop.restitution", "drive.amplitude", "block.v", "block.f"].map(reference);
    // SAFETY: four of each.
    assert_eq!(unsafe { fmi2SetReal(host.c, names.as_ptr(), 4, [0.3, 0.4, 0.3, 0.02].as_ptr()) }, OK);
    host.initialize();
    for i in 0..300 {
        host.step(f64::from(i) * 0.7, 0.7);
    }
    for word in ["impact", "rest", "leaves"] {
        let seen = host.log().iter().any(|(status, _, message)| *status == OK && message.contains(word));
        assert!(seen, "no {word} in the log");
    }
}

/// fmusim resumes in this way: no initialization between instantiation and step.
#[test]
fn a_run_is_resumed_from_serialized_bytes_without_initialization() {
    let first = Fmu2::logged().start(&[]);
    first.step(0.0, 77.7);
    let second = Fmu2::logged();
    second.restore(&first.bytes());
    for i in 0..50 {
        let point = 77.7 + 0.5 * f64::from(i);
        first.step(point, 0.5);
        second.step(point, 0.5);
        assert_eq!(first.motion().map(f64::to_bits), second.motion().map(f64::to_bits));
    }
}

#[test]
fn the_logger_and_memory_callbacks_are_null() {
    let host = Fmu2::new(1, None, true);
    assert_eq!(host.try_step(0.0, 1.0), ERROR); // would be logged
    host.initialize();
    host.step(0.0, 50.0); // so would its impacts
}

#[test]
fn neither_stop_time_nor_tolerance_is_defined() {
    // `initialize` passes a tolerance that is not a number and a stop before the start, neither
    // defined.
    let host = Fmu2::logged().start(&[]);
    host.step(0.0, 1e4);
    assert_eq!(host.time(), 1e4);
}

/// Status Discard, for a host that has asked for steps that end at impacts.
const DISCARD: i32 = 2;

fn stopping() -> Fmu2 {
    Fmu2::logged().start(&[("stopAtImpact", 1.0)])
}

fn last(host: &Fmu2) -> &str {
    &host.log().last().unwrap().2
}

#[test]
fn a_step_after_an_impact_names_the_way_back() {
    let host = stopping();
    assert_eq!(host.try_step(0.0, 40.0), DISCARD);
    let (status, category, message) = host.log().last().unwrap();
    assert_eq!((*status, category.as_str()), (DISCARD, "logStatusDiscard"));
    assert!(message.starts_with("fmi2DoStep: the step ended at the impact at t = "), "{message}");
    let time = host.time();
    assert_eq!(host.try_step(40.0, 1.0), ERROR);
    let refusal = format!(
        "currentCommunicationPoint = 40 s, but the last step ended at the impact at t = {time} s: restore the state saved \
         before the impact, or continue from lastSuccessfulTime"
    );
    assert!(last(&host).ends_with(&refusal), "{}", last(&host));
    // SAFETY: a live component.
    assert_eq!(unsafe { fmi2EnterInitializationMode(host.c) }, ERROR);
    let refusal = "StepFailed of Co-Simulation: restore the state saved before the impact, or continue from lastSuccessfulTime";
    assert!(last(&host).ends_with(refusal), "{}", last(&host));
}

/// Like fmusim, with its own load; the motion equals the motion for a host that returns to its
/// saved state.
#[test]
fn a_host_goes_on_from_an_impact_where_the_motion_stands() {
    const END: f64 = 60.0;
    const LOAD: f64 = 0.01;
    let (going_on, going_back) = (stopping(), stopping());
    let (mut time, mut stops) = (0.0, 0);
    loop {
        let load = if stops % 2 == 0 { LOAD } else { -LOAD };
        for host in [&going_on, &going_back] {
            host.set("block.f", load);
        }
        let saved = going_back.bytes();
        let status = going_on.try_step(time, END - time);
        assert_eq!(going_back.try_step(time, END - time), status);
        if status == OK {
            break;
        }
        assert_eq!(status, DISCARD, "{}", last(&going_on));
        let mut reached = 0.0;
        // SAFETY: one value.
        assert_eq!(unsafe { fmi2GetRealStatus(going_on.c, 2, &mut reached) }, OK);
        going_back.restore(&saved);
        going_back.step(time, reached - time);
        (time, stops) = (reached, stops + 1);
    }
    assert!(stops > 5, "{stops}");
    // A step up to the impact and one that stops there differ in the last digit of its time.
    assert_same(going_on.motion(), going_back.motion());
}

/// Many instances in many threads, as in servers that run studies, against a single one and the
/// library.
#[test]
fn a_thousand_instances_in_eight_threads_have_the_same_bits() {
    let alone = Fmu2::logged().start(&[]);
    (0..20).for_each(|i| alone.step(f64::from(i), 1.0));
    assert_same(alone.motion(), native(20.0));
    let expected = alone.motion().map(f64::to_bits);
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                // In each thread all instances exist at once and take turns stepping.
                let hosts: Vec<_> = (0..125).map(|_| Fmu2::logged().start(&[])).collect();
                for i in 0..20 {
                    for host in &hosts {
                        host.step(f64::from(i), 1.0);
                    }
                }
                for host in &hosts {
                    assert_eq!(host.motion().map(f64::to_bits), expected);
                }
            });
        }
    });
}

/// A host that reaches the limit of work in one step: the whole step is refused, and shorter ones
/// are carried out.
#[test]
fn a_step_with_too_much_work_is_refused_and_can_be_taken_in_parts() {
    /// About a second on a busy machine.
    const LONGEST: f64 = 15.0;
    let host = Fmu2::logged();
    let names = ["stop.restitution", "block.s", "box.f", "block.f"].map(reference);
    // SAFETY: four of each.
    assert_eq!(unsafe { fmi2SetReal(host.c, names.as_ptr(), 4, [1.0, 0.99, -100.0, 100.0].as_ptr()) }, OK);
    host.initialize();
    // Logging is off, so that events are not logged one by one.
    // SAFETY: one C string.
    assert_eq!(unsafe { fmi2SetDebugLogging(host.c, 0, 1, &c"logEvents".as_ptr()) }, OK);
    host.step(0.0, 1.0);
    let before = host.motion().map(f64::to_bits);
    let begin = std::time::Instant::now();
    assert_eq!(host.try_step(1.0, 1e5), ERROR);
    assert!(begin.elapsed().as_secs_f64() < LONGEST);
    // Nothing has changed, and the message agrees.
    assert_eq!((host.time(), host.motion().map(f64::to_bits)), (1.0, before));
    let (status, category, message) = host.log().last().unwrap();
    assert_eq!((*status, category.as_str()), (ERROR, "logStatusError"));
    for part in ["fmi2DoStep: ", "stop.restitution = 1 ", "t = 1 s", "smaller steps"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    assert!(!message.contains("advance again"), "{message}");
    for i in 0..20 {
        host.step(1.0 + f64::from(i), 1.0);
    }
    assert_eq!(host.time(), 21.0);
}
