//! Sets numbers of a machine in the text of its file. Everything else is unchanged: comments,
//! units, paths of records.

use super::any_unit::quantity;
use super::named::candidates;
use super::reading::{FileTable, Reading};
use super::syntax;
use super::{Records, machine};
use crate::check::check_structure;
use crate::description::Description;
use crate::slots::{Slot, slots};
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use vibro_numerics::quantities::{in_si, split};
use vibro_numerics::sorting::sort_by_key;

/// Largest difference between the number written and the number read back, in units of rounding: a
/// unit's factor rounds twice.
const ROUNDINGS: f64 = 4.0;

/// Returns the text of a machine's file with the numbers of another machine. A number that differs
/// is replaced in place, in its unit in the text. A number that the text leaves out is added next
/// to its siblings.
///
/// `None` if the result would not be read as the other machine: its elements differ, a number that
/// an expression determines differs, or a number is in a record.
///
/// ```
/// use vibro_machine::file::{no_records, parse, with_numbers};
///
/// let text = "name = \"A\" # by hand\n\
///     spring.k = { between = [\"ground\", \"b\"], stiffness = 2.0 }\n\
///     body.b = { mass = \"3 g\" }\n";
/// let other = [("body.b.mass", 4e-3), ("body.b.start.v", 2.0)];
/// let other = parse(text, "a.toml", &no_records)?.with(other)?;
/// let edited = with_numbers(text, &no_records, &other).unwrap();
/// assert!(edited.starts_with("name = \"A\" # by hand\n"));
/// assert!(edited.ends_with("body.b = { mass = \"4 g\", start.v = 2.0 }\n"));
/// # Ok::<(), vibro_machine::Refusal>(())
/// ```
pub fn with_numbers(text: &str, records: Records, other: &Description) -> Option<String> {
    let (mut own, places) = read(text, records)?;
    let mut other = other.clone();
    // A number that follows from a parameter has an expression instead.
    let following: HashSet<String> = own.following().into_iter().map(|own| own.name).collect();
    let mut edits: Vec<(Range<usize>, String)> = Vec::new();
    {
        let (own, other) = (slots(&mut own), slots(&mut other));
        if own.len() != other.len() {
            return None;
        }
        let differs =
            |(own, other): &(&Slot, &Slot)| *own.value != *other.value && !following.contains(&own.name);
        for (own, other) in own.iter().zip(&other).filter(differs) {
            let edit = places.of(text, &own.name).map(|span| replaced(text, span, other));
            edits.push(edit.unwrap_or_else(|| places.added(text, other))?);
        }
    }
    // Apply edits from the end, so that earlier places do not move.
    sort_by_key(&mut edits, |(span, _)| span.start);
    let mut edited = text.to_owned();
    edits.into_iter().rev().for_each(|(span, new)| edited.replace_range(span, &new));
    is_machine(&edited, records, other).then_some(edited)
}

/// Whether a text is read as this machine, up to the rounding of units.
fn is_machine(text: &str, records: Records, mut other: Description) -> bool {
    let Some((mut found, _)) = read(text, records) else { return false };
    let (own, wanted) = (slots(&mut found), slots(&mut other));
    let is_near =
        |(a, b): (&Slot, &Slot)| (*a.value - *b.value).abs() <= ROUNDINGS * f64::EPSILON * b.value.abs();
    if own.len() != wanted.len() || !own.iter().zip(&wanted).all(is_near) {
        return false;
    }
    own.into_iter().zip(wanted).for_each(|(own, wanted)| *own.value = *wanted.value);
    found == other
}

/// Returns the machine of a text, and the places of its numbers.
fn read(text: &str, records: Records) -> Option<(Description, Places)> {
    let (root, broken) = syntax::toml(text);
    let mut reading = Reading::new(text, records);
    let found = machine(&mut reading, &FileTable::root(root.get_ref()));
    let is_sound = broken.is_empty() && reading.problems.is_empty() && check_structure(&found).is_empty();
    is_sound.then(|| (found, Places(reading.spans())))
}

/// Spans of the values of a text, by their dotted names.
struct Places(HashMap<String, Range<usize>>);

impl Places {
    /// The span of a number of the machine.
    fn of(&self, text: &str, name: &str) -> Option<Range<usize>> {
        let parameter = format!("parameters.{name}");
        let own = self.0.get(name).or_else(|| self.0.get(&parameter));
        let is_own =
            |entry: &&String| candidates(entry).iter().any(|own| own == name) && !self.is_table(text, entry);
        own.or_else(|| self.0.get(self.0.keys().find(is_own)?)).cloned()
    }

    /// Returns the insertion of a number that a text leaves out, after a number of the same table,
    /// or of an enclosing table.
    fn added(&self, text: &str, slot: &Slot) -> Option<(Range<usize>, String)> {
        let ends = slot.name.match_indices('.').map(|(at, _)| at).rev();
        let mut found = ends.filter_map(|at| {
            let (table, key) = (&slot.name[..=at], &slot.name[at + 1..]);
            let is_in = |name: &&String| {
                name.strip_prefix(table)
                    .is_some_and(|rest| !rest.contains(['.', '[']) && !self.is_table(text, name))
            };
            // The last sibling, so that the order of the text is kept.
            let sibling = self.0.iter().filter(|(name, _)| is_in(name)).max_by_key(|(_, span)| span.end)?;
            Some((sibling.1.clone(), key))
        });
        let (span, key) = found.next()?;
        let before = text.get(..span.start)?.trim_end().strip_suffix('=')?.trim_end();
        let is_key = |c: char| c.is_alphanumeric() || "._-\"'".contains(c);
        let own = &before[before.trim_end_matches(is_key).len()..];
        let key = own.rsplit_once('.').map_or(key.to_owned(), |(table, _)| format!("{table}.{key}"));
        let behind = text.get(span.end..)?;
        let rest = behind.lines().next().unwrap_or("");
        // Within braces the next character is a comma or the brace.
        if rest.trim_start().starts_with([',', '}']) {
            return Some((span.end..span.end, format!(", {key} = {:?}", slot.value)));
        }
        let end = span.end + rest.len();
        Some((end..end, format!("\n{key} = {:?}", slot.value)))
    }

    /// Whether a value is a table in braces or an array.
    fn is_table(&self, text: &str, name: &str) -> bool {
        let value = self.0.get(name).and_then(|span| text.get(span.clone()));
        value.is_none_or(|value| value.starts_with(['{', '[']))
    }
}

/// Returns the replacement of a number, in its unit in the text.
fn replaced(text: &str, span: Range<usize>, slot: &Slot) -> Option<(Range<usize>, String)> {
    let written = text.get(span.clone())?;
    let Some(quote) = written.chars().next().filter(|c| ['"', '\''].contains(c)) else {
        return Some((span, format!("{:?}", slot.value)));
    };
    let inner = written.trim_matches(quote);
    let (_, symbol) = split(inner)?;
    let si = slot.kind.unit(slot.dimension);
    let own = || in_si(quantity(&format!("1 {symbol}"), "").ok()?.1, 1.0, symbol);
    let Some(unit) = in_si(si, 1.0, symbol).or_else(own)?.unit else {
        return Some((span, format!("{:?}", slot.value)));
    };
    // The shortest number in the unit that is read as the value, if there is one.
    let near = unit.number(*slot.value);
    let all = [near, near.next_up(), near.next_down()];
    let number = all.into_iter().find(|number| unit.si(*number) == *slot.value).unwrap_or(near);
    let space = if inner.trim_end_matches(symbol).ends_with(' ') { " " } else { "" };
    // Without an exponent a small number has hundreds of digits.
    let digits = if number == number.trunc() && number.abs() < 1e6 {
        format!("{number}")
    } else {
        format!("{number:?}")
    };
    Some((span, format!("{quote}{digits}{space}{symbol}{quote}")))
}
