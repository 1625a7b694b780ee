//! Friction whose level follows the force of a compliant stop (docs/assembly-law.md, section 4).

use crate::common::both_laws::{Balance, BothLaws, on_machines};
use crate::common::machines::assembly;
use crate::common::*;
use proptest::prelude::*;
use std::cell::Cell;
use std::sync::Arc;
use vibro_machine::description::*;
use vibro_machine::file::{no_records, parse};
use vibro_machine::mode::FrictionState;
use vibro_machine::motion::{Event, EventKind};
use vibro_machine::{Assembly, Motion};

/// Roundings of a few dozen operations.
const ROUNDING: f64 = 1e-12;
/// Relative errors of a random machine: its energy, and the difference between direct and general
/// law in the largest coordinate. Stiff buffers amplify rounding.
const BALANCE: f64 = 1e-10;
const BOTH: BothLaws = BothLaws { events: 200, end: 3.0, rounding: BALANCE };

const MU: f64 = 0.3;

/// A pin that bounces on a pad, and a slide that the pad's force brakes.
fn pin(limit: DampingLimit, damping: f64) -> Description {
    Description {
        name: "Pin".into(),
        bodies: vec![body("pin", 2.0, 0.0, 0.5), body("slide", 1.5, 0.0, 3.0)],
        stops: vec![compliant("pad", &[(0, 1.0)], 0.1, 800.0, damping, limit)],
        frictions: vec![following(&[(1, 1.0)], 0, MU, None)],
        ..Description::default()
    }
}

fn following(terms: &[(usize, f64)], stop: usize, coefficient: f64, largest: Option<f64>) -> Friction {
    let follows = Some(Follows { stop, coefficient, static_coefficient: largest });
    Friction { follows, ..friction(terms, 0.0) }
}

/// The slide loses μ times the impulse of the pad, for any law of the pad. Without a dashpot, the
/// impulse of a contact is 2 m v.
#[test]
fn closed_form_a_slide_is_braked_by_the_impulse_of_a_pad() {
    let mut m = motion(pin(DampingLimit::NoPull, 0.0));
    let all = events(&mut m, 1.0);
    let kinds: Vec<EventKind> = all.iter().map(|e| e.kind).collect();
    assert!(matches!(kinds[..], [EventKind::Press { .. }, EventKind::Free { .. }]), "{kinds:?}");
    assert!((m.body(1)[1] - (3.0 - MU * 2.0 * 2.0 * 0.5 / 1.5)).abs() < ROUNDING, "{:?}", m.body(1));
    assert_eq!((m.mode().frictions[0], m.friction(0)[2]), (FrictionState::Off, 0.0));
    for (limit, damping) in [
        (DampingLimit::NoPull, 14.0),
        (DampingLimit::Elastogap, 14.0),
        (DampingLimit::UndampedRebound, 14.0),
        (DampingLimit::Elastogap, 90.0),
    ] {
        let mut m = motion(pin(limit, damping));
        m.advance_to(0.23).unwrap();
        let [_, _, f] = m.friction(0);
        assert!((f - MU * m.stop(0)[2]).abs() < ROUNDING && f > 1.0, "{limit:?}: {f} {:?}", m.stop(0));
        m.advance_to(2.0).unwrap();
        let impulse = 2.0 * (0.5 - m.body(0)[1]);
        assert!((m.body(1)[1] - (3.0 - MU * impulse / 1.5)).abs() < ROUNDING, "{limit:?} {:?}", m.body(1));
        let lost = 0.5 * 1.5 * (9.0 - m.body(1)[1].powi(2));
        assert!((m.energy().frictions[0].value() - lost).abs() < 10.0 * ROUNDING, "{limit:?}");
    }
}

/// A stop causes no friction while it pulls.
#[test]
fn closed_form_a_pull_makes_no_friction() {
    let (delta, mut d) = (14.0f64 / 4.0, pin(DampingLimit::Pull, 14.0));
    d.frictions[0].follows.as_mut().unwrap().coefficient = 0.2;
    let omega = (400.0 - delta * delta).sqrt();
    let mut m = motion(d);
    let all = events(&mut m, 1.0);
    // f = k x + c x' passes zero where tan ωt = c ω/(c δ - k), in the second quarter of a turn.
    let zero = 0.2 + (14.0 * omega).atan2(14.0 * delta - 800.0) / omega;
    let levels: Vec<f64> = times(&all, |k| matches!(k, EventKind::Level { acts: false, .. }));
    assert_eq!(levels.len(), 1, "{all:?}");
    assert!((levels[0] - zero).abs() < ROUNDING, "{levels:?} {zero}");
    // The momentum that the pad's force has transferred until then.
    let mut m = motion(pin(DampingLimit::Pull, 14.0));
    m.advance_to(zero).unwrap();
    let lost = MU * 2.0 * (0.5 - m.body(0)[1]) / 1.5;
    m.advance_to(1.0).unwrap();
    assert!((m.body(1)[1] - (3.0 - lost)).abs() < ROUNDING, "{:?}", m.body(1));
}

/// A plate that a spring presses on a pad sticks up to the static level, and slips at the kinetic
/// level: the drag at which it slips is μ_s N.
#[test]
fn closed_form_a_pressed_plate_sticks_up_to_its_static_level() {
    let ramp = Record::new(vec![(0.0, 0.0), (10.0, 100.0)], Interpolation::Straight);
    let mut m = motion(Description {
        name: "Plate".into(),
        bodies: vec![body("press", 1.0, 0.02, 0.0), body("plate", 2.0, 0.0, 0.0)],
        stops: vec![compliant("pad", &[(0, 1.0)], 0.0, 1000.0, 0.0, DampingLimit::NoPull)],
        frictions: vec![following(&[(1, 1.0)], 0, 0.3, Some(0.5))],
        loads: vec![
            Load { name: "down".into(), body: 0, force: constant(20.0) },
            Load { name: "drag".into(), body: 1, force: Signal { table: Some(ramp), ..Signal::default() } },
        ],
        ..Description::default()
    });
    assert_eq!(m.mode().frictions[0], FrictionState::Stuck);
    let all = events(&mut m, 1.5);
    let slips: Vec<_> = all.iter().filter(|e| matches!(e.kind, EventKind::Slip { .. })).collect();
    assert_eq!((slips.len(), all.len()), (1, 1), "{all:?}");
    assert!((slips[0].time - 1.0).abs() < ROUNDING, "{all:?}");
    // From rest at a drag of 10 N, which grows by 10 N/s, against 6 N of friction.
    let speed = (4.0 * 0.5 + 10.0 * 0.125) / 2.0;
    assert!((m.body(1)[1] - speed).abs() < ROUNDING, "{:?}", m.body(1));
    assert!((m.friction(0)[2] - 6.0).abs() < ROUNDING);
}

/// Stop and friction act on the same body: a wedge, which its own contact force brakes.
#[test]
fn closed_form_a_wedge_that_its_own_force_brakes() {
    // x'' = -ω² (1 + μ) x inwards, -ω² (1 - μ) x outwards.
    let mut m = motion(Description {
        name: "Wedge".into(),
        bodies: vec![body("b", 1.0, 0.0, 0.8)],
        stops: vec![compliant("pad", &[(0, 1.0)], 0.0, 400.0, 0.0, DampingLimit::NoPull)],
        frictions: vec![following(&[(0, 1.0)], 0, 0.3, None)],
        ..Description::default()
    });
    let all = events(&mut m, 1.0);
    let (inward, outward) = ((400.0f64 * 1.3).sqrt(), (400.0f64 * 0.7).sqrt());
    let half = 0.5 * std::f64::consts::PI;
    let turn = times(&all, |k| matches!(k, EventKind::Slip { .. }));
    let free = times(&all, |k| matches!(k, EventKind::Free { .. }));
    assert!((turn[0] - half / inward).abs() < ROUNDING, "{all:?}");
    assert!((free[0] - half / inward - half / outward).abs() < ROUNDING, "{all:?}");
    assert!((m.body(0)[1] + 0.8 * outward / inward).abs() < ROUNDING, "{:?}", m.body(0));
    // If μ > 1, the wedge locks.
    let mut m = motion(Description {
        name: "Wedge".into(),
        bodies: vec![body("b", 1.0, 0.0, 0.8)],
        stops: vec![compliant("pad", &[(0, 1.0)], 0.0, 400.0, 0.0, DampingLimit::NoPull)],
        frictions: vec![following(&[(0, 1.0)], 0, 1.2, None)],
        ..Description::default()
    });
    m.advance_to(1.0).unwrap();
    assert_eq!(m.mode().frictions[0], FrictionState::Stuck);
    assert!((m.body(0)[0] - 0.8 / (400.0f64 * 2.2).sqrt()).abs() < ROUNDING, "{:?}", m.body(0));
}

/// A start at rest on a belt whose drag follows the pad's force: two equations for both places.
#[test]
fn closed_form_a_start_at_rest_beside_a_belt() {
    let mut d = Description {
        name: "Belt".into(),
        starts_at_rest: true,
        bodies: vec![body("b", 1.0, 0.0, 0.0), prescribed("belt", constant(0.0), 0.5)],
        springs: vec![spring(&[(0, 1.0)], 100.0, 0.0)],
        stops: vec![compliant("pad", &[(0, -1.0)], 0.0, 400.0, 3.0, DampingLimit::NoPull)],
        frictions: vec![following(&[(1, -1.0), (0, 1.0)], 0, 0.3, None)],
        loads: vec![Load { name: "l".into(), body: 0, force: constant(-10.0) }],
        ..Description::default()
    };
    // -10 - 100 s - 400 s - 0.3 · 400 s = 0 for s < 0, with upward drag.
    let mut m = motion(d.clone());
    let place = -10.0 / 620.0;
    assert!((m.body(0)[0] - place).abs() < ROUNDING, "{:?} {place}", m.body(0));
    m.advance_to(2.0).unwrap();
    assert!((m.body(0)[0] - place).abs() < ROUNDING && m.body(0)[1].abs() < ROUNDING, "{:?}", m.body(0));
    d.loads[0].force = sine(4.0, 1.0, -0.7);
    d.loads[0].force.constant = -10.0;
    let (names, _) = differences::compare(&d, 1.0);
    assert!(names.iter().any(|name| name == "friction.friction.coefficient"), "{names:?}");
}

#[test]
fn second_method_derivatives_of_a_machine_with_friction_that_follows() {
    let (names, met) = differences::compare(&laws(), 0.35);
    assert!(met >= 4 && names.iter().any(|name| name == "friction.rub.static_coefficient"), "{names:?}");
    for limit in [DampingLimit::NoPull, DampingLimit::Elastogap, DampingLimit::Pull] {
        let mut d = pin(limit, 14.0);
        d.springs = vec![spring(&[(0, 1.0)], 30.0, 0.5), spring(&[(1, 1.0)], 20.0, 0.5)];
        d.loads = vec![Load { name: "l".into(), body: 0, force: sine(3.0, 1.7, 0.4) }];
        differences::compare(&d, 0.9);
    }
}

/// The machine with friction that follows its first compliant stop; `None` without one.
fn follows(mut d: Description) -> Option<Description> {
    let stop = d.stops.iter().position(|stop| matches!(stop.law, StopLaw::Compliant { .. }))?;
    if d.frictions.is_empty() {
        let terms = d.stops[stop].arms.terms[..1].to_vec();
        d.frictions = vec![friction(&terms, 0.0)];
    }
    for (i, own) in d.frictions.iter_mut().enumerate() {
        let largest = if i % 2 == 0 { None } else { Some(0.6) };
        (own.force, own.static_force) = (Signal::default(), None);
        own.follows = Some(Follows { stop, coefficient: 0.4, static_coefficient: largest });
    }
    Some(d)
}

#[test]
fn invariant_random_machines_keep_their_energy_and_both_ways_of_the_law_agree() {
    let count = Cell::new(0);
    on_machines(&assembly().prop_filter_map("no compliant stop", follows), 240, |start| {
        let mut balance = Balance::new(&start);
        BOTH.follow(start, |handled| {
            let m = handled.direct;
            balance.check(m, BALANCE)?;
            for (i, own) in m.assembly().description.frictions.iter().enumerate() {
                let stop = own.follows.as_ref().unwrap().stop;
                let [normal, force] = [m.stop(stop)[2], m.friction(i)[2]];
                let level = if m.mode().frictions[i].sticks() { 0.6 } else { 0.4 } * normal.max(0.0);
                let allowed = level + 1e-9 * balance.largest.max(normal);
                prop_assert!(force.abs() <= allowed, "{force} {normal}");
            }
            count.set(count.get() + 1);
            Ok(())
        })
    });
    assert!(count.get() > 1000, "{}", count.get());
}

/// A chain without tables of modes.
#[test]
fn invariant_a_chain_of_pads_that_brake_keeps_its_energy() {
    let count = 24;
    let mut d = Description {
        name: "Chain".into(),
        bodies: (0..count).map(|i| body(&format!("b{i}"), 0.2, 0.0, 0.0)).collect(),
        ..Description::default()
    };
    let laws =
        [DampingLimit::NoPull, DampingLimit::Elastogap, DampingLimit::Pull, DampingLimit::UndampedRebound];
    for i in 0..count {
        let terms = if i == 0 { vec![(0, 1.0)] } else { vec![(i - 1, -1.0), (i, 1.0)] };
        d.springs.push(Spring { name: format!("s{i}"), ..spring(&terms, 40.0, 0.02) });
        let law = laws[i % 4];
        d.stops.push(compliant(&format!("p{i}"), &terms, 0.002, 200.0, 0.8, law));
        let own = following(&[(i, 1.0)], i, 0.3, (i % 3 == 0).then_some(0.5));
        d.frictions.push(Friction { name: format!("f{i}"), ..own });
    }
    d.loads = vec![Load { name: "l".into(), body: count - 1, force: sine(2.0, 1.3, 0.2) }];
    let mut m = motion(d);
    let all = events(&mut m, 4.0);
    let (kinetic, stored) = m.kinetic_and_stored();
    assert!(all.len() > 200, "{}", all.len());
    let off = kinetic + stored - m.energy().balance();
    assert!(off.abs() < ROUNDING, "{off}");
    let rubbed: f64 = m.energy().frictions.iter().map(|lost| lost.value()).sum();
    assert!(rubbed > 0.01 && m.energy().frictions.iter().all(|lost| lost.value() > -ROUNDING), "{rubbed}");
}

const TEXT: &str = r#"
    name = "Rubs"
    [body.pin]
    mass = 2.0
    start = { v = 0.5 }
    [body.slide]
    mass = 1.5
    [stop.wall]
    between = ["ground", "slide"]
    gap = 1.0
    restitution = 0.5
    [stop.pad]
    between = ["ground", "pin"]
    gap = 0.1
    stiffness = 800.0
    [friction.rub]
    between = ["ground", "slide"]
    follows = "pad"
    coefficient = 0.3
    static_coefficient = 0.4
"#;

#[test]
fn golden_following_in_files() {
    let machine = parse(TEXT, "rubs.toml", &no_records).unwrap();
    let own = Follows { stop: 1, coefficient: 0.3, static_coefficient: Some(0.4) };
    assert_eq!(machine.frictions[0].follows, Some(own));
    assert_eq!(parse(&machine.to_toml(), "again.toml", &no_records).unwrap(), machine);
    assert_eq!(machine.get("friction.rub.static_coefficient").unwrap(), 0.4);
    for (from, to, message) in [
        (
            "follows = \"pad\"",
            "follows = \"wall\"",
            "m.toml:18: friction.rub.follows = \"wall\": this stop is rigid, and impacts with friction are not supported; use a compliant stop, \
             with `stiffness`",
        ),
        (
            "follows = \"pad\"",
            "follows = \"pat\"",
            "m.toml:18: friction.rub.follows = \"pat\": no stop has this name; did you mean `pad`?",
        ),
        (
            "static_coefficient = 0.4",
            "static_coefficient = 0.2",
            "m.toml:20: friction.rub.static_coefficient = 0.2: must be at least 0.3, the sliding friction friction.rub.coefficient",
        ),
        (
            "static_coefficient = 0.4",
            "force = 3.0",
            "m.toml:20: friction.rub.force = 3.0: cannot be combined with `follows`: use `coefficient` and `static_coefficient` for friction at a stop, or `force` and `static` for a given friction force",
        ),
        (
            "coefficient = 0.3\n",
            "coefficient = -0.3\n",
            "m.toml:19: friction.rub.coefficient = -0.3: must not be negative",
        ),
        (
            "follows = \"pad\"\n",
            "\n",
            "m.toml:16: friction.rub.follows: missing; expected the name of a compliant stop",
        ),
    ] {
        assert!(TEXT.contains(from), "{from}");
        let said = parse(&TEXT.replacen(from, to, 1), "m.toml", &no_records).unwrap_err().to_string();
        assert!(said.starts_with(message), "{said}");
    }
    let mut told = Vec::new();
    let mut m = Motion::new(Arc::new(Assembly::new(machine).unwrap())).unwrap();
    m.advance_observed(1.0, &mut |e: &Event| told.push(e.kind)).unwrap();
    assert!(told.iter().all(|kind| !matches!(kind, EventKind::Level { .. })), "{told:?}");
}
