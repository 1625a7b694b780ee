//! Reading of records: two columns of numbers, time and value.

use super::{Records, read_text};
use crate::check::MOST_KNOTS;
use std::io;
use std::path::{Component, Path, PathBuf};

/// A reader for texts without records, which finds none.
///
/// # Errors
/// Always.
pub fn no_records(_: &str) -> io::Result<String> {
    Err(io::Error::other("no files can be read from here"))
}

/// A reader of records in a folder.
pub fn records_beside(folder: &Path) -> impl Fn(&str) -> io::Result<String> + use<> {
    let folder = PathBuf::from(folder);
    move |path| read_regular(&folder.join(path))
}

/// The text of a regular file; a pipe could block without end.
fn read_regular(path: &Path) -> io::Result<String> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(io::Error::other("it is a folder, pipe or device; allowed is a regular file"));
    }
    read_text(path)
}

/// The knots of a record. The error is the problem's text.
pub(super) fn read(path: &str, records: Records) -> Result<Vec<(f64, f64)>, String> {
    stays_inside(path)?;
    let text = records(path).map_err(|e| format!("cannot be read: {e}"))?;
    knots(&text).map_err(|e| format!("{path}:{e}"))
}

/// Checks that a path is below the file's folder and means the same on every system.
pub(super) fn stays_inside(path: &str) -> Result<(), String> {
    let plain = |part| matches!(part, Component::Normal(_) | Component::CurDir);
    if path.is_empty() || path.contains(['\\', ':', '\0']) || !Path::new(path).components().all(plain) {
        return Err(
            "allowed is a path below the file's folder with / between its parts, such as \"data/record.csv\""
                .into(),
        );
    }
    Ok(())
}

/// The knots of a text with one knot a line: time and value in SI, separated by a comma. The first
/// line may be a heading; blank lines and lines that begin with # are skipped.
fn knots(text: &str) -> Result<Vec<(f64, f64)>, String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim()));
    let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let mut knots: Vec<(f64, f64)> = Vec::new();
    for (i, (line, text)) in lines.enumerate() {
        let said = || -> String { text.chars().take(60).collect() };
        let Some((time, value)) = pair(text) else {
            let heading = i == 0
                && text.split(',').count() == 2
                && text.split(',').all(|word| word.parse::<f64>().is_err());
            if heading {
                continue;
            }
            return Err(format!("{line}: {}: allowed is a time and a value, such as 0.5,20", said()));
        };
        if knots.last().is_some_and(|last| time <= last.0) {
            return Err(format!("{line}: {}: allowed is a time after that of the line before", said()));
        }
        knots.push((time, value));
        if knots.len() > MOST_KNOTS {
            return Err(format!("{line}: allowed are up to {MOST_KNOTS} lines"));
        }
    }
    if knots.len() < 2 {
        return Err(format!(" it has {} knots; allowed are 2 to {MOST_KNOTS}", knots.len()));
    }
    Ok(knots)
}

fn pair(text: &str) -> Option<(f64, f64)> {
    let (time, value) = text.split_once(',')?;
    let number = |text: &str| text.trim().parse().ok().filter(|v: &f64| v.is_finite());
    number(time).zip(number(value))
}
