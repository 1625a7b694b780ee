//! The model description: committed file up to date, valid, and every own check notices what it is there for.

use fmu_build::check::{problems, problems_of};
use fmu_build::compile::workspace;
use fmu_build::describe::{from_xml, model_description, to_xml};
use fmu_build::schema::{ModelDescription, Real, ScalarVariable, SimpleKind, VariableKind};
use fmu_build::{licences, package};

#[test]
fn committed_files_are_what_is_generated() {
    let described = package::described().unwrap();
    for (name, bytes) in package::committed().unwrap() {
        let committed = std::fs::read(workspace().join(&name)).unwrap_or_default();
        let option = if described.contains_key(&name) { " --description" } else { "" };
        assert!(committed == bytes, "{name} is stale: run `cargo run --bin fmu-build -- refresh{option}`");
    }
}

#[test]
fn text_and_structs_say_the_same() {
    let model = model_description().unwrap();
    let text = to_xml(&model).unwrap();
    assert_eq!(from_xml(&text).unwrap(), model);
    assert_eq!(problems(&text).unwrap(), [""; 0]);
}

#[test]
fn text_that_is_no_description_is_an_error() {
    assert!(problems("<fmiModelDescription fmiVersion=\"2.0\"/>").is_err());
    assert!(problems("not XML").is_err());
}

fn named<'a>(model: &'a mut ModelDescription, name: &str) -> &'a mut ScalarVariable {
    model.model_variables.variables.iter_mut().find(|v| v.name == name).unwrap()
}

fn real<'a>(model: &'a mut ModelDescription, name: &str) -> &'a mut Real {
    match &mut named(model, name).kind {
        VariableKind::Real(real) => real,
        _ => panic!("{name} is a Real"),
    }
}

type Damage = fn(&mut ModelDescription);

/// What each check must notice, and a word of its message.
const DAMAGES: [(&str, Damage); 34] = [
    ("fmiVersion", |m| m.fmi_version = "3.0".into()),
    ("guid", |m| m.guid.clear()),
    ("modelIdentifier", |m| m.co_simulation.model_identifier = "3DOF".into()),
    ("numberOfEventIndicators", |m| {
        m.number_of_event_indicators = if m.number_of_event_indicators.is_some() { None } else { Some(1) };
    }),
    ("DefaultExperiment", |m| m.default_experiment.stop = -1.0),
    ("log category", |m| m.log_categories.categories.push(m.log_categories.categories[0].clone())),
    ("unit kg", |m| m.unit_definitions.units.retain(|unit| unit.name != "kg")),
    ("display unit mm", |m| m.unit_definitions.units.iter_mut().for_each(|unit| unit.display.clear())),
    ("box.m is defined twice", |m| named(m, "box.k").name = "box.m".into()),
    ("share value reference", |m| named(m, "box.k").value_reference = 1),
    ("no description", |m| named(m, "box.k").description.clear()),
    ("outside", |m| real(m, "stop.restitution").start = Some(1.5)),
    ("above max", |m| real(m, "stop.restitution").min = Some(2.0)),
    ("nominal", |m| real(m, "box.s").nominal = Some(0.0)),
    ("declared type Weight", |m| real(m, "box.m").declared_type = "Weight".into()),
    ("start inf is outside", |m| real(m, "drive.phase").start = Some(f64::INFINITY)),
    ("factor -1 is not positive", |m| m.unit_definitions.units[0].display[0].factor = -1.0),
    ("is not a structured name", |m| named(m, "box.k").name = "box..k".into()),
    ("items of Mode share a value", |m| {
        for kind in m.type_definitions.types.iter_mut().map(|t| &mut t.kind) {
            if let SimpleKind::Enumeration(mode) = kind {
                mode.items[1].value = 1;
            }
        }
    }),
    ("is below min", |m| {
        if let VariableKind::Integer(count) = &mut named(m, "impacts.upper").kind {
            count.start = Some(-1);
        }
    }),
    ("reinit belongs", |m| real(m, "stop.s").reinit = Some(true)),
    ("the derivative of one", |m| real(m, "block.v").derivative = Some(21)),
    ("dependencies of", |m| {
        let unknown = m.model_structure.outputs.unknowns.iter_mut().find(|u| u.kinds.is_some());
        unknown.unwrap().kinds = Some("linear".into());
    }),
    ("dependencies of", |m| {
        let unknown = m.model_structure.outputs.unknowns.iter_mut().find(|u| u.dependencies.is_some());
        unknown.unwrap().dependencies = Some("999".into());
    }),
    ("no item of Mode", |m| {
        if let VariableKind::Enumeration(mode) = &mut named(m, "mode").kind {
            mode.start = Some(9);
        }
    }),
    ("do not go together", |m| named(m, "box.m").initial = Some("calculated".into())),
    ("a start value belongs", |m| real(m, "box.m").start = None),
    ("only a Real", |m| named(m, "impacts.upper").variability = "continuous".into()),
    ("independent", |m| m.model_variables.variables.retain(|v| v.causality != "independent")),
    ("derivative = 999", |m| real(m, "box.a").derivative = Some(999)),
    ("is missing from ModelStructure/Outputs", |m| drop(m.model_structure.outputs.unknowns.pop())),
    ("does not belong in ModelStructure/Derivatives", |m| {
        m.model_structure.derivatives.unknowns[0].index = 1;
    }),
    ("dependencies of", |m| {
        let unknown = m.model_structure.outputs.unknowns.iter_mut().find(|u| u.dependencies.is_some());
        unknown.unwrap().dependencies = Some("5 4".into());
    }),
    ("ModelStructure/InitialUnknowns: dependencies of", |m| {
        let unknowns = &mut m.model_structure.initial_unknowns.unknowns;
        let unknown = unknowns.iter_mut().find(|u| u.kinds.as_deref() == Some("dependent dependent"));
        unknown.unwrap().kinds = Some("fixed fixed".into());
    }),
];

#[test]
fn every_check_notices_its_damage() {
    for (word, damage) in DAMAGES {
        let mut model = model_description().unwrap();
        damage(&mut model);
        let found = problems_of(&model);
        assert!(found.iter().any(|problem| problem.contains(word)), "{word}: {found:?}");
    }
}

/// Against what cargo itself says of the library's dependencies, and no crate without its text.
#[test]
fn licences_of_what_is_linked_are_packed() {
    // Its package holds no text; it is pulp's, by the same author under the same licence.
    const WITHOUT_TEXT: [&str; 1] = ["pulp-wasm-simd-flag"];
    let content = licences::texts(false).unwrap();
    let list = String::from_utf8(content[licences::LIST].clone()).unwrap();
    let crates: Vec<(&str, &str)> = list
        .lines()
        .filter_map(|line| line.split_once(": ")?.0.split_once(' '))
        .filter(|(_, version)| version.starts_with(|c: char| c.is_ascii_digit()))
        .collect();
    for name in ["nalgebra", "pulp", "serde", "thiserror"] {
        assert!(crates.iter().any(|(found, _)| *found == name), "{name}: {list}");
    }
    for (name, version) in crates {
        let folder = format!("{name}-{version}/");
        let has_text = content.keys().any(|path| path.starts_with(&folder));
        assert_eq!(has_text, !WITHOUT_TEXT.contains(&name), "{name}");
    }
    // Runs while compiling only.
    assert!(!content.keys().any(|name| name.contains("syn-")));
    assert!(list.contains("The Rust standard library"));
    // No text of the GPL without the exception that makes it the licence of linked code, in the same file and before it.
    for (name, text) in &content {
        let text = String::from_utf8_lossy(text);
        if let Some(gpl) = text.find("GNU GENERAL PUBLIC LICENSE") {
            let exception =
                text.find("GCC RUNTIME LIBRARY EXCEPTION").or(text.find("GCC Runtime Library Exception"));
            assert!(name.contains("WITH-GCC-exception") && exception.is_some_and(|at| at < gpl), "{name}");
        }
    }
}
