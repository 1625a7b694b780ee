//! Reading of bodies with mass or inertia, and of bodies with prescribed motion.

use super::reading::{FileTable, Reading};
use super::signals::{self, Values};
use crate::check::problem_of_name;
use crate::description::{Body, BodyKind, Description, Dimension, Free, Integrated, Level, Signal};
use crate::elements::SECTIONS;
use crate::kinds::{self, NumberKind};
use crate::parameters::has_unit;
use crate::refusal::Problem;
use toml::de::DeValue;

/// Message with the keys for the kind of a body, which needs exactly one of them.
const KINDS: &str = "`mass` for a body that translates, `inertia` for a body that rotates, \
                     or `motion` for a prescribed motion";

/// Dimensions, each with its word in a file.
pub(super) const DIMENSIONS: [(Dimension, &str); 2] =
    [(Dimension::Translation, "translation"), (Dimension::Rotation, "rotation")];

/// Names of the bodies in the file's order, with their dimensions if these are known.
pub(super) struct Names(Vec<(String, Option<Dimension>)>);

impl Names {
    /// Adds a body.
    pub fn add(&mut self, name: String, dimension: Option<Dimension>) {
        self.0.push((name, dimension));
    }

    /// The index of a body and its dimension.
    pub fn find(&self, name: &str) -> Option<(usize, Option<Dimension>)> {
        self.0.iter().position(|body| body.0 == name).map(|place| (place, self.0[place].1))
    }

    /// All names.
    pub fn all(&self) -> impl Iterator<Item = &str> + Clone {
        let is_good = |name: &str| name.split('.').all(|part| problem_of_name(part).is_none());
        self.0.iter().map(|body| body.0.as_str()).filter(move |name| is_good(name) && *name != "ground")
    }
}

/// Reads the bodies. A body with problems keeps its name, so that elements that refer to it can be
/// read.
pub(super) fn read(
    reading: &mut Reading,
    root: &FileTable,
    section: &[(String, FileTable)],
    machine: &mut Description,
) -> Names {
    let mut names = Vec::new();
    for (name, table) in section {
        let body = body(reading, name, table, root, machine.starts_at_rest);
        names.push((name.clone(), body.as_ref().map(|body| body.0)));
        if let Some((dimension, kind)) = body {
            machine.bodies.push(Body { name: name.clone(), dimension, kind });
        }
    }
    Names(names)
}

fn body(
    reading: &mut Reading,
    name: &str,
    table: &FileTable,
    root: &FileTable,
    at_rest: bool,
) -> Option<(Dimension, BodyKind)> {
    let given: Vec<_> = ["mass", "inertia", "motion"].into_iter().filter(|key| table.has(key)).collect();
    match given[..] {
        ["mass"] => {
            Some((Dimension::Translation, free(reading, table, "mass", Dimension::Translation, at_rest)))
        }
        ["inertia"] => {
            Some((Dimension::Rotation, free(reading, table, "inertia", Dimension::Rotation, at_rest)))
        }
        ["motion"] => prescribed(reading, name, table, root),
        _ => {
            reading.known(table, &["mass", "inertia", "motion", "dimension", "gravity", "start"]);
            let text = match given.len() {
                0 => format!("requires {KINDS}"),
                _ => format!("`{}` cannot be combined: use {KINDS}", given.join("` and `")),
            };
            reading.refuse_table(table, text);
            None
        }
    }
}

fn free(
    reading: &mut Reading,
    table: &FileTable,
    key: &str,
    dimension: Dimension,
    at_rest: bool,
) -> BodyKind {
    reading.known(table, &[key, "gravity", "start"]);
    if dimension == Dimension::Rotation {
        let text = "requires `mass`: gravity exerts no torque on a body with `inertia`";
        reading.excluded(table, "gravity", text);
    }
    let mut free = Free { inertia: f64::NAN, gravity: 0.0, s: 0.0, v: 0.0 };
    if let Some(inertia) = reading.required_number(table, key, kinds::INERTIA, dimension) {
        free.inertia = inertia;
    }
    if dimension == Dimension::Translation {
        free.gravity = reading.number_or(table, "gravity", kinds::COSINE, dimension, 0.0).unwrap_or(0.0);
    }
    let Some(entry) = reading.optional(table, "start") else { return BodyKind::Free(free) };
    if let Some(start) = reading.table(&entry, "expected a table such as { s = 0.0, v = 0.0 }") {
        reading.known(&start, &["s", "v"]);
        free.s = reading.number_or(&start, "s", kinds::START, dimension, 0.0).unwrap_or(0.0);
        free.v = reading.number_or(&start, "v", kinds::START_RATE, dimension, 0.0).unwrap_or(0.0);
        if at_rest && (free.s, free.v) == (0.0, 0.0) {
            // A zero start next to "rest" is refused as well: it would contradict the equilibrium
            // after a change of a parameter.
            reading.refuse_table(
                &start,
                "cannot be combined with `start = \"rest\"`, the start of the machine: remove one of them",
            );
        }
    }
    BodyKind::Free(free)
}

fn prescribed(
    reading: &mut Reading,
    name: &str,
    table: &FileTable,
    root: &FileTable,
) -> Option<(Dimension, BodyKind)> {
    reading.known(table, &["motion", "dimension", "start", "gravity"]);
    for key in ["start", "gravity"] {
        reading.excluded(table, key, "cannot be combined with `motion`, which determines the body's motion");
    }
    let dimension = dimension(reading, name, table, root)?;
    let entry = reading.optional(table, "motion")?;
    let values = Values { kind: kinds::POSITION, alone: kinds::POSITION, dimension };
    let (motion, rate) = if entry.value.is_table() {
        let table = reading.table(&entry, "")?;
        if let Some(level) = level(&table) {
            return Some((dimension, integrated(reading, &table, level, dimension)));
        }
        reading.known(&table, &[&signals::KEYS[..], &["offset", "rate", "acceleration"]].concat());
        let rate = reading.number_or(&table, "rate", kinds::RATE, dimension, 0.0);
        (signals::flat(reading, &table, values, &["offset", "rate", "acceleration"]), rate)
    } else {
        (signals::value(reading, &entry, values), Some(0.0))
    };
    let motion = motion.unwrap_or_else(|| Signal::constant(f64::NAN));
    Some((dimension, BodyKind::Prescribed { motion, rate: rate.unwrap_or(f64::NAN) }))
}

/// Returns the level that the signal of a motion gives, unless it is the coordinate. A number
/// `rate` is a uniform motion added to the coordinate's signal.
fn level(table: &FileTable) -> Option<Level> {
    let rate = table.entries.get("rate").is_some_and(|rate| rate.get_ref().is_table());
    match table.has("acceleration") {
        true => Some(Level::Acceleration),
        false => rate.then_some(Level::Rate),
    }
}

/// Reads a motion whose rate or acceleration is a signal. The coordinate follows from it, so that
/// only the coordinate's value at time 0 may be given as well.
fn integrated(reading: &mut Reading, table: &FileTable, level: Level, dimension: Dimension) -> BodyKind {
    let (key, kind) = match level {
        Level::Rate => ("rate", kinds::DRIVEN_RATE),
        Level::Acceleration => ("acceleration", kinds::ACCELERATION),
    };
    let beside = if level == Level::Rate { &["s"][..] } else { &["s", "v"] };
    let mut place = None;
    for entry in reading.all(table) {
        let own = entry.key.as_str();
        match own {
            "s" | "constant" | "offset" if place.is_some() => {
                reading.refuse(
                    &entry,
                    "the position at time 0 is given twice; use one of `s`, `constant` and `offset`",
                );
            }
            "s" | "constant" | "offset" => {
                place = Some(reading.number(&entry, kinds::START, dimension).unwrap_or(f64::NAN));
            }
            _ if own == key || beside.contains(&own) => {}
            _ if own == "v" || own == "rate" || signals::KEYS.contains(&own) => {
                let text = format!(
                    "cannot be combined with `{key}`, which determines the motion: use `{}` for the start",
                    beside.join("` and `")
                );
                reading.refuse(&entry, text);
            }
            _ => {
                let valid = std::iter::once(key).chain(beside.iter().copied());
                reading.refuse_name(&entry, own, "no such key", valid);
            }
        }
    }
    let values = Values { kind, alone: kind, dimension };
    let signal = reading.optional(table, key).and_then(|entry| signals::value(reading, &entry, values));
    let v = if level == Level::Rate {
        Some(0.0)
    } else {
        reading.number_or(table, "v", kinds::START_RATE, dimension, 0.0)
    };
    BodyKind::Integrated(Integrated {
        level,
        signal: signal.unwrap_or_else(|| Signal::constant(f64::NAN)),
        s: place.unwrap_or(0.0),
        v: v.unwrap_or(f64::NAN),
    })
}

/// Returns the dimension of a prescribed body: from its key `dimension`; otherwise from the first
/// unit in its motion; otherwise from the body with mass or inertia at the other end of an element
/// `between` both; otherwise a length.
fn dimension(reading: &mut Reading, name: &str, table: &FileTable, root: &FileTable) -> Option<Dimension> {
    if let Some(entry) = reading.optional(table, "dimension") {
        return reading.word(&entry, &DIMENSIONS);
    }
    let motion = table.entries.get("motion").map(|motion| motion.get_ref());
    let unit = motion.and_then(unit_of);
    Some(unit.or_else(|| neighbour(name, root)).unwrap_or(Dimension::Translation))
}

/// Returns the dimension of the first value with a unit in a motion; frequencies, phases and times
/// do not count.
fn unit_of(motion: &DeValue) -> Option<Dimension> {
    match motion {
        DeValue::String(text) => {
            let is = |kind: NumberKind, dimension| has_unit(kind.unit(dimension), text);
            let all = [Dimension::Translation, Dimension::Rotation];
            let kinds = [kinds::POSITION, kinds::RATE, kinds::ACCELERATION];
            all.into_iter().find(|&d| kinds.into_iter().any(|kind| is(kind, d)))
        }
        DeValue::Table(table) => {
            let direct = ["constant", "offset", "s", "v", "rate", "acceleration", "amplitude", "scale"];
            let direct = direct.into_iter().filter_map(|key| table.get(key));
            let items = |key| table.get(key).and_then(|list| list.get_ref().as_array()).into_iter().flatten();
            let sweep = table.get("sweep").filter(|sweep| sweep.get_ref().is_table()).into_iter();
            let waves = items("harmonics").chain(items("sweep")).chain(sweep);
            let harmonics = waves.filter_map(|item| item.get_ref().get("amplitude"));
            let pairs = items("steps").chain(items("table")).filter_map(|item| item.get_ref().get(1));
            direct.chain(harmonics).chain(pairs).find_map(|value| unit_of(value.get_ref()))
        }
        _ => None,
    }
}

/// Returns the dimension of the first body with mass or inertia at the other end of an element
/// `between` it and this body.
fn neighbour(name: &str, root: &FileTable) -> Option<Dimension> {
    let sections = SECTIONS.into_iter().filter_map(|(section, _)| root.entries.get(section));
    let elements =
        sections.filter_map(|section| section.get_ref().as_table()).flat_map(|section| section.values());
    let pairs = elements.filter_map(|element| element.get_ref().get("between")?.get_ref().as_array());
    let ends = pairs.filter(|pair| pair.iter().any(|end| end.get_ref().as_str() == Some(name)));
    let mut others = ends.flat_map(|pair| pair.iter()).filter_map(|end| end.get_ref().as_str());
    others.find_map(|other| {
        let body = root.entries.get("body")?.get_ref().get(other)?.get_ref();
        match (body.get("mass").is_some(), body.get("inertia").is_some()) {
            (true, false) => Some(Dimension::Translation),
            (false, true) => Some(Dimension::Rotation),
            _ => None,
        }
    })
}

/// Refuses bodies with gravity in a file without `gravity`.
pub(super) fn without_gravity(reading: &mut Reading, machine: &Description) {
    let text = "requires `gravity` at the top level of the file, such as `gravity = \"9.81 m/s2\"`";
    for body in &machine.bodies {
        if let BodyKind::Free(Free { gravity, .. }) = body.kind
            && gravity != 0.0
            && !body.is_inner()
        {
            let name = format!("body.{}.gravity", body.name);
            reading.place(Problem::new(name, Some(format!("{gravity:?}")), text));
        }
    }
    let heavy =
        |place: usize| matches!(machine.bodies[place].kind, BodyKind::Free(free) if free.gravity != 0.0);
    for element in machine.elements().filter(|element| element.coordinates().any(heavy)) {
        reading.place(Problem::new(format!("{}.gravity", element.dotted()), None, text));
    }
}
