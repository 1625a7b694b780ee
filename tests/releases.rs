//! Releases and departures with zero velocity, in steps that end at the release or are too short
//! for w to change.

use vibro_impact::flow::Series;
use vibro_impact::model::{Model, RELATIVE, SmoothMode};
use vibro_impact::simulator::{AdvanceOutcome, Contact, DoubleDouble, Event, Loads, Pause};
use vibro_impact::{Parameters, Simulator, State};

/// A step that ends at the announced time of a release, or a unit in the last place before or
/// after it, adds no impact.
#[test]
fn invariant_steps_that_end_at_a_release_add_no_impact() {
    let start = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    let (mut releases, mut added) = (0, Vec::new());
    for n in 0..600 {
        let (amplitude, frequency) = (0.1 + 0.01 * f64::from(n % 53), 0.3 + 0.07 * f64::from(n % 23));
        let p = Parameters {
            stop_restitution: 0.1 * f64::from(n % 5),
            drive_amplitude: amplitude,
            drive_frequency: frequency,
            ..Parameters::default()
        };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        while simulator.time() < 400.0 {
            let Some(event) = simulator.next_event(400.0).unwrap() else { break };
            if let Event::Release { time, .. } = event {
                let impacts_after = |first: f64| {
                    let mut divided = simulator.clone();
                    divided.advance_to(first).unwrap();
                    divided.advance_to(time + 0.01).unwrap();
                    *divided.impacts()
                };
                releases += 1;
                let whole = impacts_after(time + 0.01);
                let ends = [time.next_down(), time, time.next_up(), time.next_up().next_up()];
                added.extend(ends.into_iter().filter(|end| impacts_after(*end) != whole));
            }
            simulator.advance_until(400.0, Pause::BeforeEvent, None).unwrap();
            simulator.apply_due_event(None);
        }
    }
    assert!(releases > 8000, "{releases}");
    assert!(added.is_empty(), "{} of {releases} releases", added.len());
}

/// A block that rounding-sized forces move off its stop, or that is released very slowly, leaves
/// in short steps as in a single advance: changes too small for w in one step accumulate.
#[test]
fn second_method_a_block_that_leaves_slowly_does_so_in_steps_of_any_length() {
    const STEP: f64 = 0.1;
    /// Relative difference of the displacement, by the roundings of ten thousand steps.
    const SAME: f64 = 0.02;
    for (load, end) in [
        ([-2e-15, 0.0, 0.0, 0.0], 1e3),
        ([-4e-15, 0.0, 0.0, 0.0], 1e3),
        ([1e-15, -1e-15, 0.0, 0.0], 1e2),
        ([1e-16, -1e-16, 0.0, 0.0], 1e3),
    ] {
        // The box's spring balances its load, so that only the force on the block moves anything.
        let p = Parameters {
            box_mass: 1.0,
            box_stiffness: 1.0,
            box_damping: 0.0,
            block_mass: 1.0,
            secondary_mass: 1.0,
            secondary_stiffness: 0.0,
            secondary_damping: 0.0,
            coupling_stiffness: 0.0,
            stop_gap: 1.0,
            stop_restitution: 0.5,
            drive_amplitude: 0.0,
            drive_frequency: 0.0,
            constant_loads: [1.0, 0.0, 0.0],
            ..Parameters::default()
        };
        let at_stop = State { x: [1.0, 2.0, 0.0], v: [0.0; 3] };
        let mut whole = Simulator::new(&p, &at_stop, 0.0).unwrap();
        whole.set_loads(&Loads { derivatives: [[0.0; 4], load, [0.0; 4]] }).unwrap();
        let mut divided = whole.clone();
        whole.advance_to(end).unwrap();
        for n in 1..=(end / STEP).round() as u32 {
            divided.advance_to(f64::from(n) * STEP).unwrap();
        }
        let [way, expected] = [&divided, &whole].map(|s| 1.0 - s.relative_motion().0);
        assert!(
            expected > 1e-11 && (way - expected).abs() < SAME * expected,
            "{load:?}: {way:e} {expected:e}"
        );
    }
}

/// A force that releases the block slightly and reverses before w changes: the reversal causes no
/// impact, and the block keeps its velocity.
#[test]
fn closed_form_a_release_whose_jerk_turns_adds_no_impact() {
    const STEP: f64 = 1e-3;
    const LET_GO: f64 = 3e-15; // N, and m/s² of a block of 1 kg
    const TIME: f64 = 10.0;
    /// Relative difference of the speed, by the rounding of the force.
    const SAME: f64 = 0.2;
    let bend = 8.0 * LET_GO / (TIME * TIME);
    let p = Parameters {
        box_mass: 1.0,
        box_stiffness: 1.0,
        block_mass: 1.0,
        secondary_mass: 1.0,
        secondary_stiffness: 0.0,
        secondary_damping: 0.0,
        coupling_stiffness: 0.0,
        box_damping: 0.0,
        drive_amplitude: 0.0,
        drive_frequency: 0.0,
        ..Parameters::default()
    };
    let mut simulator = Simulator::new(&p, &State { x: [0.0, 1.0, 0.0], v: [0.0; 3] }, 0.0).unwrap();
    // bend (t - 0.6 TIME)²/2 - LET_GO, which is negative from 0.1 to 1.1 TIME.
    let load = [0.18 * bend * TIME * TIME - LET_GO, -0.6 * bend * TIME, bend, 0.0];
    simulator.set_loads(&Loads { derivatives: [[0.0; 4], load, [0.0; 4]] }).unwrap();
    let speed = -2.0 / 3.0 * LET_GO * TIME;
    // The jerk reverses at an arbitrary point of a step.
    for phase in 0..8 {
        let mut simulator = simulator.clone();
        for n in 0..=11_000 {
            simulator.advance_to((f64::from(n) + f64::from(phase) / 8.0) * STEP).unwrap();
        }
        let (_, reached) = simulator.relative_motion();
        assert_eq!(simulator.impacts().upper, 0, "{phase}");
        assert!((reached - speed).abs() < SAME * -speed, "{phase}: {reached:e} {speed:e}");
    }
}

/// Loads on the block for which, at the start, the derivatives of w of orders 2 to `order` - 1 are
/// zero, and the derivative of order `order` leads away from the stop with the size `away` m/sᵏ, k
/// = `order`. `None` if rounding allows no such loads.
fn loads_of_order(simulator: &Simulator, order: usize, away: f64) -> Option<Loads> {
    let (model, side) = (Model::new(simulator.parameters()).unwrap(), simulator.relative_motion().0.signum());
    let mut derivatives = [[0.0; 4]; 3];
    let derivative = |loads: &[[f64; 4]; 3], k: usize| {
        let z = simulator.augmented();
        let series = Series::<9>::expand(&model, SmoothMode::Flight, &z, Some(loads), 1.0 / model.rate);
        let [of_box, of_block, _] = series.derivatives::<9>(model.rate);
        (series.states[k][RELATIVE], of_block[k] - of_box[k])
    };
    for k in 2..order {
        let load = derivative(&derivatives, k).1 / model.inverse_mass[1];
        let zero = (-40..=40).map(|units: i64| f64::from_bits((load.to_bits() as i64 + units) as u64));
        derivatives[1][k - 2] = zero.map(|load| -load).find(|load| {
            derivatives[1][k - 2] = *load;
            derivative(&derivatives, k).0 == 0.0
        })?;
    }
    derivatives[1][order - 2] = -(derivative(&derivatives, order).1 + side * away) / model.inverse_mass[1];
    Some(Loads { derivatives })
}

/// A block whose loads follow the moving box up to some order leaves by the next order, in steps
/// however short, though all lower derivatives are rounding as soon as it has left.
#[test]
fn second_method_departures_of_high_orders_in_steps_of_any_shortness() {
    let mut departures = [0; 6];
    for n in 0..1800 {
        let number = f64::from(n);
        let p = Parameters {
            box_mass: 2.0,
            box_stiffness: 0.3176919137341083,
            block_mass: 0.125,
            coupling_stiffness: 0.0,
            stop_restitution: f64::from(n % 2) * 0.5,
            drive_phase: number,
            ..Parameters::default()
        };
        let (x, v, side) = ((0.7 * number).sin(), (0.9 * number).cos(), if n % 4 < 2 { 1.0 } else { -1.0 });
        let start = State { x: [x, x + side, 0.3], v: [v, v, 0.0] };
        let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
        let order = 3 + n as usize % 3;
        let Some(loads) = loads_of_order(&simulator, order, 0.1) else { continue };
        simulator.set_loads(&loads).unwrap();
        if simulator.contact() != Contact::Flight {
            continue;
        }
        departures[order] += 1;
        let step = 10f64.powf(-17.0 + 10.0 * (0.37 * number).fract());
        let steps = (1..50).map(|n| f64::from(n) * step);
        for end in steps.chain([1e-3]) {
            simulator.advance_to(end).unwrap();
        }
        assert_eq!(simulator.impacts().upper + simulator.impacts().lower, 0, "{n}: {order}, {step:e} s");
        assert_eq!(simulator.contact(), Contact::Flight, "{n}: {order}, {step:e} s");
    }
    assert!(departures[3..].iter().all(|count| *count > 100), "{departures:?}");
}

/// A block that is released by a jerk which the next derivative turns, late in a longer step: the
/// small speed from some short steps before causes no impact.
#[test]
fn second_method_a_longer_step_after_short_ones_finds_no_impact_at_its_start() {
    let mut added = Vec::new();
    for n in 1..400 {
        let p =
            Parameters { box_damping: 0.0, drive_amplitude: 0.0, stop_gap: 0.01, ..Parameters::default() };
        let mut simulator = Simulator::new(&p, &State { x: [0.0, 0.01, 0.0], v: [0.0; 3] }, 0.0).unwrap();
        let turn = 1e-4 * f64::from(n); // s; the block returns after three times that
        let load = [p.coupling_stiffness * p.stop_gap, -1e-2 * turn, 1e-2, 0.0];
        simulator.set_loads(&Loads { derivatives: [[0.0; 4], load, [0.0; 4]] }).unwrap();
        let mut whole = simulator.clone();
        let end = 2.5 * turn;
        for step in 1..=30 {
            simulator.advance_to(f64::from(step) * 1.3e-14).unwrap();
        }
        simulator.advance_to(end).unwrap();
        whole.advance_to(end).unwrap();
        assert_eq!(whole.impacts().upper, 0, "{n}");
        if simulator.impacts().upper != 0 {
            added.push(n);
        }
    }
    assert!(added.is_empty(), "{added:?}");
}

/// A machine at rest under the largest force of its drive, with the block at a stop: the rate of
/// the force is the rounding of the cosine, and the higher derivatives decide. On one side the
/// block is pressed and rests, on the other it is released.
#[test]
fn closed_form_a_start_at_the_static_deflection_of_the_drive() {
    use std::f64::consts::PI;
    const END: f64 = 0.01;
    /// Relative change of the displacement by the box's spring and damper in this time.
    const SAME: f64 = 0.02;
    for (mass, stiffness, damping, frequency) in
        [(1.0, 1.0, 0.1, 1.04), (3.0, 1.0, 0.1, 0.3), (0.7, 100.0, 0.0, 1.04), (2.0, 100.0, 0.1, 1.0)]
    {
        for restitution in [0.0, 0.5, 0.75, 0.9] {
            for (phase, toward) in [(0.5 * PI, 1.0), (1.5 * PI, -1.0), (-0.5 * PI, -1.0), (2.5 * PI, 1.0)] {
                for side in [1.0, -1.0] {
                    let p = Parameters {
                        box_mass: mass,
                        box_stiffness: stiffness,
                        box_damping: damping,
                        coupling_stiffness: 0.0,
                        stop_restitution: restitution,
                        drive_frequency: frequency,
                        drive_phase: phase,
                        ..Parameters::default()
                    };
                    let x = p.drive_amplitude * phase.sin() / stiffness;
                    let start = State { x: [x, x + side * p.stop_gap, 0.0], v: [0.0; 3] };
                    let mut simulator = Simulator::new(&p, &start, 0.0).unwrap();
                    for step in [1e-17, 1e-15, 3e-14, 1e-12, 1e-9, END] {
                        simulator.advance_to(step).unwrap();
                    }
                    let said = format!("{mass} {stiffness} κ {restitution} phase {phase} side {side}");
                    assert_eq!(simulator.impacts().upper + simulator.impacts().lower, 0, "{said}");
                    if side == toward {
                        assert_eq!(simulator.contact().side(), side, "{said}");
                    } else {
                        // The box accelerates by the cosine's curvature, and the block does not.
                        let way = p.stop_gap - side * simulator.relative_motion().0;
                        let expected = p.drive_amplitude * frequency * frequency / mass * END.powi(4) / 24.0;
                        assert_eq!(simulator.contact(), Contact::Flight, "{said}");
                        assert!((way - expected).abs() < SAME * expected, "{said}: {way:e} {expected:e}");
                    }
                }
            }
        }
    }
}

/// While w rounds to the stop that the block has left, several steps are bit-identical to one step
/// from the departure to their end, even from a restored state.
#[test]
fn invariant_short_steps_after_a_departure_have_the_bits_of_one() {
    /// Rounding of energies of some joules, of one sum for each of some hundred steps.
    const ENERGIES: f64 = 1e-12;
    let mut compared = 0;
    for n in 0..40 {
        let p = Parameters {
            stop_restitution: 0.2 * f64::from(n % 4),
            drive_amplitude: 0.2 + 0.013 * f64::from(n),
            ..Parameters::default()
        };
        let mut simulator =
            Simulator::new(&p, &State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] }, 0.0).unwrap();
        for _ in 0..20 {
            simulator.advance_until(f64::from(n) + 400.0, Pause::BeforeEvent, None).unwrap();
            if simulator.apply_due_event(None).is_none() {
                break;
            }
            let mut divided = simulator.clone();
            let mut end = DoubleDouble::sum(simulator.time(), 0.0);
            let mut way = 1e-17;
            let mut touches = simulator.contact() == Contact::Flight;
            while touches {
                end = end.plus(way);
                way *= 1.5;
                let mut whole = simulator.clone();
                let [one, other] = [&mut whole, &mut divided]
                    .map(|s| s.advance_until(end, Pause::BeforeEvent, None).unwrap());
                assert_eq!((whole.state(), one), (divided.state(), other));
                let [a, b] = [&whole, &divided].map(Simulator::energy_accounts);
                assert!((a.input - b.input).abs() < ENERGIES && (a.damped - b.damped).abs() < ENERGIES);
                touches = divided.relative_motion().0.abs() == p.stop_gap && other == AdvanceOutcome::End;
                let mut restored = Simulator::new(&p, &State::default(), 0.0).unwrap();
                restored.restore(&divided.snapshot()).unwrap();
                divided = restored;
                compared += 1;
            }
        }
    }
    assert!(compared > 10_000, "{compared}");
}

/// Forces and rates near the bound on rounding, where the derivative that decides is beyond the
/// bound in flight but not in rest, or in rest but not in flight: the motion does not stall.
#[test]
fn invariant_forces_at_the_edge_of_rounding_do_not_stall() {
    let still = Parameters { drive_amplitude: 0.0, ..Parameters::default() };
    let first = Parameters {
        box_mass: 8.229968638831624,
        box_stiffness: 0.09919179502563313,
        box_damping: 1.2553306398396404,
        block_mass: 0.06135645706749279,
        secondary_mass: 0.7532427038491336,
        secondary_stiffness: 0.46960151798629945,
        secondary_damping: 0.0,
        coupling_stiffness: 1.9238702102068317,
        stop_restitution: 0.0,
        ..still
    };
    let second = Parameters {
        box_mass: 0.47801091464246886,
        box_stiffness: 1.3971000953209118,
        box_damping: 0.38195152936983556,
        block_mass: 0.0883526450460092,
        secondary_mass: 0.8660245444844178,
        secondary_stiffness: 0.4162047351703805,
        secondary_damping: 0.0,
        coupling_stiffness: 0.05882175745712315,
        stop_restitution: 0.9,
        ..still
    };
    let of_first = [
        [-9.036762303389616e-13, 0.0, 3.2813918756922216e-10, -5.689498106273122e-9],
        [1.906863775684922e-12, 2.862815862382699e-13, -3.731078485263517e-12, 3.640796919438193e-12],
        [0.4696015179840292, -3.235585829015945e-12, 4.807413182249164e-11, 0.0],
    ];
    let of_second = [
        [6.865066697307579e-15, -3.8533932070376124e-14, 4.400379294997227e-13, -1.3081677275467366e-12],
        [5.882045621866763e-14, -1.797248042201948e-14, 0.0, 1.2682855093127168e-13],
        [0.4162047351699054, -2.4955079698151257e-13, 7.915070997647616e-13, 0.0],
    ];
    let at_stop = State { x: [0.0, 1.0, 0.999999999999], v: [0.0; 3] };
    for (p, derivatives) in [(first, of_first), (second, of_second)] {
        for steps in [1, 20, 137] {
            let mut simulator = Simulator::new(&p, &at_stop, 0.0).unwrap();
            simulator.set_loads(&Loads { derivatives }).unwrap();
            for n in 1..=steps {
                simulator.advance_to(3.0 * f64::from(n) / f64::from(steps)).unwrap();
            }
            assert!(simulator.work_counters().events < 1000, "{:?}", simulator.work_counters());
        }
    }
}

/// A block that leaves a stop by the ninth derivative of w, while the second to the eighth are
/// rounding: it is kept there only until a derivative is beyond rounding.
#[test]
fn second_method_what_was_in_doubt_leaves_by_what_is_beyond_rounding() {
    /// Rounding of w in gaps: docs/numerics.md, section 3, allows 18 ε S, and S is some gaps here.
    const ROUNDING: f64 = 100.0 * f64::EPSILON;
    let p = Parameters {
        box_mass: 0.7982975814983321,
        box_stiffness: 0.35717646298409533,
        box_damping: 0.0,
        block_mass: 0.3188250400708371,
        secondary_mass: 0.9605847606883469,
        secondary_stiffness: 0.25984669616306655,
        secondary_damping: 0.0,
        coupling_stiffness: 0.29230263444816973,
        stop_gap: 0.1,
        stop_restitution: 0.0,
        drive_amplitude: -0.7617733683553457,
        drive_frequency: 2.134263818818754,
        ..Parameters::default()
    };
    let derivatives = [
        [0.0; 4],
        [-0.1773572871149936, -0.6493240623796352, 1.6226055746147424e-17, 2.652938591901833],
        [0.3610063075308729, 0.0, -3.0650444993798114e-17, -38.66897088058967],
    ];
    let at_stop = State { x: [0.0, 0.1, 0.706759112690933], v: [0.0; 3] };
    let mut at_rest = Simulator::new(&p, &at_stop, 0.0).unwrap();
    at_rest.set_loads(&Loads { derivatives }).unwrap();
    let model = Model::new(&p).unwrap();
    let time = 0.3 / model.rate;
    let series =
        Series::<24>::expand(&model, SmoothMode::Flight, &at_rest.augmented(), Some(&derivatives), time);
    // The part of the motion that is beyond rounding.
    let way: f64 = series.excess_polynomial(1.0, p.stop_gap)[9..].iter().sum();
    assert!(way < -10.0 * ROUNDING * p.stop_gap, "{way:e}");
    for steps in [1, 7, 100] {
        let mut simulator = at_rest.clone();
        for n in 1..=steps {
            simulator.advance_to(time * f64::from(n) / f64::from(steps)).unwrap();
        }
        let found = simulator.relative_motion().0 - p.stop_gap;
        assert!((found - way).abs() < ROUNDING * p.stop_gap, "{steps}: {found:e} {way:e}");
    }
}
