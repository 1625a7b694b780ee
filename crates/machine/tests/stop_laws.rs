//! Compliant stops that may pull, and stops whose dashpot acts only in compression
//! (docs/assembly-law.md (A14)).

use crate::common::both_laws::{Balance, BothLaws, on_machines};
use crate::common::machines::assembly;
use crate::common::*;
use proptest::prelude::*;
use std::cell::Cell;
use std::f64::consts::{PI, TAU};
use vibro_machine::description::*;
use vibro_machine::mode::StopState;
use vibro_machine::motion::{Event, EventKind};

/// Roundings of a few dozen operations.
const ROUNDING: f64 = 1e-13;
/// Energy error relative to a random machine's largest energy: stiff buffers amplify rounding.
const BALANCE: f64 = 1e-10;
/// Difference between the direct and the general law, as in tests/lone_events.rs.
const SAME: f64 = 1e-12;
const BOTH: BothLaws = BothLaws { events: 300, end: 4.0, rounding: SAME };

const M: f64 = 2.0;
const K: f64 = 800.0;
const C: f64 = 12.0;
const V: f64 = 0.7;

/// A body that flies into a stop at 0.1 m and comes back.
fn flier(limit: DampingLimit) -> Description {
    Description {
        bodies: vec![body("b", M, 0.0, V)],
        stops: vec![compliant("buffer", &[(0, 1.0)], 0.1, K, C, limit)],
        ..Description::default()
    }
}

/// Decay rate and angular frequency of the body on spring and dashpot.
fn damped() -> (f64, f64) {
    let delta = C / (2.0 * M);
    (delta, (K / M - delta * delta).sqrt())
}

/// Half a turn of x = v/ω exp(-δt) sin ωt, at the end of which the stop pulls: the force is c x'
/// at both ends.
#[test]
fn closed_form_a_stop_that_pulls_is_left_after_half_a_turn() {
    let (delta, omega) = damped();
    let mut m = motion(flier(DampingLimit::Pull));
    let (begin, end) = (0.1 / V, 0.1 / V + PI / omega);
    let mut lowest = f64::INFINITY;
    for k in 1..50 {
        let t = PI / omega * f64::from(k) / 50.0;
        m.advance_to(begin + t).unwrap();
        let (x, turn) = (V / omega * (-delta * t).exp() * (omega * t).sin(), (omega * t).cos());
        let rate = V * (-delta * t).exp() * turn - delta * x;
        assert!((m.stop(0)[0] - 0.1 - x).abs() < ROUNDING && (m.stop(0)[1] - rate).abs() < ROUNDING);
        assert!((m.stop(0)[2] - K * x - C * rate).abs() < K * ROUNDING, "{:?}", m.stop(0));
        assert_eq!(m.mode().stops[0], StopState::Pressed);
        lowest = lowest.min(m.stop(0)[2]);
    }
    assert!(lowest < -0.3 * C * V, "{lowest}: it pulls");
    let mut m = motion(flier(DampingLimit::Pull));
    let all = events(&mut m, 1.0);
    let kinds: Vec<_> = all.iter().map(|e| (e.time, e.kind)).collect();
    assert_eq!(kinds.len(), 2, "{kinds:?}");
    assert!((kinds[0].0 - begin).abs() < ROUNDING && (kinds[1].0 - end).abs() < ROUNDING, "{kinds:?}");
    assert!(matches!(kinds[0].1, EventKind::Press { speed, .. } if (speed - V).abs() < ROUNDING));
    assert!(matches!(kinds[1].1, EventKind::Free { stop: 0, .. }), "{kinds:?}");
    let left = -V * (-delta * PI / omega).exp();
    assert!((m.body(0)[1] - left).abs() < ROUNDING, "{:?} {left}", m.body(0));
    let lost = 0.5 * M * (V * V - left * left);
    assert!((m.energy().stops[0].value() - lost).abs() < ROUNDING, "{:?}", m.energy());
}

/// The force of spring and dashpot is zero at tan ωt = -2δω/(ω² - δ²), before the body is back at
/// the gap. Under every law a contact has one beginning and one end.
#[test]
fn closed_form_a_contact_ends_once_with_its_rate() {
    let (delta, omega) = damped();
    let turn = PI - 2.0 * (delta / omega).atan();
    let end = 0.1 / V + turn / omega;
    let rate = V * (-delta * turn / omega).exp() * (turn.cos() - delta / omega * turn.sin());
    let all = events(&mut motion(flier(DampingLimit::NoPull)), 1.0);
    let [_, Event { time, kind: EventKind::Free { rate: found, .. } }] = all[..] else { panic!("{all:?}") };
    assert!((time - end).abs() < ROUNDING && (found - rate).abs() < ROUNDING, "{time} {end} {found} {rate}");
    for limit in [DampingLimit::Elastogap, DampingLimit::Pull, DampingLimit::UndampedRebound] {
        let mut m = motion(flier(limit));
        let all = events(&mut m, 1.0);
        let told: Vec<_> = all.iter().filter(|e| !matches!(e.kind, EventKind::Cap { .. })).collect();
        let [EventKind::Press { .. }, EventKind::Free { rate, .. }] =
            told.iter().map(|e| e.kind).collect::<Vec<_>>()[..]
        else {
            panic!("{limit:?} {all:?}")
        };
        // After its end the contact changes no rate.
        assert!((rate - m.body(0)[1]).abs() < ROUNDING, "{limit:?} {rate} {:?}", m.body(0));
    }
}

/// Damped until it reverses, at tan ωt = ω/δ, and half a cosine after that; the reversal is not
/// reported as an event.
#[test]
fn closed_form_a_stop_without_a_dashpot_in_the_rebound() {
    let (delta, omega) = damped();
    let own = (K / M).sqrt();
    let mut m = motion(flier(DampingLimit::UndampedRebound));
    let (begin, turn) = (0.1 / V, (omega / delta).atan() / omega);
    let deep = V / omega * (-delta * turn).exp() * (omega * turn).sin();
    let all = events(&mut m, 1.0);
    assert_eq!(all.len(), 2, "{all:?}");
    assert!(matches!(all[0].kind, EventKind::Press { .. }) && (all[0].time - begin).abs() < ROUNDING);
    let left = begin + turn + 0.25 * TAU / own;
    assert!(matches!(all[1].kind, EventKind::Free { .. }) && (all[1].time - left).abs() < ROUNDING);
    assert!((m.body(0)[1] + own * deep).abs() < ROUNDING, "{:?}", m.body(0));
    let lost = 0.5 * M * V * V - 0.5 * K * deep * deep;
    assert!((m.energy().stops[0].value() - lost).abs() < ROUNDING, "{:?}", m.energy());
    let mut m = motion(flier(DampingLimit::UndampedRebound));
    m.advance_to(begin + 0.9 * turn).unwrap();
    assert_eq!(m.mode().stops[0], StopState::Pressed);
    let [e, rate, force] = m.stop(0);
    assert!((force - K * (e - 0.1) - C * rate).abs() < K * ROUNDING);
    m.advance_to(begin + turn + 0.01).unwrap();
    assert_eq!(m.mode().stops[0], StopState::Rebounding);
    let x = deep * (own * 0.01).cos();
    let [e, _, force] = m.stop(0);
    assert!((e - 0.1 - x).abs() < ROUNDING && (force - K * x).abs() < K * ROUNDING, "{e} {force}");
}

/// A body on such a stop under its weight loses energy in each compression until it is at rest,
/// and stays there.
#[test]
fn invariant_a_body_comes_to_rest_on_a_stop_without_a_dashpot_in_the_rebound() {
    let mut m = motion(Description {
        gravity: 10.0,
        bodies: vec![heavy("b", 1.0, 1.0, 0.0, 0.0)],
        stops: vec![compliant("pad", &[(0, 1.0)], 0.0, 100.0, 6.0, DampingLimit::UndampedRebound)],
        ..Description::default()
    });
    m.advance_to(60.0).unwrap();
    assert!((m.body(0)[0] - 0.1).abs() < 1e-12 && m.body(0)[1].abs() < 1e-11, "{:?}", m.body(0));
    let (kinetic, stored) = m.kinetic_and_stored();
    assert!((kinetic + stored - m.energy().balance()).abs() < ROUNDING);
    m.advance_to(600.0).unwrap();
    assert!((m.body(0)[0] - 0.1).abs() < 1e-12, "{:?}", m.body(0));
}

/// Without a dashpot all laws agree, bit for bit.
#[test]
fn invariant_laws_without_a_dashpot_agree() {
    let of = |limit| {
        let mut d = flier(limit);
        let StopLaw::Compliant { damping, .. } = &mut d.stops[0].law else { panic!() };
        *damping = 0.0;
        d.bodies[0].kind = BodyKind::Free(Free { inertia: M, gravity: 0.0, s: 0.0, v: V });
        let mut m = motion(d);
        let all = events(&mut m, 1.0);
        (all, m.body(0))
    };
    let (events, [s, v, _]) = of(DampingLimit::NoPull);
    for limit in [DampingLimit::Pull, DampingLimit::UndampedRebound] {
        let (own, body) = of(limit);
        assert_eq!(events.len(), own.len());
        assert!(events.iter().zip(&own).all(|(a, b)| (a.time - b.time).abs() < ROUNDING));
        assert!((body[0] - s).abs() < ROUNDING && (body[1] - v).abs() < ROUNDING);
    }
}

#[test]
fn second_method_derivatives_of_a_machine_with_both_laws() {
    let (names, met) = differences::compare(&laws(), 0.35);
    assert!(met >= 4 && names.len() > 20, "{met} {names:?}");
}

/// Derivatives of the final state by every number of the machine, compared with differences.
#[test]
fn second_method_derivatives_against_differences() {
    for limit in [DampingLimit::Pull, DampingLimit::UndampedRebound] {
        let mut d = flier(limit);
        (d.name, d.gravity) = ("M".into(), 2.0);
        d.bodies = vec![heavy("b", M, 0.3, 0.0, V)];
        d.springs = vec![spring(&[(0, 1.0)], 30.0, 0.5)];
        d.loads = vec![Load { name: "l".into(), body: 0, force: sine(3.0, 1.7, 0.4) }];
        let (names, met) = differences::compare(&d, 2.3);
        assert!(met >= 4 && names.len() > 10, "{met} {names:?}");
    }
}

/// The machine with its compliant stops under the new laws.
fn relawed(mut d: Description) -> Description {
    let mut pulls = false;
    for stop in &mut d.stops {
        if let StopLaw::Compliant { limit, .. } = &mut stop.law {
            *limit = if pulls { DampingLimit::Pull } else { DampingLimit::UndampedRebound };
            pulls = !pulls;
        }
    }
    d
}

#[test]
fn invariant_random_machines_keep_their_energy_and_both_ways_of_the_law_agree() {
    let [events, turns] = [Cell::new(0), Cell::new(0)];
    on_machines(&assembly().prop_map(relawed), 200, |start| {
        let mut balance = Balance::new(&start);
        BOTH.follow(start, |handled| {
            let m = handled.direct;
            balance.check(m, BALANCE)?;
            let least = -BALANCE * balance.largest;
            prop_assert!(m.energy().stops.iter().all(|lost| lost.value() > least));
            let changed = handled.before.stops.iter().zip(&m.mode().stops);
            let turned = changed.filter(|(a, b)| a != b && **b == StopState::Rebounding);
            turns.set(turns.get() + turned.count());
            events.set(events.get() + 1);
            Ok(())
        })
    });
    let [events, turns] = [events, turns].map(|count| count.get());
    println!("{events} events, {turns} turns");
    assert!(events > 2000 && turns > 50, "{events} {turns}");
}
