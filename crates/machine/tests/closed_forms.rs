//! Motions compared with closed forms.

use crate::common::*;
use nalgebra::DVector;
use vibro_machine::Assembly;
use vibro_machine::description::*;
use vibro_machine::law::Sizes;
use vibro_machine::law::impact::Instant;
use vibro_machine::motion::EventKind;

/// Roundings of numbers of order one, and of sums of a few hundred of them.
const ROUNDING: f64 = 1e-12;

/// Remainder of a transient that shrinks by more than a quarter at each impact, after more than a
/// hundred impacts, and rounding.
const SETTLED: f64 = 1e-12;

fn is_impact(kind: &EventKind) -> bool {
    matches!(kind, EventKind::Impact { .. })
}

#[test]
fn closed_form_ball_that_comes_to_rest() {
    let d = Description {
        gravity: 9.81,
        bodies: vec![heavy("ball", 1.0, -1.0, 1.0, 0.0)],
        stops: vec![rigid("floor", &[(0, -1.0)], 0.0, 0.9)],
        ..Description::default()
    };
    let mut motion = motion(d);
    let all = events(&mut motion, 10.0);
    let close = times(&all, |k| matches!(k, EventKind::Close { .. }));
    let fall = (2.0f64 / 9.81).sqrt();
    let rest = fall * (1.0 + 2.0 * 0.9 / (1.0 - 0.9));
    assert_eq!(close.len(), 1, "{all:?}");
    assert!((close[0] - rest).abs() < ROUNDING * rest, "{close:?} {rest}");
    let first = times(&all, is_impact);
    assert!((first[0] - fall).abs() < ROUNDING && (first[1] - fall * 2.8).abs() < ROUNDING, "{first:?}");
    assert_eq!(motion.body(0)[0..2], [0.0, 0.0]);
    let mechanical = 9.81; // m g h, all lost
    assert!((motion.energy().impacts.value() - mechanical).abs() < ROUNDING * mechanical);
}

#[test]
fn closed_form_oscillator_with_dry_friction() {
    let d = Description {
        bodies: vec![body("mass", 1.0, 8.5e-4, 0.0)],
        springs: vec![spring(&[(0, 1.0)], 1e4, 0.0)],
        frictions: vec![friction(&[(0, 1.0)], 1.0)],
        ..Description::default()
    };
    let mut motion = motion(d);
    let half = std::f64::consts::PI / 100.0;
    for (k, turn) in [-6.5e-4, 4.5e-4, -2.5e-4, 0.5e-4].into_iter().enumerate() {
        motion.advance_to(half * (k + 1) as f64).unwrap();
        assert!((motion.body(0)[0] - turn).abs() < ROUNDING * 1e-3, "{k} {:?}", motion.body(0));
    }
    let all = events(&mut motion, 1.0);
    assert!(times(&all, |k| matches!(k, EventKind::Slip { .. })).is_empty());
    assert_eq!(motion.body(0)[1], 0.0);
    assert!((motion.friction(0)[2] + 0.5).abs() < 1e-9, "{:?}", motion.friction(0));
}

#[test]
fn closed_form_impact_pair() {
    // Base sin t, gap 3, restitution 0.5: a motion with two impacts a period, approach speed V =
    // 1.50557395311726.
    let base = sine(1.0, 1.0 / std::f64::consts::TAU, 0.0);
    let d = Description {
        bodies: vec![prescribed("base", base, 0.0), body("block", 1.0, 0.0, 0.9)],
        stops: vec![
            rigid("upper", &[(0, -1.0), (1, 1.0)], 1.5, 0.5),
            rigid("lower", &[(0, 1.0), (1, -1.0)], 1.5, 0.5),
        ],
        ..Description::default()
    };
    let mut motion = motion(d);
    let all = events(&mut motion, 400.0);
    let last = all
        .iter()
        .rev()
        .find_map(|e| if let EventKind::Impact { speed, .. } = e.kind { Some(speed) } else { None });
    // The block's speed c reverses at an impact, c(1 - ε) = -b(1 + ε) with the base's speed b; in
    // half a period the block travels 2(L + sqrt(1 - b²)) = π c. The closing speed is
    // c - b = 4c/3.
    let c = 1.50557395311726;
    assert!((last.unwrap() - 4.0 * c / 3.0).abs() < SETTLED, "{last:?}");
}

#[test]
fn closed_form_impact_on_a_spring() {
    // m = 100, k = 1e6 contact beside mount 1e4, v = 1: F = 9950.37190209989 N, 0.0312600152681233
    // s.
    let d = Description {
        bodies: vec![body("mass", 100.0, 0.0, 1.0)],
        springs: vec![spring(&[(0, 1.0)], 1e4, 0.0)],
        stops: vec![compliant("buffer", &[(0, 1.0)], 0.0, 1e6, 0.0, DampingLimit::NoPull)],
        ..Description::default()
    };
    let mut m = motion(d);
    let omega = (1.01e6f64 / 100.0).sqrt();
    m.advance_to(std::f64::consts::PI / omega / 2.0).unwrap();
    assert!((m.stop(0)[2] - 9950.37190209989).abs() < 1e-8, "{:?}", m.stop(0));
    let all = events(&mut m, 0.1);
    let free = times(&all, |k| matches!(k, EventKind::Free { .. }));
    assert!((free[0] - 0.0312600152681233).abs() < 1e-14, "{all:?}");
}

#[test]
fn closed_form_cradle() {
    // Three equal balls that touch: Newton's law with restitution 1 gives (-1/3, 2/3, 2/3) v;
    // apart, (0, 0, 1) v.
    for (gap, expected) in [(0.0, [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]), (0.01, [0.0, 0.0, 1.0])] {
        let d = Description {
            bodies: vec![body("a", 1.0, -1.0, 1.0), body("b", 1.0, 0.0, 0.0), body("c", 1.0, 0.0, 0.0)],
            stops: vec![
                rigid("ab", &[(0, 1.0), (1, -1.0)], 0.0, 1.0),
                rigid("bc", &[(1, 1.0), (2, -1.0)], gap, 1.0),
            ],
            ..Description::default()
        };
        let mut m = motion(d);
        let all = events(&mut m, 2.0);
        for (k, v) in expected.into_iter().enumerate() {
            assert!((m.body(k)[1] - v).abs() < ROUNDING, "{gap} {k} {:?} {all:?}", m.body(k));
        }
    }
}

#[test]
fn others_models_elastogap() {
    // MSL Translational.ElastoGap: m = 1, c = 10, d = 1.5, gaps ±0.5, from 2: s(5) =
    // -0.707885294079811.
    let d = Description {
        bodies: vec![body("mass", 1.0, 2.0, 0.0)],
        stops: vec![
            compliant("upper", &[(0, 1.0)], 0.5, 10.0, 1.5, DampingLimit::Elastogap),
            compliant("lower", &[(0, -1.0)], 0.5, 10.0, 1.5, DampingLimit::Elastogap),
        ],
        ..Description::default()
    };
    let mut m = motion(d);
    let energy = |m: &vibro_machine::Motion| m.kinetic_and_stored().0 + m.kinetic_and_stored().1;
    let before = energy(&m);
    events(&mut m, 5.0);
    assert!((m.body(0)[0] + 0.707885294079811).abs() < ROUNDING, "{:?}", m.body(0));
    let change = energy(&m) - before;
    assert!((m.energy().balance() - change).abs() < ROUNDING * before, "{change} {}", m.energy().balance());
}

/// MSL's Rotational.Examples.CoupledClutches: four wheels with J = 1, the first at 10 rad/s under
/// 10 sin(10 π t); clutches with μ = 0.5, peak 1.1, normal force 20 N times cos(0.4 π t), a step
/// at 0.4 s and one at 0.9 s.
#[test]
fn others_models_coupled_clutches() {
    let step = |time: f64, height: f64| Signal { steps: vec![Step { time, height }], ..Signal::default() };
    let clutch = |name: &str, between: [usize; 2], force: Signal, peak: Signal| Friction {
        name: name.into(),
        arms: arms(&[(between[0], -1.0), (between[1], 1.0)]),
        force,
        static_force: Some(peak),
        follows: None,
        stribeck: None,
        viscous: None,
    };
    let quarter = std::f64::consts::FRAC_PI_2;
    let d = Description {
        bodies: (1..=4).map(|i| body(&format!("J{i}"), 1.0, 0.0, if i == 1 { 10.0 } else { 0.0 })).collect(),
        frictions: vec![
            clutch("clutch1", [0, 1], sine(10.0, 0.2, quarter), sine(11.0, 0.2, quarter)),
            clutch("clutch2", [1, 2], step(0.4, 10.0), step(0.4, 11.0)),
            clutch("clutch3", [2, 3], step(0.9, 10.0), step(0.9, 11.0)),
        ],
        loads: vec![Load { name: "torque".into(), body: 0, force: sine(10.0, 5.0, 0.0) }],
        ..Description::default()
    };
    let mut m = motion(d);
    let all = events(&mut m, 1.5);
    let changes = times(&all, |k| {
        matches!(k, EventKind::Stick { .. } | EventKind::Slip { .. } | EventKind::Level { acts: false, .. })
    });
    let expected = [
        0.709621474693747,
        0.791662359154816,
        0.831108506137653,
        0.906850192797880,
        1.00029585989464,
        1.14396749247317,
        1.25,
    ];
    assert_eq!(changes.len(), expected.len(), "{all:#?}");
    for (found, exact) in changes.iter().zip(expected) {
        assert!((found - exact).abs() < 1e2 * ROUNDING, "{changes:?}");
    }
    assert!((m.body(0)[1] - 3.24705827241880).abs() < ROUNDING * 10.0, "{:?}", m.body(0));
}

#[test]
fn closed_form_bead_column() {
    // Five beads fall on a floor, one above the other, with plastic impacts: all come to rest, and
    // each contact carries the weight above it.
    let count = 5;
    let bodies =
        (0..count).map(|i| heavy(&format!("bead{i}"), 1.0, -1.0, 0.1 * (i + 1) as f64, 0.0)).collect();
    let mut stops = vec![rigid("floor", &[(0, -1.0)], 0.0, 0.0)];
    for i in 1..count {
        stops.push(rigid(&format!("contact{i}"), &[(i - 1, 1.0), (i, -1.0)], 0.0, 0.0));
    }
    let mut m = motion(Description { gravity: 9.81, bodies, stops, ..Description::default() });
    let all = events(&mut m, 2.0);
    for i in 0..count {
        assert!(
            (m.stop(i)[2] - 9.81 * (count - i) as f64).abs() < ROUNDING * 10.0,
            "{:?} {all:#?}",
            m.stop(i)
        );
        assert_eq!(m.body(i)[1], 0.0);
    }
    assert!(
        (m.energy().impacts.value() - 9.81 * 1.5).abs() < ROUNDING * 100.0,
        "{}",
        m.energy().impacts.value()
    );
}

#[test]
fn closed_form_redundant_stops() {
    // Two floors at the same height under one block: it rests, whatever share each floor carries.
    let d = Description {
        gravity: 9.81,
        bodies: vec![heavy("block", 2.0, -1.0, 0.3, 0.0)],
        stops: vec![rigid("left", &[(0, -1.0)], 0.0, 0.2), rigid("right", &[(0, -1.0)], 0.0, 0.7)],
        ..Description::default()
    };
    let mut m = motion(d);
    let all = events(&mut m, 0.25);
    let fall = (0.6f64 / 9.81).sqrt();
    let v = 0.7 * 9.81 * fall; // the larger restitution decides
    let after = 0.25 - fall;
    assert!((m.body(0)[0] - (v * after - 0.5 * 9.81 * after * after)).abs() < ROUNDING, "{all:?}");
    m.advance_to(5.0).unwrap();
    assert_eq!(m.body(0)[0..2], [0.0, 0.0]);
    assert!((m.stop(0)[2] + m.stop(1)[2] - 2.0 * 9.81).abs() < ROUNDING * 10.0);
}

/// A light body at rest at a wall, touched by one of mass 1 that moves towards it.
fn anvil(mass: f64, speed: f64) -> Description {
    Description {
        bodies: vec![body("light", mass, 0.0, 0.0), body("heavy", 1.0, 0.0, speed)],
        stops: vec![rigid("wall", &[(0, 1.0)], 0.0, 0.5), rigid("contact", &[(0, -1.0), (1, 1.0)], 0.0, 0.0)],
        ..Description::default()
    }
}

#[test]
fn closed_form_light_body_between_a_wall_and_a_heavy_one() {
    // The heavy body drives the light one against the wall, where both stop; then a load pulls
    // them away together. The two impulses on the light body cancel; its speed is their rounding.
    for k in 1..100 {
        let (mass, speed) = (0.83f64.powi(k), 0.37 * k as f64);
        let mut d = anvil(mass, speed);
        d.loads.push(Load { name: "load".into(), body: 0, force: constant(-1.0) });
        let mut motion = motion(d);
        let all = events(&mut motion, 1.0);
        assert!(all.is_empty(), "{k}: {all:?}");
        let way = -0.5 / (1.0 + mass);
        for i in 0..2 {
            let [s, v, _] = motion.body(i);
            assert!((s - way).abs() < ROUNDING && (v - 2.0 * way).abs() < ROUNDING, "{k}, body {i}: {s} {v}");
            assert_eq!(motion.impacts(i).count, 1, "{k}");
        }
    }
}

#[test]
fn invariant_an_impact_without_impulse_ends_the_sequence() {
    // The light body's speed is below the zero threshold of the heavy body's speed.
    let machine = Assembly::new(anvil(0.01, 0.0)).unwrap();
    let system = machine.system();
    let mut z = DVector::zeros(system.signals.size);
    z[system.coordinates] = 1e-16;
    let before = z.clone();
    let mut sizes = Sizes(z.clone());
    sizes.0[system.coordinates + 1] = 1.0;
    let restitution = &[0.5, 0.0];
    let instant = Instant { system, sizes: &sizes, touching: &[0, 1], restitution, engaged: &[] };
    let impacts = instant.collide(&mut z, &mut |_, stops, _, _| Ok(vec![true; stops.len()])).unwrap();
    assert!(impacts.sequence.is_empty() && !impacts.projected, "{}", impacts.sequence.len());
    assert_eq!(z, before);
}

#[test]
fn closed_form_shares_of_impulses_that_cancel() {
    // The heavy body's 2 N s go through the light one into the wall: of its speed, which stays
    // nothing, each of the two impulses makes 2 N s / 0.01 kg.
    let machine = Assembly::new(anvil(0.01, 2.0)).unwrap();
    let system = machine.system();
    let mut z = DVector::zeros(system.signals.size);
    z[system.coordinates + 1] = 2.0;
    let sizes = Sizes(z.clone());
    let restitution = &[0.5, 0.0];
    let instant = Instant { system, sizes: &sizes, touching: &[0, 1], restitution, engaged: &[] };
    let impacts = instant.collide(&mut z, &mut |_, stops, _, _| Ok(vec![true; stops.len()])).unwrap();
    let [light, heavy] = [impacts.shares[0], impacts.shares[1]];
    assert!((light - 400.0).abs() < 400.0 * ROUNDING && (heavy - 2.0).abs() < ROUNDING, "{light} {heavy}");
}

#[test]
fn closed_form_bounces_that_follow_one_another_ever_faster() {
    // Two equal bodies fall, the lower one pulled down faster: restitution 1/2 at the ground, 0
    // between them. If both fall at v, the lower one bounces at v/2, meets the upper one, and both
    // fall at v/4. Each pause is of the size of the square of the last one: soon there is no
    // double between two impacts, and in the end both bodies rest.
    let d = Description {
        gravity: 9.81,
        bodies: vec![heavy("lower", 1.0, -1.0, 0.1, 0.0), heavy("upper", 1.0, -1.0, 0.101, -1.0)],
        loads: vec![Load { name: "down".into(), body: 0, force: constant(-5.0) }],
        stops: vec![
            rigid("ground", &[(0, -1.0)], 0.0, 0.5),
            rigid("between", &[(0, 1.0), (1, -1.0)], 0.0, 0.0),
        ],
        ..Description::default()
    };
    let mut m = motion(d);
    let all = events(&mut m, 0.15);
    let speeds: Vec<(f64, f64)> = all
        .iter()
        .filter_map(|e| match e.kind {
            EventKind::Impact { stop: 0, speed, .. } => Some((e.time, speed)),
            _ => None,
        })
        .collect();
    let (last, _) = speeds[speeds.len() - 1];
    assert!(speeds.len() > 15, "{all:#?}");
    // The accelerations between two of these impacts add 1e-9 m/s.
    let same_instant = |pair: &&[(f64, f64)]| pair[0].0 == last && pair[1].0 == last;
    for pair in speeds.windows(2).filter(same_instant) {
        assert!((pair[1].1 - 0.25 * pair[0].1).abs() < 2e-9 * (pair[0].1 / 2e-3), "{pair:?}");
    }
    for i in 0..2 {
        assert!(m.body(i)[0].abs() < ROUNDING && m.body(i)[1].abs() < ROUNDING, "{:?} {all:#?}", m.body(i));
    }
}

#[test]
fn closed_form_redundant_friction_that_was_released_holds_again() {
    // A sled held by two frictions on the ground carries a block that a load pulls. While the
    // block sticks, the load exceeds the static levels on the ground; once it slips at its level
    // of 1.5, the two frictions of 1 each suffice: the sled never moves.
    let ground = || Friction { static_force: Some(constant(1.1)), ..friction(&[(1, 1.0)], 1.0) };
    let block = Friction { static_force: Some(constant(4.0)), ..friction(&[(1, -1.0), (0, 1.0)], 1.5) };
    let d = Description {
        bodies: vec![body("block", 0.1, 0.0, 0.0), body("sled", 1.0, 0.0, 0.0)],
        frictions: vec![ground(), ground(), block],
        loads: vec![Load {
            name: "pull".into(),
            body: 0,
            force: Signal { steps: vec![Step { time: 0.25, height: 4.5 }], ..Signal::default() },
        }],
        ..Description::default()
    };
    let mut m = motion(d);
    let all = events(&mut m, 0.75);
    let slips = times(&all, |k| matches!(k, EventKind::Slip { .. }));
    assert_eq!(slips, [0.25], "{all:?}");
    assert!((m.body(0)[0] - 15.0 * 0.25).abs() < ROUNDING && m.body(1)[0..2] == [0.0, 0.0]);
    let shares = [m.friction(0)[2], m.friction(1)[2]];
    assert!((shares[0] + shares[1] - 1.5).abs() < ROUNDING, "{shares:?}");
    assert!(shares.iter().all(|f| *f >= 0.0 && *f <= 1.1), "{shares:?}");
}
