//! Ends of advances: every state reached can be saved and restored; an end just after an event
//! adds no event.

use vibro_impact::model::Model;
use vibro_impact::simulator::{Contact, Event, Loads, Pause, Snapshot};
use vibro_impact::{Groups, Parameters, Scales, Simulator, State};
use vibro_numerics::double_double::DoubleDouble;

fn machine(f10: f64, kappa: f64) -> Parameters {
    Groups { f10, kappa, ..Groups::basic() }.to_parameters(Scales::default()).unwrap()
}

fn start() -> State {
    State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] }
}

/// Distances of an end from an event, s, on both sides, down to the resolution of a double-double.
fn distances() -> Vec<f64> {
    let mut distances = vec![0.0];
    for exponent in -22..-6 {
        for digit in [1.0, 1.7, 2.9, 4.3, 5.5, 7.9] {
            let distance = digit * 10f64.powi(exponent);
            distances.extend([distance, -distance]);
        }
    }
    distances
}

/// Advances from a snapshot to `end` and restores the state reached in this and in another
/// simulator; true if both accept it.
fn is_restored(simulator: &mut Simulator, other: &mut Simulator, from: &Snapshot, end: DoubleDouble) -> bool {
    simulator.restore(from).unwrap();
    if simulator.advance_until(end, Pause::Never, None).is_err() {
        return true; // an end before the current time, which is refused
    }
    let reached = simulator.snapshot();
    let taken = simulator.restore(&reached).is_ok() && other.restore(&reached).is_ok();
    taken && other.snapshot() == reached
}

/// Scans ends around `events` events; returns the refused ends and the number of ends.
fn scan(p: &Parameters, events: usize, load: impl Fn(f64) -> Loads) -> (Vec<f64>, usize) {
    let mut simulator = Simulator::new(p, &start(), 0.0).unwrap().without_energy_accounts();
    let mut other = simulator.clone();
    let distances = distances();
    let (mut refused, mut count) = (Vec::new(), 0);
    for _ in 0..events {
        simulator.set_loads(&load(simulator.time())).unwrap();
        let before = simulator.snapshot();
        let end = simulator.time() + 20.0 * p.period();
        simulator.advance_until(end, Pause::BeforeEvent, None).unwrap();
        let event = simulator.time();
        for distance in &distances {
            let end = DoubleDouble::sum(event, *distance);
            count += 1;
            if !is_restored(&mut simulator, &mut other, &before, end) {
                refused.push(end.value());
            }
        }
        simulator.restore(&before).unwrap();
        simulator.advance_until(end, Pause::BeforeEvent, None).unwrap();
        simulator.apply_due_event(None);
    }
    (refused, count)
}

/// Every end near an event, among them 76.64538209875533 s + 7.9e-16 s of the motion with f10 =
/// 3.6: w is a unit in the last place of the gap past the stop there, and is put on the stop.
#[test]
fn invariant_every_end_near_an_event_can_be_restored() {
    /// Events of each motion whose neighbourhood is scanned.
    const EVENTS: usize = 400;
    let still = |_: f64| Loads::default();
    let push = |t: f64| Loads {
        derivatives: [[0.02 * t.sin(), 0.01, 0.0, 0.0], [0.003 * t.cos(), 0.0, -0.002, 0.0], [0.0; 4]],
    };
    for (f10, kappa) in
        [(3.6, 0.75), (1.5, 0.75), (2.45, 0.75), (3.0, 0.0), (3.5, 0.1), (1.5, 1.0), (0.8, 0.5)]
    {
        let p = machine(f10, kappa);
        for (loaded, (refused, count)) in [(false, scan(&p, EVENTS, still)), (true, scan(&p, EVENTS, push))] {
            assert!(refused.is_empty(), "f {f10} κ {kappa} loads {loaded}: {refused:?} of {count}");
        }
    }
}

/// Advances through the next release.
fn advance_to_release(simulator: &mut Simulator) {
    let mut released = false;
    while !released {
        let end = simulator.time() + 20.0 * simulator.parameters().period();
        simulator.advance_until(end, Pause::BeforeEvent, None).unwrap();
        simulator.apply_due_event(Some(&mut |event| released = matches!(event, Event::Release { .. })));
    }
}

/// A released block has zero velocity, and its acceleration is rounding, which must not bring it
/// back, however short the steps are.
#[test]
fn invariant_steps_of_any_shortness_after_a_release_add_no_impact() {
    let mut added = Vec::new();
    for f10 in [2.0, 2.5, 3.0, 3.5, 4.0, 4.5] {
        let p = machine(f10, 0.0);
        let mut simulator = Simulator::new(&p, &start(), 0.0).unwrap();
        for _ in 0..12 {
            advance_to_release(&mut simulator);
            let mut whole = simulator.clone();
            let later = simulator.time() + 1e-3;
            whole.advance_to(later).unwrap();
            for exponent in -18..-11 {
                for digit in [1.0, 2.0, 5.0] {
                    let mut short = simulator.clone();
                    let step = digit * 10f64.powi(exponent);
                    for n in 1..=3 {
                        let end = DoubleDouble::sum(simulator.time(), f64::from(n) * step);
                        // The release may be later than that double, by the rounding of its time.
                        let _ = short.advance_until(end, Pause::Never, None);
                        let saved = short.snapshot();
                        short.restore(&saved).unwrap();
                    }
                    short.advance_to(later).unwrap();
                    if short.impacts() != whole.impacts() || short.contact() != whole.contact() {
                        added.push((f10, step, short.impacts().last_speed));
                    }
                }
            }
        }
    }
    assert!(added.is_empty(), "{} of 1512: {:?}", added.len(), &added[..added.len().min(5)]);
}

/// Setting loads right after a release decides again whether the block rests: not by the
/// acceleration, which is rounding, but by the jerk, which leads away. No second release is
/// reported, and the motion does not change.
#[test]
fn invariant_loads_set_right_after_a_release_move_nothing() {
    /// Difference of the displacements in gaps, by the rounding of the acceleration.
    const ROUNDING: f64 = 1e-12;
    /// Force on the block, N: negligible next to the drive's force of about 1 N, but not zero.
    const NOTHING: f64 = 1e-25;
    for f10 in [2.0, 3.0, 4.0] {
        let p = machine(f10, 0.0);
        let mut simulator = Simulator::new(&p, &start(), 0.0).unwrap();
        for _ in 0..12 {
            advance_to_release(&mut simulator);
            let later = simulator.time() + 1e-3;
            let mut whole = simulator.clone();
            whole.advance_to(later).unwrap();
            for exponent in -18..-8 {
                let mut short = simulator.clone();
                let end = DoubleDouble::sum(simulator.time(), 10f64.powi(exponent));
                let _ = short.advance_until(end, Pause::Never, None);
                short
                    .set_loads(&Loads { derivatives: [[0.0; 4], [NOTHING, 0.0, 0.0, 0.0], [0.0; 4]] })
                    .unwrap();
                let mut further = 0;
                short
                    .advance_observed(later, &mut |event| {
                        further += usize::from(matches!(event, Event::Release { .. }));
                    })
                    .unwrap();
                assert!(further == 0 && short.impacts() == whole.impacts());
                assert_eq!(short.contact(), whole.contact());
                let (found, expected) = (short.state(), whole.state());
                for (found, expected) in found.x.iter().zip(expected.x) {
                    assert!((found - expected).abs() < ROUNDING * p.stop_gap, "{found} {expected}");
                }
            }
        }
    }
}

/// A block without springs under a constant load rises to a stop. The impact may depend on the
/// ends of steps only if the path reverses within rounding of it (docs/numerics.md, "Statement").
#[test]
fn closed_form_only_grazes_within_rounding_depend_on_where_steps_end() {
    /// η of docs/numerics.md, section 2, relative to the motion's size.
    const OVERSHOOT: f64 = 2e-12;
    let p = Parameters {
        box_damping: 0.0,
        secondary_damping: 0.0,
        coupling_stiffness: 0.0,
        drive_amplitude: 0.0,
        drive_frequency: 1.0,
        block_mass: 1.0,
        ..Parameters::default()
    };
    let (gap, rate) = (p.stop_gap, Model::new(&p).unwrap().rate);
    let (mut grazes, mut others) = (0, 0);
    for load in (0..40).map(|n| 0.02 + 0.01 * f64::from(n)) {
        for size in [0.0, 1e-16, 2e-16, 4e-16, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10] {
            for past in [size, -size] {
                let speed = (2.0 * load * gap * (1.0 + past)).sqrt();
                let mut simulator =
                    Simulator::new(&p, &State { x: [0.0; 3], v: [0.0, speed, 0.0] }, 0.0).unwrap();
                let derivatives = [[0.0; 4], [-load, 0.0, 0.0, 0.0], [0.0; 4]];
                simulator.set_loads(&Loads { derivatives }).unwrap();
                let (top, end) = (speed / load, 1.5 * speed / load);
                let impacts = |inner: Option<f64>| {
                    let mut simulator = simulator.clone();
                    inner.into_iter().for_each(|time| simulator.advance_to(time).unwrap());
                    simulator.advance_to(end).unwrap();
                    (simulator.impacts().upper, simulator.impacts().last_speed)
                };
                let whole = impacts(None);
                for exponent in 2..40 {
                    let away = 2f64.powi(-exponent) * top;
                    for inner in [top - away, top + away] {
                        let split = impacts(Some(inner));
                        if split.0 == whole.0 {
                            others += 1;
                            continue;
                        }
                        grazes += 1;
                        let eta = OVERSHOOT * (gap + speed / rate + load / (rate * rate));
                        let (slow, said) =
                            (whole.1.max(split.1), format!("{load} {past} {inner}: {whole:?} {split:?}"));
                        assert!(past.abs() * gap < eta && slow <= (2.0 * load * eta).sqrt(), "{said}");
                    }
                }
            }
        }
    }
    println!("{grazes} of {} depend on the step", grazes + others);
    assert!(grazes > 0, "no graze depends on the step: docs/guarantees.md says that one may");
}

/// The last bounces of chatter are as low as the rounding of w, to which the state between two
/// advances is rounded. Their number may depend on the ends of steps; motion and rest do not.
#[test]
fn invariant_only_the_number_of_the_last_bounces_depends_on_where_steps_end() {
    /// Difference of displacements in gaps, and of velocities.
    const ROUNDING: f64 = 1e-12;
    /// Speed of a bounce 10⁻¹² gaps high, under the largest acceleration of these motions, 1 m/s².
    const SLOW: f64 = 1.5e-6;
    /// Time until chatter ends after a bounce at that speed, s.
    const LATER: f64 = 1e-4;
    let (mut changed, mut runs) = (0, 0);
    for (load, kappa) in [(-0.05, 0.5), (-0.03, 0.75), (-0.1, 0.2)] {
        let p = Parameters { constant_loads: [0.0, load, 0.0], ..machine(1.0, kappa) };
        let mut simulator = Simulator::new(&p, &start(), 0.0).unwrap();
        for _ in 0..100 {
            let before = simulator.clone();
            simulator.advance_until(simulator.time() + 20.0 * p.period(), Pause::BeforeEvent, None).unwrap();
            let event = simulator.time();
            simulator.apply_due_event(None);
            let mut whole = before.clone();
            whole.advance_to(event + LATER).unwrap();
            if whole.contact() == Contact::Flight || simulator.impacts().last_speed > SLOW {
                continue;
            }
            runs += 1;
            for exponent in 9..18 {
                for part in [-1.0, 1.0] {
                    let mut split = before.clone();
                    let end = DoubleDouble::sum(event, part * 10f64.powi(-exponent));
                    let _ = split.advance_until(end, Pause::Never, None); // an end before the present is refused
                    split.advance_to(event + LATER).unwrap();
                    changed += i32::from(split.impacts().lower != whole.impacts().lower);
                    assert_eq!(split.contact(), whole.contact());
                    let (a, b) = (split.state(), whole.state());
                    let pairs = a.x.iter().zip(b.x).chain(a.v.iter().zip(b.v));
                    pairs.for_each(|(a, b)| assert!((a - b).abs() < ROUNDING, "{a} {b}"));
                }
            }
        }
    }
    // The nearly elastic runs of another test show that the number can change.
    println!("{changed} of {} ends change the number of bounces", 18 * runs);
    assert!(runs > 20, "{runs} runs");
}

/// Bounces, with the first speed `u`, of a block that its load presses with the acceleration `a`
/// against the upper stop of a box without spring and damper. Advances by `span` in equal `steps`;
/// returns the impacts, the time of rest, and the largest distance from the stop after a step,
/// gaps.
fn bounce(kappa: f64, u: f64, a: f64, span: f64, steps: u32) -> (u64, Option<f64>, f64) {
    let p = Parameters {
        box_stiffness: 0.0,
        box_damping: 0.0,
        block_mass: 1.0,
        secondary_mass: 1.0,
        secondary_stiffness: 1.0,
        coupling_stiffness: 0.0,
        drive_amplitude: 0.0,
        stop_restitution: kappa,
        ..Parameters::default()
    };
    let at_stop = State { x: [0.0, p.stop_gap, 0.0], v: [0.0, u / kappa, 0.0] };
    let mut simulator = Simulator::new(&p, &at_stop, 0.0).unwrap();
    simulator.set_loads(&Loads { derivatives: [[0.0; 4], [a, 0.0, 0.0, 0.0], [0.0; 4]] }).unwrap();
    let (mut rest, mut height) = (None, 0.0f64);
    for step in 1..=steps {
        let end = span * f64::from(step) / f64::from(steps);
        simulator
            .advance_observed(end, &mut |event| {
                if let Event::Rest { time, .. } = event {
                    rest = Some(*time);
                }
            })
            .unwrap();
        height = height.max(p.stop_gap - simulator.relative_motion().0);
    }
    (simulator.impacts().upper, rest, height / p.stop_gap)
}

/// For κ near 1, thousands of bounces are within rounding of the stop. The ends of steps decide
/// their number and the time of rest, and with κ = 1 whether the block comes to rest. Throughout,
/// the block is on the stop, up to the exception of docs/guarantees.md.
#[test]
fn closed_form_nearly_elastic_runs_stay_on_the_stop_however_they_are_divided() {
    /// η of docs/numerics.md, section 2, in gaps, as the size of these motions is about the gap.
    const OVERSHOOT: f64 = 2e-12;
    let a = 1e-3;
    let kappa = 0.998;
    let u = (2.0 * a * 1e-13f64).sqrt();
    let length = 2.0 * u / (a * (1.0 - kappa));
    let divided = |steps| bounce(kappa, u, a, 1.5 * length, steps);
    let (few, many) = (divided(1), divided(1000));
    println!("κ {kappa}, run of {length} s: {few:?} {many:?}");
    assert!(few.2.max(many.2) < OVERSHOOT, "{few:?} {many:?}");
    assert!(few.0.abs_diff(many.0) > 500, "{few:?} {many:?}: docs/guarantees.md says by thousands");
    let end = few.1.expect("a block at rest");
    assert!((end - length).abs() < 1e-6 * length, "{end}");
    assert!(many.1.is_none_or(|end| (end - length).abs() > 1e-3 * length), "{many:?}");

    // 0.003 % faster than the limit at which such a run is closed: rounding decides.
    let u = 1.00003 * (2.0 * a * 1e-12f64).sqrt();
    let divided = |steps| bounce(1.0, u, a, 300.0 * 2.0 * u / a, steps);
    let (few, many) = (divided(1), divided(1000));
    println!("κ 1: {few:?} {many:?}");
    assert!(few.2.max(many.2) < OVERSHOOT, "{few:?} {many:?}");
    assert!(few.1.is_none() && many.1.is_some(), "{few:?} {many:?}: docs/guarantees.md says that it may");
}

/// The motion w = w0 + v t + a t²/2 in many short steps, with and without loads. The roundings
/// have no preferred direction, even if a t²/2 of a step is less than half a unit in the last
/// place.
#[test]
fn closed_form_roundings_of_many_short_steps_do_not_add_up() {
    const STEPS: u32 = 10_000;
    /// Rounding of all steps together, in units in the last place of the gap. Random roundings add
    /// up to a third of a unit times the square root of their number, roundings in one direction
    /// to thousands of units.
    const ROUNDING: f64 = 150.0;
    let still = Parameters {
        box_stiffness: 0.0,
        box_damping: 0.0,
        coupling_stiffness: 0.0,
        drive_amplitude: 0.0,
        ..Parameters::default()
    };
    let (w0, v, a) = (0.6 * still.stop_gap, 1e-3, -1.0);
    // The block is accelerated by a load, or the box by its spring, which hardly moves in this
    // time.
    let swung = Parameters { box_stiffness: still.box_mass, ..still };
    for (p, x1, load) in [(still, 0.0, a * still.block_mass), (swung, a, 0.0)] {
        for step in [1e-9, 3e-9, 1e-8, 1e-7] {
            let start = State { x: [x1, x1 + w0, 0.0], v: [0.0, v, 0.0] };
            let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
            simulator.set_loads(&Loads { derivatives: [[0.0; 4], [load, 0.0, 0.0, 0.0], [0.0; 4]] }).unwrap();
            for n in 1..=STEPS {
                simulator.advance_to(step * f64::from(n)).unwrap();
            }
            let t = step * f64::from(STEPS);
            let bent = if load == 0.0 { 1.0 - t.cos() } else { 0.5 * t * t };
            let error =
                (simulator.relative_motion().0 - (w0 + t * v + a * bent)) / (p.stop_gap * f64::EPSILON);
            assert!(error.abs() <= ROUNDING, "load {load}, steps of {step} s: {error} units");
        }
    }
}

/// A block on a stop with forces that cancel except for a very slowly decreasing load. Its
/// velocity is rounding for a whole sub-step and longer. Rounding may add impacts, rests and
/// releases, but these do not move the block.
#[test]
fn closed_form_a_block_that_hardly_any_force_moves_stays_at_its_stop() {
    /// Speeds that are rounding, in gaps times the fastest rate, as in docs/guarantees.md.
    const SPEED: f64 = 20.0 * f64::EPSILON;
    /// Distances from the stop that are rounding, in gaps, as in docs/guarantees.md.
    const NEAR: f64 = 2e-12;
    const END: f64 = 1000.0;
    let mut added = 0;
    for kappa in [0.0, 0.5, 1.0] {
        let p = Parameters { drive_amplitude: 0.0, stop_restitution: kappa, ..Parameters::default() };
        let (rate, hold) = (Model::new(&p).unwrap().rate, p.coupling_stiffness * p.stop_gap);
        // The largest is about ε/100 of the ramp that moves the block by a gap in the time 1/rate.
        for ramp in [1e-18, 1e-20, 1e-22, 1e-25] {
            for step in [END, 0.3, 0.01] {
                let start = State { x: [0.0, p.stop_gap, 0.0], v: [0.0; 3] };
                let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
                let load = [hold + 10.0 * ramp, -ramp, 0.0, 0.0];
                let derivatives = [[0.0; 4], load, [-hold, 0.0, 0.0, 0.0]];
                simulator.set_loads(&Loads { derivatives }).unwrap();
                for n in 1..=(END / step) as u32 {
                    simulator
                        .advance_observed(f64::from(n) * step, &mut |event| {
                            if let Event::Impact { speed, .. } = *event {
                                added += 1;
                                assert!(
                                    speed < SPEED * rate * p.stop_gap,
                                    "{kappa} {ramp:e} {step}: {speed:e}"
                                );
                            }
                        })
                        .unwrap();
                    let (w, _) = simulator.relative_motion();
                    assert!(p.stop_gap - w < NEAR * p.stop_gap, "{kappa} {ramp:e} {step}: {w}");
                }
            }
        }
    }
    assert!(added > 1000, "{added}: docs/guarantees.md says that there may be thousands");
}
