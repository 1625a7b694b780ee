//! Steps, events, saved states and inputs.

use crate::host::*;
use crate::*;
use fmi_doors::fmi2::abi::FmiComponent;
use std::ffi::CString;
use std::ptr::{null, null_mut};
use vibro_impact::{Parameters, Simulator, State};
use vibro_machine_component::{FILE, Plan};

/// Time at which a ball dropped from 1 m with e = 0.9 at g = 9.81 comes to rest, s: (1 + e)/(1 -
/// e) sqrt(2 h/g).
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
        assert_eq!(ball.whole("floor.impacts") as u64, native.impacts(0).count);
        assert!(ball.get("energy.residual").abs() < 1e-13, "{}", ball.get("energy.residual"));
    }
    assert_eq!([ball.get("ball.s"), ball.get("ball.v")], [1.0, 0.0]);
    assert!((ball.get("floor.f") - 0.02 * 9.81).abs() < 1e-15);
    unsafe { fmi2FreeInstance(c) };
}

#[test]
fn second_method_the_papers_machine_against_the_core() {
    // Rounding of some hundreds of sub-steps, magnified tenfold by impacts.
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
    let (times, told) = native_events(&plan, 1.0);
    let mut native = native(&plan);
    native.advance_to(1.0).unwrap();
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
    assert!(told.len() > 20 && told.iter().all(|time| seen.contains(time)), "{told:?}");
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
    // A state saved before the event continues identically.
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
        // Restored into an instance that was never initialized.
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
    // A single altered bit is detected.
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

/// Whether a saved state with another phase and a valid checksum is accepted.
fn is_taken(machine: &Instance<'_>, phase: u8) -> bool {
    // The mark and the checksum (8 bytes each) and the token are followed by the interface type,
    // two Booleans and the phase.
    const CONTENT: usize = 16;
    const BEFORE_THE_PHASE: usize = 3;
    let (mut state, mut size) = (null_mut(), 0);
    unsafe {
        assert_eq!(fmi3GetFMUState(machine.c, &mut state), OK);
        assert_eq!(fmi3SerializedFMUStateSize(machine.c, state, &mut size), OK);
        let mut bytes = vec![0; size];
        assert_eq!(fmi3SerializeFMUState(machine.c, state, bytes.as_mut_ptr(), size), OK);
        let token = usize::from(bytes[CONTENT]);
        bytes[CONTENT + 1 + token + BEFORE_THE_PHASE] = phase;
        let sum = vibro_numerics::digest::fnv1a(&bytes[CONTENT..]);
        bytes[8..CONTENT].copy_from_slice(&sum.to_le_bytes());
        let status = fmi3DeserializeFMUState(machine.c, bytes.as_ptr(), size, &mut state);
        assert_eq!(fmi3FreeFMUState(machine.c, &mut state), OK);
        let refusal = status == ERROR && machine.messages.last().unwrap().contains("phase");
        assert!(status == OK || refusal, "{phase}: {:?}", machine.messages);
        status == OK
    }
}

/// Damaged bytes may hold any phase; only phases that fit the motion or its absence are accepted.
#[test]
fn saved_states_whose_phase_does_not_go_with_the_motion_are_refused() {
    let plan = plan("damper_with_buffer.toml", unchanged);
    for (begun, possible) in [(false, [0, 1, 6].as_slice()), (true, &[2, 4, 5, 6])] {
        for phase in 0..8 {
            let machine = Instance::of("phases", &plan, false);
            if begun {
                machine.begin();
            }
            assert_eq!(is_taken(&machine, phase), possible.contains(&phase), "{begun} {phase}");
        }
    }
}

#[test]
fn closed_form_inputs_with_their_derivatives() {
    // Rounding over half a second.
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
        // Set values are read back at once, and time is the host's time.
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
        // A value without derivatives is held.
        assert_eq!(fmi2SetReal(c, &input, 1, &-1.0), OK);
        assert_eq!(fmi2DoStep(c, 3.5, 0.5, 1), OK);
        assert!((get(c, "sled.v") - v).abs() < ROUNDING, "{}", get(c, "sled.v") - v);
        assert!(get(c, "energy.residual").abs() < ROUNDING, "{}", get(c, "energy.residual"));
        let order = fmi2SetRealInputDerivatives(c, &input, 1, &4, &1.0);
        assert_eq!(order, ERROR);
        fmi2FreeInstance(c);
    }
}

/// Steps of a machine with formulas have the engine's bits, and continue with a changed parameter
/// of a formula.
#[test]
fn invariant_formulas_in_steps_are_the_engines() {
    let plan = Plan::new(include_str!("../common/formulas.toml").into(), FILE).unwrap();
    let machine = Instance::of("formulas in steps", &plan, false);
    machine.begin();
    let mut own = native(&plan);
    for k in 0..40 {
        machine.step(0.05 * f64::from(k), 0.05);
        own.advance_to(0.05 * f64::from(k) + 0.05).unwrap();
        assert_eq!(machine.get("arm.s").to_bits(), own.body(0)[0].to_bits(), "{k}");
        assert_eq!(machine.get("mass.v").to_bits(), own.body(1)[1].to_bits(), "{k}");
    }
    assert_eq!(machine.set("weight", 0.0), OK, "{:?}", machine.messages);
    let [_, v, _] = own.body(0);
    let s = machine.get("arm.s");
    let turn = 0.02 * v.powi(3) / (1.0 + s * s) + 0.02 * (3.0 * v).atan();
    let a = machine.get("arm.a");
    assert!((a + turn / 0.2).abs() < 1e-14 * a.abs().max(1.0), "{a} {}", -turn / 0.2);
}
