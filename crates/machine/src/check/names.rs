//! Checks of names and counts.

use super::MOST;
use crate::description::{Body, BodyKind, Description};
use crate::elements::Element;
use crate::refusal::Problem;
use std::collections::{HashMap, HashSet};

/// Largest number of letters in a name; FMU variables and table columns repeat names.
const LONGEST: usize = 100;

/// The allowed names, in words.
const NAME: &str = "expected a name of letters (A-Z, a-z), digits and _, beginning with a letter, at most 100 \
                    characters long";
/// The fault of a body called `ground`.
pub(crate) const GROUND: &str = "`ground` is the fixed frame; use another name";

/// The problem of a name, if it has one.
pub(crate) fn problem_of(name: &str) -> Option<&'static str> {
    let letters = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let good = letters && name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.len() <= LONGEST;
    (!good).then_some(NAME)
}

/// Problems of names and counts.
pub(super) fn check(machine: &Description) -> Vec<Problem> {
    let mut problems = Vec::new();
    if let Some(text) = problem_of(&machine.name) {
        problems.push(Problem::new("name", Some(format!("{:?}", machine.name)), text));
    }
    let made = |b: &&Body| b.is_inner() || matches!(b.kind, BodyKind::Node(_));
    unique(machine.bodies.iter().filter(|b| !made(b)).map(|b| ("body", b.name.as_str())), &mut problems);
    made_names(machine.bodies.iter().filter(made), &mut problems);
    unique(machine.elements().map(|e| (e.section(), e.name())), &mut problems);
    apart(machine, &mut problems);
    if machine.bodies.iter().any(|b| b.name == "ground") {
        problems.push(Problem::new("body.ground", None, GROUND));
    }
    let counts = [
        ("body", machine.bodies.len()),
        ("elements", machine.elements().count()),
        (
            "harmonics and steps",
            machine
                .signals()
                .map(|s| s.signal.harmonics.len() + s.signal.sweeps.len() + s.signal.steps.len())
                .sum(),
        ),
    ];
    for (name, count) in counts {
        if count > MOST {
            problems.push(Problem::new(name, None, format!("there are {count}; expected at most {MOST}")));
        }
    }
    problems
}

/// Problems of the names of coordinates and nodes of bodies with many coordinates: `beam.q[3]`,
/// `beam.tip`.
fn made_names<'a>(bodies: impl Iterator<Item = &'a Body>, problems: &mut Vec<Problem>) {
    let mut seen = HashSet::new();
    for body in bodies {
        let (of, last) = body.name.split_once('.').unwrap_or((&body.name, ""));
        let last = if body.is_inner() { last.split('[').next().unwrap_or(last) } else { last };
        // A node with directions has the direction after its name.
        let mut parts = std::iter::once(of).chain(last.splitn(2, '.'));
        if let Some(text) = parts.find_map(problem_of) {
            problems.push(Problem::new(format!("body.{}", body.name), None, text));
        } else if !seen.insert(&body.name) {
            problems.push(Problem::new(&body.name, None, "is given twice; keep one of them"));
        }
    }
}

/// Problems of names that must be well formed and unique. Elements of different sections cannot
/// share a name, since outputs are named without the section.
fn unique<'a>(names: impl Iterator<Item = (&'static str, &'a str)>, problems: &mut Vec<Problem>) {
    let mut first = HashMap::new();
    for (section, name) in names {
        let dotted = format!("{section}.{name}");
        if let Some(text) = problem_of(name) {
            problems.push(Problem::new(dotted, None, text));
        } else if let Some(other) = first.insert(name, section) {
            let same = other == section;
            let text = if same {
                "is given twice; keep one of them".into()
            } else {
                format!("another element has this name: {other}.{name}")
            };
            problems.push(Problem::new(dotted, None, text));
        }
    }
}

/// Problems of signals and blocks with the name of a body: inputs are named without a section.
fn apart(machine: &Description, problems: &mut Vec<Problem>) {
    let computed = machine.elements().filter(|e| matches!(e, Element::Source(_) | Element::Block(_)));
    for element in computed.filter(|e| machine.bodies.iter().any(|body| body.name == e.name())) {
        let text = format!("a body has this name: body.{}", element.name());
        problems.push(Problem::new(element.dotted(), None, text));
    }
    for name in machine.elements().map(Element::name).filter(|name| *name == "time" || *name == "energy") {
        let is_computed = machine.sources.iter().any(|own| own.name == name);
        if is_computed {
            problems.push(Problem::new(
                format!("signal.{name}"),
                None,
                "this name is reserved; use another name",
            ));
        }
    }
}
