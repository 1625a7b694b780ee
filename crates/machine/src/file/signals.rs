//! Reading of signals: a number, or a table of constant, harmonics, sweeps, steps, record and
//! input. The signal is their sum.

use super::reading::{Entry, FileTable, Reading};
use super::records::{self, RecordValues};
use crate::description::{Dimension, Harmonic, Interpolation, Record, Signal, Step, Sweep, SweepLaw};
use crate::kinds::{self, NumberKind};

/// The keys of a signal.
pub(super) const KEYS: [&str; 12] = [
    "constant",
    "harmonics",
    "amplitude",
    "frequency",
    "phase",
    "sweep",
    "steps",
    "table",
    "interpolation",
    "scale",
    "repeat",
    "input",
];

/// Kinds of number of a signal's values.
#[derive(Clone, Copy)]
pub(super) struct Values {
    /// Kind of number of each part.
    pub kind: NumberKind,
    /// Kind of number of a signal that is a single number.
    pub alone: NumberKind,
    pub dimension: Dimension,
}

/// Part of a message about a number that may also be a signal.
const OR_SIGNAL: &str = ", or a signal such as { amplitude = 1.0, frequency = \"10 Hz\" }";

/// Reads a signal: a number with or without a unit, or a table.
pub(super) fn value(reading: &mut Reading, entry: &Entry, values: Values) -> Option<Signal> {
    if entry.value.is_table() {
        let table = reading.table(entry, "")?;
        reading.known(&table, &KEYS);
        return flat(reading, &table, values, &[]);
    }
    let kind = NumberKind { or: OR_SIGNAL, ..values.alone };
    Some(Signal::constant(reading.number(entry, kind, values.dimension)?))
}

/// Reads a signal whose keys are in a table together with the keys `also`; at least one of all
/// these must be present. A key `offset` in `also` is another name for `constant`.
pub(super) fn flat(
    reading: &mut Reading,
    table: &FileTable,
    values: Values,
    also: &[&str],
) -> Option<Signal> {
    if !KEYS.iter().chain(also).any(|key| table.has(key)) {
        let parts = ["constant", "amplitude with frequency", "harmonics", "sweep", "steps", "table", "input"];
        let parts: Vec<_> = parts.iter().chain(also).copied().collect();
        reading.refuse_table(table, format!("requires one or more of {}", parts.join(", ")));
        return None;
    }
    let constant = constant(reading, table, values, also.contains(&"offset"));
    let harmonics = harmonics(reading, table, values);
    let sweeps = sweeps(reading, table, values);
    let steps = steps(reading, table, values);
    let record = record(reading, table, values);
    let repeat = repeat(reading, table, values);
    let input = input(reading, table);
    Some(Signal {
        constant: constant?,
        harmonics: harmonics?,
        sweeps: sweeps?,
        steps: steps?,
        table: record?,
        repeat: repeat?,
        input: input?,
    })
}

fn constant(reading: &mut Reading, table: &FileTable, values: Values, offset: bool) -> Option<f64> {
    if offset && let Some(entry) = reading.optional(table, "offset") {
        if table.has("constant") {
            let text = "cannot be combined with `constant`, which means the same: use one of them";
            reading.refuse(&entry, text);
            return None;
        }
        return reading.number(&entry, values.kind, values.dimension);
    }
    reading.number_or(table, "constant", values.kind, values.dimension, 0.0)
}

fn harmonics(reading: &mut Reading, table: &FileTable, values: Values) -> Option<Vec<Harmonic>> {
    let short = ["amplitude", "frequency", "phase"].into_iter().find(|key| table.has(key));
    let Some(list) = reading.optional(table, "harmonics") else {
        return match short {
            Some(_) => Some(vec![harmonic(reading, table, values)?]),
            None => Some(Vec::new()),
        };
    };
    if let Some(entry) = short.and_then(|key| reading.optional(table, key)) {
        let text = "cannot be combined with `harmonics`: use `amplitude`, `frequency` and `phase` \
                    for one harmonic, or `harmonics` for a list of them";
        reading.refuse(&entry, text);
        return None;
    }
    let allowed = "expected a list such as [{ amplitude = 1.0, frequency = \"10 Hz\", phase = 0.0 }]";
    let Some(items) = reading.items(&list) else {
        reading.refuse(&list, allowed);
        return None;
    };
    if items.is_empty() {
        reading.refuse(&list, format!("is empty; {allowed}"));
        return None;
    }
    let mut all = Vec::new();
    for item in &items {
        let Some(table) = reading.table(item, allowed) else { continue };
        reading.known(&table, &["amplitude", "frequency", "phase"]);
        all.extend(harmonic(reading, &table, values));
    }
    (all.len() == items.len()).then_some(all)
}

fn harmonic(reading: &mut Reading, table: &FileTable, values: Values) -> Option<Harmonic> {
    let amplitude = reading.required_number(table, "amplitude", values.kind, values.dimension);
    let frequency = reading.required_number(table, "frequency", kinds::FREQUENCY, values.dimension);
    let phase = reading.number_or(table, "phase", kinds::PHASE, values.dimension, 0.0);
    Some(Harmonic { amplitude: amplitude?, frequency: frequency?, phase: phase? })
}

/// Reads one sweep or a list of them.
fn sweeps(reading: &mut Reading, table: &FileTable, values: Values) -> Option<Vec<Sweep>> {
    let Some(entry) = reading.optional(table, "sweep") else { return Some(Vec::new()) };
    let items = if entry.value.is_table() { None } else { reading.items(&entry) };
    let allowed = "expected a sweep such as { amplitude = 1.0, from = \"5 Hz\", to = \"15 Hz\", \
                   duration = \"60 s\" }, or a list of sweeps";
    if items.as_ref().is_some_and(Vec::is_empty) {
        reading.refuse(&entry, format!("is empty; {allowed}"));
        return None;
    }
    let items = items.unwrap_or_else(|| vec![entry]);
    let mut all = Vec::new();
    for item in &items {
        let Some(table) = reading.table(item, allowed) else { continue };
        reading.known(&table, &["amplitude", "from", "to", "duration", "phase", "law"]);
        all.extend(sweep(reading, &table, values));
    }
    (all.len() == items.len()).then_some(all)
}

fn sweep(reading: &mut Reading, table: &FileTable, values: Values) -> Option<Sweep> {
    let amplitude = reading.required_number(table, "amplitude", values.kind, values.dimension);
    let [from, to] =
        ["from", "to"].map(|key| reading.required_number(table, key, kinds::SWEPT, values.dimension));
    let duration = reading.required_number(table, "duration", kinds::DURATION, values.dimension);
    let phase = reading.number_or(table, "phase", kinds::PHASE, values.dimension, 0.0);
    let law = match reading.optional(table, "law") {
        None => Some(SweepLaw::Linear),
        Some(entry) => reading.word(&entry, &SweepLaw::ALL),
    };
    Some(Sweep { amplitude: amplitude?, from: from?, to: to?, duration: duration?, phase: phase?, law: law? })
}

/// Reads a list of pairs of time and value.
fn pairs(reading: &mut Reading, list: &Entry, values: Values, allowed: &str) -> Option<Vec<(f64, f64)>> {
    let Some(items) = reading.items(list) else {
        reading.refuse(list, allowed);
        return None;
    };
    if !items.is_empty() && items.iter().all(|item| item.value.as_array().is_none()) {
        reading.refuse(list, allowed);
        return None;
    }
    let mut all = Vec::with_capacity(items.len());
    for item in &items {
        let pair = reading.items(item);
        let Some([time, value]) = pair.as_deref() else {
            reading.refuse(item, allowed);
            continue;
        };
        let time = reading.number(time, kinds::TIME, values.dimension);
        let value = reading.number(value, values.kind, values.dimension);
        all.extend(time.zip(value));
    }
    (all.len() == items.len()).then_some(all)
}

fn steps(reading: &mut Reading, table: &FileTable, values: Values) -> Option<Vec<Step>> {
    let Some(list) = reading.optional(table, "steps") else { return Some(Vec::new()) };
    let allowed = "expected a list of [time, height], such as [[0.4, 20.0]]";
    let pairs = pairs(reading, &list, values, allowed)?;
    if pairs.is_empty() {
        reading.refuse(&list, format!("is empty; {allowed}"));
        return None;
    }
    Some(pairs.into_iter().map(|(time, height)| Step { time, height }).collect())
}

/// Reads the record of a signal, if it has one; the outer `None` means a problem.
fn record(reading: &mut Reading, table: &FileTable, values: Values) -> Option<Option<Record>> {
    let interpolation = interpolation(reading, table);
    let scale = scale(reading, table, values);
    let Some(found) = reading.optional(table, "table") else {
        for key in ["interpolation", "scale"] {
            if let Some(entry) = reading.optional(table, key) {
                let what = if key == "scale" { "multiply" } else { "interpolate" };
                reading.refuse(&entry, format!("requires `table`, the record to {what}"));
            }
        }
        let is_sound = !table.has("interpolation") && !table.has("scale");
        return is_sound.then_some(None);
    };
    // If a scale is given, the values are plain numbers.
    let has_scale = table.has("scale");
    let values = if has_scale { Values { kind: kinds::PLAIN, ..values } } else { values };
    let knots = match found.value.as_str() {
        Some(path) => {
            let Values { kind, dimension, .. } = values;
            let knots = records::read(path, reading.records, RecordValues { kind, dimension, has_scale });
            knots.map_err(|problem| reading.refuse(&found, problem)).ok()
        }
        None => {
            let allowed = "expected a file such as \"record.csv\", or a list of [time, value]";
            pairs(reading, &found, values, allowed)
        }
    };
    Some(Some(Record { knots: knots?, scale: scale?, interpolation: interpolation? }))
}

fn interpolation(reading: &mut Reading, table: &FileTable) -> Option<Interpolation> {
    let Some(entry) = reading.optional(table, "interpolation") else { return Some(Interpolation::Straight) };
    reading.word(&entry, &Interpolation::ALL)
}

/// Reads the factor of a record's values, if it has one; the outer `None` means a problem.
fn scale(reading: &mut Reading, table: &FileTable, values: Values) -> Option<Option<f64>> {
    match reading.optional(table, "scale") {
        Some(entry) => reading.number(&entry, kinds::scale_of(values.kind), values.dimension).map(Some),
        None => Some(None),
    }
}

/// Reads the period of steps and record, if there is one; the outer `None` means a problem.
fn repeat(reading: &mut Reading, table: &FileTable, values: Values) -> Option<Option<f64>> {
    let Some(entry) = reading.optional(table, "repeat") else { return Some(None) };
    if !table.has("steps") && !table.has("table") {
        reading.refuse(&entry, "requires `steps` or `table`, which it repeats");
        return None;
    }
    reading.number(&entry, kinds::PERIOD, values.dimension).map(Some)
}

fn input(reading: &mut Reading, table: &FileTable) -> Option<bool> {
    let Some(entry) = reading.optional(table, "input") else { return Some(false) };
    let found = entry.value.as_bool();
    if found.is_none() {
        reading.refuse(&entry, "expected true or false, without quotation marks");
    }
    found
}
