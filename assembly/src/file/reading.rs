//! State of a reading, shared by all parts of the file's reader: values with their lines, known
//! keys, and problems.

use super::Records;
use crate::description::Dimension;
use crate::kinds::Kind;
use crate::parameters;
use crate::refusal::{Problem, SHOWN, advice, cut};
use std::collections::HashMap;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

/// Longest value quoted by a message, characters.
const QUOTED: usize = 60;

/// The text parsed as TOML, and its first syntax error.
pub(super) fn toml(text: &str) -> (Spanned<DeTable<'_>>, Vec<Problem>) {
    let (root, errors) = DeTable::parse_recoverable(text);
    // Further errors are mostly consequences of the first.
    let problem = errors.first().map(|error| {
        let span = error.span().unwrap_or(0..0);
        let line = Lines::of(text).of_byte(span.start);
        let (value, said) = (quoted(text, &span), error.message());
        match said.contains("duplicate") {
            true => Problem {
                line: Some(line),
                name: dotted_at(text, span.start),
                value: None,
                text: "is there twice".into(),
            },
            false => {
                let text = if value.is_empty() { said.into() } else { format!("{said}: {value}") };
                Problem { line: Some(line), name: String::new(), value: None, text }
            }
        }
    });
    (root, problem.into_iter().collect())
}

/// The dotted name at a byte: that of the header in its line, or of the header above and the key.
fn dotted_at(text: &str, byte: usize) -> String {
    let start = text[..byte].rfind('\n').map_or(0, |at| at + 1);
    let line = text[start..].lines().next().unwrap_or("").trim();
    let header = |line: &str| Some(line.strip_prefix('[')?.split(']').next()?.trim().to_owned());
    if let Some(name) = header(line) {
        return name;
    }
    let key = line.split('=').next().unwrap_or("").trim();
    match text[..start].lines().rev().find_map(|line| header(line.trim())) {
        Some(table) => format!("{table}.{key}"),
        None => key.into(),
    }
}

/// Byte offsets of the starts of a text's lines.
struct Lines(Vec<usize>);

impl Lines {
    fn of(text: &str) -> Self {
        Self(std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect())
    }

    /// The line of a byte, counted from 1.
    fn of_byte(&self, byte: usize) -> usize {
        self.0.partition_point(|&start| start <= byte)
    }
}

/// The first line of a span, shortened to [`QUOTED`] characters.
fn quoted(text: &str, span: &Range<usize>) -> String {
    let whole = text.get(span.clone()).unwrap_or("").trim();
    let line = whole.lines().next().unwrap_or("");
    let quoted = cut(line, QUOTED);
    if quoted.len() == line.len() && line.len() < whole.len() { format!("{line}…") } else { quoted.into() }
}

/// A table of the file with its dotted name.
#[derive(Clone)]
pub(super) struct Table<'a> {
    /// Empty for the whole file.
    pub name: String,
    pub line: usize,
    pub entries: &'a DeTable<'a>,
}

impl<'a> Table<'a> {
    pub fn root(entries: &'a DeTable<'a>) -> Self {
        Self { name: String::new(), line: 1, entries }
    }

    fn dotted(&self, key: &str) -> String {
        if self.name.is_empty() { key.into() } else { format!("{}.{key}", self.name) }
    }

    pub fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }
}

/// A value of the file with its dotted name.
#[derive(Clone)]
pub(super) struct Entry<'a> {
    pub name: String,
    /// The last part of the name.
    pub key: String,
    pub line: usize,
    pub value: &'a DeValue<'a>,
    span: Range<usize>,
}

/// Line and text of a value, kept to locate problems that are found later.
struct Written {
    line: usize,
    value: Option<String>,
}

/// The state of a reading.
pub(super) struct Reading<'a> {
    text: &'a str,
    lines: Lines,
    written: HashMap<String, Written>,
    pub records: Records<'a>,
    pub problems: Vec<Problem>,
}

impl<'a> Reading<'a> {
    pub fn new(text: &'a str, records: Records<'a>) -> Self {
        Self { text, lines: Lines::of(text), written: HashMap::new(), records, problems: Vec::new() }
    }

    /// The problems in the order of their lines.
    pub fn finish(mut self) -> Vec<Problem> {
        self.problems.sort_by_key(|problem| problem.line);
        self.problems
    }

    /// Adds a problem with a value of the file.
    pub fn refuse(&mut self, entry: &Entry, text: impl Into<String>) {
        let value = self.value(entry);
        self.problems.push(Problem {
            line: Some(entry.line),
            name: entry.name.clone(),
            value,
            text: text.into(),
        });
    }

    /// Adds a problem with an unknown name. The nearest valid one is sought only for problems that
    /// are written out: a search for each of thousands would take minutes.
    pub fn refuse_name<'n>(
        &mut self,
        entry: &Entry,
        name: &str,
        said: &str,
        valid: impl Iterator<Item = &'n str> + Clone,
    ) {
        let shown = self.problems.len() < SHOWN;
        let text = if shown { format!("{said}; {}", advice(name, valid)) } else { said.into() };
        self.refuse(entry, text);
    }

    /// Adds a problem with a table.
    pub fn refuse_table(&mut self, table: &Table, text: impl Into<String>) {
        let (line, name) = (Some(table.line), table.name.clone());
        self.problems.push(Problem { line, name, value: None, text: text.into() });
    }

    /// Adds a problem found in the whole machine, at the line of its name or of the longest prefix
    /// of the name that is in the file, with the value as written.
    pub fn place(&mut self, mut problem: Problem) {
        if let Some(written) = self.written.get(&problem.name) {
            problem.line = Some(written.line);
            problem.value = problem.value.and_then(|value| written.value.clone().or(Some(value)));
        } else {
            let mut name = problem.name.as_str();
            while let Some(end) = name.rfind(['.', '[']) {
                name = &name[..end];
                if let Some(written) = self.written.get(name) {
                    problem.line = Some(written.line);
                    break;
                }
            }
        }
        self.problems.push(problem);
    }

    /// A value as written in the file; `None` for tables.
    fn value(&self, entry: &Entry) -> Option<String> {
        let table = entry.value.is_table();
        (!table).then(|| quoted(self.text, &entry.span)).filter(|value| !value.is_empty())
    }

    fn note(&mut self, entry: &Entry) {
        let value = self.value(entry);
        self.written.insert(entry.name.clone(), Written { line: entry.line, value });
    }

    /// The value of a key, if present.
    pub fn optional<'t>(&mut self, table: &Table<'t>, key: &str) -> Option<Entry<'t>> {
        let (found, value) = table.entries.get_key_value(key)?;
        let line = self.lines.of_byte(found.span().start);
        let (name, key) = (table.dotted(key), key.into());
        let entry = Entry { name, key, line, value: value.get_ref(), span: value.span() };
        self.note(&entry);
        Some(entry)
    }

    /// The value of a required key.
    pub fn required<'t>(&mut self, table: &Table<'t>, key: &str, allowed: &str) -> Option<Entry<'t>> {
        let found = self.optional(table, key);
        if found.is_none() {
            self.missing(table, key, allowed);
        }
        found
    }

    fn missing(&mut self, table: &Table, key: &str, allowed: &str) {
        let text = format!("missing; {allowed}");
        let name = table.dotted(key);
        self.problems.push(Problem { line: Some(table.line), name, value: None, text });
    }

    /// All entries of a table.
    pub fn all<'t>(&mut self, table: &Table<'t>) -> Vec<Entry<'t>> {
        let keys: Vec<String> = table.entries.keys().map(|key| key.get_ref().to_string()).collect();
        keys.iter().filter_map(|key| self.optional(table, key)).collect()
    }

    /// The items of an array, each named with its index.
    pub fn items<'t>(&mut self, entry: &Entry<'t>) -> Option<Vec<Entry<'t>>> {
        let item = |(i, item): (usize, &'t Spanned<DeValue<'t>>)| {
            let (name, span) = (format!("{}[{i}]", entry.name), item.span());
            Entry {
                name,
                key: entry.key.clone(),
                line: self.lines.of_byte(span.start),
                value: item.get_ref(),
                span,
            }
        };
        let items: Vec<_> = entry.value.as_array()?.iter().enumerate().map(item).collect();
        items.iter().for_each(|item| self.note(item));
        Some(items)
    }

    /// Refuses every key of a table that is not among `keys`.
    pub fn known(&mut self, table: &Table, keys: &[&str]) {
        for entry in self.all(table) {
            if !keys.contains(&entry.key.as_str()) {
                self.refuse_name(&entry, &entry.key, "no such key", keys.iter().copied());
            }
        }
    }

    /// A value as a table.
    pub fn table<'t>(&mut self, entry: &Entry<'t>, allowed: &str) -> Option<Table<'t>> {
        match entry.value.as_table() {
            Some(entries) => Some(Table { name: entry.name.clone(), line: entry.line, entries }),
            None => {
                self.refuse(entry, allowed);
                None
            }
        }
    }

    /// The tables of a section, each with its name.
    pub fn section<'t>(&mut self, root: &Table<'t>, section: &str) -> Vec<(String, Table<'t>)> {
        let Some(whole) = self.optional(root, section) else { return Vec::new() };
        let allowed = format!("allowed are tables with names, such as [{section}.NAME]");
        let Some(whole) = self.table(&whole, &allowed) else { return Vec::new() };
        let entries = self.all(&whole);
        let table = |entry: &Entry<'t>| Some((entry.key.clone(), self.table(entry, &allowed)?));
        entries.iter().filter_map(table).collect()
    }

    /// A value as a string.
    pub fn string(&mut self, entry: &Entry, allowed: &str) -> Option<String> {
        let found = entry.value.as_str().map(str::to_owned);
        if found.is_none() {
            self.refuse(entry, allowed);
        }
        found
    }

    /// A value as a number of a kind, in SI.
    pub fn number(&mut self, entry: &Entry, kind: Kind, dimension: Dimension) -> Option<f64> {
        let found = number(entry.value, kind, dimension);
        if found.is_none() {
            self.refuse(entry, kind.allowed(dimension));
        }
        found
    }

    /// The number of a required key.
    pub fn required_number(
        &mut self,
        table: &Table,
        key: &str,
        kind: Kind,
        dimension: Dimension,
    ) -> Option<f64> {
        let entry = self.required(table, key, &kind.allowed(dimension))?;
        self.number(&entry, kind, dimension)
    }

    /// The number of an optional key.
    pub fn number_or(
        &mut self,
        table: &Table,
        key: &str,
        kind: Kind,
        dimension: Dimension,
        default: f64,
    ) -> Option<f64> {
        match self.optional(table, key) {
            Some(entry) => self.number(&entry, kind, dimension),
            None => Some(default),
        }
    }
}

/// A value as an allowed number of a kind.
pub(super) fn number(value: &DeValue, kind: Kind, dimension: Dimension) -> Option<f64> {
    match value {
        DeValue::Integer(digits) => integer(digits).filter(|&v| kind.contains(v)),
        DeValue::Float(digits) => digits.as_str().parse().ok().filter(|&v| kind.contains(v)),
        DeValue::String(text) => parameters::read(kind, dimension, text),
        _ => None,
    }
}

/// An integer as the nearest double, whatever its size.
fn integer(digits: &DeInteger) -> Option<f64> {
    match digits.radix() {
        10 => digits.as_str().parse().ok(),
        radix => i64::from_str_radix(digits.as_str(), radix).ok().map(|n| n as f64),
    }
}
