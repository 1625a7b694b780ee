//! Reading of a start: its time, coordinates and rates of bodies, inner places of springs in
//! series and of contacts with friction, states of blocks.

use super::no_records;
use super::reading::{FileTable, Reading};
use super::syntax;
use crate::description::{Description, Dimension};
use crate::kinds;
use crate::refusal::Refusal;
use crate::start::{BodyStart, Start};
use crate::system::{InSeries, in_series};
use std::collections::BTreeMap;

impl Start {
    /// Reads the text of a start's file; messages call the file `file`:
    ///
    /// ```toml
    /// time = 0.123
    /// [body.box]
    /// s = "2 mm"
    /// v = 0.1
    /// ```
    ///
    /// # Errors
    /// A [`Refusal`] with every problem found.
    pub fn parse(text: &str, file: &str, d: &Description) -> Result<Self, Refusal> {
        start(text, file, d)
    }

    /// Reads a start's file.
    ///
    /// # Errors
    /// As [`parse`](Self::parse), or the reason why the file cannot be read.
    pub fn read(path: &std::path::Path, d: &Description) -> Result<Self, Refusal> {
        Self::parse(&super::text_of(path)?, &path.display().to_string(), d)
    }
}

/// Reads the text of a start's file.
fn start(text: &str, file: &str, d: &Description) -> Result<Start, Refusal> {
    let refusal = |problems| Refusal { file: file.into(), problems };
    let (root, broken) = syntax::toml(text);
    if !broken.is_empty() {
        return Err(refusal(broken));
    }
    let mut reading = Reading::new(text, &no_records);
    let found = of_root(&mut reading, &FileTable::root(root.get_ref()), d);
    match reading.finish() {
        problems if problems.is_empty() => Ok(found),
        problems => Err(refusal(problems)),
    }
}

fn of_root(reading: &mut Reading, root: &FileTable, d: &Description) -> Start {
    reading.known(root, &["time", "body", "spring", "contact", "block"]);
    let mut start = Start::default();
    if let Some(time) = reading.required_number(root, "time", kinds::TIME, Dimension::Translation) {
        start.time = time;
    }
    let (springs, contacts) = ("no spring in series has this name", "no contact with friction has this name");
    start.sliders = sliders(reading, root, d, ("spring", springs));
    start.contacts = sliders(reading, root, d, ("contact", contacts));
    blocks(reading, root, d, &mut start);
    let Some(whole) = reading.optional(root, "body") else { return start };
    const TABLES: &str = "expected tables with names, such as [body.NAME]";
    let Some(whole) = reading.table(&whole, TABLES) else { return start };
    for entry in reading.all(&whole) {
        let Some(body) = d.bodies.iter().find(|body| body.name == entry.key) else {
            let names = d.bodies.iter().map(|body| body.name.as_str());
            reading.refuse_name(&entry, &entry.key, "no body has this name", names);
            continue;
        };
        let Some(table) = reading.table(&entry, "expected a table such as { s = 0.0, v = 0.0 }") else {
            continue;
        };
        if body.kind.is_prescribed() {
            reading.refuse_table(&table, "its motion is prescribed; use a body with mass or inertia");
            continue;
        }
        reading.known(&table, &["s", "v"]);
        let mut number = |key, kind| {
            let entry = reading.optional(&table, key)?;
            reading.number(&entry, kind, body.dimension)
        };
        let given = BodyStart { s: number("s", kinds::START), v: number("v", kinds::START_RATE) };
        start.bodies.insert(body.name.clone(), given);
    }
    start
}

/// Reads the inner places of the springs in series, or of the contacts, of a section.
fn sliders(
    reading: &mut Reading,
    root: &FileTable,
    d: &Description,
    (section, unknown): (&str, &str),
) -> BTreeMap<String, f64> {
    let mut all = BTreeMap::new();
    let Some(whole) = reading.optional(root, section) else { return all };
    let allowed = format!("expected tables with names, such as [{section}.NAME]");
    let Some(whole) = reading.table(&whole, &allowed) else { return all };
    for entry in reading.all(&whole) {
        // `[spring]` also accepts contacts, because a start written as `NAME.slider=VALUE` does
        // not say which of the two NAME is.
        let is_own = |own: &InSeries| own.section == section || section == "spring";
        let known = in_series(d).filter(is_own);
        let Some(own) = known.clone().find(|own| own.name == entry.key) else {
            reading.refuse_name(&entry, &entry.key, unknown, known.map(|own| own.name));
            continue;
        };
        let Some(table) = reading.table(&entry, "expected a table such as { slider = 0.0 }") else {
            continue;
        };
        // A contact with two tangents has two sliders. The start may give one of them alone.
        let is_same = |other: &InSeries| (other.section, other.name) == (own.section, own.name);
        let these: Vec<InSeries> = known.filter(is_same).collect();
        let words: Vec<String> = these.iter().map(|own| format!("slider{}", own.index)).collect();
        reading.known(&table, &words.iter().map(String::as_str).collect::<Vec<_>>());
        for (own, word) in these.iter().zip(&words) {
            if these.len() > 1 && !table.has(word) {
                continue;
            }
            let slider = reading.required_number(&table, word, kinds::SLIDER, own.arms.dimension);
            all.extend(slider.map(|slider| (own.key(), slider)));
        }
    }
    all
}

/// Reads the states of blocks, by their names: `"pid.x[0]" = 0.1`.
fn blocks(reading: &mut Reading, root: &FileTable, d: &Description, start: &mut Start) {
    let Some(whole) = reading.optional(root, "block") else { return };
    let allowed = "expected a table such as [block] with \"pid.x[0]\" = 0.0";
    let Some(table) = reading.table(&whole, allowed) else { return };
    let names = d.names_of_blocks();
    for entry in reading.all(&table) {
        if !names.contains(&entry.key) {
            let all = names.iter().map(String::as_str);
            reading.refuse_name(&entry, &entry.key, "no block stores a number of this name", all);
            continue;
        }
        let value = reading.number(&entry, kinds::BLOCK_START, Dimension::Translation);
        start.blocks.extend(value.map(|value| (entry.key.clone(), value)));
    }
}
