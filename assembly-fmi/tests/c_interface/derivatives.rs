//! Derivatives of outputs, by what differences of the same machine's outputs say.

use crate::host::*;
use crate::*;
use vibro_assembly_fmi::{FILE, Plan};

/// A body between a spring and a compliant stop, which an input pushes.
fn pushed() -> Plan {
    let text = "name = \"Pushed\"\n[body.b]\nmass = 2.0\nstart = { s = 0.3, v = 1.0 }\n[spring.k]\nbetween = [\"ground\", \"b\"]\n\
                stiffness = 50.0\ndamping = 1.0\n[stop.wall]\nbetween = [\"ground\", \"b\"]\ngap = 0.2\nstiffness = 1e3\n\
                [load.push]\non = \"b\"\ninput = true\nconstant = 3.0\n";
    Plan::new(text.into(), FILE).unwrap()
}

#[test]
fn second_method_time_derivatives_against_differences() {
    // Of a central difference over 2e-4 s: the third derivative's part is h²/6 of it.
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
    // Of a division by the mass through its factor.
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
