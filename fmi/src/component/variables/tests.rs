use super::*;

/// Value references of released versions, in order: they never change.
const RELEASED: &str = include_str!("../../../tests/data/value_references.txt");

#[test]
fn golden_file_of_the_value_references() {
    let names = VARIABLES.iter().map(|variable| variable.name);
    for (i, (now, released)) in names.zip(RELEASED.lines()).enumerate() {
        assert_eq!(now, released, "value reference {i}: append new variables at the end of the table");
    }
    assert!(COUNT >= RELEASED.lines().count(), "a released variable is missing");
}

/// Names, attributes and units are checked on the model description as written, by `fmu-build`.
#[test]
fn invariant_start_values_are_allowed_and_what_is_not_finite_never() {
    for v in &VARIABLES {
        if let Some(start) = v.start() {
            assert!(v.accepts(start), "{} = {start}", v.name);
            assert!(!v.allowed().is_empty(), "{}", v.name);
            assert!(!v.accepts(f64::NAN) && !v.accepts(f64::INFINITY), "{}", v.name);
        }
    }
}

#[test]
fn second_method_units_of_parameters() {
    for field in vibro_impact::parameters::FIELDS {
        assert_eq!(find(field.name).unwrap().1.unit(), Some(field.unit));
    }
}

/// What has a rate is what changes between events.
#[test]
fn invariant_continuous_outputs_vary() {
    for v in VARIABLES.iter().filter(|v| v.causality == Causality::Output) {
        if let Access::Output(reading) | Access::Start { now: reading, .. } = v.access {
            let continuous = v.variability == Variability::Continuous;
            assert_eq!(reading.varied.is_some(), continuous, "{}", v.name);
        }
        assert!(matches!(v.dependencies, Dependencies::On(_)), "{}", v.name);
    }
}

#[test]
fn invariant_every_section_is_listed_and_used() {
    assert!(VARIABLES.iter().all(|v| SECTIONS.contains(&v.section)));
    assert!(SECTIONS.iter().all(|section| VARIABLES.iter().any(|v| v.section == *section)));
}

#[test]
fn references_are_known_at_compile_time() {
    const TIME: u32 = reference("time");
    assert_eq!(TIME, 0);
}
