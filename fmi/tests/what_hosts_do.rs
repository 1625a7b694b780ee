//! What hosts do to an FMU, through the C interface: each test is a habit of a host that was seen (named where known).
#![allow(unsafe_code)] // the C interface

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::ptr::{null, null_mut};
use vibro_fmi::component::variables::reference;
use vibro_fmi::fmi2::abi::*;
use vibro_fmi::fmi2::description;
use vibro_impact::{Parameters, Simulator, State};

const OK: c_int = 0;
const WARNING: c_int = 1;
const ERROR: c_int = 3;

const MOTION: [&str; 6] = ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v"];

/// The same motion cut into other steps; the default motion is stable, so rounding is not amplified.
const SAME: f64 = 1e-10;

type Record = (c_int, String, String);

unsafe extern "C" fn keep(
    environment: *mut c_void,
    _: *const c_char,
    status: c_int,
    category: *const c_char,
    message: *const c_char,
) {
    // SAFETY: the environment is the host's list; the FMU hands over C strings.
    unsafe {
        let text = |p| CStr::from_ptr(p).to_str().unwrap().to_owned();
        (*environment.cast::<Vec<Record>>()).push((status, text(category), text(message)));
    }
}

type Plain = unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char);

struct Host {
    c: FmiComponent,
    log: *mut Vec<Record>,
}

impl Host {
    fn new() -> Self {
        let log = Box::into_raw(Box::new(Vec::<Record>::new()));
        // SAFETY: on the platforms of the tests a variadic call without variadic arguments is an ordinary one.
        let logger = unsafe { std::mem::transmute::<Plain, FmiLogger>(keep) };
        Self { c: instantiate(Some(logger), log.cast()), log }
    }

    fn log(&self) -> &[Record] {
        // SAFETY: freed with the host; the logger does not run now.
        unsafe { &*self.log }
    }

    fn initialized() -> Self {
        let host = Self::new();
        host.initialize();
        host
    }

    fn initialize(&self) {
        // SAFETY: a live component. What is not defined is not read.
        unsafe {
            assert_eq!(fmi2SetupExperiment(self.c, 0, f64::NAN, 0.0, 0, -1.0), OK);
            assert_eq!(fmi2EnterInitializationMode(self.c), OK);
            assert_eq!(fmi2ExitInitializationMode(self.c), OK);
        }
    }

    fn step(&self, point: f64, size: f64) -> c_int {
        // SAFETY: a live component.
        unsafe { fmi2DoStep(self.c, point, size, 1) }
    }

    fn motion(&self) -> [f64; 6] {
        let (references, mut values) = (MOTION.map(reference), [f64::NAN; 6]);
        // SAFETY: six of each.
        assert_eq!(unsafe { fmi2GetReal(self.c, references.as_ptr(), 6, values.as_mut_ptr()) }, OK);
        values
    }

    fn time(&self) -> f64 {
        let mut time = f64::NAN;
        // SAFETY: one of each.
        assert_eq!(unsafe { fmi2GetReal(self.c, &reference("time"), 1, &mut time) }, OK);
        time
    }

    fn set_integer(&self, name: &str, value: c_int) {
        // SAFETY: one of each.
        assert_eq!(unsafe { fmi2SetInteger(self.c, &reference(name), 1, &value) }, OK);
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        // SAFETY: the component is not used again, and then nor is its log.
        unsafe {
            fmi2FreeInstance(self.c);
            drop(Box::from_raw(self.log));
        }
    }
}

fn instantiate(logger: Option<FmiLogger>, environment: *mut c_void) -> FmiComponent {
    let guid = CString::new(description::guid()).unwrap();
    let functions = FmiCallbackFunctions {
        logger,
        allocate_memory: None,
        free_memory: None,
        step_finished: None,
        component_environment: environment,
    };
    // SAFETY: valid strings; the callbacks may go after the call, the logger and its environment stay.
    let c = unsafe { fmi2Instantiate(c"box".as_ptr(), 1, guid.as_ptr(), null(), &functions, 0, 1) };
    assert!(!c.is_null());
    c
}

/// The native library's states at that time, from the default start.
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

/// fmpy and others leave a last step of the size of a rounding error.
#[test]
fn the_last_step_is_2e_14_long() {
    let host = Host::initialized();
    assert_eq!(host.step(0.0, 100.0), OK);
    let before = host.motion();
    assert_eq!(host.step(100.0, 2e-14), OK);
    assert_eq!(host.time(), 100.0 + 2e-14);
    assert_same(host.motion(), before);
    assert_eq!(host.step(100.0 + 2e-14, 1.0), OK);
    assert_same(host.motion(), native(101.0));
}

/// Hosts that add step sizes up: the point drifts away from k h, and each end is another sum than the next point.
#[test]
fn the_communication_point_drifts_by_1e_14_a_step() {
    let host = Host::initialized();
    let (step, count) = (0.1, 6000);
    let mut point = 0.0;
    for _ in 0..count {
        assert_eq!(host.step(point, step), OK);
        point += step + 1e-14;
    }
    assert!((point - 600.0).abs() > 5e-11, "no drift, no test: {point}");
    assert_same(host.motion(), native(host.time()));
    assert!(host.log().iter().all(|(status, ..)| *status == OK), "{:?}", host.log().last());
}

#[test]
fn a_point_that_is_off_by_more_than_1e_9_is_an_error_with_both_times() {
    let host = Host::initialized();
    assert_eq!(host.step(0.0, 2.5), OK);
    // The allowed mismatch is 1e-9 max(1, |t|), 2.5e-9 here.
    assert_eq!(host.step(2.5 + 2e-9, 1e-12), OK);
    let before = host.motion().map(f64::to_bits);
    for point in [2.5 + 6e-9, 2.5 - 1e-8, 0.0] {
        assert_eq!(host.step(point, 1e-12), ERROR, "{point}");
        assert_eq!(host.motion().map(f64::to_bits), before);
    }
    let (status, category, message) = host.log().last().unwrap();
    assert_eq!((*status, category.as_str()), (ERROR, "logStatusError"));
    assert!(
        message.contains("currentCommunicationPoint = 0 s") && message.contains("at t = 2.5"),
        "{message}"
    );
}

/// `fmi2Warning` from a step makes OMSimulator fail and PyFMI stop: warnings go to the log alone.
#[test]
fn valid_steps_are_ok_and_warnings_go_to_the_log() {
    let host = Host::new();
    host.set_integer("mode", 2);
    // Above the stability limit: played, with a warning.
    // SAFETY: one of each.
    assert_eq!(unsafe { fmi2SetReal(host.c, &reference("drive.amplitude"), 1, &0.25) }, OK);
    host.initialize();
    assert!(host.log().iter().any(|(status, ..)| *status == WARNING), "{:?}", host.log());
    for i in 0..100 {
        assert_eq!(host.step(f64::from(i) * 0.7, 0.7), OK);
    }
    // Impacts, chatter and rest too.
    let host = Host::new();
    let names = ["stop.restitution", "drive.amplitude", "block.v", "block.f"].map(reference);
    // SAFETY: four of each.
    assert_eq!(unsafe { fmi2SetReal(host.c, names.as_ptr(), 4, [0.3, 0.4, 0.3, 0.02].as_ptr()) }, OK);
    host.initialize();
    for i in 0..300 {
        assert_eq!(host.step(f64::from(i) * 0.7, 0.7), OK);
    }
    for word in ["impact", "rest", "leaves"] {
        let seen = host.log().iter().any(|(status, _, message)| *status == OK && message.contains(word));
        assert!(seen, "no {word} in the log");
    }
}

/// fmusim resumes like this: no initialization between instantiation and step.
#[test]
fn a_run_is_resumed_from_serialized_bytes_without_initialization() {
    let first = Host::initialized();
    assert_eq!(first.step(0.0, 77.7), OK);
    // SAFETY: live components, states of theirs, a buffer of that size.
    unsafe {
        let (mut state, mut size) = (null_mut(), 0);
        assert_eq!(fmi2GetFMUstate(first.c, &mut state), OK);
        assert_eq!(fmi2SerializedFMUstateSize(first.c, state, &mut size), OK);
        let mut bytes = vec![0_u8; size];
        assert_eq!(fmi2SerializeFMUstate(first.c, state, bytes.as_mut_ptr(), size), OK);
        assert_eq!(fmi2FreeFMUstate(first.c, &mut state), OK);

        let second = Host::new();
        // What is in the variable that is written to may be anything.
        let mut state = std::ptr::without_provenance_mut(0xdead_beef);
        assert_eq!(fmi2DeSerializeFMUstate(second.c, bytes.as_ptr(), size, &mut state), OK);
        assert_eq!(fmi2SetFMUstate(second.c, state), OK);
        assert_eq!(fmi2FreeFMUstate(second.c, &mut state), OK);
        for i in 0..50 {
            let point = 77.7 + 0.5 * f64::from(i);
            assert_eq!((first.step(point, 0.5), second.step(point, 0.5)), (OK, OK));
            assert_eq!(first.motion().map(f64::to_bits), second.motion().map(f64::to_bits));
        }
    }
}

#[test]
fn the_logger_and_memory_callbacks_are_null() {
    let c = instantiate(None, null_mut());
    // SAFETY: a live component, freed last.
    unsafe {
        assert_eq!(fmi2DoStep(c, 0.0, 1.0, 1), ERROR); // would be logged
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
        assert_eq!(fmi2DoStep(c, 0.0, 50.0, 1), OK); // so would its impacts
        fmi2FreeInstance(c);
    }
}

#[test]
fn neither_stop_time_nor_tolerance_is_defined() {
    // `initialize` gives a tolerance that is no number and a stop before the start, neither defined.
    let host = Host::initialized();
    assert_eq!(host.step(0.0, 1e4), OK);
    assert_eq!(host.time(), 1e4);
}

/// Hosts that print messages without expanding arguments show them as they are; those that expand them need %%.
#[test]
fn messages_are_finished_text_with_percent_signs_doubled() {
    let host = Host::initialized();
    let category = c"50 % of %s %n".as_ptr();
    // SAFETY: one C string.
    assert_eq!(unsafe { fmi2SetDebugLogging(host.c, 1, 1, &category) }, ERROR);
    let message = &host.log().last().unwrap().2;
    assert!(message.contains("50 %% of %%s %%n"), "{message}");
    assert!(!message.replace("%%", "").contains('%'), "{message}");
}

/// Many instances in many threads, as servers that run studies have them.
#[test]
fn a_thousand_instances_in_eight_threads() {
    let expected = native(20.0);
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                // All alive at once in each thread, stepped in turn.
                let hosts: Vec<_> = (0..125).map(|_| Host::initialized()).collect();
                for i in 0..20 {
                    for host in &hosts {
                        assert_eq!(host.step(f64::from(i), 1.0), OK);
                    }
                }
                for host in &hosts {
                    assert_same(host.motion(), expected);
                }
            });
        }
    });
}

/// A host that meets the limit of work in one step: the step is refused as a whole, and shorter ones get on.
#[test]
fn a_step_with_too_much_work_is_refused_and_can_be_taken_in_parts() {
    /// About a second, on a machine with other work to do.
    const LONGEST: f64 = 15.0;
    let host = Host::new();
    let names = ["stop.restitution", "block.s", "box.f", "block.f"].map(reference);
    // SAFETY: four of each.
    assert_eq!(unsafe { fmi2SetReal(host.c, names.as_ptr(), 4, [1.0, 0.99, -100.0, 100.0].as_ptr()) }, OK);
    host.initialize();
    // Quiet, so that events are not logged one by one.
    // SAFETY: one C string.
    assert_eq!(unsafe { fmi2SetDebugLogging(host.c, 0, 1, &c"logEvents".as_ptr()) }, OK);
    assert_eq!(host.step(0.0, 1.0), OK);
    let before = host.motion().map(f64::to_bits);
    let begin = std::time::Instant::now();
    assert_eq!(host.step(1.0, 1e5), ERROR);
    assert!(begin.elapsed().as_secs_f64() < LONGEST);
    // Nothing has changed, and the text does not say otherwise.
    assert_eq!((host.time(), host.motion().map(f64::to_bits)), (1.0, before));
    let (status, category, message) = host.log().last().unwrap();
    assert_eq!((*status, category.as_str()), (ERROR, "logStatusError"));
    for part in ["fmi2DoStep: ", "stop.restitution = 1 ", "t = 1 s", "smaller steps"] {
        assert!(message.contains(part), "{part}: {message}");
    }
    assert!(!message.contains("advance again"), "{message}");
    for i in 0..20 {
        assert_eq!(host.step(1.0 + f64::from(i), 1.0), OK);
    }
    assert_eq!(host.time(), 21.0);
}
