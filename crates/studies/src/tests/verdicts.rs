//! Classes and exponents of machines whose motions are known in closed form.

use super::*;
use std::f64::consts::TAU;

/// Tolerance for an exponent from multipliers at the distance 1e-9 from the orbit.
const EXACT: f64 = 1e-7;

fn verdict(machine: &Machine, first: u32) -> Settled {
    let (mut motion, section) = machine.motion(&Start::default()).unwrap();
    discard(&mut motion, &section, first).unwrap();
    settled(&mut motion, &section, Some(64)).unwrap()
}

fn exponent_of(found: &Settled) -> f64 {
    found.exponent.unwrap().value
}

const ROTOR: &str = "name = \"R\"\n[body.r]\ninertia = 0.5\nstart = { v = 3.0 }\n[spring.drag]\nbetween = [\"ground\", \"r\"]\n\
    stiffness = 0.0\ndamping = 0.4\n[load.t]\non = \"r\"\nconstant = 2.0\namplitude = 1.0\nfrequency = 5.0\n";

#[test]
fn closed_form_a_free_shaft_with_drag_has_a_period_and_the_exponent_of_its_speed() {
    let found = verdict(&text(ROTOR), 0);
    assert_eq!(found.class, MotionClass::Periodic(1));
    // 0.5 v' = -0.4 v + …
    assert!((exponent_of(&found) + 0.8).abs() < EXACT, "{found:?}");
}

/// A shaft that a torque turns against friction that always slips: neighbours separate linearly.
#[test]
fn closed_form_a_shaft_that_always_slips_has_the_exponent_zero_and_what_turns_with_it_its_own() {
    let of = |torque: f64, relative: &str| {
        text(&format!(
            "name = \"G\"\n[body.a]\ninertia = 0.5\nstart = {{ v = 30.0 }}\n{relative}[friction.drag]\nbetween = [\"ground\", \"a\"]\n\
             force = 2.0\n[load.t]\non = \"a\"\nconstant = {torque:?}\namplitude = 1.0\nfrequency = 5.0\n"
        ))
    };
    let relative = "[body.b]\ninertia = 0.5\nstart = { v = 30.0 }\n[spring.k]\nbetween = [\"a\", \"b\"]\n\
        stiffness = 100.0\ndamping = 2.0\n";
    for beside in ["", relative] {
        let found = verdict(&of(2.0, beside), 0);
        assert_eq!((found.class, exponent_of(&found)), (MotionClass::Periodic(1), 0.0), "{beside}");
        // It accelerates for ever.
        let found = verdict(&of(2.02, beside), 0);
        assert!(!found.class.is_decided() && found.exponent.is_none(), "{beside}: {found:?}");
    }
}

/// A car braked by friction, next to an oscillator: the motion has a period only once the car is
/// at rest.
#[test]
fn closed_form_what_friction_brakes_has_no_period_before_it_stands() {
    let of = |drag: f64| {
        text(&format!(
            "name = \"C\"\n[body.m]\ninertia = 1.0\n[body.car]\ninertia = 1.0\nstart = {{ v = 50.0 }}\n[spring.k]\n\
             between = [\"ground\", \"m\"]\nstiffness = 1e5\ndamping = 20.0\n[friction.drag]\nbetween = [\"ground\", \"car\"]\n\
             force = {drag:?}\n[load.l]\non = \"m\"\namplitude = 1e4\nfrequency = \"50 Hz\"\n"
        ))
    };
    assert!(!verdict(&of(1e-3), 0).class.is_decided());
    // A measure of the oscillator reports that the motion has not settled.
    let (mut motion, section) = of(1e-3).motion(&Start::default()).unwrap();
    discard(&mut motion, &section, 40).unwrap();
    let amplitude = ["amplitude.m.s".parse().unwrap()];
    assert_eq!(measure(&mut motion, &section, &amplitude, 60).unwrap().unsettled, Some(1));
    // The car is at rest after 5 s, at any position; the oscillator has δ'' + 20 δ' + 1e5 δ = 0.
    let found = verdict(&of(10.0), 400);
    assert_eq!(found.class, MotionClass::Periodic(1), "{found:?}");
    assert!((exponent_of(&found) + 10.0).abs() < EXACT, "{found:?}");
}

const REST_ON_TABLE: &str = "name = \"RestOnTable\"\ngravity = 9.81\n[body.table]\nmotion = { amplitude = 0.005, frequency = 5.0 }\n\
    [body.ball]\nmass = 0.3\ngravity = -1.0\nstart = { v = 0.15707963267948966 }\n[spring.k]\nbetween = [\"ground\", \"ball\"]\n\
    stiffness = 100.0\ndamping = 2.0\n[stop.s]\nbetween = [\"ball\", \"table\"]\ngap = 0.0\nrestitution = 0.4\n";

#[test]
fn closed_form_what_rests_on_a_table_for_ever_has_the_tables_period_and_no_exponent() {
    for frequency in ["2.0", "3.3", "4.0", "5.0", "6.1"] {
        for mass in ["0.1", "0.3", "0.7"] {
            let file = REST_ON_TABLE.replace("frequency = 5.0", &format!("frequency = {frequency}"));
            let file = file.replace("mass = 0.3", &format!("mass = {mass}"));
            let found = verdict(&text(&file), 0);
            assert_eq!(found.class, MotionClass::Periodic(1), "{frequency} Hz, {mass} kg");
            assert_eq!(exponent_of(&found), f64::NEG_INFINITY, "{frequency} Hz, {mass} kg");
        }
    }
    // Nothing can grow if everything is held, so a few returns of 0.2 s decide.
    let (mut motion, section) = text(REST_ON_TABLE).motion(&Start::default()).unwrap();
    settled(&mut motion, &section, None).unwrap();
    assert!(motion.time() < 18.0 * 0.2, "{}", motion.time());
    // An oscillator next to it: δ'' + δ' + 50 δ = 0.
    let beside = "[body.other]\nmass = 2.0\nstart = { s = 0.01 }\n[spring.other]\nbetween = [\"ground\", \"other\"]\nstiffness = 100.0\ndamping = 2.0\n";
    let found = verdict(&text(&format!("{REST_ON_TABLE}{beside}")), 0);
    assert_eq!(found.class, MotionClass::Periodic(1));
    assert!((exponent_of(&found) + 0.5).abs() < EXACT, "{found:?}");
}

/// Phase of the table, as sine and cosine, at the impact of the ball's 1T motion with one impact
/// per period. The ball leaves and arrives with speed g T/2.
fn ball_phase(amplitude: f64) -> [f64; 2] {
    // g T/2 = (1 + e) p' + e g T/2.
    let cosine = G * PERIOD / 2.0 * (1.0 - E) / (1.0 + E) / (amplitude * TAU / PERIOD);
    [(1.0 - cosine * cosine).sqrt(), cosine]
}

const E: f64 = 0.5;
const G: f64 = 9.81;
const PERIOD: f64 = 0.04;

/// A ball on a table. It starts on its 1T motion with 1 % more speed.
pub(crate) fn ball(amplitude: f64) -> Machine {
    ball_from(amplitude, 1.01)
}

/// A ball on a table. It starts with a multiple of the speed of its 1T motion.
fn ball_from(amplitude: f64, part: f64) -> Machine {
    let [sine, cosine] = ball_phase(amplitude);
    let since = PERIOD - sine.atan2(cosine) / TAU * PERIOD;
    let s = amplitude * sine + G * PERIOD / 2.0 * since - G * since * since / 2.0;
    let v = part * (G * PERIOD / 2.0 - G * since);
    text(&format!(
        "name = \"B\"\ngravity = {G:?}\n[body.table]\nmotion = {{ amplitude = {amplitude:?}, frequency = {:?} }}\n[body.ball]\n\
         mass = 0.1\ngravity = -1.0\nstart = {{ s = {s:?}, v = {v:?} }}\n[stop.s]\nbetween = [\"ball\", \"table\"]\n\
         gap = 0.0\nrestitution = {E:?}\n",
        1.0 / PERIOD
    ))
}

/// Largest modulus of the multipliers of the ball's 1T motion.
fn ball_multiplier(amplitude: f64) -> f64 {
    let [sine, cosine] = ball_phase(amplitude);
    let w = TAU / PERIOD;
    let (speed, acceleration) = (amplitude * w * cosine, -amplitude * w * w * sine);
    let after = G * PERIOD / 2.0;
    // From an impact at t, with speed v after it, to the next at t': p(t) + v s - g s²/2 = p(t')
    // with s = t' - t, whose variation is p' δt + s δv + (v - g s)(δt' - δt) = p' δt'.
    let closing = after - G * PERIOD - speed;
    let [dt_t, dt_v] = [(after - G * PERIOD - speed) / closing, -PERIOD / closing];
    let [v_t, v_v] = [-G * (dt_t - 1.0), 1.0 - G * dt_v];
    // v⁺ = (1 + e) p' - e v⁻.
    let jump = (1.0 + E) * acceleration;
    let m = [[dt_t, dt_v], [jump * dt_t - E * v_t, jump * dt_v - E * v_v]];
    let (trace, det) = (m[0][0] + m[1][1], m[0][0] * m[1][1] - m[0][1] * m[1][0]);
    let root = trace * trace - 4.0 * det;
    if root < 0.0 { det.sqrt() } else { 0.5 * (trace.abs() + root.sqrt()) }
}

#[test]
fn closed_form_a_ball_beside_its_doubling_has_its_period_and_multiplier() {
    // The doubling is at 0.60704 mm.
    for (amplitude, period) in [(0.55e-3, 1), (0.605e-3, 1), (0.6065e-3, 1), (0.6075e-3, 2), (0.62e-3, 2)] {
        let found = verdict(&ball(amplitude), 100);
        assert_eq!(found.class, MotionClass::Periodic(period), "{amplitude}");
        if period == 1 {
            let expected = ball_multiplier(amplitude).ln() / PERIOD;
            let own = exponent_of(&found);
            let error = found.exponent.unwrap().error;
            assert!((own - expected).abs() < EXACT * 10.0, "{amplitude}: {own} {expected}");
            assert!((own - expected).abs() <= 3.0 * error + 1e-9, "{amplitude}: {own} {expected} {error}");
        }
    }
}

/// Beyond its doubling the 1T motion still exists, but neighbours depart from it.
#[test]
fn closed_form_a_ball_that_starts_on_its_unstable_motion_does_not_have_its_period() {
    assert!(ball_multiplier(0.62e-3) > 1.01);
    let found = verdict(&ball_from(0.62e-3, 1.0 + 1e-8), 0);
    assert_eq!(found.class, MotionClass::Periodic(2), "{found:?}");
}

#[test]
fn closed_form_two_frequencies_without_a_common_period_are_quasi_periodic() {
    let two = OSCILLATOR.replace(
        "amplitude = 10.0\nfrequency = \"5 Hz\"",
        "harmonics = [{amplitude = 10.0, frequency = 5.0}, {amplitude = 10.0, frequency = 7.071067811865475}]",
    );
    let mut machine = text(&two);
    machine.section = SectionRule::Period(0.2);
    let found = verdict(&machine, 0);
    assert_eq!(found.class, MotionClass::QuasiPeriodic);
    // δ'' + 4 δ' + 400 δ = 0: within two standard errors.
    let exponent = found.exponent.unwrap();
    assert!((exponent.value + 2.0).abs() <= 2.0 * exponent.error, "{exponent:?}");
}

/// A weak ripple of 1 MHz together with the stick-slip of a block on a belt.
#[test]
fn second_method_a_ripple_of_microseconds_is_no_period_of_a_slow_motion() {
    let belt = "name = \"B\"\n[body.belt]\nmotion = { rate = 0.1 }\n[body.block]\nmass = 1.0\n[spring.k]\n\
        between = [\"ground\", \"block\"]\nstiffness = 100.0\n[friction.f]\nbetween = [\"belt\", \"block\"]\nforce = 2.0\nstatic = 4.0\n";
    let ripple = "[load.l]\non = \"block\"\namplitude = 1e-6\nfrequency = \"1 MHz\"\n";
    let found = verdict(&text(&format!("{belt}{ripple}")), 8);
    assert_eq!(found.class, MotionClass::NotSettled, "{found:?}");
    assert!(matches!(verdict(&text(belt), 8).class, MotionClass::Periodic(1)));
}

/// Exponents of linear machines are the real parts -c/(2 m) of the roots, for any frequency and
/// phase of the drive.
#[test]
fn closed_form_exponents_of_oscillators_that_turn_against_the_section() {
    for k in 0..12 {
        let (m, c, f) = (1.0 + 0.3 * f64::from(k), 0.5 + 0.1 * f64::from(k), 1.0 + 0.37 * f64::from(k));
        let file = format!(
            "name = \"O\"\n[body.a]\nmass = {m:?}\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 300.0\ndamping = {c:?}\n\
             [load.f]\non = \"a\"\namplitude = 1.0\nfrequency = {f:?}\nphase = \"{} deg\"\n",
            17 * k
        );
        let found = verdict(&text(&file), 20);
        let expected = -c / (2.0 * m);
        assert_eq!(found.class, MotionClass::Periodic(1), "{k} {found:?}");
        assert!((exponent_of(&found) - expected).abs() < EXACT, "{k}: {:?} {expected}", found.exponent);
    }
}

/// The ball's 1T motion on a table whose phase makes impacts fall on whole periods: rounding
/// decides on which side of the section each impact comes.
#[test]
fn closed_form_a_ball_that_hits_the_table_at_the_section_has_its_period_and_multiplier() {
    for amplitude in [0.55e-3, 0.58e-3] {
        let [sine, cosine] = ball_phase(amplitude);
        let phase = sine.atan2(cosine).to_degrees();
        let file = format!(
            "name = \"B\"\ngravity = {G:?}\n[body.table]\nmotion = {{ amplitude = {amplitude:?}, frequency = {:?}, phase = \"{phase} deg\" }}\n\
             [body.ball]\nmass = 0.1\ngravity = -1.0\nstart = {{ s = {:?}, v = {:?} }}\n[stop.s]\nbetween = [\"ball\", \"table\"]\n\
             gap = 0.0\nrestitution = {E:?}\n",
            1.0 / PERIOD,
            amplitude * sine + 1e-9,
            G * PERIOD / 2.0
        );
        let found = verdict(&text(&file), 100);
        assert_eq!((found.class, found.contacts), (MotionClass::Periodic(1), 1.0), "{amplitude}");
        let expected = ball_multiplier(amplitude).ln() / PERIOD;
        assert!((exponent_of(&found) - expected).abs() < 10.0 * EXACT, "{found:?} {expected}");
    }
}

#[test]
fn invariant_what_is_not_decided_is_no_hysteresis() {
    let decided = verdict(&text(ROTOR), 0);
    let other = verdict(&text(&ROTOR.replace("constant = 2.0", "constant = 3.0")), 0);
    assert_eq!(decided.differs(&decided), Some(false));
    assert_eq!(decided.differs(&other), Some(true), "another speed");
    let open = Settled { class: MotionClass::Settling, period: None, ..decided.clone() };
    assert_eq!((decided.differs(&open), open.differs(&decided)), (None, None));
    let chaotic = Settled { class: MotionClass::Chaotic, period: None, ..decided.clone() };
    assert_eq!((chaotic.differs(&chaotic), chaotic.differs(&decided)), (None, Some(true)));
}

/// Three bodies whose returns are within 1e-5 of their sizes, with chatter that ends one bounce
/// earlier or later. Up to this size, motions from states 1e-6 apart separate by a factor 1.57 per
/// return (computed from changed starts).
const SMALL_CHAOS: &str = r#"
name = "M565"
[body.a]
mass = 0.300742
start = { s = 0, v = -0.12232 }
[body.b]
mass = 0.97248
start = { s = 0, v = -0.0721715 }
[body.c]
mass = 0.294237
start = { s = 0, v = -0.380451 }
[spring.ka]
between = ["ground","a"]
stiffness = 1151.78
damping = 12.2984
[spring.kb]
between = ["a","b"]
stiffness = 623.975
damping = 0.227049
[spring.kc]
between = ["b","c"]
stiffness = 4111.88
damping = 0.402599
[stop.s0]
between = ["c","b"]
gap = 0.00036945
restitution = 0.714
[stop.s1]
between = ["a","b"]
gap = 0.00463225
restitution = 0.530
[friction.f]
between = ["ground","b"]
force = 2.48799
[load.l]
on = "c"
amplitude = 6.75323
frequency = 4.12661
"#;

#[test]
fn second_method_returns_to_the_size_of_a_small_chaos_are_no_period() {
    let found = verdict(&text(SMALL_CHAOS), 200);
    assert_eq!(found.class, MotionClass::Chaotic, "{found:?}");
    assert!((0.3..1.2).contains(&exponent_of(&found)), "{found:?}");
}

/// Without damping the oscillator keeps swinging in addition to the drive: two frequencies, each
/// with a zero exponent.
#[test]
fn closed_form_an_undamped_oscillator_beside_its_drive_is_quasi_periodic() {
    let file = OSCILLATOR
        .replace("damping = 8.0", "damping = 0.0")
        .replace("mass = 2.0", "mass = 2.0\nstart = { s = 0.1 }");
    let found = verdict(&text(&file), 0);
    assert_eq!(found.class, MotionClass::QuasiPeriodic, "{found:?}");
    let exponent = found.exponent.unwrap();
    assert!(exponent.value.abs() <= exponent.error, "{exponent:?}");
}

/// Contacts of rods and of shafts follow the same law.
#[test]
fn invariant_a_machine_about_an_axis_has_the_verdict_of_one_along_a_line() {
    let along = "name = \"P\"\n[body.a]\nmass = 2.0\nstart = { v = 0.3 }\n[spring.k]\nbetween = [\"ground\", \"a\"]\nstiffness = 300.0\n\
        damping = 1.0\n[stop.s]\nbetween = [\"ground\", \"a\"]\ngap = 0.01\nstiffness = 5000.0\ndamping = 5.0\n[load.f]\non = \"a\"\n\
        amplitude = 8.0\nfrequency = 2.5\n";
    let about = along.replace("mass = 2.0", "inertia = 2.0");
    let [line, axis] = [along, &about].map(|file| verdict(&text(file), 50));
    assert!(line.contacts > 0.0 && line.period.is_some(), "{line:?}");
    assert_eq!(line, axis);
}

#[test]
fn a_sweep_takes_each_parameter_once() {
    use crate::design_sweep::{Designs, SampledAxis, SweepRequest};
    let axis = |name: &str| SampledAxis { name: name.to_owned(), values: vec![1.0, 2.0] };
    let request = |names: &[&str]| SweepRequest::<Machine> {
        designs: Designs::Grid(names.iter().map(|name| axis(name)).collect()),
        measures: vec![Measure::Class],
        ..SweepRequest::default()
    };
    request(&["body.a.mass", "spring.k.stiffness"]).check().unwrap();
    let refused = request(&["body.a.mass", "body.a.mass"]).check().unwrap_err().to_string();
    assert!(refused.contains("body.a.mass"), "{refused}");
}

/// The engine turns the gears uniformly, so their angles do not return.
#[test]
fn invariant_gears_that_turn_on_have_the_period_of_their_play() {
    let machine =
        example("gear_backlash.toml").with([("body.engine.motion.amplitude", 0.1f64.to_radians())]).unwrap();
    let found = verdict(&machine, 40);
    assert_eq!(found.class, MotionClass::Periodic(1), "{found:?}");
    assert!(exponent_of(&found) < 0.0, "{found:?}");
}

#[test]
fn a_section_is_found_by_its_elements_name() {
    let frictions = ["first", "second"]
        .map(|name| format!("[friction.{name}]\nbetween = [\"ground\", \"a\"]\nforce = 0.1\n"));
    let mut machine = text(&format!("{OSCILLATOR}{}", frictions.concat()));
    for (place, name) in ["friction.first", "second"].into_iter().enumerate() {
        machine.section = SectionRule::Element(name.into());
        assert_eq!(Section::of(&machine.description, &machine.section).unwrap(), Section::Friction(place));
    }
}

/// Repeated pulses drive a motion of their period, which the oscillator approaches at its own rate
/// c/(2m) = 2/s. At the same rate it comes to rest after a sweep, seen at the given period.
#[test]
fn closed_form_the_exponent_of_an_oscillator_under_what_repeats() {
    const EXACT: f64 = 1e-9;
    let with = |signal: &str| text(&OSCILLATOR.replace("amplitude = 10.0\nfrequency = \"5 Hz\"", signal));
    let hold = "table = [[0.0, 5.0], [0.05, -5.0], [0.12, 0.0]]\ninterpolation = \"hold\"\nrepeat = 0.2";
    let cubic = "table = [[0.05, 5.0], [0.1, -5.0], [0.15, 0.0]]\ninterpolation = \"cubic\"\nrepeat = 0.2";
    let steps = "steps = [[0.0, 5.0], [0.07, -5.0]]\nrepeat = 0.2";
    let sweep = "sweep = { amplitude = 10.0, from = 1.0, to = 5.0, duration = 1.9 }";
    for signal in [hold, cubic, steps, sweep] {
        let mut machine = with(signal);
        if signal == sweep {
            machine.section = SectionRule::Period(0.2);
        }
        let (mut motion, section) = machine.motion(&Start::default()).unwrap();
        settle(&mut motion, &section, 400).unwrap();
        let found = settled(&mut motion, &section, Some(16)).unwrap();
        assert_eq!(found.period, Some(1), "{signal}");
        let exponent = found.exponent.unwrap().value;
        assert!((exponent + 2.0).abs() < EXACT, "{signal}: {exponent}");
    }
}

/// A stiffness that switches gives the common period. Its multipliers come from the product of two
/// cosine maps: x = exp(-c t/2) y with y'' + (k - c²/4) y = 0.
#[test]
fn closed_form_the_exponent_of_a_gear_mesh_within_its_tongue_and_outside() {
    const EXACT: f64 = 1e-9;
    let (c, k) = (0.5_f64, [1.4_f64, 0.6]);
    for period in [2.2_f64, std::f64::consts::PI] {
        let machine = text(&format!(
            "name = \"Mesh\"\n[body.gear]\nmass = 1.0\nstart = {{ s = 0.3 }}\n[spring.mesh]\nbetween = [\"ground\", \"gear\"]\n\
             damping = {c}\nstiffness = {{ constant = 1.4, steps = [[{:?}, -0.8]], repeat = {period:?} }}\n\
             [load.f]\non = \"gear\"\nconstant = 1.0\n",
            0.5 * period
        ));
        assert_eq!(common_period(&machine.description), Some(period));
        let half = |k: f64| {
            let (omega, (sine, cosine)) =
                ((k - 0.25 * c * c).sqrt(), ((k - 0.25 * c * c).sqrt() * 0.5 * period).sin_cos());
            [[cosine, sine / omega], [-omega * sine, cosine]]
        };
        let [a, b] = k.map(half);
        let trace: f64 = (0..2).map(|i| (0..2).map(|j| a[i][j] * b[j][i]).sum::<f64>()).sum();
        let grows = trace.abs() > 2.0;
        assert_eq!(grows, period > 3.0);
        let growth =
            if grows { (0.5 * (trace.abs() + (trace * trace - 4.0).sqrt())).ln() / period } else { 0.0 };
        let (mut motion, section) = machine.motion(&Start::default()).unwrap();
        settle(&mut motion, &section, 400).unwrap();
        let found = settled(&mut motion, &section, Some(16)).unwrap();
        assert_eq!(found.period, Some(1), "{period}");
        assert!((exponent_of(&found) - growth + 0.5 * c).abs() < EXACT, "{period}: {found:?} {growth}");
    }
}
