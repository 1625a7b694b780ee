//! This project's checks of the text of a model description, for either version: rules that the
//! XML schema cannot express, properties on which importers rely, and errors that hosts overlook,
//! such as start values outside their range.

mod model;
mod structure;

use crate::error::Result;
use crate::xml::Element;
use fmi_doors::Version;
use model::{Model, Variable, VariableType};
use std::collections::BTreeSet;

/// All problems of a model description; empty if it is valid.
///
/// # Errors
/// [`crate::Error::Xml`] if the text is not XML.
pub fn problems(text: &str, version: Version) -> Result<Vec<String>> {
    Ok(problems_of(&Element::parse(text)?, version))
}

/// All problems of a parsed model description; empty if it is valid.
pub fn problems_of(root: &Element, version: Version) -> Vec<String> {
    let mut found = Vec::new();
    required(root, version, &mut found);
    let model = Model::of(root, version);
    header(&model, &mut found);
    units(&model, &mut found);
    names(&model, &mut found);
    for v in &model.variables {
        variable(v, &model, &mut found);
    }
    derivatives(&model, &mut found);
    structure::check(&model, &mut found);
    found
}

/// Required attributes of the root element, in both versions.
const ROOT: &str = "fmiVersion modelName description author version copyright license generationTool variableNamingConvention";
/// Required children of the root element, in both versions.
const CHILDREN: [&str; 7] = [
    "CoSimulation",
    "UnitDefinitions",
    "TypeDefinitions",
    "LogCategories",
    "DefaultExperiment",
    "ModelVariables",
    "ModelStructure",
];
/// Required attributes of other elements, in both versions.
const ATTRIBUTES: [(&str, &str); 6] = [
    ("Unit", "name"),
    ("DisplayUnit", "name factor"),
    ("Item", "name value description"),
    ("Category", "name description"),
    ("DefaultExperiment", "startTime stopTime tolerance stepSize"),
    ("Alias", "name"),
];
/// Required attributes of elements in FMI 2.0 only.
const OF_FMI2: [(&str, &str); 6] = [
    ("fmiModelDescription", "guid"),
    (
        "ModelExchange",
        "completedIntegratorStepNotNeeded canGetAndSetFMUstate canSerializeFMUstate providesDirectionalDerivative",
    ),
    (
        "CoSimulation",
        "canHandleVariableCommunicationStepSize canInterpolateInputs maxOutputDerivativeOrder canRunAsynchronuously",
    ),
    ("SimpleType", "name description"),
    ("ScalarVariable", "name valueReference description causality variability"),
    ("Unknown", "index"),
];
const OF_FMI3: [(&str, &str); 9] = [
    ("fmiModelDescription", "instantiationToken"),
    (
        "ModelExchange",
        "needsCompletedIntegratorStep canGetAndSetFMUState canSerializeFMUState providesDirectionalDerivatives",
    ),
    (
        "CoSimulation",
        "canHandleVariableCommunicationStepSize maxOutputDerivativeOrder providesIntermediateUpdate hasEventMode",
    ),
    ("Float64Type", "name description"),
    ("EnumerationType", "name description"),
    ("Output", "valueReference"),
    ("ContinuousStateDerivative", "valueReference"),
    ("InitialUnknown", "valueReference"),
    ("EventIndicator", "valueReference"),
];

fn required(root: &Element, version: Version, found: &mut Vec<String>) {
    for child in CHILDREN {
        if root.all(child).count() != 1 {
            found.push(format!("{} has not one {child}", root.name));
        }
    }
    let own: &[_] = if version == Version::Fmi2 { &OF_FMI2 } else { &OF_FMI3 };
    let mut open = vec![root];
    while let Some(element) = open.pop() {
        let all = ATTRIBUTES.iter().chain(own).chain([&("fmiModelDescription", ROOT)]);
        for name in all.filter(|row| row.0 == element.name).flat_map(|row| row.1.split(' ')) {
            if element.attribute(name).is_none() {
                found.push(format!("{} without {name}: {:?}", element.name, element.attributes));
            }
        }
        open.extend(&element.children);
    }
}

fn unique<'a>(what: &str, names: impl Iterator<Item = &'a str>, found: &mut Vec<String>) {
    let mut seen = BTreeSet::new();
    for name in names.filter(|name| !seen.insert(*name)) {
        found.push(format!("{what} {name} is defined twice"));
    }
}

fn attributes<'a>(list: &'a [Element], name: &str) -> impl Iterator<Item = &'a str> {
    list.iter().filter_map(move |element| element.attribute(name))
}

fn header(model: &Model, found: &mut Vec<String>) {
    let root = model.root;
    // FMI 3.0.2, 2.4.1: the standard's version as the schema's pattern has it, without a patch.
    let (version, token) = if model.is_fmi3() { ("3.0", "instantiationToken") } else { ("2.0", "guid") };
    let told = root.attribute("fmiVersion").unwrap_or_default();
    if told != version {
        found.push(format!("fmiVersion is {told}, expected {version}"));
    }
    if root.attribute(token) == Some("") {
        found.push(format!("{token} is empty"));
    }
    for interface in root.all("ModelExchange").chain(root.all("CoSimulation")) {
        // FMI 2.0, 2.1.1: the identifier becomes part of file and function names.
        let identifier = interface.attribute("modelIdentifier").unwrap_or_default();
        let letters = identifier.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if !letters || identifier.starts_with(|c: char| c.is_ascii_digit()) || identifier.is_empty() {
            found.push(format!("modelIdentifier {identifier} is not a C identifier"));
        }
    }
    let indicators = root.attribute("numberOfEventIndicators").is_some();
    if !model.is_fmi3() && indicators != (root.all("ModelExchange").count() > 0) {
        found.push("numberOfEventIndicators belongs to ModelExchange: give both or none".into());
    }
    for experiment in root.all("DefaultExperiment") {
        let number = |name| experiment.attribute(name).and_then(|x| x.parse().ok()).unwrap_or(f64::NAN);
        let numbers = ["startTime", "stopTime", "tolerance", "stepSize"].map(number);
        let [start, stop, tolerance, step] = numbers;
        let ordered = start < stop && tolerance > 0.0 && step > 0.0;
        if !(ordered && numbers.iter().all(|x| x.is_finite())) {
            found.push(format!(
                "DefaultExperiment {numbers:?}: expected start < stop, tolerance > 0, step > 0, all finite"
            ));
        }
        // Some importers require a whole quotient of duration and step.
        if model.is_fmi3() && ((stop - start) / step).fract() != 0.0 {
            found.push(format!("DefaultExperiment {numbers:?}: the step does not divide the duration"));
        }
    }
    unique("log category", attributes(root.within("LogCategories"), "name"), found);
}

fn units(model: &Model, found: &mut Vec<String>) {
    unique("unit", attributes(model.units, "name"), found);
    for unit in model.units {
        let displays = unit.all("DisplayUnit");
        unique("display unit", displays.filter_map(|display| display.attribute("name")), found);
        for display in unit.all("DisplayUnit") {
            let [name, factor] = ["name", "factor"].map(|name| display.attribute(name).unwrap_or_default());
            if !factor.parse().is_ok_and(|factor: f64| factor.is_finite() && factor > 0.0) {
                found.push(format!("display unit {name}: factor {factor} is not positive"));
            }
        }
    }
    for (name, declared) in &model.types {
        unit_exists(name, declared, model, found);
        let items = &declared.children;
        unique(&format!("item of {name}"), attributes(items, "name"), found);
        if attributes(items, "value").collect::<BTreeSet<_>>().len() != items.len() {
            found.push(format!("items of {name} share a value"));
        }
    }
}

/// Checks that the unit and display unit of a type or variable, if it has them, are defined.
fn unit_exists(owner: &str, of: &Element, model: &Model, found: &mut Vec<String>) {
    let Some(unit) = of.attribute("unit") else { return };
    let display = of.attribute("displayUnit");
    match model.units.iter().find(|known| known.attribute("name") == Some(unit)) {
        None => found.push(format!("unit {unit} of {owner} is not defined")),
        Some(known)
            if display.is_none_or(|_| known.all("DisplayUnit").any(|d| d.attribute("name") == display)) => {}
        Some(_) => {
            let display = display.unwrap_or_default();
            found.push(format!("display unit {display} of {owner} is not defined for {unit}"));
        }
    }
}

/// FMI 2.0, 2.2.3; FMI 3.0.2, 2.4 and 2.4.7.3: types, variables and aliases share one name space.
fn names(model: &Model, found: &mut Vec<String>) {
    let types = model.types.iter().map(|(name, _)| *name);
    let names = model.variables.iter().map(|v| v.name);
    let aliases = model.variables.iter().flat_map(|v| v.element.all("Alias"));
    let aliases = aliases.filter_map(|alias| alias.attribute("name"));
    let all: Vec<&str> = types.chain(names).chain(aliases).collect();
    unique("type, variable or alias", all.iter().copied(), found);
    if model.variables.len() != model.root.within("ModelVariables").len() {
        found.push("ModelVariables has an element that is not a variable".into());
    }
    let structured = model.root.attribute("variableNamingConvention") == Some("structured");
    for name in all.into_iter().filter(|name| structured && !is_structured(name)) {
        found.push(format!("{name} is not a structured name"));
    }
    unique("value reference", model.variables.iter().filter_map(|v| v.get("valueReference")), found);
}

/// FMI 2.0, 2.2.9; FMI 3.0.2, 2.4.7.5.1, restricted to the forms that this project uses:
/// identifiers, perhaps with indices, separated by dots, and their first derivatives.
fn is_structured(name: &str) -> bool {
    let inner = name.strip_prefix("der(").and_then(|rest| rest.strip_suffix(')'));
    inner.unwrap_or(name).split('.').all(|part| {
        // An array's element has its indices in brackets after the name, separated by commas.
        let element = part.strip_suffix(']').and_then(|part| part.split_once('['));
        let index = |place: &str| !place.is_empty() && place.chars().all(|c| c.is_ascii_digit());
        let part = element.filter(|(_, places)| places.split(',').all(index)).map_or(part, |(name, _)| name);
        let rest = part.strip_prefix(|c: char| c.is_ascii_alphabetic() || c == '_');
        rest.is_some_and(|rest| rest.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'))
    })
}

fn variable(v: &Variable, model: &Model, found: &mut Vec<String>) {
    let name = v.name;
    if v.get("description") == Some("") {
        found.push(format!("{name} has no description"));
    }
    let declared = v.get("declaredType");
    // FMI 3.0.2, 2.4.7.4: an Enumeration must have a declared type. Importers refuse a Clock that
    // has one.
    let needs_type = match v.kind {
        VariableType::Enumeration => true,
        VariableType::Real => model.is_fmi3() || v.get("unit").is_none() || declared.is_some(),
        _ => false,
    };
    if needs_type != declared.is_some() || needs_type && model.type_of(v).is_none() {
        found.push(format!("declared type {declared:?} of {name} is not a defined type of its kind"));
    }
    if model.is_fmi3() && (v.get("unit").is_some() || v.get("displayUnit").is_some()) {
        found.push(format!("{name}: unit and display unit belong to its declared type"));
    }
    unit_exists(name, v.of_type, model, found);
    combination(v, model, found);
    start(v, model, found);
    if model.is_fmi3() {
        of_fmi3(v, model, found);
    }
}

/// FMI 2.0, 2.2.7; FMI 3.0.2, 2.4.7.4: allowed combinations of causality, variability and initial.
/// Inputs have no `initial` in FMI 3.0 either, since some importers refuse it.
fn combination(v: &Variable, model: &Model, found: &mut Vec<String>) {
    let (name, initial) = (v.name, v.get("initial"));
    let allowed = match (v.causality, v.variability) {
        ("output", "discrete") if v.kind == VariableType::Clock => {
            initial.is_none() && v.get("intervalVariability") == Some("triggered")
        }
        ("parameter", "fixed" | "tunable") => initial == Some("exact"),
        ("calculatedParameter", "fixed" | "tunable") => initial == Some("calculated"),
        ("input", "discrete" | "continuous") => initial.is_none(),
        ("local", "discrete" | "continuous") if !model.is_fmi3() => initial == Some("calculated"),
        ("output" | "local", "discrete" | "continuous") => matches!(initial, Some("exact" | "calculated")),
        ("independent", "continuous") => initial.is_none(),
        _ => false,
    };
    if !allowed {
        let (causality, variability) = (v.causality, v.variability);
        found.push(format!("{name}: {causality}, {variability}, initial {initial:?} do not go together"));
    }
    if v.variability == "continuous" && v.kind != VariableType::Real {
        found.push(format!("{name}: only a Real can be continuous"));
    }
}

fn start(v: &Variable, model: &Model, found: &mut Vec<String>) {
    let (name, start) = (v.name, v.get("start"));
    if start.is_some() != v.is_set() {
        found.push(format!("{name}: a start value belongs only to initial = exact and to inputs"));
    }
    let mut number = |attribute, absent: f64| match v.get(attribute).map(str::parse) {
        None => absent,
        Some(Ok(value)) => value,
        Some(Err(_)) => {
            found.push(format!("{name}: {attribute} is not a number"));
            absent
        }
    };
    let (min, max) = (number("min", f64::NEG_INFINITY), number("max", f64::INFINITY));
    let nominal = number("nominal", 1.0);
    if min > max {
        found.push(format!("{name}: min {min} is above max {max}"));
    }
    if !(nominal > 0.0 && nominal.is_finite()) {
        found.push(format!("{name}: nominal is not positive"));
    }
    let Some(start) = start else { return };
    let fits = match v.kind {
        VariableType::Boolean => start == "true" || start == "false",
        _ => start.parse().is_ok_and(|start: f64| start.is_finite() && (min..=max).contains(&start)),
    };
    if !fits {
        found.push(format!("{name}: start {start} is outside {min} ... {max}"));
    }
    if let (VariableType::Enumeration, Some(declared)) = (v.kind, model.type_of(v))
        && !attributes(&declared.children, "value").any(|value| value == start)
    {
        found.push(format!(
            "{name}: start {start} is not an item of {}",
            v.get("declaredType").unwrap_or_default()
        ));
    }
}

/// Checks of attributes that only FMI 3.0 has.
fn of_fmi3(v: &Variable, model: &Model, found: &mut Vec<String>) {
    let name = v.name;
    // Some importers take value references for indices.
    if v.key != v.place {
        found.push(format!("{name} has value reference {}, but is at place {}", v.key, v.place));
    }
    let mut lengths = v.element.all("Dimension").map(|dimension| dimension.attribute("start"));
    let is_array = v.element.all("Dimension").count() > 0;
    if is_array && (v.causality != "local" || lengths.any(|length| length.is_none_or(|length| length == "0")))
    {
        // Some importers fail on arrays that they connect or record.
        found.push(format!("{name}: expected local arrays without a length of 0"));
    }
    let intermediate = v.get("intermediateUpdate") == Some("true");
    if intermediate && (v.variability != "continuous" || v.causality == "local") {
        found.push(format!("{name}: intermediateUpdate is for continuous inputs and outputs"));
    }
    // Some validators take the alias of a calculated output for another output.
    if v.element.all("Alias").count() > 0 && !v.is_set() {
        found.push(format!("{name}: aliases are for what is set"));
    }
    let clocks: Vec<&str> = v.get("clocks").iter().flat_map(|clocks| clocks.split_whitespace()).collect();
    let is_clock = |key: &&str| {
        key.parse().is_ok_and(|key| model.by_key(key).is_some_and(|clock| clock.kind == VariableType::Clock))
    };
    if !clocks.iter().all(is_clock) || !clocks.is_empty() && v.variability != "discrete" {
        found.push(format!("{name}: clocks = {clocks:?}: expected clocks, for discrete variables"));
    }
}

fn derivatives(model: &Model, found: &mut Vec<String>) {
    let mut states = BTreeSet::new();
    for v in &model.variables {
        let Some(state) = v.derivative() else { continue };
        match model.by_key(state) {
            Some(s) if s.name == v.name || s.kind != VariableType::Real => {
                found.push(format!("{}: derivative = {state} is not another Real variable", v.name));
            }
            None => found.push(format!("{}: derivative = {state} is not another Real variable", v.name)),
            Some(s) if model.is_fmi3() && s.derivative().is_some() => {
                found.push(format!("{}: derivative = {state} is not a state", v.name));
            }
            Some(_) => {}
        }
        if !states.insert(state) {
            found.push(format!("{}: another variable is the derivative of {state} as well", v.name));
        }
    }
    for v in &model.variables {
        // FMI 2.0, 2.2.7.
        if v.get("reinit") == Some("true") && !states.contains(&v.key) {
            found.push(format!("{}: reinit belongs to continuous states", v.name));
        }
    }
    let clocks = model.keys(|v| v.causality == "independent").len();
    if clocks != 1 {
        found.push(format!("{clocks} variables are independent, expected one"));
    }
}
