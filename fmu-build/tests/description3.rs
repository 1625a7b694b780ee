//! The model descriptions of FMI 3.0: valid, and every own check notices what it is there for.

use fmu_build::describe::to_xml;
use fmu_build::fmi3::check::{problems, problems_of};
use fmu_build::fmi3::schema::{Attributes, Dimension, ModelDescription, Type, Variable};
use fmu_build::fmi3::{from_xml, model_description};
use fmu_build::terminals;
use vibro_fmi::component::structure::{INDICATORS, STATES};
use vibro_fmi::fmi3::description::{ARRAYS, CLOCKED, Edition, MAIN, instantiation_token};

#[test]
fn text_and_structs_say_the_same() {
    for edition in [MAIN, ARRAYS, CLOCKED] {
        let model = model_description(edition).unwrap();
        let text = to_xml(&model).unwrap();
        assert_eq!(from_xml(&text).unwrap(), model);
        assert_eq!(problems(&text).unwrap(), [""; 0]);
        assert_eq!(model.instantiation_token, instantiation_token(edition));
    }
    assert!(problems("<fmiModelDescription fmiVersion=\"3.0\"/>").is_err());
}

fn named<'a>(model: &'a mut ModelDescription, name: &str) -> &'a mut Attributes {
    let variables = model.model_variables.variables.iter_mut().map(Variable::attributes_mut);
    variables.into_iter().find(|v| v.name == name).unwrap()
}

/// The value reference of a variable in this description: it may change with every row of the table.
fn reference(model: &mut ModelDescription, name: &str) -> u32 {
    named(model, name).value_reference
}

type Damage = fn(&mut ModelDescription);

/// What each check must notice, and a word of its message.
const DAMAGES: [(&str, Damage); 33] = [
    ("fmiVersion", |m| m.fmi_version = "3.0.2".into()),
    ("instantiationToken", |m| m.instantiation_token.clear()),
    ("modelIdentifier", |m| m.model_exchange.model_identifier = "3DOF".into()),
    ("DefaultExperiment", |m| m.default_experiment.tolerance = 0.0),
    ("does not divide", |m| m.default_experiment.step = 0.1),
    ("m1 is defined twice", |m| named(m, "box.k").name = "m1".into()),
    ("is not a structured name", |m| named(m, "box.k").name = "der(box".into()),
    ("has value reference", |m| named(m, "box.k").value_reference = reference(m, "box.m")),
    ("has no description", |m| named(m, "box.k").description.clear()),
    ("is not a defined type", |m| named(m, "mode").declared_type = None),
    ("is not a defined type", |m| named(m, "impacts.clock").declared_type = Some("Time".into())),
    ("left to its declared type", |m| named(m, "box.m").unit = Some("m".into())),
    ("unit kg or display unit", |m| m.unit_definitions.units.retain(|unit| unit.name != "kg")),
    ("do not go together", |m| named(m, "box.f").initial = Some("exact".into())),
    ("do not go together", |m| named(m, "impacts.clock").interval_variability = Some("countdown".into())),
    ("only a Float64", |m| named(m, "impacts.upper").variability = "continuous".into()),
    ("a start value belongs", |m| named(m, "motion.s").start = Some("0 0 0".into())),
    ("start 2 is outside", |m| named(m, "stop.restitution").start = Some("2".into())),
    ("start yes is outside", |m| named(m, "startOnOrbit").start = Some("yes".into())),
    ("nominal is not positive", |m| named(m, "box.s").nominal = Some(-1.0)),
    ("allowed are local arrays", |m| named(m, "box.a").dimensions = vec![Dimension { start: 3 }]),
    ("allowed are local arrays", |m| named(m, "motion.s").dimensions[0].start = 0),
    ("intermediateUpdate", |m| named(m, "impacts.lastTime").intermediate_update = Some(true)),
    ("aliases are for what is set", |m| {
        let aliases = named(m, "box.s").aliases.split_off(0);
        named(m, "stop.s").aliases = aliases;
    }),
    ("allowed are clocks", |m| {
        named(m, "impacts.clocked.time").clocks = Some(reference(m, "time").to_string());
    }),
    ("is no state", |m| named(m, "box.a").derivative = Some(reference(m, "impacts.clocked.side"))),
    ("another variable is the derivative", |m| {
        named(m, "block.a").derivative = Some(reference(m, "box.v"));
    }),
    ("reinit belongs", |m| named(m, "stop.s").reinit = Some(true)),
    ("is missing from Output", |m| drop(m.model_structure.outputs.pop())),
    ("does not belong in ContinuousStateDerivative", |m| {
        m.model_structure.derivatives[0].value_reference = reference(m, "box.v");
    }),
    ("dependencies of", |m| m.model_structure.outputs[2].dependencies = None),
    ("InitialUnknown: dependencies of", |m| {
        // A factor that is fixed is known only after initialization.
        let ratio = reference(m, "groups.epsilon");
        let unknown = m.model_structure.initial_unknowns.iter_mut().find(|u| u.value_reference == ratio);
        unknown.unwrap().kinds = Some("fixed fixed".into());
    }),
    ("allowed are continuous locals", |m| {
        m.model_structure.event_indicators[0].value_reference = reference(m, "mode");
    }),
];

#[test]
fn every_check_notices_its_damage() {
    for (word, damage) in DAMAGES {
        let mut model = model_description(CLOCKED).unwrap();
        damage(&mut model);
        let found = problems_of(&model);
        assert!(found.iter().any(|problem| problem.contains(word)), "{word}: {found:?}");
    }
}

/// The order of ContinuousStateDerivative is that of the states in `fmi3GetContinuousStates` (FMI 3.0.2, 2.4.8), and the
/// indicators' that of `fmi3GetEventIndicators`.
#[test]
fn states_and_indicators_are_listed_in_the_order_of_their_functions() {
    let model = model_description(MAIN).unwrap();
    let attributes = |reference: u32| model.model_variables.variables[reference as usize - 1].attributes();
    let states =
        model.model_structure.derivatives.iter().map(|u| attributes(u.value_reference).derivative.unwrap());
    let names: Vec<&str> = states.map(|state| attributes(state).name.as_str()).collect();
    assert_eq!(names, STATES);
    let indicators =
        model.model_structure.event_indicators.iter().map(|u| attributes(u.value_reference).name.as_str());
    assert_eq!(indicators.collect::<Vec<_>>(), INDICATORS);
}

fn names(model: &ModelDescription) -> Vec<(String, bool)> {
    let attributes = model.model_variables.variables.iter().map(Variable::attributes);
    attributes.map(|a| (a.name.clone(), !a.dimensions.is_empty())).collect()
}

/// What the main description has not, and another one has: several importers take every local variable for a scalar, and
/// break on clocks.
#[test]
fn arrays_and_the_clock_are_in_descriptions_of_their_own() {
    let model = |edition: Edition| model_description(edition).unwrap();
    let [main, arrays, clocked] = [MAIN, ARRAYS, CLOCKED].map(|edition| names(&model(edition)));
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
    let same: Vec<_> = [MAIN, ARRAYS, CLOCKED].map(|edition| model(edition).instantiation_token).into();
    assert!(same[0] != same[1] && same[1] != same[2] && same[0] != same[2]);
    let side = |types: &[Type]| types.iter().any(|t| t.name() == "Side");
    let types = |edition| model(edition).type_definitions.types;
    assert!(!side(&types(MAIN)) && side(&types(CLOCKED)));
}

/// Three bodies with displacement, velocity, acceleration and force, all of them variables that can be connected.
#[test]
fn every_member_of_a_terminal_exists() {
    let xml = terminals::xml();
    assert_eq!(terminals::members().len(), 12);
    for member in terminals::members() {
        assert!(xml.contains(&format!("variableName=\"{}\"", member.name)), "{}", member.name);
    }
    assert_eq!(xml.matches("<TerminalMemberVariable").count(), 12);
}
