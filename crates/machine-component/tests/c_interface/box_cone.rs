//! Contacts with two tangents.

use crate::host::*;
use crate::*;
use std::ffi::CString;
use std::ptr::null;
use vibro_machine_component::{FILE, Plan};

/// Number of steps, and their size, s.
const STEPS: (u32, f64) = (150, 0.01);

/// Rounding of a derivative of a force relative to its largest terms.
const ROUNDING: f64 = 1e-12;

/// Values of both versions have the engine's bits. The force along a tangent has the derivative of
/// its spring by the tangent's own stiffness while the slider holds, the normal force by the
/// coefficient of friction while the slider slips, and none by the other tangent's stiffness.
#[test]
fn invariant_values_are_the_engines_and_closed_form_derivatives_of_forces() {
    let plan = Plan::new(include_str!("../common/box.toml").into(), FILE).unwrap();
    let mut own = native(&plan);
    let machine = Instance::of("box cone", &plan, false);
    machine.begin();
    let uri = CString::new(format!("file://{}", resources("box cone", &plan).display())).unwrap();
    let token = CString::new(plan.token()).unwrap();
    let c = unsafe { fmi2Instantiate(c"b".as_ptr(), 1, token.as_ptr(), uri.as_ptr(), null(), 0, 0) };
    unsafe {
        assert_eq!(fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0), OK);
        assert_eq!(fmi2EnterInitializationMode(c), OK);
        assert_eq!(fmi2ExitInitializationMode(c), OK);
    }
    let columns = plan.assembly.description.named_quantities();
    let of = |name: &str| columns.iter().find(|own| own.name == name).unwrap().quantity;
    let derivative = |unknown: &str, known: &str| {
        let (unknown, known, mut along) = (machine.reference(unknown), machine.reference(known), f64::NAN);
        let status = unsafe {
            fmi3GetDirectionalDerivative(machine.c, &unknown, 1, &known, 1, &1.0, 1, &mut along, 1)
        };
        assert_eq!(status, OK, "{:?}", machine.messages);
        along
    };
    let (steps, size) = STEPS;
    let mut met = [[0; 5]; 2];
    for k in 0..steps {
        let point = size * f64::from(k);
        machine.step(point, size);
        unsafe { assert_eq!(fmi2DoStep(c, point, size, 1), OK) };
        own.advance_to(point + size).unwrap();
        for (tangent, met) in met.iter_mut().enumerate() {
            for word in ["et", "ft", "slider"] {
                let name = format!("pad.{word}[{tangent}]");
                let exact = own.value(of(&name)) + 0.0;
                assert_eq!(machine.get(&name), exact, "{name}");
                let mut value = f64::NAN;
                unsafe { assert_eq!(fmi2GetReal(c, &machine.reference(&name), 1, &mut value), OK) };
                assert_eq!(value, exact, "{name}");
            }
            // 1 off, 2 slips upwards, 3 slips downwards, 4 holds.
            let state = machine.state(&format!("pad.slider[{tangent}].state"));
            met[state as usize] += 1;
            let (force, stiffness) = (format!("pad.ft[{tangent}]"), "contact.pad.tangential_stiffness");
            let stretch =
                machine.get(&format!("pad.et[{tangent}]")) - machine.get(&format!("pad.slider[{tangent}]"));
            let slips = [0.0, 0.0, 1.0, -1.0, 0.0][state as usize];
            let held = if state == 4 { stretch } else { 0.0 };
            for (by, exact) in [
                (format!("{stiffness}[{tangent}]"), held),
                (format!("{stiffness}[{}]", 1 - tangent), 0.0),
                ("contact.pad.friction".into(), slips * machine.get("pad.f")),
            ] {
                let found = derivative(&force, &by);
                assert!((found - exact).abs() <= ROUNDING * exact.abs(), "{force} by {by}: {found} {exact}");
            }
        }
    }
    unsafe { fmi2FreeInstance(c) };
    assert!(met.iter().all(|own| own[1..].iter().all(|count| *count > 3)), "{met:?}");
}
