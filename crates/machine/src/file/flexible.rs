//! Reading of bodies with many coordinates, and of nodes on them.

use super::bodies::{DIMENSIONS, Names};
use super::matrices;
use super::numbers::finite;
use super::reading::{Entry, FileTable, Reading};
use super::residual;
use crate::check::{MOST_COORDINATES, problem_of_name};
use crate::description::{Body, BodyKind, Description, Dimension, Free, Modal};
use crate::kernel::sort_by_place;
use crate::kinds::{self, NumberKind};

/// Message that lists the allowed rows of a node.
const ROW: &str = "expected a row of finite numbers, one for each coordinate and not all 0; \
                   the index of one coordinate, counted from 0, such as 17; \
                   a table of indices and factors, such as { \"17\" = 0.5, \"18\" = 0.5 }; \
                   or a table of directions, such as { x = [...], y = [...] }";

/// Reads the bodies in modal coordinates. The nodes of a body with problems keep their names, so
/// that elements that refer to them can be read.
pub(super) fn read(reading: &mut Reading, root: &FileTable, names: &mut Names, machine: &mut Description) {
    for (name, table) in reading.section(root, "modal") {
        let modal = modal(reading, &name, &table, machine);
        let count = modal.as_ref().map(|modal| modal.frequencies.len());
        nodes(reading, &name, &table, count, names, machine);
        let residual = residual::read(reading, &name, &table, names);
        machine.modals.extend(modal.map(|own| Modal { residual, ..own }));
    }
}

fn modal(reading: &mut Reading, name: &str, table: &FileTable, machine: &mut Description) -> Option<Modal> {
    reading
        .known(table, &["frequencies", "damping_ratio", "masses", "gravity", "start", "nodes", "residual"]);
    let allowed = "expected a list of natural frequencies, such as [\"12 Hz\", \"75 Hz\"]";
    let entry = reading.required(table, "frequencies", allowed)?;
    let frequencies = list(reading, &entry, kinds::NATURAL, None, allowed)?;
    if frequencies.is_empty() || frequencies.len() > MOST_COORDINATES {
        reading.refuse(&entry, format!("expected 1 to {MOST_COORDINATES} frequencies"));
        return None;
    }
    let count = frequencies.len();
    let damping_ratios = match reading.optional(table, "damping_ratio") {
        None => Some(vec![0.0]),
        Some(entry) if entry.value.is_array() => of_modes(reading, &entry, kinds::RATIO, count),
        Some(entry) => reading.number(&entry, kinds::RATIO, Dimension::Translation).map(|one| vec![one]),
    };
    let mut per_mode = |table: &FileTable, key: &str, kind, default: f64| match reading.optional(table, key) {
        None => Some(vec![default; count]),
        Some(entry) => of_modes(reading, &entry, kind, count),
    };
    let masses = per_mode(table, "masses", kinds::MODAL_MASS, 1.0);
    let gravity = per_mode(table, "gravity", kinds::SHARE, 0.0);
    let starts = start(reading, table, count, machine.starts_at_rest);
    let (masses, gravity, [q, v]) = (masses?, gravity?, starts?);
    let first = machine.bodies.len();
    for i in 0..count {
        let free = Free { inertia: masses[i], gravity: gravity[i], s: q[i], v: v[i] };
        let (name, dimension) = (Description::name_of_coordinate(name, i), Dimension::Translation);
        machine.bodies.push(Body { name, dimension, kind: BodyKind::Free(free) });
    }
    let (name, has_masses) = (name.to_owned(), table.has("masses"));
    Some(Modal { name, first, frequencies, damping_ratios: damping_ratios?, has_masses, residual: None })
}

/// Reads start values of coordinates and rates.
pub(super) fn start(
    reading: &mut Reading,
    table: &FileTable,
    count: usize,
    at_rest: bool,
) -> Option<[Vec<f64>; 2]> {
    let zero = vec![0.0; count];
    let Some(entry) = reading.optional(table, "start") else { return Some([zero.clone(), zero]) };
    let start = reading.table(&entry, "expected a table such as { q = [0.0, 0.1], v = [0.0, 0.0] }")?;
    if at_rest {
        let text = "cannot be combined with `start = \"rest\"`, the start of the machine: remove one of them";
        reading.refuse_table(&start, text);
        return None;
    }
    reading.known(&start, &["q", "v"]);
    let mut own = |key| match reading.optional(&start, key) {
        None => Some(zero.clone()),
        Some(entry) => of_modes(reading, &entry, kinds::INNER_START, count),
    };
    let (q, v) = (own("q"), own("v"));
    Some([q?, v?])
}

pub(super) fn of_modes(
    reading: &mut Reading,
    entry: &Entry,
    kind: NumberKind,
    count: usize,
) -> Option<Vec<f64>> {
    let allowed = format!("expected a list of {count} numbers, one for each coordinate");
    list(reading, entry, kind, Some(count), &allowed)
}

/// Reads a list of numbers.
pub(super) fn list(
    reading: &mut Reading,
    entry: &Entry,
    kind: NumberKind,
    count: Option<usize>,
    allowed: &str,
) -> Option<Vec<f64>> {
    let items = reading.items(entry).filter(|items| count.is_none_or(|count| items.len() == count));
    let Some(items) = items else {
        reading.refuse(entry, allowed);
        return None;
    };
    let found: Vec<Option<f64>> =
        items.iter().map(|item| reading.number(item, kind, Dimension::Translation)).collect();
    found.into_iter().collect()
}

/// Reads the nodes of a body with `count` coordinates, which are the last bodies so far.
fn nodes(
    reading: &mut Reading,
    name: &str,
    table: &FileTable,
    count: Option<usize>,
    names: &mut Names,
    machine: &mut Description,
) {
    for i in 0..count.unwrap_or(0) {
        names.add(Description::name_of_coordinate(name, i), Some(Dimension::Translation));
    }
    let Some(entry) = reading.optional(table, "nodes") else { return };
    let Some(table) = reading.table(&entry, "expected a table of nodes, such as { tip = [1.9, -2.0] }")
    else {
        return;
    };
    let first = machine.bodies.len() - count.unwrap_or(0);
    for entry in named_nodes(reading, &table) {
        let (dimension, row) = node(reading, &entry, count);
        let name = format!("{name}.{}", entry.key);
        names.add(name.clone(), dimension);
        if let (Some(row), Some(dimension)) = (row, dimension) {
            let row = row.into_iter().map(|(k, factor)| (first + k, factor)).collect();
            machine.bodies.push(Body { name, dimension, kind: BodyKind::Node(row) });
        }
    }
}

/// The nodes of a table, each with its name, such as `tip` or, for a node with directions, `tip.x`.
pub(super) fn named_nodes<'t>(reading: &mut Reading, table: &FileTable<'t>) -> Vec<Entry<'t>> {
    let is_name = |key: &str| problem_of_name(key).is_none();
    let mut all = Vec::new();
    for entry in reading.all(table) {
        if !is_name(&entry.key) {
            reading.refuse(&entry, problem_of_name(&entry.key).unwrap_or_default());
        }
        let is_direction = |key: &str| is_name(key) && !["row", "dimension"].contains(&key);
        let directions =
            entry.value.as_table().filter(|own| own.keys().all(|key| is_direction(key.get_ref())));
        let Some(entries) = directions.filter(|own| !own.is_empty()) else {
            all.push(entry);
            continue;
        };
        let inner = FileTable { name: entry.name.clone(), line: entry.line, entries };
        all.extend(reading.all(&inner).into_iter().map(|own| own.below(&entry.key)));
    }
    all
}

/// Indices and factors of a node's row.
pub(super) type Row = Vec<(usize, f64)>;

/// Reads the dimension and the row of a node.
pub(super) fn node(
    reading: &mut Reading,
    entry: &Entry,
    count: Option<usize>,
) -> (Option<Dimension>, Option<Row>) {
    let own = entry.value.as_table().filter(|own| own.contains_key("row") || own.contains_key("dimension"));
    let Some(entries) = own else { return (Some(Dimension::Translation), row(reading, entry, count)) };
    let table = FileTable { name: entry.name.clone(), line: entry.line, entries };
    reading.known(&table, &["row", "dimension"]);
    let dimension = match reading.optional(&table, "dimension") {
        None => Some(Dimension::Translation),
        Some(entry) => reading.word(&entry, &DIMENSIONS),
    };
    let found = reading.required(&table, "row", ROW).and_then(|entry| row(reading, &entry, count));
    (dimension, found)
}

/// Reads the row of a node from a file with one row or one column.
fn of_file(reading: &mut Reading, entry: &Entry, count: usize) -> Option<Row> {
    let found = matrices::read(reading, entry)?;
    let is_row = found.nrows().min(found.ncols()) == 1 && found.len() == count && found.amax() > 0.0;
    if !is_row {
        let text = format!(
            "is a {} × {} matrix (rows × columns), but there are {count} coordinates; {ROW}",
            found.nrows(),
            found.ncols()
        );
        reading.refuse(entry, text);
        return None;
    }
    Some(found.iter().copied().enumerate().filter(|term| term.1 != 0.0).collect())
}

/// Reads the row of a node, without zeros and with rising indices. Returns `None` without a
/// problem if the body was refused.
fn row(reading: &mut Reading, entry: &Entry, count: Option<usize>) -> Option<Row> {
    let count = count?;
    let place = |text: &str| text.parse().ok().filter(|k: &usize| *k < count);
    if entry.value.is_str() {
        return of_file(reading, entry, count);
    }
    let found: Option<Row> = if let Some(table) = entry.value.as_table() {
        table.iter().map(|(key, value)| Some((place(key.get_ref())?, finite(value.get_ref())?))).collect()
    } else if let Some(items) = entry.value.as_array() {
        let items = items.iter().enumerate().map(|(k, item)| Some((k, finite(item.get_ref())?)));
        items.collect::<Option<Row>>().filter(|row| row.len() == count)
    } else {
        let whole =
            finite(entry.value).filter(|x| entry.value.is_integer() && (0.0..count as f64).contains(x));
        whole.map(|k| vec![(k as usize, 1.0)])
    };
    let found = found.map(|mut row| {
        row.retain(|term| term.1 != 0.0);
        sort_by_place(&mut row);
        row
    });
    let found = found.filter(|row| !row.is_empty());
    if found.is_none() {
        let text = match entry.value.as_array() {
            Some(items) if items.len() != count => {
                format!(
                    "the row has the length {}; expected {count}, one number for each coordinate",
                    items.len()
                )
            }
            Some(items) if items.iter().all(|item| finite(item.get_ref()) == Some(0.0)) => {
                "every entry is 0; expected at least one other number".into()
            }
            None if entry.value.is_integer() => {
                format!("expected the index of a coordinate, 0 to {}", count - 1)
            }
            _ => format!("there are {count} coordinates, 0 to {}; {ROW}", count - 1),
        };
        reading.refuse(entry, text);
    }
    found
}
