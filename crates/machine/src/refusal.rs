//! Refusal of a machine: all its problems, each with line and dotted name.

use std::borrow::Cow;
use std::fmt;

/// Largest number of problems written out; the rest is counted.
pub(crate) const SHOWN: usize = 50;

/// One problem of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Line of the file, counted from 1; `None` without a file.
    pub line: Option<usize>,
    /// Dotted name, such as `stop.upper.gap`; empty if the text is not TOML.
    pub name: String,
    /// The value found, if any.
    pub value: Option<String>,
    /// The fault, and the expected values.
    pub text: String,
}

impl Problem {
    /// A problem without a line.
    pub(crate) fn new(name: impl Into<String>, value: Option<String>, text: impl Into<String>) -> Self {
        Self { line: None, name: name.into(), value, text: text.into() }
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, text) = (cut(&self.name, LONGEST_NAME), cut(&self.text, LONGEST_TEXT));
        match &self.value {
            Some(value) => write!(f, "{name} = {}: {text}", cut(value, LONGEST_NAME)),
            None if name.is_empty() => f.write_str(&text),
            None => write!(f, "{name}: {text}"),
        }
    }
}

/// Longest name or value written out, characters: a damaged file must not fill the screen.
const LONGEST_NAME: usize = 150;
/// Longest message written out, characters.
const LONGEST_TEXT: usize = 2_000;

/// The first `longest` characters of a text, with an ellipsis if more follow.
pub(crate) fn cut(text: &str, longest: usize) -> Cow<'_, str> {
    match text.char_indices().nth(longest) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}

/// Refusal of a machine with all problems found, in the order of their lines.
///
///
/// An editor can mark each problem at its line:
///
/// ```
/// use vibro_machine::file::{no_records, parse};
///
/// let text = "name = \"A\"\n[body.a]\nmass = 1.0\n\
///     [stop.s]\nbetween = [\"ground\", \"a\"]\ngap = \"1 mm\"\nrestitution = 1.5\n";
/// let refused = parse(text, "a.toml", &no_records).unwrap_err();
/// assert_eq!(refused.problems.len(), 1);
/// let problem = &refused.problems[0];
/// assert_eq!((problem.line, problem.name.as_str()), (Some(7), "stop.s.restitution"));
/// assert_eq!(problem.to_string(), "stop.s.restitution = 1.5: expected a number from 0 to 1");
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// Name of the file; empty without a file.
    pub file: String,
    /// One or more problems.
    pub problems: Vec<Problem>,
}

impl Refusal {
    /// A refusal with one problem, without a file.
    pub(crate) fn one(problem: Problem) -> Self {
        Self { file: String::new(), problems: vec![problem] }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, problem) in self.problems.iter().take(SHOWN).enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            match (self.file.is_empty(), problem.line) {
                (false, Some(line)) => write!(f, "{}:{line}: {problem}", self.file)?,
                (false, None) => write!(f, "{}: {problem}", self.file)?,
                (true, _) => write!(f, "{problem}")?,
            }
        }
        match self.problems.len().saturating_sub(SHOWN) {
            0 => Ok(()),
            more => write!(f, "\nand {more} more"),
        }
    }
}

impl std::error::Error for Refusal {}

/// Length limit, bytes, of a name in the search for the nearest valid name; longer ones are not
/// typos.
const LONGEST_MISSPELT: usize = 100;

/// Largest number of valid names that a message lists completely; the keys of a section are fewer.
const LONGEST_LIST: usize = 24;
/// Number of names that a message lists of a longer list.
const LISTED: usize = 8;

/// Advice on an unknown name: the nearest valid name or, if none is near, the valid names. Names
/// with the same first parts are searched alone: `stop.a.damping` is not near `stop.b.damping`.
pub fn advice<'a>(name: &str, valid: impl Iterator<Item = &'a str> + Clone) -> String {
    if let Some(nearest) = nearest(name, valid.clone()) {
        return format!("did you mean `{nearest}`?");
    }
    let first = same_parts(name, valid.clone());
    let mut all: Vec<_> = valid.filter(|v| v.starts_with(&first)).collect();
    match all.len() {
        0 => "there are none".into(),
        n if n > LONGEST_LIST => {
            all.truncate(LISTED);
            format!("expected one of {} and {} more", all.join(", "), n - LISTED)
        }
        _ => format!("expected one of {}", all.join(", ")),
    }
}

/// The first parts of a dotted name, with the last point, that a valid name has as well.
fn same_parts<'a>(name: &str, valid: impl Iterator<Item = &'a str> + Clone) -> String {
    let whole = format!("{name}.");
    let ends = whole.match_indices('.').map(|(at, _)| &whole[..=at]);
    let first = ends.rev().find(|first| valid.clone().any(|v| v.starts_with(*first)));
    first.unwrap_or("").to_owned()
}

/// The valid name that an unknown name probably misspells, or whose last parts it is.
pub(crate) fn nearest<'a>(name: &str, valid: impl Iterator<Item = &'a str> + Clone) -> Option<&'a str> {
    let first = same_parts(name, valid.clone());
    let rest = name.get(first.len()..).filter(|rest| !rest.is_empty() && name.len() <= LONGEST_MISSPELT)?;
    let same = valid.filter(|v| v.starts_with(&first));
    let ends_so = |v: &&str| v[first.len()..].strip_suffix(rest).is_some_and(|before| before.ends_with('.'));
    if let Some(found) = same.clone().find(ends_so) {
        return Some(found);
    }
    // A name that differs in more than half of its letters is not a misspelling.
    let far = rest.chars().count() / 2;
    let lower = rest.to_lowercase();
    let distance = |v: &str| strsim::damerau_levenshtein(&lower, &v[first.len()..].to_lowercase());
    same.map(|v| (distance(v), v)).min().filter(|found| found.0 <= far).map(|found| found.1)
}
