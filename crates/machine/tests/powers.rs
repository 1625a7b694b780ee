//! Powers of elongations and rates at bodies that contacts hold, and the units of their numbers.

use crate::common::assembled;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::{Event, EventKind, Motion};

/// Rounding of a time of order 1, relative.
const TIME: f64 = 1e-13;
/// Rounding of a unit's factor, relative.
const FACTOR: f64 = 1e-14;

/// Time of the first event of a kind in the first seconds.
fn first(text: &str, is_it: fn(&EventKind) -> bool) -> f64 {
    let mut motion = Motion::new(assembled(text)).expect("a motion");
    let mut found = f64::NAN;
    let mut note = |event: &Event| {
        if found.is_nan() && is_it(&event.kind) {
            found = event.time;
        }
    };
    motion.advance_observed(2.0, &mut note).expect(text);
    found
}

/// A puller moves at a constant rate v, and its spring, contact or damper loads a body that
/// friction holds, or that a bias presses to a rigid stop: F(v t) = level at the slip. The force
/// moves no state until then, but decides when the contact ends. A cubic spring elsewhere has the
/// motion computed by series.
#[test]
fn closed_form_held_bodies_leave_under_powers() {
    let (v, level) = (0.7, 2.5);
    let machine = |elements: &str| {
        format!(
            "name = \"H\"\nbody.b = {{ mass = 0.8 }}\nbody.p = {{ motion = {{ rate = {v} }} }}\n\
             body.c = {{ mass = 1.0, start = {{ v = 1.0 }} }}\n\
             spring.c = {{ between = [\"ground\", \"c\"], cubic = 30.0 }}\n{elements}"
        )
    };
    let friction = format!("friction.f = {{ between = [\"ground\", \"b\"], force = {level} }}\n");
    let wall = format!(
        "stop.w = {{ between = [\"b\", \"ground\"], gap = 0.0, restitution = 0.0 }}\n\
         load.l = {{ on = \"b\", constant = -{level} }}\n"
    );
    for p in [1.2, 1.5, 2.0, 3.0, 9.0] {
        let spring =
            format!("spring.k = {{ between = [\"b\", \"p\"], coefficient = 40.0, exponent = {p:?} }}\n");
        let hertz = format!(
            "stop.h = {{ between = [\"b\", \"p\"], gap = 0.05, stiffness = 40.0, exponent = {p:?} }}\n"
        );
        let reached = (level / 40.0f64).powf(1.0 / p);
        for (element, e) in [(spring, reached), (hertz, 0.05 + reached)] {
            let slip = first(&machine(&(element.clone() + &friction)), |kind| {
                matches!(kind, EventKind::Slip { .. })
            });
            assert!((slip * v / e - 1.0).abs() < TIME, "slip at {slip:?} s, not {:?} s: {element}", e / v);
            let open =
                first(&machine(&(element.clone() + &wall)), |kind| matches!(kind, EventKind::Open { .. }));
            assert!((open * v / e - 1.0).abs() < TIME, "open at {open:?} s, not {:?} s: {element}", e / v);
        }
        // The rate of this puller is a t.
        let damper = format!(
            "body.q = {{ motion = {{ acceleration = {{ constant = 3.0 }} }} }}\n\
             damper.d = {{ between = [\"b\", \"q\"], coefficient = 2.0, exponent = {p:?} }}\n{friction}"
        );
        let slip = first(&machine(&damper), |kind| matches!(kind, EventKind::Slip { .. }));
        let expected = (level / 2.0f64).powf(1.0 / p) / 3.0;
        assert!((slip / expected - 1.0).abs() < TIME, "slip at {slip:?} s, not {expected:?} s: {damper}");
    }
}

/// The force of a damper between two prescribed bodies moves nothing. Its loss is the work of the
/// motions: c ∫ |a t|^(p+1) dt.
#[test]
fn closed_form_loss_between_prescribed_bodies() {
    let (a, c, p, end) = (-3.0f64, 2.0, 1.5, 0.9f64);
    let text = format!(
        "name = \"P\"\nbody.c = {{ mass = 1.0 }}\nload.c = {{ on = \"c\", constant = 0.0 }}\n\
         body.q = {{ motion = {{ acceleration = {{ constant = {a:?} }} }} }}\n\
         damper.d = {{ between = [\"ground\", \"q\"], coefficient = {c:?}, exponent = {p:?} }}\n"
    );
    let mut motion = Motion::new(assembled(&text)).expect("a motion");
    motion.advance_to(end).expect("an end");
    let expected = c * a.abs().powf(p + 1.0) * end.powf(p + 2.0) / (p + 2.0);
    let energy = motion.energy();
    let off = (energy.dashpots[0].value() / expected - 1.0).abs();
    assert!(off < TIME, "{} J instead of {expected} J", energy.dashpots[0].value());
}

/// Units with the exponent of their file, whatever it is. One N/mm^p is 1000^p N/m^p.
#[test]
fn closed_form_units_have_the_exponent_of_the_file() {
    let cases = [
        ("stop", "stiffness", "3e8 N/m^2.2", 2.2, 3e8),
        ("stop", "stiffness", "2 kN/mm^1.2", 1.2, 2e3 * 1e3f64.powf(1.2)),
        ("stop", "stiffness", "0.3 GN/m10", 10.0, 3e8),
        ("spring", "coefficient", "2 N/m^1.7", 1.7, 2.0),
        ("damper", "coefficient", "2 N s^1.5/m^1.5", 1.5, 2.0),
        ("damper", "coefficient", "5 mN.s2.5/m2.5", 2.5, 5e-3),
    ];
    let described = |kind: &str, key: &str, unit: &str, exponent: f64| {
        let gap = if kind == "stop" { "gap = 0.1, " } else { "" };
        let text = format!(
            "name = \"U\"\nbody.b = {{ mass = 1.0 }}\n\
             {kind}.x = {{ between = [\"ground\", \"b\"], {gap}{key} = \"{unit}\", exponent = {exponent:?} }}\n"
        );
        parse(&text, "u.toml", &no_records).map_err(|error| error.to_string())
    };
    for (kind, key, unit, exponent, expected) in cases {
        let machine = described(kind, key, unit, exponent).expect(unit);
        let found = machine.parameter(&format!("{kind}.x.{key}")).expect(key).value;
        assert!((found / expected - 1.0).abs() < FACTOR, "{unit}: {found:e}, not {expected:e}");
    }
    for (kind, key, unit, exponent, said) in [
        ("stop", "stiffness", "3 N/mp", 2.2, "cannot be in N/mp; expected N/m^2.2"),
        ("damper", "coefficient", "3 N/m^1.5", 1.5, "cannot be in N/m^1.5; expected N s^1.5/m^1.5"),
        ("stop", "stiffness", "-3 N/m^2.2", 2.2, "stop.x.stiffness = \"-3 N/m^2.2\""),
    ] {
        let error = described(kind, key, unit, exponent).expect_err(unit);
        assert!(error.contains(said), "{error}\ninstead of\n{said}");
    }
}
