//! Each energy account compared with a quadrature of the elements' powers, and the work of jumps
//! with closed forms.

use crate::common::*;
use vibro_machine::Motion;
use vibro_machine::description::*;
use vibro_machine::mode::StopState;

/// Longest interval of the quadrature, s, by Gauss's rule with three nodes: for motions of 20
/// rad/s its error is below 1e-9 of a power's size.
const PART: f64 = 2e-3;
/// Error of the quadrature, J.
const QUADRATURE: f64 = 1e-8;
/// Tens of roundings of energies of order one.
const ROUNDING: f64 = 1e-12;

const GAUSS: [(f64, f64); 3] =
    [(0.112_701_665_379_258_3, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.887_298_334_620_741_7, 5.0 / 18.0)];

/// The integrals of powers up to a time, by quadrature between events.
fn quadrature(mut m: Motion, end: f64, powers: impl Fn(&Motion) -> Vec<f64>) -> Vec<f64> {
    let mut sums = vec![0.0; powers(&m).len()];
    while m.time() < end {
        let from = m.time();
        let mut ahead = m.clone();
        ahead.advance_before_event(end, &mut |_| {}).unwrap();
        let span = ahead.time() - from;
        let parts = (span / PART).ceil().max(1.0);
        for part in 0..parts as usize {
            for (node, weight) in GAUSS {
                m.advance_to(from + span * (part as f64 + node) / parts).unwrap();
                let now = powers(&m);
                sums.iter_mut().zip(now).for_each(|(sum, p)| *sum += weight * span / parts * p);
            }
        }
        ahead.apply_event(&mut |_| {}).unwrap();
        m = ahead;
    }
    sums
}

/// Two bodies linked to a prescribed one, with a load on each, elements of every kind, and a base
/// with friction on one of them.
fn linked() -> Description {
    let p = 2;
    Description {
        gravity: 9.81,
        bodies: vec![
            heavy("a", 1.0, 1.0, 0.0, 0.0),
            heavy("b", 3.0, -0.5, 0.0, 0.0),
            prescribed("p", sine(0.2, 0.7, 0.0), 0.0),
            prescribed("belt", constant(0.0), 0.2),
        ],
        links: vec![Link { name: "l".into(), arms: arms(&[(0, 2.0), (1, 1.0), (p, -1.0)]) }],
        springs: vec![
            Spring { preload: 1.5, ..spring(&[(0, -1.0), (1, 1.0)], 40.0, 0.7) },
            Spring { preload: -2.5, ..spring(&[(p, -1.0), (1, 1.0)], 20.0, 0.3) },
        ],
        stops: vec![
            compliant("pulls", &[(0, 1.0)], 0.1, 150.0, 3.0, DampingLimit::NoPull),
            compliant("capped", &[(1, -1.0), (p, 1.0)], 0.1, 150.0, 5.0, DampingLimit::Elastogap),
        ],
        frictions: vec![friction(&[(3, -1.0), (0, 1.0)], 1.3)],
        loads: vec![
            Load { name: "on_a".into(), body: 0, force: sine(4.0, 1.1, 0.3) },
            Load { name: "on_b".into(), body: 1, force: Signal { constant: 2.0, ..sine(3.0, 0.9, 1.0) } },
        ],
        ..Description::default()
    }
}

/// The powers of [`linked`]: loads, motions, dashpots, stops, friction.
fn powers_of_linked(m: &Motion) -> Vec<f64> {
    let [a, b, p, belt] = [0, 1, 2, 3].map(|i| m.body(i));
    let [mutual, base] = [0, 1].map(|i| m.spring(i));
    let [pulls, capped] = [0, 1].map(|i| m.stop(i));
    let rubs = m.friction(0);
    let stored = |e: f64| 150.0 * (e - 0.1).max(0.0);
    // The link's force from the balance of `b`; the balance of `a` must give the same.
    let on_a = m.load(0) + 9.81 + mutual[2] - pulls[2] - rubs[2];
    let on_b = m.load(1) - 0.5 * 3.0 * 9.81 - mutual[2] - base[2] + capped[2];
    let link = 3.0 * b[2] - on_b;
    assert!((a[2] - on_a - 2.0 * link).abs() < 1e-9, "{} {}", a[2] - on_a, 2.0 * link);
    // The drive of a prescribed body balances the forces on it.
    let on_p = base[2] - capped[2] - link;
    vec![
        m.load(0) * a[1],
        m.load(1) * b[1],
        -on_p * p[1] - rubs[2] * belt[1],
        0.7 * mutual[1] * mutual[1],
        0.3 * base[1] * base[1],
        (pulls[2] - stored(pulls[0])) * pulls[1],
        (capped[2] - stored(capped[0])) * capped[1],
        rubs[2] * rubs[1],
    ]
}

#[test]
fn second_method_each_account_by_a_quadrature() {
    let mut m = motion(linked());
    let end = 6.0;
    let sums = quadrature(m.clone(), end, powers_of_linked);
    let all = events(&mut m, end);
    assert!(all.len() > 12, "{all:?}");
    let e = m.energy();
    let accounts = e.loads.iter().chain([&e.motions]).chain(&e.dashpots).chain(&e.stops).chain(&e.frictions);
    for (k, (account, sum)) in accounts.zip(&sums).enumerate() {
        assert!(sum.abs() > 0.01, "{k}: {sum} is no test");
        assert!((account.value() - sum).abs() < QUADRATURE, "{k}: {} {sum}", account.value());
    }
    assert_eq!(e.impacts.value(), 0.0);
}

#[test]
fn closed_form_work_of_motions_and_loss_at_jumps_and_impacts() {
    // The link splits a jump by 4 m/s into 3 m/s for 1 kg and 1 m/s for 3 kg: 6 J, an impulse of
    // 3 N s at a mean of 2 m/s. The second jump, back to 1 m/s, is an impulse of -2.25 N s at a
    // mean of 2.5 m/s.
    let table = Record::new(vec![(0.25, 0.0), (0.5, 1.0), (0.75, 1.25)], Interpolation::Straight);
    let moved = Signal { table: Some(table), ..Signal::default() };
    let d = Description {
        bodies: vec![body("a", 1.0, 0.0, 0.0), body("b", 3.0, 0.0, 0.0), prescribed("p", moved, 0.0)],
        links: vec![Link { name: "l".into(), arms: arms(&[(0, 1.0), (1, 1.0), (2, -1.0)]) }],
        ..Description::default()
    };
    let mut m = motion(d);
    for (time, work) in [(0.3, 6.0), (0.6, 6.0 - 5.625), (0.8, 0.0)] {
        m.advance_to(time).unwrap();
        assert!((m.energy().motions.value() - work).abs() < ROUNDING, "{time}: {:?}", m.energy());
        assert!((m.kinetic_and_stored().0 - work).abs() < ROUNDING);
    }
    // A ball of 2 kg meets a plate that approaches at 1 m/s: closing speed 3 m/s, with e = 0.5 an
    // impulse of 9 N s.
    let d = Description {
        bodies: vec![body("ball", 2.0, 0.0, 2.0), prescribed("plate", constant(0.6), -1.0)],
        stops: vec![rigid("s", &[(0, 1.0), (1, -1.0)], 0.0, 0.5)],
        ..Description::default()
    };
    let mut m = motion(d);
    m.advance_to(0.3).unwrap();
    let e = m.energy();
    assert!((e.impacts.value() - 0.5 * 0.5 * 3.0 * 9.0).abs() < ROUNDING, "{e:?}");
    // The plate moves at -1 m/s against an impulse of 9 N s: work 9 J.
    assert!((e.motions.value() - 9.0).abs() < ROUNDING, "{e:?}");
}

#[test]
fn closed_form_a_buffer_whose_force_ends_just_where_a_wall_throws_the_body_back() {
    // On the way out the buffer's force k x + c x' vanishes at x > 0. The wall there reverses x',
    // so that the force jumps to k x + c |x'| and leaves its limit, although it falls from there
    // on.
    let (k, c) = (100.0, 15.0);
    let mut d = Description {
        bodies: vec![body("b", 1.0, 0.05, 0.0)],
        stops: vec![compliant("buffer", &[(0, 1.0)], 0.0, k, c, DampingLimit::NoPull)],
        ..Description::default()
    };
    let mut m = motion(d.clone());
    m.advance_to_event(1.0, &mut |_| {}).unwrap();
    let ([s, v, _], time) = (m.body(0), m.time());
    assert!(m.mode().stops[0] == StopState::Free && s > 0.0 && v < 0.0, "{s} {v}");
    // The wall is so little beyond that point that both events count as simultaneous.
    d.stops.push(rigid("wall", &[(0, -1.0)], -s + 3e-15, 1.0));
    let mut m = motion(d);
    m.advance_to(time + 1e-9).unwrap();
    assert_eq!((m.impacts(1).count, m.mode().stops[0]), (1, StopState::Pressed));
    let exact = k * s - c * v;
    assert!((m.stop(0)[2] / exact - 1.0).abs() < 1e-6, "{:?} {exact}", m.stop(0));
}
