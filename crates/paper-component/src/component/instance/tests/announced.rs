//! Steps that end at the announced time of an event, and the log of events that an input causes.

use super::*;
use fmi_doors::hybrid::Pieces;

/// Handles the event at which a step has ended, if there is one.
fn handle(fmu: &mut Instance, event: bool, messages: &mut Messages) {
    if event {
        fmu.enter_event().unwrap();
        fmu.handle_events(messages).unwrap();
        fmu.leave_event(messages).unwrap();
    }
}

fn leaves(messages: &Messages) -> usize {
    messages.0.iter().filter(|(_, text)| text.contains("leaves the")).count()
}

/// A block that comes to rest, is released, and continues, under a strong drive.
const PLASTIC: [(&str, f64); 3] = [("stop.restitution", 0.0), ("drive.amplitude", 1.0), ("block.s", 0.3)];

/// Numbers of announced events and of logged releases, with steps to announced times.
fn follow(mut fmu: Instance, by_step: bool, until: f64) -> (usize, usize) {
    let (mut events, mut messages) = (0, Messages::default());
    while fmu.time() < until {
        let place =
            |fmu: &mut Instance| ["impacts.upper", "impacts.lower", "stop.state"].map(|name| get(fmu, name));
        let (now, before) = (fmu.time(), place(&mut fmu));
        let (next, known) = (get(&mut fmu, "impacts.nextTime"), get(&mut fmu, "impacts.nextKnown"));
        assert!(next > now, "the next event is announced for the present, {now}");
        if by_step {
            fmu.step_without_event_mode(now, next - now, &mut messages).unwrap();
        } else {
            let event = fmu.step_as_agreed(now, next - now, &mut messages).unwrap().event;
            handle(&mut fmu, event, &mut messages);
        }
        if known == 1.0 {
            assert_ne!(place(&mut fmu), before, "announced for {next}");
            events += 1;
        }
    }
    (events, leaves(&messages))
}

/// In each protocol the event is past once the step to its announced time has ended, also for
/// releases, and is logged once.
#[test]
fn second_method_announced_events_of_a_plastic_block_happen_by_each_protocol() {
    const UNTIL: f64 = 120.0;
    let stop = |on: f64| [&PLASTIC[..], &[("stopAtImpact", on)]].concat();
    let mut found = Vec::new();
    for on in [0.0, 1.0] {
        found.push(follow(with_handling(false, false, &stop(on)), true, UNTIL));
    }
    for (event_mode, early) in [(false, false), (false, true), (true, false), (true, true)] {
        found.push(follow(with_handling(event_mode, early, &stop(1.0)), false, UNTIL));
    }
    let (events, releases) = found[0];
    assert!(releases > 20 && events >= 2 * releases, "{found:?}");
    assert!(found.iter().all(|other| *other == found[0]), "{found:?}");
}

/// Near the time 0 times are rounded by far less than a step's sums, so the component's own time
/// may be past the end of a step that stops.
#[test]
fn a_step_to_an_announced_impact_near_the_time_zero_is_carried_out() {
    let start = [
        ("stopAtImpact", 1.0),
        ("box.s", 0.5373038806531685),
        ("block.s", 0.786567381285369),
        ("secondary.s", -0.6304278177288063),
        ("box.v", -0.384972918453782),
        ("block.v", 0.5274794813448991),
        ("secondary.v", -0.9565940638970998),
    ];
    let mut fmu = instance();
    for (name, value) in start {
        set(&mut fmu, name, value).unwrap();
    }
    fmu.set_experiment(None, -2.5, None).unwrap();
    fmu.enter_initialization();
    fmu.exit_initialization(&mut Silence).unwrap();
    let first = step(&mut fmu, -2.5, 0.7174412956663453).unwrap();
    step(&mut fmu, first.time, 1.9459923775484858).unwrap();
    assert_eq!(get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower"), 2.0);
}

/// If the announcement is some steps old, each step has moved the state by rounding, here for a
/// machine a hundred gaps from its origin.
#[test]
fn an_announced_impact_is_behind_the_last_of_several_steps_to_it() {
    let mut met = 0;
    for k in 0..400 {
        let place = 0.5 + 0.001 * f64::from(k);
        let far = [("box.s", 100.0), ("block.s", 100.0 + place), ("secondary.s", 100.0), ("coupling.k", 0.5)];
        let soft = [("box.k", 1e-6), ("secondary.k", 1e-6), ("block.v", 0.3), ("box.v", 0.4)];
        let start = [&far[..], &soft].concat();
        let mut fmu = with_handling(true, true, &start);
        for _ in 0..6 {
            let (mut now, next) = (fmu.time(), get(&mut fmu, "impacts.nextTime"));
            if get(&mut fmu, "impacts.nextKnown") == 0.0 {
                break;
            }
            let part = (next - now) / 7.3;
            for _ in 0..7 {
                fmu.step_as_agreed(now, part, &mut Messages::default()).unwrap();
                now += part;
            }
            let end = fmu.step_as_agreed(now, next - now, &mut Messages::default()).unwrap();
            assert!(end.event, "{place}: announced for {next}");
            handle(&mut fmu, end.event, &mut Messages::default());
            met += 1;
        }
    }
    assert!(met > 1000, "{met}");
}

/// A block released by an input between two steps is logged like any other release, with all kinds
/// of steps.
#[test]
fn a_release_by_an_input_is_logged_by_each_protocol() {
    let held = [("block.s", 1.0), ("block.f", 0.5), ("drive.amplitude", 0.0)];
    for (event_mode, early) in [(false, false), (false, true), (true, false), (true, true)] {
        for pieces in [false, true] {
            let mut fmu = with_handling(event_mode, early, &held);
            let mut messages = Messages::default();
            fmu.step_as_agreed(0.0, 0.1, &mut messages).unwrap();
            assert_eq!(get(&mut fmu, "stop.state"), 2.0);
            set(&mut fmu, "block.f", -0.5).unwrap();
            if pieces {
                let mut course = Pieces::begin(&fmu, 0.1, 0.05).unwrap();
                course.start(&mut fmu, &mut messages).unwrap();
            } else {
                fmu.step_as_agreed(0.1, 0.05, &mut messages).unwrap();
            }
            assert_eq!(leaves(&messages), 1, "{event_mode} {early} {pieces}: {:?}", messages.0);
        }
    }
    let mut fmu = with_handling(false, false, &held);
    let mut messages = Messages::default();
    set(&mut fmu, "block.f", -0.5).unwrap();
    fmu.step_without_event_mode(0.0, 0.05, &mut messages).unwrap();
    assert_eq!(leaves(&messages), 1, "{:?}", messages.0);
}

/// The impacts of a closed form are also past once the step to their announced time has ended,
/// including late starts.
#[test]
fn announced_impacts_of_a_closed_form_are_behind_the_step_by_each_protocol() {
    const BEGIN: f64 = 7244.0;
    /// Tolerance: rounding of a drive's phase after thousands of turns.
    const SAME: f64 = 1e-11;
    for frequency in 0..20 {
        for stop in [0.0, 1.0] {
            let mut found = Vec::new();
            for by_step in [true, false] {
                let mut fmu = instance();
                let frequency = 1.0 + 0.003 * f64::from(frequency);
                for (name, value) in [("mode", 3.0), ("drive.frequency", frequency), ("stopAtImpact", stop)] {
                    set(&mut fmu, name, value).unwrap();
                }
                fmu.set_experiment(None, BEGIN, None).unwrap();
                fmu.enter_initialization();
                fmu.exit_initialization(&mut Silence).unwrap();
                let mut messages = Messages::default();
                for n in 1..=20 {
                    let (now, next) = (fmu.time(), get(&mut fmu, "impacts.nextTime"));
                    assert!(next > now, "{frequency}: the impact after {now} is announced for {next}");
                    if by_step {
                        fmu.step_without_event_mode(now, next - now, &mut messages).unwrap();
                    } else {
                        fmu.step_as_agreed(now, next - now, &mut messages).unwrap();
                    }
                    let met = get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower");
                    assert_eq!(met, f64::from(n), "{frequency}: announced for {next}");
                    assert_eq!(messages.0.len(), n as usize);
                }
                found.push(get(&mut fmu, "block.v"));
            }
            assert!((found[0] - found[1]).abs() < SAME, "{found:?}");
        }
    }
}
