//! Properties over wide random parameters, loads and steps. proptest shrinks failing cases and
//! keeps them in `properties.proptest-regressions`.

use proptest::prelude::*;
use vibro_impact::reference::{Reference, Tolerance};
use vibro_impact::simulator::{Contact, Event, ImpactRecord, Loads, Pause, advance_together};
use vibro_impact::{Error, Parameters, Simulator, State};
use vibro_numerics::double_double::DoubleDouble;

/// A number over several decades.
fn decades(low: f64, high: f64) -> impl Strategy<Value = f64> {
    (low.ln()..high.ln()).prop_map(f64::exp)
}

/// Sometimes zero, otherwise a number over several decades.
fn zero_or(low: f64, high: f64) -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 5 => decades(low, high)]
}

fn restitution() -> impl Strategy<Value = f64> {
    prop_oneof![1 => Just(0.0), 1 => Just(1.0), 6 => 0.0..1.0f64, 1 => 0.99..1.0f64]
}

fn parameters() -> impl Strategy<Value = Parameters> {
    let masses = (decades(0.05, 20.0), decades(1e-3, 1e2), decades(1e-2, 1e2));
    let springs = (zero_or(1e-3, 30.0), zero_or(1e-3, 30.0), zero_or(1e-4, 3.0));
    let dampers = (zero_or(1e-4, 3.0), zero_or(1e-4, 3.0));
    let stop = (decades(0.1, 10.0), restitution());
    let drive = (zero_or(1e-2, 30.0), zero_or(0.05, 10.0), -4.0..4.0f64);
    (masses, springs, dampers, stop, drive).prop_map(|(m, k, c, stop, drive)| Parameters {
        box_mass: m.0,
        block_mass: m.1,
        secondary_mass: m.2,
        box_stiffness: k.0,
        secondary_stiffness: k.1,
        coupling_stiffness: k.2,
        box_damping: c.0,
        secondary_damping: c.1,
        stop_gap: stop.0,
        stop_restitution: stop.1,
        drive_amplitude: drive.0,
        drive_frequency: drive.1,
        drive_phase: drive.2,
        constant_loads: [0.0; 3],
    })
}

/// A start inside or on the stops.
fn state(gap: f64) -> impl Strategy<Value = State> {
    let relative = prop_oneof![4 => -1.0..1.0f64, 1 => Just(1.0), 1 => Just(-1.0)];
    (-2.0..2.0f64, relative, -2.0..2.0f64, prop::array::uniform3(-2.0..2.0f64), any::<bool>()).prop_map(
        move |(x1, w, x3, v, still)| {
            let v = if still { [v[0], v[0], v[2]] } else { v };
            // If the box is at zero, w is exactly at a stop if it is meant to be.
            let x1 = if w.abs() == 1.0 { 0.0 } else { x1 };
            State { x: [x1, x1 + w * gap, x3], v }
        },
    )
}

fn loads() -> impl Strategy<Value = Loads> {
    let some = prop::array::uniform3(prop::array::uniform4(-0.5..0.5f64))
        .prop_map(|derivatives| Loads { derivatives });
    prop_oneof![Just(Loads::default()), some]
}

fn system() -> impl Strategy<Value = (Parameters, State)> {
    parameters().prop_flat_map(|p| (Just(p), state(p.stop_gap)))
}

/// Whether an error is the only one allowed for a valid step: the work limit, in a nearly elastic
/// motion.
fn allowed(error: &Error) -> bool {
    matches!(error, Error::WorkLimit { restitution, .. } if *restitution > 0.99)
}

/// Number of cases of a test run; `PROPTEST_CASES=100000 cargo test --release --test properties`
/// runs more.
fn cases() -> ProptestConfig {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(200);
    ProptestConfig { cases, max_global_rejects: 10 * cases, ..ProptestConfig::default() }
}

/// Largest growth until `end` of a small change of one of the initial velocities. Simultaneous
/// changes of several may cancel: in a case of thirteen elastic impacts they grew by less than 1e4
/// together and by 3e6 each.
fn growth(p: &Parameters, start: &State, load: &Loads, end: f64) -> f64 {
    const CHANGE: f64 = 1e-9;
    let state_at_end = |start: &State| -> Result<State, Error> {
        let mut simulator = Simulator::new(p, start, 0.0)?;
        simulator.set_loads(load)?;
        simulator.advance_to(end).map(|()| simulator.state())
    };
    let Ok(a) = state_at_end(start) else { return f64::INFINITY };
    let of_velocity = |i: usize| {
        let mut changed = *start;
        changed.v[i] += CHANGE;
        let Ok(b) = state_at_end(&changed) else { return f64::INFINITY };
        let differences = a.x.iter().chain(&a.v).zip(b.x.iter().chain(&b.v)).map(|(x, y)| (x - y).abs());
        differences.fold(0.0, f64::max) / CHANGE
    };
    (0..3).map(of_velocity).fold(0.0, f64::max)
}

/// Largest growth of small differences in comparisons of two computations of a motion.
const MAX_GROWTH: f64 = 1e4;

proptest! {
    #![proptest_config(cases())]

    #[test]
    fn invariant_stops_restitution_energy_and_work(
        (p, start) in system(),
        script in prop::collection::vec((1e-3..3.0f64, loads()), 1..20),
    ) {
        /// Rounding relative to the energy that passed; under loads states grow to thousands of
        /// gaps.
        const BALANCE: f64 = 1e-9;
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        let first = simulator.energy_accounts().mechanical;
        let (mut passed, mut t) = (first, 0.0);
        for (step, load) in script {
            prop_assume!(simulator.set_loads(&load).is_ok()); // else out of all proportion to this system
            let mut previous = f64::NEG_INFINITY;
            let mut wrong = None;
            let outcome = simulator.advance_until(DoubleDouble::sum(t, step), Pause::Never, Some(&mut |e| {
                let (time, speed, impulse) = match *e {
                    Event::Impact { time, speed, impulse, .. } => (time, speed, impulse),
                    Event::Rest { .. } => return,
                    Event::Release { time, .. } => (time, 0.0, 0.0),
                };
                let reduced = p.box_mass * p.block_mass / (p.box_mass + p.block_mass);
                let expected = (1.0 + p.stop_restitution) * reduced * speed;
                let in_step = time >= t * (1.0 - 1e-15) && time <= (t + step) * (1.0 + 1e-15);
                if speed < 0.0 || (impulse - expected).abs() > 1e-14 * expected || time < previous || !in_step {
                    wrong = Some(*e);
                }
                previous = time;
            }));
            if let Err(error) = outcome {
                prop_assert!(allowed(&error), "{error}");
                return Ok(());
            }
            prop_assert!(wrong.is_none(), "{wrong:?}");
            t += step;
            prop_assert!((simulator.time() - t).abs() <= 1e-15 * t);
            let (w, rate) = simulator.relative_motion();
            prop_assert!(w.abs() <= p.stop_gap * (1.0 + 1e-12));
            if simulator.contact() != Contact::Flight {
                prop_assert!(rate == 0.0 && simulator.contact_force() >= 0.0);
            }
            let l = simulator.energy_accounts();
            prop_assert!(l.damped >= 0.0 && l.impact >= 0.0);
            passed = passed.max(l.mechanical).max(l.damped).max(l.input.abs()).max(l.impact);
            let error = l.mechanical - first - l.input + l.damped + l.impact;
            prop_assert!(error.abs() <= BALANCE * passed.max(1e-6), "{error:e} of {passed:e}");
        }
        /// Bound on the sub-steps per second that do not end at an event.
        const PER_TIME: f64 = 20_000.0;
        let work = simulator.work_counters();
        prop_assert!((work.substeps as f64) < 100.0 + 8.0 * work.events as f64 + PER_TIME * t, "{work:?} in {t}");
    }

    #[test]
    fn invariant_splitting_a_step_changes_nothing_but_round_off(
        (p, start) in system(),
        load in loads(),
        end in 0.1..6.0f64,
        parts in 2..40u32,
    ) {
        let mut whole = Simulator::new(&p, &start, 0.0).unwrap();
        prop_assume!(whole.set_loads(&load).is_ok()); // else out of all proportion to this system
        let mut split = whole.clone();
        let mut least = f64::INFINITY;
        let mut impacts = 0;
        let outcome = whole.advance_observed(end, &mut |e| if let Event::Impact { speed, .. } = e {
            least = least.min(*speed);
            impacts += 1;
        });
        prop_assume!(outcome.is_ok());
        for n in 1..=parts {
            let t = if n == parts { end } else { end * f64::from(n) / f64::from(parts) };
            split.advance_to(t).unwrap();
        }
        // A slow impact or a long run of impacts amplifies rounding: then the two may differ
        // considerably.
        prop_assume!(least > 1e-2 && impacts < 30 && growth(&p, &start, &load, end) < MAX_GROWTH);
        /// Rounding of some hundred sub-steps, amplified by up to 30 impacts no slower than 0.01
        /// m/s.
        const BOUND: f64 = 1e-7;
        let (a, b) = (whole.state(), split.state());
        let scale = a.x.iter().chain(&a.v).fold(1.0f64, |m, x| m.max(x.abs()));
        for (x, y) in a.x.iter().chain(&a.v).zip(b.x.iter().chain(&b.v)) {
            prop_assert!((x - y).abs() <= BOUND * scale, "{a:?} {b:?}");
        }
        prop_assert_eq!(whole.impacts().upper, split.impacts().upper);
    }

    #[test]
    fn second_method_agrees_over_a_few_periods(
        (p, start) in system(),
        load in loads(),
        end in 0.1..8.0f64,
    ) {
        /// Local tolerance of the reference method. Its error is this times the number of steps,
        /// amplified by impacts: in a motion through rest, release and ten plastic impacts it was
        /// 5e-5 with 1e-11, 5e-6 with 1e-12, 5e-7 with 1e-13.
        const TOLERANCE: f64 = 1e-12;
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        prop_assume!(simulator.set_loads(&load).is_ok()); // else out of all proportion to this system
        // From a start at rest, the reference method counts a touch of some 1e-11 m/s; the
        // simulator counts none.
        let mut flies = simulator.contact() == Contact::Flight;
        let (mut least, mut events) = (f64::INFINITY, 0);
        let outcome = simulator.advance_observed(end, &mut |e| {
            events += 1;
            flies &= !matches!(e, Event::Rest { time: 0.0, .. });
            if let Event::Impact { speed, .. } = e {
                least = least.min(*speed);
            }
        });
        // Slow impacts, chatter and long runs of impacts amplify the reference method's error
        // without bound.
        prop_assume!(outcome.is_ok() && least > 2e-2 * p.stop_gap && events < 15);
        prop_assume!(growth(&p, &start, &load, end) < MAX_GROWTH);
        let mut reference = Reference::new(&p, &start, 0.0, Tolerance::new(TOLERANCE)).unwrap();
        reference.set_loads(&load).unwrap();
        prop_assume!(reference.advance_to(end).is_ok());
        let (a, b) = (simulator.state(), reference.state());
        let scale = a.x.iter().chain(&a.v).fold(1.0f64, |m, x| m.max(x.abs()));
        /// Tolerance of a few thousand steps, amplified by up to 15 impacts.
        const BOUND: f64 = 1e-5;
        for (x, y) in a.x.iter().chain(&a.v).zip(b.x.iter().chain(&b.v)) {
            prop_assert!((x - y).abs() <= BOUND * scale, "{a:?} {b:?}");
        }
        let count = |i: &ImpactRecord| (i.upper, i.lower);
        if flies {
            prop_assert_eq!(count(simulator.impacts()), count(reference.impacts()));
        }
    }

    #[test]
    fn second_method_together_as_one_by_one(
        systems in prop::collection::vec(system(), 1..12),
        end in 0.5..12.0f64,
    ) {
        /// Rounding of some hundred sub-steps, amplified by up to 100 impacts.
        const BOUND: f64 = 1e-8;
        /// Number of impacts of a run near the limit of work.
        const MANY: u64 = 900_000;
        let first: Vec<Simulator> =
            systems.iter().map(|(p, start)| Simulator::new(p, start, 0.0).unwrap().without_energy_accounts()).collect();
        let mut together = first.clone();
        let results = advance_together(&mut together, |_| end);
        for (i, (p, start)) in systems.iter().enumerate() {
            // Bit-identical without the other motions.
            let mut single = [first[i].clone()];
            prop_assert_eq!(&advance_together(&mut single, |_| end)[0], &results[i]);
            prop_assert_eq!(single[0].snapshot(), together[i].snapshot());
            let (mut alone, mut least, mut impacts) = (first[i].clone(), f64::INFINITY, 0u64);
            let outcome = alone.advance_observed(end, &mut |e| if let Event::Impact { speed, .. } = e {
                least = least.min(*speed);
                impacts += 1;
            });
            let together = &together[i];
            // The work limit counts sub-steps, whose number differs slightly between the two
            // methods.
            prop_assert!(outcome.is_ok() == results[i].is_ok() || impacts > MANY);
            if let Err(error) = &results[i] {
                prop_assert!(allowed(error), "{error}");
            }
            let (w, _) = together.relative_motion();
            prop_assert!(w.abs() <= p.stop_gap * (1.0 + 1e-12));
            // A slow impact or a long run of impacts amplifies rounding: then the two may differ
            // considerably.
            if outcome.is_err() || results[i].is_err() || least < 1e-2 || impacts > 100
                || growth(p, start, &Loads::default(), end) >= MAX_GROWTH {
                continue;
            }
            let (a, b) = (alone.state(), together.state());
            let scale = a.x.iter().chain(&a.v).fold(1.0f64, |m, x| m.max(x.abs()));
            for (x, y) in a.x.iter().chain(&a.v).zip(b.x.iter().chain(&b.v)) {
                prop_assert!((x - y).abs() <= BOUND * scale, "{a:?} {b:?}");
            }
            let count = |s: &Simulator| (s.impacts().upper, s.impacts().lower, s.contact());
            prop_assert_eq!(count(&alone), count(together));
        }
    }

    #[test]
    fn invariant_repeats_mirrors_and_resumes_bit_by_bit(
        (p, start) in system(),
        load in loads(),
        steps in prop::collection::vec(1e-4..2.0f64, 1..12),
    ) {
        let mirror = |s: &State| State { x: s.x.map(|x| -x), v: s.v.map(|v| -v) };
        let opposite = Parameters { drive_amplitude: -p.drive_amplitude, ..p };
        let against = Loads { derivatives: load.derivatives.map(|d| d.map(|x| -x)) };
        let mut one = Simulator::new(&p, &start, 0.0).unwrap();
        let mut two = Simulator::new(&opposite, &mirror(&start), 0.0).unwrap();
        let mut other = Simulator::new(&Parameters::default(), &State::default(), -5.0).unwrap();
        let refused = one.set_loads(&load);
        prop_assert_eq!(&refused, &two.set_loads(&against));
        if refused.is_err() {
            return Ok(()); // out of all proportion to this system
        }
        let mut t = 0.0;
        for step in steps {
            other.restore(&one.snapshot()).unwrap();
            t += step;
            let outcome = one.advance_to(t);
            prop_assert_eq!(&outcome, &two.advance_to(t));
            prop_assert_eq!(&outcome, &other.advance_to(t));
            prop_assert_eq!(one.snapshot(), other.snapshot());
            // Equal as numbers: the mirror of 0 is -0.
            prop_assert_eq!(one.state(), mirror(&two.state()));
            if outcome.is_err() {
                return Ok(());
            }
        }
    }
}
