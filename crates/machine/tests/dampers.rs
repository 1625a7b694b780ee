//! Dampers: dashpots without a spring, on bodies and by arms.

use crate::common::*;
use vibro_machine::file::{no_records, parse};
use vibro_machine::neutral::Neutral;
use vibro_machine::{Assembly, Quantity, What};

/// A hundred roundings of numbers of order one.
const ROUNDING: f64 = 1e-13;

/// A body slowed by a single damper, and a drum damped through a lever of 0.1 m.
const MACHINE: &str = r#"
    name = "Slowed"
    body.sledge = { mass = 2.0, start = { v = 3.0 } }
    body.drum = { inertia = 0.02, start = { v = 5.0 } }
    damper.oil = { between = ["ground", "sledge"], damping = "8 N s/m" }
    damper.rim = { arms = { drum = "100 mm" }, damping = 4.0 }
"#;

/// v = v0 exp(-c t/m), s = (v0 - v) m/c; about an axis with the inertia I and the damping c r².
#[test]
fn closed_form_a_damper_slows_a_body_and_its_account_has_the_energy() {
    let mut m = motion(machine(MACHINE));
    m.advance_to(0.7).unwrap();
    let v = 3.0 * (-8.0 * 0.7 / 2.0f64).exp();
    let spin = 5.0 * (-4.0 * 0.01 * 0.7 / 0.02f64).exp();
    let value = |element, what| m.value(Quantity::of_element(element, what));
    let (e, rate, f) = (value(0, What::E), value(0, What::Rate), value(0, What::F));
    for (found, exact) in [(rate, v), (f, 8.0 * v), (e, (3.0 - v) / 4.0), (m.rate(1), spin)] {
        assert!((found - exact).abs() < ROUNDING * 25.0, "{found} {exact}");
    }
    assert!((value(1, What::F) - 4.0 * 0.1 * spin).abs() < ROUNDING * 25.0);
    let lost: Vec<f64> = m.energy().dashpots.iter().map(|x| x.value()).collect();
    let exact = [9.0 - v * v, 0.01 * (25.0 - spin * spin)];
    assert!(lost.iter().zip(exact).all(|(a, b)| (a - b).abs() < ROUNDING * 100.0), "{lost:?} {exact:?}");
}

#[test]
fn second_method_a_damper_is_a_spring_without_stiffness() {
    let as_spring = MACHINE.replace("damper.", "spring.").replace("damping", "stiffness = 0.0, damping");
    let [mut one, mut other] = [MACHINE, &as_spring].map(|text| motion(machine(text)));
    one.advance_to(0.7).unwrap();
    other.advance_to(0.7).unwrap();
    assert_eq!(one.state(), other.state());
}

/// No force depends on the coordinates; both rates are damped.
#[test]
fn invariant_the_elongation_of_a_damper_need_not_return() {
    let assembly = Assembly::new(machine(MACHINE)).unwrap();
    let neutral = Neutral::of(assembly.system());
    assert_eq!((neutral.places().len(), neutral.rates().len()), (2, 0));
}

#[test]
fn golden_names_columns_and_the_written_file() {
    let machine = machine(MACHINE);
    assert_eq!(machine.get("damper.oil.damping"), Ok(8.0));
    assert_eq!(machine.get("damper.rim.arms.drum"), Ok(0.1));
    let columns = machine.named_quantities();
    let of_rim: Vec<_> =
        columns.iter().filter(|c| c.name.starts_with("rim.")).map(|c| (c.name.as_str(), c.unit)).collect();
    assert_eq!(of_rim, [("rim.e", "m"), ("rim.rate", "m/s"), ("rim.f", "N")]);
    assert_eq!(parse(&machine.to_toml(), "written.toml", &no_records), Ok(machine));
}

#[test]
fn errors_a_damper_damps_and_has_no_other_keys() {
    for (wrong, text) in [
        ("\"8 N s/m\"", "damper.oil.damping = 0.0: must be greater than 0"),
        ("\"8 N s/m\", stiffness", "damper.oil.stiffness"),
    ] {
        let file = MACHINE.replace(
            "\"8 N s/m\"",
            &wrong.replace("\"8 N s/m\"", "0.0").replace("stiffness", "stiffness = 1.0"),
        );
        let refused = parse(&file, "dampers.toml", &no_records).unwrap_err().to_string();
        assert!(refused.contains(text), "{refused}");
    }
    let refused = machine(MACHINE).replace("damper.oil.damping", 0.0).unwrap_err().to_string();
    assert!(refused.starts_with("damper.oil.damping = 0.0: must be"), "{refused}");
}
