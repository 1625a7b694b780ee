//! Measures, quantities, natural oscillations and starts of machines whose numbers are known in
//! closed form.

use super::*;
use crate::machine::is_between_stops;
use crate::oscillations::oscillations;
use std::f64::consts::TAU;
use vibro_machine::Motion;
use vibro_machine::start::BodyStart;

#[track_caller]
fn near(found: f64, expected: f64, part: f64) {
    assert!((found - expected).abs() <= part * expected.abs(), "{found} {expected}");
}

#[test]
fn closed_form_measures_of_the_impact_pair() {
    /// Tolerance: digits to which the file gives the start, and to which the motion settles.
    const DIGITS: f64 = 1e-8;
    let names = [
        "impacts",
        "impacts.right",
        "impact.rate",
        "impact.rate.left",
        "impact.speed.right",
        "impact.speed.left",
        "impact.impulse.right",
        "power.right",
        "power.left",
        "power.lost",
    ];
    let found = measured(&example("impact_pair.toml"), &names);
    // The ball flies at V to a wall that moves at -V/3; half of the closing speed is returned.
    let speed = 1.505_573_953_117_26 * 4.0 / 3.0;
    let lost = 0.5 * 0.5 * speed * 1.5 * speed;
    let expected =
        [2.0, 1.0, 2.0 / TAU, 1.0 / TAU, speed, speed, 1.5 * speed, lost / TAU, lost / TAU, 2.0 * lost / TAU];
    for (found, expected) in found.into_iter().zip(expected) {
        near(found, expected, DIGITS);
    }
}

#[test]
fn closed_form_extremes_of_what_swings_about_a_place_below_zero() {
    let found = measured(
        &text(&OSCILLATOR.replace("amplitude = 10.0", "constant = -1600.0\namplitude = 10.0")),
        &["amplitude.a.s", "maximum.a.s", "peak_to_peak.a.s", "rms.a.s", "maximum.f.f", "amplitude.f.f"],
    );
    let w = 10.0 * std::f64::consts::PI;
    let swing = 10.0 / (800.0 - 2.0 * w * w).hypot(8.0 * w);
    let expected =
        [2.0 + swing, swing - 2.0, 2.0 * swing, (4.0 + swing * swing / 2.0).sqrt(), -1590.0, 1610.0];
    for (found, expected) in found.into_iter().zip(expected) {
        near(found, expected, SETTLED);
    }
}

#[test]
fn measures_are_read_as_they_are_written_and_of_what_a_machine_has() {
    let d = example("damper_with_buffer.toml").description;
    let all = Measure::all(&d);
    let mut words: Vec<String> = all.iter().map(Measure::description).collect();
    for measure in &all {
        assert_eq!(measure.to_string().parse::<Measure>().unwrap(), *measure);
        measure.check(&d).unwrap();
        assert!(
            matches!(measure.unit(&d), "m" | "m/s" | "m/s2" | "N" | "N.s" | "W" | "1" | "1/s"),
            "{measure}"
        );
    }
    words.sort();
    words.dedup();
    assert_eq!(words.len(), all.len(), "each is described by its own words");
    for wrong in [
        "impact.impulse.buffer",
        "impacts.guide",
        "power.box",
        "power.none",
        "impact.speed.mount",
        "rms.box.f",
    ] {
        assert!(wrong.parse::<Measure>().unwrap().check(&d).is_err(), "{wrong}");
    }
    assert!("speed.box".parse::<Measure>().is_err() && "power".parse::<Measure>().is_err());
    let usual: Vec<String> = Measure::usual(&d).iter().map(ToString::to_string).collect();
    let expected = "amplitude.box.s amplitude.block.s amplitude.pump.s impacts impact.speed.steel impact.speed.buffer power.lost class";
    assert_eq!(usual.join(" "), expected);
    assert!(!Measure::usual(&text(OSCILLATOR).description).contains(&Measure::Impacts(None)));
    let gears = example("gear_backlash.toml").description;
    for (name, unit) in [
        ("impact.speed.drive_flank", "m/s"),
        ("rms.pinion.s", "rad"),
        ("rms.pinion.v", "rad/s"),
        ("rms.pinion.a", "rad/s2"),
        ("maximum.clutch.f", "N.m"),
        ("maximum.clutch.e", "rad"),
        ("maximum.clutch.rate", "rad/s"),
        ("exponent", "1/s"),
    ] {
        let measure = name.parse::<Measure>().unwrap();
        assert_eq!((measure.unit(&gears), measure.check(&gears).is_ok()), (unit, true), "{name}");
    }
    let pair = text(
        "name = \"P\"\n[body.a]\ninertia = 1.0\n[stop.s]\nbetween = [\"ground\", \"a\"]\ngap = 0.1\nrestitution = 0.5\n",
    );
    let units =
        ["impact.speed.s", "impact.impulse.s"].map(|n| n.parse::<Measure>().unwrap().unit(&pair.description));
    assert_eq!(units, ["rad/s", "N.m.s"]);
}

/// A body, a spring and a load may share a name; the quantity determines which of them is meant.
#[test]
fn a_quantity_is_of_the_body_or_the_element_by_what_it_is() {
    let file = "name = \"N\"\n[body.k]\nmass = 2.0\nstart = { s = 0.1, v = 0.5 }\n[spring.k]\nbetween = [\"ground\", \"k\"]\nstiffness = 800.0\n\
        [load.f]\non = \"k\"\nconstant = 3.0\namplitude = 0.0\nfrequency = 1.0\n";
    let (motion, _) = text(file).motion(&Start::default()).unwrap();
    let d = &motion.assembly().description;
    let mut flows = crate::flight::Flows::default();
    for (name, value) in [
        ("k.s", 0.1),
        ("k.v", 0.5),
        ("k.a", -38.5),
        ("k.e", 0.1),
        ("k.rate", 0.5),
        ("k.f", 80.0),
        ("f.f", 3.0),
    ] {
        let quantity: QuantityName = name.parse().unwrap();
        assert_eq!(quantity.to_string(), name);
        let found = flows.value(&motion, quantity.find(d).unwrap().quantity);
        assert!((found.abs() - f64::abs(value)).abs() < 1e-12, "{name}: {found}");
    }
    assert_eq!("spring.k.f".parse::<QuantityName>().unwrap(), "k.f".parse().unwrap());
    for wrong in ["f.e", "g.f", "k.x", "k"] {
        assert!(wrong.parse::<QuantityName>().and_then(|q| q.find(d)).is_err(), "{wrong}");
    }
}

fn frequencies(file: &str) -> Vec<f64> {
    let assembly = Assembly::new(text(file).description).unwrap();
    let mut all = oscillations(assembly.system());
    all.sort_by(f64::total_cmp);
    all
}

#[test]
fn closed_form_own_oscillations() {
    let one = |damping: &str| {
        format!(
            "name = \"O\"\n[body.a]\nmass = 2.0\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\n{damping}[stop.s]\n\
             between = [\"ground\", \"a\"]\ngap = -0.1\nstiffness = 1e6\n[stop.r]\nbetween = [\"a\", \"ground\"]\ngap = 5.0\n\
             restitution = 0.5\n[friction.f]\nbetween = [\"ground\", \"a\"]\nforce = 1e3\n[load.l]\non = \"a\"\namplitude = 1.0\nfrequency = 3.7\n"
        )
    };
    let [free] = frequencies(&one(""))[..] else { panic!() };
    near(free, 20.0 / TAU, 1e-9);
    // √(ω² - δ²) with δ = 12/s.
    let [damped] = frequencies(&one("damping = 48.0\n"))[..] else { panic!() };
    near(damped, 16.0 / TAU, 1e-9);
    assert!(frequencies(&one("damping = 100.0\n")).is_empty(), "it creeps");
    // Two equal masses between three equal springs: 1 and √3.
    let two = "name = \"T\"\n[body.a]\nmass = 2.0\n[body.b]\nmass = 2.0\n[spring.a]\nbetween = [\"ground\", \"a\"]\nstiffness = 800.0\n\
        [spring.b]\nbetween = [\"a\", \"b\"]\nstiffness = 800.0\n[spring.c]\nbetween = [\"b\", \"ground\"]\nstiffness = 800.0\n";
    let [low, high] = frequencies(two)[..] else { panic!() };
    near(low, 20.0 / TAU, 1e-9);
    near(high, 20.0 * 3f64.sqrt() / TAU, 1e-9);
}

/// A body that a table presses against a wall a quarter period after the start, with `overlap` m
/// less room than it needs.
fn jammed(overlap: f64) -> Option<Motion> {
    let file = format!(
        "name = \"J\"\n[body.table]\nmotion = {{ amplitude = {:?}, frequency = 1.0 }}\n[body.a]\nmass = 1.0\n[stop.wall]\n\
         between = [\"ground\", \"a\"]\ngap = 1e-3\nrestitution = 0.5\n[stop.table]\nbetween = [\"a\", \"table\"]\n\
         gap = 1e-3\nrestitution = 0.5\n",
        2e-3 + overlap
    );
    let assembly = Assembly::new(text(&file).description).unwrap();
    Motion::starting_at(Arc::new(assembly), 0.25).ok()
}

#[test]
fn stops_are_violated_by_more_than_rounding_of_their_terms() {
    assert!(jammed(-1e-6).is_some_and(|motion| is_between_stops(&motion)));
    let violated: Vec<Option<bool>> = [1e-10, 1e-8, 1e-6]
        .iter()
        .map(|overlap| jammed(*overlap).map(|motion| !is_between_stops(&motion)))
        .collect();
    assert_eq!(violated, [Some(true); 3]);
}

#[test]
fn a_motion_goes_on_where_another_ended_or_else_begins_at_the_machines_own_start() {
    let file = "name = \"J\"\n[body.table]\nmotion = { amplitude = 3e-3, frequency = 1.0 }\n[body.a]\nmass = 1.0\n[stop.wall]\n\
        between = [\"ground\", \"a\"]\ngap = 1e-3\nrestitution = 0.5\n[stop.table]\nbetween = [\"a\", \"table\"]\n\
        gap = 1e-3\nrestitution = 0.5\n";
    let at = |time: f64| {
        let given = BodyStart { s: Some(5e-4), v: Some(0.1) };
        let bodies = [("a".to_owned(), given)].into();
        let end = Start { time, bodies, ..Start::default() };
        let (motion, _) = text(file).motion_on(&end).unwrap();
        (motion.time(), motion.body(1)[0], motion.body(1)[1])
    };
    assert_eq!(at(0.5), (0.5, 5e-4, 0.1));
    // The table leaves no room.
    assert_eq!(at(0.25), (0.0, 0.0, 0.0));
    let (motion, _) = text(file).motion(&Start::default()).unwrap();
    assert_eq!(now(&motion).time, 0.0);
    assert_eq!(now(&motion).bodies.len(), 2);
}

#[test]
fn resonances_are_those_of_frequencies_alone() {
    use crate::design_sweep::DesignMachine as _;
    let machine = text(OSCILLATOR);
    let [own] = machine.resonances(&"load.f.frequency".to_owned())[..] else { panic!() };
    // √(ω² - δ²) with ω = 20/s and δ = 2/s.
    near(own, 396f64.sqrt() / TAU, 1e-9);
    assert!(machine.resonances(&"body.a.mass".to_owned()).is_empty());
}

#[test]
fn a_class_has_no_spread_and_what_a_sweep_measures_has_its_accounts() {
    let machine = text(OSCILLATOR);
    let (mut motion, section) = machine.motion(&Start::default()).unwrap();
    discard(&mut motion, &section, 200).unwrap();
    let names = ["class", "exponent", "power.k"].map(|name| name.parse().unwrap());
    let found = measure(&mut motion, &section, &names, 12).unwrap();
    assert_eq!(
        (found.class, found.numbers[0], found.spreads[0]),
        (Some(MotionClass::Periodic(1)), None, 0.0)
    );
    assert!((found.numbers[1].unwrap() + 2.0).abs() < SETTLED && found.spreads[1] < SETTLED, "{found:?}");
    let row = swept(&machine, &["power.k"], 200, 12);
    near(row.outputs[0].unwrap().largest, found.numbers[2].unwrap(), SETTLED);
    // The same for a measure that does not need the accounts.
    let row = swept(&machine, &["maximum.a.s"], 200, 12);
    near(row.outputs[0].unwrap().largest, measured(&machine, &["maximum.a.s"])[0], SETTLED);
}

/// After a step the middle is 2 m, where the body meets a soft stop once per period. Before the
/// step it meets nothing.
#[test]
fn closed_form_a_point_of_a_plane_is_the_motion_after_what_is_discarded() {
    use crate::isoperiodic::{IsoperiodicRequest, PlaneMachine};
    let stop = "[stop.s]\nbetween = [\"ground\", \"a\"]\ngap = 2.0\nstiffness = 1.0\n";
    let file =
        OSCILLATOR.replace("frequency = \"5 Hz\"", "frequency = \"5 Hz\"\nsteps = [[\"20 s\", 1600.0]]");
    let machine = text(&format!("{file}{stop}"));
    let axis = |name: &str, ends: (f64, f64)| ParameterAxis::of(name.to_owned(), ends, 2).unwrap();
    let x = axis("spring.k.damping", (8.0, 9.0));
    let y = axis("load.f.amplitude", (9.0, 10.0));
    let request =
        IsoperiodicRequest::<Machine> { x, y, start: Start::default(), discard: 200, exponents: Some(16) };
    machine.check_plane(&request).unwrap();
    let points = machine.points(&request, 0..2, &mut ());
    assert_eq!(points.len(), 4);
    for (k, point) in points.into_iter().enumerate() {
        let point = point.unwrap();
        assert_eq!(
            (point.class, point.contacts, point.rests),
            (MotionClass::Periodic(1), 1.0, false),
            "{point:?}"
        );
        assert!((point.interval - 0.2).abs() < 1e-9);
        // -c/(2 m), along the first axis.
        let damping = [8.0, 9.0][k % 2];
        assert!((point.exponent.unwrap()[0] + damping / 4.0).abs() < 1e-3, "{k}: {point:?}");
    }
    // A step beyond the discarded time is refused by name.
    let short = IsoperiodicRequest { discard: 99, ..request };
    assert!(machine.check_plane(&short).unwrap_err().to_string().starts_with("load.f has a step at 20 s"));
}
