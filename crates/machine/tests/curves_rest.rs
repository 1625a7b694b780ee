//! Starts at rest of machines with curved forces (docs/assembly-law.md, section 23).

use crate::common::*;
use vibro_machine::{Assembly, Differentiated, Error, Motion};

/// Relative rounding of coordinates.
const ROUNDING: f64 = 1e-14;
/// Displacement of a machine at rest after some periods, relative to its coordinates: the rounding
/// of the coordinates is a load, amplified a little at each period.
const STANDS: f64 = 1e-12;
/// Error of the factor at which a machine gives way: steps of the path and the square root of
/// rounding, by which a double root is known.
const FACTOR: f64 = 1e-7;
/// Relative rounding of a derivative of a stiff contact behind a spring that is 500 times softer.
const OF_DERIVATIVE: f64 = 1e-9;

/// Bodies `a`, `b`, … of 2 kg on a line from the ground, each loaded by a constant force.
fn chain(forces: &[f64], elements: &str) -> String {
    let names = ["a", "b", "c"];
    let mut text = String::from("name = \"Chain\"\nstart = \"rest\"\n");
    for (name, force) in names.iter().zip(forces) {
        text += &format!("body.{name} = {{ mass = 2.0 }}\n");
        text += &format!("load.on_{name} = {{ on = \"{name}\", constant = {force:?} }}\n");
    }
    text + elements
}

/// The places of the bodies at rest; the machine stays there.
fn places(text: &str) -> Vec<f64> {
    let assembly = assembled(text);
    let found = assembly.equilibrium().unwrap();
    let mut motion = Motion::new(assembly).unwrap();
    motion.advance_to(3.0).unwrap();
    for (i, s) in found.iter().enumerate() {
        assert!((motion.body(i)[0] - s).abs() < STANDS * s.abs(), "{i}: {:?} {s} in {text}", motion.body(i));
    }
    found
}

fn gives_way(text: &str) -> (String, f64) {
    let description = vibro_machine::file::parse(text, "m.toml", &vibro_machine::file::no_records).unwrap();
    match Assembly::new(description).map(drop) {
        Err(Error::GivesWay { spring, factor }) => (spring, factor),
        other => panic!("{other:?} for {text}"),
    }
}

/// The force of a hardening spring at a given elongation holds the body there, at any scale.
#[test]
fn closed_form_a_hardening_spring_bears_a_load_at_the_place_of_its_force() {
    for (k, cubic, e) in [(4e3, 1e8, 3e-3), (0.0, 5.0, -2.0), (1e-3, 1e12, 1e-4), (2e9, 0.0, 1e-6)] {
        let force: f64 = k * e + cubic * e * e * e;
        let spring =
            format!("spring.s = {{ between = [\"ground\", \"a\"], stiffness = {k:e}, cubic = {cubic:e} }}\n");
        let found = places(&chain(&[force], &spring));
        assert!((found[0] / e - 1.0).abs() < ROUNDING, "{found:?} {e}");
    }
}

/// In a chain each spring carries the loads behind it; a Hertz contact at its end, too.
#[test]
fn closed_form_springs_and_contacts_in_a_chain_carry_the_loads_behind_them() {
    let text = chain(
        &[3.0, -1.0, 4.0],
        "spring.k = { between = [\"ground\", \"a\"], stiffness = 50.0, cubic = 2e3, quintic = 1e4 }\n\
         spring.l = { between = [\"a\", \"b\"], coefficient = \"700 N/m^1.5\", exponent = 1.5 }\n\
         stop.h = { between = [\"b\", \"c\"], gap = 0.02, stiffness = \"1e6 N/m^1.5\", exponent = 1.5 }\n",
    );
    let found = places(&text);
    let e = found[0];
    let carried =
        [50.0 * e + 2e3 * e.powi(3) + 1e4 * e.powi(5) - 6.0, found[1] - e - (3.0 / 700f64).powf(1.0 / 1.5)];
    assert!(carried.iter().all(|off| off.abs() < 6.0 * ROUNDING), "{carried:?}");
    let pressed = found[2] - found[1] - 0.02 - (4.0 / 1e6f64).powf(1.0 / 1.5);
    assert!(pressed.abs() < ROUNDING * found[2], "{pressed:e}");
}

/// A body on a Hertz contact sinks by (m g/k)^(1/p), from any gap, also if the gap is pressed.
#[test]
fn closed_form_a_body_sinks_into_a_contact_by_its_weight() {
    for (exponent, stiffness, gap) in [(1.5, 1e7, 0.1), (1.5, 3e2, 0.0), (2.5, 1e9, -0.004), (3.0, 1e5, 2.0)]
    {
        let unit = if exponent == 3.0 { "3".into() } else { format!("^{exponent}") };
        let stop = format!(
            "stop.h = {{ between = [\"ground\", \"a\"], gap = {gap:?}, stiffness = \"{stiffness:e} N/m{unit}\", \
             exponent = {exponent:?} }}\n"
        );
        let found = places(&chain(&[19.62], &stop));
        let place = gap + (19.62f64 / stiffness).powf(1.0 / exponent);
        let size = gap.abs() + place.abs();
        assert!((found[0] - place).abs() < ROUNDING * size, "{found:?} {place} in {stop}");
    }
}

/// k e - c e³ is at most 2/3 k √(k/(3 c)): below this load the body rests before the maximum;
/// above it the spring gives way when the load has grown to the maximum.
#[test]
fn closed_form_a_softening_spring_gives_way_at_its_largest_force() {
    let (k, c) = (300.0f64, 1e4f64);
    let most = 2.0 / 3.0 * k * (k / (3.0 * c)).sqrt();
    let text = |force| {
        chain(&[force], "spring.soft = { between = [\"ground\", \"a\"], stiffness = 300.0, cubic = -1e4 }\n")
    };
    // sin(3 u) = 3 sin u - 4 sin³ u gives the root between 0 and the maximum.
    let share: f64 = 0.99;
    let e = 2.0 * (k / (3.0 * c)).sqrt() * (share.asin() / 3.0).sin();
    let found = places(&text(share * most));
    assert!((found[0] / e - 1.0).abs() < 1e3 * ROUNDING, "{found:?} {e}");
    for factor in [1.000_1, 1.5, 40.0] {
        let (spring, found) = gives_way(&text(factor * most));
        assert!(spring == "soft" && (found * factor - 1.0).abs() < FACTOR, "{factor}: {spring} {found}");
    }
    // A straight spring beside it leaves it the rest of the load.
    let beside = text(1.5 * most) + "spring.hard = { between = [\"ground\", \"a\"], stiffness = 1e3 }\n";
    let e = places(&beside)[0];
    assert!((1300.0 * e - c * e.powi(3) - 1.5 * most).abs() < ROUNDING * most);
}

/// Of two equal springs with two stable places the one without load is unstable.
#[test]
fn invariant_a_place_between_two_stable_ones_is_no_place_of_rest() {
    let spring = "spring.snap = { between = [\"ground\", \"a\"], stiffness = -100.0, cubic = 1e4 }\n";
    for force in [0.0, 1e-3, -4.0] {
        assert_eq!(gives_way(&chain(&[force], spring)), ("snap".into(), 0.0));
    }
    // With a straight spring that holds it, it rests.
    let held = format!("{spring}spring.hold = {{ between = [\"ground\", \"a\"], stiffness = 150.0 }}\n");
    assert_eq!(assembled(&chain(&[0.0], &held)).equilibrium().unwrap(), [0.0]);
}

/// The place at rest has the derivatives 1/K by the load and -∂φ/K by the numbers of the law, with
/// the stiffness K of the tangent.
#[test]
fn closed_form_derivatives_of_places_at_rest() {
    let text = chain(
        &[3.0, 4.0],
        "spring.k = { between = [\"ground\", \"a\"], stiffness = 50.0, cubic = 2e3 }\n\
         stop.h = { between = [\"a\", \"b\"], gap = 0.02, stiffness = \"1e6 N/m^1.5\", exponent = 1.5 }\n",
    );
    let assembly = assembled(&text);
    let found = assembly.equilibrium().unwrap();
    let (e, x) = (found[0], found[1] - found[0] - 0.02);
    let (of_spring, of_stop) = (50.0 + 6e3 * e * e, 1.5e6 * x.sqrt());
    let columns =
        ["load.on_a.constant", "load.on_b.constant", "spring.k.cubic", "stop.h.stiffness", "stop.h.gap"];
    let by = columns.map(vibro_machine::derivative::By::from);
    let motion = Differentiated::new(assembly, &by).unwrap();
    let expected = [
        [1.0 / of_spring, 1.0 / of_spring],
        [1.0 / of_spring, 1.0 / of_spring + 1.0 / of_stop],
        [-e.powi(3) / of_spring; 2],
        [0.0, -x.powf(1.5) / of_stop],
        [0.0, 1.0],
    ];
    for (p, (name, expected)) in columns.iter().zip(expected).enumerate() {
        let found = motion.state_derivative(p).unwrap_or_else(|| panic!("{name}: {:?}", motion.lost(p)));
        let size = expected[0].abs() + expected[1].abs();
        let off = (found[0] - expected[0]).abs().max((found[1] - expected[1]).abs());
        assert!(off < OF_DERIVATIVE * size, "{name}: {found:?} {expected:?}");
    }
}

/// A pendulum bears the torque m g l sin(e), and a formula that is straight the load k e. The path
/// to a plate before an electrode ends at its fold.
#[test]
fn closed_form_formulas_bear_loads_and_give_way_at_folds() {
    let formula = |force: f64, formula: &str, more: &str| {
        let spring =
            format!("spring.f = {{ between = [\"ground\", \"a\"], force = \"= {formula}\" }}\n{more}");
        chain(&[force], &spring)
    };
    for share in [0.3f64, -0.999] {
        let found = places(&formula(5.0 * share, "5 * sin(e)", ""));
        assert!((found[0] / share.asin() - 1.0).abs() < 1e3 * ROUNDING, "{found:?} {share}");
    }
    let (spring, factor) = gives_way(&formula(5.5, "5 * sin(e)", ""));
    assert!(spring == "f" && (factor * 1.1 - 1.0).abs() < FACTOR, "{spring} {factor}");
    let found = places(&formula(3.0, "120 * e + 0.6 + 2 * rate", ""));
    assert!((found[0] - 0.02).abs() < ROUNDING, "{found:?}");
    let (k, d) = (100.0f64, 2e-3f64);
    let leaf = "spring.leaf = { between = [\"ground\", \"a\"], stiffness = 100.0 }\n";
    let plate = |c: f64| formula(0.0, &format!("-{c:e} / (2e-3 - e)^2"), leaf);
    let most = 4.0 / 27.0 * k * d.powi(3);
    let found = places(&plate(0.9 * most))[0];
    let off = k * found - 0.9 * most / (d - found).powi(2);
    assert!(off.abs() < 1e2 * ROUNDING * k * d && found < d / 3.0, "{found} {off:e}");
    let c = 1.2 * most;
    let fold = d - (2.0 * c / k).cbrt();
    let expected = 1.0 - (c / (d - fold).powi(2) - k * fold) * d * d / c;
    let (spring, factor) = gives_way(&plate(c));
    assert!(spring == "f" && (factor - expected).abs() < FACTOR, "{spring} {factor} {expected}");
}

/// The force of a spring at an elongation.
type Force<'a> = &'a dyn Fn(f64) -> f64;

/// Springs without a stiffness at e = 0, alone or one behind another, bear a load at F(e) = load:
/// powers, formulas, and springs across the motion without tension at e = 0.
#[test]
fn closed_form_springs_that_are_soft_at_zero_bear_loads() {
    let spring = |ends: &str, keys: &str| format!("spring.{ends} = {{ between = {keys} }}\n");
    let on_a = |keys: &str| spring("k", &format!("[\"ground\", \"a\"], {keys}"));
    let across = |e: f64| 1000.0 * e * (1.0 - 0.1 / e.hypot(0.1));
    let cases: [(&str, f64, Force); 7] = [
        ("force = \"= 1e4 * e^7\"", 20.0, &|e| 1e4 * e.powi(7)),
        ("force = \"= 1e3 * e^2 * e\"", -20.0, &|e| 1e3 * e.powi(3)),
        ("force = \"= 1e4 * e^2\"", 20.0, &|e| 1e4 * e * e),
        ("force = \"= 100 * (e - sin(e))\"", 20.0, &|e| 100.0 * (e - e.sin())),
        ("coefficient = 1e4, exponent = 9", 20.0, &|e| 1e4 * e.powi(9)),
        ("coefficient = 1e4, exponent = 20", 20.0, &|e| 1e4 * e.powi(20)),
        ("stiffness = 1000, offset = 0.1, free_length = 0.1", -20.0, &across),
    ];
    for (keys, load, force) in cases {
        let found = places(&chain(&[load], &on_a(keys)))[0];
        let off = force(found) - load;
        assert!(off.abs() < 1e2 * ROUNDING * load.abs(), "{off:e} N at {found} m with {keys}");
        let behind = on_a(keys) + &spring("l", &format!("[\"a\", \"b\"], {keys}"));
        let found = places(&chain(&[0.5 * load, load], &behind));
        for (e, load) in [(found[0], 1.5 * load), (found[1] - found[0], load)] {
            let off = force(e) - load;
            assert!(off.abs() < 1e2 * ROUNDING * load.abs(), "{off:e} N at {found:?} with {keys} twice");
        }
    }
}
