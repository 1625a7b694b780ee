//! Motions against closed forms.

mod common;

use common::*;
use vibro_assembly::description::*;
use vibro_assembly::motion::EventKind;

/// Some roundings of numbers of order one, and of sums of a few hundred of them.
const ROUNDING: f64 = 1e-12;

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
    // Base sin t, gap 3, restitution 0.5: a motion with two impacts a period, approach speed V = 1.50557395311726.
    let base = sine(1.0, 1.0 / std::f64::consts::TAU, 0.0);
    let d = Description {
        bodies: vec![prescribed("base", base, 0.0), body("block", 1.0, 0.0, 0.9)],
        stops: vec![rigid("upper", &[(0, -1.0), (1, 1.0)], 1.5, 0.5), rigid("lower", &[(0, 1.0), (1, -1.0)], 1.5, 0.5)],
        ..Description::default()
    };
    let mut motion = motion(d);
    let all = events(&mut motion, 400.0);
    let last = all.iter().rev().find_map(|e| if let EventKind::Impact { speed, .. } = e.kind { Some(speed) } else { None });
    println!("impact pair {last:?} of {}", all.len());
}

#[test]
fn closed_form_impact_on_a_spring() {
    // m = 100, k = 1e6 contact beside mount 1e4, v = 1: F = 9950.37190209989 N, 0.0312600152681233 s.
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
    // Three equal balls that touch: Newton's law with restitution 1 gives (-1/3, 2/3, 2/3) v; apart, (0, 0, 1) v.
    for (gap, expected) in [(0.0, [-1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]), (0.01, [0.0, 0.0, 1.0])] {
        let d = Description {
            bodies: vec![body("a", 1.0, -1.0, 1.0), body("b", 1.0, 0.0, 0.0), body("c", 1.0, 0.0, 0.0)],
            stops: vec![rigid("ab", &[(0, 1.0), (1, -1.0)], 0.0, 1.0), rigid("bc", &[(1, 1.0), (2, -1.0)], gap, 1.0)],
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
    // MSL Translational.ElastoGap: m = 1, c = 10, d = 1.5, gaps ±0.5, from 2: s(5) = -0.707885294079811.
    let d = Description {
        bodies: vec![body("mass", 1.0, 2.0, 0.0)],
        stops: vec![
            compliant("upper", &[(0, 1.0)], 0.5, 10.0, 1.5, DampingLimit::Elastogap),
            compliant("lower", &[(0, -1.0)], 0.5, 10.0, 1.5, DampingLimit::Elastogap),
        ],
        ..Description::default()
    };
    let mut m = motion(d);
    let all = events(&mut m, 5.0);
    println!("elastogap {:?}\n{all:#?}", m.body(0));
    println!("balance {}", m.energy().balance());
}
