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
        if let Access::Tick(_) = v.access {
            assert_eq!(v.variability, Variability::Discrete, "{}", v.name);
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

/// An array has as many elements as its dimensions say, and only what reads elements has dimensions.
#[test]
fn invariant_arrays_have_dimensions_and_scalars_have_none() {
    for v in &VARIABLES {
        let array = matches!(v.access, Access::Elements(_) | Access::Step(_));
        assert_eq!(!v.dimensions.is_empty(), array, "{}", v.name);
        assert_eq!(v.size(), v.dimensions.iter().product::<usize>(), "{}", v.name);
    }
}

/// Some hosts take value references for places in an extended description, so there must be no gap: what the clock needs
/// stands last. The description with the fewest variables may have gaps: a row that it has may stand behind rows it has not.
#[test]
fn invariant_extended_descriptions_have_no_gap() {
    for edition in [Edition::Extended, Edition::Clocked] {
        let places: Vec<u32> = of_edition(edition).map(|(place, _)| place).collect();
        assert!(places.iter().zip(0..).all(|(place, i)| *place == i), "{edition:?}");
    }
}

/// A getter reaches the variables of its edition and those before it, of its types.
#[test]
fn second_method_of_the_bits_of_classes() {
    let types = [Base::Real, Base::Integer, Base::Boolean, Base::Enumeration, Base::Clock];
    for (reached, wanted) in Edition::ALL.into_iter().flat_map(|e| types.map(|t| (e, t))) {
        let bases = Bases::new("some", &[wanted]).of(reached);
        for (edition, base) in Edition::ALL.into_iter().flat_map(|e| types.map(|t| (e, t))) {
            let expected = edition <= reached && base == wanted;
            assert_eq!(
                bases.contains(Class::new(base, edition)),
                expected,
                "{reached:?} {edition:?} {base:?}"
            );
        }
    }
}
