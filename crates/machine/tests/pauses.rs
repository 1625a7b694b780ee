//! Motions that pause before events, that are saved as bytes, or that begin at another time.

use crate::common::*;
use vibro_machine::Motion;
use vibro_machine::description::*;
use vibro_machine::motion::{Hybrid, Reached};

/// A ball that falls a metre, with a load that jumps in flight.
fn ball() -> Description {
    let jump = Signal { steps: vec![Step { time: 0.3, height: 0.05 }], ..Signal::default() };
    Description {
        gravity: 9.81,
        bodies: vec![heavy("ball", 0.02, 1.0, 0.0, 0.0)],
        stops: vec![rigid("floor", &[(0, 1.0)], 1.0, 0.9)],
        loads: vec![Load { name: "wind".into(), body: 0, force: jump }],
        ..Description::default()
    }
}

/// Rounding of a flight of one second.
const ROUNDING: f64 = 1e-15;

#[test]
fn invariant_pausing_before_events_changes_no_bit() {
    let (mut whole, mut paused) = (motion(ball()), motion(ball()));
    let (mut passed, mut before) = (Vec::new(), Vec::new());
    whole.advance_observed(3.0, &mut |event| passed.push(event.clone())).unwrap();
    let mut pauses = 0;
    while paused.advance_before_event(3.0, &mut |event| before.push(event.clone())).unwrap() == Reached::Event
    {
        let (known, speed) = (before.len(), paused.body(0)[1]);
        assert!(paused.is_event_due());
        // Before the event is handled the ball still falls, or the load has not jumped yet; the
        // law acts once, on request.
        assert_eq!(paused.load(0), if paused.time() > 0.3 { 0.05 } else { 0.0 });
        assert!(speed > 0.0, "{speed}");
        paused.apply_event(&mut |event| before.push(event.clone())).unwrap();
        assert!(before.len() > known && !paused.is_event_due());
        pauses += 1;
    }
    assert_eq!(before, passed);
    assert_eq!(paused.save(), whole.save());
    assert!(pauses > 3, "{pauses}");
}

#[test]
fn invariant_a_state_goes_through_bytes_before_an_event_too() {
    let mut moving = motion(ball());
    moving.advance_before_event(3.0, &mut |_| ()).unwrap();
    let bytes = postcard::to_stdvec(&moving.save()).unwrap();
    let saved: Hybrid = postcard::from_bytes(&bytes).unwrap();
    assert!(saved.fits(moving.assembly()));
    let mut other = motion(ball());
    other.restore(&saved);
    moving.advance_to(2.0).unwrap();
    other.advance_to(2.0).unwrap();
    assert_eq!(moving.save(), other.save());
    // A machine with other elements refuses the state.
    let machine = Description { stops: Vec::new(), ..ball() };
    assert!(!saved.fits(motion(machine).assembly()));
}

#[test]
fn closed_form_of_a_start_at_another_time() {
    let machine = motion(ball()).assembly().clone();
    let mut later = Motion::starting_at(machine.clone(), 10.0).unwrap();
    assert_eq!((later.time(), later.body(0)[0], later.load(0)), (10.0, 0.0, 0.05));
    later.advance_to(10.2).unwrap();
    let (acceleration, dt) = (9.81 + 0.05 / 0.02, 10.2 - 10.0);
    assert!((later.body(0)[0] - 0.5 * acceleration * dt * dt).abs() < ROUNDING);
    let refused = Motion::starting_at(machine, f64::NAN).unwrap_err().to_string();
    assert_eq!(refused, "start time = NaN: expected a finite number");
}

/// Names and machines whose event function touches its limit before 1.5 s without an event.
fn touches() -> [(&'static str, Description); 4] {
    let wave = |constant, amplitude| Signal { constant, ..sine(amplitude, 0.5, 0.0) };
    let load = |force| vec![Load { name: "load".into(), body: 0, force }];
    let at_rest = Description { bodies: vec![body("body", 1.0, 0.0, 0.0)], ..Description::default() };
    let level = Friction { force: wave(1.0, 1.0), ..friction(&[(0, 1.0)], 0.0) };
    let still = friction(&[(0, 1.0)], 2.0);
    let floor = vec![rigid("floor", &[(0, 1.0)], 0.0, 0.5)];
    let buffer = vec![compliant("buffer", &[(0, 1.0)], 1.0, 1e3, 1.0, DampingLimit::NoPull)];
    let bodies = vec![prescribed("cam", wave(0.0, -1.0), 0.0), body("body", 1.0, 0.0, 0.0)];
    [
        ("a level that is zero", Description { frictions: vec![level], ..at_rest.clone() }),
        (
            "a load that is the level",
            Description { frictions: vec![still], loads: load(wave(1.0, -1.0)), ..at_rest.clone() },
        ),
        (
            "a closed stop without force",
            Description { stops: floor, loads: load(wave(1.0, 1.0)), ..at_rest.clone() },
        ),
        ("a buffer that is reached", Description { stops: buffer, bodies, ..at_rest }),
    ]
}

#[test]
fn invariant_what_only_touches_its_limit_is_no_event_wherever_a_call_ends() {
    for (name, machine) in touches() {
        for parts in 1..200 {
            let mut motion = motion(machine.clone());
            let mut events = Vec::new();
            for k in 1..=parts {
                let end = 3.0 * f64::from(k) / f64::from(parts);
                motion.advance_observed(end, &mut |event| events.push(event.clone())).unwrap();
            }
            assert_eq!(events, [], "{name}, {parts} parts");
        }
    }
}

#[test]
fn invariant_a_capped_buffer_that_is_hardly_reached_stops_no_motion() {
    for depth in [0.5e-13, 1e-13, 1.5e-13, 2e-13, 3e-13, 1e-12] {
        for parts in 1..100 {
            let law = (0.5 - depth, 1e3, 1.0, DampingLimit::Elastogap);
            let mut motion = motion(Description {
                bodies: vec![prescribed("cam", sine(0.5, 1.0, 0.0), 0.0), body("body", 1.0, 0.0, 0.0)],
                stops: vec![compliant("buffer", &[(0, 1.0), (1, -1.0)], law.0, law.1, law.2, law.3)],
                ..Description::default()
            });
            for k in 1..=parts {
                let went = motion.advance_to(5.0 * f64::from(k) / f64::from(parts));
                assert!(went.is_ok(), "depth {depth}, {parts} parts: {went:?}");
            }
            // Five times the impulse of at most 2 k depth for microseconds.
            assert!((0.0..1e-13).contains(&motion.rate(1)), "{}", motion.rate(1));
        }
    }
}

#[test]
fn invariant_a_buffer_that_is_met_slowly_lets_go_in_one_call_as_in_many() {
    // A cam with a flat top, of sixth order at 2 s, enters a heavily damped buffer by 1e-12 m, at
    // 7e-10 m/s.
    let wave = |amplitude, frequency| Harmonic { amplitude, frequency, phase: std::f64::consts::FRAC_PI_2 };
    let harmonics = [wave(1.0, 0.25), wave(-1.0 / 6.0, 0.75), wave(0.02, 1.25)];
    let shift = |h: &Harmonic| Harmonic { phase: h.phase - 4.0 * std::f64::consts::PI * h.frequency, ..*h };
    let harmonics: Vec<Harmonic> = harmonics.iter().map(shift).collect();
    let top: f64 = 1.0 - 1.0 / 6.0 + 0.02;
    for depth in [3e-13, 5e-13, 9.6e-13, 2e-12, 1e-11] {
        for parts in [1, 3, 10, 100, 1000] {
            let law = (top - depth, 1e3, 1e4, DampingLimit::Elastogap);
            let cam = Signal { harmonics: harmonics.clone(), ..Signal::default() };
            let mut motion = motion(Description {
                bodies: vec![prescribed("cam", cam, 0.0), body("body", 1.0, 0.0, 0.0)],
                stops: vec![compliant("buffer", &[(0, 1.0), (1, -1.0)], law.0, law.1, law.2, law.3)],
                ..Description::default()
            });
            for k in 1..=parts {
                motion.advance_to(5.0 * f64::from(k) / f64::from(parts)).unwrap();
            }
            assert!(motion.rate(1).abs() < 1e-5, "depth {depth}, {parts} parts: {} m/s", motion.rate(1));
        }
    }
}
