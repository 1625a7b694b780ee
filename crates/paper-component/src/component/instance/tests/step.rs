//! Steps and events.

use super::*;

#[test]
fn time_may_be_off_by_rounding_but_not_by_more() {
    let mut fmu = initialized();
    step(&mut fmu, 0.0, 100.0).unwrap();
    step(&mut fmu, 100.0 + 5e-8, 1.0).unwrap();
    assert_eq!(get(&mut fmu, "time"), 100.0 + 5e-8 + 1.0);
    let before = motion(&mut fmu);
    let error = step(&mut fmu, 101.1, 1.0).unwrap_err().to_string();
    assert!(error.contains("101.1 s") && error.contains("t = 101.00000005 s"), "{error}");
    // A step that ends before the own time, by less than the tolerance, is valid and does nothing.
    step(&mut fmu, 101.0, 1e-9).unwrap();
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(step(&mut fmu, 101.0, size).is_err(), "{size}");
    }
    assert!(step(&mut fmu, f64::NAN, 1.0).is_err());
    assert_eq!(motion(&mut fmu), before);
    step(&mut fmu, 101.0, 1e-14).unwrap();
    step(&mut fmu, 101.0, 1.0).unwrap();
    assert_eq!(get(&mut fmu, "time"), 102.0);
}

#[test]
fn tunable_parameters_act_from_the_next_step_on() {
    let (mut fmu, mut other) = (initialized(), initialized());
    step(&mut fmu, 0.0, 5.0).unwrap();
    step(&mut other, 0.0, 5.0).unwrap();
    set(&mut fmu, "drive.amplitude", 0.3).unwrap();
    assert_eq!(get(&mut fmu, "drive.amplitude"), 0.3);
    assert!((get(&mut fmu, "groups.f10") - 3.0).abs() < 1e-12);
    assert_eq!(get(&mut fmu, "box.s"), get(&mut other, "box.s"));
    step(&mut fmu, 5.0, 1.0).unwrap();
    step(&mut other, 5.0, 1.0).unwrap();
    assert!((get(&mut fmu, "box.s") - get(&mut other, "box.s")).abs() > 1e-3);
}

#[test]
fn events_are_logged_when_asked_for() {
    let mut fmu = initialized();
    let mut messages = Messages::default();
    fmu.step_without_event_mode(0.0, 40.0, &mut messages).unwrap();
    let impacts = get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower");
    assert!(impacts > 0.0);
    assert_eq!(messages.0.len() as f64, impacts);
    assert!(messages.0.iter().all(|(c, _)| *c == Category::Events));
    assert!(messages.0[0].1.starts_with("impact on the"), "{}", messages.0[0].1);
    fmu.step_without_event_mode(40.0, 40.0, &mut Silence).unwrap();
}

#[test]
fn stop_at_impact_ends_the_step_there_and_can_be_redone() {
    let mut fmu = instance();
    set(&mut fmu, "stopAtImpact", 1.0).unwrap();
    let mut fmu = initialize(fmu);
    let before = fmu.save();
    let StepOutcome { time, event, early } = step(&mut fmu, 0.0, 40.0).unwrap();
    assert_eq!((event, early, fmu.phase(), fmu.time()), (false, true, Phase::StoppedEarly, time));
    assert!(time > 0.0 && time < 40.0);
    assert_eq!(get(&mut fmu, "impacts.lastTime"), time);
    // As masters do it: back to the step's beginning, then a step that ends at the impact.
    fmu.restore(&before).unwrap();
    step(&mut fmu, 0.0, time).unwrap();
    assert_eq!(get(&mut fmu, "time"), time);
}

/// Compared with a run that does not stop: equal impacts, and each step makes progress.
#[test]
fn a_master_gets_from_impact_to_impact() {
    const END: f64 = 300.0;
    let mut plain = initialized();
    step(&mut plain, 0.0, END).unwrap();
    let mut fmu = instance();
    set(&mut fmu, "stopAtImpact", 1.0).unwrap();
    let mut fmu = initialize(fmu);
    let (mut time, mut met) = (0.0, 0);
    while time < END {
        let before = fmu.save();
        let size = f64::min(2.0, END - time);
        let outcome = step(&mut fmu, time, size).unwrap();
        match outcome.early {
            false => time += size,
            true => {
                let impact = outcome.time;
                assert!(impact > time, "the step from t = {time} s does not progress");
                fmu.restore(&before).unwrap();
                // A master's sum may round up or down.
                let off = f64::from(met % 3 - 1) * 2.0 * f64::EPSILON * impact;
                step(&mut fmu, time, impact - time + off).unwrap();
                time = impact;
                met += 1;
                let counted = get(&mut fmu, "impacts.upper") + get(&mut fmu, "impacts.lower");
                assert_eq!(counted, f64::from(met), "at t = {time} s");
            }
        }
    }
    assert!(met > 50, "{met}");
    for name in MOTION {
        let (a, b) = (get(&mut fmu, name), get(&mut plain, name));
        // Round-off, since each stop splits a step.
        assert!((a - b).abs() < 1e-10, "{name}: {a} {b}");
    }
}

/// A slow impact is found only as accurately as w is rounded. It is also past once the step to its
/// announced time has ended.
#[test]
fn a_slow_impact_is_behind_the_step_that_ends_at_its_announced_time() {
    for k in 0..40 {
        let mut fmu = instance();
        let depth = 10.0_f64.powf(-0.1 * f64::from(k)); // of the block before the stop against which it is pressed
        for (name, value) in [("stopAtImpact", 1.0), ("block.s", 1.0 - depth), ("block.f", 0.02)] {
            set(&mut fmu, name, value).unwrap();
        }
        let mut fmu = initialize(fmu);
        let announced = get(&mut fmu, "impacts.nextTime");
        step(&mut fmu, 0.0, announced).unwrap();
        assert_eq!(get(&mut fmu, "impacts.upper"), 1.0, "{depth}: announced for {announced}");
    }
}

/// A step is undone by restoring the state before it. If that state is refused, the failure is
/// reported with its cause.
#[test]
fn a_step_that_cannot_be_taken_back_is_reported() {
    use crate::component::instance::arrival::take_back;
    use vibro_impact::Error;
    use vibro_impact::parameters::Parameters;
    use vibro_impact::simulator::{Simulator, Snapshot};
    let mut simulator = Simulator::new(&Parameters::default(), &vibro_impact::State::default(), 0.0).unwrap();
    let before = simulator.snapshot();
    let cause = || Error::Step { time: 1.0, end: 0.5 };
    let problem = take_back(&mut simulator, &before, cause().into());
    assert!(matches!(problem, ComponentProblem::Model(Error::Step { .. })), "{problem}");
    // A snapshot that no simulator has made: after its parameters and its time come x1 and w,
    // which is past the stop here.
    let mut bytes = postcard::to_stdvec(&before).unwrap();
    let w = size_of::<Parameters>() + 24;
    bytes[w..w + 8].copy_from_slice(&1.5f64.to_le_bytes());
    let foreign: Snapshot = postcard::from_bytes(&bytes).unwrap();
    let problem = take_back(&mut simulator, &foreign, cause().into());
    let said = problem.to_string();
    assert!(matches!(problem, ComponentProblem::Door(fmi_doors::Problem::NotTakenBack { .. })), "{said}");
    assert!(said.contains(&cause().to_string()) && said.contains("could not be taken back"), "{said}");
    assert_eq!(simulator.snapshot(), before);
}

/// A step that a closed form refuses leaves the parameters for the next step, and the motion
/// unchanged.
#[test]
fn a_refused_step_of_a_closed_form_is_taken_back() {
    for mode in [2.0, 3.0] {
        for by_advance in [false, true] {
            let mut fmu = instance();
            set(&mut fmu, "mode", mode).unwrap();
            let mut fmu = initialize(fmu);
            step(&mut fmu, 0.0, 1.0).unwrap();
            let (before, amplitude) = (fmu.save().engine, get(&mut fmu, "drive.amplitude"));
            set(&mut fmu, "drive.amplitude", 1.1 * amplitude).unwrap();
            let far = 1e17; // beyond it a double cannot distinguish two moments of the motion
            let refused = match by_advance {
                true => fmu.step_as_agreed(1.0, far, &mut Silence).err(),
                false => fmu.step_without_event_mode(1.0, far, &mut Silence).err(),
            };
            assert!(refused.is_some());
            assert_eq!(fmu.save().engine, before);
        }
    }
}

/// An input that followed a polynomial during a step is held from its end on, unless its
/// derivatives are set again.
#[test]
fn an_input_with_derivatives_is_held_after_its_step() {
    let mut fmu = initialized();
    fmu.set_input_derivatives(&[reference("box.f")], &[1], &[1.0]).unwrap();
    step(&mut fmu, 0.0, 0.5).unwrap();
    assert_eq!(get(&mut fmu, "box.f"), 0.5);
    let mut held = instance();
    held.restore(&fmu.save()).unwrap();
    set(&mut held, "box.f", 0.5).unwrap();
    set(&mut fmu, "block.f", 0.0).unwrap();
    for fmu in [&mut fmu, &mut held] {
        step(fmu, 0.5, 0.5).unwrap();
        step(fmu, 1.0, 0.5).unwrap();
        assert_eq!(get(fmu, "box.f"), 0.5);
    }
    assert_eq!(motion(&mut fmu), motion(&mut held));
}

/// A step that stops at an impact is not at its end: its remainder follows the same polynomial as
/// without the stop.
#[test]
fn an_input_with_derivatives_goes_on_after_an_impact_in_its_step() {
    /// Tolerance: rounding of loads and positions of order one after a few impacts.
    const SAME: f64 = 1e-9;
    let [mut whole, mut stopping] = [0.0, 1.0].map(|stop| {
        let mut fmu = instance();
        for (name, value) in [("stopAtImpact", stop), ("block.s", 0.9), ("block.v", 0.5)] {
            set(&mut fmu, name, value).unwrap();
        }
        initialize(fmu)
    });
    for fmu in [&mut whole, &mut stopping] {
        fmu.set_input_derivatives(&[reference("box.f")], &[1], &[0.01]).unwrap();
    }
    step(&mut whole, 0.0, 12.0).unwrap();
    let mut stops = 0;
    while stopping.time() < 12.0 {
        let now = stopping.time();
        stops += usize::from(step(&mut stopping, now, 12.0 - now).unwrap().early);
    }
    assert!(stops > 1, "{stops}");
    for name in ["box.f", "box.s", "block.s"] {
        let (a, b) = (get(&mut whole, name), get(&mut stopping, name));
        assert!((a - b).abs() < SAME, "{name}: {a} {b}");
    }
}
