use super::*;

/// Every value reference that was ever used, with its variable. A line stays when the variable is
/// removed.
const GIVEN: &str = include_str!("../../../tests/data/value_references.txt");
/// Number of released lines, and their FNV-1a hash: a released reference is never used for another
/// variable.
const RELEASED: (usize, u128) = (92, 0xb5d6_d64b_7044_1ad2_49fd_53a5_0e67_b5ae);

/// A reference belongs to one name for ever: the list counts without a gap, its released part is
/// unchanged, and the table has each variable under the list's reference.
#[test]
fn golden_file_of_the_value_references() {
    let given: Vec<(u32, &str)> = GIVEN
        .lines()
        .map(|line| line.split_once(' ').and_then(|(r, name)| Some((r.parse().ok()?, name))).expect(line))
        .collect();
    for (i, (reference, name)) in (0..).zip(&given) {
        assert_eq!(*reference, i, "{name}: references count from 0 without a gap");
    }
    for variable in &VARIABLES {
        let Variable { reference, name, .. } = *variable;
        let listed = given.get(reference as usize).map(|(_, name)| *name);
        assert_eq!(
            listed,
            Some(name),
            "value reference {reference}: a new variable takes the next of the list"
        );
    }
    let released: String = GIVEN.split_inclusive('\n').take(RELEASED.0).collect();
    assert_eq!(fmi_doors::identifier::fnv1a(released.as_bytes()), RELEASED.1, "released lines never change");
}

/// The table can grow and shrink: if a row is inserted anywhere with the next reference of the
/// list, or removed, all others keep their references, and the numbers of a description that
/// counts its rows stay without a gap.
#[test]
fn invariant_value_references_stay_where_rows_are_put_in_or_taken_out() {
    /// More than any reference of a table with one more row.
    const LENGTH: usize = 256;
    let next = GIVEN.lines().count() as u32;
    assert!(VARIABLES.iter().all(|v| v.reference < next) && next as usize + 1 < LENGTH);
    let names = |table: &[Variable], places: [u16; LENGTH]| -> Vec<(u32, &str)> {
        let listed =
            |(reference, place): (u32, &u16)| Some((reference, table.get(usize::from(*place))?.name));
        (0..).zip(&places).filter_map(listed).collect()
    };
    for edition in Edition::ALL {
        let before = names(&VARIABLES, numbering::own(&VARIABLES, edition));
        for place in 0..=COUNT {
            let mut grown = VARIABLES.to_vec();
            let new = Variable { reference: next, name: "the.new", edition: Edition::Arrays, ..VARIABLES[0] };
            grown.insert(place, new);
            let mut expected = before.clone();
            if Edition::Arrays <= edition {
                expected.push((next, "the.new"));
            }
            assert_eq!(names(&grown, numbering::own(&grown, edition)), expected, "{edition:?}, row {place}");
            let counted = names(&grown, numbering::counted(&grown, edition));
            assert!(counted.iter().map(|(number, _)| *number).eq(1..=expected.len() as u32));
        }
        for (place, gone) in VARIABLES.iter().enumerate() {
            let mut shrunk = VARIABLES.to_vec();
            shrunk.remove(place);
            let mut expected = before.clone();
            expected.retain(|(reference, _)| *reference != gone.reference);
            assert_eq!(
                names(&shrunk, numbering::own(&shrunk, edition)),
                expected,
                "{edition:?}, {}",
                gone.name
            );
        }
    }
}

/// `fmu-build` checks names, attributes and units in the written model description.
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
        assert_eq!(find(field.name).unwrap().unit(), Some(field.unit));
    }
}

/// Exactly the outputs that change between events have a rate.
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

/// An array has the number of elements given by its dimensions, and only variables that are read
/// by element have dimensions.
#[test]
fn invariant_arrays_have_dimensions_and_scalars_have_none() {
    for v in &VARIABLES {
        let array = matches!(v.access, Access::Elements(_) | Access::Step(_));
        assert_eq!(!v.dimensions.is_empty(), array, "{}", v.name);
        assert_eq!(v.size(), v.dimensions.iter().product::<usize>(), "{}", v.name);
    }
}

/// Some hosts take value references for indices: a description that counts its variables has no
/// gap, wherever the variables of other descriptions are in the table. References and indices map
/// to each other in every numbering.
#[test]
fn invariant_numberings_are_one_to_one_and_the_counted_ones_have_no_gap() {
    for edition in Edition::ALL {
        let counted = Numbering::counted(edition);
        let names: Vec<_> = of_edition(edition).map(|(_, variable)| variable.name).collect();
        let numbered: Vec<_> =
            (1..).map_while(|r| counted.variable(r)).map(|variable| variable.name).collect();
        assert_eq!(numbered, names, "{edition:?}");
        assert_eq!(counted.range(), (1, names.len() as u32), "{edition:?}");
    }
    for numbering in [Numbering::ALL, Numbering::EVERY, Numbering::counted(Edition::Clocked)] {
        for (reference, variable) in numbering.variables() {
            assert_eq!(numbering.variable(reference).map(|v| v.name), Some(variable.name));
            assert_eq!(numbering.reference(place(variable.name)), Some(reference));
        }
        assert!(numbering.variable(u32::MAX).is_none());
    }
    let own = Numbering::EVERY.variables().all(|(reference, variable)| reference == variable.reference);
    assert!(own && Numbering::EVERY.variables().count() == of_edition(Edition::Every).count());
}
