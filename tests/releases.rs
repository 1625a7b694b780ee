//! A block that lets go of its stop without speed, in steps that end right then or are too short for its way to show.

use vibro_impact::simulator::{Event, Loads, Pause};
use vibro_impact::{Parameters, Simulator, State};

/// A step that ends where a release was foretold, or a unit in the last place beside it, adds no impact to the motion.
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

/// A block that a force of rounding's size takes off its stop, or lets go ever so slowly, leaves it in short steps as in one advance: what
/// is too little for w to show in a step adds up.
#[test]
fn second_method_a_block_that_leaves_slowly_does_so_in_steps_of_any_length() {
    const STEP: f64 = 0.1;
    /// Of the way; the roundings of ten thousand steps.
    const SAME: f64 = 0.02;
    for (load, end) in [
        ([-2e-15, 0.0, 0.0, 0.0], 1e3),
        ([-4e-15, 0.0, 0.0, 0.0], 1e3),
        ([1e-15, -1e-15, 0.0, 0.0], 1e2),
        ([1e-16, -1e-16, 0.0, 0.0], 1e3),
    ] {
        // The box's spring holds its load, so that only what acts on the block moves anything.
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

/// A force that lets go of the block a little and turns before w shows it: no impact comes of the turn, and the block goes on with the speed
/// that it was given.
#[test]
fn closed_form_a_release_whose_jerk_turns_adds_no_impact() {
    const STEP: f64 = 1e-3;
    const LET_GO: f64 = 3e-15; // N, and m/s² of a block of 1 kg
    const TIME: f64 = 10.0;
    /// Of the speed: the rounding of the force.
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
    // Wherever in a step the jerk turns.
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
