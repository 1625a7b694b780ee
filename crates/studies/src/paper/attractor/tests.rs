use super::record::{ObservedPeriod, approaches, period};
use super::*;
use crate::class::{LONGEST, RETURN};
use crate::paper::motion::settled_simulator;
use crate::paper::stroboscopic::moving_block;
use vibro_impact::parameters::{Groups, Scales};
use vibro_impact::simulator::{Contact, Loads, State};

/// Periods of a constructed motion.
fn periods(coordinate: impl Fn(f64) -> f64, pattern: impl Fn(u64) -> u64) -> Vec<ObservedPeriod> {
    (0..u64::from(OBSERVED))
        .map(|n| ObservedPeriod {
            state: [coordinate(n as f64); 6],
            pattern: pattern(n),
            impacts: [1; 2],
            rests: false,
        })
        .collect()
}

#[test]
fn closed_form_periods_of_made_up_motions() {
    use std::f64::consts::TAU;
    assert_eq!(period(&periods(|_| 0.3, |_| 1)), Some(1));
    assert_eq!(period(&periods(|n| (TAU * n / 4.0).cos(), |_| 1)), Some(4));
    // The states alone repeat after 1 period, the sequence of impacts after 3.
    assert_eq!(period(&periods(|_| 0.3, |n| n % 3)), Some(3));
    assert_eq!(period(&periods(|n| (TAU * n / f64::from(LONGEST)).cos(), |_| 1)), Some(LONGEST));
    let torus = periods(|n| (TAU * n * 0.381_966_011).cos(), |_| 1);
    assert_eq!((period(&torus), approaches(&torus)), (None, false));
    // An alternating transient that decays by half a per cent a period.
    let slow = periods(|n| 0.995f64.powf(n) * if n % 2.0 == 0.0 { 1.0 } else { -1.0 }, |_| 1);
    assert_eq!((period(&slow), approaches(&slow)), (None, true));
}

#[test]
fn invariant_the_stable_symmetric_motion_is_its_own_mirror_image() {
    let p = Groups::basic().to_parameters(Scales::default()).unwrap();
    let mut simulator = settled_simulator(&p, &moving_block(&p), 400.0).unwrap();
    let found = observe(&mut simulator).unwrap();
    assert_eq!((found.period, found.impacts, found.rests), (Some(1), [1.0, 1.0], false));
    assert!(found.is_symmetric() && !found.approaching);
    assert_eq!(MotionClass::of(&found, None, &p), MotionClass::Periodic(1));
}

#[test]
fn second_method_impacts_of_a_motion_that_settles_under_observation() {
    // Finally three impacts per period; the usual 400 discarded periods are omitted here.
    let groups = Groups { f10: 3.9, ..Groups::basic() };
    let p = groups.to_parameters(Scales::default()).unwrap();
    let [early, late] =
        [5.0, 400.0].map(|n| observe(&mut settled_simulator(&p, &moving_block(&p), n).unwrap()).unwrap());
    assert_eq!((early.period, late.period), (Some(1), Some(1)));
    assert_eq!(early.impacts.iter().sum::<f64>(), 3.0);
    assert_ne!(early.relation(&late), Relation::Different);
}

#[test]
fn closed_form_motions_without_impacts_have_one_limit() {
    // The slow oscillation of block and secondary oscillator loses about a thousandth per period.
    let groups = Groups { f10: 0.4, sigma1: 2.0, ..Groups::basic() };
    let p = groups.to_parameters(Scales::default()).unwrap();
    let start = |v2| vibro_impact::simulator::State { x: [0.0; 3], v: [0.0, v2, 0.0] };
    let [slow, fast] =
        [0.02, 0.1].map(|v2| observe(&mut settled_simulator(&p, &start(v2), 300.0).unwrap()).unwrap());
    assert!(slow.is_free() && slow.period.is_none() && slow.approaching, "{slow:?}");
    assert_eq!(slow.relation(&fast), Relation::Same);
    // The limit: x1 = Re((sin - i cos) ...) of the box alone, with the other two at rest.
    let late = observe(&mut settled_simulator(&p, &start(0.1), 20_000.0).unwrap()).unwrap();
    let (stiffness, damping) =
        (p.box_stiffness - p.box_mass * p.drive_frequency.powi(2), p.box_damping * p.drive_frequency);
    let amplitude = p.drive_amplitude / stiffness.hypot(damping) / p.stop_gap;
    assert_eq!((late.period, late.is_symmetric()), (Some(1), true));
    assert!(
        (late.states[0][0].hypot(late.states[0][3] * p.box_frequency() / p.drive_frequency) - amplitude)
            .abs()
            < RETURN
    );
    assert!(late.states[0][1].abs() < RETURN && late.states[0][2].abs() < RETURN);
    assert_eq!(late.relation(&slow), Relation::Same);
}

#[test]
fn closed_form_classes_by_exponents() {
    let p = Groups::basic().to_parameters(Scales::default()).unwrap();
    let attractor = |approaching| Attractor {
        period: None,
        approaching,
        impacts: [1.0; 2],
        rests: false,
        states: vec![[0.0; 6]],
        mirror_states: vec![[0.0; 6]],
        sizes: [1.0; 3],
        statistics: None,
    };
    let spectrum = |first: f64, second: f64| Spectrum {
        exponents: [first, second, -1.0, -1.0, -1.0, -1.0, f64::NEG_INFINITY],
        deviation: 0.0,
        periods: 1500,
        settled: false,
        impacts: 3000,
        rests: false,
    };
    let class = |approaching, first, second| {
        MotionClass::of(&attractor(approaching), Some(&spectrum(first, second)), &p)
    };
    assert_eq!(class(false, 0.05, 0.0), MotionClass::Chaotic);
    assert_eq!(class(false, 0.95e-3, 0.0), MotionClass::QuasiPeriodic);
    assert_eq!(class(true, 0.0, 0.0), MotionClass::Settling);
    assert_eq!(class(false, 0.0, -0.1), MotionClass::Settling);
    assert_eq!(MotionClass::of(&attractor(false), None, &p), MotionClass::NotSettled);
    // With a box frequency a thousand times the drive's.
    let stiff = Parameters { box_stiffness: 1e6 * p.box_stiffness, ..p };
    assert_eq!(MotionClass::of(&attractor(false), Some(&spectrum(2e-4, 0.0)), &stiff), MotionClass::Chaotic);
}

/// A weight on the block that exceeds all forces of the drive holds it at the lower stop: it has
/// no impacts, but is not free either.
#[test]
fn closed_form_a_block_that_a_load_holds_at_a_stop_rests_throughout() {
    let p = Groups { f10: 0.1, ..Groups::basic() }.to_parameters(Scales::default()).unwrap();
    let held = State { x: [0.0, -p.stop_gap, 0.0], v: [0.0; 3] };
    let mut simulator = Simulator::new(&p, &held, 0.0).unwrap();
    let mut loads = Loads::default();
    loads.derivatives[1][0] = -100.0;
    simulator.set_loads(&loads).unwrap();
    simulator.advance_to(2000.0 * p.period()).unwrap();
    assert_ne!(simulator.contact(), Contact::Flight);
    let found = observe(&mut simulator).unwrap();
    assert!(found.rests && !found.is_free() && found.impacts == [0.0; 2], "{found:?}");
    assert_eq!(found.period, Some(1));
    // Box and block move as one body.
    assert!(found.states.iter().all(|s| (s[1] - s[0] + 1.0).abs() < 1e-12));
    // Without load the motion is free, and another one.
    let mut free = Simulator::new(&p, &State::default(), 0.0).unwrap();
    free.advance_to(2000.0 * p.period()).unwrap();
    let free = observe(&mut free).unwrap();
    assert!(free.is_free() && !free.rests && free.relation(&found) == Relation::Different);
}
