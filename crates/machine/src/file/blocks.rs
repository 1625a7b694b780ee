//! Reading of named signals and of linear blocks.

use super::bodies::Names;
use super::reading::{Entry, FileTable, Reading};
use super::signals::{self, Values};
use crate::description::{Block, BlockInput, Description, Dimension, Feed, Sampling, Source};
use crate::kinds::{self, NumberKind};
use crate::quantity::What;

const KEYS: [&str; 12] =
    ["inputs", "states", "start", "a", "b", "c", "d", "outputs", "limits", "sample", "delay", "quantum"];

/// Message that lists the quantities a block can read.
const READ: &str =
    "expected s or v of a body or node, e or rate of an element, a signal, or an output of a block";

/// Largest number of states, inputs or outputs of a block.
const MOST: f64 = 500.0;

/// Reads the signals that blocks read, and the blocks.
pub(super) fn read(reading: &mut Reading, root: &FileTable, names: &Names, machine: &mut Description) {
    for (name, table) in reading.section(root, "signal") {
        reading.known(&table, &signals::KEYS);
        let values = Values { kind: kinds::SIGNAL, alone: kinds::SIGNAL, dimension: Dimension::Translation };
        let signal = signals::flat(reading, &table, values, &[]);
        machine.sources.push(Source { name, signal: signal.unwrap_or_default() });
    }
    let section = reading.section(root, "block");
    // Blocks read each other, so the names of outputs are needed before inputs.
    let outputs: Vec<(String, Vec<String>)> =
        section.iter().map(|(name, table)| (name.clone(), outputs(reading, table))).collect();
    for ((name, table), (_, own)) in section.into_iter().zip(&outputs) {
        reading.known(&table, &KEYS);
        let block = block(reading, &table, own, &Known { names, machine, outputs: &outputs });
        machine.blocks.push(Block { name, outputs: own.clone(), ..block.unwrap_or_default() });
    }
}

/// Everything that inputs may name.
struct Known<'a> {
    names: &'a Names,
    machine: &'a Description,
    outputs: &'a [(String, Vec<String>)],
}

impl Known<'_> {
    /// All names of inputs.
    fn all(&self) -> Vec<String> {
        let bodies = self.names.all().flat_map(|body| ["s", "v"].map(|what| format!("{body}.{what}")));
        let elements = self.machine.elements().filter(|own| own.quantities().contains(&What::Rate));
        let elements = elements.flat_map(|own| ["e", "rate"].map(|what| format!("{}.{what}", own.name())));
        let sources = self.machine.sources.iter().map(|own| own.name.clone());
        let all = bodies.chain(elements.collect::<Vec<_>>()).chain(sources);
        all.chain(names_of(self.outputs)).collect()
    }

    /// Whether a name is of a block whose outputs were refused.
    fn is_refused(&self, name: &str) -> bool {
        let block = name.split('.').next();
        self.outputs.iter().any(|own| Some(own.0.as_str()) == block && own.1.is_empty())
    }

    fn find(&self, name: &str) -> Result<BlockInput, &'static str> {
        if let Some(place) = self.machine.sources.iter().position(|own| own.name == name) {
            return Ok(BlockInput::Source(place));
        }
        const UNKNOWN: &str = "no signal, body, element or block has this quantity";
        let (of, what) = name.rsplit_once('.').ok_or(UNKNOWN)?;
        if let Some((body, _)) = self.names.find(of) {
            match what {
                "s" => return Ok(BlockInput::Place(body)),
                "v" => return Ok(BlockInput::Rate(body)),
                "a" => {
                    return Err(
                        "is an acceleration, which depends on the block's own output at the same instant",
                    );
                }
                _ => {}
            }
        }
        if let Some(block) = self.outputs.iter().position(|own| own.0 == of) {
            let output = self.outputs[block].1.iter().position(|own| own == what);
            return output.map(|output| BlockInput::Output(block, output)).ok_or(UNKNOWN);
        }
        let Some((place, element)) = self.machine.elements().enumerate().find(|own| own.1.name() == of)
        else {
            return Err(UNKNOWN);
        };
        match what {
            "f" => Err(
                "is a force; forces of contact and sticking friction depend on the accelerations, and so \
                 on the block's own output, at the same instant",
            ),
            "e" if element.quantities().contains(&What::E) => Ok(BlockInput::Elongation(place)),
            "rate" if element.quantities().contains(&What::E) => Ok(BlockInput::ElongationRate(place)),
            _ => Err(UNKNOWN),
        }
    }
}

/// All outputs of blocks by name.
fn names_of(outputs: &[(String, Vec<String>)]) -> impl Iterator<Item = String> + '_ {
    outputs.iter().flat_map(|(block, own)| own.iter().map(move |output| format!("{block}.{output}")))
}

/// Returns the names of a block's outputs; empty if the list is refused.
fn outputs(reading: &mut Reading, table: &FileTable) -> Vec<String> {
    let allowed = "expected a list of names, such as [\"u\"]";
    let Some(entry) = reading.required(table, "outputs", allowed) else { return Vec::new() };
    let Some(items) = reading.items(&entry).filter(|items| !items.is_empty()) else {
        reading.refuse(&entry, allowed);
        return Vec::new();
    };
    let mut all: Vec<String> = Vec::new();
    for item in &items {
        let Some(name) = reading.string(item, allowed) else { continue };
        if let Some(text) = crate::check::problem_of_name(&name) {
            reading.refuse(item, text);
        } else if ["x", "start"].contains(&name.as_str()) {
            reading.refuse(item, "is reserved for states; use another name");
        } else if all.contains(&name) {
            reading.refuse(item, "is given twice; keep one of them");
        } else {
            all.push(name);
        }
    }
    if all.len() == items.len() { all } else { Vec::new() }
}

fn block(reading: &mut Reading, table: &FileTable, outputs: &[String], known: &Known) -> Option<Block> {
    let inputs = inputs(reading, table, known);
    let states = states(reading, table);
    // Rows belong to outputs: if outputs were refused, rows are not checked.
    let (count, states) = (inputs.as_ref().filter(|_| !outputs.is_empty())?.len(), states?);
    let rows = outputs.len();
    let a = matrix(reading, table, "a", [states, states], states > 0);
    let b = matrix(reading, table, "b", [states, count], states > 0 && count > 0);
    let c = matrix(reading, table, "c", [rows, states], states > 0);
    let d = matrix(reading, table, "d", [rows, count], states == 0 && count > 0);
    let start = start(reading, table, states);
    let limits = limits(reading, table, outputs);
    let names: Vec<String> = inputs.as_ref()?.iter().map(|own| own.1.clone()).collect();
    let inputs: Vec<BlockInput> = inputs?.into_iter().map(|own| own.0).collect();
    let block = Block { inputs, ..Block::default() };
    let (_, units) = known.machine.inputs_of(&block);
    let sampling = sampling(reading, table, &names, &units);
    let outputs = outputs.to_vec();
    let (name, inputs) = (String::new(), block.inputs);
    Some(Block {
        name,
        inputs,
        start: start?,
        a: a?,
        b: b?,
        c: c?,
        d: d?,
        outputs,
        limits: limits?,
        sampling: sampling?,
    })
}

/// Returns the inputs, each with its name.
fn inputs(reading: &mut Reading, table: &FileTable, known: &Known) -> Option<Vec<(BlockInput, String)>> {
    let allowed = "expected a list of names, such as [\"cart.s\", \"reference\"]";
    let entry = reading.required(table, "inputs", allowed)?;
    let Some(items) = reading.items(&entry).filter(|items| items.len() as f64 <= MOST) else {
        reading.refuse(&entry, allowed);
        return None;
    };
    let mut all = Vec::new();
    for item in &items {
        let Some(name) = reading.string(item, allowed) else { continue };
        match known.find(&name) {
            Ok(input) => all.push((input, name)),
            // The outputs of a refused block are unknown.
            Err(_) if known.is_refused(&name) => {}
            Err(text) if text.starts_with("is ") => reading.refuse(item, format!("{text}; {READ}")),
            Err(text) => {
                let names = known.all();
                reading.refuse_name(item, &name, text, names.iter().map(String::as_str));
            }
        }
    }
    (all.len() == items.len()).then_some(all)
}

/// Returns the number of states, from `states` or from the rows of `a`.
fn states(reading: &mut Reading, table: &FileTable) -> Option<usize> {
    let Some(entry) = reading.optional(table, "states") else {
        let rows = reading.optional(table, "a").and_then(|a| Some(reading.items(&a)?.len()));
        return Some(rows.unwrap_or(0));
    };
    let found = super::numbers::finite(entry.value).filter(|x| x.fract() == 0.0 && (0.0..=MOST).contains(x));
    if found.is_none() {
        reading.refuse(&entry, format!("expected a whole number from 0 to {MOST}"));
    }
    found.map(|count| count as usize)
}

/// Reads a matrix by rows; zeros if it may be left out.
fn matrix(
    reading: &mut Reading,
    table: &FileTable,
    key: &str,
    [rows, columns]: [usize; 2],
    is_required: bool,
) -> Option<Vec<Vec<f64>>> {
    let allowed =
        format!("expected a {rows} × {columns} matrix (rows × columns), such as {}", example(rows, columns));
    let entry = match is_required {
        true => reading.required(table, key, &allowed)?,
        false => match reading.optional(table, key) {
            Some(entry) => entry,
            None => return Some(vec![vec![0.0; columns]; rows]),
        },
    };
    let Some(items) = reading.items(&entry) else {
        reading.refuse(&entry, allowed);
        return None;
    };
    if items.is_empty() && rows * columns == 0 {
        return Some(vec![vec![0.0; columns]; rows]);
    }
    if items.len() != rows {
        reading.refuse(&entry, format!("has {}; {allowed}", counted(items.len(), "row")));
        return None;
    }
    let all: Vec<_> = items.iter().filter_map(|item| row(reading, item, columns, &allowed)).collect();
    (all.len() == rows).then_some(all)
}

fn example(rows: usize, columns: usize) -> String {
    let row = format!("[{}]", vec!["0.0"; columns.min(3)].join(", "));
    format!("[{}]", vec![row; rows.min(2)].join(", "))
}

/// A count with its noun: "1 row", "2 rows".
fn counted(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

fn row(reading: &mut Reading, entry: &Entry, count: usize, allowed: &str) -> Option<Vec<f64>> {
    match reading.items(entry) {
        Some(items) if items.len() == count => list(reading, &items, kinds::COEFFICIENT_OF_BLOCK),
        found => {
            let has = found.map(|items| format!("has {}; ", counted(items.len(), "number")));
            reading.refuse(entry, format!("{}{allowed}", has.unwrap_or_default()));
            None
        }
    }
}

fn list(reading: &mut Reading, items: &[Entry], kind: NumberKind) -> Option<Vec<f64>> {
    let number = |item: &Entry| reading.number(item, kind, Dimension::Translation);
    let all: Vec<f64> = items.iter().filter_map(number).collect();
    (all.len() == items.len()).then_some(all)
}

fn start(reading: &mut Reading, table: &FileTable, states: usize) -> Option<Vec<f64>> {
    let Some(entry) = reading.optional(table, "start") else { return Some(vec![0.0; states]) };
    let Some(items) = reading.items(&entry).filter(|items| items.len() == states) else {
        reading.refuse(&entry, format!("expected a list with one number for each state: {states}"));
        return None;
    };
    list(reading, &items, kinds::BLOCK_START)
}

/// Reads the limits of each output, if it has any.
fn limits(reading: &mut Reading, table: &FileTable, outputs: &[String]) -> Option<Vec<Option<[f64; 2]>>> {
    let mut all = vec![None; outputs.len()];
    let Some(entry) = reading.optional(table, "limits") else { return Some(all) };
    let allowed = "expected a table of outputs with two limits, such as { u = [-10, 10] }";
    let limits = reading.table(&entry, allowed)?;
    let (entries, mut is_sound) = (reading.all(&limits), true);
    for entry in &entries {
        let Some(place) = outputs.iter().position(|own| *own == entry.key) else {
            reading.refuse_name(
                entry,
                &entry.key,
                "no output has this name",
                outputs.iter().map(String::as_str),
            );
            is_sound = false;
            continue;
        };
        let items = reading.items(entry).unwrap_or_default();
        let [low, high] = &items[..] else {
            let text = "expected two limits, such as [-10, 10]; the lower may be -inf, the upper inf";
            reading.refuse(entry, text);
            is_sound = false;
            continue;
        };
        let both = [limit(reading, low, f64::NEG_INFINITY), limit(reading, high, f64::INFINITY)];
        match both {
            [Some(low), Some(high)] => all[place] = Some([low, high]),
            _ => is_sound = false,
        }
    }
    is_sound.then_some(all)
}

/// Reads a limit, which may be the value `infinite`.
fn limit(reading: &mut Reading, entry: &Entry, infinite: f64) -> Option<f64> {
    let toml::de::DeValue::Float(digits) = entry.value else {
        return reading.number(entry, kinds::OUTPUT_LIMIT, Dimension::Translation);
    };
    match digits.as_str().trim_start_matches('+').parse::<f64>() {
        Ok(value) if value == infinite => Some(value),
        Ok(value) if !value.is_finite() => {
            reading.refuse(entry, format!("expected a finite number or {infinite:?}"));
            None
        }
        _ => reading.number(entry, kinds::OUTPUT_LIMIT, Dimension::Translation),
    }
}

/// Reads the sampling of a block; `Some(None)` for a continuous block.
fn sampling(
    reading: &mut Reading,
    table: &FileTable,
    inputs: &[String],
    units: &[&'static str],
) -> Option<Option<Sampling>> {
    if !table.has("sample") {
        let found = ["delay", "quantum"].into_iter().filter_map(|key| reading.optional(table, key));
        let found: Vec<_> = found.collect();
        let text = "requires `sample`, the time between the samples of the block";
        found.iter().for_each(|entry| reading.refuse(entry, text));
        return found.is_empty().then_some(None);
    }
    let dimension = Dimension::Translation;
    let period = reading.required_number(table, "sample", kinds::SAMPLE, dimension);
    let delay = reading.number_or(table, "delay", kinds::DELAY, dimension, 0.0);
    let quanta = quanta(reading, table, inputs, units);
    Some(Some(Sampling { period: period?, delay: delay?, quanta: quanta? }))
}

/// Reads the quantum of each input; `cart = { s = … }` gives the quantum of `cart.s`.
fn quanta(
    reading: &mut Reading,
    table: &FileTable,
    inputs: &[String],
    units: &[&'static str],
) -> Option<Vec<Option<f64>>> {
    let mut all = vec![None; inputs.len()];
    let Some(entry) = reading.optional(table, "quantum") else { return Some(all) };
    let quanta = reading.table(&entry, "expected a table of inputs, such as { \"cart.s\" = 5e-8 }")?;
    let mut is_sound = true;
    for entry in nested(reading, &quanta, inputs) {
        let Some(place) = inputs.iter().position(|own| *own == entry.key) else {
            let names = inputs.iter().map(String::as_str);
            reading.refuse_name(&entry, &entry.key, "no input of this block has this name", names);
            is_sound = false;
            continue;
        };
        let found = reading.number(&entry, kinds::quantum(units[place]), Dimension::Translation);
        // An input that is named twice is rounded both times.
        for (own, name) in all.iter_mut().zip(inputs).filter(|(_, name)| **name == entry.key) {
            debug_assert_eq!(*name, entry.key);
            *own = found;
        }
        is_sound &= found.is_some();
    }
    is_sound.then_some(all)
}

/// Returns all entries; entries of nested tables have the names of both tables.
fn nested<'t>(reading: &mut Reading, table: &FileTable<'t>, inputs: &[String]) -> Vec<Entry<'t>> {
    let mut all = Vec::new();
    for entry in reading.all(table) {
        match entry.value.as_table().filter(|_| !inputs.contains(&entry.key)) {
            Some(entries) => {
                let inner = FileTable { name: entry.name.clone(), line: entry.line, entries };
                all.extend(nested(reading, &inner, &[]).into_iter().map(|own| own.below(&entry.key)));
            }
            None => all.push(entry),
        }
    }
    all
}

/// Reads the output that a load follows (`from = "pid.u"`), after the blocks have been read.
pub(super) fn follow(
    reading: &mut Reading,
    from: &Entry,
    (load, factor): (usize, f64),
    machine: &Description,
) -> Option<Feed> {
    let name = reading.string(from, "expected an output of a block, such as \"pid.u\"")?;
    let all = machine
        .blocks
        .iter()
        .enumerate()
        .flat_map(|(block, own)| (0..own.outputs.len()).map(move |output| (block, output)));
    let all: Vec<_> = all.map(|place| (machine.name_of_output(place), place)).collect();
    match all.iter().find(|own| own.0 == name) {
        Some(&(_, (block, output))) => Some(Feed { load, block, output, factor }),
        None => {
            // The outputs of a refused block are unknown.
            let block = name.split('.').next().unwrap_or("");
            let is_known = machine.blocks.iter().any(|own| own.name == block && !own.outputs.is_empty());
            if !is_known && !reading.problems.is_empty() && reading.has_read(&format!("block.{block}")) {
                return None;
            }
            if all.is_empty() {
                reading.refuse(from, "no block has this output: the machine has no block");
                return None;
            }
            let names = all.iter().map(|own| own.0.as_str());
            reading.refuse_name(from, &name, "no block has this output", names);
            None
        }
    }
}
