//! Springs and dashpots with curved forces: motions in closed form, energies, events.

use crate::common::assembled;
use std::f64::consts::PI;
use vibro_machine::derivative::{Extremes, Gradient};
use vibro_machine::file::{no_records, parse};
use vibro_machine::motion::{Event, EventKind, Motion, Reached};
use vibro_machine::{Differentiated, Quantity, What};

/// Tolerance on the difference from 50 digits, divided by the motion's amplification of a change
/// of its start: some tens of roundings of coordinates and rates of order 1 to 10.
const ROUNDINGS: f64 = 1e-13;

/// Rounding of a state after twenty periods, relative to its amplitudes; also the tolerance for
/// derivatives of an amplitude.
const RETURNED: f64 = 1e-12;
/// Tolerances for an amplitude of order 1, and for its derivatives: the rounding of a motion of a few
/// periods.
const AMPLITUDE: f64 = 1e-13;
const AMPLITUDE_BY_NUMBER: f64 = 1e-12;
/// Rounding of the energy accounts of order 100 J over a thousand events.
const BALANCED: f64 = 1e-11;
/// Largest number of series in a call. A period of a purely cubic spring takes about 20, but
/// thousands if sub-steps do not follow the motion's own time scale.
const SERIES: u64 = 60;
/// Rounding of the energy accounts over a hundred events, relative to the first energy.
const BALANCE: f64 = 1e-12;
/// Rounding of a displacement of order 0.1 m after a hundred events, amplified by the motion, m.
const PAUSED: f64 = 1e-11;
/// Relative tolerance for a central difference of motions: truncation, and rounding divided by the
/// shift.
const OF_DIFFERENCE: f64 = 1e-6;
/// Shift of an initial value, or relative shift of a parameter, for central differences: its
/// square, and rounding of 1e-15 divided by it, are below 1e-6.
const DIFFERENCE: f64 = 1e-6;

/// Largest difference of a derivative from 50 digits, relative to the largest of its column: the
/// magnification of roundings over up to 60 impacts.
const OF_DERIVATIVE: f64 = 1e-9;

/// Complete elliptic integral of the first kind by the arithmetic-geometric mean.
fn complete(m: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - m).sqrt());
    for _ in 0..40 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    PI / (2.0 * a)
}

/// An undamped body on a hardening spring returns to its start after 4 K(m)/W, at any scale, from
/// rest or from the middle, also if an unrelated body is far away and fast.
#[test]
fn closed_form_period_of_a_hardening_spring() {
    // m q'' + k q + c q³ = 0 from q = A: W² = (k + c A²)/m, parameter c A²/(2 m W²).
    let cases =
        [(2.0, 30.0, 500.0, 0.7), (1e-9, 0.0, 1e15, 5e-7), (1e6, 0.0, 1e-3, 20.0), (1e-3, 2e3, 3e11, 1e-4)];
    for (mass, k, c, amplitude) in cases {
        let stiffness = if k > 0.0 { format!("stiffness = {k}, ") } else { String::new() };
        let square = (k + c * amplitude * amplitude) / mass;
        let period = 4.0 * complete(c * amplitude * amplitude / (2.0 * mass * square)) / square.sqrt();
        // Starts: at rest at the largest displacement; at the middle with all energy kinetic.
        let fastest = amplitude * ((k + 0.5 * c * amplitude * amplitude) / mass).sqrt();
        for (start, speed) in [(amplitude, 0.0), (0.0, fastest)] {
            let text = format!(
                "name = \"Duffing\"\nbody.b = {{ mass = {mass:e}, start = {{ s = {start:e}, v = {speed:e} }} }}\n\
                 spring.k = {{ between = [\"ground\", \"b\"], {stiffness}cubic = {c:e} }}\n\
                 body.car = {{ mass = 1e3, start = {{ s = 100.0, v = 30.0 }} }}\n\
                 damper.d = {{ between = [\"ground\", \"car\"], damping = 0.1 }}\n"
            );
            let mut motion = Motion::new(assembled(&text)).expect("a motion").with_most_work(SERIES);
            for turn in 1..=20 {
                motion.advance_to(f64::from(turn) * period).expect("an end");
            }
            let [s, v, _] = motion.body(0);
            let off = ((s - start) / amplitude).abs().max(((v - speed) / fastest).abs());
            assert!(off < RETURNED, "{off:e} after 20 periods of {text}");
        }
    }
}

/// A chain with curved springs and dashpots, stops, friction and a drive: the energy accounts
/// balance, and pauses every 0.01 s change the motion only by rounding.
#[test]
fn invariant_energy_accounts_balance() {
    let text = "name = \"Chain\"\ngravity = 9.81\n\
        body.a = { mass = 2.0, gravity = 1.0, start = { s = 0.02, v = 1.5 } }\n\
        body.b = { mass = 1.0, gravity = 1.0, start = { v = -2.0 } }\n\
        body.c = { mass = 0.5, start = { s = 0.01 } }\n\
        spring.a = { between = [\"ground\", \"a\"], stiffness = 200.0, quadratic = -300.0, cubic = 4e4, damping = 0.3 }\n\
        spring.b = { between = [\"a\", \"b\"], stiffness = -50.0, cubic = 2e4, quintic = 1e6, preload = 1.0 }\n\
        spring.c = { between = [\"b\", \"c\"], quartic = -1e3, cubic = 3e4, stiffness = 100.0 }\n\
        damper.d = { between = [\"ground\", \"b\"], damping = -0.2, cubic = 0.8 }\n\
        stop.rigid = { between = [\"ground\", \"b\"], gap = 0.12, restitution = 0.7 }\n\
        stop.soft = { between = [\"a\", \"ground\"], gap = 0.05, stiffness = 2e4, damping = 20.0 }\n\
        friction.f = { between = [\"ground\", \"c\"], force = 0.6, static = 0.9 }\n\
        load.l = { on = \"a\", amplitude = 30.0, frequency = 2.3 }\n";
    let mut motion = Motion::new(assembled(text)).expect("a motion");
    let energy = |motion: &Motion| {
        let (k, p) = motion.kinetic_and_stored();
        k + p
    };
    let first = energy(&motion);
    let mut count = 0;
    motion.advance_observed(8.0, &mut |_| count += 1).expect("an end");
    let off = energy(&motion) - first - motion.energy().balance();
    assert!(count > 100 && off.abs() < BALANCE * first.abs(), "{count} events, {off}");
    // Pauses change the series, not the motion.
    let mut paused = Motion::new(assembled(text)).expect("a motion");
    (1..=800).for_each(|i| paused.advance_to(0.01 * f64::from(i)).expect("an end"));
    for i in 0..3 {
        let off = paused.body(i)[0] - motion.body(i)[0];
        assert!(off.abs() < PAUSED, "{i}: {off:e}");
    }
}

/// Random chains against Taylor series in 50 digits (`data/make_curved.py`): number of impacts,
/// and states up to the rounding that the motion has amplified.
#[test]
fn second_method_random_chains_in_fifty_digits() {
    let all = include_str!("data/curved.txt");
    for row in all.lines() {
        let fields: Vec<&str> = row.split(';').collect();
        let number = |text: &str| text.trim().parse::<f64>().expect("a number");
        let (end, impacts, factor) = (number(fields[1]), number(fields[2]), number(fields[3]));
        let mut motion = Motion::new(assembled(&fields[0].replace('|', "\n"))).expect("a motion");
        let mut count = 0.0;
        let mut observer =
            |event: &Event| count += f64::from(u8::from(matches!(event.kind, EventKind::Impact { .. })));
        motion.advance_observed(end, &mut observer).expect("an end");
        assert_eq!(count, impacts, "{row}");
        let bodies = fields[4].split(',').count() / 2;
        for (k, x) in fields[4].split(',').map(number).enumerate() {
            let own = motion.body(k % bodies)[k / bodies];
            let off = (own - x).abs() / factor.max(1.0);
            assert!(off < ROUNDINGS, "{own} {x} of {row}");
        }
    }
}

/// Variations over flights and impacts against differences of motions.
#[test]
fn second_method_variations_are_differences_of_motions() {
    let text = |shift: f64| {
        format!(
            "name = \"V\"\nbody.a = {{ mass = 1.0, start = {{ s = {:?}, v = 1.0 }} }}\n\
             body.b = {{ mass = 0.6, start = {{ v = -0.5 }} }}\n\
             spring.a = {{ between = [\"ground\", \"a\"], stiffness = 10.0, cubic = 60.0, damping = 0.1 }}\n\
             spring.b = {{ between = [\"a\", \"b\"], quadratic = -5.0, cubic = 90.0, quintic = 40.0 }}\n\
             damper.d = {{ between = [\"ground\", \"b\"], cubic = 0.2 }}\n\
             stop.s = {{ between = [\"ground\", \"b\"], gap = 0.3, restitution = 0.8 }}\n\
             load.l = {{ on = \"a\", amplitude = 4.0, frequency = 0.7 }}\n",
            0.1 + shift
        )
    };
    let end = |shift: f64| {
        let mut motion = Motion::new(assembled(&text(shift))).expect("a motion");
        motion.advance_to(3.0).expect("an end");
        motion.states()
    };
    let mut motion = Motion::new(assembled(&text(0.0))).expect("a motion");
    let mut variations = vec![motion.unit_variations()[0].clone()];
    let mut events = 0;
    while motion.advance_with(3.0, &mut variations).expect("an end") == Reached::Event {
        motion.pass_event_with(&mut variations).expect("a law");
        events += 1;
    }
    let (above, below) = (end(DIFFERENCE), end(-DIFFERENCE));
    assert!(events >= 2, "{events}");
    for (k, (a, b)) in above.iter().zip(&below).enumerate() {
        let (difference, own) = ((a - b) / (2.0 * DIFFERENCE), variations[0][k]);
        assert!((difference - own).abs() < OF_DIFFERENCE * own.abs().max(1.0), "{k}: {difference} {own}");
    }
}

/// Options that curved forces do not support are refused; the message names the element.
#[test]
fn refusals_name_the_element() {
    let duffing = "name = \"D\"\nbody.b = { mass = 1.0 }\n\
                   spring.k = { between = [\"ground\", \"b\"], cubic = 5.0 }\n";
    let refused = |from: &str, to: &str| {
        let text = duffing.replace(from, to);
        assert_ne!(text, duffing);
        parse(&text, "m.toml", &no_records).map(drop).expect_err("a refusal").to_string()
    };
    let falling = "start = \"rest\"\nspring.l = { between = [\"ground\", \"b\"], \
                   points = [[0.0, 0.0], [0.1, 1.0], [0.2, 0.5]] }\nbody.b";
    let found = refused("body.b", falling);
    assert!(found.contains("spring.l.points: falling lines cannot be combined with spring.k"), "{found}");
    let found = refused("cubic = 5.0", "cubic = \"5 N/m2\"");
    assert!(found.contains("spring.k.cubic = \"5 N/m2\"") && found.contains("N/m3"), "{found}");
    let found = refused("cubic = 5.0", "cubic = 5.0, slip = 3.0, stiffness = 1.0");
    assert!(found.contains("spring.k.cubic = 5.0: cannot be combined with `slip`"), "{found}");
    let found = refused("cubic = 5.0", "cubik = 5.0");
    assert!(found.contains("cubic"), "{found}");
}

/// The amplitude A of an undamped hardening oscillator follows from m v² = k A² + c A⁴/2.
#[test]
fn closed_form_derivatives_of_an_amplitude() {
    let (m, k, c, v) = (2.0f64, 30.0, 500.0, 3.0);
    let text = format!(
        "name = \"D\"\nbody.b = {{ mass = {m}, start = {{ v = {v} }} }}\n\
         spring.k = {{ between = [\"ground\", \"b\"], stiffness = {k}, cubic = {c} }}\n"
    );
    let columns = ["body.b.start.v", "body.b.mass", "spring.k.stiffness", "spring.k.cubic"];
    let mut motion = Differentiated::new(assembled(&text), &columns).expect("a motion");
    let mut extremes = [Extremes::new(Quantity::of_body(0, What::S))];
    motion.advance_with_extremes(3.0, &mut extremes, &mut |_, _| ()).expect("an end");
    let highest = extremes[0].highest().expect("an amplitude");
    let a = (((k * k + 2.0 * c * m * v * v).sqrt() - k) / c).sqrt();
    let force = k * a + c * a.powi(3);
    let exact = [m * v, 0.5 * v * v, -0.5 * a * a, -0.25 * a.powi(4)].map(|by| by / force);
    assert!((highest.value - a).abs() < AMPLITUDE, "{} {a}", highest.value);
    for (by, exact) in highest.by.iter().zip(exact) {
        let by = by.as_ref().expect("a derivative");
        assert!((by - exact).abs() < AMPLITUDE_BY_NUMBER, "{by} {exact}");
    }
}

/// Stops, friction and a drive over many events: no event is missed, because the tolerance for a
/// zero of an event function does not grow with the slope of the curved forces.
#[test]
fn invariant_energy_balances_over_many_events() {
    let text = "name = \"Chain\"\nbody.a = { mass = 1.0 }\nbody.b = { mass = 0.3 }\n\
        spring.a = { between = [\"ground\", \"a\"], stiffness = 40.0, cubic = 300.0, damping = 0.4 }\n\
        spring.b = { between = [\"a\", \"b\"], stiffness = 5.0, quadratic = 10.0, cubic = 200.0, damping = 0.1 }\n\
        damper.c = { between = [\"ground\", \"b\"], damping = 0.05, cubic = 0.3 }\n\
        stop.wall = { between = [\"ground\", \"b\"], gap = 0.3, restitution = 0.6 }\n\
        stop.soft = { between = [\"a\", \"ground\"], gap = 0.2, stiffness = 500.0, damping = 1.0 }\n\
        friction.f = { between = [\"ground\", \"a\"], force = 0.1 }\n\
        load.l = { on = \"a\", amplitude = 6.0, frequency = 1.1 }\n";
    let mut motion = Motion::new(assembled(text)).expect("a motion");
    let mut events = 0;
    for k in 1..=2000 {
        motion.advance_observed(0.05 * f64::from(k), &mut |_| events += 1).expect("an end");
    }
    let (kinetic, stored) = motion.kinetic_and_stored();
    let off = kinetic + stored - motion.energy().balance();
    assert!(events > 500 && off.abs() < BALANCED, "{events} events, off by {off:e} J");
}

/// A softening spring drives its body to infinity in finite time. The error names the spring, and
/// the motion keeps its last finite state.
#[test]
fn a_motion_that_ends_in_finite_time_says_so() {
    let text = "name = \"E\"\nbody.b = { mass = 1.0, start = { s = 1.5 } }\n\
                spring.k = { between = [\"ground\", \"b\"], stiffness = 1.0, cubic = -1.0 }\n";
    let mut motion = Motion::new(assembled(text)).expect("a motion");
    let error = motion.advance_to(100.0).expect_err("an end").to_string();
    assert!(error.contains("spring.k") && error.contains("finite time"), "{error}");
    assert!(motion.time() < 10.0 && motion.body(0).iter().all(|x| x.is_finite()), "{:?}", motion.body(0));
}

/// Rounding of the time at which a motion ends: the clock shows 1e-16 of it.
const END: f64 = 1e-14;

/// Dampers that accelerate, v' = v^p with v = 1 at first: v = (1 - (p - 1) t)^(1/(1 - p)) grows
/// without bounds until t = 1/(p - 1), at a finite place for p > 2.
#[test]
fn closed_form_end_of_motions_whose_rate_grows_without_bounds() {
    let dampers = [("quadratic", "", 2.0), ("cubic", "", 3.0), ("coefficient", ", exponent = 2.5", 2.5)];
    for (key, more, p) in dampers {
        let text = format!(
            "name = \"E\"\nbody.b = {{ mass = 1.0, start = {{ v = 1.0 }} }}\n\
             damper.d = {{ between = [\"ground\", \"b\"], {key} = -1.0{more} }}\n"
        );
        let mut motion = Motion::new(assembled(&text)).expect("a motion");
        let error = motion.advance_to(5.0).expect_err("an end").to_string();
        assert!(error.contains("damper.d") && error.contains("finite time"), "{error}");
        let off = motion.time() * (p - 1.0) - 1.0;
        assert!(off.abs() < END && motion.body(0).iter().all(|x| x.is_finite()), "{off:e} {error}");
    }
}

/// The load varies while the body hardly moves: it sticks, or its load begins with a power of
/// time.
#[test]
fn closed_form_bodies_at_rest_under_signals() {
    let text = "name = \"S\"\nbody.b = { mass = 1.0 }\n\
                spring.k = { between = [\"ground\", \"b\"], cubic = 5.0 }\n\
                friction.f = { between = [\"ground\", \"b\"], force = 3.0 }\n\
                load.l = { on = \"b\", amplitude = 2.0, frequency = 1.0 }\n";
    let mut motion = Motion::new(assembled(text)).expect("a motion");
    motion.advance_to(10.0).expect("an end");
    assert_eq!(motion.body(0), [0.0, 0.0, 0.0]);
    // The load begins as 3.75 t², and the spring is too weak to matter: s begins as 0.31 t⁴.
    let record = "[[0.0, 0.0], [0.5, 0.75], [1.0, 6.0]]";
    let text = format!(
        "name = \"R\"\nbody.b = {{ mass = 1.0 }}\n\
         spring.k = {{ between = [\"ground\", \"b\"], cubic = 1e-9 }}\n\
         load.l = {{ on = \"b\", table = {record}, interpolation = \"cubic\" }}\n"
    );
    let mut motion = Motion::new(assembled(&text)).expect("a motion");
    motion.advance_to(1.0).expect("an end");
    assert!(motion.body(0)[0] > 0.1, "{:?}", motion.body(0));
}

/// Derivatives of random chains by a parameter against differences in 50 digits
/// (`data/make_curved.py`).
#[test]
fn second_method_derivatives_by_numbers_are_differences_in_fifty_digits() {
    let mut worst = 0.0f64;
    for row in include_str!("data/curved_by.txt").lines() {
        let fields: Vec<&str> = row.split(';').collect();
        let number = |text: &str| text.trim().parse::<f64>().expect("a number");
        let assembly = assembled(&fields[0].replace('|', "\n"));
        let mut motion = Differentiated::new(assembly, &[fields[2]]).expect("a motion");
        motion.advance_to(number(fields[1])).expect("an end");
        let own = motion.state_derivative(0).expect("a derivative");
        let exact: Vec<f64> = fields[3].split(',').map(number).collect();
        let size = exact.iter().fold(0.0f64, |most, x| most.max(x.abs()));
        for (a, b) in own.iter().zip(&exact) {
            worst = worst.max((a - b).abs() / size);
            assert!((a - b).abs() <= OF_DERIVATIVE * size, "{own:?} {exact:?} by {row}");
        }
    }
    println!("{worst:e}");
}

/// The gradient of a sum, with derivatives by several numbers at once and a sticking friction,
/// against differences of motions.
#[test]
fn second_method_a_gradient_is_differences_of_sums() {
    let text = |cubic: f64, force: f64, gap: f64, frequency: f64| {
        format!(
            "name = \"G\"\nbody.a = {{ mass = 1.0, start = {{ v = 2.0 }} }}\nbody.b = {{ mass = 0.5 }}\n\
             spring.a = {{ between = [\"ground\", \"a\"], stiffness = 8.0, cubic = {cubic:?} }}\n\
             spring.b = {{ between = [\"a\", \"b\"], quadratic = -4.0, cubic = 70.0, stiffness = 20.0 }}\n\
             stop.soft = {{ between = [\"ground\", \"b\"], gap = {gap:?}, stiffness = 900.0, damping = 2.0 }}\n\
             friction.f = {{ between = [\"ground\", \"a\"], force = {force:?} }}\n\
             load.l = {{ on = \"b\", amplitude = 3.0, frequency = {frequency:?} }}\n"
        )
    };
    let start = [60.0, 1.2, 0.2, 0.9];
    let assembly = |x: &[f64]| assembled(&text(x[0], x[1], x[2], x[3]));
    let place = Quantity::of_body(1, What::S);
    let sum = |x: &[f64]| {
        let mut motion = Motion::new(assembly(x)).expect("a motion");
        let value = |k: u32| {
            motion.advance_to(0.2 * f64::from(k)).expect("an end");
            motion.value(place).powi(2)
        };
        (1..=15).map(value).sum::<f64>()
    };
    let names = ["spring.a.cubic", "friction.f.force", "stop.soft.gap", "load.l.frequency"];
    let mut found = Gradient::new(assembly(&start), &names).expect("a motion");
    for k in 1..=15 {
        found.advance_to(0.2 * f64::from(k)).expect("an end");
        found.add(place, 2.0 * found.motion().value(place));
    }
    for (j, own) in found.gradient().expect("a gradient").into_iter().enumerate() {
        let moved = |sign: f64| {
            let mut x = start;
            x[j] *= 1.0 + sign * DIFFERENCE;
            sum(&x)
        };
        let difference = (moved(1.0) - moved(-1.0)) / (2.0 * DIFFERENCE * start[j]);
        let own = own.expect("a derivative");
        assert!((difference - own).abs() < OF_DIFFERENCE * own.abs().max(1.0), "{j}: {difference} {own}");
    }
}

/// A prescribed body stands still after the last knot of its record: the knot is not missed,
/// wherever the last sub-step before it ends.
#[test]
fn invariant_energy_balances_after_the_last_knot_of_a_record() {
    let text = "name = \"T\"\nbody.b0 = { mass = 0.168023, start = { s = -0.0006827272, v = -0.001386739 } }\n\
        body.b1 = { inertia = 4.087269e-07, start = { s = -0.359365, v = 1.699337 } }\n\
        body.b2 = { motion = { table = [[0.02496103, 3.912137e-05], [0.07488308, -0.0005101811], \
        [0.1248051, 0.0003322196]], interpolation = \"cubic\" } }\n\
        spring.e0 = { between = [\"ground\", \"b0\"], stiffness = 418.8237 }\n\
        spring.e1 = { arms = { b0 = 1.3, b1 = \"0.001330862 m\" }, cubic = -11879160.0, \
        quintic = 91750470000000.0, damping = 0.00674637 }\n\
        spring.e2 = { arms = { b1 = \"0.001330862 m\" }, stiffness = 161.525, quartic = -54027570000.0 }\n\
        spring.e3 = { arms = { b1 = \"0.001330862 m\", b2 = -0.6 }, stiffness = -216.0457, cubic = 458676800.0 }\n\
        spring.e4 = { arms = { b1 = \"-0.001330862 m\", b0 = 1.0 }, quintic = 247765200000000.0, \
        damping = 0.01380835 }\n\
        load.l0 = { on = \"b0\", constant = -0.07968722, steps = [[0.03244933, 0.07340087]] }\n";
    let state = [0.000225213406241421, -0.31182452831209273, -0.05864380383214766, -35.29264294729204];
    let mut off = 0.0f64;
    for k in 0..20 {
        let begin = 0.1247 + 1e-6 * f64::from(k);
        let mut motion = Motion::from_state(assembled(text), begin, &state).expect("a motion");
        let energy = |motion: &Motion| motion.kinetic_and_stored().0 + motion.kinetic_and_stored().1;
        let first = energy(&motion);
        motion.advance_to(0.1303).expect("an end");
        off = off.max((energy(&motion) - first - motion.energy().balance()).abs() / first);
    }
    assert!(off < BALANCE, "{off:e}");
}
