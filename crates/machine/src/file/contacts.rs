//! Reading of contacts with a normal stiffness.

use super::bodies::Names;
use super::elements::{End, NO_BODY, between, joined, levers};
use super::reading::{Entry, FileTable, Reading};
use crate::check::RIGID;
use crate::description::{Arms, Closing, Contact, Description, Dimension, Tangent};
use crate::kinds::{self, NumberKind};
use crate::refusal::Problem;
use crate::slots::TANGENTS;

/// Keys of a contact.
const KEYS: [&str; 12] = [
    "between",
    "normal",
    "tangent",
    "second_tangent",
    "cone",
    "gap",
    "preload",
    "stiffness",
    "damping",
    "tangential_stiffness",
    "friction",
    "slider",
];

/// Keys that a contact does not have, with the reason.
const OTHERS: [(&str, &str); 7] = [
    (
        "restitution",
        "is not supported in a contact: laws of rigid contact with friction disagree (Newton, Poisson, Routh); \
         use `stiffness`, or [stop.NAME] for a rigid stop without friction",
    ),
    ("static_friction", "is not supported: the tangential force would jump; use `friction` alone"),
    ("static_coefficient", "is not supported: the tangential force would jump; use `friction` alone"),
    ("coefficient", "is called `friction` in a contact"),
    ("mu", "is called `friction` in a contact"),
    ("tangents", "is not a key of a contact; use `tangent`, and `second_tangent` with `cone = \"box\"`"),
    ("tangential_damping", "is not supported in a contact; use a [damper.NAME] along the tangent"),
];

/// The cone of friction with two tangents.
const BOX: &str = "box";

/// The forms of a normal or tangent.
const ROW: &str = "expected a direction of the nodes in `between`, such as \"y\" or \"-y\"; two names, such as \
                   [\"ground\", \"box\"]; or { arms = { A = 1.0, B = -1.0 } }";

/// Reads the contacts.
pub(super) fn read(reading: &mut Reading, root: &FileTable, names: &Names, machine: &mut Description) {
    for (name, table) in reading.section(root, "contact") {
        machine.contacts.extend(contact(reading, name, &table, names));
    }
}

/// Reads a contact.
fn contact(reading: &mut Reading, name: String, table: &FileTable, names: &Names) -> Option<Contact> {
    let others = OTHERS.iter().map(|own| own.0).filter(|key| table.has(key));
    reading.known(table, &KEYS.into_iter().chain(others).collect::<Vec<_>>());
    OTHERS.iter().for_each(|(key, text)| reading.excluded(table, key, text));
    let before = reading.problems.len();
    let normal = row(reading, table, "normal", names);
    let closing = closing(reading, table);
    let stiffness = stiffness(reading, table);
    let damping = reading.number_or(table, "damping", kinds::DAMPING, Dimension::Translation, 0.0);
    let rubbing = rubbing(reading, table, names);
    let is_direction = |key: &str| table.entries.get(key).is_some_and(|own| own.get_ref().is_str());
    if !["normal", "tangent", "second_tangent"].into_iter().any(is_direction) && table.has("normal") {
        let text =
            "requires a direction in `normal`, such as \"y\"; remove it if `normal` names its own ends";
        reading.excluded(table, "between", text);
    }
    // The normal and the tangents have the same ends.
    for problem in reading.problems.split_off(before) {
        let is_same = |own: &Problem| (&own.name, &own.text) == (&problem.name, &problem.text);
        if !reading.problems[before..].iter().any(is_same) {
            reading.problems.push(problem);
        }
    }
    let (friction, tangents) = rubbing?;
    let (normal, closing, stiffness, damping) = (normal?, closing?, stiffness?, damping?);
    Some(Contact { name, normal, closing, stiffness, damping, friction, tangents })
}

fn stiffness(reading: &mut Reading, table: &FileTable) -> Option<f64> {
    if !table.has("stiffness") && !reading.has_residual() {
        reading.refuse_table(table, RIGID);
        return None;
    }
    if !table.has("stiffness") {
        reading.excluded(table, "preload", "requires `stiffness`: use `gap` for a rigid contact");
        reading.excluded(table, "damping", "requires `stiffness`");
        return Some(f64::INFINITY);
    }
    reading.required_number(table, "stiffness", kinds::NORMAL_STIFFNESS, Dimension::Translation)
}

fn closing(reading: &mut Reading, table: &FileTable) -> Option<Closing> {
    let mut number = |key, kind| reading.required_number(table, key, kind, Dimension::Translation);
    match (table.has("gap"), table.has("preload")) {
        (true, false) => number("gap", kinds::GAP).map(Closing::Gap),
        (false, true) => number("preload", kinds::CONTACT_PRELOAD).map(Closing::Preload),
        (true, true) => {
            let text = "cannot be combined with `gap`: use `gap` for the elongation at which the contact \
                        closes, or `preload` for the normal force at e = 0";
            reading.excluded(table, "preload", text);
            None
        }
        (false, false) => {
            let text = "requires `gap`, the elongation at which the contact closes, or `preload`, the normal \
                        force at e = 0";
            reading.refuse_table(table, text);
            None
        }
    }
}

/// Reads the coefficient of friction and the tangents; none for a contact without friction, `None`
/// if they are refused.
fn rubbing(reading: &mut Reading, table: &FileTable, names: &Names) -> Option<(f64, Vec<Tangent>)> {
    let own = ["friction", "tangential_stiffness", "tangent"];
    let others = ["slider", "second_tangent", "cone"];
    if !own.iter().chain(&others).any(|key| table.has(key)) {
        return Some((0.0, Vec::new()));
    }
    // A cone can be completed before the other keys are written.
    if let Some(entry) = reading.optional(table, "cone") {
        reading.note_names(entry.value.as_str().unwrap_or_default(), [BOX].into_iter());
    }
    let missing: Vec<String> =
        own.into_iter().filter(|key| !table.has(key)).map(|key| format!("`{key}`")).collect();
    if !missing.is_empty() {
        let given = own.into_iter().chain(others).filter(|key| table.has(key));
        for entry in given.filter_map(|key| reading.optional(table, key)).collect::<Vec<_>>() {
            let text = format!(
                "requires {}: friction acts along a tangent through a stiffness",
                missing.join(" and ")
            );
            reading.refuse(&entry, text);
        }
        return None;
    }
    let is_box = cone(reading, table);
    let count = if table.has("second_tangent") { 2 } else { 1 };
    let keys = TANGENTS.iter().take(count);
    let arms: Vec<Option<Arms>> = keys.map(|key| row(reading, table, key, names)).collect();
    let stiffness = each(reading, table, ("tangential_stiffness", kinds::TANGENTIAL_STIFFNESS), count);
    let line = Dimension::Translation;
    let friction = reading.required_number(table, "friction", kinds::FRICTION_OF_CONTACT, line);
    let slider = match table.has("slider") {
        true => each(reading, table, ("slider", kinds::SLIDER), count),
        false => Some(vec![0.0; count]),
    };
    let (_, friction, stiffness, slider) = (is_box?, friction?, stiffness?, slider?);
    let tangent = |(arms, (stiffness, slider))| Some(Tangent { arms: arms?, stiffness, slider });
    let all = arms.into_iter().zip(stiffness.into_iter().zip(slider)).map(tangent);
    Some((friction, all.collect::<Option<_>>()?))
}

/// Reads the cone of friction, which two tangents require; `None` if it is refused.
fn cone(reading: &mut Reading, table: &FileTable) -> Option<()> {
    const MEANING: &str =
        "with two tangents, \"box\" limits the force along each of them by friction times the normal force";
    let second = reading.optional(table, "second_tangent");
    let Some(entry) = reading.optional(table, "cone") else {
        let Some(second) = second else { return Some(()) };
        reading.refuse(&second, format!("requires `cone = \"box\"`: {MEANING}"));
        return None;
    };
    match entry.value.as_str() {
        Some(BOX) if second.is_none() => {
            reading.refuse(&entry, format!("requires `second_tangent`: {MEANING}"));
        }
        Some(BOX) => return Some(()),
        Some("circle") => reading.refuse(&entry, "is not piecewise linear; use `cone = \"box\"`"),
        None if entry.value.is_integer() || entry.value.is_float() => {
            reading.refuse(&entry, "a polygon is not supported; use `cone = \"box\"`");
        }
        _ => _ = reading.word(&entry, &[((), BOX)]),
    }
    None
}

/// Reads a number of each tangent: a number for one tangent, a list of two for two.
fn each(
    reading: &mut Reading,
    table: &FileTable,
    (key, kind): (&str, NumberKind),
    count: usize,
) -> Option<Vec<f64>> {
    let line = Dimension::Translation;
    if count == 1 {
        return Some(vec![reading.required_number(table, key, kind, line)?]);
    }
    let entry = reading.optional(table, key)?;
    let Some(items) = reading.items(&entry).filter(|items| items.len() == count) else {
        reading.refuse(&entry, "expected two numbers, one for each tangent, such as [1.0, 2.0]");
        return None;
    };
    let all: Vec<Option<f64>> = items.iter().map(|item| reading.number(item, kind, line)).collect();
    all.into_iter().collect()
}

/// Reads the elongation along the normal or a tangent, which is a length.
fn row(reading: &mut Reading, table: &FileTable, key: &str, names: &Names) -> Option<Arms> {
    let entry = reading.required(table, key, ROW)?;
    let arms = if entry.value.is_str() {
        direction(reading, table, &entry, names)
    } else if entry.value.is_array() {
        between(reading, &entry, names)
    } else {
        let inner = reading.table(&entry, ROW)?;
        reading.known(&inner, &["arms"]);
        let arms = reading.required(&inner, "arms", "expected a table such as { A = 1.0, B = -1.0 }")?;
        levers(reading, &arms, names)
    }?;
    if arms.dimension == Dimension::Rotation {
        let text = "is an angle; the normal and the tangent of a contact are lengths: use `arms` with a lever \
                    such as \"50 mm\"";
        reading.refuse(&entry, text);
        return None;
    }
    Some(arms)
}

/// Reads the elongation between two nodes in a direction, such as "y", or "-y" the other way.
fn direction(reading: &mut Reading, table: &FileTable, entry: &Entry, names: &Names) -> Option<Arms> {
    let said = entry.value.as_str().unwrap_or_default();
    let direction = said.strip_prefix('-').unwrap_or(said);
    let Some(ends) = reading.optional(table, "between") else {
        let text = "a direction requires `between = [A, B]` with names of nodes that have directions";
        reading.refuse(entry, text);
        return None;
    };
    let items = reading.items(&ends);
    let Some(items) = items.filter(|items| items.len() == 2) else {
        reading.refuse(&ends, "expected two names, such as [\"ground\", \"blade.tip\"]");
        return None;
    };
    let mut found: Vec<End> = Vec::new();
    for item in &items {
        let node = reading.string(item, "expected \"ground\" or the name of a node")?;
        if node == "ground" {
            found.push(None);
            continue;
        }
        let before = format!("{node}.");
        let directions: Vec<&str> =
            names.all().filter_map(|name| name.strip_prefix(before.as_str())).collect();
        if directions.is_empty() {
            let bodies = names.all().filter_map(|name| Some(name.rsplit_once('.')?.0));
            let said = match names.find(&node) {
                Some(_) if node.matches('.').count() > 1 => {
                    let (of, _) = node.rsplit_once('.').unwrap_or_default();
                    let text = format!(
                        "is a direction of the node `{of}`; expected the node, \"{of}\": `normal` and \
                         `tangent` give the directions"
                    );
                    reading.refuse(item, text);
                    return None;
                }
                Some(_) => {
                    let text = "it has no directions; use `normal = [A, B]`, or give the node directions, such as \
                                nodes.tip = { x = [...], y = [...] }";
                    reading.refuse(item, text);
                    return None;
                }
                None => NO_BODY,
            };
            reading.refuse_body(item, &node, said, bodies.chain(["ground"]));
            return None;
        }
        let Some(own) = names.find(&format!("{before}{direction}")) else {
            let text = format!("`{node}` has no such direction");
            reading.refuse_name(entry, direction, &text, directions.into_iter());
            return None;
        };
        found.push(Some(own));
    }
    let mut ends_of = [found[0], found[1]];
    if said.starts_with('-') {
        ends_of.reverse();
    }
    let same = "both ends are the same; expected two nodes, or ground and a node";
    let mixed = "cannot connect a translating and a rotating node directly";
    joined(reading, ends_of, [(&ends, same), (entry, mixed)])
}
