//! Loads from samples: the interpolant, the motion under it, and refusals.

use vibro_impact::load::{Body, Interpolation, Load, loads_at, next_sample};
use vibro_impact::reference::{Reference, Tolerance};
use vibro_impact::simulator::{AdvanceOutcome, Event, Loads, Pause};
use vibro_impact::{Error, Parameters, Simulator, State};

/// Rounding of a motion of a few units' size over some tens of sub-steps.
const ROUNDING: f64 = 1e-12;
/// Error of the reference integrator at its tightest tolerance.
const REFERENCE: f64 = 1e-7;

/// A record with flat parts, turns and unequal steps.
const RECORD: [(f64, f64); 9] = [
    (0.5, 0.0),
    (1.0, 0.3),
    (1.4, 0.3),
    (2.5, -0.2),
    (3.1, -0.25),
    (4.0, 0.4),
    (6.0, 0.1),
    (6.25, 0.05),
    (8.0, 0.0),
];

/// Bodies without springs, dampers and drive.
fn free() -> Parameters {
    Parameters {
        box_stiffness: 0.0,
        box_damping: 0.0,
        secondary_stiffness: 0.0,
        secondary_damping: 0.0,
        coupling_stiffness: 0.0,
        drive_amplitude: 0.0,
        stop_gap: 1e3,
        ..Parameters::default()
    }
}

fn load(body: Body, interpolation: Interpolation) -> Load {
    Load::new(body, &RECORD, interpolation).unwrap()
}

#[test]
fn closed_form_of_a_free_block_under_a_ramp() {
    // f = t up to 1 s, then zero: x2 = t³/6m, v2 = t²/2m, then uniform motion.
    let p = free();
    let ramp = Load::new(Body::Block, &[(0.0, 0.0), (1.0, 1.0)], Interpolation::Linear).unwrap();
    let mut simulator = Simulator::new(&p, &State::default(), 0.0).unwrap();
    for t in [0.25, 1.0, 3.5] {
        simulator.advance_under(std::slice::from_ref(&ramp), t, Pause::Never, None).unwrap();
        let (under, after) = (f64::min(t, 1.0), f64::max(t - 1.0, 0.0));
        let v = under * under / 2.0 / p.block_mass;
        let x = under.powi(3) / 6.0 / p.block_mass + v * after;
        let State { x: [x1, x2, x3], v: [_, v2, _] } = simulator.state();
        assert!((x2 - x).abs() < ROUNDING * (1.0 + x) && (v2 - v).abs() < ROUNDING * (1.0 + v), "{t}");
        assert_eq!((x1, x3), (0.0, 0.0));
    }
}

#[test]
fn closed_form_of_the_cubic() {
    // Samples of a straight line give that line; on a parabola with equal steps the slopes are
    // harmonic means of chords.
    let line = Load::new(Body::Box, &[(0.0, 1.0), (1.0, 3.0), (3.0, 7.0)], Interpolation::Cubic).unwrap();
    for t in [0.0, 0.3, 1.0, 2.9] {
        assert!((line.force(t) - (1.0 + 2.0 * t)).abs() < ROUNDING, "{t}");
    }
    let squares: Vec<(f64, f64)> = (0..5).map(|i| (f64::from(i), f64::from(i * i))).collect();
    let cubic = Load::new(Body::Box, &squares, Interpolation::Cubic).unwrap();
    let slope = 2.0 / (1.0 / 3.0 + 1.0 / 5.0);
    assert!((cubic.derivatives(2.0)[1] - slope).abs() < ROUNDING);
    // Impulse on a free box: the integral of a cubic by its ends, h (f0 + f1)/2 + h² (s0 - s1)/12.
    let p = free();
    let mut simulator = Simulator::new(&p, &State::default(), 2.0).unwrap();
    simulator.advance_under(std::slice::from_ref(&cubic), 3.0, Pause::Never, None).unwrap();
    let next = 2.0 / (1.0 / 5.0 + 1.0 / 7.0);
    let impulse = (4.0 + 9.0) / 2.0 + (slope - next) / 12.0;
    assert!((simulator.state().v[0] * p.box_mass - impulse).abs() < ROUNDING * impulse);
}

#[test]
fn invariant_the_cubic_keeps_to_its_samples_and_is_smooth() {
    let cubic = load(Body::Box, Interpolation::Cubic);
    for pair in RECORD.windows(2) {
        let ((t0, f0), (t1, f1)) = (pair[0], pair[1]);
        let mut before = f0;
        for i in 0..=50 {
            let f = cubic.force((t1 - t0).mul_add(f64::from(i) / 50.001, t0));
            assert!((f1 - f0) * (f - before) >= -ROUNDING, "monotone from {t0} to {t1}");
            before = f;
        }
        assert!((before - f1).abs() < 1e-4);
        // Slopes from both sides of a sample, by the polynomial before the sample.
        let [_, d1, d2, d3] = cubic.derivatives(t0);
        let h = t1 - t0;
        if t1 < 8.0 {
            assert!((d1 + h * (d2 + h * d3 / 2.0) - cubic.derivatives(t1)[1]).abs() < ROUNDING);
        }
    }
    assert_eq!((cubic.force(0.4), cubic.force(8.0), cubic.force(9.0)), (0.0, 0.0, 0.0));
}

#[test]
fn second_method_the_reference_integrator_under_the_same_loads() {
    let p = Parameters::default();
    let start = State { x: [0.0, 0.5, 0.0], v: [0.2, 0.8, 0.0] };
    for interpolation in [Interpolation::Linear, Interpolation::Cubic] {
        let loads = [Body::Box, Body::Block, Body::Secondary].map(|body| load(body, interpolation));
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        let mut impacts = 0;
        let mut count = |e: &Event| impacts += u32::from(matches!(e, Event::Impact { .. }));
        simulator.advance_under(&loads, 10.0, Pause::Never, Some(&mut count)).unwrap();
        assert!(impacts >= 2, "{impacts}");
        let mut reference = Reference::new(&p, &start, 0.0, Tolerance::new(1e-13)).unwrap();
        while reference.time() < 10.0 {
            let now = reference.time();
            reference.set_loads(&loads_at(&loads, now)).unwrap();
            reference.advance_to(next_sample(&loads, now).unwrap_or(10.0)).unwrap();
        }
        let (a, b) = (simulator.state(), reference.state());
        for i in 0..3 {
            assert!(
                (a.x[i] - b.x[i]).abs() < REFERENCE && (a.v[i] - b.v[i]).abs() < REFERENCE,
                "{a:?} {b:?}"
            );
        }
    }
}

#[test]
fn invariant_a_record_split_in_two_and_an_advance_cut_in_pieces_change_nothing() {
    let p = Parameters::default();
    let start = State { x: [0.0, 0.5, 0.0], v: [0.2, 0.8, 0.0] };
    let run = |loads: &[Load], ends: &[f64]| {
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        for end in ends {
            simulator.advance_under(loads, *end, Pause::Never, None).unwrap();
        }
        simulator
    };
    let whole = run(&[load(Body::Block, Interpolation::Linear)], &[10.0]);
    let halves = [&RECORD[..5], &RECORD[4..]];
    let halves = halves.map(|half| Load::new(Body::Block, half, Interpolation::Linear).unwrap());
    let split = run(&halves, &[10.0]);
    let ends: Vec<f64> = (1..=100).map(|i| 0.1 * f64::from(i)).collect();
    for interpolation in [Interpolation::Linear, Interpolation::Cubic] {
        let loads = [load(Body::Block, interpolation)];
        close(&run(&loads, &[10.0]), &run(&loads, &ends));
    }
    close(&whole, &split);
}

fn close(a: &Simulator, b: &Simulator) {
    assert_eq!(a.impacts().upper + a.impacts().lower, b.impacts().upper + b.impacts().lower);
    for i in 0..3 {
        assert!((a.state().x[i] - b.state().x[i]).abs() < ROUNDING, "{:?} {:?}", a.state(), b.state());
        assert!((a.state().v[i] - b.state().v[i]).abs() < ROUNDING, "{:?} {:?}", a.state(), b.state());
    }
}

#[test]
fn invariant_energy_balance_and_pauses_before_events_under_loads() {
    let loads = [load(Body::Block, Interpolation::Cubic), load(Body::Block, Interpolation::Linear)];
    let start = State { x: [0.0, 0.5, 0.0], v: [0.2, 0.8, 0.0] };
    let mut simulator = Simulator::new(&Parameters::default(), &start, 0.0).unwrap();
    let mut plain = simulator.clone();
    let before = simulator.energy_accounts().mechanical;
    let mut events = 0;
    while simulator.advance_under(&loads, 20.0, Pause::BeforeEvent, None).unwrap() == AdvanceOutcome::EventDue
    {
        simulator.apply_due_event(None);
        events += 1;
    }
    let e = simulator.energy_accounts();
    assert!(events >= 4);
    assert!((e.mechanical - (before + e.input - e.damped - e.impact)).abs() < ROUNDING, "{e:?}");
    plain.advance_under(&loads, 20.0, Pause::Never, None).unwrap();
    close(&simulator, &plain);
}

#[test]
fn what_is_no_record_is_refused_by_index() {
    let refused = |samples: &[(f64, f64)]| Load::new(Body::Box, samples, Interpolation::Cubic).unwrap_err();
    let index = |samples: &[(f64, f64)]| match refused(samples) {
        Error::Sample { index, .. } => index,
        other => panic!("{other}"),
    };
    assert_eq!(refused(&[(0.0, 1.0)]), Error::Samples { count: 1 });
    assert_eq!(index(&[(0.0, 1.0), (1.0, f64::NAN), (0.5, 1.0)]), 1);
    assert_eq!(index(&[(0.0, 1.0), (1.0, 1.0), (f64::INFINITY, 1.0)]), 2);
    assert_eq!(index(&[(0.0, 1.0), (1.0, 1.0), (1.0, 2.0)]), 2);
    assert_eq!(index(&[(0.0, 1.0), (1.0, 1.0), (0.5, 2.0)]), 2);
    assert_eq!(index(&[(0.0, 0.0), (1.0, 0.0), (1.0 + f64::EPSILON, 1e300)]), 1);
    let text = refused(&[(0.0, 1.0), (0.0, 2.0)]).to_string();
    assert!(
        text.starts_with("sample 1 ")
            && text.contains("expected a time later than the time of the previous sample"),
        "{text}"
    );
}

/// Loads that represent a gap whose middle lies `b` above the block's place, docs/theory.md (97).
fn off_centre(p: &Parameters, b: f64) -> Loads {
    let mut loads = Loads::default();
    (loads.derivatives[1][0], loads.derivatives[2][0]) =
        (-p.coupling_stiffness * b, p.coupling_stiffness * b);
    loads
}

#[test]
fn closed_form_of_a_block_at_its_place_off_centre() {
    // Nothing moves if the block is where the coupling spring is relaxed, b below the middle of
    // the gap.
    let p = Parameters { drive_amplitude: 0.0, ..Parameters::default() };
    let b = 0.25 * p.stop_gap;
    let start = State { x: [0.0, -b, 0.0], v: [0.0; 3] };
    let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
    simulator.set_loads(&off_centre(&p, b)).unwrap();
    simulator.advance_to(50.0 * p.period()).unwrap();
    let State { x, v } = simulator.state();
    assert!(x.iter().zip(start.x).chain(v.iter().zip([0.0; 3])).all(|(a, b)| (a - b).abs() < ROUNDING));
}

#[test]
fn invariant_mirror_image_of_an_off_centre_gap() {
    let run = |sign: f64| {
        let p = Parameters { drive_amplitude: sign * 0.15, ..Parameters::default() };
        let start = State { x: [0.0, sign * 0.5, 0.0], v: [0.0, sign, 0.0] };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        simulator.set_loads(&off_centre(&p, sign * 0.2)).unwrap();
        simulator.advance_to(60.0 * p.period()).unwrap();
        (simulator.state(), *simulator.impacts())
    };
    let ((above, one), (below, other)) = (run(1.0), run(-1.0));
    assert_eq!((one.upper, one.lower), (other.lower, other.upper));
    assert!(one.upper > 20 && one.lower > 20, "{one:?}");
    assert_eq!(above.x.map(|x| -x), below.x);
    assert_eq!(above.v.map(|v| -v), below.v);
}

/// A block that its load holds at a stop by the force (t - t0)² - d, which falls and rises again:
/// it is released when the force is zero, however short the dip and wherever it lies between two
/// samples, and not released if the force stays above zero.
#[test]
fn closed_form_a_dip_of_the_contact_force_is_found_between_two_samples() {
    /// Error of the time at which the force falls through zero, times the square root of the
    /// depth: rounding of the force over its slope.
    const TIME: f64 = 1e-14;
    let p =
        Parameters { drive_frequency: 1.0, stop_gap: 1.0, block_mass: 1.0, stop_restitution: 0.0, ..free() };
    for side in [1.0, -1.0] {
        for exponent in 2..=10 {
            for place in 0..40 {
                let (depth, lowest) = (10f64.powi(-exponent), 0.7 + 0.017 * f64::from(place));
                for depth in [depth, -depth] {
                    let at_stop = State { x: [0.0, side, 0.0], v: [0.0; 3] };
                    let mut simulator = Simulator::new(&p, &at_stop, 0.0).unwrap();
                    let force = [lowest * lowest - depth, -2.0 * lowest, 2.0, 0.0].map(|f| side * f);
                    simulator.set_loads(&Loads { derivatives: [[0.0; 4], force, [0.0; 4]] }).unwrap();
                    let mut releases = Vec::new();
                    let mut keep = |event: &Event| {
                        if let Event::Release { time, .. } = event {
                            releases.push(*time);
                        }
                    };
                    simulator.advance_observed(2.4, &mut keep).unwrap();
                    let exact = (depth > 0.0).then(|| lowest - depth.sqrt());
                    assert_eq!(!releases.is_empty(), exact.is_some(), "{depth:e} at {lowest}");
                    if let Some(exact) = exact {
                        let error = (releases[0] - exact).abs();
                        assert!(error <= TIME / depth.sqrt(), "{depth:e} at {lowest}: {error:e}");
                    }
                }
            }
        }
    }
}

/// A block that its load holds at its stop up to rounding, in steps one of which finds an impact
/// in the past: it takes place at the current time, with the state there. Otherwise time and loads
/// would be ahead of the bodies, and the block would gain a velocity from nothing.
#[test]
fn second_method_an_event_found_in_the_past_moves_no_clock() {
    /// Rounding of w relative to the size of the motion: docs/numerics.md, section 3, allows 18 ε
    /// in a time of 1/r.
    const ROUNDING: f64 = 18.0 * f64::EPSILON;
    const STEPS: u32 = 300;
    let p = Parameters {
        box_mass: 4.106534556443866,
        box_stiffness: 0.7250522391175724,
        box_damping: 0.0,
        block_mass: 0.15559747452939504,
        secondary_mass: 9.600513972095115,
        secondary_stiffness: 0.10596007540815833,
        secondary_damping: 0.2244579239451615,
        coupling_stiffness: 0.0,
        stop_gap: 415.5964555069834,
        stop_restitution: 0.9,
        drive_amplitude: 339.01318918245795,
        drive_frequency: 0.7904248931723623,
        drive_phase: 0.06604562253327717,
        constant_loads: [0.0; 3],
    };
    // The load accelerates the block as the drive accelerates the box, up to the fifth derivative
    // of the displacements.
    let load = [0.8477580355092145, 10.131094698408301, -0.6793357438453484, -8.11837159249228];
    let start = State { x: [0.0, -p.stop_gap, 282.5911201755524], v: [0.0, 0.0, -351.95968862946336] };
    let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
    simulator.set_loads(&Loads { derivatives: [[0.0; 4], load, [0.0; 4]] }).unwrap();
    for n in 1..=STEPS {
        simulator.advance_to(9.433306453994917e-3 * f64::from(n) / f64::from(STEPS)).unwrap();
    }
    let way = simulator.relative_motion().0 + p.stop_gap;
    assert!(way < ROUNDING * 3.0 * p.stop_gap, "{way:e}");
}
