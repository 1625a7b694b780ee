//! Reading of formulas of springs and dampers, and of springs across the motion.

use super::reading::{ASKED, Entry, FileTable, Reading};
use crate::description::{Across, Dimension};
use crate::formula::{Formula, VARIABLES};
use crate::kinds;
use crate::named::Expression;

/// Keys of a spring that cannot be combined with a formula.
const EXCLUDED: [&str; 3] = ["points", "series_damping", "slip"];
/// Keys of a spring that cannot be combined with `offset`.
const ALONG: [&str; 12] = [
    "points",
    "series_damping",
    "slip",
    "slider",
    "preload",
    "force",
    "quadratic",
    "cubic",
    "quartic",
    "quintic",
    "coefficient",
    "exponent",
];
/// Keys of a spring across the motion.
pub(super) const ACROSS: [&str; 2] = ["offset", "free_length"];

/// Reads the formula of a spring; the outer `None` if it is refused.
pub(super) fn of_spring(reading: &mut Reading, table: &FileTable) -> Option<Option<Formula>> {
    let Some(entry) = reading.optional(table, "force") else { return Some(None) };
    if let Some(other) = EXCLUDED.into_iter().find(|other| table.has(other)) {
        reading.refuse(&entry, format!("cannot be combined with `{other}`: use two springs in parallel"));
        return None;
    }
    formula(reading, &entry, "= k1 * e + k3 * e^3").map(Some)
}

/// Reads the formula of a damper; the outer `None` if it is refused.
pub(super) fn of_damper(reading: &mut Reading, table: &FileTable) -> Option<Option<Formula>> {
    let Some(entry) = reading.optional(table, "force") else { return Some(None) };
    let formula = formula(reading, &entry, "= c * tanh(rate / v)")?;
    if formula.depends_on_elongation() {
        reading.refuse(&entry, "the force of a damper cannot depend on `e`: use a spring");
        return None;
    }
    Some(Some(formula))
}

/// Reads a formula; its parameters are numbers that follow from the named parameters.
fn formula(reading: &mut Reading, entry: &Entry, example: &str) -> Option<Formula> {
    let allowed = format!("expected an expression of `e` and `rate`, such as \"{example}\"");
    let Some(text) = entry.value.as_str().map(str::trim) else {
        reading.refuse(entry, allowed);
        return None;
    };
    if text == ASKED {
        reading.note_names(ASKED, ["= e", "= rate"].into_iter());
    }
    let named = reading.named.clone();
    let parameters: Vec<(&str, f64)> = named.names().zip(named.values()).collect();
    let Some(expression) = text.strip_prefix('=') else {
        let is_formula = Formula::new(text, &parameters).is_ok();
        let text =
            if is_formula { format!("an expression begins with `=`; write \"= {text}\"") } else { allowed };
        reading.refuse(entry, text);
        return None;
    };
    if reading.named_refused {
        return None;
    }
    if let Some(name) = named.names().find(|name| VARIABLES.contains(name)) {
        let text = format!("`{name}` is a variable of formulas: give the parameter `{name}` another name");
        reading.refuse(entry, text);
        return None;
    }
    match Formula::new(expression, &parameters) {
        Err(text) => {
            reading.refuse(entry, text);
            None
        }
        Ok(formula) => {
            for name in formula.names() {
                let own = Expression::parse(name, named.names());
                let follow = own.map(|own| (format!("{}.{name}", entry.name), own));
                reading.follow.extend(follow);
            }
            Some(formula)
        }
    }
}

/// Whether a table has keys of a spring across the motion.
pub(super) fn is_across(table: &FileTable) -> bool {
    ACROSS.iter().any(|key| table.has(key))
}

/// Reads offset and free length; `Some(None)` if there are none, `None` if they are refused.
pub(super) fn across(
    reading: &mut Reading,
    table: &FileTable,
    dimension: Dimension,
) -> Option<Option<Across>> {
    if !is_across(table) {
        return Some(None);
    }
    let pairs = [
        ("offset", "free_length", "the length of the unloaded spring"),
        ("free_length", "offset", "the distance of the fixed end from the line of the motion"),
    ];
    for (key, other, meaning) in pairs {
        if !table.has(other) {
            reading.excluded(table, key, &format!("requires `{other}`, {meaning}"));
            return None;
        }
    }
    let offset = reading.required_number(table, "offset", kinds::OFFSET, Dimension::Translation);
    let free_length =
        reading.required_number(table, "free_length", kinds::FREE_LENGTH, Dimension::Translation);
    let mut is_sound = true;
    let entry = reading.optional(table, "offset");
    if let (Some(entry), Dimension::Rotation) = (&entry, dimension) {
        reading.refuse(entry, "requires an elongation in m: the spring lies across a translation");
        is_sound = false;
    }
    for key in ALONG {
        if let Some(other) = reading.optional(table, key) {
            let text = "cannot be combined with `offset`: use two springs in parallel";
            reading.refuse(&other, text);
            is_sound = false;
        }
    }
    if let Some(other) = reading.optional(table, "stiffness").filter(|own| own.value.is_table()) {
        let text = "a stiffness that steps in time cannot be combined with `offset`: expected a number";
        reading.refuse(&other, text);
        is_sound = false;
    }
    Some(Some(Across { offset: offset?, free_length: free_length? })).filter(|_| is_sound)
}
