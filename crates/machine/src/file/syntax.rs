//! Syntax errors of a file, in the words of a machine's file instead of the TOML library's.

use super::reading::{Lines, QUOTED, quoted};
use crate::refusal::{Problem, cut};
use crate::table::has_decimal_comma;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text as TOML, and its first syntax error.
pub(super) fn toml(text: &str) -> (Spanned<DeTable<'_>>, Vec<Problem>) {
    let (root, errors) = DeTable::parse_recoverable(text);
    // Further errors are mostly consequences of the first.
    let first = errors.first();
    let parameters = root.get_ref().get("parameters").map(|own| own.get_ref());
    let problem =
        first.map(|error| problem(text, &error.span().unwrap_or(0..0), error.message(), parameters));
    (root, problem.into_iter().collect())
}

/// Beginnings of the library's messages about text without quotation marks.
const UNQUOTED: [&str; 3] = ["string values must be quoted", "invalid boolean", "extra `=`"];
/// Beginnings of the library's messages about numbers.
const NUMBERS: [&str; 7] = [
    "invalid float",
    "invalid fraction",
    "invalid integer",
    "invalid mantissa",
    "invalid exponent",
    "unexpected leading zero",
    "`_` may only",
];
/// Beginnings of the library's messages about a key without `=`.
const NO_EQUALS: [&str; 3] = ["key with no value", "missing value for key", "missing assignment"];
/// Quotation marks, the longer ones first.
const QUOTES: [&str; 4] = ["\"\"\"", "'''", "\"", "'"];

/// Returns the problem of a syntax error: its span, and the library's message.
fn problem(text: &str, span: &Range<usize>, said: &str, parameters: Option<&DeValue>) -> Problem {
    let whole = span.start.min(text.len());
    let at = (0..=whole).rev().find(|at| text.is_char_boundary(*at)).unwrap_or(0);
    let begin = text[..at].rfind('\n').map_or(0, |at| at + 1);
    let line = text[begin..].lines().next().unwrap_or("");
    let (start, end) = (Place::after(&text[..begin]), Place::after(&text[..begin + line.len()]));
    let plain = line.split('#').next().unwrap_or("").trim();
    let of = |at: usize, name: String, value: Option<&str>, said: String| Problem {
        line: Some(Lines::of(text).of_byte(at)),
        value: value.filter(|_| !name.is_empty()).map(str::to_owned),
        name,
        text: said,
    };
    let here = |said: String| of(at, end.name(), None, said);
    if said.contains("duplicate") {
        let key = cut(text.get(span.clone()).unwrap_or("").trim(), QUOTED);
        let which = if end.name().ends_with(&*key) { String::new() } else { format!("`{key}` ") };
        return here(format!("{which}is given twice; keep one of them"));
    }
    if let Some(quote) = end.quote.filter(|own| own.len() == 1 || said.contains("multi-line")) {
        return here(format!("missing quotation mark `{quote}`"));
    }
    if start.open.is_empty() && line.trim_start().starts_with('[') && said.starts_with("unclosed") {
        let text = match line.contains(']') {
            true => "expected a heading such as [body.NAME]",
            false => "missing closing bracket `]`",
        };
        return here(text.into());
    }
    if let Some((bracket, opened)) = unclosed(text, (begin, at), line, said) {
        let name = Place::after(&text[..opened]).name();
        return of(opened, name, None, format!("missing closing bracket `{bracket}`"));
    }
    let opened = |open: char, close: char| line.matches(open).count() < line.matches(close).count();
    let other = [('[', ']'), ('{', '}')].into_iter().find(|(open, close)| opened(*open, *close));
    if let Some((open, close)) = other.filter(|_| start.open.is_empty()) {
        if open == '[' && is_heading(line) {
            let heading = plain.trim_end_matches(close);
            let said = format!("one `{close}` too many in `{}`; write {heading}{close}", cut(plain, QUOTED));
            return of(at, String::new(), None, said);
        }
        let name = if end.key.is_empty() { String::new() } else { end.name() };
        let said = format!("missing opening bracket `{open}` in `{}`", cut(line.trim(), QUOTED));
        return of(at, name, None, said);
    }
    if begins(said, &NO_EQUALS) {
        if plain.contains('.') && plain.chars().all(is_key) {
            let word = cut(plain, QUOTED);
            let said = format!("`{word}`: expected a heading in brackets, [{word}], or `=` and a value");
            return of(at, String::new(), None, said);
        }
        let words = line.split_once('=').map(|(words, _)| words.trim());
        if let Some(words) = words.filter(|words| is_words(words)) {
            let said = "a key has no spaces; a unit stands in the value, such as mass = \"3 kg\"";
            return of(at, String::new(), None, format!("`{}`: {said}", cut(words, QUOTED)));
        }
        let name = if said.contains("assignment") { end.name() } else { start.name() };
        return of(at, name, None, format!("missing `=`{}", after_key(text, at, line, said)));
    }
    let rest = line.get(at - begin..).unwrap_or("").split('#').next().unwrap_or("").trim();
    let is_parameter = |word: &str| parameters.is_some_and(|own| own.get(word).is_some());
    if let Some((value, said)) = of_value(text, at, (span, said), (rest, end.key), &is_parameter) {
        return of(at, end.name(), Some(&*value).filter(|value| !value.is_empty()), said);
    }
    match said {
        _ if said.starts_with("missing comma") || said.starts_with("extra assignment") => {
            here("missing comma between two items".into())
        }
        _ if said.starts_with("unquoted keys cannot be empty") => match line.trim().starts_with('[') {
            true => of(at, String::new(), None, without_name(line)),
            false => of(at, start.name(), None, "missing key before `=`".into()),
        },
        _ if said.starts_with("unexpected key or value") && !rest.is_empty() => {
            let value = line.split_once('=').and_then(|own| own.1.split('#').next()).unwrap_or("").trim();
            match value.strip_prefix('(').and_then(|own| own.strip_suffix(')')) {
                Some(list) => here(format!("write a list in square brackets: [{}]", cut(list, QUOTED))),
                None if has_decimal_comma(value) => {
                    let said = format!("write a decimal point: {}", value.replace(',', "."));
                    of(at, end.name(), Some(value), said)
                }
                None if value.contains(';') => here("unexpected `;`: write each key on its own line".into()),
                None => here(format!("unexpected `{}` after the value", cut(rest, QUOTED))),
            }
        }
        _ if said.starts_with("missing escaped value") => {
            here("write `\\\\` for a backslash, or the text in single quotation marks".into())
        }
        _ if said.starts_with("invalid unquoted key") => {
            let letter = quoted(text, span);
            of(
                at,
                String::new(),
                None,
                format!("`{letter}` is not allowed in a name; expected letters (A-Z, a-z), digits and _"),
            )
        }
        _ if said.starts_with("invalid key-value pair") => {
            let line = cut(line.trim(), QUOTED);
            of(
                at,
                String::new(),
                None,
                format!("`{line}`: expected a heading such as [body.NAME], or a key, `=` and a value"),
            )
        }
        _ => {
            let value = quoted(text, span);
            let said = if value.is_empty() { said.into() } else { format!("{said}: {value}") };
            of(at, String::new(), None, said)
        }
    }
}

/// Whether a text is two or more words with letters, digits and `_`.
fn is_words(text: &str) -> bool {
    text.contains(' ') && text.chars().all(|c| c.is_ascii_alphanumeric() || " _".contains(c))
}

fn begins(said: &str, all: &[&str]) -> bool {
    all.iter().any(|own| said.starts_with(own))
}

/// A value and its fault, if the library's message is about the value; `rest` is the line after
/// the start of the error.
fn of_value(
    text: &str,
    at: usize,
    (span, said): (&Range<usize>, &str),
    (rest, key): (&str, &str),
    is_parameter: &dyn Fn(&str) -> bool,
) -> Option<(String, String)> {
    let word = match said {
        _ if said.starts_with("extra") => rest.to_owned(),
        _ if said.starts_with("string values") => quoted(text, span),
        _ => word_at(text, at).to_owned(),
    };
    let fault = match said {
        _ if begins(said, &UNQUOTED) && word.is_empty() => "missing value after `=`".into(),
        // A word that begins as `nan` or `inf` is a number for the library.
        _ if begins(said, &UNQUOTED) || (begins(said, &NUMBERS) && word.starts_with(char::is_alphabetic)) => {
            unquoted(&word, key, is_parameter(&word))
        }
        _ if said.starts_with("invalid fraction") && word.ends_with('.') => {
            format!("a digit is missing after the decimal point; write {}0", cut(&word, QUOTED))
        }
        _ if begins(said, &NUMBERS) => "expected a number, such as 12, 0.5 or 1e-3".into(),
        _ => return None,
    };
    Some((cut(&word, QUOTED).into_owned(), fault))
}

/// The fault of a value without quotation marks.
fn unquoted(word: &str, key: &str, is_parameter: bool) -> String {
    let plain = word.trim_matches(['"', '\'', '“', '”', '„', '‘', '’']);
    let plain = cut(plain, QUOTED);
    if ["true", "false"].contains(&&*plain.to_lowercase()) {
        return match key {
            "input" => format!("write `{}`, in small letters", plain.to_lowercase()),
            _ => "expected a number, or a text in quotation marks".into(),
        };
    }
    let is_name = |part: &str| part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let is_term = |part: &str| !part.is_empty() && (is_name(part) || part.parse::<f64>().is_ok());
    let parts = |word: &str| word.split(['+', '*', '/']).all(|part| is_term(part.trim()));
    if is_parameter || word.contains(['+', '*', '/']) && parts(word) {
        return format!("write an expression in quotation marks, beginning with `=`: \"= {plain}\"");
    }
    if let Some((value, comment)) = word.split_once("//") {
        return format!("a comment begins with `#`: {} # {}", value.trim_end(), comment.trim_start());
    }
    match word.starts_with(['“', '”', '„', '‘', '’']) {
        true => format!("use straight quotation marks: \"{plain}\""),
        false => format!("must be in quotation marks: \"{plain}\""),
    }
}

/// The fault of a heading with an empty name.
fn without_name(line: &str) -> String {
    let heading = line.split('#').next().unwrap_or("").trim();
    let before = heading.trim_matches(['[', ']']).trim_end_matches('.');
    let (after, example) = match before.is_empty() || before.contains("..") || before.starts_with('.') {
        true => (String::new(), "body"),
        false => (format!(" after `{before}.`"), before),
    };
    format!("`{}`: a name is missing{after}; write a heading such as [{example}.NAME]", cut(heading, QUOTED))
}

/// Returns the closing bracket that is missing before an error, and the byte of its opening
/// bracket. `begin` is the first byte of the error's line.
fn unclosed(text: &str, (begin, at): (usize, usize), line: &str, said: &str) -> Option<(char, usize)> {
    if said.starts_with("unclosed") {
        return Place::after(text).open.pop();
    }
    let mut open = Place::after(&text[..at]).open;
    let other = text[at..].chars().next().filter(|c| [']', '}'].contains(c));
    if let Some(&(bracket, opened)) = open.last()
        && other.is_some_and(|other| other != bracket)
    {
        return Some((bracket, opened));
    }
    open.retain(|own| own.1 < begin);
    let (bracket, opened) = open.pop()?;
    // Braces may hold keys on several lines.
    let is_full = !text[opened + 1..].lines().next().unwrap_or("").trim().is_empty();
    let ends = bracket == ']' || (is_full && said.starts_with("missing comma"));
    let is_outside = is_heading(line) || (is_assignment(line) && ends);
    is_outside.then_some((bracket, opened))
}

fn is_key(c: char) -> bool {
    c.is_alphanumeric() || "_-.\"'".contains(c)
}

/// Whether a line is a heading such as `[body.box]`, not a row of numbers.
fn is_heading(line: &str) -> bool {
    let name = line.trim().strip_prefix('[').and_then(|rest| rest.split(']').next());
    name.is_some_and(|name| name.starts_with(char::is_alphabetic) && name.chars().all(is_key))
}

/// Whether a line begins with a key and `=`.
fn is_assignment(line: &str) -> bool {
    let key = line.split_once('=').map(|own| own.0.trim());
    key.is_some_and(|key| !key.is_empty() && key.chars().all(is_key))
}

/// Returns the words " after `KEY`" for a key without `=`.
fn after_key(text: &str, at: usize, line: &str, said: &str) -> String {
    let key = match said.starts_with("key with no value") {
        true => line.trim().split(|c| !is_key(c)).next(),
        false => text[..at].trim_end().rsplit(|c| !is_key(c)).next(),
    };
    let key = key.filter(|key| !key.is_empty());
    key.map_or(String::new(), |key| format!(" after `{}`", cut(key, QUOTED)))
}

/// The word at a byte, without spaces and brackets.
fn word_at(text: &str, at: usize) -> &str {
    let ends = |c: char| c.is_whitespace() || ",[]{}=#".contains(c);
    let begin = text[..at].rfind(ends).map_or(0, |at| at + 1);
    let end = text[at..].find(ends).map_or(text.len(), |end| at + end);
    text.get(begin..end).unwrap_or("")
}

/// Table, key and open brackets at a place of a text.
struct Place<'t> {
    /// Name of the table.
    table: &'t str,
    /// Key of the value; empty outside a value.
    key: &'t str,
    /// Closing characters of the open brackets with the bytes of the opening ones, innermost last.
    open: Vec<(char, usize)>,
    /// Quotation mark of an unfinished string.
    quote: Option<&'static str>,
}

impl<'t> Place<'t> {
    /// Returns the place at the end of a text.
    fn after(text: &'t str) -> Self {
        let mut own = Self { table: "", key: "", open: Vec::new(), quote: None };
        let (mut at, mut line) = (0, 0);
        while let Some(c) = text[at..].chars().next() {
            let rest = &text[at..];
            let mut step = c.len_utf8();
            match (own.quote, c) {
                (Some(quote), _) if rest.starts_with(quote) => {
                    step = quote.len();
                    own.quote = None;
                }
                (Some(quote), '\\') if quote.starts_with('"') => {
                    step += rest[1..].chars().next().map_or(0, char::len_utf8);
                }
                (Some(quote), '\n') if quote.len() == 1 => own.quote = None,
                (Some(_), _) => {}
                (None, '#') => step = rest.find('\n').unwrap_or(rest.len()),
                (None, '"' | '\'') => {
                    own.quote = QUOTES.into_iter().find(|quote| rest.starts_with(*quote));
                    step = own.quote.map_or(1, str::len);
                }
                (None, '[') if own.open.is_empty() && text[line..at].trim().is_empty() => {
                    let heading = rest.lines().next().unwrap_or("");
                    own.table = heading.trim_start_matches('[').split([']', '#']).next().unwrap_or("").trim();
                    step = heading.len();
                }
                (None, '[') => own.open.push((']', at)),
                (None, '{') => own.open.push(('}', at)),
                (None, ']' | '}') => drop(own.open.pop()),
                (None, '=') if own.open.is_empty() => {
                    own.key = text[line..at].split('=').next().unwrap_or("").trim();
                }
                (None, _) => {}
            }
            if c == '\n' {
                line = at + 1;
                if own.open.is_empty() && own.quote.is_none() {
                    own.key = "";
                }
            }
            at += step;
        }
        own
    }

    /// The dotted name of the key.
    fn name(&self) -> String {
        match (self.table, self.key) {
            ("", name) | (name, "") => name.into(),
            (table, key) => format!("{table}.{key}"),
        }
    }
}
