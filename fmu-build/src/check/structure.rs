//! Checks of the model structure: the variables that each list must name, and their dependencies.

use super::model::{Model, Variable, VariableType};
use crate::xml::Element;
use fmi_doors::Version;
use std::collections::BTreeSet;

/// Kinds of dependencies (FMI 2.0, 2.2.8; FMI 3.0.2, 2.4.8).
const KINDS: [&str; 5] = ["dependent", "constant", "fixed", "tunable", "discrete"];

/// FMI 2.0, 2.2.8; FMI 3.0.2, 2.4.8: the lists of the model structure, and allowed dependencies.
pub(super) fn check(model: &Model, found: &mut Vec<String>) {
    let states: BTreeSet<u32> = model.variables.iter().filter_map(Variable::derivative).collect();
    let calculated = |v: &Variable| v.get("initial") == Some("calculated");
    let outputs = model.keys(|v| v.causality == "output");
    let derivatives = model.keys(|v| v.derivative().is_some());
    // During initialization only the first two kinds of dependencies are allowed.
    let first = &KINDS[..2];
    if !model.is_fmi3() {
        let all = model.keys(|_| true);
        let initial = model.keys(|v| calculated(v) && v.causality != "local");
        list(model, "Outputs", Some(outputs), (&all, &KINDS), found);
        list(model, "Derivatives", Some(derivatives), (&all, &KINDS), found);
        list(model, "InitialUnknowns", Some(initial), (&all, first), found);
        return;
    }
    let is_known = |v: &Variable| {
        matches!(v.causality, "input" | "parameter" | "independent")
            || states.contains(&v.key)
            || v.kind == VariableType::Clock
    };
    let initial = |v: &Variable| {
        let of_state = v.derivative().is_some() || states.contains(&v.key);
        let listed = matches!(v.causality, "output" | "calculatedParameter") || of_state;
        listed && (v.kind == VariableType::Clock || calculated(v) && v.get("clocks").is_none())
    };
    let known = model.keys(is_known);
    let set = model.keys(|v| v.is_set() || v.causality == "independent");
    list(model, "Output", Some(outputs), (&known, &KINDS), found);
    list(model, "ContinuousStateDerivative", Some(derivatives), (&known, &KINDS), found);
    list(model, "InitialUnknown", Some(model.keys(initial)), (&set, first), found);
    list(model, "EventIndicator", None, (&known, &KINDS), found);
    for key in model.root.within("ModelStructure").iter().filter(|row| row.name == "EventIndicator").map(key)
    {
        let continuous =
            |v: &Variable| v.variability == "continuous" && matches!(v.causality, "local" | "output");
        if !model.by_key(key).is_some_and(continuous) {
            found.push(format!("EventIndicator {key}: expected continuous locals and outputs"));
        }
    }
}

/// The variable named by a row of the model structure.
fn key(row: &Element) -> u32 {
    let key = row.attribute("index").or_else(|| row.attribute("valueReference"));
    key.and_then(|key| key.parse().ok()).unwrap_or_default()
}

/// Checks one list of the model structure: exactly the expected keys, each once, with dependencies
/// on `knowns` of allowed kinds only.
fn list(
    model: &Model,
    what: &str,
    expected: Option<BTreeSet<u32>>,
    (knowns, kinds): (&BTreeSet<u32>, &[&str]),
    found: &mut Vec<String>,
) {
    let structure = model.root.within("ModelStructure");
    let rows: Vec<&Element> = match model.version {
        Version::Fmi2 => {
            structure.iter().filter(|list| list.name == what).flat_map(|list| &list.children).collect()
        }
        Version::Fmi3 => structure.iter().filter(|row| row.name == what).collect(),
    };
    let name = |key: u32| model.by_key(key).map_or("(none)", |v| v.name);
    let given: BTreeSet<u32> = rows.iter().map(|row| key(row)).collect();
    for key in expected.iter().flat_map(|expected| expected.symmetric_difference(&given)) {
        let problem = if given.contains(key) { "does not belong in" } else { "is missing from" };
        found.push(format!("{} ({key}) {problem} {what}", name(*key)));
    }
    if given.len() != rows.len() {
        found.push(format!("{what} names a variable twice"));
    }
    for row in rows {
        let words = |name| row.attribute(name).map(|text| text.split_whitespace().collect::<Vec<_>>());
        let (on, how) = (words("dependencies"), words("dependenciesKind"));
        // Some importers of FMI 3.0 need both lists. Without both an unknown depends on every known,
        // as with residual flexibility.
        let told = !model.is_fmi3() || on.is_some() == how.is_some();
        let keys: Vec<u32> = on.iter().flatten().map(|word| word.parse().unwrap_or(u32::MAX)).collect();
        let once = keys.iter().collect::<BTreeSet<_>>().len() == keys.len();
        let in_order = model.is_fmi3() || keys.is_sorted();
        let fits = how.as_ref().is_none_or(|how| {
            on.as_ref().map(Vec::len) == Some(how.len()) && how.iter().all(|kind| kinds.contains(kind))
        });
        if !(told && once && in_order && fits && keys.iter().all(|key| knowns.contains(key))) {
            found.push(format!("{what}: dependencies of {} are not valid", name(key(row))));
        }
    }
}
