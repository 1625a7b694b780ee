//! Invariants of every motion: laws of impact, energy, independence of the steps, symmetry,
//! repeatability.

use vibro_impact::model::Model;
use vibro_impact::simulator::{Contact, Event, Loads, Pause};
use vibro_impact::{Groups, Parameters, Scales, Simulator, State};
use vibro_numerics::double_double::DoubleDouble;

fn start() -> State {
    State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] }
}

fn basic(f10: f64, kappa: f64) -> Parameters {
    Groups { f10, kappa, ..Groups::basic() }.to_parameters(Scales::default()).unwrap()
}

/// Distance of two states.
fn distance(a: &State, b: &State) -> f64 {
    a.x.iter().chain(&a.v).zip(b.x.iter().chain(&b.v)).map(|(p, q)| (p - q).abs()).fold(0.0, f64::max)
}

#[test]
fn invariant_the_state_does_not_depend_on_the_communication_steps() {
    /// Rounding, amplified by 400 impacts of a stable motion.
    const BOUND: f64 = 1e-10;
    let p = Parameters::default();
    let end = 200.0 * p.period();
    let mut whole = Simulator::new(&p, &start(), 0.0).unwrap();
    whole.advance_to(end).unwrap();
    for step in [p.period() / 10.0, p.period() / 7.3, 13.0 * p.period(), 1e-3 * p.period()] {
        let mut simulator = Simulator::new(&p, &start(), 0.0).unwrap();
        let mut n = 0u32;
        while simulator.time() < end {
            n += 1;
            simulator.advance_to((f64::from(n) * step).min(end)).unwrap();
        }
        assert_eq!(simulator.time(), end);
        let d = distance(&simulator.state(), &whole.state());
        assert!(d < BOUND, "step {step}: {d:e}");
        assert_eq!(simulator.impacts().upper, whole.impacts().upper);
    }
}

#[test]
fn invariant_momentum_and_restitution_at_each_impact() {
    /// Relative rounding of a velocity jump.
    const ROUNDING: f64 = 1e-13;
    let p = basic(3.5, 0.75);
    let mut simulator = Simulator::new(&p, &start(), 0.0).unwrap();
    let mut seen = 0;
    while seen < 200 {
        // A copy from the last impact, to be advanced to just before this one.
        let before = simulator.clone();
        let mut impact = None;
        let begin = simulator.time();
        simulator
            .advance_until(
                DoubleDouble::sum(begin, 100.0),
                Pause::AfterImpact,
                Some(&mut |e| {
                    if let Event::Impact { time, side, speed, impulse } = *e {
                        impact = Some((time, f64::from(side), speed, impulse));
                    }
                }),
            )
            .unwrap();
        let (time, side, speed, impulse) = impact.expect("an impact comes");
        let mut approach = before;
        let just_before = time - 1e-9;
        if just_before <= approach.time() {
            continue;
        }
        approach.advance_to(just_before).unwrap();
        let (a, b) = (approach.state(), simulator.state());
        let acceleration = approach.acceleration();
        let v: Vec<f64> = (0..3).map(|i| a.v[i] + acceleration[i] * (time - just_before)).collect();
        let (m1, m2) = (p.box_mass, p.block_mass);
        const EXTRAPOLATION: f64 = 1e-12; // the jerk over a nanosecond, and the rounding of time
        assert!((m1 * (b.v[0] - v[0]) - side * impulse).abs() < EXTRAPOLATION);
        assert!((m2 * (b.v[1] - v[1]) + side * impulse).abs() < EXTRAPOLATION);
        assert!((b.v[2] - v[2]).abs() < EXTRAPOLATION);
        assert!((b.v[1] - b.v[0] + p.stop_restitution * side * speed).abs() < ROUNDING);
        assert!((impulse - (1.0 + p.stop_restitution) * m1 * m2 / (m1 + m2) * speed).abs() < ROUNDING);
        assert_eq!(simulator.relative_motion().0, side * p.stop_gap);
        seen += 1;
    }
}

#[test]
fn invariant_energy_balance_over_ten_thousand_periods() {
    /// Bound, relative to the energy turnover (docs/guarantees.md).
    const BOUND: f64 = 1e-12;
    for (f10, kappa) in [(1.5, 0.75), (0.6, 0.75), (3.6, 0.75), (1.5, 0.0), (1.5, 1.0)] {
        let p = basic(f10, kappa);
        let mut simulator = Simulator::new(&p, &start(), 0.0).unwrap();
        let first = simulator.energy_accounts();
        simulator.advance_to(1e4 * p.period()).unwrap();
        let l = simulator.energy_accounts();
        let error = l.mechanical - first.mechanical - l.input + l.damped + l.impact;
        assert!(error.abs() < BOUND * l.damped, "f {f10} κ {kappa}: {error:e} of {}", l.damped);
        assert!(l.damped > 1.0 && l.input > l.damped);
    }
}

/// In steps shorter than an interval the damping in flight is computed by another rule, over at
/// most half an interval or over all of it.
#[test]
fn invariant_energy_balance_in_short_steps() {
    /// Bound, relative to the energy turnover (docs/guarantees.md).
    const BOUND: f64 = 1e-12;
    let basic = basic(1.5, 0.75);
    // The drive is the fastest rate, with which the errors of the rules are largest.
    let fast = Parameters { drive_frequency: 50.0, drive_amplitude: 50.0, ..basic };
    for p in [basic, fast] {
        for part in [0.99, 0.49, 0.1] {
            let off = imbalance_in_steps(&p, part, 10_000);
            assert!(off < BOUND, "{part} of an interval: {off:e}");
        }
    }
}

/// Impacts that recur at one phase of the drive give the rule's error one sign, so that it
/// accumulates. Given a damper whose rate is a fifth of the fastest, the sum exceeds rounding in
/// steps over which that rule alone computes the damping, but not in other steps.
#[test]
fn invariant_energy_balance_in_steps_of_half_an_interval_beside_a_damper() {
    /// Bounds relative to the energy that passed through (docs/guarantees.md), in steps in which
    /// the rule's error accumulates and in others.
    const BOUNDS: [f64; 2] = [1e-11, 1e-12];
    let p = Parameters {
        box_stiffness: 0.823,
        box_damping: 0.215,
        block_mass: 0.353,
        secondary_mass: 0.0713,
        secondary_stiffness: 0.0432,
        secondary_damping: 0.00374,
        coupling_stiffness: 0.00464,
        stop_restitution: 0.98,
        drive_amplitude: 0.54,
        drive_frequency: 1.14,
        ..Parameters::default()
    };
    let [half, other] = [0.499, 0.1].map(|part| imbalance_in_steps(&p, part, 4000));
    assert!(half > BOUNDS[1] && half < BOUNDS[0], "{half:e}");
    assert!(other < BOUNDS[1], "{other:e}");
}

/// Imbalance of the accounts after a number of `steps`, each a `part` of an interval, relative to
/// the energy that passed through.
fn imbalance_in_steps(p: &Parameters, part: f64, steps: u32) -> f64 {
    let interval = 0.15 / Model::new(p).unwrap().rate;
    let mut simulator = Simulator::new(p, &start(), 0.0).unwrap();
    let first = simulator.energy_accounts().mechanical;
    for n in 1..=steps {
        simulator.advance_to(f64::from(n) * part * interval).unwrap();
    }
    let l = simulator.energy_accounts();
    let error = l.mechanical - first - l.input + l.damped + l.impact;
    error.abs() / first.max(l.mechanical).max(l.damped).max(l.input)
}

/// A box that moves by its gap in a small part of a drive period: its forced vibration is a
/// million gaps wide.
#[test]
fn invariant_energy_balance_under_a_strong_and_slow_drive() {
    /// Bound relative to the energy that passed through, or to the drive's work over the gap if
    /// that is more (docs/guarantees.md).
    const BOUND: f64 = 1e-12;
    let soft = Parameters {
        box_stiffness: 1e-3,
        drive_frequency: 1e-3,
        drive_amplitude: 1e3,
        drive_phase: 0.7,
        ..basic(1.5, 0.75)
    };
    let mut simulator = Simulator::new(&soft, &start(), 0.0).unwrap();
    let first = simulator.energy_accounts().mechanical;
    for n in 1..=40 {
        simulator.advance_to(0.05 * f64::from(n)).unwrap();
        let l = simulator.energy_accounts();
        let error = l.mechanical - first - l.input + l.damped + l.impact;
        let passed = first.max(l.mechanical).max(l.input).max(soft.drive_amplitude * soft.stop_gap);
        assert!(error.abs() < BOUND * passed, "{n}: {error:e} of {passed}");
    }
}

#[test]
fn second_method_drive_work_in_closed_form_and_by_quadrature() {
    /// Rounding over 300 periods. Under any nonzero load, all work is computed by quadrature.
    const ROUNDING: f64 = 1e-12;
    let undamped = |p: Parameters, detuning: f64| {
        let resonance = (p.box_stiffness / p.box_mass).sqrt();
        Parameters { box_damping: 0.0, drive_frequency: resonance * (1.0 + detuning), ..p }
    };
    let p = basic(1.5, 0.75);
    for p in [p, basic(3.0, 0.1), undamped(p, 0.0), undamped(p, 1e-4), undamped(p, 0.02), undamped(p, -0.3)] {
        let mut form = Simulator::new(&p, &start(), 0.0).unwrap();
        for n in 1..=300 {
            // The quadrature restarts from this state each period, so that the motions stay
            // together.
            let mut rule = Simulator::new(&p, &form.state(), form.time()).unwrap();
            rule.set_loads(&Loads { derivatives: [[f64::MIN_POSITIVE, 0.0, 0.0, 0.0], [0.0; 4], [0.0; 4]] })
                .unwrap();
            let before = form.energy_accounts();
            form.advance_to(f64::from(n) * p.period()).unwrap();
            rule.advance_to(f64::from(n) * p.period()).unwrap();
            let (a, b) = (form.energy_accounts(), rule.energy_accounts());
            let size = a.mechanical + b.input.abs() + before.input.abs();
            assert!(
                (a.input - before.input - b.input).abs() < ROUNDING * size,
                "{n}: {a:?} {before:?} {b:?}"
            );
            assert!(
                (a.damped - before.damped - b.damped).abs() < ROUNDING * size,
                "{n}: {a:?} {before:?} {b:?}"
            );
        }
        let l = form.energy_accounts();
        let first = Simulator::new(&p, &start(), 0.0).unwrap().energy_accounts().mechanical;
        let error = l.mechanical - first - l.input + l.damped + l.impact;
        assert!(error.abs() < ROUNDING * l.input.abs().max(l.mechanical), "{error:e} of {l:?}");
    }
}

#[test]
fn invariant_energy_balance_under_loads_in_all_modes() {
    /// Rounding of the quadrature over some thousand steps.
    const BOUND: f64 = 1e-12;
    let p = basic(3.0, 0.1);
    let mut simulator = Simulator::new(&p, &start(), 0.0).unwrap();
    let first = simulator.energy_accounts().mechanical;
    let mut rests = 0;
    for n in 0..3000 {
        let t = 0.31 * f64::from(n);
        let (s, c) = (0.3 * t).sin_cos();
        let load = [0.05 * s, 0.015 * c, -0.0045 * s, -0.00135 * c];
        simulator
            .set_loads(&Loads { derivatives: [load, load.map(|x| -0.3 * x), load.map(|x| 0.2 * x)] })
            .unwrap();
        simulator
            .advance_until(
                DoubleDouble::sum(t, 0.31),
                Pause::Never,
                Some(&mut |e| rests += u32::from(matches!(e, Event::Rest { .. }))),
            )
            .unwrap();
    }
    let l = simulator.energy_accounts();
    let error = l.mechanical - first - l.input + l.damped + l.impact;
    assert!(rests > 10, "the case is meant to reach rest: {rests}");
    assert!(error.abs() < BOUND * l.damped, "{error:e} of {}", l.damped);
}

#[test]
fn invariant_reflection_turns_the_motion_by_half_a_period() {
    let p = basic(3.5, 0.75);
    let s = start();
    let mirrored = State { x: s.x.map(|x| -x), v: s.v.map(|v| -v) };
    let mut one = Simulator::new(&p, &s, 0.0).unwrap();
    let mut two =
        Simulator::new(&Parameters { drive_amplitude: -p.drive_amplitude, ..p }, &mirrored, 0.0).unwrap();
    let end = 500.0 * p.period();
    one.advance_to(end).unwrap();
    two.advance_to(end).unwrap();
    let (a, b) = (one.state(), two.state());
    assert_eq!(a.x, b.x.map(|x| -x));
    assert_eq!(a.v, b.v.map(|v| -v));
    assert_eq!(one.impacts().upper, two.impacts().lower);
}

/// A load throws the block past one stop and, if that stop did not exist, past the other within
/// one interval. Both stops are searched, and the root at the first must not depend on which of
/// them is the upper one.
#[test]
fn invariant_the_mirror_image_has_the_same_bits_where_both_stops_are_in_reach() {
    const STARTS: u32 = 6000;
    let p = Parameters::default();
    let opposite = Parameters { drive_amplitude: -p.drive_amplitude, ..p };
    let [one, two] = [p, opposite].map(|p| Simulator::new(&p, &State::default(), 0.0).unwrap());
    let interval = 0.15 / Model::new(&p).unwrap().rate;
    let mut seed = 1u64;
    let mut next = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut hits = 0;
    for _ in 0..STARTS {
        // In an interval the path rises above the upper stop, reverses and reaches the lower one.
        let (x1, x3, v1, v3) = (next() - 0.5, next() - 0.5, 0.3, next());
        let w = p.stop_gap * (0.85 + 0.149 * next());
        let rate = (0.5 + 0.7 * next()) * p.stop_gap / interval;
        let force = -2.0 * (1.8 + 1.5 * next()) * p.stop_gap * p.block_mass / (interval * interval);
        let end = (0.9 + 0.1 * next()) * interval;
        let image = |sign: f64, of: &Simulator| {
            let [x, v] = [[x1, x1 + w, x3], [v1, v1 + rate, v3]].map(|of| of.map(|a| sign * a));
            let mut simulator = of.with_state(&State { x, v }, 0.0).unwrap();
            let load = [sign * force, 0.0, 0.0, 0.0];
            simulator.set_loads(&Loads { derivatives: [[0.0; 4], load, [0.0; 4]] }).unwrap();
            simulator.advance_until(end, Pause::AfterImpact, None).unwrap();
            simulator
        };
        let (a, b) = (image(1.0, &one), image(-1.0, &two));
        hits += a.impacts().upper;
        assert_eq!(a.time(), b.time());
        assert_eq!((a.state().x, a.state().v), (b.state().x.map(|x| -x), b.state().v.map(|v| -v)));
    }
    assert!(hits > u64::from(STARTS / 4), "{hits}");
}

#[test]
fn invariant_snapshot_and_restore_give_the_same_bits() {
    let p = basic(0.748, 0.5);
    let mut one = Simulator::new(&p, &start(), 0.0).unwrap();
    one.set_loads(&Loads { derivatives: [[0.01, 0.001, 0.0, 0.0], [0.0; 4], [0.002, 0.0, 0.0, 0.0]] })
        .unwrap();
    let mut two = Simulator::new(&Parameters::default(), &State::default(), 7.0).unwrap();
    let mut t = 0.0;
    for n in 1..400 {
        two.restore(&one.snapshot()).unwrap();
        t += 0.1 + 0.01 * f64::from(n % 17);
        one.advance_to(t).unwrap();
        two.advance_to(t).unwrap();
        assert_eq!(one.snapshot(), two.snapshot(), "at {t}");
    }
}

#[test]
fn invariant_phase_and_state_after_a_million_periods_equal_a_restart() {
    /// Rounding of angle and state: both times are equal doubles.
    const BOUND: f64 = 1e-11;
    let p = Parameters::default();
    let mut long = Simulator::new(&p, &start(), 0.0).unwrap().without_energy_accounts();
    let period = p.period();
    long.advance_to(1e6 * period).unwrap();
    let mut restart = Simulator::new(&p, &long.state(), long.time()).unwrap();
    let angle = |s: &Simulator| s.drive_phase().sin_cos();
    let ((s1, c1), (s2, c2)) = (angle(&long), angle(&restart));
    assert!((s1 - s2).abs() + (c1 - c2).abs() < BOUND);
    long.advance_to(1e6 * period + 50.0).unwrap();
    restart.advance_to(1e6 * period + 50.0).unwrap();
    assert!(distance(&long.state(), &restart.state()) < BOUND);
    // And the periodic motion after 10⁶ periods is that after 10³: the phase has not slipped.
    let mut short = Simulator::new(&p, &start(), 0.0).unwrap();
    short.advance_to(1e3 * period).unwrap();
    let mut end = Simulator::new(&p, &start(), 0.0).unwrap();
    end.advance_to(1e6 * period).unwrap();
    /// Rounding of 10⁶ periods as a double, up to 5e-10 s, times speeds of about 1 m/s.
    const TIME_ROUNDING: f64 = 2e-9;
    assert!(distance(&short.state(), &end.state()) < TIME_ROUNDING);
}

#[test]
fn invariant_rest_holds_the_stop_and_lets_go_with_falling_force() {
    let p = basic(3.0, 0.0);
    let mut simulator = Simulator::new(&p, &start(), 0.0).unwrap();
    let (mut rests, mut releases) = (0, 0);
    for n in 0..20_000 {
        simulator
            .advance_until(
                DoubleDouble::sum(0.01 * f64::from(n), 0.01),
                Pause::Never,
                Some(&mut |e| match e {
                    Event::Rest { .. } => rests += 1,
                    Event::Release { .. } => releases += 1,
                    _ => {}
                }),
            )
            .unwrap();
        let (w, rate) = simulator.relative_motion();
        assert!(w.abs() <= p.stop_gap);
        if simulator.contact() != Contact::Flight {
            assert_eq!((w.abs(), rate), (p.stop_gap, 0.0));
            assert!(simulator.contact_force() >= 0.0);
            let a = simulator.acceleration();
            assert!((a[0] - a[1]).abs() < 1e-14, "box and block move as one");
        }
    }
    assert!(rests > 50 && releases + 1 >= rests, "{rests} {releases}");
}

#[test]
fn invariant_a_change_of_frequency_keeps_the_force_continuous() {
    let p = Parameters::default();
    let mut simulator = Simulator::new(&p, &start(), 0.0).unwrap();
    simulator.advance_to(1234.5).unwrap();
    let before = simulator.drive_phase();
    simulator.set_parameters(&Parameters { drive_frequency: 1.3, ..p }).unwrap();
    assert!((simulator.drive_phase() - before).abs() < 1e-14);
    let wrong = Parameters { drive_frequency: f64::NAN, ..p };
    let snapshot = simulator.snapshot();
    let message = simulator.set_parameters(&wrong).unwrap_err().to_string();
    assert!(message.contains("drive.frequency") && message.contains("NaN"), "{message}");
    assert_eq!(simulator.snapshot(), snapshot);
}
