//! All kinds of starts, and parameters at the limits of their ranges.

use vibro_impact::simulator::{Contact, Event, Loads, Pause};
use vibro_impact::{Error, Parameters, Simulator, State};
use vibro_numerics::double_double::DoubleDouble;

fn at_stop(side: f64, relative: f64) -> State {
    State { x: [0.0, side, 0.0], v: [0.0, relative, 0.0] }
}

/// Machine without springs on box and block. At rest only the given push acts.
fn pushed(push: f64) -> Parameters {
    Parameters {
        box_stiffness: 0.0,
        coupling_stiffness: 0.0,
        drive_frequency: 0.0,
        drive_phase: 0.0,
        ..Parameters::default()
    }
    .with_push(push)
}

trait Push {
    fn with_push(self, push: f64) -> Self;
}

impl Push for Parameters {
    /// Constant force on the box, as a drive of frequency zero at the phase π/2.
    fn with_push(self, push: f64) -> Self {
        Self { drive_amplitude: push, drive_phase: std::f64::consts::FRAC_PI_2, ..self }
    }
}

#[test]
fn closed_form_contact_at_the_start() {
    for side in [1.0, -1.0] {
        let rest = if side > 0.0 { Contact::RestUpper } else { Contact::RestLower };
        // If pushed towards the block, the box presses it; if pulled away, it leaves the block
        // behind.
        let pressed = Simulator::new(&pushed(-0.1 * side), &at_stop(side, 0.0), 0.0).unwrap();
        assert_eq!(pressed.contact(), rest);
        let free = Simulator::new(&pushed(0.1 * side), &at_stop(side, 0.0), 0.0).unwrap();
        assert_eq!(free.contact(), Contact::Flight);
        let still = Simulator::new(&pushed(0.0), &at_stop(side, 0.0), 0.0).unwrap();
        assert_eq!(still.contact(), rest, "touching with nothing that moves them");
    }
}

#[test]
fn closed_form_approach_speed_at_the_start_is_an_impact_at_once() {
    for side in [1.0, -1.0] {
        for step in [1e-14, 1e-3, 10.0] {
            let mut simulator =
                Simulator::new(&Parameters::default(), &at_stop(side, 0.5 * side), 3.0).unwrap();
            let mut first = None;
            simulator
                .advance_until(
                    DoubleDouble::sum(3.0, step),
                    Pause::AfterImpact,
                    Some(&mut |e| first = first.or(Some(*e))),
                )
                .unwrap();
            match first {
                Some(Event::Impact { time, speed, side: s, .. }) => {
                    assert_eq!((time, speed, f64::from(s)), (3.0, 0.5, side));
                }
                other => panic!("{other:?}"),
            }
        }
    }
}

#[test]
fn closed_form_leaving_speed_at_the_start_is_none() {
    let mut simulator = Simulator::new(&Parameters::default(), &at_stop(1.0, -0.5), 0.0).unwrap();
    simulator.advance_to(0.5).unwrap();
    assert_eq!(simulator.impacts().upper, 0);
    assert!(simulator.relative_motion().0 < 0.9);
}

#[test]
fn bad_starts_are_named() {
    let p = Parameters::default();
    let outside = Simulator::new(&p, &at_stop(1.001, 0.0), 0.0).unwrap_err();
    assert!(matches!(outside, Error::Penetration { .. }), "{outside}");
    assert!(outside.to_string().contains("1.001"));
    let nan = State { v: [0.0, 0.0, f64::NAN], ..State::default() };
    assert!(Simulator::new(&p, &nan, 0.0).unwrap_err().to_string().contains("secondary.v"));
    assert!(Simulator::new(&p, &State::default(), f64::INFINITY).unwrap_err().to_string().contains("time"));
    let far = State { x: [1e12, 1e12, 0.0], v: [0.0; 3] };
    assert!(matches!(Simulator::new(&p, &far, 0.0).unwrap_err(), Error::PrecisionLost { .. }));
    let stiff = Parameters { secondary_mass: 1e-30, ..p };
    assert!(matches!(
        Simulator::new(&stiff, &State::default(), 0.0).unwrap_err(),
        Error::PrecisionLost { .. }
    ));
    let mut simulator = Simulator::new(&p, &State::default(), 0.0).unwrap();
    for end in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(simulator.advance_to(end).unwrap_err(), Error::Step { .. }));
    }
    let before = simulator.snapshot();
    for end in [1e16, 1e305] {
        let late = simulator.advance_to(end).unwrap_err();
        assert!(late.to_string().contains("time times the fastest rate"), "{late}");
        assert!(matches!(Simulator::new(&p, &State::default(), end), Err(Error::PrecisionLost { .. })));
    }
    assert_eq!(simulator.snapshot(), before);
    let loads = Loads { derivatives: [[0.0; 4], [0.0, f64::NAN, 0.0, 0.0], [0.0; 4]] };
    assert!(simulator.set_loads(&loads).unwrap_err().to_string().contains("block.f"));
}

#[test]
fn second_method_a_drive_phase_of_any_size_is_its_rest_of_a_turn() {
    /// Rounding of the reduced phase, amplified over three periods.
    const ROUNDING: f64 = 1e-12;
    let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    let base = Parameters::default();
    for phase in [1e6, 1e15, -3.7e22, -9.2e305, f64::MAX] {
        let far = Parameters { drive_phase: phase, ..base };
        let near = Parameters { drive_phase: phase.sin().atan2(phase.cos()), ..base };
        let end = 3.0 * base.period();
        let at_end = |p: &Parameters| {
            let mut simulator = Simulator::new(p, &start, 0.0).unwrap();
            simulator.advance_to(end).unwrap();
            simulator
        };
        let (mut one, mut two) = (at_end(&far), at_end(&near));
        for back in [None, Some(base), Some(far), Some(Parameters { drive_phase: -phase, ..base })] {
            if let Some(p) = back {
                // A change from one phase to another, however far apart, followed by a snapshot.
                one.set_parameters(&p).unwrap();
                let reduced = p.drive_phase.sin().atan2(p.drive_phase.cos());
                two.set_parameters(&Parameters { drive_phase: reduced, ..p }).unwrap();
                let saved = one.snapshot();
                one.restore(&saved).unwrap();
            }
            let (t, step) = (one.time(), 0.1);
            one.advance_to(t + step).unwrap();
            two.advance_to(t + step).unwrap();
            for (a, b) in one.state().x.iter().zip(two.state().x) {
                assert!((a - b).abs() < ROUNDING, "{phase:e}: {a} {b}");
            }
        }
    }
}

#[test]
fn invariant_extreme_but_allowed_parameters_keep_the_stops_and_the_energy() {
    /// Bound relative to the largest of mechanical energy, damped energy and work. Stiff springs
    /// store much more than the work.
    const BOUND: f64 = 1e-9;
    let p = Parameters::default();
    let cases = [
        ("undamped", Parameters { box_damping: 0.0, secondary_damping: 0.0, ..p }),
        ("uncoupled", Parameters { coupling_stiffness: 0.0, ..p }),
        ("box adrift", Parameters { box_stiffness: 0.0, ..p }),
        ("all adrift", Parameters { box_stiffness: 0.0, secondary_stiffness: 0.0, ..p }),
        ("heavy block", Parameters { block_mass: 1e3, ..p }),
        ("light block", Parameters { block_mass: 1e-6, ..p }),
        (
            "weak springs",
            Parameters { box_stiffness: 1e-8, coupling_stiffness: 1e-9, secondary_stiffness: 1e-8, ..p },
        ),
        ("stiff coupling", Parameters { coupling_stiffness: 1e4, ..p }),
        ("stiff box", Parameters { box_stiffness: 1e5, ..p }),
        ("overdamped box", Parameters { box_damping: 1e3, ..p }),
        ("strong drive", Parameters { drive_amplitude: 1e4, ..p }),
        ("tiny gap", Parameters { stop_gap: 1e-6, ..p }),
        ("no drive", Parameters { drive_amplitude: 0.0, ..p }),
        ("constant force", Parameters { drive_frequency: 0.0, drive_phase: 1.0, ..p }),
        ("fast drive", Parameters { drive_frequency: 300.0, ..p }),
        ("slow drive", Parameters { drive_frequency: 1e-4, ..p }),
    ];
    for (name, p) in cases {
        for kappa in [0.0, 0.75, 1.0] {
            let p = Parameters { stop_restitution: kappa, ..p };
            let start = State { x: [0.0, 0.9 * p.stop_gap, 0.0], v: [0.0, 0.5, 0.0] };
            let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
            let first = simulator.energy_accounts().mechanical;
            let mut passed = first;
            // In the tiny gap the block hits a stop a million times as often.
            let count = if p.stop_gap < 1e-3 { 50 } else { 500 };
            for n in 1..=count {
                simulator
                    .advance_to(0.2 * f64::from(n))
                    .unwrap_or_else(|e| panic!("{name}, κ = {kappa}: {e}"));
                let (w, _) = simulator.relative_motion();
                assert!(w.abs() <= p.stop_gap, "{name}, κ = {kappa}: {w}");
                let l = simulator.energy_accounts();
                passed = passed.max(l.mechanical).max(l.damped).max(l.input.abs());
            }
            let l = simulator.energy_accounts();
            let error = l.mechanical - first - l.input + l.damped + l.impact;
            assert!(error.abs() < BOUND * passed, "{name}, κ = {kappa}: {error:e} of {passed:e}");
            assert!(simulator.impacts().upper > 0, "{name}, κ = {kappa}");
        }
    }
}

#[test]
fn invariant_a_step_of_nothing_from_the_present_is_none() {
    let mut simulator = Simulator::new(&Parameters::default(), &State::default(), 0.0).unwrap();
    for n in 0..200 {
        // The step ends at a time in extended precision, which rounding to a double may decrease.
        simulator.advance_until(DoubleDouble::sum(simulator.time(), 0.0317), Pause::Never, None).unwrap();
        let before = simulator.time();
        simulator.advance_observed(before, &mut |_| {}).unwrap_or_else(|e| panic!("step {n}: {e}"));
        assert_eq!(simulator.time(), before);
    }
}

/// Motions with absurd speeds end soon and stay within the stops. Just after a release or between
/// two fast impacts, the bound on a sub-step's acceleration is far above the acceleration; it must
/// not shorten the step. (Found by the fuzzer.)
#[test]
fn invariant_absurd_speeds_end_and_keep_the_stops() {
    for speed in [1e3, 1e12] {
        let start = State { x: [0.0, 1.0, 4.0], v: [4.0, -speed, 4.0] };
        let mut simulator = Simulator::new(&Parameters::default(), &start, 0.0).unwrap();
        simulator.advance_to(30.0).unwrap();
        assert!(simulator.relative_motion().0.abs() <= 1.0);
        assert!(simulator.work_counters().substeps < 100_000, "{speed:e}: {:?}", simulator.work_counters());
    }
    let p = Parameters::default();
    let refused = |p: &Parameters, v: f64| {
        let start = State { x: [0.0; 3], v: [0.0, v, 0.0] };
        matches!(Simulator::new(p, &start, 0.0), Err(Error::PrecisionLost { .. }))
    };
    assert!(refused(&p, 6e66));
    assert!(refused(&Parameters { stop_gap: 1e-300, ..p }, 0.5));
    assert!(refused(&Parameters { drive_amplitude: 1e30, ..p }, 0.0));
    // Squares of speeds, the criterion for closing chatter, must not underflow: a motion scaled by
    // a power of two is bit-identical, or is refused.
    let scaled = |gap: f64| {
        let p = Parameters {
            drive_amplitude: 0.3 * gap,
            stop_gap: gap,
            block_mass: 1.0,
            stop_restitution: 0.3,
            ..p
        };
        let start = State { x: [0.0, 0.9 * gap, 0.0], v: [0.0, 0.5 * gap, 0.0] };
        let mut simulator = Simulator::new(&p, &start, 0.0)?;
        simulator.advance_to(100.0).map(|()| (simulator.state().x.map(|x| x / gap), *simulator.impacts()))
    };
    let ((one, few), (other, many)) = (scaled(1.0).unwrap(), scaled(2f64.powi(-330)).unwrap());
    assert!(one == other && few.upper == many.upper && few.upper > 10, "{one:?} {other:?}");
    for power in [-340, -600, -1070] {
        assert!(matches!(scaled(2f64.powi(power)), Err(Error::PrecisionLost { .. })), "{power}");
    }
    // Squares of speeds must not overflow either; otherwise a state that is reached could not be
    // restored.
    assert!(refused(&Parameters { stop_gap: 1e101, ..p }, 0.0));
    assert!(refused(&Parameters { stop_gap: 1e99, drive_frequency: 1e3, ..p }, 0.0));
    let mut simulator = Simulator::new(&p, &State::default(), 0.0).unwrap();
    let huge = Loads { derivatives: [[0.0; 4], [0.0; 4], [4.8e97, 0.0, 0.0, 0.0]] };
    assert!(matches!(simulator.set_loads(&huge), Err(Error::PrecisionLost { .. })));
}

/// Masses and rates with which energies and derivatives would overflow are refused by name.
#[test]
fn masses_and_rates_beyond_all_machines_are_refused() {
    for (p, what) in [
        (Parameters { secondary_mass: 1e41, ..Parameters::default() }, "masses"),
        (Parameters { drive_frequency: 1e41, ..Parameters::default() }, "drive.frequency"),
    ] {
        let refused = Simulator::new(&p, &State::default(), 0.0).unwrap_err();
        assert!(
            matches!(refused, Error::PrecisionLost { .. }) && refused.to_string().contains(what),
            "{refused}"
        );
    }
    let p = Parameters { drive_frequency: 1e40, ..Parameters::default() };
    let simulator = Simulator::new(&p, &State { x: [0.0, 0.5, 0.0], v: [0.0; 3] }, 0.0).unwrap();
    assert!(simulator.derivatives().iter().flatten().all(|d| d.is_finite()));
}
