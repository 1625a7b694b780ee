//! Momentum: `box.impulse` and `block.impulse` are the impulses of the stops on either body
//! (docs/theory.md (114)).

use super::*;
use crate::component::variables::Numbering;

/// Tolerance, N·s: rounding of some dozens of impulses of 0.1 N·s and momenta of 1 N·s, propagated
/// by the impacts.
const ROUNDING: f64 = 1e-12;
const BOX_MASS: f64 = 1.0;
const BLOCK_MASS: f64 = 0.1;
const SPEED: f64 = 2.0;

/// A box and a block without springs and dampers: only drive, constant loads and stops change
/// their momenta. The stops are elastic, so that the block never rests and no contact force lasts.
const FREE: [(&str, f64); 11] = [
    ("stop.restitution", 1.0),
    ("box.k", 0.0),
    ("box.c", 0.0),
    ("coupling.k", 0.0),
    ("block.s", 0.3),
    ("block.v", SPEED),
    ("drive.amplitude", 0.2),
    ("drive.frequency", 1.3),
    ("drive.phase", 0.4),
    ("box.f", 0.01),
    ("block.f", -0.004),
];

fn made(
    interface: Interface,
    handling: EventHandling,
    stop_at_impact: bool,
    start: &[(&str, f64)],
) -> Instance {
    let settings = Settings { stop_at_impact, ..Settings::default() };
    let protocol = Protocol { handling, start: settings, numbering: Numbering::ALL, ..Protocol::default() };
    let mut fmu = Instance::of_protocol(interface, protocol);
    for (name, value) in start {
        set(&mut fmu, name, *value).unwrap();
    }
    let mut fmu = initialize(fmu);
    if handling.event_mode {
        fmu.handle_events(&mut Messages::default()).unwrap();
        fmu.leave_event(&mut Messages::default()).unwrap();
    }
    fmu
}

/// Momenta of box and block.
fn momenta(fmu: &mut Instance) -> [f64; 2] {
    [BOX_MASS * get(fmu, "box.v"), BLOCK_MASS * get(fmu, "block.v")]
}

fn impulses(fmu: &mut Instance) -> [f64; 2] {
    [get(fmu, "box.impulse"), get(fmu, "block.impulse")]
}

/// Momenta of [`FREE`] up to now from drive and loads alone.
fn without_stops(fmu: &mut Instance) -> [f64; 2] {
    let t = get(fmu, "time");
    let drive = 0.2 / 1.3 * (0.4_f64.cos() - (1.3 * t + 0.4).cos());
    [drive + 0.01 * t, BLOCK_MASS * SPEED - 0.004 * t]
}

fn assert_balanced(fmu: &mut Instance, what: &str) {
    let (now, smooth, stops) = (momenta(fmu), without_stops(fmu), impulses(fmu));
    for body in 0..2 {
        let left = now[body] - smooth[body] - stops[body];
        assert!(left.abs() < ROUNDING, "{what}, body {body} at {}: {left:e}", get(fmu, "time"));
    }
}

/// At communication points of any distance, with steps that end at impacts, and on both sides of
/// events; also after a saved state.
#[test]
fn closed_form_momenta_of_a_free_box_and_block() {
    for (event_mode, early_return) in [(false, false), (false, true), (true, true)] {
        for size in [0.37, 5.9] {
            let handling = EventHandling { event_mode, early_return };
            let mut fmu = made(Interface::CoSimulation, handling, true, &FREE);
            let mut kept = None;
            while fmu.time() < 40.0 {
                let time = fmu.time();
                let reached = fmu.step_as_agreed(time, size, &mut Messages::default()).unwrap();
                assert_balanced(&mut fmu, "step");
                if reached.event {
                    let before = impulses(&mut fmu);
                    fmu.enter_event().unwrap();
                    assert_balanced(&mut fmu, "Event Mode");
                    assert_ne!(impulses(&mut fmu), before, "the law shows");
                    fmu.handle_events(&mut Messages::default()).unwrap();
                    assert_balanced(&mut fmu, "update");
                    fmu.leave_event(&mut Messages::default()).unwrap();
                }
                if kept.is_none() && fmu.time() > 15.0 {
                    kept = Some((fmu.save().serialize().unwrap(), impulses(&mut fmu)));
                }
            }
            assert!(get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower") > 5.0);
            let (bytes, told) = kept.unwrap();
            restore_bytes(&mut fmu, &bytes).unwrap();
            assert_eq!(impulses(&mut fmu), told);
            assert_balanced(&mut fmu, "restored");
            let time = fmu.time();
            fmu.step_as_agreed(time, 0.01, &mut Messages::default()).unwrap();
            assert_balanced(&mut fmu, "after the restored state");
        }
    }
}

/// Differences telescope: over any steps they add up to the difference over the whole time, and an
/// undone step has no effect.
#[test]
fn invariant_impulses_do_not_depend_on_the_steps() {
    let run = |size: f64, again: bool| {
        let mut fmu = made(Interface::CoSimulation, EventHandling::default(), false, &FREE);
        let (mut sum, mut before) = (0.0, 0.0);
        for i in 0..(40.0 / size) as u32 {
            let time = f64::from(i) * size;
            let saved = fmu.save();
            if again {
                fmu.step_as_agreed(time, 0.4 * size, &mut Messages::default()).unwrap();
                fmu.restore(&saved).unwrap();
            }
            fmu.step_as_agreed(time, size, &mut Messages::default()).unwrap();
            let [now, _] = impulses(&mut fmu);
            (sum, before) = (sum + (now - before), now);
        }
        sum
    };
    let expected = run(40.0, false);
    assert!(expected.abs() > 0.1);
    for (size, again) in [(8.0, true), (1.0, true), (0.125, false)] {
        assert!((run(size, again) - expected).abs() < ROUNDING, "{size}");
    }
}

/// Starts whose events are impacts, captures with and without bounces, releases. The last one is a
/// chatter run that ends by the height of its bounces, with remaining speeds of 1e-6 m/s.
const EVENTS: [&[(&str, f64)]; 4] = [
    &[("block.s", 0.9), ("block.v", 0.5)],
    &[("stop.restitution", 0.3), ("drive.amplitude", 0.4), ("block.v", 0.3), ("block.f", 0.02)],
    &[("stop.restitution", 0.0), ("drive.phase", 1.0), ("block.v", 0.5)],
    &[
        ("stop.restitution", 0.9995),
        ("block.s", 0.999_999_999_99),
        ("block.f", 0.5),
        ("drive.amplitude", 0.01),
    ],
];

/// At every event momentum jumps by the impulses, including merges into rest.
#[test]
fn invariant_impulses_are_the_jumps_of_momentum() {
    let handling = EventHandling { event_mode: true, early_return: true };
    for (case, start) in EVENTS.into_iter().enumerate() {
        let mut fmu = made(Interface::CoSimulation, handling, true, start);
        let (mut events, mut rests) = (0, 0);
        while fmu.time() < 40.0 && events < 5000 {
            let time = fmu.time();
            let reached = fmu.step_as_agreed(time, 1.0, &mut Messages::default()).unwrap();
            if !reached.event {
                continue;
            }
            let (p, j) = (momenta(&mut fmu), impulses(&mut fmu));
            fmu.enter_event().unwrap();
            let (after, told) = (momenta(&mut fmu), impulses(&mut fmu));
            for body in 0..2 {
                let left = (after[body] - p[body]) - (told[body] - j[body]);
                assert!(left.abs() < ROUNDING, "case {case}, body {body} at {}: {left:e}", fmu.time());
            }
            events += 1;
            rests += usize::from(get(&mut fmu, "stop.state") != 1.0);
            fmu.handle_events(&mut Messages::default()).unwrap();
            fmu.leave_event(&mut Messages::default()).unwrap();
        }
        assert!(events > 5, "case {case}: {events}");
        assert!(case == 0 || rests > 0, "case {case}: {rests} rests");
    }
}

/// If the host handles events but does not accept early returns, the impulses are updated when it
/// handles them, like all discrete outputs.
#[test]
fn impulses_are_shown_at_the_event_when_steps_go_on() {
    let handling = EventHandling { event_mode: true, early_return: false };
    let mut fmu = made(Interface::CoSimulation, handling, true, &FREE);
    let reached = fmu.step_as_agreed(0.0, 10.0, &mut Messages::default()).unwrap();
    assert!(reached.event && impulses(&mut fmu) == [0.0, 0.0]);
    fmu.enter_event().unwrap();
    assert_balanced(&mut fmu, "Event Mode at the step's end");
    assert!(impulses(&mut fmu)[0].abs() > 0.01);
}

/// In Model Exchange the impulses come from the laws at events, for any solver between them.
#[test]
fn invariant_impulses_of_model_exchange_are_the_jumps_of_momentum() {
    const FALLING: &[(&str, f64)] =
        &[("stop.restitution", 0.9995), ("block.s", 0.99), ("block.f", 0.5), ("drive.amplitude", 0.01)];
    for start in EVENTS[..3].iter().copied().chain([FALLING]) {
        let handling = EventHandling { event_mode: true, early_return: false };
        let mut fmu = made(Interface::ModelExchange, handling, false, start);
        let (mut met, step) = (0, 1e-3);
        for i in 1..=20_000 {
            let (mut x, rates) = (fmu.continuous_states().unwrap(), fmu.state_derivatives().unwrap());
            x.iter_mut().zip(rates).for_each(|(x, rate)| *x += step * rate);
            fmu.set_time(f64::from(i) * step).unwrap();
            fmu.set_continuous_states(&x).unwrap();
            if fmu.complete_integrator_step().unwrap() {
                let (p, j) = (momenta(&mut fmu), impulses(&mut fmu));
                fmu.enter_event().unwrap();
                let handled = fmu.handle_events(&mut Messages::default()).unwrap();
                let (after, told) = (momenta(&mut fmu), impulses(&mut fmu));
                let left = (after[0] - p[0]) - (told[0] - j[0]);
                assert!(left.abs() < ROUNDING, "at {}: {left:e}", fmu.time());
                met += usize::from(handled.states && told != j);
                fmu.leave_event(&mut Messages::default()).unwrap();
            }
        }
        assert!(met > 0, "{start:?}");
    }
}

/// A closed form has the same impulses as the simulation that starts on its orbit.
#[test]
fn second_method_impulses_of_the_played_orbit() {
    let mut played = instance();
    set(&mut played, "mode", 3.0).unwrap();
    let mut simulated = instance();
    set(&mut simulated, "startOnOrbit", 1.0).unwrap();
    let (mut played, mut simulated) = (initialize(played), initialize(simulated));
    for i in 0..30 {
        for fmu in [&mut played, &mut simulated] {
            step(fmu, f64::from(i) * 1.7, 1.7).unwrap();
        }
        let (a, b) = (impulses(&mut played), impulses(&mut simulated));
        assert!((a[0] - b[0]).abs() < 1e-11 && (a[1] - b[1]).abs() < 1e-11, "{a:?} {b:?}");
    }
}

/// The contact force without pressing is exactly zero, without a sign, in flight after rests on
/// either stop and in all engines.
#[test]
fn invariant_the_contact_force_of_flight_is_plus_zero() {
    let mut flights = 0;
    for start in EVENTS {
        let mut fmu = made(Interface::CoSimulation, EventHandling::default(), false, start);
        for i in 0..400 {
            step(&mut fmu, f64::from(i) * 0.1, 0.1).unwrap();
            if get(&mut fmu, "stop.state") == 1.0 {
                assert_eq!(get(&mut fmu, "stop.force").to_bits(), 0, "{start:?}");
                flights += 1;
            }
        }
        let handling = EventHandling { event_mode: true, early_return: false };
        let mut fmu = made(Interface::ModelExchange, handling, false, start);
        assert!(get(&mut fmu, "stop.state") != 1.0 || get(&mut fmu, "stop.force").to_bits() == 0);
    }
    for mode in [2.0, 3.0] {
        let mut fmu = instance();
        set(&mut fmu, "mode", mode).unwrap();
        assert_eq!(get(&mut initialize(fmu), "stop.force").to_bits(), 0);
    }
    assert!(flights > 500, "{flights}");
}
