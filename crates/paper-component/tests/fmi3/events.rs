//! Event mode and early return.

use super::host::*;
use vibro_impact::simulator::Event;
use vibro_impact::{Parameters, Simulator, State};
use vibro_paper_component::fmi3::abi::*;

/// The default motion is stable: rounding at each pause is not amplified.
const SAME: f64 = 1e-10;

const START: &[(&str, f64)] = &[("block.s", 0.9), ("block.v", 0.5)];
const RESTING: &[(&str, f64)] = &[("block.s", 0.9), ("stop.restitution", 0.2)];
const PLASTIC: &[(&str, f64)] = &[("stop.restitution", 0.0), ("drive.phase", 1.0)];

fn assert_same(a: &Fmu, b: &Fmu) {
    for (name, (a, b)) in MOTION.iter().zip(a.motion().into_iter().zip(b.motion())) {
        assert!((a - b).abs() <= SAME, "{name}: {a} {b}");
    }
    for name in ["impacts.upper", "impacts.lower", "stop.state"] {
        assert_eq!(a.get(name), b.get(name), "{name}");
    }
}

/// Row F/T: the step returns at the event, after its law.
#[test]
fn row_early_return_alone() {
    for start in [START, RESTING, PLASTIC, &[("mode", 3.0)]] {
        let (plain, fmu) = (Fmu::started(FF, start), Fmu::started(FT, start));
        let (mut time, mut early) = (0.0, 0);
        while time < 60.0 {
            let counts = fmu.get("impacts.upper") + fmu.get("impacts.lower");
            let state = fmu.get("stop.state");
            let end = fmu.step(time, 60.0 - time);
            assert!(!end.event && !end.terminate && end.time > time);
            assert_eq!(end.early, end.time < 60.0);
            time = end.time;
            if end.early {
                early += 1;
                let impact = fmu.get("impacts.upper") + fmu.get("impacts.lower") > counts;
                assert!(impact || fmu.get("stop.state") != state, "nothing happened at {time}");
                assert!(!impact || fmu.get("impacts.lastTime") == time);
            }
        }
        assert!(early > 5);
        plain.step(0.0, 60.0);
        assert_same(&plain, &fmu);
    }
}

/// Row T/T: the step pauses before the law; both limits can be read, and they satisfy restitution
/// and momentum.
#[test]
fn row_event_mode_with_early_return() {
    const EXACT: f64 = 1e-12;
    let p = Parameters::default();
    for (start, kappa) in
        [(START, p.stop_restitution), (RESTING, 0.2), (PLASTIC, 0.0), (&[("mode", 3.0)], p.stop_restitution)]
    {
        let (plain, fmu) = (Fmu::started(FF, start), Fmu::started(TT, start));
        let (mut time, mut impacts, mut releases) = (0.0, 0, 0);
        while time < 60.0 {
            let end = fmu.step(time, 60.0 - time);
            assert_eq!((end.early, end.event), (end.time < 60.0, end.time < 60.0));
            assert!(end.time >= time);
            time = end.time;
            if !end.event {
                continue;
            }
            let count = |fmu: &Fmu| fmu.get("impacts.upper") + fmu.get("impacts.lower");
            let (before, counted, state) = (fmu.motion(), count(&fmu), fmu.get("stop.state"));
            fmu.enter_event_mode();
            let (after, shown) = (fmu.motion(), count(&fmu));
            let update = fmu.update();
            assert_eq!(after.map(f64::to_bits), fmu.motion().map(f64::to_bits), "shown as it then is");
            assert!(!fmu.update().values_changed, "nothing more");
            fmu.enter_step_mode();
            assert_eq!(after.map(f64::to_bits), fmu.motion().map(f64::to_bits));
            assert_eq!(update.values_changed, shown > counted);
            if shown == counted {
                releases += 1;
                assert!(state != 1.0 && fmu.get("stop.state") == 1.0);
                assert_eq!(before, after, "a release is no jump");
                continue;
            }
            impacts += 1;
            let rate = |x: [f64; 6]| x[4] - x[3];
            if fmu.get("stop.state") == 1.0 {
                assert!((rate(after) + kappa * rate(before)).abs() < EXACT, "{time}: {before:?} {after:?}");
            }
            let momentum = |x: [f64; 6]| p.box_mass * x[3] + p.block_mass * x[4];
            assert!((momentum(after) - momentum(before)).abs() < EXACT);
            assert_eq!((before[2], before[5]), (after[2], after[5]), "the secondary feels nothing");
            assert_eq!(fmu.get("impacts.lastTime"), time);
        }
        assert!(impacts > 5);
        assert_eq!(releases > 0, kappa == 0.0, "{kappa} {releases}");
        plain.step(0.0, 60.0);
        assert_same(&plain, &fmu);
    }
}

/// Row T/F, and T/T with stopAtImpact = false: the step continues; discrete outputs are latched
/// until Event Mode.
#[test]
fn row_event_mode_without_early_return() {
    for (flags, stop) in [(TF, 1.0), (TT, 0.0)] {
        for start in [START, RESTING, PLASTIC, &[("mode", 3.0)]] {
            let start = [start, &[("stopAtImpact", stop)]].concat();
            let (plain, fmu) = (Fmu::started(FF, &start), Fmu::started(flags, &start));
            let mut seen = 0;
            for i in 0..60 {
                let names = [
                    "impacts.upper",
                    "impacts.lower",
                    "impacts.lastTime",
                    "impacts.impulse",
                    "stop.state",
                    "energy.impact",
                ];
                let held = names.map(|name| fmu.get(name));
                let time = f64::from(i);
                plain.step(time, 1.0);
                let end = fmu.step(time, 1.0);
                assert_eq!((end.early, end.time), (false, time + 1.0));
                if end.event {
                    seen += 1;
                    assert_eq!(names.map(|name| fmu.get(name)), held, "latched");
                    fmu.enter_event_mode();
                    assert_ne!(names.map(|name| fmu.get(name)), held, "shown");
                    assert!(!fmu.update().values_changed);
                    fmu.enter_step_mode();
                }
                for name in names.iter().chain(&MOTION) {
                    let values = [&plain, &fmu].map(|fmu| fmu.get(name));
                    assert_eq!(values[0].to_bits(), values[1].to_bits(), "{name} at {time}");
                }
            }
            assert!(seen > 5, "{seen}");
        }
    }
}

/// The times of events agree with the library's up to the last places.
#[test]
fn second_method_event_times_are_the_librarys() {
    const UNITS: f64 = 16.0; // in the last place: different sub-steps
    let p = Parameters::default();
    let state = State { x: [0.0, 0.9, 0.0], v: [0.0, 0.5, 0.0] };
    let mut simulator = Simulator::new(&p, &state, 0.0).unwrap();
    let mut times = Vec::new();
    simulator
        .advance_observed(100.0, &mut |event| {
            if let Event::Impact { time, .. } = event {
                times.push(*time);
            }
        })
        .unwrap();
    let fmu = Fmu::started(TT, START);
    for (i, expected) in times.iter().enumerate() {
        let from = if i == 0 { 0.0 } else { fmu.get("time") };
        let end = fmu.step(from, 100.0 - from);
        assert!((end.time - expected).abs() <= UNITS * f64::EPSILON * expected, "{} {expected}", end.time);
        fmu.handle_event();
    }
}

/// An event at the step's end up to rounding is met there, however the host's sum rounds.
#[test]
fn an_event_at_the_end_of_a_step_is_no_early_return() {
    let find = Fmu::started(TT, START);
    let impact = find.step(0.0, 50.0).time;
    for units in [-2.0, -1.0, 0.0, 1.0, 2.0] {
        let size = impact + units * f64::EPSILON * impact;
        for (flags, event) in [(TT, true), (FT, false), (FF, false)] {
            let fmu = Fmu::started(flags, START);
            let end = fmu.step(0.0, size);
            assert_eq!((end.event, end.early), (event, false), "{units}");
            assert!((end.time - impact).abs() <= 4.0 * f64::EPSILON * impact);
            let count = fmu.get("impacts.upper") + fmu.get("impacts.lower");
            match (flags.event_mode, flags.early_return) {
                (true, _) => {
                    assert_eq!(count, 0.0, "before the law");
                    assert!(fmu.handle_event().values_changed);
                }
                (false, true) => assert_eq!(count, 1.0, "after the law"),
                _ => {}
            }
            // The event is met once.
            let next = fmu.step(end.time, 0.05);
            assert!(!next.event && !next.early, "{units}: {next:?}");
            assert_eq!(fmu.get("impacts.upper") + fmu.get("impacts.lower"), 1.0);
        }
    }
}

/// A host that ignores the early return requests the next planned point.
#[test]
fn an_early_return_that_is_ignored_is_an_error() {
    let fmu = Fmu::started(FT, START);
    let end = fmu.step(0.0, 50.0);
    assert!(end.early);
    let (status, again) = fmu.try_step(50.0, 50.0);
    assert_eq!((status, again.time), (ERROR, end.time));
    assert!(
        fmu.last().contains("currentCommunicationPoint = 50 s, but the instance is at t ="),
        "{}",
        fmu.last()
    );
}

#[test]
fn a_pending_event_must_be_handled() {
    let fmu = Fmu::started(TT, START);
    let end = fmu.step(0.0, 50.0);
    assert_eq!(fmu.try_step(end.time, 1.0).0, ERROR);
    assert!(fmu.last().contains("must be handled in Event Mode first"), "{}", fmu.last());
}

/// Some hosts enter Event Mode after every step.
#[test]
fn event_mode_without_an_event_changes_nothing() {
    let (plain, fmu) = (Fmu::started(TF, START), Fmu::started(TF, START));
    for i in 0..100 {
        for fmu in [&plain, &fmu] {
            let end = fmu.step(f64::from(i) * 0.3, 0.3);
            if end.event {
                fmu.handle_event();
            }
        }
        assert!(!fmu.handle_event().values_changed);
    }
    assert_eq!(plain.motion().map(f64::to_bits), fmu.motion().map(f64::to_bits));
}

/// The law uses inputs and tunable parameters set in Event Mode, and getters see them.
#[test]
fn parameters_set_at_an_event_take_part_in_it() {
    let fmu = Fmu::started(TT, START);
    let mut time = fmu.step(0.0, 50.0).time;
    let before = fmu.motion();
    let rate = |x: [f64; 6]| x[4] - x[3];
    fmu.enter_event_mode();
    for kappa in [0.9, 0.3, 0.0] {
        assert_eq!(fmu.set("stop.restitution", kappa), OK);
        assert!((rate(fmu.motion()) + kappa * rate(before)).abs() < 1e-12);
    }
    assert_eq!(fmu.set("stop.restitution", 0.5), OK);
    assert_eq!(fmu.set("drive.frequency", 1.1), OK);
    let shown = fmu.motion();
    assert!(fmu.update().values_changed);
    assert_eq!(fmu.motion(), shown);
    assert!((rate(shown) + 0.5 * rate(before)).abs() < 1e-12);
    assert_eq!(fmu.get("stop.restitution"), 0.5);
    fmu.enter_step_mode();
    assert_eq!(fmu.motion(), shown);
    // A resting block that is pulled off is released in that Event Mode, and in Step Mode at the
    // step's own start.
    let fmu = Fmu::started(TT, PLASTIC);
    while fmu.get("stop.state") == 1.0 {
        time = fmu.step(fmu.get("time"), 100.0).time;
        fmu.handle_event();
    }
    let pull = if fmu.get("stop.state") == 2.0 { -50.0 } else { 50.0 };
    let saved = fmu.bytes();
    let time = if time > fmu.get("time") { time } else { fmu.get("time") };
    fmu.enter_event_mode();
    assert_eq!(fmu.set("block.f", pull), OK);
    assert_eq!(fmu.get("stop.state"), 1.0);
    assert!(!fmu.update().values_changed, "no jump");
    fmu.enter_step_mode();
    assert_eq!(fmu.get("stop.state"), 1.0);
    fmu.restore(&saved);
    assert_eq!(fmu.set("block.f", pull), OK);
    let resting = fmu.get("stop.state");
    let end = fmu.step(time, 0.01);
    assert_eq!((end.event, end.early, end.time), (true, true, time), "at its own start");
    assert_eq!(fmu.get("stop.state"), resting, "latched");
    fmu.handle_event();
    assert_eq!(fmu.get("stop.state"), 1.0);
    assert!(fmu.step(time, 0.01).time > time, "once");
}

#[test]
fn an_event_that_is_not_updated_is_taken_with_a_warning() {
    let fmu = Fmu::started(TT, START);
    let time = fmu.step(0.0, 50.0).time;
    fmu.enter_event_mode();
    fmu.enter_step_mode();
    assert!(fmu.log().iter().any(|(status, category, text)| *status == WARNING
        && category == "logStatusWarning"
        && text.starts_with("fmi3EnterStepMode: the discrete states were not updated")));
    assert_eq!(fmu.get("impacts.upper") + fmu.get("impacts.lower"), 1.0);
    assert!(fmu.step(time, 0.1).time > time);
}

/// A start at a stop with closing speed: the first step meets the impact immediately, and
/// continues after it.
#[test]
fn a_start_at_a_stop_is_an_event_at_the_start() {
    let fmu = Fmu::started(TT, &[("block.s", 1.0), ("block.v", 0.5)]);
    let end = fmu.step(0.0, 1.0);
    assert_eq!((end.event, end.early, end.time), (true, true, 0.0));
    assert_eq!(fmu.get("stop.v"), 0.5);
    assert!(fmu.handle_event().values_changed);
    assert_eq!(fmu.get("stop.v"), -0.5 * Parameters::default().stop_restitution);
    assert!(fmu.step(0.0, 0.1).time == 0.1);
}

/// The announced event happens: bit for bit if the host steps past it with held inputs.
#[test]
fn invariant_the_announced_event_happens() {
    const EVENTS: usize = 10_000;
    for start in [START, RESTING, PLASTIC, &[("block.s", 0.9), ("drive.amplitude", 0.45)], &[("mode", 3.0)]] {
        let fmu = Fmu::started(TT, start);
        let (mut time, mut next, mut announced) = (0.0, None, 0);
        for _ in 0..EVENTS / 5 {
            let end = fmu.step(time, 13.0);
            if let Some(next) = next {
                assert_eq!(end.time, next, "after {time}");
                announced += 1;
            }
            time = end.time;
            next = if end.event { fmu.handle_event().next } else { None };
            assert!(next.is_none_or(|next| next > time + 1e-9 * time.max(1.0)));
        }
        assert!(announced > EVENTS / 20, "{start:?}: {announced}");
    }
}

/// Like a container: steps end at the announced time, with Event Mode after every step.
#[test]
fn steps_that_end_on_the_announced_time_meet_the_event() {
    let (fmu, plain) = (Fmu::started(TF, START), Fmu::started(FF, START));
    let (mut time, mut next, mut met) = (0.0_f64, None, 0);
    while time < 60.0 {
        let planned = time + 0.7;
        let end = next.filter(|next| *next < planned).unwrap_or(planned);
        let reached = fmu.step(time, end - time);
        assert!(!reached.early);
        let announced = next == Some(end);
        assert!(!announced || reached.event, "announced for {end}, not met");
        met += usize::from(announced);
        fmu.enter_event_mode();
        next = fmu.update().next;
        if announced {
            assert!((fmu.get("impacts.lastTime") - end).abs() <= 8.0 * f64::EPSILON * end);
        }
        fmu.enter_step_mode();
        time = reached.time;
    }
    plain.step(0.0, time);
    assert!(met > 10);
    assert_eq!(fmu.get("impacts.upper"), plain.get("impacts.upper"));
}

/// A closed form that begins late, so that announced times are rounded more than the drive's
/// phase.
#[test]
fn steps_that_end_on_the_announced_time_meet_the_impacts_of_a_closed_form() {
    const BEGIN: f64 = 1e4;
    for frequency in 0..20 {
        let fmu = Fmu::new(TF);
        for (name, value) in [("mode", 3.0), ("drive.frequency", 1.0 + 0.003 * f64::from(frequency))] {
            assert_eq!(fmu.set(name, value), OK);
        }
        // SAFETY: a live instance. Undefined values are not read.
        unsafe {
            assert_eq!(fmi3EnterInitializationMode(fmu.c, 0, f64::NAN, BEGIN, 0, -1.0), OK);
            assert_eq!(fmi3ExitInitializationMode(fmu.c), OK);
        }
        let (mut time, mut next) = (BEGIN, fmu.update().next);
        fmu.enter_step_mode();
        for _ in 0..20 {
            let announced = next.expect("one impact follows the other");
            let end = fmu.step(time, announced - time);
            assert!(end.event && !end.early, "{frequency}: announced for {announced}, not met");
            (time, next) = (end.time, fmu.handle_event().next);
            assert!((fmu.get("impacts.lastTime") - announced).abs() <= 8.0 * f64::EPSILON * announced);
        }
    }
}

/// A slow impact is found only as accurately as w is rounded, which is coarser than the rounding
/// of its time. It is also met by the step that ends at the announced time.
#[test]
fn slow_impacts_are_met_by_steps_that_end_on_the_announced_time() {
    /// Slower impacts are the last bounces of a chatter run, which round-off decides.
    const SLOWEST: f64 = 1e-4;
    let mut met = 0;
    for k in 0..60 {
        let depth = 10.0_f64.powf(-0.1 * f64::from(k)); // distance of the block from the stop against which it is pressed
        let start = [("block.s", 1.0 - depth), ("block.f", 0.02), ("stop.restitution", 0.5)];
        let fmu = Fmu::started(TT, &start);
        let (mut time, mut next) = (0.0, fmu.handle_event().next);
        while let Some(announced) = next {
            let end = fmu.step(time, announced - time);
            assert!(end.event && !end.early, "{depth}: announced for {announced}, not met");
            (time, next) = (end.time, fmu.handle_event().next);
            met += 1;
            if time > 5.0 || fmu.get("impacts.lastSpeed") < SLOWEST {
                break;
            }
        }
    }
    assert!(met > 200, "{met}");
}

/// A new input makes the announcement obsolete, without harm.
#[test]
fn an_obsolete_announcement_is_harmless() {
    let fmu = Fmu::started(TT, START);
    let next = fmu.handle_event().next.unwrap();
    assert_eq!(fmu.get("impacts.nextTime"), next);
    assert_eq!(fmu.set("block.f", -0.3), OK);
    let other = fmu.get("impacts.nextTime");
    assert_ne!(other, next);
    let end = fmu.step(0.0, next.min(other) * 0.5);
    assert!(!end.event);
    fmu.handle_event();
    assert!(fmu.step(end.time, 20.0).event);
}

/// Modes, and whether a parameter is set in the event; otherwise the event is an impact.
const SHOWN: [(f64, bool); 4] = [(1.0, false), (2.0, true), (3.0, true), (3.0, false)];

/// An instance in such an event, and its flags.
fn in_an_event((mode, set): (f64, bool)) -> (Fmu, Flags) {
    let flags = if set { TF } else { TT };
    let fmu = Fmu::new(flags);
    assert_eq!(fmu.set("mode", mode), OK);
    fmu.initialize();
    if set {
        assert_eq!(fmu.set("drive.amplitude", 0.2), OK);
    } else {
        fmu.update();
        fmu.enter_step_mode();
        assert!(fmu.step(0.0, 60.0).event);
        // SAFETY: a live instance.
        assert_eq!(unsafe { fmi3EnterEventMode(fmu.c) }, OK);
    }
    (fmu, flags)
}

/// Values shown by an event, after a parameter was set or an impact, stay if the host ends the
/// simulation in it, and in a state saved then.
#[test]
fn invariant_the_end_in_an_event_keeps_what_was_shown() {
    for case in SHOWN {
        let (fmu, flags) = in_an_event(case);
        let shown = fmu.motion().map(f64::to_bits);
        // SAFETY: a live instance.
        assert_eq!(unsafe { fmi3Terminate(fmu.c) }, OK);
        let other = Fmu::new(flags);
        other.restore(&fmu.bytes());
        for ended in [&fmu, &other] {
            assert_eq!(ended.motion().map(f64::to_bits), shown, "{case:?}");
        }
    }
}

/// An error in an event ends the simulation before the event, here and in a state saved then,
/// whatever was shown.
#[test]
fn invariant_an_error_in_an_event_leaves_what_is_saved() {
    for case in SHOWN {
        let (fmu, flags) = in_an_event(case);
        fmu.motion(); // values after the event
        // SAFETY: a live instance; no variable has this reference.
        assert_eq!(unsafe { fmi3SetFloat64(fmu.c, &u32::MAX, 1, &1.0, 1) }, ERROR);
        let other = Fmu::new(flags);
        other.restore(&fmu.bytes());
        let [ended, restored] = [&fmu, &other].map(|fmu| fmu.motion().map(f64::to_bits));
        assert_eq!(ended, restored, "{case:?}");
    }
}
