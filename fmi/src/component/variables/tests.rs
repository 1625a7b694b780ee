use super::*;
use crate::component::units;

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

#[test]
fn invariant_names_are_unique_and_structured() {
    for (i, variable) in VARIABLES.iter().enumerate() {
        assert_eq!(find(variable.name).unwrap().0 as usize, i, "{}", variable.name);
        assert!(variable.name.split('.').all(|part| {
            part.starts_with(|c: char| c.is_ascii_alphabetic())
                && part.chars().all(|c| c.is_ascii_alphanumeric())
        }));
        assert!(units::REAL_TYPES.iter().all(|t| t.name != variable.name));
        assert!(!variable.description.is_empty());
    }
}

#[test]
fn invariant_start_values_are_allowed_and_units_defined() {
    for v in &VARIABLES {
        if let Some(start) = v.start() {
            assert!(v.accepts(start), "{} = {start}", v.name);
            assert!(!v.allowed().is_empty(), "{}", v.name);
            assert!(!v.accepts(f64::NAN) && !v.accepts(f64::INFINITY), "{}", v.name);
        }
        if let Some(declared) = v.real_type() {
            let unit = units::find(declared.unit).unwrap();
            assert!(declared.display_unit.is_none_or(|name| unit.display.iter().any(|d| d.name == name)));
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
