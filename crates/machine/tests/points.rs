//! Springs with a piecewise linear force through points (docs/assembly-law.md (A15)).

use crate::common::both_laws::{Balance, BothLaws, on_machines};
use crate::common::machines::assembly;
use crate::common::*;
use proptest::prelude::*;
use std::cell::Cell;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use vibro_machine::description::*;
use vibro_machine::file::{no_records, parse};
use vibro_machine::mode::StopState;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Motion};

/// Roundings of a few dozen operations.
const ROUNDING: f64 = 1e-13;
/// Tolerance for the snap-through spring over four seconds. Its segment of negative stiffness
/// (-167 N/m on 0.7 kg) amplifies rounding errors by up to exp(√(167/0.7) t).
const SNAP: f64 = 1e-11;

/// Relative tolerance for random machines: energy balance, and difference between the direct and
/// the general event law. Stiff buffers amplify rounding.
const BALANCE: f64 = 1e-10;
const BOTH: BothLaws = BothLaws { events: 200, end: 3.0, rounding: BALANCE };

fn points(all: &[(f64, f64)]) -> Vec<ForcePoint> {
    all.iter().map(|&(e, f)| ForcePoint { e, f }).collect()
}

fn by_points(terms: &[(usize, f64)], damping: f64, all: &[(f64, f64)]) -> Spring {
    Spring { points: points(all), ..spring(terms, 0.0, damping) }
}

/// A body of 1 kg on a spring with a piecewise linear force.
fn alone(s: f64, v: f64, all: &[(f64, f64)]) -> Description {
    Description {
        name: "Alone".into(),
        bodies: vec![body("b", 1.0, s, v)],
        springs: vec![by_points(&[(0, 1.0)], 0.0, all)],
        ..Description::default()
    }
}

fn corners(events: &[Event]) -> Vec<(f64, f64)> {
    let corner = |e: &Event| match e.kind {
        EventKind::Corner { rate, .. } => Some((e.time, rate)),
        _ => None,
    };
    events.iter().filter_map(corner).collect()
}

/// For stiffness k at e < 0 and K at e > 0, a body of 1 kg alternates between half-periods of π/√K
/// and π/√k.
#[test]
fn closed_form_two_slopes_are_half_turns() {
    let (k, stiff, v) = (100.0f64, 900.0f64, 0.6);
    let mut m = motion(alone(0.0, v, &[(-0.1, -10.0), (0.0, 0.0), (0.2, 180.0)]));
    let all = corners(&events(&mut m, 10.0));
    let turn = PI / k.sqrt() + PI / stiff.sqrt();
    assert!(all.len() >= 40, "{}", all.len());
    for (i, (time, rate)) in all.iter().enumerate() {
        let whole = turn * (i / 2) as f64;
        let expected = if i % 2 == 0 { whole + PI / stiff.sqrt() } else { whole + turn };
        assert!((time - expected).abs() < 100.0 * ROUNDING, "{i}: {time} {expected}");
        let sign = if i % 2 == 0 { -1.0 } else { 1.0 };
        assert!((rate - sign * v).abs() < 100.0 * ROUNDING);
    }
    // The end slopes continue beyond the points.
    let mut m = motion(alone(0.0, 30.0, &[(-0.1, -10.0), (0.0, 0.0), (0.2, 180.0)]));
    m.advance_to(0.5 * PI / stiff.sqrt()).unwrap();
    let [e, _, f] = m.spring(0);
    assert!((e - 30.0 / stiff.sqrt()).abs() < ROUNDING && (f - stiff * e).abs() < stiff * ROUNDING);
}

/// A spring through two points is bitwise equal to a linear spring with preload. Points on one
/// line cause no events.
#[test]
fn closed_form_straight_lines_have_no_corner() {
    let mut straight = alone(0.1, 0.0, &[(0.0, 3.0), (1.0, 28.0)]);
    let mut plain = straight.clone();
    plain.springs = vec![Spring { preload: 3.0, ..spring(&[(0, 1.0)], 25.0, 0.0) }];
    let [mut a, mut b] = [motion(straight.clone()), motion(plain)];
    a.advance_to(3.0).unwrap();
    b.advance_to(3.0).unwrap();
    assert_eq!((a.states(), a.kinetic_and_stored()), (b.states(), b.kinetic_and_stored()));
    straight.springs[0].points = points(&[(-0.3, -4.5), (-0.1, 0.5), (0.0, 3.0), (1.0, 28.0)]);
    let mut c = motion(straight);
    assert!(events(&mut c, 3.0).is_empty());
    assert!(c.states().iter().zip(a.states()).all(|(c, a)| (c - a).abs() < 10.0 * ROUNDING));
}

/// On a segment of negative stiffness the motion is a hyperbolic cosine. The force follows the
/// curve, and the stored energy (zero at e = 0) is its integral, here negative.
#[test]
fn closed_form_a_falling_line() {
    let all = [(-0.2, -1.0), (-0.1, 2.5), (0.1, -2.5), (0.2, 1.0)];
    let (s, falls) = (0.03, 5.0);
    let own = (0.1f64 / s).acosh() / 5.0;
    let all = corners(&events(&mut motion(alone(s, 0.0, &all)), 0.5));
    assert!((all[0].0 - own).abs() < ROUNDING && (all[0].1 - 5.0 * (0.01 - s * s).sqrt()).abs() < ROUNDING);
    let mut m = motion(alone(s, 0.0, &[(-0.2, -1.0), (-0.1, 2.5), (0.1, -2.5), (0.2, 1.0)]));
    m.advance_to(0.9 * own).unwrap();
    let e = s * (falls * 0.9 * own).cosh();
    let [got, _, f] = m.spring(0);
    assert!((got - e).abs() < ROUNDING && (f + 25.0 * e).abs() < 25.0 * ROUNDING, "{got} {e} {f}");
    assert!((m.kinetic_and_stored().1 + 12.5 * e * e).abs() < ROUNDING, "{:?}", m.kinetic_and_stored());
    assert_eq!(m.energy().balance(), 0.0);
}

/// At a corner with e' = 0, the sign of the first nonzero derivative of e decides which segment
/// acts; if all are zero, the segment to the left acts.
#[test]
fn closed_form_a_start_on_a_corner() {
    let lines = [(-0.1, -10.0), (0.0, 0.0), (0.2, 180.0)];
    let mut rests = motion(alone(0.0, 0.0, &lines));
    assert!(events(&mut rests, 5.0).is_empty() && rests.body(0)[0] == 0.0);
    assert_eq!(rests.mode().stops, [StopState::Below]);
    for (push, stiffness, state) in [(3.0, 900.0f64, StopState::Pressed), (-3.0, 100.0, StopState::Below)] {
        let mut d = alone(0.0, 0.0, &lines);
        d.loads = vec![Load { name: "l".into(), body: 0, force: constant(push) }];
        let mut m = motion(d);
        assert_eq!(m.mode().stops, [state]);
        let turn = TAU / stiffness.sqrt();
        assert!(events(&mut m, 0.99 * turn).is_empty());
        let exact = push / stiffness * (1.0 - (stiffness.sqrt() * m.time()).cos());
        assert!((m.body(0)[0] - exact).abs() < ROUNDING, "{:?} {exact}", m.body(0));
    }
    // Decided by the third derivative: a load that grows as t.
    let mut d = alone(0.0, 0.0, &lines);
    let ramp = Record::new(vec![(0.0, 0.0), (1.0, -3.0)], Interpolation::Straight);
    d.loads =
        vec![Load { name: "l".into(), body: 0, force: Signal { table: Some(ramp), ..Signal::default() } }];
    assert_eq!(motion(d.clone()).mode().stops, [StopState::Below]);
    d.loads[0].force.table.as_mut().unwrap().knots[1].1 = 3.0;
    assert_eq!(motion(d).mode().stops, [StopState::Pressed]);
}

/// The machine of data/make_points.py.
const SNAPS: &str = r#"
    name = "Snaps"
    [body.a]
    mass = 0.7
    start = { s = 0.01, v = 0.3 }
    [body.b]
    mass = 1.3
    start = { s = -0.02 }
    [spring.membrane]
    between = ["ground", "a"]
    points = [["-60 mm", "-8 N"], ["-10 mm", "3 N"], ["20 mm", "-2 N"], ["40 mm", "-1 N"], ["50 mm", "4 N"]]
    damping = 0.2
    [spring.tie]
    between = ["a", "b"]
    stiffness = 25.0
    [load.push]
    on = "a"
    amplitude = 6.0
    frequency = 1.3
    phase = 0.4
"#;

#[test]
fn second_method_a_snap_through_spring_in_40_digits() {
    let machine = parse(SNAPS, "snaps.toml", &no_records).unwrap();
    let mut m = Motion::new(Arc::new(Assembly::new(machine).unwrap())).unwrap();
    let (mut met, mut count) = (Vec::new(), 0);
    let (kinetic, stored) = m.kinetic_and_stored();
    for line in include_str!("data/points.txt").lines().filter(|line| !line.starts_with('#')) {
        let words: Vec<&str> = line.split_whitespace().collect();
        let numbers: Vec<f64> = words[1..].iter().map(|x| x.parse().unwrap()).collect();
        if words[0] == "corner" {
            met.push((numbers[0], numbers[1]));
            continue;
        }
        let found = corners(&events(&mut m, numbers[0]));
        assert_eq!(found.len(), met.len(), "at {}: {found:?}", numbers[0]);
        for ((time, rate), exact) in found.iter().zip(met.drain(..)) {
            assert!(
                (time - exact.0).abs() < SNAP && (rate - exact.1).abs() < SNAP,
                "{time} {rate} {exact:?}"
            );
            count += 1;
        }
        let own = [m.body(0)[0], m.body(0)[1], m.body(1)[0], m.body(1)[1]];
        for (own, exact) in own.iter().zip(&numbers[1..]) {
            assert!((own - exact).abs() < SNAP, "{}: {own} {exact}", numbers[0]);
        }
        let (now, held) = m.kinetic_and_stored();
        let off = now + held - kinetic - stored - m.energy().balance();
        assert!(off.abs() < ROUNDING, "{off}");
    }
    assert!(count > 20, "{count}");
}

#[test]
fn second_method_derivatives_by_points() {
    let machine = parse(SNAPS, "snaps.toml", &no_records).unwrap();
    let (names, met) = differences::compare(&machine, 1.1);
    assert!(met >= 6, "{met}");
    assert!(names.iter().any(|name| name == "spring.membrane.points[1].e"), "{names:?}");
    assert!(names.iter().any(|name| name == "spring.membrane.points[4].f"), "{names:?}");
    // A curve whose points lie on one line also has derivatives with respect to each point.
    let straight = alone(0.05, 0.4, &[(-0.3, -4.5), (-0.02, 2.5), (0.02, 3.5), (1.0, 28.0)]);
    differences::compare(&straight, 0.9);
}

#[test]
fn golden_points_in_files() {
    let machine = parse(SNAPS, "snaps.toml", &no_records).unwrap();
    assert_eq!(machine.springs[0].points[1], ForcePoint { e: -0.01, f: 3.0 });
    assert_eq!(parse(&machine.to_toml(), "again.toml", &no_records).unwrap(), machine);
    let named = SNAPS.replace("[body.a]", "[parameters]\nedge = \"10 mm\"\nhill = 3.0\n[body.a]");
    let named = named.replace("[\"-10 mm\", \"3 N\"]", "[\"= -edge\", \"= hill\"]");
    let mut named = parse(&named, "named.toml", &no_records).unwrap();
    assert_eq!(named.springs, machine.springs);
    assert_eq!(parse(&named.to_toml(), "again.toml", &no_records).unwrap(), named);
    named.replace("edge", 0.012).unwrap();
    assert_eq!(named.get("spring.membrane.points[1].e").unwrap(), -0.012);
    let refused = |from: &str, to: &str| {
        assert!(SNAPS.contains(from), "{from}");
        parse(&SNAPS.replace(from, to), "m.toml", &no_records).unwrap_err().to_string()
    };
    for (from, to, message) in [
        (
            "[\"20 mm\", \"-2 N\"]",
            "[\"-20 mm\", \"-2 N\"]",
            "m.toml:11: spring.membrane.points[2].e = \"-20 mm\": must be greater than -0.01 m, the e of the previous point",
        ),
        (
            "damping = 0.2",
            "stiffness = 3.0",
            "m.toml:12: spring.membrane.stiffness = 3.0: cannot be combined with `points`: use `points` (with `damping`) for a curve, or `stiffness` for a linear spring",
        ),
        (
            "[\"20 mm\", \"-2 N\"]",
            "[\"20 mm\", \"-2 m\"]",
            "m.toml:11: spring.membrane.points[2,1] = \"-2 m\": cannot be in `m`; expected one of N, mN, kN, MN, lbf",
        ),
        (
            "[[\"-60 mm\", \"-8 N\"], [\"-10 mm\", \"3 N\"], [\"20 mm\", \"-2 N\"], [\"40 mm\", \"-1 N\"], [\"50 mm\", \"4 N\"]]",
            "[[0.0, 0.0]]",
            "m.toml:11: spring.membrane.points = [[0.0, 0.0]]: expected two or more pairs [e, f] with increasing e, such as [[\"-2 mm\", \
             \"-40 N\"], [\"1 mm\", \"10 N\"]]",
        ),
    ] {
        let said = refused(from, to);
        assert!(said.starts_with(message), "{said}");
    }
    let mut machine = machine;
    let said = machine.replace("spring.membrane.points[3].e", 0.06).unwrap_err().to_string();
    assert!(said.contains("spring.membrane.points[4].e") && said.contains("greater than 0.06"), "{said}");
}

/// Replaces each spring's stiffness by a piecewise linear curve with one falling segment.
fn bent(mut d: Description) -> Description {
    for spring in &mut d.springs {
        let k = std::mem::take(&mut spring.stiffness);
        spring.points = points(&[(-1.0, -k), (-0.2, 0.1 * k), (0.1, -0.1 * k), (0.4, 0.0), (1.0, 2.0 * k)]);
    }
    d
}

#[test]
fn invariant_random_machines_keep_their_energy_and_both_ways_of_the_law_agree() {
    let [events, corners] = [Cell::new(0), Cell::new(0)];
    on_machines(&assembly().prop_map(bent), 200, |start| {
        let mut balance = Balance::new(&start);
        BOTH.follow(start, |handled| {
            balance.check(handled.direct, BALANCE)?;
            let met = handled.observed.iter().filter(|e| matches!(e.kind, EventKind::Corner { .. }));
            corners.set(corners.get() + met.count());
            events.set(events.get() + 1);
            Ok(())
        })
    });
    let [events, corners] = [events, corners].map(|count| count.get());
    println!("{events} events, {corners} corners");
    assert!(events > 2000 && corners > 500, "{events} {corners}");
}

/// A chain without tables of modes, checked by its energy balance.
#[test]
fn invariant_a_chain_of_bodies_with_lines_keeps_its_energy() {
    let count = 30;
    let lines = [(-0.02, -3.0), (-0.005, -0.4), (0.005, 0.2), (0.01, 0.15), (0.03, 4.0)];
    let mut d = Description {
        name: "Chain".into(),
        bodies: (0..count).map(|i| body(&format!("b{i}"), 0.2, 0.0, 0.0)).collect(),
        ..Description::default()
    };
    for i in 0..count {
        let terms = if i == 0 { vec![(0, 1.0)] } else { vec![(i - 1, -1.0), (i, 1.0)] };
        d.springs.push(Spring { name: format!("s{i}"), ..by_points(&terms, 0.01, &lines) });
    }
    d.loads = vec![Load { name: "l".into(), body: count - 1, force: sine(0.8, 1.1, 0.2) }];
    let mut m = motion(d);
    let all = corners(&events(&mut m, 4.0));
    let (kinetic, stored) = m.kinetic_and_stored();
    assert!(all.len() > 200, "{}", all.len());
    assert!((kinetic + stored - m.energy().balance()).abs() < ROUNDING * 100.0, "{kinetic} {stored}");
    assert!(m.energy().dashpots.iter().map(|lost| lost.value()).sum::<f64>() > 1e-4);
}
