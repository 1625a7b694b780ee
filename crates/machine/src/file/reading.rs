//! The state of the file's reader: lines of keys and values, known keys, and the problems found.

use super::{Records, VALUES};
use crate::check::{GROUND, problem_of_name};
use crate::elements::SECTIONS;
use crate::kinds;
use crate::named::{Expression, NamedParameters};
use crate::refusal::{Problem, SHOWN, advice, cut, nearest};
use std::collections::{HashMap, HashSet};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Cap on the quoted letters of a value in a message.
pub(super) const QUOTED: usize = 60;

/// The byte at which each line of a text begins.
pub(super) struct Lines(Vec<usize>);

impl Lines {
    pub fn of(text: &str) -> Self {
        Self(std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1)).collect())
    }

    /// Returns the line of a byte, counted from 1.
    pub fn of_byte(&self, byte: usize) -> usize {
        self.0.partition_point(|&start| start <= byte)
    }
}

/// The name of an item of a list of pairs, such as `points[2,0]`, by the name of its number,
/// `points[2].e`.
fn of_pair(name: &str) -> Option<String> {
    let (pair, number) = name.rsplit_once("].")?;
    let place = match number {
        "e" | "time" => 0,
        "f" | "height" => 1,
        _ => return None,
    };
    Some(format!("{pair},{place}]"))
}

/// Returns the first line of a span of the text, shortened to [`QUOTED`] letters.
pub(super) fn quoted(text: &str, span: &Range<usize>) -> String {
    let whole = text.get(span.clone()).unwrap_or("").trim();
    let line = whole.lines().next().unwrap_or("");
    let quoted = cut(line, QUOTED);
    if quoted.len() == line.len() && line.len() < whole.len() { format!("{line}…") } else { quoted.into() }
}

/// A table of the file.
#[derive(Clone)]
pub(super) struct FileTable<'a> {
    /// Dotted name; empty for the whole file.
    pub name: String,
    pub line: usize,
    pub entries: &'a DeTable<'a>,
}

impl<'a> FileTable<'a> {
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

/// A value of the file.
#[derive(Clone)]
pub(super) struct Entry<'a> {
    pub name: String,
    /// Last part of the dotted name.
    pub key: String,
    pub line: usize,
    pub value: &'a DeValue<'a>,
    span: Range<usize>,
}

impl Entry<'_> {
    /// Prefixes the entry's key with the key of its table.
    pub fn below(mut self, table: &str) -> Self {
        self.key = format!("{table}.{}", self.key);
        self
    }
}

/// Line, text and span of a value, kept for problems of the whole machine and for edits.
struct Written {
    line: usize,
    value: Option<String>,
    span: Range<usize>,
}

/// Sections of bodies.
const BODIES: [&str; 3] = ["body", "modal", "matrix"];

/// The name or value whose completion is requested, see [`Allowed`]. No machine's text has it.
pub(super) const ASKED: &str = "\u{f8ff}";

/// Everything that the reader accepts at the place of [`ASKED`], collected when it refuses
/// [`ASKED`].
#[derive(Default)]
pub(super) struct Allowed {
    /// Keys, or names and words as values.
    pub names: Vec<String>,
    /// Units of a number.
    pub units: Vec<&'static str>,
    /// The allowed numbers in words.
    pub words: String,
}

/// The state of the file's reader.
pub(super) struct Reading<'a> {
    text: &'a str,
    lines: Lines,
    written: HashMap<String, Written>,
    /// The named parameters, which are read before everything else.
    pub named: NamedParameters,
    /// Whether named parameters were refused; then expressions are not checked.
    pub named_refused: bool,
    /// Expressions of numbers, by the numbers' names in the file.
    pub follow: Vec<(String, Expression)>,
    pub records: Records<'a>,
    pub problems: Vec<Problem>,
    /// Whether a body's name or section was refused; then unknown names of bodies are not reported.
    lacks_bodies: bool,
    /// Dotted names of the keys that were probably meant by misspelt ones.
    meant: HashSet<String>,
    pub allowed: Allowed,
}

impl<'a> Reading<'a> {
    pub fn new(text: &'a str, records: Records<'a>) -> Self {
        Self {
            text,
            lines: Lines::of(text),
            written: HashMap::new(),
            named: NamedParameters::default(),
            named_refused: false,
            follow: Vec::new(),
            records,
            problems: Vec::new(),
            lacks_bodies: false,
            meant: HashSet::new(),
            allowed: Allowed::default(),
        }
    }

    /// Returns the problems in the order of their lines.
    pub fn finish(mut self) -> Vec<Problem> {
        vibro_numerics::sorting::sort_by_key(&mut self.problems, |problem| problem.line);
        self.problems
    }

    /// Adds a problem of an entry.
    pub fn refuse(&mut self, entry: &Entry, text: impl Into<String>) {
        let value = self.value(entry);
        self.problems.push(Problem {
            line: Some(entry.line),
            name: entry.name.clone(),
            value,
            text: text.into(),
        });
    }

    /// Adds a problem for a name that is not among the valid names. The nearest valid name is
    /// searched only for problems that will be displayed; for thousands of problems it would take
    /// minutes.
    pub fn refuse_name<'n>(
        &mut self,
        entry: &Entry,
        name: &str,
        said: &str,
        valid: impl Iterator<Item = &'n str> + Clone,
    ) {
        self.note_names(name, valid.clone());
        let shown = self.problems.len() < SHOWN;
        let text = if shown { format!("{said}; {}", advice(name, valid)) } else { said.into() };
        self.refuse(entry, text);
    }

    /// Adds a problem for a name that no body has, unless the name of a body was refused.
    pub fn refuse_body<'n>(
        &mut self,
        entry: &Entry,
        name: &str,
        said: &str,
        valid: impl Iterator<Item = &'n str> + Clone,
    ) {
        if !self.lacks_bodies || name == ASKED {
            self.refuse_name(entry, name, said, valid);
        }
    }

    /// Refuses a key that another key excludes, if it is present.
    pub fn excluded(&mut self, table: &FileTable, key: &str, text: &str) {
        if let Some(entry) = self.optional(table, key) {
            self.refuse(&entry, text);
        }
    }

    /// Refuses bodies and elements with names that are not allowed.
    pub fn check_names(&mut self, root: &FileTable) {
        for section in SECTIONS.iter().map(|own| own.0).chain(["body"]) {
            let table = root.entries.get(section).and_then(|own| own.get_ref().as_table());
            for key in table.into_iter().flat_map(|own| own.keys()) {
                let name: &str = key.get_ref();
                let is_ground = section == "body" && name == "ground";
                if let Some(text) = problem_of_name(name).or(is_ground.then_some(GROUND)) {
                    self.lacks_bodies |= BODIES.contains(&section) && !is_ground;
                    let line = Some(self.lines.of_byte(key.span().start));
                    let name = format!("{section}.{name}");
                    self.problems.push(Problem { line, name, value: None, text: text.into() });
                }
            }
        }
    }

    /// Whether a body in the file has residual flexibility.
    pub fn has_residual(&self) -> bool {
        self.written.keys().any(|name| name.starts_with("modal.") && name.ends_with(".residual"))
    }

    /// Whether the file has a value or table with a dotted name that was read.
    pub fn has_read(&self, name: &str) -> bool {
        self.written.contains_key(name)
    }

    /// Adds a problem of a table.
    pub fn refuse_table(&mut self, table: &FileTable, text: impl Into<String>) {
        let (line, name) = (Some(table.line), table.name.clone());
        self.problems.push(Problem { line, name, value: None, text: text.into() });
    }

    /// Adds a problem of the whole machine, with the value as written. Its line is the line of its
    /// name, or of the longest part of the name that is in the file.
    pub fn place(&mut self, mut problem: Problem) {
        let item = of_pair(&problem.name);
        if let Some(written) = self.written.get(item.as_deref().unwrap_or(&problem.name)) {
            problem.line = Some(written.line);
            problem.value = problem.value.and_then(|value| written.value.clone().or(Some(value)));
        } else {
            let mut name = problem.name.as_str();
            while let Some(end) = name.rfind(['.', '[', ',']) {
                name = &name[..end];
                if let Some(written) = self.written.get(name) {
                    problem.line = Some(written.line);
                    break;
                }
            }
        }
        self.problems.push(problem);
    }

    /// The text of a value as written; `None` for tables.
    fn value(&self, entry: &Entry) -> Option<String> {
        let table = entry.value.is_table();
        (!table).then(|| quoted(self.text, &entry.span)).filter(|value| !value.is_empty())
    }

    /// Returns the comment after a value, on its line; empty if there is none.
    pub fn comment(&self, entry: &Entry) -> String {
        let rest = self.text.get(entry.span.end..).and_then(|rest| rest.lines().next());
        let comment = rest.and_then(|rest| rest.trim_start().strip_prefix('#'));
        comment.map_or_else(String::new, |comment| comment.trim().to_owned())
    }

    fn note(&mut self, entry: &Entry) {
        let value = self.value(entry);
        self.written
            .insert(entry.name.clone(), Written { line: entry.line, value, span: entry.span.clone() });
    }

    /// The spans of all values, by dotted name.
    pub fn spans(self) -> HashMap<String, Range<usize>> {
        self.written.into_iter().map(|(name, own)| (name, own.span)).collect()
    }

    /// The entry of a key, if present.
    pub fn optional<'t>(&mut self, table: &FileTable<'t>, key: &str) -> Option<Entry<'t>> {
        let (found, value) = table.entries.get_key_value(key)?;
        let line = self.lines.of_byte(found.span().start);
        let (name, key) = (table.dotted(key), key.into());
        let entry = Entry { name, key, line, value: value.get_ref(), span: value.span() };
        self.note(&entry);
        Some(entry)
    }

    /// The entry of a key that must be present.
    pub fn required<'t>(&mut self, table: &FileTable<'t>, key: &str, allowed: &str) -> Option<Entry<'t>> {
        let found = self.optional(table, key);
        if found.is_none() {
            self.missing(table, key, allowed);
        }
        found
    }

    fn missing(&mut self, table: &FileTable, key: &str, allowed: &str) {
        let text = format!("missing; {allowed}");
        let name = table.dotted(key);
        if self.meant.contains(&name) {
            return;
        }
        self.problems.push(Problem { line: Some(table.line), name, value: None, text });
    }

    /// All entries of a table.
    pub fn all<'t>(&mut self, table: &FileTable<'t>) -> Vec<Entry<'t>> {
        let keys: Vec<String> = table.entries.keys().map(|key| key.get_ref().to_string()).collect();
        keys.iter().filter_map(|key| self.optional(table, key)).collect()
    }

    /// Returns the items of an array, with their indices in their names.
    pub fn items<'t>(&mut self, entry: &Entry<'t>) -> Option<Vec<Entry<'t>>> {
        // An array within an array has both indices in one bracket, like FMI's structured names.
        let before = entry.name.strip_suffix(']').map_or(format!("{}[", entry.name), |of| format!("{of},"));
        let item = |(i, item): (usize, &'t Spanned<DeValue<'t>>)| {
            let (name, span) = (format!("{before}{i}]"), item.span());
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

    /// Refuses all keys of a table except `keys`.
    pub fn known(&mut self, table: &FileTable, keys: &[&str]) {
        // A key that has a value cannot be completed; a table may get more keys.
        let has_value = |key: &str| table.entries.get(key).is_some_and(|own| !own.get_ref().is_table());
        let is_free = |key: &&str| !table.has(ASKED) || !has_value(key);
        for entry in self.all(table) {
            if !keys.contains(&entry.key.as_str()) {
                let is_section = table.name.is_empty() && entry.value.is_table();
                let fits = |key: &&str| !is_section || !VALUES.contains(key);
                let free = keys.iter().copied().filter(is_free).filter(fits);
                let text = if is_section { "no such kind of section" } else { "no such key" };
                if self.problems.len() < SHOWN {
                    let near = nearest(&entry.key, free.clone());
                    self.lacks_bodies |= is_section && near.is_some_and(|own| BODIES.contains(&own));
                    self.meant.extend(near.map(|own| table.dotted(own)));
                }
                self.refuse_name(&entry, &entry.key, text, free);
            }
        }
    }

    /// A value as a table.
    pub fn table<'t>(&mut self, entry: &Entry<'t>, allowed: &str) -> Option<FileTable<'t>> {
        match entry.value.as_table() {
            Some(entries) => Some(FileTable { name: entry.name.clone(), line: entry.line, entries }),
            None => {
                self.refuse(entry, allowed);
                None
            }
        }
    }

    /// The tables of a section, each with its name.
    pub fn section<'t>(&mut self, root: &FileTable<'t>, section: &str) -> Vec<(String, FileTable<'t>)> {
        let Some(whole) = self.optional(root, section) else { return Vec::new() };
        let allowed = format!("expected tables with names, such as [{section}.NAME]");
        let single = format!("expected a heading in single brackets, such as [{section}.NAME]");
        let allowed = |value: &DeValue| {
            let is_list =
                value.as_array().is_some_and(|items| items.iter().any(|item| item.get_ref().is_table()));
            if is_list { &single } else { &allowed }
        };
        let Some(whole) = self.table(&whole, allowed(whole.value)) else { return Vec::new() };
        let entries = self.all(&whole);
        let table = |entry: &Entry<'t>| Some((entry.key.clone(), self.table(entry, allowed(entry.value))?));
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

    /// A value that is one of some words.
    pub fn word<T: Copy>(&mut self, entry: &Entry, words: &[(T, &str)]) -> Option<T> {
        let said = entry.value.as_str();
        self.note_names(said.unwrap_or_default(), words.iter().map(|own| own.1));
        let found = words.iter().find(|own| said == Some(own.1)).map(|own| own.0);
        if found.is_none() {
            let quoted: Vec<String> = words.iter().map(|own| format!("{:?}", own.1)).collect();
            self.refuse(entry, format!("expected {}", kinds::one_of(&quoted)));
        }
        found
    }

    /// Records the allowed names if the completion of [`ASKED`] is requested.
    pub fn note_names<'n>(&mut self, name: &str, valid: impl Iterator<Item = &'n str>) {
        if name == ASKED {
            self.allowed.names.extend(valid.map(str::to_owned));
        }
    }

    /// Adds a problem for a name that was read.
    pub fn refuse_name_of(&mut self, name: &str, text: &str) {
        self.place(Problem::new(name, None, text));
    }
}
