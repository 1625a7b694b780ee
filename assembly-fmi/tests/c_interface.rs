//! Described machines through the C interface, as a host would run them: both versions, events, saved states, refusals.
#![allow(unsafe_code)] // the C interface

use fmi_doors::fmi2::abi::FmiComponent;
use fmi_doors::fmi3::abi::FmiInstance;
use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::{Path, PathBuf};
use std::ptr::{null, null_mut};
use vibro_assembly::motion::Event;
use vibro_assembly::{Motion, file};
use vibro_assembly_fmi::{FILE, Machine, Plan};
use vibro_impact::{Parameters, Simulator, State};

fmi_doors::export!(Machine);

const OK: c_int = 0;
const DISCARD: c_int = 2;
const ERROR: c_int = 3;

/// The plan of an example, changed in its text.
fn plan(example: &str, change: impl Fn(String) -> String) -> Plan {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/assembly").join(example);
    let machine = file::read(&path).unwrap();
    Plan::new(change(machine.to_toml()), FILE).unwrap()
}

/// A folder of resources with the machine's file.
fn resources(folder: &str, plan: &Plan) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(folder);
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(FILE), plan.text()).unwrap();
    folder
}

unsafe extern "C-unwind" fn keep(text: *mut c_void, _: c_int, _: *const c_char, message: *const c_char) {
    let message = unsafe { CStr::from_ptr(message) }.to_str().unwrap().to_owned();
    unsafe { (*text.cast::<Vec<String>>()).push(message) };
}

/// An instance of FMI 3.0 with its messages.
struct Instance<'a> {
    c: FmiInstance,
    plan: &'a Plan,
    #[allow(clippy::box_collection)] // the callback has its address
    messages: Box<Vec<String>>,
}

impl Drop for Instance<'_> {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.c) }
    }
}

impl<'a> Instance<'a> {
    fn new(folder: &Path, plan: &'a Plan, token: &str, events: bool) -> Self {
        let mut messages: Box<Vec<String>> = Box::default();
        let token = CString::new(token).unwrap();
        let folder = CString::new(folder.to_str().unwrap()).unwrap();
        let (events, environment) = (u8::from(events), std::ptr::from_mut(&mut *messages).cast());
        let c = unsafe {
            fmi3InstantiateCoSimulation(
                c"a".as_ptr(),
                token.as_ptr(),
                folder.as_ptr(),
                0,
                1,
                events,
                events,
                null(),
                0,
                environment,
                Some(keep),
                None,
            )
        };
        Self { c, plan, messages }
    }

    fn of(name: &str, plan: &'a Plan, events: bool) -> Self {
        let instance = Self::new(&resources(name, plan), plan, plan.token(), events);
        assert!(!instance.c.is_null(), "{:?}", instance.messages);
        instance
    }

    fn begin(&self) {
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(self.c, 0, 0.0, 0.0, 0, 0.0), OK);
            assert_eq!(fmi3ExitInitializationMode(self.c), OK, "{:?}", self.messages);
        }
    }

    fn reference(&self, name: &str) -> u32 {
        self.plan.table.reference(name).unwrap_or_else(|| panic!("no {name}"))
    }

    fn get(&self, name: &str) -> f64 {
        let mut value = f64::NAN;
        let status = unsafe { fmi3GetFloat64(self.c, &self.reference(name), 1, &mut value, 1) };
        assert_eq!(status, OK, "{name}: {:?}", self.messages);
        value
    }

    fn whole(&self, name: &str) -> i32 {
        let mut value = -1;
        assert_eq!(unsafe { fmi3GetInt32(self.c, &self.reference(name), 1, &mut value, 1) }, OK);
        value
    }

    fn state(&self, name: &str) -> i64 {
        let mut value = -1;
        assert_eq!(unsafe { fmi3GetInt64(self.c, &self.reference(name), 1, &mut value, 1) }, OK);
        value
    }

    fn set(&self, name: &str, value: f64) -> c_int {
        unsafe { fmi3SetFloat64(self.c, &self.reference(name), 1, &value, 1) }
    }

    /// A step; whether an event is to be handled, whether it has ended early, and the time reached.
    fn step(&self, point: f64, size: f64) -> (bool, bool, f64) {
        let (mut event, mut end, mut early, mut time) = (0, 0, 0, 0.0);
        let status =
            unsafe { fmi3DoStep(self.c, point, size, 1, &mut event, &mut end, &mut early, &mut time) };
        assert_eq!(status, OK, "{:?}", self.messages);
        (event != 0, early != 0, time)
    }

    /// Handles the events of this instant; whether something has changed, and the time of the next event where it is known.
    fn handle(&self) -> (bool, Option<f64>) {
        let (mut changed, mut defined, mut next) = (0, 0, 0.0);
        unsafe {
            let (mut again, mut end, mut nominals) = (0, 0, 0);
            let (again, end, nominals) = (&mut again, &mut end, &mut nominals);
            let (defined, next) = (&mut defined, &mut next);
            let status = fmi3UpdateDiscreteStates(self.c, again, end, nominals, &mut changed, defined, next);
            assert_eq!(status, OK, "{:?}", self.messages);
            assert_eq!(fmi3EnterStepMode(self.c), OK);
        }
        (changed != 0, (defined != 0).then_some(next))
    }
}

fn unchanged(text: String) -> String {
    text
}

fn native(plan: &Plan) -> Motion {
    Motion::new(plan.assembly.clone()).unwrap()
}

/// Rest of a ball that falls from 1 m with e = 0.9 at g = 9.81: (1 + e)/(1 - e) sqrt(2 h/g).
const REST: f64 = 8.578_949_178_728_89;

#[test]
fn closed_form_ball_by_both_versions_and_the_same_bits_as_the_engine() {
    let plan = plan("bouncing_ball.toml", unchanged);
    let mut native = native(&plan);
    let ball = Instance::of("ball", &plan, false);
    ball.begin();
    let uri = CString::new(format!("file://{}", resources("ball", &plan).display())).unwrap();
    let token = CString::new(plan.token()).unwrap();
    let c: FmiComponent =
        unsafe { fmi2Instantiate(c"b".as_ptr(), 1, token.as_ptr(), uri.as_ptr(), null(), 0, 0) };
    let get = |name: &str| {
        let mut value = f64::NAN;
        unsafe { assert_eq!(fmi2GetReal(c, &ball.reference(name), 1, &mut value), OK) };
        value
    };
    unsafe {
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
    }
    let closed = |time: f64| time > REST;
    for k in 0..90 {
        let (point, size) = (0.1 * f64::from(k), 0.1);
        assert_eq!(ball.step(point, size), (false, false, point + size));
        unsafe { assert_eq!(fmi2DoStep(c, point, size, 1), OK) };
        native.advance_to(point + size).unwrap();
        let [s, v, a] = native.body(0).map(|x| x + 0.0);
        assert_eq!([ball.get("ball.s"), ball.get("ball.v"), ball.get("ball.a")], [s, v, a], "{k}");
        assert_eq!([get("ball.s"), get("ball.v"), get("ball.a")], [s, v, a], "{k}");
        // Open is 1, closed 2.
        assert_eq!(ball.state("floor.state"), 1 + i64::from(closed(point + size)), "{k}");
        assert_eq!(ball.whole("floor.impacts") as u64, native.impacts(0).0);
        assert!(ball.get("energy.residual").abs() < 1e-13, "{}", ball.get("energy.residual"));
    }
    assert_eq!([ball.get("ball.s"), ball.get("ball.v")], [1.0, 0.0]);
    assert!((ball.get("floor.f") - 0.02 * 9.81).abs() < 1e-15);
    unsafe { fmi2FreeInstance(c) };
}

#[test]
fn second_method_the_papers_machine_against_the_core() {
    // Roundings of some hundreds of sub-steps, which impacts magnify tenfold.
    const AGREEMENT: f64 = 1e-12;
    let plan = plan("paper_machine.toml", unchanged);
    let machine = Instance::of("paper", &plan, false);
    machine.begin();
    let (parameters, start) = (Parameters::default(), State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] });
    let mut core = Simulator::new(&parameters, &start, 0.0).unwrap();
    let size = parameters.period() / 4.0;
    let mut time = 0.0;
    for _ in 0..80 {
        machine.step(time, size);
        time += size;
        core.advance_to(time).unwrap();
        for (name, (s, v)) in
            ["box", "block", "secondary"].iter().zip(core.state().x.iter().zip(core.state().v))
        {
            assert!((machine.get(&format!("{name}.s")) - s).abs() < AGREEMENT, "{name} at {time}");
            assert!((machine.get(&format!("{name}.v")) - v).abs() < AGREEMENT, "{name} at {time}");
        }
    }
    let impacts = machine.whole("upper.impacts") + machine.whole("lower.impacts");
    assert_eq!(impacts as u64, core.impacts().upper + core.impacts().lower);
}

#[test]
fn invariant_event_mode_sees_every_event_of_the_native_run() {
    let plan = plan("damper_with_buffer.toml", unchanged);
    let mut events: Vec<Event> = Vec::new();
    let mut native = native(&plan);
    native.advance_observed(1.0, &mut |event| events.push(event.clone())).unwrap();
    let mut times: Vec<f64> = events.iter().map(|event| event.time).collect();
    times.dedup();
    let machine = Instance::of("damper", &plan, true);
    machine.begin();
    machine.handle();
    let (mut time, mut seen) = (0.0, Vec::new());
    while time < 1.0 {
        let (event, early, reached) = machine.step(time, 1.0 - time);
        assert_eq!(early, reached < 1.0);
        time = reached;
        if event {
            assert_eq!(unsafe { fmi3EnterEventMode(machine.c) }, OK);
            assert!(machine.handle().0);
            seen.push(time);
        }
    }
    seen.dedup();
    assert!(times.len() > 20, "{}", times.len());
    assert_eq!(seen, times);
    assert_eq!(
        [machine.get("block.s"), machine.get("block.v")],
        [native.body(1)[0] + 0.0, native.body(1)[1] + 0.0]
    );
}

#[test]
fn closed_form_both_sides_of_a_load_that_jumps_at_a_time_that_is_told() {
    let text =
        "name = \"Sled\"\n[body.sled]\nmass = 4.0\n[load.push]\non = \"sled\"\nsteps = [[0.25, 8.0]]\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let sled = Instance::of("pushed", &plan, true);
    sled.begin();
    assert_eq!(sled.handle(), (false, Some(0.25)));
    assert_eq!(sled.step(0.0, 1.0), (true, true, 0.25));
    unsafe { assert_eq!(fmi3EnterEventMode(sled.c), OK) };
    assert_eq!([sled.get("push.f"), sled.get("sled.a")], [0.0, 0.0]);
    // What is saved before the event goes on as if it had not been left.
    let mut state = null_mut();
    unsafe { assert_eq!(fmi3GetFMUState(sled.c, &mut state), OK) };
    for _ in 0..2 {
        assert_eq!(sled.handle(), (true, None));
        assert_eq!([sled.get("push.f"), sled.get("sled.a")], [8.0, 2.0]);
        assert_eq!(sled.step(0.25, 0.5), (false, false, 0.75));
        // Rounding of a flight of half a second.
        assert!((sled.get("sled.v") - 1.0).abs() < 1e-15 && (sled.get("sled.s") - 0.25).abs() < 1e-15);
        unsafe { assert_eq!(fmi3SetFMUState(sled.c, state), OK) };
    }
    unsafe { assert_eq!(fmi3FreeFMUState(sled.c, &mut state), OK) };
}

#[test]
fn invariant_saved_states_go_through_bytes_and_reset_begins_anew() {
    let plan = plan("damper_with_buffer.toml", unchanged);
    let (one, two) = (Instance::of("saved", &plan, false), Instance::of("saved", &plan, false));
    one.begin();
    one.step(0.0, 0.3);
    let (mut state, mut size) = (null_mut(), 0);
    let mut bytes;
    unsafe {
        assert_eq!(fmi3GetFMUState(one.c, &mut state), OK);
        assert_eq!(fmi3SerializedFMUStateSize(one.c, state, &mut size), OK);
        bytes = vec![0; size];
        assert_eq!(fmi3SerializeFMUState(one.c, state, bytes.as_mut_ptr(), size), OK);
        assert_eq!(fmi3FreeFMUState(one.c, &mut state), OK);
        // Into an instance that was never initialized.
        let mut read = null_mut();
        assert_eq!(fmi3DeserializeFMUState(two.c, bytes.as_ptr(), size, &mut read), OK, "{:?}", two.messages);
        assert_eq!(fmi3SetFMUState(two.c, read), OK, "{:?}", two.messages);
        assert_eq!(fmi3FreeFMUState(two.c, &mut read), OK);
    }
    one.step(0.3, 0.5);
    two.step(0.3, 0.5);
    for row in plan.table.rows.iter().filter(|row| row.base == fmi_doors::Base::Real) {
        assert_eq!(one.get(&row.name).to_bits(), two.get(&row.name).to_bits(), "{}", row.name);
    }
    // One bit off is noticed.
    bytes[size / 2] ^= 1;
    unsafe { assert_eq!(fmi3DeserializeFMUState(two.c, bytes.as_ptr(), size, &mut null_mut()), ERROR) };
    assert!(two.messages.last().unwrap().contains("checksum"), "{:?}", two.messages);
    let first = one.get("block.s");
    unsafe { assert_eq!(fmi3Reset(one.c), OK) };
    one.begin();
    one.step(0.0, 0.3);
    one.step(0.3, 0.5);
    assert_eq!(one.get("block.s"), first);
}

#[test]
fn parameters_that_are_no_machine_are_refused_by_name_and_nothing_is_lost() {
    let plan = plan("bouncing_ball.toml", unchanged);
    let ball = Instance::of("refused", &plan, false);
    assert_eq!(ball.set("stop.floor.restitution", 1.5), DISCARD);
    let last = || ball.messages.last().unwrap().clone();
    assert!(last().ends_with("stop.floor.restitution = 1.5: allowed is a number from 0 to 1"), "{}", last());
    // A start beyond the stop is found when initialization ends, since both may be set one after the other.
    assert_eq!(ball.set("body.ball.start.s", 2.0), OK);
    unsafe {
        assert_eq!(fmi3EnterInitializationMode(ball.c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi3ExitInitializationMode(ball.c), DISCARD);
        assert!(last().contains("floor"), "{}", last());
        assert_eq!(ball.set("stop.floor.gap", 3.0), OK);
        assert_eq!(ball.get("ball.s"), 2.0);
        assert_eq!(fmi3ExitInitializationMode(ball.c), OK, "{}", last());
    }
    // Falling for 0.4 s is not yet a metre.
    ball.step(0.0, 0.4);
    assert!((ball.get("ball.s") - (2.0 + 0.5 * 9.81 * 0.16)).abs() < 1e-14);
    assert_eq!(ball.set("stop.floor.gap", 4.0), ERROR);
    assert!(last().contains("stop.floor.gap cannot be set at a communication point"), "{}", last());
}

#[test]
fn another_machines_file_or_description_is_refused_at_instantiation() {
    let (ball, paper) = (plan("bouncing_ball.toml", unchanged), plan("paper_machine.toml", unchanged));
    let heavier = plan("bouncing_ball.toml", |text| text.replace("0.02", "0.03"));
    let folder = resources("swapped", &ball);
    for other in [&paper, &heavier] {
        let refused = Instance::new(&folder, &ball, other.token(), false);
        assert!(refused.c.is_null());
        assert!(refused.messages[0].contains("instantiationToken"), "{:?}", refused.messages);
        assert!(refused.messages[0].contains(ball.token()), "{:?}", refused.messages);
    }
    let nowhere = Instance::new(Path::new("/nowhere"), &ball, ball.token(), false);
    assert!(nowhere.c.is_null());
    assert!(nowhere.messages[0].contains("machine.toml: "), "{:?}", nowhere.messages);
    // No Model Exchange, by name.
    let token = CString::new(ball.token()).unwrap();
    let path = CString::new(folder.to_str().unwrap()).unwrap();
    let mut messages: Box<Vec<String>> = Box::default();
    let environment = std::ptr::from_mut(&mut *messages).cast();
    let (name, log) = (c"a".as_ptr(), Some(keep as _));
    let none =
        unsafe { fmi3InstantiateModelExchange(name, token.as_ptr(), path.as_ptr(), 0, 1, environment, log) };
    assert!(none.is_null());
    assert!(messages[0].contains("does not offer Model Exchange"), "{messages:?}");
}

#[test]
fn closed_form_inputs_with_their_derivatives() {
    // Of half a second.
    const ROUNDING: f64 = 1e-15;
    let text = "name = \"Sled\"\n[body.sled]\nmass = 4.0\n[load.push]\non = \"sled\"\ninput = true\nconstant = 1.0\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let uri = CString::new(format!("file://{}/", resources("sled", &plan).display())).unwrap();
    let token = CString::new(plan.token()).unwrap();
    let reference = |name: &str| plan.table.reference(name).unwrap();
    let get = |c, name: &str| {
        let mut value = f64::NAN;
        unsafe { assert_eq!(fmi2GetReal(c, &reference(name), 1, &mut value), OK) };
        value
    };
    unsafe {
        let c = fmi2Instantiate(c"a".as_ptr(), 1, token.as_ptr(), uri.as_ptr(), null(), 0, 0);
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 3.0, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        let input = reference("load.push.input");
        assert_eq!(fmi2SetReal(c, &input, 1, &3.0), OK);
        // What was set shows at once, and time is that of the host.
        assert_eq!([get(c, "sled.a"), get(c, "push.f"), get(c, "time")], [1.0, 4.0, 3.0]);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
        assert_eq!(fmi2SetReal(c, &input, 1, &1.0), OK);
        assert_eq!(
            fmi2SetRealInputDerivatives(c, [input; 2].as_ptr(), 2, [1, 2].as_ptr(), [6.0, 4.0].as_ptr()),
            OK
        );
        assert_eq!(fmi2DoStep(c, 3.0, 0.5, 1), OK);
        let t = 0.5_f64;
        // The sum of 1 and 1 + 6 t + 4 t²/2 over 4 kg, once and twice integrated.
        let v = (2.0 * t + 3.0 * t.powi(2) + 2.0 / 3.0 * t.powi(3)) / 4.0;
        let s = (t.powi(2) + t.powi(3) + t.powi(4) / 6.0) / 4.0;
        assert!((get(c, "sled.v") - v).abs() < ROUNDING && (get(c, "sled.s") - s).abs() < ROUNDING);
        assert_eq!(get(c, "load.push.input"), 1.0 + 6.0 * t + 2.0 * t * t);
        // A value alone holds.
        assert_eq!(fmi2SetReal(c, &input, 1, &-1.0), OK);
        assert_eq!(fmi2DoStep(c, 3.5, 0.5, 1), OK);
        assert!((get(c, "sled.v") - v).abs() < ROUNDING, "{}", get(c, "sled.v") - v);
        assert!(get(c, "energy.residual").abs() < ROUNDING, "{}", get(c, "energy.residual"));
        let order = fmi2SetRealInputDerivatives(c, &input, 1, &4, &1.0);
        assert_eq!(order, ERROR);
        fmi2FreeInstance(c);
    }
}
