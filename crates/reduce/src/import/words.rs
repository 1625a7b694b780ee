//! Lines, words and numbers of the files.

use crate::{Error, Result};

/// Length limit of a quoted line in a message, in characters.
const SHOWN: usize = 60;

/// Refuses a line.
pub fn refused(file: &str, line: usize, text: &str, expected: &str) -> Error {
    let text = text.trim();
    let mut shown: String = text.chars().take(SHOWN).map(|c| if c.is_control() { '?' } else { c }).collect();
    if text.chars().count() > SHOWN {
        shown.push('…');
    }
    Error::new(format!("{file}:{line}"), format!("{shown}: {expected}"))
}

/// A finite number. The exponent may begin with `D`, or with its sign alone: `1.5-3` is 0.0015.
pub fn number(text: &str) -> Option<f64> {
    let text = text.trim();
    if let Ok(value) = text.parse::<f64>() {
        // Rust also parses `inf` and `nan`, and `1e999` as infinity.
        return value.is_finite().then_some(value);
    }
    let mut written = text.to_ascii_uppercase().replace('D', "E");
    if !written.contains('E')
        && let Some(at) = written.rfind(['+', '-']).filter(|at| *at > 0)
    {
        written.insert(at, 'E');
    }
    let digits = written.chars().all(|c| c.is_ascii_digit() || "+-.E".contains(c));
    written.parse().ok().filter(|value: &f64| digits && value.is_finite())
}

/// Converts a row or column counted from 1 to an index counted from 0.
pub fn row(text: &str) -> Option<usize> {
    // The limit is half of the largest number, so that sums of two indices do not overflow.
    text.trim().parse::<usize>().ok().filter(|k| (1..usize::MAX / 2).contains(k)).map(|k| k - 1)
}

/// Refuses a text whose last line has no end: in files that do not state their size, a number that
/// is cut off would be read as another one.
///
/// # Errors
/// An error with the last line.
pub fn whole(text: &str, file: &str) -> Result<()> {
    match lines(text).last().filter(|_| !text.ends_with('\n')) {
        None => Ok(()),
        Some((line, text)) => Err(refused(
            file,
            line,
            text,
            "the file ends within this line and may be truncated; expected a line break at its end",
        )),
    }
}

/// Lines with their numbers, counted from 1.
pub fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    text.lines().enumerate().map(|(i, line)| (i + 1, line))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_form_numbers_of_each_program() {
        for (text, value) in [
            ("1.5", Some(1.5)),
            (" -1.5E+03 ", Some(-1500.0)),
            ("1.25D-02", Some(0.0125)),
            ("1.5-3", Some(0.0015)),
            ("-2.+4", Some(-20000.0)),
            ("nan", None),
            ("inf", None),
            ("1e999", None),
            ("1d999", None),
            ("12x", None),
            ("", None),
            ("-", None),
        ] {
            assert_eq!(number(text), value, "{text}");
        }
        assert_eq!((row("1"), row("0"), row("-1"), row("99999999999999999999")), (Some(0), None, None, None));
    }
}
