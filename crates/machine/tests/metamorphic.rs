//! Metamorphic tests: the motion of a mirrored, rescaled, time-shifted or reordered machine
//! follows from the original motion without a second method.

use crate::common::machines::{assembly, scaled};
use crate::common::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::sync::Arc;
use vibro_machine::description::*;
use vibro_machine::motion::Event;
use vibro_machine::{Assembly, Motion};

/// Largest number of events of a motion: bodies pressed together with restitution 1 bounce without
/// end.
const EVENTS: usize = 300;
/// Duration, s, and number of parts; their ends are exact sums for any start.
const END: (f64, u32) = (2.0, 16);
/// Offset of the parts' ends, s, before times with few decimals, at which bodies may meet:
/// rounding must not decide whether an end is before or after a contact.
const BEFORE: f64 = 0.0078125;
/// Perturbation of a start, which measures how much a motion amplifies errors.
const OFF: f64 = 1e-10;
/// Rounding of two motions, in the unit of [`OFF`]: tens of roundings of displacements, 1e-14, and
/// for speeds up to sqrt(k/m) = 1e3/s times that, with 0.01 kg on a spring or stop of 1e4 N/m.
const OWN: f64 = 3e-11;
/// Speed that counts as zero: while sticking, speeds fall by 1e-16 a sub-step, and scaling by
/// powers of two must not underflow.
const NOTHING: f64 = 1e-200;
/// Amplification of errors beyond which rounding determines the motion.
const DECIDED: f64 = 1e4;

/// States by time: s and v of every body.
type Path = Vec<Vec<f64>>;

fn path(mut m: Motion, bodies: &[usize]) -> (Path, Vec<Event>) {
    let (mut states, mut events) = (Vec::new(), Vec::new());
    let start = m.time();
    for k in 1..=END.1 {
        let end = start + END.0 * f64::from(k) / f64::from(END.1) - BEFORE;
        while m.time() < end {
            if events.len() > EVENTS || m.advance_to_event(end, &mut |e| events.push(e.clone())).is_err() {
                return (states, events);
            }
        }
        states.push(bodies.iter().flat_map(|&i| m.body(i)[..2].to_vec()).collect());
    }
    (states, events)
}

fn all(d: &Description) -> Vec<usize> {
    (0..d.bodies.len()).collect()
}

/// Every signal of a machine.
fn signals(d: &mut Description) -> impl Iterator<Item = &mut Signal> {
    let levels =
        d.frictions.iter_mut().flat_map(|f| std::iter::once(&mut f.force).chain(&mut f.static_force));
    levels.chain(d.loads.iter_mut().map(|load| &mut load.force))
}

fn free(d: &mut Description) -> impl Iterator<Item = &mut Free> {
    d.bodies.iter_mut().filter_map(|b| if let BodyKind::Free(free) = &mut b.kind { Some(free) } else { None })
}

fn all_arms(d: &mut Description) -> impl Iterator<Item = &mut Arms> {
    let springs = d.springs.iter_mut().map(|x| &mut x.arms);
    let stops = d.stops.iter_mut().map(|x| &mut x.arms);
    let frictions = d.frictions.iter_mut().map(|x| &mut x.arms);
    springs.chain(stops).chain(frictions).chain(d.links.iter_mut().map(|x| &mut x.arms))
}

/// The nearest time to which times of some minutes are added without rounding.
fn on_grid(time: f64) -> f64 {
    (time * 1048576.0).round() / 1048576.0
}

/// The machine perturbed by [`OFF`]: all speeds, every second speed, or all gaps of rigid stops.
/// The first preserves relative speeds; only the last detects a stop that is just touched.
fn off(d: &Description) -> [Description; 3] {
    let [mut all, mut second, mut gaps] = [0, 1, 2].map(|_| d.clone());
    free(&mut all).for_each(|b| b.v += OFF);
    free(&mut second).step_by(2).for_each(|b| b.v += OFF);
    gaps.stops.iter_mut().filter(|s| matches!(s.law, StopLaw::Rigid { .. })).for_each(|s| s.gap += OFF);
    [all, second, gaps]
}

/// Whether two paths agree within the errors that the motion amplifies.
fn agree(d: &Description, one: &Path, other: &Path) -> Result<(), TestCaseError> {
    let moved = off(d).map(|off| path(motion(off), &all(d)).0);
    let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    let (mut magnified, mut size) = (1.0f64, 1.0f64);
    for (k, (a, b)) in one.iter().zip(other).enumerate() {
        for c in moved.iter().filter_map(|path| path.get(k)) {
            magnified = magnified.max(distance(a, c) / OFF);
        }
        if magnified > DECIDED {
            break;
        }
        size = a.iter().fold(size, |most, x| most.max(x.abs()));
        let error = distance(a, b) / (magnified * size);
        prop_assert!(error < OWN, "part {}: {:e}, magnified {}\n{:?}\n{:?}", k, error, magnified, a, b);
    }
    Ok(())
}

/// A fixed seed, unless `PROPTEST_CASES` and `PROPTEST_RNG_SEED` ask for more or other machines.
fn config() -> ProptestConfig {
    let asked = ProptestConfig { failure_persistence: None, ..ProptestConfig::default() };
    let is_set = |name: &str| std::env::var_os(name).is_some();
    ProptestConfig {
        cases: if is_set("PROPTEST_CASES") { asked.cases } else { 60 },
        rng_seed: if is_set("PROPTEST_RNG_SEED") { asked.rng_seed } else { RngSeed::Fixed(1) },
        ..asked
    }
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn invariant_a_mirror_image_changes_no_bit(d in assembly()) {
        let mut mirrored = d.clone();
        free(&mut mirrored).for_each(|b| (b.s, b.v, b.gravity) = (-b.s, -b.v, -b.gravity));
        all_arms(&mut mirrored).flat_map(|arms| &mut arms.terms).for_each(|term| term.1 = -term.1);
        mirrored.loads.iter_mut().for_each(|load| load.force = scaled(&load.force, -1.0));
        let (one, events) = path(motion(d.clone()), &all(&d));
        let (other, their_events) = path(motion(mirrored), &all(&d));
        let back: Path = other.iter().map(|state| state.iter().map(|x| -x).collect()).collect();
        prop_assert_eq!(one, back);
        prop_assert_eq!(events, their_events);
    }

    #[test]
    fn invariant_units_of_length_and_mass_change_no_bit(d in assembly()) {
        // Powers of two scale without rounding.
        let (length, mass) = (1024.0, 0.015625);
        let mut other = d.clone();
        other.gravity *= length;
        free(&mut other).for_each(|b| (b.s, b.v, b.inertia) = (b.s * length, b.v * length, b.inertia * mass));
        for spring in &mut other.springs {
            (spring.stiffness, spring.damping) = (spring.stiffness * mass, spring.damping * mass);
            spring.preload *= mass * length;
        }
        for stop in &mut other.stops {
            stop.gap *= length;
            if let StopLaw::Compliant { stiffness, damping, .. } = &mut stop.law {
                (*stiffness, *damping) = (*stiffness * mass, *damping * mass);
            }
        }
        signals(&mut other).for_each(|signal| *signal = scaled(signal, mass * length));
        let (one, events) = path(motion(d.clone()), &all(&d));
        let (scaled, their_events) = path(motion(other), &all(&d));
        let kept = |x: f64| if x.abs() < NOTHING { 0.0 } else { x };
        let in_units = |path: &Path, unit: f64| -> Path {
            path.iter().map(|state| state.iter().map(|x| kept(x / unit)).collect()).collect()
        };
        prop_assert_eq!(in_units(&one, 1.0), in_units(&scaled, length));
        prop_assert_eq!(events.len(), their_events.len());
    }

    #[test]
    fn invariant_the_time_of_the_start(d in assembly(), later in (0..200u8).prop_map(|k| 0.25 * f64::from(k))) {
        // Knots at times whose sum with the start is exact.
        let mut d = d;
        for signal in signals(&mut d) {
            signal.steps.iter_mut().for_each(|s| s.time = on_grid(s.time));
            signal.table.iter_mut().flat_map(|t| &mut t.knots).for_each(|k| k.0 = on_grid(k.0));
        }
        let mut other = d.clone();
        for signal in signals(&mut other) {
            signal.harmonics.iter_mut().for_each(|h| h.phase -= std::f64::consts::TAU * (h.frequency * later).fract());
            signal.steps.iter_mut().for_each(|s| s.time += later);
            signal.table.iter_mut().flat_map(|t| &mut t.knots).for_each(|k| k.0 += later);
        }
        let (one, _) = path(motion(d.clone()), &all(&d));
        let shifted = Motion::starting_at(Arc::new(Assembly::new(other).unwrap()), later).unwrap();
        agree(&d, &one, &path(shifted, &all(&d)).0)?;
    }

    #[test]
    fn invariant_the_order_in_the_file(d in assembly()) {
        let mut other = d.clone();
        other.bodies.reverse();
        let last = d.bodies.len() - 1;
        all_arms(&mut other).flat_map(|arms| &mut arms.terms).for_each(|term| term.0 = last - term.0);
        other.loads.iter_mut().for_each(|load| load.body = last - load.body);
        other.springs.reverse();
        other.stops.reverse();
        other.frictions.reverse();
        other.loads.reverse();
        let (one, _) = path(motion(d.clone()), &all(&d));
        let places: Vec<usize> = all(&d).into_iter().rev().collect();
        agree(&d, &one, &path(motion(other), &places).0)?;
    }

    #[test]
    fn invariant_bodies_that_touch_nothing(d in assembly()) {
        // Machines with few coordinates use tables of sub-steps, those with many a series for each
        // state.
        let mut other = d.clone();
        other.bodies.extend((0..10).map(|i| body(&format!("idle{i}"), 1.0, 0.0, 0.0)));
        let (one, _) = path(motion(d.clone()), &all(&d));
        agree(&d, &one, &path(motion(other), &all(&d)).0)?;
    }
}

/// A ball under gravity on a floor, from one metre.
fn ball(stop: Stop) -> Description {
    Description {
        gravity: 9.81,
        bodies: vec![heavy("ball", 1.0, -1.0, 1.0, 0.0)],
        stops: vec![stop],
        ..Description::default()
    }
}

#[test]
fn closed_form_rigid_stop_as_the_limit_of_a_stiff_one() {
    let rigid = path(motion(ball(rigid("floor", &[(0, -1.0)], 0.0, 1.0))), &[0]).0;
    let mut before = f64::INFINITY;
    for exponent in [6, 8, 10, 12, 14] {
        let stiffness = 10f64.powi(exponent);
        let floor = compliant("floor", &[(0, -1.0)], 0.0, stiffness, 0.0, DampingLimit::NoPull);
        let soft = path(motion(ball(floor)), &[0]).0;
        let apart = (rigid.last().unwrap()[0] - soft.last().unwrap()[0]).abs();
        // Two contacts of half a period π sqrt(m/k) each, during which the rigid ball flies at
        // less than 5 m/s both ways.
        let most = 2.0 * 10.0 * std::f64::consts::PI / stiffness.sqrt();
        assert!(apart <= most && apart < 0.2 * before, "1e{exponent}: {apart:e}, {most:e}, {before:e}");
        before = apart;
    }
}

/// Oscillators m = 1, k = 1 about 0 from (0, 1): their largest e is 1.
fn oscillators(gaps: &[f64]) -> Description {
    let bodies = gaps.iter().enumerate().map(|(i, _)| body(&format!("b{i}"), 1.0, 0.0, 1.0));
    let springs = gaps.iter().enumerate().map(|(i, _)| spring(&[(i, 1.0)], 1.0, 0.0));
    let stops = gaps.iter().enumerate().map(|(i, &gap)| rigid(&format!("s{i}"), &[(i, 1.0)], gap, 0.5));
    Description {
        bodies: bodies.collect(),
        springs: springs.collect(),
        stops: stops.collect(),
        ..Description::default()
    }
}

#[test]
fn closed_form_grazing_by_a_part_of_the_gap() {
    for depth in [1e-6, 1e-9, 1e-11] {
        for (gap, hits) in [(1.0 - depth, 1), (1.0 + depth, 0)] {
            let all = events(&mut motion(oscillators(&[gap])), 3.0);
            let found = times(&all, |k| matches!(k, vibro_machine::motion::EventKind::Impact { .. }));
            assert_eq!(found.len(), hits, "{depth:e} {gap} {all:?}");
            // Error of a root of sin t = gap: the gap's rounding over the speed, sqrt(2 depth).
            let near = 1e-15 / (2.0 * depth).sqrt();
            assert!(found.iter().all(|t| (t - gap.asin()).abs() < 4.0 * near), "{depth:e} {found:?}");
        }
    }
}

#[test]
fn closed_form_what_only_touches_is_no_event() {
    // An oscillator released from its stop without speed returns to it each period and reverses
    // there; a rounding of the coordinate, 1e-16, would be an impact at 1e-8 m/s. Another body has
    // friction whose level 1 + sin touches zero once a second without stopping it.
    for k in 1..20 {
        let (stiffness, mass, from) =
            (17.3 * f64::from(k), 0.37 * f64::from(k % 7 + 1), 0.061 * f64::from(k));
        let level = Signal { constant: 1.0, ..sine(1.0, 1.0, 0.0) };
        let mut motion = motion(Description {
            bodies: vec![body("turns", mass, from, 0.0), body("slides", 10.0, 0.0, 100.0)],
            springs: vec![spring(&[(0, 1.0)], stiffness, 0.0)],
            stops: vec![rigid("stop", &[(0, 1.0)], from, 0.5)],
            frictions: vec![Friction { force: level, ..friction(&[(1, 1.0)], 0.0) }],
            ..Description::default()
        });
        let all = events(&mut motion, 3.0);
        assert!(all.is_empty(), "{k}: {all:?}");
        let exact = from * (3.0 * (stiffness / mass).sqrt()).cos();
        assert!((motion.body(0)[0] - exact).abs() < 1e-13 * from, "{k}: {:e}", motion.body(0)[0] - exact);
    }
}

#[test]
fn closed_form_corners_met_at_one_instant() {
    // Three stops at one instant, each as if it were alone; and a body caught between two stops.
    let alone = path(motion(oscillators(&[0.5])), &[0]).0;
    let together = path(motion(oscillators(&[0.5, 0.5, 0.5])), &[0, 1, 2]).0;
    for (a, b) in alone.iter().zip(&together) {
        let apart = b.chunks(2).flat_map(|b| [(a[0] - b[0]).abs(), (a[1] - b[1]).abs()]).fold(0.0, f64::max);
        assert!(apart < 1e-14, "{a:?} {b:?}");
    }
    // A body of mass 1 meets a stop and another body of mass 1, at rest between them, at one
    // instant.
    let d = Description {
        bodies: vec![body("a", 1.0, -1.0, 1.0), body("b", 1.0, 1.0, -1.0), body("c", 1.0, 0.0, 0.0)],
        stops: vec![
            rigid("ac", &[(0, 1.0), (2, -1.0)], 0.0, 1.0),
            rigid("cb", &[(2, 1.0), (1, -1.0)], 0.0, 1.0),
        ],
        ..Description::default()
    };
    let mut m = motion(d);
    m.advance_to(2.0).unwrap();
    for (i, v) in [-1.0, 1.0, 0.0].into_iter().enumerate() {
        assert!((m.body(i)[1] - v).abs() < 1e-15, "{i} {:?}", m.body(i));
    }
}
