//! Own checks of a model description of FMI 3.0, on the text as written: what the XML schema cannot say, and what importers rely
//! on.

use super::schema::*;
use crate::error::Result;
use std::collections::{BTreeMap, BTreeSet};

/// Everything wrong with a model description; empty when it is valid.
///
/// # Errors
/// [`crate::Error::Xml`] when the text is no model description at all.
pub fn problems(text: &str) -> Result<Vec<String>> {
    Ok(problems_of(&super::from_xml(text)?))
}

/// As [`problems`], of one that is parsed already.
pub fn problems_of(model: &ModelDescription) -> Vec<String> {
    let mut found = Vec::new();
    header(model, &mut found);
    let variables = &model.model_variables.variables;
    names(model, &mut found);
    for (place, v) in (1..).zip(variables) {
        variable(place, v, model, &mut found);
    }
    derivatives(variables, &mut found);
    structure(model, &mut found);
    found
}

fn header(model: &ModelDescription, found: &mut Vec<String>) {
    // FMI 3.0.2, 2.4.1: the standard's version as the schema's pattern has it, without a patch.
    if model.fmi_version != "3.0" {
        found.push(format!("fmiVersion is {}, allowed is 3.0", model.fmi_version));
    }
    if model.instantiation_token.is_empty() {
        found.push("instantiationToken is empty".into());
    }
    for identifier in [&model.model_exchange.model_identifier, &model.co_simulation.model_identifier] {
        let letters = identifier.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if !letters || identifier.starts_with(|c: char| c.is_ascii_digit()) || identifier.is_empty() {
            found.push(format!("modelIdentifier {identifier} is not a C identifier"));
        }
    }
    let e = &model.default_experiment;
    let numbers = [e.start, e.stop, e.tolerance, e.step];
    let ordered = e.start < e.stop && e.tolerance > 0.0 && e.step > 0.0;
    if !(ordered && numbers.iter().all(|x| x.is_finite())) {
        found.push(format!(
            "DefaultExperiment {numbers:?}: allowed is start < stop, tolerance > 0, step > 0, all finite"
        ));
    }
    // Importers exist that check this on the quotient.
    if ((e.stop - e.start) / e.step).fract() != 0.0 {
        found.push(format!("DefaultExperiment {numbers:?}: the step does not divide the duration"));
    }
}

/// FMI 3.0.2, 2.4.7.1: names of variables and aliases are unique, structured, and no type has one of them.
fn names(model: &ModelDescription, found: &mut Vec<String>) {
    let mut seen = BTreeSet::new();
    let types = model.type_definitions.types.iter().map(Type::name);
    let variables = model.model_variables.variables.iter().map(Variable::attributes);
    let names = variables.clone().map(|v| v.name.as_str());
    let aliases = variables.flat_map(|v| v.aliases.iter().map(|alias| alias.name.as_str()));
    for name in types.chain(names).chain(aliases) {
        if !seen.insert(name) {
            found.push(format!("type, variable or alias {name} is defined twice"));
        }
        if !is_structured(name) {
            found.push(format!("{name} is not a structured name"));
        }
    }
}

/// FMI 3.0.2, 2.4.7.5.2, as far as our names go: identifiers with dots between them, and their first derivatives.
fn is_structured(name: &str) -> bool {
    let inner = name.strip_prefix("der(").and_then(|rest| rest.strip_suffix(')'));
    crate::check::is_structured(inner.unwrap_or(name))
}

fn variable(place: u32, v: &Variable, model: &ModelDescription, found: &mut Vec<String>) {
    let a = v.attributes();
    let name = &a.name;
    // Importers exist that take value references for places.
    if a.value_reference != place {
        found.push(format!("{name} has value reference {}, but stands at place {place}", a.value_reference));
    }
    if a.description.is_empty() {
        found.push(format!("{name} has no description"));
    }
    declared_type(v, model, found);
    combination(v, found);
    start(v, found);
    if !a.dimensions.is_empty() && (a.causality != "local" || a.dimensions.iter().any(|d| d.start == 0)) {
        // Importers exist that break on arrays which they connect or record.
        found.push(format!("{name}: allowed are local arrays without a length of 0"));
    }
    if a.intermediate_update == Some(true) && (a.variability != "continuous" || a.causality == "local") {
        found.push(format!("{name}: intermediateUpdate is for continuous inputs and outputs"));
    }
    // Validators exist that take the alias of a calculated output for another output.
    let set = a.initial.as_deref() == Some("exact") || a.causality == "input";
    if !a.aliases.is_empty() && !set {
        found.push(format!("{name}: aliases are for what is set"));
    }
    let clocks: Vec<&str> = a.clocks.iter().flat_map(|clocks| clocks.split_whitespace()).collect();
    let is_clock = |reference: &&str| {
        let variables = &model.model_variables.variables;
        let clock = variables.iter().find(|v| v.attributes().value_reference.to_string() == **reference);
        matches!(clock, Some(Variable::Clock(_)))
    };
    if !clocks.iter().all(is_clock) || !clocks.is_empty() && a.variability != "discrete" {
        found.push(format!("{name}: clocks = {clocks:?}: allowed are clocks, of discrete variables"));
    }
}

fn declared_type(v: &Variable, model: &ModelDescription, found: &mut Vec<String>) {
    let a = v.attributes();
    let declared = a.declared_type.as_deref();
    let types = &model.type_definitions.types;
    let defined = declared.and_then(|name| types.iter().find(|t| t.name() == name));
    let fits = match (v, defined) {
        (Variable::Float64(_), Some(Type::Float64Type(_)))
        | (Variable::Enumeration(_), Some(Type::EnumerationType(_))) => true,
        // FMI 3.0.2, 2.4.7.4: an Enumeration must have one. A Clock with one is refused by importers.
        (Variable::Enumeration(_) | Variable::Float64(_), _) => false,
        _ => declared.is_none(),
    };
    if !fits {
        found.push(format!("declared type {declared:?} of {} is not a defined type of its kind", a.name));
    }
    let (unit, display) = match defined {
        Some(Type::Float64Type(t)) => (t.unit.as_deref(), t.display_unit.as_deref()),
        _ => (None, None),
    };
    if a.unit.is_some() || a.display_unit.is_some() {
        found.push(format!("{}: unit and display unit are left to its declared type", a.name));
    }
    if let Some(unit) = unit {
        let defined = model.unit_definitions.units.iter().find(|u| u.name == unit);
        let shown =
            |u: &crate::schema::Unit| display.is_none_or(|name| u.display.iter().any(|d| d.name == name));
        if !defined.is_some_and(shown) {
            found.push(format!("unit {unit} or display unit {display:?} of {} is not defined", a.name));
        }
    }
}

/// FMI 3.0.2, 2.4.7.4: what goes together. Inputs have no `initial` here, since importers exist that refuse one.
fn combination(v: &Variable, found: &mut Vec<String>) {
    let a = v.attributes();
    let initial = a.initial.as_deref();
    let allowed = match (a.causality.as_str(), a.variability.as_str()) {
        ("output", "discrete") if matches!(v, Variable::Clock(_)) => {
            initial.is_none() && a.interval_variability.as_deref() == Some("triggered")
        }
        ("parameter", "fixed" | "tunable") => initial == Some("exact"),
        ("calculatedParameter", "fixed" | "tunable") => initial == Some("calculated"),
        ("input", "discrete" | "continuous") => initial.is_none(),
        ("output" | "local", "discrete" | "continuous") => matches!(initial, Some("exact" | "calculated")),
        ("independent", "continuous") => initial.is_none(),
        _ => false,
    };
    if !allowed {
        let (causality, variability) = (&a.causality, &a.variability);
        found.push(format!("{}: {causality}, {variability}, initial {initial:?} do not go together", a.name));
    }
    if a.variability == "continuous" && !matches!(v, Variable::Float64(_)) {
        found.push(format!("{}: only a Float64 can be continuous", a.name));
    }
}

fn start(v: &Variable, found: &mut Vec<String>) {
    let a = v.attributes();
    if a.start.is_some() != (a.initial.as_deref() == Some("exact") || a.causality == "input") {
        found.push(format!(
            "{}: a start value belongs to initial = exact and inputs, and to them only",
            a.name
        ));
    }
    let (min, max) = (a.min.unwrap_or(f64::NEG_INFINITY), a.max.unwrap_or(f64::INFINITY));
    if min > max || a.nominal.is_some_and(|nominal| !(nominal > 0.0 && nominal.is_finite())) {
        found.push(format!("{}: min {min} is above max {max}, or nominal is not positive", a.name));
    }
    let Some(start) = &a.start else { return };
    let fits = match v {
        Variable::Boolean(_) => start == "true" || start == "false",
        _ => start.parse().is_ok_and(|start: f64| start.is_finite() && (min..=max).contains(&start)),
    };
    if !fits {
        found.push(format!("{}: start {start} is outside {min} ... {max}", a.name));
    }
}

fn derivatives(variables: &[Variable], found: &mut Vec<String>) {
    let by_reference: BTreeMap<u32, &Variable> =
        variables.iter().map(|v| (v.attributes().value_reference, v)).collect();
    let mut states = BTreeSet::new();
    for a in variables.iter().map(Variable::attributes) {
        let Some(state) = a.derivative else { continue };
        match by_reference.get(&state) {
            Some(Variable::Float64(s)) if s.name != a.name && s.derivative.is_none() => {}
            _ => found.push(format!("{}: derivative = {state} is no state", a.name)),
        }
        if !states.insert(state) {
            found.push(format!("{}: another variable is the derivative of {state} as well", a.name));
        }
    }
    for a in variables.iter().map(Variable::attributes) {
        if a.reinit.is_some() && !states.contains(&a.value_reference) {
            found.push(format!("{}: reinit belongs to continuous states", a.name));
        }
    }
}

/// Sets of references by what their variables are.
struct Sets<'a> {
    variables: BTreeMap<u32, &'a Variable>,
    states: BTreeSet<u32>,
}

impl<'a> Sets<'a> {
    fn of(&self, wanted: impl Fn(&Attributes) -> bool) -> BTreeSet<u32> {
        self.variables.iter().filter(|(_, v)| wanted(v.attributes())).map(|(r, _)| *r).collect()
    }

    fn name(&self, reference: u32) -> &'a str {
        self.variables.get(&reference).map_or("(none)", |v| v.attributes().name.as_str())
    }
}

/// FMI 3.0.2, 2.4.8: who must be listed where, and on what each may depend.
fn structure(model: &ModelDescription, found: &mut Vec<String>) {
    let variables = &model.model_variables.variables;
    let sets = Sets {
        variables: variables.iter().map(|v| (v.attributes().value_reference, v)).collect(),
        states: variables.iter().filter_map(|v| v.attributes().derivative).collect(),
    };
    let lists = &model.model_structure;
    let clocks = sets.of(|a| a.interval_variability.is_some());
    let mut known = sets.of(|a| matches!(a.causality.as_str(), "input" | "parameter" | "independent"));
    known.extend(&sets.states);
    known.extend(&clocks);
    let exact = |a: &Attributes| {
        matches!(a.causality.as_str(), "input" | "independent") || a.initial.as_deref() == Some("exact")
    };
    let initially = sets.of(exact);
    let derivatives = sets.of(|a| a.derivative.is_some());
    let unknown = |a: &Attributes| {
        let clock = a.interval_variability.is_some();
        let calculated = clock || a.initial.as_deref() == Some("calculated") && a.clocks.is_none();
        let of_state = a.derivative.is_some() || sets.states.contains(&a.value_reference);
        calculated && (a.causality == "output" || a.causality == "calculatedParameter" || of_state)
    };
    const ALL: [&str; 5] = ["dependent", "constant", "fixed", "tunable", "discrete"];
    list("Output", &lists.outputs, Some(sets.of(|a| a.causality == "output")), (&known, &ALL), &sets, found);
    let derivative = ("ContinuousStateDerivative", &lists.derivatives);
    list(derivative.0, derivative.1, Some(derivatives), (&known, &ALL), &sets, found);
    let initial = ("InitialUnknown", &lists.initial_unknowns);
    list(initial.0, initial.1, Some(sets.of(unknown)), (&initially, &ALL[..2]), &sets, found);
    list("EventIndicator", &lists.event_indicators, None, (&known, &ALL), &sets, found);
    for row in &lists.event_indicators {
        let indicator = sets.variables.get(&row.value_reference).map(|v| v.attributes());
        if !indicator.is_some_and(|a| {
            a.variability == "continuous" && matches!(a.causality.as_str(), "local" | "output")
        }) {
            found.push(format!(
                "EventIndicator {}: allowed are continuous locals and outputs",
                row.value_reference
            ));
        }
    }
}

/// One list: the expected references, each once, with dependencies on `knowns` by the kinds that are allowed there.
fn list(
    what: &str,
    rows: &[Unknown],
    expected: Option<BTreeSet<u32>>,
    (knowns, kinds): (&BTreeSet<u32>, &[&str]),
    sets: &Sets<'_>,
    found: &mut Vec<String>,
) {
    let given: BTreeSet<u32> = rows.iter().map(|row| row.value_reference).collect();
    for reference in expected.iter().flat_map(|expected| expected.symmetric_difference(&given)) {
        let problem = if given.contains(reference) { "does not belong in" } else { "is missing from" };
        found.push(format!("{} (value reference {reference}) {problem} {what}", sets.name(*reference)));
    }
    if given.len() != rows.len() {
        found.push(format!("{what} names a value reference twice"));
    }
    for row in rows {
        let words = |list: &Option<String>| -> Option<Vec<String>> {
            list.as_ref().map(|text| text.split_whitespace().map(str::to_owned).collect())
        };
        let (on, how) = (words(&row.dependencies), words(&row.kinds));
        let once = |on: &[String]| on.iter().collect::<BTreeSet<_>>().len() == on.len();
        let is_known = |word: &String| word.parse().is_ok_and(|reference: u32| knowns.contains(&reference));
        let valid = on.as_ref().is_some_and(|on| once(on) && on.iter().all(is_known));
        let told = how.as_ref().is_some_and(|how| how.iter().all(|kind| kinds.contains(&kind.as_str())));
        if !valid || !told || on.map(|on| on.len()) != how.map(|how| how.len()) {
            found.push(format!("{what}: dependencies of {} are not valid", sets.name(row.value_reference)));
        }
    }
}
