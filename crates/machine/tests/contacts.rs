//! Contacts with an exponent and a dissipation, and powers with two sides.

use crate::common::assembled;
use vibro_machine::derivative::Extremes;
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::{Event, EventKind, Motion, Reached};
use vibro_machine::{Assembly, Description, Differentiated, Quantity, What};

/// Γ(7/5)/Γ(9/10) √π from 40 digits: the duration of a Hertz impact is 2 xₘ/v times this.
const HERTZ: f64 = 1.471_637_592_162_352_3;
/// Relative rounding of a duration and a depth after some hundred series.
const IMPACT: f64 = 1e-13;

/// A body meets a Hertz contact without other forces: the duration 2 xₘ/v √π Γ(7/5)/Γ(9/10), and
/// the depth xₘ = (5 m v²/(4 k))^(2/5), in machines of any scale.
#[test]
fn closed_form_duration_and_depth_of_a_hertz_impact() {
    for (mass, k, v) in [(0.3_f64, 2e6_f64, 1.7_f64), (1e-3, 1e9, 20.0), (2e3, 1e4, 0.01)] {
        let text = format!(
            "name = \"Hertz\"\nbody.b = {{ mass = {mass:e}, start = {{ v = {v} }} }}\n\
             stop.h = {{ between = [\"ground\", \"b\"], gap = 0.0, stiffness = {k:e}, exponent = 1.5 }}\n"
        );
        let depth = (1.25 * mass * v * v / k).powf(0.4);
        let duration = 2.0 * depth / v * HERTZ;
        let mut motion = Motion::new(assembled(&text)).expect("a motion");
        motion.advance_to(0.5 * duration).expect("an end");
        let off = (motion.body(0)[0] / depth - 1.0).abs();
        assert!(off < IMPACT, "{off:e} of the depth in {text}");
        let mut times = Vec::new();
        let mut note = |event: &Event| {
            if let EventKind::Free { .. } = event.kind {
                times.push(event.time);
            }
        };
        motion.advance_observed(2.0 * duration, &mut note).expect("an end");
        let off = (times[0] / duration - 1.0).abs();
        assert!(times.len() == 1 && off < IMPACT, "{off:e} of the duration in {text}");
        let off = (motion.body(0)[1] / v + 1.0).abs();
        assert!(off < IMPACT, "{off:e} of the speed in {text}");
    }
}

/// Tolerance for the invariant of a contact, relative to its terms.
const INVARIANT: f64 = 1e-13;

/// Without other forces v/d - ln(1 + d v)/d² with d = 3/2 c has the same value before and after a
/// contact of Hunt and Crossley, whatever its exponent and stiffness. The loss is the account's.
#[test]
fn invariant_of_hunt_and_crossley() {
    for exponent in [1.0, 1.25, 1.5, 2.0, 2.2, 3.0] {
        for dissipation in [1e-4, 0.05, 0.4, 3.0] {
            let (mass, v) = (0.7, 2.0);
            let text = format!(
                "name = \"H\"\nbody.b = {{ mass = {mass}, start = {{ v = {v} }} }}\n\
                 stop.h = {{ between = [\"ground\", \"b\"], gap = 0.001, stiffness = 3e5, \
                 exponent = {exponent}, dissipation = {dissipation} }}\n"
            );
            let mut motion = Motion::new(assembled(&text)).expect("a motion");
            let mut events = 0;
            motion.advance_observed(1.0, &mut |_| events += 1).expect("an end");
            let after = motion.body(0)[1];
            let d = 1.5 * dissipation;
            let term = |v: f64| (v / d, (d * v).ln_1p() / (d * d));
            let (one, other) = (term(v), term(after));
            let off = (one.0 - one.1 - other.0 + other.1).abs();
            assert!(events == 2 && off < INVARIANT * one.0, "{off:e} with {exponent}, {dissipation}");
            let lost = 0.5 * mass * (v * v - after * after);
            let off = (motion.energy().stops[0].value() - lost).abs();
            assert!(off < INVARIANT * mass * v * v, "{off:e} J with {exponent}, {dissipation}");
        }
    }
}

/// Rounding of places and speeds of order 1 to 10.
const DROP: f64 = 2e-14;

/// A body thrown upwards with drag c v |v| turns and falls: √(m g/c) tan, then tanh and ln cosh.
#[test]
fn closed_form_drop_with_drag() {
    let (m, g, c) = (2.0_f64, 9.81, 0.8);
    for power in ["quadratic = 0.8", "coefficient = 0.8, exponent = 2"] {
        for up in [0.0, 6.0] {
            let text = format!(
                "name = \"Drop\"\ngravity = {g}\n\
                 body.b = {{ mass = {m}, gravity = 1.0, start = {{ v = -{up:?} }} }}\n\
                 damper.air = {{ between = [\"ground\", \"b\"], {power} }}\n"
            );
            let mut motion = Motion::new(assembled(&text)).expect("a motion");
            let (last, pace) = ((m * g / c).sqrt(), (g * c / m).sqrt());
            let top = (up / last).atan() / pace;
            let height = (m / c) * 0.5 * (up / last).powi(2).ln_1p();
            for time in [0.3 * top, 0.9 * top, top, top + 0.01, top + 0.7, top + 3.0] {
                motion.advance_to(time).expect("an end");
                let later = pace * (time - top);
                let (s, v) = match later < 0.0 {
                    true => (-height - (m / c) * later.cos().ln(), last * later.tan()),
                    false => (-height + (m / c) * later.cosh().ln(), last * later.tanh()),
                };
                let off = (motion.body(0)[0] - s).abs().max((motion.body(0)[1] - v).abs());
                assert!(off < DROP, "{off:e} at {time} of {top} with {power}");
            }
            let (kinetic, stored) = motion.kinetic_and_stored();
            let off = kinetic + stored - 0.5 * m * up * up - motion.energy().balance();
            assert!(off.abs() < DROP * m * g, "{off:e} J");
        }
    }
}

/// Rounding of a state after five periods, relative to its amplitudes.
const RETURNED: f64 = 1e-12;

/// A body on a spring c e |e|^(p-1) returns after √(m/c) A^((1 - p)/2) times
/// 4 √((p + 1)/2) √π Γ(1 + 1/(p + 1))/Γ(1/2 + 1/(p + 1)), computed in 25 digits.
#[test]
fn closed_form_period_of_a_power_spring() {
    let cases = [
        (2.0, 6.869_261_369_017_644),
        (1.5, 6.581_363_388_638_263),
        (2.7, 7.255_999_605_305_385),
        (4.0, 7.929_288_693_456_797),
        (3.0, 7.416_298_709_205_488),
    ];
    for (exponent, factor) in cases {
        for (mass, c, amplitude) in [(2.0_f64, 300.0_f64, 0.3_f64), (1e-3, 1e6, 1e-5)] {
            let period = (mass / c).sqrt() * amplitude.powf(0.5 * (1.0 - exponent)) * factor;
            let text = format!(
                "name = \"P\"\nbody.b = {{ mass = {mass:e}, start = {{ s = {amplitude:e} }} }}\n\
                 spring.k = {{ between = [\"ground\", \"b\"], coefficient = {c:e}, exponent = {exponent:?} }}\n"
            );
            let mut motion = Motion::new(assembled(&text)).expect("a motion");
            motion.advance_to(5.0 * period).expect("an end");
            let [s, v, _] = motion.body(0);
            let off = (s / amplitude - 1.0).abs().max((v * period / amplitude).abs());
            assert!(off < RETURNED, "{off:e} with the exponent {exponent}");
        }
    }
}

/// Tolerances for states and times against 40 digits, divided by the motion's magnification: some
/// tens of roundings.
const ROUNDINGS: f64 = 1e-13;

/// Balls and chains on contacts with several exponents, dissipation and dashpots, and odd powers,
/// against Taylor series in 40 digits (`data/make_contacts.py`).
#[test]
fn second_method_contacts_in_forty_digits() {
    for row in include_str!("data/contacts.txt").lines() {
        let fields: Vec<&str> = row.split(';').collect();
        let number = |text: &str| text.trim().parse::<f64>().expect("a number");
        let numbers = |text: &str| text.split(',').filter(|x| !x.is_empty()).map(number).collect::<Vec<_>>();
        let (exact_times, exact, factor) = (numbers(fields[3]), numbers(fields[4]), number(fields[5]));
        let mut motion = Motion::new(assembled(&fields[0].replace('|', "\n"))).expect("a motion");
        let (kinetic, stored) = motion.kinetic_and_stored();
        let mut times = Vec::new();
        motion.advance_observed(number(fields[1]), &mut |event| times.push(event.time)).expect("an end");
        assert_eq!(times.len(), exact_times.len(), "{row}");
        for (own, exact) in times.iter().zip(&exact_times) {
            assert!((own - exact).abs() < ROUNDINGS * factor.max(1.0), "{own} {exact} of {row}");
        }
        let bodies = exact.len() / 2;
        for (k, x) in exact.iter().enumerate() {
            let off = (motion.body(k % bodies)[k / bodies] - x).abs() / factor.max(1.0);
            assert!(off < ROUNDINGS, "{off:e} of {x} in {row}");
        }
        let (now, kept) = motion.kinetic_and_stored();
        let off = now + kept - kinetic - stored - motion.energy().balance();
        assert!(off.abs() < ROUNDINGS, "{off:e} J in {row}");
    }
}

/// Largest difference of a derivative from 40 digits, relative to the largest of its column.
const OF_DERIVATIVE: f64 = 1e-10;

/// Derivatives of contacts and odd powers by their numbers against differences in 48 digits.
#[test]
fn second_method_derivatives_of_contacts_by_numbers() {
    for row in include_str!("data/contacts_by.txt").lines() {
        let fields: Vec<&str> = row.split(';').collect();
        let number = |text: &str| text.trim().parse::<f64>().expect("a number");
        let assembly = assembled(&fields[0].replace('|', "\n"));
        let mut motion = Differentiated::new(assembly, &[fields[2]]).expect("a motion");
        motion.advance_to(number(fields[1])).expect("an end");
        let own = motion.state_derivative(0).expect("a derivative");
        let exact: Vec<f64> = fields[3].split(',').map(number).collect();
        let size = exact.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        for (a, b) in own.iter().zip(&exact) {
            let off = (a - b).abs() / size;
            assert!(off <= OF_DERIVATIVE, "{off:e}: {own:?} {exact:?} by {} of {}", fields[2], fields[0]);
        }
    }
}

/// Tolerance for derivatives of order 1 relative to their values, after one contact.
const BY_NUMBER: f64 = 1e-11;

/// After a Hertz impact at the time T ∝ k^(-2/5) m^(2/5) v^(-1/5) the place is g - v (t - g/v - T).
/// The largest depth (5 m v²/(4 k))^(2/5) has derivatives in closed form as well.
#[test]
fn closed_form_derivatives_of_a_hertz_impact() {
    let (m, k, v, gap, end) = (0.4_f64, 5e6_f64, 1.3_f64, 0.01, 0.02);
    let text = format!(
        "name = \"H\"\nbody.b = {{ mass = {m}, start = {{ v = {v} }} }}\n\
         stop.h = {{ between = [\"ground\", \"b\"], gap = {gap}, stiffness = {k}, exponent = 1.5, dissipation = 0 }}\n"
    );
    let names = ["stop.h.stiffness", "stop.h.gap", "body.b.mass", "body.b.start.v"];
    let mut motion = Differentiated::new(assembled(&text), &names).expect("a motion");
    let mut extremes = [Extremes::new(Quantity::of_body(0, What::S))];
    motion.advance_with_extremes(end, &mut extremes, &mut |_, _| ()).expect("an end");
    let depth = (1.25 * m * v * v / k).powf(0.4);
    let duration = 2.0 * depth / v * HERTZ;
    let by_v = -(end - gap / v - duration) - gap / v - 0.2 * duration;
    let exact = [-0.4 * v * duration / k, 2.0, 0.4 * v * duration / m, by_v];
    for (p, exact) in exact.into_iter().enumerate() {
        let own = motion.derivative(Quantity::of_body(0, What::S), p).expect("a derivative");
        assert!((own / exact - 1.0).abs() < BY_NUMBER, "{own} {exact} by {}", names[p]);
    }
    let highest = extremes[0].highest().expect("a depth");
    let exact = [-0.4 * depth / k, 1.0, 0.4 * depth / m, 0.8 * depth / v];
    for (p, exact) in exact.into_iter().enumerate() {
        let own = *highest.by[p].as_ref().expect("a derivative");
        assert!((own / exact - 1.0).abs() < BY_NUMBER, "{own} {exact} of the depth by {}", names[p]);
    }
}

/// Rounding of the momentum and the energy of a chain, relative to their first values.
const KEPT: f64 = 1e-13;

/// Beads that touch one another with Hertz contacts: a blow passes through the chain. Momentum and
/// energy stay, with gaps and with beads that touch without force at the start.
#[test]
fn invariant_momentum_and_energy_of_beads() {
    for gap in [0.0, 1e-5] {
        let count = 8;
        let mut text = "name = \"Beads\"\n".to_string();
        for i in 0..count {
            let v = if i == 0 { 1.2 } else { 0.0 };
            text +=
                &format!("body.b{i} = {{ mass = {}, start = {{ v = {v:?} }} }}\n", 0.05 + 0.01 * i as f64);
        }
        for i in 1..count {
            text += &format!(
                "stop.c{i} = {{ between = [\"b{i}\", \"b{}\"], gap = {gap:e}, stiffness = 8e9, exponent = 1.5 }}\n",
                i - 1
            );
        }
        let mut motion = Motion::new(assembled(&text)).expect("a motion");
        let momentum = |motion: &Motion| -> f64 {
            (0..count).map(|i| (0.05 + 0.01 * i as f64) * motion.body(i)[1]).sum()
        };
        let (first, energy) = (momentum(&motion), motion.kinetic_and_stored().0);
        let mut events = 0;
        for k in 1..=40 {
            motion.advance_observed(2e-5 * f64::from(k), &mut |_| events += 1).expect("an end");
            let (kinetic, stored) = motion.kinetic_and_stored();
            let off = (momentum(&motion) / first - 1.0).abs().max(((kinetic + stored) / energy - 1.0).abs());
            assert!(off < KEPT, "{off:e} with the gap {gap}");
        }
        assert!(events >= count, "{events}");
        assert!(motion.body(count - 1)[1] > 0.5, "the blow arrives");
    }
}

/// Largest |e| at the time of an edge, m: the last digit of a time near 100 s, 1.4e-14 s, times a
/// speed of 2 m/s.
const AT_EDGE: f64 = 5e-14;

/// A body in a forced motion of period 0.5 s touches a contact with dissipation once a period.
/// Each contact begins and ends at e = 0, also after hundreds of them: what counts as zero does
/// not grow with the count of contacts.
#[test]
fn invariant_contacts_end_at_their_edge() {
    for (stiffness, per_period) in [(1e5, 1.0), (1e9, 1.5)] {
        let text = format!(
            "name = \"R\"\nbody.a = {{ mass = 1.0, start = {{ s = -0.1, v = 1.0 }} }}\n\
             spring.k = {{ between = [\"ground\", \"a\"], stiffness = 100.0 }}\n\
             load.f = {{ on = \"a\", amplitude = 8.0, frequency = 2.0 }}\n\
             stop.h = {{ between = [\"ground\", \"a\"], gap = 0.0, stiffness = {stiffness:e}, \
             exponent = 1.5, dissipation = 0.2 }}\n"
        );
        let (mut motion, until) = (Motion::new(assembled(&text)).expect("a motion"), 100.0);
        let mut ends = Vec::new();
        let mut note = |event: &Event| {
            if matches!(event.kind, EventKind::Press { .. } | EventKind::Free { .. }) {
                ends.push(event.clone());
            }
        };
        let reached = motion.advance_observed(until, &mut note);
        assert!(reached.is_ok(), "{reached:?} in {text}");
        let (contacts, expected) = (ends.len() / 2, per_period * until / 0.5);
        assert_eq!(contacts as f64, expected, "contacts in {text}");
        for pair in ends.chunks(2) {
            let kinds = pair.iter().map(|event| matches!(event.kind, EventKind::Press { .. }));
            assert!(kinds.eq([true, false]), "{pair:?} in {text}");
        }
        let mut motion = Motion::new(assembled(&text)).expect("a motion");
        for event in &ends {
            motion.advance_to(event.time).expect("an end");
            let off = motion.body(0)[0].abs();
            assert!(off < AT_EDGE, "e = {off:e} m at {} s in {text}", event.time);
        }
    }
}

/// Rounding of the energy accounts of order 10 J over some tens of events, J.
const BALANCED: f64 = 1e-12;

/// A contact with much dissipation lets go before the edge when its body is pulled away: it has no
/// force from there on, and what it still stores is lost.
#[test]
fn invariant_a_contact_never_pulls() {
    let text = "name = \"Pull\"\nbody.b = { mass = 0.2, start = { v = 1.0 } }\n\
                stop.h = { between = [\"ground\", \"b\"], gap = 0.0, stiffness = 4e4, exponent = 1.5, dissipation = 2.5 }\n\
                load.l = { on = \"b\", amplitude = 40.0, frequency = 20.0, phase = 0.4 }\n\
                spring.k = { between = [\"ground\", \"b\"], stiffness = 400.0 }\n";
    let mut motion = Motion::new(assembled(text)).expect("a motion");
    let (kinetic, stored) = motion.kinetic_and_stored();
    let (mut frees, mut inside) = (0, 0);
    let stop = motion.assembly().description.elements().position(|own| own.dotted() == "stop.h");
    let stop = Quantity::of_element(stop.expect("the stop"), What::F);
    for k in 1..=4000 {
        let mut places = Vec::new();
        let mut note = |event: &Event| {
            if let EventKind::Free { .. } = event.kind {
                places.push(event.time);
            }
        };
        motion.advance_observed(5e-4 * f64::from(k), &mut note).expect("an end");
        frees += places.len();
        let f = motion.value(stop);
        inside += usize::from(motion.body(0)[0] > 1e-9 && f == 0.0);
        assert!(f >= 0.0, "{f}");
    }
    let (now, kept) = motion.kinetic_and_stored();
    let off = now + kept - kinetic - stored - motion.energy().balance();
    assert!(frees > 10 && inside > 0, "{frees} {inside}");
    assert!(off.abs() < BALANCED, "{off:e} J");
}

/// Variations are the limit of differences of motions, relative.
const OF_DIFFERENCE: f64 = 1e-6;

/// Variations of the start over Hertz contacts and odd powers against central differences.
#[test]
fn second_method_variations_are_differences() {
    let text = |s: f64, v: f64| {
        format!(
            "name = \"V\"\ngravity = 9.81\nbody.b = {{ mass = 0.3, gravity = 1.0, start = {{ s = {s:?}, v = {v:?} }} }}\n\
             stop.h = {{ between = [\"ground\", \"b\"], gap = 0.02, stiffness = 2e6, exponent = 1.5, dissipation = 0.2 }}\n\
             damper.air = {{ between = [\"ground\", \"b\"], quadratic = 0.1 }}\n"
        )
    };
    let end = |s: f64, v: f64| {
        let mut motion = Motion::new(assembled(&text(s, v))).expect("a motion");
        motion.advance_to(0.3).expect("an end");
        motion.body(0)
    };
    let mut motion = Motion::new(assembled(&text(0.0, 0.1))).expect("a motion");
    let mut variations = motion.unit_variations();
    while motion.advance_with(0.3, &mut variations).expect("an end") == Reached::Event {}
    let h = 1e-7;
    let by_s = [0, 1].map(|k| (end(h, 0.1)[k] - end(-h, 0.1)[k]) / (2.0 * h));
    let by_v = [0, 1].map(|k| (end(0.0, 0.1 + h)[k] - end(0.0, 0.1 - h)[k]) / (2.0 * h));
    for (own, exact) in variations.iter().zip([by_s, by_v]) {
        for (a, b) in own.iter().zip(exact) {
            assert!((a - b).abs() < OF_DIFFERENCE * (1.0 + b.abs()), "{own:?} {exact:?}");
        }
    }
}

/// Keys that exclude one another, and numbers out of range, are refused by name.
#[test]
fn refused_contacts_and_powers() {
    let text = "name = \"R\"\nbody.b = { mass = 1.0 }\n\
                spring.k = { between = [\"ground\", \"b\"], coefficient = \"5 N/m^1.5\", exponent = 1.5 }\n\
                damper.d = { between = [\"ground\", \"b\"], quadratic = \"0.2 N s2/m2\" }\n\
                stop.h = { between = [\"ground\", \"b\"], gap = 0.1, stiffness = \"2e9 N/m^1.5\", exponent = 1.5, \
                dissipation = \"0.1 s/m\" }\n";
    parse(text, "m.toml", &no_records).expect("a machine");
    let refused = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        parse(&text.replace(from, to), "m.toml", &no_records).expect_err(to).to_string()
    };
    let cases = [
        (
            "stiffness = \"2e9 N/m^1.5\"",
            "stiffness = \"2e9 N/m\"",
            "stop.h.stiffness = \"2e9 N/m\": cannot be in `N/m`; expected one of N/m1.5",
        ),
        (
            "exponent = 1.5, dissipation",
            "exponent = 0.5, dissipation",
            "stop.h.exponent = 0.5: expected a number from 1 to 20",
        ),
        (
            "exponent = 1.5, dissipation",
            "exponent = \"= 3/4\", dissipation",
            "stop.h.exponent = \"= 3/4\": is 0.75; expected a number from 1 to 20",
        ),
        (
            "dissipation = \"0.1 s/m\"",
            "dissipation = 0.1, damping = 3.0",
            "stop.h.dissipation = 0.1: cannot be combined with `damping`",
        ),
        (
            "dissipation = \"0.1 s/m\"",
            "dissipation = -0.1",
            "stop.h.dissipation = -0.1: must not be negative",
        ),
        (
            "dissipation = \"0.1 s/m\"",
            "law = \"pull\"",
            "stop.h.law = \"pull\": cannot be combined with `exponent`; expected \"no-pull\"",
        ),
        (
            "stiffness = \"2e9 N/m^1.5\"",
            "restitution = 0.5",
            "stop.h.exponent = 1.5: cannot be combined with `restitution`",
        ),
        (
            "stiffness = \"2e9 N/m^1.5\"",
            "stiffness = { constant = 3.0, steps = [[1.0, 2.0]] }",
            "a stiffness that steps in time cannot be combined with `exponent`",
        ),
        (
            "coefficient = \"5 N/m^1.5\"",
            "coefficient = \"5 N/m^2.5\"",
            "spring.k.coefficient = \"5 N/m^2.5\"",
        ),
        (
            "coefficient = \"5 N/m^1.5\", exponent = 1.5 }",
            "coefficient = \"5 N/m^2.2\", exponent = 2.3 }",
            "its unit has the power 2.2; expected the exponent 2.3",
        ),
        (
            "coefficient = \"5 N/m^1.5\", exponent = 1.5 }",
            "coefficient = 5, exponent = 0.9 }",
            "spring.k.exponent = 0.9: expected a number from 1 to 20",
        ),
        (
            "coefficient = \"5 N/m^1.5\", exponent = 1.5 }",
            "coefficient = 5, exponent = 1.5, slip = 3.0, stiffness = 1.0 }",
            "spring.k.coefficient = 5: cannot be combined with `slip`",
        ),
        (
            "coefficient = \"5 N/m^1.5\", exponent = 1.5 }",
            "exponent = 1.5 }",
            "spring.k.exponent = 1.5: requires `coefficient`: the force is coefficient * |x|^exponent",
        ),
        (
            "stop.h = ",
            "friction.f = { between = [\"ground\", \"b\"], follows = \"h\", coefficient = 0.2 }\nstop.h = ",
            "friction.f.follows = \"h\": friction at a stop with `exponent` or `dissipation` is not supported",
        ),
    ];
    for (from, to, said) in cases {
        let found = refused(from, to);
        assert!(found.contains(said), "{found}\ninstead of\n{said}");
    }
}

/// A machine written as a file is read as the same machine, and completions have the new keys.
#[test]
fn round_trip_of_contacts_and_powers() {
    let text = "name = \"R\"\nbody.b = { mass = 1.0 }\n\
                spring.k = { between = [\"ground\", \"b\"], cubic = 3.0, coefficient = 5.0, exponent = 1.75 }\n\
                damper.d = { between = [\"ground\", \"b\"], quadratic = 0.2, coefficient = 3.0, exponent = 2.5 }\n\
                stop.h = { between = [\"ground\", \"b\"], gap = 0.1, stiffness = \"= k_h\", exponent = 1.5, dissipation = \"= c_h\" }\n\
                stop.i = { between = [\"b\", \"ground\"], gap = 0.1, stiffness = 3.0, exponent = 2.5, damping = 2.0 }\n\
                [parameters]\nk_h = \"3 GN/m^1.5\"\nc_h = \"0.2 s/m\"\n";
    let description = parse(text, "m.toml", &no_records).expect("a machine");
    assert_eq!(description.stops[0].contact.map(|own| own.dissipation), Some(Some(0.2)));
    let written = description.to_toml();
    let again = parse(&written, "again.toml", &no_records).expect(&written);
    assert_eq!(description, again, "{written}");
    let typed = text.split("dissipation").next().unwrap_or_default();
    let offers = vibro_machine::file::completion(&format!("{typed}diss"), "").offers;
    assert_eq!(offers, [("dissipation".to_string(), "dissipation = ".to_string())]);
}

/// Exponents by a named parameter: the parameter is set and varied, and the file keeps it. A motion
/// has no derivative by it.
#[test]
fn invariant_exponents_follow_parameters() {
    let text = |exponent: &str| {
        format!(
            "name = \"P\"\nbody.b = {{ mass = 1.0, start = {{ s = 0.1, v = 0.5 }} }}\n\
             spring.k = {{ between = [\"ground\", \"b\"], coefficient = 40.0, exponent = {exponent} }}\n\
             damper.d = {{ between = [\"ground\", \"b\"], coefficient = 0.2, exponent = {exponent} }}\n\
             stop.h = {{ between = [\"ground\", \"b\"], gap = 0.11, stiffness = 9e3, exponent = {exponent} }}\n\
             parameters.p = 1.5\n"
        )
    };
    let follows = parse(&text("\"= p\""), "m.toml", &no_records).expect("a machine");
    assert_eq!(follows, parse(&follows.to_toml(), "m.toml", &no_records).expect("the same machine"));
    let end = |d: Description| {
        let mut motion = Motion::new(Assembly::new(d).expect("a machine").into()).expect("a motion");
        motion.advance_to(1.0).expect("an end");
        motion.states()
    };
    for p in [1.0, 1.5, 2.0, 2.2] {
        let own = parse(&text(&format!("{p:?}")), "m.toml", &no_records).expect("a machine");
        let (found, own) = (end(follows.with([("p", p)]).expect("a machine")), end(own));
        assert!(found.iter().zip(&own).all(|(a, b)| (a - b).abs() < IMPACT), "{p}: {found:?} {own:?}");
    }
    let refused = follows.with([("p", 0.5)]).expect_err("a refusal").to_string();
    assert!(refused.contains("p = 0.5: then"), "{refused}");
    let assembly = Assembly::new(follows).expect("a machine");
    let refused = Differentiated::new(assembly.into(), &["p"]).err().expect("a refusal").to_string();
    assert!(refused.contains("no derivative with respect to"), "{refused}");
}

/// Powers with the exponent 1 are stiffness and damping, also in derivatives by their coefficients.
#[test]
fn invariant_the_exponent_1_is_straight() {
    let text = |spring: &str, damper: &str| {
        format!(
            "name = \"S\"\nbody.b = {{ mass = 1.0, start = {{ s = 0.1, v = 0.5 }} }}\n\
             spring.k = {{ between = [\"ground\", \"b\"], {spring} }}\n\
             damper.d = {{ between = [\"ground\", \"b\"], {damper} }}\n\
             stop.w = {{ between = [\"ground\", \"b\"], gap = 0.11, restitution = 0.6 }}\n"
        )
    };
    let power = text("stiffness = 15.0, coefficient = 25.0, exponent = 1", "coefficient = 0.2, exponent = 1");
    let end = |text: &str, names: &[&str]| {
        let mut motion = Differentiated::new(assembled(text), names).expect("a motion");
        motion.advance_to(3.0).expect("an end");
        let energy = motion.motion().energy().balance();
        (motion.motion().states(), [0, 1].map(|p| motion.state_derivative(p).expect("a derivative")), energy)
    };
    let own = end(&power, &["spring.k.coefficient", "damper.d.coefficient"]);
    let straight = text("stiffness = 40.0", "damping = 0.2");
    assert_eq!(own, end(&straight, &["spring.k.stiffness", "damper.d.damping"]));
}
