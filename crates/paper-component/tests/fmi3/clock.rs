//! The description with a clock: it ticks at impacts.

use super::host::*;
use std::ptr::null;
use vibro_impact::simulator::Event;
use vibro_impact::{Parameters, Simulator, State};
use vibro_paper_component::fmi3::abi::*;

const CLOCKED: [&str; 4] =
    ["impacts.clocked.time", "impacts.clocked.impulse", "impacts.clocked.speed", "impacts.clocked.side"];

fn started(flags: Flags) -> Fmu {
    let fmu = Fmu::clocked(flags);
    assert_eq!(fmu.set("block.s", 0.9), OK);
    assert_eq!(fmu.set("block.v", 0.5), OK);
    fmu.initialize();
    if flags.event_mode {
        fmu.update();
        fmu.enter_step_mode();
    }
    fmu
}

/// Impacts from the library: time, impulse, speed, side as in the enumeration.
fn impacts(end: f64) -> Vec<[f64; 4]> {
    let state = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    let mut simulator = Simulator::new(&Parameters::default(), &state, 0.0).unwrap();
    let mut impacts = Vec::new();
    let mut observe = |event: &Event| {
        if let Event::Impact { time, side, speed, impulse } = *event {
            impacts.push([time, impulse, speed, f64::from(2 + i32::from(side))]);
        }
    };
    simulator.advance_observed(end, &mut observe).unwrap();
    impacts
}

fn close(a: [f64; 4], b: [f64; 4]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-10 * (1.0 + b.abs()))
}

#[test]
fn second_method_ticks_are_impacts_with_the_librarys_values() {
    let expected = impacts(100.0);
    let fmu = started(TT);
    let (mut time, mut ticks) = (0.0, 0);
    while time < 100.0 {
        assert_eq!(fmu.get("impacts.clock"), 0.0);
        let end = fmu.step(time, 100.0 - time);
        assert_eq!(fmu.get("impacts.clock"), 0.0, "in Step Mode");
        time = end.time;
        if !end.event {
            continue;
        }
        fmu.enter_event_mode();
        if fmu.get("impacts.clock") == 1.0 {
            let shown = CLOCKED.map(|name| fmu.get(name));
            assert!(close(shown, expected[ticks]), "{shown:?} {:?}", expected[ticks]);
            ticks += 1;
            // A saved state during the tick.
            let again = Fmu::clocked(TT);
            again.restore(&fmu.bytes());
            assert_eq!(again.get("impacts.clock"), 1.0);
            assert_eq!(CLOCKED.map(|name| again.get(name)), shown);
            fmu.update();
            assert_eq!(fmu.get("impacts.clock"), 0.0, "deactivated by the update");
            assert_eq!(CLOCKED.map(|name| fmu.get(name)), shown, "and still shown");
        } else {
            fmu.update();
        }
        fmu.enter_step_mode();
    }
    assert!(ticks > 20);
    assert_eq!(ticks, expected.len());
}

/// Several impacts in a step: one tick, for the last impact; the counts show their number.
#[test]
fn a_step_through_several_impacts_ticks_once_for_the_last() {
    let fmu = started(TF);
    let expected = impacts(60.0);
    for i in 0..6 {
        let time = f64::from(i) * 10.0;
        let end = fmu.step(time, 10.0);
        let last = expected.iter().rfind(|impact| impact[0] <= time + 10.0).copied();
        let inside = last.filter(|impact| impact[0] > time);
        assert_eq!(end.event, inside.is_some());
        fmu.enter_event_mode();
        assert_eq!(fmu.get("impacts.clock"), f64::from(u8::from(inside.is_some())));
        if let Some(inside) = inside {
            assert!(close(CLOCKED.map(|name| fmu.get(name)), inside));
        }
        fmu.update();
        fmu.enter_step_mode();
    }
}

#[test]
fn a_tick_takes_parameters_that_are_set_during_it() {
    let fmu = started(TT);
    fmu.step(0.0, 50.0);
    fmu.enter_event_mode();
    let elastic = |kappa: f64| {
        assert_eq!(fmu.set("stop.restitution", kappa), OK);
        fmu.get("impacts.clocked.impulse")
    };
    let (half, full) = (elastic(0.5), elastic(1.0));
    assert!((full / half - 2.0 / 1.5).abs() < 1e-12);
}

#[test]
fn without_event_mode_it_never_ticks_and_says_so() {
    let (fmu, plain) = (started(FF), Fmu::started(FF, &[("block.s", 0.9), ("block.v", 0.5)]));
    assert!(
        fmu.log().iter().any(|record| record.0 == WARNING && record.2.contains("impacts.clock never ticks"))
    );
    for i in 0..20 {
        for fmu in [&fmu, &plain] {
            fmu.step(f64::from(i) * 3.0, 3.0);
        }
        assert_eq!(fmu.get("impacts.clock"), 0.0);
    }
    assert_eq!(fmu.motion().map(f64::to_bits), plain.motion().map(f64::to_bits));
}

#[test]
fn the_main_description_has_no_clock_and_no_clock_is_an_input() {
    let (main, clocked) = (Fmu::started(TT, &[]), started(TT));
    let (r, mut active) = (clocked.vr("impacts.clock"), 7);
    // SAFETY: one of each.
    unsafe {
        assert_eq!(fmi3GetClock(main.c, &r, 1, &mut active), ERROR);
        assert!(
            main.last().contains("is not a variable of type Clock: expected a value reference of the model"),
            "{}",
            main.last()
        );
        assert_eq!(fmi3GetClock(clocked.c, &r, 1, &mut active), OK);
        clocked.enter_event_mode();
        assert_eq!(fmi3SetClock(clocked.c, &r, 1, &1), ERROR);
        assert!(clocked.last().contains("is not a variable of type input Clock"), "{}", clocked.last());
        assert_eq!(
            fmi3GetIntervalDecimal(clocked.c, null(), 0, std::ptr::null_mut(), std::ptr::null_mut()),
            ERROR
        );
    }
}

/// An error during a tick ends the tick: the shown values stay, here and in a state saved then,
/// and belong to one impact.
#[test]
fn invariant_an_error_during_a_tick_ends_it() {
    let fmu = started(TT);
    let mut time = 0.0;
    for impact in impacts(100.0) {
        loop {
            time = fmu.step(time, 100.0 - time).time;
            fmu.enter_event_mode();
            if fmu.get("impacts.clock") == 1.0 {
                break;
            }
            fmu.update();
            fmu.enter_step_mode();
        }
        let tick = fmu.bytes();
        // SAFETY: a live instance; no variable has this reference.
        assert_eq!(unsafe { fmi3SetFloat64(fmu.c, &u32::MAX, 1, &1.0, 1) }, ERROR);
        let other = Fmu::clocked(TT);
        other.restore(&fmu.bytes());
        for ended in [&fmu, &other] {
            let shown = CLOCKED.map(|name| ended.get(name));
            assert!(close(shown, impact), "{shown:?} {impact:?}");
            assert_eq!(ended.get("impacts.clock"), 0.0);
        }
        fmu.restore(&tick);
        assert_eq!(fmu.get("impacts.clock"), 1.0);
        fmu.update();
        fmu.enter_step_mode();
    }
}
