use super::*;
use crate::fmi2::logging::{Category, Status};
use crate::fmi2::variables::{Base, Causality, VARIABLES, Variability, find, reference};

/// Keeps what is logged.
#[derive(Default)]
struct Messages(Vec<(Status, Category, String)>);

impl Log for Messages {
    fn log(&mut self, status: Status, category: Category, message: &str) {
        self.0.push((status, category, message.to_owned()));
    }
}

fn instance() -> Instance {
    Instance::new("test", Interface::CoSimulation, &description::guid(), true).unwrap()
}

fn initialized() -> Instance {
    initialize(instance())
}

fn initialize(mut instance: Instance) -> Instance {
    instance.setup_experiment(None, 0.0, None).unwrap();
    instance.enter_initialization_mode().unwrap();
    instance.exit_initialization_mode(&mut Messages::default()).unwrap();
    instance
}

fn get(instance: &mut Instance, name: &str) -> f64 {
    let reference = [find(name).unwrap().0];
    let mut value = f64::NAN;
    instance.get(VARIABLES[reference[0] as usize].base(), &reference, |_, v| value = v).unwrap();
    value
}

fn set(instance: &mut Instance, name: &str, value: f64) -> Outcome {
    let reference = [find(name).unwrap().0];
    instance.set(VARIABLES[reference[0] as usize].base(), &reference, |_| value)
}

fn step(instance: &mut Instance, point: f64, size: f64) -> Outcome {
    instance.do_step(point, size, &mut Messages::default())
}

const MOTION: [&str; 12] = [
    "time",
    "box.s",
    "box.v",
    "box.a",
    "block.s",
    "block.v",
    "secondary.s",
    "stop.s",
    "impacts.upper",
    "impacts.lower",
    "energy.input",
    "energy.impact",
];

fn motion(instance: &mut Instance) -> Vec<u64> {
    MOTION.map(|name| get(instance, name).to_bits()).to_vec()
}

#[test]
fn wrong_guid_and_blank_name_are_refused() {
    let guid = description::guid();
    let error = Instance::new("a", Interface::CoSimulation, "{x}", false).unwrap_err();
    assert_eq!(error.to_string(), format!("fmuGUID = \"{{x}}\": allowed is {guid}"));
    assert!(Instance::new(" \t", Interface::CoSimulation, &guid, false).is_err());
}

#[test]
fn start_values_come_back_bit_exactly_in_initialization_mode() {
    let mut fmu = instance();
    let value = 0.1 + 0.2;
    set(&mut fmu, "block.s", value).unwrap();
    set(&mut fmu, "secondary.v", -0.0).unwrap();
    fmu.setup_experiment(Some(1e-6), 2.5, Some(10.0)).unwrap();
    fmu.enter_initialization_mode().unwrap();
    set(&mut fmu, "box.s", 1e-17).unwrap();
    assert_eq!(get(&mut fmu, "block.s").to_bits(), value.to_bits());
    assert_eq!(get(&mut fmu, "secondary.v").to_bits(), (-0.0_f64).to_bits());
    assert_eq!(get(&mut fmu, "box.s"), 1e-17);
    assert_eq!(get(&mut fmu, "time"), 2.5);
    assert_eq!(get(&mut fmu, "stop.s"), value);
}

#[test]
fn outputs_in_initialization_mode_follow_what_is_set() {
    let mut fmu = instance();
    fmu.setup_experiment(None, 0.0, None).unwrap();
    fmu.enter_initialization_mode().unwrap();
    assert_eq!(get(&mut fmu, "box.a"), 0.0);
    set(&mut fmu, "box.f", 2.0).unwrap();
    assert_eq!(get(&mut fmu, "box.a"), 2.0);
    set(&mut fmu, "box.m", 4.0).unwrap();
    assert_eq!(get(&mut fmu, "box.a"), 0.5);
    assert!((get(&mut fmu, "groups.epsilon") - 0.025).abs() < 1e-16);
}

#[test]
fn a_block_outside_the_box_is_refused_on_leaving_initialization_and_can_be_put_right() {
    let mut fmu = instance();
    set(&mut fmu, "block.s", 1.5).unwrap();
    fmu.setup_experiment(None, 0.0, None).unwrap();
    fmu.enter_initialization_mode().unwrap();
    assert_eq!(get(&mut fmu, "block.s"), 1.5);
    let reference = [reference("block.a")];
    assert!(fmu.get(Base::Real, &reference, |_, _| panic!("nothing must be written")).is_err());
    let error = fmu.exit_initialization_mode(&mut Messages::default()).unwrap_err();
    assert!(error.to_string().starts_with("block.s - box.s = 1.5 m: allowed is"), "{error}");
    assert_eq!(fmu.state(), State::InitializationMode);
    set(&mut fmu, "box.s", 1.0).unwrap();
    fmu.exit_initialization_mode(&mut Messages::default()).unwrap();
}

#[test]
fn refused_sets_change_nothing_and_name_the_variable_and_its_range() {
    let mut fmu = instance();
    let references = [reference("box.k"), reference("stop.restitution")];
    let values = [7.0, 1.5];
    let error = fmu.set(Base::Real, &references, |i| values[i]).unwrap_err();
    assert_eq!(error.to_string(), "stop.restitution = 1.5: allowed is 0 <= stop.restitution <= 1");
    fmu.setup_experiment(None, 0.0, None).unwrap();
    fmu.enter_initialization_mode().unwrap();
    assert_eq!(get(&mut fmu, "box.k"), 1.0);
    for (name, value, text) in [
        ("box.m", 0.0, "box.m = 0: allowed is a finite number > 0"),
        ("box.m", f64::NAN, "box.m = NaN: allowed is a finite number > 0"),
        ("box.f", f64::INFINITY, "box.f = inf: allowed is a finite number"),
        ("mode", 4.0, "mode = 4: allowed is 1 (EventDriven), 2 (MultipleScales) or 3 (ExactOrbit)"),
        ("stopAtImpact", 2.0, "stopAtImpact = 2: allowed is 0 (false) or 1 (true)"),
    ] {
        assert_eq!(set(&mut fmu, name, value).unwrap_err().to_string(), text);
    }
    for (base, reference, text) in [
        (Base::Real, 72, "value reference 72 is not a Real variable: allowed is 0 to 71"),
        (Base::Real, reference("mode"), "value reference 14 is not a Real variable: mode is Integer"),
        (Base::String, 0, "value reference 0 is not a String variable: time is Real"),
    ] {
        assert_eq!(fmu.set(base, &[reference], |_| 0.0).unwrap_err().to_string(), text);
        assert_eq!(fmu.get(base, &[reference], |_, _| ()).unwrap_err().to_string(), text);
    }
    for name in ["time", "box.a", "groups.kappa", "steady.exists"] {
        assert!(matches!(set(&mut fmu, name, 0.0), Err(Problem::NotSettable { .. })), "{name}");
    }
}

#[test]
fn between_steps_only_inputs_and_tunable_parameters_are_set() {
    let mut fmu = initialized();
    for (i, variable) in VARIABLES.iter().enumerate() {
        let may = variable.causality == Causality::Input
            || (variable.causality == Causality::Parameter && variable.variability == Variability::Tunable);
        let start = variable.start().unwrap_or(0.0);
        let outcome = fmu.set(variable.base(), &[i as u32], |_| start);
        assert_eq!(outcome.is_ok(), may, "{} {outcome:?}", variable.name);
    }
}

#[test]
fn ten_steps_and_one_agree_and_land_on_their_end() {
    let (mut ten, mut one) = (initialized(), initialized());
    for i in 0..10 {
        step(&mut ten, f64::from(i) * 3.0, 3.0).unwrap();
    }
    step(&mut one, 0.0, 30.0).unwrap();
    assert_eq!(get(&mut ten, "time"), 30.0);
    assert!(get(&mut one, "impacts.upper") > 0.0);
    for name in MOTION {
        let (a, b) = (get(&mut ten, name), get(&mut one, name));
        assert!((a - b).abs() < 1e-11, "{name}: {a} {b}");
    }
}

#[test]
fn time_may_be_off_by_rounding_but_not_by_more() {
    let mut fmu = initialized();
    step(&mut fmu, 0.0, 100.0).unwrap();
    step(&mut fmu, 100.0 + 5e-8, 1.0).unwrap();
    assert_eq!(get(&mut fmu, "time"), 100.0 + 5e-8 + 1.0);
    let before = motion(&mut fmu);
    let error = step(&mut fmu, 101.1, 1.0).unwrap_err().to_string();
    assert!(error.contains("101.1 s") && error.contains("t = 101.00000005 s"), "{error}");
    // A step that ends before own time, by less than the allowed mismatch, is a valid one and does nothing.
    step(&mut fmu, 101.0, 1e-9).unwrap();
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(step(&mut fmu, 101.0, size).is_err(), "{size}");
    }
    assert!(step(&mut fmu, f64::NAN, 1.0).is_err());
    assert_eq!(motion(&mut fmu), before);
    step(&mut fmu, 101.0, 1e-14).unwrap();
    step(&mut fmu, 101.0, 1.0).unwrap();
    assert_eq!(get(&mut fmu, "time"), 102.0);
}

#[test]
fn the_smallest_steps_are_steps() {
    let mut fmu = initialized();
    for _ in 0..10 {
        step(&mut fmu, 0.0, 1e-14).unwrap();
    }
    step(&mut fmu, 0.0, 1.0).unwrap();
    for _ in 0..10 {
        step(&mut fmu, 1.0, 1e-14).unwrap();
    }
    assert!((get(&mut fmu, "time") - 1.0).abs() < 1e-12);
}

#[test]
fn the_stop_time_is_not_passed() {
    let mut fmu = instance();
    fmu.setup_experiment(None, 0.0, Some(1.0)).unwrap();
    fmu.enter_initialization_mode().unwrap();
    fmu.exit_initialization_mode(&mut Messages::default()).unwrap();
    let error = step(&mut fmu, 0.0, 1.5).unwrap_err().to_string();
    assert_eq!(error, "step to t = 1.5 s: allowed is up to the stop time 1 s of fmi2SetupExperiment");
    step(&mut fmu, 0.0, 1.0 + 1e-12).unwrap();
}

#[test]
fn tunable_parameters_act_from_the_next_step_on() {
    let (mut fmu, mut other) = (initialized(), initialized());
    step(&mut fmu, 0.0, 5.0).unwrap();
    step(&mut other, 0.0, 5.0).unwrap();
    set(&mut fmu, "drive.amplitude", 0.3).unwrap();
    assert_eq!(get(&mut fmu, "drive.amplitude"), 0.3);
    assert!((get(&mut fmu, "groups.f10") - 3.0).abs() < 1e-12);
    assert_eq!(get(&mut fmu, "box.s"), get(&mut other, "box.s"));
    step(&mut fmu, 5.0, 1.0).unwrap();
    step(&mut other, 5.0, 1.0).unwrap();
    assert!((get(&mut fmu, "box.s") - get(&mut other, "box.s")).abs() > 1e-3);
}

#[test]
fn events_are_logged_when_asked_for() {
    let mut fmu = initialized();
    let mut messages = Messages::default();
    fmu.do_step(0.0, 40.0, &mut messages).unwrap();
    let impacts = get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower");
    assert!(impacts > 0.0);
    assert_eq!(messages.0.len() as f64, impacts);
    assert!(messages.0.iter().all(|(s, c, _)| (*s, *c) == (Status::Ok, Category::Events)));
    assert!(messages.0[0].2.starts_with("impact on the"), "{}", messages.0[0].2);
    fmu.set_debug_logging(false, [Ok("logEvents")]).unwrap();
    let mut messages = Messages::default();
    fmu.do_step(40.0, 40.0, &mut messages).unwrap();
    assert!(messages.0.is_empty());
}

#[test]
fn stop_at_impact_ends_the_step_there_and_can_be_redone() {
    let mut fmu = instance();
    set(&mut fmu, "stopAtImpact", 1.0).unwrap();
    let mut fmu = initialize(fmu);
    let before = fmu.fmu_state().unwrap();
    let problem = step(&mut fmu, 0.0, 40.0).unwrap_err();
    assert_eq!(problem.status(), Status::Discard);
    assert_eq!(fmu.state(), State::StepFailed);
    let time = fmu.real_status(StatusKind::LastSuccessfulTime).unwrap();
    assert!(time > 0.0 && time < 40.0);
    assert_eq!(get(&mut fmu, "impacts.lastTime"), time);
    assert!(!fmu.boolean_status(StatusKind::Terminated).unwrap());
    // As the standard has it: back to the step's start, then a step that ends at the impact.
    fmu.set_fmu_state(&before).unwrap();
    step(&mut fmu, 0.0, time).unwrap();
    assert_eq!(get(&mut fmu, "time"), time);
}

#[test]
fn loads_follow_their_derivatives_whichever_is_set_first() {
    let body = reference("block.f");
    let run = |order: [u8; 2]| {
        let mut fmu = initialized();
        for call in order {
            match call {
                0 => set(&mut fmu, "block.f", 0.01).unwrap(),
                _ => fmu.set_real_input_derivatives(&[body, body], &[1, 3], &[0.02, -0.03]).unwrap(),
            }
        }
        step(&mut fmu, 0.0, 1.5).unwrap();
        (get(&mut fmu, "block.f"), motion(&mut fmu))
    };
    let (load, moved) = run([0, 1]);
    assert!((load - (0.01 + 0.02 * 1.5 - 0.03 * 1.5_f64.powi(3) / 6.0)).abs() < 1e-15);
    assert_eq!(run([1, 0]), (load, moved.clone()));
    let (held, otherwise) = run([0, 0]);
    assert_eq!(held, 0.01);
    assert_ne!(otherwise, moved);
}

#[test]
fn a_value_without_derivatives_is_held() {
    let mut fmu = initialized();
    let body = reference("box.f");
    fmu.set_real_input_derivatives(&[body], &[1], &[1.0]).unwrap();
    step(&mut fmu, 0.0, 0.5).unwrap();
    assert!((get(&mut fmu, "box.f") - 0.5).abs() < 1e-15);
    set(&mut fmu, "box.f", 0.25).unwrap();
    step(&mut fmu, 0.5, 0.5).unwrap();
    assert_eq!(get(&mut fmu, "box.f"), 0.25);
}

#[test]
fn input_derivatives_are_checked() {
    let mut fmu = initialized();
    let body = reference("box.f");
    for (reference, order, value) in [
        (body, 0, 1.0),
        (body, 4, 1.0),
        (body, -1, 1.0),
        (body, 1, f64::NAN),
        (reference("box.s"), 1, 1.0),
        (999, 1, 1.0),
    ] {
        let before = fmu.fmu_state().unwrap();
        fmu.set_real_input_derivatives(&[body, reference], &[1, order], &[1.0, value]).unwrap_err();
        assert_eq!(fmu.fmu_state().unwrap(), before);
    }
}

#[test]
fn output_derivatives_are_those_of_the_motion() {
    let mut fmu = initialized();
    step(&mut fmu, 0.0, 0.7).unwrap();
    let names = ["box.s", "box.s", "box.v", "stop.s", "coupling.f", "secondary.a"];
    let references = names.map(|name| find(name).unwrap().0);
    let mut values = [0.0; 6];
    fmu.get_real_output_derivatives(&references, &[1, 2, 1, 1, 1, 1], |i, v| values[i] = v).unwrap();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} {b}");
    near(values[0], get(&mut fmu, "box.v"));
    near(values[1], get(&mut fmu, "box.a"));
    near(values[2], get(&mut fmu, "box.a"));
    near(values[3], get(&mut fmu, "stop.v"));
    near(values[4], 0.006 * (get(&mut fmu, "block.v") - get(&mut fmu, "secondary.v")));
    let h = 1e-4;
    let before = fmu.fmu_state().unwrap();
    step(&mut fmu, 0.7, h).unwrap();
    let after = get(&mut fmu, "secondary.a");
    fmu.set_fmu_state(&before).unwrap();
    assert!((values[5] - (after - get(&mut fmu, "secondary.a")) / h).abs() < 1e-4);
    for (name, order) in [("energy.input", 1), ("box.s", 0), ("box.s", 4), ("box.m", 1)] {
        let reference = [find(name).unwrap().0];
        assert!(fmu.get_real_output_derivatives(&reference, &[order], |_, _| panic!()).is_err(), "{name}");
    }
}

#[test]
fn restore_then_continue_is_bit_identical() {
    let mut fmu = initialized();
    set(&mut fmu, "box.f", 0.01).unwrap();
    step(&mut fmu, 0.0, 13.7).unwrap();
    set(&mut fmu, "box.c", 0.09).unwrap(); // pending
    set(&mut fmu, "block.f", 0.003).unwrap();
    fmu.set_real_input_derivatives(&[reference("secondary.f")], &[2], &[1e-4]).unwrap();
    let saved = fmu.fmu_state().unwrap();
    let bytes = saved.serialize().unwrap();
    step(&mut fmu, 13.7, 20.0).unwrap();
    let straight = motion(&mut fmu);

    fmu.set_fmu_state(&saved).unwrap();
    step(&mut fmu, 13.7, 20.0).unwrap();
    assert_eq!(motion(&mut fmu), straight);

    let mut fresh = instance();
    fresh.set_fmu_state(&FmuState::deserialize(&bytes).unwrap()).unwrap();
    assert_eq!(fresh.state(), State::StepComplete);
    assert_eq!(get(&mut fresh, "box.c"), 0.09);
    assert!((get(&mut fresh, "groups.gamma1") - 0.9).abs() < 1e-12);
    step(&mut fresh, 13.7, 20.0).unwrap();
    assert_eq!(motion(&mut fresh), straight);
}

#[test]
fn a_state_of_before_initialization_comes_back_too() {
    let mut fmu = instance();
    set(&mut fmu, "box.s", 0.5).unwrap();
    let saved = fmu.fmu_state().unwrap();
    let bytes = saved.serialize().unwrap();
    let mut fmu = initialize(fmu);
    step(&mut fmu, 0.0, 1.0).unwrap();
    fmu.set_fmu_state(&FmuState::deserialize(&bytes).unwrap()).unwrap();
    assert_eq!(fmu.state(), State::Instantiated);
    let mut fmu = initialize(fmu);
    assert_eq!((get(&mut fmu, "box.s"), get(&mut fmu, "time")), (0.5, 0.0));
}

#[test]
fn damaged_and_foreign_bytes_are_refused() {
    let mut fmu = initialized();
    step(&mut fmu, 0.0, 13.7).unwrap();
    let bytes = fmu.fmu_state().unwrap().serialize().unwrap();
    for length in 0..bytes.len() {
        assert!(matches!(FmuState::deserialize(&bytes[..length]), Err(Problem::Memory { .. })), "{length}");
    }
    for place in 0..bytes.len() {
        let mut altered = bytes.clone();
        altered[place] ^= 0x10;
        assert!(FmuState::deserialize(&altered).is_err(), "{place}");
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(FmuState::deserialize(&longer).is_err());
    // Of another build, with a right checksum.
    let mut foreign = bytes[..bytes.len() - 8].to_vec();
    foreign[12] ^= 1;
    let checksum = crate::fmi2::bytes::checksum(&foreign);
    foreign.extend_from_slice(&checksum.to_le_bytes());
    assert!(FmuState::deserialize(&foreign).unwrap_err().to_string().contains("another build"));
    // Of the other interface type.
    let mut exchange = Instance::new("test", Interface::ModelExchange, &description::guid(), true).unwrap();
    assert!(exchange.set_fmu_state(&FmuState::deserialize(&bytes).unwrap()).is_err());
    assert_eq!(exchange.state(), State::Instantiated);
}

#[test]
fn handles_are_looked_up_and_never_followed() {
    let mut fmu = initialized();
    let first = fmu.keep(fmu.fmu_state().unwrap(), 0).unwrap();
    step(&mut fmu, 0.0, 1.0).unwrap();
    let second = fmu.keep(fmu.fmu_state().unwrap(), 0).unwrap();
    assert_ne!(first, second);
    assert_eq!(fmu.keep(fmu.fmu_state().unwrap(), second).unwrap(), second);
    fmu.restore_kept(first).unwrap();
    assert_eq!(get(&mut fmu, "time"), 0.0);
    fmu.restore_kept(second).unwrap();
    assert_eq!(get(&mut fmu, "time"), 1.0);
    fmu.free_kept(first).unwrap();
    assert!(fmu.free_kept(first).is_err());
    assert!(fmu.restore_kept(first).is_err());
    assert!(fmu.restore_kept(12345).is_err());
    assert!(initialized().restore_kept(second).is_err());
    fmu.restore_kept(second).unwrap();
}

#[test]
fn reset_is_as_new() {
    let mut fmu = instance();
    set(&mut fmu, "box.k", 3.0).unwrap();
    let mut fmu = initialize(fmu);
    step(&mut fmu, 0.0, 20.0).unwrap();
    fmu.reset().unwrap();
    let mut fmu = initialize(fmu);
    step(&mut fmu, 0.0, 20.0).unwrap();
    let mut fresh = initialized();
    step(&mut fresh, 0.0, 20.0).unwrap();
    assert_eq!(motion(&mut fmu), motion(&mut fresh));
}

#[test]
fn experiments_are_checked_and_needed() {
    let mut fmu = instance();
    assert!(matches!(fmu.enter_initialization_mode(), Err(Problem::Sequence { .. })));
    for (tolerance, start, stop) in [
        (Some(-1.0), 0.0, None),
        (Some(f64::NAN), 0.0, None),
        (None, f64::INFINITY, None),
        (None, 1.0, Some(0.5)),
        (None, 0.0, Some(f64::NAN)),
    ] {
        assert!(fmu.setup_experiment(tolerance, start, stop).is_err());
    }
    assert!(fmu.enter_initialization_mode().is_err());
    fmu.setup_experiment(None, 0.0, None).unwrap();
    fmu.setup_experiment(None, 7.0, Some(7.0)).unwrap();
    fmu.enter_initialization_mode().unwrap();
    assert_eq!(get(&mut fmu, "time"), 7.0);
}
