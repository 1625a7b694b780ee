//! Announcements of the next event, and arrays.

use super::*;
use vibro_impact::parameters::Parameters;

fn next(fmu: &mut Instance) -> (f64, bool) {
    let time = get(fmu, "impacts.nextTime");
    (time, get(fmu, "impacts.nextKnown") == 1.0)
}

/// The horizon is two periods of the default drive.
fn horizon(time: f64) -> f64 {
    time + 2.0 * Parameters::default().period()
}

/// Steps to the announced time and returns its difference from the recorded time of the impact, in
/// units of the last place.
fn missed(fmu: &mut Instance) -> f64 {
    let impacts = |fmu: &mut Instance| get(fmu, "impacts.upper") + get(fmu, "impacts.lower");
    let (time, before) = (get(fmu, "time"), impacts(fmu));
    let (announced, known) = next(fmu);
    assert!(known && announced > time);
    // Past the event by less than the distance of any other event.
    step(fmu, time, announced - time + 1e-9).unwrap();
    assert_eq!(impacts(fmu), before + 1.0);
    let happened = get(fmu, "impacts.lastTime");
    (announced - happened).abs() / (f64::EPSILON * happened)
}

/// Second method for the same event: continuing the motion.
#[test]
fn second_method_announced_impacts_happen() {
    // A step boundary moves the event by the rounding of the flow.
    const UNITS: f64 = 8.0;
    let mut fmu = initialized();
    set(&mut fmu, "block.f", 0.02).unwrap();
    set(&mut fmu, "drive.amplitude", 0.2).unwrap();
    for _ in 0..50 {
        let units = missed(&mut fmu);
        assert!(units <= UNITS, "{units}");
    }
}

#[test]
fn second_method_announced_impacts_of_a_closed_form_happen() {
    const UNITS: f64 = 4.0;
    let mut fmu = instance();
    set(&mut fmu, "mode", 3.0).unwrap();
    let mut fmu = initialize(fmu);
    for _ in 0..5 {
        assert!(missed(&mut fmu) <= UNITS);
    }
}

#[test]
fn a_new_input_or_parameter_changes_what_is_announced() {
    let mut fmu = initialized();
    step(&mut fmu, 0.0, 20.0).unwrap();
    let first = next(&mut fmu);
    assert_eq!(next(&mut fmu), first);
    set(&mut fmu, "block.f", 0.5).unwrap();
    let second = next(&mut fmu);
    assert_ne!(second, first);
    set(&mut fmu, "drive.amplitude", 0.0).unwrap();
    assert_ne!(next(&mut fmu), second);
    // Reading the prediction changes nothing.
    let mut silent = initialized();
    step(&mut silent, 0.0, 20.0).unwrap();
    set(&mut silent, "block.f", 0.5).unwrap();
    set(&mut silent, "drive.amplitude", 0.0).unwrap();
    for fmu in [&mut fmu, &mut silent] {
        step(fmu, 20.0, 10.0).unwrap();
    }
    assert_eq!(motion(&mut fmu), motion(&mut silent));
}

#[test]
fn where_no_event_comes_the_end_of_the_horizon_is_announced() {
    let mut fmu = initialized();
    set(&mut fmu, "drive.amplitude", 0.0).unwrap();
    step(&mut fmu, 0.0, 2000.0).unwrap();
    assert_eq!(next(&mut fmu), (horizon(2000.0), false));
    // Without a drive the horizon stays finite.
    set(&mut fmu, "drive.frequency", 0.0).unwrap();
    let (time, known) = next(&mut fmu);
    assert!(time.is_finite() && time > 2000.0 && !known);
    let mut host = Instance::new(Interface::ModelExchange);
    assert_eq!(next(&mut host), (horizon(0.0), false));
    host = initialize(host);
    assert_eq!(next(&mut host), (horizon(0.0), false));
}

#[test]
fn before_initialization_the_start_is_looked_ahead_from() {
    let mut fmu = instance();
    fmu.set_experiment(None, 0.0, None).unwrap();
    fmu.enter_initialization();
    set(&mut fmu, "block.v", 5.0).unwrap();
    let announced = next(&mut fmu);
    fmu.exit_initialization(&mut Messages::default()).unwrap();
    assert_eq!(next(&mut fmu), announced);
    assert!(announced.0 < 0.3 && announced.1, "{announced:?}");
    // An impossible start does not have a motion.
    let mut fmu = instance();
    set(&mut fmu, "block.s", 1.5).unwrap();
    assert_eq!(next(&mut fmu), (horizon(0.0), false));
}

#[test]
fn arrays_are_their_scalars_in_order() {
    let mut fmu = initialized();
    step(&mut fmu, 0.0, 7.0).unwrap();
    let references = ["time", "motion.s", "box.v", "motion.a", "motion.v"].map(reference);
    let mut values = Vec::new();
    fmu.get(ANY, &references, |i, value| {
        assert_eq!(i, values.len());
        values.push(value);
    })
    .unwrap();
    let scalars = "time box.s block.s secondary.s box.v box.a block.a secondary.a box.v block.v secondary.v";
    let scalars: Vec<f64> = scalars.split(' ').map(|name| get(&mut fmu, name)).collect();
    assert_eq!(values, scalars);
}

/// In both engines the same function of the state; in rest it is the contact force divided by its
/// scale.
#[test]
fn second_method_of_the_indicators() {
    const ROUNDING: f64 = 1e-15;
    let names = ["stop.indicator.upper", "stop.indicator.lower", "stop.indicator.rest"];
    for rest in [false, true] {
        for interface in [Interface::CoSimulation, Interface::ModelExchange] {
            let mut fmu = Instance::new(interface);
            for (name, value) in [("block.s", if rest { 1.0 } else { 0.25 }), ("block.f", 2.0)] {
                set(&mut fmu, name, value).unwrap();
            }
            let mut fmu = initialize(fmu);
            if interface == Interface::ModelExchange {
                fmu.handle_events(&mut Messages::default()).unwrap();
                let own = fmu.event_indicators().unwrap();
                assert_eq!(names.map(|name| get(&mut fmu, name)), own);
            }
            let p = Parameters::default();
            let pressing = 2.0 / p.block_mass; // at the start box and drive are at rest
            let scale = p.box_stiffness / p.box_mass + p.coupling_stiffness / p.block_mass;
            let coupled = pressing - p.coupling_stiffness / p.block_mass; // from the spring at x2 = 1
            let expected = match rest {
                true => [1.0, 1.0, coupled / (scale + p.drive_amplitude / p.box_mass)],
                false => [0.75, 1.25, 1.0],
            };
            for (name, expected) in names.iter().zip(expected) {
                let value = get(&mut fmu, name);
                assert!((value - expected).abs() <= ROUNDING * expected, "{name}: {value} {expected}");
            }
        }
    }
}
