//! Stiff machines, which take long sub-steps while no event is near.

use crate::common::*;
use std::f64::consts::TAU;
use vibro_machine::description::*;
use vibro_machine::motion::EventKind;
use vibro_machine::{Error, Motion};

/// Rounding of a state of order one over some hundred radians.
const ROUNDING: f64 = 1e-13;
/// Difference of two integrations with rates of 1e3/s over a thousand radians: a rounding of the
/// fast motion in each of thousands of sub-steps, amplified by impacts.
const TWO_WAYS: f64 = 1e-10;

/// Relative error of a loss: the decay of the fast motion, 500/s at 1e9 rad/s, changes its mean,
/// and 1e9 sub-steps round it.
const LOST: f64 = 1e-7;

/// Errors of coordinate and speed of the midpoint of two bodies 1 m from the origin: roundings of
/// the coordinates, 1e-16, and of the buffer's 100 m/s2 times a sub-step, in 2e4 sub-steps.
const MIDDLE: [f64; 2] = [1e-12, 1e-11];

/// Two bodies of mass 1 on springs to the ground, with a spring between them.
fn pair(soft: f64, stiff: f64, damping: f64, start: (f64, f64)) -> Description {
    Description {
        bodies: vec![body("slow", 1.0, start.0, start.1), body("fast", 1.0, 0.0, 0.0)],
        springs: vec![
            spring(&[(0, 1.0)], soft, 0.0),
            spring(&[(1, 1.0)], stiff, damping),
            spring(&[(0, -1.0), (1, 1.0)], 1.0, 0.0),
        ],
        ..Description::default()
    }
}

#[test]
fn closed_form_two_undamped_oscillators_far_apart_in_frequency() {
    // M = 1 and K = [soft + 1, -1; -1, stiff + 1]: the slow frequency from the product of the
    // quadratic's roots, without cancellation. The fast frequency would need up to 5e11 ordinary
    // sub-steps.
    for (stiff, end) in [(1e8, 100.0), (1e14, 100.0), (1e20, 50.0)] {
        let (soft, start) = (39.5, 0.04);
        let mut motion = motion(pair(soft, stiff, 0.0, (start, 0.0)));
        let (kinetic, stored) = motion.kinetic_and_stored();
        motion.advance_to(end).unwrap();
        let (a, b) = (soft + 1.0, stiff + 1.0);
        let fast = 0.5 * (a + b) + 0.5 * ((b - a).powi(2) + 4.0f64).sqrt();
        let slow = (a * b - 1.0) / fast;
        // The slow mode shape (1, share), the fast one (-share, 1), and their parts of the start.
        let share = 1.0 / (b - slow);
        let part = start / (1.0 + share * share);
        let angle = slow.sqrt() * end;
        let exact = part * angle.cos();
        let rest = part * share * share; // the fast part of the slow body's motion
        let [s, v, _] = motion.body(0);
        assert!((s - exact).abs() <= ROUNDING + rest, "{stiff:e}: {:e}", s - exact);
        assert!(
            (v + part * slow.sqrt() * angle.sin()).abs() <= 10.0 * ROUNDING + rest * fast.sqrt(),
            "{stiff:e}: {v}"
        );
        let after = motion.kinetic_and_stored();
        let change = after.0 + after.1 - kinetic - stored;
        // Energy is quadratic in the state.
        assert!(change.abs() <= 2.0 * ROUNDING * stored, "{stiff:e}: {change:e} of {stored:e}");
    }
}

/// The tie of the pair in [`tied`].
#[derive(Clone, Copy, Debug, PartialEq)]
enum Tie {
    /// A spring with this damping, and a relative speed at the start.
    Spring(f64, f64),
    /// A buffer on which loads press both bodies.
    Buffer,
}

/// Two bodies of mass 1, each on 1 N/m, tied by 1e9 N/m; their midpoint moves as cos t. Other
/// bodies: one on a spring as stiff as the tie, one on a closed stop, and `idle` free ones.
fn tied(tie: Tie, idle: usize) -> Description {
    let stiff = 1e9;
    let speed = if let Tie::Spring(_, speed) = tie { speed } else { 0.0 };
    let mut d = Description {
        bodies: vec![
            body("left", 1.0, 1.0, speed),
            body("right", 1.0, 1.0, -speed),
            body("beside", 1.0, 0.0, 0.0),
            body("lies", 1.0, 0.0, 0.0),
        ],
        springs: vec![
            spring(&[(0, 1.0)], 1.0, 0.0),
            spring(&[(1, 1.0)], 1.0, 0.0),
            spring(&[(2, 1.0)], stiff, 1e3),
        ],
        stops: vec![rigid("floor", &[(3, 1.0)], 0.0, 0.5)],
        loads: vec![Load { name: "weight".into(), body: 3, force: constant(10.0) }],
        ..Description::default()
    };
    match tie {
        Tie::Spring(damping, _) => d.springs.push(spring(&[(0, -1.0), (1, 1.0)], stiff, damping)),
        Tie::Buffer => {
            d.stops.push(compliant("tie", &[(0, 1.0), (1, -1.0)], 0.0, stiff, 1e3, DampingLimit::NoPull));
            let load = |name: &str, body, force| Load { name: name.into(), body, force: constant(force) };
            d.loads.extend([load("right", 0, 100.0), load("left", 1, -100.0)]);
        }
    }
    d.bodies.extend((0..idle).map(|i| body(&format!("idle{i}"), 1.0, 0.0, 0.0)));
    d
}

#[test]
fn closed_form_what_a_stiff_spring_ties_moves_as_a_whole() {
    // Forces of 1e9 N/m times the coordinates, rounded separately for each body, would move the
    // midpoint by 1e-7. After the tie's vibration has decayed, long sub-steps suffice; while it
    // lasts there are some 2e4 ordinary ones per second, since the stop might open in any of them.
    for tie in [Tie::Spring(1e3, 0.0), Tie::Spring(0.0, 1e-3), Tie::Buffer] {
        for idle in [0, 10] {
            let mut motion = motion(tied(tie, idle));
            motion.advance_to(1.0).unwrap();
            let [left, right] = [0, 1].map(|i| motion.body(i));
            for (k, exact) in [1f64.cos(), -1f64.sin()].into_iter().enumerate() {
                let off = 0.5 * (left[k] + right[k]) - exact;
                assert!(off.abs() < MIDDLE[k], "{tie:?}, {idle} idle, {k}: {off:e}");
            }
            assert!((motion.stop(0)[2] - 10.0).abs() < ROUNDING * 100.0, "{tie:?}: {:?}", motion.stop(0));
        }
    }
}

#[test]
fn closed_form_what_friction_or_a_stop_holds_across_a_stiff_spring_moves_as_one() {
    // A light body is held to a heavy one, in parallel to a spring of 1e10 N/m; both oscillate on
    // 100 N/m as 0.1 m cos ωt. A load of 0 N has knots, which shorten sub-steps. The tie's
    // rounding in the light body's row, with 1e10 N/m / 0.01 kg, would be 1e-4/s2 beside ω² =
    // 100/s2.
    let stuck =
        Description { frictions: vec![friction(&[(0, -1.0), (1, 1.0)], 1e3)], ..Description::default() };
    let pressed = Description {
        stops: vec![rigid("held", &[(0, -1.0), (1, 1.0)], 0.0, 0.5)],
        loads: vec![
            Load { name: "pull".into(), body: 0, force: constant(-1e2) },
            Load { name: "push".into(), body: 1, force: constant(1e2) },
        ],
        ..Description::default()
    };
    for (held, idle) in [(&stuck, 0), (&stuck, 10), (&pressed, 0), (&pressed, 10)] {
        let mut d = held.clone();
        d.bodies = vec![body("light", 0.01, 0.1, 0.0), body("heavy", 0.99, 0.1, 0.0)];
        d.springs = vec![spring(&[(0, 1.0)], 1e2, 0.0), spring(&[(0, -1.0), (1, 1.0)], 1e10, 0.0)];
        let knots = (0..100).map(|k| (0.037 * f64::from(k), 0.0)).collect();
        let nothing =
            Signal { table: Some(Record::new(knots, Interpolation::Straight)), ..Signal::default() };
        d.loads.push(Load { name: "knots".into(), body: 1, force: nothing });
        d.bodies.extend((0..idle).map(|i| body(&format!("idle{i}"), 1.0, 0.0, 0.0)));
        let mut motion = motion(d);
        motion.advance_to(3.5).unwrap();
        for i in 0..2 {
            let [s, v, _] = motion.body(i);
            let off = [s - 0.1 * 35f64.cos(), v + 35f64.sin()];
            assert!(off[0].abs() < ROUNDING && off[1].abs() < 10.0 * ROUNDING, "{i}, {idle} idle: {off:?}");
        }
    }
}

/// A load that increases linearly.
fn ramp(body: usize, from: f64, rise: f64) -> Load {
    let table = Some(Record::new(vec![(0.0, from), (1.0, from + rise)], Interpolation::Straight));
    Load { name: "ramp".into(), body, force: Signal { table, ..Signal::default() } }
}

/// Machines that hold a body against a stiff spring or buffer, with their only event and its time.
fn held() -> [(Description, EventKind, f64); 3] {
    // Friction of 1 N, and a load of 11.2 N + 10 N/s on a buffer compressed by 80 nm at 1.4e8 N/m.
    let buffer = compliant("buffer", &[(0, 1.0)], 0.05, 1.4e8, 3e4, DampingLimit::NoPull);
    let sticks = Description {
        bodies: vec![body("held", 0.3, 0.05000008, 0.0)],
        stops: vec![buffer],
        frictions: vec![friction(&[(0, 1.0)], 1.0)],
        loads: vec![ramp(0, 11.2, 10.0)],
        ..Description::default()
    };
    // A spring of 1e8 N/m presses with 10 N, and a load of 20 N/s pulls away: directly, or through
    // a body held by friction of 4 N.
    let mut pressed = Description {
        bodies: vec![body("pressed", 1.0, 1.0, 0.0)],
        springs: vec![Spring { preload: -1e8 - 10.0, ..spring(&[(0, 1.0)], 1e8, 1e3) }],
        stops: vec![rigid("stop", &[(0, 1.0)], 1.0, 0.5)],
        loads: vec![ramp(0, 0.0, -20.0)],
        ..Description::default()
    };
    let alone = pressed.clone();
    pressed.bodies.push(body("other", 2.0, 1.0, 0.0));
    pressed.springs = vec![Spring { preload: 10.0, ..spring(&[(0, -1.0), (1, 1.0)], 1e8, 1e3) }];
    pressed.frictions = vec![friction(&[(1, 1.0)], 14.0)];
    pressed.loads = vec![ramp(1, 0.0, -20.0)];
    let slip = |direction, force| EventKind::Slip { friction: 0, direction, force };
    [
        (sticks, slip(1.0, 1.0), 0.1),
        (alone, EventKind::Open { stop: 0 }, 0.5),
        (pressed, slip(-1.0, -14.0), 0.2),
    ]
}

#[test]
fn closed_form_what_holds_a_body_on_a_stiff_spring_lets_go() {
    // A held body does not move, however large the forces that the contact balances. Doubles
    // resolve 1.4e8 N/m times 0.05 m to 1e-9 N, which at 10 N/s is 1e-10 s.
    for (machine, kind, time) in held() {
        let mut motion = motion(machine);
        let start = motion.state().clone();
        let mut first = None;
        motion.advance_before_event(0.9, &mut |_| {}).unwrap();
        let moved = (motion.state() - start).rows(0, motion.assembly().system().signals.one).amax();
        assert_eq!(moved, 0.0, "{kind:?}");
        motion.apply_event(&mut |e| first = Some(e.clone())).unwrap();
        let first = first.unwrap();
        assert!(first.kind == kind && (first.time - time).abs() < 1e-9, "{first:?}, not {kind:?} at {time}");
    }
}

/// The damped [`pair`] with a load, a prescribed base, friction and a stop.
fn rattle() -> Description {
    let mut d = pair(39.5, 4e5, 10.0, (0.0, 1.0));
    d.bodies.push(prescribed("base", sine(0.01, 0.7, 0.3), 0.0));
    d.springs.push(spring(&[(2, -1.0), (0, 1.0)], 3.0, 0.4));
    d.stops = vec![
        rigid("stop", &[(0, 1.0)], 0.05, 0.5),
        compliant("buffer", &[(0, -1.0)], 0.06, 900.0, 3.0, DampingLimit::NoPull),
    ];
    d.frictions = vec![friction(&[(0, 1.0)], 0.2)];
    d.loads = vec![Load { name: "drive".into(), body: 0, force: sine(4.0, 1.1, 0.0) }];
    d
}

#[test]
fn second_method_a_stiff_machine_in_parts_too_short_for_long_sub_steps() {
    // An ordinary sub-step is about 2/sqrt(4e5) = 3 ms.
    const PART: f64 = 1.0 / 256.0;
    let (mut long, mut short) = (motion(rattle()), motion(rattle()));
    let all = events(&mut long, 20.0);
    let mut theirs = Vec::new();
    for k in 1..=5120 {
        short.advance_observed(PART * f64::from(k), &mut |e| theirs.push(e.clone())).unwrap();
    }
    assert!(all.len() > 100 && all.len() == theirs.len(), "{} {}", all.len(), theirs.len());
    for (a, b) in all.iter().zip(&theirs) {
        assert!((a.time - b.time).abs() < TWO_WAYS, "{a:?} {b:?}");
        assert_eq!(std::mem::discriminant(&a.kind), std::mem::discriminant(&b.kind));
    }
    let off = (long.state() - short.state()).amax();
    assert!(off < TWO_WAYS, "{off:e}");
    // Each account, and the balance with the mechanical energy, which is independent of them.
    let accounts = |m: &Motion| {
        let e = m.energy();
        let all = e
            .loads
            .iter()
            .chain(&e.dashpots)
            .chain(&e.stops)
            .chain(&e.frictions)
            .chain([&e.motions, &e.impacts]);
        all.map(|sum| sum.value()).collect::<Vec<_>>()
    };
    for (a, b) in accounts(&long).into_iter().zip(accounts(&short)) {
        assert!((a - b).abs() < TWO_WAYS, "{a:e} {b:e}");
    }
    let (kinetic, stored) = long.kinetic_and_stored();
    let start = motion(rattle()).kinetic_and_stored();
    let residual = kinetic + stored - start.0 - start.1 - long.energy().balance();
    assert!(residual.abs() < TWO_WAYS, "{residual:e}");
}

#[test]
fn closed_form_a_light_body_on_a_stiff_spring_follows_its_load() {
    // A light body on a stiff spring: 1e9 rad/s, weakly damped, 1e11 ordinary sub-steps in 100 s.
    // Another body meets a stop.
    let mut d = Description {
        bodies: vec![body("light", 1e-6, 0.0, 0.0), body("slow", 1.0, 0.5, 0.0)],
        springs: vec![spring(&[(0, 1.0)], 1e12, 1e-3), spring(&[(1, 1.0)], 1.0, 0.0)],
        stops: vec![rigid("far", &[(0, 1.0)], 1e-3, 0.5), rigid("near", &[(1, 1.0)], 0.6, 0.5)],
        loads: vec![Load { name: "load".into(), body: 0, force: sine(1e3, 0.25, 0.0) }],
        ..Description::default()
    };
    d.bodies[0] = body("light", 1e-6, 0.0, 1e-3);
    let mut motion = motion(d);
    let end = 99.0;
    motion.advance_to(end).unwrap();
    let angle = TAU * 0.25 * end;
    // Its natural motion has decayed by exp(-500 t).
    assert!((motion.body(0)[0] - 1e-9 * angle.sin()).abs() < 1e-9 * ROUNDING, "{:e}", motion.body(0)[0]);
    assert!((motion.body(1)[0] - 0.5 * end.cos()).abs() < ROUNDING, "{:e}", motion.body(1)[0]);
    // The dashpot takes the energy of the initial speed relative to the forced motion, and the
    // loss of the forced motion, whose squared speed has the mean 1/2 at this end.
    let follows = 1e-9 * TAU * 0.25;
    let exact = 0.5 * 1e-6 * (1e-3 - follows).powi(2) + 1e-3 * follows.powi(2) * 0.5 * end;
    let lost = motion.energy().dashpots[0].value();
    assert!((lost / exact - 1.0).abs() < LOST, "{:e}", lost / exact - 1.0);
}

#[test]
fn a_motion_too_fast_for_its_end_is_told_with_body_and_sub_step() {
    // An undamped body on a stiff spring with a stop at twice its amplitude: each of its periods
    // must be checked for contact.
    let d = Description {
        bodies: vec![body("light", 1e-6, 0.0, 1.0), body("slow", 1.0, 0.1, 0.0)],
        springs: vec![spring(&[(0, 1.0)], 1e12, 0.0), spring(&[(1, 1.0)], 1.0, 0.0)],
        stops: vec![rigid("beside", &[(0, 1.0)], 2e-9, 0.5)],
        ..Description::default()
    };
    let mut motion = motion(d).with_most_work(10_000);
    let Err(Error::TooStiff { time, cause }) = motion.advance_to(1.0) else { panic!("{}", motion.time()) };
    assert!(cause.starts_with("10000 sub-steps in one call;") && cause.contains("body.light"), "{cause}");
    // 10,000 sub-steps of 3/1e9 s; the next call continues.
    assert!(time == motion.time() && (1e-6..1e-4).contains(&time), "{time:e}");
    assert!((motion.body(0)[0] - 1e-9 * (1e9 * time).sin()).abs() < 1e-9 * 1e-7, "{:e}", motion.body(0)[0]);
    motion.advance_to(time + 1e-6).unwrap();
}

#[test]
fn closed_form_a_slow_body_beside_a_fast_one_meets_its_stop() {
    // The fast body's stop keeps sub-steps short; in each of them the slow body moves by less than
    // the threshold of its coordinate.
    const SPEED: f64 = 2e-8;
    const GAP: f64 = 1e-10;
    /// A few times the threshold of a coordinate, relative to the largest coordinate.
    const PLACE: f64 = 1e-12;
    let mut motion = motion(Description {
        bodies: vec![body("fast", 1.0, 1e-3, 0.0), body("slow", 1.0, 1.0, SPEED)],
        springs: vec![spring(&[(0, 1.0)], 1e12, 0.0)],
        stops: vec![
            rigid("fast", &[(0, 1.0)], 1.000_000_1e-3, 0.5),
            rigid("slow", &[(1, 1.0)], 1.0 + GAP, 0.0),
        ],
        ..Description::default()
    });
    let met = events(&mut motion, 2.0 * GAP / SPEED);
    assert!(!met.is_empty() && (SPEED * met[0].time - GAP).abs() < PLACE, "{met:?}");
    assert!((motion.body(1)[0] - 1.0 - GAP).abs() < PLACE, "{:?}", motion.body(1));
}

#[test]
fn closed_form_a_stop_lets_go_whose_force_begins_as_zero_beside_a_stiff_spring() {
    // The threshold, 1e-13 of the spring's 1e8 N and of its force on the other body, hides the
    // load and its derivatives at the start, so that the stop's force counts as zero throughout
    // the mode. A load of 1 N - 1 N cos pulls at once, one of 1 N sin after half a period, until
    // which both bodies are held; without a fast motion a sub-step may cover a whole period of the
    // load, with one a long sub-step may.
    /// Time until the load exceeds 16 times the threshold, s.
    const LATE: f64 = 0.03;
    let load =
        |constant, amplitude, frequency, phase| Signal { constant, ..sine(amplitude, frequency, phase) };
    for k in 0..60 {
        let frequency = 0.2 + 0.0035 * f64::from(k);
        let machine = |force, stops: &[usize]| Description {
            bodies: vec![body("held", 1.0, 1.0, 0.0), body("other", 1.0, 1.0, 0.0)],
            springs: vec![spring(&[(0, -1.0), (1, 1.0)], 1e8, 1e3)],
            stops: stops.iter().map(|&i| rigid(&format!("stop{i}"), &[(i, 1.0)], 1.0, 0.5)).collect(),
            loads: vec![Load { name: "load".into(), body: 0, force }],
            ..Description::default()
        };
        let at_once = machine(load(-1.0, 1.0, frequency, TAU / 4.0), &[0]);
        let after_half = machine(load(0.0, 1.0, frequency, 0.0), &[0, 1]);
        for (d, time) in [(at_once, 0.0), (after_half, 0.5 / frequency)] {
            for parts in [1, 2, 37] {
                let (mut motion, mut all) = (motion(d.clone()), Vec::new());
                for part in 1..=parts {
                    let end = 11.0 * f64::from(part) / f64::from(parts);
                    motion.advance_observed(end, &mut |event| all.push(event.clone())).unwrap();
                }
                let opens = times(&all, |kind| *kind == EventKind::Open { stop: 0 });
                assert!(
                    opens.first().is_some_and(|t| (t - time).abs() < LATE),
                    "{frequency} {parts}: {opens:?}"
                );
            }
        }
    }
}
