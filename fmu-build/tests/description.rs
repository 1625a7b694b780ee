//! The model descriptions: committed files are up to date and valid, and each of our own checks
//! detects its error.

use fmi_doors::Version::{self, Fmi2, Fmi3};
use fmu_build::check::{problems, problems_of};
use fmu_build::compile::workspace;
use fmu_build::version::Version as Archive;
use fmu_build::xml::Element;
use fmu_build::{licences, package, terminals};
use vibro_paper_component::component::structure::{INDICATORS, STATES};
use vibro_paper_component::fmi3::description::instantiation_token;

#[test]
fn committed_files_are_what_is_generated() {
    let described = package::described().unwrap();
    for (name, bytes) in package::committed().unwrap() {
        let committed = std::fs::read(workspace().join(&name)).unwrap_or_default();
        let option = if described.contains_key(&name) { " --description" } else { "" };
        assert!(committed == bytes, "{name} is stale: run `cargo run --bin fmu-build -- refresh{option}`");
    }
}

/// The description of an archive, after all checks have passed.
fn model(archive: Archive) -> Element {
    Element::parse(&archive.description(None).unwrap()).unwrap()
}

#[test]
fn each_description_is_valid_and_has_the_token_of_its_edition() {
    for archive in Archive::ALL {
        let model = model(archive);
        assert_eq!(problems_of(&model, archive.fmi()), [""; 0]);
        if let Some(edition) = archive.edition() {
            assert_eq!(model.attribute("instantiationToken"), Some(&*instantiation_token(edition)));
        }
    }
}

#[test]
fn text_that_is_no_description_is_an_error() {
    for version in [Fmi2, Fmi3] {
        let number = if version == Fmi2 { "2.0" } else { "3.0" };
        let empty = problems(&format!("<fmiModelDescription fmiVersion=\"{number}\"/>"), version).unwrap();
        assert!(empty.contains(&"fmiModelDescription has not one ModelVariables".to_owned()), "{empty:?}");
        for text in ["not XML", "<fmiModelDescription>", "<a></b>", ""] {
            assert!(problems(text, version).is_err(), "{text}");
        }
    }
}

/// The children of the first element of that name.
fn within<'a>(of: &'a mut Element, name: &str) -> &'a mut Vec<Element> {
    &mut of.children.iter_mut().find(|child| child.name == name).unwrap().children
}

fn named<'a>(list: &'a mut [Element], name: &str) -> &'a mut Element {
    list.iter_mut().find(|element| element.attribute("name") == Some(name)).unwrap()
}

fn variable<'a>(model: &'a mut Element, name: &str) -> &'a mut Element {
    named(within(model, "ModelVariables"), name)
}

/// Sets an attribute of a variable; in FMI 2.0 a child element has the attributes of its type.
fn set(model: &mut Element, name: &str, attribute: &str, value: &str) {
    let variable = variable(model, name);
    let place = match variable.children.first_mut() {
        Some(of_type) if !variable.attributes.contains_key(attribute) && of_type.name != "Alias" => of_type,
        _ => variable,
    };
    place.attributes.insert(attribute.into(), value.into());
}

/// The value reference of a variable in this description, which may change with every row of the
/// table.
fn reference(model: &mut Element, name: &str) -> String {
    variable(model, name).attribute("valueReference").unwrap().to_owned()
}

fn put(element: &mut Element, attribute: &str, value: &str) {
    element.attributes.insert(attribute.into(), value.into());
}

/// The first element of a list, or of its elements' children, that has an attribute with a value.
fn with<'a>(list: &'a mut [Element], attribute: &str, is: impl Fn(&str) -> bool) -> &'a mut Element {
    list.iter_mut().find(|element| element.attribute(attribute).is_some_and(&is)).unwrap()
}

fn structure<'a>(model: &'a mut Element, list: &str) -> &'a mut Vec<Element> {
    within(model.children.iter_mut().find(|child| child.name == "ModelStructure").unwrap(), list)
}

/// A row of a list in the structure of FMI 3.0.
fn row<'a>(model: &'a mut Element, list: &str, place: usize) -> &'a mut Element {
    within(model, "ModelStructure").iter_mut().filter(|row| row.name == list).nth(place).unwrap()
}

type Damage = fn(&mut Element);

/// Damages that each check must detect, each with a word of its message.
const DAMAGES: [(Version, &str, Damage); 72] = [
    (Fmi2, "fmiVersion", |m| put(m, "fmiVersion", "3.0")),
    (Fmi2, "guid is empty", |m| put(m, "guid", "")),
    (Fmi2, "without author", |m| drop(m.attributes.remove("author"))),
    (Fmi2, "modelIdentifier", |m| {
        put(m.children.iter_mut().find(|c| c.name == "CoSimulation").unwrap(), "modelIdentifier", "3DOF");
    }),
    (Fmi2, "numberOfEventIndicators", |m| drop(m.attributes.remove("numberOfEventIndicators"))),
    (Fmi2, "DefaultExperiment", |m| {
        put(m.children.iter_mut().find(|c| c.name == "DefaultExperiment").unwrap(), "stopTime", "-1");
    }),
    (Fmi2, "log category", |m| {
        let categories = within(m, "LogCategories");
        categories.push(categories[0].clone());
    }),
    (Fmi2, "unit kg", |m| within(m, "UnitDefinitions").retain(|unit| unit.attribute("name") != Some("kg"))),
    (Fmi2, "display unit mm", |m| {
        within(m, "UnitDefinitions")
            .iter_mut()
            .for_each(|unit| unit.children.retain(|c| c.name == "BaseUnit"));
    }),
    (Fmi2, "box.m is defined twice", |m| set(m, "box.k", "name", "box.m")),
    (Fmi2, "value reference 1 is defined twice", |m| set(m, "box.k", "valueReference", "1")),
    (Fmi2, "no description", |m| set(m, "box.k", "description", "")),
    (Fmi2, "start 1.5 is outside", |m| set(m, "stop.restitution", "start", "1.5")),
    (Fmi2, "above max", |m| set(m, "stop.restitution", "min", "2")),
    (Fmi2, "nominal is not positive", |m| set(m, "box.s", "nominal", "0")),
    (Fmi2, "declared type Some(\"Weight\")", |m| set(m, "box.m", "declaredType", "Weight")),
    (Fmi2, "start inf is outside", |m| set(m, "drive.phase", "start", "inf")),
    (Fmi2, "min is not a number", |m| set(m, "stop.restitution", "min", "low")),
    (Fmi2, "factor -1 is not positive", |m| {
        let units = within(m, "UnitDefinitions").iter_mut();
        let mut displays = units.flat_map(|unit| &mut unit.children).filter(|c| c.name == "DisplayUnit");
        put(displays.next().unwrap(), "factor", "-1");
    }),
    (Fmi2, "is not a structured name", |m| set(m, "box.k", "name", "box..k")),
    (Fmi2, "items of Mode share a value", |m| {
        let mode = named(within(m, "TypeDefinitions"), "Mode");
        put(&mut within(mode, "Enumeration")[1], "value", "1");
    }),
    (Fmi2, "start -1 is outside", |m| set(m, "impacts.upper", "start", "-1")),
    (Fmi2, "reinit belongs", |m| set(m, "stop.s", "reinit", "true")),
    (Fmi2, "another variable is the derivative", |m| set(m, "block.v", "derivative", "21")),
    (Fmi2, "dependencies of", |m| {
        put(with(structure(m, "Outputs"), "dependenciesKind", |_| true), "dependenciesKind", "linear");
    }),
    (Fmi2, "dependencies of", |m| {
        put(with(structure(m, "Outputs"), "dependencies", |_| true), "dependencies", "999");
    }),
    (Fmi2, "not an item of Mode", |m| set(m, "mode", "start", "9")),
    (Fmi2, "do not go together", |m| set(m, "box.m", "initial", "calculated")),
    (Fmi2, "a start value belongs", |m| drop(variable(m, "box.m").children[0].attributes.remove("start"))),
    (Fmi2, "only a Real", |m| set(m, "impacts.upper", "variability", "continuous")),
    (Fmi2, "independent", |m| {
        within(m, "ModelVariables").retain(|v| v.attribute("causality") != Some("independent"));
    }),
    (Fmi2, "derivative = 999", |m| set(m, "box.a", "derivative", "999")),
    (Fmi2, "is missing from Outputs", |m| drop(structure(m, "Outputs").pop())),
    (Fmi2, "does not belong in Derivatives", |m| put(&mut structure(m, "Derivatives")[0], "index", "1")),
    (Fmi2, "names a variable twice", |m| {
        let outputs = structure(m, "Outputs");
        outputs.push(outputs[0].clone());
    }),
    (Fmi2, "dependencies of", |m| {
        put(with(structure(m, "Outputs"), "dependencies", |_| true), "dependencies", "5 4");
    }),
    (Fmi2, "InitialUnknowns: dependencies of", |m| {
        let initial = structure(m, "InitialUnknowns");
        let unknown = with(initial, "dependenciesKind", |kinds| kinds == "dependent dependent");
        put(unknown, "dependenciesKind", "fixed fixed");
    }),
    (Fmi3, "is not a variable", |m| within(m, "ModelVariables")[3].name = "Float63".into()),
    (Fmi3, "fmiVersion", |m| put(m, "fmiVersion", "3.0.2")),
    (Fmi3, "instantiationToken is empty", |m| put(m, "instantiationToken", "")),
    (Fmi3, "modelIdentifier", |m| {
        put(m.children.iter_mut().find(|c| c.name == "ModelExchange").unwrap(), "modelIdentifier", "3DOF");
    }),
    (Fmi3, "DefaultExperiment", |m| {
        put(m.children.iter_mut().find(|c| c.name == "DefaultExperiment").unwrap(), "tolerance", "0");
    }),
    (Fmi3, "does not divide", |m| {
        put(m.children.iter_mut().find(|c| c.name == "DefaultExperiment").unwrap(), "stepSize", "0.1");
    }),
    (Fmi3, "m1 is defined twice", |m| set(m, "box.k", "name", "m1")),
    (Fmi3, "is not a structured name", |m| set(m, "box.k", "name", "der(box")),
    (Fmi3, "has value reference", |m| {
        let taken = reference(m, "box.m");
        set(m, "box.k", "valueReference", &taken);
    }),
    (Fmi3, "has no description", |m| set(m, "box.k", "description", "")),
    (Fmi3, "is not a defined type", |m| drop(variable(m, "mode").attributes.remove("declaredType"))),
    (Fmi3, "is not a defined type", |m| set(m, "impacts.clock", "declaredType", "Time")),
    (Fmi3, "belong to its declared type", |m| set(m, "box.m", "unit", "m")),
    (Fmi3, "unit kg of", |m| {
        within(m, "UnitDefinitions").retain(|unit| unit.attribute("name") != Some("kg"))
    }),
    (Fmi3, "do not go together", |m| set(m, "box.f", "initial", "exact")),
    (Fmi3, "do not go together", |m| set(m, "impacts.clock", "intervalVariability", "countdown")),
    (Fmi3, "only a Real", |m| set(m, "impacts.upper", "variability", "continuous")),
    (Fmi3, "a start value belongs", |m| put(variable(m, "motion.s"), "start", "0 0 0")),
    (Fmi3, "start 2 is outside", |m| set(m, "stop.restitution", "start", "2")),
    (Fmi3, "start yes is outside", |m| set(m, "startOnOrbit", "start", "yes")),
    (Fmi3, "nominal is not positive", |m| put(variable(m, "box.s"), "nominal", "-1")),
    (Fmi3, "expected local arrays", |m| {
        let array = variable(m, "motion.s").children.clone();
        variable(m, "box.a").children = array;
    }),
    (Fmi3, "expected local arrays", |m| put(&mut variable(m, "motion.s").children[0], "start", "0")),
    (Fmi3, "intermediateUpdate", |m| set(m, "impacts.lastTime", "intermediateUpdate", "true")),
    (Fmi3, "aliases are for what is set", |m| {
        let aliases = variable(m, "box.s").children.split_off(0);
        variable(m, "stop.s").children = aliases;
    }),
    (Fmi3, "expected clocks", |m| {
        let time = reference(m, "time");
        set(m, "impacts.clocked.time", "clocks", &time);
    }),
    (Fmi3, "is not another Real variable", |m| {
        let side = reference(m, "impacts.clocked.side");
        set(m, "box.a", "derivative", &side);
    }),
    (Fmi3, "is not a state", |m| {
        let derivative = reference(m, "block.a");
        set(m, "box.a", "derivative", &derivative);
    }),
    (Fmi3, "another variable is the derivative", |m| {
        let state = reference(m, "box.v");
        set(m, "block.a", "derivative", &state);
    }),
    (Fmi3, "reinit belongs", |m| set(m, "stop.s", "reinit", "true")),
    (Fmi3, "is missing from Output", |m| {
        let last = within(m, "ModelStructure").iter().rposition(|row| row.name == "Output").unwrap();
        within(m, "ModelStructure").remove(last);
    }),
    (Fmi3, "does not belong in ContinuousStateDerivative", |m| {
        let state = reference(m, "box.v");
        put(row(m, "ContinuousStateDerivative", 0), "valueReference", &state);
    }),
    (Fmi3, "dependencies of", |m| drop(row(m, "Output", 2).attributes.remove("dependencies"))),
    (Fmi3, "InitialUnknown: dependencies of", |m| {
        // A fixed factor is known only after initialization.
        let ratio = reference(m, "groups.epsilon");
        let mut rows = within(m, "ModelStructure").iter_mut().filter(|row| row.name == "InitialUnknown");
        let row = rows.find(|row| row.attribute("valueReference") == Some(&*ratio)).unwrap();
        put(row, "dependenciesKind", "fixed fixed");
    }),
    (Fmi3, "expected continuous locals", |m| {
        let mode = reference(m, "mode");
        put(row(m, "EventIndicator", 0), "valueReference", &mode);
    }),
];

#[test]
fn every_check_notices_its_damage() {
    for (version, word, damage) in DAMAGES {
        let mut model = model(if version == Fmi2 { Archive::Fmi2 } else { Archive::Clocked });
        damage(&mut model);
        let found = problems_of(&model, version);
        assert!(found.iter().any(|problem| problem.contains(word)), "{word}: {found:?}");
    }
}

/// The order of ContinuousStateDerivative (FMI 3.0.2, 2.4.8) is the order of the states in
/// `fmi3GetContinuousStates`; indicators have the order of `fmi3GetEventIndicators`.
#[test]
fn states_and_indicators_are_listed_in_the_order_of_their_functions() {
    let model = model(Archive::Fmi3);
    let variable = |reference: &str| &model.within("ModelVariables")[reference.parse::<usize>().unwrap() - 1];
    let rows = |list: &str| -> Vec<&Element> {
        let rows = model.within("ModelStructure").iter().filter(|row| row.name == list);
        rows.map(|row| variable(row.attribute("valueReference").unwrap())).collect()
    };
    let name = |v: &Element| v.attribute("name").unwrap().to_owned();
    let state = |v: &&Element| name(variable(v.attribute("derivative").unwrap()));
    let states: Vec<_> = rows("ContinuousStateDerivative").iter().map(state).collect();
    assert_eq!(states, STATES);
    let indicators: Vec<_> = rows("EventIndicator").into_iter().map(name).collect();
    assert_eq!(indicators, INDICATORS);
}

/// Features that only other descriptions have, not the main one: several importers treat every
/// local variable as a scalar, and fail on clocks.
#[test]
fn arrays_and_the_clock_are_in_descriptions_of_their_own() {
    let models = [Archive::Fmi3, Archive::Arrays, Archive::Clocked].map(model);
    let row = |v: &Element| (v.attribute("name").unwrap().to_owned(), v.all("Dimension").count() > 0);
    let rows = |model: &Element| model.within("ModelVariables").iter().map(row).collect::<Vec<_>>();
    let [main, arrays, clocked] = models.each_ref().map(rows);
    assert!(main.iter().all(|(_, array)| !array), "{main:?}");
    let beyond = |more: &[(String, bool)], less: &[(String, bool)]| -> Vec<String> {
        assert!(less.iter().all(|row| more.contains(row)));
        more.iter().filter(|row| !less.contains(row)).map(|row| row.0.clone()).collect()
    };
    assert_eq!(
        beyond(&arrays, &main),
        ["motion.s", "motion.v", "motion.a", "step.transition", "step.response"]
    );
    let clock = beyond(&clocked, &arrays);
    assert!(clock.len() == 5 && clock.iter().all(|name| name.starts_with("impacts.clock")), "{clock:?}");
    let same = models.each_ref().map(|model| model.attribute("instantiationToken"));
    assert!(same[0] != same[1] && same[1] != same[2] && same[0] != same[2]);
    let has_side =
        |model: &Element| model.within("TypeDefinitions").iter().any(|t| t.attribute("name") == Some("Side"));
    assert!(!has_side(&models[0]) && has_side(&models[2]));
}

/// Three bodies with displacement, velocity, acceleration and force, all of which can be
/// connected.
#[test]
fn every_member_of_a_terminal_exists() {
    let xml = terminals::xml();
    assert_eq!(terminals::members().len(), 12);
    for member in terminals::members() {
        assert!(xml.contains(&format!("variableName=\"{}\"", member.name)), "{}", member.name);
    }
    assert_eq!(xml.matches("<TerminalMemberVariable").count(), 12);
}

/// Compared with cargo's list of the library's dependencies; no crate without its text.
#[test]
fn licences_of_what_is_linked_are_packed() {
    // Its package contains no text; the text is pulp's, by the same author under the same licence.
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
    // Used only at compile time.
    assert!(!content.keys().any(|name| name.contains("syn-")));
    assert!(list.contains("The Rust standard library"));
    // No text of the GPL without the exception that applies to linked code, in the same file and
    // before the text.
    for (name, text) in &content {
        let text = String::from_utf8_lossy(text);
        if let Some(gpl) = text.find("GNU GENERAL PUBLIC LICENSE") {
            let exception =
                text.find("GCC RUNTIME LIBRARY EXCEPTION").or(text.find("GCC Runtime Library Exception"));
            assert!(name.contains("WITH-GCC-exception") && exception.is_some_and(|at| at < gpl), "{name}");
        }
    }
}
