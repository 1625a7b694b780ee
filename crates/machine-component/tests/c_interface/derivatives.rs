//! Derivatives of outputs, compared with differences of the machine's outputs.

use crate::host::*;
use crate::*;
use vibro_machine_component::{FILE, Plan, Role};

/// A body between a spring and a compliant stop, pushed by an input.
fn pushed() -> Plan {
    let text = "name = \"Pushed\"\n[body.b]\nmass = 2.0\nstart = { s = 0.3, v = 1.0 }\n[spring.k]\nbetween = [\"ground\", \"b\"]\n\
                stiffness = 50.0\ndamping = 1.0\n[stop.wall]\nbetween = [\"ground\", \"b\"]\ngap = 0.2\nstiffness = 1e3\n\
                [load.push]\non = \"b\"\ninput = true\nconstant = 3.0\n";
    Plan::new(text.into(), FILE).unwrap()
}

#[test]
fn second_method_time_derivatives_against_differences() {
    // Error of a central difference over 2e-4 s: h²/6 times the third derivative.
    const DIFFERENCE: f64 = 1e-5;
    let plan = pushed();
    let machine = Instance::of("time derivatives", &plan, false);
    machine.begin();
    let (h, names) = (1e-4, ["b.s", "b.v", "b.a", "k.f", "wall.f", "wall.e"]);
    machine.step(0.0, 0.01 - h);
    let before = names.map(|name| machine.get(name));
    machine.step(0.01 - h, h);
    let references = names.map(|name| machine.reference(name));
    let mut first = [f64::NAN; 6];
    unsafe {
        let status = fmi3GetOutputDerivatives(
            machine.c,
            references.as_ptr(),
            6,
            [1; 6].as_ptr(),
            first.as_mut_ptr(),
            6,
        );
        assert_eq!(status, OK, "{:?}", machine.messages);
        let mut second = 0.0;
        assert_eq!(fmi3GetOutputDerivatives(machine.c, &references[0], 1, [2].as_ptr(), &mut second, 1), OK);
        assert_eq!(second, machine.get("b.a"));
        assert_eq!(first[0], machine.get("b.v"));
        let energy = machine.reference("energy.kinetic");
        assert_eq!(fmi3GetOutputDerivatives(machine.c, &energy, 1, [1].as_ptr(), &mut second, 1), ERROR);
        assert!(
            machine.messages.last().unwrap().contains("time derivatives of other variables"),
            "{:?}",
            machine.messages
        );
        let again = Instance::of("time derivatives", &plan, false);
        again.begin();
        again.step(0.0, 0.01 + h);
        let after = names.map(|name| again.get(name));
        for (k, name) in names.iter().enumerate() {
            let difference = (after[k] - before[k]) / (2.0 * h);
            assert!(
                (first[k] - difference).abs() < DIFFERENCE * first[k].abs().max(1.0),
                "{name}: {} {difference}",
                first[k]
            );
        }
    }
}

#[test]
fn closed_form_directional_derivatives_by_an_input() {
    // Rounding of a division by the mass through its Cholesky factor.
    const ROUNDING: f64 = 1e-15;
    let plan = pushed();
    let machine = Instance::of("derivatives", &plan, false);
    machine.begin();
    let input = machine.reference("load.push.input");
    let names = ["b.a", "push.f", "b.s", "wall.f"];
    let references = names.map(|name| machine.reference(name));
    let mut along = [f64::NAN; 4];
    let mut adjoint = f64::NAN;
    unsafe {
        let status = fmi3GetDirectionalDerivative(
            machine.c,
            references.as_ptr(),
            4,
            &input,
            1,
            &6.0,
            1,
            along.as_mut_ptr(),
            4,
        );
        assert_eq!(status, OK, "{:?}", machine.messages);
        let status = fmi3GetAdjointDerivative(
            machine.c,
            references.as_ptr(),
            2,
            &input,
            1,
            [2.0, 1.0].as_ptr(),
            2,
            &mut adjoint,
            1,
        );
        assert_eq!(status, OK, "{:?}", machine.messages);
    }
    // A force of 6 N on 2 kg.
    let near = |a: f64, b: f64| (a - b).abs() <= ROUNDING * b.abs();
    assert!(along.iter().zip([3.0, 6.0, 0.0, 0.0]).all(|(a, b)| near(*a, b)), "{along:?}");
    assert!(near(adjoint, 2.0 * 0.5 + 1.0), "{adjoint}");
}

/// A stop's force never pulls; its derivatives may have either sign.
#[test]
fn closed_form_derivatives_of_a_stops_force_that_falls() {
    // Rounding of a sine and of a weight in a sum.
    const ROUNDING: f64 = 1e-12;
    let text = "name = \"Resting\"\ngravity = 10.0\n[body.b]\nmass = 2.0\ngravity = 1.0\n[stop.floor]\nbetween = [\"ground\", \"b\"]\n\
                gap = 0.0\nrestitution = 0.0\n[load.push]\non = \"b\"\ninput = true\namplitude = 3.0\nfrequency = 0.5\n";
    let plan = Plan::new(text.into(), FILE).unwrap();
    let machine = Instance::of("falling force", &plan, false);
    machine.begin();
    machine.step(0.0, 0.75);
    let (force, input) = (machine.reference("floor.f"), machine.reference("load.push.input"));
    let (mut by_time, mut along, mut adjoint) = (f64::NAN, f64::NAN, f64::NAN);
    unsafe {
        assert_eq!(fmi3GetOutputDerivatives(machine.c, &force, 1, &1, &mut by_time, 1), OK);
        let status = fmi3GetDirectionalDerivative(machine.c, &force, 1, &input, 1, &-1.0, 1, &mut along, 1);
        assert_eq!(status, OK, "{:?}", machine.messages);
        assert_eq!(fmi3GetAdjointDerivative(machine.c, &force, 1, &input, 1, &-1.0, 1, &mut adjoint, 1), OK);
    }
    // Weight and 3 sin(pi t).
    let (pi, t) = (std::f64::consts::PI, 0.75);
    assert!((machine.get("floor.f") - 20.0 - 3.0 * (pi * t).sin()).abs() < ROUNDING);
    assert!((by_time - 3.0 * pi * (pi * t).cos()).abs() < ROUNDING, "{by_time}");
    assert!((along + 1.0).abs() < ROUNDING && (adjoint + 1.0).abs() < ROUNDING, "{along} {adjoint}");
}

/// A body between a rigid and a compliant stop in a sliding frame, pushed by an input: impacts,
/// contact, sticking and slipping.
fn shaken() -> Plan {
    let text = "name = \"Shaken\"\n[body.box]\nmass = 3.0\n[body.block]\nmass = 0.5\nstart = { s = 0.1, v = 1.0 }\n\
                [spring.mount]\nbetween = [\"ground\", \"box\"]\nstiffness = 40.0\ndamping = 0.5\n\
                [stop.upper]\nbetween = [\"box\", \"block\"]\ngap = 0.4\nrestitution = 0.6\n\
                [stop.lower]\nbetween = [\"block\", \"box\"]\ngap = 0.3\nstiffness = 2e3\ndamping = 4.0\n\
                [friction.guide]\nbetween = [\"box\", \"block\"]\nforce = 0.2\n\
                [load.push]\non = \"box\"\ninput = true\namplitude = 9.0\nfrequency = 1.1\n";
    Plan::new(text.into(), FILE).unwrap().with_arrays()
}

const STATES: [&str; 4] = ["box.s", "block.s", "box.v", "block.v"];

fn states(machine: &Instance<'_>) -> [f64; 4] {
    STATES.map(|name| machine.get(name))
}

fn matrix(machine: &Instance<'_>, name: &str) -> [[f64; 4]; 4] {
    let mut all = [f64::NAN; 16];
    let status = unsafe { fmi3GetFloat64(machine.c, &machine.reference(name), 1, all.as_mut_ptr(), 16) };
    assert_eq!(status, OK, "{:?}", machine.messages);
    std::array::from_fn(|i| std::array::from_fn(|j| all[4 * i + j]))
}

fn product(a: &[[f64; 4]; 4], b: &[[f64; 4]; 4]) -> [[f64; 4]; 4] {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..4).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Lengths of steps, s: in flight, over an impact, over all kinds of events.
const SIZES: [f64; 3] = [0.05, 0.7, 2.0];

#[test]
fn second_method_derivatives_over_a_step_against_differences_of_steps() {
    // Step and error of a fourth-order difference, with rounding over its step.
    const STEP: f64 = 1e-5;
    const DIFFERENCE: f64 = 1e-6;
    let plan = shaken();
    let starts = ["body.box.start.s", "body.block.start.s", "body.box.start.v", "body.block.start.v"];
    let run = |size: f64, changed: usize, shift: f64| {
        let machine = Instance::of("step", &plan, false);
        if changed < 4 {
            let value = machine.get(starts[changed]) + shift;
            assert_eq!(machine.set(starts[changed], value), OK);
        }
        machine.begin();
        assert_eq!(machine.set("load.push.input", 0.3 + if changed == 4 { shift } else { 0.0 }), OK);
        machine.step(0.0, size);
        machine
    };
    for (size, impacts) in SIZES.into_iter().zip([0, 1, 2]) {
        let machine = run(size, 0, 0.0);
        assert!(machine.whole("upper.impacts") >= impacts, "{size}");
        let (transition, response) = (matrix(&machine, "step.transition"), matrix(&machine, "step.response"));
        let column =
            |j: usize| [0, 1, 2, 3].map(|i: usize| if j < 4 { transition[i][j] } else { response[i][0] });
        for (changed, column) in (0..5).map(column).enumerate() {
            let at = |places: f64| states(&run(size, changed, places * STEP));
            let [a, b, c, d] = [-2.0, -1.0, 1.0, 2.0].map(at);
            for i in 0..4 {
                let difference = (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * STEP);
                let exact = column[i];
                let error = (exact - difference).abs();
                assert!(
                    error < DIFFERENCE * (1.0 + exact.abs()),
                    "{size} {i} by {changed}: {exact} {difference}"
                );
            }
        }
    }
}

/// Every tunable parameter, changed at a communication point during the motion: the next step uses
/// the changed machine.
#[test]
fn second_method_derivatives_over_a_step_by_parameters_against_differences_of_steps() {
    // Relative step and error of a fourth-order difference, with rounding over its step.
    const STEP: f64 = 1e-5;
    const DIFFERENCE: f64 = 1e-6;
    const BEGIN: f64 = 0.3;
    let plan = shaken();
    let tunable: Vec<&str> =
        plan.table.rows.iter().filter(|row| row.role == Role::Tunable).map(|row| row.name.as_str()).collect();
    let run = |size: f64, changed: &str, shift: f64| {
        let machine = Instance::of("step by parameters", &plan, false);
        machine.begin();
        assert_eq!(machine.set("load.push.input", 0.3), OK);
        machine.step(0.0, BEGIN);
        if shift != 0.0 {
            assert_eq!(machine.set(changed, machine.get(changed) + shift), OK, "{changed}");
        }
        machine.step(BEGIN, size);
        machine
    };
    for size in SIZES {
        let machine = run(size, "", 0.0);
        let mut all = vec![f64::NAN; 4 * tunable.len()];
        let reference = machine.reference("step.parameters");
        let status = unsafe { fmi3GetFloat64(machine.c, &reference, 1, all.as_mut_ptr(), all.len()) };
        assert_eq!(status, OK, "{:?}", machine.messages);
        let mut moved = 0;
        for (k, name) in tunable.iter().enumerate() {
            let step = STEP * machine.get(name).abs().max(0.1);
            // A value that is 0 is varied upwards only, since most values must not be negative.
            let places = if machine.get(name) == 0.0 { [0.0, 1.0, 2.0, 3.0] } else { [-2.0, -1.0, 1.0, 2.0] };
            let [a, b, c, d] = places.map(|place| states(&run(size, name, place * step)));
            for i in 0..4 {
                let difference = match places[0] {
                    0.0 => (-11.0 * a[i] + 18.0 * b[i] - 9.0 * c[i] + 2.0 * d[i]) / (6.0 * step),
                    _ => (8.0 * (c[i] - b[i]) - (d[i] - a[i])) / (12.0 * step),
                };
                let exact = all[i * tunable.len() + k];
                moved += usize::from(exact != 0.0);
                assert!(
                    (exact - difference).abs() < DIFFERENCE * (1.0 + exact.abs()),
                    "{size} {} by {name}: {exact} {difference}",
                    STATES[i]
                );
            }
        }
        assert!(moved > 20, "{moved}");
    }
    // Without a step, parameters have not moved anything.
    let still = Instance::of("step by parameters", &plan, false);
    still.begin();
    let mut all = vec![f64::NAN; 4 * tunable.len()];
    let reference = still.reference("step.parameters");
    assert_eq!(unsafe { fmi3GetFloat64(still.c, &reference, 1, all.as_mut_ptr(), all.len()) }, OK);
    assert!(all.iter().all(|x| *x == 0.0));
}

/// In FMI 2.0 inputs and states are knowns; in FMI 3.0 also tunable parameters and time, once the
/// motion has begun.
#[test]
fn what_is_no_known_is_refused_by_name() {
    let plan = pushed();
    let machine = Instance::of("knowns", &plan, false);
    let (unknown, gap, start) = (
        machine.reference("b.a"),
        machine.reference("spring.k.stiffness"),
        machine.reference("body.b.start.s"),
    );
    let mut along = 7.0;
    let mut ask = |known: &u32| unsafe {
        fmi3GetDirectionalDerivative(machine.c, &unknown, 1, known, 1, &2.0, 1, &mut along, 1)
    };
    machine.begin();
    assert_eq!(ask(&gap), OK);
    assert_eq!(ask(&start), ERROR);
    let last = machine.messages.last().unwrap();
    assert!(last.contains("other variables than inputs, tunable parameters and time"), "{last}");
    // -2 k' s/m with s = 0.3 m and m = 2 kg.
    assert!((along + 0.3).abs() < 1e-15, "{along}");
}

/// Steps that end before each event's law. If matrices are read after the events, their product is
/// the matrix of the whole step; if read before, they lack the jump.
#[test]
fn invariant_products_of_steps_between_events() {
    // Rounding of a product of some twenty matrices.
    const ROUNDING: f64 = 1e-9;
    let plan = shaken();
    let whole = Instance::of("whole", &plan, false);
    whole.begin();
    whole.step(0.0, 3.0);
    let expected = matrix(&whole, "step.transition");
    let parts = Instance::of("whole", &plan, true);
    parts.begin();
    let unit: [[f64; 4]; 4] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    assert_eq!(matrix(&parts, "step.transition"), unit, "no step was made");
    parts.handle();
    let (mut all, mut time, mut jumps) = (unit, 0.0, 0);
    while time < 3.0 {
        let (event, _, reached) = parts.step(time, 3.0 - time);
        let before = matrix(&parts, "step.transition");
        if event {
            assert_eq!(unsafe { fmi3EnterEventMode(parts.c) }, OK);
            parts.handle();
            jumps += usize::from(matrix(&parts, "step.transition") != before);
        }
        all = product(&matrix(&parts, "step.transition"), &all);
        time = reached;
    }
    assert!(jumps > 5, "{jumps}");
    let largest = expected.iter().flatten().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (a, b) in all.iter().flatten().zip(expected.iter().flatten()) {
        assert!((a - b).abs() < ROUNDING * largest, "{a} {b}");
    }
    // A restored instance has not made a step.
    let mut state = std::ptr::null_mut();
    unsafe {
        assert_eq!(fmi3GetFMUState(parts.c, &mut state), OK);
        assert_eq!(fmi3SetFMUState(parts.c, state), OK);
        assert_eq!(fmi3FreeFMUState(parts.c, &mut state), OK);
    }
    assert_eq!(matrix(&parts, "step.transition"), unit);
}

#[test]
fn closed_form_the_response_of_a_sled_to_an_inputs_derivatives() {
    let text = "name = \"Sled\"\n[body.sled]\nmass = 4.0\n[load.push]\non = \"sled\"\ninput = true\n";
    let plan = Plan::new(text.into(), FILE).unwrap().with_arrays();
    let sled = Instance::of("responding", &plan, false);
    sled.begin();
    let t = 0.5_f64;
    sled.step(0.0, t);
    let mut found = [f64::NAN; 8];
    unsafe {
        let status = fmi3GetFloat64(sled.c, &sled.reference("step.response"), 1, found.as_mut_ptr(), 8);
        assert_eq!(status, OK, "{:?}", sled.messages);
        // A wrong number of values.
        assert_eq!(fmi3GetFloat64(sled.c, &sled.reference("step.response"), 1, found.as_mut_ptr(), 7), ERROR);
    }
    let factorial = [1.0, 1.0, 2.0, 6.0, 24.0, 120.0];
    for k in 0..4 {
        let [s, v] = [2, 1].map(|n| t.powi(k as i32 + n) / factorial[k + n as usize] / 4.0);
        assert!((found[k] - s).abs() < 1e-16 && (found[4 + k] - v).abs() < 1e-16, "{k}: {found:?}");
    }
}

#[test]
fn invariant_arrays_are_in_their_own_description_alone() {
    let (usual, arrays) = (pushed(), pushed().with_arrays());
    assert_ne!(usual.token(), arrays.token());
    assert_eq!(usual.table.reference("step.transition"), None);
    let xml = arrays.xml(fmi_doors::Version::Fmi3, None);
    assert!(xml.contains("name=\"step.transition\"") && xml.contains("<Dimension start=\"2\"/>"), "{xml}");
    // FMI 2.0 has no arrays.
    let uri = std::ffi::CString::new(format!("file://{}", resources("arrays", &usual).display())).unwrap();
    let token = std::ffi::CString::new(arrays.token()).unwrap();
    let (none, name) = (std::ptr::null(), c"a".as_ptr());
    assert!(unsafe { fmi2Instantiate(name, 1, token.as_ptr(), uri.as_ptr(), none, 0, 0) }.is_null());
}

/// A seed that is not finite, or gives a derivative that is not finite, is refused by name.
/// Nothing is written, and the motion continues.
#[test]
fn derivatives_that_are_no_finite_numbers_are_refused_by_name() {
    let plan = pushed();
    let machine = Instance::of("not finite", &plan, false);
    machine.begin();
    let (input, unknown) = (machine.reference("load.push.input"), machine.reference("b.a"));
    for (seed, text) in [
        ([f64::NAN, 0.0], "seed of load.push.input = NaN: expected a finite number"),
        ([0.0, f64::INFINITY], "seed of load.push.input = inf: expected a finite number"),
        ([f64::MAX, f64::MAX], "derivative of b.a = inf: expected a finite number"),
    ] {
        let mut along = 7.0;
        let knowns = [input; 2];
        let status = unsafe {
            fmi3GetDirectionalDerivative(
                machine.c,
                &unknown,
                1,
                knowns.as_ptr(),
                2,
                seed.as_ptr(),
                2,
                &mut along,
                1,
            )
        };
        assert_eq!((status, along), (DISCARD, 7.0), "{:?}", machine.messages.last());
        let message = machine.messages.last().unwrap();
        assert!(message.contains(text), "{message}");
    }
    machine.step(0.0, 0.1);
}
