//! Completion of a text that is being written.
//!
//! The file's reader finds the completions: [`ASKED`], a word that no machine has, replaces the
//! unfinished word, and the reader collects the words it would allow.

use super::reading::{ASKED, Allowed, FileTable, Reading};
use super::syntax;
use super::{TABLES, VALUES, machine, no_records};
use crate::elements::SECTIONS;
use vibro_numerics::quantities::split;

/// Placeholder for further items of an unfinished array.
const FURTHER: &str = "\u{f8fe}";

/// The completions at a place of a text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Completion {
    /// Bytes before and after the place that a completion replaces.
    pub replaced: [usize; 2],
    /// Completions, each with its name and the text that replaces the word.
    pub offers: Vec<(String, String)>,
    /// The allowed numbers in words; empty if no number can be here.
    pub allowed: String,
}

/// Part of the text around a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Within {
    Header,
    Key,
    Value,
}

/// The place where a text ends.
#[derive(Debug)]
struct Place {
    within: Within,
    /// Byte at which the unfinished word begins, with its quotation mark.
    begin: usize,
    /// The quotation mark of an unfinished string.
    quote: Option<char>,
    /// Closing characters of the open brackets, innermost last.
    open: Vec<char>,
    is_comment: bool,
}

impl Place {
    /// Returns the place at the end of a text. Multi-line strings are not supported.
    fn after(text: &str) -> Self {
        let mut own =
            Self { within: Within::Key, begin: 0, quote: None, open: Vec::new(), is_comment: false };
        let (mut chars, mut is_line_empty) = (text.char_indices().peekable(), true);
        while let Some((at, c)) = chars.next() {
            let next = at + c.len_utf8();
            match (own.quote, c) {
                (_, '\n') => {
                    (own.quote, own.is_comment, own.begin) = (None, false, next);
                    if own.open.is_empty() {
                        (own.within, is_line_empty) = (Within::Key, true);
                    }
                    continue;
                }
                _ if own.is_comment => continue,
                (Some('"'), '\\') => drop(chars.next()),
                (Some(quote), _) if c == quote => own.quote = None,
                (Some(_), _) => {}
                (None, '#') => own.is_comment = true,
                (None, '"' | '\'') => (own.quote, own.begin) = (Some(c), at),
                (None, '[') if is_line_empty && own.open.is_empty() => {
                    (own.within, own.begin) = (Within::Header, next);
                }
                (None, '[') => {
                    own.open.push(']');
                    (own.within, own.begin) = (Within::Value, next);
                }
                (None, '{') => {
                    own.open.push('}');
                    (own.within, own.begin) = (Within::Key, next);
                }
                (None, ']' | '}') => {
                    own.open.pop();
                    own.begin = next;
                }
                (None, '=') if own.within == Within::Key => {
                    (own.within, own.begin) = (Within::Value, next);
                }
                (None, ',') => {
                    let is_table = own.open.last() == Some(&'}');
                    own.within = if is_table { Within::Key } else { Within::Value };
                    own.begin = next;
                }
                (None, '.') if own.within != Within::Value => own.begin = next,
                (None, ' ' | '\t') if text[own.begin..at].trim().is_empty() => own.begin = next,
                _ => {}
            }
            is_line_empty &= c.is_whitespace();
        }
        own
    }

    /// Number of bytes of the word in the following text.
    fn rest(&self, tail: &str) -> usize {
        let line = tail.lines().next().unwrap_or("");
        match self.quote {
            Some(quote) => match line.split_once(quote) {
                // The next quotation mark may belong to another string.
                Some((word, _)) if !word.contains([',', ']', '}', '=']) => word.len() + 1,
                _ => 0,
            },
            None => {
                let is_part = |c: char| c.is_alphanumeric() || "_-+.".contains(c);
                line.find(|c| !is_part(c)).unwrap_or(line.len())
            }
        }
    }
}

/// Returns completions at the end of `head` in the text `head` and `tail`: keys, kinds of tables,
/// names of bodies, words, and units after a number.
///
/// ```
/// use vibro_machine::file::completion;
///
/// let head = "name = \"A\"\n[body.ball]\nmass = 1.0\n\
///     [spring.s]\nbetween = [\"ground\", \"ball\"]\n";
/// let of = |typed: &str| -> Vec<String> {
///     completion(&format!("{head}{typed}"), "").offers.into_iter().map(|own| own.1).collect()
/// };
/// assert_eq!(of("stiff"), ["stiffness = "]);
/// assert_eq!(of("stiffness = \"3 k"), ["\"3 kN/m\"", "\"3 kN/mm\""]);
/// ```
pub fn completion(head: &str, tail: &str) -> Completion {
    let place = Place::after(head);
    if place.is_comment {
        return Completion::default();
    }
    let (rest, typed) = (place.rest(tail), &head[place.begin..]);
    let allowed = allowed(&head[..place.begin], &tail[rest..], &place);
    let is_key = tail[rest..].trim_start_matches([' ', '\t']).starts_with('=');
    let word = typed.trim_start_matches(['"', '\'']);
    let quoted = |text: &str| format!("\"{text}\"");
    let mut offers: Vec<(String, String)> = Vec::new();
    let mut offer = |name: &str, text: String| {
        if text != format!("{typed}{}", &tail[..rest]) && !offers.iter().any(|own| own.0 == name) {
            offers.push((name.to_owned(), text));
        }
    };
    let names = allowed.names.iter().map(String::as_str).filter(|name| begins(name, word));
    match place.within {
        Within::Header => {
            let names = names.filter(|name| !VALUES.contains(name));
            names.for_each(|name| offer(name, name.to_owned()));
        }
        Within::Key => {
            let is_root = |name: &&str| !TABLES.contains(name) && !SECTIONS.iter().any(|own| own.0 == *name);
            let names = names.filter(|name| is_root(name) || !place.open.is_empty());
            names.for_each(|name| offer(name, if is_key { name.into() } else { format!("{name} = ") }));
        }
        Within::Value => {
            names.for_each(|name| offer(name, quoted(name)));
            // The number as written, with its sign and its zeros.
            if let Some((_, symbol)) = split(word) {
                let number = word.strip_suffix(symbol).unwrap_or(word).trim();
                let units = allowed.units.iter().filter(|unit| begins(unit, symbol));
                units.for_each(|unit| offer(unit, quoted(&format!("{number} {unit}"))));
            }
        }
    }
    Completion { replaced: [typed.len(), rest], offers, allowed: allowed.words }
}

/// Whether a name begins with the typed text, ignoring case.
fn begins(name: &str, typed: &str) -> bool {
    name.get(..typed.len()).is_some_and(|begin| begin.eq_ignore_ascii_case(typed))
}

/// Returns what the reader allows between two texts. Tries several ways to finish the text: the
/// first that is valid TOML and gives an answer counts, otherwise the first that gives an answer.
fn allowed(head: &str, tail: &str, place: &Place) -> Allowed {
    let (line, below) = tail.split_at(tail.find('\n').unwrap_or(tail.len()));
    let closing: String = place.open.iter().rev().collect();
    let has_value = line.trim_start().starts_with('=');
    let (asked, further) = (format!("\"{ASKED}\""), format!("\"{ASKED}\", \"{FURTHER}\""));
    let ways = match place.within {
        Within::Header => vec![format!("{head}{asked}]{below}")],
        Within::Key if has_value => vec![format!("{head}{asked}{tail}")],
        Within::Key => {
            vec![format!("{head}{asked} = 0{tail}"), format!("{head}{asked} = 0{closing}{below}")]
        }
        Within::Value => [tail.to_owned(), format!("{closing}{below}")]
            .into_iter()
            .flat_map(|end| [&asked, &further].map(|word| format!("{head}{word}{end}")))
            .collect(),
    };
    let mut first = None;
    for way in ways {
        let (root, broken) = syntax::toml(&way);
        let mut reading = Reading::new(&way, &no_records);
        machine(&mut reading, &FileTable::root(root.get_ref()));
        let found = reading.allowed;
        if found.names.is_empty() && found.words.is_empty() {
            continue;
        }
        if broken.is_empty() {
            return found;
        }
        first.get_or_insert(found);
    }
    first.unwrap_or_default()
}
