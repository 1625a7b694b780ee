//! Names, and how much there is of everything.

use super::MOST;
use crate::description::{Description, Signal};
use crate::refusal::Problem;
use std::collections::HashMap;

/// Letters of a name: FMU variables and columns of tables are named after it.
const LONGEST: usize = 100;

/// What a name consists of.
const NAME: &str = "allowed are up to 100 characters of A to Z, a to z, 0 to 9 and _, a letter first";

/// What is wrong with a name, if anything.
pub(crate) fn problem_of(name: &str) -> Option<&'static str> {
    let letters = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let good = letters && name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.len() <= LONGEST;
    (!good).then_some(NAME)
}

/// Elements of every kind, as section and name.
fn elements(machine: &Description) -> impl Iterator<Item = (&'static str, &str)> {
    let springs = machine.springs.iter().map(|s| ("spring", s.name.as_str()));
    let stops = machine.stops.iter().map(|s| ("stop", s.name.as_str()));
    let frictions = machine.frictions.iter().map(|f| ("friction", f.name.as_str()));
    let links = machine.links.iter().map(|l| ("link", l.name.as_str()));
    let loads = machine.loads.iter().map(|l| ("load", l.name.as_str()));
    springs.chain(stops).chain(frictions).chain(links).chain(loads)
}

/// Problems of the names and of the numbers of things.
pub(super) fn check(machine: &Description) -> Vec<Problem> {
    let mut problems = Vec::new();
    if let Some(text) = problem_of(&machine.name) {
        problems.push(Problem::new("name", Some(format!("{:?}", machine.name)), text));
    }
    unique(machine.bodies.iter().map(|b| ("body", b.name.as_str())), &mut problems);
    unique(elements(machine), &mut problems);
    if machine.bodies.iter().any(|b| b.name == "ground") {
        problems.push(Problem::new(
            "body.ground",
            None,
            "`ground` is what stands still; allowed is another name",
        ));
    }
    let counts = [
        ("body", machine.bodies.len()),
        ("elements", elements(machine).count()),
        ("harmonics and steps", signals(machine).map(|s| s.harmonics.len() + s.steps.len()).sum()),
    ];
    for (name, count) in counts {
        if count > MOST {
            problems.push(Problem::new(name, None, format!("there are {count}; allowed are up to {MOST}")));
        }
    }
    problems
}

fn signals(machine: &Description) -> impl Iterator<Item = &Signal> {
    super::signals(machine).map(|(_, signal)| signal)
}

/// Names are well formed, and each is there once: outputs of elements are called by name without
/// their section.
fn unique<'a>(names: impl Iterator<Item = (&'static str, &'a str)>, problems: &mut Vec<Problem>) {
    let mut first = HashMap::new();
    for (section, name) in names {
        let dotted = format!("{section}.{name}");
        if let Some(text) = problem_of(name) {
            problems.push(Problem::new(dotted, None, text));
        } else if let Some(other) = first.insert(name, section) {
            let same = other == section;
            let text = if same {
                "is there twice".into()
            } else {
                format!("another element has this name: {other}.{name}")
            };
            problems.push(Problem::new(dotted, None, text));
        }
    }
}
