//! Names, and how much there is of everything.

use super::MOST;
use crate::description::Description;
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

/// Problems of the names and of the numbers of things.
pub(super) fn check(machine: &Description) -> Vec<Problem> {
    let mut problems = Vec::new();
    if let Some(text) = problem_of(&machine.name) {
        problems.push(Problem::new("name", Some(format!("{:?}", machine.name)), text));
    }
    unique(machine.bodies.iter().map(|b| ("body", b.name.as_str())), &mut problems);
    unique(machine.elements().map(|e| (e.section(), e.name())), &mut problems);
    if machine.bodies.iter().any(|b| b.name == "ground") {
        problems.push(Problem::new(
            "body.ground",
            None,
            "`ground` is what stands still; allowed is another name",
        ));
    }
    let counts = [
        ("body", machine.bodies.len()),
        ("elements", machine.elements().count()),
        (
            "harmonics and steps",
            machine.signals().map(|s| s.signal.harmonics.len() + s.signal.steps.len()).sum(),
        ),
    ];
    for (name, count) in counts {
        if count > MOST {
            problems.push(Problem::new(name, None, format!("there are {count}; allowed are up to {MOST}")));
        }
    }
    problems
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
