//! Friction whose force depends on its rate: Stribeck's curve with the exponent 1, and a viscous part.

use crate::common::assembled;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Differentiated, Motion, Quantity, What};

/// Rounding of times and states of order 1 over some slips.
const ROUNDING: f64 = 2e-13;
/// Difference of the energy from its accounts, J, of order 0.1 J.
const BALANCE: f64 = 1e-13;
/// Shift of a number for central differences, and their relative tolerance: truncation, and
/// rounding divided by the shift.
const DIFFERENCE: f64 = 1e-6;
const OF_DIFFERENCE: f64 = 1e-6;

/// A body on a belt with a spring. Its friction falls with exp(-|e'|/v) and has a viscous part.
fn belt([force, largest, speed, viscous]: [f64; 4]) -> String {
    format!(
        "name = \"Belt\"\nbody.belt = {{ dimension = \"translation\", motion = {{ rate = 0.1 }} }}\n\
         body.m = {{ mass = 1.0, start.v = 0.1 }}\n\
         spring.k = {{ between = [\"ground\", \"m\"], stiffness = 50.0, damping = 0.1 }}\n\
         friction.f = {{ between = [\"belt\", \"m\"], force = {force:?}, static = {largest:?}, \
         stribeck = {speed:?}, stribeck_exponent = 1, viscous = {viscous:?} }}\n"
    )
}

/// Slips and sticks until 4 s and the state then, by Taylor series in 50 digits, without and with a
/// viscous part; and the mirrored motion, with the belt the other way.
#[test]
fn second_method_stribeck_with_the_exponent_1_in_50_digits() {
    let cases = [
        (
            0.0,
            [0.798, 1.3835054955592332, 2.2294402180592856, 2.8149457136185188, 3.6608804361185716],
            [0.03840616507211837, -0.3315461149133859],
        ),
        (
            0.3,
            [0.798, 1.3862212642294842, 2.1897994684506714, 2.778020732680156, 3.5815989369013432],
            [0.016888936580959496, -0.258159792246985],
        ),
    ];
    for (viscous, times, [s, v]) in cases {
        for sign in [1.0, -1.0] {
            let text = belt([2.0, 4.0, 0.05, viscous]);
            let text = if sign > 0.0 { text } else { text.replace("rate = 0.1", "rate = -0.1") };
            let text = if sign > 0.0 { text } else { text.replace("start.v = 0.1", "start.v = -0.1") };
            let mut motion = Motion::new(assembled(&text)).expect("a motion");
            let (first, mut found) = (motion.kinetic_and_stored(), Vec::new());
            let mut note = |event: &Event| {
                if matches!(event.kind, EventKind::Stick { .. } | EventKind::Slip { .. }) {
                    found.push(event.time);
                }
            };
            motion.advance_observed(4.0, &mut note).expect("an end");
            assert_eq!(found.len(), times.len(), "{found:?}");
            for (own, exact) in found.iter().zip(times) {
                assert!((own - exact).abs() < ROUNDING, "{own} {exact}");
            }
            let [own, rate, _] = motion.body(1);
            let off = (sign * own - s).abs().max((sign * rate - v).abs());
            assert!(off < ROUNDING, "{off:e}");
            let now = motion.kinetic_and_stored();
            let off = now.0 + now.1 - first.0 - first.1 - motion.energy().balance();
            assert!(off.abs() < BALANCE, "{off:e}");
        }
    }
}

/// Derivatives by all numbers of the friction against central differences.
#[test]
fn second_method_derivatives_by_the_numbers_of_a_friction() {
    let values = [2.0, 4.0, 0.05, 0.3];
    let names = ["friction.f.force", "friction.f.static", "friction.f.stribeck", "friction.f.viscous"];
    let mut motion = Differentiated::new(assembled(&belt(values)), &names).expect("a motion");
    motion.advance_to(4.0).expect("an end");
    let end = |i: usize, by: f64| {
        let mut values = values;
        values[i] += by;
        let mut motion = Motion::new(assembled(&belt(values))).expect("a motion");
        motion.advance_to(4.0).expect("an end");
        motion.states()
    };
    for i in 0..values.len() {
        let shift = DIFFERENCE * values[i];
        let own = motion.state_derivative(i).expect("a derivative");
        for ((a, b), own) in end(i, shift).iter().zip(end(i, -shift)).zip(own.iter()) {
            let difference = (a - b) / (2.0 * shift);
            let off = (difference - own).abs();
            assert!(off < OF_DIFFERENCE * own.abs().max(10.0), "{}: {difference} {own}", names[i]);
        }
    }
    let description = parse(&belt(values), "m.toml", &no_records).expect("a machine");
    assert_eq!(description, parse(&description.to_toml(), "m.toml", &no_records).expect("the same machine"));
}

/// A viscous part is a damper between the same ends, and its loss is part of the friction's.
#[test]
fn invariant_a_viscous_part_is_a_damper_beside() {
    let text = |friction: &str, further: &str| {
        format!(
            "name = \"V\"\nbody.m = {{ mass = 2.0, start = {{ s = 0.4, v = 1.0 }} }}\n\
             spring.k = {{ between = [\"ground\", \"m\"], stiffness = 80.0 }}\n\
             friction.f = {{ between = [\"ground\", \"m\"], force = 1.5{friction} }}\n{further}"
        )
    };
    let damper = "damper.c = { between = [\"ground\", \"m\"], damping = 0.7 }\n";
    let mut own = Motion::new(assembled(&text(", viscous = 0.7", ""))).expect("a motion");
    let mut other = Motion::new(assembled(&text("", damper))).expect("a motion");
    // The elements are listed by kind: spring, damper, friction.
    let force = |motion: &Motion, index: usize| motion.value(Quantity::of_element(index, What::F));
    for k in 1..=40 {
        let time = 0.05 * f64::from(k);
        own.advance_to(time).expect("a motion");
        other.advance_to(time).expect("a motion");
        assert_eq!(own.body(0), other.body(0));
        let both = force(&other, 1) + force(&other, 2);
        assert!((force(&own, 1) - both).abs() < ROUNDING, "{} {both}", force(&own, 1));
    }
    let balance = |motion: &Motion| motion.energy().balance();
    assert!((balance(&own) - balance(&other)).abs() < BALANCE);
}
