//! Reading of `[parameters]`, and the assignment of expressions to numbers of the machine.

use super::any_unit::quantity;
use super::numbers::{finite, without_sign};
use super::reading::{Entry, FileTable, Reading};
use crate::check::problem_of_name;
use crate::description::Description;
use crate::elements::SECTIONS;
use crate::named::{Expression, Named, NamedParameters};
use crate::slots::{EXPONENT, slots};
use std::collections::HashSet;
use vibro_numerics::quantities::UNITS;

/// Largest number of named parameters.
const MOST: usize = 1_000;

/// Message that lists the allowed values of a parameter.
const VALUE: &str = "expected a number, with or without a unit, or an expression such as \"= backlash / 2\"";

/// Reads the named parameters; if there are problems, none is kept.
pub(super) fn read(reading: &mut Reading, root: &FileTable) {
    let before = reading.problems.len();
    reading.named = all(reading, root);
    reading.named_refused = reading.problems.len() > before;
}

fn all(reading: &mut Reading, root: &FileTable) -> NamedParameters {
    let none = NamedParameters::default();
    let Some(whole) = reading.optional(root, "parameters") else { return none };
    let allowed = "expected a table such as [parameters] with backlash = \"0.1 mm\"";
    let Some(table) = reading.table(&whole, allowed) else { return none };
    let entries = reading.all(&table);
    if entries.len() > MOST {
        let text = format!("there are {}; expected at most {MOST}", entries.len());
        reading.refuse_table(&table, text);
        return none;
    }
    let names: Vec<String> = entries.iter().map(|entry| entry.key.clone()).collect();
    let before = reading.problems.len();
    let all: Vec<_> = entries.iter().filter_map(|entry| parameter(reading, entry, &names)).collect();
    if reading.problems.len() > before {
        return none;
    }
    NamedParameters::new(all).unwrap_or_else(|(place, text)| {
        reading.refuse(&entries[place], text);
        none
    })
}

fn parameter(reading: &mut Reading, entry: &Entry, names: &[String]) -> Option<Named> {
    let reserved = ["gravity", "name", "start", "time", "parameters", "body", "signal", "pi"];
    if let Some(text) = problem_of_name(&entry.key) {
        reading.refuse(entry, text);
    } else if SECTIONS.iter().map(|section| section.0).chain(reserved).any(|own| own == entry.key) {
        reading.refuse(entry, "this name is reserved; use another name");
    }
    let (name, number) = (entry.key.clone(), |value| (value, "1", None));
    let text = entry.value.as_str().map(str::trim);
    let found = match text.map(|text| (text, text.strip_prefix('='))) {
        None => finite(entry.value).map(number).ok_or_else(|| VALUE.to_owned()),
        Some((_, Some(text))) => Expression::parse(text, names.iter().map(String::as_str))
            .map(|expression| (f64::NAN, "1", Some(expression))),
        Some((text, None)) => {
            reading.note_number(entry, UNITS.iter().map(|unit| unit.symbol), || VALUE.to_owned());
            match without_sign(text, names.iter().map(String::as_str)) {
                Some(fault) => Err(fault),
                None => quantity(text, VALUE).map(|(value, unit)| (value, unit, None)),
            }
        }
    };
    match found {
        Ok((value, unit, expression)) => {
            let comment = reading.comment(entry);
            Some(Named { name, unit, value, expression, comment })
        }
        Err(text) => {
            reading.refuse(entry, text);
            None
        }
    }
}

/// Moves the expressions into the machine, by the names of their numbers.
pub(super) fn put(reading: &mut Reading, machine: &mut Description) {
    let follow = std::mem::take(&mut reading.follow);
    if follow.is_empty() {
        machine.named = std::mem::take(&mut reading.named);
        return;
    }
    machine.named = std::mem::take(&mut reading.named);
    // An exponent is a number of the machine only with an expression.
    let (exponents, follow): (Vec<_>, Vec<_>) =
        follow.into_iter().partition(|(entry, _)| entry.ends_with(EXPONENT));
    exponents.into_iter().for_each(|(name, expression)| machine.named.put(name, expression));
    let names: HashSet<String> = slots(machine).into_iter().map(|slot| slot.name).collect();
    for (entry, expression) in follow {
        match candidates(&entry).into_iter().find(|name| names.contains(name)) {
            Some(name) => machine.named.put(name, expression),
            // If elements are refused, their numbers are missing.
            None if !reading.problems.is_empty() => {}
            None => {
                reading.refuse_name_of(&entry, "an expression in a record is not supported; use a number")
            }
        }
    }
}

/// Possible names of a number in the machine, from its name in the file.
pub(super) fn candidates(entry: &str) -> [String; 10] {
    let replaced = |end: &str, by: &str| {
        let cut = entry.strip_suffix(end).unwrap_or(entry);
        if cut.len() < entry.len() { format!("{cut}{by}") } else { entry.to_owned() }
    };
    let step = match entry.rsplit_once(',') {
        Some((of, "0]")) if of.contains(".steps[") => format!("{of}].time"),
        Some((of, "1]")) if of.contains(".steps[") => format!("{of}].height"),
        Some((of, "0]")) if of.contains(".points[") => format!("{of}].e"),
        Some((of, "1]")) if of.contains(".points[") => format!("{of}].f"),
        _ => entry.to_owned(),
    };
    let one = entry.replace(".harmonics[0].", ".");
    [
        entry.to_owned(),
        one,
        step,
        replaced(".offset", ".constant"),
        replaced(".constant", ""),
        entry.replace(".sweep[0].", ".sweep."),
        replaced(".motion.constant", ".motion.s"),
        replaced(".motion.offset", ".motion.s"),
        replaced(".scale", ".table.scale"),
        format!("{entry}.constant"),
    ]
}
