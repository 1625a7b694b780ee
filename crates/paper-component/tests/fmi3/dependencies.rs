//! `fmi3GetVariableDependencies` (FMI 3.0.2, 2.2.9).

use super::derivatives::{CONTACTS, INPUTS, forward, in_event_mode};
use super::host::*;
use vibro_paper_component::component::variables::VARIABLES;
use vibro_paper_component::fmi3::abi::*;
use vibro_paper_component::fmi3::description;

/// The result of `fmi3GetVariableDependencies`: element, name, kind.
fn dependencies(fmu: &Fmu, name: &str) -> Vec<(usize, &'static str, i32)> {
    let mut count = 99;
    // SAFETY: one of each.
    assert_eq!(
        unsafe { fmi3GetNumberOfVariableDependencies(fmu.c, fmu.vr(name), &mut count) },
        OK,
        "{}",
        fmu.last()
    );
    let (mut elements, mut references, mut others, mut kinds) =
        (vec![9; count], vec![0; count], vec![9; count], vec![9; count]);
    // SAFETY: the stated number of elements.
    let status = unsafe {
        fmi3GetVariableDependencies(
            fmu.c,
            fmu.vr(name),
            elements.as_mut_ptr(),
            references.as_mut_ptr(),
            others.as_mut_ptr(),
            kinds.as_mut_ptr(),
            count,
        )
    };
    assert_eq!(status, OK, "{}", fmu.last());
    assert!(others.iter().all(|element| *element == 0) && kinds.iter().all(|kind| (1..6).contains(kind)));
    let names = references.iter().map(|r| description::numbering(fmu.edition).variable(*r).unwrap().name);
    elements.into_iter().zip(names).zip(kinds).map(|((element, name), kind)| (element, name, kind)).collect()
}

/// Compared with the derivatives: if a variable does not depend on another in this contact, the
/// derivative is 0; if it does, the derivative at this generic point is not 0.
#[test]
fn second_method_dependencies_of_the_present_contact() {
    for (i, start) in CONTACTS.into_iter().enumerate() {
        let fmu = in_event_mode(start, true);
        let checked =
            ["box.a", "block.a", "secondary.a", "stop.s", "stop.v", "stop.force", "coupling.f", "der(box.s)"];
        for unknown in checked {
            let listed: Vec<&str> = dependencies(&fmu, unknown).into_iter().map(|entry| entry.1).collect();
            for known in MOTION.into_iter().chain(INPUTS).chain([
                "time",
                "box.k",
                "box.c",
                "coupling.k",
                "drive.amplitude",
            ]) {
                let derivative = forward(&fmu, &[unknown], &[known], &[1.0])[0];
                assert_eq!(
                    derivative != 0.0,
                    listed.contains(&known),
                    "{unknown} on {known} in contact {i}: {derivative}"
                );
            }
        }
        let on_load = dependencies(&fmu, "box.a").iter().any(|entry| entry.1 == "block.f");
        assert_eq!(on_load, i > 0);
    }
}

#[test]
fn dependencies_of_arrays_parameters_and_in_initialization() {
    let fmu = Fmu::arrays(TT).start(FF, CONTACTS[0]);
    let places = dependencies(&fmu, "motion.s");
    let expected = ["box.s", "block.s", "secondary.s"];
    assert_eq!(places.len(), 3);
    for (i, name) in expected.iter().enumerate() {
        assert!(places.iter().any(|entry| (entry.0, entry.1) == (i + 1, *name)), "{places:?}");
    }
    let accelerations = dependencies(&fmu, "motion.a");
    assert!(accelerations.iter().any(|entry| (entry.0, entry.1) == (3, "secondary.f")));
    assert!(!accelerations.iter().any(|entry| (entry.0, entry.1) == (1, "secondary.f")));
    assert!(dependencies(&fmu, "box.m").is_empty() && dependencies(&fmu, "box.f").is_empty());
    // Within the declared dependencies.
    for (_, variable) in description::variables(description::ARRAYS) {
        let listed = dependencies(&fmu, variable.name);
        let declared = vibro_paper_component::component::structure::outputs(description::ARRAYS);
        let of = |unknown: &&vibro_paper_component::component::structure::Unknown| {
            VARIABLES[unknown.place].name == variable.name
        };
        if let Some(unknown) = declared.iter().find(of) {
            for entry in listed {
                assert!(unknown.dependencies.iter().any(|(place, _)| VARIABLES[*place].name == entry.1));
            }
        }
    }
    let fmu = Fmu::exchange();
    let initial = dependencies(&fmu, "box.a");
    assert!(
        initial.iter().any(|entry| entry.1 == "box.s")
            && initial.iter().all(|entry| entry.2 == 5 || entry.2 == 1)
    );
    let mut count = 0;
    // SAFETY: one of each.
    assert_eq!(unsafe { fmi3GetNumberOfVariableDependencies(fmu.c, 9999, &mut count) }, ERROR);
}
