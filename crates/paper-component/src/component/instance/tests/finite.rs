//! No output is ever NaN or infinite, for all valid values of the variables.

use super::*;
use proptest::prelude::*;
use vibro_impact::parameters::FIELDS;

/// Reads every variable individually; one that cannot be computed is refused and not written.
fn assert_finite(fmu: &mut Instance, when: &str) {
    for variable in &VARIABLES {
        let reference = variable.reference;
        let mut value = 0.0;
        let _ = fmu.get(ANY, &[reference], |_, v| value = v);
        assert!(value.is_finite(), "{} = {value} {when}", variable.name);
        let _ = fmu.output_derivatives(&[reference], &[3], |_, v| value = v);
        assert!(value.is_finite(), "third derivative of {} = {value} {when}", variable.name);
    }
    for numbers in [fmu.state_derivatives().ok(), fmu.continuous_states().ok()].into_iter().flatten() {
        assert!(numbers.iter().all(|x| x.is_finite()), "{numbers:?} {when}");
    }
    if let Ok(indicators) = fmu.event_indicators() {
        assert!(indicators.iter().all(|x| x.is_finite()), "{indicators:?} {when}");
    }
}

/// Zero, or a number from tiny to huge; ordinary numbers are more likely than all others together.
fn magnitude() -> impl Strategy<Value = f64> {
    let scale = prop_oneof![4 => -2.0..2.0, 1 => -20.0..20.0, 1 => -307.0..308.0];
    prop_oneof![8 => scale.prop_map(|exponent: f64| 10.0_f64.powf(exponent)), 1 => Just(0.0)]
}

fn signed() -> impl Strategy<Value = f64> {
    (magnitude(), any::<bool>()).prop_map(|(size, minus)| if minus { -size } else { size })
}

#[derive(Clone, Debug)]
struct Case {
    exchange: bool,
    mode: f64,
    on_orbit: f64,
    /// Indices of the parameters, start values and loads that are changed, and their values.
    values: Vec<(usize, f64)>,
    time: f64,
}

fn case() -> impl Strategy<Value = Case> {
    let set = || (0..FIELDS.len() + 9, signed());
    (any::<bool>(), 1..=3, any::<bool>(), prop::collection::vec(set(), 0..6), signed()).prop_map(
        |(exchange, mode, on_orbit, values, time)| {
            let mode = if exchange { 1.0 } else { f64::from(mode) };
            Case { exchange, mode, on_orbit: f64::from(on_orbit), values, time }
        },
    )
}

const STARTS: [&str; 9] =
    ["box.s", "block.s", "secondary.s", "box.v", "block.v", "secondary.v", "box.f", "block.f", "secondary.f"];

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn invariant_no_output_is_ever_nan_or_infinite(case in case()) {
        let interface =
            if case.exchange { Interface::ModelExchange } else { Interface::CoSimulation };
        let mut fmu = Instance::new(interface);
        let _ = set(&mut fmu, "mode", case.mode);
        let _ = set(&mut fmu, "startOnOrbit", case.on_orbit);
        for (which, value) in &case.values {
            let name = FIELDS.get(*which).map_or_else(|| STARTS[which - FIELDS.len()], |field| field.name);
            // A value out of range is refused; one with the other sign may be valid.
            let _ = set(&mut fmu, name, *value).or_else(|_| set(&mut fmu, name, value.abs()));
        }
        let _ = fmu.set_experiment(None, case.time, None);
        fmu.enter_initialization();
        assert_finite(&mut fmu, "in initialization");
        if fmu.exit_initialization(&mut Messages::default()).is_ok() {
            assert_finite(&mut fmu, "at the start");
            let time = fmu.time();
            if case.exchange {
                // States that a host's solver may try.
                let _ = fmu.set_time(time + 1.0);
                for size in [1.0, 1e3, 1e160, f64::MAX] {
                    let _ = fmu.set_continuous_states(&[size, -size, size, -size, size, -size]);
                    assert_finite(&mut fmu, "at the states of a solver");
                }
                let _ = fmu.complete_integrator_step();
                let _ = fmu.handle_events(&mut Messages::default());
                assert_finite(&mut fmu, "after an event");
            } else {
                // A step of the fastest time constant, so that the work stays small.
                let parameters = fmu.settings().parameters;
                let rate = vibro_impact::model::Model::new(&parameters).map_or(1.0, |model| model.rate);
                let _ = step(&mut fmu, time, 1.0 / rate);
                assert_finite(&mut fmu, "after a step");
            }
        }
    }
}

/// Without a steady state its numbers are 0 and the flags report this; values that do not need a
/// steady state are still available.
#[test]
fn without_a_steady_state_its_numbers_are_zero_and_the_flags_say_so() {
    const NUMBERS: [&str; 6] = ["A3", "phase", "A1", "A2", "impulse", "spectralRadius"];
    for (name, value) in [("drive.amplitude", 0.01), ("box.k", 0.0), ("drive.frequency", 0.0)] {
        let mut fmu = instance();
        set(&mut fmu, name, value).unwrap();
        for flag in ["exists", "stable"] {
            assert_eq!(get(&mut fmu, &format!("steady.{flag}")), 0.0, "{flag} with {name} = {value}");
        }
        let numbers = NUMBERS.map(|number| get(&mut fmu, &format!("steady.{number}")));
        // Without its spring the box still has an exact orbit.
        let none = if name == "box.k" { 4 } else { 6 };
        assert!(numbers[..none].iter().all(|number| *number == 0.0), "{name} = {value}: {numbers:?}");
        assert_eq!(get(&mut fmu, "groups.epsilon"), 0.1);
    }
    let mut fmu = instance();
    set(&mut fmu, "box.k", 0.0).unwrap();
    for group in ["f10", "sigma1"] {
        assert_eq!(get(&mut fmu, &format!("groups.{group}")), 0.0, "{group}");
    }
    set(&mut fmu, "box.k", 5e-324).unwrap();
    assert_eq!(get(&mut fmu, "groups.f10"), f64::MAX);
}

/// A machine whose energies exceed a double is refused by name, and can be corrected.
#[test]
fn a_machine_beyond_doubles_is_refused_by_name() {
    let mut fmu = instance();
    set(&mut fmu, "box.m", 1e300).unwrap();
    fmu.set_experiment(None, 0.0, None).unwrap();
    fmu.enter_initialization();
    let error = fmu.exit_initialization(&mut Messages::default()).unwrap_err().to_string();
    assert!(error.contains("the masses = 1e300: must be at most 1e40"), "{error}");
    set(&mut fmu, "box.m", 1.0).unwrap();
    fmu.exit_initialization(&mut Messages::default()).unwrap();
}
