//! Without event mode and early return, the motion is bit-identical to FMI 2.0 and to the library;
//! states can be exchanged between the versions.

use super::fmi2::Fmu2;
use super::host::*;
use vibro_impact::{Parameters, Simulator, State};
use vibro_paper_component::component::variables::{Base, reference};
use vibro_paper_component::fmi2::description;

/// Compares all variables of both descriptions except the setting with a different start value.
fn compare(two: &Fmu2, three: &Fmu, at: f64) {
    for (r, variable) in description::variables().filter(|(_, v)| v.name != "stopAtImpact") {
        let (a, b) = (two.get(r, variable.base()), three.get(variable.name));
        assert_eq!(a.to_bits(), b.to_bits(), "{} at {at}: {a} {b}", variable.name);
    }
}

/// Starts with impacts, chatter and rest, chaos, plastic impacts, closed forms.
const RUNS: [&[(&str, f64)]; 6] = [
    &[("block.s", 0.9), ("block.v", 0.5)],
    &[("block.s", 0.9), ("stop.restitution", 0.2)],
    &[("block.s", 0.9), ("drive.amplitude", 0.45)],
    &[("stop.restitution", 0.0), ("drive.phase", 1.0)],
    &[("mode", 2.0)],
    &[("mode", 3.0)],
];

#[test]
fn invariant_bits_of_both_versions_are_equal() {
    for start in RUNS {
        let (two, three) = (Fmu2::started(start), Fmu::started(FF, start));
        let closed = start[0].0 == "mode";
        for i in 0..400 {
            let (time, size) = (f64::from(i) * 0.17, 0.17);
            if !closed && i > 200 {
                let load = 0.02 * (f64::from(i) * 0.37).sin();
                two.set("block.f", load);
                assert_eq!(three.set("block.f", load), OK);
            }
            two.step(time, size);
            let end = three.step(time, size);
            assert_eq!((end.event, end.early, end.terminate), (false, false, false));
            assert_eq!(end.time, time + size);
            if i % 20 == 0 {
                compare(&two, &three, time + size);
            }
        }
        compare(&two, &three, 68.0);
    }
}

#[test]
fn invariant_bits_are_those_of_the_library() {
    let mut simulator = Simulator::new(&Parameters::default(), &State::default(), 0.0).unwrap();
    let fmu = Fmu::started(FF, &[]);
    for i in 0..500 {
        let time = f64::from(i) * 0.25;
        fmu.step(time, 0.25);
        simulator.advance_to(time + 0.25).unwrap();
    }
    assert!(fmu.get("impacts.upper") > 10.0);
    let State { x, v } = simulator.state();
    assert_eq!(fmu.motion().map(f64::to_bits), [x[0], x[1], x[2], v[0], v[1], v[2]].map(f64::to_bits));
}

#[test]
fn invariant_a_saved_state_of_either_version_goes_on_in_the_other() {
    for start in RUNS {
        let (two, three) = (Fmu2::started(start), Fmu::started(FF, start));
        for i in 0..50 {
            two.step(f64::from(i) * 0.7, 0.7);
            three.step(f64::from(i) * 0.7, 0.7);
        }
        let (into_two, into_three) = (Fmu2::quiet(1), Fmu::new(FF));
        into_three.restore(&two.bytes());
        into_two.restore(&three.bytes());
        compare(&into_two, &into_three, 35.0);
        for i in 50..100 {
            let time = f64::from(i) * 0.7;
            two.step(time, 0.7);
            into_two.step(time, 0.7);
            into_three.step(time, 0.7);
        }
        compare(&two, &into_three, 70.0);
        compare(&into_two, &into_three, 70.0);
    }
}

/// A state saved before an impact's law, with its event pending, in both directions and onto
/// itself.
#[test]
fn invariant_a_saved_state_at_a_pending_event_goes_on() {
    let start = RUNS[0];
    let three = Fmu::started(TT, start);
    let end = three.step(0.0, 50.0);
    assert!(end.event && end.early);
    let bytes = three.bytes();
    let again = Fmu::new(TT);
    again.restore(&bytes);
    assert_eq!(again.try_step(end.time, 1.0).0, ERROR, "the event is still to be handled");
    again.restore(&bytes);
    assert_eq!(again.motion().map(f64::to_bits), three.motion().map(f64::to_bits));
    for fmu in [&again, &three] {
        assert!(fmu.handle_event().values_changed);
        fmu.run(end.time, 60.0, 0.5);
    }
    assert_eq!(again.motion().map(f64::to_bits), three.motion().map(f64::to_bits));
    // FMI 2.0 has no pending events: its next step begins with the law.
    let two = Fmu2::quiet(1);
    two.restore(&bytes);
    assert_eq!(two.get(reference("impacts.upper"), Base::Integer) as u32, 0);
    two.step(end.time, 60.0 - end.time);
    let plain = Fmu2::started(start);
    plain.step(0.0, 60.0);
    for name in ["impacts.upper", "impacts.lower"] {
        let counts = [&two, &plain].map(|fmu| fmu.get(reference(name), Base::Integer));
        assert_eq!(counts[0], counts[1], "{name}");
    }
    // In Event Mode too, and with instances of both versions at the same time.
    let third = Fmu::started(TT, start);
    third.step(0.0, 50.0);
    third.enter_event_mode();
    let bytes = third.bytes();
    two.restore(&bytes);
    two.step(end.time, 60.0 - end.time);
    let fourth = Fmu::new(TT);
    fourth.restore(&bytes);
    for fmu in [&third, &fourth] {
        assert!(fmu.update().values_changed);
        fmu.enter_step_mode();
        fmu.run(end.time, 60.0, 0.5);
    }
    assert_eq!(third.motion().map(f64::to_bits), fourth.motion().map(f64::to_bits));
}
