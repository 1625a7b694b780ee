//! Start values, sets, gets, input and output derivatives.

use super::*;
use crate::component::variables::Numbering;

#[test]
fn start_values_come_back_bit_exactly_in_initialization_mode() {
    let mut fmu = instance();
    let value = 0.1 + 0.2;
    set(&mut fmu, "block.s", value).unwrap();
    set(&mut fmu, "secondary.v", -0.0).unwrap();
    fmu.set_experiment(Some(1e-6), 2.5, Some(10.0)).unwrap();
    fmu.enter_initialization();
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
    fmu.set_experiment(None, 0.0, None).unwrap();
    fmu.enter_initialization();
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
    fmu.set_experiment(None, 0.0, None).unwrap();
    fmu.enter_initialization();
    assert_eq!(get(&mut fmu, "block.s"), 1.5);
    let reference = [reference("block.a")];
    assert!(fmu.get(Bases::REAL, &reference, |_, _| panic!("nothing must be written")).is_err());
    let error = fmu.exit_initialization(&mut Messages::default()).unwrap_err();
    assert!(error.to_string().starts_with("block.s - box.s = 1.5 m: expected"), "{error}");
    assert_eq!(fmu.phase(), Phase::Initialization);
    set(&mut fmu, "box.s", 1.0).unwrap();
    fmu.exit_initialization(&mut Messages::default()).unwrap();
}

#[test]
fn refused_sets_change_nothing_and_name_the_variable_and_its_range() {
    let mut fmu = instance();
    let references = [reference("box.k"), reference("stop.restitution")];
    let values = [7.0, 1.5];
    let error = fmu.set(Bases::REAL, &references, |i| values[i]).unwrap_err();
    assert_eq!(error.to_string(), "stop.restitution = 1.5: expected 0 <= stop.restitution <= 1");
    fmu.set_experiment(None, 0.0, None).unwrap();
    fmu.enter_initialization();
    assert_eq!(get(&mut fmu, "box.k"), 1.0);
    for (name, value, text) in [
        ("box.m", 0.0, "box.m = 0: expected a finite number > 0"),
        ("box.m", f64::NAN, "box.m = NaN: expected a finite number > 0"),
        ("box.f", f64::INFINITY, "box.f = inf: expected a finite number"),
        ("mode", 4.0, "mode = 4: expected 1 (EventDriven), 2 (MultipleScales) or 3 (ExactOrbit)"),
        ("stopAtImpact", 2.0, "stopAtImpact = 2: expected 0 (false) or 1 (true)"),
    ] {
        assert_eq!(set(&mut fmu, name, value).unwrap_err().to_string(), text);
    }
    let (integers, strings) = (Bases::new("Integer", &[Base::Integer]), Bases::new("String", &[]));
    for (bases, reference, text) in [
        (
            integers,
            reference("mode"),
            "value reference 14 is not a variable of type Integer: mode is Enumeration",
        ),
        (strings, 0, "value reference 0 is not a variable of type String: time is Real"),
    ] {
        assert_eq!(fmu.set(bases, &[reference], |_| 0.0).unwrap_err().to_string(), text);
        assert_eq!(fmu.get(bases, &[reference], |_, _| ()).unwrap_err().to_string(), text);
    }
    // A description has only its own references.
    let protocol = Protocol { numbering: Numbering::EVERY, ..Protocol::default() };
    let mut fmu = Instance::of_protocol(Interface::CoSimulation, protocol);
    for name in ["der(box.s)", "motion.s"] {
        let beyond = reference(name);
        let start = format!(
            "value reference {beyond} is not a variable of type Real: expected a value reference of the model"
        );
        for error in [
            fmu.set(Bases::REAL, &[beyond], |_| 0.0).unwrap_err(),
            fmu.get(Bases::REAL, &[beyond], |_, _| ()).unwrap_err(),
        ] {
            assert!(error.to_string().starts_with(&start), "{error}");
        }
    }
    for name in ["time", "box.a", "groups.epsilon", "steady.exists"] {
        assert!(
            matches!(
                set(&mut fmu, name, 0.0),
                Err(ComponentProblem::Door(fmi_doors::Problem::NotSettable { .. }))
            ),
            "{name}"
        );
    }
}

#[test]
fn between_steps_only_inputs_and_tunable_parameters_are_set() {
    let mut fmu = initialized();
    for variable in &VARIABLES {
        let may = variable.causality == Causality::Input
            || (variable.causality == Causality::Parameter && variable.variability == Variability::Tunable);
        let start = variable.start().unwrap_or(0.0);
        let outcome = fmu.set(ANY, &[variable.reference], |_| start);
        assert_eq!(outcome.is_ok(), may, "{} {outcome:?}", variable.name);
    }
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
        let before = fmu.save();
        fmu.set_input_derivatives(&[body, reference], &[1, order], &[1.0, value]).unwrap_err();
        assert_eq!(fmu.save(), before);
    }
}

/// One call may set many variables.
#[test]
fn a_refused_order_is_told_with_its_variable() {
    let mut fmu = initialized();
    let inputs = ["box.f", "block.f"].map(reference);
    let input = fmu.set_input_derivatives(&inputs, &[1, 4], &[1.0; 2]).unwrap_err();
    let outputs = ["box.v", "stop.s"].map(reference);
    let output = fmu.output_derivatives(&outputs, &[1, 0], |_, _| panic!()).unwrap_err();
    for (problem, text) in [
        (input, "order of a derivative of block.f = 4: expected 1, 2 or 3"),
        (output, "order of a derivative of stop.s = 0: expected 1, 2 or 3"),
    ] {
        assert_eq!(problem.to_string(), text);
    }
}

#[test]
fn output_derivatives_are_those_of_the_motion() {
    let mut fmu = initialized();
    step(&mut fmu, 0.0, 0.7).unwrap();
    let names = ["box.s", "box.s", "box.v", "stop.s", "coupling.f", "secondary.a"];
    let references = names.map(reference);
    let mut values = [0.0; 6];
    fmu.output_derivatives(&references, &[1, 2, 1, 1, 1, 1], |i, v| values[i] = v).unwrap();
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-14, "{a} {b}");
    near(values[0], get(&mut fmu, "box.v"));
    near(values[1], get(&mut fmu, "box.a"));
    near(values[2], get(&mut fmu, "box.a"));
    near(values[3], get(&mut fmu, "stop.v"));
    near(values[4], 0.006 * (get(&mut fmu, "block.v") - get(&mut fmu, "secondary.v")));
    let h = 1e-4;
    let before = fmu.save();
    step(&mut fmu, 0.7, h).unwrap();
    let after = get(&mut fmu, "secondary.a");
    fmu.restore(&before).unwrap();
    assert!((values[5] - (after - get(&mut fmu, "secondary.a")) / h).abs() < 1e-4);
    for (name, order) in [("impacts.lastTime", 1), ("box.s", 0), ("box.s", 4), ("box.m", 1)] {
        assert!(fmu.output_derivatives(&[reference(name)], &[order], |_, _| panic!()).is_err(), "{name}");
    }
}

#[test]
fn loads_follow_their_derivatives_whichever_is_set_first() {
    let body = reference("block.f");
    let run = |order: [u8; 2]| {
        let mut fmu = initialized();
        for call in order {
            match call {
                0 => set(&mut fmu, "block.f", 0.01).unwrap(),
                _ => fmu.set_input_derivatives(&[body, body], &[1, 3], &[0.02, -0.03]).unwrap(),
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
    fmu.set_input_derivatives(&[body], &[1], &[1.0]).unwrap();
    step(&mut fmu, 0.0, 0.5).unwrap();
    assert!((get(&mut fmu, "box.f") - 0.5).abs() < 1e-15);
    set(&mut fmu, "box.f", 0.25).unwrap();
    step(&mut fmu, 0.5, 0.5).unwrap();
    assert_eq!(get(&mut fmu, "box.f"), 0.25);
}

/// In all engines and at both stops; the sign of zero counts, since hosts print it.
#[test]
fn invariant_the_contact_force_is_plus_zero_in_flight_and_never_negative() {
    let resting = [0.02, -0.02].map(|push| {
        let mut fmu = instance();
        for (name, value) in
            [("stop.restitution", 0.3), ("drive.amplitude", 0.4), ("block.v", 0.3), ("block.f", push)]
        {
            set(&mut fmu, name, value).unwrap();
        }
        initialize(fmu)
    });
    let mut played = instance();
    set(&mut played, "mode", 3.0).unwrap();
    let mut exchange = Instance::new(Interface::ModelExchange);
    set(&mut exchange, "block.v", -0.3).unwrap();
    let mut exchange = initialize(exchange);
    assert_eq!(get(&mut exchange, "stop.force").to_bits(), 0);
    let mut pressed = [0; 2];
    for mut fmu in resting.into_iter().chain([initialize(played)]) {
        for i in 0..600 {
            step(&mut fmu, 0.1 * f64::from(i), 0.1).unwrap();
            let force = get(&mut fmu, "stop.force");
            let state = get(&mut fmu, "stop.state");
            if state == 1.0 {
                assert_eq!(force.to_bits(), 0, "at step {i}");
            } else {
                assert!(force >= 0.0 && force.is_sign_positive(), "at step {i}: {force}");
                pressed[usize::from(state == 3.0)] += usize::from(force > 0.0);
            }
        }
    }
    assert!(pressed.iter().all(|steps| *steps > 10), "{pressed:?}");
}

/// A host that sets the mass of its machine and leaves the rest has half a machine: the parameters
/// of the other machine are reported. A machine that is set completely, and one that keeps its
/// scales, are not reported.
#[test]
fn half_a_machine_is_told_in_the_log() {
    let warnings = |set_by_host: &[(&str, f64)]| {
        let mut fmu = instance();
        for (name, value) in set_by_host {
            set(&mut fmu, name, *value).unwrap();
        }
        fmu.set_experiment(None, 0.0, None).unwrap();
        fmu.enter_initialization();
        let mut messages = Messages::default();
        fmu.exit_initialization(&mut messages).unwrap();
        messages.0
    };
    let told = warnings(&[("box.m", 12.0), ("box.k", 48e3)]);
    let [(Category::Warnings, text)] = &told[..] else { panic!("{told:?}") };
    for part in ["stop.gap = 1 m", "drive.amplitude = 0.15 N", "block.m = 0.1 kg", "coupling.k = 0.006 N/m"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(
        !text.contains("box.m") && !text.contains("restitution") && !text.contains("drive.phase"),
        "{text}"
    );
    let uncoupled = warnings(&[("stop.gap", 0.015), ("coupling.k", 0.0)]);
    assert!(
        uncoupled[0].1.contains("box.m = 1 kg") && !uncoupled[0].1.contains("secondary"),
        "{uncoupled:?}"
    );
    let whole = [
        ("box.m", 12.0),
        ("box.k", 48e3),
        ("box.c", 30.0),
        ("block.m", 1.1),
        ("stop.gap", 1.0), // set, although it equals the start value
        ("coupling.k", 0.0),
        ("drive.amplitude", 75.0),
        ("drive.frequency", 62.8),
    ];
    assert_eq!(warnings(&whole), []);
    // The set parameters are also known after a state is restored.
    let mut saved = instance();
    for (name, value) in whole {
        set(&mut saved, name, value).unwrap();
    }
    let mut restored = instance();
    restored.restore(&saved.save()).unwrap();
    restored.set_experiment(None, 0.0, None).unwrap();
    restored.enter_initialization();
    let mut messages = Messages::default();
    restored.exit_initialization(&mut messages).unwrap();
    assert_eq!(messages.0, []);
    assert_eq!(warnings(&[("drive.amplitude", 0.25), ("stop.restitution", 0.5), ("block.v", 0.3)]), []);
}
