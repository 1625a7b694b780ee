//! Refusals of machines: all problems, each with its line and name.

use std::borrow::Cow;
use std::fmt;

/// Most problems and names that are written out; the rest is counted.
pub(crate) const SHOWN: usize = 50;

/// One problem of a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem {
    /// Line of the file, counted from 1; `None` without a file.
    pub line: Option<usize>,
    /// Dotted name, such as `stop.upper.gap`; empty where the text is no TOML.
    pub name: String,
    /// The value as written, if there is one.
    pub value: Option<String>,
    /// What is wrong, and what is allowed.
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

/// Most characters of a name or value that are written out, so that a damaged file does not fill
/// the screen.
const LONGEST_NAME: usize = 150;
/// Most characters of a problem's text that are written out.
const LONGEST_TEXT: usize = 2_000;

/// The first `longest` characters of a text, with an ellipsis where it is longer.
pub(crate) fn cut(text: &str, longest: usize) -> Cow<'_, str> {
    match text.char_indices().nth(longest) {
        Some((end, _)) => format!("{}…", &text[..end]).into(),
        None => text.into(),
    }
}

/// The refusal of a machine, with all problems found, in the order of their lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal {
    /// The file's name; empty without a file.
    pub file: String,
    /// One or more problems.
    pub problems: Vec<Problem>,
}

impl Refusal {
    /// A refusal for one problem without a file.
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

/// Most letters of a name for which the nearest is sought; a longer one is no misspelling.
const LONGEST_MISSPELT: usize = 100;

/// Advice for a name that is not valid: the nearest valid one or, where none is near, all of them.
pub(crate) fn advice<'a>(name: &str, valid: impl Iterator<Item = &'a str> + Clone) -> String {
    // A name that differs in more than half of its letters is no misspelling.
    let far = (name.chars().count() / 2).max(1);
    let lower = name.to_lowercase();
    let distance = |v: &&str| strsim::damerau_levenshtein(&lower, &v.to_lowercase());
    let near = |_: &&str| name.len() <= LONGEST_MISSPELT;
    let nearest = valid.clone().filter(near).map(|v| (distance(&v), v)).min().filter(|found| found.0 <= far);
    if let Some((_, nearest)) = nearest {
        return format!("the nearest is `{nearest}`");
    }
    let mut all: Vec<_> = valid.take(SHOWN + 1).collect();
    match all.len() {
        0 => "there are none".into(),
        n if n > SHOWN => {
            all.truncate(SHOWN);
            format!("valid are {} and more", all.join(", "))
        }
        _ => format!("valid are {}", all.join(", ")),
    }
}
