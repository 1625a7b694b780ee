//! Own checks of a model description, on the text as written: what the XML schema cannot say, and what hosts
//! overlook (start values outside their range, for one).

use crate::describe::from_xml;
use crate::error::Result;
use crate::schema::*;
use std::collections::{BTreeMap, BTreeSet};

/// Everything wrong with a model description; empty when it is valid.
///
/// # Errors
/// [`crate::Error::Xml`] when the text is no model description at all.
pub fn problems(text: &str) -> Result<Vec<String>> {
    Ok(problems_of(&from_xml(text)?))
}

/// As [`problems`], of one that is parsed already.
pub fn problems_of(model: &ModelDescription) -> Vec<String> {
    let mut found = Vec::new();
    header(model, &mut found);
    variables(model, &mut found);
    derivatives(model, &mut found);
    structure(model, &mut found);
    found
}

fn unique<'a>(
    what: &str,
    names: impl Iterator<Item = &'a str>,
    found: &mut Vec<String>,
) -> BTreeSet<&'a str> {
    let mut seen = BTreeSet::new();
    for name in names {
        if !seen.insert(name) {
            found.push(format!("{what} {name} is defined twice"));
        }
    }
    seen
}

fn header(model: &ModelDescription, found: &mut Vec<String>) {
    if model.fmi_version != "2.0" {
        found.push(format!("fmiVersion is {}, allowed is 2.0", model.fmi_version));
    }
    if model.guid.is_empty() {
        found.push("guid is empty".into());
    }
    let identifiers = std::iter::once(&model.co_simulation.model_identifier)
        .chain(model.model_exchange.as_ref().map(|me| &me.model_identifier));
    for identifier in identifiers {
        // FMI 2.0, 2.1.1: it becomes part of file and function names.
        let letters = identifier.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if !letters || identifier.starts_with(|c: char| c.is_ascii_digit()) || identifier.is_empty() {
            found.push(format!("modelIdentifier {identifier} is not a C identifier"));
        }
    }
    if model.model_exchange.is_some() != model.number_of_event_indicators.is_some() {
        found.push("numberOfEventIndicators belongs to ModelExchange: give both or none".into());
    }
    let experiment = &model.default_experiment;
    let numbers = [experiment.start, experiment.stop, experiment.tolerance, experiment.step];
    let ordered = experiment.start < experiment.stop && experiment.tolerance > 0.0 && experiment.step > 0.0;
    if !(ordered && numbers.iter().all(|x| x.is_finite())) {
        found.push(format!(
            "DefaultExperiment {numbers:?}: allowed is start < stop, tolerance > 0, step > 0, all finite"
        ));
    }
    unique("log category", model.log_categories.categories.iter().map(|c| c.name.as_str()), found);
}

fn variables(model: &ModelDescription, found: &mut Vec<String>) {
    let units = &model.unit_definitions.units;
    unique("unit", units.iter().map(|u| u.name.as_str()), found);
    for unit in units {
        unique("display unit", unit.display.iter().map(|d| d.name.as_str()), found);
        for display in unit.display.iter().filter(|d| !(d.factor.is_finite() && d.factor > 0.0)) {
            found.push(format!("display unit {}: factor {} is not positive", display.name, display.factor));
        }
    }
    let displays: BTreeMap<&str, BTreeSet<&str>> = units
        .iter()
        .map(|u| (u.name.as_str(), u.display.iter().map(|d| d.name.as_str()).collect()))
        .collect();
    let mut unit_exists = |owner: &str, unit: &str, display: Option<&str>| {
        match displays.get(unit) {
            None => found.push(format!("unit {unit} of {owner} is not defined")),
            Some(known) => {
                if let Some(display) = display.filter(|name| !known.contains(name)) {
                    found.push(format!("display unit {display} of {owner} is not defined for {unit}"));
                }
            }
        };
    };
    let types: BTreeMap<_, _> =
        model.type_definitions.types.iter().map(|t| (t.name.as_str(), &t.kind)).collect();
    for (name, kind) in &types {
        if let SimpleKind::Real(real) = kind {
            unit_exists(name, &real.unit, real.display_unit.as_deref());
        }
    }
    for v in &model.model_variables.variables {
        if let VariableKind::Real(real) = &v.kind {
            match (&real.unit, types.get(real.declared_type.as_str())) {
                (Some(unit), _) => unit_exists(&v.name, unit, real.display_unit.as_deref()),
                (None, Some(SimpleKind::Real(_))) => {}
                _ => unit_exists(&v.name, "(none)", None),
            }
        }
    }
    for (name, kind) in &types {
        if let SimpleKind::Enumeration(declared) = kind {
            unique(&format!("item of {name}"), declared.items.iter().map(|item| item.name.as_str()), found);
            let values: BTreeSet<i32> = declared.items.iter().map(|item| item.value).collect();
            if values.len() != declared.items.len() {
                found.push(format!("items of {name} share a value"));
            }
        }
    }
    let names = model.type_definitions.types.iter().map(|t| t.name.as_str());
    let names = names.chain(model.model_variables.variables.iter().map(|v| v.name.as_str()));
    unique("type or variable", names, found); // FMI 2.0, 2.2.3: they share one name space
    let mut references = BTreeMap::new();
    for v in &model.model_variables.variables {
        if let Some(other) = references.insert(v.value_reference, &v.name) {
            found.push(format!("{} and {other} share value reference {}", v.name, v.value_reference));
        }
        if model.variable_naming_convention == "structured" && !is_structured(&v.name) {
            found.push(format!("{} is not a structured name", v.name));
        }
        if v.description.is_empty() {
            found.push(format!("{} has no description", v.name));
        }
        start(v, &types, found);
        attributes(v, found);
    }
    let clocks = model.model_variables.variables.iter().filter(|v| v.causality == "independent").count();
    if clocks != 1 {
        found.push(format!("{clocks} variables are independent, allowed is one"));
    }
}

/// FMI 2.0, 2.2.9, as far as our names go: identifiers with dots between them.
pub(crate) fn is_structured(name: &str) -> bool {
    name.split('.').all(|part| {
        // An element of an array has its place behind it.
        let element = part.strip_suffix(']').and_then(|part| part.split_once('['));
        let index = |place: &str| !place.is_empty() && place.chars().all(|c| c.is_ascii_digit());
        let part = element.filter(|(_, place)| index(place)).map_or(part, |(name, _)| name);
        let rest = part.strip_prefix(|c: char| c.is_ascii_alphabetic() || c == '_');
        rest.is_some_and(|rest| rest.chars().all(|c| c.is_ascii_alphanumeric() || c == '_'))
    })
}

fn start(v: &ScalarVariable, types: &BTreeMap<&str, &SimpleKind>, found: &mut Vec<String>) {
    let name = &v.name;
    match &v.kind {
        VariableKind::Real(real) => {
            if !matches!(types.get(real.declared_type.as_str()), Some(SimpleKind::Real(_))) {
                found.push(format!("declared type {} of {name} is not a defined Real", real.declared_type));
            }
            let (min, max) = (real.min.unwrap_or(f64::NEG_INFINITY), real.max.unwrap_or(f64::INFINITY));
            if min > max {
                found.push(format!("{name}: min {min} is above max {max}"));
            }
            if real.nominal.is_some_and(|nominal| nominal <= 0.0 || nominal.is_nan()) {
                found.push(format!("{name}: nominal is not positive"));
            }
            if let Some(start) = real.start.filter(|s| !(s.is_finite() && (min..=max).contains(s))) {
                found.push(format!("{name}: start {start} is outside {min} ... {max}"));
            }
        }
        VariableKind::Integer(integer) => {
            if let (Some(min), Some(start)) = (integer.min, integer.start)
                && start < min
            {
                found.push(format!("{name}: start {start} is below min {min}"));
            }
        }
        VariableKind::Boolean(_) => {}
        VariableKind::Enumeration(enumeration) => match types.get(enumeration.declared_type.as_str()) {
            Some(SimpleKind::Enumeration(declared)) => {
                let known = |value: i32| declared.items.iter().any(|item| item.value == value);
                if let Some(start) = enumeration.start.filter(|value| !known(*value)) {
                    found.push(format!("{name}: start {start} is no item of {}", enumeration.declared_type));
                }
            }
            _ => found.push(format!(
                "declared type {} of {name} is not a defined Enumeration",
                enumeration.declared_type
            )),
        },
    }
}

/// FMI 2.0, 2.2.7: allowed combinations, and who must have a start value.
fn attributes(v: &ScalarVariable, found: &mut Vec<String>) {
    let initial = v.initial.as_deref();
    let allowed = match (v.causality.as_str(), v.variability.as_str()) {
        ("parameter", "fixed" | "tunable") => initial == Some("exact"),
        ("calculatedParameter", "fixed" | "tunable") => initial == Some("calculated"),
        ("input", "discrete" | "continuous") => initial.is_none(),
        ("local", "discrete" | "continuous") => initial == Some("calculated"),
        ("output", "discrete" | "continuous") => matches!(initial, Some("exact" | "calculated")),
        ("independent", "continuous") => initial.is_none(),
        _ => false,
    };
    if !allowed {
        let (causality, variability) = (&v.causality, &v.variability);
        found.push(format!("{}: {causality}, {variability}, initial {initial:?} do not go together", v.name));
    }
    if v.has_start() != (initial == Some("exact") || v.causality == "input") {
        found.push(format!(
            "{}: a start value belongs to initial = exact and inputs, and to them only",
            v.name
        ));
    }
    if v.variability == "continuous" && !matches!(v.kind, VariableKind::Real(_)) {
        found.push(format!("{}: only a Real can be continuous", v.name));
    }
}

fn derivatives(model: &ModelDescription, found: &mut Vec<String>) {
    let variables = &model.model_variables.variables;
    let states: Vec<u32> = variables.iter().filter_map(ScalarVariable::derivative).collect();
    if states.iter().collect::<BTreeSet<_>>().len() != states.len() {
        found.push("two variables are the derivative of one".into());
    }
    for (index, v) in (1..).zip(variables) {
        if let VariableKind::Real(Real { reinit: Some(true), .. }) = v.kind
            && !states.contains(&index)
        {
            found.push(format!("{}: reinit belongs to continuous states", v.name)); // FMI 2.0, 2.2.7
        }
    }
    for v in variables {
        let Some(index) = v.derivative() else { continue };
        match (index as usize).checked_sub(1).and_then(|i| variables.get(i)) {
            Some(state) if state.name != v.name && matches!(state.kind, VariableKind::Real(_)) => {}
            _ => found.push(format!("{}: derivative = {index} is no other Real variable", v.name)),
        }
    }
}

fn structure(model: &ModelDescription, found: &mut Vec<String>) {
    let variables = &model.model_variables.variables;
    let lists = &model.model_structure;
    let mut check = |what: &str, list: &Unknowns, expected: BTreeSet<u32>| {
        let given: BTreeSet<u32> = list.unknowns.iter().map(|u| u.index).collect();
        let name = |i: &u32| {
            (*i as usize).checked_sub(1).and_then(|i| variables.get(i)).map_or("(none)", |v| v.name.as_str())
        };
        for index in expected.symmetric_difference(&given) {
            let problem = if given.contains(index) { "does not belong in" } else { "is missing from" };
            found.push(format!("{} (index {index}) {problem} ModelStructure/{what}", name(index)));
        }
        if given.len() != list.unknowns.len() {
            found.push(format!("ModelStructure/{what} names an index twice"));
        }
        for u in &list.unknowns {
            let words = |s: &Option<String>| -> Option<Vec<String>> {
                s.as_ref().map(|s| s.split_whitespace().map(str::to_owned).collect())
            };
            let (on, kinds) = (words(&u.dependencies), words(&u.kinds));
            let indices: Option<Vec<usize>> =
                on.iter().flatten().map(|word| word.parse().ok()).collect::<Option<_>>();
            let valid = indices.is_some_and(|i| {
                i.iter().all(|i| (1..=variables.len()).contains(i)) && i.windows(2).all(|w| w[0] < w[1])
            });
            // Initialization knows the first two alone (FMI 2.0, 2.2.8).
            const KINDS: [&str; 5] = ["dependent", "constant", "fixed", "tunable", "discrete"];
            let kinds_of = if what == "InitialUnknowns" { &KINDS[..2] } else { &KINDS[..] };
            let fits = |k: &Vec<String>| {
                on.as_ref().map(Vec::len) == Some(k.len())
                    && k.iter().all(|kind| kinds_of.contains(&kind.as_str()))
            };
            if !valid || !kinds.as_ref().is_none_or(fits) {
                found
                    .push(format!("ModelStructure/{what}: dependencies of {} are not valid", name(&u.index)));
            }
        }
    };
    let of = |wanted: &dyn Fn(&ScalarVariable) -> bool| -> BTreeSet<u32> {
        (1..).zip(variables).filter(|(_, v)| wanted(v)).map(|(i, _)| i).collect()
    };
    check("Outputs", &lists.outputs, of(&|v| v.causality == "output"));
    check("Derivatives", &lists.derivatives, of(&|v| v.derivative().is_some()));
    let calculated =
        |v: &ScalarVariable| v.initial.as_deref() == Some("calculated") && v.causality != "local";
    check("InitialUnknowns", &lists.initial_unknowns, of(&calculated));
}
